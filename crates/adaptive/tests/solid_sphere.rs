//! A solid sphere on a rigid plane against the axisymmetric one, both refined without any setting.
//!
//! Contact begins and ends when the first point is touched. The axisymmetric points have one on the axis, the points of the solid
//! lie half an element `h` beside it and `h²/(4 R)` higher, so that its impact is shorter by some `h²/(2 R v)`: 0.3 % with 16
//! elements across the interval, four times as much with 8.

use crate::impacts;
use crate::impacts::{ALUMINIUM, Trace, finished, law, spec};
use adaptive::record::ImpactRecord;
use adaptive::spec::{BodySpec, ContactLaw, ContactSpec, InitialMotion, Target};
use nalgebra::{UnitQuaternion, Vector3};

const RADIUS: f64 = 10e-3;
const SPEED: f64 = 0.1;

/// The sphere falls on the plane with its top, bottom or whatever point `rotation` brings down.
fn fall(body: BodySpec) -> Trace {
    let target = Target::plane(Vector3::zeros(), Vector3::z());
    let contact = ContactSpec {
        name: "impact".into(),
        body: 0,
        target,
        law: ContactLaw::Surface(law()),
        damping: 0.0,
        initial_overlap: 0.0,
    };
    finished(&spec(vec![body], vec![contact], 1e-4))
}

fn solid(rotation: UnitQuaternion<f64>) -> BodySpec {
    let motion = InitialMotion {
        position: Vector3::z() * RADIUS,
        rotation,
        velocity: Vector3::z() * -SPEED,
        angular_velocity: Vector3::zeros(),
    };
    impacts::ball("ball", RADIUS, ALUMINIUM, motion)
}

fn compare(name: &str, trace: &Trace, expected: &ImpactRecord) {
    assert_eq!(trace.impacts.len(), 1, "{name}");
    let found = &trace.impacts[0];
    let duration = |i: &ImpactRecord| i.end - i.start;
    let peak = found.peak_force / expected.peak_force - 1.0;
    let length = duration(found) / duration(expected) - 1.0;
    println!(
        "{name}: peak {:.4} N, {peak:+.2e}; duration {:.3} us, {length:+.2e}; restitution {:.6}; momentum arm {:.1e}",
        found.peak_force,
        1e6 * duration(found),
        found.restitution,
        trace.last().angular_momentum.iter().fold(0.0_f64, |m, x| m.max(x.abs()))
    );
    // Claims of the project.
    assert!(peak.abs() < 5e-3, "{name}: peak {peak:e}");
    assert!(length.abs() < 5e-3, "{name}: duration {length:e}");
}

fn axisymmetric() -> ImpactRecord {
    let trace = fall(impacts::sphere("ball", RADIUS, ALUMINIUM, (RADIUS, -SPEED)));
    let impact = trace.impacts[0];
    println!(
        "axisymmetric: peak {:.4} N, duration {:.3} us",
        impact.peak_force,
        1e6 * (impact.end - impact.start)
    );
    impact
}

#[test]
#[ignore = "second tier: ten seconds; solid balls against Hertz are in the first (random_solid_impacts)"]
fn solid_sphere_on_a_plane_gives_the_axisymmetric_impact() {
    compare("at a regular point", &fall(solid(UnitQuaternion::identity())), &axisymmetric());
}

#[test]
#[ignore = "second tier: a minute"]
fn solid_sphere_gives_it_with_any_point_below() {
    let expected = axisymmetric();
    for (name, angles) in [
        ("at a pole", [0.5 * std::f64::consts::PI, 0.0, 0.0]),
        ("on a seam", [0.0, 0.25 * std::f64::consts::PI, 0.0]),
        ("anywhere", [0.7, 0.4, 1.1]),
    ] {
        let rotation = UnitQuaternion::from_euler_angles(angles[0], angles[1], angles[2]);
        compare(name, &fall(solid(rotation)), &expected);
    }
}
