//! Contacts that are pressed, from the start or till the end, and starts in equilibrium.

use adaptive::record::warning::WarningKind;
use adaptive::run::recording::Recording;
use fbimpact::scenario::keys::Named;
use fbimpact::scenario::tables::ContactModel;

use super::{BALL, OF_FORCE, cheap, impacts, is_told, recorded, tried};

const PRESS: &str = r#"
[simulation]
end_time = 3e-4
[bodies.ball]
model = "axisymmetric"
material = "steel"
geometry = { shape = "sphere", radius = 0.01 }
[joints.press]
type = "axial"
parent = { body = "ground", point = [0.0, 0.0, 0.0100001] }
child = { body = "ball", point = [0.0, 0.0], radius = 0.004 }
motion = { kind = "polynomial", coefficients = [0.0, -0.01] }
[bodies.floor]
model = "rigid"
geometry = { shape = "plane" }
[contacts.c]
contact_body = "ball"
target_body = "floor"
"#;

/// A press that goes on at the end of the run has a zone that fits the force it has reached: 2.9 µm at its end, and what it
/// passed on the way, with four elements of the zone at 0.6 µm. (The ball yields by some 1 % of that as a whole.)
#[test]
fn a_ball_that_is_pressed_till_the_end_obeys_hertz() {
    let k = 4.0 / 3.0 * 210e9 / (1.0 - 0.09) * 0.01_f64.sqrt();
    for model in cheap() {
        let recording = recorded(PRESS, &[&format!("contacts.c.model=\"{}\"", model.name())]);
        let is_told = OF_FORCE.iter().any(|kind| is_told(&recording, *kind));
        for time in [7e-5, 2e-4, 3e-4] {
            let force = 0.01 * (time - 1e-5);
            let force = k * f64::powf(force, 1.5);
            let at = |s: &&adaptive::record::Sample| (s.time - time).abs();
            let nearest = recording.samples.iter().min_by(|a, b| at(a).total_cmp(&at(b))).expect("a sample");
            // Instants are a fraction of a per cent of the time apart.
            let expected = force * ((nearest.time - 1e-5) / (time - 1e-5)).powf(1.5);
            let error = nearest.contacts[0].normal_force / expected - 1.0;
            // The joint holds what the contact presses: the ball moves at a constant speed, and its modes ring little.
            let held = -nearest.joints[0].reaction_force[2] / nearest.contacts[0].normal_force - 1.0;
            println!("{}: {error:+.4}, held {held:+.4} at {time:e} s", model.name());
            assert!(error.abs() < 0.015 || is_told, "{}: {error:+.4} at {time:e} s", model.name());
            assert!(held.abs() < 0.01 || is_told, "{}: {held:+.4} at {time:e} s", model.name());
        }
        // Steel yields under a quarter of this pressure.
        let is_known = recording.warnings.iter().all(|warning| warning.kind == WarningKind::Yields);
        assert!(is_known || is_told, "{:?}", recording.warnings);
    }
}

/// A ball that a damper brakes before it touches: Hertz's equation of motion, integrated apart, has a peak of 19.84 N and
/// lasts for 115.6 µs, whatever the model of the contact.
#[test]
fn a_zone_that_nobody_gave_fits_the_touch_and_not_the_start() {
    let text = BALL
        .split("[output.stress")
        .next()
        .expect("a part")
        .replace("end_time = 1.2e-4", "end_time = 4e-3\nstop_after_impacts = 1");
    let text = text
        .replace("72.8e9", "210e9")
        .replace("0.33", "0.3")
        .replace("2789.0", "7850.0")
        .replace("position = [0.0, 0.0, 10.000001e-3]\nvelocity = [0.0, 0.0, -0.1]\n", "")
        + "[joints.s]\ntype = \"axial\"\nparent = { body = \"ground\", point = [0.0, 0.0, 0.011] }\n\
           child = { body = \"ball\", point = [0.0, 0.0], radius = 0.004 }\nvelocity = -2.0\ndamping = 65.1\n";
    for model in [ContactModel::Adaptive, ContactModel::Quasistatic, ContactModel::Massless] {
        let recording = recorded(&text, &[&format!("contacts.c.model=\"{}\"", model.name())]);
        let impact = impacts(&recording)[0];
        let (peak, duration) =
            (impact.peak_force / 19.84 - 1.0, (impact.end - impact.start) / 115.6e-6 - 1.0);
        println!("{}: peak {peak:+.4}, duration {duration:+.4}", model.name());
        assert!(peak.abs() < 1e-2 && duration.abs() < 1e-2, "{}: {peak:+.4}, {duration:+.4}", model.name());
    }
}

