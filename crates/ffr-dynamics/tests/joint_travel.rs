//! Joints with chosen directions, with ends of their travel and with dry friction, against closed forms.

use crate::dynamics_support::{run, with_tolerance};
use ffr_dynamics::body::{RigidMotion, StandardInputData};
use ffr_dynamics::integration::Method;
use ffr_dynamics::kinematics::Marker;
use ffr_dynamics::system::{
    Attachment, BodySpec, CoordinateForce, FreeDirections, Friction, GROUND, JointKind, JointSpec, Multibody,
    Stop, SystemSpec, TimeCourse, TimeFunction,
};
use nalgebra::{Matrix3, UnitQuaternion, Vector3};

const MASS: f64 = 2.0;
const INERTIA: f64 = 0.03;

/// A rigid body on a joint at its centre, with one force on each coordinate.
fn system(kind: JointKind, force: &CoordinateForce, gravity: Vector3<f64>) -> Multibody {
    let inertia = Matrix3::identity() * INERTIA;
    let data = StandardInputData::rigid(RigidMotion::Spatial, MASS, Vector3::zeros(), inertia).unwrap();
    let marker = || vec![Marker::rigid("a", Vector3::zeros(), UnitQuaternion::identity())];
    let at = |body: &str| Attachment::new(body, "a");
    let coordinates = vec![force.clone(); kind.n_velocities()];
    let joint = JointSpec { coordinates, ..JointSpec::new("joint", kind, at(GROUND), at("body")) };
    let bodies = vec![BodySpec { name: "body".into(), data, markers: marker() }];
    let spec = SystemSpec { bodies, ground: marker(), joints: vec![joint], gravity, ..SystemSpec::default() };
    with_tolerance(Multibody::new(spec, Vec::new()).unwrap())
}

fn energy(system: &mut Multibody, t: f64, y: &[f64]) -> f64 {
    system.invariants(t, y).energy() + system.joint_energy(t, y)
}

#[test]
fn a_slider_bounces_off_its_stop_as_a_spring_lets_it() {
    let (end, stiffness, speed, time) = (0.01, 1e6, 0.3, 0.06);
    let stop = Stop { lower: f64::NEG_INFINITY, upper: end, stiffness, damping: 0.0 };
    let force = CoordinateForce { stop: Some(stop), ..CoordinateForce::default() };
    for method in [Method::DormandPrince, Method::Gauss] {
        let mut system = system(JointKind::Prismatic, &force, Vector3::zeros());
        let mut y = system.rest();
        system.set_joint(&mut y, 0, &[0.0], &[speed]).unwrap();
        let before = energy(&mut system, 0.0, &y);
        let middle = end / speed + 0.5 * std::f64::consts::PI * (MASS / stiffness).sqrt();
        let (at_middle, error) = run(&mut system, method, &y, middle);
        let deepest = system.joint_coordinates(middle, &at_middle, 0).positions[0];
        let contact = (MASS / stiffness).sqrt();
        // Errors of the speed last for the time of the run at most.
        assert!((deepest - end - speed * contact).abs() < error * speed * middle, "{deepest}");
        let (y, error) = run(&mut system, method, &y, time);
        let at = system.joint_coordinates(time, &y, 0);
        let left = 2.0 * middle - end / speed;
        let exact = end - speed * (time - left);
        assert!((at.positions[0] - exact).abs() < error * speed * time, "{:?}", at.positions);
        let change = energy(&mut system, time, &y) - before;
        assert!(change.abs() < 2.0 * error * before, "{method:?}: {change:e} of {before:e}, {error:e}");
    }
}

#[test]
fn damping_of_a_stop_takes_what_hunt_and_crossley_say() {
    // With w = damping times velocity, w - ln(1 + w) of the approach is -w - ln(1 - w) of the rebound, whatever mass and stiffness are.
    let (damping, speed): (f64, f64) = (1.5, -0.4);
    let approach = damping * speed.abs();
    let target = approach - approach.ln_1p();
    let (mut low, mut high) = (0.0, 1.0 - 1e-12);
    for _ in 0..60 {
        let middle: f64 = 0.5 * (low + high);
        if -middle - (-middle).ln_1p() < target {
            low = middle;
        } else {
            high = middle;
        }
    }
    let rebound = low / damping;
    let stop = Stop { lower: -0.02, upper: f64::INFINITY, stiffness: 4e4, damping };
    let force = CoordinateForce { stop: Some(stop), ..CoordinateForce::default() };
    let mut system = system(JointKind::Revolute, &force, Vector3::zeros());
    let mut y = system.rest();
    system.set_joint(&mut y, 0, &[0.0], &[speed]).unwrap();
    let before = energy(&mut system, 0.0, &y);
    let (y, error) = run(&mut system, Method::DormandPrince, &y, 0.1);
    let found = system.joint_coordinates(0.1, &y, 0).velocities[0];
    assert!((found - rebound).abs() < error * speed.abs(), "{found} {rebound}");
    let lost = before - energy(&mut system, 0.1, &y);
    assert!((lost - system.dissipated_work(&y)).abs() < 2.0 * error * before, "{lost}");
}

