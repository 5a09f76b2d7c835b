//! Motion of one body seen from another, in the components of their common model.

use crate::search::way_between;
use crate::solver_fault::SolverFault;
use ffr_dynamics::body::RigidMotion;
use ffr_dynamics::error::EvaluationFailure;
use ffr_dynamics::force::BodyState;
use nalgebra::{UnitQuaternion, Vector3};

/// Largest part of an axis across the directions that an axisymmetric or plane model can move in.
const AXIS_TOLERANCE: f64 = 1e-9;

/// Where a body stands in the frame of another: `x' = Q x + d`.
#[derive(Debug, Clone, Copy)]
pub(super) struct RelativePose {
    n_components: usize,
    /// Rows of `Q`.
    rotation: [[f64; 3]; 3],
    offset: [f64; 3],
}

impl RelativePose {
    /// The body at `from` in the frame of the body at `to`.
    pub fn new(motion: RigidMotion, from: &BodyState, to: &BodyState) -> Result<Self, EvaluationFailure> {
        let distance = way_between(motion, [&to.position, &from.position]).map_err(SolverFault::Apart)?;
        if motion != RigidMotion::Spatial {
            for state in [from, to] {
                check_axis(motion, &state.rotation)?;
            }
        }
        let n_components = motion.n_components();
        let relative = (to.rotation.inverse() * from.rotation).to_rotation_matrix();
        let local = to.rotation.inverse_transform_vector(&distance);
        let (mut rotation, mut offset) = ([[0.0; 3]; 3], [0.0; 3]);
        if motion == RigidMotion::Axial {
            // Rings: a turn of half a revolution flips the axis and keeps the radius.
            rotation[0][0] = 1.0;
            rotation[1][1] = relative[(2, 2)].signum();
            offset[1] = axis_sign(&to.rotation) * distance.z;
        } else {
            for a in 0..n_components {
                (0..n_components).for_each(|b| rotation[a][b] = relative[(a, b)]);
                offset[a] = local[a];
            }
        }
        Ok(Self { n_components, rotation, offset })
    }

    /// A point in the other frame.
    pub fn transform_point(&self, x: &[f64; 3]) -> [f64; 3] {
        let mut out = self.offset;
        for (row, slot) in self.rotation.iter().zip(&mut out) {
            *slot += row[0] * x[0] + row[1] * x[1] + row[2] * x[2];
        }
        out
    }

    /// A vector in the other frame.
    pub fn transform_vector(&self, v: &[f64; 3]) -> [f64; 3] {
        self.rotation.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
    }

    /// A vector of the other frame in the body's own.
    pub fn inverse_transform_vector(&self, v: &[f64; 3]) -> [f64; 3] {
        [0, 1, 2].map(|b| (0..self.n_components).map(|a| self.rotation[a][b] * v[a]).sum())
    }

    /// Largest distance of the two frames' origins along a component.
    pub fn largest_offset(&self) -> f64 {
        self.offset.iter().fold(0.0, |m, x| x.abs().max(m))
    }
}

/// +1 or -1 along the inertial axis z.
fn axis_sign(rotation: &UnitQuaternion<f64>) -> f64 {
    (rotation * Vector3::z()).z.signum()
}

/// The axis z must stay parallel to itself.
fn check_axis(motion: RigidMotion, rotation: &UnitQuaternion<f64>) -> Result<(), EvaluationFailure> {
    let axis = rotation * Vector3::z();
    let across = axis.x.hypot(axis.y);
    // Asked this way round, a NaN fails.
    if across < AXIS_TOLERANCE {
        return Ok(());
    }
    let body = if motion == RigidMotion::Axial { "an axisymmetric" } else { "a plane" };
    Err(SolverFault::Tilted { body, tilt: across }.into())
}

/// Components of a vector of the model as a vector in space; a ring's radial part has no direction
/// and is dropped.
pub(super) fn resultant(
    motion: RigidMotion,
    rotation: &UnitQuaternion<f64>,
    components: &[f64; 3],
) -> Vector3<f64> {
    match motion {
        RigidMotion::Axial => Vector3::new(0.0, 0.0, axis_sign(rotation) * components[1]),
        _ => rotation * Vector3::from(*components),
    }
}

/// A unit vector of the model in space. That of a ring is its axial part, as a direction of the
/// resultant.
pub(super) fn direction(
    motion: RigidMotion,
    rotation: &UnitQuaternion<f64>,
    components: &[f64; 3],
) -> Vector3<f64> {
    match motion {
        RigidMotion::Axial => Vector3::new(0.0, 0.0, (axis_sign(rotation) * components[1]).signum()),
        _ => rotation * Vector3::from(*components),
    }
}
