//! Standard input data and equations of motion against the unreduced model, node by node.

use crate::dynamics_support::{Push, Random, Sample, block, rigid_rotor};
use crate::free_motion::{free_system, state_vector};
use ffr_dynamics::DynamicsError;
use ffr_dynamics::body::{MassMatrix, ModalDamping, RigidMotion, StandardInputData};
use ffr_dynamics::error::EvaluationFailure;
use ffr_dynamics::force::active::Active;
use ffr_dynamics::force::{BodyState, ForceElement, GeneralisedForce, Motion};
use ffr_dynamics::integration::OdeSystem;
use ffr_dynamics::system::free_body::invariants::{Invariants, MeanMotion, centre_of_mass};
use nalgebra::{Matrix3, UnitQuaternion, Vector3};

const MOTIONS: [RigidMotion; 3] = [RigidMotion::Axial, RigidMotion::Planar, RigidMotion::Spatial];
const N_MODES: usize = 8;

/// Sums over thousands of products, some of them cancelling: a few hundred round-offs.
const ROUND_OFF: f64 = 1e-12;

fn gravity_of(motion: RigidMotion) -> Vector3<f64> {
    match motion {
        RigidMotion::Axial => Vector3::new(0.0, 0.0, -9.81),
        RigidMotion::Planar => Vector3::new(1.3, -9.81, 0.0),
        RigidMotion::Spatial => Vector3::new(1.3, -2.0, -9.81),
    }
}

/// `Σ_AB m_AB f(A, B)`.
fn mass_sum(sample: &Sample, f: impl Fn(usize, usize) -> f64) -> f64 {
    let n = sample.mass.nrows();
    (0..n).flat_map(|a| (0..n).map(move |b| (a, b))).map(|(a, b)| sample.mass[(a, b)] * f(a, b)).sum()
}

#[test]
fn energies_and_momenta_equal_those_of_the_full_model() {
    let mut random = Random(1);
    for motion in MOTIONS {
        let sample = block(motion, N_MODES);
        for _ in 0..20 {
            let state = random.state(&sample.data);
            let nodes = sample.node_motion(&state);
            let invariants = Invariants::of_body(&sample.data, &state, &gravity_of(motion));
            let kinetic = 0.5 * mass_sum(&sample, |a, b| nodes[a].1.dot(&nodes[b].1));
            assert!((invariants.kinetic - kinetic).abs() <= ROUND_OFF * kinetic, "{motion:?}");
            let n = nodes.len();
            let (mut p, mut l, mut moment, mut mass) =
                (Vector3::zeros(), Vector3::zeros(), Vector3::zeros(), 0.0);
            for (a, b) in (0..n).flat_map(|a| (0..n).map(move |b| (a, b))) {
                let m = sample.mass[(a, b)];
                p += nodes[a].1 * m;
                l += nodes[b].0.cross(&nodes[a].1) * m;
                moment += nodes[a].0 * m;
                mass += m;
            }
            if motion == RigidMotion::Axial {
                p.x = 0.0; // radial motion has no mean around the circumference
                moment.x = state.position.x * mass;
            } else {
                assert!((invariants.angular_momentum - l).norm() <= ROUND_OFF * l.norm(), "{motion:?}");
            }
            let expected_p = if motion == RigidMotion::Axial { Vector3::z() * p.z } else { p };
            assert!((invariants.linear_momentum - expected_p).norm() <= ROUND_OFF * p.norm(), "{motion:?}");
            let centre = moment / mass;
            assert!((centre_of_mass(&sample.data, &state) - centre).norm() <= ROUND_OFF);
            let motion_of_momenta = MeanMotion::of(&sample.data, &state);
            let v = motion_of_momenta.velocity_at(&centre);
            assert!((v * mass - expected_p).norm() <= ROUND_OFF * p.norm());
            // What the rigid motion with these momenta leaves of the velocities of all nodes.
            let rest: Vec<_> = nodes.iter().map(|(x, v)| v - motion_of_momenta.velocity_at(x)).collect();
            let vibration = 0.5 * mass_sum(&sample, |a, b| rest[a].dot(&rest[b]));
            assert!(vibration > 0.0, "{motion:?}");
            let found = motion_of_momenta.vibration;
            assert!((found - vibration).abs() <= ROUND_OFF * kinetic, "{motion:?} {found} {vibration}");
            assert!((invariants.gravity + mass * gravity_of(motion).dot(&centre)).abs() <= 1e-11 * mass);
        }
    }
}

