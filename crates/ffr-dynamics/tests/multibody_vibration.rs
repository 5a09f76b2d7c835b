//! Eigenfrequencies of joined systems against closed forms and differences of the right-hand side.

use crate::dynamics_support::{Random, block};
use faer::Mat;
use ffr_dynamics::body::{GeometricStiffening, RigidMotion, StandardInputData};
use ffr_dynamics::force::GeneralisedForce;
use ffr_dynamics::integration::OdeSystem;
use ffr_dynamics::kinematics::Marker;
use ffr_dynamics::system::vibration::pressed::{PressedModes, UnitMotion};
use ffr_dynamics::system::{
    Attachment, BodySpec, CoordinateForce, GROUND, JointKind, JointSpec, Multibody, SystemSpec, TimeFunction,
};
use nalgebra::{Matrix3, UnitQuaternion, Vector3};

const G: f64 = 9.81;
/// Differences of fourth order over 1e-3 rad: truncation and round-off of some 1e-13 of the stiffness.
const CLOSED_FORM: f64 = 1e-11;

fn marker(name: &str, place: [f64; 3]) -> Marker {
    Marker::rigid(name, Vector3::from(place), UnitQuaternion::identity())
}

/// A rigid rod of mass `m` along -y from its marker "top" to its marker "end".
fn rod(name: &str, mass: f64, length: f64) -> BodySpec {
    let centre = Vector3::new(0.0, -0.5 * length, 0.0);
    let across = mass * length * length / 12.0;
    let about = Matrix3::from_diagonal(&Vector3::new(across, 1e-3 * across, across));
    let steiner = (Matrix3::identity() * centre.norm_squared() - centre * centre.transpose()) * mass;
    let data = StandardInputData::rigid(RigidMotion::Spatial, mass, centre, about + steiner).unwrap();
    let markers = vec![marker("top", [0.0; 3]), marker("end", [0.0, -length, 0.0])];
    BodySpec { name: name.into(), data, markers }
}

fn hinge(name: &str, parent: (&str, &str), child: (&str, &str)) -> JointSpec {
    let at = |(body, marker): (&str, &str)| Attachment::new(body, marker);
    JointSpec::new(name, JointKind::Revolute, at(parent), at(child))
}

fn system(bodies: Vec<BodySpec>, joints: Vec<JointSpec>, loops: Vec<JointSpec>) -> Multibody {
    let spec = SystemSpec {
        bodies,
        ground: vec![marker("pin", [0.0; 3])],
        joints,
        loops,
        gravity: Vector3::new(0.0, -G, 0.0),
        ..SystemSpec::default()
    };
    Multibody::new(spec, Vec::new()).unwrap()
}

fn squared(system: &Multibody, y: &[f64]) -> Vec<f64> {
    system.small_vibrations(0.0, y).unwrap().modes.iter().map(|m| m.squared_frequency).collect()
}

#[test]
fn compound_pendulum_hanging_held_aside_and_upside_down() {
    let system =
        system(vec![rod("rod", 2.0, 0.7)], vec![hinge("h", (GROUND, "pin"), ("rod", "top"))], vec![]);
    let mut y = system.rest();
    let hanging = 1.5 * G / 0.7; // m g (l/2) / (m l²/3)
    for angle in [0.0, 0.5, 2.0, std::f64::consts::PI] {
        system.set_joint(&mut y, 0, &[angle], &[0.3]).unwrap();
        let found = system.small_vibrations(0.0, &y).unwrap();
        let [mode] = &found.modes[..] else { panic!("one coordinate") };
        let expected = hanging * angle.cos();
        assert!((mode.squared_frequency - expected).abs() < CLOSED_FORM * hanging, "{angle}: {mode:?}");
        assert!((mode.shares[0] - 1.0).abs() < 1e-15, "{mode:?}");
        // Left alone, points accelerate by r times this; root mean square over the rod: sqrt(l²/3).
        let left = hanging * angle.sin() * 0.7 / 3f64.sqrt();
        assert!((found.acceleration - left.abs()).abs() < 1e-12 * G, "{angle}: {found:?}");
        if angle > 3.0 {
            assert!(
                (mode.growth_rate() - hanging.sqrt()).abs() < CLOSED_FORM * hanging
                    && mode.frequency() <= 0.0
            );
        }
    }
}