#[test]
fn friction_stops_a_slider_after_its_way_and_holds_it_on_a_slope() {
    // Sliding from v to the velocity u of the transition: x = m/F ∫ √(v² + u²) dv, from v to 0.
    for method in [Method::DormandPrince, Method::Gauss] {
        let (force, transition, speed) = (5.0, 1e-3, 0.2);
        let friction = Some(Friction { force, velocity: transition });
        let coordinate = CoordinateForce { friction, ..CoordinateForce::default() };
        let mut slider = system(JointKind::Prismatic, &coordinate, Vector3::zeros());
        let mut y = slider.rest();
        slider.set_joint(&mut y, 0, &[0.0], &[speed]).unwrap();
        // A hundred times the decay time m u / F after it has slowed down to the transition.
        let time = MASS / force * (speed + 100.0 * transition);
        let (y, error) = run(&mut slider, method, &y, time);
        let whole = speed.hypot(transition);
        let way =
            0.5 * MASS / force * (speed * whole + transition * transition * (speed / transition).asinh());
        let found = slider.joint_coordinates(time, &y, 0).positions[0];
        assert!((found - way).abs() < error * speed * time, "{found} {way}");
        let lost = slider.dissipated_work(&y);
        assert!((lost / (0.5 * MASS * speed * speed) - 1.0).abs() < 2.0 * error, "{lost}");

        // Held with 60 % of the friction it creeps with F u / √(F² - f²).
        let pull = 0.6 * force;
        let mut held = system(JointKind::Prismatic, &coordinate, Vector3::new(0.0, 0.0, pull / MASS));
        let y = held.rest();
        let (y, error) = run(&mut held, method, &y, 100.0 * MASS * transition / force);
        let creep = held.joint_coordinates(0.0, &y, 0).velocities[0];
        let exact = pull * transition / (force * force - pull * pull).sqrt();
        assert!((creep / exact - 1.0).abs() < error, "{creep} {exact}");
    }
}

#[test]
fn friction_about_a_point_has_no_preferred_axis() {
    let (moment, transition, speed) = (0.2, 1e-3, 3.0);
    let friction = Some(Friction { force: moment, velocity: transition });
    let coordinate = CoordinateForce { friction, ..CoordinateForce::default() };
    let time = 0.2;
    for axis in [Vector3::x(), Vector3::new(1.0, -2.0, 0.5).normalize()] {
        let mut ball = system(JointKind::Spherical, &coordinate, Vector3::zeros());
        let mut y = ball.rest();
        let start = axis * speed;
        ball.set_joint(&mut y, 0, &[1.0, 0.0, 0.0, 0.0], start.as_slice()).unwrap();
        let (y, error) = run(&mut ball, Method::DormandPrince, &y, time);
        let left = Vector3::from_column_slice(&ball.joint_coordinates(time, &y, 0).velocities[..3]);
        // ∫ √(v² + u²) / v dv falls evenly.
        let integral = |v: f64| v.hypot(transition) - transition * (transition / v).asinh();
        let change = integral(speed) - integral(left.norm()) - moment / INERTIA * time;
        assert!(change.abs() < error * speed, "{change:e}");
        assert!((left - axis * left.norm()).norm() < error * speed, "{left}");
    }
}

