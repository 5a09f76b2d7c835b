//! Free vibrations in the explicit method: closed forms at any step, order, damping's work, what the error control sees.

use crate::dynamics_support::{Random, block};
use crate::free_motion::{free_system, state_vector};
use crate::small_equations::{Given, distance, slope};
use ffr_dynamics::body::{ModalDamping, RigidMotion};
use ffr_dynamics::force::BodyState;
use ffr_dynamics::integration::{DenseOutput, Integrator, OdeSystem, Oscillator, StepSettings};
use ffr_dynamics::kinematics::Marker;
use ffr_dynamics::system::{Attachment, BodySpec, GROUND, JointKind, JointSpec, Multibody, SystemSpec};
use nalgebra::{UnitQuaternion, Vector3};

const GRAVITY: Vector3<f64> = Vector3::new(0.0, 0.0, -9.81);

/// Steps that take vibrations from their closed form.
fn exact(settings: StepSettings) -> StepSettings {
    StepSettings { is_vibration_exact: true, ..settings }
}

/// Components `x_i` at `2 i`, `dx_i/dt` at `2 i + 1`.
fn oscillators(data: &[(f64, f64)]) -> Vec<Oscillator> {
    let of = |(i, &(omega, damping)): (usize, &(f64, f64))| Oscillator {
        position: 2 * i,
        velocity: 2 * i + 1,
        squared_frequency: omega * omega,
        damping,
    };
    data.iter().enumerate().map(of).collect()
}

/// Oscillators under `force`, which gets time, number of the oscillator, and the state; the work of the damping is summed up last.
fn forced(
    data: &[(f64, f64)],
    tolerance: f64,
    force: impl Fn(f64, usize, &[f64]) -> f64,
) -> Given<impl FnMut(f64, &[f64], &mut [f64])> {
    let list = oscillators(data);
    let n = 2 * list.len();
    let known = list.clone();
    let mut system = Given::new(n + 1, tolerance, move |t, y: &[f64], dydt: &mut [f64]| {
        dydt[n] = 0.0;
        for (i, o) in list.iter().enumerate() {
            let [x, v] = [y[o.position], y[o.velocity]];
            dydt[o.position] = v;
            dydt[o.velocity] = force(t, i, y) - o.squared_frequency * x - o.damping * v;
            dydt[n] += o.damping * v * v;
        }
    });
    (system.oscillators, system.dissipated) = (known, Some(n));
    system
}

/// Position and velocity at `t` of an oscillator that starts at `start` under the constant force `force`.
fn closed_form((omega, damping): (f64, f64), start: [f64; 2], force: f64, t: f64) -> [f64; 2] {
    let (rest, decay) = (force / (omega * omega), 0.5 * damping);
    let damped = (omega * omega - decay * decay).sqrt();
    let (a, b) = (start[0] - rest, (start[1] + decay * (start[0] - rest)) / damped);
    let (s, c) = (damped * t).sin_cos();
    let e = (-decay * t).exp();
    [rest + e * (a * c + b * s), e * ((b * damped - decay * a) * c - (a * damped + decay * b) * s)]
}

#[test]
fn free_vibration_under_a_constant_force_is_exact_at_any_step() {
    let data = [(1.0, 0.0), (50.0, 0.3), (1e3, 2.0), (1e6, 0.0)];
    let starts = [[0.3, -0.2], [1.0, 4.0], [1e-3, 2.0], [1e-7, 0.1]];
    let force = |i: usize| [0.7, -30.0, 10.0, 1e4][i];
    let mut y0: Vec<f64> = starts.iter().flatten().copied().collect();
    y0.push(0.0);
    let mut system = forced(&data, 1.0, |_, i, _| force(i));
    let mut integrator = Integrator::explicit(exact(StepSettings::fixed(0.37)), 0.0, &y0).unwrap();
    let mut y = y0.clone();
    let start: f64 = energy(&data, &y0, force);
    for _ in 0..10 {
        integrator.step(&mut system, 100.0).unwrap();
        let (begin, end) = integrator.interval();
        for share in [0.0, 0.21, 0.5, 0.98, 1.0] {
            let t = begin + share * (end - begin);
            integrator.interpolate(t, &mut y);
            for (i, &oscillator) in data.iter().enumerate() {
                let [x, v] = closed_form(oscillator, starts[i], force(i), t);
                let amplitude = starts[i][0].abs()
                    + starts[i][1].abs() / oscillator.0
                    + force(i).abs() / oscillator.0.powi(2);
                // Round-off of the angle, with a digit for the sum over ten steps.
                let limit = 10.0 * f64::EPSILON * (1.0 + oscillator.0 * t) * amplitude;
                assert!((y[2 * i] - x).abs() < limit, "{i} at {t}: {} {x}", y[2 * i]);
                assert!((y[2 * i + 1] - v).abs() < limit * oscillator.0, "{i} at {t}: {} {v}", y[2 * i + 1]);
            }
            // What the damping has taken is what is missing.
            let missing = start - energy(&data, &y, force);
            assert!((y[8] - missing).abs() < 1e-12 * start, "{t}: {} {missing}", y[8]);
        }
    }
}

