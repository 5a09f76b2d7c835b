//! Follows what a contact does while it presses: stick, slip and rest (docs/theory.md section Q.5).

use std::f64::consts::TAU;

use nalgebra::{Isometry3, Point3, Vector3};

use super::ContactInstant;
use crate::record::{EventKind, EventRecord};

/// Steps for which points stick or slide before that is told: what changes sooner is not resolved by the steps.
const HELD: u32 = 3;
/// Periods for which bodies stay in their places to rest: an impact, whose bodies yield and part again, lasts half of one, or some where
/// waves press them.
const PERIODS: f64 = 4.0;

/// What the points of a contact do, where its bodies are, and what it does beside its force.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hold {
    /// What its points do along the surfaces; none without friction.
    pub slip: Option<EventKind>,
    /// Size of the friction force \[N\].
    pub friction: f64,
    /// How far the bodies have yielded by the energy that the contact holds, as a spring \[m\].
    pub yielded: f64,
    /// Where they touch, in space \[m\].
    pub place: Vector3<f64>,
    /// Poses of both bodies; what does not move has none.
    pub poses: [Option<Isometry3<f64>>; 2],
    /// Mass of the bodies against each other \[kg\].
    pub mass: f64,
    /// Length by which a turn counts as a way: the size of the contact body \[m\].
    pub size: f64,
}

impl Hold {
    /// How far the bodies have moved along and about each other between this instant and `later`: the way between the two material points
    /// that were at the place of contact, and that of a turn \[m\].
    fn way(&self, later: &Self) -> f64 {
        let moves = [0, 1].map(|side| match (self.poses[side], later.poses[side]) {
            (Some(before), Some(after)) => after * before.inverse(),
            _ => Isometry3::identity(),
        });
        let places = moves.map(|motion| motion * Point3::from(self.place));
        (places[0] - places[1]).norm() + self.size * moves[0].rotation.angle_to(&moves[1].rotation)
    }
}

/// Events of a contact in a phase so far, and what tells the next one.
#[derive(Debug, Clone, Default)]
pub struct Course {
    events: Vec<EventRecord>,
    is_closed: bool,
    /// What its points do, once it has been told.
    slip: Option<EventKind>,
    /// What they have done for some steps.
    next: Option<(EventRecord, u32)>,
    /// When all points have ceased to slide in this touch \[s\].
    stuck: f64,
    /// The instant that the bodies have moved from by less than twice what they yield by.
    still: Option<ContactInstant>,
    /// Whether that is rest, and how often rest has ended in this touch.
    rests: bool,
    n_rests: i32,
}

impl Course {
    /// The events so far, which are forgotten; those of the points first that have not lasted yet, if nothing else is known of them.
    pub fn take(&mut self) -> Vec<EventRecord> {
        self.tell_first();
        std::mem::take(self).events
    }

    /// The contact has closed at `time`, or goes on in another zone or with another penalty factor.
    pub fn touch(&mut self, time: f64, now: &ContactInstant) {
        if self.is_closed {
            return;
        }
        (self.is_closed, self.stuck) = (true, time);
        self.tell(EventKind::Touch, time, 0.0);
        let next = now.hold.slip.map(|kind| EventRecord { kind, time, normal_force: now.force, contact: 0 });
        self.next = next.map(|next| (next, 0));
    }

    /// The contact has opened at `time`.
    pub fn release(&mut self, time: f64) {
        self.tell_first();
        self.tell(EventKind::Release, time, 0.0);
        *self = Self { events: std::mem::take(&mut self.events), ..Self::default() };
    }

    /// Force acts at the instant `now`, after the two instants `earlier`; the bodies have approached each other by `approach` \[m\].
    pub fn press(&mut self, earlier: [Option<&ContactInstant>; 2], now: &ContactInstant, approach: f64) {
        self.see_slip(earlier, now);
        self.see_way(now, approach.max(now.hold.yielded));
    }

    fn tell(&mut self, kind: EventKind, time: f64, normal_force: f64) {
        self.events.push(EventRecord { kind, time, normal_force, contact: 0 });
    }

    /// What points do in a touch that is shorter than the steps for which they are to do it.
    fn tell_first(&mut self) {
        if let Some((next, _)) = self.next.take().filter(|_| self.slip.is_none()) {
            self.events.push(next);
            self.slip = Some(next.kind);
        }
    }