#[test]
fn joints_by_their_free_directions_move_as_those_with_a_name() {
    let directions = |free: [usize; 6]| JointKind::Generic(FreeDirections(free.map(|f| f == 1)));
    let pairs = [
        (JointKind::Fixed, directions([0, 0, 0, 0, 0, 0])),
        (JointKind::Revolute, directions([0, 0, 0, 0, 0, 1])),
        (JointKind::Prismatic, directions([0, 0, 1, 0, 0, 0])),
        (JointKind::Cylindrical, directions([0, 0, 1, 0, 0, 1])),
        (JointKind::Universal, directions([0, 0, 0, 1, 1, 0])),
        (JointKind::Spherical, directions([0, 0, 0, 1, 1, 1])),
        (JointKind::Planar, directions([1, 1, 0, 0, 0, 1])),
        (JointKind::Free, directions([1, 1, 1, 1, 1, 1])),
    ];
    let (positions, velocities) = ([0.3, -0.2, 0.5, 0.1, 0.7, -0.4, 0.6], [1.0, 2.0, -3.0, 0.5, -0.7, 0.9]);
    for (named, generic) in pairs {
        assert_eq!(
            named.motion(&positions, &velocities),
            generic.motion(&positions, &velocities),
            "{named:?}"
        );
        assert_eq!(named.n_positions(), generic.n_positions());
        assert_eq!(named.quaternion(), generic.quaternion());
    }
}

#[test]
fn impossible_stops_and_friction_are_refused_by_name() {
    let refused = |kind: JointKind, force: CoordinateForce| {
        let inertia = Matrix3::identity();
        let data = StandardInputData::rigid(RigidMotion::Spatial, 1.0, Vector3::zeros(), inertia).unwrap();
        let marker = || vec![Marker::rigid("a", Vector3::zeros(), UnitQuaternion::identity())];
        let (parent, child) = (Attachment::new(GROUND, "a"), Attachment::new("body", "a"));
        let coordinates = vec![force; kind.n_velocities()];
        let joints = vec![JointSpec { coordinates, ..JointSpec::new("knee", kind, parent, child) }];
        let bodies = vec![BodySpec { name: "body".into(), data, markers: marker() }];
        let spec = SystemSpec { bodies, ground: marker(), joints, ..SystemSpec::default() };
        Multibody::<Box<dyn ffr_dynamics::force::active::ActiveForce>>::new(spec, Vec::new())
            .err()
            .map(|error| error.to_string())
            .unwrap_or_default()
    };
    let stop = Stop { lower: 0.0, upper: 0.0, stiffness: 1.0, damping: 0.0 };
    let message = refused(JointKind::Revolute, CoordinateForce { stop: Some(stop), ..Default::default() });
    assert!(message.contains("knee") && message.contains("lower < upper"), "{message}");
    let stop = Stop { upper: 1.0, ..stop };
    let message = refused(JointKind::Spherical, CoordinateForce { stop: Some(stop), ..Default::default() });
    assert!(message.contains("rotation about a point"), "{message}");
    let friction = Friction { force: 1.0, velocity: 0.0 };
    let message =
        refused(JointKind::Revolute, CoordinateForce { friction: Some(friction), ..Default::default() });
    assert!(message.contains("velocity 0 > 0") || message.contains("> 0"), "{message}");
}

/// A drive that is on for a while, and one that vibrates: an estimate from derivatives of the motion sees neither.
enum Drive {
    Pulse { size: f64, from: f64, to: f64 },
    Harmonic { size: f64, omega: f64 },
}

impl TimeCourse for Drive {
    fn at(&self, t: f64) -> [f64; 3] {
        match *self {
            Self::Pulse { size, from, to } => [if (from..to).contains(&t) { size } else { 0.0 }, 0.0, 0.0],
            Self::Harmonic { size, omega } => [size * (omega * t).sin(), 0.0, 0.0],
        }
    }

    fn next_break(&self, t: f64) -> f64 {
        match *self {
            Self::Pulse { from, to, .. } => {
                [from, to].into_iter().find(|at| *at > t).unwrap_or(f64::INFINITY)
            }
            Self::Harmonic { .. } => f64::INFINITY,
        }
    }

    fn longest_step(&self, _t: f64) -> f64 {
        match *self {
            Self::Pulse { .. } => f64::INFINITY,
            Self::Harmonic { omega, .. } => 0.5 * std::f64::consts::PI / omega,
        }
    }
}

