//! Where everything stands at the start, before any model is built: bodies, both sides of every
//! joint, loads, first touches.

use ffr_dynamics::body::RigidMotion;
use ffr_dynamics::force::BodyState;
use ffr_dynamics::system::{FreeDirections, JointKind};
use nalgebra::{UnitQuaternion, Vector3};

use super::BodyModel;
use crate::error::AdaptiveError;
use crate::sizing::zone::{PredictedZone, predicted_zone};
use crate::spec::{Attachment, ContactSpec, JointSpec, Place, RunSpec, Target};
use crate::surface::SurfacePlace;
use crate::system::start::{poses, rigid_models};
use crate::touch::first::FirstTouches;

/// A place with axes in space.
#[derive(Debug, Clone, PartialEq)]
pub struct PlacedMarker {
    /// Index of its body; `None` is ground.
    pub body: Option<usize>,
    /// Where \[m\].
    pub point: Vector3<f64>,
    /// From its axes to space.
    pub axes: UnitQuaternion<f64>,
}

/// A joint in space.
#[derive(Debug, Clone, PartialEq)]
pub struct PlacedJoint {
    /// Name.
    pub name: String,
    /// Kind.
    pub kind: JointKind,
    /// Whether it closes a loop.
    pub closes_loop: bool,
    /// The side on the parent.
    pub parent: PlacedMarker,
    /// The side on the child.
    pub child: PlacedMarker,
}

impl PlacedJoint {
    /// Distance of the two sides \[m\].
    pub fn distance(&self) -> f64 {
        (self.child.point - self.parent.point).norm()
    }

    /// The part of the distance along the directions that the joint holds: zero where it is closed
    /// \[m\].
    pub fn held_distance(&self) -> f64 {
        let apart = self.parent.axes.inverse_transform_vector(&(self.child.point - self.parent.point));
        self.kind.held_directions().iter().map(|&k| apart[k] * apart[k]).sum::<f64>().sqrt()
    }

    /// Angle between the axes of the two sides \[rad\].
    pub fn angle(&self) -> f64 {
        self.parent.axes.angle_to(&self.child.axes)
    }

    /// Largest angle by which axes that the joint keeps perpendicular are not \[rad\].
    pub fn held_angle(&self) -> f64 {
        let axis = |of: &PlacedMarker, k: usize| of.axes * Vector3::ith(k, 1.0);
        let angle = |&(p, c): &(usize, usize)| {
            axis(&self.parent, p).dot(&axis(&self.child, c)).clamp(-1.0, 1.0).asin().abs()
        };
        self.kind.perpendicular_axes().iter().map(angle).fold(0.0, f64::max)
    }

    /// Axes that the joint turns about or moves along, in space; a plane's is its normal.
    pub fn directions(&self) -> Vec<Vector3<f64>> {
        match self.kind {
            JointKind::Revolute
            | JointKind::Prismatic
            | JointKind::Cylindrical
            | JointKind::Planar
            | JointKind::Axial => vec![self.parent.axes * Vector3::z()],
            JointKind::Universal => vec![self.parent.axes * Vector3::x(), self.child.axes * Vector3::y()],
            JointKind::Fixed | JointKind::Spherical | JointKind::Free => Vec::new(),
            JointKind::Generic(FreeDirections(free)) => {
                let axis = |axes: &UnitQuaternion<f64>, k: usize| axes * Vector3::ith(k, 1.0);
                let moves = (0..3).filter(|&k| free[k]).map(|k| axis(&self.parent.axes, k));
                let turning: Vec<usize> = (0..3).filter(|&k| free[3 + k]).collect();
                let turns = match *turning {
                    [one] => vec![axis(&self.parent.axes, one)],
                    [first, second] => vec![axis(&self.parent.axes, first), axis(&self.child.axes, second)],
                    _ => Vec::new(), // none, or all
                };
                moves.chain(turns).collect()
            }
        }
    }
}

/// The first touch of a contact as shapes and motions at the start have it.
#[derive(Debug, Clone, PartialEq)]
pub struct PlacedTouch {
    /// Where the contact body is nearest to its target \[m\].
    pub on_body: Vector3<f64>,
    /// Where the target is nearest \[m\].
    pub on_target: Vector3<f64>,
    /// Normal of the gap, towards the contact body; a unit vector, zero where the bodies touch and
    /// none is known.
    pub normal: Vector3<f64>,
    /// What Hertz's theory predicts of the impact, where it has an answer.
    pub zone: Option<PredictedZone>,
}

impl PlacedTouch {
    /// Where the bodies of `contact` are nearest, and what its first touch is going to be; `None`
    /// where a body has no surface to touch, and by Hertz's law.
    pub fn new(touches: &FirstTouches<'_>, contact: &ContactSpec) -> Option<Self> {
        contact.law.surface()?;
        let at = |body: usize, site: &SurfacePlace| {
            let (pose, motion) = (&touches.poses[body], touches.spec.bodies[body].kind.motion());
            pose.position + pose.rotation * motion.in_space(&site.point)
        };
        let sites = touches.at_start(contact)?.ok()?;
        let on_body = at(contact.body, &sites.contact_body);
        let (on_target, normal) = match contact.target {
            Target::Body(other) => {
                let on_target = at(other, &sites.target?);
                let apart = on_body - on_target;
                let is_apart = apart.norm() > f64::MIN_POSITIVE.sqrt();
                (on_target, if is_apart { apart.normalize() } else { Vector3::zeros() })
            }
            Target::Plane(plane) => (plane.foot(&on_body), plane.normal.into_inner()),
        };
        Some(Self { on_body, on_target, normal, zone: predicted_zone(touches, contact) })
    }
}

