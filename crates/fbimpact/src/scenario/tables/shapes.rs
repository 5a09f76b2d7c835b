//! Shapes: their keys, the models that they go with, their markers.

use super::super::keys::{Condition, Key, Kind, Named, Test, name_values, name_variants};
use super::files::{FILE_SHA256, LengthUnit};
use super::gear_tooth;
use super::models::BodyModel;
use super::ranges::{COORDINATE, LENGTH, MAX_DEGREE, TURN};
use iga_core::nurbs::primitives::SphereNet;

const RADIUS: Key = Key::measured("radius", Kind::Number(LENGTH), "m").doc("Radius.");
const ROD_LENGTH: Key = Key::measured("length", Kind::Number(LENGTH), "m").doc("Length over all.");
const INNER_RADIUS: Key = Key::measured("inner_radius", Kind::Number(LENGTH), "m").doc("Inner radius.");
const OUTER_RADIUS: Key =
    Key::measured("outer_radius", Kind::Number(LENGTH), "m").doc("Outer radius, above the inner one.");
const WIDTH: Key = Key::measured("width", Kind::Number(LENGTH), "m").doc("Width over all, along x.");
const HEIGHT: Key = Key::measured("height", Kind::Number(LENGTH), "m").doc("Height over all, along y.");

name_values!(SphereNet {
    Cube: "cube", "one patch of degree 4, singular along twelve arcs; regular at ±x, ±y, ±z";
    Spindle: "spindle", "one patch of degree 2, along the meridians 3; singular on four meridians and at ±y; regular at ±x and ±z";
    Shells: "shells", "seven patches of degree 4, regular everywhere, only continuous between patches";
});

const NET: Key = Key::new("net", Kind::Choice(SphereNet::CHOICES))
    .otherwise("`cube` from degree 4 on and of rigid bodies, `spindle` below")
    .doc("Control net of the ball.")
    .when(&[SPATIAL.remark("a half-disc has one net")]);

/// The body is solid, or rigid and moves in space.
const SPATIAL: Condition = Condition::new(
    "for solid and spatial rigid bodies",
    Test::Around(&Test::Any(&[
        Test::OneOf("model", &["solid"]),
        Test::All(&[Test::OneOf("model", &["rigid"]), Test::OneOf("motion", &["spatial"])]),
    ])),
);

const GEAR_TOOTH: &[Key] =
    &gear_tooth::keys(&[SPATIAL.remark("a plane body has the key \"thickness\" of all of them")]);

const DEGREES: Key = Key::measured("degrees", Kind::Counts(1, MAX_DEGREE), "–")
    .otherwise("`file` or `patches` must be given")
    .doc("Degree a direction.");
const KNOTS: Key = Key::measured("knots", Kind::Lists(COORDINATE), "–")
    .otherwise("`file` or `patches` must be given")
    .doc("Clamped knot vector per direction, over any range.");
const CONTROL_POINTS: Key = Key::measured("control_points", Kind::Points(COORDINATE), "m")
    .otherwise("`file` or `patches` must be given")
    .doc("Control points; the first direction runs fastest.");
const WEIGHTS: Key =
    Key::measured("weights", Kind::List(LENGTH), "–").otherwise("all 1").doc("Weights, one a control point.");
const PATCHES: Key = Key::new("patches", Kind::Tables(PATCH))
    .otherwise("the body is one patch")
    .doc("Patches of a body of several, counted from 0, in any order and sense. Whole faces that are the same spline are joined \
     (docs/own_part.md says when).");
/// `[[bodies.NAME.geometry.patches]]`.
const PATCH: &[Key] = &[DEGREES.required(), KNOTS.required(), CONTROL_POINTS.required(), WEIGHTS];
const NURBS_FILE: Key = Key::new("file", Kind::Name)
    .otherwise("the patches are given inline")
    .doc("XML of G+Smo, NURBS mesh of MFEM, or TOML or JSON with the keys `patches`, or `degrees` to `weights`; relative to the scenario.");

