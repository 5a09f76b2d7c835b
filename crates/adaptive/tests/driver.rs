//! Phases, events and records of a run, on a coarse aluminium ball between rigid planes.

use crate::impacts::{ALUMINIUM, Trace, contact, explicit, law, spec, sphere, try_run};
use adaptive::AdaptiveError;
use adaptive::record::PhaseKind;
use adaptive::run::recording::Recording;
use adaptive::spec::{
    BodyKind, BodySpec, ContactLaw, ContactSpec, DiscretisationSpec, ElasticSpec, InitialMotion,
    PenaltySearch, ReductionSpec, RefinementSpec, RunSpec, SurfaceLaw, Target, Treatment,
};
use iga_core::elasticity::{Material, Model};
use iga_core::nurbs::primitives::axisymmetric;
use nalgebra::{UnitQuaternion, Vector3};

const RADIUS: f64 = 10e-3; // m
const SPEED: f64 = 0.1; // m/s
/// Duration of the impact at that speed: 82.7 us.
const DURATION: f64 = 83e-6; // s
/// Error a step of 1e-8 over about 500 steps, and points that open and close within steps.
const DRIFT: f64 = 1e-6;

fn plane(name: &str, height: f64, normal: f64) -> ContactSpec {
    let law = SurfaceLaw {
        treatment: Treatment::Quasistatic,
        penalty: Some(1e18),
        search: PenaltySearch::Fixed,
        ..law()
    };
    let (point, normal) = (Vector3::new(0.0, 0.0, height), Vector3::new(0.0, 0.0, normal));
    ContactSpec {
        name: name.into(),
        body: 0,
        target: Target::plane(point, normal),
        law: ContactLaw::Surface(law),
        damping: 0.0,
        initial_overlap: 0.0,
    }
}

/// A ball whose lowest point starts `height` above the floor.
fn ball(height: f64, speed: f64, end_time: f64) -> RunSpec {
    let shape = axisymmetric::sphere(RADIUS).expect("a sphere");
    // 50 um elements over 0.3 mm; the contact radius reaches 0.168 mm.
    let refine = |z: f64| RefinementSpec { centre: [0.0, z, 0.0], width: 0.3e-3, elements: 6, ratio: 2.0 };
    let body = ElasticSpec::new(
        shape,
        Model::Axisymmetric,
        Material::new(72.8e9, 0.33, 2789.0).expect("aluminium"),
        DiscretisationSpec {
            degrees: vec![3, 3],
            elements: vec![2, 2],
            knots: None,
            refine: vec![refine(-RADIUS), refine(RADIUS)],
        },
        ReductionSpec::CraigBampton { modes: 3, fixed_interface_modes: None },
    );
    let motion = InitialMotion {
        position: Vector3::new(0.0, 0.0, RADIUS + height),
        rotation: UnitQuaternion::identity(),
        velocity: Vector3::new(0.0, 0.0, -speed),
        angular_velocity: Vector3::zeros(),
    };
    let ball = BodySpec { name: "ball".into(), kind: BodyKind::Elastic(Box::new(body)), motion };
    RunSpec { settings: explicit(end_time), ..spec(vec![ball], vec![plane("floor", 0.0, 1.0)], end_time) }
}

fn finished(spec: &RunSpec) -> Trace {
    let mut trace = Trace::default();
    let end = try_run(spec, &mut trace).unwrap_or_else(|e| panic!("{e}"));
    assert!(!end.is_interrupted);
    assert!(trace.samples.windows(2).all(|w| w[0].time < w[1].time), "times rise");
    let (reached, asked) = (trace.last().time, spec.settings.end_time);
    assert!((reached - asked).abs() <= f64::EPSILON * asked, "the last state is stored: {reached:e}");
    trace
}

#[test]
fn ball_from_above_hits_like_a_ball_that_starts_in_contact() {
    let mut touching = ball(0.0, SPEED, 2e-4);
    touching.settings.pressure = false;
    let touching = finished(&touching);
    let falling = finished(&ball(10e-6, SPEED, 3e-4));
    assert!(touching.samples.iter().all(|s| s.pressures.is_empty()), "as asked for");
    assert!(falling.samples.iter().any(|s| !s.pressures[0].is_empty()));
    assert_eq!(touching.kinds(), [PhaseKind::Impact, PhaseKind::Free]);
    assert_eq!(falling.kinds(), [PhaseKind::Free, PhaseKind::Impact, PhaseKind::Free]);
    let (a, b) = (touching.impacts[0], falling.impacts[0]);
    // 10 um at 0.1 m/s; events are located to 1e-9 of a step of 2.7 us.
    assert!((b.start - 1e-4).abs() < 1e-12, "{b:?}");
    let before = falling.samples.iter().rfind(|s| s.phase == 0).expect("a free phase");
    let gap = before.bodies[0].position[2] - RADIUS;
    assert!(gap.abs() < 1e-13, "last state before the impact: gap {gap:e} m");
    // The same steps but for their places in time: error control of 1e-8 per step.
    assert!((a.peak_force / b.peak_force - 1.0).abs() < 1e-5, "{} {}", a.peak_force, b.peak_force);
    assert!((a.end - a.start - (b.end - b.start)).abs() < 1e-10);
    assert!((a.impulse / b.impulse - 1.0).abs() < 1e-6);
    assert!(falling.energy_drift() < DRIFT && touching.energy_drift() < DRIFT);
}

