//! Free bodies in motion: conservation, closed forms, impulses, errors.

use std::ops::DerefMut;

use crate::dynamics_support::{Push, Random, block, rigid_rotor};
use crate::free_motion::{body_state, free_system, state_vector};
use ffr_dynamics::body::{ModalDamping, RigidMotion, StandardInputData};
use ffr_dynamics::error::EvaluationFailure;
use ffr_dynamics::force::active::{Active, ActiveForce};
use ffr_dynamics::force::{BodyState, ForceElement, GeneralisedForce, Motion};
use ffr_dynamics::integration::{Integrator, OdeSystem, StepSettings};
use ffr_dynamics::kinematics::FlexiblePoint;
use ffr_dynamics::system::free_body::invariants::Invariants;
use ffr_dynamics::system::{BodySpec, ErrorScale, Multibody, SystemSpec};
use nalgebra::{Matrix3, UnitQuaternion, Vector3};

/// A one-sided spring between a point of body 0 and the plane z = 0.
struct Floor {
    point: FlexiblePoint,
    stiffness: f64,
}

impl ForceElement for Floor {
    type State = ();
    type Workspace = ();
    type Found = Push;

    fn start(&self) -> ((), (), Push) {
        Default::default()
    }

    fn evaluate(
        &self,
        Motion { bodies, .. }: Motion<'_>,
        (): &mut (),
        (): &mut (),
        found: &mut Push,
        forces: &mut [GeneralisedForce],
    ) -> Result<(), EvaluationFailure> {
        let depth = (-self.point.position(&bodies[0]).z).max(0.0);
        found.resultant = Vector3::z() * (self.stiffness * depth);
        found.energy = 0.5 * self.stiffness * depth * depth;
        self.point.add_force(&bodies[0], &found.resultant, &mut forces[0]);
        Ok(())
    }
}

fn system(data: StandardInputData, gravity: Vector3<f64>, relative: f64) -> Multibody {
    let mut system: Multibody = free_system(vec![("body", data)], gravity, Vec::new());
    system.set_error_scale(ErrorScale { relative, ..ErrorScale::default() }).unwrap();
    system
}

/// Integrates and returns the final state vector.
fn integrate<F: DerefMut<Target: ActiveForce>>(
    system: &mut Multibody<F>,
    start: &BodyState,
    t_end: f64,
) -> Vec<f64> {
    let y = state_vector(system, std::slice::from_ref(start));
    let mut integrator = Integrator::explicit(StepSettings::default(), 0.0, &y).unwrap();
    integrator.run(system, t_end, |_, _| true).unwrap();
    integrator.state().to_vec()
}

fn relative_change(before: &Invariants, after: &Invariants) -> [f64; 3] {
    [
        (after.energy() - before.energy()).abs() / before.energy().abs(),
        (after.linear_momentum - before.linear_momentum).norm() / before.linear_momentum.norm(),
        (after.angular_momentum - before.angular_momentum).norm() / before.angular_momentum.norm(),
    ]
}

#[test]
fn free_rotor_keeps_energy_and_angular_momentum_over_100_revolutions() {
    // About the middle axis, unstable: it tumbles.
    let mut start = BodyState::at_rest(0);
    start.angular_velocity_in_body = Vector3::new(0.02, 1.0, 0.01);
    let mut system = system(rigid_rotor(), Vector3::zeros(), 1e-12);
    let before = state_vector(&system, std::slice::from_ref(&start));
    let before = system.invariants(0.0, &before);
    let y = integrate(&mut system, &start, 100.0 * std::f64::consts::TAU);
    let after = system.invariants(0.0, &y);
    assert!((after.energy() - before.energy()).abs() < 1e-9 * before.energy());
    assert!(
        (after.angular_momentum - before.angular_momentum).norm() < 1e-9 * before.angular_momentum.norm()
    );
    assert!(body_state(&mut system, &y, 0).rotation.angle_to(&start.rotation) > 0.1, "it has turned");
}

