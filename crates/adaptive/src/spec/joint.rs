//! Joints, what acts along their coordinates, and loads.

use ffr_dynamics::system::joints::{Bearing, Friction, JointKind, Stop};
use nalgebra::UnitQuaternion;

use super::body::Place;
use super::time_curve::TimeCurve;

/// A point with axes on a body or on ground.
#[derive(Debug, Clone, PartialEq)]
pub struct Attachment {
    /// Index of the body; `None` is ground, whose places are points in space.
    pub body: Option<usize>,
    /// Where.
    pub place: Place,
    /// Rotation from the attachment's axes to the body's frame (to space on ground).
    pub rotation: UnitQuaternion<f64>,
}

/// A joint between two attachments.
///
/// The coordinates are those of [`JointKind`] in the axes of the attachments: a revolute joint
/// turns about `z`, and so on.
#[derive(Debug, Clone, PartialEq)]
pub struct JointSpec {
    /// Name.
    pub name: String,
    /// Kind.
    pub kind: JointKind,
    /// Nearer to ground.
    pub parent: Attachment,
    /// On the child of the joint.
    pub child: Attachment,
    /// Positions at the start, as many as the joint has (a quaternion has four); not for
    /// loop-closing joints, nor used for prescribed coordinates.
    pub positions: Vec<f64>,
    /// Velocities at the start.
    pub velocities: Vec<f64>,
    /// Whether they are given; others follow where loops are closed.
    pub has_velocities: bool,
    /// Springs, dampers, drives, prescribed motions: one entry a velocity, or none.
    pub coordinates: Vec<CoordinateSpec>,
    /// Friction by the load that the joint transmits.
    pub bearing: Option<Bearing>,
}

/// What acts along one velocity of a joint; N and m, or N m and rad.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct CoordinateSpec {
    /// Spring stiffness.
    pub stiffness: f64,
    /// Coordinate at which the spring is relaxed.
    pub rest: f64,
    /// Damping.
    pub damping: f64,
    /// Ends of the travel.
    pub stop: Option<Stop>,
    /// Dry friction.
    pub friction: Option<Friction>,
    /// Force of a drive over time.
    pub drive: Option<TimeCurve>,
    /// Motion prescribed to the coordinate.
    pub motion: Option<TimeCurve>,
}

/// A gear between coordinates of two joints of the tree, or of one.
#[derive(Debug, Clone, PartialEq)]
pub struct GearSpec {
    /// Name.
    pub name: String,
    /// Index of a joint of the tree, and number of its coordinate.
    pub first: (usize, usize),
    /// The other.
    pub second: (usize, usize),
    /// Rate of the second coordinate by that of the first.
    pub ratio: f64,
}

impl GearSpec {
    /// The second coordinate where the first is zero: both have at the start what their joints say,
    /// whatever that is \[m, rad\].
    pub fn offset(&self, joints: &[JointSpec]) -> f64 {
        let start = |(joint, k): (usize, usize)| {
            let JointSpec { positions, coordinates, .. } = &joints[joint];
            let motion = coordinates.get(k).and_then(|c| c.motion.as_ref());
            motion.map_or_else(
                || positions.get(k).copied().unwrap_or(0.0),
                |motion| motion.function().at(0.0)[0],
            )
        };
        start(self.second) - self.ratio * start(self.first)
    }
}

/// A force and a moment over time.
#[derive(Debug, Clone, PartialEq)]
pub struct LoadSpec {
    /// Name.
    pub name: String,
    /// Where it acts; not on ground.
    pub at: Attachment,
    /// Force along x, y, z \[N\], then moment about them \[N m\].
    pub components: [Option<TimeCurve>; 6],
    /// Whether the axes turn with the attachment; those of space otherwise.
    pub is_following: bool,
}
