//! Where the parts of a state vector stand.
//!
//! Body by body: position (3), rotation `w x y z` (4), `q_e`, velocity in the inertial frame (3), angular velocity in the
//! body's frame (3), `dq_e/dt`. Then the quadratures: dissipated work, and the impulse (3) of each force element.

use std::ops::Range;

use super::force::BodyState;
use crate::integration::KinematicBlock;
use crate::kinematics::rotation::{rotation_from_slice, write_rotation};

/// Place of one body's coordinates in the state vector.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BodyLayout {
    /// Index of the first coordinate.
    pub offset: usize,
    /// Number of elastic coordinates.
    pub n_modes: usize,
}

impl BodyLayout {
    /// Number of state variables of a body.
    pub fn len(&self) -> usize {
        13 + 2 * self.n_modes
    }

    /// Never: a body has at least its position.
    pub fn is_empty(&self) -> bool {
        false
    }

    /// Position.
    pub fn position(&self) -> Range<usize> {
        self.offset..self.offset + 3
    }

    /// Quaternion.
    pub fn rotation(&self) -> Range<usize> {
        self.offset + 3..self.offset + 7
    }

    /// Elastic coordinates.
    pub fn elastic(&self) -> Range<usize> {
        self.offset + 7..self.offset + 7 + self.n_modes
    }

    /// Velocity.
    pub fn velocity(&self) -> Range<usize> {
        let start = self.offset + 7 + self.n_modes;
        start..start + 3
    }

    /// Angular velocity.
    pub fn angular_velocity(&self) -> Range<usize> {
        let start = self.offset + 10 + self.n_modes;
        start..start + 3
    }

    /// Elastic rates.
    pub fn elastic_rates(&self) -> Range<usize> {
        let start = self.offset + 13 + self.n_modes;
        start..start + self.n_modes
    }

    /// How the coordinates change with the velocities, for implicit integrators.
    pub fn kinematics(&self) -> [KinematicBlock; 3] {
        let (velocity, rates) = (self.velocity().start, self.elastic_rates().start);
        [
            KinematicBlock::Vector { position: self.position().start, velocity, len: 3 },
            KinematicBlock::Rotation {
                quaternion: self.rotation().start,
                velocity: self.angular_velocity().start,
            },
            KinematicBlock::Vector { position: self.elastic().start, velocity: rates, len: self.n_modes },
        ]
    }

    /// Reads a body's motion; `state` has the right number of elastic coordinates. Does not allocate.
    pub fn read(&self, y: &[f64], state: &mut BodyState) {
        state.position.copy_from_slice(&y[self.position()]);
        state.rotation = rotation_from_slice(&y[self.rotation()]);
        state.velocity.copy_from_slice(&y[self.velocity()]);
        state.angular_velocity.copy_from_slice(&y[self.angular_velocity()]);
        state.elastic.copy_from_slice(&y[self.elastic()]);
        state.elastic_rates.copy_from_slice(&y[self.elastic_rates()]);
    }

    /// Writes a body's motion.
    pub fn write(&self, state: &BodyState, y: &mut [f64]) {
        y[self.position()].copy_from_slice(state.position.as_slice());
        write_rotation(&state.rotation, &mut y[self.rotation()]);
        y[self.velocity()].copy_from_slice(state.velocity.as_slice());
        y[self.angular_velocity()].copy_from_slice(state.angular_velocity.as_slice());
        y[self.elastic()].copy_from_slice(&state.elastic);
        y[self.elastic_rates()].copy_from_slice(&state.elastic_rates);
    }
}
