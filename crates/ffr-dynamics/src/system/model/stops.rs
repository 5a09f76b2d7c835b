//! Stops of the joints of a system, one by one (docs/theory.md Eq. M.15).

use super::MultibodyModel;
use crate::system::joints::{Stop, TimeFunction};

/// A stop of a joint's coordinate.
#[derive(Debug, Clone)]
pub struct StopSite {
    /// Name of the joint.
    pub joint: String,
    /// Whether the coordinate is an angle.
    pub is_angle: bool,
    stop: Stop,
    coordinate: Coordinate,
}

/// Where a coordinate is found.
#[derive(Debug, Clone)]
enum Coordinate {
    /// At these places of the state.
    InState { position: usize, velocity: usize },
    /// In the motion that is prescribed to it.
    Prescribed(TimeFunction),
}

impl StopSite {
    /// Size of the force \[N or N m\] in the state `y` at time `t`; zero between the ends.
    pub fn force(&self, t: f64, y: &[f64]) -> f64 {
        let [position, velocity] = self.motion(t, y);
        self.stop.force(position, velocity).0.abs()
    }

    /// How far the nearer end is compressed [m or rad], negative as far as it is away, and the rate of
    /// that [m/s or rad/s].
    pub fn compression(&self, t: f64, y: &[f64]) -> [f64; 2] {
        let [position, velocity] = self.motion(t, y);
        let (above, below) = (position - self.stop.upper, self.stop.lower - position);
        if above >= below { [above, velocity] } else { [below, -velocity] }
    }

    /// Position and velocity of the coordinate.
    fn motion(&self, t: f64, y: &[f64]) -> [f64; 2] {
        match &self.coordinate {
            Coordinate::InState { position, velocity } => [y[*position], y[*velocity]],
            Coordinate::Prescribed(motion) => {
                let [position, velocity, _] = motion.at(t);
                [position, velocity]
            }
        }
    }
}

impl MultibodyModel {
    /// The stops of all joints, body by body. Rotations about a point have none.
    pub fn stops(&self) -> Vec<StopSite> {
        let mut found = Vec::new();
        for body in &self.bodies {
            let (joint, kind) = (&body.joint, body.joint.kind);
            let mut free = 0;
            for (k, force) in joint.coordinates.iter().enumerate() {
                let coordinate = match &force.motion {
                    Some(motion) => Coordinate::Prescribed(motion.clone()),
                    None => Coordinate::InState {
                        position: body.layout.positions().start + free,
                        velocity: body.layout.velocities().start + free,
                    },
                };
                free += usize::from(force.motion.is_none());
                let has_angle = kind.quaternion().is_none_or(|w| k < w);
                let Some(stop) = force.stop.filter(|_| has_angle) else { continue };
                let (joint, is_angle) = (joint.name.clone(), kind.is_angle(k));
                found.push(StopSite { joint, is_angle, stop, coordinate });
            }
        }
        found
    }
}
