//! Hertz contacts of rigid spheres as force elements: closed form of the impact, conservation, gradient.

use crate::free_motion::{body_state, free_system, state_vector};
use crate::hertz_impact::HertzImpact;
use contact_qs::law::Solid;
use contact_qs::{ActiveContact, ContactError, HertzContact, Plane, Sphere, Target};
use ffr_dynamics::body::{RigidMotion, StandardInputData};
use ffr_dynamics::error::FailureKind;
use ffr_dynamics::force::active::{Active, ActiveForce};
use ffr_dynamics::force::{BodyState, GeneralisedForce, Motion};
use ffr_dynamics::integration::{CrossingSearch, DenseOutput, Integrator, StepSettings};
use ffr_dynamics::kinematics::FlexiblePoint;
use ffr_dynamics::system::{ErrorScale, Multibody};
use nalgebra::{Matrix3, UnitQuaternion, UnitVector3, Vector3};

const STEEL: Solid = Solid { young: 2.1e11, poisson: 0.3 };
const DENSITY: f64 = 7850.0;
const RADIUS: f64 = 0.01;

fn ball(radius: f64, centre: Vector3<f64>) -> StandardInputData {
    let mass = DENSITY * 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3);
    let offset = Matrix3::identity() * centre.norm_squared() - centre * centre.transpose();
    let inertia = Matrix3::identity() * (0.4 * mass * radius * radius) + offset * mass;
    StandardInputData::rigid(RigidMotion::Spatial, mass, centre, inertia).unwrap()
}

fn sphere(body: usize, radius: f64, centre: Vector3<f64>) -> Sphere {
    Sphere { body, centre: FlexiblePoint::rigid(centre), radius, solid: STEEL }
}

fn at(position: Vector3<f64>, velocity: Vector3<f64>) -> BodyState {
    BodyState { position, velocity, ..BodyState::at_rest(0) }
}

/// What a run through an impact found.
struct Impact {
    peak: f64,
    duration: f64,
    largest_drift: f64,
    y: Vec<f64>,
}

/// Runs from the touch until the gap opens and `after` beyond it.
fn collide(
    system: &mut Multibody<Box<Active<HertzContact>>>,
    start: &[BodyState],
    expected: f64,
    tolerance: f64,
) -> Impact {
    let y = state_vector(system, start);
    let scale = ErrorScale { relative: tolerance, ..system.error_scale() };
    system.set_error_scale(scale).unwrap();
    let mut integrator = Integrator::explicit(StepSettings::with_max_step(0.01 * expected), 0.0, &y).unwrap();
    let mut search = CrossingSearch::new(y.len(), 1e-12 * expected, 4);
    let before = system.invariants(0.0, &y);
    let energy = before.kinetic + before.gravity;
    let (mut peak, mut duration, mut largest_drift) = (0.0_f64, 0.0, 0.0_f64);
    while integrator.time() < 1.05 * expected {
        integrator.step(system, 1.05 * expected).unwrap();
        let y = integrator.state().to_vec();
        system.evaluate_forces(integrator.time(), &y).unwrap();
        let energies = system.forces()[0].energies();
        let now = system.invariants(0.0, &y);
        let total = now.kinetic + now.gravity + energies.elastic_high + energies.penalty;
        largest_drift = largest_drift.max((total / energy - 1.0).abs());
        assert!(
            (now.linear_momentum - before.linear_momentum).norm()
                < 1e-13 * (1.0 + now.linear_momentum.norm())
                || system.forces()[0].facts().bodies().1.is_none()
        );
        // Peak from the dense output: the force is highest where the normal velocity vanishes.
        let (a, b) = integrator.interval();
        for k in 0..=50 {
            let mut between = vec![0.0; y.len()];
            integrator.interpolate(a + (b - a) * f64::from(k) / 50.0, &mut between);
            system.evaluate_forces(a, &between).unwrap();
            peak = peak.max(system.forces()[0].report().normal_force);
        }
        let crossing = search.first_crossing(&integrator, |t, y| {
            let states = system.body_states(t, y).to_vec();
            -system.forces_mut()[0].meeting(Motion::new(0.0, &states)).gap
        });
        if let Some(found) = crossing.unwrap() {
            duration = found.time;
        }
    }
    Impact { peak, duration, largest_drift, y: integrator.state().to_vec() }
}

