//! Follows a stop of a joint through its hits: begin and end, peak, impulse (docs/theory.md
//! Eq. M.23).

use serde::{Deserialize, Serialize};

use crate::record::ImpactRecord;
use crate::record::band::{Band, NoBand};

/// States stored of a hit at most: one that lasts longer rests on its stop.
const MOST_STATES: u32 = 400;

/// A stop at an instant.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Seen {
    /// Time \[s\].
    pub time: f64,
    /// Its force [N or N m].
    pub force: f64,
    /// How far it is compressed, negative as far as it is away [m or rad].
    pub compression: f64,
    /// Rate of that [m/s or rad/s].
    pub rate: f64,
}

/// A stop as it was seen last, and the running hit.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct StopHit {
    last: Seen,
    /// The instant before.
    before: Seen,
    /// Speed at which the stop was met, and is left [m/s or rad/s].
    approach: f64,
    separation: f64,
    start: f64,
    peak: (f64, f64),
    impulse: f64,
    /// Instants of the running hit.
    instants: u32,
}

impl StopHit {
    /// The last instant.
    pub fn seen(&self) -> &Seen {
        &self.last
    }

    /// Whether the stop was met or left between the last instant and `now`.
    pub fn crossing(&self, now: &Seen) -> bool {
        (self.last.compression > 0.0) != (now.compression > 0.0) && self.last.time < now.time
    }

    /// Whether the stop pressed at the last instant.
    pub fn is_pressed(&self) -> bool {
        self.last.force > 0.0
    }

    /// Whether states of the running hit are worth storing one by one.
    pub fn is_short(&self) -> bool {
        self.instants < MOST_STATES
    }

    /// Takes the stop as it is `now`; the record of the hit that has ended, of the impact number
    /// `contact`.
    pub fn step(&mut self, now: Seen, contact: u32) -> Option<ImpactRecord> {
        let (was_pressed, last) = (self.is_pressed(), self.last);
        if now.force > 0.0 && !was_pressed {
            *self = Self { last, start: last.time, approach: last.rate, ..Self::default() };
        }
        let mut ended = None;
        if now.force > 0.0 || was_pressed {
            self.impulse += 0.5 * (last.force + now.force) * (now.time - last.time);
            self.instants += 1;
            if now.force > self.peak.1 {
                self.peak = (now.time, now.force);
            }
            let (top_time, top) = top([self.before, last, now].map(|seen| (seen.time, seen.force)));
            if self.instants > 2 && top > self.peak.1 {
                self.peak = (top_time, top);
            }
            self.separation = -now.rate;
            if now.force <= 0.0 {
                ended = Some(self.record(now.time, contact));
            }
        }
        (self.before, self.last) = (last, now);
        ended
    }

    /// The running hit up to `time`, which the bodies have not left yet.
    pub fn unended(&self, time: f64, contact: u32) -> ImpactRecord {
        let record = self.record(time, contact);
        ImpactRecord { separation_velocity: f64::NAN, restitution: f64::NAN, ..record }
    }

    /// The hit that ended at `time`.
    fn record(&self, time: f64, contact: u32) -> ImpactRecord {
        let is_ratio = self.approach > 0.0 && self.separation >= 0.0;
        ImpactRecord {
            row: 0, // where it is reported
            contact,
            start: self.start,
            end: time,
            peak_force: self.peak.1,
            peak_time: self.peak.0,
            impulse: self.impulse,
            approach_velocity: self.approach,
            separation_velocity: self.separation,
            restitution: if is_ratio { self.separation / self.approach } else { f64::NAN },
            band: Band::none(NoBand::Stop),
        }
    }
}

/// Time and force at the top of the parabola through three instants; those of the middle one if it
/// is not the largest.
fn top([a, b, c]: [(f64, f64); 3]) -> (f64, f64) {
    let (left, right) = (b.0 - a.0, c.0 - b.0);
    let is_top = b.1 >= a.1 && b.1 >= c.1 && b.1 > a.1.min(c.1) && left > 0.0 && right > 0.0;
    if !is_top {
        return b;
    }
    let (rise, fall) = ((b.1 - a.1) / left, (c.1 - b.1) / right);
    let curvature = (fall - rise) / (left + right);
    let slope = (rise * right + fall * left) / (left + right);
    let offset = -0.5 * slope / curvature;
    (b.0 + offset, b.1 + 0.5 * slope * offset)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    /// A mass on a spring that is met at the speed one: half a sine.
    fn seen(time: f64, force: f64, phase: f64) -> Seen {
        Seen { time, force, compression: phase.sin(), rate: phase.cos() }
    }

    #[test]
    fn half_a_sine_has_its_peak_and_its_impulse() {
        // Forty instants of a hit of 1 ms and 5 N; peak by parabolas: fourth powers of π/40;
        // impulse by trapezoids: π²/12 of 1/1600.
        let (n, duration, peak) = (40, 1e-3, 5.0);
        let mut hit = StopHit::default();
        assert_eq!(hit.step(seen(1.0, 0.0, 0.0), 7), None);
        let mut found = None;
        for i in 1..=n {
            let phase = PI * f64::from(i) / f64::from(n);
            let force = if i == n { 0.0 } else { peak * phase.sin() };
            found = hit.step(seen(1.0 + duration * f64::from(i) / f64::from(n), force, phase), 7);
            assert_eq!(found.is_some(), i == n);
        }
        let record = found.expect("a hit");
        assert_eq!((record.contact, record.start), (7, 1.0));
        assert!((record.end - 1.001).abs() < 1e-12);
        assert!((record.peak_force / peak - 1.0).abs() < 1e-5, "{}", record.peak_force);
        assert!((record.impulse / (2.0 / PI * peak * duration) - 1.0).abs() < 6e-4, "{}", record.impulse);
        assert!((record.restitution - 1.0).abs() < 1e-14, "met and left at the speed one; round-off");
        assert!(!hit.is_pressed());
    }

    #[test]
    fn a_joint_that_rests_on_its_stop_is_not_stored_for_ever() {
        let mut hit = StopHit::default();
        for i in 0..1000 {
            assert_eq!(hit.step(Seen { rate: 0.0, ..seen(f64::from(i), 1.0, 0.5) }, 0), None);
        }
        assert!(hit.is_pressed() && !hit.is_short());
    }
}
