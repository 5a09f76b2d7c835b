//! Balls in oblique impact on each other: momenta, energy ledger, sliding and sticking.

use crate::common::Random;
use crate::free_motion::{body_state, free_system, state_vector};
use crate::pair_support::caps::{RADIUS, caps_with};
use contact_qs::quasistatic::PointState;
use contact_qs::{ActiveContact, Friction, SurfacePair};
use ffr_dynamics::body::{RigidMotion, StandardInputData};
use ffr_dynamics::force::BodyState;
use ffr_dynamics::force::active::{Active, ActiveForce};
use ffr_dynamics::integration::{Integrator, StepSettings};
use ffr_dynamics::system::{ErrorScale, Multibody};
use nalgebra::{Matrix3, UnitQuaternion, Vector3};

const MASS: f64 = 0.0329;
const INERTIA: f64 = 0.4 * MASS * RADIUS * RADIUS;
/// Closing speed that presses the balls 2 µm together ([`contact_qs::law::hertz`], Eq. C.22).
const SPEED: f64 = 0.055;

fn system(coefficient: f64) -> Multibody<Box<Active<SurfacePair>>> {
    let pair = caps_with(0, 1.6e-4, 8, 1e18).with_friction(Friction::new(coefficient)).unwrap();
    let inertia = Matrix3::identity() * INERTIA;
    let ball = StandardInputData::rigid(RigidMotion::Spatial, MASS, Vector3::zeros(), inertia).unwrap();
    let bodies = vec![("upper", ball.clone()), ("lower", ball)];
    let mut system = free_system(bodies, Vector3::zeros(), vec![Box::new(Active::new(pair))]);
    let scale = ErrorScale { relative: 1e-9, ..system.error_scale() };
    system.set_error_scale(scale).unwrap();
    system
}

struct Outcome {
    states: [BodyState; 2],
    before: f64,
    after: f64,
    dissipated: f64,
    /// Largest deviation of the energy ledger and fall of the dissipated work, as shares of the energy at the start.
    drift: f64,
    fall: f64,
    /// Largest changes of momentum and angular momentum, as shares of those of the closing motion.
    momentum: f64,
    angular: f64,
    was_stuck: bool,
    was_sliding: bool,
    is_rim_touched: bool,
    duration: f64,
}

/// Both momenta about the origin.
fn momenta(states: &[BodyState; 2]) -> [Vector3<f64>; 2] {
    let sum = |f: &dyn Fn(&BodyState) -> Vector3<f64>| f(&states[0]) + f(&states[1]);
    [
        sum(&|s| MASS * s.velocity),
        sum(&|s| MASS * s.position.cross(&s.velocity) + INERTIA * (s.rotation * s.angular_velocity_in_body)),
    ]
}

fn run(coefficient: f64, start: &[BodyState; 2]) -> Outcome {
    let mut system = system(coefficient);
    let y = state_vector(&system, start);
    let before = system.invariants(0.0, &y).kinetic;
    let mut integrator = Integrator::explicit(StepSettings::with_max_step(1.5e-6), 0.0, &y).unwrap();
    let reference = momenta(start);
    let mut out = Outcome {
        states: start.clone(),
        before,
        after: before,
        dissipated: 0.0,
        drift: 0.0,
        fall: 0.0,
        momentum: 0.0,
        angular: 0.0,
        was_stuck: false,
        was_sliding: false,
        is_rim_touched: false,
        duration: 0.0,
    };
    let mut n_open = 0;
    while n_open < 5 && integrator.time() < 3e-4 {
        integrator.step(&mut system, 1.0).unwrap();
        let y = integrator.state();
        let pair = &system.forces()[0];
        let report = *pair.report();
        for (state, force) in pair.state().point_states().iter().zip(pair.point_forces().unwrap()) {
            out.was_stuck |= *force > 0.0 && *state == PointState::Stick;
            out.was_sliding |= *force > 0.0 && *state == PointState::Slip;
        }
        out.is_rim_touched |= report.is_rim_touched;
        if report.n_active > 0 {
            (n_open, out.duration) = (0, integrator.time());
        } else {
            n_open += usize::from(out.duration > 0.0);
        }
        let work = system.dissipated_work(y);
        out.fall = out.fall.max((out.dissipated - work) / before);
        out.dissipated = work;
        out.after = system.invariants(0.0, y).kinetic;
        let stored = system.forces()[0].energies();
        let total = out.after + stored.elastic_high + stored.penalty + work;
        out.drift = out.drift.max((total / before - 1.0).abs());
        out.states = [body_state(&mut system, y, 0), body_state(&mut system, y, 1)];
        let now = momenta(&out.states);
        out.momentum = out.momentum.max((now[0] - reference[0]).norm() / (MASS * SPEED));
        out.angular = out.angular.max((now[1] - reference[1]).norm() / (MASS * SPEED * RADIUS));
    }
    out
}