#[test]
fn two_spheres_follow_hertz_and_keep_momentum_and_energy() {
    let radii = [RADIUS, 0.7 * RADIUS];
    let balls = radii.map(|radius| ball(radius, Vector3::zeros()));
    let masses = [balls[0].mass, balls[1].mass];
    let [first, second] = balls;
    let bodies = vec![("a", first), ("b", second)];
    let contact = HertzContact::of_spheres(
        sphere(0, radii[0], Vector3::zeros()),
        Target::Body(sphere(1, radii[1], Vector3::zeros())),
        STEEL,
    )
    .unwrap();
    let law = HertzImpact::new(contact.pair().unwrap(), masses, 0.3);
    // Not along an axis.
    let line = Vector3::new(0.6, -0.48, 0.64);
    let states = [at(line * (radii[0] + radii[1]), line * -0.2), at(Vector3::zeros(), line * 0.1)];
    let mut system = free_system(bodies, Vector3::zeros(), vec![Box::new(Active::new(contact))]);
    let impact = collide(&mut system, &states, law.duration(), 1e-11);
    // Tolerance of the steps, about a hundred of them; peak sampled 50 times per step.
    assert!((impact.peak / law.peak_force() - 1.0).abs() < 1e-7, "{}", impact.peak / law.peak_force() - 1.0);
    assert!((impact.duration / law.duration() - 1.0).abs() < 1e-6, "{}", impact.duration / law.duration());
    assert!(impact.largest_drift < 1e-9, "{:e}", impact.largest_drift);
    let after = [0, 1].map(|i| body_state(&mut system, &impact.y, i));
    let separation = (after[0].velocity - after[1].velocity).dot(&line);
    assert!((separation / 0.3 - 1.0).abs() < 1e-8, "restitution {}", separation / 0.3);
    let impulse = system.impulse(&impact.y, 0);
    let change = (after[0].velocity - states[0].velocity) * masses[0];
    assert!((impulse - change).norm() < 1e-9 * change.norm());
}

#[test]
fn sphere_on_a_plane_follows_hertz_with_its_centre_off_the_frame() {
    // The frame sits at the top of the sphere, as where a pendulum holds it.
    let centre = Vector3::new(0.0, 0.0, -RADIUS);
    let body = ball(RADIUS, centre);
    let mass = body.mass;
    let plane = Plane { point: Vector3::new(1.0, 2.0, 3.0), normal: Vector3::z_axis() };
    let contact =
        HertzContact::of_spheres(sphere(0, RADIUS, centre), Target::Plane(plane), Solid::RIGID).unwrap();
    let law = HertzImpact::new(contact.pair().unwrap(), [mass, f64::INFINITY], 0.1);
    let rotation = UnitQuaternion::from_euler_angles(0.5, -0.3, 1.0);
    let position = Vector3::new(-1.0, 0.5, 3.0 + RADIUS) - rotation * centre;
    let start = BodyState { rotation, ..at(position, Vector3::new(0.0, 0.0, -0.1)) };
    let mut system =
        free_system(vec![("ball", body)], Vector3::zeros(), vec![Box::new(Active::new(contact))]);
    let impact = collide(&mut system, &[start], law.duration(), 1e-11);
    assert!((impact.peak / law.peak_force() - 1.0).abs() < 1e-7);
    assert!((impact.duration / law.duration() - 1.0).abs() < 1e-6);
    let after = body_state(&mut system, &impact.y, 0);
    assert!((after.velocity.z / 0.1 - 1.0).abs() < 1e-8);
    // The force acts through the centre of mass: no spin, whatever the frame.
    assert!(after.angular_velocity_in_body.norm() * RADIUS < 1e-10 * 0.1);
}

