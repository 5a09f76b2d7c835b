//! Multibody systems in motion: references, conservation, frames, static start, loops, errors.

use crate::dynamics_support::{Random, Sample, block};
use ffr_dynamics::DynamicsError;
use ffr_dynamics::body::{ModalDamping, RigidMotion, StandardInputData};
use ffr_dynamics::integration::{Integrator, OdeSystem, StepSettings};
use ffr_dynamics::kinematics::Marker;
use ffr_dynamics::system::{
    Attachment, BodySpec, CoordinateForce, ErrorScale, GROUND, JointKind, JointSpec, LoadSpec, Multibody,
    SystemSpec, TimeFunction,
};
use nalgebra::{Matrix3, UnitQuaternion, Vector3};

const GRAVITY: Vector3<f64> = Vector3::new(0.0, 0.0, -9.81);

/// Turns the z axis of a marker into y.
fn hinge_axis() -> UnitQuaternion<f64> {
    UnitQuaternion::from_scaled_axis(Vector3::x() * -std::f64::consts::FRAC_PI_2)
}

fn rigid_marker(name: &str, position: Vector3<f64>) -> Marker {
    Marker::rigid(name, position, hinge_axis())
}

fn build(spec: SystemSpec, relative: f64) -> Multibody {
    let mut system: Multibody = Multibody::new(spec, Vec::new()).unwrap();
    system.set_error_scale(ErrorScale { relative, ..ErrorScale::default() }).unwrap();
    system
}

fn run(system: &mut Multibody, y: &[f64], from: f64, to: f64) -> Vec<f64> {
    let mut integrator = Integrator::explicit(StepSettings::default(), from, y).unwrap();
    integrator.run(system, to, |_, _| true).unwrap();
    integrator.state().to_vec()
}

fn energy(system: &mut Multibody, t: f64, y: &[f64]) -> f64 {
    system.invariants(t, y).energy() + system.joint_energy(t, y)
}

/// Rod (solid cylinder along -z from its upper end) or ball (hinged at its top) as rigid bodies.
fn rigid(mass: f64, centre: f64, transverse: f64, axial: f64) -> StandardInputData {
    let offset = Vector3::new(0.0, 0.0, -centre);
    let about = transverse + mass * centre * centre;
    let inertia = Matrix3::from_diagonal(&Vector3::new(about, about, axial));
    StandardInputData::rigid(RigidMotion::Spatial, mass, offset, inertia).unwrap()
}

/// The double pendulum of the reference file: rod 100 mm x r 1 mm, sphere r 10 mm, steel.
fn rigid_double_pendulum() -> SystemSpec {
    let (l, r, sphere, density) = (0.1, 1e-3, 1e-2, 7850.0);
    let rod_mass = density * std::f64::consts::PI * r * r * l;
    let ball_mass = density * 4.0 / 3.0 * std::f64::consts::PI * sphere * sphere * sphere;
    let rod = rigid(rod_mass, l / 2.0, rod_mass * (l * l / 12.0 + r * r / 4.0), 0.5 * rod_mass * r * r);
    let ball = 0.4 * ball_mass * sphere * sphere;
    let ball = rigid(ball_mass, sphere, ball, ball);
    let end = rigid_marker("end", Vector3::new(0.0, 0.0, -l));
    let top = rigid_marker("top", Vector3::zeros());
    SystemSpec {
        bodies: vec![
            BodySpec { name: "rod".to_string(), data: rod, markers: vec![top.clone(), end] },
            BodySpec { name: "ball".to_string(), data: ball, markers: vec![top.clone()] },
        ],
        ground: vec![top],
        joints: vec![
            JointSpec::new(
                "suspension",
                JointKind::Revolute,
                Attachment::new(GROUND, "top"),
                Attachment::new("rod", "top"),
            ),
            JointSpec::new(
                "hinge",
                JointKind::Revolute,
                Attachment::new("rod", "end"),
                Attachment::new("ball", "top"),
            ),
        ],
        gravity: GRAVITY,
        ..SystemSpec::default()
    }
}

