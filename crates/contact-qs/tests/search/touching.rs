//! First touching times: nothing is jumped over.

use contact_qs::search::{TouchSettings, closing_speed_bound, first_touch, safe_time, surface_speed_bound};
use contact_qs::{ContactError, SearchWorkspace, SurfaceModel, minimum_distance};
use ffr_dynamics::body::RigidMotion::{Axial, Spatial};
use ffr_dynamics::force::BodyState;
use iga_core::nurbs::primitives::{SphereNet, axisymmetric, solid, sphere};
use nalgebra::{UnitQuaternion, Vector3};

use super::bodies::{Flexible, at, rigid};

const SETTINGS: TouchSettings = TouchSettings { gap: 1e-12, time: 1e-12, shortest: 1e-9, acceleration: 0.0 };

/// Looks at two bodies in the motions `states`.
fn sample<'a>(
    models: [&'a SurfaceModel; 2],
    states: impl Fn(f64) -> [BodyState; 2] + 'a,
) -> impl FnMut(f64) -> Result<(f64, f64), ContactError> + 'a {
    let mut ws = SearchWorkspace::new();
    move |t| {
        let states = states(t);
        let gap = minimum_distance(models, [&states[0], &states[1]], &mut ws)?.gap;
        Ok((gap, closing_speed_bound(models, [&states[0], &states[1]])))
    }
}

#[test]
fn bullet_does_not_tunnel_through_a_thin_plate() {
    let plate = rigid(Spatial, &solid::cuboid([0.1, 0.1, 1e-3]).unwrap(), 2);
    let bullet = rigid(Spatial, &sphere::sphere(1e-3, SphereNet::Cube).unwrap(), 2);
    let side = Vector3::new(0.0123, 0.0071, 0.0);
    let middle = minimum_distance(
        [&bullet, &plate],
        [&at([0.0, 0.0, 0.5]), &at([0.0; 3])],
        &mut SearchWorkspace::new(),
    )
    .unwrap();
    let top = middle.sites[1].point.z;
    let (height, speed) = (0.04, 1000.0);
    let states = move |t: f64| {
        let place = side + Vector3::z() * (top + height - speed * t);
        let flying = BodyState {
            velocity: Vector3::new(0.0, 0.0, -speed),
            angular_velocity_in_body: Vector3::new(3e3, 0.0, 0.0),
            rotation: UnitQuaternion::from_scaled_axis(Vector3::x() * 3e3 * t),
            ..at(place.into())
        };
        [flying, at([0.0; 3])]
    };
    // In one step of 0.1 ms it flies 0.1 m: at both ends it is apart from the plate.
    let interval = [0.0, 1e-4];
    for t in interval {
        let states = states(t);
        let gap = minimum_distance([&bullet, &plate], [&states[0], &states[1]], &mut SearchWorkspace::new());
        assert!(gap.unwrap().gap > 0.03);
    }
    let found = first_touch(interval, &SETTINGS, sample([&bullet, &plate], states)).unwrap().unwrap();
    let exact = (height - 1e-3) / speed;
    assert!((found.time - exact).abs() < 2e-12 && found.seen - found.time <= 1e-12, "{found:?} {exact}");
    assert!(found.n_samples < 60, "{found:?}");
}

#[test]
fn spinning_bar_hits_a_ball_that_it_would_have_passed() {
    // The ball stands beside the bar's hub; only the bar's tip reaches it, for a small part of each turn.
    let bar = rigid(Spatial, &solid::cuboid([1.0, 0.02, 0.02]).unwrap(), 2);
    let ball = rigid(Spatial, &sphere::sphere(0.02, SphereNet::Cube).unwrap(), 2);
    let spin = 1000.0;
    let states = move |t: f64| {
        let turning = BodyState {
            rotation: UnitQuaternion::from_scaled_axis(Vector3::z() * (spin * t + 0.3)),
            angular_velocity_in_body: Vector3::new(0.0, 0.0, spin),
            ..at([0.0; 3])
        };
        [turning, at([-0.1, 0.45, 0.01])]
    };
    let mut at_time = sample([&bar, &ball], states);
    let found = first_touch([0.0, 5e-3], &SETTINGS, sample([&bar, &ball], states)).unwrap().unwrap();
    assert!(at_time(found.time).unwrap().0 >= 0.0 && found.time > 1e-4);
    assert!(at_time(found.seen + 1e-9).unwrap().0 < 0.0, "{found:?}");
    // Nothing was touched before: looked at a thousand times.
    for k in 0..1000 {
        let t = found.time * f64::from(k) / 1000.0;
        assert!(at_time(t).unwrap().0 > 0.0, "{t}");
    }
}

#[test]
fn gap_falls_straight_through_the_first_touch() {
    let (ball, rod) = (axisymmetric::sphere(0.01).unwrap(), axisymmetric::rod(0.005, 0.1).unwrap());
    let (ball, rod) = (rigid(Axial, &ball, 8), rigid(Axial, &rod, 8));
    let mut ws = SearchWorkspace::new();
    for k in -60..=60 {
        let exact = 1e-13 * f64::from(k);
        let states = [at([0.0, 0.0, 0.11 + exact]), at([0.0; 3])];
        let found = minimum_distance([&ball, &rod], [&states[0], &states[1]], &mut ws).unwrap().gap;
        // 0.11 + exact rounds to multiples of 1.4e-17.
        assert!((found - exact).abs() < 2e-16, "{exact:e} {found:e}");
    }
}