/// Balls about to touch, the upper one with velocity and spin against the lower, both turned and moved in space together.
fn meeting(velocity: Vector3<f64>, spin: [Vector3<f64>; 2], turn: Vector3<f64>) -> [BodyState; 2] {
    let mut states = [BodyState::at_rest(0), BodyState::at_rest(0)];
    states[0].position.z = 2.0 * RADIUS + 1e-9;
    states[0].velocity = 0.5 * velocity;
    states[1].velocity = -0.5 * velocity;
    let turn = UnitQuaternion::from_scaled_axis(turn);
    for (state, spin) in states.iter_mut().zip(spin) {
        state.position = turn * state.position;
        state.velocity = turn * state.velocity + Vector3::new(0.01, -0.02, 0.03);
        state.rotation = turn;
        state.angular_velocity_in_body = spin;
    }
    states
}

#[expect(clippy::print_stdout, reason = "figures of a test, shown on demand")]
fn print(name: &str, out: &Outcome) {
    println!(
        "{name}: {:.3e} s, lost {:.3e} J of {:.3e} J, dissipated {:.3e} J, drift {:.1e}, fall {:.1e}, momentum {:.1e}, angular {:.1e}",
        out.duration,
        out.before - out.after,
        out.before,
        out.dissipated,
        out.drift,
        out.fall,
        out.momentum,
        out.angular
    );
}

#[test]
fn gross_sliding_of_balls_exchanges_impulses_in_the_ratio_of_the_coefficient() {
    let mu = 0.1;
    let velocity = Vector3::new(0.06, 0.0, -SPEED);
    let out = run(mu, &meeting(velocity, [Vector3::zeros(); 2], Vector3::new(0.3, -0.2, 0.5)));
    print("gross sliding", &out);
    assert!(out.was_sliding && out.duration > 5e-5 && !out.is_rim_touched);
    let turn = out.states[0].rotation.inverse();
    let before = [0.5 * velocity.x, 0.5 * velocity.z];
    let common = Vector3::new(0.01, -0.02, 0.03);
    let v = UnitQuaternion::from_scaled_axis(Vector3::new(0.3, -0.2, 0.5)).inverse()
        * (out.states[0].velocity - common);
    let (normal, tangential) = (v.z - before[1], v.x - before[0]);
    // The normal turns by the slide of 0.06 m/s · 0.1 ms over two radii, 3e-4; tangents differ from unit ones by less.
    assert!((tangential / normal + mu).abs() < 1e-3 * mu + 4e-4, "{tangential} {normal}");
    assert!((v.z / (0.5 * SPEED) - 1.0).abs() < 2e-3, "{v}");
    assert!(turn.angle() > 0.0);
    let lost = out.before - out.after;
    // Steps are a 65th of the impact: the trapezoidal rule of half a sine would miss (π/65)²/12 = 2e-4 of its integral, between their stages it misses
    // a seventh of that; points enter and leave with a share of 1/20 of the force.
    assert!((out.dissipated / lost - 1.0).abs() < 1e-4, "{} {lost}", out.dissipated);
    assert!(out.drift < 1e-5 && out.fall < 1e-9, "{:e} {:e}", out.drift, out.fall);
    // Sums of some hundred steps of round-off.
    assert!(out.momentum < 1e-12 && out.angular < 1e-10, "{:e} {:e}", out.momentum, out.angular);
}

#[test]
fn friction_takes_energy_whatever_the_motion_of_the_balls() {
    let mut random = Random::new(4);
    let (mut n_stuck, mut n_sliding) = (0, 0);
    for case in 0..4 {
        let mut vector = |size: f64| size * Vector3::new(random.next(), random.next(), random.next());
        let slow = if case % 2 == 0 { 1.0 } else { 0.2 };
        let aside = vector(0.1 * slow).component_mul(&Vector3::new(1.0, 1.0, 0.0));
        let spin = [vector(5.0 * slow), vector(5.0 * slow)];
        let start = meeting(aside - SPEED * Vector3::z(), spin, vector(2.0));
        let out = run(0.3, &start);
        print(&format!("case {case}"), &out);
        assert!(out.duration > 5e-5 && !out.is_rim_touched, "{case}: {}", out.duration);
        (n_stuck, n_sliding) = (n_stuck + u32::from(out.was_stuck), n_sliding + u32::from(out.was_sliding));
        assert!(out.after <= out.before * (1.0 + 1e-9), "{case}");
        // Of second order in a step of a 65th: half of that of the work, for some 30 points a share of 1/30 each.
        assert!(out.drift < 1e-4, "{case}: {:e}", out.drift);
        // As for discs on a plane: a point that turns back within a step gives back what it lost since the step began.
        assert!(out.fall < 1e-6, "{case}: {:e}", out.fall);
        assert!(out.momentum < 1e-12 && out.angular < 1e-10, "{case}: {:e} {:e}", out.momentum, out.angular);
    }
    assert!(n_stuck > 2 && n_sliding > 2, "{n_stuck} {n_sliding}");
}
