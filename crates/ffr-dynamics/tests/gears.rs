//! Gears between joint coordinates against closed forms (docs/theory.md M.37 to M.40).

use ffr_dynamics::body::{RigidMotion, StandardInputData};
use ffr_dynamics::integration::{Integrator, Method, OdeSystem, StepSettings};
use ffr_dynamics::kinematics::Marker;
use ffr_dynamics::system::{
    Attachment, BodySpec, CoordinateForce, ErrorScale, GROUND, GearSpec, JointKind, JointSpec, Multibody,
    SystemSpec, TimeFunction,
};
use nalgebra::{Matrix3, UnitQuaternion, Vector3};

/// Tolerance of each step of the integration.
const RELATIVE: f64 = 1e-9;
/// What a chain of some ten operations on doubles may lose.
const ROUNDING: f64 = 1e-13;

fn marker(place: Vector3<f64>) -> Marker {
    Marker::rigid("a", place, UnitQuaternion::identity())
}

/// A rigid body with its joint's marker at `place`, its centre of mass at the origin.
fn body(name: &str, mass: f64, inertia: [f64; 3], place: Vector3<f64>) -> BodySpec {
    let inertia = Matrix3::from_diagonal(&inertia.into());
    let data = StandardInputData::rigid(RigidMotion::Spatial, mass, Vector3::zeros(), inertia).unwrap();
    BodySpec { name: name.into(), data, markers: vec![marker(place)] }
}

fn joint(kind: JointKind, parent: &str, child: &str, forces: Vec<CoordinateForce>) -> JointSpec {
    let at = |body: &str| Attachment::new(body, "a");
    JointSpec { coordinates: forces, ..JointSpec::new(&format!("of {child}"), kind, at(parent), at(child)) }
}

fn gear(name: &str, first: (&str, usize), second: (&str, usize), ratio: f64) -> GearSpec {
    let of = |(body, k): (&str, usize)| (format!("of {body}"), k);
    GearSpec { name: name.into(), first: of(first), second: of(second), ratio, offset: 0.0 }
}

fn drive(force: f64) -> CoordinateForce {
    CoordinateForce { drive: Some(TimeFunction::constant(force)), ..CoordinateForce::default() }
}

fn spec(bodies: Vec<BodySpec>, joints: Vec<JointSpec>, gears: Vec<GearSpec>) -> SystemSpec {
    SystemSpec { bodies, joints, gears, ground: vec![marker(Vector3::zeros())], ..SystemSpec::default() }
}

fn system(spec: SystemSpec) -> Multibody {
    let mut system = Multibody::new(spec, Vec::new()).unwrap();
    system.set_error_scale(ErrorScale { relative: RELATIVE, ..ErrorScale::default() }).unwrap();
    system
}

fn run(system: &mut Multibody, method: Method, y: &[f64], to: f64) -> Vec<f64> {
    let mut integrator = Integrator::new(method, StepSettings::default(), 0.0, y, system).unwrap();
    integrator.run(system, to, |_, _| true).unwrap();
    integrator.state().to_vec()
}

fn from_rest(system: &mut Multibody, method: Method, to: f64) -> Vec<f64> {
    let y = system.rest();
    run(system, method, &y, to)
}

fn velocity(system: &Multibody, y: &[f64], body: usize, k: usize) -> f64 {
    system.joint_coordinates(0.0, y, body).velocities[k]
}

const J: [f64; 2] = [0.03, 0.7];

/// Two wheels on ground, a torque on the first.
fn wheels(ratio: f64, torque: f64) -> Multibody {
    let wheel = |name, inertia| body(name, 2.0, [1.0, 1.0, inertia], Vector3::zeros());
    let joints = vec![
        joint(JointKind::Revolute, GROUND, "one", vec![drive(torque)]),
        joint(JointKind::Revolute, GROUND, "two", Vec::new()),
    ];
    let gears = vec![gear("pair", ("one", 0), ("two", 0), ratio)];
    system(spec(vec![wheel("one", J[0]), wheel("two", J[1])], joints, gears))
}

