//! Motion of all bodies from joint and elastic coordinates (docs/theory.md Eq. M.25 to M.27).
//!
//! Spatial vectors hold a translation of the frame's origin, then a rotation, in the body's axes.
//! What concerns the parent's marker is expressed in the parent's axes as well (inertial axes for
//! ground), so that no marker axes are needed.

use nalgebra::{Matrix3, UnitQuaternion, Vector3};

use crate::force::BodyState;
use crate::kinematics::{Marker, MarkerMotion};
use crate::system::free_body::deformation::dot;
use crate::system::joints::JointPoint;
use crate::system::model::{JointCoordinates, MultibodyModel, TreeBody};

/// Spatial vector of a frame: a translation of its origin, then a rotation (velocity,
/// acceleration); a force, then a moment.
pub(in crate::system) type SpatialVector = [f64; 6];

/// Kinematics of the joint between a body and its parent at one instant: the edge of the tree from
/// the one to the other.
#[derive(Debug, Clone)]
pub(in crate::system) struct JointKinematics {
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
    /// What the joint's velocities do to the child's marker: its displacement relative to the
    /// parent's marker, in the parent's axes.
    pub joint: JointPoint,
    /// What each free velocity of the joint does to the body's frame, in the body's axes.
    pub columns: [SpatialVector; 6],
    /// What each elastic coordinate does to the child's marker; empty if that is still.
    pub marker_columns: Vec<SpatialVector>,
    /// What each elastic coordinate does to the body's frame when the child's marker is held; empty
    /// if that is still.
    pub elastic_columns: Vec<SpatialVector>,
    /// What each elastic coordinate of the parent does to the parent's marker; empty if that does
    /// not feel the deformation.
    pub parent_columns: Vec<SpatialVector>,
    /// Acceleration of the body's frame without any acceleration of the parent's marker, joint or
    /// modes.
    pub bias: SpatialVector,
    /// Acceleration of the parent's marker without any acceleration of the parent's frame or modes.
    pub parent_bias: SpatialVector,
    /// Load on the joint's bearing at the last accelerations [N or N m].
    pub bearing_load: f64,
}

/// Motion of ground.
fn ground_state() -> BodyState {
    BodyState::at_rest(0)
}

impl JointKinematics {
    /// Buffers for the joint of `body`; `n_parent` counts the elastic coordinates of its parent.
    pub fn new(body: &TreeBody, n_parent: usize) -> Self {
        let feels_parent_modes = body.joint.parent.marker.n_modes() > 0;
        let n_felt = if body.joint.child.is_still() { 0 } else { body.layout.n_modes };
        let still = body.joint.child.motion(&[], &[]);
        Self {
            coordinates: JointCoordinates::default(),
            parent_point: still,
            child_point: still,
            turn: Matrix3::identity(),
            lever: Vector3::zeros(),
            joint: JointPoint::default(),
            columns: [[0.0; 6]; 6],
            marker_columns: vec![[0.0; 6]; n_felt],
            elastic_columns: vec![[0.0; 6]; n_felt],
            parent_columns: vec![[0.0; 6]; if feels_parent_modes { n_parent } else { 0 }],
            bias: [0.0; 6],
            parent_bias: [0.0; 6],
            bearing_load: 0.0,
        }
    }
}

/// Motions of all bodies at time `t` in the state `y`, with all that couples neighbours (Eq. M.25
/// to M.27).
pub(in crate::system) fn update(
    model: &MultibodyModel,
    t: f64,
    y: &[f64],
    states: &mut [BodyState],
    edges: &mut [JointKinematics],
) {
    model.order.iter().for_each(|i| update_body(model, (t, y), *i, states, edges));
}

