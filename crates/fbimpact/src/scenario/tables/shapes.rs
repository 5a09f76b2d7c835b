//! Shapes: their keys, the models that they go with, their markers.

use super::super::keys::{Choice, Condition, Key, Kind, Need, Test, Variant};
use super::files::{FILE_SHA256, UNITS};
use super::ranges::{COORDINATE, LENGTH, MAX_DEGREE};

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
    Need::Optional("`cube` from degree 4 on and of rigid bodies, `spindle` below"),
    "Control net of the ball.",
)
.when(&[Condition::new(
    "for solid and spatial rigid bodies",
    Test::Around(&Test::Any(&[
        Test::OneOf("model", &["solid"]),
        Test::All(&[Test::OneOf("model", &["rigid"]), Test::OneOf("motion", &["spatial"])]),
    ])),
)
.remark("a half-disc has one net")]);

const DEGREES: Key = Key::new(
    "degrees",
    Kind::Counts(1, MAX_DEGREE),
    "–",
    Need::Optional("`file` or `patches` must be given"),
    "Degree a direction.",
);
const KNOTS: Key = Key::new(
    "knots",
    Kind::Lists(COORDINATE),
    "–",
    Need::Optional("`file` or `patches` must be given"),
    "Clamped knot vector per direction, over any range.",
);
const CONTROL_POINTS: Key = Key::new(
    "control_points",
    Kind::Points(COORDINATE),
    "m",
    Need::Optional("`file` or `patches` must be given"),
    "Control points; the first direction runs fastest.",
);
const WEIGHTS: Key =
    Key::new("weights", Kind::List(LENGTH), "–", Need::Optional("all 1"), "Weights, one a control point.");
const PATCHES: Key = Key::new(
    "patches",
    Kind::Tables(PATCH),
    "",
    Need::Optional("the body is one patch"),
    "Patches of a body of several, counted from 0, in any order and sense. Whole faces that are the same spline are joined \
     (docs/own_part.md says when).",
);
const fn required(key: Key) -> Key {
    Key { need: Need::Required, ..key }
}

/// `[[bodies.NAME.geometry.patches]]`.
const PATCH: &[Key] = &[required(DEGREES), required(KNOTS), required(CONTROL_POINTS), WEIGHTS];
const NURBS_FILE: Key = Key::new(
    "file",
    Kind::Name,
    "",
    Need::Optional("the patches are given inline"),
    "XML of G+Smo, NURBS mesh of MFEM, or TOML or JSON with the keys `patches`, or `degrees` to `weights`; relative to the scenario.",
);

/// The keys of a file with control nets.
pub const NURBS_NET: &[Key] = &[DEGREES, KNOTS, CONTROL_POINTS, WEIGHTS, PATCHES];
/// The same inline.
const NURBS: &[Key] = &[
    NURBS_FILE,
    FILE_SHA256.when(WITH_FILE),
    Key::new(
        "units",
        Kind::Choice(UNITS),
        "",
        Need::Optional("must be given for files of G+Smo and MFEM"),
        "Unit of length of a file of G+Smo or MFEM, which do not say it.",
    )
    .when(WITH_FILE),
    DEGREES.when(SINGLE),
    KNOTS.when(SINGLE),
    CONTROL_POINTS.when(SINGLE),
    WEIGHTS.when(SINGLE),
    PATCHES.when(INLINE),
    Key::new(
        "faces",
        Kind::NameLists,
        "",
        Need::Default("{}"),
        "Names for parts of the surface, each a list of faces: `bore = [\"0:xi-\", \"1:xi-\"]`. A body of one patch has the faces `xi-` to \
         `zeta+`, one of several `0:xi-`, `0:xi+`, … of each patch and `surface`, which is all of them.",
    ),
];
/// The net is in a file.
const WITH_FILE: &[Condition] = &[Condition::new("beside \"file\"", Test::With("file"))];
/// The net is not in a file.
const INLINE: &[Condition] = &[Condition::new("without \"file\"", Test::Without("file"))];
/// There is one patch, not in a file.
const SINGLE: &[Condition] = &[INLINE[0], Condition::new("without \"patches\"", Test::Without("patches"))];

