//! Joints: places that exist, types that suit the bodies, a tree.

mod axes;
mod coordinates;
mod tree;

use adaptive::spec::{Area, Attachment, JointSpec, Place};
use ffr_dynamics::body::RigidMotion;
use ffr_dynamics::system::joints::{FreeDirections, JointKind};
use nalgebra::{UnitQuaternion, Vector3};

use super::super::body_places::BodyPlaces;
use super::super::section::Section;
use super::super::tables::JointType;
use super::built_bodies::BuiltBodies;
use super::places::{BodyFacts, body_index, held};
use tree::Link;

/// Name of what does not move.
pub const GROUND: &str = "ground";

/// A joint that is free of faults.
#[derive(Debug)]
pub struct BuiltJoint<'a> {
    /// Its place in the tree.
    pub link: Link<'a>,
    /// What it is in the run; none while one of its bodies is at fault.
    pub spec: Option<JointSpec>,
}

/// The joints that are free of faults.
pub fn joints<'a>(root: &'a Section, bodies: &BuiltBodies) -> Vec<BuiltJoint<'a>> {
    let list = root.named("joints").iter();
    let built: Vec<BuiltJoint<'_>> =
        list.filter_map(|(name, section)| joint(root, name, section, bodies)).collect();
    let links: Vec<Link<'_>> = built.iter().map(|joint| joint.link).collect();
    tree::check(root, &links);
    built
}

/// Name of the joint whose child body `name` is, whether or not the joint is valid otherwise.
pub fn inboard_joint<'a>(root: &'a Section, name: &str) -> Option<&'a str> {
    let is_child = |section: &Section| {
        section.boolean("closes_loop") == Some(false)
            && section.table("child").and_then(|c| c.text("body")) == Some(name)
    };
    root.named("joints").iter().find(|(_, section)| is_child(section)).map(|(joint, _)| joint.as_str())
}

fn joint<'a>(
    root: &Section,
    name: &'a str,
    section: &Section,
    bodies: &BuiltBodies,
) -> Option<BuiltJoint<'a>> {
    let motion =
        section.table("child").and_then(|side| Some(BodyFacts::find(root, side.text("body")?)?.motion()));
    let motion = motion.unwrap_or(RigidMotion::Spatial);
    let kind = section.choice("type").and_then(|of| kind(section, of, motion));
    let side = |key: &str, can_be_ground: bool| {
        section.table(key).and_then(|side| attachment(root, side, can_be_ground, bodies))
    };
    let (mut parent, child) = (side("parent", true), side("child", false));
    let kind = kind?;
    let axes = axes::axes(section, kind);
    let closes_loop = section.boolean("closes_loop")?;
    if closes_loop && kind == JointKind::Free {
        section.fault("closes_loop", "a free joint holds nothing");
    }
    let start = coordinates::coordinates(section, kind, closes_loop);
    if let (Some(parent), Some(child)) = (&mut parent, &child)
        && parent.body.is_none()
        && parent.place.is_none()
    {
        let point = child.at_origin(bodies).filter(|_| !closes_loop);
        if point.is_none() && bodies.is_complete() {
            let message = "required key is missing: a point in space";
            let side = section.table("parent")?;
            side.fault("point", message);
        }
        parent.place = point;
    }
    let (parent, child, axes) = (parent?, child?, axes?);
    if parent.body == child.body {
        let side = section.table("child")?;
        return side.refuse("body", "must differ from the parent, a body is not joined to itself");
    }
    axes::check_models(root, section, kind, &axes)?;
    let start = start?;
    let link = Link { name, parent: parent.body, child: child.body, closes_loop };
    let spec = parent.with_axes(axes, bodies).zip(child.with_axes(axes, bodies));
    let spec = spec.map(|(parent, child)| JointSpec {
        name: name.to_owned(),
        kind,
        velocities: in_marker(kind, start.velocities, &child.rotation),
        parent,
        child,
        positions: start.positions,
        has_velocities: ["angular_velocity", "velocity", "velocities"].iter().any(|key| section.given(key)),
        coordinates: start.coordinates,
        bearing: start.bearing,
    });
    Some(BuiltJoint { link, spec })
}

/// Velocities of which an angular velocity stands in the axes of the child's marker, which
/// `rotation` turns into those of the child, in which it is given.
fn in_marker(kind: JointKind, mut velocities: Vec<f64>, rotation: &UnitQuaternion<f64>) -> Vec<f64> {
    // A joint that closes a loop has no velocities of its own.
    if let Some(spin) = kind.quaternion().and_then(|w| velocities.get_mut(w..w + 3)) {
        let in_marker = rotation.inverse_transform_vector(&Vector3::from_column_slice(spin));
        spin.copy_from_slice(in_marker.as_slice());
    }
    velocities
}

