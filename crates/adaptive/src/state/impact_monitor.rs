//! Follows one contact through an impact: first and last touch, peak force, impulse, velocities.

mod course;
mod impact;
mod ringing;

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use course::Course;
pub use course::Hold;
pub use impact::Impact;
use ringing::Lulls;
pub use ringing::Ringing;

use crate::record::{Band, EventRecord, ImpactRecord};

/// Relative motion of two bodies where they are nearest, as far as it is rigid (docs/theory.md
/// Eq. Q.2).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct NearMotion {
    /// Velocity of the contact body relative to the target [m/s].
    pub velocity: [f64; 3],
    /// Sum of the speeds of both bodies, by which the error of the velocity counts [m/s].
    pub speed: f64,
    /// Speed at which the bodies would approach each other with the kinetic energy of their
    /// vibration (theory Eq. Q.4) [m/s].
    pub vibration: f64,
}

impl NearMotion {
    /// Component of the relative velocity along `direction` [m/s].
    pub fn along(&self, direction: &Vector3<f64>) -> f64 {
        Vector3::from(self.velocity).dot(direction)
    }
}

/// The quantities of a contact that the monitor reads at the end of a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactInstant {
    /// Time \[s\].
    pub time: f64,
    /// Normal force \[N\].
    pub force: f64,
    /// Time integral of the force on the contact body since the start of the run [N s].
    pub impulse: Vector3<f64>,
    /// Unit normal towards the contact body.
    pub normal: Vector3<f64>,
    /// Relative motion.
    pub motion: NearMotion,
    /// Largest penetration that is left when the bodies have yielded \[m\].
    pub penetration: f64,
    /// Energy of its penalty springs, as a share of this and of what zones of the bodies hold that are no coordinates; none
    /// without such zones.
    pub of_springs: Option<f64>,
    /// What its points do, and where its bodies are.
    pub hold: Hold,
}

impl ContactInstant {
    /// Speed at which the bodies approach each other [m/s].
    fn closing_speed(&self) -> f64 {
        0.0 - self.motion.along(&self.normal)
    }
}

/// When a contact closed or opened within a step, and how the bodies moved then.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Change {
    /// Time \[s\].
    pub time: f64,
    /// Relative motion.
    pub motion: NearMotion,
}

/// Share of the largest approach, and of the largest force, below which bodies have turned back: the
/// force has passed its peak then, and what rings about it is less.
const TURNED: f64 = 0.9;
const LET_GO: f64 = 0.5;

/// Share of the approach by which bodies that were pressed together at the start of a phase come nearer while they stay in
/// equilibrium, at most: ten times what that leaves out of balance.
const AT_REST: f64 = 1e-3;

/// State of a watched contact.
#[derive(Debug, Clone, Default)]
pub struct ImpactMonitor {
    /// The impact of this phase that touched last.
    running: Option<Impact>,
    /// Impacts of this phase that are over because another one has begun.
    ended: Vec<Impact>,
    /// The impact that was reported last; another touch may turn out to belong to it.
    reported: Option<Impact>,
    phase: PhaseExtremes,
    course: Course,
    last: Option<ContactInstant>,
    before_last: Option<ContactInstant>,
}

/// Extreme values of a contact in a phase.
#[derive(Debug, Clone, Copy, Default)]
struct PhaseExtremes {
    peak_force: f64,
    peak_time: f64,
    /// Peak force when the bodies had turned back for the first time; none before.
    turned_peak: Option<f64>,
    /// Instant of the largest force at the end of a step.
    at_peak: Option<ContactInstant>,
    /// Approach of the bodies since the touch by their rigid motion, and its largest value while
    /// force acts \[m\].
    approach: f64,
    largest_approach: f64,
    /// That with which the phase began, bodies being pressed together then \[m\].
    first_approach: f64,
    /// Penetration at the instant of the largest approach \[m\].
    penetration: f64,
    /// Beginning of the touch, and that instant \[s\].
    start: f64,
    approach_time: f64,
    lulls: Lulls,
}

