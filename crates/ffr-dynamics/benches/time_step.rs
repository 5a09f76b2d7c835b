//! One right-hand side and one step of a turning flexible body with 20 modes.

#![expect(clippy::unwrap_used, reason = "a benchmark that cannot be set up shall stop")]

#[path = "../tests/dynamics_support/mod.rs"]
#[expect(dead_code, reason = "tests use the rest")]
mod dynamics_support;
#[path = "../tests/free_motion/mod.rs"]
#[expect(dead_code, reason = "tests use the rest")]
mod free_motion;

use divan::{Bencher, black_box};
use dynamics_support::{Random, block};
use ffr_dynamics::body::RigidMotion;
use ffr_dynamics::integration::{Integrator, Method, OdeSystem, StepSettings};
use ffr_dynamics::system::Multibody;
use free_motion::{free_system, state_vector};
use nalgebra::Vector3;

const N_MODES: usize = 20;

fn main() {
    divan::main();
}

fn body_in_motion() -> (Multibody, Vec<f64>) {
    let sample = block(RigidMotion::Spatial, N_MODES);
    let start = Random(2).state(&sample.data);
    let system: Multibody = free_system(vec![("block", sample.data)], Vector3::zeros(), Vec::new());
    let y = state_vector(&system, &[start]);
    (system, y)
}

#[divan::bench(sample_size = 100)]
fn right_hand_side_of_20_modes(bencher: Bencher) {
    let (mut system, y) = body_in_motion();
    let mut rates = vec![0.0; y.len()];
    bencher.bench_local(|| system.rhs(0.0, black_box(&y), &mut rates).expect("no force refuses"));
}

#[divan::bench(sample_size = 100)]
fn step_of_20_modes(bencher: Bencher) {
    let (mut system, y) = body_in_motion();
    let mut integrator =
        Integrator::explicit(StepSettings::fixed(1e-6), 0.0, &y).expect("the step is positive");
    bencher.bench_local(|| integrator.step(&mut system, 1e9).expect("the motion is smooth"));
}

#[divan::bench(sample_size = 100)]
fn invariants_of_20_modes(bencher: Bencher) {
    let (mut system, y) = body_in_motion();
    bencher.bench_local(|| system.invariants(0.0, black_box(&y)));
}

#[divan::bench(sample_size = 100)]
fn implicit_step_of_20_modes(bencher: Bencher) {
    let (mut system, y) = body_in_motion();
    let mut integrator = Integrator::new(Method::TrBdf2, StepSettings::fixed(1e-6), 0.0, &y, &system)
        .expect("the step is positive");
    bencher.bench_local(|| integrator.step(&mut system, 1e9).expect("the motion is smooth"));
}

#[divan::bench(sample_size = 10)]
fn implicit_step_of_20_modes_with_new_derivative(bencher: Bencher) {
    let (mut system, y) = body_in_motion();
    let mut integrator = Integrator::new(Method::TrBdf2, StepSettings::fixed(1e-6), 0.0, &y, &system)
        .expect("the step is positive");
    bencher.bench_local(|| {
        integrator.invalidate();
        integrator.step(&mut system, 1e9).expect("the motion is smooth")
    });
}
