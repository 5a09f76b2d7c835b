//! Contact on whole surfaces wherever flat faces and edges touch: on joints, in later impacts, and refused where no point would see it.

use crate::support::steel_parts::{FLOOR, LENGTH, MODES, STEEL, check_ledger, contact, most_lost, rod, run};
use adaptive::record::Sample;
use adaptive::record::warning::WarningKind;

/// `text` of a rod that [`rod`] makes, on a guide along its axis.
fn guided(text: &str, name: &str, z: f64, speed: f64) -> String {
    let keys = |line: &&str| {
        !line.trim_start().starts_with("position") && !line.trim_start().starts_with("velocity")
    };
    let free: Vec<&str> = text.lines().filter(keys).collect();
    format!(
        "{}\n[joints.guide]\ntype = \"axial\"\nparent = {{ body = \"ground\", point = [0.0, 0.0, {z:e}] }}\n\
         child = {{ body = \"{name}\", face = \"z-\" }}\nvelocity = {speed}\n",
        free.join("\n")
    )
}

#[test]
fn a_rod_on_a_guide_strikes_as_a_free_one_does() {
    let (gap, n) = (1e-6, MODES as f64);
    let second = rod("second", 0.0, 0.0);
    let first = rod("first", -LENGTH - gap, 1.0);
    let scenario = |first: &str| {
        run(&format!("[simulation]\nend_time = 9.0e-5\n{STEEL}{first}{second}{}", contact("first", "second")))
    };
    let free = scenario(&first);
    let held = scenario(&guided(&first, "first", -LENGTH - gap, 1.0));
    let (a, b) = (free.impacts[0], held.impacts[0]);
    println!(
        "rods, free and on a guide: impulse {:.8e} and {:.8e}, restitution {:.6}",
        a.impulse, b.impulse, b.restitution
    );
    // The guide takes no part: the same motion by other steps before the touch, to the tolerance of 1e-8 per step.
    assert!((b.impulse / a.impulse - 1.0).abs() < 1e-6 && (b.peak_force / a.peak_force - 1.0).abs() < 1e-6);
    assert!(1.0 - b.restitution < most_lost(n * 0.9), "{}", b.restitution);
    check_ledger("guided rod", &held);
}

#[test]
fn a_bar_on_a_hinge_strikes_the_floor_with_its_edge() {
    let text = format!(
        r#"
        [simulation]
        end_time = 1.0e-3
        # Energies between its long steps are those of Gauss collocation to 1e-4 only.
        free.integrator = "dormand-prince"
        {STEEL}
        [bodies.bar]
        model = "solid"
        material = "steel"
        geometry = {{ shape = "box", size = [0.2, 0.02, 0.02] }}
        reduction = {{ modes = 20 }}
        discretisation = {{ degree = 2, elements = [8, 1, 1] }}
        [joints.pivot]
        type = "revolute"
        parent = {{ body = "ground", point = [0.0, 0.0, 0.06] }}
        child = {{ body = "bar", face = "x-" }}
        axis = [0.0, 1.0, 0.0]
        angle_deg = 14.4
        angular_velocity = 5.0
        {FLOOR}
        {}
    "#,
        contact("bar", "floor")
    );
    let recording = run(&text);
    // What bends when an end is struck comes back and strikes again.
    assert!(recording.impacts.len() > 1, "{}", recording.impacts.len());
    let vertical = |s: &Sample| s.contacts[0].force[2] + s.joints[0].reaction_force[2];
    let pairs = || recording.samples.windows(2);
    let sum = |f: &dyn Fn(&Sample) -> f64| -> f64 {
        pairs().map(|w| 0.5 * (w[1].time - w[0].time) * (f(&w[0]) + f(&w[1]))).sum()
    };
    let (first, last) = (&recording.samples[0], recording.samples.last().unwrap());
    let change = last.linear_momentum[2] - first.linear_momentum[2];
    let impulse = sum(&vertical);
    let contact = sum(&|s| s.contacts[0].force[2]);
    println!(
        "bar on a hinge: {} impacts, momentum {change:.6}, impulse {impulse:.6} N s",
        recording.impacts.len()
    );
    // Trapezia over stored states of a force that changes within microseconds.
    assert!((impulse - change).abs() < 1e-2 * contact, "{impulse} {change} {contact}");
    assert!(recording.warnings.iter().any(|w| w.kind == WarningKind::EdgeTouch));
    check_ledger("bar on a hinge", &recording);
}

