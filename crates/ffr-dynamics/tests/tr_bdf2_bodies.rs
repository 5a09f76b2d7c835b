//! TR-BDF2 on flexible bodies: agreement with the explicit method, energy, unresolved modes, cost.

#![expect(clippy::unwrap_used, reason = "a failure here fails the test")]

#[expect(dead_code, reason = "other test binaries use the rest")]
mod dynamics_support;

use dynamics_support::{Random, block};
use ffr_dynamics::body::{ModalDamping, RigidMotion, StandardInputData};
use ffr_dynamics::integration::{DormandPrince, Statistics, StepSettings, TrBdf2};
use ffr_dynamics::system::{BodyState, ErrorScale, ForceElement, FreeBodies, FreeBody};
use nalgebra::Vector3;

fn system(data: StandardInputData, gravity: Vector3<f64>, relative: f64) -> FreeBodies {
    let body = FreeBody { name: "body".to_string(), data };
    let mut system = FreeBodies::<Box<dyn ForceElement>>::new(vec![body], gravity, Vec::new()).unwrap();
    system.set_error_scale(ErrorScale { relative, ..ErrorScale::default() }).unwrap();
    system
}

fn implicit(system: &mut FreeBodies, start: &BodyState, t_end: f64) -> (Vec<f64>, Statistics) {
    let y = system.state_vector(std::slice::from_ref(start)).unwrap();
    let mut integrator = TrBdf2::new(StepSettings::default(), 0.0, &y, system).unwrap();
    integrator.run(system, t_end, |_, _| true).unwrap();
    (integrator.state().to_vec(), integrator.statistics())
}

fn explicit(system: &mut FreeBodies, start: &BodyState, t_end: f64) -> (Vec<f64>, Statistics) {
    let y = system.state_vector(std::slice::from_ref(start)).unwrap();
    let mut integrator = DormandPrince::new(StepSettings::default(), 0.0, &y).unwrap();
    integrator.run(system, t_end, |_, _| true).unwrap();
    (integrator.state().to_vec(), integrator.statistics())
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
    for high in [0.0, 1e-5] {
        let mut system = system(wide_spectrum(), Vector3::zeros(), 1e-5);
        let mut start = BodyState::at_rest(20);
        start.elastic = vec![high * 1e-4; 20];
        start.elastic[0] = 1e-4;
        let (y, statistics) = implicit(&mut system, &start, 0.1);
        let end = system.body_state(&y, 0);
        // Closed form of the slow mode: phase error 1e-5 a step at worst, 150 steps.
        let (omega, zeta) = (1e2_f64, 0.01_f64);
        let damped = omega * (1.0 - zeta * zeta).sqrt();
        let t = 0.1;
        let expected = 1e-4
            * (-zeta * omega * t).exp()
            * ((damped * t).cos() + zeta / (1.0 - zeta * zeta).sqrt() * (damped * t).sin());
        println!("{high}: {statistics:?} {:e} {expected:e}", end.elastic[0]);
        assert!((end.elastic[0] - expected).abs() < 2e-3 * 1e-4);
        assert!(end.elastic[10..].iter().all(|q| q.abs() < 1e-12), "{:?}", end.elastic);
        assert!(statistics.steps < 300, "{statistics:?}");
    }
}

#[test]
fn tumbling_flexible_body_agrees_with_the_explicit_method() {
    for motion in [RigidMotion::Axial, RigidMotion::Planar, RigidMotion::Spatial] {
        let sample = block(motion, 8);
        let start = Random(3).state(&sample.data);
        let gravity = Vector3::new(0.0, 0.0, if motion == RigidMotion::Planar { 0.0 } else { -9.81 });
        let mut system = system(sample.data, gravity, 1e-9);
        let (reference, _) = explicit(&mut system, &start, 2e-3);
        let before = system.state_vector(std::slice::from_ref(&start)).unwrap();
        let before = system.invariants(&before);
        let mut errors = Vec::new();
        for relative in [1e-5, 1e-6, 1e-7] {
            system.set_error_scale(ErrorScale { relative, ..ErrorScale::default() }).unwrap();
            let (y, statistics) = implicit(&mut system, &start, 2e-3);
            let error: f64 = y[..7].iter().zip(&reference).map(|(a, b)| (a - b).abs()).sum();
            let loss = (before.energy() - system.invariants(&y).energy()) / before.energy();
            println!("{motion:?} {relative:e}: {error:e} loss {loss:e} {statistics:?}");
            errors.push(error);
            assert!(statistics.iterations < 3 * 2 * (statistics.steps + statistics.rejected));
        }
    }
}
