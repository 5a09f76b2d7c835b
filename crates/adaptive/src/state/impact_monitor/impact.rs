//! One impact: touches that follow each other closely (docs/theory.md Eq. Q.1), and what is
//! recorded of them.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use super::{Change, ContactInstant, NearMotion};
use crate::record::{Band, ImpactRecord};

/// Touches of two bodies between which they are apart for no longer than the longest of those
/// before or after lasted (docs/theory.md Eq. Q.1).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Impact {
    /// Row in which it has been reported.
    pub(super) row: Option<u32>,
    /// Start of the first touch, of the last one, and end of that \[s\].
    pub(super) start: f64,
    pub(super) touch: f64,
    pub(super) end: f64,
    /// Time that the longest touch lasted \[s\].
    pub(super) longest: f64,
    pub(super) peak_force: f64,
    pub(super) peak_time: f64,
    /// Normal at the peak. Where bodies slide past each other it turns as much before the peak as
    /// after it, so that velocities along it are those that the normal impulse changes.
    pub(super) normal: [f64; 3],
    pub(super) impulse_at_start: [f64; 3],
    pub(super) impulse: [f64; 3],
    pub(super) before: NearMotion,
    pub(super) after: NearMotion,
    /// Whether no other contact has pressed the bodies in the phases that have been reported.
    pub(super) is_alone: bool,
    /// Bands of its numbers, once it has been reported.
    pub(super) band: Band,
}

/// Smallest approach velocity that is one, as a share of the speeds that it is the difference of.
/// The integrator keeps velocities to a tolerance of 1e-8 of them unless the scenario says
/// otherwise: a ratio with less would be off by a percent.
const LEAST_APPROACH: f64 = 1e-6;
/// Largest speed of vibration before the touch, as a share of the approach, with which the ratio of
/// velocities says something of the impact: a hundredth of the energy, which changes the ratio by
/// half a percent.
const MOST_RINGING: f64 = 0.1;

impl Impact {
    /// The impact that begins with a touch in the step from `before` to `now`.
    pub(super) fn begin(before: &ContactInstant, now: &ContactInstant, touch: Option<Change>) -> Self {
        let start = touch.map_or(before.time, |t| t.time);
        Self {
            row: None,
            start,
            touch: start,
            end: now.time,
            longest: 0.0,
            peak_force: 0.0,
            peak_time: now.time,
            normal: now.normal.into(),
            impulse_at_start: before.impulse.into(),
            impulse: [0.0; 3],
            before: touch.map_or(before.motion, |t| t.motion),
            after: now.motion,
            is_alone: true,
            band: Band::default(),
        }
    }

    /// First and last contact \[s\].
    pub fn span(&self) -> (f64, f64) {
        (self.start, self.end)
    }

    /// Whether a touch that begins at the time `touch` is one of this impact.
    pub(super) fn is_joined_by(&self, touch: f64) -> bool {
        touch - self.end <= self.longest
    }

    /// Whether no touch at `time` or later is one of this impact, or none is to come: the bodies part
    /// faster than they vibrate.
    pub fn is_over(&self, time: f64) -> bool {
        !self.is_joined_by(time) || self.speeds().1 > self.after.vibration
    }

    /// Takes in the impact before, if the bodies were apart for no longer than the longest touch of
    /// either lasted.
    pub(super) fn absorb(&mut self, earlier: &Self) -> bool {
        let is_one = self.start - earlier.end <= self.longest.max(earlier.longest);
        if is_one {
            let higher = if earlier.peak_force > self.peak_force { earlier } else { &*self };
            *self = Self {
                row: earlier.row,
                start: earlier.start,
                longest: self.longest.max(earlier.longest),
                peak_force: higher.peak_force,
                peak_time: higher.peak_time,
                normal: higher.normal,
                impulse_at_start: earlier.impulse_at_start,
                before: earlier.before,
                is_alone: self.is_alone && earlier.is_alone,
                ..*self
            };
        }
        is_one
    }

    /// Takes the end of a step at which force acts, or acted before.
    pub(super) fn last_until(&mut self, time: f64, motion: NearMotion) {
        (self.end, self.after) = (time, motion);
        self.longest = self.longest.max(time - self.touch);
    }

    /// Closing speed before and separating speed after.
    fn speeds(&self) -> (f64, f64) {
        let normal = Vector3::from(self.normal);
        (0.0 - self.before.along(&normal), self.after.along(&normal))
    }

    /// Ratio of separating and closing speed; NaN if the bodies did not approach each other, rang
    /// before they touched, or go on approaching each other.
    fn restitution(&self) -> f64 {
        let (approach, separation) = self.speeds();
        let least = LEAST_APPROACH * self.before.speed.max(self.after.speed);
        let is_quiet = self.before.vibration <= MOST_RINGING * approach;
        if approach > least && is_quiet && separation >= 0.0 { separation / approach } else { f64::NAN }
    }

    /// The record of an impact that has been reported, if the run has ended at `time` before it is known
    /// to be over.
    pub fn unended(&self, contact: u32, time: f64) -> Option<ImpactRecord> {
        let record = self.record(contact, self.row?, false);
        (self.end < time && !self.is_over(time)).then_some(record)
    }

    pub(super) fn record(&self, contact: u32, row: u32, is_open: bool) -> ImpactRecord {
        let (approach_velocity, separation_velocity) = self.speeds();
        ImpactRecord {
            row,
            contact,
            start: self.start,
            end: self.end,
            peak_force: self.peak_force,
            peak_time: self.peak_time,
            impulse: Vector3::from(self.impulse).dot(&Vector3::from(self.normal)),
            approach_velocity,
            separation_velocity: if is_open { separation_velocity } else { f64::NAN },
            restitution: if is_open && self.is_alone { self.restitution() } else { f64::NAN },
            band: self.band,
        }
    }
}