#[test]
fn two_wheels_have_the_inertia_of_both() {
    let (ratio, torque, end) = (-0.4, 3.0, 0.2);
    let exact = torque / (J[0] + J[1] * ratio * ratio);
    for method in [Method::DormandPrince, Method::Gauss, Method::TrBdf2] {
        let mut system = wheels(ratio, torque);
        let y = from_rest(&mut system, method, end);
        // Constant accelerations are exact but for rounding and what Newton's method leaves, a part of the tolerance.
        let (one, two) = (velocity(&system, &y, 0, 0), velocity(&system, &y, 1, 0));
        assert!((one - exact * end).abs() < RELATIVE * exact * end, "{method:?} {one} {}", exact * end);
        assert!((two - ratio * one).abs() < ROUNDING * one, "{method:?} {two}");
        assert!(system.loop_residual(end, &y) < 1e-11, "the limit of a residual");
        system.evaluate_accelerations(end, &y).unwrap();
        assert!(
            (system.gear_force(0) / (J[1] * ratio * exact) - 1.0).abs() < ROUNDING,
            "moment on the second wheel"
        );
        // The torque's work is in the motion, none in the gear.
        let energy = system.invariants(end, &y).energy();
        assert!((energy - system.supplied_work(&y)).abs() < RELATIVE * energy, "{energy}");
        assert!((energy - 0.5 * (J[0] + J[1] * ratio * ratio) * one * one).abs() < RELATIVE * energy);
        // Reactions: the moment about the axis is what turns the wheel, drive and gear together.
        let moment = system.reaction(0).moment.z;
        assert!((moment - J[0] * exact).abs() < ROUNDING * torque, "{moment}");
    }
}

#[test]
fn a_prescribed_wheel_drives_the_other_and_supplies_its_power() {
    let ratio = 2.5;
    let mut description = spec(
        vec![
            body("one", 1.0, [1.0, 1.0, J[0]], Vector3::zeros()),
            body("two", 1.0, [1.0, 1.0, J[1]], Vector3::zeros()),
        ],
        vec![
            joint(
                JointKind::Revolute,
                GROUND,
                "one",
                vec![CoordinateForce {
                    motion: Some(TimeFunction::new(|t| [2.0 * t * t, 4.0 * t, 4.0])),
                    ..CoordinateForce::default()
                }],
            ),
            joint(JointKind::Revolute, GROUND, "two", Vec::new()),
        ],
        vec![gear("pair", ("one", 0), ("two", 0), ratio)],
    );
    let mut system = system(description.clone());
    let y = from_rest(&mut system, Method::DormandPrince, 0.5);
    assert!((velocity(&system, &y, 1, 0) - ratio * 2.0).abs() < RELATIVE * ratio * 2.0);
    let energy = system.invariants(0.5, &y).energy();
    let exact = 0.5 * (J[0] + J[1] * ratio * ratio) * 4.0;
    assert!(
        (energy - exact).abs() < RELATIVE * exact
            && (system.supplied_work(&y) - exact).abs() < RELATIVE * exact
    );

    // Both prescribed: nothing is left to follow.
    description.joints[1].coordinates = description.joints[0].coordinates.clone();
    let error = Multibody::<Box<dyn ffr_dynamics::force::active::ActiveForce>>::new(description, Vec::new())
        .err()
        .unwrap();
    assert!(
        error.to_string().contains("gear \"pair\"") && error.to_string().contains("both prescribed"),
        "{error}"
    );
}

#[test]
fn a_rack_and_a_screw_carry_weight() {
    // A pinion lifts a rack under a torque; a nut falls on its screw and turns.
    let (radius, torque, mass, g) = (0.05, 4.0, 3.0, 9.81);
    let bodies = vec![
        body("pinion", 1.0, [1.0, 1.0, 0.02], Vector3::zeros()),
        body("rack", mass, [1.0; 3], Vector3::zeros()),
    ];
    let joints = vec![
        joint(JointKind::Revolute, GROUND, "pinion", vec![drive(torque)]),
        joint(JointKind::Prismatic, GROUND, "rack", Vec::new()),
    ];
    let gears = vec![gear("teeth", ("pinion", 0), ("rack", 0), radius)];
    let gravity = Vector3::z() * -g;
    let mut lift = system(SystemSpec { gravity, ..spec(bodies, joints, gears) });
    let start = lift.rest();
    lift.evaluate_accelerations(0.0, &start).unwrap();
    let exact = (torque - mass * g * radius) / (0.02 + mass * radius * radius);
    assert!((lift.gear_force(0) / (mass * (g + radius * exact)) - 1.0).abs() < ROUNDING);

    let (lead, inertia) = (0.01 / std::f64::consts::TAU, 1e-4);
    let nut = vec![body("nut", mass, [1.0, 1.0, inertia], Vector3::zeros())];
    let guide = vec![joint(JointKind::Cylindrical, GROUND, "nut", Vec::new())];
    let mut screw = system(SystemSpec {
        gravity,
        ..spec(nut, guide, vec![gear("thread", ("nut", 1), ("nut", 0), lead)])
    });
    let y = from_rest(&mut screw, Method::DormandPrince, 0.3);
    let exact = -g * 0.3 / (1.0 + inertia / (mass * lead * lead));
    assert!((velocity(&screw, &y, 0, 0) - exact).abs() < RELATIVE * exact.abs());
    let (energy, before) = (screw.invariants(0.3, &y).energy(), 0.0);
    assert!((energy - before).abs() < RELATIVE * screw.invariants(0.3, &y).kinetic, "{energy}");
}

