//! Friction of bearings by the load of their joints from a scenario, against closed forms, and what is refused.

use crate::support::scenarios;
use crate::support::scenarios::{faults, run_text as run};
use std::path::Path;

const G: f64 = 9.81;

/// A block of 2 kg on a guide along x, which is inclined by `angle`: gravity is; `more` are further keys of the guide, then tables.
fn block(angle: f64, more: &str) -> String {
    let (down, along) = (-G * angle.cos(), G * angle.sin());
    format!(
        r#"
        [simulation]
        end_time = 0.4
        gravity = [{along:e}, 0.0, {down:e}]
        [bodies.block]
        model = "rigid"
        mass = 2.0
        inertia = [0.01, 0.02, 0.03]
        [joints.guide]
        type = "prismatic"
        axis = [1.0, 0.0, 0.0]
        parent = {{ body = "ground", point = [0.0, 0.0, 0.0] }}
        child = {{ body = "block", point = [0.0, 0.0, 0.0] }}
        velocity = 0.5
        {more}
        "#
    )
}

#[test]
fn a_block_slides_down_a_slope_with_g_sin_less_mu_g_cos() {
    let (angle, mu, speed, time): (f64, f64, f64, f64) = (0.5, 0.3, 0.5, 0.4);
    let recording = run(&block(angle, "bearing = { friction = 0.3 }"));
    let last = recording.samples.last().expect("samples");
    let (position, velocity) = (last.joints[0].positions[0], last.joints[0].velocities[0]);
    let a = G * (angle.sin() - mu * angle.cos());
    // The transition at 1e-4 m/s takes (u/v)²/2 of the friction, 2e-8; steps err by 1e-8 each, some tens of them.
    assert!((velocity - speed - a * time).abs() < 1e-6 * velocity, "{velocity}");
    assert!((position - speed * time - 0.5 * a * time * time).abs() < 1e-6 * position, "{position}");
    // The ledger closes: what the weight has given and is no motion has gone into friction.
    let first = &recording.samples[0].energies;
    let kinetic = last.energies.kinetic - first.kinetic;
    let weight = 2.0 * G * angle.sin() * position;
    let friction = 2.0 * mu * G * angle.cos() * position;
    assert!((kinetic - weight + friction).abs() < 1e-6 * weight);
    assert!((last.energies.dissipated - friction).abs() < 1e-6 * friction, "{}", last.energies.dissipated);
}

#[test]
fn a_guide_with_a_length_feels_where_it_is_pushed() {
    // A push along x, beside the guide by e: a couple of e F, which supports at a distance ℓ hold with e F/ℓ each, both rubbing. There is no
    // weight: a = F/m (1 - 2 μ e/ℓ).
    let text = |length: f64| {
        block(0.0, &format!("bearing = {{ friction = 0.3, length = {length} }}\n[loads.push]\nbody = \"block\"\npoint = [0.0, 0.0, 0.0]\nforce_x = 10.0\nmoment_y = 0.5"))
            .replace("gravity = [0", "#")
    };
    for (length, share) in [(0.1, 1.0 - 2.0 * 0.3 * 0.05 / 0.1), (1.0, 1.0 - 2.0 * 0.3 * 0.05)] {
        let recording = run(&text(length));
        let velocity = recording.samples.last().expect("samples").joints[0].velocities[0];
        let exact = 0.5 + 10.0 / 2.0 * share * 0.4;
        assert!((velocity - exact).abs() < 1e-6 * exact, "{velocity} {exact}");
    }
}

#[test]
fn what_makes_no_sense_is_a_fault_of_the_scenario() {
    let guide = |more: &str| faults(&block(0.5, more));
    assert!(guide("bearing = { radius = 0.01 }").contains("friction"));
    assert!(guide("bearing = { friction = -0.1 }").contains("bearing.friction"));
    assert!(guide("bearing = { friction = 0.1, length = 0.0 }").contains("bearing.length"));
    let collar = guide("bearing = { friction = 0.1, collar = 0.1 }");
    assert!(collar.contains("for type \"revolute\" only"), "{collar}");
    let hinge = |more: &str| {
        let text = block(0.5, more).replace("prismatic", "revolute").replace("velocity = 0.5", "");
        faults(&text)
    };
    let radius = hinge("bearing = { friction = 0.1 }");
    assert!(radius.contains("the radius at which a revolute joint slides"), "{radius}");
    let planar = faults(
        &block(0.5, "bearing = { friction = 0.1, radius = 0.1 }")
            .replace("prismatic", "planar")
            .replace("velocity = 0.5", ""),
    );
    assert!(planar.contains("give others the size of their friction in \"friction\""), "{planar}");
    let closes = faults(&block(0.5, "bearing = { friction = 0.1 }\ncloses_loop = true"));
    assert!(closes.contains("close a loop"), "{closes}");
}

#[test]
fn a_jam_ends_the_run_with_the_joint_and_what_to_change() {
    // The centre of mass stands 0.3 m above a guide of 0.25 m: sliding at μ = 0.6 loads its supports by 1.44 of what they carry.
    let text = block(0.0, "bearing = { friction = 0.6, length = 0.25 }");
    let text = text.replace("\"block\", point = [0.0, 0.0, 0.0]", "\"block\", point = [0.0, 0.0, -0.3]");
    let scenario = scenarios::valid(Path::new("."), &text, &[]);
    let message = scenarios::refusal(&scenario);
    assert!(message.contains("\"guide\" jams") && message.contains("longer bearing"), "{message}");
}
