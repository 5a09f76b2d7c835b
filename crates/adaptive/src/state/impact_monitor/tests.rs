//! Instants, peaks and impulses as an impact goes on.

use super::*;

fn instant(time: f64, force: f64, impulse: f64, velocity: f64) -> ContactInstant {
    let [impulse, velocity] = [impulse, velocity].map(|size| Vector3::z() * size);
    let normal = Vector3::z();
    let hold = Hold {
        slip: None,
        friction: 0.0,
        yielded: 0.0,
        place: Vector3::zeros(),
        poses: [None; 2],
        mass: 1.0,
        size: 1.0,
    };
    let (motion, penetration, of_springs) = (motion(velocity), 0.0, None);
    ContactInstant { time, force, impulse, normal, motion, penetration, of_springs, hold }
}

fn motion(velocity: Vector3<f64>) -> NearMotion {
    NearMotion { velocity: velocity.into(), speed: velocity.norm(), vibration: 0.0 }
}

fn only(watch: &mut ImpactMonitor) -> ImpactRecord {
    let mut records = watch.finish(0, 0, |_| true);
    assert_eq!(records.len(), 1);
    records.remove(0)
}

fn change(time: f64, velocity: f64) -> Option<Change> {
    Some(Change { time, motion: motion(Vector3::z() * velocity) })
}

#[test]
fn bodies_sliding_past_each_other_part_as_fast_as_they_met() {
    // No loss, no friction: the velocity is mirrored at the mean normal, from which the normal
    // turns by 0.01 to both sides.
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
                impulse,
                normal: normal(angle),
                motion: motion(velocity),
                ..instant(t, force, 0.0, 0.0)
            },
            None,
            None,
        );
    }
    let r = only(&mut watch);
    // Round-off.
    assert!((r.restitution - 1.0).abs() < 1e-15 && (r.approach_velocity - approach).abs() < 1e-15, "{r:?}");
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
    let r = watch.finish(3, 0, |_| true).remove(0);
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
    assert_eq!(watch.overlap_share(0.0, 0.0), None);
    // Speed falls from 2 m/s at the touch at 0.5 s to none at 2.5 s and turns: an approach of 2
    // m, of which 0.1 m is penetration.
    for (t, velocity, penetration) in
        [(0.0, -2.5, 0.0), (1.0, -1.5, 0.06), (2.0, -0.5, 0.1), (3.0, 0.5, 0.02)]
    {
        let now = ContactInstant { penetration, ..instant(t, t, 0.0, velocity) };
        watch.step(now, change(0.5, -2.0).filter(|_| (0.5..1.5).contains(&t)), None);
    }
    // What is penetration later counts for the approach of then. The trapezium over the step of
    // the touch takes its speed at the step's start: 1.0 m from there to 1 s where 0.875 m is
    // right.
    let (share, time) = watch.overlap_share(0.0, 0.0).expect("it runs");
    assert!((share - 0.1 / 2.0).abs() < 1e-12, "{share}");
    assert!((time - 1.5).abs() < 1e-12, "{time}");
    // Bodies that overlapped by 4 m before have approached by that.
    let of_overlapping = watch.overlap_share(0.0, 4.0).expect("it runs").0;
    assert!((of_overlapping - 0.1 / 4.0).abs() < 1e-12, "{of_overlapping}");
}

#[test]
fn what_vibrates_against_its_rigid_motion_is_judged_by_the_energy_at_the_largest_force() {
    let mut watch = ImpactMonitor::default();
    for (t, force, share) in
        [(0.0, 0.0, None), (1.0, 2.0, Some(0.3)), (2.0, 5.0, Some(0.2)), (3.0, 1.0, Some(0.4))]
    {
        let penetration = 1e-6 * force;
        let now = ContactInstant { penetration, of_springs: share, ..instant(t, force, 0.0, 1.0) };
        watch.step(now, change(0.5, 1.0).filter(|_| (0.5..1.5).contains(&t)), None);
    }
    assert_eq!(watch.overlap_share(0.0, 0.0), Some((0.2, 1.5)));
    // Round-off of places says nothing.
    assert_eq!(watch.overlap_share(5e-6, 0.0), None);
}

#[test]
fn what_rests_was_nearest_when_it_began_to() {
    // Pressed in by 0.1 of an approach of 1 m, and by what a step leaves later.
    for (speed, later) in [(1e-6, 0.0), (-1e-6, 0.0), (0.1, 2.0)] {
        let mut watch = ImpactMonitor::default();
        for t in [0.0, 1.0, 2.0] {
            let now = ContactInstant { penetration: 0.1, ..instant(t, 1.0, 0.0, -speed) };
            watch.step(now, None, None);
        }
        let (share, time) = watch.overlap_share(0.0, 1.0).expect("it runs");
        assert!((share - 0.1).abs() < 1e-15 && (time - later).abs() < 1e-15, "{speed} {share} {time}");
    }
}