#[test]
fn rigid_double_pendulum_follows_the_reference() {
    let mut system = build(rigid_double_pendulum(), 1e-12);
    let mut y = system.rest();
    let lines = include_str!("data/rigid_double_pendulum.csv").lines().filter(|l| !l.starts_with('#'));
    let rows: Vec<Vec<f64>> = lines.map(|l| l.split(',').map(|x| x.parse().unwrap()).collect()).collect();
    // A positive angle about y moves a hanging body to -x; the reference counts the other way.
    system.set_joint(&mut y, 0, &[-rows[0][1]], &[0.0]).unwrap();
    system.set_joint(&mut y, 1, &[rows[0][1] - rows[0][2]], &[0.0]).unwrap();
    let mut t = 0.0;
    for row in &rows {
        y = run(&mut system, &y, t, row[0]);
        t = row[0];
        let (a, b) = (system.joint_coordinates(t, &y, 0), system.joint_coordinates(t, &y, 1));
        let angles = [-a.positions[0], -a.positions[0] - b.positions[0]];
        let rates = [-a.velocities[0], -a.velocities[0] - b.velocities[0]];
        for i in 0..2 {
            assert!((angles[i] - row[1 + i]).abs() < 1e-9, "t = {t}: {} {}", angles[i], row[1 + i]);
            assert!((rates[i] - row[3 + i]).abs() < 1e-7); // frequencies up to 40 rad/s
        }
    }
}

/// A flexible block hinged at a corner, in its Buckens frame or in the tangent frame of the hinge.
fn flexible_pendulum(sample: &Sample, is_tangent: bool, gravity: Vector3<f64>) -> SystemSpec {
    let marker = |name: &str, a: usize| sample.marker(name, a, hinge_axis(), |j| sample.nodal_rotation(a, j));
    let mut body = BodySpec {
        name: "block".to_string(),
        data: sample.data.clone(),
        markers: vec![marker("hinge", 0), marker("tip", 11)],
    };
    if is_tangent {
        let frame = body.markers[0].tangent_frame(RigidMotion::Spatial);
        body.data = body.data.in_tangent_frame(&frame).unwrap();
        body.markers = body.markers.iter().map(|m| m.in_tangent_frame(&frame).unwrap()).collect();
    }
    let at = [Attachment::new(GROUND, "pivot"), Attachment::new("block", "hinge")];
    let [parent, child] = at;
    SystemSpec {
        bodies: vec![body],
        ground: vec![rigid_marker("pivot", Vector3::zeros())],
        joints: vec![JointSpec::new("hinge", JointKind::Revolute, parent, child)],
        gravity,
        ..SystemSpec::default()
    }
}

#[test]
fn flexible_pendulum_keeps_its_energy() {
    let sample = block(RigidMotion::Spatial, 6);
    for is_tangent in [true, false] {
        let mut system = build(flexible_pendulum(&sample, is_tangent, GRAVITY), 1e-9);
        let mut y = system.rest();
        system.set_joint(&mut y, 0, &[0.3], &[4.0]).unwrap();
        let before = energy(&mut system, 0.0, &y);
        let scale = system.invariants(0.0, &y).kinetic;
        let y = run(&mut system, &y, 0.0, 0.2);
        assert!((system.joint_coordinates(0.2, &y, 0).positions[0] - 0.3).abs() > 0.3, "it has swung");
        assert!((energy(&mut system, 0.2, &y) - before).abs() < 1e-6 * scale);
    }
}

