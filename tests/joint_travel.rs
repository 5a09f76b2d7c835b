//! Generic joints, stops, dry friction and loads in lines and steps from a scenario, against closed forms.

use crate::support::scenarios;
use crate::support::scenarios::{faults, run_text as run};
use std::path::Path;

use adaptive::run::recording::Recording;

/// A block of 2 kg that slides along y and turns about x of its guide; `more` are further keys of the guide, then tables.
fn block(more: &str) -> String {
    format!(
        r#"
        [simulation]
        end_time = 0.3
        [bodies.block]
        model = "rigid"
        mass = 2.0
        inertia = [0.01, 0.02, 0.03]
        [joints.guide]
        type = "generic"
        locked = ["x", "z", "ry", "rz"]
        parent = {{ body = "ground", point = [0.0, 0.0, 0.0] }}
        child = {{ body = "block", point = [0.0, 0.0, 0.0] }}
        {more}
        "#
    )
}

/// Coordinates and velocities of the guide at the end.
fn end(recording: &Recording) -> ([f64; 2], [f64; 2]) {
    let last = recording.samples.last().expect("samples");
    let joint = &last.joints[0];
    ([joint.positions[0], joint.positions[1]], [joint.velocities[0], joint.velocities[1]])
}

#[test]
fn a_push_in_steps_against_friction_and_a_moment_in_lines_give_their_impulses() {
    let (mass, inertia, friction, transition) = (2.0, 0.01, 1.0, 1e-4);
    let recording = run(&block(
        r#"
        friction = [1.0, 0.0]
        friction_velocity = [1e-4, 1.0]
        [loads.push]
        body = "block"
        point = [0.0, 0.0, 0.0]
        force_y = { kind = "table", times = [0.0, 0.1, 0.35], values = [3.0, 0.0, 0.0], interpolation = "steps" }
        moment_x = { kind = "table", times = [0.0, 0.1, 0.2], values = [0.0, 0.05, 0.0], interpolation = "linear" }
        "#,
    ));
    let (positions, velocities) = end(&recording);
    // Pushed by 3 N for 0.1 s, then friction alone; it comes to rest after 0.3 s: velocities to that of the transition.
    let speed: f64 = (3.0 - friction) / mass * 0.1;
    assert!(velocities[0].abs() < transition, "{velocities:?}");
    let way = 0.5 * speed * 0.1 + 0.5 * speed * speed * mass / friction;
    // Below the transition friction is smaller: that adds a velocity of its size for the whole time.
    assert!((positions[0] - way).abs() < 2.0 * transition * 0.3, "{positions:?} {way}");
    let turning = 0.5 * 0.05 * 0.2 / inertia;
    // The tolerance of a step of 1e-8, times some hundred steps.
    assert!((velocities[1] / turning - 1.0).abs() < 1e-6, "{velocities:?}");
}

#[test]
fn a_block_between_two_stops_comes_back_in_the_time_of_the_spring() {
    let (mass, stiffness, gap, speed): (f64, f64, f64, f64) = (2.0, 1e5, 0.01, 0.5);
    let recording = run(&block(&format!(
        "velocities = [{speed}, 0.0]\nstops = [{{ coordinate = 0, lower = -{gap}, upper = {gap}, stiffness = {stiffness:e} }}]"
    )));
    let (positions, velocities) = end(&recording);
    // Between the stops it flies, in them it is a half wave.
    let period = 2.0 * (2.0 * gap / speed + std::f64::consts::PI * (mass / stiffness).sqrt());
    let share = (0.3 / period).fract() * period;
    let half = 0.5 * period;
    let (direction, within) = if share < half { (1.0, share) } else { (-1.0, share - half) };
    let reached = gap / speed;
    let contact = std::f64::consts::PI * (mass / stiffness).sqrt();
    let exact = if within < reached {
        within * speed
    } else if within < reached + contact {
        gap + speed * (mass / stiffness).sqrt() * ((within - reached) * (stiffness / mass).sqrt()).sin()
    } else {
        gap - speed * (within - reached - contact)
    };
    // Each of some ten bounces may shift the time by the tolerance of a step, 1e-8 of it, of which it takes some hundred.
    assert!((positions[0] - direction * exact).abs() < 1e-5 * gap, "{positions:?} {exact}");
    assert!(velocities[0].abs() < speed * (1.0 + 1e-6));
}