#[test]
fn a_rod_between_planes_meets_one_with_its_round_and_one_with_its_flat_end() {
    let (length, gap, speed) = (0.1, 5e-5, 0.3);
    let text = format!(
        r#"
        [simulation]
        end_time = 5.0e-4
        {STEEL}
        [bodies.rod]
        model = "axisymmetric"
        material = "steel"
        geometry = {{ shape = "rod-spherical-end", radius = 0.005, length = {length} }}
        position = [0.0, 0.0, 1.0e-6]
        velocity = [0.0, 0.0, -{speed}]
        reduction = {{ modes = 20 }}
        discretisation = {{ degree = 3, elements = [2, 40] }}
        {FLOOR}
        [bodies.ceiling]
        model = "rigid"
        geometry = {{ shape = "plane" }}
        normal = [0.0, 0.0, -1.0]
        position = [0.0, 0.0, {}]
        [contacts.below]
        contact_body = "rod"
        target_body = "floor"
        [contacts.above]
        contact_body = "rod"
        target_body = "ceiling"
    "#,
        length + gap
    );
    let recording = run(&text);
    let contacts: Vec<u32> = recording.impacts.iter().map(|i| i.contact).collect();
    assert!(contacts.starts_with(&[0, 1]), "{contacts:?}");
    // The round end has its own zone, as wide as its contact; the flat one the whole surface.
    let width = |contact: u32| {
        let i = contacts.iter().position(|c| *c == contact).unwrap() as u32;
        recording.trials.iter().rfind(|t| t.impact == i).unwrap().interval_widths[0]
    };
    assert!(width(0) < 1e-3 && width(1) > length, "{} {}", width(0), width(1));
    // Nothing holds the rod between the impacts: each turns its momentum round but for what rings.
    let momentum = |t: f64| {
        let at = recording.samples.iter().rfind(|s| s.time <= t).unwrap();
        at.linear_momentum[2]
    };
    let above = recording.impacts.iter().find(|i| i.contact == 1).unwrap();
    let change = momentum(above.end + 1e-6) - momentum(above.start - 1e-6);
    println!("rod between planes: impulse {:.6e}, change {change:.6e} N s", above.impulse);
    assert!((above.impulse + change).abs() < 1e-3 * above.impulse, "{} {change}", above.impulse);
    check_ledger("rod between planes", &recording);
}

#[test]
fn a_factor_given_is_where_the_search_starts_unless_it_is_fixed() {
    let pair = |penalty: &str| {
        let (first, second) = (rod("first", -LENGTH - 1e-6, 1.0), rod("second", 0.0, 0.0));
        let found = run(&format!(
            "[simulation]\nend_time = 1.3e-4\n{STEEL}{first}{second}{}{penalty}",
            contact("first", "second")
        ));
        let soft = found.warnings.iter().find(|w| w.kind == WarningKind::SoftContact);
        // In trials the models are there still, when the warning is given they are gone.
        let remedy = "3 times as large as the 3.0e12 N/m^3 in use, or leave penalty.search out";
        assert!(soft.is_none_or(|w| w.remedy.contains(remedy)), "{soft:?}");
        let soft = soft.is_some();
        let factors: Vec<f64> = found.trials.iter().map(|trial| trial.penalty_end).collect();
        println!("{penalty}: peak {:.6e} N, soft {soft}, factors {factors:?}", found.impacts[0].peak_force);
        (found.impacts[0].impulse, soft, factors)
    };
    let (chosen, soft, _) = pair("");
    assert!(!soft);
    // A fifteenth of what the modes follow, from where stiffer springs follow in trials; or none.
    for (search, is_raised) in
        [("", true), (", search = \"until-converged\"", true), (", search = \"fixed\"", false)]
    {
        let (impulse, soft, factors) = pair(&format!("penalty = {{ initial = 3e12{search} }}\n"));
        assert!((factors[0] / 3e12 - 1.0).abs() < 1e-12, "{search}: {factors:?}");
        assert_eq!((factors.len() > 1, soft), (is_raised, !is_raised), "{search}: {factors:?}");
        // Rods exchange their momenta by either; soft springs only take longer for it.
        assert!(!is_raised || (impulse / chosen - 1.0).abs() < 1e-2, "{search}: {impulse} {chosen}");
    }
}