/// Eigenvalues of `K x = ω² M x` for two by two matrices.
fn two_by_two(k: [f64; 3], m: [f64; 3]) -> [f64; 2] {
    let a = m[0] * m[2] - m[1] * m[1];
    let b = k[0] * m[2] + k[2] * m[0] - 2.0 * k[1] * m[1];
    let c = k[0] * k[2] - k[1] * k[1];
    let root = (b * b - 4.0 * a * c).sqrt();
    [(b - root) / (2.0 * a), (b + root) / (2.0 * a)]
}

#[test]
fn double_pendulum_in_the_tree_and_closed_by_a_loop() {
    let (m, l) = ([2.0, 0.8], [0.7, 0.4]);
    let bodies = || vec![rod("upper", m[0], l[0]), rod("lower", m[1], l[1])];
    let upper = hinge("one", (GROUND, "pin"), ("upper", "top"));
    let lower = hinge("two", ("upper", "end"), ("lower", "top"));
    // Absolute angles: kinetic and potential energy of two uniform rods.
    let inertia = [(m[0] / 3.0 + m[1]) * l[0] * l[0], 0.5 * m[1] * l[0] * l[1], m[1] * l[1] * l[1] / 3.0];
    let weight = [(0.5 * m[0] + m[1]) * G * l[0], 0.0, 0.5 * m[1] * G * l[1]];
    let expected = two_by_two(weight, inertia);
    let tree = system(bodies(), vec![upper.clone(), lower.clone()], vec![]);
    let found = squared(&tree, &tree.rest());
    for (found, expected) in found.iter().zip(expected) {
        assert!((found / expected - 1.0).abs() < CLOSED_FORM, "{found} {expected}");
    }
    // The same with the lower rod free and tied by a loop: the force in the loop has a stiffness of its own.
    let tied = system(bodies(), vec![upper], vec![lower]);
    let mut y = tied.rest();
    tied.set_joint(&mut y, 1, &[0.0, -l[0], 0.0, 1.0, 0.0, 0.0, 0.0], &[0.0; 6]).unwrap();
    let found = tied.small_vibrations(0.0, &y).unwrap();
    assert_eq!((found.n_coordinates, found.n_constraints, found.modes.len()), (7, 5, 2));
    assert!(found.acceleration < 1e-12, "it hangs: {found:?}");
    for (found, expected) in found.modes.iter().zip(expected) {
        assert!((found.squared_frequency / expected - 1.0).abs() < CLOSED_FORM, "{found:?} {expected}");
        assert!((found.shares.iter().sum::<f64>() - 1.0).abs() < 1e-14);
    }
}

/// A unit force across at the end of a rod of the length `l`.
fn push(l: f64) -> GeneralisedForce {
    GeneralisedForce { force: Vector3::x(), torque_in_body: Vector3::z() * l, elastic: Vec::new() }
}