/// Frequencies of oscillators at rest that forces set in motion.
const PUSHED: [f64; 3] = [1.0, 60.0, 1e4];

/// A force that lasts, on each of them.
fn lasting(_t: f64, i: usize) -> f64 {
    [0.7, -30.0, 1e4][i]
}

/// A force that changes evenly.
fn rising(t: f64, i: usize) -> f64 {
    lasting(t, i) * (1.0 - 0.8 * t)
}

/// Work of the force `f + r t` on an undamped oscillator at rest, from zero to `t`:
/// `(f + r t) x(t) - r ∫ x`.
fn work_of(omega: f64, [f, r]: [f64; 2], t: f64) -> f64 {
    let (rest, drift, a) = (f / (omega * omega), r / (omega * omega), omega * t);
    // x = rest + drift t - rest cos(ωt) - drift/ω sin(ωt).
    let x = rest + drift * t - rest * a.cos() - drift / omega * a.sin();
    let integral =
        rest * t + 0.5 * drift * t * t - rest / omega * a.sin() - drift / (omega * omega) * (1.0 - a.cos());
    (f + r * t) * x - r * integral
}

#[test]
fn given_forces_supply_the_work_that_vibrations_take_at_any_step() {
    let end = 1.0;
    for (name, force, settings, limit) in [
        // Round-off of the fastest angle, 1e4, over the steps.
        ("lasting", lasting as fn(f64, usize) -> f64, StepSettings::fixed(0.37), 1e-10),
        // The motion itself is held to a tolerance of 1e-9.
        ("rising", rising, StepSettings::default(), 1e-7),
    ] {
        let data = PUSHED.map(|omega| (omega, 0.0));
        let list = oscillators(&data);
        let n = 2 * list.len();
        let known = list.clone();
        let mut system = Given::new(n + 1, 1e-9, move |t, y: &[f64], dydt: &mut [f64]| {
            dydt[n] = 0.0;
            for (i, o) in list.iter().enumerate() {
                dydt[o.position] = y[o.velocity];
                dydt[o.velocity] = force(t, i) - o.squared_frequency * y[o.position];
                dydt[n] += force(t, i) * y[o.velocity];
            }
        });
        (system.oscillators, system.supply) = (known, Some((n, force)));
        let mut integrator = Integrator::explicit(exact(settings), 0.0, &vec![0.0; n + 1]).unwrap();
        let mut y = vec![0.0; n + 1];
        let scale: f64 = PUSHED.iter().enumerate().map(|(i, w)| (lasting(0.0, i) / w).powi(2)).sum();
        while integrator.time() < end {
            integrator.step(&mut system, end).unwrap();
            let (begin, now) = integrator.interval();
            for share in [0.3, 0.8, 1.0] {
                let t = begin + share * (now - begin);
                integrator.interpolate(t, &mut y);
                let rate = |i: usize| force(1.0, i) - force(0.0, i);
                let work = |(i, &omega): (usize, &f64)| work_of(omega, [force(0.0, i), rate(i)], t);
                let expected: f64 = PUSHED.iter().enumerate().map(work).sum();
                assert!((y[n] - expected).abs() < limit * scale, "{name}, {t}: {} {expected}", y[n]);
            }
        }
    }
}

/// Energy, with that of constant forces.
fn energy(data: &[(f64, f64)], y: &[f64], force: impl Fn(usize) -> f64) -> f64 {
    let one = |(i, (omega, _)): (usize, &(f64, f64))| {
        let [x, v] = [y[2 * i], y[2 * i + 1]];
        0.5 * (v * v + omega * omega * x * x) - force(i) * x
    };
    data.iter().enumerate().map(one).sum()
}

