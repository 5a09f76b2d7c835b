//! Hertz contacts of surfaces of any curvature: potential, momentum and energy, friction with stick and slip.

use std::f64::consts::PI;
use std::sync::Arc;

use crate::free_motion::{body_state, free_system, state_vector};
use crate::hertz_impact::HertzImpact;
use contact_qs::law::Solid;
use contact_qs::{ActiveContact, ContactError, Detector, HertzContact, Plane, Sphere, SurfaceModel, Target};
use ffr_dynamics::body::{RigidMotion, StandardInputData};
use ffr_dynamics::force::active::{Active, ActiveForce};
use ffr_dynamics::force::{BodyState, GeneralisedForce, Motion};
use ffr_dynamics::integration::{Integrator, StepSettings};
use ffr_dynamics::kinematics::FlexiblePoint;
use ffr_dynamics::system::{ErrorScale, Multibody};
use iga_core::nurbs::Patch;
use iga_core::nurbs::primitives::plane::disc;
use iga_core::nurbs::primitives::sphere::ellipsoid;
use nalgebra::{Matrix3, UnitQuaternion, Vector3};

const STEEL: Solid = Solid { young: 2.1e11, poisson: 0.3 };
const DENSITY: f64 = 7850.0;
const AXES: [f64; 3] = [0.02, 0.015, 0.01];

fn surface(axes: [f64; 3]) -> Arc<SurfaceModel> {
    let shape = ellipsoid(axes).unwrap();
    Arc::new(SurfaceModel::rigid(RigidMotion::Spatial, &shape.patches).unwrap())
}

/// Hertz' law between the surfaces of two bodies.
fn of_two(models: [Arc<SurfaceModel>; 2]) -> HertzContact {
    let surfaces = Detector::of(0, Target::Body(1), |body| Ok::<_, ContactError>(Arc::clone(&models[body])));
    HertzContact::of_surfaces(surfaces.unwrap(), [STEEL; 2]).unwrap()
}

fn solid_ellipsoid([a, b, c]: [f64; 3]) -> StandardInputData {
    let mass = DENSITY * 4.0 / 3.0 * PI * a * b * c;
    let squares = Vector3::new(b * b + c * c, a * a + c * c, a * a + b * b);
    let inertia = Matrix3::from_diagonal(&(squares * (0.2 * mass)));
    StandardInputData::rigid(RigidMotion::Spatial, mass, Vector3::zeros(), inertia).unwrap()
}

fn at(position: Vector3<f64>, rotation: UnitQuaternion<f64>) -> BodyState {
    BodyState { position, rotation, ..BodyState::at_rest(0) }
}

/// A generic pose of two ellipsoids that overlap by `overlap`.
fn pair_pose(contact: &mut Active<HertzContact>, overlap: f64) -> [BodyState; 2] {
    let first = at(Vector3::new(0.02, 0.012, 0.02), UnitQuaternion::from_euler_angles(0.4, -0.7, 1.1));
    let second = at(Vector3::zeros(), UnitQuaternion::from_euler_angles(-0.2, 0.5, 0.3));
    let mut poses = [first, second];
    for _ in 0..30 {
        let motion = Motion::new(0.0, &poses);
        let (gap, normal) = {
            let found = contact.meeting(motion);
            (found.gap, found.normal)
        };
        poses[0].position -= normal * (gap + overlap);
    }
    poses
}

