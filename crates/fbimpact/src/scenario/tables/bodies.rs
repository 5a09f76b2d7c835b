//! Keys of `[materials.NAME]` and `[bodies.NAME]`, and which shape goes with which model.

use super::super::keys::{Bound, Choice, Key, Kind, Need, Range, Variant};

/// Lengths \[m\]: no body is larger than a thousand kilometres.
const LENGTH: Range = Range::positive(1e6);
/// Coordinates \[m\].
const COORDINATE: Range = Range::within(1e6);
/// Speeds [m/s] and rates [rad/s]; linear elasticity ends long before.
const RATE: Range = Range::within(1e6);
/// Highest spline degree, that of `iga_core::knots::MAX_DEGREE`.
const MAX_DEGREE: u64 = iga_core::knots::MAX_DEGREE as u64;
/// Elements a direction; more do not fit into memory in two dimensions.
const MAX_ELEMENTS: u64 = 10_000;

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
    Choice::new("rigid", "rigid and at rest; the shape is `plane`"),
];

const FRAMES: &[Choice] = &[
    Choice::new("buckens", "mean-axis frame: elastic coordinates carry no momentum"),
    Choice::later("tangent"),
];

/// `[bodies.NAME]`.
pub const BODY: &[Key] = &[
    Key::new("model", Kind::Choice(MODELS), "", Need::Default("\"solid\""), "Kinematics of the body."),
    Key::new(
        "material",
        Kind::Name,
        "",
        Need::Optional("only `rigid` bodies have none"),
        "Name of the material.",
    ),
    Key::new(
        "thickness",
        Kind::Number(LENGTH),
        "m",
        Need::Optional("1 m; only for `plane-strain` and `plane-stress`"),
        "Thickness of a plane model.",
    ),
    Key::new(
        "geometry",
        Kind::Variants { tag: "shape", variants: GEOMETRIES },
        "",
        Need::Required,
        "Shape in the body's own frame.",
    ),
    Key::new(
        "discretisation",
        Kind::Table(DISCRETISATION),
        "",
        Need::Default("{}"),
        "Spline space; not for `rigid` bodies.",
    ),
    Key::new(
        "reduction",
        Kind::Table(REDUCTION),
        "",
        Need::Default("{}"),
        "Reduced basis; not for `rigid` bodies.",
    ),
    Key::new(
        "damping",
        Kind::Table(DAMPING),
        "",
        Need::Optional("no damping"),
        "Rayleigh damping of the elastic coordinates; not for `rigid` bodies.",
    ),
    Key::new(
        "frame",
        Kind::Choice(FRAMES),
        "",
        Need::Default("\"buckens\""),
        "Reference frame; not for `rigid` bodies.",
    ),
    Key::new(
        "position",
        Kind::Vector(3, COORDINATE),
        "m",
        Need::Default("[0.0, 0.0, 0.0]"),
        "Initial position of the body's origin.",
    ),
    Key::angle(
        "orientation",
        Kind::Rotation,
        "rad",
        Need::Default("[1.0, 0.0, 0.0, 0.0]"),
        "Initial orientation: a rotation vector, or a quaternion [w, x, y, z] of unit length.",
    ),
    Key::new(
        "velocity",
        Kind::Vector(3, RATE),
        "m/s",
        Need::Default("[0.0, 0.0, 0.0]"),
        "Initial velocity of the body's origin.",
    ),
    Key::angle(
        "angular_velocity",
        Kind::Vector(3, RATE),
        "rad/s",
        Need::Default("[0.0, 0.0, 0.0]"),
        "Initial angular velocity, in space.",
    ),
    Key::new(
        "normal",
        Kind::Vector(3, COORDINATE),
        "–",
        Need::Optional("[0, 0, 1], turned by `orientation`; only for shape `plane`"),
        "Normal of a plane, out of the material; of any length but zero.",
    ),
];

const RADIUS: Key = Key::new("radius", Kind::Number(LENGTH), "m", Need::Required, "Radius.");
const ROD_LENGTH: Key = Key::new("length", Kind::Number(LENGTH), "m", Need::Required, "Length over all.");

const NETS: &[Choice] = &[
    Choice::new("cube", "one patch of degree 4, singular along twelve arcs; regular at ±x, ±y, ±z"),
    Choice::new(
        "spindle",
        "one patch of degree 2, singular on four meridians and at ±y; regular at ±x and ±z",
    ),
    Choice::new("shells", "seven patches of degree 4, regular everywhere, only continuous between patches"),
];

const NET: Key = Key::new(
    "net",
    Kind::Choice(NETS),
    "",
    Need::Optional("`cube` from degree 4 on, `spindle` below; a half-disc has one net only"),
    "Control net of a solid ball.",
);