#[test]
fn tangent_and_buckens_frames_give_the_same_motion() {
    // Displacements of the two frames differ by the square of the modes' rotation at the hinge; a hundredth of the weight
    // deforms a hundredth as much, and the phases of the vibration drift apart accordingly less.
    let sample = block(RigidMotion::Spatial, 6);
    for (weight, elastic_tolerance) in [(1.0, 1e-3), (0.01, 1e-5)] {
        let tips = [true, false].map(|is_tangent| {
            let mut system = build(flexible_pendulum(&sample, is_tangent, GRAVITY * weight), 1e-11);
            let mut y = system.rest();
            system.set_joint(&mut y, 0, &[0.3], &[0.0]).unwrap();
            let y = run(&mut system, &y, 0.0, 0.1);
            let (body, tip) = system.marker("block", "tip").map(|(b, m)| (b, m.clone())).unwrap();
            let elastic = system.invariants(0.1, &y).elastic;
            (tip.place(&system.body_states(0.1, &y)[body]), elastic)
        });
        assert!((tips[0].0 - tips[1].0).norm() < 1e-8, "{:e}", (tips[0].0 - tips[1].0).norm());
        assert!((tips[0].1 - tips[1].1).abs() < elastic_tolerance * tips[0].1);
        assert!(tips[0].1 > 1e-11, "it vibrates");
    }
}

#[test]
fn rigid_body_on_a_spherical_joint_at_its_centre_tumbles_as_a_free_one() {
    let inertia = Matrix3::from_diagonal(&Vector3::new(1.0, 2.0, 2.5));
    let data = StandardInputData::rigid(RigidMotion::Spatial, 3.0, Vector3::zeros(), inertia).unwrap();
    let marker = || vec![rigid_marker("centre", Vector3::zeros())];
    let at = |b: &str| Attachment::new(b, "centre");
    let spec = SystemSpec {
        bodies: vec![BodySpec { name: "rotor".to_string(), data, markers: marker() }],
        ground: marker(),
        joints: vec![JointSpec::new("ball", JointKind::Spherical, at(GROUND), at("rotor"))],
        ..SystemSpec::default()
    };
    let mut system = build(spec, 1e-12);
    let mut y = system.rest();
    system.set_joint(&mut y, 0, &[1.0, 0.0, 0.0, 0.0], &[0.02, 0.01, 1.0]).unwrap();
    let before = system.invariants(0.0, &y);
    let y = run(&mut system, &y, 0.0, 100.0 * std::f64::consts::TAU);
    let after = system.invariants(0.0, &y);
    assert!((after.energy() - before.energy()).abs() < 1e-9 * before.energy());
    let change = (after.angular_momentum - before.angular_momentum).norm();
    assert!(change < 1e-9 * before.angular_momentum.norm(), "{change:e}");
}

/// A driven, sprung and damped chain of two flexible blocks.
fn machine() -> SystemSpec {
    let sample = block(RigidMotion::Spatial, 5);
    let mut data = sample.data.clone();
    data.modal_damping = ModalDamping::PerMode(vec![20.0; 5]);
    let marker = |name: &str, a: usize| sample.marker(name, a, hinge_axis(), |j| sample.nodal_rotation(a, j));
    let body = |name: &str| BodySpec {
        name: name.to_string(),
        data: data.clone(),
        markers: vec![marker("a", 0), marker("b", 11)],
    };
    let mut crank = JointSpec::new(
        "crank",
        JointKind::Revolute,
        Attachment::new(GROUND, "pivot"),
        Attachment::new("first", "a"),
    );
    let angle = |t: f64| [0.5 * (8.0 * t).sin(), 4.0 * (8.0 * t).cos(), -32.0 * (8.0 * t).sin()];
    // The spring on the prescribed coordinate stores energy as well.
    let motion = Some(TimeFunction::new(angle));
    crank.coordinates =
        vec![CoordinateForce { motion, stiffness: 7.0, damping: 0.1, ..CoordinateForce::default() }];
    let mut link = JointSpec::new(
        "link",
        JointKind::Cylindrical,
        Attachment::new("first", "b"),
        Attachment::new("second", "a"),
    );
    let drive = Some(TimeFunction::new(|t: f64| [3.0 * (20.0 * t).cos(), 0.0, 0.0]));
    link.coordinates = vec![
        CoordinateForce { stiffness: 400.0, rest: 0.01, damping: 3.0, ..CoordinateForce::default() },
        CoordinateForce { stiffness: 5.0, damping: 0.05, drive, ..CoordinateForce::default() },
    ];
    let push = TimeFunction::new(|t: f64| [10.0 * (9.0 * t).sin(), 0.0, 0.0]);
    let load = LoadSpec {
        name: "push".to_string(),
        at: Attachment::new("second", "b"),
        components: [Some(push.clone()), None, Some(push.clone()), None, Some(push), None],
        is_following: true,
    };
    SystemSpec {
        bodies: vec![body("first"), body("second")],
        ground: vec![rigid_marker("pivot", Vector3::zeros())],
        joints: vec![crank, link],
        loads: vec![load],
        gravity: GRAVITY,
        ..SystemSpec::default()
    }
}

