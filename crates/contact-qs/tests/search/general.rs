//! General bodies against brute force; certificates; faulty states.

use std::sync::Arc;

use contact_qs::search::{BodySurface, plane_distance};
use contact_qs::{ContactError, Detector, Plane, SearchWorkspace, Target, minimum_distance};
use ffr_dynamics::body::RigidMotion::{Axial, Planar, Spatial};
use ffr_dynamics::force::BodyState;
use iga_core::nurbs::primitives::{SphereNet, plane, solid, sphere};
use nalgebra::{UnitQuaternion, UnitVector3, Vector3};

use super::bodies::{
    Flexible, Sampled, at, brute_force, c_shape, random_direction, random_rotation, refined, rigid,
};
use crate::common::Random;

/// The brute force ends with steps of 1e-7 of a face's parameters, to which the distance at an edge is proportional.
const BRUTE: f64 = 1e-6;

#[test]
fn solids_in_random_poses_agree_with_brute_force() {
    let shapes = [solid::hollow_cylinder(0.3, 0.5, 0.8).unwrap(), solid::cuboid([0.6, 0.5, 0.4]).unwrap()];
    let patches = shapes.each_ref().map(|s| refined(s, 2));
    let models = shapes.each_ref().map(|s| rigid(Spatial, s, 2));
    let mut random = Random::new(3);
    let mut ws = SearchWorkspace::new();
    let mut n_apart = 0;
    for _ in 0..25 {
        let place = random_direction(&mut random) * (1.1 + 0.3 * random.next());
        let states =
            [[0.0; 3], place.into()].map(|p| BodyState { rotation: random_rotation(&mut random), ..at(p) });
        let found = minimum_distance([&models[0], &models[1]], [&states[0], &states[1]], &mut ws).unwrap();
        if found.gap > 0.0 {
            n_apart += 1;
            let sampled = [0, 1].map(|b| Sampled::new(Spatial, &patches[b], &states[b]));
            let brute = brute_force(&sampled[0], &sampled[1], 14);
            assert!(found.gap <= brute + 1e-12 && brute < found.gap + BRUTE, "{} {brute}", found.gap);
        }
    }
    assert!(n_apart > 15, "{n_apart}");
}

#[test]
fn deformed_bodies_agree_with_brute_force() {
    let mut random = Random::new(4);
    for (motion, shapes) in [
        (Spatial, [sphere::sphere(0.5, SphereNet::Cube).unwrap(), solid::cuboid([0.6, 0.5, 0.4]).unwrap()]),
        (Planar, [c_shape(0.4, 0.6), plane::disc(0.3).unwrap()]),
    ] {
        let bodies = shapes.each_ref().map(|s| Flexible::new(motion, s, 3, 3));
        let mut ws = SearchWorkspace::new();
        for _ in 0..15 {
            let mut place = random_direction(&mut random) * (1.5 + 0.2 * random.next());
            let mut turn = || random_rotation(&mut random);
            let mut turns = [turn(), turn()];
            if motion == Planar {
                place.z = 0.0;
                place *= 1.4 / place.norm();
                turns = turns.map(|t| UnitQuaternion::from_euler_angles(0.0, 0.0, t.angle()));
            }
            let states = [0, 1].map(|b| BodyState {
                rotation: turns[b],
                elastic: (0..3).map(|_| 0.04 * random.next()).collect(),
                elastic_rates: vec![0.0; 3],
                ..at(if b == 0 { [0.0; 3] } else { place.into() })
            });
            let found =
                minimum_distance([&bodies[0].model, &bodies[1].model], [&states[0], &states[1]], &mut ws)
                    .unwrap();
            let deformed = [0, 1].map(|b| bodies[b].deformed(&states[b].elastic));
            let sampled = [0, 1].map(|b| Sampled::new(motion, &deformed[b], &states[b]));
            let brute = brute_force(&sampled[0], &sampled[1], if motion == Spatial { 14 } else { 200 });
            assert!(found.gap > 0.0, "{motion:?} {found:?}");
            assert!(
                found.gap <= brute + 1e-12 && brute < found.gap + BRUTE,
                "{motion:?} {} {brute}",
                found.gap
            );
        }
    }
}

