//! Follows one contact through an impact: first and last touch, peak force, impulse, velocities.

use nalgebra::Vector3;

use crate::record::ImpactRecord;

/// Relative motion of two bodies where they are nearest, as far as it is rigid (docs/theory.md Eq. A.31).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NearMotion {
    /// Velocity of the contact body relative to the target [m/s].
    pub velocity: Vector3<f64>,
    /// Sum of the speeds of both bodies, by which the error of the velocity counts [m/s].
    pub speed: f64,
}

/// What the watch needs to know of a contact at the end of a step.
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
}

impl ContactInstant {
    /// Speed at which the bodies approach each other [m/s].
    fn closing_speed(&self) -> f64 {
        0.0 - self.motion.velocity.dot(&self.normal)
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

/// State of a watched contact.
#[derive(Debug, Clone, Default)]
pub struct ImpactMonitor {
    record: Option<Running>,
    last: Option<ContactInstant>,
    before_last: Option<ContactInstant>,
}

#[derive(Debug, Clone)]
struct Running {
    start: f64,
    end: f64,
    peak_force: f64,
    peak_time: f64,
    /// Normal at the peak. Where bodies slide past each other it turns as much before the peak as after it, so that velocities
    /// along it are those that the normal impulse changes.
    normal: Vector3<f64>,
    impulse_at_start: Vector3<f64>,
    before: NearMotion,
    impulse: Vector3<f64>,
    after: NearMotion,
    /// How far the bodies have come nearer to each other since the touch, as far as their motion is rigid, and the most of it \[m\].
    approach: f64,
    largest_approach: f64,
    /// Largest penetration \[m\].
    penetration: f64,
}

/// Smallest approach velocity that is one, as a share of the speeds that it is the difference of. The integrator keeps velocities to
/// a tolerance of 1e-8 of them unless the scenario says otherwise: a ratio with less would be off by a percent.
const LEAST_APPROACH: f64 = 1e-6;

impl Running {
    /// Closing speed before and separating speed after.
    fn speeds(&self) -> (f64, f64) {
        (0.0 - self.before.velocity.dot(&self.normal), self.after.velocity.dot(&self.normal))
    }

    /// Ratio of separating and closing speed; NaN if the bodies did not approach each other, or go on approaching each other.
    fn restitution(&self) -> f64 {
        let (approach, separation) = self.speeds();
        let least = LEAST_APPROACH * self.before.speed.max(self.after.speed);
        if approach > least && separation >= 0.0 { separation / approach } else { f64::NAN }
    }
}

impl ImpactMonitor {
    /// Whether an impact is being followed.
    pub fn is_running(&self) -> bool {
        self.record.is_some()
    }

    /// End of the last touch of the running impact \[s\]; the present time while force acts.
    pub fn last_touch(&self) -> Option<f64> {
        self.record.as_ref().map(|r| r.end)
    }

    /// Whether the force is at its largest now.
    pub fn is_rising(&self) -> bool {
        let now = self.last.map(|l| l.time);
        self.record.as_ref().is_some_and(|r| r.peak_force > 0.0 && Some(r.peak_time) == now)
    }

    /// First and last contact of the running impact \[s\].
    pub fn span(&self) -> Option<(f64, f64)> {
        self.record.as_ref().map(|r| (r.start, r.end))
    }

    /// Share of the approach of the bodies, the largest of the running impact, that is penetration and not deformation; none without approach,
    /// or if the penetration is no more than `round_off` \[m\] (theory Eq. A.76).
    pub fn overlap_share(&self, round_off: f64) -> Option<f64> {
        let running = self.record.as_ref().filter(|r| r.largest_approach > 0.0 && r.penetration > round_off);
        running.map(|r| r.penetration / r.largest_approach)
    }

    /// Peak force so far \[N\].
    pub fn peak_force(&self) -> f64 {
        self.record.as_ref().map_or(0.0, |r| r.peak_force)
    }

    /// Takes the instant at which watching begins: what was seen in earlier phases does not count.
    pub fn begin(&mut self, now: ContactInstant) {
        (self.last, self.before_last) = (None, None);
        self.step(now, None, None);
    }

    /// Takes the end of an accepted step. `touch` and `release` tell when the contact closed or opened within
    /// the step, if it did. Returns whether the force reached a new maximum at this instant.
    pub fn step(&mut self, now: ContactInstant, touch: Option<Change>, release: Option<Change>) -> bool {
        if now.force > 0.0 && self.record.is_none() {
            let before = self.last.unwrap_or(now);
            self.record = Some(Running {
                start: touch.map_or(before.time, |t| t.time),
                end: now.time,
                peak_force: 0.0,
                peak_time: now.time,
                normal: now.normal,
                impulse_at_start: before.impulse,
                before: touch.map_or(before.motion, |t| t.motion),
                impulse: Vector3::zeros(),
                after: now.motion,
                // Bodies that begin pressed together have approached by their penetration at least.
                approach: before.penetration,
                largest_approach: before.penetration,
                penetration: before.penetration,
            });
        }
        let mut is_new_peak = false;
        if let Some(running) = &mut self.record {
            if let Some(last) = &self.last {
                let since = last.time.max(running.start);
                running.approach += 0.5 * (last.closing_speed() + now.closing_speed()) * (now.time - since);
            }
            running.largest_approach = running.largest_approach.max(running.approach);
            running.penetration = running.penetration.max(now.penetration);
            let was_touching = self.last.is_some_and(|l| l.force > 0.0);
            if now.force > 0.0 {
                (running.end, running.after) = (now.time, now.motion);
            } else if was_touching {
                running.end = release.map_or(now.time, |r| r.time);
                running.after = release.map_or(now.motion, |r| r.motion);
            }
            // Points may touch within a step and at neither of its ends.
            running.impulse = now.impulse - running.impulse_at_start;
            if now.force > running.peak_force {
                (running.peak_force, running.peak_time) = (now.force, now.time);
                running.normal = now.normal;
                is_new_peak = true;
            } else if let (Some(a), Some(b)) = (self.before_last, self.last) {
                let (time, force) = parabola_top(&a, &b, &now);
                if force > running.peak_force {
                    (running.peak_force, running.peak_time) = (force, time);
                }
            }
        }
        self.before_last = self.last;
        self.last = Some(now);
        is_new_peak
    }

    /// Ends the running impact and returns its record; `contact` is the contact's index, `is_alone` whether its bodies were pressed
    /// by no other contact meanwhile: otherwise, and while force still acts, there is no restitution.
    pub fn finish(&mut self, contact: u32, is_alone: bool) -> Option<ImpactRecord> {
        let is_open = self.last.is_some_and(|l| l.force <= 0.0);
        self.record.take().map(|r| {
            let (approach_velocity, separation_velocity) = r.speeds();
            ImpactRecord {
                contact,
                start: r.start,
                end: r.end,
                peak_force: r.peak_force,
                peak_time: r.peak_time,
                impulse: r.impulse.dot(&r.normal),
                approach_velocity,
                separation_velocity: if is_open { separation_velocity } else { f64::NAN },
                restitution: if is_open && is_alone { r.restitution() } else { f64::NAN },
            }
        })
    }
}

/// Ratio of neighbouring steps from which on a parabola through forces makes sense.
const SHORTEST_STEP: f64 = 0.05;

/// Top of the parabola through three instants none of which is higher than the middle one; the middle one otherwise.
fn parabola_top(a: &ContactInstant, b: &ContactInstant, c: &ContactInstant) -> (f64, f64) {
    // Two equal instants have the top between them; three equal ones have no parabola.
    if b.force < a.force || b.force < c.force || b.force <= a.force.min(c.force) {
        return (b.time, b.force);
    }
    let (left, right) = (b.time - a.time, c.time - b.time);
    // Steps of very different size, as after a failure: the difference of two forces over the short one is noise.
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
mod tests {
    use super::*;

    fn instant(time: f64, force: f64, impulse: f64, velocity: f64) -> ContactInstant {
        let [impulse, velocity] = [impulse, velocity].map(|size| Vector3::z() * size);
        let normal = Vector3::z();
        ContactInstant { time, force, impulse, normal, motion: motion(velocity), penetration: 0.0 }
    }

    fn motion(velocity: Vector3<f64>) -> NearMotion {
        NearMotion { velocity, speed: velocity.norm() }
    }

    fn change(time: f64, velocity: f64) -> Option<Change> {
        Some(Change { time, motion: motion(Vector3::z() * velocity) })
    }

    #[test]
    fn bodies_sliding_past_each_other_part_as_fast_as_they_met() {
        // No loss, no friction: the velocity is mirrored at the mean normal, from which the normal turns by 0.01 to both sides.
        let normal = |angle: f64| Vector3::new(angle.sin(), 0.0, angle.cos());
        let mut velocity = Vector3::new(2.0, 0.0, -1.0);
        let approach = -velocity.dot(&normal(0.0));
        let mut watch = ImpactMonitor::default();
        for (t, force, angle) in
            [(0.0, 0.0, -0.01), (1.0, 5.0, -0.005), (2.0, 7.0, 0.0), (3.0, 5.0, 0.005), (4.0, 0.0, 0.01)]
        {
            if t > 2.0 {
                velocity = Vector3::new(2.0, 0.0, 1.0);
            }
            let impulse = Vector3::z() * if t > 2.0 { 2.0 } else { 0.0 };
            watch.step(
                ContactInstant {
                    time: t,
                    force,
                    impulse,
                    normal: normal(angle),
                    motion: motion(velocity),
                    penetration: 0.0,
                },
                None,
                None,
            );
        }
        let r = watch.finish(0, true).unwrap();
        // Round-off.
        assert!(
            (r.restitution - 1.0).abs() < 1e-15 && (r.approach_velocity - approach).abs() < 1e-15,
            "{r:?}"
        );
        assert!((r.impulse - 2.0).abs() < 1e-15);
    }

    #[test]
    fn half_sine_impact_is_recorded_with_peak_between_steps() {
        let mut watch = ImpactMonitor::default();
        let (n, peak, duration) = (23, 50.0, 1.0); // 23 steps never hit the middle
        watch.step(instant(-0.1, 0.0, 7.0, -2.0), None, None);
        for i in 1..=n {
            let t = i as f64 / n as f64;
            let force = if i == n { 0.0 } else { peak * (std::f64::consts::PI * t).sin() };
            let impulse = 7.0 + peak / std::f64::consts::PI * (1.0 - (std::f64::consts::PI * t).cos());
            let (touch, release) = (change(0.0, -2.0), change(1.0, 1.9));
            let now = instant(t * duration, force, impulse, -2.0 + 3.9 * t);
            watch.step(now, touch.filter(|_| i == 1), release.filter(|_| i == n));
        }
        let r = watch.finish(3, true).unwrap();
        assert_eq!((r.contact, r.start, r.end), (3, 0.0, 1.0));
        // A parabola through three points of a sine, spacing h: error of order (pi h)^4 / 64.
        assert!((r.peak_force / peak - 1.0).abs() < 1e-4, "{r:?}");
        assert!((r.peak_time - 0.5).abs() < 1e-3);
        assert!((r.impulse - 2.0 * peak / std::f64::consts::PI).abs() < 1e-12);
        assert!((r.approach_velocity - 2.0).abs() < 1e-15 && (r.restitution - 0.95).abs() < 1e-12);
        assert!(!watch.is_running());
    }

    #[test]
    fn penetration_is_a_share_of_the_approach() {
        let mut watch = ImpactMonitor::default();
        assert_eq!(watch.overlap_share(0.0), None);
        // Speed falls from 2 m/s at the touch at 0.5 s to none at 2.5 s and turns: an approach of 2 m, of which 0.1 m is penetration.
        for (t, velocity, penetration) in
            [(0.0, -2.5, 0.0), (1.0, -1.5, 0.06), (2.0, -0.5, 0.1), (3.0, 0.5, 0.02)]
        {
            let now = ContactInstant { penetration, ..instant(t, t, 0.0, velocity) };
            watch.step(now, change(0.5, -2.0).filter(|_| (0.5..1.5).contains(&t)), None);
        }
        // The trapezium over the step of the touch takes its speed at the step's start: 1.0 m from there to 1 s where 0.875 m is right.
        let share = watch.overlap_share(0.0).expect("it runs");
        assert!((share - 0.1 / 2.0).abs() < 1e-12, "{share}");
    }

    #[test]
    fn peak_is_not_sought_between_steps_of_very_different_size() {
        let mut watch = ImpactMonitor::default();
        // After a failing step the next one is 1e-9 as long, its small change of force is noise.
        for (t, f) in [(0.0, 0.0), (1.0, 5.0), (1.0 + 1e-9, 4.99), (2.0, 4.0)] {
            watch.step(instant(t, f, 0.0, 0.0), None, None);
        }
        assert!((watch.peak_force() - 5.0).abs() < 1e-15, "{}", watch.peak_force());
    }

    #[test]
    fn watch_that_begins_again_forgets_what_it_saw() {
        let mut watch = ImpactMonitor::default();
        watch.step(instant(0.0, 0.0, 0.0, 3.0), None, None);
        watch.begin(instant(5.0, 1e-9, 2.0, -0.1));
        watch.step(instant(6.0, 4.0, 3.0, 0.0), None, None);
        let r = watch.finish(0, true).unwrap();
        assert_eq!((r.start, r.approach_velocity, r.impulse), (5.0, 0.1, 1.0));
    }

    #[test]
    fn contact_that_opens_and_closes_again_is_one_impact() {
        let mut watch = ImpactMonitor::default();
        for (t, f) in [(0.0, 0.0), (1.0, 4.0), (2.0, 0.0), (3.0, 5.0), (4.0, 0.0)] {
            watch.step(instant(t, f, 0.0, 0.0), None, change(t - 0.5, 0.0));
        }
        let r = watch.finish(0, true).unwrap();
        assert_eq!((r.start, r.end, r.peak_force), (0.0, 3.5, 5.0));
    }

    /// A touch from 0.25 to 2.75 s; speeds at the ends of steps differ from those at the touch, as under gravity.
    fn bounce(approach: f64, separation: f64) -> ImpactMonitor {
        let mut watch = ImpactMonitor::default();
        watch.step(instant(0.0, 0.0, 0.0, -approach + 0.1), None, None);
        watch.step(instant(1.0, 5.0, 1.0, 0.0), change(0.25, -approach), None);
        watch.step(instant(2.0, 5.0, 2.0, 0.0), None, None);
        watch.step(instant(3.0, 0.0, 2.0, separation - 0.1), None, change(2.75, separation));
        watch
    }

    #[test]
    fn velocities_are_those_at_touch_and_release() {
        let r = bounce(2.0, 1.5).finish(0, true).unwrap();
        let found = [r.approach_velocity, r.separation_velocity, r.restitution];
        assert!(found.iter().zip([2.0, 1.5, 0.75]).all(|(a, b)| (a - b).abs() < 1e-15), "{r:?}");
    }

    #[test]
    fn restitution_is_no_number_where_it_has_no_meaning() {
        let of = |mut watch: ImpactMonitor, is_alone| watch.finish(0, is_alone).unwrap();
        // Pushed from behind at rest, and with nothing but round-off.
        assert!(of(bounce(0.0, 1.5), true).restitution.is_nan());
        assert!(of(bounce(1e-14, 1.5), true).restitution.is_nan());
        // The rigid motions go on approaching each other.
        assert!(of(bounce(2.0, -0.5), true).restitution.is_nan());
        // Another contact pressed the same bodies.
        let r = of(bounce(2.0, 1.5), false);
        assert!(r.restitution.is_nan() && r.separation_velocity > 1.0, "{r:?}");
        // Time is up in contact.
        let mut watch = bounce(2.0, 1.5);
        watch.step(instant(4.0, 1.0, 3.0, 0.0), None, None);
        let r = of(watch, true);
        assert!(r.restitution.is_nan() && r.separation_velocity.is_nan(), "{r:?}");
    }
}
