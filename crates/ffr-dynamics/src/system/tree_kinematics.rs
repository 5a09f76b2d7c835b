//! Motion of all bodies from joint and elastic coordinates (docs/theory.md Eq. M.11 to M.13).
//!
//! Spatial vectors hold a translation of the frame's origin, then a rotation, in the body's axes. What concerns the parent's
//! marker is expressed in the parent's axes as well (inertial axes for ground), so that no marker axes are needed.

use nalgebra::{Matrix3, UnitQuaternion, Vector3};

use super::equations::dot;
use super::force::BodyState;
use super::joints::JointPoint;
use super::model::{JointCoordinates, MultibodyModel, TreeBody};
use crate::kinematics::{Marker, MarkerMotion};

/// Spatial vector of a frame: a translation of its origin, then a rotation (velocity, acceleration); a force, then a moment.
pub(super) type SpatialVector = [f64; 6];

/// Kinematics of the joint between a body and its parent at one instant: the edge of the tree from the one to the other.
#[derive(Debug, Clone)]
pub(super) struct JointKinematics {
    /// Joint coordinates.
    pub coordinates: JointCoordinates,
    /// Parent's marker in the parent's frame.
    pub parent_point: MarkerMotion,
    /// Child's marker in the body's frame.
    pub child_point: MarkerMotion,
    /// Rotation from the parent's axes to the body's axes.
    pub turn: Matrix3<f64>,
    /// From the parent's marker to the origin of the body's frame, in the parent's axes \[m\].
    pub lever: Vector3<f64>,
    /// What the joint's velocities do to the child's marker: its displacement relative to the parent's marker, in the
    /// parent's axes.
    pub joint: JointPoint,
    /// What each free velocity of the joint does to the body's frame, in the body's axes.
    pub columns: [SpatialVector; 6],
    /// Elastic rows of the body's frame when the child's marker is held (6 x n_q, row by row); empty if it is still.
    pub elastic_rows: Vec<f64>,
    /// Elastic rows of the parent's marker (6 x n_q of the parent); empty if it does not feel the deformation.
    pub parent_rows: Vec<f64>,
    /// Acceleration of the body's frame without any acceleration of the parent's marker, joint or modes.
    pub bias: SpatialVector,
    /// Acceleration of the parent's marker without any acceleration of the parent's frame or modes.
    pub parent_bias: SpatialVector,
}

/// Motion of ground.
fn ground_state() -> BodyState {
    BodyState::at_rest(0)
}

impl JointKinematics {
    /// Buffers for the joint of `body`; `n_parent` counts the elastic coordinates of its parent.
    pub fn new(body: &TreeBody, n_parent: usize) -> Self {
        let has_parent_rows = body.joint.parent.marker.n_modes() > 0;
        let has_elastic_rows = !body.joint.child.is_still();
        let still = body.joint.child.motion(&[], &[]);
        Self {
            coordinates: JointCoordinates::default(),
            parent_point: still,
            child_point: still,
            turn: Matrix3::identity(),
            lever: Vector3::zeros(),
            joint: JointPoint::default(),
            columns: [[0.0; 6]; 6],
            elastic_rows: if has_elastic_rows { vec![0.0; 6 * body.layout.n_modes] } else { Vec::new() },
            parent_rows: if has_parent_rows { vec![0.0; 6 * n_parent] } else { Vec::new() },
            bias: [0.0; 6],
            parent_bias: [0.0; 6],
        }
    }
}

/// Motions of all bodies at time `t` in the state `y`, with all that couples neighbours (Eq. M.11 to M.13).
pub(super) fn update(
    model: &MultibodyModel,
    t: f64,
    y: &[f64],
    states: &mut [BodyState],
    edges: &mut [JointKinematics],
) {
    for &i in &model.order {
        let body = &model.bodies[i];
        states[i].elastic.copy_from_slice(&y[body.layout.elastic()]);
        states[i].elastic_rates.copy_from_slice(&y[body.layout.elastic_rates()]);
        let edge = &mut edges[i];
        edge.coordinates = model.joint_coordinates(i, t, y);
        match body.joint.parent.body {
            None => move_body(body, &ground_state(), &mut states[i], edge),
            Some(p) => {
                // Parent and child are different entries.
                let [parent, child] = states
                    .get_disjoint_mut([p, i])
                    .expect("a body is not its own parent: cycles are refused");
                move_body(body, parent, child, edge);
            }
        }
    }
}

