//! Friction of Hertz contacts of bodies that roll and spin on each other: where it acts, what work it does, and that nothing creeps.

use std::sync::Arc;

use contact_qs::law::Solid;
use contact_qs::{
    ActiveContact, ContactError, Detector, DofLookup, HertzContact, Plane, Sphere, SurfaceModel, Target,
};
use faer::Mat;
use ffr_dynamics::body::{Dof, RigidMotion};
use ffr_dynamics::force::active::{Active, ActiveForce};
use ffr_dynamics::force::{BodyState, GeneralisedForce, Motion};
use ffr_dynamics::kinematics::FlexiblePoint;
use iga_core::nurbs::Shape;
use iga_core::nurbs::primitives::round::torus;
use iga_core::nurbs::primitives::solid::hollow_cylinder;
use iga_core::nurbs::primitives::sphere::ellipsoid;
use iga_core::space::{PatchSpace, Space};
use nalgebra::{UnitQuaternion, Vector3};

const STEEL: Solid = Solid { young: 2.1e11, poisson: 0.3 };
/// Radius of the ball that rolls \[m\].
const RADIUS: f64 = 0.01;
/// By how much it is pressed into what it rolls on \[m\].
const OVERLAP: f64 = 1e-5;
/// Spin of the ball about the normal [rad/s].
const SPIN: f64 = 150.0;
/// How far the springs are stretched before the ball rolls \[m\].
const STRETCH: f64 = 1e-7;
/// So rough that nothing slides.
const ROUGH: f64 = 1e3;

fn turn(rate: Vector3<f64>, time: f64) -> UnitQuaternion<f64> {
    UnitQuaternion::from_scaled_axis(rate * time)
}

fn surface(shape: &Shape) -> Arc<SurfaceModel> {
    Arc::new(SurfaceModel::rigid(RigidMotion::Spatial, &shape.patches).unwrap())
}

fn ball() -> Arc<SurfaceModel> {
    surface(&ellipsoid([RADIUS; 3]).unwrap())
}

/// Hertz' law between the surfaces `models`, of which a plane has none.
fn of_surfaces(target: Target, models: &[Arc<SurfaceModel>]) -> HertzContact {
    let surfaces = Detector::of(0, target, |body| Ok::<_, ContactError>(Arc::clone(&models[body])));
    HertzContact::of_surfaces(surfaces.unwrap(), [STEEL; 2]).unwrap()
}

fn sphere(body: usize, radius: f64, shapes: &[Vector3<f64>]) -> Sphere {
    let centre = FlexiblePoint { shapes: shapes.to_vec(), ..FlexiblePoint::rigid(Vector3::zeros()) };
    Sphere { body, centre, radius, solid: STEEL }
}

/// A ball that rolls on a target with a symmetry, along it, without sliding.
struct Rolling {
    name: &'static str,
    contact: HertzContact,
    /// Place of the first touch on the target and the normal towards the ball.
    place: Vector3<f64>,
    normal: Vector3<f64>,
    /// Screw of the touch in the frame of the target: it turns by the first and goes along the second.
    screw: [Vector3<f64>; 2],
    has_target: bool,
    /// Whether the ball is the target of the contact, and the target its contact body.
    is_swapped: bool,
    /// Elastic coordinates of the bodies of the contact over the time.
    elastic: fn(f64) -> [Vec<f64>; 2],
}

impl Rolling {
    /// Position of the ball's centre when it begins.
    fn centre(&self) -> Vector3<f64> {
        self.place + self.normal * (RADIUS - OVERLAP)
    }

    /// Turn of the ball against what is carried with the touch: it does not slide where both surfaces would be without the overlap's
    /// halves, and spins.
    fn relative(&self) -> Vector3<f64> {
        let [turn, along] = self.screw;
        let velocity = turn.cross(&self.centre()) + along;
        self.normal.cross(&velocity) / (RADIUS - 0.5 * OVERLAP) + self.normal * SPIN - turn
    }

    /// Speed of the touch over the target.
    fn speed(&self) -> f64 {
        let [turn, along] = self.screw;
        (turn.cross(&(self.place - self.normal * (0.5 * OVERLAP))) + along).norm()
    }

