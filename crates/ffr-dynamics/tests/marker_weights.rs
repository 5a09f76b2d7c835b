//! Markers of unreduced bodies, bodies held at one point, and bodies as plain values.

use crate::dynamics_support::block;
use faer::Mat;
use ffr_dynamics::body::{ModalDamping, RigidMotion};
use ffr_dynamics::interchange::{BodyFrame, FullBody, ReducedModel, ReducedParts};
use ffr_dynamics::kinematics::MarkerWeights;
use ffr_dynamics::reduction::ElasticProblem;
use nalgebra::{UnitQuaternion, Vector3};

/// A marker beside its nodes, all of the body's.
fn marker(motion: RigidMotion, nodes: &[u32]) -> MarkerWeights {
    let sample = block(motion, 3);
    let z = if motion == RigidMotion::Planar { 0.0 } else { 0.3 };
    let place = Vector3::new(if motion == RigidMotion::Axial { 0.0 } else { 0.1 }, 0.0, z);
    MarkerWeights::of_nodes(&sample.body, place, UnitQuaternion::identity(), nodes).unwrap()
}

#[test]
fn markers_on_nodes_follow_rigid_motions() {
    for motion in [RigidMotion::Axial, RigidMotion::Planar, RigidMotion::Spatial] {
        let sample = block(motion, 3);
        let marker = marker(motion, &[0, 1, 2, 3]);
        marker.check_rigid_motions(&sample.body).unwrap();
        // One that forgets a node does not.
        let fewer = marker.entries()[2..].to_vec();
        let broken = MarkerWeights::new(marker.position(), marker.rotation(), fewer).unwrap();
        let text = broken.check_rigid_motions(&sample.body).unwrap_err().to_string();
        assert!(text.contains("does not follow the body's translation"), "{text}");
    }
}

#[test]
fn nodes_that_define_no_rotation_are_refused() {
    let sample = block(RigidMotion::Spatial, 3);
    let refused = |nodes: &[u32]| {
        let place = Vector3::zeros();
        MarkerWeights::of_nodes(&sample.body, place, UnitQuaternion::identity(), nodes)
            .unwrap_err()
            .to_string()
    };
    assert!(refused(&[]).contains("nodes of a marker: 0"));
    assert!(refused(&[0]).contains("do not define a rotation"));
    assert!(refused(&[0, 1]).contains("do not define a rotation"));
    assert!(refused(&[0, 1, 1]).contains("nodes of a marker: 1 of"));
    assert!(refused(&[0, 1, 99]).contains("nodes of a marker: 99 of"));
}

#[test]
fn held_bodies_are_in_equilibrium_and_do_not_move_at_the_support() {
    for motion in [RigidMotion::Axial, RigidMotion::Planar, RigidMotion::Spatial] {
        let sample = block(motion, 3);
        let n = sample.body.dofs.len();
        let support = marker(motion, &[0, 1, 2, 3]).forces(motion, n).unwrap();
        let loads = Mat::from_fn(n, 2, |i, j| ((3 * i + 5 * j) % 7) as f64 - 2.0);
        let problem = ElasticProblem::free(&sample.body, &[]).unwrap();
        let u = problem.held_at_point(loads.as_ref(), support.as_ref()).unwrap();
        let scale = u.norm_max();
        assert!((support.transpose() * &u).norm_max() < 1e-10 * scale * support.norm_max());
        // K u - F is a combination of the reactions: what is orthogonal to them is orthogonal to it.
        let rest = problem.stiffness_product(u.as_ref()) - &loads;
        let gram = support.transpose() * &support;
        let factor = gram.partial_piv_lu();
        let part = &support * faer::linalg::solvers::Solve::solve(&factor, support.transpose() * &rest);
        assert!((rest - part).norm_max() < 1e-9 * loads.norm_max(), "{motion:?}");
        // Betti: loads do the same work on each other's displacements.
        let work = loads.transpose() * &u;
        assert!((work[(0, 1)] - work[(1, 0)]).abs() < 1e-9 * work.norm_max());
        assert!(
            problem.held_at_point(loads.as_ref(), loads.as_ref()).is_err() || motion == RigidMotion::Axial
        );
    }
}