    fn see_slip(&mut self, earlier: [Option<&ContactInstant>; 2], now: &ContactInstant) {
        let Some(kind) = now.hold.slip else { return };
        if self.slip == Some(kind) {
            self.next = None;
            return;
        }
        let (next, steps) = match self.next.take() {
            Some((next, steps)) if next.kind == kind => (next, steps + 1),
            _ => {
                let time = located(self.slip, kind, earlier, now);
                (EventRecord { kind, time, normal_force: now.force, contact: 0 }, 1)
            }
        };
        if steps < HELD {
            self.next = Some((next, steps));
            return;
        }
        self.events.push(next);
        if self.slip == Some(EventKind::Slip) {
            self.stuck = next.time;
        }
        self.slip = Some(kind);
    }

    /// Sees whether the bodies have moved by more than twice the way `yielded` \[m\] (Eq. Q.10).
    fn see_way(&mut self, now: &ContactInstant, yielded: f64) {
        // As far as bodies that tremble about a place go from one end of their way to the other while they press each other.
        let still = self.still.filter(|still| still.hold.way(&now.hold) <= 2.0 * yielded);
        let Some(still) = still else {
            if self.rests {
                self.tell(EventKind::Motion, now.time, now.force);
                (self.rests, self.n_rests) = (false, self.n_rests + 1);
            }
            self.still = Some(*now);
            return;
        };
        let period = TAU * (now.hold.mass * yielded / now.force).sqrt();
        if !self.rests && now.time - still.time >= PERIODS * period * f64::exp2(f64::from(self.n_rests)) {
            self.rests = true;
            self.tell(EventKind::Rest, still.time.max(self.stuck.min(now.time)), now.force);
        }
    }
}

/// When the points of a contact came to do `kind` in the step to `now`, before which they did `before`: where the speed of sliding, or the
/// friction per normal force, comes to where it then is on the line through its values at the ends of the two steps before.
fn located(
    before: Option<EventKind>,
    kind: EventKind,
    earlier: [Option<&ContactInstant>; 2],
    now: &ContactInstant,
) -> f64 {
    let [Some(first), Some(last)] = earlier else { return now.time };
    let speed = |instant: &ContactInstant| {
        let velocity = Vector3::from(instant.motion.velocity);
        (velocity - instant.normal * velocity.dot(&instant.normal)).norm()
    };
    let share = |instant: &ContactInstant| instant.hold.friction / instant.force;
    let line: [f64; 3] = match (before, kind) {
        (Some(EventKind::Slip), EventKind::Stick) => [speed(first), speed(last), 0.0],
        (Some(_), EventKind::Slip) => [share(first), share(last), share(now)],
        _ => return now.time,
    };
    let time = last.time + (line[2] - line[1]) * (last.time - first.time) / (line[1] - line[0]);
    if time >= last.time && time <= now.time { time } else { now.time }
}

#[cfg(test)]
mod tests {
    use super::super::ImpactMonitor;
    use super::*;
    use crate::state::impact_monitor::{Change, NearMotion};

    /// A mass of 2 kg that a force of 8 N presses and a spring holds that yields by 1e-3 m: its period is 2π/√(8/(2·1e-3)) s, 0.0993 s.
    fn instant(time: f64, force: f64, x: f64, speed: f64, slip: EventKind) -> ContactInstant {
        let velocity = [speed, 0.0, 0.0];
        let place = Vector3::new(x, 0.0, 0.0);
        let hold = Hold {
            slip: Some(slip),
            friction: 0.3 * force,
            yielded: 1e-3,
            place,
            poses: [Some(Isometry3::translation(x, 0.0, 0.0)), None],
            mass: 2.0,
            size: 0.5,
        };
        ContactInstant {
            time,
            force,
            impulse: Vector3::zeros(),
            normal: Vector3::z(),
            motion: NearMotion { velocity, speed: speed.abs(), vibration: 0.0 },
            penetration: 0.0,
            of_springs: None,
            hold,
        }
    }

    fn told(monitor: &mut ImpactMonitor) -> Vec<(&'static str, f64)> {
        monitor.take_events().iter().map(|event| (event.kind.identifier(), event.time)).collect()
    }