#[test]
fn symmetric_top_follows_the_closed_form() {
    // Torque-free, I = (a, a, c): in the body's frame ω precesses about z at λ = (c - a) / a ω_z; in space the body turns
    // by L / a about L, and back by λ about its own axis (Goldstein, 5.6).
    let (a, c) = (1.0, 1.6);
    let inertia = Matrix3::from_diagonal(&Vector3::new(a, a, c));
    let data = StandardInputData::rigid(RigidMotion::Spatial, 2.0, Vector3::zeros(), inertia).unwrap();
    let mut start = BodyState::at_rest(0);
    start.rotation = UnitQuaternion::from_scaled_axis(Vector3::new(0.4, 0.2, -0.7));
    start.angular_velocity_in_body = Vector3::new(0.5, 0.0, 2.0);
    let mut system = system(data, Vector3::zeros(), 1e-12);
    let t = 10.0;
    let y = integrate(&mut system, &start, t);
    let end = body_state(&mut system, &y, 0);
    let rate = (c - a) / a * 2.0;
    let expected = Vector3::new(0.5 * (rate * t).cos(), 0.5 * (rate * t).sin(), 2.0);
    // Tolerance 1e-12 per step, about 1e4 steps.
    assert!((end.angular_velocity_in_body - expected).norm() < 1e-8);
    let momentum = start.rotation * (inertia * start.angular_velocity_in_body);
    let expected = UnitQuaternion::from_scaled_axis(momentum * (t / a))
        * start.rotation
        * UnitQuaternion::from_scaled_axis(Vector3::z() * (-rate * t));
    assert!((end.rotation.inverse() * expected).scaled_axis().norm() < 1e-8);
}

#[test]
fn flying_flexible_body_keeps_energy_and_momenta() {
    for motion in [RigidMotion::Planar, RigidMotion::Spatial] {
        let sample = block(motion, 8);
        let start = Random(3).state(&sample.data);
        let mut system = system(sample.data, Vector3::zeros(), 1e-11);
        let y = state_vector(&system, std::slice::from_ref(&start));
        let before = system.invariants(0.0, &y);
        let y = integrate(&mut system, &start, 0.02);
        let [energy, linear, angular] = relative_change(&before, &system.invariants(0.0, &y));
        // Tolerance 1e-11 per step, some hundred steps; the errors of a stretched mode all have the same sign.
        assert!(energy < 1e-8 && linear < 1e-9 && angular < 1e-9, "{motion:?}: {energy} {linear} {angular}");
        let moved = body_state(&mut system, &y, 0);
        let exchanged: f64 = moved.elastic.iter().zip(&start.elastic).map(|(a, b)| (a - b).abs()).sum();
        assert!(exchanged > 1e-3, "the modes have moved");
    }
}

#[test]
fn undeformed_body_falls_along_a_parabola_without_ringing() {
    for motion in [RigidMotion::Axial, RigidMotion::Planar, RigidMotion::Spatial] {
        let sample = block(motion, 8);
        let mut start = BodyState::at_rest(8);
        let up = if motion == RigidMotion::Axial { Vector3::z() } else { Vector3::y() };
        start.velocity = up * 0.3;
        if motion == RigidMotion::Spatial {
            start.rotation = UnitQuaternion::from_scaled_axis(Vector3::new(0.4, 0.2, -0.7));
        }
        let gravity = up * -9.81;
        let mut system = system(sample.data, gravity, 1e-8);
        let t = 0.1;
        // Weight is an acceleration of the frame, so that modes feel the round-off of falling. Steps within the stability of the
        // highest mode, 3.3 / ω, leave it so; longer ones would raise it to the tolerance.
        let y = state_vector(&system, &[start]);
        let max_step = 0.3 / system.highest_frequency();
        let mut integrator = Integrator::explicit(StepSettings::with_max_step(max_step), 0.0, &y).unwrap();
        integrator.run(&mut system, t, |_, _| true).unwrap();
        let end = body_state(&mut system, integrator.state(), 0);
        let expected = up * (0.3 * t - 0.5 * 9.81 * t * t);
        assert!((end.position - expected).norm() < 1e-13, "{motion:?}");
        // C_t is zero to the orthogonality of the modes: nothing shakes them.
        assert!(end.elastic.iter().all(|q| q.abs() < 1e-13), "{motion:?}: {:?}", end.elastic);
    }
}

