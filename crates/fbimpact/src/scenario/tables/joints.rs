//! Keys of `[joints.NAME]` and `[loads.NAME]`.

use super::super::keys::{Choice, Condition, Key, Kind, Named, Range, Test, name_values};
use super::bodies::{BESIDE_PART, BESIDE_POINT, COUPLING, FACE, RADIUS};
use super::ranges::{COORDINATE, RATE};
use super::time_curves::curve;

/// Type of a joint; a generic one holds what it is told.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum JointType {
    /// No relative motion.
    Fixed,
    /// Hinge.
    Revolute,
    /// Slider.
    Prismatic,
    /// Sleeve.
    Cylindrical,
    /// Cardan joint.
    Universal,
    /// Ball joint.
    Spherical,
    /// Plane on plane.
    Planar,
    /// All motions.
    Free,
    /// Slider along z of axisymmetric bodies.
    Axial,
    /// By its free directions.
    Generic,
}

name_values!(JointType {
    Fixed: "fixed", "no relative motion",
        elsewhere ["weld", "rigid", "lock", "locked", "clamp", "bracket", "tie", "bonded"];
    Revolute: "revolute", "angle about `axis`",
        elsewhere ["hinge", "pin", "pivot", "rotational", "rotary", "bearing"];
    Prismatic: "prismatic", "displacement along `axis`",
        elsewhere ["slider", "slide", "translational", "translation", "rail", "linear", "guide"];
    Cylindrical: "cylindrical", "displacement along `axis` and angle about it", elsewhere ["sleeve", "piston"];
    Universal: "universal", "angle about `axis` of the parent, then about `second_axis` of the child",
        elsewhere ["cardan", "hooke"];
    Spherical: "spherical", "rotation about a point",
        elsewhere ["ball", "ball-joint", "socket", "ball-and-socket"];
    Planar: "planar", "two displacements across `axis` and the angle about it", elsewhere ["plane"];
    Free: "free", "three displacements and a rotation",
        elsewhere ["floating", "6dof", "freejoint", "bushing"];
    Axial: "axial", "displacement along z, for axisymmetric bodies";
    Generic: "generic", "displacements along and rotations about the axes that `locked` leaves free",
        elsewhere ["6dof-spring", "custom"];
});

/// Directions of a joint.
const DIRECTIONS: &[Choice] = &[
    Choice::new("x", "displacement along the first cross axis"),
    Choice::new("y", "displacement along the second cross axis"),
    Choice::new("z", "displacement along `axis`"),
    Choice::new("rx", "rotation about the first cross axis"),
    Choice::new("ry", "rotation about the second cross axis"),
    Choice::new("rz", "rotation about `axis`"),
];

/// Name of the body, `ground` for space.
const BODY: Key = Key::new("body", Kind::Name).doc("Name of a body; `ground` is space, for a parent only.");
const MARKER: Key = Key::new("marker", Kind::Name)
    .otherwise("`face` or `point` must be given")
    .doc("Marker of the body: of a flexible one with a shape it must have an extent, as `start` and `end` of bars have, which are \
     their end faces.");
const HELD_FACE: Key = FACE.otherwise("`marker` or `point` must be given");
const HELD_RADIUS: Key = RADIUS.otherwise("flexible bodies need one beside `point`");
const POINT: Key = Key::measured("point", Kind::Point(COORDINATE), "m")
    .otherwise("`marker` or `face` must be given; on ground, unless the joint closes a loop, where the child's place is with the \
         child's origin at that of space")
    .doc("Point in the components of the body's model: [x, y, z], [x, y] or [r, z]; on ground [x, y, z]. Beside `face` it says where the place is that \
     the face carries, on a rigid arm; in the middle of the face otherwise.");

/// The side of the joint is on a body.
const ON_BODY: Condition = Condition::new("on bodies", Test::NoneOf("body", &["ground"]))
    .remark("ground has no markers and no parts, give a \"point\" in space");

const ATTACHMENT: &[Key] = &[
    BODY,
    MARKER.when(&[ON_BODY]),
    HELD_FACE.when(&[ON_BODY]),
    POINT,
    HELD_RADIUS.when(&[ON_BODY, BESIDE_POINT]),
    COUPLING.when(&[ON_BODY, BESIDE_PART]),
];

