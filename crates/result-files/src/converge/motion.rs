//! Motions of bodies at the end of a run.
//!
//! The frame of a body that is joined to a vibrating one rings with it, and its velocity at one
//! instant tells the phase of that ringing: of the rods of two double pendulums, 33 rad/s where
//! they swing at 4 rad/s. What is compared is the mean over a stretch of time, the way over the
//! time it takes.

use nalgebra::{Quaternion, UnitQuaternion, Vector3};

use crate::error::ResultError;
use crate::stored::Stored;

/// Length of the stretch as a share of the simulated time: motion hardly changes in a tenth of what
/// was thought worth simulating, vibrations that the run can be asked about have many periods in
/// it.
const STRETCH: f64 = 0.1;
/// Angle between two stored instants above which it is taken from angular velocities: beyond half a
/// turn, rotations have lost it \[rad\].
const LARGE_ANGLE: f64 = 1.0;

/// Motion of a body's reference frame at the end of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Motion {
    /// Name of the body.
    pub body: String,
    /// Mean velocity over the last stretch [m/s].
    pub velocity: [f64; 3],
    /// Mean angular velocity over the last stretch [rad/s].
    pub angular_velocity: [f64; 3],
    /// Largest speed of the whole run [m/s].
    pub fastest: f64,
    /// Largest mean angular speed over a stretch of the run [rad/s].
    pub fastest_turn: f64,
}

/// Motions at the end of the run in `stored`, in the order of names.
///
/// # Errors
/// [`ResultError::File`] if the result cannot be read.
pub fn motions(stored: &Stored) -> Result<Vec<Motion>, ResultError> {
    let names =
        stored.entries.keys().filter_map(|path| path.strip_prefix("bodies/")?.strip_suffix("/velocity"));
    let last_contact = stored.impacts.iter().map(|impact| impact.end).fold(f64::NEG_INFINITY, f64::max);
    names.map(|body| Ok(Course::read(stored, body)?.motion(body, last_contact))).collect()
}