impl ImpactMonitor {
    /// A monitor after the impact `reported`, which goes on if another touch belongs to it.
    pub fn after(reported: Option<Impact>) -> Self {
        Self { reported, ..Self::default() }
    }

    /// The impact reported last.
    pub fn reported(&self) -> Option<Impact> {
        self.reported
    }

    /// Keeps the `band` of the impact reported last.
    pub fn set_band(&mut self, band: Band) {
        self.reported.iter_mut().for_each(|impact| impact.band = band);
    }

    /// Whether an impact is being followed.
    pub fn is_running(&self) -> bool {
        self.running.is_some()
    }

    /// End of the last touch of the running impact \[s\]; the present time while force acts.
    pub fn last_touch(&self) -> Option<f64> {
        self.running.as_ref().map(|r| r.end)
    }

    /// Whether force acted at the instant seen last.
    pub fn is_pressed(&self) -> bool {
        self.last.is_some_and(|last| last.force > 0.0)
    }

    /// For how long force has acted without a break at the instant seen last, and how long it took to its largest value in this phase
    /// \[s\]; none while none acts.
    pub fn pressed_for(&self) -> Option<(f64, f64)> {
        let last = self.last.filter(|last| last.force > 0.0)?;
        let impact = self.running?;
        Some((last.time - impact.touch, self.phase.peak_time - self.phase.start))
    }

    /// Longest time that a touch of this phase has lasted \[s\].
    pub fn longest_touch(&self) -> f64 {
        self.impacts().map(|impact| impact.longest).fold(0.0, f64::max)
    }

    /// Whether no force acted and the bodies approached each other at the instant seen last.
    pub fn is_closing_without_force(&self) -> bool {
        self.last.is_some_and(|last| last.force <= 0.0 && last.closing_speed() > 0.0)
    }

    /// Impacts of this phase, in the order in which they began.
    pub fn impacts(&self) -> impl Iterator<Item = &Impact> {
        self.ended.iter().chain(&self.running)
    }

    /// Row of the first impact of this phase if the next new impact gets the row `next`, and the
    /// number of new impacts.
    pub fn rows(&self, next: u32) -> (u32, u32) {
        let first = self.impacts().next().and_then(|impact| impact.row);
        (first.unwrap_or(next), self.impacts().filter(|impact| impact.row.is_none()).count() as u32)
    }

    /// Share of the approach of the bodies, the largest of this phase, that is penetration and not
    /// deformation at that instant, and how long after the first touch that is \[s\]; none if the penetration is no more than
    /// `round_off` \[m\] (theory Eq. A.36). Bodies
    /// that overlapped by `before` when the phase began have approached by that at least \[m\]; where they
    /// stay in the equilibrium in which it began, that is the instant. Of bodies whose rigid motion takes them apart all the
    /// time, what vibrates pressing them together, the share of the springs in the energy at the largest force.
    pub fn overlap_share(&self, round_off: f64, before: f64) -> Option<(f64, f64)> {
        let phase = &self.phase;
        let approach = phase.largest_approach.max(before);
        let peak = phase.at_peak.filter(|peak| self.is_running() && peak.penetration > round_off)?;
        if approach <= 0.0 || phase.penetration <= round_off {
            return Some((peak.of_springs?, peak.time - phase.start));
        }
        let moves = phase.largest_approach - phase.first_approach > AT_REST * approach;
        let time = if moves { phase.approach_time - phase.start } else { 0.0 };
        Some((phase.penetration / approach, time))
    }

    /// How the force rings at the peak of this phase, between the lulls before and after it; none if it does
    /// not.
    pub fn ringing(&self) -> Option<Ringing> {
        let PhaseExtremes { peak_force, peak_time, lulls, start, .. } = self.phase;
        lulls.ringing((peak_time, peak_force), self.last_touch()? - start)
    }

    /// Peak force of this phase so far \[N\].
    pub fn peak_force(&self) -> f64 {
        self.phase.peak_force
    }

    /// Peak force at which the bodies turned back for the first time in this phase: the peak of a phase
    /// in which they have not, or not yet \[N\]. Trials are compared by it, for it is known by then.
    pub fn judged_peak(&self) -> f64 {
        self.phase.turned_peak.unwrap_or(self.phase.peak_force)
    }