#[test]
fn energy_changes_by_supplied_less_dissipated_work() {
    let mut system = build(machine(), 1e-10);
    let y = system.rest();
    let before = energy(&mut system, 0.0, &y);
    let y = run(&mut system, &y, 0.0, 0.3);
    let (supplied, dissipated) = (system.supplied_work(&y), system.dissipated_work(&y));
    let change = energy(&mut system, 0.3, &y) - before;
    assert!(dissipated > 1e-3 && supplied.abs() > 1e-3, "{supplied} {dissipated}");
    let size = supplied.abs() + dissipated;
    assert!((change - supplied + dissipated).abs() < 1e-8 * size, "{:e}", change - supplied + dissipated);
}

#[test]
fn static_start_leaves_no_elastic_acceleration() {
    let sample = block(RigidMotion::Spatial, 6);
    for is_tangent in [true, false] {
        let mut system = build(flexible_pendulum(&sample, is_tangent, GRAVITY), 1e-9);
        let mut y = system.rest();
        system.set_joint(&mut y, 0, &[0.7], &[1.0]).unwrap();
        system.static_start(0.0, &mut y).unwrap();
        let layout = system.model().bodies[0].layout;
        assert!((y[layout.positions().start] - 0.7).abs() < 1e-15, "the joint is held");
        let mut rates = vec![0.0; y.len()];
        system.rhs(0.0, &y, &mut rates).unwrap();
        let forces = y[layout.elastic()].iter().zip(&system.model().bodies[0].data.modal_stiffness);
        let size = forces.map(|(q, k)| (q * k).abs()).fold(0.0, f64::max);
        let left = rates[layout.elastic_rates()].iter().map(|a| a.abs()).fold(0.0, f64::max);
        assert!(size > 1e-3 && left < 1e-9 * size, "{left:e} of {size:e}"); // twelve digits of the coordinates
    }
}

/// Four rigid bars: crank, coupler, rocker and ground; all hinges about y.
fn four_bar() -> SystemSpec {
    let (a, b, c, d) = (0.1, 0.3, 0.25, 0.3);
    let bar = |name: &str, length: f64| {
        let mass = 10.0 * length;
        let bodies = Matrix3::from_diagonal(&Vector3::new(1e-5, 1.0, 1.0)) * (mass * length * length / 3.0);
        let inertia = bodies + Matrix3::from_diagonal(&Vector3::new(1e-4, 1e-4, 1e-4));
        let centre = Vector3::x() * (length / 2.0);
        BodySpec {
            name: name.to_string(),
            data: StandardInputData::rigid(RigidMotion::Spatial, mass, centre, inertia).unwrap(),
            markers: vec![
                rigid_marker("start", Vector3::zeros()),
                rigid_marker("end", Vector3::x() * length),
            ],
        }
    };
    let hinge = |name: &str, p: (&str, &str), c: (&str, &str)| {
        JointSpec::new(name, JointKind::Revolute, Attachment::new(p.0, p.1), Attachment::new(c.0, c.1))
    };
    SystemSpec {
        bodies: vec![bar("crank", a), bar("coupler", b), bar("rocker", c)],
        ground: vec![rigid_marker("left", Vector3::zeros()), rigid_marker("right", Vector3::x() * d)],
        joints: vec![
            hinge("crank bearing", (GROUND, "left"), ("crank", "start")),
            hinge("crank pin", ("crank", "end"), ("coupler", "start")),
            hinge("rocker bearing", (GROUND, "right"), ("rocker", "start")),
        ],
        loops: vec![hinge("rocker pin", ("coupler", "end"), ("rocker", "end"))],
        gravity: GRAVITY,
        ..SystemSpec::default()
    }
}