#[test]
fn force_is_minus_the_gradient_of_the_elastic_energy_on_flexible_bodies_too() {
    let shapes = vec![Vector3::new(0.3, -0.2, 0.9), Vector3::new(-0.5, 0.4, 0.1)];
    let mut first = sphere(0, RADIUS, Vector3::new(0.01, 0.0, -0.02));
    first.centre.shapes = shapes;
    let contact =
        HertzContact::of_spheres(first, Target::Body(sphere(1, 2.0 * RADIUS, Vector3::zeros())), STEEL)
            .unwrap();
    let mut contact = Active::new(contact);
    let mut a = BodyState::at_rest(2);
    a.elastic = vec![1e-4, -2e-4];
    a.rotation = UnitQuaternion::from_euler_angles(0.2, 0.1, -0.4);
    let b = BodyState::at_rest(0);
    let direction = Vector3::new(0.3, 0.5, -0.8).normalize();
    a.position = direction * (3.0 * RADIUS - 2e-5) - a.rotation * (Vector3::new(0.01, 0.0, -0.02));
    let mut evaluate = |a: &BodyState| {
        let mut forces = [GeneralisedForce::zeros(2), GeneralisedForce::zeros(0)];
        contact.evaluate(Motion::new(0.0, &[a.clone(), b.clone()]), &mut forces).unwrap();
        let gap = contact.meeting(Motion::new(0.0, &[a.clone(), b.clone()])).gap;
        assert!((contact.report().penetration + gap).abs() < 1e-18);
        (forces, contact.energies().elastic_high)
    };
    let (forces, energy) = evaluate(&a);
    assert!(energy > 0.0 && (forces[0].force + forces[1].force).norm() < f64::MIN_POSITIVE);
    let (h, scale) = (1e-9, forces[0].force.norm());
    // Central differences at h = 1e-4 of the approach: error about 1e-8.
    for k in 0..3 {
        let mut shift = |step: f64| {
            let mut moved = a.clone();
            moved.position[k] += step;
            evaluate(&moved).1
        };
        assert!((forces[0].force[k] + (shift(h) - shift(-h)) / (2.0 * h)).abs() < 1e-6 * scale);
        let mut turn = |step: f64| {
            let mut moved = a.clone();
            let mut axis = Vector3::zeros();
            axis[k] = step;
            moved.rotation *= UnitQuaternion::from_scaled_axis(axis);
            evaluate(&moved).1
        };
        let slope = (turn(1e-7) - turn(-1e-7)) / 2e-7;
        assert!((forces[0].torque_in_body[k] + slope).abs() < 1e-6 * scale * RADIUS, "{k}");
    }
    for k in 0..2 {
        let mut bend = |step: f64| {
            let mut moved = a.clone();
            moved.elastic[k] += step;
            evaluate(&moved).1
        };
        assert!((forces[0].elastic[k] + (bend(h) - bend(-h)) / (2.0 * h)).abs() < 1e-6 * scale);
    }
}

#[test]
fn spheres_that_make_no_contact_are_refused() {
    let plane = Plane { point: Vector3::zeros(), normal: UnitVector3::new_normalize(Vector3::x()) };
    let rigid = Sphere { solid: Solid::RIGID, ..sphere(0, RADIUS, Vector3::zeros()) };
    let refused = |r: Result<HertzContact, ContactError>| {
        matches!(r, Err(ContactError::Data(_) | ContactError::RigidPair))
    };
    assert!(refused(HertzContact::of_spheres(rigid.clone(), Target::Plane(plane), Solid::RIGID)));
    assert!(refused(HertzContact::of_spheres(
        sphere(0, -1.0, Vector3::zeros()),
        Target::Plane(plane),
        STEEL
    )));
    assert!(refused(HertzContact::of_spheres(
        sphere(0, f64::NAN, Vector3::zeros()),
        Target::Plane(plane),
        STEEL
    )));
    assert!(HertzContact::of_spheres(rigid, Target::Plane(plane), STEEL).is_ok());
    let on_body = |body: usize| sphere(body, RADIUS, Vector3::zeros());
    assert!(HertzContact::of_spheres(on_body(1), Target::Body(on_body(1)), STEEL).is_err());
    // Centres that coincide have no direction.
    let mut contact =
        Active::new(HertzContact::of_spheres(on_body(0), Target::Body(on_body(1)), STEEL).unwrap());
    let bodies = [BodyState::at_rest(0), BodyState::at_rest(0)];
    let mut forces = [GeneralisedForce::zeros(0), GeneralisedForce::zeros(0)];
    assert_eq!(
        contact.evaluate(Motion::new(0.0, &bodies), &mut forces).unwrap_err().kind(),
        FailureKind::NotFinite
    );
    assert!(contact.meeting(Motion::new(0.0, &bodies)).gap.is_nan());
}