#[test]
fn kinetic_energy_of_an_axial_body_includes_radial_motion() {
    let sample = block(RigidMotion::Axial, N_MODES);
    let mut state = BodyState::at_rest(N_MODES);
    state.elastic_rates[2] = 0.7;
    let invariants = Invariants::of_body(&sample.data, &state, &Vector3::zeros());
    assert!((invariants.kinetic - 0.5 * 0.49).abs() <= ROUND_OFF);
}

#[test]
fn modes_of_the_free_body_belong_to_a_buckens_frame_whatever_its_origin() {
    for motion in MOTIONS {
        let sample = block(motion, N_MODES);
        assert!(is_buckens_frame(&sample.data), "{motion:?}");
        assert!(sample.data.centre_of_mass().norm() > 0.01);
        let mut moved = sample.body.clone();
        let centre = sample.data.centre_of_mass();
        let origin = motion.components(centre.as_ref());
        for point in moved.nodes.iter_mut().chain(&mut moved.anchors) {
            point.iter_mut().zip(origin).for_each(|(x, x0)| *x -= x0);
        }
        let data =
            StandardInputData::new(&moved, sample.shapes.as_ref(), &sample.data.modal_stiffness).unwrap();
        assert!(data.centre_of_mass().norm() < ROUND_OFF, "{motion:?}");
        assert!(is_buckens_frame(&data));
        // Parallel axes.
        let steiner = centre * centre.transpose() * data.mass;
        assert!((data.second_moment + steiner - sample.data.second_moment).norm() < ROUND_OFF);
    }
}

/// Whether the modes belong to the Buckens frame: `C_t = 0` and `C_r = 0` at rest (Eq. D.5), to the eigensolver's tolerance.
fn is_buckens_frame(data: &StandardInputData) -> bool {
    let (scale, inertia) = (data.mass.sqrt(), data.second_moment.trace().sqrt());
    data.coupling_translation.iter().all(|c| c.norm() <= 1e-6 * scale)
        && (0..data.n_modes()).all(|j| data.coupling_rotation_at_rest(j).norm() <= 1e-6 * inertia)
}

/// A given force on the only body.
struct Given(GeneralisedForce);

impl ForceElement for Given {
    type State = ();
    type Workspace = ();
    type Found = Push;

    fn start(&self) -> ((), (), Push) {
        ((), (), Push { resultant: self.0.force, energy: 0.0 })
    }

    fn evaluate(
        &self,
        _: Motion<'_>,
        (): &mut (),
        (): &mut (),
        _: &mut Push,
        forces: &mut [GeneralisedForce],
    ) -> Result<(), EvaluationFailure> {
        forces[0] = self.0.clone();
        Ok(())
    }
}

/// Accelerations of a free body: of its frame's origin in the inertial frame, angular in the body's, and elastic.
fn accelerated(
    sample: &Sample,
    state: &BodyState,
    gravity: &Vector3<f64>,
    force: &GeneralisedForce,
) -> (Vector3<f64>, Vector3<f64>, Vec<f64>) {
    let bodies = vec![("block", sample.data.clone())];
    let mut system = free_system(bodies, *gravity, vec![Box::new(Active::new(Given(force.clone())))]);
    let y = state_vector(&system, std::slice::from_ref(state));
    let mut rates = vec![0.0; y.len()];
    system.rhs(0.0, &y, &mut rates).unwrap();
    let layout = system.model().bodies[0].layout;
    let (joint, elastic) = (&rates[layout.velocities()], rates[layout.elastic_rates()].to_vec());
    match sample.body.motion {
        RigidMotion::Axial => (Vector3::z() * joint[0], Vector3::zeros(), elastic),
        RigidMotion::Planar => (Vector3::new(joint[0], joint[1], 0.0), Vector3::z() * joint[2], elastic),
        RigidMotion::Spatial => {
            let vector = |from: usize| Vector3::from_column_slice(&joint[from..from + 3]);
            (vector(0), vector(3), elastic)
        }
    }
}

fn random_force(random: &mut Random, motion: RigidMotion) -> GeneralisedForce {
    let mut force = GeneralisedForce::zeros(N_MODES);
    force.elastic.iter_mut().for_each(|f| *f = 10.0 * random.next());
    match motion {
        RigidMotion::Axial => force.force.z = random.next(),
        RigidMotion::Planar => {
            force.force = Vector3::new(random.next(), random.next(), 0.0);
            force.torque_in_body.z = random.next();
        }
        RigidMotion::Spatial => (force.force, force.torque_in_body) = (random.vector(), random.vector()),
    }
    force
}

