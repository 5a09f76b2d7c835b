//! Keys of `[joints.NAME]` and `[loads.NAME]`.

use super::super::keys::{Bound, Choice, Condition, Key, Kind, Named, Need, Range, Test, name_values};
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
const BODY: Key =
    Key::new("body", Kind::Name, "", Need::Required, "Name of a body; `ground` is space, for a parent only.");
const MARKER: Key = Key::new(
    "marker",
    Kind::Name,
    "",
    Need::Optional("`face` or `point` must be given"),
    "Marker of the body: of a flexible one with a shape it must have an extent, as `start` and `end` of bars have, which are \
     their end faces.",
);
const HELD_FACE: Key = Key { need: Need::Optional("`marker` or `point` must be given"), ..FACE };
const HELD_RADIUS: Key = Key { need: Need::Optional("flexible bodies need one beside `point`"), ..RADIUS };
const POINT: Key = Key::new(
    "point",
    Kind::Point(COORDINATE),
    "m",
    Need::Optional(
        "`marker` or `face` must be given; on ground, unless the joint closes a loop, where the child's place is with the \
         child's origin at that of space",
    ),
    "Point in the components of the body's model: [x, y, z], [x, y] or [r, z]; on ground [x, y, z]. Beside `face` it says where the place is that \
     the face carries, on a rigid arm; in the middle of the face otherwise.",
);

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
const CONSTANT: Range = Range { min: Bound::Closed(0.0), max: Bound::Closed(1e18) };
/// Coordinates of a joint \[m, rad\].
const JOINT_COORDINATE: Range = Range::within(1e6);