/// The joint has coordinates.
const WITH_COORDINATES: Condition = Condition::new(
    "for joints that are neither fixed nor close a loop",
    Test::All(&[Test::NoneOf("type", &["fixed"]), Test::IsFalse("closes_loop")]),
);
/// The free directions are chosen.
const GENERIC: Condition = Condition::new("for type \"generic\"", Test::OneOf("type", &["generic"]));
/// One angle is among the coordinates.
const ONE_ANGLE: Condition = Condition::new(
    "for joints with a single angle",
    Test::OneOf("type", &["revolute", "cylindrical", "planar"]),
);
/// One displacement is among the coordinates.
const ONE_DISPLACEMENT: Condition = Condition::new(
    "for joints with a single displacement",
    Test::OneOf("type", &["prismatic", "cylindrical", "axial"]),
);
/// There is one coordinate.
const ONE_COORDINATE: Condition = Condition::new(
    "for joints with a single coordinate",
    Test::OneOf("type", &["revolute", "prismatic", "axial"]),
);

/// Stiffness or damping, of any unit.
const CONSTANT: Range = Range::closed(0.0, 1e18);
/// Coordinates of a joint \[m, rad\].
const JOINT_COORDINATE: Range = Range::within(1e6);

/// `[joints.NAME]`.
pub(super) const JOINT: &[Key] = &[
    Key::new("type", Kind::Choice(JointType::CHOICES))
        .doc("Type. Where there are several coordinates they stand in the order given here."),
    Key::new("parent", Kind::Table(ATTACHMENT)).doc("Place on the body nearer to ground, or on ground."),
    Key::new("child", Kind::Table(ATTACHMENT))
        .doc("Place on the child of the joint. With all joint coordinates at zero both places coincide."),
    Key::measured("axis", Kind::Vector(3, COORDINATE), "–")
        .otherwise("z for `axial`, the axes of space for `spherical`, `free` and `generic`")
        .doc("Axis in space with all joint coordinates at zero; of any length but zero.")
        .when(&[Condition::new("for joints with coordinates", Test::NoneOf("type", &["fixed"])).remark("a fixed joint has none")]),
    Key::measured("second_axis", Kind::Vector(3, COORDINATE), "–")
        .otherwise("must be given")
        .doc("Second axis, perpendicular to the first.")
        .when(&[Condition::new("for type \"universal\"", Test::OneOf("type", &["universal"]))]),
    Key::measured("reference", Kind::Vector(3, COORDINATE), "–")
        .otherwise("the axis of space that is farthest from `axis`")
        .doc("Vector whose part across `axis` is the first of the joint's cross axes, as `planar` joints count displacements.")
        .when(&[Condition::new(
            "for joints with one axis",
            Test::NoneOf("type", &["fixed", "universal"]),
        )]),
    Key::new("locked", Kind::Choices(DIRECTIONS))
        .otherwise("must be given")
        .doc("Directions in which the joint holds its child, along and about the axes of the parent: the first and second cross axis and `axis`; plane bodies \
         have `x`, `y` and `rz` alone, what else there is is held anyhow. Of two free \
         rotations the first one in this order is about the parent's axis, the second about the child's. Coordinates are the free displacements, \
         then the free rotations, in this order.")
        .when(&[GENERIC]),
    Key::new("closes_loop", Kind::Boolean)
        .default("false")
        .doc("Whether the joint is a constraint on bodies that are children of other joints; it has no coordinates then."),
    Key::angle("angle", Kind::Number(JOINT_COORDINATE), "rad")
        .otherwise("0")
        .doc("Initial angle.")
        .when(&[WITH_COORDINATES, ONE_ANGLE.remark("others take \"coordinates\"")]),
    Key::measured("displacement", Kind::Number(JOINT_COORDINATE), "m")
        .otherwise("0")
        .doc("Initial displacement.")
        .when(&[WITH_COORDINATES, ONE_DISPLACEMENT.remark("others take \"coordinates\"")]),
    Key::measured("coordinates", Kind::Numbers(JOINT_COORDINATE), "m, rad")
        .otherwise("0")
        .doc("All initial coordinates of the joint; a rotation of `spherical` and `free` joints is a rotation vector.")
        .when(&[WITH_COORDINATES]),
    Key::angle("angular_velocity", Kind::Number(RATE), "rad/s")
        .otherwise("0")
        .doc("Initial angular velocity.")
        .when(&[WITH_COORDINATES, ONE_ANGLE.remark("others take \"velocities\"")]),
    Key::measured("velocity", Kind::Number(RATE), "m/s")
        .otherwise("0")
        .doc("Initial velocity.")
        .when(&[WITH_COORDINATES, ONE_DISPLACEMENT.remark("others take \"velocities\"")]),
    Key::measured("velocities", Kind::Numbers(RATE), "m/s, rad/s")
        .otherwise("0")
        .doc("All initial velocities of the joint; of `spherical` and `free` joints the angular velocity along the joint's axes on the child, which turn with it.")
        .when(&[WITH_COORDINATES]),
    Key::measured("stiffness", Kind::Numbers(CONSTANT), "N/m, N m/rad")
        .otherwise("no springs")
        .doc("Stiffness of the joint's springs, one per coordinate; one number for all if they are of one kind.")
        .when(&[WITH_COORDINATES]),
    Key::measured("rest", Kind::Numbers(JOINT_COORDINATE), "m, rad")
        .otherwise("0")
        .doc("Coordinates at which the springs are relaxed.")
        .when(&[WITH_COORDINATES]),
    Key::measured("damping", Kind::Numbers(CONSTANT), "N s/m, N m s/rad")
        .otherwise("no dampers")
        .doc("Constants of the joint's dampers.")
        .when(&[WITH_COORDINATES]),
    Key::measured("friction", Kind::Numbers(CONSTANT), "N, N m")
        .otherwise("none")
        .doc("Force or moment of dry friction while the coordinate slides (Coulomb), whatever the joint transmits; alike about the three axes of a rotation \
         about a point, where it opposes the angular velocity.")
        .when(&[WITH_COORDINATES]),
    Key::measured("friction_velocity", Kind::Numbers(Range::positive(1e6)), "m/s, rad/s")
        .otherwise("1e-4 m/s, 1e-3 rad/s")
        .doc("Velocity `u` up to which friction grows, `friction v / sqrt(v² + u²)`: a coordinate that friction holds creeps more slowly than that.")
        .when(&[WITH_COORDINATES, Condition::new("with friction", Test::With("friction"))]),
    Key::new("bearing", Kind::Table(BEARING))
        .otherwise("none")
        .doc("Friction by the load that the joint transmits, beside that of `friction`.")
        .when(&[WITH_COORDINATES, Condition::new(
        "for types \"revolute\", \"prismatic\", \"cylindrical\" and \"spherical\"",
        Test::OneOf("type", &["revolute", "prismatic", "cylindrical", "spherical"]),
    ).remark("give others the size of their friction in \"friction\"")]),
    Key::new("stop", Kind::Table(STOP))
        .otherwise("none")
        .doc("Ends of the coordinate's travel.")
        .when(&[WITH_COORDINATES, ONE_COORDINATE.remark("others take \"stops\"")]),
    Key::new("stops", Kind::Tables(STOPS))
        .default("[]")
        .doc("Ends of the travel of coordinates of a joint with several; not of a rotation with three angles.")
        .when(&[WITH_COORDINATES]),
    curve("drive", "N, N m", "Force along the coordinate.")
        .when(&[WITH_COORDINATES, ONE_COORDINATE.remark("others take \"drives\"")]),
    curve("motion", "m, rad", "Motion prescribed to the coordinate.")
        .when(&[WITH_COORDINATES, ONE_COORDINATE.remark("others take \"motions\"")]),
    Key::new("drives", Kind::Tables(DRIVES))
        .default("[]")
        .doc("Forces along coordinates of a joint with several.")
        .when(&[WITH_COORDINATES]),
    Key::new("motions", Kind::Tables(MOTIONS))
        .default("[]")
        .doc("Motions prescribed to coordinates of a joint with several; not of a rotation with three angles.")
        .when(&[WITH_COORDINATES]),
];