#[test]
fn four_bar_linkage_keeps_its_loop_and_its_energy() {
    let mut system = build(four_bar(), 1e-10);
    let mut y = system.rest();
    for (joint, angle) in [(0, -1.2), (1, 0.7), (2, -1.4)] {
        system.set_joint(&mut y, joint, &[angle], &[0.0]).unwrap();
    }
    system.set_joint(&mut y, 0, &[-1.2], &[12.0]).unwrap();
    system.assemble(0.0, &mut y).unwrap();
    let mut rates = vec![0.0; y.len()];
    system.rhs(0.0, &y, &mut rates).unwrap();
    assert_eq!(system.loop_constraints(), (5, 2), "three of five constraints are redundant in the plane");
    let before = energy(&mut system, 0.0, &y);
    let scale = system.invariants(0.0, &y).kinetic;
    let mut integrator = Integrator::explicit(StepSettings::default(), 0.0, &y).unwrap();
    let mut drift: f64 = 0.0;
    let mut turned: f64 = 0.0;
    integrator
        .run(&mut system, 1.0, |system, at| {
            drift = drift.max(system.loop_residual(at.time(), at.state()));
            turned = turned.max((system.joint_coordinates(0.0, at.state(), 0).positions[0] + 1.2).abs());
            true
        })
        .unwrap();
    assert!(drift < 1e-10, "{drift:e}");
    assert!(turned > 1.0, "{turned}");
    let after = energy(&mut system, 1.0, integrator.state());
    assert!((after - before).abs() < 1e-7 * scale, "{:e}", (after - before) / scale);
}

#[test]
fn closed_ring_of_flexible_rods_keeps_momentum_and_loop() {
    // Three blocks hinged to a ring by spherical joints, flying freely.
    let sample = block(RigidMotion::Spatial, 5);
    let marker = |name: &str, a: usize| sample.marker(name, a, hinge_axis(), |j| sample.nodal_rotation(a, j));
    let names = ["first", "second", "third"];
    let bodies = names.map(|name| BodySpec {
        name: name.to_string(),
        data: sample.data.clone(),
        markers: vec![marker("a", 0), marker("b", 11)],
    });
    let joint = |i: usize, kind: JointKind| {
        JointSpec::new(
            &format!("joint {i}"),
            kind,
            Attachment::new(names[i], "b"),
            Attachment::new(names[(i + 1) % 3], "a"),
        )
    };
    let spec = SystemSpec {
        bodies: bodies.to_vec(),
        joints: vec![joint(0, JointKind::Spherical), joint(1, JointKind::Spherical)],
        loops: vec![joint(2, JointKind::Spherical)],
        ..SystemSpec::default()
    };
    let mut system = build(spec, 1e-9);
    let mut y = system.rest();
    let third = UnitQuaternion::from_scaled_axis(Vector3::new(0.1, 0.2, std::f64::consts::TAU / 3.0));
    for i in 1..3 {
        let q = [third.w, third.i, third.j, third.k];
        system.set_joint(&mut y, i, &q, &[3.0, -4.0, 2.0]).unwrap();
    }
    system.assemble(0.0, &mut y).unwrap();
    let before = system.invariants(0.0, &y);
    assert!(
        before.elastic < 1e-3 * before.kinetic,
        "joints close the loop rather than the bodies' deformation"
    );
    let mut integrator = Integrator::explicit(StepSettings::default(), 0.0, &y).unwrap();
    let mut drift: f64 = 0.0;
    let step = |system: &mut Multibody, at: &Integrator| {
        drift = drift.max(system.loop_residual(at.time(), at.state()));
        true
    };
    integrator.run(&mut system, 0.05, step).unwrap();
    assert!(drift < 1e-10, "{drift:e}");
    let after = system.invariants(0.05, integrator.state());
    assert!((after.energy() - before.energy()).abs() < 1e-6 * before.kinetic);
    let size = before.angular_momentum.norm();
    assert!((after.angular_momentum - before.angular_momentum).norm() < 1e-6 * size);
    assert!(
        (after.linear_momentum - before.linear_momentum).norm()
            < 1e-6 * before.linear_momentum.norm().max(size)
    );
}

