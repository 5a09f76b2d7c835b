//! Springs, dampers, stops, friction, drives and prescribed motion along joint coordinates
//! (docs/theory.md Eq. M.14 to M.16, M.22).

use std::fmt;
use std::sync::Arc;

use nalgebra::Vector3;

use super::kind::JointKind;
use crate::error::DynamicsError;
use crate::rotation::rotation_from_slice;

/// A quantity given over time.
pub trait TimeCourse: Send + Sync {
    /// Value, first and second derivative at time `t`; at a break those behind it. Must not
    /// allocate.
    fn at(&self, t: f64) -> [f64; 3];

    /// The next time after `t` at which the quantity or a low derivative of it jumps \[s\].
    fn next_break(&self, _t: f64) -> f64 {
        f64::INFINITY
    }

    /// Longest step from time `t` that resolves the quantity between its breaks \[s\].
    fn longest_step(&self, _t: f64) -> f64 {
        f64::INFINITY
    }
}

/// A smooth function that steps need not resolve.
struct Smooth<F>(F);

impl<F: Fn(f64) -> [f64; 3] + Send + Sync> TimeCourse for Smooth<F> {
    fn at(&self, t: f64) -> [f64; 3] {
        self.0(t)
    }
}

/// A quantity given over time, with its first and second derivative.
#[derive(Clone)]
pub struct TimeFunction(Arc<dyn TimeCourse>);

impl TimeFunction {
    /// From a smooth function of time that returns value, first and second derivative, and changes
    /// no faster than the motion. Must not allocate.
    pub fn new(function: impl Fn(f64) -> [f64; 3] + Send + Sync + 'static) -> Self {
        Self::with_course(Smooth(function))
    }

    /// From a course that knows its breaks and its pace.
    pub fn with_course(course: impl TimeCourse + 'static) -> Self {
        Self(Arc::new(course))
    }

    /// A constant.
    pub fn constant(value: f64) -> Self {
        Self::new(move |_| [value, 0.0, 0.0])
    }

    /// Value, first and second derivative at time `t`.
    pub fn at(&self, t: f64) -> [f64; 3] {
        self.0.at(t)
    }

    /// The next time after `t` at which the quantity is not smooth \[s\].
    pub fn next_break(&self, t: f64) -> f64 {
        self.0.next_break(t)
    }

    /// Longest step from time `t` that resolves it \[s\].
    pub fn longest_step(&self, t: f64) -> f64 {
        self.0.longest_step(t)
    }
}

impl fmt::Debug for TimeFunction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("TimeFunction")
    }
}

/// What acts along one velocity of a joint. Forces are in N for translations, N m for rotations.
///
/// Of a quaternion's three velocities the springs must be alike, without a rest position: the
/// spring pulls along the rotation vector.
#[derive(Debug, Clone, Default)]
pub struct CoordinateForce {
    /// Spring stiffness, not negative [N/m or N m/rad].
    pub stiffness: f64,
    /// Coordinate at which the spring is relaxed [m or rad].
    pub rest: f64,
    /// Damping, not negative [N s/m or N m s/rad].
    pub damping: f64,
    /// Ends of the travel.
    pub stop: Option<Stop>,
    /// Dry friction.
    pub friction: Option<Friction>,
    /// Force of a drive over time; its derivatives are not used.
    pub drive: Option<TimeFunction>,
    /// Motion of the coordinate over time; it is no unknown then.
    pub motion: Option<TimeFunction>,
}

/// Ends of a coordinate's travel: one-sided springs with the damping of Hunt and Crossley, which
/// vanishes with the compression, so that the force sets in and ends at zero (Eq. M.15).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stop {
    /// Least coordinate that is reached without compression [m or rad]; may be -∞.
    pub lower: f64,
    /// Largest [m or rad]; may be ∞.
    pub upper: f64,
    /// Stiffness, positive [N/m or N m/rad].
    pub stiffness: f64,
    /// Damping as a share of the spring's force per velocity, not negative [s/m or s/rad].
    pub damping: f64,
}

/// Dry friction of given size (Coulomb), smooth about zero velocity (Eq. M.16).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Friction {
    /// Force or moment of sliding, not negative [N or N m].
    pub force: f64,
    /// Velocity at which 1/√2 of it is reached, positive [m/s or rad/s].
    pub velocity: f64,
}