/// A carrier on ground with a planet on it and a sun beside, all axes along z; the planet's axle is 0.2 m from the middle.
fn planetary(gears: Vec<GearSpec>, torque: f64) -> SystemSpec {
    let axle = Vector3::x() * 0.2;
    let mut carrier = body("carrier", 2.0, [0.1, 0.1, 0.15], Vector3::zeros());
    carrier.markers.push(Marker::rigid("axle", axle, UnitQuaternion::identity()));
    let bodies = vec![
        carrier,
        body("planet", 0.5, [1e-3, 1e-3, 2e-3], Vector3::zeros()),
        body("sun", 1.0, [3e-3, 3e-3, 4e-3], Vector3::zeros()),
    ];
    let on_axle = JointSpec::new(
        "of planet",
        JointKind::Revolute,
        Attachment::new("carrier", "axle"),
        Attachment::new("planet", "a"),
    );
    let joints = vec![
        joint(JointKind::Revolute, GROUND, "carrier", vec![drive(torque)]),
        on_axle,
        joint(JointKind::Revolute, "carrier", "sun", Vec::new()),
    ];
    spec(bodies, joints, gears)
}

#[test]
fn a_planet_on_a_fixed_ring_turns_as_rolling_says() {
    // The angle of the planet relative to the carrier: ring of 60 teeth at rest, planet of 20 inside: -60/20; the sun of 20, outside.
    let gears =
        vec![gear("ring", ("carrier", 0), ("planet", 0), -3.0), gear("sun", ("planet", 0), ("sun", 0), -1.0)];
    let torque = 0.7;
    let mut system = system(planetary(gears, torque));
    let y = from_rest(&mut system, Method::DormandPrince, 0.4);
    // Absolute speeds by the carrier's: planet 1 - 3, sun 1 + 3 (Willis).
    let inertia = 0.15 + 0.5 * 0.04 + 2e-3 * 4.0 + 4e-3 * 16.0;
    let exact = torque / inertia * 0.4;
    assert!((velocity(&system, &y, 0, 0) / exact - 1.0).abs() < RELATIVE);
    let spin = system.body_states(0.4, &y)[2].angular_velocity_in_body.z;
    assert!((spin / (4.0 * exact) - 1.0).abs() < RELATIVE, "{spin}");
    let energy = system.invariants(0.4, &y).energy();
    assert!((energy - system.supplied_work(&y)).abs() < RELATIVE * energy);
}

#[test]
fn chains_that_lock_or_repeat_are_refused() {
    let chain = |last: f64| {
        vec![
            gear("a", ("carrier", 0), ("planet", 0), -2.0),
            gear("b", ("planet", 0), ("sun", 0), -3.0),
            gear("c", ("sun", 0), ("carrier", 0), last),
        ]
    };
    let refused = |gears| {
        Multibody::<Box<dyn ffr_dynamics::force::active::ActiveForce>>::new(planetary(gears, 0.0), Vec::new())
            .err()
            .unwrap()
            .to_string()
    };
    let error = refused(chain(-1.0 / 6.0));
    assert!(error.contains("gear \"c\": ratio -0.16") && error.contains("would lock"), "{error}");
    assert!(refused(chain(1.0 / 6.0)).contains("say the same already"), "the two others give the ratio six");
    assert!(refused(vec![gear("a", ("wheel", 0), ("sun", 0), 1.0)]).contains("no joint \"of wheel\""));
    assert!(refused(vec![gear("a", ("planet", 1), ("sun", 0), 1.0)]).contains("no coordinate 1"));
    assert!(refused(vec![gear("a", ("planet", 0), ("sun", 0), 0.0)]).contains("must be finite and not zero"));
}

#[test]
fn velocities_follow_those_given_and_slipping_ones_are_refused() {
    let mut system = wheels(-0.4, 0.0);
    let mut y = system.rest();
    system.set_joint(&mut y, 0, &[0.0], &[5.0]).unwrap();
    let start = y.clone();
    system.assemble_start(0.0, &mut y, &[true, false]).unwrap();
    assert!(
        (velocity(&system, &y, 0, 0) - 5.0).abs() < ROUNDING * 5.0
            && (velocity(&system, &y, 1, 0) + 2.0).abs() < ROUNDING * 5.0
    );
    // None given: the least kinetic energy that keeps what the momenta are along the constraint.
    y.copy_from_slice(&start);
    system.assemble(0.0, &mut y).unwrap();
    let kept = J[0] * 5.0 / (J[0] + J[1] * 0.16);
    assert!((velocity(&system, &y, 0, 0) / kept - 1.0).abs() < ROUNDING, "{}", velocity(&system, &y, 0, 0));

    y.copy_from_slice(&start);
    let error = system.assemble_start(0.0, &mut y, &[true, true]).unwrap_err().to_string();
    assert!(error.contains("gear \"pair\"") && error.contains("slip by"), "{error}");
}