#[test]
fn steps_end_where_a_drive_jumps_and_resolve_one_that_vibrates() {
    let (size, time) = (30.0, 0.7);
    let (from, to, omega) = (0.123, 0.1234, 2.0 * std::f64::consts::PI * 400.0);
    let pulse = (Drive::Pulse { size, from, to }, size / MASS * (to - from));
    let harmonic = Drive::Harmonic { size, omega };
    let harmonic = (harmonic, size / (MASS * omega) * (1.0 - (omega * time).cos()));
    for (drive, gained) in [pulse, harmonic] {
        let force =
            CoordinateForce { drive: Some(TimeFunction::with_course(drive)), ..CoordinateForce::default() };
        let mut slider = system(JointKind::Prismatic, &force, Vector3::zeros());
        let mut y = slider.rest();
        let speed = 0.2;
        slider.set_joint(&mut y, 0, &[0.0], &[speed]).unwrap();
        for method in [Method::DormandPrince, Method::Gauss] {
            let (y, error) = run(&mut slider, method, &y, time);
            let found = slider.joint_coordinates(time, &y, 0).velocities[0] - speed;
            // Quarters of a period: the quadrature of order eight errs by 2e-8 of the amplitude in each, and what it errs cancels in a period.
            let resolved = 2e-8 * size / (MASS * omega);
            assert!(
                (found - gained).abs() < error * (speed + gained) + resolved,
                "{method:?} {found} {gained}"
            );
        }
    }
}

/// Crank of 50 mm about ground, rod of 200 mm, piston on a guide that closes the loop; the crank stands at 90°.
fn slider_crank() -> Multibody {
    let body = |name: &str, length: f64| {
        let centre = Vector3::x() * 0.5 * length;
        let about_end = 1e-3 + 0.3 * centre.norm_squared();
        let inertia = Matrix3::from_diagonal(&Vector3::new(1e-3, about_end, about_end));
        let data = StandardInputData::rigid(RigidMotion::Spatial, 0.3, centre, inertia).unwrap();
        let along = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), 0.5 * std::f64::consts::PI);
        let marker = |name: &str, x: f64, rotation| Marker::rigid(name, Vector3::x() * x, rotation);
        let identity = UnitQuaternion::identity();
        let markers =
            vec![marker("a", 0.0, identity), marker("b", length, identity), marker("along", 0.0, along)];
        BodySpec { name: name.into(), data, markers }
    };
    let ground = body("any", 0.0).markers;
    let bodies = vec![body("crank", 0.05), body("rod", 0.2), body("piston", 0.0)];
    let at = Attachment::new;
    let hinge = |name: &str, parent, child| JointSpec::new(name, JointKind::Revolute, parent, child);
    let joints = vec![
        hinge("motor", at(GROUND, "a"), at("crank", "a")),
        hinge("pin", at("crank", "b"), at("rod", "a")),
        hinge("wrist", at("rod", "b"), at("piston", "a")),
    ];
    let guide = JointSpec::new("guide", JointKind::Prismatic, at(GROUND, "along"), at("piston", "along"));
    let spec = SystemSpec { bodies, ground, joints, loops: vec![guide], ..SystemSpec::default() };
    Multibody::new(spec, Vec::new()).unwrap()
}

#[test]
fn a_crank_given_alone_moves_rod_and_piston_as_the_mechanism_does() {
    let (crank, rod, speed) = (0.05_f64, 0.2_f64, -30.0);
    let lean = (crank / rod).asin();
    let angles = [0.5 * std::f64::consts::PI, -0.5 * std::f64::consts::PI - lean, lean];
    let start = |system: &Multibody, speeds: [f64; 3]| {
        let mut y = system.rest();
        for i in 0..3 {
            system.set_joint(&mut y, i, &[angles[i]], &[speeds[i]]).unwrap();
        }
        y
    };
    let mut system = slider_crank();
    let mut y = start(&system, [speed, 0.0, 0.0]);
    system.assemble_start(0.0, &mut y, &[true, false, false]).unwrap();
    let found: Vec<f64> = (0..3).map(|i| system.joint_coordinates(0.0, &y, i).velocities[0]).collect();
    // The crank stands across the guide: the rod does not turn, the piston moves with the end of the crank.
    for (found, exact) in found.iter().zip([speed, -speed, 0.0]) {
        assert!((found - exact).abs() < 1e-10 * speed.abs(), "{found} {exact}"); // where the projection ends
    }
    let piston = system.body_states(0.0, &y)[2].velocity;
    assert!((piston - Vector3::x() * -speed * crank).norm() < 1e-10 * speed.abs(), "{piston}");

    let mut y = start(&system, [speed, -speed, 5.0]);
    let error = system.assemble_start(0.0, &mut y, &[true; 3]).unwrap_err().to_string();
    assert!(error.contains("guide") && error.contains("leave those out that follow"), "{error}");
}