const DEGREES: Key = Key::new(
    "degrees",
    Kind::Counts(1, MAX_DEGREE),
    "–",
    Need::Optional("`file` must be given"),
    "Degree a direction.",
);
const KNOTS: Key = Key::new(
    "knots",
    Kind::Lists(COORDINATE),
    "–",
    Need::Optional("`file` must be given"),
    "Clamped knot vector a direction.",
);
const CONTROL_POINTS: Key = Key::new(
    "control_points",
    Kind::Points(COORDINATE),
    "m",
    Need::Optional("`file` must be given"),
    "Control points; the first direction runs fastest.",
);
const WEIGHTS: Key =
    Key::new("weights", Kind::List(LENGTH), "–", Need::Optional("all 1"), "Weights, one a control point.");
const NURBS_FILE: Key = Key::new(
    "file",
    Kind::Name,
    "",
    Need::Optional("the net is given inline"),
    "TOML or JSON file with the same keys, relative to the scenario.",
);

/// The keys of a NURBS patch in a file.
pub const NURBS_NET: &[Key] = &[DEGREES, KNOTS, CONTROL_POINTS, WEIGHTS];
/// The same inline.
const NURBS: &[Key] = &[NURBS_FILE, DEGREES, KNOTS, CONTROL_POINTS, WEIGHTS];

const GEOMETRIES: &[Variant] = &[
    Variant {
        name: "sphere",
        doc: "Ball about the origin; an axisymmetric one is a half-disc.",
        keys: &[RADIUS, NET],
    },
    Variant { name: "rod", doc: "Rod along z with flat ends, from z = 0.", keys: &[RADIUS, ROD_LENGTH] },
    Variant {
        name: "rod-spherical-end",
        doc: "Rod along z with a hemispherical lower end, whose pole is the origin.",
        keys: &[RADIUS, ROD_LENGTH],
    },
    Variant { name: "cylinder", doc: "Solid cylinder along z, from z = 0.", keys: &[RADIUS, ROD_LENGTH] },
    Variant {
        name: "hollow-cylinder",
        doc: "Tube along z, from z = 0.",
        keys: &[
            Key::new("inner_radius", Kind::Number(LENGTH), "m", Need::Required, "Inner radius."),
            Key::new("outer_radius", Kind::Number(LENGTH), "m", Need::Required, "Outer radius."),
            ROD_LENGTH,
        ],
    },
    Variant {
        name: "box",
        doc: "Cuboid about the origin.",
        keys: &[Key::new("size", Kind::Vector(3, LENGTH), "m", Need::Required, "Edges along x, y and z.")],
    },
    Variant {
        name: "rectangle",
        doc: "Rectangle about the origin.",
        keys: &[Key::new("size", Kind::Vector(2, LENGTH), "m", Need::Required, "Edges along x and y.")],
    },
    Variant { name: "disc", doc: "Disc about the origin.", keys: &[RADIUS] },
    Variant { name: "nurbs", doc: "A patch given by its control net, inline or from a file.", keys: NURBS },
    Variant { name: "plane", doc: "Unbounded rigid plane through the body's position.", keys: &[] },
];

/// What the key tables cannot say about a shape.
#[derive(Debug)]
pub struct ShapeFacts {
    /// Name.
    pub name: &'static str,
    /// Models that it goes with, and the names of its points there.
    pub models: &'static [ModelFacts],
}

/// A model that a shape goes with, and the markers of the shape in it; `None` if they are not known before it is built.
pub type ModelFacts = (&'static str, Option<&'static [&'static str]>);

impl ShapeFacts {
    /// The facts of the shape called `name`.
    pub fn find(name: &str) -> Option<&'static Self> {
        SHAPES.iter().find(|s| s.name == name)
    }

    /// Whether the shape goes with `model`.
    pub fn fits(&self, model: &str) -> bool {
        self.models.iter().any(|(m, _)| *m == model)
    }

    /// Markers of the shape in `model`.
    pub fn markers(&self, model: &str) -> Option<&'static [&'static str]> {
        self.models.iter().find(|(m, _)| *m == model).and_then(|(_, markers)| *markers)
    }
}

const ROD: Option<&[&str]> = Some(&["start", "end", "centre", "bottom", "top"]);
const HALF_DISC: Option<&[&str]> = Some(&["centre", "bottom", "top", "equator"]);
const BALL: Option<&[&str]> = Some(&["centre", "left", "right", "front", "back", "bottom", "top"]);
const CYLINDER: Option<&[&str]> =
    Some(&["start", "end", "centre", "bottom", "top", "left", "right", "front", "back"]);
const RECTANGLE: Option<&[&str]> = Some(&["centre", "left", "right", "bottom", "top", "start", "end"]);
const DISC: Option<&[&str]> = Some(&["centre", "left", "right", "bottom", "top"]);

