//! Several refined pairs in one impact phase, and one pair that meets many times; no setting anywhere.

use crate::impacts::{STEEL, Trace, contact, finished, softened, spec, sphere};
use adaptive::record::TrialOutcome;
use adaptive::record::{PhaseKind, Sample};
use adaptive::spec::{RunSpec, Target};
use nalgebra::Vector3;

const RADIUS: f64 = 10e-3; // m
const SPEED: f64 = 0.1; // m/s
/// Permitted drift of the energy, all transfers and changes of the penalty factor counted (claim 1 of docs/verification.md).
const DRIFT: f64 = 1e-5;
/// Permitted jump of a single transfer (claim 2 of docs/verification.md).
const JUMP: f64 = 1e-5;
/// Permitted change of the momentum: forces are equal and opposite to round-off (claim 3 of docs/verification.md).
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
    assert!(trace.trials.iter().any(|t| t.outcome == TrialOutcome::Accepted));
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
    let (expected, _) = masses_and_springs(3, 2e-4);
    for (body, v) in trace.last().bodies.iter().zip(&expected) {
        assert!((body.velocity[2] - v).abs() < 0.01 * SPEED, "{expected:?}");
    }
}

/// What becomes of a row of `n` spheres that touch, of which the first has the speed of the tests, up to the time `end` if they are
/// point masses between springs `k x^1.5`: their velocities, and the largest force of each contact.
fn masses_and_springs(n: usize, end: f64) -> (Vec<f64>, Vec<f64>) {
    let k = 4.0 / 3.0 * 0.5 * STEEL.youngs / (1.0 - STEEL.poisson.powi(2)) * (0.5 * RADIUS).sqrt();
    let (mut x, mut v, mut peaks) = (vec![0.0_f64; n], vec![0.0; n], vec![0.0_f64; n - 1]);
    v[0] = SPEED;
    // Leapfrog; steps of a nanosecond over impacts of 50 us leave an error far below what is compared.
    let h = 1e-9;
    for _ in 0..(end / h) as usize {
        for i in 0..n - 1 {
            let force = k * (x[i] - x[i + 1]).max(0.0).powf(1.5);
            peaks[i] = peaks[i].max(force);
            v[i] -= h * force / mass();
            v[i + 1] += h * force / mass();
        }
        x.iter_mut().zip(&v).for_each(|(x, v)| *x += h * v);
    }
    (v, peaks)
}

#[test]
fn contacts_that_a_wave_has_not_reached_are_not_judged() {
    // The wave takes some 14 us from contact to contact: the last ones carry no more than errors of the motion.
    let (n, end) = (9, 6e-5);
    let ball = |i: usize| {
        sphere(&format!("s{i}"), RADIUS, STEEL, (2.0 * RADIUS * i as f64, if i == 0 { SPEED } else { 0.0 }))
    };
    let pair = |i: usize| contact(&format!("c{i}"), i + 1, Target::Body(i));
    let trace = finished(&spec((0..n).map(ball).collect(), (0..n - 1).map(pair).collect(), end));
    assert!(trace.energy_drift() < DRIFT && trace.momentum_change(mass() * SPEED) < MOMENTUM);
    let (_, peaks) = masses_and_springs(n, end);
    let main = peaks.iter().copied().fold(0.0, f64::max);
    let found =
        |i: usize| trace.impacts.iter().find(|r| r.contact as usize == i).map_or(0.0, |r| r.peak_force);
    for (i, peak) in peaks.into_iter().enumerate() {
        // Spheres of finite size are stiffer and vibrate: less than 1 % of the largest force each.
        assert!((found(i) - peak).abs() < 0.02 * main, "contact {i}: {} N, {peak} N", found(i));
    }
    assert!((1..n - 1).any(|i| 0.0 < found(i) && found(i) < 1e-8 * main), "no contact carries errors alone");
    // As many as the contacts that carry force need: two widths, three factors.
    assert!(trace.trials.iter().all(|t| t.number <= 6), "{:?}", trace.trials);
}