/// Bodies, joints and loads in space at the start.
#[derive(Debug, Clone)]
pub struct Arrangement {
    /// Motions of the bodies if they were rigid.
    pub poses: Vec<BodyState>,
    /// Joints of the tree, then those that close loops.
    pub joints: Vec<PlacedJoint>,
    /// Where loads act.
    pub loads: Vec<PlacedMarker>,
    /// Observed points \[m\].
    pub points: Vec<Vector3<f64>>,
}

impl Arrangement {
    /// The start of `spec`, with loops closed as far as its joints can move.
    ///
    /// # Errors
    /// As [`super::start_poses`].
    pub fn new(spec: &RunSpec) -> Result<Self, AdaptiveError> {
        Self::of(spec, poses(spec)?)
    }

    /// The same with the joint coordinates as given, whether or not loops are closed then.
    ///
    /// # Errors
    /// As [`super::start_poses`], but for loops.
    pub fn as_given(spec: &RunSpec) -> Result<Self, AdaptiveError> {
        let open = RunSpec { loops: Vec::new(), ..spec.clone() };
        Self::of(spec, poses(&open)?)
    }

    fn of(spec: &RunSpec, poses: Vec<BodyState>) -> Result<Self, AdaptiveError> {
        let bodies = rigid_models(spec)?;
        let placed = |at: &Attachment| placed(&bodies, &poses, at);
        let joint = |(joint, closes_loop): (&JointSpec, bool)| {
            Ok(PlacedJoint {
                name: joint.name.clone(),
                kind: joint.kind,
                closes_loop,
                parent: placed(&joint.parent)?,
                child: placed(&joint.child)?,
            })
        };
        let tree = spec.joints.iter().map(|j| (j, false));
        let joints = tree.chain(spec.loops.iter().map(|j| (j, true))).map(joint);
        let joints = joints.collect::<Result<_, AdaptiveError>>()?;
        let loads = spec.loads.iter().map(|load| placed(&load.at)).collect::<Result<_, AdaptiveError>>()?;
        let point = |p: &crate::spec::PointSpec| in_space(&bodies[p.body], &poses[p.body], &p.place);
        let points = spec.points.iter().map(point).collect::<Result<_, AdaptiveError>>()?;
        Ok(Self { poses, joints, loads, points })
    }
}

fn placed(bodies: &[BodyModel], poses: &[BodyState], at: &Attachment) -> Result<PlacedMarker, AdaptiveError> {
    let Some(body) = at.body else {
        let point = match &at.place {
            Place::Point(point) => Vector3::from(*point),
            Place::Marker(_) | Place::Area(_) => Vector3::zeros(), // ground has points alone
        };
        return Ok(PlacedMarker { body: None, point, axes: at.rotation });
    };
    let axes = poses[body].rotation * at.rotation;
    Ok(PlacedMarker { body: Some(body), point: in_space(&bodies[body], &poses[body], &at.place)?, axes })
}

/// A place of a body in space.
fn in_space(body: &BodyModel, pose: &BodyState, place: &Place) -> Result<Vector3<f64>, AdaptiveError> {
    let mut point = body.point(place)?.position;
    if body.data.motion == RigidMotion::Axial && matches!(place, Place::Area(_)) {
        // The mean motion of a ring is that of its centre, on the axis.
        (point.x, point.y) = (0.0, 0.0);
    }
    Ok(pose.position + pose.rotation * point)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn joint(kind: JointKind, displacement: Vector3<f64>, rotation: UnitQuaternion<f64>) -> PlacedJoint {
        let axes = UnitQuaternion::from_euler_angles(0.3, -0.8, 1.2);
        let parent = PlacedMarker { body: None, point: Vector3::new(1.0, 2.0, 3.0), axes };
        let child =
            PlacedMarker { body: Some(0), point: parent.point + axes * displacement, axes: axes * rotation };
        PlacedJoint { name: "j".into(), kind, closes_loop: true, parent, child }
    }

    #[test]
    fn motions_that_a_joint_allows_leave_it_closed() {
        // Two coordinates of each kind that are not zero; round-off of lengths of a few metres.
        let positions = [0.4, -0.3, 0.2, 0.9, 0.1, 0.3, -0.2];
        for kind in [
            JointKind::Fixed,
            JointKind::Revolute,
            JointKind::Prismatic,
            JointKind::Cylindrical,
            JointKind::Universal,
            JointKind::Planar,
            JointKind::Axial,
        ] {
            let motion = kind.motion(&positions, &[0.0; 6]);
            let joint = joint(kind, motion.displacement, motion.rotation);
            assert!(joint.held_distance() < 1e-14, "{kind:?}");
            assert!(joint.held_angle() < 1e-14, "{kind:?}");
        }
    }

    #[test]
    fn motions_that_a_joint_holds_are_measured() {
        let off = joint(
            JointKind::Prismatic,
            Vector3::new(3.0, 4.0, 7.0),
            UnitQuaternion::from_euler_angles(0.25, 0.0, 0.0),
        );
        assert!((off.held_distance() - 5.0).abs() < 1e-14);
        assert!((off.distance() - 74.0_f64.sqrt()).abs() < 1e-14);
        assert!((off.held_angle() - 0.25).abs() < 1e-14 && (off.angle() - 0.25).abs() < 1e-14);
    }
}