/// Differences of the energy of `contact` at `poses` over ways along and turns about the `axes`: none is farther from the forces than `limits`
/// say, of the normal force, and of its moment with the arm `arm`.
fn check_gradient(
    contact: &mut Active<HertzContact>,
    poses: &[BodyState; 2],
    axes: [&[usize]; 2],
    (limits, arm): ([f64; 2], f64),
) {
    let mut evaluate = |poses: &[BodyState; 2]| {
        let mut forces = [GeneralisedForce::zeros(0), GeneralisedForce::zeros(0)];
        contact.evaluate(Motion::new(0.0, poses), &mut forces).unwrap();
        (forces, contact.energies().elastic_high)
    };
    let (forces, energy) = evaluate(poses);
    assert!(energy > 0.0);
    let normal_force = forces[0].force.norm();
    for b in 0..2 {
        let mut slope = |k: usize, step: f64, is_turn: bool| {
            let axis = Vector3::ith(k, 1.0);
            let mut energy = |step: f64| {
                let mut moved = poses.clone();
                if is_turn {
                    moved[b].rotation *= UnitQuaternion::from_scaled_axis(axis * step);
                } else {
                    moved[b].position += axis * step;
                }
                evaluate(&moved).1
            };
            (energy(step) - energy(-step)) / (2.0 * step)
        };
        for k in axes[0] {
            let error = (forces[b].force[*k] + slope(*k, 1e-7, false)).abs();
            assert!(error < limits[0] * normal_force, "{b} {k} force {error:e}");
        }
        for k in axes[1] {
            let lever = (forces[b].torque_in_body[*k] + slope(*k, 1e-5, true)).abs() / (normal_force * arm);
            assert!(lever < limits[1], "{b} {k} moment {lever:e}");
        }
    }
    // Action and reaction, about one point.
    let moments = [0, 1]
        .map(|b| poses[b].rotation * forces[b].torque_in_body + poses[b].position.cross(&forces[b].force));
    assert!((forces[0].force + forces[1].force).norm() < 1e-14 * normal_force);
    assert!((moments[0] + moments[1]).norm() < 1e-14 * normal_force * AXES[0]);
}

#[test]
fn forces_and_couples_are_the_gradient_of_the_energy() {
    let models = [surface(AXES), surface([0.012, 0.03, 0.017])];
    let mut contact = Active::new(of_two(models));
    // A fiftieth of the radii, so that what the change of the stiffness exerts is seen.
    let poses = pair_pose(&mut contact, 2e-4);
    // What is left out of the couple is of the size of the overlap over the radius, 0.02, of what is there of it, itself 0.004 of the force
    // (times the radius): 1e-4 at most; differences of the curvature, a thousandth of its step, are below.
    let all = [0, 1, 2];
    check_gradient(&mut contact, &poses, [&all, &all], ([1e-4; 2], AXES[2]));
    let mut contact = Active::new(of_two_ellipses());
    let poses = plane_pose(&mut contact, 4e-5);
    // An overlap of a four hundredth of the radii, and what the change of the stiffness exerts is 5e-4 of the force.
    check_gradient(&mut contact, &poses, [&[0, 1], &[2]], ([2e-6; 2], 0.01));
}

/// An ellipse of the semi-axes `axes` in the plane.
fn ellipse(axes: [f64; 2]) -> Arc<SurfaceModel> {
    let circle = disc(1.0).unwrap().patches;
    let scaled = circle.iter().map(|patch| {
        let points = patch.control_points().iter().map(|p| [p[0] * axes[0], p[1] * axes[1], p[2]]);
        Patch::new(patch.knots().to_vec(), points.collect(), patch.weights().to_vec()).unwrap()
    });
    Arc::new(SurfaceModel::rigid(RigidMotion::Planar, &scaled.collect::<Vec<_>>()).unwrap())
}

/// Half axes of the ellipses that touch along a line \[m\], and their thicknesses.
const ELLIPSES: [[f64; 2]; 2] = [[0.02, 0.012], [0.012, 0.03]];
const THICKNESSES: [f64; 2] = [0.02, 0.005];

fn of_plane(models: &[Arc<SurfaceModel>], target: Target, solids: [Solid; 2]) -> HertzContact {
    let surfaces = Detector::of(0, target, |body| Ok::<_, ContactError>(Arc::clone(&models[body])));
    HertzContact::of_plane_surfaces(surfaces.unwrap(), solids, THICKNESSES.map(Some)).unwrap()
}

fn of_two_ellipses() -> HertzContact {
    of_plane(&ELLIPSES.map(ellipse), Target::Body(1), [STEEL; 2])
}

/// A generic pose of two ellipses that overlap by `overlap`.
fn plane_pose(contact: &mut Active<HertzContact>, overlap: f64) -> [BodyState; 2] {
    let turned = |angle: f64| UnitQuaternion::from_scaled_axis(Vector3::z() * angle);
    let mut poses = [at(Vector3::new(0.02, 0.022, 0.0), turned(0.7)), at(Vector3::zeros(), turned(-0.4))];
    for _ in 0..30 {
        let found = contact.meeting(Motion::new(0.0, &poses));
        poses[0].position -= found.normal * (found.gap + overlap);
    }
    poses
}

