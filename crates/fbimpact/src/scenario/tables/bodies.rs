//! Keys of `[materials.NAME]` and `[bodies.NAME]`.

use super::super::keys::{Bound, Choice, Key, Kind, Need, Range};
use super::discretisation::{DISCRETISATION, REDUCTION};
use super::ranges::{COORDINATE, LENGTH, RATE};
use super::shapes::GEOMETRIES;

/// `[materials.NAME]`.
pub const MATERIAL: &[Key] = &[
    Key::new("youngs_modulus", Kind::Number(Range::positive(1e15)), "Pa", Need::Required, "Young's modulus."),
    Key::new(
        "poissons_ratio",
        // Thermodynamics allows -1 to 0.5; at 0.5 a displacement model locks and its stiffness is infinite.
        Kind::Number(Range { min: Bound::Open(-1.0), max: Bound::Open(0.5) }),
        "–",
        Need::Required,
        "Poisson's ratio.",
    ),
    Key::new("density", Kind::Number(Range::positive(1e9)), "kg/m³", Need::Required, "Density."),
];

const MODELS: &[Choice] = &[
    Choice::new("solid", "three-dimensional, in (x, y, z)"),
    Choice::new("axisymmetric", "rotationally symmetric about z, in (r, z); moves along z only"),
    Choice::new("plane-strain", "plane strain in (x, y)"),
    Choice::new("plane-stress", "plane stress in (x, y)"),
    Choice::new("imported", "from the body file `file`, reduced or to be reduced (docs/body-file.md)"),
    Choice::new("rigid", "rigid; with the shape `plane` also at rest"),
];

const FRAMES: &[Choice] = &[
    Choice::new("buckens", "mean-axis frame: elastic coordinates carry no momentum"),
    Choice::new("tangent", "the frame follows the material at `frame_marker` or `frame_point`"),
];

const MOTIONS: &[Choice] = &[
    Choice::new("spatial", "three translations, three rotations; points are [x, y, z]"),
    Choice::new("planar", "in the plane (x, y), turning about z; points are [x, y]"),
    Choice::new("axial", "along z; points are [r, z]"),
];

/// `[bodies.NAME]`.
pub const BODY: &[Key] = &[
    Key::new("model", Kind::Choice(MODELS), "", Need::Default("\"solid\""), "Kinematics of the body."),
    Key::new(
        "material",
        Kind::Name,
        "",
        Need::Optional("only `rigid` and `imported` bodies may have none"),
        "Name of the material. A rigid body takes its density, Hertz contacts its elastic constants.",
    ),
    Key::new(
        "file",
        Kind::Name,
        "",
        Need::Optional("only `imported` bodies have one"),
        "Body file of an `imported` body, relative to the scenario. Its markers are those of the body, which has no other \
         places; contacts and stresses need a shape and do not go with it.",
    ),
    Key::new(
        "file_sha256",
        Kind::Name,
        "",
        Need::Optional("any"),
        "SHA-256 that `file` must have, in hexadecimal digits; the resolved scenario of a result holds it.",
    ),
    Key::new(
        "motion",
        Kind::Choice(MOTIONS),
        "",
        Need::Default("\"spatial\""),
        "Motions that a `rigid` body can make.",
    ),
    Key::new(
        "mass",
        Kind::Number(Range::positive(1e15)),
        "kg",
        Need::Optional("follows from `geometry` and `material`"),
        "Mass of a `rigid` body without `geometry`.",
    ),
    Key::new(
        "centre_of_mass",
        Kind::Vector(3, COORDINATE),
        "m",
        Need::Optional("the origin, or follows from `geometry`"),
        "Centre of mass of a `rigid` body without `geometry`, in its frame.",
    ),
    Key::new(
        "inertia",
        Kind::Symmetric(Range::within(1e24)),
        "kg m²",
        Need::Optional("follows from `geometry` and `material`; `axial` bodies need none"),
        "Inertia of a `rigid` body without `geometry` about its centre of mass, in the axes of its frame.",
    ),
    Key::new(
        "thickness",
        Kind::Number(LENGTH),
        "m",
        Need::Optional("1 m; only for `plane-strain`, `plane-stress` and planar rigid shapes"),
        "Thickness of a plane model.",
    ),
    Key::new(
        "geometry",
        Kind::Variants { tag: "shape", variants: GEOMETRIES },
        "",
        Need::Optional("only `imported` bodies and `rigid` ones with `mass` have none"),
        "Shape in the body's own frame.",
    ),
    Key::new(
        "markers",
        Kind::Named(MARKER),
        "",
        Need::Default("{}"),
        "Named points and parts of the body beside those of its shape, usable wherever a marker can be named; not for \
         `imported` bodies.",
    ),
    Key::new(
        "discretisation",
        Kind::Table(DISCRETISATION),
        "",
        Need::Default("{}"),
        "Spline space; not for `rigid` and `imported` bodies.",
    ),
    Key::new(
        "reduction",
        Kind::Table(REDUCTION),
        "",
        Need::Default("{}"),
        "Reduced basis; not for `rigid` bodies and reduced body files.",
    ),
    Key::new(
        "damping",
        Kind::Table(DAMPING),
        "",
        Need::Optional("no damping"),
        "Damping of the elastic coordinates, of Rayleigh or a mode at a time; not for `rigid` bodies and reduced body \
         files.",
    ),
    Key::new(
        "frame",
        Kind::Choice(FRAMES),
        "",
        Need::Default("\"buckens\""),
        "Reference frame; not for `rigid` bodies and reduced body files, which have theirs.",
    ),
    Key::new(
        "frame_marker",
        Kind::Name,
        "",
        Need::Optional("the attachment of the joint on which the body hangs"),
        "Marker that a `tangent` frame follows, averaged over its extent if it has one.",
    ),
    Key::new(
        "frame_point",
        Kind::Point(COORDINATE),
        "m",
        Need::Optional("the attachment of the joint on which the body hangs"),
        "Point that a `tangent` frame follows.",
    ),
    Key::new(
        "geometric_stiffening",
        Kind::Boolean,
        "",
        Need::Default("false"),
        "Whether inertia forces stiffen the body, as rotors need it; with a `tangent` frame, not for `axisymmetric` and \
         `imported`; a reduced body file brings its own.",
    ),
    Key::new(
        "position",
        Kind::Vector(3, COORDINATE),
        "m",
        Need::Default("[0.0, 0.0, 0.0]"),
        "Initial position of the body's origin; not for bodies that hang on a joint.",
    ),
    Key::angle(
        "orientation",
        Kind::Rotation,
        "rad",
        Need::Default("[1.0, 0.0, 0.0, 0.0]"),
        "Initial orientation: a rotation vector, or a quaternion [w, x, y, z] of unit length. \
         Of a body that hangs on a joint, the one with all joint coordinates at zero.",
    ),
    Key::new(
        "velocity",
        Kind::Vector(3, RATE),
        "m/s",
        Need::Default("[0.0, 0.0, 0.0]"),
        "Initial velocity of the body's origin; not for bodies that hang on a joint.",
    ),
    Key::angle(
        "angular_velocity",
        Kind::Vector(3, RATE),
        "rad/s",
        Need::Default("[0.0, 0.0, 0.0]"),
        "Initial angular velocity, in space; not for bodies that hang on a joint.",
    ),
    Key::new(
        "normal",
        Kind::Vector(3, COORDINATE),
        "–",
        Need::Optional("[0, 0, 1], turned by `orientation`; only for shape `plane`"),
        "Normal of a plane, out of the material; of any length but zero.",
    ),
];

