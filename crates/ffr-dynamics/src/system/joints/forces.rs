//! Springs, dampers, drives and prescribed motion along joint coordinates (docs/theory.md Eq. M.10).

use std::fmt;
use std::sync::Arc;

use nalgebra::Vector3;

use super::kind::JointKind;
use crate::error::DynamicsError;
use crate::joint_fault::JointFault;
use crate::kinematics::rotation::rotation_from_slice;

/// A quantity given over time, with its first and second derivative.
#[derive(Clone)]
pub struct TimeFunction(Arc<dyn Fn(f64) -> [f64; 3] + Send + Sync>);

impl TimeFunction {
    /// From a function of time that returns value, first and second derivative. Must not allocate.
    pub fn new(function: impl Fn(f64) -> [f64; 3] + Send + Sync + 'static) -> Self {
        Self(Arc::new(function))
    }

    /// A constant.
    pub fn constant(value: f64) -> Self {
        Self::new(move |_| [value, 0.0, 0.0])
    }

    /// Value, first and second derivative at time `t`.
    pub fn at(&self, t: f64) -> [f64; 3] {
        (self.0)(t)
    }
}

impl fmt::Debug for TimeFunction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("TimeFunction")
    }
}

/// What acts along one velocity of a joint. Forces are in N for translations, N m for rotations.
///
/// Of a quaternion's three velocities the springs must be alike, without a rest position: the spring pulls along the rotation vector.
#[derive(Debug, Clone, Default)]
pub struct CoordinateForce {
    /// Spring stiffness, not negative [N/m or N m/rad].
    pub stiffness: f64,
    /// Coordinate at which the spring is relaxed [m or rad].
    pub rest: f64,
    /// Damping, not negative [N s/m or N m s/rad].
    pub damping: f64,
    /// Force of a drive over time; its derivatives are not used.
    pub drive: Option<TimeFunction>,
    /// Motion of the coordinate over time; it is no unknown then.
    pub motion: Option<TimeFunction>,
}

/// Forces along the velocities of a joint at one instant.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct JointForces {
    /// Spring and damper.
    pub passive: [f64; 6],
    /// Drive.
    pub drive: [f64; 6],
    /// Power lost in dampers \[W\].
    pub dissipated: f64,
}

/// Forces of a joint's springs, dampers and drives (Eq. M.10).
pub(crate) fn joint_forces(
    kind: JointKind,
    coordinates: &[CoordinateForce],
    t: f64,
    positions: &[f64],
    velocities: &[f64],
) -> JointForces {
    let mut forces = JointForces::default();
    for (k, (force, u)) in coordinates.iter().zip(velocities).enumerate() {
        forces.passive[k] = -force.stiffness * extension(kind, force, positions, k) - force.damping * u;
        forces.dissipated += force.damping * u * u;
        forces.drive[k] = force.drive.as_ref().map_or(0.0, |f| f.at(t)[0]);
    }
    forces
}

/// Energy in a joint's springs \[J\].
pub(crate) fn joint_energy(kind: JointKind, coordinates: &[CoordinateForce], positions: &[f64]) -> f64 {
    let energy = |(k, force): (usize, &CoordinateForce)| {
        0.5 * force.stiffness * extension(kind, force, positions, k).powi(2)
    };
    coordinates.iter().enumerate().map(energy).sum()
}

/// Extension of the spring along velocity `k`.
fn extension(kind: JointKind, force: &CoordinateForce, positions: &[f64], k: usize) -> f64 {
    if force.stiffness <= 0.0 {
        return 0.0;
    }
    match kind.quaternion() {
        Some(w) if k >= w => {
            let vector: Vector3<f64> = rotation_from_slice(&positions[w..w + 4]).scaled_axis();
            vector[k - w]
        }
        _ => positions[k] - force.rest,
    }
}

/// Refuses coordinates that the joint does not have, and negative or unlike constants.
pub(crate) fn check(
    joint: &str,
    kind: JointKind,
    coordinates: &[CoordinateForce],
) -> Result<(), DynamicsError> {
    let fail =
        |fault: JointFault| Err(DynamicsError::Joint { joint: joint.to_string(), fault: Box::new(fault) });
    let n = kind.n_velocities();
    if !coordinates.is_empty() && coordinates.len() != n {
        let found = coordinates.len();
        return fail(JointFault::ForceCount { found, kind: kind.name(), expected: n });
    }
    for (k, c) in coordinates.iter().enumerate() {
        let is_sound = |x: f64| x >= 0.0 && x.is_finite();
        if !is_sound(c.stiffness) || !is_sound(c.damping) || !c.rest.is_finite() {
            let CoordinateForce { stiffness, damping, rest, .. } = *c;
            return fail(JointFault::Constants { coordinate: k + 1, stiffness, damping, rest });
        }
        if kind.quaternion().is_some_and(|w| k >= w) {
            let first = &coordinates[kind.quaternion().unwrap_or(0)];
            if c.stiffness.to_bits() != first.stiffness.to_bits() || c.rest != 0.0 {
                return fail(JointFault::UnlikeSprings);
            }
        }
        if c.motion.is_some() && kind.quaternion().is_some() {
            return fail(JointFault::Prescribed { kind: kind.name() });
        }
    }
    Ok(())
}