#[test]
fn numbers_of_coordinates_have_the_unit_of_the_coordinate() {
    // The coordinates of a block on a guide with locked = ["x", "z", "ry", "rz"]: a displacement and an angle.
    let read = |more: &str| scenarios::valid(Path::new("."), &block(more), &[]).run.joints[0].clone();
    let drives = |value: &str| format!("drives = [{{ coordinate = 1, curve = {value} }}]\n");
    let stops = |upper: &str| {
        format!(
            "stops = [{{ coordinate = 1, upper = {upper}, stiffness = \"2 N m/rad\", damping = \"3 s/rad\" }}]\n"
        )
    };
    let with = read(&format!(
        "velocities = [\"2 mm/s\", \"180 deg/s\"]\nstiffness = [\"3 N/mm\", 5.0]\n{}{}",
        stops("\"90 deg\""),
        drives("{ kind = \"constant\", value = \"7 N mm\" }"),
    ));
    let without = read(&format!(
        "velocities = [2e-3, {}]\nstiffness = [3e3, 5.0]\nstops = [{{ coordinate = 1, upper = {}, stiffness = 2.0, damping = 3.0 }}]\n{}",
        std::f64::consts::PI,
        std::f64::consts::FRAC_PI_2,
        drives("7e-3"),
    ));
    assert_eq!(with, without);
    let fault = |more: &str| faults(&block(more));
    for (more, key, known) in [
        (stops("\"10 mm\""), "stops[0].upper", "is an angle, known here are rad, deg"),
        (
            drives("{ kind = \"harmonic\", amplitude = \"3 N\", frequency = 1.0 }"),
            "curve.amplitude",
            "known here are N m",
        ),
        (drives("\"3 N\""), "drives[0].curve", "known here are N m"),
        (
            "velocities = [\"2 mm/s\", \"3 mm/s\"]".into(),
            "guide.velocities",
            "coordinate 1 of a generic joint is an angle",
        ),
        ("rest = [\"2 deg\", 0.0]".into(), "guide.rest", "coordinate 0 of a generic joint is a displacement"),
        ("rest = [\"2 kg\", 0.0]".into(), "guide.rest", "unknown unit \"kg\", known here are m,"),
    ] {
        let found = fault(&more);
        assert!(found.contains(key) && found.contains(known), "{more}: {found}");
    }
}