const DISC: &str = r#"
[simulation]
end_time = 1e-4
[bodies.d]
model = "plane-stress"
thickness = 0.01
material = "steel"
geometry = { shape = "disc", radius = 0.1 }
angular_velocity = [0.0, 0.0, 1000.0]
reduction = { modes = 20 }
[output]
free_interval = 5e-6
[output.points.centre]
body = "d"
marker = "centre"
stress = true
"#;

/// A disc that spins has the stress (3 + ν)/8 ρ ω² R² in its middle: at once with a static start, else it is told that it rings.
#[test]
fn a_spin_given_at_the_start_is_in_equilibrium_or_told() {
    let expected = 3.3 / 8.0 * 7850.0 * 1e6 * 0.01;
    let stresses = |recording: &Recording| -> Vec<f64> {
        recording.samples.iter().map(|sample| sample.points[0].state.stress[0]).collect()
    };
    let sudden = recorded(DISC, &[]);
    assert!(is_told(&sudden, WarningKind::SuddenSpin), "{:?}", sudden.warnings);
    let resting = recorded(DISC, &["simulation.static_start=true"]);
    assert!(!is_told(&resting, WarningKind::SuddenSpin));
    // 20 modes and one static answer; the mesh is right to a per mille.
    stresses(&resting).iter().for_each(|s| assert!((s / expected - 1.0).abs() < 1e-2, "{s:e} {expected:e}"));
}

/// A disc of 10 mm pressed on a floor by a spring of `force` N on a slide, turned by `angle`; positive forces
/// press.
fn bolt(force: f64, angle: f64) -> String {
    let (c, s) = (angle.cos(), angle.sin());
    format!(
        "[simulation]\nend_time = 2e-7\nstatic_start = true\n\
[bodies.a]\nmodel = \"plane-strain\"\nthickness = 0.02\nmaterial = \"steel\"\ngeometry = {{ shape = \"disc\", radius = 10e-3 }}\n\
discretisation = {{ elements = [4, 4] }}\nreduction = {{ modes = 6 }}\n\
[joints.bolt]\ntype = \"prismatic\"\naxis = [{:?}, {c:?}, 0.0]\nparent = {{ body = \"ground\", point = [{:?}, {:?}, 0.0] }}\n\
child = {{ body = \"a\", point = [0.0, 0.0], radius = 3e-3 }}\nstiffness = 1e6\nrest = {:?}\n\
[bodies.floor]\nmodel = \"rigid\"\ngeometry = {{ shape = \"plane\" }}\nnormal = [{:?}, {c:?}, 0.0]\n\
[contacts.c]\ncontact_body = \"a\"\ntarget_body = \"floor\"\n",
        -s,
        -s * 0.01,
        c * 0.01,
        -force / 1e6,
        -s
    )
}

#[test]
fn a_contact_that_is_pressed_at_a_start_in_equilibrium_is_told_in_any_pose() {
    // The equilibrium lifts the touched side of the disc by nanometres.
    for (force, angle) in [(1000.0, 0.0), (1000.0, 0.7), (1.0, 0.0)] {
        let recording = recorded(&bolt(force, angle), &[]);
        assert!(
            is_told(&recording, WarningKind::StaticContact),
            "{force} N at {angle}: {:?}",
            recording.warnings
        );
    }
    // Without a force nothing is told; a pull, which moves the touched side into the floor, is refused.
    assert!(!is_told(&recorded(&bolt(0.0, 0.7), &[]), WarningKind::StaticContact));
    assert!(tried(&bolt(-1000.0, 0.7), &[]).is_err_and(|error| error.contains("overlap")));
}
