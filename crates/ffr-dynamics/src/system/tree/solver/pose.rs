//! The tree in one pose: inertia of each body, and what its joints hold.

use nalgebra::{Matrix6, Vector6};

use super::number::{applied, product};
use crate::system::free_body::equations::BodyWorkspace;
use crate::system::joints::forces::joint_tangent;
use crate::system::model::{JointCoordinates, MultibodyModel};
use crate::system::tree::kinematics::{JointKinematics, SpatialVector};

/// One body and the joint to its parent. Columns belong to uncoupled modes, rows to a translation
/// and a rotation.
#[derive(Debug, Clone)]
pub(super) struct BodyPose {
    /// Inertia of the frame.
    pub rigid: Matrix6<f64>,
    /// Coupling of frame and modes, one column for each mode.
    pub coupling: Vec<SpatialVector>,
    /// Motion of the place that the own joint holds by the modes; empty if it does not feel them.
    /// That place is then the marker, otherwise the frame.
    pub own: Vec<SpatialVector>,
    /// Motion of that place by that of the frame.
    pub at_own: Matrix6<f64>,
    /// Motion of the parent's marker by the modes of the parent; empty if it does not feel them.
    pub parent: Vec<SpatialVector>,
    /// Motion of the parent's marker by that of the parent's frame.
    pub at_parent: Matrix6<f64>,
    /// Motion of the place by that of the parent's marker.
    pub across: Matrix6<f64>,
    /// Motions of the place by the free velocities of the joint; the rest are zero.
    pub joint: Matrix6<f64>,
    /// Acceleration of the place by velocities and prescribed motions alone.
    pub bias: Vector6<f64>,
    /// The same of the parent's marker.
    pub parent_bias: Vector6<f64>,
    /// Size of the body's inertia, its square root: of a translation and of a rotation [√kg, √kg
    /// m].
    pub sizes: [f64; 2],
    /// Stiffness and damping of the joint's free velocities about the present motion.
    pub springs: [[f64; 2]; 6],
}

/// All bodies in one pose.
#[derive(Debug, Clone)]
pub(in crate::system) struct TreePose {
    pub(super) bodies: Vec<BodyPose>,
}

impl TreePose {
    /// Space for the bodies of `model`.
    pub fn new(model: &MultibodyModel) -> Self {
        let n_modes = |i: usize| model.bodies[i].layout.n_modes;
        let bodies = model.bodies.iter().enumerate().map(|(i, body)| {
            let of_parent = body.joint.parent.body.filter(|_| body.joint.parent.marker.n_modes() > 0);
            let n_own = if body.joint.child.is_still() { 0 } else { n_modes(i) };
            // A model that lies on a line may turn about it without inertia, or even with less.
            let turning = body.data.second_moment.trace().abs().max(f64::MIN_POSITIVE);
            BodyPose {
                rigid: Matrix6::zeros(),
                coupling: vec![[0.0; 6]; n_modes(i)],
                own: vec![[0.0; 6]; n_own],
                parent: vec![[0.0; 6]; of_parent.map_or(0, n_modes)],
                at_parent: Matrix6::identity(),
                at_own: Matrix6::identity(),
                bias: Vector6::zeros(),
                parent_bias: Vector6::zeros(),
                sizes: [body.data.mass.sqrt(), turning.sqrt()],
                across: Matrix6::identity(),
                joint: Matrix6::zeros(),
                springs: [[0.0; 2]; 6],
            }
        });
        Self { bodies: bodies.collect() }
    }

    /// Stiffness and damping of the free velocities of each body's joint.
    pub fn springs(&self) -> impl Iterator<Item = &[[f64; 2]; 6]> {
        self.bodies.iter().map(|body| &body.springs)
    }

    /// Takes over the pose of the joints and the inertia of the bodies.
    pub fn load(&mut self, model: &MultibodyModel, edges: &[JointKinematics], bodies: &[BodyWorkspace]) {
        for (i, body) in model.bodies.iter().enumerate() {
            let (edge, pose) = (&edges[i], &mut self.bodies[i]);
            let (inertia, coupling) = bodies[i].inertia();
            pose.rigid = Matrix6::from_fn(|r, c| inertia[r.max(c)][r.min(c)]);
            body.modes.columns(coupling, &mut pose.coupling);
            if let Some(p) = body.joint.parent.body {
                model.bodies[p].modes.columns(&edge.parent_columns, &mut pose.parent);
            }
            let lever = edge.lever.cross_matrix().transpose();
            pose.across.fixed_view_mut::<3, 3>(0, 0).copy_from(&edge.turn);
            pose.across.fixed_view_mut::<3, 3>(0, 3).copy_from(&(edge.turn * lever));
            pose.across.fixed_view_mut::<3, 3>(3, 3).copy_from(&edge.turn);
            let arm = edge.parent_point.arm.cross_matrix().transpose();
            pose.at_parent.fixed_view_mut::<3, 3>(0, 3).copy_from(&arm);
            for (j, column) in edge.columns.iter().enumerate().take(body.layout.n_velocities) {
                pose.joint.column_mut(j).copy_from_slice(column);
            }
            if !body.joint.coordinates.is_empty() {
                let JointCoordinates { positions, velocities, .. } = &edge.coordinates;
                let tangent = joint_tangent(body.joint.kind, &body.joint.coordinates, positions, velocities);
                for (spring, k) in pose.springs.iter_mut().zip(body.joint.free_velocities()) {
                    *spring = tangent[k];
                }
            }
            if let Some(bearing) = &body.joint.bearing {
                let damping = bearing.damping(&edge.coordinates.velocities, edge.bearing_load);
                for (spring, k) in pose.springs.iter_mut().zip(body.joint.free_velocities()) {
                    let others = if body.joint.coordinates.is_empty() { [0.0; 2] } else { *spring };
                    *spring = [others[0], others[1] + damping[k]];
                }
            }
            pose.bias = Vector6::from(edge.bias);
            pose.parent_bias = Vector6::from(edge.parent_bias);
            if !pose.own.is_empty() {
                // At the marker the modes' displacements and turns have little to do with each
                // other, at a frame far off they have.
                let arm = edge.child_point.arm.cross_matrix();
                pose.at_own.fixed_view_mut::<3, 3>(0, 3).copy_from(&-arm);
                pose.across = product(&pose.at_own, &pose.across);
                pose.joint = product(&pose.at_own, &pose.joint);
                pose.bias = applied(&pose.at_own, &pose.bias);
                body.modes.columns(&edge.marker_columns, &mut pose.own);
            }
        }
    }
}