/// `[joints.NAME]`.
pub(super) const JOINT: &[Key] = &[
    Key::new(
        "type",
        Kind::Choice(JointType::CHOICES),
        "",
        Need::Required,
        "Type. Where there are several coordinates they stand in the order given here.",
    ),
    Key::new(
        "parent",
        Kind::Table(ATTACHMENT),
        "",
        Need::Required,
        "Place on the body nearer to ground, or on ground.",
    ),
    Key::new(
        "child",
        Kind::Table(ATTACHMENT),
        "",
        Need::Required,
        "Place on the child of the joint. With all joint coordinates at zero both places coincide.",
    ),
    Key::new(
        "axis",
        Kind::Vector(3, COORDINATE),
        "–",
        Need::Optional("z for `axial`, the axes of space for `spherical`, `free` and `generic`"),
        "Axis in space with all joint coordinates at zero; of any length but zero.",
    ).when(&[Condition::new("for joints with coordinates", Test::NoneOf("type", &["fixed"])).remark("a fixed joint has none")]),
    Key::new(
        "second_axis",
        Kind::Vector(3, COORDINATE),
        "–",
        Need::Optional("must be given"),
        "Second axis, perpendicular to the first.",
    ).when(&[Condition::new("for type \"universal\"", Test::OneOf("type", &["universal"]))]),
    Key::new(
        "reference",
        Kind::Vector(3, COORDINATE),
        "–",
        Need::Optional("the axis of space that is farthest from `axis`"),
        "Vector whose part across `axis` is the first of the joint's cross axes, as `planar` joints count displacements.",
    ).when(&[Condition::new(
            "for joints with one axis",
            Test::NoneOf("type", &["fixed", "universal"]),
        )]),
    Key::new(
        "locked",
        Kind::Choices(DIRECTIONS),
        "",
        Need::Optional("must be given"),
        "Directions in which the joint holds its child, along and about the axes of the parent: the first and second cross axis and `axis`; plane bodies \
         have `x`, `y` and `rz` alone, what else there is is held anyhow. Of two free \
         rotations the first one in this order is about the parent's axis, the second about the child's. Coordinates are the free displacements, \
         then the free rotations, in this order.",
    ).when(&[GENERIC]),
    Key::new(
        "closes_loop",
        Kind::Boolean,
        "",
        Need::Default("false"),
        "Whether the joint is a constraint on bodies that are children of other joints; it has no coordinates then.",
    ),
    Key::angle(
        "angle",
        Kind::Number(JOINT_COORDINATE),
        "rad",
        Need::Optional("0"),
        "Initial angle.",
    ).when(&[WITH_COORDINATES, ONE_ANGLE.remark("others take \"coordinates\"")]),
    Key::new(
        "displacement",
        Kind::Number(JOINT_COORDINATE),
        "m",
        Need::Optional("0"),
        "Initial displacement.",
    ).when(&[WITH_COORDINATES, ONE_DISPLACEMENT.remark("others take \"coordinates\"")]),
    Key::new(
        "coordinates",
        Kind::Numbers(JOINT_COORDINATE),
        "m, rad",
        Need::Optional("0"),
        "All initial coordinates of the joint; a rotation of `spherical` and `free` joints is a rotation vector.",
    ).when(&[WITH_COORDINATES]),
    Key::angle(
        "angular_velocity",
        Kind::Number(RATE),
        "rad/s",
        Need::Optional("0"),
        "Initial angular velocity.",
    ).when(&[WITH_COORDINATES, ONE_ANGLE.remark("others take \"velocities\"")]),
    Key::new(
        "velocity",
        Kind::Number(RATE),
        "m/s",
        Need::Optional("0"),
        "Initial velocity.",
    ).when(&[WITH_COORDINATES, ONE_DISPLACEMENT.remark("others take \"velocities\"")]),
    Key::new(
        "velocities",
        Kind::Numbers(RATE),
        "m/s, rad/s",
        Need::Optional("0"),
        "All initial velocities of the joint; of `spherical` and `free` joints the angular velocity along the joint's axes on the child, which turn with it.",
    ).when(&[WITH_COORDINATES]),
    Key::new(
        "stiffness",
        Kind::Numbers(CONSTANT),
        "N/m, N m/rad",
        Need::Optional("no springs"),
        "Stiffness of the joint's springs, one per coordinate; one number for all if they are of one kind.",
    ).when(&[WITH_COORDINATES]),
    Key::new(
        "rest",
        Kind::Numbers(JOINT_COORDINATE),
        "m, rad",
        Need::Optional("0"),
        "Coordinates at which the springs are relaxed.",
    ).when(&[WITH_COORDINATES]),
    Key::new(
        "damping",
        Kind::Numbers(CONSTANT),
        "N s/m, N m s/rad",
        Need::Optional("no dampers"),
        "Constants of the joint's dampers.",
    ).when(&[WITH_COORDINATES]),
    Key::new(
        "friction",
        Kind::Numbers(CONSTANT),
        "N, N m",
        Need::Optional("none"),
        "Force or moment of dry friction while the coordinate slides (Coulomb), whatever the joint transmits; alike about the three axes of a rotation \
         about a point, where it opposes the angular velocity.",
    ).when(&[WITH_COORDINATES]),
    Key::new(
        "friction_velocity",
        Kind::Numbers(Range::positive(1e6)),
        "m/s, rad/s",
        Need::Optional("1e-4 m/s, 1e-3 rad/s"),
        "Velocity `u` up to which friction grows, `friction v / sqrt(v² + u²)`: a coordinate that friction holds creeps more slowly than that.",
    ).when(&[WITH_COORDINATES, Condition::new("with friction", Test::With("friction"))]),
    Key::new(
        "bearing",
        Kind::Table(BEARING),
        "",
        Need::Optional("none"),
        "Friction by the load that the joint transmits, beside that of `friction`.",
    ).when(&[WITH_COORDINATES, Condition::new(
        "for types \"revolute\", \"prismatic\", \"cylindrical\" and \"spherical\"",
        Test::OneOf("type", &["revolute", "prismatic", "cylindrical", "spherical"]),
    ).remark("give others the size of their friction in \"friction\"")]),
    Key::new(
        "stop",
        Kind::Table(STOP),
        "",
        Need::Optional("none"),
        "Ends of the coordinate's travel.",
    ).when(&[WITH_COORDINATES, ONE_COORDINATE.remark("others take \"stops\"")]),
    Key::new(
        "stops",
        Kind::Tables(STOPS),
        "",
        Need::Default("[]"),
        "Ends of the travel of coordinates of a joint with several; not of a rotation with three angles.",
    ).when(&[WITH_COORDINATES]),
    curve("drive", "N, N m", "Force along the coordinate.")
        .when(&[WITH_COORDINATES, ONE_COORDINATE.remark("others take \"drives\"")]),
    curve("motion", "m, rad", "Motion prescribed to the coordinate.")
        .when(&[WITH_COORDINATES, ONE_COORDINATE.remark("others take \"motions\"")]),
    Key::new(
        "drives",
        Kind::Tables(DRIVES),
        "",
        Need::Default("[]"),
        "Forces along coordinates of a joint with several.",
    ).when(&[WITH_COORDINATES]),
    Key::new(
        "motions",
        Kind::Tables(MOTIONS),
        "",
        Need::Default("[]"),
        "Motions prescribed to coordinates of a joint with several; not of a rotation with three angles.",
    ).when(&[WITH_COORDINATES]),
];

