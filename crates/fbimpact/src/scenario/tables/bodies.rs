//! Keys of `[materials.NAME]` and `[bodies.NAME]`.

mod copies;

use super::super::keys::{Condition, Fact, Key, Kind, Named, Range, Test, name_values};
use super::discretisation::{DISCRETISATION, REDUCTION};
use super::files::{FILE_SHA256, LengthUnit};
use super::models::BodyModel;
use super::ranges::{COORDINATE, LENGTH, RATE};
use super::shapes::ShapeName;
use adaptive::spec::Coupling;
use fe_mesh::element::rules::MassRule;
use ffr_dynamics::body::RigidMotion;

use copies::COPIES;
pub use copies::{Arrangement, MOST as MOST_COPIES};

/// What says how copies of a body stand and move.
pub const COPIED: &[Key] = &[COPIES, POSITION, ORIENTATION, VELOCITY, ANGULAR_VELOCITY];

/// `[materials.NAME]`.
pub const MATERIAL: &[Key] = &[
    Key::measured("youngs_modulus", Kind::Number(Range::positive(1e15)), "Pa").doc("Young's modulus."),
    // Thermodynamics allows -1 to 0.5; at 0.5 a displacement model locks and its stiffness is
    // infinite.
    Key::measured("poissons_ratio", Kind::Number(Range::open(-1.0, 0.5)), "–")
        .doc("Poisson's ratio."),
    Key::measured("density", Kind::Number(Range::positive(1e9)), "kg/m³").doc("Density."),
    Key::measured("yield_strength", Kind::Number(Range::positive(1e15)), "Pa")
        .otherwise("nothing is told of yielding")
        .doc("Proof stress in tension: contacts and stresses beyond it are told by the warning `yields`; the run stays elastic."),
];

/// What the reference frame of a body follows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FrameKind {
    /// All of the body.
    Buckens,
    /// The material at a place.
    Tangent,
}

name_values!(FrameKind {
    Buckens: "buckens", "mean-axis frame: elastic coordinates carry no momentum";
    Tangent: "tangent", "the frame follows the material at `frame_marker` or `frame_point`";
});

name_values!(RigidMotion {
    Spatial: "spatial", "three translations, three rotations; points are [x, y, z]";
    Planar: "planar", "in the plane (x, y), turning about z; points are [x, y]";
    Axial: "axial", "along z; points are [r, z]";
});

/// The body is from a file.
const FROM_FILE: Condition = Condition::new(
    "for bodies with model \"imported\" or \"mesh\", and for plane and axisymmetric ones without \"geometry\"",
    Test::Any(&[
        Test::OneOf("model", &["imported", "mesh"]),
        Test::All(&[IS_PLANE, Test::Without("geometry")]),
    ]),
);
/// The model is plane or axisymmetric.
const IS_PLANE: Test = Test::OneOf("model", &["axisymmetric", "plane-strain", "plane-stress"]);
/// The body has a mesh.
pub(super) const IS_MESH: Test =
    Test::Any(&[Test::OneOf("model", &["mesh"]), Test::All(&[IS_PLANE, Test::With("file")])]);
const OF_MESH: Condition = Condition::new("for bodies with a mesh", IS_MESH);
/// The body has a shape by name or of splines.
const WITH_SHAPE: Condition =
    Condition::new("for bodies that are not from a file", Test::NoneOf("model", &["imported", "mesh"]));
/// The body is not from a file.
const NOT_IMPORTED: Condition =
    Condition::new("for bodies that are not \"imported\"", Test::NoneOf("model", &["imported"]));
/// The body is rigid.
const RIGID: Condition = Condition::new("for bodies with model \"rigid\"", Test::OneOf("model", &["rigid"]));
/// The body is flexible.
const FLEXIBLE: Condition = Condition::new("for flexible bodies", Test::NoneOf("model", &["rigid"]));
/// The body has matrices that are reduced.
const TO_REDUCE: &[Condition] =
    &[FLEXIBLE, Condition::new("for bodies that are not reduced already", Test::Fact(Fact::IsNotReduced))];