/// Johnson's Eqs. 4.45 and 5.57: the centres of discs of the radii `R` come nearer to the place of the touch by
/// `P (1 - ν²)/(π E) (2 ln(4 R/a) - 1)` under the load `P` a metre, a half space that moves as a whole as if it had the size of the disc.
#[test]
fn discs_come_nearer_by_the_logarithm_of_their_diameters() {
    let soft = Solid { young: 3e9, poisson: 0.4 };
    let radii = [0.03, 0.01];
    let models = radii.map(|radius| ellipse([radius; 2]));
    let ground = Target::plane(Vector3::zeros(), Vector3::y());
    for (target, radii, thicknesses) in
        [(Target::Body(1), radii, THICKNESSES), (ground, [0.03, f64::INFINITY], THICKNESSES)]
    {
        let mut contact = Active::new(of_plane(&models, target, [STEEL, soft]));
        let overlap = 2e-5;
        let rest = if target.body().is_some() { radii[0] + radii[1] } else { radii[0] };
        let mut poses = vec![at(Vector3::new(0.0, rest - overlap, 0.0), UnitQuaternion::identity())];
        poses.extend(target.body().map(|_| BodyState::at_rest(0)));
        let mut forces: Vec<_> = poses.iter().map(|_| GeneralisedForce::zeros(0)).collect();
        contact.evaluate(Motion::new(0.0, &poses), &mut forces).unwrap();
        let force = forces[0].force.y;
        let loads = thicknesses.map(|t| force / t);
        let yields = [STEEL, soft].map(Solid::compliance);
        let curvature: f64 = radii.iter().map(|r| 1.0 / r).sum();
        let pressed: f64 = loads.iter().zip(yields).map(|(p, c)| p * c).sum();
        let a = (4.0 * pressed / (PI * curvature)).sqrt();
        let sizes = radii.map(|r| if r.is_finite() { r } else { radii[0] });
        let approach: f64 =
            (0..2).map(|i| loads[i] * yields[i] / PI * (2.0 * (4.0 * sizes[i] / a).ln() - 1.0)).sum();
        // Round-off of a gap of 2e-5 m between places 0.04 m from the origin, times the slope of the logarithm.
        assert!((approach / overlap - 1.0).abs() < 1e-10, "{approach:e} against {overlap:e}");
        let area = contact.report().contact_area;
        assert!((area / (2.0 * a * thicknesses[0]) - 1.0).abs() < 1e-10, "{area:e}");
    }
    // In plane stress a body yields by 1/E.
    assert!((STEEL.of_plane_stress().compliance() * STEEL.young - 1.0).abs() < 1e-14);
    let surfaces = Detector::of(0, ground, |body| Ok::<_, ContactError>(Arc::clone(&models[body]))).unwrap();
    assert!(HertzContact::of_plane_surfaces(surfaces, [STEEL; 2], [Some(0.0), None]).is_err());
}

#[test]
fn a_touch_in_the_plane_is_followed_from_piece_to_piece() {
    let (contact, overlap) = (of_two_ellipses(), 1e-5);
    let from_scratch = |poses: &[BodyState; 2]| Active::new(contact.clone()).meeting(Motion::new(0.0, poses));
    let mut followed = Active::new(contact.clone());
    let mut poses = plane_pose(&mut followed, overlap);
    for _ in 0..160 {
        poses[0].rotation *= UnitQuaternion::from_scaled_axis(Vector3::z() * 0.04);
        for _ in 0..8 {
            let found = from_scratch(&poses);
            poses[0].position -= found.normal * (found.gap + overlap);
        }
        let [found, known] = [followed.meeting(Motion::new(0.0, &poses)), from_scratch(&poses)];
        // Round-off of places 0.03 m from the origin; the place of a smallest gap is known to the root of that.
        assert!((found.gap - known.gap).abs() < 1e-16, "{:e}", found.gap - known.gap);
        assert!((found.place - known.place).norm() < 1e-9, "{:e}", (found.place - known.place).norm());
    }
}