    /// Whether they have.
    pub fn has_turned(&self) -> bool {
        self.phase.turned_peak.is_some()
    }

    /// Begins a phase at the instant `now`; extremes of earlier phases are forgotten. Returns whether bodies are pressed then
    /// with a larger force than any before in an impact that goes on.
    pub fn begin(&mut self, now: ContactInstant) -> bool {
        (self.last, self.before_last) = (None, None);
        self.step(now, None, None)
    }

    /// Whether the steps up to the time `time` were shown.
    pub fn has_seen(&self, time: f64) -> bool {
        self.running.is_some() || self.last.is_some_and(|last| last.time >= time)
    }

    /// Takes the instant before a step that may bring a touch, after steps without force that were not shown.
    pub fn see_again(&mut self, now: ContactInstant) {
        (self.before_last, self.last) = (None, Some(now));
    }

    /// Takes the end of an accepted step. `touch` and `release` tell when the contact closed or
    /// opened within the step, if it did. Returns whether the force reached a new maximum of the
    /// phase at this instant.
    pub fn step(&mut self, now: ContactInstant, touch: Option<Change>, release: Option<Change>) -> bool {
        let before = self.last.unwrap_or(now);
        let was_touching = self.last.is_some_and(|l| l.force > 0.0);
        if now.force > 0.0 && !was_touching {
            self.begin_touch(&before, &now, touch);
        }
        let Some(impact) = &mut self.running else {
            (self.before_last, self.last) = (self.last, Some(now));
            return false;
        };
        let phase = &mut self.phase;
        if let Some(last) = &self.last {
            let since = last.time.max(impact.start.min(now.time));
            phase.approach += 0.5 * (last.closing_speed() + now.closing_speed()) * (now.time - since);
        }
        if now.force > 0.0 && phase.approach > phase.largest_approach {
            (phase.largest_approach, phase.penetration) = (phase.approach, now.penetration);
            phase.approach_time = now.time;
        }
        if now.force > 0.0 {
            impact.last_until(now.time, now.motion);
            self.course.press([self.before_last.as_ref(), self.last.as_ref()], &now, phase.approach);
        } else if was_touching {
            let (time, motion) = release.map_or((now.time, now.motion), |r| (r.time, r.motion));
            impact.last_until(time, motion);
            self.course.release(time);
        }
        while let Some(earlier) = self.ended.last().or(self.reported.as_ref())
            && earlier.row.is_none_or(|row| impact.row != Some(row))
            && impact.absorb(earlier)
        {
            self.ended.pop();
        }
        // Points may touch within a step and at neither of its ends.
        impact.impulse = (now.impulse - Vector3::from(impact.impulse_at_start)).into();
        let earlier = self.before_last.zip(self.last);
        let top = |peak: f64| match earlier {
            Some((a, b)) if now.force <= peak => parabola_top(&a, &b, &now),
            _ => (now.time, now.force),
        };
        let (time, force) = top(impact.peak_force);
        if force > impact.peak_force {
            (impact.peak_time, impact.peak_force) = (time, force);
            impact.normal = normal_at(time, [self.before_last.as_ref(), self.last.as_ref()], &now).into();
        }
        let is_new_peak = now.force > phase.peak_force;
        if is_new_peak {
            phase.at_peak = Some(now);
        }
        if let Some((a, b)) = earlier {
            phase.lulls.see([&a, &b, &now].map(|instant| (instant.time, instant.force)));
        }
        let (time, force) = top(phase.peak_force);
        if force > phase.peak_force {
            (phase.peak_time, phase.peak_force) = (time, force);
            phase.lulls.rise();
        }
        let has_turned =
            phase.approach < TURNED * phase.largest_approach && now.force < LET_GO * phase.peak_force;
        if has_turned && phase.turned_peak.is_none() {
            phase.turned_peak = Some(phase.peak_force);
        }
        (self.before_last, self.last) = (self.last, Some(now));
        is_new_peak
    }