/// The body has elements.
const MESHED: Condition = Condition::new(
    "for flexible bodies with a shape",
    Test::All(&[Test::NoneOf("model", &["rigid", "imported", "mesh"]), Test::Without("file")]),
);
/// The frame follows a place, which is to be given.
const WITH_ELEMENTS: Condition = Condition::new(
    "for flexible bodies with a shape or a mesh",
    Test::NoneOf("model", &["rigid", "imported"]),
);

const FOLLOWING: &[Condition] = &[
    TO_REDUCE[0],
    TO_REDUCE[1],
    Condition::new("with frame \"tangent\"", Test::OneOf("frame", &["tangent"])),
];
/// The body is bounded and moves.
const NO_PLANE: Condition =
    Condition::new("for shapes other than \"plane\"", Test::NoneOf("geometry.shape", &["plane"]))
        .remark("which is unbounded and at rest");
/// Mass properties that no shape gives.
const OWN_MASS: &[Condition] = &[
    RIGID,
    Condition::new("without \"geometry\"", Test::Without("geometry"))
        .remark("with which it follows from shape and material"),
];
/// The initial motion is the body's own.
const FREE: &[Condition] =
    &[Condition::new("for bodies that are the child of no joint", Test::Fact(Fact::IsChildOfNoJoint))];

/// Where a body stands.
const POSITION: Key = Key::measured("position", Kind::Vector(3, COORDINATE), "m")
    .default("[0.0, 0.0, 0.0]")
    .doc("Initial position of the body's origin.")
    .when(FREE);
/// How it stands.
const ORIENTATION: Key = Key::angle("orientation", Kind::Rotation, "rad")
    .default("[1.0, 0.0, 0.0, 0.0]")
    .doc(
        "Initial orientation: a rotation vector, or a quaternion [w, x, y, z] of unit length. \
     Of a body that is the child of a joint, the one with all joint coordinates at zero.",
    )
    .when(&[
        Condition::new("without \"normal\"", Test::Without("normal")).remark("which says how a plane stands")
    ]);
/// How fast it goes.
const VELOCITY: Key = Key::measured("velocity", Kind::Vector(3, RATE), "m/s")
    .default("[0.0, 0.0, 0.0]")
    .doc("Initial velocity of the body's origin.")
    .when(FREE);
/// How fast it turns.
const ANGULAR_VELOCITY: Key = Key::angle("angular_velocity", Kind::Vector(3, RATE), "rad/s")
    .default("[0.0, 0.0, 0.0]")
    .doc("Initial angular velocity, in space.")
    .when(FREE);

