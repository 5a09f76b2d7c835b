//! Rates of contact forces from the active sets (C.109) against differences, contact by contact.

use crate::common::Random;
use crate::pair_support::{
    CASES, MOTIONS, N_MODES, N_POINTS, random_bodies, random_points, random_target, upwards,
};
use contact_qs::law::Solid;
use contact_qs::quasistatic::Method;
use contact_qs::{
    ActiveContact, ContactSides, ContactSubmodel, Friction, HertzContact, Plane, PlaneContact,
    PlaneContactSettings, Sphere, SurfacePair, SurfacePairSettings, Target,
};
use ffr_dynamics::body::RigidMotion;
use ffr_dynamics::force::active::{Active, ActiveForce};
use ffr_dynamics::force::{BodyState, GeneralisedForce, Motion};
use ffr_dynamics::kinematics::FlexiblePoint;
use nalgebra::{UnitQuaternion, UnitVector3, Vector3};

/// Distance of the points from the frames, by which moments are compared with forces \[m\].
const LEVER: f64 = 0.05;

fn at(contact: &mut dyn ActiveContact, bodies: &[BodyState]) -> Vec<GeneralisedForce> {
    let mut forces = vec![GeneralisedForce::zeros(N_MODES); bodies.len()];
    contact.evaluate(Motion::new(0.0, bodies), &mut forces).unwrap();
    forces
}

/// The bodies after `time` at their velocities.
fn later(bodies: &[BodyState], time: f64) -> Vec<BodyState> {
    let mut moved = bodies.to_vec();
    for body in &mut moved {
        body.position += body.velocity * time;
        body.rotation *= UnitQuaternion::from_scaled_axis(body.angular_velocity_in_body * time);
        body.elastic.iter_mut().zip(&body.elastic_rates).for_each(|(q, rate)| *q += rate * time);
    }
    moved
}

/// The bodies where they are with `factor` times their velocities.
fn slowed(bodies: &[BodyState], factor: f64) -> Vec<BodyState> {
    let mut slowed = bodies.to_vec();
    for body in &mut slowed {
        body.velocity *= factor;
        body.angular_velocity_in_body *= factor;
        body.elastic_rates.iter_mut().for_each(|rate| *rate *= factor);
    }
    slowed
}

/// The bodies at rest where they are.
fn stopped(bodies: &[BodyState]) -> Vec<BodyState> {
    slowed(bodies, 0.0)
}

/// The bodies with velocities, each of one coordinate of one body, that `motion` allows.
fn motions(bodies: &[BodyState], motion: RigidMotion) -> Vec<Vec<BodyState>> {
    let mut all = Vec::new();
    for b in 0..bodies.len() {
        let mut add = |set: &dyn Fn(&mut BodyState)| {
            let mut moving = stopped(bodies);
            set(&mut moving[b]);
            all.push(moving);
        };
        (0..N_MODES).for_each(|j| add(&|body| body.elastic_rates[j] = 1.0));
        let nc = motion.n_components();
        let moves = if motion == RigidMotion::Axial { 2..3 } else { 0..nc };
        moves.for_each(|c| add(&|body| body.velocity[c] = 1.0));
        let turns = [0..0, 2..3, 0..3][MOTIONS.iter().position(|m| *m == motion).unwrap()].clone();
        turns.for_each(|c| add(&|body| body.angular_velocity_in_body[c] = 1.0));
    }
    all
}