/// The keys of a file with control nets.
pub const NURBS_NET: &[Key] = &[DEGREES, KNOTS, CONTROL_POINTS, WEIGHTS, PATCHES];
/// The same inline.
const NURBS: &[Key] = &[
    NURBS_FILE,
    FILE_SHA256.when(WITH_FILE),
    Key::new("units", Kind::Choice(LengthUnit::CHOICES))
        .otherwise("must be given for files of G+Smo and MFEM")
        .doc("Unit of length of a file of G+Smo or MFEM, which do not say it.")
        .when(WITH_FILE),
    DEGREES.when(SINGLE),
    KNOTS.when(SINGLE),
    CONTROL_POINTS.when(SINGLE),
    WEIGHTS.when(SINGLE),
    PATCHES.when(INLINE),
    Key::new("faces", Kind::NameLists)
        .default("{}")
        .doc("Names for parts of the surface, each a list of faces: `bore = [\"0:xi-\", \"1:xi-\"]`. A body of one patch has the faces `xi-` to \
         `zeta+`, one of several `0:xi-`, `0:xi+`, … of each patch and `surface`, which is all of them."),
];
/// The net is in a file.
const WITH_FILE: &[Condition] = &[Condition::new("beside \"file\"", Test::With("file"))];
/// The net is not in a file.
const INLINE: &[Condition] = &[Condition::new("without \"file\"", Test::Without("file"))];
/// There is one patch, not in a file.
const SINGLE: &[Condition] = &[INLINE[0], Condition::new("without \"patches\"", Test::Without("patches"))];

/// Shapes by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ShapeName {
    /// Ball.
    Sphere,
    /// Ellipsoid.
    Ellipsoid,
    /// Rod with flat ends.
    Rod,
    /// Rod with a hemispherical lower end.
    RodSphericalEnd,
    /// Solid cylinder.
    Cylinder,
    /// Tube.
    HollowCylinder,
    /// Part of a tube.
    TubeSector,
    /// Truncated cone.
    Cone,
    /// Cylinder with hemispheres on both ends.
    Capsule,
    /// Cylinder with a crowned or filleted face.
    RoundedCylinder,
    /// Torus.
    Torus,
    /// Cuboid with rounded edges.
    RoundedBox,
    /// Rectangular plate with a round hole.
    PlateWithHole,
    /// Beam with the section of an L.
    LBeam,
    /// Beam with the section of a T.
    TBeam,
    /// Tooth of a spur gear.
    GearTooth,
    /// Cuboid.
    Box,
    /// Rectangle.
    Rectangle,
    /// Disc.
    Disc,
    /// Patches of one's own.
    Nurbs,
    /// Unbounded rigid plane.
    Plane,
}