#[test]
fn what_makes_no_sense_is_a_fault_of_the_scenario() {
    let guide = |more: &str| faults(&block(more));
    let stop = |entry: &str| guide(&format!("stops = [{{ {entry} }}]"));
    assert!(stop("coordinate = 0, stiffness = 1.0").contains("\"lower\" or an \"upper\""));
    assert!(stop("coordinate = 0, stiffness = 1.0, lower = 1.0, upper = 0.5").contains("must be > lower"));
    assert!(stop("coordinate = 2, stiffness = 1.0, lower = 1.0").contains("must be < 2"));
    assert!(guide("stop = { stiffness = 1.0, lower = 1.0 }").contains("others take \"stops\""));
    assert!(guide("friction_velocity = [1.0, 1.0]").contains("with friction"));
    assert!(guide("friction = [1.0]").contains("a generic joint has 2 coordinates"));
    let curve = "{ kind = \"table\", times = [0.0, 1.0], values = [0.0, 1.0], interpolation = \"linear\" }";
    let moved = guide(&format!("motions = [{{ coordinate = 0, curve = {curve} }}]"));
    assert!(moved.contains("its velocity jumps"), "{moved}");
    let driven = guide(
        "motions = [{ coordinate = 1, curve = 1.0 }]\ndrives = [{ coordinate = 0, curve = 2.0 }, { coordinate = 1, curve = 2.0 }]",
    );
    assert!(driven.contains("the motion of coordinate 1 is prescribed, no force along it"), "{driven}");
    let locked = |list: &str| faults(&block("").replace(r#"["x", "z", "ry", "rz"]"#, list));
    assert!(locked(r#"["x", "y", "z", "rx", "ry", "rz"]"#).contains("choose type \"fixed\""));
    assert!(locked("[]").contains("choose type \"free\""));
    assert!(locked(r#"["x", "x"]"#).contains("stands in the list already"));
    assert!(faults(&block("").replace("locked", "# locked")).contains("directions that the joint holds"));
    let spherical = block("stops = [{ coordinate = 1, stiffness = 1.0, lower = 1.0 }]");
    let spherical = spherical.replace("\"generic\"", "\"spherical\"").replace("locked", "# locked");
    assert!(faults(&spherical).contains("it has no angles"));
}

#[test]
fn an_elastic_rod_of_a_slider_crank_starts_undeformed_at_the_speed_of_the_crank() {
    let recording = run(r#"
        [simulation]
        end_time = 1e-5
        [bodies.crank]
        model = "rigid"
        mass = 0.5
        inertia = [1e-4, 1e-3, 1e-3]
        [bodies.rod]
        model = "solid"
        material = "aluminium"
        geometry = { shape = "box", size = [0.2, 0.01, 0.02] }
        discretisation = { degree = 2, elements = [4, 1, 1] }
        reduction = { modes = 4 }
        [bodies.piston]
        model = "rigid"
        mass = 0.3
        inertia = [1e-4, 1e-4, 1e-4]
        [joints.motor]
        type = "revolute"
        axis = [0.0, 0.0, 1.0]
        parent = { body = "ground", point = [0.0, 0.0, 0.0] }
        child = { body = "crank", point = [0.0, 0.0, 0.0] }
        angle_deg = 90
        angular_velocity = -30.0
        [joints.pin]
        type = "revolute"
        axis = [0.0, 0.0, 1.0]
        parent = { body = "crank", point = [0.05, 0.0, 0.0] }
        child = { body = "rod", face = "x-" }
        angle_deg = -104.47751218592993
        [joints.wrist]
        type = "revolute"
        axis = [0.0, 0.0, 1.0]
        parent = { body = "rod", face = "x+" }
        child = { body = "piston", point = [0.0, 0.0, 0.0] }
        angle_deg = 14.47751218592993
        [joints.guide]
        type = "prismatic"
        axis = [1.0, 0.0, 0.0]
        parent = { body = "ground", point = [0.0, 0.0, 0.0] }
        child = { body = "piston", point = [0.0, 0.0, 0.0] }
        closes_loop = true
        "#);
    let first = &recording.samples[0];
    let speeds: Vec<f64> = first.joints[..3].iter().map(|joint| joint.velocities[0]).collect();
    for (found, exact) in speeds.iter().zip([-30.0, 30.0, 0.0]) {
        assert!((found - exact).abs() < 1e-8 * 30.0, "{speeds:?}"); // the digits of the angles above
    }
    // The rod and the piston move with 1.5 m/s, the crank turns.
    let rod = 2700.0 * 0.2 * 0.01 * 0.02;
    let kinetic = 0.5 * (rod + 0.3) * 1.5_f64.powi(2) + 0.5 * 1e-3 * 900.0;
    assert!((first.energies.kinetic / kinetic - 1.0).abs() < 1e-7, "{} {kinetic}", first.energies.kinetic);
}

#[test]
fn a_joint_that_begins_beyond_its_stop_is_a_fault() {
    let begins = |y: f64| {
        let keys = "stops = [{ coordinate = 0, upper = 0.1, stiffness = 1e5 }]";
        block(&format!("coordinates = [{y}, 0.0]\n{keys}"))
    };
    let message = faults(&begins(0.2));
    assert!(
        message.contains("joints.guide.stops") && message.contains("begins at 0.2, 1e-1 beyond it"),
        "{message}"
    );
    assert!(scenarios::parse(Path::new("."), &begins(0.1), &[]).is_ok());
}
