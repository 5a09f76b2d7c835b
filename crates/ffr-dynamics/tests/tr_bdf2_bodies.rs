//! TR-BDF2 on flexible bodies: agreement with the explicit method, energy, unresolved modes, cost.

use crate::dynamics_support::{Random, block};
use crate::free_motion::{body_state, free_system, state_vector};
use ffr_dynamics::body::{ModalDamping, RigidMotion, StandardInputData};
use ffr_dynamics::force::BodyState;
use ffr_dynamics::integration::{Integrator, Linearisation, Method, OdeSystem, Statistics, StepSettings};
use ffr_dynamics::system::{ErrorScale, Multibody};
use nalgebra::Vector3;

fn system(data: StandardInputData, gravity: Vector3<f64>, relative: f64) -> Multibody {
    let mut system: Multibody = free_system(vec![("body", data)], gravity, Vec::new());
    system.set_error_scale(ErrorScale { relative, ..ErrorScale::default() }).unwrap();
    system
}

fn implicit(system: &mut Multibody, start: &BodyState, t_end: f64) -> (Vec<f64>, Statistics) {
    let y = state_vector(system, std::slice::from_ref(start));
    let mut integrator = Integrator::new(Method::TrBdf2, StepSettings::default(), 0.0, &y, system).unwrap();
    integrator.run(system, t_end, |_, _| true).unwrap();
    (integrator.state().to_vec(), integrator.statistics())
}

fn explicit(system: &mut Multibody, start: &BodyState, t_end: f64) -> (Vec<f64>, Statistics) {
    let y = state_vector(system, std::slice::from_ref(start));
    let mut integrator = Integrator::explicit(StepSettings::default(), 0.0, &y).unwrap();
    integrator.run(system, t_end, |_, _| true).unwrap();
    (integrator.state().to_vec(), integrator.statistics())
}

#[test]
fn derivatives_of_a_body_agree_with_differences() {
    for motion in [RigidMotion::Axial, RigidMotion::Planar, RigidMotion::Spatial] {
        let mut data = block(motion, 6).data;
        data.modal_damping =
            ModalDamping::PerMode(data.modal_stiffness.iter().map(|k| 0.02 * k.sqrt()).collect());
        // Undeformed, so that the inertia's dependence on the elastic coordinates, left out by intent, has little to act on:
        // what remains is quadratic in the angular velocity, against stiffness terms of 1e7 1/s².
        let mut start = Random(7).state(&data);
        start.elastic.fill(0.0);
        start.elastic_rates.fill(0.0);
        let mut system = system(data, Vector3::zeros(), 1e-6);
        let y = state_vector(&system, std::slice::from_ref(&start));
        let layout = system.model().bodies[0].layout;
        let rows: Vec<usize> = layout.elastic_rates().chain(layout.velocities()).collect();
        let mut derivative = Linearisation::new(rows.len());
        system.linearise(0.0, &y, &mut derivative).unwrap();
        let rates = |system: &mut Multibody, i: usize, step: f64| {
            let (mut moved, mut rates) = (y.clone(), vec![0.0; y.len()]);
            moved[i] += step;
            system.rhs(0.0, &moved, &mut rates).unwrap();
            rates
        };
        for j in 0..6 {
            // Central differences of quadratic functions: exact but for round-off, 1e-16 / 1e-6 of terms of 1e4.
            let components = [(layout.elastic().start + j, false), (layout.elastic_rates().start + j, true)];
            for (i, by_rate) in components {
                let (forth, back) = (rates(&mut system, i, 1e-6), rates(&mut system, i, -1e-6));
                let column =
                    if by_rate { derivative.velocity_column(j) } else { derivative.position_column(j) };
                let scale = column.iter().map(|c| c.abs()).fold(0.0, f64::max);
                for (c, &row) in column.iter().zip(&rows) {
                    let difference = (forth[row] - back[row]) / 2e-6;
                    let tolerance = if by_rate { 1e-6 } else { 1e-3 };
                    assert!((c - difference).abs() < tolerance * scale, "{motion:?} {j}: {c} {difference}");
                }
            }
        }
    }
}

/// A block whose modes have eigenfrequencies from 1e2 to 1e6 rad/s in equal ratios, each damped by 1 %.
fn wide_spectrum() -> StandardInputData {
    let mut data = block(RigidMotion::Spatial, 20).data;
    let omega: Vec<f64> = (0..20).map(|j| 1e2 * 1e4_f64.powf(f64::from(j) / 19.0)).collect();
    data.modal_stiffness = omega.iter().map(|w| w * w).collect();
    data.modal_damping = ModalDamping::PerMode(omega.iter().map(|w| 2.0 * 0.01 * w).collect());
    data
}

