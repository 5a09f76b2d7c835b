//! Trees of flexible bodies: kinematics and equations of motion against routes that share no code with them.

use crate::dynamics_support::{Random, Sample, block};
use crate::free_motion::{free_system, state_vector};
use crate::tree::{GRAVITY, KINDS, STENCIL, STEP, Tree, moved, node_velocities, tree};
use ffr_dynamics::body::RigidMotion;
use ffr_dynamics::force::BodyState;
use ffr_dynamics::force::active::ActiveForce;
use ffr_dynamics::integration::OdeSystem;
use ffr_dynamics::system::{CoordinateForce, JointKind, Multibody, TimeFunction};
use nalgebra::{UnitQuaternion, Vector3};

/// Largest violation of Jourdain's principle: for each free rate, the power of inertia, weight and elastic forces of all
/// control points, as a share of the sum of its parts.
fn jourdain(tree: &mut Tree, t: f64) -> f64 {
    let y = tree.y.clone();
    let mut rates = vec![0.0; y.len()];
    tree.system.rhs(t, &y, &mut rates).unwrap();
    let ends = STENCIL.map(|(at, weight)| {
        let h = at * STEP;
        (weight / STEP, node_velocities(tree, t + h, &moved(&y, &rates, h)))
    });
    let base = node_velocities(tree, t, &y);
    let mut worst: f64 = 0.0;
    for i in 0..3 {
        let layout = tree.system.model().bodies[i].layout;
        for (k, index) in layout.elastic_rates().chain(layout.velocities()).enumerate() {
            let mut varied = y.clone();
            varied[index] += 1.0;
            let varied = node_velocities(tree, t, &varied);
            let (mut sum, mut size) = (0.0, 0.0);
            let mut count = |power: f64| {
                sum += power;
                size += power.abs();
            };
            for (b, sample) in tree.samples.iter().enumerate() {
                for a in 0..base[b].len() {
                    let direction = varied[b][a] - base[b][a];
                    let force: Vector3<f64> = (0..base[b].len())
                        .map(|c| {
                            let acceleration: Vector3<f64> = ends.iter().map(|(w, v)| v[b][c] * *w).sum();
                            (acceleration - GRAVITY) * sample.mass[(a, c)]
                        })
                        .sum();
                    count(direction.dot(&force));
                }
            }
            if k < layout.n_modes {
                let stiffness = tree.system.model().bodies[i].data.modal_stiffness[k];
                count(stiffness * y[layout.elastic().start + k]);
            }
            worst = worst.max(sum.abs() / size);
        }
    }
    worst
}

#[test]
fn accelerations_obey_the_principle_of_virtual_power_for_all_joints() {
    for (i, kind) in KINDS.into_iter().enumerate() {
        let kinds = [kind, KINDS[(i + 4) % 9], KINDS[(i + 7) % 9]];
        let mut tree = tree(kinds, 7 + i as u64, |_| {});
        let violation = jourdain(&mut tree, 0.0);
        // Round-off of velocities of 5 m/s over 1e-5 s is 1e-10, against accelerations of 10 m/s² and more.
        assert!(violation < 1e-7, "{kinds:?}: {violation:e}");
    }
}

#[test]
fn prescribed_motion_enters_the_accelerations() {
    let motion = |a: f64, w: f64| {
        TimeFunction::new(move |t| [a * (w * t).sin(), a * w * (w * t).cos(), -a * w * w * (w * t).sin()])
    };
    let kinds = [JointKind::Planar, JointKind::Universal, JointKind::Cylindrical];
    let mut tree = tree(kinds, 3, |spec| {
        for (joint, k) in spec.joints.iter_mut().zip([1, 0, 1]) {
            joint.coordinates = vec![CoordinateForce::default(); joint.kind.n_velocities()];
            joint.coordinates[k].motion = Some(motion(0.4, 5.0 + k as f64));
        }
    });
    let violation = jourdain(&mut tree, 0.3);
    assert!(violation < 1e-7, "{violation:e}"); // as above
    let at = tree.system.joint_coordinates(0.3, &tree.y, 0);
    assert!((at.positions[1] - 0.4 * 1.8f64.sin()).abs() < 1e-15);
}