/// The same of body `i`, whose parent has its motion.
pub(in crate::system) fn update_body(
    model: &MultibodyModel,
    (t, y): (f64, &[f64]),
    i: usize,
    states: &mut [BodyState],
    edges: &mut [JointKinematics],
) {
    let body = &model.bodies[i];
    states[i].elastic.copy_from_slice(&y[body.layout.elastic()]);
    states[i].elastic_rates.copy_from_slice(&y[body.layout.elastic_rates()]);
    let edge = &mut edges[i];
    edge.coordinates = model.joint_coordinates(i, t, y);
    match body.joint.parent.body {
        None => move_body(body, &ground_state(), &mut states[i], edge),
        Some(p) => {
            // Parent and child are different entries.
            let [parent, child] =
                states.get_disjoint_mut([p, i]).expect("a body is not its own parent: cycles are refused");
            move_body(body, parent, child, edge);
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
    fill_columns(&joint.child, &c, &mut edge.marker_columns);
    hold_marker(&c.arm, &edge.marker_columns, &mut edge.elastic_columns);
    fill_columns(&joint.parent.marker, &p, &mut edge.parent_columns);
    edge.parent_point = p;
    edge.child_point = c;
    edge.turn = turn;
    edge.lever = lever;
    edge.joint = joint_point;
}

/// Columns of displacement `Φ` and angular velocity `J Ψ` of a marker.
fn fill_columns(marker: &Marker, motion: &MarkerMotion, columns: &mut [SpatialVector]) {
    if columns.is_empty() {
        return;
    }
    let jacobian = &motion.turn.jacobian;
    let displacement: [&[f64]; 3] = std::array::from_fn(|c| marker.displacement_row(c));
    let rotation: [&[f64]; 3] = std::array::from_fn(|c| marker.rotation_row(c));
    for (j, column) in columns.iter_mut().enumerate() {
        let turn = jacobian * Vector3::new(rotation[0][j], rotation[1][j], rotation[2][j]);
        *column = [displacement[0][j], displacement[1][j], displacement[2][j], turn.x, turn.y, turn.z];
    }
}

/// Columns of the frame when a marker with the columns `at_marker` is held: `(-Φ + Θ × arm, -Θ)`.
fn hold_marker(arm: &Vector3<f64>, at_marker: &[SpatialVector], of_frame: &mut [SpatialVector]) {
    for (column, at_marker) in of_frame.iter_mut().zip(at_marker) {
        let (moved, turn) = split(at_marker);
        *column = join(&(turn.cross(arm) - moved), &-turn);
    }
}

impl JointKinematics {
    /// Velocity (or acceleration without bias) of the parent's marker from that of the parent's
    /// frame and its elastic rates.
    pub fn at_parent_marker(&self, frame: &SpatialVector, elastic_rates: &[f64]) -> SpatialVector {
        let mut at = self.at_parent_marker_of_frame(frame);
        add_columns(&self.parent_columns, elastic_rates, &mut at);
        at
    }

    /// Velocity of the parent's marker from that of the parent's frame, without deformation.
    pub fn at_parent_marker_of_frame(&self, frame: &SpatialVector) -> SpatialVector {
        let (v, omega) = split(frame);
        join(&(v + omega.cross(&self.parent_point.arm)), &omega)
    }

    /// Adds a force at the parent's marker to the forces on the parent's frame and modes.
    pub fn add_at_parent(&self, force: &SpatialVector, frame: &mut SpatialVector, elastic: &mut [f64]) {
        let (f, m) = split(force);
        let at_frame = join(&f, &(m + self.parent_point.arm.cross(&f)));
        frame.iter_mut().zip(at_frame).for_each(|(sum, f)| *sum += f);
        for (sum, column) in elastic.iter_mut().zip(&self.parent_columns) {
            *sum += dot(column, force);
        }
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
        add_columns(&self.columns, joint_velocities, &mut at);
        add_columns(&self.elastic_columns, elastic_rates, &mut at);
        at
    }
}

/// Adds a combination of columns, as many as there are factors for.
fn add_columns(columns: &[SpatialVector], factors: &[f64], to: &mut SpatialVector) {
    for (column, factor) in columns.iter().zip(factors) {
        to.iter_mut().zip(column).for_each(|(x, c)| *x += c * factor);
    }
}

/// Velocities of all frames, in body axes, from rates of all coordinates; prescribed motion is held
/// (Eq. M.26).
pub(in crate::system) fn frame_velocities(
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
pub(in crate::system) fn join(translation: &Vector3<f64>, rotation: &Vector3<f64>) -> SpatialVector {
    [translation.x, translation.y, translation.z, rotation.x, rotation.y, rotation.z]
}

/// Halves of a spatial vector.
pub(in crate::system) fn split(vector: &SpatialVector) -> (Vector3<f64>, Vector3<f64>) {
    (Vector3::new(vector[0], vector[1], vector[2]), Vector3::new(vector[3], vector[4], vector[5]))
}
