//! Gears from a scenario: a flexible shaft, a rack, faults.

use crate::support::scenarios;
use crate::support::scenarios::{faults, run_text as run};
use std::path::Path;

/// A wheel of 0.02 kg m² and a body called `other` on a joint along z, geared; `more` are further tables.
fn geared(other: &str, joint: &str, gear: &str, more: &str) -> String {
    format!(
        r#"
        [simulation]
        end_time = 2e-3
        [bodies.wheel]
        model = "rigid"
        mass = 1.0
        inertia = [0.01, 0.01, 0.02]
        [bodies.other]
        {other}
        [joints.axle]
        type = "revolute"
        axis = [0.0, 0.0, 1.0]
        parent = {{ body = "ground", point = [0.5, 0.0, 0.0] }}
        child = {{ body = "wheel", point = [0.0, 0.0, 0.0] }}
        [joints.bearing]
        axis = [0.0, 0.0, 1.0]
        {joint}
        [gears.mesh]
        first = "axle"
        second = "bearing"
        {gear}
        {more}
        "#
    )
}

const BLOCK: &str = r#"model = "rigid"
mass = 2.0
inertia = [0.01, 0.02, 0.03]"#;
const GUIDE: &str = r#"type = "prismatic"
parent = { body = "ground", point = [0.0, 0.0, 0.0] }
child = { body = "other", point = [0.0, 0.0, 0.0] }"#;

#[test]
fn a_flexible_shaft_on_a_gear_takes_the_momentum_of_the_torque() {
    let (ratio, torque) = (-3.0, 5.0);
    let shaft = r#"model = "solid"
        material = "steel"
        geometry = { shape = "cylinder", radius = 0.02, length = 0.3 }
        discretisation = { degree = 2, elements = [1, 1, 4] }
        reduction = { modes = 6 }"#;
    let bearing = r#"type = "revolute"
        parent = { body = "ground" }
        child = { body = "other", marker = "start" }"#;
    let text =
        geared(shaft, bearing, "ratio = -3.0", "[joints.axle.drive]\nkind = \"constant\"\nvalue = 5.0\n");
    let recording = run(&text);
    let mut twisted: f64 = 0.0;
    for sample in &recording.samples {
        let [wheel, shaft] = [0, 1].map(|i| sample.joints[i].velocities[0]);
        // Projected after each step to 1e-11 of the speeds of the bodies, here up to some m/s.
        assert!((shaft - ratio * wheel).abs() < 1e-10, "{shaft} {wheel}");
        // d/dt (L_wheel + ratio L_shaft) = torque, whatever vibrates: the gear exerts λ on the shaft and -ratio λ on the wheel.
        let of_wheel = 0.02 * wheel;
        let of_shaft = sample.angular_momentum[2] - of_wheel;
        let momentum = of_wheel + ratio * of_shaft;
        // The tolerance of a step of 1e-8, times a thousand steps.
        assert!(
            (momentum - torque * sample.time).abs() <= 1e-5 * torque * 2e-3,
            "{momentum} {}",
            sample.time
        );
        let e = &sample.energies;
        let sum = e.kinetic + e.elastic_low - e.supplied;
        assert!(sum.abs() <= 1e-5 * e.supplied.abs().max(1e-6), "{sum} {}", e.supplied);
        twisted = twisted.max(e.elastic_low);
        assert!(sample.gears[0].is_finite());
    }
    assert!(twisted > 0.0 && recording.samples.len() > 2, "the gear twists the shaft");
}