#[test]
fn bodies_that_pass_or_part_have_no_touch() {
    let ball = rigid(Spatial, &sphere::sphere(0.1, SphereNet::Cube).unwrap(), 2);
    // They pass with 1 mm to spare.
    let passing = |t: f64| {
        let moving = BodyState { velocity: Vector3::new(10.0, 0.0, 0.0), ..at([10.0 * t - 1.0, 0.201, 0.0]) };
        [moving, at([0.0; 3])]
    };
    let found = first_touch([0.0, 0.2], &SETTINGS, sample([&ball, &ball], passing)).unwrap();
    assert_eq!(found, None);
    let parting = |t: f64| {
        let moving =
            BodyState { velocity: Vector3::new(10.0, 0.0, 0.0), ..at([10.0 * t + 0.2001, 0.0, 0.0]) };
        [moving, at([0.0; 3])]
    };
    assert_eq!(first_touch([0.0, 0.2], &SETTINGS, sample([&ball, &ball], parting)).unwrap(), None);
}

#[test]
fn not_a_number_ends_the_search_of_a_touch_with_an_error() {
    for bad in [(f64::NAN, 1.0), (1.0, f64::NAN), (1.0, f64::INFINITY)] {
        let found = first_touch([0.0, 1.0], &SETTINGS, |t| Ok(if t > 0.0 { bad } else { (0.5, 1.0) }));
        assert!(matches!(found, Err(ContactError::Motion { .. })));
    }
    let idle = TouchSettings { shortest: 0.0, ..SETTINGS };
    assert!(first_touch([0.0, 1.0], &idle, |_| Ok((1.0, 1.0))).is_err());
}

#[test]
fn safe_time_is_the_time_of_the_fastest_approach() {
    assert!((safe_time(2.0, 4.0, 0.0) - 0.5).abs() < 1e-15);
    let t = safe_time(3.0, 2.0, 5.0);
    assert!((2.0 * t + 2.5 * t * t - 3.0).abs() < 1e-14);
    assert!(safe_time(1.0, 0.0, 0.0).is_infinite() && safe_time(-1.0, 1.0, 0.0) <= 0.0);
    assert!(safe_time(f64::NAN, 1.0, 0.0).is_nan() && safe_time(1.0, 1.0, f64::NAN).is_nan());
}

#[test]
fn no_surface_point_is_faster_than_its_bound() {
    let body = Flexible::new(Spatial, &sphere::sphere(0.5, SphereNet::Cube).unwrap(), 2, 3);
    let state = BodyState {
        angular_velocity_in_body: Vector3::new(3.0, -2.0, 1.0),
        elastic: vec![0.02, -0.01, 0.03],
        elastic_rates: vec![1.0, 2.0, -1.5],
        ..BodyState::at_rest(3)
    };
    let bound = surface_speed_bound(&body.model, &state);
    let (here, rates) = (body.deformed(&state.elastic), body.deformed(&state.elastic_rates));
    let rest = body.deformed(&[0.0; 3]);
    let mut fastest = 0.0_f64;
    for k in 0..500 {
        let share = |m: usize| ((k * m) % 499) as f64 / 499.0;
        let xi = [share(1), share(17), f64::from(k as u32 % 2)];
        let at = |patches: &[iga_core::nurbs::Patch]| Vector3::from(patches[0].point(&xi));
        let velocity = state.angular_velocity_in_body.cross(&at(&here)) + at(&rates) - at(&rest);
        fastest = fastest.max(velocity.norm());
    }
    assert!(fastest <= bound && fastest > 0.3 * bound, "{fastest} {bound}");
    // With frequencies the bound holds at any phase of the vibration.
    let stiff = body.model.clone().with_frequencies(&[100.0, 200.0, 300.0]).unwrap();
    assert!(surface_speed_bound(&stiff, &state) > bound);
    assert!(body.model.clone().with_frequencies(&[1.0]).is_err());
}

/// Gap over time, with its exact slope as the bound of the speed.
fn touch_of(gap: impl Fn(f64) -> f64) -> Option<f64> {
    let settings = TouchSettings { gap: 1e-12, time: 1e-12, shortest: 1e-4, acceleration: 10.0 };
    first_touch([0.0, 1.0], &settings, |t| Ok((gap(t), 10.0))).unwrap().map(|touch| touch.time)
}

#[test]
fn surfaces_that_touch_at_the_start_touch_unless_they_open() {
    // At rest beside each other, at their distance of round-off.
    for rest in [0.0, 5e-13, -5e-13] {
        assert_eq!(touch_of(|_| rest), None, "{rest:e}");
    }
    // They fall from rest: seen when the gap has shrunk by the tolerance, which takes 4.5e-7 s; the first look is later.
    for rest in [0.0, 5e-13, -5e-13, -1e-6] {
        assert_eq!(touch_of(|t| rest - 4.905 * t * t), Some(0.0), "{rest:e}");
    }
    // Overlapping at rest: no force holds them apart, so there is one to be found.
    assert_eq!(touch_of(|_| -1e-6), Some(0.0));
    // On their way apart, from an overlap as well.
    for start in [0.0, -1e-6] {
        assert_eq!(touch_of(|t| start + 1e-3 * t), None, "{start:e}");
    }
    // They turn before they are apart, and after it; looks come twice as late each time.
    let turning = touch_of(|t| -1e-6 + 1e-7 * (0.1 - (t - 0.1).abs())).expect("it turns");
    assert!((0.05..=0.2).contains(&turning), "{turning}");
    let again = touch_of(|t| 1e-3 * t * (0.5 - t)).expect("it comes back");
    assert!((again - 0.5).abs() < 1e-9, "{again}");
}