#[test]
fn run_that_ends_in_contact_records_the_impact_so_far() {
    let end = 0.5 * DURATION;
    let trace = finished(&ball(0.0, SPEED, end));
    assert_eq!(trace.kinds(), [PhaseKind::Impact]);
    let impact = trace.impacts[0];
    assert!((impact.end - end).abs() < 1e-15 && trace.last().contacts[0].normal_force > 0.0);
    // Half an impact: the bodies have not parted.
    assert!(impact.separation_velocity.is_nan() && impact.restitution.is_nan(), "{impact:?}");
    assert!((trace.trials[0].stop - end).abs() < 1e-15);
}

#[test]
fn an_impact_in_the_last_instant_is_not_begun() {
    // Contact points of the run, and a zone that the program would make.
    let lasting = |end: f64| ball(10e-6, SPEED, end);
    let refined = |end: f64| RunSpec {
        settings: explicit(end),
        ..spec(
            vec![sphere("ball", RADIUS, ALUMINIUM, (RADIUS + 10e-6, -SPEED))],
            vec![contact("floor", 0, Target::plane(Vector3::zeros(), Vector3::z()))],
            end,
        )
    };
    let cases: [&dyn Fn(f64) -> RunSpec; 2] = [&lasting, &refined];
    for of in cases {
        // The ball arrives at 0.1 ms; rounding of its place moves that by 2e-17 s and more.
        for end in [1e-4 * (1.0 - 1e-15), 1e-4, 1e-4 * (1.0 + 1e-15)] {
            let trace = finished(&of(end));
            assert_eq!(trace.kinds(), [PhaseKind::Free], "{end:e}");
            // No fine model was made for it.
            assert!(trace.impacts.is_empty() && trace.trials.is_empty() && trace.transfers.is_empty());
            assert!((trace.last().bodies[0].position[2] - RADIUS).abs() < 1e-14);
        }
        let trace = finished(&of(1e-4 + 1e-9));
        assert_eq!((trace.kinds().len(), trace.impacts.len()), (2, 1));
    }
}

#[test]
fn ball_between_two_planes_flies_freely_between_its_impacts() {
    let clearance = 20e-6;
    let mut spec = ball(0.0, SPEED, 7e-4);
    spec.contacts.push(plane("ceiling", 2.0 * RADIUS + clearance, -1.0));
    let trace = finished(&spec);
    let impact = PhaseKind::Impact;
    assert_eq!(trace.kinds(), [impact, PhaseKind::Free, impact, PhaseKind::Free, impact, PhaseKind::Free]);
    assert_eq!(trace.impacts.iter().map(|i| i.contact).collect::<Vec<_>>(), [0, 1, 0]);
    for pair in trace.impacts.windows(2) {
        // Flight at the rebound speed; vibration of the pole moves touch and release by less than a tenth of a microsecond.
        let flight = clearance / pair[0].separation_velocity;
        assert!((pair[1].start - pair[0].end - flight).abs() < 2e-6, "{pair:?}");
        assert!((pair[1].peak_force / pair[0].peak_force - 1.0).abs() < 1e-2, "{pair:?}");
    }
    assert!(trace.energy_drift() < 3.0 * DRIFT, "{:e}", trace.energy_drift());
}