const COORDINATE_NUMBER: Key =
    Key::new("coordinate", Kind::Integer(0, 5), "–", Need::Required, "Number of the coordinate, from 0.");
const LOWER: Key = Key::new(
    "lower",
    Kind::Number(JOINT_COORDINATE),
    "m, rad",
    Need::Optional("no lower end, `upper` must be given"),
    "Coordinate at which the lower stop is met.",
);
const UPPER: Key = Key::new(
    "upper",
    Kind::Number(JOINT_COORDINATE),
    "m, rad",
    Need::Optional("no upper end, `lower` must be given"),
    "Coordinate at which the upper stop is met.",
);
const STOP_STIFFNESS: Key = Key::new(
    "stiffness",
    Kind::Number(Range { min: Bound::Open(0.0), max: Bound::Closed(1e18) }),
    "N/m, N m/rad",
    Need::Required,
    "Stiffness of the stop. Where the impact on it matters, model the two bodies with a contact instead.",
);
const STOP_DAMPING: Key = Key::new(
    "damping",
    Kind::Number(Range { min: Bound::Closed(0.0), max: Bound::Closed(1e12) }),
    "s/m, s/rad",
    Need::Default("0.0"),
    "Damping `c` in the force `stiffness δ (1 + c dδ/dt)` of the compression δ (Hunt and Crossley): a meeting at the speed v takes about `2/3 c v` of it.",
);
const STOP_OVERLAP: Key = Key::new(
    "initial_overlap",
    Kind::Number(Range { min: Bound::Closed(0.0), max: Bound::Closed(1e6) }),
    "m, rad",
    Need::Default("0.0"),
    "Compression of the stop at the start that is allowed; the run begins with its energy. More is an error. A mass *m* rests on its stop \
     with the compression *m g* / `stiffness`.",
);
/// Size of a bearing \[m\].
const BEARING_SIZE: Range = Range::positive(1e6);
/// `bearing` of a joint.
const BEARING: &[Key] = &[
    Key::new(
        "friction",
        Kind::Number(Range { min: Bound::Closed(0.0), max: Bound::Closed(100.0) }),
        "–",
        Need::Required,
        "Coefficient of friction, of stick and slip alike.",
    ),
    Key::new(
        "radius",
        Kind::Number(BEARING_SIZE),
        "m",
        Need::Optional("must be given; of a slider, which holds the moment about its axis without friction then, it may be left out"),
        "Radius of the pin, the sleeve or the ball; of a slider the arm at which it holds the moment about its axis.",
    ),
    Key::new(
        "length",
        Kind::Number(BEARING_SIZE),
        "m",
        Need::Optional("moments across the axis are held without friction"),
        "Distance of two supports along the axis, with the child's place of the joint in the middle: they share the force and hold moments across the axis \
         as a couple.",
    ).when(&[Condition::new("for joints with an axis", Test::Around(&Test::NoneOf("type", &["spherical"]))).remark("a ball holds no moment")]),
    Key::new(
        "collar",
        Kind::Number(BEARING_SIZE),
        "m",
        Need::Optional("the force along the axis is held without friction"),
        "Mean radius of the collar that holds the force along the axis.",
    ).when(&[Condition::new("for type \"revolute\"", Test::Around(&Test::OneOf("type", &["revolute"]))).remark("others hold no force along an axis about which they turn")]),
    Key::new(
        "velocity",
        Kind::Number(Range::positive(1e6)),
        "m/s",
        Need::Default("1e-4"),
        "Velocity `u` of sliding up to which friction grows, as `v / sqrt(v² + u²)`: a bearing that friction holds creeps more slowly than that.",
    ),
];
/// `stop` of a joint with one coordinate.
const STOP: &[Key] = &[LOWER, UPPER, STOP_STIFFNESS, STOP_DAMPING, STOP_OVERLAP];
/// An entry of `stops`.
const STOPS: &[Key] = &[COORDINATE_NUMBER, LOWER, UPPER, STOP_STIFFNESS, STOP_DAMPING, STOP_OVERLAP];