#[test]
fn surfaces_are_never_nearer_than_the_least_gap() {
    let shapes =
        [solid::hollow_cylinder(0.3, 0.5, 0.8).unwrap(), sphere::sphere(0.5, SphereNet::Cube).unwrap()];
    let models = shapes.each_ref().map(|shape| Arc::new(Flexible::new(Spatial, shape, 2, 3).model));
    let surface = |body: usize, model: usize| BodySurface { body, model: Arc::clone(&models[model]) };
    let mut random = Random::new(8);
    let mut ws = SearchWorkspace::new();
    let mut n_apart = 0;
    for k in 0..40 {
        // From one in the other to far apart; the last ten are two balls at rest.
        let is_balls = k >= 30;
        let place = random_direction(&mut random) * (0.1 * f64::from(k) + if is_balls { 0.0 } else { 0.05 });
        let states = [[0.0; 3], place.into()].map(|p| BodyState {
            rotation: random_rotation(&mut random),
            elastic: (0..3).map(|_| if is_balls { 0.0 } else { 0.03 * random.next() }).collect(),
            elastic_rates: vec![0.0; 3],
            ..at(p)
        });
        let normal = UnitVector3::new_normalize(random_direction(&mut random));
        let plane = Plane { point: -place, normal };
        for target in [Target::Body(surface(1, 1)), Target::Plane(plane)] {
            let detector = Detector { own: surface(0, usize::from(is_balls)), target };
            let (least, gap) = (detector.least_gap(&states), detector.nearest(&states, &mut ws).unwrap().gap);
            assert!(least <= gap.max(0.0) + 1e-12, "{k}: {least} {gap}");
            n_apart += usize::from(least > 0.0);
            // Control points of pieces as long as half the radius stand a twentieth of it outside of a ball; boxes would say
            // up to 0.7 of the radius less.
            assert!(!is_balls || gap < 0.0 || gap - least < 0.1 * 0.5 * 2.0, "{k}: {least} {gap}");
            let lost = states
                .each_ref()
                .map(|state| BodyState { position: state.position * f64::NAN, ..state.clone() });
            assert!(detector.least_gap(&lost).is_infinite());
        }
    }
    assert!(n_apart > 40, "{n_apart}");
}

#[test]
fn displacement_bounds_hold_on_the_whole_surface() {
    let body = Flexible::new(Spatial, &sphere::sphere(0.5, SphereNet::Cube).unwrap(), 2, 4);
    let q = [0.01, -0.02, 0.03, 0.005];
    let (rest, moved) = (body.deformed(&[0.0; 4]), body.deformed(&q));
    let state = at([0.0; 3]);
    let bound = body.model.displacement_bound(&q);
    let up = Plane { point: Vector3::zeros(), normal: Vector3::z_axis() };
    let mut ws = SearchWorkspace::new();
    let lowest = |q: &[f64], ws: &mut SearchWorkspace| {
        let state = BodyState { elastic: q.to_vec(), ..state.clone() };
        plane_distance(&body.model, &state, &up, ws).unwrap().gap
    };
    assert!((lowest(&q, &mut ws) - lowest(&[0.0; 4], &mut ws)).abs() <= bound);
    for (a, b) in rest.iter().zip(&moved) {
        for k in 0..200 {
            let share = |m: usize| ((k * m) % 199) as f64 / 199.0;
            let xi = [share(1), share(7), share(31)];
            let (x, y) = (a.point(&xi), b.point(&xi));
            let u = (0..3).map(|c| (x[c] - y[c]).powi(2)).sum::<f64>().sqrt();
            // Inside the body the control points are others, but the made-up shapes are as large there.
            assert!(u <= 1.3 * bound);
        }
    }
}