#[test]
fn a_rack_follows_its_pinion_from_where_it_stands() {
    let text = geared(
        BLOCK,
        &format!("{GUIDE}\ndisplacement = 0.25"),
        "ratio = 0.05",
        "[joints.axle.drive]\nkind = \"constant\"\nvalue = 5.0\n",
    );
    let scenario = scenarios::valid(Path::new("."), &text, &["joints.axle.angular_velocity=4.0"]);
    let recording = scenarios::run(&scenario);
    let first = &recording.samples[0];
    // The rack has no velocity given: it follows.
    assert!((first.joints[1].velocities[0] - 0.2).abs() < 1e-12, "{:?}", first.joints[1]);
    assert!((first.joints[1].positions[0] - 0.25).abs() < 1e-12, "{:?}", first.joints[1]);
    let last = recording.samples.last().expect("samples");
    let acceleration = 5.0 / (0.02 + 2.0 * 0.05 * 0.05);
    // The tolerance of a step of 1e-8, times some ten steps.
    assert!((last.joints[0].velocities[0] / (4.0 + acceleration * 2e-3) - 1.0).abs() < 1e-7);
    assert!((last.joints[1].positions[0] - 0.25 - 0.05 * last.joints[0].positions[0]).abs() < 1e-11);
    assert!((last.gears[0] / (2.0 * 0.05 * acceleration) - 1.0).abs() < 1e-9, "force on the rack");
}

#[test]
fn faults_of_gears_say_what_to_change() {
    let more = |text: &str| faults(&geared(BLOCK, GUIDE, "ratio = 0.05", text));
    let other = |first: &str, second: &str, ratio: f64| {
        format!("[gears.two]\nfirst = \"{first}\"\nsecond = \"{second}\"\nratio = {ratio:?}\n")
    };
    assert!(more(&other("axel", "bearing", 0.05)).contains("gears.two.first: unknown joint"));
    let lock = more(&other("bearing", "axle", 10.0));
    assert!(lock.contains("gears.two.ratio: ratio 10 contradicts") && lock.contains("would lock"), "{lock}");
    assert!(more(&other("bearing", "axle", 20.0)).contains("say the same already"));
    let zero = faults(&geared(BLOCK, GUIDE, "ratio = 0.0", ""));
    assert!(zero.contains("gears.mesh.ratio") && zero.contains("not zero"), "{zero}");
    let sleeve = GUIDE.replace("prismatic", "cylindrical");
    let several = faults(&geared(BLOCK, &sleeve, "ratio = 1.0", ""));
    assert!(
        several.contains("gears.mesh.second: joint \"bearing\" has 2 coordinates")
            && several.contains("second_coordinate")
    );
    let far = faults(&geared(BLOCK, &sleeve, "second_coordinate = 2\nratio = 1.0", ""));
    assert!(far.contains("gears.mesh.second_coordinate"), "{far}");
    assert!(more(&other("axle", "axle", 2.0)).contains("both sides are the same coordinate"));
    // The axle turns, the rack is moved.
    let [wrong, plain] =
        ["2 rad/mm", "2 mm"].map(|r| faults(&geared(BLOCK, GUIDE, &format!("ratio = \"{r}\""), "")));
    assert!(wrong.contains("the ratio is in m/rad, known here are m/rad, mm/rad, mm/rev"), "{wrong}");
    assert!(plain.contains("unknown unit \"mm\""), "{plain}");
    let lead = geared(BLOCK, GUIDE, "ratio = \"5 mm/rev\"", "");
    let lead = scenarios::valid(Path::new("."), &lead, &[]).run.gears[0].ratio;
    assert!((lead - 5e-3 / std::f64::consts::TAU).abs() < 1e-18, "{lead:e}");
    let ball = GUIDE.replace("prismatic", "spherical").replace("axis", "reference");
    assert!(faults(&geared(BLOCK, &ball, "ratio = 1.0", "")).contains("no coordinate for a gear"));

    // Velocities that contradict the gear are an error of the run.
    let text = geared(BLOCK, &format!("{GUIDE}\nvelocity = 1.0"), "ratio = 0.05", "");
    let slips = scenarios::valid(Path::new("."), &text, &["joints.axle.angular_velocity=4.0"]);
    let error = scenarios::refusal(&slips);
    assert!(error.contains("gear \"mesh\"") && error.contains("slip"), "{error}");
}