/// Largest difference between rates and differences over steps of `depth / 1000`, over the largest rate of all motions, and how
/// many motions could be compared: not those in which points change between sticking, sliding and open.
fn error(
    contact: &mut dyn ActiveContact,
    bodies: &[BodyState],
    motion: RigidMotion,
    depth: f64,
) -> (f64, usize) {
    let (mut worst, mut stiffest, mut n) = (0.0_f64, 0.0_f64, 0);
    for moving in motions(bodies, motion) {
        let step = 1e-3 * depth;
        let size = |force: &GeneralisedForce| {
            let parts = [force.force.norm(), force.torque_in_body.norm() / LEVER];
            force.elastic.iter().map(|f| f.abs()).chain(parts).fold(0.0, f64::max)
        };
        let mut sets = Vec::new();
        let ends = [-2.0, -1.0, 1.0, 2.0, 0.0].map(|n| {
            let forces = at(contact, &stopped(&later(&moving, n * step)));
            sets.push((contact.report().n_active, contact.report().n_sliding));
            forces
        });
        if sets.iter().any(|set| *set != sets[0]) {
            continue;
        }
        let mut rates = vec![GeneralisedForce::zeros(N_MODES); bodies.len()];
        assert!(contact.rates(Motion::new(0.0, &moving), false, &mut rates));
        let (mut largest, mut difference) = (0.0_f64, 0.0_f64);
        for (b, rate) in rates.iter().enumerate() {
            let [near, far] =
                [(2, 1), (3, 0)].map(|(ahead, behind)| ends[ahead][b].without(&ends[behind][b]));
            let expected = near.scaled(8.0).without(&far).scaled(1.0 / (12.0 * step));
            largest = largest.max(size(&expected));
            difference = difference.max(size(&rate.without(&expected)));
        }
        (worst, stiffest, n) = (worst.max(difference), stiffest.max(largest), n + 1);
    }
    (worst / stiffest, n)
}

/// Presses, and has the points stick, slide or roll by some of what they yield.
fn rub(
    contact: &mut dyn ActiveContact,
    bodies: &[BodyState],
    motion: RigidMotion,
    depth: f64,
) -> Vec<BodyState> {
    at(contact, bodies);
    contact.save();
    let mut random = Random::new(77);
    let mut moving = stopped(bodies);
    for body in &mut moving {
        let v = Vector3::new(random.next(), random.next(), random.next());
        body.velocity = match motion {
            RigidMotion::Axial => Vector3::new(0.0, 0.0, 0.1 * v.z),
            RigidMotion::Planar => Vector3::new(v.x, v.y, 0.0),
            RigidMotion::Spatial => v,
        };
        body.elastic_rates.iter_mut().for_each(|rate| *rate = random.next());
    }
    let moved = stopped(&later(&moving, 0.2 * depth));
    at(contact, &moved);
    moved
}

/// How deep the points lie, as shares of the depth.
fn shares(seed: u64) -> Vec<f64> {
    let mut random = Random::new(seed);
    (0..N_POINTS).map(|_| 0.75 + 0.25 * random.next()).collect()
}

/// A pair of bodies whose points all lie below the surface of the target, and the bodies.
fn pair(
    motion: RigidMotion,
    (quasistatic, penalty): ([bool; 2], f64),
    (coefficient, depth, seed): (f64, f64, u64),
) -> (Box<dyn ActiveContact>, Vec<BodyState>) {
    let with = |points: &[[f64; 3]], [own, target]: [bool; 2], penalty: f64| {
        let settings =
            SurfacePairSettings { contact_body: 2, target_body: Some(0), penalty, method: Method::ActiveSet };
        let points = ContactSubmodel { points: points.to_vec(), ..random_points(motion, own, seed) };
        let target = random_target(motion, target, seed + 100);
        SurfacePair::new(points, target, settings).unwrap().with_tolerance(1e-12)
    };
    let mut points = random_points(motion, false, seed).points;
    let bodies = random_bodies(&with(&points, [false; 2], 1.0), motion, depth, seed);
    for _ in 0..8 {
        let mut contact = Active::new(with(&points, [false; 2], 1.0));
        at(&mut contact, &bodies);
        for ((point, gap), share) in points.iter_mut().zip(contact.state().gaps()).zip(shares(seed)) {
            let way = bodies[2].position + bodies[2].rotation * Vector3::from(*point) - bodies[0].position;
            let up = bodies[2].rotation.inverse_transform_vector(&way.normalize());
            *point = (Vector3::from(*point) - up * (gap + share * depth)).into();
        }
    }
    let pair = with(&points, quasistatic, penalty);
    let pair = pair.with_friction(Friction { coefficient, stiffness_ratio: 0.7 }).unwrap();
    (Box::new(Active::new(pair)), bodies)
}