/// Length of a vector.
pub fn length(v: &[f64; 3]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// The frame of a body at the stored instants.
struct Course {
    time: Vec<f64>,
    position: Vec<Vector3<f64>>,
    rotation: Vec<UnitQuaternion<f64>>,
    velocity: Vec<Vector3<f64>>,
    angular_velocity: Vec<Vector3<f64>>,
}

impl Course {
    fn read(stored: &Stored, body: &str) -> Result<Self, ResultError> {
        let vectors = |name: &str| -> Result<Vec<Vector3<f64>>, ResultError> {
            let values = stored.values(&format!("bodies/{body}/{name}"))?;
            Ok(values.as_chunks::<3>().0.iter().copied().map(Vector3::from).collect())
        };
        let rotations = stored.values(&format!("bodies/{body}/rotation"))?;
        let (rotations, _) = rotations.as_chunks::<4>();
        let rotation =
            |q: &[f64; 4]| UnitQuaternion::from_quaternion(Quaternion::new(q[0], q[1], q[2], q[3]));
        let mut course = Self {
            time: stored.time.clone(),
            position: vectors("position")?,
            rotation: rotations.iter().map(rotation).collect(),
            velocity: vectors("velocity")?,
            angular_velocity: vectors("angular_velocity")?,
        };
        // A result with rows missing is compared as far as it goes.
        let rows = [course.position.len(), course.rotation.len(), course.velocity.len()];
        let n = rows.into_iter().fold(course.time.len().min(course.angular_velocity.len()), usize::min);
        course.time.truncate(n);
        Ok(course)
    }

    /// The motion at the end, averaged over the last stretch without contact.
    fn motion(&self, body: &str, last_contact: f64) -> Motion {
        let bounds = self.stretches();
        let begin = bounds.iter().rev().nth(1).copied().unwrap_or(0);
        let opened = self.time.partition_point(|t| *t < last_contact);
        let end = self.time.len().saturating_sub(1);
        let (velocity, angular_velocity) = self.mean(begin.max(opened).min(end), end);
        let turns = bounds.windows(2).map(|w| self.mean(w[0], w[1]).1.norm());
        Motion {
            body: body.to_owned(),
            velocity: velocity.into(),
            angular_velocity: angular_velocity.into(),
            fastest: self.velocity.iter().map(|v| v.norm()).fold(0.0, f64::max),
            fastest_turn: turns.fold(angular_velocity.norm(), f64::max),
        }
    }

    /// The instants between which the run is cut into stretches.
    fn stretches(&self) -> Vec<usize> {
        let (Some(&first), Some(&last)) = (self.time.first(), self.time.last()) else {
            return Vec::new();
        };
        let n = (1.0 / STRETCH).round() as usize;
        let begin = |k: usize| first + (last - first) * k as f64 / n as f64;
        let begins = (0..n).map(|k| self.time.partition_point(|t| *t < begin(k)));
        let mut bounds: Vec<usize> = begins.chain([self.time.len() - 1]).collect();
        bounds.dedup();
        bounds
    }

    /// Mean velocity and angular velocity from instant `from` to instant `to`; those at `to` where
    /// no time lies between.
    fn mean(&self, from: usize, to: usize) -> (Vector3<f64>, Vector3<f64>) {
        if self.time.is_empty() {
            return (Vector3::zeros(), Vector3::zeros());
        }
        let duration = self.time[to] - self.time[from];
        if duration <= 0.0 {
            return (self.velocity[to], self.angular_velocity[to]);
        }
        let turn: Vector3<f64> = (from..to).map(|i| self.turn(i)).sum();
        ((self.position[to] - self.position[from]) / duration, turn / duration)
    }

    /// Rotation vector from instant `i` to the next one, in space.
    fn turn(&self, i: usize) -> Vector3<f64> {
        let mean = 0.5 * (self.angular_velocity[i] + self.angular_velocity[i + 1]);
        let expected = mean * (self.time[i + 1] - self.time[i]);
        if expected.norm() > LARGE_ANGLE {
            return expected;
        }
        (self.rotation[i + 1] * self.rotation[i].inverse()).scaled_axis()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A pendulum that turns about y at `rate` and vibrates with 3 mrad at 400 Hz and the phase
    /// given; states every millisecond.
    fn swinging(rate: f64, phase: f64) -> Course {
        let omega = std::f64::consts::TAU * 400.0;
        let time: Vec<f64> = (0..=1000).map(|i| 1e-3 * f64::from(i)).collect();
        let angle = |t: f64| rate * t + 3e-3 * (omega * t + phase).sin();
        let speed = |t: f64| rate + 3e-3 * omega * (omega * t + phase).cos();
        Course {
            position: time.iter().map(|t| Vector3::new(0.1 * angle(*t), 0.0, 0.0)).collect(),
            rotation: time.iter().map(|t| UnitQuaternion::new(Vector3::y() * angle(*t))).collect(),
            velocity: time.iter().map(|t| Vector3::new(0.1 * speed(*t), 0.0, 0.0)).collect(),
            angular_velocity: time.iter().map(|t| Vector3::y() * speed(*t)).collect(),
            time,
        }
    }

    #[test]
    fn ringing_leaves_the_motion_at_the_end_alone() {
        let [one, other] = [0.0, 2.0].map(|phase| swinging(4.0, phase).motion("rod", f64::NEG_INFINITY));
        for motion in [&one, &other] {
            // At most twice the amplitude in the stretch of 0.1 s, on 4 rad/s.
            let error = (motion.angular_velocity[1] - 4.0).abs();
            assert!(error <= 2.0 * 3e-3 / 0.1, "{error} rad/s");
            assert!((motion.velocity[0] - 0.1 * motion.angular_velocity[1]).abs() < 1e-12, "round-off");
            assert!((motion.fastest_turn - 4.0).abs() <= 2.0 * 3e-3 / 0.1, "{}", motion.fastest_turn);
        }
        let at_the_end = swinging(4.0, 2.0).angular_velocity[1000].y;
        assert!((at_the_end - 4.0).abs() > 3.0, "the velocity at one instant is {at_the_end} rad/s");
    }

    #[test]
    fn the_stretch_begins_when_the_last_contact_opens() {
        let mut course = swinging(0.0, 0.0);
        for (x, t) in course.position.iter_mut().zip(&course.time) {
            *x = Vector3::new(0.0, 0.0, (t - 0.95).abs());
        }
        let after = course.motion("ball", 0.95);
        assert!((after.velocity[2] - 1.0).abs() < 1e-12, "round-off: {}", after.velocity[2]);
        // Nothing is stored after it.
        let closed = course.motion("ball", 2.0);
        assert!((Vector3::from(closed.velocity) - course.velocity[1000]).norm() < f64::MIN_POSITIVE);
    }

    #[test]
    fn fast_spins_are_not_folded() {
        let mut course = swinging(5e3, 0.0);
        course.angular_velocity.fill(Vector3::y() * 5e3);
        let motion = course.motion("disc", f64::NEG_INFINITY);
        assert!((motion.angular_velocity[1] - 5e3).abs() < 1e-6, "{:?}", motion.angular_velocity);
    }
}