#[test]
fn errors_name_what_is_wrong() {
    let refused = |change: fn(&mut SystemSpec)| {
        let mut spec = rigid_double_pendulum();
        change(&mut spec);
        Multibody::<Box<dyn ffr_dynamics::force::active::ActiveForce>>::new(spec, Vec::new()).err().unwrap()
    };
    let error = refused(|s| s.joints[0].parent = Attachment::new("ball", "top"));
    assert!(
        matches!(&error, DynamicsError::JointCycle { path } if path.contains("hinge") && path.contains("rod"))
    );
    let error = refused(|s| s.joints[1].child.marker = "bottom".to_string());
    assert!(
        matches!(&error, DynamicsError::UnknownMarker { marker, known, .. } if marker == "bottom" && known == "top")
    );
    let error = refused(|s| s.joints[1].child.body = "bell".to_string());
    assert!(matches!(&error, DynamicsError::UnknownBody { known, .. } if known == "ground, rod, ball"));
    let error = refused(|s| s.joints[1].child = Attachment::new("rod", "end"));
    assert!(matches!(&error, DynamicsError::OverConstrained { body, .. } if body == "rod"));
    let error = refused(|s| s.bodies[1].name = "rod".to_string());
    assert!(matches!(&error, DynamicsError::DuplicateName { .. }));
    let error = refused(|s| s.joints[0].coordinates = vec![CoordinateForce::default(); 2]);
    assert!(matches!(&error, DynamicsError::Joint { joint, .. } if joint == "suspension"));
    let error = refused(|s| s.bodies[1].data.motion = RigidMotion::Planar);
    assert!(error.to_string().contains("plane model"), "{error}");
    let error = refused(|s| {
        s.bodies[0].data.motion = RigidMotion::Axial;
        s.joints.pop();
    });
    assert!(error.to_string().contains("axisymmetric"), "{error}");
}

#[test]
fn open_loop_is_refused_by_name() {
    let mut spec = four_bar();
    spec.ground[1].position.x = 2.0;
    let mut system = build(spec, 1e-9);
    let mut y = system.rest();
    let error = system.assemble(0.0, &mut y).unwrap_err();
    assert!(error.to_string().contains("rocker pin"), "{error}");
}

#[test]
fn plane_and_axisymmetric_bodies_move_as_their_models_do() {
    for (motion, kind) in [(RigidMotion::Planar, JointKind::Planar), (RigidMotion::Axial, JointKind::Axial)] {
        let sample = block(motion, 4);
        let body = BodySpec { name: "block".to_string(), data: sample.data.clone(), markers: Vec::new() };
        let spec = SystemSpec { bodies: vec![body], gravity: GRAVITY, ..SystemSpec::default() };
        let mut system = build(spec, 1e-9);
        assert_eq!(system.model().bodies[0].joint.kind, kind);
        let mut random = Random(9);
        let mut y = system.rest();
        let n = y.len() - 2;
        y[..n].iter_mut().for_each(|x| *x = 1e-2 * random.next());
        let before = system.invariants(0.0, &y);
        let y = run(&mut system, &y, 0.0, 0.05);
        let after = system.invariants(0.05, &y);
        assert!((after.energy() - before.energy()).abs() < 1e-6 * (before.kinetic + before.elastic));
    }
}