#[test]
fn spinning_ellipses_keep_energy_and_momentum() {
    let body = |[a, b]: [f64; 2], thickness: f64| {
        let mass = DENSITY * PI * a * b * thickness;
        let inertia = Matrix3::from_diagonal(&(Vector3::new(b * b, a * a, a * a + b * b) * (0.25 * mass)));
        StandardInputData::rigid(RigidMotion::Planar, mass, Vector3::zeros(), inertia).unwrap()
    };
    for friction in [0.0, 0.3] {
        let contact = of_two_ellipses().with_friction(friction).unwrap();
        let mut poses = plane_pose(&mut Active::new(contact.clone()), -1e-9);
        poses[0].angular_velocity_in_body = Vector3::z() * -400.0;
        poses[1].angular_velocity_in_body = Vector3::z() * -250.0;
        poses[0].velocity = Active::new(contact.clone()).meeting(Motion::new(0.0, &poses)).normal * -1.0;
        let bodies = vec![("a", body(ELLIPSES[0], THICKNESSES[0])), ("b", body(ELLIPSES[1], THICKNESSES[1]))];
        let mut system = free_system(bodies, Vector3::zeros(), vec![Box::new(Active::new(contact))]);
        let (energy, momentum, _) = drift(&mut system, &poses, (1.5e-4, 2e-7));
        // As of ellipsoids.
        let limit = if friction > 0.0 { 1e-5 } else { 1e-6 };
        assert!(energy < limit, "energy {energy:e} at friction {friction}");
        assert!(momentum < 1e-12, "momentum {momentum:e} at friction {friction}");
    }
}

#[test]
fn surfaces_of_balls_are_spheres() {
    let models = [surface([0.01; 3]), surface([0.02; 3])];
    let mut surfaces = Active::new(of_two(models));
    let sphere = |body: usize, radius: f64| Sphere {
        body,
        centre: FlexiblePoint::rigid(Vector3::zeros()),
        radius,
        solid: STEEL,
    };
    let mut spheres =
        Active::new(HertzContact::of_spheres(sphere(0, 0.01), Target::Body(sphere(1, 0.02)), STEEL).unwrap());
    let direction = Vector3::new(0.36, 0.48, 0.8);
    let turn = UnitQuaternion::from_euler_angles(0.1, 0.9, -0.6);
    let poses = [at(direction * (0.03 - 1e-5), turn), at(Vector3::zeros(), UnitQuaternion::identity())];
    let none = || [GeneralisedForce::zeros(0), GeneralisedForce::zeros(0)];
    let mut forces = [none(), none()];
    surfaces.evaluate(Motion::new(0.0, &poses), &mut forces[0]).unwrap();
    spheres.evaluate(Motion::new(0.0, &poses), &mut forces[1]).unwrap();
    let size = forces[1][0].force.norm();
    // Round-off of a gap of 1e-5 m between places 0.03 m from the origin, times 3/2.
    assert!((forces[0][0].force - forces[1][0].force).norm() < 1e-9 * size);
    assert!(forces[0][0].torque_in_body.norm() < 1e-8 * size * 0.01);
}

/// Largest change of energy over the kinetic energy at the start, and of both momenta over those of the first body, in an impact from `start`, and the
/// state at its end.
fn drift(
    system: &mut Multibody<Box<Active<HertzContact>>>,
    start: &[BodyState],
    (end, step): (f64, f64),
) -> (f64, f64, Vec<f64>) {
    let y = state_vector(system, start);
    let scale = ErrorScale { relative: 1e-10, ..system.error_scale() };
    system.set_error_scale(scale).unwrap();
    let mut integrator = Integrator::explicit(StepSettings::with_max_step(step), 0.0, &y).unwrap();
    let before = system.invariants(0.0, &y);
    let size = before.linear_momentum.norm();
    system.evaluate_forces(0.0, &y).unwrap();
    let held = before.kinetic + before.gravity + system.forces()[0].energies().elastic_high;
    let (mut energy, mut momentum) = (0.0_f64, 0.0_f64);
    let mut has_touched = false;
    while integrator.time() < end {
        integrator.step(system, end).unwrap();
        let y = integrator.state().to_vec();
        system.evaluate_forces(integrator.time(), &y).unwrap();
        let energies = system.forces()[0].energies();
        let now = system.invariants(integrator.time(), &y);
        let total =
            now.kinetic + now.gravity + energies.elastic_high + energies.penalty + system.dissipated_work(&y);
        has_touched |= energies.elastic_high > 0.0;
        energy = energy.max((total - held).abs() / before.kinetic);
        momentum = momentum.max((now.linear_momentum - before.linear_momentum).norm() / size);
        let angular = (now.angular_momentum - before.angular_momentum).norm();
        momentum = momentum.max(angular / (size * AXES[0]));
    }
    assert!(has_touched, "no impact");
    (energy, momentum, integrator.state().to_vec())
}