#[test]
fn accelerations_balance_the_inertia_forces_of_all_nodes() {
    let mut random = Random(7);
    for motion in MOTIONS {
        let sample = block(motion, N_MODES);
        let gravity = gravity_of(motion);
        for _ in 0..10 {
            let state = random.state(&sample.data);
            let force = random_force(&mut random, motion);
            let (v_dot, omega_dot, q_ddot) = accelerated(&sample, &state, &gravity, &force);
            let omega = state.angular_velocity_in_body;
            let local = |v: &Vector3<f64>| state.rotation.inverse_transform_vector(v);
            let n = sample.body.nodes.len();
            let arms: Vec<_> =
                (0..n).map(|a| sample.node(a) + sample.displacement(a, &state.elastic)).collect();
            // Acceleration of each node minus gravity, in the body's frame.
            let a: Vec<_> = (0..n)
                .map(|i| {
                    local(&(v_dot - gravity))
                        + omega_dot.cross(&arms[i])
                        + omega.cross(&omega.cross(&arms[i]))
                        + 2.0 * omega.cross(&sample.displacement(i, &state.elastic_rates))
                        + sample.displacement(i, &q_ddot)
                })
                .collect();
            let weighted: Vec<Vector3<f64>> = (0..n)
                .map(|i| (0..n).fold(Vector3::zeros(), |sum, k| sum + a[k] * sample.mass[(i, k)]))
                .collect();
            let resultant: Vector3<f64> = weighted.iter().sum();
            let moment: Vector3<f64> = arms.iter().zip(&weighted).map(|(r, f)| r.cross(f)).sum();
            // Inertia forces reach 1e3 N here.
            let tolerance = ROUND_OFF * 1e4;
            let along = |v: Vector3<f64>| if motion == RigidMotion::Axial { Vector3::z() * v.z } else { v };
            assert!(along(resultant - local(&force.force)).norm() < tolerance, "{motion:?}");
            if motion != RigidMotion::Axial {
                assert!((moment - force.torque_in_body).norm() < tolerance, "{motion:?}");
            }
            for j in 0..N_MODES {
                let mut unit = vec![0.0; N_MODES];
                unit[j] = 1.0;
                let virtual_work: f64 = (0..n).map(|i| sample.displacement(i, &unit).dot(&weighted[i])).sum();
                let spring = sample.data.modal_stiffness[j] * state.elastic[j];
                let residual = virtual_work + spring - force.elastic[j];
                assert!(
                    residual.abs() < ROUND_OFF * (1e4 + spring.abs()),
                    "{motion:?}, mode {j}: {residual}"
                );
            }
        }
    }
}

#[test]
fn elastic_accelerations_satisfy_lagrange_equations_by_finite_differences() {
    let mut random = Random(23);
    let sample = block(RigidMotion::Spatial, N_MODES);
    let data = &sample.data;
    let kinetic = |s: &BodyState| Invariants::of_body(data, s, &Vector3::zeros()).kinetic;
    // ∂T/∂(dq_j/dt): T is quadratic in the rates, so that the central difference is exact for any step.
    let momentum = |s: &BodyState, j: usize| {
        let ends = [-1.0, 1.0].map(|sign| {
            let mut moved = s.clone();
            moved.elastic_rates[j] += sign;
            kinetic(&moved)
        });
        0.5 * (ends[1] - ends[0])
    };
    let state = random.state(data);
    let force = random_force(&mut random, RigidMotion::Spatial);
    let (v_dot, omega_dot, q_ddot) = accelerated(&sample, &state, &Vector3::zeros(), &force);
    let after = |dt: f64| {
        let mut moved = state.clone();
        moved.velocity += v_dot * dt;
        let mean_omega = state.angular_velocity_in_body + omega_dot * (0.5 * dt);
        moved.rotation = state.rotation * UnitQuaternion::from_scaled_axis(mean_omega * dt);
        moved.angular_velocity_in_body += omega_dot * dt;
        for (j, a) in q_ddot.iter().enumerate() {
            moved.elastic[j] += state.elastic_rates[j] * dt + 0.5 * a * dt * dt;
            moved.elastic_rates[j] += a * dt;
        }
        moved
    };
    // Energies of 1e2 J: round-off 1e-14 / dt = 1e-8; truncation dt² times third derivatives of 1e4 N/s² = 1e-8.
    let dt = 1e-6;
    for j in 0..N_MODES {
        let rate = (momentum(&after(dt), j) - momentum(&after(-dt), j)) / (2.0 * dt);
        let ends = [-1.0, 1.0].map(|sign| {
            let mut moved = state.clone();
            moved.elastic[j] += sign; // T is quadratic in q_e too
            kinetic(&moved)
        });
        let slope = 0.5 * (ends[1] - ends[0]);
        let spring = data.modal_stiffness[j] * state.elastic[j];
        let residual = rate - slope + spring - force.elastic[j];
        assert!(residual.abs() < 1e-6 * (1.0 + spring.abs()), "mode {j}: {residual} of {spring}");
    }
}