    /// Motions of the bodies at `time`, the ball beside rolling by `shift` across the normal and with the turn `more`; both bodies have a
    /// motion in common.
    fn poses(&self, time: f64, shift: Vector3<f64>, more: UnitQuaternion<f64>) -> Vec<BodyState> {
        let carried = turn(self.screw[0], time);
        let elastic = (self.elastic)(time);
        let mut ball = BodyState::at_rest(0);
        ball.position = carried * (self.centre() + shift) + self.screw[1] * time;
        ball.rotation = carried * turn(self.relative(), time) * more;
        let mut poses = vec![ball];
        if self.has_target {
            poses.push(BodyState::at_rest(0));
            let common = turn(Vector3::new(30.0, -20.0, 50.0), time);
            for pose in &mut poses {
                pose.position = common * pose.position + Vector3::new(0.7, 1.1, -0.4) * time;
                pose.rotation = common * pose.rotation;
            }
        }
        if self.is_swapped {
            poses.swap(0, 1);
        }
        for (pose, q) in poses.iter_mut().zip(elastic) {
            pose.elastic_rates = vec![0.0; q.len()];
            pose.elastic = q;
        }
        poses
    }

    fn at(&self, time: f64) -> Vec<BodyState> {
        self.poses(time, Vector3::zeros(), UnitQuaternion::identity())
    }

    /// A direction across the normal, askew to the way of the touch.
    fn askew(&self) -> Vector3<f64> {
        let [turn, along] = self.screw;
        let way = (turn.cross(&self.place) + along).normalize();
        (way * 0.8 + self.normal.cross(&way) * 0.6).normalize()
    }

    /// The contact with its springs stretched by `STRETCH`, accepted where the ball begins to roll, and its force there.
    fn stretched(&self, friction: f64) -> (Active<HertzContact>, Vector3<f64>) {
        let mut contact = Active::new(self.contact.clone().with_friction(friction).unwrap());
        evaluate(&mut contact, &self.poses(0.0, self.askew() * -STRETCH, UnitQuaternion::identity()));
        contact.save();
        evaluate(&mut contact, &self.at(0.0));
        contact.save();
        let force = contact.report().friction_force;
        (contact, force)
    }
}

fn evaluate(contact: &mut Active<HertzContact>, poses: &[BodyState]) -> Vec<GeneralisedForce> {
    let mut forces: Vec<_> = poses.iter().map(|pose| GeneralisedForce::zeros(pose.elastic.len())).collect();
    contact.evaluate(Motion::new(0.0, poses), &mut forces).unwrap();
    forces
}

fn no_modes(_: f64) -> [Vec<f64>; 2] {
    [Vec::new(), Vec::new()]
}

/// A ball with three modes that change within a tenth of its radius.
fn soft_ball() -> Arc<SurfaceModel> {
    let fine = ellipsoid([RADIUS; 3]).unwrap().refined(&[4; 3], &[6, 6, 1], &[]).unwrap();
    let space = PatchSpace::new(fine.patches).unwrap();
    let dofs: Vec<_> = (0..3 * space.n_functions())
        .map(|k| Dof { node: (k / 3) as u32, component: (k % 3) as u8 })
        .collect();
    let shapes = Mat::from_fn(dofs.len(), 3, |k, mode| {
        let [x, y, z] = space.control_points()[k / 3].map(|x| 1e3 * x);
        (x * (1.0 + mode as f64) + 2.0 * y - z + (k % 3) as f64).sin()
    });
    let lookup = DofLookup::new(&dofs);
    let (motion, patches) = (RigidMotion::Spatial, space.patches());
    Arc::new(SurfaceModel::new(motion, patches, &space, &lookup, shapes.as_ref()).unwrap())
}

fn fast_modes(time: f64) -> [Vec<f64>; 2] {
    let (sine, cosine) = (5e3 * time).sin_cos();
    [vec![5e-7 * sine, -5e-7 * cosine, 3e-7 * cosine], Vec::new()]
}

/// Two modes of the first body, one of the second: they shift the centres of spheres.
fn some_modes(time: f64) -> [Vec<f64>; 2] {
    let (sine, cosine) = (4e3 * time).sin_cos();
    [vec![1e-6 * sine, 2e-6 * (1.0 - cosine)], vec![-3e-6 * sine]]
}