#[test]
fn second_pair_joins_a_running_impact() {
    let trace = finished(&softened(cradle(1e-6, 2e-4)));
    check(&trace, mass() * SPEED);
    let [front, back] = [trace.impacts[0], trace.impacts[1]];
    assert_eq!([front.contact, back.contact], [0, 1]);
    assert!(front.start < back.start && back.start < front.end, "{front:?} {back:?}");
    // A trial that only says that another penalty factor follows ends once the later of both has turned back.
    let (peak, end) = (front.peak_time.max(back.peak_time), front.end.max(back.end));
    let raised: Vec<_> = trace.trials.iter().filter(|t| t.reason.contains("not yet compared")).collect();
    assert!(!raised.is_empty() && raised.iter().all(|t| t.outcome == TrialOutcome::Rejected));
    // The force has fallen to a half by then.
    let is_at_peak = |stop: f64| peak < stop && stop < peak + 0.7 * (end - peak);
    assert!(raised.iter().all(|t| is_at_peak(t.stop)), "{peak:e} to {end:e}: {raised:?}");
    // Nobody flies into anybody afterwards.
    let v: Vec<f64> = trace.last().bodies.iter().map(|b| b.velocity[2]).collect();
    assert!(v[0] <= v[1] && v[1] < v[2], "{v:?}");
}

#[test]
fn ball_between_two_planes_meets_them_again_and_again() {
    let clearance = 20e-6;
    let plane = |z: f64, n: f64| Target::plane(Vector3::z() * z, Vector3::z() * n);
    let bodies = vec![sphere("ball", RADIUS, STEEL, (RADIUS, -SPEED))];
    let contacts = vec![
        contact("floor", 0, plane(0.0, 1.0)),
        contact("ceiling", 0, plane(2.0 * RADIUS + clearance, -1.0)),
    ];
    let trace = finished(&spec(bodies, contacts, 1.75e-3));
    // An impact of 55 us and a flight of 200 us in turn.
    let contacts: Vec<u32> = trace.impacts.iter().map(|i| i.contact).collect();
    assert_eq!(contacts, [0, 1, 0, 1, 0, 1, 0]);
    // The share of penetration shows that the first penalty factor is high enough; impacts that follow know it, and the width.
    let trials: Vec<u32> = trace.trials.iter().map(|t| t.number).collect();
    assert_eq!(trials, [1; 7]);
    let peaks = trace.impacts.iter().map(|i| i.peak_force / trace.impacts[0].peak_force);
    // Vibration left from earlier impacts.
    assert!(peaks.clone().all(|p| (p - 1.0).abs() < 1e-2), "{:?}", peaks.collect::<Vec<_>>());
    assert!(trace.energy_drift() < DRIFT && trace.largest_jump() < JUMP);
}

#[test]
fn a_run_may_end_with_its_third_impact() {
    let clearance = 20e-6;
    let plane = |z: f64, n: f64| Target::plane(Vector3::z() * z, Vector3::z() * n);
    let bodies = vec![sphere("ball", RADIUS, STEEL, (RADIUS, -SPEED))];
    let contacts = vec![
        contact("floor", 0, plane(0.0, 1.0)),
        contact("ceiling", 0, plane(2.0 * RADIUS + clearance, -1.0)),
    ];
    let mut spec = spec(bodies, contacts, 1.75e-3);
    let whole = finished(&spec);
    spec.settings.stop_after_impacts = Some(3);
    let trace = finished(&spec);
    assert_eq!(trace.impacts, whole.impacts[..3]);
    // Its last state is the end of the third impact phase, and everything before it is as in the longer run.
    let end = whole.phases.iter().filter(|p| p.kind == PhaseKind::Impact).nth(2).expect("three impacts").end;
    assert!(trace.last().time.to_bits() == end.to_bits() && end < 1e-3, "{:e} {end:e}", trace.last().time);
    let n = trace.samples.len() - 1;
    let is_same = |a: &[Sample], b: &[Sample]| {
        let key = |s: &Sample| (s.time, s.phase, s.bodies.clone());
        a.len() == b.len() && a.iter().zip(b).all(|(a, b)| key(a) == key(b))
    };
    assert!(is_same(&trace.samples[..n], &whole.samples[..n]));
    spec.settings.stop_after_impacts = Some(30);
    assert!(is_same(&finished(&spec).samples, &whole.samples));
}