impl Stop {
    /// Compression and the direction of its force; zero between the ends.
    fn compression(&self, position: f64) -> (f64, f64) {
        if position < self.lower {
            (self.lower - position, 1.0)
        } else if position > self.upper {
            (position - self.upper, -1.0)
        } else {
            (0.0, 0.0)
        }
    }

    /// Force along the coordinate, and the power that its damping takes \[W\].
    pub(crate) fn force(&self, position: f64, velocity: f64) -> (f64, f64) {
        let (compression, direction) = self.compression(position);
        let rate = -direction * velocity;
        let spring = self.stiffness * compression;
        // A stop does not pull.
        let force = spring * (1.0 + self.damping * rate).max(0.0);
        (direction * force, (force - spring) * rate)
    }

    /// Stiffness and damping of small changes.
    pub(crate) fn tangent(&self, position: f64, velocity: f64) -> [f64; 2] {
        let (compression, direction) = self.compression(position);
        let growth = 1.0 - self.damping * direction * velocity;
        if growth <= 0.0 || direction == 0.0 {
            return [0.0; 2];
        }
        [self.stiffness * growth, self.stiffness * self.damping * compression]
    }

    fn energy(&self, position: f64) -> f64 {
        0.5 * self.stiffness * self.compression(position).0.powi(2)
    }
}

impl Friction {
    /// Force per velocity at a speed whose square is given [N s/m or N m s/rad].
    fn resistance(&self, speed_squared: f64) -> f64 {
        self.force / (speed_squared + self.velocity * self.velocity).sqrt()
    }
}

/// Forces along the velocities of a joint at one instant.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct JointForces {
    /// Spring, damper, stop and friction.
    pub passive: [f64; 6],
    /// Drive.
    pub drive: [f64; 6],
    /// Power lost in dampers, stops and friction \[W\].
    pub dissipated: f64,
}

/// Forces of a joint's springs, dampers, stops, friction and drives (Eq. M.14 to M.16).
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
        if let Some(stop) = &force.stop {
            let (push, lost) = stop.force(positions[k], *u);
            forces.passive[k] += push;
            forces.dissipated += lost;
        }
        if let Some(friction) = &force.friction {
            let resistance = friction.resistance(sliding_squared(kind, velocities, k));
            forces.passive[k] -= resistance * u;
            forces.dissipated += resistance * u * u;
        }
        forces.drive[k] = force.drive.as_ref().map_or(0.0, |f| f.at(t)[0]);
    }
    forces
}

/// Square of the speed that friction along velocity `k` belongs to: that of the whole rotation if
/// it is one about a point.
fn sliding_squared(kind: JointKind, velocities: &[f64], k: usize) -> f64 {
    match kind.quaternion() {
        Some(w) if k >= w => velocities[w..w + 3].iter().map(|u| u * u).sum(),
        _ => velocities[k] * velocities[k],
    }
}

/// Stiffness and damping of a joint's velocities for small motions about the present one;
/// coordinates that friction or the spring of a quaternion couples count for themselves.
pub(crate) fn joint_tangent(
    kind: JointKind,
    coordinates: &[CoordinateForce],
    positions: &[f64],
    velocities: &[f64],
) -> [[f64; 2]; 6] {
    let mut tangent = [[0.0; 2]; 6];
    for (k, (force, u)) in coordinates.iter().zip(velocities).enumerate() {
        tangent[k] = [force.stiffness, force.damping];
        if let Some(stop) = &force.stop {
            let [stiffness, damping] = stop.tangent(positions[k], *u);
            tangent[k][0] += stiffness;
            tangent[k][1] += damping;
        }
        if let Some(friction) = &force.friction {
            let squared = sliding_squared(kind, velocities, k);
            let whole = squared + friction.velocity * friction.velocity;
            tangent[k][1] += friction.resistance(squared) * (1.0 - u * u / whole);
        }
    }
    tangent
}