    #[test]
    fn a_mass_slides_until_friction_has_braked_it_and_rests() {
        // x = v t - a t²/2, v = 1, a = 2: it stands from 0.5 s on, in the middle of a step.
        let mut monitor = ImpactMonitor::default();
        monitor.begin(instant(0.0, 0.0, 0.0, 1.0, EventKind::Stick));
        let touch = Change { time: 0.01, motion: instant(0.0, 0.0, 0.0, 1.0, EventKind::Slip).motion };
        let step = 0.04;
        for k in 1..60 {
            let t = step * f64::from(k);
            let slides = t < 0.5;
            let (x, v) = if slides { (t - t * t, 1.0 - 2.0 * t) } else { (0.25, 0.0) };
            let kind = if slides { EventKind::Slip } else { EventKind::Stick };
            monitor.step(instant(t, 8.0, x, v, kind), (k == 1).then_some(touch), None);
        }
        let events = told(&mut monitor);
        let names: Vec<_> = events.iter().map(|event| event.0).collect();
        assert_eq!(names, ["touch", "slip", "stick", "rest"]);
        // The speed falls on a line: its end is where it is, to round-off.
        let expected = [0.01, 0.01, 0.5, 0.5];
        for ((name, time), expected) in events.iter().zip(expected) {
            assert!((time - expected).abs() < 1e-12, "{name} {time}");
        }
    }

    #[test]
    fn slip_begins_where_friction_has_come_to_its_bound() {
        // The share of friction grows to the bound 0.3 by 0.1 a second from 0.255 on: after 0.45 s, between two steps of 0.1 s.
        let mut monitor = ImpactMonitor::default();
        for k in 0..9 {
            let t = 0.1 * f64::from(k);
            let share = (0.255 + 0.1 * t).min(0.3);
            let kind = if t < 0.45 { EventKind::Stick } else { EventKind::Slip };
            let mut now = instant(t, 8.0, 0.0, 0.0, kind);
            now.hold.friction = share * 8.0;
            if k == 0 {
                monitor.begin(now);
            } else {
                monitor.step(now, None, None);
            }
        }
        let events = told(&mut monitor);
        let slip = events.iter().find(|event| event.0 == "slip").expect("it slides");
        assert!((slip.1 - 0.45).abs() < 1e-12, "{}", slip.1); // round-off
    }

    #[test]
    fn what_rolls_or_trembles_does_not_slide_and_what_trembles_rests() {
        let run = |turns: bool| {
            let mut monitor = ImpactMonitor::default();
            monitor.begin(instant(0.0, 8.0, 0.0, 0.0, EventKind::Stick));
            for k in 1..200 {
                let t = 1e-2 * f64::from(k);
                // It trembles by 0.9 of what it yields by.
                let mut now = instant(t, 8.0, 9e-4 * (300.0 * t).sin(), 0.1, EventKind::Stick);
                if turns && let Some(pose) = &mut now.hold.poses[0] {
                    // Rolls at 0.1 rad/s: 0.5 m times that in a period of 0.1 s is five times what it yields by.
                    pose.rotation = nalgebra::UnitQuaternion::from_scaled_axis(Vector3::y() * (0.1 * t));
                }
                monitor.step(now, None, None);
            }
            let kinds: Vec<_> = told(&mut monitor).iter().map(|event| event.0).collect();
            kinds
        };
        assert_eq!(run(false), ["touch", "stick", "rest"]);
        assert_eq!(run(true), ["touch", "stick"]);
    }

    #[test]
    fn what_creeps_tells_rest_and_motion_ever_more_seldom() {
        // A tenth of what it yields by in a period: it has moved by twice that after twenty of them, and is told to rest after 4, 8, 16 of
        // them.
        let mut monitor = ImpactMonitor::default();
        let period = TAU * (2.0 * 1e-3 / 8.0_f64).sqrt();
        monitor.begin(instant(0.0, 8.0, 0.0, 0.0, EventKind::Stick));
        for k in 1..30_000 {
            let t = 1e-2 * f64::from(k);
            monitor.step(instant(t, 8.0, 1e-4 / period * t, 1e-4 / period, EventKind::Stick), None, None);
        }
        let kinds: Vec<_> = told(&mut monitor).iter().map(|event| event.0).collect();
        assert_eq!(kinds, ["touch", "stick", "rest", "motion", "rest", "motion", "rest", "motion"]);
    }

    #[test]
    fn a_touch_of_two_steps_tells_what_its_points_did() {
        let mut monitor = ImpactMonitor::default();
        monitor.begin(instant(0.0, 0.0, 0.0, 1.0, EventKind::Stick));
        monitor.step(instant(1.0, 8.0, 0.0, 1.0, EventKind::Slip), None, None);
        monitor.step(instant(2.0, 0.0, 0.0, 1.0, EventKind::Stick), None, None);
        assert_eq!(told(&mut monitor), [("touch", 0.0), ("slip", 0.0), ("release", 2.0)]);
    }
}