#[test]
fn spinning_ellipsoids_keep_energy_and_momentum() {
    let bodies = || vec![("a", solid_ellipsoid(AXES)), ("b", solid_ellipsoid([0.012, 0.03, 0.017]))];
    for friction in [0.0, 0.3] {
        let models = [surface(AXES), surface([0.012, 0.03, 0.017])];
        let contact = of_two(models);
        let contact = contact.with_friction(friction).unwrap();
        let mut poses = pair_pose(&mut Active::new(contact.clone()), -1e-9);
        // Spins that turn the bodies by 0.05 while they touch: the stiffness changes by per cents.
        poses[0].angular_velocity_in_body = Vector3::new(300.0, -200.0, 400.0);
        poses[1].angular_velocity_in_body = Vector3::new(-100.0, 500.0, 50.0);
        let normal = Active::new(contact.clone()).meeting(Motion::new(0.0, &poses)).normal;
        poses[0].velocity = normal * -1.0;
        let mut system = free_system(bodies(), Vector3::zeros(), vec![Box::new(Active::new(contact))]);
        let (energy, momentum, _) = drift(&mut system, &poses, (1.5e-4, 2e-7));
        // The couple leaves out the overlap over the radius of itself (1e-5 of the energy times 3e-3), differences of the curvature over
        // the pieces' ends; friction has the second order of the step, a three hundredth of the impact.
        let limit = if friction > 0.0 { 1e-5 } else { 1e-6 };
        assert!(energy < limit, "energy {energy:e} at friction {friction}");
        assert!(momentum < 1e-12, "momentum {momentum:e} at friction {friction}");
    }
}

/// Normal speed of oblique impacts [m/s]: slow, so that the contact, over the radius of the ball, is flat.
const SPEED: f64 = 1e-3;

/// A ball of steel on a half space of steel at a small normal speed and the tangential speed that `psi` says
/// (Maw, Barber & Fawcett 1976): both over the speed at which Coulomb's limit is reached as soon as the bodies touch. Returns the
/// tangential speed of the surface after the impact in the same unit, energy and restitution.
fn oblique(psi: f64, friction: f64, step: f64) -> (f64, f64, f64) {
    let radius = 0.01;
    let sphere = Sphere { body: 0, centre: FlexiblePoint::rigid(Vector3::zeros()), radius, solid: STEEL };
    let plane = Plane { point: Vector3::zeros(), normal: Vector3::z_axis() };
    let contact = HertzContact::of_spheres(sphere, Target::Plane(plane), STEEL)
        .unwrap()
        .with_friction(friction)
        .unwrap();
    let body = solid_ellipsoid([radius; 3]);
    let duration = HertzImpact::new(contact.pair().unwrap(), [body.mass, f64::INFINITY], SPEED).duration();
    // Tangential over normal stiffness of a circle.
    let ratio = 2.0 * (1.0 - 0.3) / (2.0 - 0.3);
    let unit = SPEED * friction / ratio;
    let mut start = at(Vector3::new(0.0, 0.0, radius), UnitQuaternion::identity());
    start.velocity = Vector3::new(0.8, 0.6, 0.0) * (psi * unit) - Vector3::z() * SPEED;
    let mut system =
        free_system(vec![("ball", body)], Vector3::zeros(), vec![Box::new(Active::new(contact))]);
    let (energy, _, y) = drift(&mut system, &[start], (1.01 * duration, step * duration));
    let end = body_state(&mut system, &y, 0);
    let spin = end.rotation * end.angular_velocity_in_body;
    let surface = end.velocity + spin.cross(&Vector3::new(0.0, 0.0, -radius));
    let along = Vector3::new(0.8, 0.6, 0.0);
    assert!(surface.cross(&along).z.abs() < 1e-9 * SPEED, "sliding has left its plane");
    (surface.dot(&along) / unit, energy, end.velocity.z / SPEED)
}