#[test]
fn single_mode_swings_like_an_oscillator() {
    let sample = block(RigidMotion::Spatial, 1);
    let omega = sample.data.modal_stiffness[0].sqrt();
    let mut data = sample.data;
    let damping = 0.02 * omega;
    data.modal_damping = ModalDamping::PerMode(vec![damping]);
    let mut start = BodyState::at_rest(1);
    start.elastic[0] = 1e-4;
    let mut system = system(data, Vector3::zeros(), 1e-11);
    let energy = 0.5 * omega * omega * 1e-8;
    let t = 5.3 * std::f64::consts::TAU / omega;
    let y = integrate(&mut system, &start, t);
    let end = body_state(&mut system, &y, 0);
    let damped = (omega * omega - 0.25 * damping * damping).sqrt();
    let decay = (-0.5 * damping * t).exp();
    let expected = 1e-4 * decay * ((damped * t).cos() + 0.5 * damping / damped * (damped * t).sin());
    // The frame turns with the mode only at second order in the amplitude: nothing here.
    assert!((end.elastic[0] - expected).abs() < 1e-8 * 1e-4, "{} {expected}", end.elastic[0]);
    let balance = system.invariants(0.0, &y).energy() + system.dissipated_work(&y) - energy;
    assert!(balance.abs() < 1e-8 * energy, "{balance}");
}

#[test]
fn elastic_answer_is_the_same_in_every_orientation() {
    let sample = block(RigidMotion::Spatial, 6);
    let start = Random(5).state(&sample.data);
    let mut reference: Option<BodyState> = None;
    for turn in [Vector3::zeros(), Vector3::new(1.0, -0.4, 2.0), Vector3::new(-2.5, 0.3, 0.1)] {
        let turn = UnitQuaternion::from_scaled_axis(turn);
        let shift = turn * Vector3::new(3.0, -1.0, 2.0) - Vector3::new(3.0, -1.0, 2.0);
        let mut turned = start.clone();
        turned.position = turn * start.position + shift;
        turned.rotation = turn * start.rotation;
        turned.velocity = turn * start.velocity;
        let mut system = system(sample.data.clone(), turn * Vector3::new(0.0, 0.0, -9.81), 1e-10);
        let y = integrate(&mut system, &turned, 0.01);
        let end = body_state(&mut system, &y, 0);
        let reference = reference.get_or_insert_with(|| end.clone());
        let scale = reference.elastic.iter().fold(0.0_f64, |s, q| s.max(q.abs()));
        for (a, b) in end.elastic.iter().zip(&reference.elastic) {
            assert!((a - b).abs() < 1e-10 * scale, "{a} {b}");
        }
        assert!((end.angular_velocity_in_body - reference.angular_velocity_in_body).norm() < 1e-10 * 20.0);
    }
}

fn axial_impact(relative: f64) -> (Multibody<Box<Active<Floor>>>, BodyState) {
    let sample = block(RigidMotion::Axial, 3);
    let lowest = (0..sample.body.nodes.len())
        .min_by(|a, b| sample.body.nodes[*a][1].total_cmp(&sample.body.nodes[*b][1]))
        .unwrap();
    let point =
        FlexiblePoint::from_rows(RigidMotion::Axial, sample.node(lowest), sample.shapes.as_ref(), 2 * lowest);
    let mut start = BodyState::at_rest(3);
    start.position.z = 1e-3 - point.position.z;
    start.velocity.z = -2.0;
    let floor = Floor { point, stiffness: 2e5 };
    let mut system =
        free_system(vec![("block", sample.data)], Vector3::zeros(), vec![Box::new(Active::new(floor))]);
    system.set_error_scale(ErrorScale { relative, ..ErrorScale::default() }).unwrap();
    (system, start)
}