fn kind(section: &Section, of: JointType, motion: RigidMotion) -> Option<JointKind> {
    Some(match of {
        JointType::Fixed => JointKind::Fixed,
        JointType::Revolute => JointKind::Revolute,
        JointType::Prismatic => JointKind::Prismatic,
        JointType::Cylindrical => JointKind::Cylindrical,
        JointType::Universal => JointKind::Universal,
        JointType::Spherical => JointKind::Spherical,
        JointType::Planar => JointKind::Planar,
        JointType::Free => JointKind::Free,
        JointType::Axial => JointKind::Axial,
        JointType::Generic => generic(section, motion)?,
    })
}

/// The joint that holds the directions of key `locked`, and those in which bodies with `motion` cannot move.
fn generic(section: &Section, motion: RigidMotion) -> Option<JointKind> {
    if section.item("locked").is_none() {
        let message = "required key is missing for type \"generic\": the directions that the joint holds";
        return section.refuse("locked", message);
    }
    let locked = section.names("locked")?;
    let most = JointKind::freest(motion);
    let FreeDirections(all) = most.free_directions();
    let is_locked = |name: &str| locked.iter().any(|l| l == name);
    let free: [bool; 6] = std::array::from_fn(|k| all[k] && !is_locked(FreeDirections::NAMES[k]));
    let other = match free {
        [false, false, false, false, false, false] => ("holds everything", "fixed"),
        _ if free == all => ("holds nothing", most.name()),
        _ => return Some(JointKind::Generic(FreeDirections(free))),
    };
    section.refuse("locked", format!("{}, choose type \"{}\"", other.0, other.1))
}

/// One side of a joint.
struct Side {
    /// Body of the file; none is ground.
    body: Option<usize>,
    /// Where on it; none while the body is at fault, and on ground where no point is given.
    place: Option<Place>,
}

impl Side {
    /// The point of space at which the place is while the body's origin is that of space and its
    /// orientation that of the scenario; none of a place that only a body file knows.
    fn at_origin(&self, bodies: &BuiltBodies) -> Option<Place> {
        let body = self.body?;
        let motion = bodies.moving(body)?.spec.kind.motion();
        let point = match self.place.as_ref()? {
            // The mean of a ring lies on the axis.
            Place::Area(area) if motion == RigidMotion::Axial => Vector3::new(0.0, 0.0, area.centre[1]),
            Place::Point(point) | Place::Area(Area { centre: point, .. }) => motion.in_space(point),
            Place::Marker(_) => return None,
        };
        Some(Place::Point((bodies.rotation(body)? * point).into()))
    }

    /// The attachment with `axes` given in space for the orientation of the scenario.
    fn with_axes(self, axes: UnitQuaternion<f64>, bodies: &BuiltBodies) -> Option<Attachment> {
        // Unit length to the last bit, whatever the axes were made from.
        let axes = UnitQuaternion::from_quaternion(axes.into_inner());
        let place = self.place?;
        let Some(body) = self.body else { return Some(Attachment { body: None, place, rotation: axes }) };
        let rotation = bodies.rotation(body)?.inverse() * axes;
        Some(Attachment { body: Some(bodies.index(body)?), place, rotation })
    }
}

fn attachment(root: &Section, side: &Section, can_be_ground: bool, bodies: &BuiltBodies) -> Option<Side> {
    if side.text("body")? == GROUND {
        if !can_be_ground {
            let message = "ground is the child of no joint, name it as \"parent\" and the body as \"child\"";
            return side.refuse("body", message);
        }
        return ground(side);
    }
    if root.place_of("bodies", side.text("body")?).is_none() {
        let known = root.named("bodies").iter().map(|(n, _)| n.as_str());
        let known: Vec<&str> = can_be_ground.then_some(GROUND).into_iter().chain(known).collect();
        side.unknown_name("body", "body", &known);
        return None;
    }
    let body = body_index(root, side, "body")?;
    let facts = BodyFacts::find(root, side.text("body")?)?;
    if facts.is_plane() {
        let message = "a plane is at rest and takes part in no joint, name \"ground\" instead";
        return side.refuse("body", message);
    }
    let at = held(side, &facts)?;
    let place = bodies.place(side, body, &at, BodyPlaces::held);
    Some(Side { body: Some(body), place })
}

fn ground(side: &Section) -> Option<Side> {
    if side.item("point").is_none() {
        return Some(Side { body: None, place: None });
    }
    let Some(point) = side.vector("point") else {
        if side.numbers("point").is_some() {
            side.fault("point", "a point on ground has 3 coordinates");
        }
        return None;
    };
    Some(Side { body: None, place: Some(Place::Point(point)) })
}
