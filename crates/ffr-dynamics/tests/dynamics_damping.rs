//! Damped modes of a free body: closed form, and the work that damping takes.

use crate::dynamics_support::block;
use crate::free_motion::{body_state, free_system, state_vector};
use ffr_dynamics::body::{ModalDamping, RayleighDamping, RigidMotion};
use ffr_dynamics::force::BodyState;
use ffr_dynamics::force::active::ActiveForce;
use ffr_dynamics::integration::{Integrator, OdeSystem, StepSettings};
use ffr_dynamics::system::ErrorScale;
use nalgebra::Vector3;
use std::f64::consts::TAU;

/// Amplitude of mode `j` after `t`, let go at 1 with damping ratio `zeta` below, at or above 1.
fn released(omega: f64, zeta: f64, t: f64) -> f64 {
    let root = omega * (1.0 - zeta * zeta).abs().sqrt();
    let decay = (-zeta * omega * t).exp();
    if zeta < 1.0 {
        decay * ((root * t).cos() + zeta * omega / root * (root * t).sin())
    } else if zeta > 1.0 {
        decay * ((root * t).cosh() + zeta * omega / root * (root * t).sinh())
    } else {
        decay * (1.0 + omega * t)
    }
}

#[test]
fn modes_decay_as_in_closed_form_and_the_ledger_closes() {
    const AMPLITUDE: f64 = 1e-5;
    let sample = block(RigidMotion::Planar, 3);
    let omega: Vec<f64> = sample.data.modal_stiffness.iter().map(|k| k.sqrt()).collect();
    let rayleigh = RayleighDamping::from_frequencies([omega[0] / TAU, omega[2] / TAU], 0.05).unwrap();
    let by_rayleigh: Vec<f64> = omega.iter().map(|w| rayleigh.ratio(w / TAU)).collect();
    for (damping, ratios) in [
        (rayleigh.modal(&sample.data.modal_stiffness), by_rayleigh),
        // Weakly damped, critical ([A] section 6, model 4), overcritical.
        (
            ModalDamping::from_ratios(&[0.01, 1.0, 1.5], &sample.data.modal_stiffness).unwrap(),
            vec![0.01, 1.0, 1.5],
        ),
    ] {
        let mut data = sample.data.clone();
        data.modal_damping = damping;
        let none: Vec<Box<dyn ActiveForce>> = Vec::new();
        let mut system = free_system(vec![("block", data)], Vector3::zeros(), none);
        let mut state = BodyState::at_rest(3);
        state.elastic.fill(AMPLITUDE);
        let y = state_vector(&system, &[state]);
        let scale = ErrorScale { relative: 1e-10, ..system.error_scale() };
        system.set_error_scale(scale).unwrap();
        let start = system.invariants(0.0, &y);
        let end = 3.0 * TAU / omega[0];
        let mut integrator = Integrator::explicit(StepSettings::with_max_step(end), 0.0, &y).unwrap();
        integrator.run(&mut system, end, |_, _| true).unwrap();
        let y = integrator.state();
        let last = body_state(&mut system, y, 0);
        for j in 0..3 {
            let expected = AMPLITUDE * released(omega[j], ratios[j], end);
            // A block at rest in a Buckens frame: rigid and elastic motion interact only at second order in the amplitude.
            assert!((last.elastic[j] - expected).abs() < 1e-6 * AMPLITUDE, "{j} {}", last.elastic[j]);
        }
        let now = system.invariants(0.0, y);
        let lost = start.kinetic + start.elastic - now.kinetic - now.elastic;
        let work = system.dissipated_work(y);
        assert!(lost > 0.1 * start.elastic);
        // Tolerance of the steps, some hundred of them.
        assert!((work - lost).abs() < 1e-7 * start.elastic, "{work} {lost}");
        assert!(system.dimension() == y.len());
    }
}