/// Facts of every shape; the markers are those of `iga_core::nurbs::primitives`.
pub const SHAPES: &[ShapeFacts] = &[
    ShapeFacts { name: "sphere", models: &[("solid", BALL), ("axisymmetric", HALF_DISC)] },
    ShapeFacts { name: "rod", models: &[("axisymmetric", ROD)] },
    ShapeFacts { name: "rod-spherical-end", models: &[("axisymmetric", ROD)] },
    ShapeFacts { name: "cylinder", models: &[("solid", CYLINDER)] },
    ShapeFacts { name: "hollow-cylinder", models: &[("solid", CYLINDER), ("axisymmetric", ROD)] },
    ShapeFacts { name: "box", models: &[("solid", CYLINDER)] },
    ShapeFacts { name: "rectangle", models: &[("plane-strain", RECTANGLE), ("plane-stress", RECTANGLE)] },
    ShapeFacts { name: "disc", models: &[("plane-strain", DISC), ("plane-stress", DISC)] },
    ShapeFacts {
        name: "nurbs",
        models: &[("solid", None), ("axisymmetric", None), ("plane-strain", None), ("plane-stress", None)],
    },
    ShapeFacts { name: "plane", models: &[("rigid", Some(&[]))] },
];

const DAMPING: &[Key] = &[
    Key::new(
        "frequencies",
        Kind::Vector(2, Range::positive(1e12)),
        "Hz",
        Need::Required,
        "Two frequencies between which modes are damped least, the band of the modes that matter.",
    ),
    Key::new(
        "ratio",
        Kind::Number(Range { min: Bound::Closed(0.0), max: Bound::Closed(1e3) }),
        "–",
        Need::Default("1e-3"),
        "Damping ratio at both frequencies, 1 being critical; it grows with the frequency above them.",
    ),
];

const DISCRETISATION: &[Key] = &[
    Key::new(
        "degree",
        Kind::Counts(1, MAX_DEGREE),
        "–",
        Need::Default("3"),
        "Spline degree; raised to that of the exact geometry where it is lower.",
    ),
    Key::new(
        "elements",
        Kind::Counts(1, MAX_ELEMENTS),
        "–",
        Need::Default("8"),
        "Uniform elements a direction, before refinement.",
    ),
    Key::new(
        "knots",
        Kind::Lists(Range { min: Bound::Open(0.0), max: Bound::Open(1.0) }),
        "–",
        Need::Optional("uniform knots from `elements`"),
        "Interior knots a direction, which take the place of `elements`.",
    ),
    Key::new(
        "refine",
        Kind::Tables(REFINE),
        "",
        Need::Default("[]"),
        "Zones of small elements, from which elements grow geometrically.",
    ),
];

const REFINE: &[Key] = &[
    Key::new(
        "marker",
        Kind::Name,
        "",
        Need::Optional("`point` must be given"),
        "Named point of the shape in the middle of the zone.",
    ),
    Key::new(
        "point",
        Kind::Point(COORDINATE),
        "m",
        Need::Optional("`marker` must be given"),
        "Point in the middle of the zone, in the components of the model: [x, y, z], [x, y] or [r, z].",
    ),
    Key::new(
        "width",
        Kind::Number(LENGTH),
        "m",
        Need::Required,
        "Width of the zone along the surface. On the axis of an axisymmetric model it is counted from the axis.",
    ),
    Key::new(
        "elements",
        Kind::Integer(1, MAX_ELEMENTS),
        "–",
        Need::Default("16"),
        "Elements across the width.",
    ),
    Key::new(
        "ratio",
        Kind::Number(Range { min: Bound::Open(1.0), max: Bound::Closed(100.0) }),
        "–",
        Need::Default("1.5"),
        "Largest ratio of neighbouring elements outside the zone.",
    ),
];

const METHODS: &[Choice] = &[
    Choice::new("craig-bampton", "free modes, and the static answer of the contact zone"),
    Choice::new("modal", "free modes alone; local deformation at the contact is lost"),
    Choice::new("all", "every mode of the full model, for verification"),
];

const REDUCTION: &[Key] = &[
    Key::new("method", Kind::Choice(METHODS), "", Need::Default("\"craig-bampton\""), "Reduction method."),
    Key::new(
        "modes",
        Kind::Integer(1, 100_000),
        "–",
        Need::Default("20"),
        "Number of elastic modes with dynamics; without meaning for `all`.",
    ),
    Key::new(
        "fixed_interface_modes",
        Kind::Integer(1, 100_000),
        "–",
        Need::Optional("`modes`, the rigid ones and a margin"),
        "Number of fixed-interface modes of `craig-bampton`.",
    ),
];