/// `[bodies.NAME]`.
pub const BODY: &[Key] = &[
    Key::new("model", Kind::Choice(BodyModel::CHOICES)).default("\"solid\"").doc("Kinematics of the body."),
    Key::new("material", Kind::Name)
        .otherwise("only `rigid` and `imported` bodies, and a `mesh` all of whose `groups` have one, may have none")
        .doc("Name of a table of `[materials]` or of a standard material (see the end of this page). A rigid body takes its density, Hertz contacts its \
         elastic constants.")
        .when(&[NOT_IMPORTED, Condition::new(
            "for bodies with \"geometry\"",
            Test::Any(&[Test::NoneOf("model", &["rigid"]), Test::With("geometry")]),
        )]),
    Key::new("file", Kind::Name)
        .otherwise("must be given")
        .doc("Body file or mesh, relative to the scenario; of plane and axisymmetric models a mesh in the plane z = 0, with x the radius. Of a body file the markers are those of the body, which has no other places; contacts \
         and stresses need a shape and do not go with either yet.")
        .when(&[FROM_FILE]),
    FILE_SHA256.when(&[FROM_FILE]),
    Key::new("units", Kind::Choice(LengthUnit::CHOICES))
        .otherwise("must be given")
        .doc("Unit of length of the mesh; files do not say it.")
        .when(&[OF_MESH]),
    Key::new("part", Kind::Name)
        .otherwise("the only one")
        .doc("The part of the mesh that is the body: name of an instance or part, of a group of elements, or \"element 7\", all that hangs together \
         with element 7.")
        .when(&[OF_MESH]),
    Key::new("groups", Kind::NamedByFile(GROUP))
        .default("{}")
        .doc("Groups of elements of the mesh that have a material of their own.")
        .when(&[OF_MESH]),
    Key::new("mass_points", Kind::Choice(MassRule::CHOICES))
        .default("\"exact\"")
        .doc("Points by which the mass of the elements is integrated.")
        .when(&[OF_MESH]),
    Key::new("motion", Kind::Choice(RigidMotion::CHOICES))
        .default("\"spatial\"")
        .doc("Motions that the body can make.")
        .when(&[RIGID, NO_PLANE]),
    Key::measured("mass", Kind::Number(Range::positive(1e15)), "kg")
        .otherwise("follows from `geometry` and `material`")
        .doc("Mass.")
        .when(OWN_MASS),
    Key::measured("centre_of_mass", Kind::Vector(3, COORDINATE), "m")
        .otherwise("the origin, or follows from `geometry`")
        .doc("Centre of mass in the frame of the body.")
        .when(OWN_MASS),
    Key::measured("inertia", Kind::Symmetric(Range::within(1e24)), "kg m²")
        .otherwise("follows from `geometry` and `material`; `axial` bodies need none")
        .doc("Inertia about the centre of mass, in the axes of the body's frame.")
        .when(OWN_MASS),
    Key::measured("thickness", Kind::Number(LENGTH), "m")
        .default("1.0")
        .doc("Thickness of a plane model.")
        .when(&[NO_PLANE, Condition::new(
            "for \"plane-strain\", \"plane-stress\" and planar rigid shapes",
            Test::Any(&[
                Test::OneOf("model", &["plane-strain", "plane-stress"]),
                Test::All(&[
                    Test::OneOf("model", &["rigid"]),
                    Test::OneOf("motion", &["planar"]),
                    Test::With("geometry"),
                ]),
            ]),
        )]),
    Key::new("geometry", Kind::Variants { tag: "shape", variants: ShapeName::VARIANTS })
        .otherwise("only `imported` and `mesh` bodies and `rigid` ones with `mass` have none")
        .doc("Shape in the body's own frame.")
        .when(&[WITH_SHAPE]),
    Key::new("markers", Kind::Named(MARKER))
        .default("{}")
        .doc("Named points and parts of the body beside those of its shape, usable wherever a marker can be named.")
        .when(&[NOT_IMPORTED.remark("whose markers are those of the file"), NO_PLANE]),
    Key::new("discretisation", Kind::Table(DISCRETISATION))
        .default("{}")
        .doc("Spline space.")
        .when(&[MESHED]),
    Key::new("reduction", Kind::Table(REDUCTION)).default("{}").doc("Reduced basis.").when(TO_REDUCE),
    Key::new("damping", Kind::Table(DAMPING))
        .otherwise("no damping")
        .doc("Damping of the body's vibrations, by ratios that hold as its joints hold it: a mode at a time, of Rayleigh, or structural.")
        .when(TO_REDUCE),
    Key::new("frame", Kind::Choice(FrameKind::CHOICES))
        .default("\"buckens\"")
        .doc("Reference frame.")
        .when(TO_REDUCE),
    Key::new("frame_marker", Kind::Name)
        .otherwise("the attachment of the joint whose child the body is")
        .doc("Marker that the frame follows, averaged over its extent if it has one.")
        .when(FOLLOWING),
    Key::measured("frame_point", Kind::Point(COORDINATE), "m")
        .otherwise("the attachment of the joint whose child the body is")
        .doc("Point that the frame follows.")
        .when(FOLLOWING),
    Key::new("geometric_stiffening", Kind::Boolean)
        .default("false")
        .doc("Whether inertia forces stiffen the body, as rotors need it; with a `tangent` frame, not for `axisymmetric`. A reduced body \
         file brings its own.")
        .when(&[WITH_ELEMENTS]),
    COPIES,
    POSITION,
    ORIENTATION,
    VELOCITY,
    ANGULAR_VELOCITY,
    Key::measured("normal", Kind::Vector(3, COORDINATE), "–")
        .otherwise("[0, 0, 1], turned by `orientation`")
        .doc("Normal of a plane, out of the material; of any length but zero.")
        .when(&[Condition::new(
            "for the shape \"plane\"",
            Test::OneOf("geometry.shape", &["plane"]),
        )]),
];