#[test]
fn a_force_meets_the_modes_of_what_joints_hold() {
    let (m, l) = ([2.0, 0.8], [0.7, 0.4]);
    let upper = hinge("one", (GROUND, "pin"), ("upper", "top"));
    let alone = system(vec![rod("upper", m[0], l[0])], vec![upper.clone()], vec![]);
    let mut y = alone.rest();
    alone.set_joint(&mut y, 0, &[0.0], &[0.3]).unwrap();
    let across = |unit: UnitMotion<'_>| vec![unit.reactions[0].force.x, unit.states[0].velocity.x];
    let found = alone.pressed_modes((0.0, &y), &[(0, push(l[0]))], across).unwrap();
    let [mode] = &found.modes[..] else { panic!("one coordinate") };
    // l²/(m l²/3); weight is left out; the end moves by l times the angular velocity.
    assert!(
        (mode.share * mode.share * m[0] / 3.0 - 1.0).abs() < 1e-12 && mode.squared_frequency.abs() <= 0.0,
        "{mode:?}"
    );
    assert!((mode.share * mode.start[1] / (0.3 * l[0]) - 1.0).abs() < 1e-12, "{mode:?}");
    assert!((mode.carried / mode.share - 1.0).abs() < 1e-12, "{mode:?}");
    // The hinge of a rod that is struck at its end pushes half as much the same way: 3/2 of the force over the mass is how its
    // middle accelerates. The frame is at the hinge, which does not move.
    let pushed = found.observed[0] + mode.share * mode.observed[0];
    assert!((found.observed[0] + 1.0).abs() < 1e-14 && (pushed - 0.5).abs() < 1e-12, "{found:?}");
    assert!(mode.observed[1].abs() < 1e-14, "{mode:?}");

    // Two rods, in the tree and closed by a loop: the mobility is that of the inverse of their inertia by absolute angles.
    let bodies = || vec![rod("upper", m[0], l[0]), rod("lower", m[1], l[1])];
    let lower = hinge("two", ("upper", "end"), ("lower", "top"));
    let inertia = [(m[0] / 3.0 + m[1]) * l[0] * l[0], 0.5 * m[1] * l[0] * l[1], m[1] * l[1] * l[1] / 3.0];
    let [a, b, c] = inertia;
    let expected = (c * l[0] * l[0] - 2.0 * b * l[0] * l[1] + a * l[1] * l[1]) / (a * c - b * b);
    let tree = system(bodies(), vec![upper.clone(), lower.clone()], vec![]);
    let tied = system(bodies(), vec![upper], vec![lower]);
    let mut y = tied.rest();
    tied.set_joint(&mut y, 1, &[0.0, -l[0], 0.0, 1.0, 0.0, 0.0, 0.0], &[0.0; 6]).unwrap();
    for (system, y) in [(&tree, tree.rest()), (&tied, y)] {
        let asked = |unit: UnitMotion<'_>| vec![unit.reactions[0].force.x];
        let PressedModes { modes, observed } =
            system.pressed_modes((0.0, &y), &[(1, push(l[1]))], asked).unwrap();
        let mobility: f64 = modes.iter().map(|mode| mode.share * mode.share).sum();
        assert!(modes.len() == 2 && (mobility / expected - 1.0).abs() < 1e-12, "{mobility} {expected}");
        if system.model().loops.is_empty() {
            // What accelerates the middles of both rods beside the force: m1 l1/2 α1 + m2 (l1 α1 + l2/2 α2) - 1.
            let [p, q] = [(c * l[0] - b * l[1]) / (a * c - b * b), (a * l[1] - b * l[0]) / (a * c - b * b)];
            let right = 0.5 * m[0] * l[0] * p + m[1] * (l[0] * p + 0.5 * l[1] * q) - 1.0;
            let found = observed[0] + modes.iter().map(|mode| mode.share * mode.observed[0]).sum::<f64>();
            assert!((found / right - 1.0).abs() < 1e-12, "{found} {right}");
        }
    }
}

#[test]
fn springs_count_and_prescribed_coordinates_are_held() {
    let spring = CoordinateForce { stiffness: 55.0, rest: 0.4, ..CoordinateForce::default() };
    let motion = TimeFunction::new(|t| [0.3 + 8.0 * t, 8.0, 0.0]);
    let mut two = hinge("two", ("upper", "end"), ("lower", "top"));
    two.coordinates = vec![spring];
    let mut one = hinge("one", (GROUND, "pin"), ("upper", "top"));
    one.coordinates = vec![CoordinateForce { motion: Some(motion), ..CoordinateForce::default() }];
    let system = system(vec![rod("upper", 2.0, 0.7), rod("lower", 0.8, 0.4)], vec![one, two], vec![]);
    let mut y = system.rest();
    system.set_joint(&mut y, 1, &[0.2], &[0.0]).unwrap();
    // The upper rod stands at 0.3 rad, whatever its speed.
    let expected = (55.0 + 0.8 * G * 0.2 * f64::cos(0.5)) / (0.8 * 0.16 / 3.0);
    let [found] = squared(&system, &y)[..] else { panic!("one coordinate") };
    assert!((found / expected - 1.0).abs() < CLOSED_FORM, "{found} {expected}");
}

