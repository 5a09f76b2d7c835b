//! Runs that end as soon as their bodies are at rest.

use crate::support::scenarios;
use crate::support::scenarios::run_text as run;
use std::path::Path;

use adaptive::record::{PhaseKind, Sample};
use adaptive::run::recording::Recording;

fn last(recording: &Recording) -> &Sample {
    recording.samples.last().expect("samples")
}

/// A mass of 2 kg on a spring with a twentieth of the critical damping, drawn out by 10 mm; `more` are further keys of the simulation.
fn oscillator(more: &str) -> String {
    format!(
        r#"
        [simulation]
        end_time = 20.0
        free = {{ max_step = 1e-3 }}
        {more}
        [bodies.block]
        model = "rigid"
        mass = 2.0
        inertia = [0.01, 0.02, 0.03]
        [joints.guide]
        type = "prismatic"
        axis = [1.0, 0.0, 0.0]
        parent = {{ body = "ground", point = [0.0, 0.0, 0.0] }}
        child = {{ body = "block", point = [0.0, 0.0, 0.0] }}
        displacement = 0.01
        stiffness = 800.0
        damping = 4.0
        "#
    )
}

#[test]
fn a_damped_mass_ends_its_run_when_it_has_been_slow_for_long_enough() {
    let (speed, duration, step) = (1e-3, 0.2, 1e-3);
    let recording = run(&oscillator("stop_at_rest = { speed = 1e-3, duration = 0.2 }"));
    // v = -x0 w0/sqrt(1 - z²) exp(-z w0 t) sin(w t); half a period is 0.157 s, so that a turn alone is no rest.
    let (natural, ratio): (f64, f64) = (20.0, 0.05);
    let root = (1.0 - ratio * ratio).sqrt();
    let velocity =
        |t: f64| -0.01 * natural / root * (-ratio * natural * t).exp() * (natural * root * t).sin();
    let slow_since =
        (0..200_000).map(|i| 1e-4 * f64::from(i)).filter(|t| velocity(*t).abs() > speed).fold(0.0, f64::max);
    let end = last(&recording).time;
    // Speeds are looked at after each step: a step late for the start and for the end.
    assert!(
        end >= slow_since + duration && end <= slow_since + duration + 2.0 * step + 1e-4,
        "{end} {slow_since}"
    );
    assert!(velocity(0.0).abs() < speed && slow_since > 4.0, "it starts slowly and swings on: {slow_since}");
    // The rest of the run is as without the key.
    let whole = run(&oscillator(""));
    let n = recording.samples.len() - 1;
    assert!(whole.samples.len() > n && last(&whole).time >= 20.0);
    for (a, b) in recording.samples[..n].iter().zip(&whole.samples) {
        assert!(a.time.to_bits() == b.time.to_bits() && a.joints == b.joints, "{}", a.time);
    }
}

#[test]
fn a_ball_that_lies_on_the_floor_ends_its_run_in_contact() {
    let recording = run(r#"
        [simulation]
        end_time = 1e-2
        gravity = [0.0, 0.0, -9.81]
        stop_at_rest = { speed = 1e-2, duration = 1e-4 }
        [bodies.ball]
        model = "axisymmetric"
        material = "steel"
        geometry = { shape = "sphere", radius = 0.01 }
        position = [0.0, 0.0, 0.01]
        [bodies.floor]
        model = "rigid"
        geometry = { shape = "plane" }
        normal = [0.0, 0.0, 1.0]
        [contacts.lies]
        contact_body = "ball"
        target_body = "floor"
        "#);
    let end = last(&recording);
    assert!(
        recording.phases[end.phase as usize].kind == PhaseKind::Impact
            && end.time >= 1e-4
            && end.time < 1.1e-4,
        "{:?} {}",
        end.phase,
        end.time
    );
}

#[test]
fn both_numbers_are_asked_for() {
    let faults = scenarios::parse(Path::new("."), &oscillator("stop_at_rest = { speed = 1e-3 }"), &[])
        .expect_err("a fault");
    assert!(faults.iter().any(|f| f.key == "simulation.stop_at_rest.duration"), "{faults:#?}");
}