/// Motion of one body from that of its parent.
fn move_body(body: &TreeBody, parent: &BodyState, state: &mut BodyState, edge: &mut JointKinematics) {
    let joint = &body.joint;
    let p = joint.parent.marker.motion(&parent.elastic, &parent.elastic_rates);
    let c = joint.child.motion(&state.elastic, &state.elastic_rates);
    let relative = joint.kind.motion(&edge.coordinates.positions, &edge.coordinates.velocities);
    let joint_point = JointPoint::new(&relative, &p.rotation, joint.kind.n_velocities());
    let d = &joint_point.displacement;
    // Pose.
    let parent_from_body: UnitQuaternion<f64> = p.rotation * relative.rotation * c.rotation.inverse();
    state.rotation = parent.rotation * parent_from_body;
    let turn: Matrix3<f64> = parent_from_body.inverse().to_rotation_matrix().into_inner();
    let lever = d - turn.tr_mul(&c.arm);
    state.position = parent.position + parent.rotation * (p.arm + lever);
    // Velocity: of the parent's marker, of the child's marker, of the frame.
    let omega_parent = &parent.angular_velocity_in_body;
    let omega_p = omega_parent + p.turn.spin;
    let v_p =
        parent.rotation.inverse_transform_vector(&parent.velocity) + omega_parent.cross(&p.arm) + p.arm_rate;
    let v_c = v_p + omega_p.cross(d) + joint_point.velocity;
    let omega_c = omega_p + joint_point.angular_velocity;
    let omega = turn * omega_c - c.turn.spin;
    let v = turn * v_c - omega.cross(&c.arm) - c.arm_rate;
    state.angular_velocity_in_body = omega;
    state.velocity = state.rotation * v;
    // Accelerations that velocities alone cause.
    edge.parent_bias = join(
        &(omega_parent.cross(&omega_parent.cross(&p.arm)) + 2.0 * omega_parent.cross(&p.arm_rate)),
        &(omega_parent.cross(&p.turn.spin) + p.turn.bias),
    );
    let (mut driven, mut driven_turn) = (Vector3::zeros(), joint_point.bias);
    for (column, a) in joint_point.columns.iter().zip(edge.coordinates.accelerations) {
        driven += column.translation * a;
        driven_turn += column.rotation * a;
    }
    let marker_turn = turn * (omega_p.cross(&joint_point.angular_velocity) + driven_turn);
    let marker = turn * (omega_p.cross(&(omega_p.cross(d) + 2.0 * joint_point.velocity)) + driven);
    let bias_turn = marker_turn - omega.cross(&c.turn.spin) - c.turn.bias;
    let bias = marker - bias_turn.cross(&c.arm) - omega.cross(&(omega.cross(&c.arm) + 2.0 * c.arm_rate));
    edge.bias = join(&bias, &bias_turn);
    // Linear relations.
    for (column, k) in edge.columns.iter_mut().zip(joint.free_velocities()) {
        let JointPoint { columns, .. } = &joint_point;
        let moved = columns[k].translation + columns[k].rotation.cross(&(lever - d));
        *column = join(&(turn * moved), &(turn * columns[k].rotation));
    }
    fill_rows(&joint.child, &c, &mut edge.elastic_rows);
    hold_marker(&c.arm, &mut edge.elastic_rows);
    fill_rows(&joint.parent.marker, &p, &mut edge.parent_rows);
    edge.parent_point = p;
    edge.child_point = c;
    edge.turn = turn;
    edge.lever = lever;
    edge.joint = joint_point;
}