#[test]
fn centrifugal_forces_are_the_derivatives_of_the_inertia() {
    let sample = block(RigidMotion::Spatial, N_MODES);
    let data = &sample.data;
    let zero = vec![0.0; N_MODES];
    for j in 0..N_MODES {
        let moved = |q: f64| {
            let mut elastic = zero.clone();
            elastic[j] = q;
            data.deformed_moments(&elastic, &zero).inertia
        };
        // The inertia is quadratic in q_e: the central difference is exact.
        let gradient = (moved(1.0) - moved(-1.0)) * 0.5;
        let omega = Vector3::new(0.3, -1.2, 0.8);
        let squares = [
            omega.x * omega.x,
            omega.y * omega.y,
            omega.z * omega.z,
            omega.x * omega.y,
            omega.y * omega.z,
            omega.z * omega.x,
        ];
        let centrifugal: f64 = data.centrifugal(j).iter().zip(squares).map(|(o, s)| o * s).sum();
        // The force is minus the derivative of ½ ω·I ω.
        assert!((centrifugal + 0.5 * omega.dot(&(gradient * omega))).abs() < ROUND_OFF);
    }
}

#[test]
fn data_that_do_not_fit_are_refused_with_the_numbers() {
    let sample = block(RigidMotion::Planar, 3);
    let (body, shapes, stiffness) = (&sample.body, sample.shapes.as_ref(), &sample.data.modal_stiffness);
    let reason = |result: Result<StandardInputData, DynamicsError>| result.unwrap_err().to_string();
    assert!(
        reason(StandardInputData::new(body, shapes, &stiffness[..2]))
            .contains("eigenfrequencies of the modes: 2, must be 3")
    );
    assert!(reason(StandardInputData::new(body, shapes, &[1.0, f64::NAN, 1.0])).contains("mode 2"));
    let scaled = faer::Scale(1.1) * &sample.shapes;
    assert!(reason(StandardInputData::new(body, scaled.as_ref(), stiffness)).contains("orthonormality"));
    let short = shapes.subrows(0, 4);
    assert!(
        reason(StandardInputData::new(body, short, stiffness))
            .contains("rows of the mode shapes: 4, must be")
    );
    let mut general = body.clone();
    let MassMatrix::PerComponent(mass) = &body.mass else { panic!("made so") };
    general.mass = MassMatrix::General(mass.clone());
    assert!(reason(StandardInputData::new(&general, shapes, stiffness)).contains("the mass matrix is"));
    let rigid =
        |mass, inertia| StandardInputData::rigid(RigidMotion::Spatial, mass, Vector3::zeros(), inertia);
    assert!(reason(rigid(-1.0, Matrix3::identity())).contains("the mass [kg] is -1"));
    let impossible = Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, 3.0));
    assert!(reason(rigid(1.0, impossible)).contains("principal moment"));
    assert!(rigid(1.0, rigid_rotor().inertia()).is_ok());
}

#[test]
fn damping_matrix_and_coefficients_agree() {
    let coefficients = vec![1.0, 2.0, 3.0];
    let matrix = faer::Mat::from_fn(3, 3, |i, j| if i == j { coefficients[i] } else { 0.0 });
    let rates = [0.5, -1.0, 2.0];
    let mut forces = [[0.0; 3]; 2];
    let powers = [
        ModalDamping::PerMode(coefficients.clone()).apply(&rates, &mut forces[0]),
        ModalDamping::Full(matrix).apply(&rates, &mut forces[1]),
    ];
    assert!((powers[0] - powers[1]).abs() < ROUND_OFF && (powers[0] - 14.25).abs() < ROUND_OFF);
    assert!(forces[0].iter().zip(&forces[1]).all(|(a, b)| (a - b).abs() < ROUND_OFF));
}