/// Nonlinear springs between two damped oscillators, and a force over time.
fn coupled(t: f64, i: usize, y: &[f64]) -> f64 {
    let stretch = y[2] - y[0];
    let push = 0.8 * stretch.powi(3) + 0.4 * stretch;
    if i == 0 { push + (2.0 * t).cos() } else { -push }
}

const PAIR: [(f64, f64); 2] = [(3.0, 0.1), (5.0, 0.4)];
const PAIR_START: [f64; 5] = [0.5, 0.0, -0.3, 1.0, 0.0];

fn pair_run(n: u32, is_exact: bool) -> Integrator {
    let mut system = forced(&PAIR, 1.0, coupled);
    let settings = StepSettings { is_vibration_exact: is_exact, ..StepSettings::fixed(1.0 / f64::from(n)) };
    let mut integrator = Integrator::explicit(settings, 0.0, &PAIR_START).unwrap();
    integrator.run(&mut system, 1.0, |_, _| true).unwrap();
    integrator
}

#[test]
fn forces_beside_the_vibration_are_integrated_with_order_five_and_dense_output_with_order_four() {
    // The method that knows no oscillators, in steps that are 8 and more times shorter: its error is 1e-4 of theirs.
    let reference = pair_run(512, false);
    let errors: Vec<_> = [16, 32, 64]
        .map(|n| (1.0 / f64::from(n), distance(pair_run(n, true).state(), reference.state())))
        .to_vec();
    let measured = slope(&errors);
    assert!((measured - 5.0).abs() < 0.3, "order {measured}, errors {errors:?}");

    let mut dense = Vec::new();
    for n in [16, 32, 64] {
        let h = 1.0 / f64::from(n);
        let mut system = forced(&PAIR, 1.0, coupled);
        let mut one = Integrator::explicit(exact(StepSettings::fixed(h)), 0.0, &PAIR_START).unwrap();
        one.step(&mut system, 1.0).unwrap();
        let (mut worst, mut y) = (0.0_f64, [0.0; 5]);
        for i in 1..8 {
            let t = h * f64::from(i) / 8.0;
            let mut plain = forced(&PAIR, 1.0, coupled);
            let mut fine = Integrator::explicit(StepSettings::fixed(t / 50.0), 0.0, &PAIR_START).unwrap();
            fine.run(&mut plain, t, |_, _| true).unwrap();
            one.interpolate(t, &mut y);
            worst = worst.max(distance(&y, fine.state()));
        }
        dense.push((h, worst));
    }
    // An interpolant of order four has a local error of order five.
    let measured = slope(&dense);
    assert!((measured - 5.0).abs() < 0.3, "order {measured}, errors {dense:?}");
}

#[test]
fn what_the_stages_do_not_see_is_counted_as_error() {
    // Two fast vibrations that a slow turn couples: the coupling vibrates as fast as they do. Few steps, far above its period: in many
    // of them errors of either sign would hide each other.
    let (fast, end) = ([(4.0e5, 0.0), (4.3e5, 0.0)], 5e-4);
    let run = |turn: f64, tolerance: f64| {
        let rate = move |_: f64, i: usize, y: &[f64]| {
            if i == 0 { 2.0 * turn * y[3] } else { -2.0 * turn * y[1] }
        };
        let mut system = forced(&fast, tolerance, rate);
        let y0 = [0.0, 1.0, 1.0 / fast[1].0, 0.0, 0.0];
        let settings = exact(StepSettings::with_max_step(1e-4));
        let mut integrator = Integrator::explicit(settings, 0.0, &y0).unwrap();
        integrator.run(&mut system, end, |_, _| true).unwrap();
        (integrator.statistics().steps as f64, integrator.state().to_vec())
    };
    let mut n_steps = 0.0;
    for turn in [0.03, 0.05, 0.1, 0.2, 0.3, 0.5, 1.0] {
        let (_, reference) = run(turn, 1e-11);
        for tolerance in [1e-4, 3e-5, 1e-5, 3e-6, 1e-6] {
            let (steps, state) = run(turn, tolerance);
            let error = (state[1] - reference[1]).hypot(state[3] - reference[3]);
            // The control allows so much in each step; the sum of them all is the worst case.
            assert!(error < tolerance * steps, "{turn}, {tolerance}: {error} after {steps} steps");
            n_steps += steps;
        }
    }
    // Far fewer than the periods of the faster one.
    assert!(n_steps < 35.0 * end * fast[1].0 / std::f64::consts::TAU, "{n_steps}");
}