#[test]
fn full_bodies_are_checked() {
    let sample = block(RigidMotion::Planar, 3);
    let hub = marker(RigidMotion::Planar, &[0, 1, 2, 3]);
    let twice = vec![("hub".to_string(), hub.clone()), ("hub".to_string(), hub.clone())];
    assert!(FullBody::new(sample.body.clone(), twice).unwrap_err().to_string().contains("\"hub\""));
    let mut held = sample.body.clone();
    held.stiffness.val_mut()[0] *= 1.1;
    let text = FullBody::new(held, vec![("hub".to_string(), hub.clone())]).unwrap_err().to_string();
    assert!(text.contains("resists rigid motion"), "{text}");
    let mut negative = sample.body.clone();
    negative.stiffness.val_mut()[0] *= -1.0;
    assert!(FullBody::new(negative, Vec::new()).unwrap_err().to_string().contains("must be positive"));
    assert_eq!(FullBody::new(sample.body, vec![("hub".to_string(), hub)]).unwrap().markers().len(), 1);
}

#[test]
fn reduced_bodies_come_back_the_same_and_faults_are_named() {
    let sample = block(RigidMotion::Spatial, 3);
    let hub = marker(RigidMotion::Spatial, &[0, 1, 2, 3]).marker("hub", sample.shapes.as_ref()).unwrap();
    let tangent = hub.tangent_frame(RigidMotion::Spatial);
    let mut data = sample.data.in_tangent_frame(&tangent).unwrap();
    data.modal_damping = ModalDamping::PerMode(vec![0.1, 0.2, 0.3]);
    let parts = ReducedParts {
        name: "block".to_string(),
        frame: BodyFrame::Tangent { marker: "hub".to_string() },
        data: data.to_parts(),
        frequencies: vec![1.0, 2.0, 3.0],
        points: vec![("tip".to_string(), hub.point())],
        markers: vec![hub.in_tangent_frame(&tangent).unwrap()],
    };
    let model = ReducedModel::new(parts.clone()).unwrap();
    assert_eq!(model.data(), &data);
    assert_eq!(ReducedModel::new(model.to_parts()).unwrap(), model);
    type Change = fn(&mut ReducedParts);
    let faults: [(Change, &str); 12] = [
        (|p| p.data.mass = f64::NAN, "the mass [kg] is NaN"),
        (|p| p.data.second_moment[(0, 1)] += 1.0, "not symmetric"),
        (|p| p.data.second_moment *= -1.0, "no distribution of mass"),
        (|p| p.data.position_shape.truncate(5), "entries of position_shape for 3 modes: 5, must be 27"),
        (|p| p.data.shape_shape[30] = f64::INFINITY, "not finite"),
        (|p| p.data.shape_shape[30] += 1.0, "shape_shape"),
        (|p| p.data.modal_stiffness[1] = -1.0, "the stiffness of mode 2 is -1"),
        (|p| p.data.modal_damping = ModalDamping::Full(Mat::from_fn(3, 3, |_, _| -1.0)), "adds energy"),
        (
            |p| p.data.modal_mass = Some(Mat::from_fn(3, 3, |i, j| if i == j { -1.0 } else { 0.0 })),
            "modal mass",
        ),
        (|p| p.frequencies.truncate(2), "eigenfrequencies of the modes: 2, must be 3"),
        (
            |p| p.frame = BodyFrame::Tangent { marker: "hob".to_string() },
            "\"hob\", which the body does not have",
        ),
        (|p| p.points.push(p.points[0].clone()), "\"tip\""),
    ];
    for (change, expected) in faults {
        let mut faulty = parts.clone();
        change(&mut faulty);
        let text = ReducedModel::new(faulty).unwrap_err().to_string();
        assert!(text.contains(expected), "{text}");
    }
    let moved = ReducedParts { markers: vec![hub], ..parts };
    assert!(ReducedModel::new(moved).unwrap_err().to_string().contains("which the modes move"));
}