#[test]
fn search_from_the_last_answer_gives_what_a_fresh_search_gives() {
    let shapes = [solid::hollow_cylinder(0.3, 0.5, 0.8).unwrap(), solid::cuboid([0.6, 0.5, 0.4]).unwrap()];
    let models = shapes.each_ref().map(|s| rigid(Spatial, s, 2));
    let mut warm = SearchWorkspace::new();
    let mut n_warm = 0;
    for k in 0..400 {
        let t = f64::from(k) / 400.0;
        let spin = UnitQuaternion::from_scaled_axis(Vector3::new(9.0, 5.0, -7.0) * t);
        let angle = 6.0 * t;
        let place = Vector3::new(angle.cos(), angle.sin(), 0.4 - t) * (1.0 + 0.3 * (20.0 * t).sin());
        let states = [BodyState { rotation: spin, ..at([0.0; 3]) }, at(place.into())];
        let of = |ws: &mut SearchWorkspace| {
            minimum_distance([&models[0], &models[1]], [&states[0], &states[1]], ws).unwrap().gap
        };
        let (a, b) = (of(&mut warm), of(&mut SearchWorkspace::new()));
        // Apart the minimum is certified; the depth of an overlap is searched with finitely many starts.
        if a > 0.0 || b > 0.0 {
            assert!((a - b).abs() < 1e-12, "{k}: {a} {b}");
        }
        n_warm += usize::from(warm.report().is_warm);
    }
    assert_eq!(n_warm, 399);
}

#[test]
fn equal_minima_change_places_without_a_jump() {
    // A C on its two tips over a bar: a little tilt makes one tip the nearer one.
    let c = rigid(Planar, &c_shape(1.0, 1.2), 3);
    let bar = rigid(Planar, &plane::rectangle(4.0, 0.2).unwrap(), 5);
    let mut ws = SearchWorkspace::new();
    let mut places = [0, 0];
    let mut last: Option<f64> = None;
    for k in -20..=20 {
        let tilt = f64::from(k) * 1e-4;
        // The opening looks down.
        let turn = UnitQuaternion::from_euler_angles(0.0, 0.0, tilt - std::f64::consts::FRAC_PI_2);
        let states = [BodyState { rotation: turn, ..at([0.0, 2.0, 0.0]) }, at([0.0; 3])];
        let found = minimum_distance([&c, &bar], [&states[0], &states[1]], &mut ws).unwrap();
        let fresh =
            minimum_distance([&c, &bar], [&states[0], &states[1]], &mut SearchWorkspace::new()).unwrap();
        assert!((found.gap - fresh.gap).abs() < 1e-14);
        // Symmetric about no tilt; a tip moves by its arm times the change of the angle.
        let tip = 1.2 * std::f64::consts::FRAC_1_SQRT_2;
        if let Some(before) = last {
            assert!((found.gap - before).abs() < 1.01e-4 * tip * 1.01, "{k}");
        }
        last = Some(found.gap);
        places[usize::from(found.sites[0].point.x > 0.0)] += 1;
    }
    assert!(places[0] >= 20 && places[1] >= 20, "{places:?}");
}

#[test]
fn states_that_are_not_numbers_are_errors() {
    let ball = rigid(Spatial, &sphere::sphere(0.5, SphereNet::Cube).unwrap(), 1);
    let flexible = Flexible::new(Spatial, &solid::cuboid([1.0, 1.0, 1.0]).unwrap(), 1, 2);
    let mut ws = SearchWorkspace::new();
    let good = [at([3.0, 0.0, 0.0]), BodyState::at_rest(2)];
    let mut of = |states: [&BodyState; 2]| minimum_distance([&ball, &flexible.model], states, &mut ws);
    assert!(of([&good[0], &good[1]]).unwrap().gap > 0.0);
    for bad in [
        BodyState { elastic: vec![0.0, f64::NAN], ..good[1].clone() },
        BodyState { elastic: vec![f64::INFINITY, 0.0], ..good[1].clone() },
        BodyState { elastic: vec![0.0], ..good[1].clone() },
        BodyState { position: Vector3::new(f64::NAN, 0.0, 0.0), ..good[1].clone() },
        BodyState {
            rotation: UnitQuaternion::new_unchecked(nalgebra::Quaternion::new(f64::NAN, 0.0, 0.0, 0.0)),
            ..good[1].clone()
        },
    ] {
        assert!(matches!(of([&good[0], &bad]), Err(ContactError::Motion { .. })), "{bad:?}");
    }
    // Finite but too large for squares.
    let far = at([1e200, 0.0, 0.0]);
    assert!(of([&far, &good[1]]).is_err());
    assert!(of([&good[0], &good[1]]).unwrap().gap > 0.0);
    let disc = rigid(Axial, &plane::disc(0.5).unwrap(), 1);
    let mixed = minimum_distance([&ball, &disc], [&good[0], &at([0.0; 3])], &mut SearchWorkspace::new());
    assert!(matches!(mixed, Err(ContactError::MixedModels { .. })));
}
