//! Several refined pairs in one impact phase, and one pair that meets many times; no setting anywhere.

mod impacts;

use adaptive::record::PhaseKind;
use adaptive::spec::{RunSpec, Target};
use impacts::{STEEL, Trace, contact, finished, spec, sphere};
use nalgebra::Vector3;

const RADIUS: f64 = 10e-3; // m
const SPEED: f64 = 0.1; // m/s
/// Permitted drift of the energy, all hand-overs and changes of the penalty factor counted (claim of the project).
const DRIFT: f64 = 1e-5;
/// Permitted jump of a single hand-over (claim of the project).
const JUMP: f64 = 1e-5;
/// Permitted change of the momentum: forces are equal and opposite to round-off (claim of the project).
const MOMENTUM: f64 = 1e-12;

/// Three steel spheres in a row, the first flies at the others, which are `gap` apart.
fn cradle(gap: f64, end: f64) -> RunSpec {
    let ball = |name, z, v| sphere(name, RADIUS, STEEL, (z, v));
    let bodies = vec![
        ball("first", -2.0 * RADIUS, SPEED),
        ball("middle", 0.0, 0.0),
        ball("last", 2.0 * RADIUS + gap, 0.0),
    ];
    let contacts = vec![contact("front", 0, Target::Body(1)), contact("back", 1, Target::Body(2))];
    spec(bodies, contacts, end)
}

fn check(trace: &Trace, momentum: f64) {
    assert!(trace.energy_drift() < DRIFT, "{:e}", trace.energy_drift());
    assert!(!trace.transfers.is_empty() && trace.largest_jump() < JUMP, "{:e}", trace.largest_jump());
    assert!(trace.momentum_change(momentum) < MOMENTUM, "{:e}", trace.momentum_change(momentum));
    assert!(trace.tries.iter().any(|t| t.outcome == "accepted"));
}

fn mass() -> f64 {
    4.0 / 3.0 * std::f64::consts::PI * RADIUS.powi(3) * STEEL.density
}

#[test]
fn middle_sphere_of_a_cradle_takes_part_in_two_pairs_at_once() {
    let trace = finished(&cradle(0.0, 2e-4));
    check(&trace, mass() * SPEED);
    assert_eq!(trace.phases[0].kind, PhaseKind::Impact);
    assert_eq!(trace.impacts.iter().map(|i| i.contact).collect::<Vec<_>>(), [0, 1]);
    let [front, back] = [trace.impacts[0], trace.impacts[1]];
    assert!(back.start < front.end, "both pairs touch at the same time: {front:?} {back:?}");
    // Masses and Hertz springs; spheres of finite size vibrate, and are stiffer by less than 1 %.
    let expected = masses_and_springs();
    for (body, v) in trace.last().bodies.iter().zip(expected) {
        assert!((body.velocity[2] - v).abs() < 0.01 * SPEED, "{expected:?}");
    }
}

/// Velocities that the three spheres end with if they are point masses between springs `k x^1.5`.
fn masses_and_springs() -> [f64; 3] {
    let k = 4.0 / 3.0 * 0.5 * STEEL.youngs / (1.0 - STEEL.poisson.powi(2)) * (0.5 * RADIUS).sqrt();
    let (mut x, mut v) = ([0.0_f64; 3], [SPEED, 0.0, 0.0]);
    // Leapfrog; 2e5 steps over twice the time of an impact leave an error far below what is compared.
    let h = 2e-4 / 2e5;
    for _ in 0..200_000 {
        let [front, back] = [x[0] - x[1], x[1] - x[2]].map(|d| k * d.max(0.0).powf(1.5) / mass());
        v = [v[0] - h * front, v[1] + h * (front - back), v[2] + h * back];
        x = std::array::from_fn(|i| x[i] + h * v[i]);
    }
    v
}

#[test]
fn second_pair_joins_a_running_impact() {
    let trace = finished(&cradle(1e-6, 2e-4));
    check(&trace, mass() * SPEED);
    let [front, back] = [trace.impacts[0], trace.impacts[1]];
    assert_eq!([front.contact, back.contact], [0, 1]);
    assert!(front.start < back.start && back.start < front.end, "{front:?} {back:?}");
    // Nobody flies into anybody afterwards.
    let v: Vec<f64> = trace.last().bodies.iter().map(|b| b.velocity[2]).collect();
    assert!(v[0] <= v[1] && v[1] < v[2], "{v:?}");
}

#[test]
fn ball_between_two_planes_meets_them_again_and_again() {
    let clearance = 20e-6;
    let plane = |z: f64, n: f64| Target::Plane { point: Vector3::z() * z, normal: Vector3::z() * n };
    let bodies = vec![sphere("ball", RADIUS, STEEL, (RADIUS, -SPEED))];
    let contacts = vec![
        contact("floor", 0, plane(0.0, 1.0)),
        contact("ceiling", 0, plane(2.0 * RADIUS + clearance, -1.0)),
    ];
    let trace = finished(&spec(bodies, contacts, 1.75e-3));
    // An impact of 55 us and a flight of 200 us in turn.
    let contacts: Vec<u32> = trace.impacts.iter().map(|i| i.contact).collect();
    assert_eq!(contacts, [0, 1, 0, 1, 0, 1, 0]);
    // The first impact takes two tries, those that follow know width and penalty factor.
    let tries: Vec<u32> = trace.tries.iter().map(|t| t.number).collect();
    assert_eq!(tries, [1, 2, 1, 1, 1, 1, 1, 1]);
    let peaks = trace.impacts.iter().map(|i| i.peak_force / trace.impacts[0].peak_force);
    // Vibration left from earlier impacts.
    assert!(peaks.clone().all(|p| (p - 1.0).abs() < 1e-2), "{:?}", peaks.collect::<Vec<_>>());
    assert!(trace.energy_drift() < DRIFT && trace.largest_jump() < JUMP);
}
