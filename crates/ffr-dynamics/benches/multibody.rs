//! Right-hand side of two double pendulums: four flexible bodies of 20 modes in two chains of a rod and a ball.

#![expect(clippy::unwrap_used, reason = "a benchmark that cannot be set up shall stop")]

#[path = "../tests/dynamics_support/mod.rs"]
#[expect(dead_code, reason = "tests use the rest")]
mod dynamics_support;

use divan::{Bencher, black_box};
use dynamics_support::{Random, block};
use ffr_dynamics::body::RigidMotion;
use ffr_dynamics::integration::{Integrator, OdeSystem, StepSettings};
use ffr_dynamics::kinematics::Marker;
use ffr_dynamics::system::{Attachment, BodySpec, GROUND, JointKind, JointSpec, Multibody, SystemSpec};
use nalgebra::{UnitQuaternion, Vector3};

const N_MODES: usize = 20;

fn main() {
    divan::main();
}

/// Two chains in motion; rods in a tangent frame at their upper ends if `is_tangent`.
fn double_pendulums(is_tangent: bool) -> (Multibody, Vec<f64>) {
    let sample = block(RigidMotion::Spatial, N_MODES);
    let marker = |name: &str, a: usize| {
        sample.marker(name, a, UnitQuaternion::identity(), |j| sample.nodal_rotation(a, j))
    };
    let (start, end) = (marker("start", 0), marker("end", 11));
    let frame = start.tangent_frame(RigidMotion::Spatial);
    let mut spec = SystemSpec { gravity: Vector3::z() * -9.81, ..SystemSpec::default() };
    for side in ["left", "right"] {
        let (rod, ball) = (format!("{side} rod"), format!("{side} ball"));
        spec.ground.push(Marker::rigid(side, Vector3::zeros(), UnitQuaternion::identity()));
        let (mut data, mut markers) = (sample.data.clone(), vec![start.clone(), end.clone()]);
        if is_tangent {
            data = data.in_tangent_frame(&frame).expect("the number of modes fits");
            for marker in &mut markers {
                *marker = marker.in_tangent_frame(&frame).expect("the number of modes fits");
            }
        }
        spec.bodies.push(BodySpec { name: rod.clone(), data, markers });
        let markers = vec![start.clone()];
        spec.bodies.push(BodySpec { name: ball.clone(), data: sample.data.clone(), markers });
        let ends = [
            (format!("{side} suspension"), Attachment::new(GROUND, side), Attachment::new(&rod, "start")),
            (format!("{side} hinge"), Attachment::new(&rod, "end"), Attachment::new(&ball, "start")),
        ];
        for (name, parent, child) in ends {
            spec.joints.push(JointSpec::new(&name, JointKind::Revolute, parent, child));
        }
    }
    let system: Multibody = Multibody::new(spec, Vec::new()).expect("the parts fit");
    let mut random = Random(3);
    let mut y = system.rest();
    let n = y.len() - 2;
    y[..n].iter_mut().for_each(|x| *x = 1e-3 * random.next());
    // Functions of the C library may leave the upper halves of vector registers in use, which slows down all that follows
    // by a factor of 2.4 (seen on one machine); a product with wide registers ends by releasing them.
    let wide = faer::Mat::<f64>::from_fn(16, 16, |i, j| (i + j) as f64);
    black_box(&wide * &wide);
    (system, y)
}

#[divan::bench(sample_size = 100, args = [true, false])]
fn right_hand_side_of_4_bodies_of_20_modes(bencher: Bencher, is_tangent: bool) {
    let (mut system, y) = double_pendulums(is_tangent);
    let mut rates = vec![0.0; y.len()];
    bencher.bench_local(|| system.rhs(0.0, black_box(&y), &mut rates).expect("no force refuses"));
}

#[divan::bench(sample_size = 20)]
fn step_of_4_bodies_of_20_modes(bencher: Bencher) {
    let (mut system, y) = double_pendulums(true);
    let mut integrator =
        Integrator::explicit(StepSettings::fixed(1e-7), 0.0, &y).expect("the step is positive");
    bencher.bench_local(|| integrator.step(&mut system, 1e9).expect("the motion is smooth"));
}

#[divan::bench(sample_size = 100)]
fn error_norm_of_4_bodies_of_20_modes(bencher: Bencher) {
    let (mut system, y) = double_pendulums(true);
    bencher.bench_local(|| system.error_norm(black_box(&y), &y, &y));
}
