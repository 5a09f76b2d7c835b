//! Friction of a Hertz contact over steps: what it depends on their length.

use contact_qs::law::Solid;
use contact_qs::{ActiveContact, HertzContact, Plane, Sphere, Target};
use ffr_dynamics::force::active::{Active, ActiveForce};
use ffr_dynamics::force::{BodyState, GeneralisedForce, Motion};
use ffr_dynamics::kinematics::FlexiblePoint;
use nalgebra::Vector3;

const STEEL: Solid = Solid { young: 2.1e11, poisson: 0.3 };
/// Radius of the ball \[m\].
const RADIUS: f64 = 0.01;
/// Deepest approach \[m\].
const DEPTH: f64 = 2e-5;
/// How long a course takes \[s\].
const END: f64 = 1e-4;

/// Place of the ball over the time, from where it touches undeformed.
type Course<'a> = &'a dyn Fn(f64) -> Vector3<f64>;

fn ball_on_plane(friction: f64) -> Active<HertzContact> {
    let centre = FlexiblePoint::rigid(Vector3::zeros());
    let sphere = Sphere { body: 0, centre, radius: RADIUS, solid: STEEL };
    let plane = Plane { point: Vector3::zeros(), normal: Vector3::z_axis() };
    let contact = HertzContact::of_spheres(sphere, Target::Plane(plane), STEEL).unwrap();
    Active::new(contact.with_friction(friction).unwrap())
}

fn evaluate(contact: &mut Active<HertzContact>, course: Course<'_>, time: f64) {
    let mut ball = BodyState::at_rest(0);
    ball.position = course(time) + Vector3::z() * RADIUS;
    // Difference to both sides: off by a billionth.
    let h = 1e-4 * END;
    ball.velocity = (course(time + h) - course(time - h)) / (2.0 * h);
    contact.evaluate(Motion::new(time, &[ball]), &mut [GeneralisedForce::zeros(0)]).unwrap();
}

/// Force of friction at the end of the course after `n` equal steps.
fn force_after(friction: f64, course: Course<'_>, n: u32) -> Vector3<f64> {
    let mut contact = ball_on_plane(friction);
    for k in 0..=n {
        evaluate(&mut contact, course, END * f64::from(k) / f64::from(n));
        contact.save();
    }
    contact.report().friction_force
}

/// Errors of the force after 10, 20, 40 and 80 steps, over that of a run of very short ones, whose own error is 1/1000 of the last.
fn errors(friction: f64, course: Course<'_>) -> [f64; 4] {
    let exact = force_after(friction, course, 2560);
    [10, 20, 40, 80].map(|n| (force_after(friction, course, n) - exact).norm() / exact.norm())
}

/// Orders that halved steps show.
fn orders(errors: [f64; 4]) -> [f64; 3] {
    [0, 1, 2].map(|k| (errors[k] / errors[k + 1]).log2())
}

/// Slides on an arc, by one radian in all, at the height `z`.
fn arc(time: f64, z: f64) -> Vector3<f64> {
    let (radius, turned) = (4e-5, time / END);
    Vector3::new(radius * turned.sin(), radius * (1.0 - turned.cos()), z)
}

#[test]
fn a_slide_that_turns_is_of_second_order_in_the_step() {
    let found = errors(0.3, &|time| arc(time, -DEPTH));
    // The implicit rule of Euler lags behind by half the turn within a step, 0.05 with 10 steps. Two stages leave a part of the square of the turn, 0.01:
    // a fiftieth, which 4e-4 is twice of.
    assert!(found[0] < 4e-4, "{found:?}");
    assert!(orders(found).iter().all(|order| *order > 1.8), "{found:?}");
}

#[test]
fn springs_count_the_slip_from_when_the_approach_reached_them() {
    // So rough that nothing slides. In proportion to the approach the slip is known wherever the steps end.
    let found = errors(1e3, &|time| Vector3::new(0.1, 0.03, -1.0) * (DEPTH * time / END));
    // Round-off of places 0.01 m from the origin over the slip of 2e-6 m.
    assert!(found.iter().all(|error| *error < 1e-11), "{found:?}");
    // Other slips are in proportion to the square of a step; counted from the beginning of the step they are of the first order, 0.07 with 10.
    let found = errors(1e3, &|time| Vector3::new(0.1 * (time / END).powi(2), 0.03, -time / END) * DEPTH);
    assert!(found[0] < 4e-3, "{found:?}");
    assert!(orders(found).iter().all(|order| *order > 1.8), "{found:?}");
}

/// Friction's power on the ball, its energy, lost power, work booked at the end of a step and the rate of that.
fn ledger(pair: &mut [Active<HertzContact>; 2], course: Course<'_>, time: f64) -> [f64; 5] {
    pair.iter_mut().for_each(|contact| evaluate(contact, course, time));
    let h = 1e-4 * END;
    let velocity = (course(time + h) - course(time - h)) / (2.0 * h);
    let [rough, smooth] = pair.each_ref().map(ActiveForce::energies);
    let power = pair[0].report().friction_force.dot(&velocity);
    [power, rough.elastic_high - smooth.elastic_high, rough.dissipated_power, rough.slid, rough.slid_rate]
}

#[test]
fn work_of_a_slide_that_turns_is_balanced() {
    let course = |time: f64| arc(time, -DEPTH * (1.0 - 0.3 * time / END));
    let (mut pair, step) = ([0.3, 0.0].map(ball_on_plane), END / 10.0);
    for k in 0..6 {
        ledger(&mut pair, &course, step * f64::from(k));
        pair.iter_mut().for_each(ActiveForce::save);
    }
    for share in [0.13, 0.41, 0.77, 1.0] {
        let time = step * (5.0 + share);
        let h = 1e-4 * step;
        let [before, now, after] = [time - h, time, time + h].map(|t| ledger(&mut pair, &course, t));
        let rate = |k: usize| (after[k] - before[k]) / (2.0 * h);
        let [power, _, lost, _, booked] = now;
        assert!(lost > 0.9 * power.abs(), "does not slide: {now:?}");
        // Differences of the work over 2e-4 of a step: corners of the law, where a level is left, and round-off.
        assert!((power + rate(1) + lost).abs() < 1e-5 * lost, "{share}: {power} {} {lost}", rate(1));
        assert!((rate(3) - booked).abs() < 1e-5 * lost, "{share}: {} {booked}", rate(3));
    }
}