const COORDINATE_NUMBER: Key =
    Key::measured("coordinate", Kind::Integer(0, 5), "–").doc("Number of the coordinate, from 0.");
const LOWER: Key = Key::measured("lower", Kind::Number(JOINT_COORDINATE), "m, rad")
    .otherwise("no lower end, `upper` must be given")
    .doc("Coordinate at which the lower stop is met.");
const UPPER: Key = Key::measured("upper", Kind::Number(JOINT_COORDINATE), "m, rad")
    .otherwise("no upper end, `lower` must be given")
    .doc("Coordinate at which the upper stop is met.");
const STOP_STIFFNESS: Key = Key::measured("stiffness", Kind::Number(Range::positive(1e18)), "N/m, N m/rad")
    .doc(
        "Stiffness of the stop. Where the impact on it matters, model the two bodies with a contact instead.",
    );
const STOP_DAMPING: Key = Key::measured("damping", Kind::Number(Range::closed(0.0, 1e12)), "s/m, s/rad")
    .default("0.0")
    .doc("Damping `c` in the force `stiffness δ (1 + c dδ/dt)` of the compression δ (Hunt and Crossley): a meeting at the speed v takes about `2/3 c v` of it.");
const STOP_OVERLAP: Key = Key::measured("initial_overlap", Kind::Number(Range::closed(0.0, 1e6)), "m, rad")
    .default("0.0")
    .doc("Compression of the stop at the start that is allowed; the run begins with its energy. More is an error. A mass *m* rests on its stop \
     with the compression *m g* / `stiffness`.");