#[test]
fn a_law_without_points_says_so_whatever_it_is_asked() {
    let spheres = [0, 1].map(|body| sphere(body, RADIUS, Vector3::zeros()));
    let [own, other] = spheres;
    let mut contact = Active::new(HertzContact::of_spheres(own, Target::Body(other), STEEL).unwrap());
    let bodies = [BodyState::at_rest(0), at(Vector3::z() * RADIUS, Vector3::zeros())];
    let mut forces = [GeneralisedForce::zeros(0), GeneralisedForce::zeros(0)];
    contact.evaluate(Motion::new(0.0, &bodies), &mut forces).unwrap();
    assert!(contact.report().normal_force > 0.0);
    assert!(contact.facts().point(0).is_none() && contact.point_forces().is_none());
    assert!(contact.compliance_weight(Motion::new(0.0, &bodies), 0.0).unwrap().is_none());
    assert!(matches!(contact.set_penalty(1.0), Err(ContactError::NoPenalty { .. })));
    let mut untouched = [7.0];
    assert!(!contact.interface_force(0, &mut untouched));
    assert!(untouched.iter().all(|force: &f64| force.to_bits() == 7.0_f64.to_bits()));
}

#[test]
fn contacts_left_out_for_their_distance_change_no_bit() {
    // Balls that fly through each other, all pairs of them and a plane: some touch, most do not, and who does changes. A
    // system that has just been made leaves nothing out. One centre lies beside its frame, which turns.
    let n = 6;
    let centre = |i: usize| Vector3::new(0.0, if i == 2 { 0.3 * RADIUS } else { 0.0 }, 0.0);
    let names = ["a", "b", "c", "d", "e", "f"];
    let system = || {
        let ball = |i: usize| sphere(i, RADIUS, centre(i));
        let pairs = (0..n).flat_map(|i| (0..i).map(move |j| (i, Target::Body(ball(j)))));
        let plane = Plane { point: Vector3::zeros(), normal: Vector3::z_axis() };
        let all = pairs.chain((0..n).map(|i| (i, Target::Plane(plane))));
        let contact = |(i, target)| HertzContact::of_spheres(ball(i), target, STEEL).unwrap();
        let forces = all.map(|pair| Box::new(Active::new(contact(pair)))).collect();
        let bodies = names.iter().enumerate().map(|(i, name)| (*name, self::ball(RADIUS, centre(i))));
        free_system(bodies.collect(), Vector3::zeros(), forces)
    };
    let motion = |i: usize, k: usize| {
        let (i, t) = (i as f64, k as f64 / 400.0);
        let place = Vector3::new(0.021 * i, 0.004 * i.sin(), 0.0102);
        let velocity = Vector3::new((2.0 * i).cos(), 0.5 * (3.0 * i).sin(), 0.02 * i.cos()) * 0.06;
        let rotation = UnitQuaternion::from_euler_angles(3.0 * t, 2.0 * t * i, -t);
        BodyState { rotation, ..at(place + velocity * t, velocity) }
    };
    let mut kept = system();
    let (mut touches, mut least) = (0, usize::MAX);
    for k in 0..400 {
        let states: Vec<BodyState> = (0..n).map(|i| motion(i, k)).collect();
        let mut fresh = system();
        let y = state_vector(&kept, &states);
        kept.evaluate_forces(0.0, &y).unwrap();
        fresh.evaluate_forces(0.0, &y).unwrap();
        let bits = |system: &Multibody<Box<Active<HertzContact>>>| {
            let sums = system.last_evaluation().1.iter().flat_map(|sum| [sum.force, sum.torque_in_body]);
            let found = system.forces().iter().map(|force| force.report().force);
            sums.chain(found).flat_map(|v| [v.x, v.y, v.z]).map(f64::to_bits).collect::<Vec<_>>()
        };
        assert_eq!(bits(&kept), bits(&fresh), "at {k}");
        let touching = fresh.forces().iter().filter(|force| force.report().normal_force > 0.0).count();
        (touches, least) = (touches.max(touching), least.min(touching));
    }
    assert!(touches > least, "contacts open and close: {least} to {touches}");
}