#[test]
fn velocities_are_derivatives_of_positions_for_all_joints() {
    for (i, kind) in KINDS.into_iter().enumerate() {
        let Tree { mut system, y, .. } =
            tree([kind, KINDS[(i + 1) % 9], KINDS[(i + 2) % 9]], 20 + i as u64, |_| {});
        let mut rates = vec![0.0; y.len()];
        system.rhs(0.0, &y, &mut rates).unwrap();
        let states = system.body_states(0.0, &y).to_vec();
        let ends = STENCIL.map(|(at, weight)| {
            let end = system.body_states(0.0, &moved(&y, &rates, at * STEP)).to_vec();
            (weight / STEP, end)
        });
        for (b, state) in states.iter().enumerate() {
            let velocity: Vector3<f64> = ends.iter().map(|(w, s)| s[b].position * *w).sum();
            let turned = |s: &BodyState| (state.rotation.inverse() * s.rotation).scaled_axis();
            let spin: Vector3<f64> = ends.iter().map(|(w, s)| turned(&s[b]) * *w).sum();
            assert!((velocity - state.velocity).norm() < 1e-8, "{kind:?}");
            assert!((spin - state.angular_velocity_in_body).norm() < 1e-8, "{kind:?}");
        }
    }
}

#[test]
fn joints_hold_what_they_should() {
    for (i, kind) in KINDS.into_iter().enumerate() {
        let Tree { mut system, y, .. } =
            tree([JointKind::Free, kind, JointKind::Fixed], 40 + i as u64, |_| {});
        let states = system.body_states(0.0, &y).to_vec();
        let (root, parent) = system.marker("root", "b").unwrap();
        let (left, child) = system.marker("left", "b").unwrap();
        let axes = parent.orientation(&states[root]);
        let d = axes.inverse() * (child.place(&states[left]) - parent.place(&states[root]));
        let relative = (axes.inverse() * child.orientation(&states[left])).to_rotation_matrix();
        for &k in kind.held_directions() {
            assert!(d[k].abs() < 1e-14, "{kind:?}"); // round-off
        }
        for &(a, b) in kind.perpendicular_axes() {
            assert!(relative[(a, b)].abs() < 1e-14, "{kind:?}");
        }
        let n = kind.held_directions().len() + kind.perpendicular_axes().len();
        assert_eq!(n + kind.n_velocities(), 6);
    }
}

/// Power of inertia and weight of all nodes of a free body, and of its elastic forces, for a unit rate of each coordinate: six of
/// the frame, then the elastic ones; as shares of the sums of their parts. `shape` is the displacement of a node by a mode.
fn free_violation(
    sample: &Sample,
    system: &mut Multibody,
    state: &BodyState,
    shape: impl Fn(usize, usize) -> Vector3<f64>,
) -> f64 {
    let y = state_vector(system, std::slice::from_ref(state));
    let mut rates = vec![0.0; y.len()];
    system.rhs(0.0, &y, &mut rates).unwrap();
    let layout = system.model().bodies[0].layout;
    let frame = |from: usize| Vector3::from_column_slice(&rates[layout.velocities()][from..from + 3]);
    let (translation, spin_rate, omega) = (frame(0), frame(3), state.angular_velocity_in_body);
    let (n, n_q) = (sample.body.nodes.len(), layout.n_modes);
    let field = |a: usize, q: &[f64]| (0..n_q).map(|j| shape(a, j) * q[j]).sum::<Vector3<f64>>();
    let arms: Vec<_> = (0..n).map(|a| sample.node(a) + field(a, &state.elastic)).collect();
    let apparent = state.rotation.inverse() * (translation - GRAVITY);
    let acceleration = |a: usize| {
        apparent
            + spin_rate.cross(&arms[a])
            + omega.cross(&omega.cross(&arms[a]))
            + 2.0 * omega.cross(&field(a, &state.elastic_rates))
            + field(a, &rates[layout.elastic_rates()])
    };
    let accelerations: Vec<_> = (0..n).map(acceleration).collect();
    let force = |a: usize| (0..n).map(|b| accelerations[b] * sample.mass[(a, b)]).sum::<Vector3<f64>>();
    let forces: Vec<_> = (0..n).map(force).collect();
    let unit = |c: usize| Vector3::from_fn(|i, _| f64::from(u8::from(i == c)));
    let mut worst: f64 = 0.0;
    for k in 0..6 + n_q {
        let direction = |a: usize| match k {
            0..3 => unit(k),
            3..6 => unit(k - 3).cross(&arms[a]),
            _ => shape(a, k - 6),
        };
        let mut powers: Vec<f64> = (0..n).map(|a| direction(a).dot(&forces[a])).collect();
        if k >= 6 {
            powers.push(system.model().bodies[0].data.modal_stiffness[k - 6] * state.elastic[k - 6]);
        }
        let size: f64 = powers.iter().map(|p| p.abs()).sum();
        worst = worst.max(powers.iter().sum::<f64>().abs() / size);
    }
    worst
}

