//! Constraints of loop-closing joints and gears at one instant: residuals, directions,
//! accelerations by velocities alone, and how readily free bodies answer them (docs/theory.md
//! Eq. M.32, M.33, M.37).

use nalgebra::{Matrix3, Vector3};

use crate::force::BodyState;
use crate::kinematics::MarkerMotion;
use crate::system::model::gear::Gear;
use crate::system::model::tree_order::Parent;
use crate::system::model::{JointCoordinates, MultibodyModel, Site};
use crate::system::tree::kinematics::{JointKinematics, SpatialVector, split};
use crate::system::tree::solver::Answer;

/// One side of a loop joint at one instant, in inertial axes.
#[derive(Debug, Clone)]
pub(super) struct Side {
    pub place: Vector3<f64>,
    pub axes: Matrix3<f64>,
    /// From body axes to inertial axes.
    pub body_axes: Matrix3<f64>,
    pub velocity: Vector3<f64>,
    pub spin: Vector3<f64>,
    /// Accelerations by velocities alone, without those of the body's frame and modes.
    pub bias: (Vector3<f64>, Vector3<f64>),
    pub motion: MarkerMotion,
}

impl Side {
    /// The marker `site` of bodies in the motions `states`.
    pub fn new(site: &Site, states: &[BodyState]) -> Self {
        let ground = BodyState::at_rest(0);
        let state = site.body.map_or(&ground, |b| &states[b]);
        let motion = site.marker.motion(&state.elastic, &state.elastic_rates);
        let body_axes: Matrix3<f64> = state.rotation.to_rotation_matrix().into_inner();
        let omega = &state.angular_velocity_in_body;
        let MarkerMotion { arm, arm_rate, rotation, turn } = &motion;
        let bias = omega.cross(&(omega.cross(arm) + 2.0 * arm_rate));
        Self {
            place: state.position + body_axes * arm,
            axes: body_axes * rotation.to_rotation_matrix().into_inner(),
            velocity: state.velocity + body_axes * (omega.cross(arm) + arm_rate),
            spin: body_axes * (omega + turn.spin),
            bias: (body_axes * bias, body_axes * (omega.cross(&turn.spin) + turn.bias)),
            body_axes,
            motion,
        }
    }

    /// Velocity and angular velocity of the marker, in inertial axes, from those of its frame and
    /// its elastic rates.
    pub fn velocities(
        &self,
        site: &Site,
        frame: &SpatialVector,
        elastic: &[f64],
    ) -> (Vector3<f64>, Vector3<f64>) {
        let (v, omega) = split(frame);
        let combine = |row: &[f64]| row.iter().zip(elastic).map(|(r, q)| r * q).sum::<f64>();
        let moved = Vector3::from_fn(|c, _| combine(site.marker.displacement_row(c)));
        let turned = Vector3::from_fn(|c, _| combine(site.marker.rotation_row(c)));
        let local = v + omega.cross(&self.motion.arm) + moved;
        (self.body_axes * local, self.body_axes * (omega + self.motion.turn.jacobian * turned))
    }

    /// Adds a force and a moment at the marker to a response's forces.
    pub fn add(
        &self,
        site: &Site,
        model: &MultibodyModel,
        force: &Vector3<f64>,
        moment: &Vector3<f64>,
        to: &mut Answer<f64>,
    ) {
        let Some(b) = site.body else { return };
        let (f, m) = (self.body_axes.tr_mul(force), self.body_axes.tr_mul(moment));
        let torque = self.motion.arm.cross(&f) + m;
        for c in 0..3 {
            to.frame_forces[b][c] += f[c];
            to.frame_forces[b][3 + c] += torque[c];
        }
        let elastic = &mut to.forces[model.bodies[b].layout.rates_elastic()];
        site.marker.add_elastic(&f, &self.motion.turn.jacobian.tr_mul(&m), elastic);
    }
}

/// One constraint at one instant: residual, direction, and acceleration by velocities alone.
#[derive(Debug, Clone, Copy)]
pub(super) struct Row {
    pub joint: usize,
    /// Displacement \[m\] or cosine [-].
    pub residual: f64,
    /// Axis of the displacement, or of the rotation.
    pub axis: Vector3<f64>,
    pub is_rotation: bool,
    pub bias: f64,
}

/// The joint or gear that a constraint belongs to.
#[derive(Debug, Clone, Copy)]
pub(in crate::system) enum Owner {
    /// A joint that closes a loop.
    Loop {
        /// Number of the joint.
        joint: usize,
        /// Whether it holds a rotation.
        is_rotation: bool,
    },
    /// A gear.
    Gear {
        /// Number of the gear.
        gear: usize,
        /// Size of the rates of its coordinates.
        speed: f64,
    },
}

/// A gear at one instant.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct GearRow {
    /// Second coordinate less what the first makes of it [m or rad].
    pub residual: f64,
    /// Size of the coordinates, whose round-off the residual has; at least 1.
    pub size: f64,
    pub rate: f64,
    /// Size of the rates.
    pub speed: f64,
    /// Acceleration by prescribed motions.
    pub bias: f64,
}

impl GearRow {
    /// The gear `gear` between joints in the motions `edges`.
    pub fn new(gear: &Gear, edges: &[JointKinematics]) -> Self {
        let mut row = Self { residual: -gear.offset, size: 1.0, ..Self::default() };
        for (at, factor) in gear.terms() {
            let JointCoordinates { positions, velocities, accelerations } = &edges[at.body].coordinates;
            let (position, velocity) = (factor * positions[at.velocity], factor * velocities[at.velocity]);
            row.residual += position;
            row.size += position.abs();
            row.rate += velocity;
            row.speed += velocity.abs();
            row.bias += factor * accelerations[at.velocity]; // none of free coordinates
        }
        row
    }
}

/// Mobility of a displacement and of a rotation between the free, undeformed `bodies` [1/kg, 1/(kg
/// m²)].
pub(super) fn free_mobility(model: &MultibodyModel, bodies: [Parent; 2]) -> (f64, f64) {
    let (mut translation, mut rotation) = (0.0, 0.0);
    for body in bodies.into_iter().flatten() {
        let data = &model.bodies[body].data;
        translation += 1.0 / data.mass;
        let centre = data.centre_of_mass();
        let about_centre = data.inertia().trace() - 2.0 * data.mass * centre.norm_squared();
        rotation += 3.0 / about_centre;
    }
    // A point mass does not resist turning: the joint's rotation has no scale of its own.
    let is_sound = rotation.is_finite() && rotation > 0.0;
    (translation, if is_sound { rotation } else { f64::MAX.sqrt() })
}

/// Mobility of a gear between free bodies.
pub(super) fn gear_mobility(model: &MultibodyModel, gear: &Gear) -> f64 {
    let free = gear.terms().into_iter().filter(|(at, _)| at.rate.is_some());
    let mobility = free.map(|(at, factor)| {
        let joint = &model.bodies[at.body].joint;
        let (translation, rotation) = free_mobility(model, [joint.parent.body, Some(at.body)]);
        let is_angle = joint.kind.is_angle(at.velocity) && rotation < f64::MAX.sqrt();
        factor * factor * if is_angle { rotation } else { translation }
    });
    mobility.sum()
}