#[test]
fn energy_with_gravity_is_counted_from_the_start() {
    // 1000 m/s^2, so that gravity counts beside the impact.
    let mut spec = ball(1e-6, SPEED, 2e-4);
    spec.settings.gravity = Vector3::new(0.0, 0.0, -1000.0);
    let trace = finished(&spec);
    assert!(trace.samples[0].energies.gravity.abs() < 1e-30, "{:?}", trace.samples[0].energies);
    let kinetic = trace.samples[0].energies.kinetic;
    let change = trace.samples.iter().map(|s| (s.energies.total() - kinetic).abs()).fold(0.0, f64::max);
    assert!(change < DRIFT * kinetic, "{change:e} J of {kinetic:e} J");
    let lowest = trace.samples.iter().map(|s| s.energies.gravity).fold(f64::INFINITY, f64::min);
    assert!(lowest < -1e-3 * kinetic, "gravity does work: {lowest:e} J");
    let mass = trace.samples[0].linear_momentum[2] / -SPEED;
    let end = trace.last();
    let change = end.linear_momentum[2] - trace.samples[0].linear_momentum[2];
    let expected = trace.impacts[0].impulse - mass * 1000.0 * end.time;
    assert!((change / expected - 1.0).abs() < 1e-8, "impulse less weight: {change:e} {expected:e}");
}

#[test]
fn impact_ends_after_the_quiet_time() {
    let mut spec = ball(0.0, SPEED, 2e-4);
    spec.settings.quiet_time = Some(30e-6);
    let trace = finished(&spec);
    let quiet = trace.phases[0].end - trace.impacts[0].end;
    // Ends with the first step beyond the quiet time that starts after the last force; two steps of 2.7 us.
    assert!((30e-6..36e-6).contains(&quiet), "{quiet:e}");
    assert!(trace.impacts[0].end < DURATION);
}

#[test]
fn ball_that_leaves_the_plane_has_no_impact() {
    let trace = finished(&ball(0.0, -SPEED, 2e-4));
    assert_eq!(trace.kinds(), [PhaseKind::Impact, PhaseKind::Free]);
    assert!(trace.impacts.is_empty() && trace.trials.is_empty());
    assert!((trace.last().bodies[0].position[2] - RADIUS - SPEED * 2e-4).abs() < 1e-15);
}

#[test]
fn contact_that_outgrows_its_interval_stops_the_run() {
    let mut spec = ball(0.0, SPEED, 1e-4);
    let BodyKind::Elastic(ball) = &mut spec.bodies[0].kind else { panic!("an elastic ball") };
    ball.discretisation.refine[0].width = 0.12e-3;
    let mut trace = Trace::default();
    let error = try_run(&spec, &mut trace).expect_err("0.168 mm do not fit into 0.12 mm");
    assert!(!error.is_model_error());
    let AdaptiveError::IntervalTooSmall { contact, time, width } = error else { panic!("{error}") };
    assert_eq!(contact, "floor");
    assert!((width - 0.12e-3).abs() < 1e-15);
    // Hertz: the contact radius passes 0.1 mm, where the last element begins, at a third of the largest approach.
    assert!(time > 0.05 * DURATION && time < 0.3 * DURATION, "{time:e}");
    assert!((trace.last().time - time).abs() < 1e-15, "what was computed is stored");
}

#[test]
fn interrupted_run_keeps_its_last_state_and_impact() {
    let mut trace = Trace(Recording { stop_at: Some(20e-6), ..Recording::default() });
    let end = try_run(&ball(0.0, SPEED, 1e-4), &mut trace).unwrap_or_else(|e| panic!("{e}"));
    assert!(end.is_interrupted && (20e-6..23e-6).contains(&end.time));
    assert!((trace.last().time - end.time).abs() < 1e-15);
    assert_eq!((trace.impacts.len(), trace.trials[0].outcome.identifier()), (1, "interrupted"));
}

#[test]
fn states_of_a_long_phase_are_stored_at_growing_intervals() {
    let stored = |share: f64| {
        let mut spec = ball(0.1e-3, 0.1, 4e-2);
        spec.settings.free_interval = Some(1e-5);
        (spec.settings.phase_share, spec.settings.free_share) = (share, share);
        finished(&spec)
    };
    let (all, few) = (stored(0.0), stored(0.02));
    assert_eq!(all.kinds(), few.kinds());
    assert!(few.samples.len() * 4 < all.samples.len(), "{} {}", few.samples.len(), all.samples.len());
    let phases: Vec<(f64, f64)> = few.phases.iter().map(|p| (p.start, p.end)).collect();
    for pair in few.samples.windows(2) {
        let (before, now) = (pair[0].time, pair[1].time);
        let Some((start, end)) = phases.iter().find(|(start, end)| *start < before && now < *end) else {
            continue;
        };
        // Between two states of one phase: at least 2 % of its time so far, to round-off; its end is stored in any case.
        assert!(
            now - before >= 0.02 * (before - start) * (1.0 - 1e-9),
            "{before:e} {now:e}, {start:e} to {end:e}"
        );
    }
    // Nothing else changes.
    assert_eq!(all.impacts, few.impacts);
}