#[test]
fn free_body_has_its_own_frequencies_and_six_rigid_motions_in_either_frame() {
    let sample = block(RigidMotion::Spatial, 8);
    let pin = sample.marker("pin", 4, UnitQuaternion::identity(), |j| sample.nodal_rotation(4, j));
    let tangent = sample.data.in_tangent_frame(&pin.tangent_frame(RigidMotion::Spatial)).unwrap();
    for (data, gravity) in [(sample.data.clone(), 0.0), (tangent.clone(), 0.0), (sample.data.clone(), -G)] {
        let body = BodySpec { name: "block".into(), data, markers: vec![] };
        let gravity = Vector3::z() * gravity;
        let spec = SystemSpec { bodies: vec![body], gravity, ..SystemSpec::default() };
        let system: Multibody = Multibody::new(spec, Vec::new()).unwrap();
        let found = squared(&system, &system.rest());
        assert_eq!(found.len(), 14);
        assert!(found[..6].iter().all(|f| f.abs() <= 0.0), "rigid motions: {found:?}");
        for (found, expected) in found[6..].iter().zip(&sample.data.modal_stiffness) {
            assert!((found / expected - 1.0).abs() < 1e-11, "{found} {expected}"); // round-off of 14 x 14
        }
    }
}

#[test]
fn soft_pendulum_is_found_below_modes_of_a_megahertz() {
    // A rigid pendulum with a stiff block fixed to its end: ten decades between the frequencies' squares.
    let sample = block(RigidMotion::Spatial, 8);
    let mut stiff = sample.data.clone();
    stiff.modal_stiffness.iter_mut().for_each(|k| *k *= 1e6);
    let node = sample.node(0);
    let pin = sample.marker("pin", 0, UnitQuaternion::identity(), |j| sample.nodal_rotation(0, j));
    let rigid = |elastic: bool| {
        let data = if elastic {
            stiff.clone()
        } else {
            let data = &stiff;
            let inertia = data.inertia();
            StandardInputData::rigid(RigidMotion::Spatial, data.mass, data.centre_of_mass(), inertia).unwrap()
        };
        let pin = if elastic { pin.clone() } else { Marker::rigid("pin", node, UnitQuaternion::identity()) };
        let block = BodySpec { name: "block".into(), data, markers: vec![pin] };
        let fixed = JointSpec::new(
            "weld",
            JointKind::Fixed,
            Attachment::new("rod", "end"),
            Attachment::new("block", "pin"),
        );
        let joints = vec![hinge("h", (GROUND, "pin"), ("rod", "top")), fixed];
        let system = system(vec![rod("rod", 2.0, 0.7), block], joints, vec![]);
        let found = system.small_vibrations(0.0, &system.rest()).unwrap();
        (found.modes[0].squared_frequency, found.modes.last().unwrap().frequency())
    };
    let ((soft, highest), (expected, _)) = (rigid(true), rigid(false));
    assert!(highest > 1e6, "{highest}");
    // Elastic give: the pendulum's squared frequency over that of the lowest mode, 1e2 / 1e13.
    assert!((soft / expected - 1.0).abs() < 1e-9, "{soft} {expected}");
}

/// The trace of `M⁻¹K` in an equilibrium, from differences of the accelerations coordinate by coordinate.
fn trace_of_accelerations(system: &mut Multibody, y: &[f64]) -> f64 {
    let (mut trace, mut rates) = (0.0, vec![0.0; y.len()]);
    for i in 0..system.model().bodies.len() {
        let layout = system.model().bodies[i].layout;
        let kind = system.model().bodies[i].joint.kind;
        for (k, velocity) in layout.elastic_rates().chain(layout.velocities()).enumerate() {
            let step = if k < layout.n_modes { 1e-7 } else { 1e-5 };
            for sign in [-1.0, 1.0] {
                let mut moved = y.to_vec();
                if k < layout.n_modes {
                    moved[layout.elastic().start + k] += sign * step;
                } else {
                    let mut by = vec![0.0; layout.n_velocities];
                    by[k - layout.n_modes] = sign * step;
                    kind.displace(&mut moved[layout.positions()], &by);
                }
                system.rhs(0.0, &moved, &mut rates).unwrap();
                trace -= sign * rates[velocity] / (2.0 * step);
            }
        }
    }
    trace
}