/// A body whose points all lie below a plane.
fn plane(
    motion: RigidMotion,
    quasistatic: bool,
    (coefficient, depth, seed): (f64, f64, u64),
) -> (Box<dyn ActiveContact>, Vec<BodyState>) {
    let up = upwards(motion).1;
    let plane = Plane { point: Vector3::zeros(), normal: UnitVector3::new_normalize(up) };
    let settings = PlaneContactSettings { body: 0, plane, penalty: 1e10, method: Method::ActiveSet };
    let mut submodel = random_points(motion, quasistatic, seed);
    for (point, share) in submodel.points.iter_mut().zip(shares(seed)) {
        let place = Vector3::from(*point);
        *point = (place - up * (place.dot(&up) + LEVER + share * depth)).into();
    }
    let mut contact = PlaneContact::new(submodel, settings).unwrap();
    if coefficient > 0.0 {
        contact = contact.with_friction(Friction { coefficient, stiffness_ratio: 0.7 }).unwrap();
    }
    let body = BodyState { position: up * LEVER, ..BodyState::at_rest(N_MODES) };
    (Box::new(Active::new(contact)), vec![body])
}

/// What turns with the motion is left out of the rates: normals, tangents, compliances along them and levers, by the share of the
/// penetration in the least radius, 0.02 m, of either body. Differences are good to 1e-7.
#[test]
fn rates_of_forces_are_those_of_differences() {
    let mut compared = 0;
    for motion in MOTIONS {
        for seed in 1..4 {
            for coefficient in [0.0, 0.3] {
                for depth in [1e-5, 1e-6, 1e-7] {
                    let allowed = 2.0 * depth / 0.02 + 1e-7;
                    let pairs = CASES.iter().map(|case| pair(motion, *case, (coefficient, depth, seed)));
                    let planes = [true, false]
                        .map(|quasistatic| plane(motion, quasistatic, (coefficient, depth, seed)));
                    for (k, (mut contact, bodies)) in pairs.chain(planes).enumerate() {
                        let bodies = rub(contact.as_mut(), &bodies, motion, depth);
                        let (found, n) = error(contact.as_mut(), &bodies, motion, depth);
                        compared += n;
                        assert!(found < allowed, "{motion:?} {seed} {coefficient} {depth:e} {k}: {found:e}");
                    }
                }
            }
        }
    }
    assert!(compared > 3000, "{compared}");
}

/// The same of Hertz' law, of balls of 0.02 m.
#[test]
fn rates_of_hertz_forces_are_those_of_differences() {
    let depth = 1e-6;
    let mut random = Random::new(3);
    let mut ball = |body: usize| {
        let shapes =
            (0..N_MODES).map(|_| Vector3::new(random.next(), random.next(), random.next())).collect();
        let centre = FlexiblePoint { shapes, ..FlexiblePoint::rigid(Vector3::zeros()) };
        Sphere { body, centre, radius: 0.02, solid: Solid { young: 210e9, poisson: 0.3 } }
    };
    let mut bodies = vec![BodyState::at_rest(N_MODES); 2];
    bodies[1].position.z = 0.04 - depth;
    let mut contact =
        Active::new(HertzContact::of_spheres(ball(1), Target::Body(ball(0)), Solid::RIGID).unwrap());
    let (found, n) = error(&mut contact, &bodies, RigidMotion::Spatial, depth);
    assert!(found < 2.0 * depth / 0.02 + 1e-7 && n > 10, "{found:e} {n}");
}

/// Damping makes the forces grow by the closing speed: a velocity adds to them what it adds to the speed.
#[test]
fn damped_contacts_tell_what_velocities_change() {
    let (motion, depth) = (RigidMotion::Spatial, 1e-6);
    let (contact, bodies) = pair(motion, CASES[0], (0.0, depth, 1));
    let mut contact = ContactSides::new(contact, None, 2.0).unwrap();
    let (found, n) = error(&mut contact, &bodies, motion, depth);
    assert!(found < 2.0 * depth / 0.02 + 1e-7 && n > 10, "{found:e} {n}");
    for moving in motions(&bodies, motion) {
        let fast = at(&mut contact, &slowed(&moving, 0.1));
        let still = at(&mut contact, &bodies);
        let mut rates = vec![GeneralisedForce::zeros(N_MODES); bodies.len()];
        assert!(contact.rates(Motion::new(0.0, &moving), true, &mut rates));
        for ((fast, still), rate) in fast.iter().zip(&still).zip(&rates) {
            let (expected, size) = (fast.without(still).scaled(10.0), still.force.norm());
            // The forces are linear in the speed; those of two evaluations differ by 1e-12.
            assert!((expected.force - rate.force).norm() <= 1e-9 * size);
            assert!((expected.torque_in_body - rate.torque_in_body).norm() <= 1e-9 * size);
        }
    }
}
