//! Follows one contact through an impact: first and last touch, peak force, impulse, velocities.

use nalgebra::Vector3;

use crate::record::ImpactRecord;

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
    /// Velocity of the contact body's centre of mass relative to the target's [m/s].
    pub velocity: Vector3<f64>,
}

/// State of a watched contact.
#[derive(Debug, Clone, Default)]
pub struct ImpactWatch {
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
    velocity_before: Vector3<f64>,
    impulse: Vector3<f64>,
    velocity_after: Vector3<f64>,
}

impl ImpactWatch {
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

    /// Peak force so far \[N\].
    pub fn peak_force(&self) -> f64 {
        self.record.as_ref().map_or(0.0, |r| r.peak_force)
    }

    /// Takes the instant at which watching begins: what was seen in earlier phases does not count.
    pub fn begin(&mut self, now: ContactInstant) {
        (self.last, self.before_last) = (None, None);
        self.step(now, None, None);
    }

    /// Takes the end of an accepted step. `touch` and `release` are the times at which the contact closed or opened within
    /// the step, if it did \[s\]. Returns whether the force reached a new maximum at this instant.
    pub fn step(&mut self, now: ContactInstant, touch: Option<f64>, release: Option<f64>) -> bool {
        if now.force > 0.0 && self.record.is_none() {
            let before = self.last.unwrap_or(now);
            self.record = Some(Running {
                start: touch.unwrap_or(before.time),
                end: now.time,
                peak_force: 0.0,
                peak_time: now.time,
                normal: now.normal,
                impulse_at_start: before.impulse,
                velocity_before: before.velocity,
                impulse: Vector3::zeros(),
                velocity_after: now.velocity,
            });
        }
        let mut is_new_peak = false;
        if let Some(running) = &mut self.record {
            let was_touching = self.last.is_some_and(|l| l.force > 0.0);
            if now.force > 0.0 {
                running.end = now.time;
            } else if was_touching {
                running.end = release.unwrap_or(now.time);
            }
            // Points may touch within a step and at neither of its ends.
            running.impulse = now.impulse - running.impulse_at_start;
            if now.force > 0.0 || was_touching {
                running.velocity_after = now.velocity;
            }
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

    /// Ends the running impact and returns its record; `contact` is the contact's index.
    pub fn finish(&mut self, contact: u32) -> Option<ImpactRecord> {
        self.record.take().map(|r| {
            let (approach, separation) = (-r.velocity_before.dot(&r.normal), r.velocity_after.dot(&r.normal));
            ImpactRecord {
                contact,
                start: r.start,
                end: r.end,
                peak_force: r.peak_force,
                peak_time: r.peak_time,
                impulse: r.impulse.dot(&r.normal),
                approach_velocity: approach,
                separation_velocity: separation,
                restitution: separation / approach,
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
        ContactInstant { time, force, impulse, normal: Vector3::z(), velocity }
    }

    #[test]
    fn bodies_sliding_past_each_other_part_as_fast_as_they_met() {
        // No loss, no friction: the velocity is mirrored at the mean normal, from which the normal turns by 0.01 to both sides.
        let normal = |angle: f64| Vector3::new(angle.sin(), 0.0, angle.cos());
        let mut velocity = Vector3::new(2.0, 0.0, -1.0);
        let approach = -velocity.dot(&normal(0.0));
        let mut watch = ImpactWatch::default();
        for (t, force, angle) in
            [(0.0, 0.0, -0.01), (1.0, 5.0, -0.005), (2.0, 7.0, 0.0), (3.0, 5.0, 0.005), (4.0, 0.0, 0.01)]
        {
            if t > 2.0 {
                velocity = Vector3::new(2.0, 0.0, 1.0);
            }
            let impulse = Vector3::z() * if t > 2.0 { 2.0 } else { 0.0 };
            watch.step(
                ContactInstant { time: t, force, impulse, normal: normal(angle), velocity },
                None,
                None,
            );
        }
        let r = watch.finish(0).unwrap();
        // Round-off.
        assert!(
            (r.restitution - 1.0).abs() < 1e-15 && (r.approach_velocity - approach).abs() < 1e-15,
            "{r:?}"
        );
        assert!((r.impulse - 2.0).abs() < 1e-15);
    }

    #[test]
    fn half_sine_impact_is_recorded_with_peak_between_steps() {
        let mut watch = ImpactWatch::default();
        let (n, peak, duration) = (23, 50.0, 1.0); // 23 steps never hit the middle
        watch.step(instant(-0.1, 0.0, 7.0, -2.0), None, None);
        for i in 1..=n {
            let t = i as f64 / n as f64;
            let force = if i == n { 0.0 } else { peak * (std::f64::consts::PI * t).sin() };
            let impulse = 7.0 + peak / std::f64::consts::PI * (1.0 - (std::f64::consts::PI * t).cos());
            let touch = (i == 1).then_some(0.0);
            watch.step(instant(t * duration, force, impulse, -2.0 + 3.9 * t), touch, (i == n).then_some(1.0));
        }
        let r = watch.finish(3).unwrap();
        assert_eq!((r.contact, r.start, r.end), (3, 0.0, 1.0));
        // A parabola through three points of a sine, spacing h: error of order (pi h)^4 / 64.
        assert!((r.peak_force / peak - 1.0).abs() < 1e-4, "{r:?}");
        assert!((r.peak_time - 0.5).abs() < 1e-3);
        assert!((r.impulse - 2.0 * peak / std::f64::consts::PI).abs() < 1e-12);
        assert!((r.approach_velocity - 2.0).abs() < 1e-15 && (r.restitution - 0.95).abs() < 1e-12);
        assert!(!watch.is_running());
    }

    #[test]
    fn peak_is_not_sought_between_steps_of_very_different_size() {
        let mut watch = ImpactWatch::default();
        // After a failing step the next one is 1e-9 as long, its small change of force is noise.
        for (t, f) in [(0.0, 0.0), (1.0, 5.0), (1.0 + 1e-9, 4.99), (2.0, 4.0)] {
            watch.step(instant(t, f, 0.0, 0.0), None, None);
        }
        assert!((watch.peak_force() - 5.0).abs() < 1e-15, "{}", watch.peak_force());
    }

    #[test]
    fn watch_that_begins_again_forgets_what_it_saw() {
        let mut watch = ImpactWatch::default();
        watch.step(instant(0.0, 0.0, 0.0, 3.0), None, None);
        watch.begin(instant(5.0, 1e-9, 2.0, -0.1));
        watch.step(instant(6.0, 4.0, 3.0, 0.0), None, None);
        let r = watch.finish(0).unwrap();
        assert_eq!((r.start, r.approach_velocity, r.impulse), (5.0, 0.1, 1.0));
    }

    #[test]
    fn contact_that_opens_and_closes_again_is_one_impact() {
        let mut watch = ImpactWatch::default();
        for (t, f) in [(0.0, 0.0), (1.0, 4.0), (2.0, 0.0), (3.0, 5.0), (4.0, 0.0)] {
            watch.step(instant(t, f, 0.0, 0.0), None, Some(t - 0.5));
        }
        let r = watch.finish(0).unwrap();
        assert_eq!((r.start, r.end, r.peak_force), (0.0, 3.5, 5.0));
    }
}