#[test]
fn free_ringing_body_keeps_energy_and_momenta_in_steps_above_its_periods() {
    let sample = block(RigidMotion::Spatial, 8);
    let mut system: Multibody = free_system(vec![("block", sample.data)], GRAVITY, Vec::new());
    let stiffness = system.model().bodies[0].data.modal_stiffness.clone();
    let highest = stiffness.iter().fold(0.0_f64, |a, k| a.max(k.sqrt()));
    let mut random = Random(7);
    let ringing = BodyState {
        velocity: Vector3::new(1.0, -0.5, 0.2),
        elastic: stiffness.iter().map(|k| 1e-2 * random.next() / k.sqrt()).collect(),
        elastic_rates: stiffness.iter().map(|_| 1e-2 * random.next()).collect(),
        ..BodyState::at_rest(8)
    };
    let turning = BodyState { angular_velocity_in_body: Vector3::new(0.3, 2.0, -0.4), ..ringing.clone() };
    let (end, max_step) = (0.5, 1e-2);
    // The method without closed forms is stable up to a step of 1/ω.
    let resolved = highest * end;
    for (state, most) in [
        // Nothing but free fall, vibration, and what is quadratic in it.
        (ringing, 0.1 * resolved),
        // Coriolis forces of the vibration are not part of the closed form and have to be followed.
        (turning, 0.5 * resolved),
    ] {
        let y = state_vector(&system, &[state]);
        let before = system.invariants(0.0, &y);
        let mut integrator =
            Integrator::explicit(exact(StepSettings::with_max_step(max_step)), 0.0, &y).unwrap();
        integrator.run(&mut system, end, |_, _| true).unwrap();
        let steps = integrator.statistics().steps as f64;
        assert!(steps <= most, "{steps} steps, {most}");
        let after = system.invariants(end, integrator.state());
        // Each step may be off by the tolerance of 1e-8 of the velocity, 2e-8 of the energy.
        let limit = 2e-8 * steps;
        let change = after.energy() - before.energy();
        assert!(change.abs() < limit * before.kinetic, "{before:?} {after:?}");
        let expected = before.linear_momentum + GRAVITY * (end * system.model().bodies[0].data.mass);
        assert!((after.linear_momentum - expected).norm() < limit * expected.norm(), "{after:?}");
    }
}

#[test]
fn only_modes_that_nothing_else_moves_are_oscillators() {
    let sample = block(RigidMotion::Spatial, 6);
    let count = |at: Marker, damping: ModalDamping, in_tangent: bool| {
        let mut data = sample.data.clone();
        data.modal_damping = damping;
        if in_tangent {
            data = data.in_tangent_frame(&at.tangent_frame(RigidMotion::Spatial)).unwrap();
        }
        let bodies = vec![BodySpec { name: "block".into(), data, markers: vec![at] }];
        let ground = vec![Marker::rigid("pivot", Vector3::zeros(), UnitQuaternion::identity())];
        let ends = [Attachment::new(GROUND, "pivot"), Attachment::new("block", "at")];
        let [parent, child] = ends;
        let joints = vec![JointSpec::new("hinge", JointKind::Revolute, parent, child)];
        let system: Multibody =
            Multibody::new(SystemSpec { bodies, ground, joints, ..SystemSpec::default() }, Vec::new())
                .unwrap();
        system.oscillators().list.len()
    };
    let still = || Marker::rigid("at", Vector3::new(0.1, 0.0, 0.0), UnitQuaternion::identity());
    let moved = || sample.marker("at", 0, UnitQuaternion::identity(), |j| sample.nodal_rotation(0, j));
    assert_eq!(count(still(), ModalDamping::None, false), 6);
    assert_eq!(count(moved(), ModalDamping::None, false), 0);
    assert_eq!(count(moved(), ModalDamping::None, true), 0);
    // Critical damping and more has no vibration.
    let stiffness = &sample.data.modal_stiffness;
    let ratios: Vec<f64> = (0..6).map(|j| if j == 2 { 1.0 } else { 0.01 }).collect();
    let damping = ModalDamping::from_ratios(&ratios, stiffness).unwrap();
    assert_eq!(count(still(), damping, false), 5);
}