/// Shapes by name.
pub(super) const GEOMETRIES: &[Variant] = &[
    Variant {
        name: "sphere",
        elsewhere: &["ball"],
        doc: "Ball about the origin; an axisymmetric one is a half-disc.",
        keys: &[RADIUS, NET],
    },
    Variant {
        name: "ellipsoid",
        elsewhere: &["spheroid"],
        doc: "Ellipsoid about the origin. As a flexible body it can be touched adaptively about the ends of its axes, where its net is regular.",
        keys: &[Key::new(
            "semi_axes",
            Kind::Vector(3, LENGTH),
            "m",
            Need::Required,
            "Semi-axes along x, y and z.",
        )],
    },
    Variant {
        name: "rod",
        elsewhere: &[],
        doc: "Rod along z with flat ends, from z = 0.",
        keys: &[RADIUS, ROD_LENGTH],
    },
    Variant {
        name: "rod-spherical-end",
        elsewhere: &[],
        doc: "Rod along z with a hemispherical lower end, whose pole is the origin.",
        keys: &[RADIUS, ROD_LENGTH],
    },
    Variant {
        name: "cylinder",
        elsewhere: &["shaft"],
        doc: "Solid cylinder along z, from z = 0.",
        keys: &[RADIUS, ROD_LENGTH],
    },
    Variant {
        name: "hollow-cylinder",
        elsewhere: &["tube", "pipe", "ring", "annulus", "sleeve"],
        doc: "Tube along z, from z = 0.",
        keys: &[
            Key::new("inner_radius", Kind::Number(LENGTH), "m", Need::Required, "Inner radius."),
            Key::new("outer_radius", Kind::Number(LENGTH), "m", Need::Required, "Outer radius."),
            ROD_LENGTH,
        ],
    },
    Variant {
        name: "box",
        elsewhere: &["beam", "bar", "cuboid", "block", "brick", "plate", "beam3d", "prism"],
        doc: "Cuboid about the origin.",
        keys: &[Key::new("size", Kind::Vector(3, LENGTH), "m", Need::Required, "Edges along x, y and z.")],
    },
    Variant {
        name: "rectangle",
        elsewhere: &["strip", "quad", "square", "beam2d"],
        doc: "Rectangle about the origin.",
        keys: &[Key::new("size", Kind::Vector(2, LENGTH), "m", Need::Required, "Edges along x and y.")],
    },
    Variant { name: "disc", elsewhere: &["disk", "circle"], doc: "Disc about the origin.", keys: &[RADIUS] },
    Variant {
        name: "nurbs",
        elsewhere: &["spline", "b-spline", "iga", "brep"],
        doc: "Patches of one's own, given by their control nets, inline or from a file.",
        keys: NURBS,
    },
    Variant {
        name: "plane",
        elsewhere: &["floor", "ground", "wall", "half-space", "halfspace"],
        doc: "Unbounded rigid plane through the body's position, at rest.",
        keys: &[],
    },
];

/// What the key tables cannot say about a shape.
#[derive(Debug)]
pub struct ShapeFacts {
    /// Name.
    pub name: &'static str,
    /// Models that it goes with, and what has a name there.
    pub models: &'static [ModelFacts],
}

/// A model that a shape goes with, and what of the shape has a name in it.
///
/// Rigid bodies have the shapes of the model whose components their points have: `solid`, `plane-strain` or `axisymmetric`.
#[derive(Debug, Clone, Copy)]
pub struct ModelFacts {
    /// Name of the model.
    pub model: &'static str,
    /// Names of points.
    pub markers: &'static [&'static str],
    /// Names of faces. A free patch has those of them that bound it.
    pub faces: &'static [&'static str],
}