#[test]
fn a_gear_of_ratio_one_holds_like_a_joint() {
    // Two bars hinged on ground at one axis and geared one to one move like one body on the hinge.
    let (g, place) = (9.81, Vector3::new(0.0, 0.3, 0.0));
    let bar = |name: &str| body(name, 1.5, [0.02, 0.01, 0.02], place);
    let other = body("two", 0.5, [0.03, 0.03, 0.05], -place);
    let hinge = |child| joint(JointKind::Revolute, GROUND, child, Vec::new());
    let welded =
        JointSpec::new("of two", JointKind::Fixed, Attachment::new("one", "a"), Attachment::new("two", "a"));
    let gravity = Vector3::x() * g;
    let all = |second, gears| SystemSpec {
        gravity,
        ..spec(vec![bar("one"), other.clone()], vec![hinge("one"), second], gears)
    };
    let mut geared = system(all(hinge("two"), vec![gear("belt", ("one", 0), ("two", 0), 1.0)]));
    let mut fixed = system(all(welded, Vec::new()));
    let geared_end = from_rest(&mut geared, Method::DormandPrince, 0.5);
    let fixed_end = from_rest(&mut fixed, Method::DormandPrince, 0.5);
    let angle = |system: &Multibody, y: &[f64], body| system.joint_coordinates(0.5, y, body).positions[0];
    let exact = angle(&fixed, &fixed_end, 0);
    // Each of some hundred steps errs by its tolerance.
    assert!(exact.abs() > 0.1 && (angle(&geared, &geared_end, 0) - exact).abs() < 100.0 * RELATIVE);
    assert!((angle(&geared, &geared_end, 1) - exact).abs() < 100.0 * RELATIVE);
    let (energy, kinetic) =
        (geared.invariants(0.5, &geared_end).energy(), geared.invariants(0.5, &geared_end).kinetic);
    let start = geared.rest();
    assert!((energy - geared.invariants(0.0, &start).energy()).abs() < 100.0 * RELATIVE * kinetic);
    // The gear transmits what the weld does about the axis.
    geared.evaluate_accelerations(0.5, &geared_end).unwrap();
    fixed.evaluate_accelerations(0.5, &fixed_end).unwrap();
    let (moment, weld) = (geared.gear_force(0), fixed.reaction(1).moment.z);
    assert!((moment - weld).abs() < 1e3 * RELATIVE * weld.abs(), "{moment} {weld}"); // g/l makes ten of an angle's error
}

#[test]
fn vibrations_of_geared_wheels_on_a_spring_have_their_closed_form() {
    let (ratio, stiffness) = (-0.4_f64, 50.0);
    let mut description = spec(
        vec![
            body("one", 1.0, [1.0, 1.0, J[0]], Vector3::zeros()),
            body("two", 1.0, [1.0, 1.0, J[1]], Vector3::zeros()),
        ],
        vec![
            joint(
                JointKind::Revolute,
                GROUND,
                "one",
                vec![CoordinateForce { stiffness, ..CoordinateForce::default() }],
            ),
            joint(JointKind::Revolute, GROUND, "two", Vec::new()),
        ],
        vec![gear("pair", ("one", 0), ("two", 0), ratio)],
    );
    let exact = (stiffness / (J[0] + J[1] * ratio * ratio)).sqrt() / std::f64::consts::TAU;
    let modes = |system: &Multibody| {
        let y = system.rest();
        system.small_vibrations(0.0, &y).unwrap()
    };
    let found = modes(&system(description.clone()));
    assert_eq!(found.modes.len(), 1);
    assert!(
        (found.modes[0].frequency() / exact - 1.0).abs() < 1e-9,
        "{} {exact}",
        found.modes[0].frequency()
    ); // differences of fourth order
    description.gears.clear();
    assert_eq!(modes(&system(description)).modes.len(), 2);
}

#[test]
fn right_hand_sides_with_gears_are_those_without_where_the_second_wheel_is_light() {
    // A second wheel of inertia zero in the limit: the first does not feel it.
    let mut with = wheels(1e-9, 3.0);
    let mut rates = vec![0.0; with.dimension()];
    let start = with.rest();
    with.rhs(0.0, &start, &mut rates).unwrap();
    let at = with.model().bodies[0].layout.velocities().start;
    assert!((rates[at] * J[0] / 3.0 - 1.0).abs() < ROUNDING, "{}", rates[at]);
}