/// `[bodies.NAME.markers.NAME]`.
const MARKER: &[Key] = &[
    Key::new(
        "point",
        Kind::Point(COORDINATE),
        "m",
        Need::Optional("`face` must be given"),
        "Point in the components of the body's model: [x, y, z], [x, y] or [r, z].",
    ),
    RADIUS,
    FACE,
    COUPLING,
];

/// Radius of a disc or ball about a point.
pub(super) const RADIUS: Key = Key::new(
    "radius",
    Kind::Number(LENGTH),
    "m",
    Need::Optional("no extent"),
    "Radius of the part of the body about `point`: a disc on the surface, a ball inside.",
);
/// A face by name.
pub(super) const FACE: Key = Key::new(
    "face",
    Kind::Name,
    "",
    Need::Optional("`point` must be given"),
    "Name of a whole face of the shape, such as `x-` (docs/places.md shows them).",
);
/// How a part of a body is held.
pub(super) const COUPLING: Key = Key::new(
    "coupling",
    Kind::Choice(COUPLINGS),
    "",
    Need::Optional("`average`; needs `face` or `radius` beside it"),
    "How the part of the body hangs together with what holds it.",
);

const COUPLINGS: &[Choice] = &[
    Choice::new("average", "distributing (RBE3): motion averaged over the part, force spread over it"),
    Choice::new("rigid", "kinematic (RBE2): the part moves like a rigid body, also stiffened by that"),
];

/// Damping ratios.
const RATIO: Range = Range { min: Bound::Closed(0.0), max: Bound::Closed(1e3) };

const DAMPING: &[Key] = &[
    Key::new(
        "frequencies",
        Kind::Vector(2, Range::positive(1e12)),
        "Hz",
        Need::Optional("`modal` must be given"),
        "Two frequencies between which modes are damped least, the band of the modes that matter.",
    ),
    Key::new(
        "ratio",
        Kind::Number(RATIO),
        "–",
        Need::Default("1e-3"),
        "Damping ratio at both frequencies, 1 being critical; it grows with the frequency above them.",
    ),
    Key::new(
        "modal",
        Kind::Numbers(RATIO),
        "–",
        Need::Optional("`frequencies` must be given"),
        "Damping ratios, one a mode; the last, or a single number, holds for all that follow.",
    ),
];