/// What rolls on what.
fn cases() -> Vec<Rolling> {
    let [x, z] = [Vector3::x(), Vector3::z()];
    let on_plane = |name, contact| Rolling {
        name,
        contact,
        place: Vector3::zeros(),
        normal: z,
        screw: [Vector3::zeros(), Vector3::new(0.6, 0.8, 0.0)],
        has_target: false,
        is_swapped: false,
        elastic: no_modes,
    };
    let plane = Plane { point: Vector3::zeros(), normal: Vector3::z_axis() };
    let of_sphere = HertzContact::of_spheres(sphere(0, RADIUS, &[]), Target::Plane(plane), STEEL).unwrap();
    let of_surface = of_surfaces(Target::Plane(plane), &[ball()]);
    let of_soft = of_surfaces(Target::Plane(plane), &[soft_ball()]);
    let direction = Vector3::new(0.36, 0.48, 0.8);
    let across = direction.cross(&x).normalize();
    let spheres = |name, contact, elastic| Rolling {
        name,
        contact,
        place: direction * 0.02,
        normal: direction,
        screw: [across * 50.0, Vector3::zeros()],
        has_target: true,
        is_swapped: false,
        elastic,
    };
    let two =
        HertzContact::of_spheres(sphere(0, RADIUS, &[]), Target::Body(sphere(1, 0.02, &[])), STEEL).unwrap();
    let shapes = [Vector3::new(0.3, -0.2, 0.9), Vector3::new(-0.5, 0.4, 0.1)];
    let soft = HertzContact::of_spheres(
        sphere(0, RADIUS, &shapes),
        Target::Body(sphere(1, 0.02, &shapes[..1])),
        STEEL,
    )
    .unwrap();
    let surfaces = |shape: &Shape, is_swapped: bool| {
        let mut models = [ball(), surface(shape)];
        if is_swapped {
            models.reverse();
        }
        of_surfaces(Target::Body(1), &models)
    };
    let around = turn(z, 0.3) * x;
    let on = |name, shape: &Shape, place, normal, along: f64, is_swapped| Rolling {
        name,
        contact: surfaces(shape, is_swapped),
        place,
        normal,
        screw: [z * 30.0, z * along],
        has_target: true,
        is_swapped,
        elastic: no_modes,
    };
    let jacket = hollow_cylinder(0.01, 0.03, 0.1).unwrap();
    let ring = torus(0.05, 0.015).unwrap();
    let lens = ellipsoid([0.03, 0.03, 0.015]).unwrap();
    vec![
        on_plane("sphere on plane", of_sphere),
        on_plane("surface on plane", of_surface),
        Rolling { elastic: fast_modes, ..on_plane("flexible surface on plane", of_soft) },
        spheres("sphere on sphere", two, no_modes),
        spheres("flexible sphere on flexible sphere", soft, some_modes),
        on("ball on cylinder", &jacket, around * 0.03 + z * 0.05, around, 0.7, false),
        on("cylinder on ball", &jacket, around * 0.03 + z * 0.05, around, 0.7, true),
        on("ball in ring", &ring, around * 0.035, -around, 0.0, false),
        on("ring about ball", &ring, around * 0.035, -around, 0.0, true),
        on("ball on spheroid", &lens, around * 0.03, around, 0.0, false),
    ]
}

/// Force of friction alone on the bodies at `poses`: what is there beside that of `smooth`, the same contact without friction and with the same past,
/// whose searches find the same places.
fn friction([contact, smooth]: &mut [Active<HertzContact>; 2], poses: &[BodyState]) -> Vec<GeneralisedForce> {
    let (mut all, normal) = (evaluate(contact, poses), evaluate(smooth, poses));
    for (all, normal) in all.iter_mut().zip(&normal) {
        all.force -= normal.force;
        all.torque_in_body -= normal.torque_in_body;
        all.elastic.iter_mut().zip(&normal.elastic).for_each(|(f, n)| *f -= n);
    }
    all
}