#[test]
fn a_step_to_equilibrium_has_the_stiffness_of_force_elements() {
    // A block with modes above a spring that it presses, linear as long as it does: one step of Newton's ends in balance.
    let (mut system, mut start) = axial_impact(1e-9);
    (start.velocity.z, start.position.z) = (0.0, start.position.z - 2e-3);
    let y = state_vector(&system, std::slice::from_ref(&start));
    let held = vec![false; system.model().n_rates()];
    let before = system.balance(0.0, &y, &held).unwrap();
    let (change, is_short) = before.change(1.0);
    assert!(!is_short);
    // Half of the way: the spring still presses, so that what is left is half of it.
    let half: Vec<f64> = change.iter().map(|d| 0.5 * d).collect();
    let there = system.displaced(0.0, &y, &half);
    let mut after = system.balance(0.0, &there, &held).unwrap();
    after.remember(&before);
    // Differences of a linear force are right to the round-off of its values over a fiftieth of the travel.
    assert!(
        (after.residual() / before.residual() - 0.5).abs() < 1e-9,
        "{} {}",
        after.residual(),
        before.residual()
    );
}

#[test]
fn impulse_of_an_impact_equals_the_change_of_momentum_to_round_off() {
    let (mut system, start) = axial_impact(1e-9);
    let y = state_vector(&system, std::slice::from_ref(&start));
    let before = system.invariants(0.0, &y);
    let mut integrator = Integrator::explicit(StepSettings::default(), 0.0, &y).unwrap();
    let mut largest: f64 = 0.0;
    integrator
        .run(&mut system, 0.05, |s, _| {
            largest = largest.max(s.forces()[0].resultant().z);
            true
        })
        .unwrap();
    let y = integrator.state().to_vec();
    let after = system.invariants(0.0, &y);
    assert!(largest > 100.0 && body_state(&mut system, &y, 0).velocity.z > 0.5, "it has bounced");
    let change = after.linear_momentum - before.linear_momentum;
    let error = (system.impulse(&y, 0) - change).norm();
    assert!(error < 1e-13 * change.norm(), "{error} of {change}");
    // Tolerance 1e-9 per step, some hundred steps; the force has kinks where contact begins and ends.
    system.evaluate_forces(0.05, &y).unwrap();
    let energy = after.energy() + system.forces()[0].energies().penalty;
    assert!((energy - before.energy()).abs() < 1e-7 * before.energy(), "{energy} {}", before.energy());
}

#[test]
fn forces_of_the_accepted_state_need_no_new_evaluation() {
    let (mut system, start) = axial_impact(1e-6);
    let y = state_vector(&system, std::slice::from_ref(&start));
    let mut integrator = Integrator::explicit(StepSettings::default(), 0.0, &y).unwrap();
    let mut checked = 0;
    integrator
        .run(&mut system, 0.02, |s, i| {
            let last = s.forces()[0].resultant();
            s.evaluate_forces(i.time(), i.state()).unwrap();
            checked += u32::from(last.z > 0.0);
            (last - s.forces()[0].resultant()).norm() <= 1e-12 * last.norm()
        })
        .unwrap();
    assert!(checked > 0 && integrator.time() >= 0.02, "stopped at {}", integrator.time());
}

