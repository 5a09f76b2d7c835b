//! Shapes: their keys, the models that they go with, their markers.

use super::super::keys::{Choice, Key, Kind, Need, Variant};
use super::bodies::{COORDINATE, LENGTH, MAX_DEGREE};

const RADIUS: Key = Key::new("radius", Kind::Number(LENGTH), "m", Need::Required, "Radius.");
const ROD_LENGTH: Key = Key::new("length", Kind::Number(LENGTH), "m", Need::Required, "Length over all.");

const NETS: &[Choice] = &[
    Choice::new("cube", "one patch of degree 4, singular along twelve arcs; regular at ±x, ±y, ±z"),
    Choice::new(
        "spindle",
        "one patch of degree 2, along the meridians 3; singular on four meridians and at ±y; regular at ±x and ±z",
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

/// Shapes by name.
pub(super) const GEOMETRIES: &[Variant] = &[
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
    Variant { name: "plane", doc: "Unbounded rigid plane through the body's position, at rest.", keys: &[] },
];

/// What the key tables cannot say about a shape.
#[derive(Debug)]
pub struct ShapeFacts {
    /// Name.
    pub name: &'static str,
    /// Models that it goes with, and the names of its points there.
    pub models: &'static [ModelFacts],
}

/// A model that a shape goes with, and the markers of the shape in it; `None` if it has none of its own.
///
/// Rigid bodies have the shapes of the model whose components their points have: `solid`, `plane-strain` or `axisymmetric`.
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