    /// Begins a touch, of the impact before or of another one.
    fn begin_touch(&mut self, before: &ContactInstant, now: &ContactInstant, touch: Option<Change>) {
        let start = touch.map_or(before.time, |t| t.time);
        self.course.touch(start, now);
        if self.impacts().next().is_none() {
            // Bodies that are pressed together at the start count as having approached by at least
            // their penetration.
            let penetration = before.penetration;
            self.phase = PhaseExtremes {
                approach: penetration,
                largest_approach: penetration,
                first_approach: penetration,
                penetration,
                start,
                approach_time: start,
                ..PhaseExtremes::default()
            };
        }
        let previous = self.running.or(self.reported);
        self.running = Some(match previous.filter(|impact| impact.is_joined_by(start)) {
            // A penalty factor that is lowered during a touch does not begin another touch.
            Some(joined) => Impact { touch: if start > joined.end { start } else { joined.touch }, ..joined },
            None => {
                self.ended.extend(self.running);
                Impact::begin(before, now, touch)
            }
        });
    }

    /// The events of this phase, which are forgotten.
    pub fn take_events(&mut self) -> Vec<EventRecord> {
        self.course.take()
    }

    /// Ends the phase and returns the records of its impacts, new ones in rows from `next` on;
    /// `contact` is the contact's index, `is_alone` whether an impact's bodies were pressed by no
    /// other contact meanwhile: otherwise, and while force still acts, there is no restitution.
    pub fn finish(
        &mut self,
        contact: u32,
        next: u32,
        is_alone: impl Fn(&Impact) -> bool,
    ) -> Vec<ImpactRecord> {
        let is_open = self.last.is_some_and(|l| l.force <= 0.0);
        let n_ended = self.ended.len();
        let mut new = next;
        let impacts = self.ended.drain(..).chain(self.running.take());
        let records = impacts.enumerate().map(|(k, mut impact)| {
            impact.is_alone &= is_alone(&impact);
            let row = impact.row.unwrap_or(new);
            new += u32::from(impact.row.is_none());
            impact.row = Some(row);
            self.reported = Some(impact);
            impact.record(contact, row, is_open || k < n_ended)
        });
        let records = records.collect();
        self.phase = PhaseExtremes::default();
        records
    }
}

/// Least ratio of two neighbouring steps for which a parabola is laid through the forces at their
/// ends.
const SHORTEST_STEP: f64 = 0.05;

/// Normal at `time` \[s\], which turns evenly between the two instants `earlier` and `now`.
fn normal_at(time: f64, earlier: [Option<&ContactInstant>; 2], now: &ContactInstant) -> Vector3<f64> {
    let instants = earlier.into_iter().flatten().filter(|instant| instant.force > 0.0);
    let (before, after) = instants.chain([now]).fold((None, None), |(before, after), instant| match after {
        None if instant.time < time => (Some(instant), None),
        None => (before, Some(instant)),
        Some(_) => (before, after),
    });
    match (before, after) {
        (Some(a), Some(b)) => {
            let share = (time - a.time) / (b.time - a.time);
            (a.normal * (1.0 - share) + b.normal * share).normalize()
        }
        (a, b) => a.or(b).unwrap_or(now).normal,
    }
}

/// Top of the parabola through three instants none of which is higher than the middle one; the
/// middle one otherwise.
fn parabola_top(a: &ContactInstant, b: &ContactInstant, c: &ContactInstant) -> (f64, f64) {
    // Two equal instants have the top between them; three equal ones have no parabola.
    if b.force < a.force || b.force < c.force || b.force <= a.force.min(c.force) {
        return (b.time, b.force);
    }
    let (left, right) = (b.time - a.time, c.time - b.time);
    // Steps of very different size, as after a failure: the difference of two forces over the short
    // one is noise.
    if left.min(right) < SHORTEST_STEP * left.max(right) {
        return (b.time, b.force);
    }
    let (rise, fall) = ((b.force - a.force) / left, (c.force - b.force) / right);
    let curvature = (fall - rise) / (left + right);
    let slope = (rise * right + fall * left) / (left + right);
    let offset = -0.5 * slope / curvature;
    (b.time + offset, b.force + 0.5 * slope * offset)
}

#[cfg(test)]
mod tests;