name_variants!(ShapeName {
    Sphere: "sphere", "Ball about the origin; an axisymmetric one is a half-disc.",
        elsewhere ["ball"],
        keys &[RADIUS, NET];
    Ellipsoid: "ellipsoid", "Ellipsoid about the origin; an axisymmetric one is half an ellipse, with the first two semi-axes alike.",
        elsewhere ["spheroid"],
        keys &[Key::measured("semi_axes", Kind::Vector(3, LENGTH), "m").doc("Semi-axes along x, y and z.")];
    Rod: "rod", "Rod along z with flat ends, from z = 0.",
        keys &[RADIUS, ROD_LENGTH];
    RodSphericalEnd: "rod-spherical-end", "Rod along z with a hemispherical lower end, whose pole is the origin.",
        keys &[RADIUS, ROD_LENGTH];
    Cylinder: "cylinder", "Solid cylinder along z, from z = 0; an axisymmetric one is the shape `rod`.",
        elsewhere ["shaft"],
        keys &[RADIUS, ROD_LENGTH];
    HollowCylinder: "hollow-cylinder", "Tube along z, from z = 0.",
        elsewhere ["tube", "pipe", "ring", "annulus", "sleeve"],
        keys &[INNER_RADIUS, OUTER_RADIUS, ROD_LENGTH];
    TubeSector: "tube-sector", "Part of a tube along z, from z = 0, half its angle on either side of the x axis.",
        elsewhere ["sector", "partial-tube", "shell-segment", "curved-beam", "arch"],
        keys &[
            INNER_RADIUS,
            OUTER_RADIUS,
            ROD_LENGTH,
            Key::angle("angle", Kind::Number(TURN), "rad")
                .doc("Angle from the face `first` to the face `last`."),
        ];
    Cone: "cone", "Truncated cone along z, from z = 0. Regular throughout, so that its jacket can be touched anywhere; of a pointed one give the \
              radius of its tip.",
        elsewhere ["truncated-cone", "frustum", "conical"],
        keys &[
            Key::measured("radius", Kind::Number(LENGTH), "m").doc("Radius at z = 0."),
            Key::measured("end_radius", Kind::Number(LENGTH), "m").doc("Radius at z = `length`."),
            ROD_LENGTH,
        ];
    Capsule: "capsule", "Cylinder with hemispheres on both ends along z, from z = 0. Longer than twice its radius.",
        elsewhere ["spherocylinder", "stadium", "pill"],
        keys &[RADIUS, ROD_LENGTH];
    RoundedCylinder: "rounded-cylinder", "Cylinder along z whose striking face, at z = 0, may be crowned and have a fillet at its edge; the other end is flat. The pole of \
              the face is the origin.",
        elsewhere ["hammer", "piston", "punch", "drill-bit", "crowned-cylinder"],
        keys &[
            RADIUS,
            ROD_LENGTH,
            Key::measured("crown_radius", Kind::Number(LENGTH), "m")
                .otherwise("the face is flat")
                .doc("Radius of the sphere that the face is part of, not below `radius`; with a fillet above it."),
            Key::measured("fillet_radius", Kind::Number(LENGTH), "m")
                .otherwise("there is an edge")
                .doc("Radius of the fillet between face and jacket, below `radius`."),
        ];
    Torus: "torus", "Torus about the z axis and the origin.",
        elsewhere ["donut", "doughnut", "o-ring"],
        keys &[
            Key::measured("radius", Kind::Number(LENGTH), "m")
                .doc("Radius of the circle on which the middles of the sections lie."),
            Key::measured("tube_radius", Kind::Number(LENGTH), "m")
                .doc("Radius of the sections, below `radius`."),
        ];
    RoundedBox: "rounded-box", "Cuboid about the origin with rounded edges and corners, of degree 4.",
        elsewhere ["filleted-box", "rounded-cuboid"],
        keys &[
            Key::measured("size", Kind::Vector(3, LENGTH), "m").doc("Sizes along x, y and z over all."),
            Key::measured("fillet_radius", Kind::Number(LENGTH), "m")
                .doc("Radius of edges and corners, below half of each size."),
        ];
    PlateWithHole: "plate-with-hole", "Rectangular plate about the origin in the x-y plane with a round hole in its middle.",
        elsewhere ["perforated-plate", "holed-plate", "plate-hole"],
        keys &[
            Key::measured("size", Kind::Vector(2, LENGTH), "m").doc("Sizes along x and y."),
            Key::measured("hole_radius", Kind::Number(LENGTH), "m")
                .doc("Radius of the hole, below half of both sizes."),
            Key::measured("thickness", Kind::Number(LENGTH), "m")
                .otherwise("must be given for solid and spatial rigid bodies")
                .doc("Thickness along z.")
                .when(&[SPATIAL.remark("a plane body has its own key \"thickness\"")]),
        ];
    LBeam: "l-beam", "Beam along z, from z = 0, with the section of an L: a flange along x and a web along y, whose outer edge is the z axis.",
        elsewhere ["angle-profile", "l-profile", "l-section"],
        keys &[
            WIDTH,
            HEIGHT,
            Key::measured("thickness", Kind::Number(LENGTH), "m")
                .doc("Thickness of both, below `width` and `height`."),
            ROD_LENGTH,
        ];
    TBeam: "t-beam", "Beam along z, from z = 0, with the section of a T: a flange along x, whose upper face is y = 0, and a web under its middle.",
        elsewhere ["t-profile", "t-section", "tee"],
        keys &[
            WIDTH,
            HEIGHT,
            Key::measured("flange_thickness", Kind::Number(LENGTH), "m")
                .doc("Thickness of the flange, below `height`."),
            Key::measured("web_thickness", Kind::Number(LENGTH), "m")
                .doc("Thickness of the web, below `width`."),
            ROD_LENGTH,
        ];
    GearTooth: "gear-tooth", "Tooth of a spur gear about the z axis, symmetric about the x axis, with the sector of the rim under it. Its flanks follow involutes to a \
              millionth of the module; they begin at a roll angle of 0.05 rad or at the root circle and are straight below, without a fillet.",
        elsewhere ["tooth", "spur-gear", "involute", "gear"],
        keys GEAR_TOOTH;
    Box: "box", "Cuboid about the origin; of plane models \"rectangle\".",
        elsewhere ["beam", "bar", "cuboid", "block", "brick", "plate", "beam3d", "prism"],
        keys &[Key::measured("size", Kind::Vector(3, LENGTH), "m").doc("Edges along x, y and z.")];
    Rectangle: "rectangle", "Rectangle about the origin.",
        elsewhere ["strip", "quad", "square", "beam2d"],
        keys &[Key::measured("size", Kind::Vector(2, LENGTH), "m").doc("Edges along x and y.")];
    Disc: "disc", "Disc about the origin.",
        elsewhere ["disk", "circle"],
        keys &[RADIUS];
    Nurbs: "nurbs", "Patches of one's own, given by their control nets, inline or from a file.",
        elsewhere ["spline", "b-spline", "iga", "brep"],
        keys NURBS;
    Plane: "plane", "Unbounded rigid plane through the body's position, at rest.",
        elsewhere ["floor", "ground", "wall", "half-space", "halfspace"],
        keys &[];
});