#[test]
fn the_normal_is_that_of_the_peak_between_two_steps() {
    let mut watch = ImpactMonitor::default();
    // The normal turns evenly by 0.2 rad a second; the parabola through the forces 3, 4, 3.5 has
    // its top a sixth of a second behind the middle one.
    for (t, force) in [(0.0, 0.0), (1.0, 3.0), (2.0, 4.0), (3.0, 3.5)] {
        let angle: f64 = 0.2 * (t - 2.0);
        let normal = Vector3::new(angle.sin(), 0.0, angle.cos());
        watch.step(ContactInstant { normal, ..instant(t, force, 0.0, 0.0) }, None, None);
    }
    let turned = Vector3::from(watch.running.expect("it runs").normal);
    // Chords turn as evenly as arcs to the cube of the angle between steps.
    assert!((turned.x.atan2(turned.z) - 0.2 / 6.0).abs() < 0.2_f64.powi(3), "{turned}");
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
    let r = only(&mut watch);
    assert_eq!((r.start, r.approach_velocity, r.impulse), (5.0, 0.1, 1.0));
}

/// Touches from start to end \[s\] with a peak \[N\] each in steps of `h`, numbers of steps
/// apart; a phase ends after the touches numbered `ends`.
fn touches(list: &[(f64, f64, f64)], h: f64, ends: &[usize]) -> Vec<ImpactRecord> {
    let (mut watch, mut records) = (ImpactMonitor::default(), Vec::<ImpactRecord>::new());
    let mut finish = |watch: &mut ImpactMonitor| {
        let next = records.iter().map(|r| r.row + 1).max().unwrap_or(0);
        for record in watch.finish(0, next, |_| true) {
            records.retain(|r| r.row != record.row);
            records.push(record);
        }
    };
    let mut impulse = 0.0;
    for (k, (start, end, peak)) in list.iter().enumerate() {
        watch.step(instant(start - 0.5 * h, 0.0, impulse, -1.0), None, None);
        let n = ((end - start) / h).round() as i32;
        for i in 1..=n {
            let t = start + f64::from(i) * h;
            let force =
                if i < n { peak * (std::f64::consts::PI * f64::from(i) / f64::from(n)).sin() } else { 0.0 };
            impulse += peak * h;
            watch.step(
                instant(t, force, impulse, 1.0),
                change(*start, -1.0).filter(|_| i == 1),
                change(*end, 1.0).filter(|_| i == n),
            );
        }
        if ends.contains(&k) {
            finish(&mut watch);
            watch.begin(instant(end + 0.1 * h, 0.0, impulse, 0.0));
        }
    }
    finish(&mut watch);
    records.sort_by_key(|r| r.row);
    records
}

#[test]
fn touches_are_one_impact_while_they_follow_sooner_than_the_longest_lasts() {
    // 4 s long, 1 s apart: joined. 2 s long after 3 s: joined by the first, though longer apart
    // than it lasts. After 6 s: another.
    let list = [(0.0, 4.0, 4.0), (5.0, 7.0, 5.0), (10.0, 11.0, 1.0), (17.0, 19.0, 2.0)];
    let of = |records: &[ImpactRecord]| -> Vec<_> {
        records.iter().map(|r| (r.row, r.start, r.end, r.impulse)).collect()
    };
    for h in [0.25, 0.125] {
        let found = touches(&list, h, &[]);
        let expected = [(0, 0.0, 11.0, 16.0 + 10.0 + 1.0), (1, 17.0, 19.0, 4.0)];
        assert_eq!(of(&found), expected);
        assert!((found[0].peak_force - 5.0).abs() < 1e-2 && (found[1].peak_force - 2.0).abs() < 1e-2);
        // Wherever phases end.
        for ends in [&[0][..], &[1], &[2], &[0, 1, 2], &[0, 2]] {
            assert_eq!(of(&touches(&list, h, ends)), expected, "{ends:?}");
        }
    }
}

#[test]
fn a_touch_shorter_than_the_way_to_a_longer_one_is_its_beginning() {
    // The first contact point flutters before the bodies press each other.
    let list = [(0.0, 0.25, 0.5), (1.0, 5.0, 4.0), (10.0, 10.25, 6.0), (10.75, 11.0, 1.0)];
    for ends in [&[][..], &[0], &[0, 1], &[2]] {
        let found: Vec<_> =
            touches(&list, 0.125, ends).iter().map(|r| (r.row, r.start, r.end, r.impulse)).collect();
        assert_eq!(
            found,
            [(0, 0.0, 5.0, 0.125 + 16.0), (1, 10.0, 10.25, 1.5), (2, 10.75, 11.0, 0.25)],
            "{ends:?}"
        );
    }
}

#[test]
fn bodies_that_ring_before_they_touch_have_no_restitution() {
    let of = |vibration: f64| {
        let mut watch = bounce(2.0, 1.5);
        if let Some(impact) = &mut watch.running {
            impact.before.vibration = vibration;
        }
        only(&mut watch).restitution
    };
    assert!((of(0.199) - 0.75).abs() < 1e-15 && of(0.201).is_nan());
}

/// A touch from 0.25 to 2.75 s; speeds at the ends of steps differ from those at the touch, as
/// under gravity.
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
    let r = only(&mut bounce(2.0, 1.5));
    let found = [r.approach_velocity, r.separation_velocity, r.restitution];
    assert!(found.iter().zip([2.0, 1.5, 0.75]).all(|(a, b)| (a - b).abs() < 1e-15), "{r:?}");
}

#[test]
fn restitution_is_no_number_where_it_has_no_meaning() {
    let of = |mut watch: ImpactMonitor, is_alone| watch.finish(0, 0, |_| is_alone).remove(0);
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