/// An entry of `drives`.
const DRIVES: &[Key] = &[
    COORDINATE_NUMBER,
    Key { need: Need::Required, ..curve("curve", "N, N m", "Force along the coordinate over time.") },
];
/// An entry of `motions`.
const MOTIONS: &[Key] =
    &[COORDINATE_NUMBER, Key { need: Need::Required, ..curve("curve", "m, rad", "Coordinate over time.") }];

const RATIO: Range = Range::within(1e9);

/// `[gears.NAME]`.
pub(super) const GEAR: &[Key] = &[
    Key::new(
        "first",
        Kind::Name,
        "",
        Need::Required,
        "Name of a joint with coordinates, which does not close a loop.",
    ),
    Key::new(
        "first_coordinate",
        Kind::Integer(0, 5),
        "–",
        Need::Optional("that of a joint with a single coordinate"),
        "Number of its coordinate, from 0; none of three angles about a point.",
    ),
    Key::new(
        "second",
        Kind::Name,
        "",
        Need::Required,
        "Name of the other joint; the same one where two of its coordinates move together, as those of a screw.",
    ),
    Key::new(
        "second_coordinate",
        Kind::Integer(0, 5),
        "–",
        Need::Optional("that of a joint with a single coordinate"),
        "Number of its coordinate, from 0.",
    ),
    Key::new(
        "ratio",
        Kind::Number(RATIO),
        "rad/rad, m/rad, rad/m, m/m",
        Need::Required,
        "Rate of the second coordinate by that of the first; not zero. Wheels that mesh outside turn in opposite directions about axes of one \
         direction: the ratio is negative. Of a rack it is the radius of its pinion, of a screw the lead over 2π: `\"5 mm/rev\"`.",
    ),
];

/// `[loads.NAME]`.
pub(super) const LOAD: &[Key] = &[
    Key::new("body", Kind::Name, "", Need::Required, "Name of the body."),
    MARKER,
    HELD_FACE,
    Key {
        need: Need::Optional("`marker` or `face` must be given"),
        doc: "Point in the components of the body's model: [x, y, z], [x, y] or [r, z]; beside `face` where the load acts, on a rigid arm.",
        ..POINT
    },
    HELD_RADIUS,
    COUPLING,
    curve("force_x", "N", "Force along x."),
    curve("force_y", "N", "Force along y."),
    curve("force_z", "N", "Force along z."),
    curve("moment_x", "N m", "Moment about x."),
    curve("moment_y", "N m", "Moment about y."),
    curve("moment_z", "N m", "Moment about z."),
    Key::new(
        "following",
        Kind::Boolean,
        "",
        Need::Default("false"),
        "Whether the axes are those of the body at the place of the load and turn with it; those of space otherwise.",
    ),
];