#[test]
fn ringing_of_high_modes_is_not_resolved() {
    let mut steps = Vec::new();
    for (relative, high) in [(1e-4, 0.0), (1e-4, 1e-5), (1e-5, 0.0), (1e-5, 1e-5)] {
        let mut system = system(wide_spectrum(), Vector3::zeros(), relative);
        let mut start = BodyState::at_rest(20);
        start.elastic = vec![high * 1e-4; 20];
        start.elastic[0] = 1e-4;
        let (y, statistics) = implicit(&mut system, &start, 0.1);
        let end = body_state(&mut system, &y, 0);
        let (omega, zeta, t) = (1e2_f64, 0.01_f64, 0.1);
        let damped = omega * (1.0 - zeta * zeta).sqrt();
        let phase = damped * t;
        let expected = (-zeta * omega * t).exp() * (phase.cos() + zeta * omega / damped * phase.sin());
        // The permitted error of each step, all of one sign: in a free oscillation both the phase and the energy drift.
        let bound = relative * statistics.steps as f64;
        assert!((end.elastic[0] / 1e-4 - expected).abs() < bound, "{relative} {high}: {}", end.elastic[0]);
        // Modes above 1e4 rad/s, 0.1 of the resolved steps at most, have lost all but a trace of what they had.
        assert!(end.elastic[10..].iter().all(|q| q.abs() < 1e-3 * 1e-5 * 1e-4), "{:?}", end.elastic);
        assert_eq!(statistics.jacobians, 1, "a nearly linear motion needs one derivative");
        steps.push(statistics.steps);
    }
    assert_eq!(steps, RINGING_STEPS);
}

/// Steps with high modes at rest and at 1e-5 of the slow one, at the tolerances 1e-4 and 1e-5. In a norm of plain components
/// a method of this kind needs 34 909. In one that knows the modes and only cuts the energy of each (Eq. T.24) it needs 99, 112,
/// 212, 332: the filter of a system (Eq. M.49) drops elastic energy altogether.
const RINGING_STEPS: [u64; 4] = [92, 91, 187, 222];

#[test]
fn tumbling_flexible_body_agrees_with_the_explicit_method() {
    for motion in [RigidMotion::Axial, RigidMotion::Planar, RigidMotion::Spatial] {
        let sample = block(motion, 8);
        let mut start = Random(3).state(&sample.data);
        start.angular_velocity_in_body *= 20.0;
        let gravity = Vector3::new(0.0, 0.0, if motion == RigidMotion::Planar { 0.0 } else { -9.81 });
        let mut system = system(sample.data, gravity, 1e-10);
        let t_end = 1e-2;
        let (reference, _) = explicit(&mut system, &start, t_end);
        let reference = body_state(&mut system, &reference, 0);
        if motion == RigidMotion::Spatial {
            assert!(
                reference.rotation.angle_to(&start.rotation) > 1.0,
                "a large rotation: {:?}",
                reference.rotation.angle_to(&start.rotation)
            );
        }
        let before = state_vector(&system, std::slice::from_ref(&start));
        let before = system.invariants(0.0, &before);
        let mut errors = Vec::new();
        for relative in [1e-5, 1e-6, 1e-7] {
            system.set_error_scale(ErrorScale { relative, ..ErrorScale::default() }).unwrap();
            let (y, s) = implicit(&mut system, &start, t_end);
            let (end, after) = (body_state(&mut system, &y, 0), system.invariants(0.0, &y));
            let turned = end.rotation.angle_to(&reference.rotation);
            let bent: f64 = end.elastic.iter().zip(&reference.elastic).map(|(a, b)| (a - b).powi(2)).sum();
            errors.push((s.steps as f64, (end.position - reference.position).norm() + turned, bent.sqrt()));
            let loss = (before.energy() - after.energy()) / before.energy();
            assert!(loss > 0.0 && loss < relative * s.steps as f64, "{motion:?} {relative}: loss {loss}");
            // Two stages with at most two iterations; a derivative costs two evaluations for each velocity.
            assert!(s.iterations <= 4 * (s.steps + s.rejected), "{motion:?} {relative}: {s:?}");
            // Steps follow the vibration up and down; still most of them keep their size and their factors.
            assert!(s.jacobians <= 3 && s.factorisations < s.steps / 2, "{motion:?} {relative}: {s:?}");
        }
        let (first, last) = (errors[0], errors[2]);
        // Order two: the square of the number of steps, within a third for the changing steps.
        let gain = (last.0 / first.0).powi(2);
        assert!(first.2 / last.2 > 0.67 * gain, "{motion:?}: elastic errors {errors:?}");
        if motion == RigidMotion::Spatial {
            assert!(first.1 / last.1 > 0.67 * gain && last.1 < 1e-6, "{motion:?}: rigid errors {errors:?}");
        }
    }
}

#[test]
fn damped_work_and_numerical_loss_share_the_energy() {
    // Physical damping is booked as dissipated work; what is missing beyond is the method's, and not negative.
    let mut data = block(RigidMotion::Spatial, 8).data;
    let damping = data.modal_stiffness.iter().map(|k| 2.0 * 0.01 * k.sqrt()).collect();
    data.modal_damping = ModalDamping::PerMode(damping);
    let start = Random(5).state(&data);
    let mut system = system(data, Vector3::zeros(), 1e-6);
    let y = state_vector(&system, std::slice::from_ref(&start));
    let before = system.invariants(0.0, &y).energy();
    let mut integrator = Integrator::new(Method::TrBdf2, StepSettings::default(), 0.0, &y, &system).unwrap();
    let mut last = 0.0;
    integrator
        .run(&mut system, 5e-3, |system, i| {
            let lost = before - system.invariants(0.0, i.state()).energy();
            let numerical = lost - system.dissipated_work(i.state());
            // The work's quadrature has an error of order two of its own, 1e-6 per step at most, of either sign.
            assert!(numerical > last - 1e-6 * before, "the method adds no energy: {numerical} after {last}");
            last = numerical;
            true
        })
        .unwrap();
    let dissipated = system.dissipated_work(integrator.state());
    assert!(dissipated > 1e-3 * before && last.abs() < 1e-2 * dissipated);
}