/// Energy in a joint's springs and stops \[J\].
pub(crate) fn joint_energy(kind: JointKind, coordinates: &[CoordinateForce], positions: &[f64]) -> f64 {
    let energy = |(k, force): (usize, &CoordinateForce)| {
        let stop = force.stop.as_ref().map_or(0.0, |stop| stop.energy(positions[k]));
        0.5 * force.stiffness * extension(kind, force, positions, k).powi(2) + stop
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

/// Refuses coordinates that the joint does not have, negative or unlike constants, and stops of
/// rotations about a point.
pub(crate) fn check(
    joint: &str,
    kind: JointKind,
    coordinates: &[CoordinateForce],
) -> Result<(), DynamicsError> {
    let fail = |fault: String| Err(DynamicsError::Joint { joint: joint.to_string(), fault });
    let n = kind.n_velocities();
    if !coordinates.is_empty() && coordinates.len() != n {
        let found = coordinates.len();
        return fail(format!("forces along {found} coordinates, a {} joint has {n}", kind.name()));
    }
    for (k, c) in coordinates.iter().enumerate() {
        let is_sound = |x: f64| x >= 0.0 && x.is_finite();
        if !is_sound(c.stiffness) || !is_sound(c.damping) || !c.rest.is_finite() {
            let CoordinateForce { stiffness, damping, rest, .. } = *c;
            return fail(format!(
                "coordinate {}: stiffness {stiffness} and damping {damping} must be >= 0, rest position {rest} finite",
                k + 1
            ));
        }
        if let Some(stop) = &c.stop {
            let Stop { lower, upper, stiffness, damping } = *stop;
            let has_room = lower < upper && stiffness > 0.0 && stiffness.is_finite() && is_sound(damping);
            if !has_room || kind.quaternion().is_some_and(|w| k >= w) {
                return fail(format!(
                    "coordinate {coordinate}: a stop from {lower} to {upper} with stiffness {stiffness} and damping {damping} needs lower < upper, \
         stiffness > 0, damping >= 0, and no rotation about a point",
                    coordinate = k + 1
                ));
            }
        }
        if let Some(Friction { force, velocity }) = c.friction
            && !(is_sound(force) && is_sound(velocity) && velocity > 0.0)
        {
            return fail(format!(
                "coordinate {}: friction {force} must be >= 0, its velocity {velocity} > 0",
                k + 1
            ));
        }
        if kind.quaternion().is_some_and(|w| k >= w) {
            let first = &coordinates[kind.quaternion().unwrap_or(0)];
            if c.stiffness.to_bits() != first.stiffness.to_bits() || c.rest != 0.0 {
                return fail("springs about the three axes must be alike, with the rest position 0".into());
            }
            if c.friction != first.friction {
                return fail("friction about the three axes must be alike".into());
            }
        }
        if c.motion.is_some() && kind.quaternion().is_some() {
            return fail(format!("the motion of a {} joint cannot be prescribed", kind.name()));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::{CoordinateForce, Friction, Stop, joint_forces, joint_tangent};
    use crate::system::joints::JointKind;

    #[test]
    fn tangent_is_the_derivative_of_the_forces() {
        let stop = Some(Stop { lower: -0.2, upper: 0.1, stiffness: 3e3, damping: 0.7 });
        let friction = Some(Friction { force: 5.0, velocity: 0.3 });
        let one = CoordinateForce { stiffness: 40.0, damping: 2.0, stop, friction, ..Default::default() };
        let coordinates = [one.clone(), one];
        let step = 1e-4;
        // Below, between, above; the last leaves its stop faster than the damping lets the force
        // follow.
        for (x, u) in [(-0.3, 0.4), (-0.25, -0.6), (0.0, 0.2), (0.15, 0.5), (0.2, -0.4), (0.2, -2.0)] {
            let force = |dx: f64, du: f64| {
                let (positions, velocities) = ([x + dx, -x], [u + du, 0.1]);
                joint_forces(JointKind::Cylindrical, &coordinates, 0.0, &positions, &velocities).passive[0]
            };
            let tangent = joint_tangent(JointKind::Cylindrical, &coordinates, &[x, -x], &[u, 0.1])[0];
            let differences = [
                (force(-step, 0.0) - force(step, 0.0)) / (2.0 * step),
                (force(0.0, -step) - force(0.0, step)) / (2.0 * step),
            ];
            for (exact, difference) in tangent.iter().zip(differences) {
                // Friction bends over 0.3 m/s: the third derivative, some 5 / 0.3³, times the
                // square of the step.
                assert!((exact - difference).abs() < 1e-5 * (1.0 + exact.abs()), "{exact} {difference}");
            }
        }
    }
}