/// Rows of displacement `Φ` and angular velocity `J Ψ` of a marker.
fn fill_rows(marker: &Marker, motion: &MarkerMotion, rows: &mut [f64]) {
    if rows.is_empty() {
        return;
    }
    let n = marker.n_modes();
    let jacobian = &motion.turn.jacobian;
    for c in 0..3 {
        rows[c * n..(c + 1) * n].copy_from_slice(marker.displacement_row(c));
        let row = &mut rows[(3 + c) * n..(4 + c) * n];
        let (x, y, z) = (marker.rotation_row(0), marker.rotation_row(1), marker.rotation_row(2));
        let (a, b, e) = (jacobian[(c, 0)], jacobian[(c, 1)], jacobian[(c, 2)]);
        for (r, ((x, y), z)) in row.iter_mut().zip(x.iter().zip(y).zip(z)) {
            *r = a * x + b * y + e * z;
        }
    }
}

/// Turns the rows of a marker into those of the frame when the marker is held: `(-Φ + Θ × arm, -Θ)`.
fn hold_marker(arm: &Vector3<f64>, rows: &mut [f64]) {
    let n = rows.len() / 6;
    for j in 0..n {
        let u = Vector3::new(rows[j], rows[n + j], rows[2 * n + j]);
        let turn = Vector3::new(rows[3 * n + j], rows[4 * n + j], rows[5 * n + j]);
        let moved = turn.cross(arm) - u;
        for c in 0..3 {
            rows[c * n + j] = moved[c];
            rows[(3 + c) * n + j] = -turn[c];
        }
    }
}

impl JointKinematics {
    /// Velocity (or acceleration without bias) of the parent's marker from that of the parent's frame and its elastic rates.
    pub fn at_parent_marker(&self, frame: &SpatialVector, elastic_rates: &[f64]) -> SpatialVector {
        let mut at = self.at_parent_marker_of_frame(frame);
        let n = elastic_rates.len();
        if !self.parent_rows.is_empty() {
            for (x, row) in at.iter_mut().zip(self.parent_rows.chunks_exact(n)) {
                *x += dot(row, elastic_rates);
            }
        }
        at
    }

    /// Velocity of the parent's marker from that of the parent's frame, without deformation.
    pub fn at_parent_marker_of_frame(&self, frame: &SpatialVector) -> SpatialVector {
        let (v, omega) = split(frame);
        join(&(v + omega.cross(&self.parent_point.arm)), &omega)
    }

    /// Velocity (or acceleration without bias) of the body's frame.
    pub fn at_frame(
        &self,
        marker: &SpatialVector,
        elastic_rates: &[f64],
        joint_velocities: &[f64],
    ) -> SpatialVector {
        let (v, omega) = split(marker);
        let mut at = join(&(self.turn * (v + omega.cross(&self.lever))), &(self.turn * omega));
        for (column, u) in self.columns.iter().zip(joint_velocities) {
            at.iter_mut().zip(column).for_each(|(x, c)| *x += c * u);
        }
        let n = elastic_rates.len();
        if !self.elastic_rows.is_empty() && n > 0 {
            for (x, row) in at.iter_mut().zip(self.elastic_rows.chunks_exact(n)) {
                *x += dot(row, elastic_rates);
            }
        }
        at
    }
}

/// Velocities of all frames, in body axes, from rates of all coordinates; prescribed motion is held (Eq. M.12).
pub(super) fn frame_velocities(
    model: &MultibodyModel,
    edges: &[JointKinematics],
    rates: &[f64],
    frames: &mut [SpatialVector],
) {
    for &i in &model.order {
        let TreeBody { joint, layout, .. } = &model.bodies[i];
        let marker = match joint.parent.body {
            None => [0.0; 6],
            Some(p) => edges[i].at_parent_marker(&frames[p], &rates[model.bodies[p].layout.rates_elastic()]),
        };
        frames[i] = edges[i].at_frame(&marker, &rates[layout.rates_elastic()], &rates[layout.rates_joint()]);
    }
}

/// A spatial vector from its halves.
pub(super) fn join(translation: &Vector3<f64>, rotation: &Vector3<f64>) -> SpatialVector {
    [translation.x, translation.y, translation.z, rotation.x, rotation.y, rotation.z]
}

/// Halves of a spatial vector.
pub(super) fn split(vector: &SpatialVector) -> (Vector3<f64>, Vector3<f64>) {
    (Vector3::new(vector[0], vector[1], vector[2]), Vector3::new(vector[3], vector[4], vector[5]))
}