/// Size of a bearing \[m\].
const BEARING_SIZE: Range = Range::positive(1e6);
/// `bearing` of a joint.
const BEARING: &[Key] = &[
    Key::measured("friction", Kind::Number(Range::closed(0.0, 100.0)), "–")
        .doc("Coefficient of friction, of stick and slip alike."),
    Key::measured("radius", Kind::Number(BEARING_SIZE), "m")
        .otherwise("must be given; of a slider, which holds the moment about its axis without friction then, it may be left out")
        .doc("Radius of the pin, the sleeve or the ball; of a slider the arm at which it holds the moment about its axis."),
    Key::measured("length", Kind::Number(BEARING_SIZE), "m")
        .otherwise("moments across the axis are held without friction")
        .doc("Distance of two supports along the axis, with the child's place of the joint in the middle: they share the force and hold moments across the axis \
         as a couple.")
        .when(&[Condition::new("for joints with an axis", Test::Around(&Test::NoneOf("type", &["spherical"]))).remark("a ball holds no moment")]),
    Key::measured("collar", Kind::Number(BEARING_SIZE), "m")
        .otherwise("the force along the axis is held without friction")
        .doc("Mean radius of the collar that holds the force along the axis.")
        .when(&[Condition::new("for type \"revolute\"", Test::Around(&Test::OneOf("type", &["revolute"]))).remark("others hold no force along an axis about which they turn")]),
    Key::measured("velocity", Kind::Number(Range::positive(1e6)), "m/s")
        .default("1e-4")
        .doc("Velocity `u` of sliding up to which friction grows, as `v / sqrt(v² + u²)`: a bearing that friction holds creeps more slowly than that."),
];
/// `stop` of a joint with one coordinate.
const STOP: &[Key] = &[LOWER, UPPER, STOP_STIFFNESS, STOP_DAMPING, STOP_OVERLAP];
/// An entry of `stops`.
const STOPS: &[Key] = &[COORDINATE_NUMBER, LOWER, UPPER, STOP_STIFFNESS, STOP_DAMPING, STOP_OVERLAP];

/// An entry of `drives`.
const DRIVES: &[Key] =
    &[COORDINATE_NUMBER, curve("curve", "N, N m", "Force along the coordinate over time.").required()];
/// An entry of `motions`.
const MOTIONS: &[Key] = &[COORDINATE_NUMBER, curve("curve", "m, rad", "Coordinate over time.").required()];

const RATIO: Range = Range::within(1e9);

/// `[gears.NAME]`.
pub(super) const GEAR: &[Key] = &[
    Key::new("first", Kind::Name).doc("Name of a joint with coordinates, which does not close a loop."),
    Key::measured("first_coordinate", Kind::Integer(0, 5), "–")
        .otherwise("that of a joint with a single coordinate")
        .doc("Number of its coordinate, from 0; none of three angles about a point."),
    Key::new("second", Kind::Name)
        .doc("Name of the other joint; the same one where two of its coordinates move together, as those of a screw."),
    Key::measured("second_coordinate", Kind::Integer(0, 5), "–")
        .otherwise("that of a joint with a single coordinate")
        .doc("Number of its coordinate, from 0."),
    Key::measured("ratio", Kind::Number(RATIO), "rad/rad, m/rad, rad/m, m/m")
        .doc("Rate of the second coordinate by that of the first; not zero. Wheels that mesh outside turn in opposite directions about axes of one \
         direction: the ratio is negative. Of a rack it is the radius of its pinion, of a screw the lead over 2π: `\"5 mm/rev\"`."),
];

/// `[loads.NAME]`.
pub(super) const LOAD: &[Key] = &[
    Key::new("body", Kind::Name).doc("Name of the body."),
    MARKER,
    HELD_FACE,
    POINT
        .otherwise("`marker` or `face` must be given")
        .doc("Point in the components of the body's model: [x, y, z], [x, y] or [r, z]; beside `face` where the load acts, on a rigid arm."),
    HELD_RADIUS,
    COUPLING,
    curve("force_x", "N", "Force along x."),
    curve("force_y", "N", "Force along y."),
    curve("force_z", "N", "Force along z."),
    curve("moment_x", "N m", "Moment about x."),
    curve("moment_y", "N m", "Moment about y."),
    curve("moment_z", "N m", "Moment about z."),
    Key::new("following", Kind::Boolean)
        .default("false")
        .doc("Whether the axes are those of the body at the place of the load and turn with it; those of space otherwise."),
];
