//! Solid balls with fine zones: evaluations that leave points out, momenta, gradient of the potential.

use crate::common::Random;
use crate::pair_support::caps::{N_MODES, RADIUS, caps, pressed};
use crate::pair_support::moment;
use contact_qs::{ActiveContact, SurfacePair};
use ffr_dynamics::force::active::{Active, ActiveForce};
use ffr_dynamics::force::{BodyState, GeneralisedForce, Motion};
use nalgebra::{UnitQuaternion, Vector3};

const WIDTH: f64 = 1.5e-4;
const DEPTH: f64 = 2e-6;

fn evaluate(pair: &mut Active<SurfacePair>, bodies: &[BodyState]) -> (Vec<GeneralisedForce>, f64) {
    let mut forces = vec![GeneralisedForce::zeros(N_MODES); 2];
    pair.evaluate(Motion::new(0.0, bodies), &mut forces).unwrap();
    (forces, pair.energies().elastic_high + pair.energies().penalty)
}

/// Balls pressed together, shifted, turned and deformed at random, all turned in space together.
fn random_state(random: &mut Random) -> Vec<BodyState> {
    let mut bodies = pressed(DEPTH);
    let mut vector = |size: f64| size * Vector3::new(random.next(), random.next(), random.next());
    bodies[0].position += vector(2e-7) + vector(2e-5).component_mul(&Vector3::new(1.0, 1.0, 0.0));
    let (common, shift) = (UnitQuaternion::from_scaled_axis(vector(1.0)), vector(0.3));
    for body in &mut bodies {
        body.rotation = common * UnitQuaternion::from_scaled_axis(vector(2e-3));
        body.position = common * body.position + shift;
        body.elastic.iter_mut().for_each(|q| *q = vector(2e-9).x);
    }
    bodies
}

#[test]
fn evaluations_that_leave_points_out_find_the_forces_of_those_that_look_at_all() {
    let [mut warm, mut cold] = [(); 2].map(|()| Active::new(caps(WIDTH, 10, 1e18).with_tolerance(1e-8)));
    let mut random = Random::new(3);
    let mut bodies = pressed(-DEPTH);
    evaluate(&mut warm, &bodies);
    let (mut most, mut n_open) = (0, 0);
    for step in 0..60 {
        // Small motions, and now and then a jump: apart, deep, aside.
        let size = if step % 7 == 6 { 1.0 } else { 0.02 };
        bodies[0].position +=
            size * 3e-6 * Vector3::new(4.0 * random.next(), 4.0 * random.next(), random.next());
        bodies[0].position.z = bodies[0].position.z.clamp(2.0 * RADIUS - 2.5e-6, 2.0 * RADIUS + 1e-6);
        bodies[1].elastic[step % N_MODES] += size * 1e-8 * random.next();
        cold.forget();
        let gaps = (warm.meeting(Motion::new(0.0, &bodies)).gap, cold.meeting(Motion::new(0.0, &bodies)).gap);
        // Both projections end at round-off of positions of 1e-2 m.
        assert!((gaps.0 - gaps.1).abs() < 1e-16, "{step}: {gaps:?}");
        let (found, energy) = evaluate(&mut warm, &bodies);
        let (expected, other) = evaluate(&mut cold, &bodies);
        let scale = expected[0].force.norm();
        // Gaps known to 1e-8 of the penetration from either side; forces go with its power 3/2.
        assert!((found[0].force - expected[0].force).norm() <= 1e-7 * scale, "{step}: {}", found[0].force);
        assert!((energy - other).abs() <= 1e-7 * other, "{step}: {energy} {other}");
        let count = |f: &Active<SurfacePair>| f.point_forces().unwrap().iter().filter(|f| **f > 0.0).count();
        assert_eq!(count(&warm), count(&cold), "{step}");
        most = most.max(count(&warm));
        n_open += usize::from(count(&warm) == 0);
    }
    assert!(most > 20 && n_open > 2, "{most} {n_open}");
}

#[test]
fn forces_on_solid_balls_keep_both_momenta_to_round_off() {
    let mut pair = Active::new(caps(WIDTH, 10, 1e18));
    let mut random = Random::new(5);
    for case in 0..20 {
        let bodies = random_state(&mut random);
        let (forces, _) = evaluate(&mut pair, &bodies);
        assert!(pair.report().n_active > 10, "{case}");
        assert_eq!(forces[0].force, -forces[1].force);
        let moment = moment(&bodies, &forces);
        // Round-off of arms of half a metre; projections end at some eps of positions, tangents of short elements amplify.
        let scale = 0.5 * pair.report().normal_force;
        assert!(moment.norm() < 1e-13 * scale, "{case}: {:e}", moment.norm() / scale);
    }
}

#[test]
fn force_on_solid_balls_is_minus_the_gradient_of_the_potential() {
    let mut pair = Active::new(caps(WIDTH, 8, 1e18).with_tolerance(1e-12));
    let mut random = Random::new(7);
    let mut potential = |bodies: &[BodyState]| evaluate(&mut pair, bodies);
    for case in 0..4 {
        let bodies = random_state(&mut random);
        let (forces, _) = potential(&bodies);
        let scale = forces[0].force.norm();
        let errors = [4e-9, 2e-9, 1e-9].map(|h| {
            let mut slope = |shift: &dyn Fn(&mut [BodyState], f64)| {
                let mut at = |step: f64| {
                    let mut moved = bodies.clone();
                    shift(&mut moved, step);
                    potential(&moved).1
                };
                // Fourth order: the potential is smooth but for points that enter.
                (8.0 * (at(h) - at(-h)) - (at(2.0 * h) - at(-2.0 * h))) / (12.0 * h)
            };
            let mut worst = 0.0_f64;
            for body in 0..2 {
                for d in 0..3 {
                    let gradient = slope(&|b, step| b[body].position[d] += step);
                    worst = worst.max((forces[body].force[d] + gradient).abs());
                    let turned = slope(&|b, step| {
                        let mut axis = Vector3::zeros();
                        axis[d] = step / RADIUS;
                        b[body].rotation *= UnitQuaternion::from_scaled_axis(axis);
                    });
                    worst = worst.max((forces[body].torque_in_body[d] / RADIUS + turned).abs());
                }
                for k in [0, 7] {
                    let gradient = slope(&|b, step| b[body].elastic[k] += 0.1 * step);
                    worst = worst.max((0.1 * forces[body].elastic[k] + gradient).abs());
                }
            }
            worst / scale
        });
        // Penetrations of 2e-6 and steps of 1e-9: (h/depth)² = 2.5e-7 at a point that enters or leaves between the places;
        // otherwise round-off of energies, some 1e-14 m of half a metre on 1e-9 m.
        let best = errors.iter().copied().fold(f64::INFINITY, f64::min);
        assert!(best < 2e-6, "{case}: {errors:?}");
    }
}