#[test]
fn energy_error_drops_with_the_tolerance() {
    let sample = block(RigidMotion::Spatial, 8);
    let start = Random(11).state(&sample.data);
    let drift = [1e-6, 1e-8, 1e-10].map(|relative| {
        let mut system = system(sample.data.clone(), Vector3::zeros(), relative);
        let y = state_vector(&system, std::slice::from_ref(&start));
        let before = system.invariants(0.0, &y).energy();
        let y = integrate(&mut system, &start, 0.01);
        (system.invariants(0.0, &y).energy() - before).abs() / before
    });
    // Proportional to the tolerance, up to the sixth root (error control per step).
    assert!(drift[1] < 0.1 * drift[0] && drift[2] < 0.1 * drift[1], "{drift:?}");
    assert!(drift[0] < 1e-3, "{drift:?}");
}

#[test]
fn tiny_ringing_of_a_high_mode_does_not_decide_the_step() {
    let sample = block(RigidMotion::Spatial, 20);
    let steps = [0.0, 1e-12].map(|amplitude| {
        let mut start = BodyState::at_rest(20);
        start.velocity = Vector3::x();
        start.elastic[0] = 1e-5;
        start.elastic[19] = amplitude;
        let mut system = system(sample.data.clone(), Vector3::zeros(), 1e-6);
        let y = state_vector(&system, &[start]);
        let mut integrator = Integrator::explicit(StepSettings::default(), 0.0, &y).unwrap();
        integrator.run(&mut system, 0.01, |_, _| true).unwrap();
        integrator.statistics().steps
    });
    assert!(steps[1] as f64 <= 1.1 * steps[0] as f64, "{steps:?}");
}

#[test]
fn motions_that_a_model_does_not_have_are_refused_by_name() {
    // A plane body has two displacements and an angle; the seven coordinates and six velocities of space are too many.
    let sample = block(RigidMotion::Planar, 2);
    let system = system(sample.data, Vector3::zeros(), 1e-8);
    let mut y = system.rest();
    let refused = system.set_joint(&mut y, 0, &[0.0; 7], &[0.0; 6]).unwrap_err().to_string();
    assert!(refused.contains("\"body\"") && refused.contains("planar joint has 3 and 3"), "{refused}");
    let refused = system.set_joint(&mut y, 0, &[0.0; 3], &[0.0, f64::NAN, 0.0]).unwrap_err().to_string();
    assert!(refused.contains("\"body\"") && refused.contains("not finite"), "{refused}");
    let refused = system.set_elastic(&mut y, 0, &[0.0; 3], &[0.0; 2]).unwrap_err().to_string();
    assert!(refused.contains("elastic coordinates or rates of body \"body\": 3, must be 2"), "{refused}");
    let refused = system.set_elastic(&mut y, 0, &[0.0; 2], &[f64::NAN, 0.0]).unwrap_err().to_string();
    assert!(refused.contains("body \"body\"") && refused.contains("not finite"), "{refused}");
}

#[test]
fn damping_and_tolerances_that_make_no_sense_are_refused() {
    let mut data = block(RigidMotion::Planar, 2).data;
    data.modal_damping = ModalDamping::PerMode(vec![1.0, -1.0]);
    let body = BodySpec { name: "block".to_string(), data, markers: Vec::new() };
    let spec = SystemSpec { bodies: vec![body], ..SystemSpec::default() };
    let result: Result<Multibody, _> = Multibody::new(spec, Vec::new());
    assert!(result.err().unwrap().to_string().contains("body \"block\""));
    let mut system = system(rigid_rotor(), Vector3::zeros(), 1e-8);
    assert!(system.set_error_scale(ErrorScale { relative: 0.0, velocity_floor: 1.0 }).is_err());
    assert_eq!(system.dimension(), 13 + 2);
    assert!(system.highest_frequency().abs() < f64::MIN_POSITIVE);
}

#[test]
fn error_norm_passes_nan_on() {
    let mut system = system(rigid_rotor(), Vector3::zeros(), 1e-8);
    let y = state_vector(&system, &[BodyState::at_rest(0)]);
    let mut error = vec![0.0; y.len()];
    assert!(system.error_norm(&y, &y, &error).abs() < f64::MIN_POSITIVE);
    error[8] = f64::NAN;
    assert!(system.error_norm(&y, &y, &error).is_nan());
}