#[test]
fn oblique_impacts_are_those_of_a_uniform_foundation_of_springs() {
    // Gross slip throughout: the impulse is μ times the normal one, 2 m v (closed form): ψ₂ = ψ₁ - 2 (1 + 5/2) ratio.
    let ratio = 2.0 * 0.7 / 1.7;
    let (psi, energy, restitution) = oblique(8.0, 0.3, 2e-3);
    // The lever of the friction is shorter by half the approach, 5e-6 of the radius; tolerance of the steps.
    assert!((psi - (8.0 - 7.0 * ratio)).abs() < 1e-4, "gross slip {psi}");
    assert!(energy < 1e-6 && (restitution - 1.0).abs() < 1e-5, "{energy:e} {restitution}");
    for (psi, expected) in FOUNDATION {
        let (found, energy, _) = oblique(psi, 0.3, 2e-3);
        // The outermost of the levels is 4.4 % of the contact wide.
        assert!((found - expected).abs() < 0.03, "{psi}: {found} against {expected}");
        assert!(energy < 1e-5, "{psi}: energy {energy:e}");
    }
}

/// Tangential speeds before and after impacts with `ν = 0.3` and the inertia of a solid ball: uniform Winkler foundation of 1000 springs (Popov and Heß,
/// method of dimensionality reduction), 40,000 steps, its difference to 500 springs and 20,000 steps below 0.001.
const FOUNDATION: [(f64, f64); 6] =
    [(0.5, 0.0478), (1.0, -0.0597), (2.0, -0.8372), (3.0, -1.3797), (4.0, -1.4365), (5.0, -0.7647)];

#[test]
fn a_sliding_ball_ends_rolling_at_five_sevenths() {
    // Soft enough to be integrated while it slides, which takes 2 v/(7 μ g).
    let (radius, friction, speed) = (0.01, 0.3, 0.1);
    let rubber = Solid { young: 1e8, poisson: 0.3 };
    let sphere = Sphere { body: 0, centre: FlexiblePoint::rigid(Vector3::zeros()), radius, solid: rubber };
    let plane = Plane { point: Vector3::zeros(), normal: Vector3::z_axis() };
    let contact = HertzContact::of_spheres(sphere, Target::Plane(plane), Solid::RIGID)
        .unwrap()
        .with_friction(friction)
        .unwrap();
    let body = solid_ellipsoid([radius; 3]);
    let mass = body.mass;
    let (sunk, contact_stiffness) =
        (contact.pair().unwrap().approach(mass * 9.81), contact.pair().unwrap().stiffness());
    let mut start = at(Vector3::new(0.0, 0.0, radius - sunk), UnitQuaternion::identity());
    start.velocity = Vector3::new(speed, 0.0, 0.0);
    let gravity = Vector3::new(0.0, 0.0, -9.81);
    let mut system = free_system(vec![("ball", body)], gravity, vec![Box::new(Active::new(contact))]);
    let slides = 2.0 * speed / (7.0 * friction * 9.81);
    let (energy, _, y) = drift(&mut system, &[start], (1.5 * slides, 0.005 * slides));
    let end = body_state(&mut system, &y, 0);
    let spin = (end.rotation * end.angular_velocity_in_body).y * radius;
    // The moment of momentum about the place of the touch stays, but for the lever of the friction, which is shorter by half the approach.
    let mean = (end.velocity.x + 0.4 * spin) / 1.4;
    assert!((mean / (5.0 / 7.0 * speed) - 1.0).abs() < 0.5 * sunk / radius, "{mean}");
    // About rolling the contact springs back and forth by what its springs hold, `μ m g`, at `sqrt(7/2 k_T/m)`.
    let stiffness = 2.0 * 0.7 / 1.7 * 1.5 * contact_stiffness * sunk.sqrt();
    let swing = friction * 9.81 * (3.5 * mass / stiffness).sqrt();
    assert!((end.velocity.x - spin).abs() < 1.05 * swing, "{} above {swing}", end.velocity.x - spin);
    // A fiftieth of a swing is a step: the second order of that, of what the springs hold, 6e-3.
    assert!(energy < 1e-5, "{energy:e}");
}