/// A model that a shape goes with, and what of the shape has a name in it.
///
/// Rigid bodies have the shapes of the model whose components their points have: `solid`,
/// `plane-strain` or `axisymmetric`.
#[derive(Debug, Clone, Copy)]
pub struct ModelFacts {
    /// The model.
    pub model: BodyModel,
    /// Names of points.
    pub markers: &'static [&'static str],
    /// Names of faces. A free patch has those of them that bound it.
    pub faces: &'static [&'static str],
}

const fn named(
    model: BodyModel,
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

const TORUS: &[&str] = &["left", "right", "front", "back", "bottom", "top"];
const TORUS_SECTION: &[&str] = &["centre", "bottom", "top", "inner", "outer"];
const SECTOR: &[&str] = &["start", "end", "centre", "bottom", "top", "inner", "outer", "first", "last"];
const PLATE: &[&str] = &["left", "right", "front", "back", "start", "end"];
const PLANE_PLATE: &[&str] = &["left", "right", "bottom", "top", "start", "end"];
const BEAM: &[&str] = &["start", "end", "centre", "bottom", "top", "flange", "web"];

const TOOTH: &[&str] = &["centre", "tip", "bore", "first-flank", "last-flank"];

const SURFACE: &[&str] = &["surface"];
const ROD_FACES: &[&str] = &["z-", "z+", "jacket", "start", "end"];
const TUBE_FACES: &[&str] = &["z-", "z+", "inner", "outer", "start", "end"];
const BOX_FACES: &[&str] = &["x-", "x+", "y-", "y+", "z-", "z+", "start", "end"];
const EDGES: &[&str] = &["x-", "x+", "y-", "y+", "start", "end"];
const SECTOR_FACES: &[&str] = &["z-", "z+", "inner", "outer", "first", "last", "start", "end"];
const PLATE_FACES: &[&str] = &["x-", "x+", "y-", "y+", "z-", "z+", "hole", "start", "end"];
const PLATE_EDGES: &[&str] = &["x-", "x+", "y-", "y+", "hole", "start", "end"];
const L_FACES: &[&str] = &["x-", "x+", "y-", "y+", "z-", "z+", "inside", "start", "end"];
const T_FACES: &[&str] = &["x-", "x+", "y-", "y+", "z-", "z+", "web", "under", "start", "end"];
const TOOTH_FACES: &[&str] =
    &["tip", "first-flank", "last-flank", "root", "bore", "first", "last", "z-", "z+"];
const TOOTH_EDGES: &[&str] = &["tip", "first-flank", "last-flank", "root", "bore", "first", "last"];
const RIM: &[&str] = &["rim"];
const PATCH_FACES: &[&str] = &["xi-", "xi+", "eta-", "eta+", "zeta-", "zeta+"];
const PATCH_EDGES: &[&str] = &["xi-", "xi+", "eta-", "eta+"];

impl ShapeName {
    /// Models that the shape goes with, and what has a name there; markers and faces are those of
    /// `iga_core::nurbs::primitives`.
    pub fn models(self) -> &'static [ModelFacts] {
        use BodyModel::{Axisymmetric, PlaneStrain, PlaneStress, Rigid, Solid};
        match self {
            Self::Sphere | Self::Ellipsoid => {
                const { &[named(Solid, BALL, SURFACE), named(Axisymmetric, HALF_DISC, SURFACE)] }
            }
            Self::Rod | Self::RodSphericalEnd => const { &[named(Axisymmetric, ROD, ROD_FACES)] },
            Self::Cylinder | Self::Cone | Self::Capsule | Self::RoundedCylinder => {
                const { &[named(Solid, CYLINDER, ROD_FACES), named(Axisymmetric, ROD, ROD_FACES)] }
            }
            Self::HollowCylinder => {
                const { &[named(Solid, CYLINDER, TUBE_FACES), named(Axisymmetric, ROD, TUBE_FACES)] }
            }
            Self::TubeSector => const { &[named(Solid, SECTOR, SECTOR_FACES)] },
            Self::Torus => {
                const { &[named(Solid, TORUS, SURFACE), named(Axisymmetric, TORUS_SECTION, SURFACE)] }
            }
            Self::PlateWithHole => {
                const {
                    &[
                        named(Solid, PLATE, PLATE_FACES),
                        named(PlaneStrain, PLANE_PLATE, PLATE_EDGES),
                        named(PlaneStress, PLANE_PLATE, PLATE_EDGES),
                    ]
                }
            }
            Self::LBeam => const { &[named(Solid, BEAM, L_FACES)] },
            Self::TBeam => const { &[named(Solid, BEAM, T_FACES)] },
            Self::GearTooth => {
                const {
                    &[
                        named(Solid, TOOTH, TOOTH_FACES),
                        named(PlaneStrain, TOOTH, TOOTH_EDGES),
                        named(PlaneStress, TOOTH, TOOTH_EDGES),
                    ]
                }
            }
            Self::Box | Self::RoundedBox => const { &[named(Solid, CYLINDER, BOX_FACES)] },
            Self::Rectangle => {
                const { &[named(PlaneStrain, RECTANGLE, EDGES), named(PlaneStress, RECTANGLE, EDGES)] }
            }
            Self::Disc => const { &[named(PlaneStrain, DISC, RIM), named(PlaneStress, DISC, RIM)] },
            Self::Nurbs => {
                const {
                    &[
                        named(Solid, &[], PATCH_FACES),
                        named(Axisymmetric, &[], PATCH_EDGES),
                        named(PlaneStrain, &[], PATCH_EDGES),
                        named(PlaneStress, &[], PATCH_EDGES),
                    ]
                }
            }
            Self::Plane => const { &[named(Rigid, &[], &[])] },
        }
    }

    /// Whether the shape goes with `model`.
    pub fn fits(self, model: BodyModel) -> bool {
        self.in_model(model).is_some()
    }

    /// What has a name in `model`, if the shape goes with it.
    pub fn in_model(self, model: BodyModel) -> Option<&'static ModelFacts> {
        self.models().iter().find(|facts| facts.model == model)
    }
}
