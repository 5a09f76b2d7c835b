//! What the user says about a system: bodies, markers, joints, loads, by name.

use nalgebra::Vector3;

use crate::body::StandardInputData;
use crate::kinematics::Marker;
use crate::system::joints::{Bearing, CoordinateForce, JointKind, TimeFunction};

/// Name of the body that does not move.
pub const GROUND: &str = "ground";

/// A body with the markers that joints and loads refer to.
#[derive(Debug, Clone)]
pub struct BodySpec {
    /// Name; not [`GROUND`].
    pub name: String,
    /// Inertia, modes, stiffness, damping.
    pub data: StandardInputData,
    /// Markers; one without elastic coordinates sits on the body's frame and does not feel the
    /// deformation.
    pub markers: Vec<Marker>,
}

/// A marker, by name.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Attachment {
    /// Name of a body, or [`GROUND`].
    pub body: String,
    /// Name of one of its markers.
    pub marker: String,
}

impl Attachment {
    /// Marker `marker` of body `body`.
    pub fn new(body: &str, marker: &str) -> Self {
        Self { body: body.to_string(), marker: marker.to_string() }
    }
}

/// A joint between two markers.
#[derive(Debug, Clone)]
pub struct JointSpec {
    /// Name.
    pub name: String,
    /// Kind.
    pub kind: JointKind,
    /// Marker on the body nearer to ground.
    pub parent: Attachment,
    /// Marker on the child of the joint.
    pub child: Attachment,
    /// Springs, dampers, drives, prescribed motion: one entry a velocity of the joint, or none at
    /// all.
    pub coordinates: Vec<CoordinateForce>,
    /// Friction by the load that the joint transmits.
    pub bearing: Option<Bearing>,
}

impl JointSpec {
    /// A joint without forces of its own.
    pub fn new(name: &str, kind: JointKind, parent: Attachment, child: Attachment) -> Self {
        Self { name: name.to_string(), kind, parent, child, coordinates: Vec::new(), bearing: None }
    }
}

/// A gear between two joint coordinates of the tree: `second = offset + ratio first`.
#[derive(Debug, Clone, PartialEq)]
pub struct GearSpec {
    /// Name.
    pub name: String,
    /// Joint of the first coordinate, and its number.
    pub first: (String, usize),
    /// Joint of the second coordinate, and its number.
    pub second: (String, usize),
    /// Rate of the second coordinate by that of the first.
    pub ratio: f64,
    /// Second coordinate where the first is zero [m or rad].
    pub offset: f64,
}

/// A force and a moment that act on a marker over time.
#[derive(Debug, Clone)]
pub struct LoadSpec {
    /// Name.
    pub name: String,
    /// Where it acts.
    pub at: Attachment,
    /// Force along x, y, z \[N\], then moment about them \[N m\]; derivatives are not used.
    pub components: [Option<TimeFunction>; 6],
    /// Whether the axes turn with the marker; otherwise they are those of the inertial frame.
    pub is_following: bool,
}

/// A multibody system by name.
///
/// A body that is the child of no joint moves freely relative to the inertial frame, in the rigid
/// motions of its model: its joint has the body's name and leads from the inertial frame to the
/// body's frame.
#[derive(Debug, Clone, Default)]
pub struct SystemSpec {
    /// Bodies.
    pub bodies: Vec<BodySpec>,
    /// Markers on ground.
    pub ground: Vec<Marker>,
    /// Joints of the tree.
    pub joints: Vec<JointSpec>,
    /// Loop-closing joints.
    pub loops: Vec<JointSpec>,
    /// Gears.
    pub gears: Vec<GearSpec>,
    /// Loads.
    pub loads: Vec<LoadSpec>,
    /// Gravity [m/s²].
    pub gravity: Vector3<f64>,
}