#[test]
fn sagging_bodies_that_stiffen_vibrate_as_their_right_hand_side_says() {
    let sample = block(RigidMotion::Spatial, 5);
    let mut random = Random(17);
    // Random symmetric matrices: under weight 1e-4 of the modal stiffness, far more than what it does to a block.
    let size = 1e-4 * sample.data.modal_stiffness[0] / G;
    let mut matrix = || {
        let mut matrix = Mat::from_fn(5, 5, |_, _| size * random.next());
        for (i, j) in (0..5).flat_map(|i| (0..i).map(move |j| (i, j))) {
            matrix[(i, j)] = matrix[(j, i)];
        }
        matrix
    };
    let given = GeometricStiffening {
        translation: std::array::from_fn(|_| matrix()),
        position: std::array::from_fn(|_| std::array::from_fn(|_| Mat::zeros(5, 5))), // nothing turns
    };
    let data = sample.data.clone().with_geometric_stiffening(&given).unwrap();
    let body = |name: &str| {
        let turn = UnitQuaternion::from_scaled_axis(Vector3::new(0.4, -0.3, 0.9));
        let markers = [("a", 1), ("b", 10)]
            .map(|(name, node)| sample.marker(name, node, turn, |j| sample.nodal_rotation(node, j)));
        BodySpec { name: name.into(), data: data.clone(), markers: markers.to_vec() }
    };
    let fixed = |name: &str, parent: (&str, &str), child: &str| {
        let parent = Attachment::new(parent.0, parent.1);
        JointSpec::new(name, JointKind::Fixed, parent, Attachment::new(child, "b"))
    };
    let joints = vec![fixed("one", (GROUND, "pin"), "upper"), fixed("two", ("upper", "a"), "lower")];
    let mut system = system(vec![body("upper"), body("lower")], joints, vec![]);
    let mut y = system.rest();
    system.static_start(0.0, &mut y).unwrap();
    let found = system.small_vibrations(0.0, &y).unwrap();
    let sum: f64 = found.modes.iter().map(|m| m.squared_frequency).sum();
    let trace = trace_of_accelerations(&mut system, &y);
    // Steps change the inertia by their size times that of the matrices, 1e-4; its square is the truncation.
    assert!((sum / trace - 1.0).abs() < 1e-7, "{sum} {trace}");
    assert!(found.asymmetry < 1e-9, "weight has a potential: {found:?}");
}

#[test]
fn random_trees_in_equilibrium_vibrate_as_their_right_hand_side_says() {
    // No gravity and no velocity: any undeformed pose is in equilibrium, and the derivative of the right-hand side is -M⁻¹K.
    let kinds = [JointKind::Spherical, JointKind::Universal, JointKind::Cylindrical];
    let mut random = Random(3);
    let samples = [block(RigidMotion::Spatial, 5), block(RigidMotion::Spatial, 4)];
    let body = |name: &str, i: usize, random: &mut Random| {
        let markers = [("a", 1), ("b", 10)].map(|(name, node)| {
            let turn = UnitQuaternion::from_scaled_axis(random.vector());
            samples[i].marker(name, node, turn, |j| samples[i].nodal_rotation(node, j))
        });
        BodySpec { name: name.into(), data: samples[i].data.clone(), markers: markers.to_vec() }
    };
    let bodies =
        vec![body("one", 0, &mut random), body("two", 1, &mut random), body("three", 1, &mut random)];
    let places = [((GROUND, "pin"), "one"), (("one", "a"), "two"), (("one", "b"), "three")];
    let joints = places.iter().zip(kinds).map(|((parent, child), kind)| {
        let (p, c) = (Attachment::new(parent.0, parent.1), Attachment::new(child, "b"));
        let mut joint = JointSpec::new(&format!("to {child}"), kind, p, c);
        let spring = CoordinateForce { stiffness: 20.0, ..CoordinateForce::default() };
        joint.coordinates = vec![spring; kind.n_velocities()];
        joint
    });
    let joints = joints.collect();
    let ground = vec![marker("pin", [0.1, -0.2, 0.3])];
    let spec = SystemSpec { bodies, ground, joints, ..SystemSpec::default() };
    let mut system: Multibody = Multibody::new(spec, Vec::new()).unwrap();
    let y = system.rest();
    let found = system.small_vibrations(0.0, &y).unwrap();
    assert!(found.acceleration < 1e-12 && found.asymmetry < 1e-9, "{found:?}");
    let trace = trace_of_accelerations(&mut system, &y);
    let sum: f64 = found.modes.iter().map(|m| m.squared_frequency).sum();
    // Truncation of the differences: the square of the step over the size of the motion, a tenth.
    assert!((sum / trace - 1.0).abs() < 1e-7, "{sum} {trace}");
    assert!(found.modes.iter().all(|m| m.squared_frequency > 0.0), "springs hold everything");
}
