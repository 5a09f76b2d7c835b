//! Stops of the joints of a system, one by one (docs/theory.md Eq. M.15).

use super::MultibodyModel;
use crate::system::joints::Stop;

/// A stop of a joint's coordinate.
#[derive(Debug, Clone, PartialEq)]
pub struct StopSite {
    /// Name of the joint.
    pub joint: String,
    /// Whether the coordinate is an angle.
    pub is_angle: bool,
    stop: Stop,
    position: usize,
    velocity: usize,
}

impl StopSite {
    /// Size of the force \[N or N m\] in the state `y`, and the rate at which the stop is
    /// compressed [m/s or rad/s]; zeros between the ends.
    pub fn force(&self, y: &[f64]) -> (f64, f64) {
        let (position, velocity) = (y[self.position], y[self.velocity]);
        let (force, _) = self.stop.force(position, velocity);
        let inwards = if position > self.stop.upper { velocity } else { -velocity };
        if position > self.stop.upper || position < self.stop.lower {
            (force.abs(), inwards)
        } else {
            (0.0, 0.0)
        }
    }
}

impl MultibodyModel {
    /// The stops of all joints, body by body. Prescribed coordinates have none, nor have rotations
    /// about a point.
    pub fn stops(&self) -> Vec<StopSite> {
        let mut found = Vec::new();
        for body in &self.bodies {
            let kind = body.joint.kind;
            for (free, k) in body.joint.free_velocities().enumerate() {
                let stop = body.joint.coordinates.get(k).and_then(|force| force.stop);
                let Some(stop) = stop.filter(|_| kind.quaternion().is_none_or(|w| k < w)) else { continue };
                found.push(StopSite {
                    joint: body.joint.name.clone(),
                    is_angle: kind.is_angle(k),
                    stop,
                    position: body.layout.positions().start + free,
                    velocity: body.layout.velocities().start + free,
                });
            }
        }
        found
    }
}