#[test]
fn friction_acts_in_the_touch_along_both_surfaces() {
    for case in cases() {
        let mut pair = [ROUGH, 0.0].map(|rough| case.stretched(rough).0);
        // At the end of a step of 0.02 ms, in which the ball rolls by a few thousandths of its radius.
        let poses = case.at(2e-5);
        let forces = friction(&mut pair, &poses);
        pair.iter_mut().for_each(ActiveForce::save);
        let after = friction(&mut pair, &poses);
        let [contact, smooth] = &mut pair;
        let (force, normal) = (contact.report().friction_force, contact.report().normal_force);
        let motion = Motion::new(0.0, &poses);
        let place = smooth.meeting(motion).place;
        // Round-off of sums with the normal force; after the update, of places 0.05 m from the origin over the stretch.
        let noise = 1e-13 * normal;
        let renewed = noise + 10.0 * f64::EPSILON * 0.05 / STRETCH * force.norm();
        assert!(force.norm() > 1e-3 * normal, "{}: no friction", case.name);
        for (k, (pose, sum)) in poses.iter().zip(&forces).enumerate() {
            let sign = if k == 0 { 1.0 } else { -1.0 };
            assert!((sum.force - force * sign).norm() < noise, "{}: not opposite", case.name);
            let moment = pose.rotation * sum.torque_in_body + (pose.position - place).cross(&sum.force);
            assert!(moment.norm() < noise * 0.05, "{}: moment {moment:?} about the touch", case.name);
            assert!((sum.force - after[k].force).norm() < renewed, "{}: force jumps", case.name);
            let jump = (sum.torque_in_body - after[k].torque_in_body).norm();
            assert!(jump < renewed * 0.05, "{}: moment jumps by {jump:e}", case.name);
            for (before, after) in sum.elastic.iter().zip(&after[k].elastic) {
                assert!((before - after).abs() < renewed, "{}: modal force jumps", case.name);
            }
        }
        let askew = force.dot(&smooth.meeting(motion).normal).abs();
        assert!(askew < 1e-13 * force.norm(), "{}: {askew:e} along the normal", case.name);
    }
}

#[test]
fn rolling_and_spinning_stretch_no_spring() {
    for case in cases() {
        if !(case.elastic)(1e-3)[0].is_empty() {
            continue; // modes shift the bodies
        }
        let (end, n) = (1e-3, 50);
        let step = end / f64::from(n);
        let (mut contact, start) = case.stretched(ROUGH);
        for k in 1..=n {
            evaluate(&mut contact, &case.at(step * f64::from(k)));
            contact.save();
        }
        // The springs keep their place on the target: they go with the touch along the target's symmetry, on the ball they turn with its spin.
        let poses = case.at(end);
        let ball = &poses[usize::from(case.is_swapped)];
        let carrier = ball.rotation * turn(case.relative(), end).inverse();
        let spin = if case.is_swapped { turn(case.normal * SPIN, end) } else { UnitQuaternion::identity() };
        let expected = carrier * spin * start;
        let found = contact.report().friction_force;
        // Each step measures the way `u` of the touch over a body that turns by `ω` against the touch too short by `u (ω step)²/6`, on both bodies;
        // measured between two material points alone, it would be off by `u SPIN step/2`.
        let turns = case.relative().norm_squared() + case.screw[0].norm_squared();
        let slip = (found - expected).norm() / start.norm() * STRETCH;
        let bound = case.speed() * end * turns * step * step / 6.0;
        assert!(slip < bound, "{}: {slip:e} above {bound:e}", case.name);
    }
}

#[test]
fn a_body_that_rests_or_rocks_stays_where_it_sticks() {
    for case in cases() {
        let (mut contact, start) = case.stretched(ROUGH);
        for cycle in 0..1000 {
            // At rest, then to and fro by a thousandth of the radius and more.
            evaluate(&mut contact, &case.at(if cycle < 500 { 0.0 } else { 2e-5 }));
            contact.save();
            evaluate(&mut contact, &case.at(0.0));
            contact.save();
        }
        // Round-off of 2000 differences of places 0.05 m from the origin, over the stretch.
        let limit = 2000.0 * f64::EPSILON * 0.05 / STRETCH;
        let change = (contact.report().friction_force - start).norm() / start.norm();
        assert!(change < limit, "{}: {change:e} above {limit:e}", case.name);
    }
}