impl ShapeFacts {
    /// The facts of the shape called `name`.
    pub fn find(name: &str) -> Option<&'static Self> {
        SHAPES.iter().find(|s| s.name == name)
    }

    /// Whether the shape goes with `model`.
    pub fn fits(&self, model: &str) -> bool {
        self.in_model(model).is_some()
    }

    /// What has a name in `model`, if the shape goes with it.
    pub fn in_model(&self, model: &str) -> Option<&'static ModelFacts> {
        self.models.iter().find(|facts| facts.model == model)
    }
}

const fn named(
    model: &'static str,
    markers: &'static [&'static str],
    faces: &'static [&'static str],
) -> ModelFacts {
    ModelFacts { model, markers, faces }
}

const ROD: &[&str] = &["start", "end", "centre", "bottom", "top"];
const HALF_DISC: &[&str] = &["centre", "bottom", "top", "equator"];
const BALL: &[&str] = &["centre", "left", "right", "front", "back", "bottom", "top"];
const CYLINDER: &[&str] = &["start", "end", "centre", "bottom", "top", "left", "right", "front", "back"];
const RECTANGLE: &[&str] = &["centre", "left", "right", "bottom", "top", "start", "end"];
const DISC: &[&str] = &["centre", "left", "right", "bottom", "top"];

const SURFACE: &[&str] = &["surface"];
const ROD_FACES: &[&str] = &["z-", "z+", "jacket", "start", "end"];
const TUBE_FACES: &[&str] = &["z-", "z+", "inner", "outer", "start", "end"];
const BOX_FACES: &[&str] = &["x-", "x+", "y-", "y+", "z-", "z+", "start", "end"];
const EDGES: &[&str] = &["x-", "x+", "y-", "y+", "start", "end"];
const RIM: &[&str] = &["rim"];
const PATCH_FACES: &[&str] = &["xi-", "xi+", "eta-", "eta+", "zeta-", "zeta+"];
const PATCH_EDGES: &[&str] = &["xi-", "xi+", "eta-", "eta+"];

/// Facts of every shape; markers and faces are those of `iga_core::nurbs::primitives`.
pub const SHAPES: &[ShapeFacts] = &[
    ShapeFacts {
        name: "sphere",
        models: &[named("solid", BALL, SURFACE), named("axisymmetric", HALF_DISC, SURFACE)],
    },
    ShapeFacts { name: "ellipsoid", models: &[named("solid", BALL, SURFACE)] },
    ShapeFacts { name: "rod", models: &[named("axisymmetric", ROD, ROD_FACES)] },
    ShapeFacts { name: "rod-spherical-end", models: &[named("axisymmetric", ROD, ROD_FACES)] },
    ShapeFacts { name: "cylinder", models: &[named("solid", CYLINDER, ROD_FACES)] },
    ShapeFacts {
        name: "hollow-cylinder",
        models: &[named("solid", CYLINDER, TUBE_FACES), named("axisymmetric", ROD, TUBE_FACES)],
    },
    ShapeFacts { name: "box", models: &[named("solid", CYLINDER, BOX_FACES)] },
    ShapeFacts {
        name: "rectangle",
        models: &[named("plane-strain", RECTANGLE, EDGES), named("plane-stress", RECTANGLE, EDGES)],
    },
    ShapeFacts {
        name: "disc",
        models: &[named("plane-strain", DISC, RIM), named("plane-stress", DISC, RIM)],
    },
    ShapeFacts {
        name: "nurbs",
        models: &[
            named("solid", &[], PATCH_FACES),
            named("axisymmetric", &[], PATCH_EDGES),
            named("plane-strain", &[], PATCH_EDGES),
            named("plane-stress", &[], PATCH_EDGES),
        ],
    },
    ShapeFacts { name: "plane", models: &[named("rigid", &[], &[])] },
];