#[test]
fn free_body_balances_the_forces_of_its_nodes_in_either_frame() {
    let sample = block(RigidMotion::Spatial, 8);
    let state = Random(5).state(&sample.data);
    let marker = sample.marker("a", 4, UnitQuaternion::identity(), |j| sample.nodal_rotation(4, j));
    let frame = marker.tangent_frame(RigidMotion::Spatial);
    let unit = |j: usize| (0..8).map(|i| f64::from(u8::from(i == j))).collect::<Vec<_>>();
    let buckens = |a: usize, j: usize| sample.displacement(a, &unit(j));
    let tangent = |a: usize, j: usize| buckens(a, j) + frame.displacement(j, &sample.node(a));
    let data = [sample.data.clone(), sample.data.in_tangent_frame(&frame).unwrap()];
    let [mut system, mut shifted] =
        data.map(|data| free_system::<Box<dyn ActiveForce>>(vec![("block", data)], GRAVITY, Vec::new()));
    let violations = [
        free_violation(&sample, &mut system, &state, buckens),
        free_violation(&sample, &mut shifted, &state, tangent),
    ];
    // Round-off: forces of stretched modes of 1e5 N that accelerate the nodes cancel in the motion of the whole body.
    assert!(violations.iter().all(|v| *v < 1e-12), "{violations:?}");
}

#[test]
fn orientation_and_place_of_the_whole_system_do_not_matter() {
    // Ground's marker and gravity turned together: elastic and joint accelerations stay.
    let kinds = [JointKind::Universal, JointKind::Spherical, JointKind::Planar];
    let base = tree(kinds, 11, |_| {});
    let whole = UnitQuaternion::from_scaled_axis(Vector3::new(0.7, -1.9, 0.4));
    let turned = tree(kinds, 11, |spec| {
        spec.ground[0].rotation = whole * spec.ground[0].rotation;
        spec.ground[0].position += Vector3::new(3.0, 1.0, -2.0);
        spec.gravity = whole * spec.gravity;
    });
    let rates = [base, turned].map(|mut tree| {
        let mut rates = vec![0.0; tree.y.len()];
        tree.system.rhs(0.0, &tree.y, &mut rates).unwrap();
        rates
    });
    let scale = rates[0].iter().map(|r| r.abs()).fold(0.0, f64::max);
    for (a, b) in rates[0].iter().zip(&rates[1]) {
        assert!((a - b).abs() < 1e-12 * scale); // round-off
    }
}

#[test]
fn tangent_frame_data_give_the_energy_of_the_same_displacements() {
    let sample = block(RigidMotion::Spatial, 7);
    let mut random = Random(17);
    let marker = sample.marker("a", 4, UnitQuaternion::identity(), |j| sample.nodal_rotation(4, j));
    let frame = marker.tangent_frame(RigidMotion::Spatial);
    let data = sample.data.in_tangent_frame(&frame).unwrap();
    let state = random.state(&sample.data);
    // Kinetic energy node by node with the shifted shapes.
    let n = sample.body.nodes.len();
    let field = |a: usize, q: &[f64]| {
        let shift: Vector3<f64> = (0..7).map(|j| frame.displacement(j, &sample.node(a)) * q[j]).sum();
        sample.displacement(a, q) + shift
    };
    let velocity = |a: usize| {
        let arm = sample.node(a) + field(a, &state.elastic);
        let local = state.angular_velocity_in_body.cross(&arm) + field(a, &state.elastic_rates);
        state.velocity + state.rotation * local
    };
    let v: Vec<_> = (0..n).map(velocity).collect();
    let kinetic: f64 = (0..n)
        .flat_map(|a| (0..n).map(move |b| (a, b)))
        .map(|(a, b)| 0.5 * sample.mass[(a, b)] * v[a].dot(&v[b]))
        .sum();
    let invariants =
        ffr_dynamics::system::free_body::invariants::Invariants::of_body(&data, &state, &GRAVITY);
    assert!((invariants.kinetic - kinetic).abs() < 1e-12 * kinetic); // round-off of sums over 12 nodes
    let shifted = marker.in_tangent_frame(&frame).unwrap();
    assert!(shifted.is_still(), "the frame's own marker does not move");
}