/// The same motions with rates, as differences over 0.1 µs to both sides: off by a billionth.
fn with_rates(poses: &dyn Fn(f64) -> Vec<BodyState>, time: f64) -> Vec<BodyState> {
    let h = 1e-7;
    let (mut now, before, after) = (poses(time), poses(time - h), poses(time + h));
    for (k, state) in now.iter_mut().enumerate() {
        let (a, b) = (&before[k], &after[k]);
        state.velocity = (b.position - a.position) / (2.0 * h);
        let turned = state.rotation.inverse() * (b.rotation * a.rotation.inverse()).scaled_axis();
        state.angular_velocity_in_body = turned / (2.0 * h);
        for (rate, (a, b)) in state.elastic_rates.iter_mut().zip(a.elastic.iter().zip(&b.elastic)) {
            *rate = (b - a) / (2.0 * h);
        }
    }
    now
}

/// Power of friction on the bodies, growth of its energy and lost power, together, over the size of the force, at the end of a step `step` on the
/// course `poses` [m/s]; and whether power is lost.
fn imbalance(
    pair: &mut [Active<HertzContact>; 2],
    poses: &dyn Fn(f64) -> Vec<BodyState>,
    step: f64,
) -> (f64, bool) {
    let here = with_rates(poses, step);
    let forces = friction(pair, &here);
    let (lost, force) = (pair[0].energies().dissipated_power, pair[0].report().friction_force.norm());
    let mut power = 0.0;
    for (state, sum) in here.iter().zip(&forces) {
        power += sum.force.dot(&state.velocity) + sum.torque_in_body.dot(&state.angular_velocity_in_body);
        power += sum.elastic.iter().zip(&state.elastic_rates).map(|(f, v)| f * v).sum::<f64>();
    }
    let mut energy = |time: f64| {
        friction(pair, &poses(time));
        pair[0].energies().elastic_high - pair[1].energies().elastic_high
    };
    // Short, so that hardly a corner of the law, where a spring begins to slide, lies within.
    let h = 1e-9;
    let growth = (energy(step + h) - energy(step - h)) / (2.0 * h);
    ((power + growth + lost).abs() / force, lost > 0.0)
}

#[test]
fn work_of_friction_is_balanced_to_the_second_order_of_the_step() {
    let (acceleration, growth) = (400.0, Vector3::new(2.0, -1.0, 1.5) * 1e4);
    let mut n_lost = 0;
    for case in cases() {
        // Rolls, spins, slides with an acceleration, and turns ever faster.
        let course = |time: f64| {
            let more = UnitQuaternion::from_scaled_axis(growth * (0.5 * time * time));
            case.poses(time, case.askew() * (0.1 * time + 0.5 * acceleration * time * time), more)
        };
        // Of the first order in the time `h` since the update, `u` over a body that turns by `ω` against the touch, nothing is left; of the
        // second `u (ωh)²/2` for either body, and a quarter of `h²` times what the growing turn and the sliding add; modes turn the surfaces less.
        let (turn, speed) = (case.relative(), case.speed());
        let steady = 0.5 * speed * (turn.norm_squared() + case.screw[0].norm_squared());
        let unsteady = 0.25 * (growth.norm() * speed + turn.norm() * acceleration);
        for rough in [0.3, ROUGH] {
            let found = [20e-6, 10e-6, 5e-6].map(|step: f64| {
                let mut pair = [rough, 0.0].map(|rough| case.stretched(rough).0);
                let (sum, is_lost) = imbalance(&mut pair, &course, step);
                n_lost += usize::from(is_lost);
                let bound = step * step * (steady + unsteady);
                assert!(sum < bound, "{} {rough}: {sum:e} above {bound:e}", case.name);
                sum
            });
            // Where all slides the force is what it is, whatever the slip. A quarter of the step leaves 1/16, of an error of the first order 1/4.
            // Round-off of places 0.05 m from the origin, over the difference's 2 ns.
            let left = (found[0] / 8.0).max(4.0 * f64::EPSILON * 0.05 / 2e-9);
            assert!(rough < ROUGH || found[2] < left, "{}: {found:?}", case.name);
        }
    }
    assert!(n_lost > cases().len(), "{n_lost}");
}