name_values!(MassRule {
    Exact: "exact", "exact on straight-sided elements";
    AsStiffness: "as-stiffness", "those of the stiffness, as CalculiX has them in tet10 and wedge15, for comparison";
});

/// `[bodies.NAME.groups.NAME]`.
const GROUP: &[Key] =
    &[Key::new("material", Kind::Name).doc("Name of the material of the group's elements.")];

/// `[bodies.NAME.markers.NAME]`.
const MARKER: &[Key] = &[
    Key::measured("point", Kind::Point(COORDINATE), "m")
        .otherwise("`face` must be given")
        .doc("Point in the components of the body's model: [x, y, z], [x, y] or [r, z]; beside `face` where the marker is, on a rigid arm."),
    RADIUS,
    FACE,
    COUPLING,
];

/// A point stands beside the key.
pub(super) const BESIDE_POINT: Condition =
    Condition::new("beside \"point\" alone", Test::All(&[Test::With("point"), Test::Without("face")]))
        .remark("a face is taken as a whole, and a marker has its own");
/// A part of the body is given beside the key.
pub(super) const BESIDE_PART: Condition =
    Condition::new("beside \"face\" or \"radius\"", Test::Any(&[Test::With("face"), Test::With("radius")]))
        .remark("a marker has its own");
/// Radius of a disc or ball about a point.
pub(super) const RADIUS: Key = Key::measured("radius", Kind::Number(LENGTH), "m")
    .otherwise("no extent")
    .doc("Radius of the part of the body about `point`: a disc on the surface, a ball inside.")
    .when(&[BESIDE_POINT]);
/// A face by name.
pub(super) const FACE: Key = Key::new("face", Kind::Name)
    .otherwise("`point` must be given")
    .doc("Name of a whole face of the shape, such as `x-` (docs/places.md shows them); of a mesh a group of faces or a set.");
/// How a part of a body is held.
pub(super) const COUPLING: Key = Key::new("coupling", Kind::Choice(Coupling::CHOICES))
    .otherwise("`average`")
    .doc("How the part of the body is joined to what holds it.")
    .when(&[BESIDE_PART]);

name_values!(Coupling {
    Average: "average", "distributing (RBE3): motion averaged over the part, force spread over it";
    Rigid: "rigid", "kinematic (RBE2): the part moves like a rigid body, also stiffened by that";
});

/// Damping ratios.
const RATIO: Range = Range::closed(0.0, 1e3);

/// Damping ratios are not given a mode at a time.
const NOT_BY_MODE: Condition = Condition::new("without \"modal\"", Test::Without("modal"));
/// Nor is the loss factor.
const NOT_STRUCTURAL: Condition = Condition::new("without \"loss_factor\"", Test::Without("loss_factor"));
const RAYLEIGH: &[Condition] = &[NOT_BY_MODE, NOT_STRUCTURAL];

const DAMPING: &[Key] = &[
    Key::measured("frequencies", Kind::Vector(2, Range::positive(1e12)), "Hz")
        .otherwise("`modal` or `loss_factor` must be given")
        .doc("Two frequencies between which modes are damped least, the band of the modes that matter.")
        .when(RAYLEIGH),
    Key::measured("ratio", Kind::Number(RATIO), "–")
        .default("1e-3")
        .doc("Damping ratio at both frequencies, 1 being critical; it grows with the frequency above them.")
        .when(RAYLEIGH),
    Key::measured("modal", Kind::Numbers(RATIO), "–")
        .otherwise("`frequencies` or `loss_factor` must be given")
        .doc("Damping ratios of the modes of the body as its joints hold it, one per mode; the last, or a single number, holds for all that \
         follow."),
    Key::measured("loss_factor", Kind::Number(RATIO), "–")
        .otherwise("`modal` or `frequencies` must be given")
        .doc("Structural damping: the loss factor of all modes, which is twice their damping ratio.")
        .when(&[NOT_BY_MODE]),
];
