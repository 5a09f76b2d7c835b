//! Joints: places that exist, types that suit the bodies, a tree.

mod axes;
mod coordinates;
mod tree;

use ffr_dynamics::system::joints::JointKind;

use super::super::check::Checker;
use super::super::model::{Attachment, Joint, Place};
use super::super::section::Section;
use super::places::{BodyFacts, body_index, held};

/// Name of what does not move.
pub const GROUND: &str = "ground";

/// The joints that are free of faults, and whether that is all of them.
pub fn joints(checker: &mut Checker, root: &Section) -> (Vec<Joint>, bool) {
    let list = root.named("joints");
    let built: Vec<Joint> =
        list.iter().filter_map(|(name, section)| joint(checker, root, name, section)).collect();
    tree::check(checker, root, &built);
    let is_complete = built.len() == list.len();
    (built, is_complete)
}

/// Name of the joint on which body `name` hangs, whether or not the joint is valid otherwise.
pub fn hanging_joint<'a>(root: &'a Section, name: &str) -> Option<&'a str> {
    let hangs = |section: &Section| {
        section.boolean("closes_loop") == Some(false)
            && section.table("child").and_then(|c| c.text("body")) == Some(name)
    };
    root.named("joints").iter().find(|(_, section)| hangs(section)).map(|(joint, _)| joint.as_str())
}

fn joint(checker: &mut Checker, root: &Section, name: &str, section: &Section) -> Option<Joint> {
    let kind = section.text("type").and_then(kind);
    let parent = section.table("parent").and_then(|side| attachment(checker, root, side, true));
    let child = section.table("child").and_then(|side| attachment(checker, root, side, false));
    let (kind, parent, child) = (kind?, parent, child);
    let axes = axes::axes(checker, section, kind);
    let closes_loop = section.boolean("closes_loop")?;
    if closes_loop && kind == JointKind::Free {
        checker.fault_in(section, "closes_loop", "a free joint holds nothing".into());
    }
    let start = coordinates::coordinates(checker, section, kind, closes_loop);
    let (parent, child, axes) = (parent?, child?, axes?);
    if parent.body == child.body {
        let side = section.table("child")?;
        checker.fault_in(side, "body", "must differ from the parent, a body is not joined to itself".into());
        return None;
    }
    axes::check_models(checker, root, section, kind, &axes)?;
    let start = start?;
    Some(Joint {
        name: name.to_owned(),
        kind,
        parent,
        child,
        axes: [axes.w, axes.i, axes.j, axes.k],
        closes_loop,
        positions: start.positions,
        velocities: start.velocities,
        coordinates: start.coordinates,
    })
}

fn kind(name: &str) -> Option<JointKind> {
    use JointKind::{Axial, Cylindrical, Fixed, Free, Planar, Prismatic, Revolute, Spherical, Universal};
    [Fixed, Revolute, Prismatic, Cylindrical, Universal, Spherical, Planar, Free, Axial]
        .into_iter()
        .find(|kind| kind.name() == name)
}

/// One side of a joint.
fn attachment(
    checker: &mut Checker,
    root: &Section,
    side: &Section,
    can_be_ground: bool,
) -> Option<Attachment> {
    if side.text("body")? == GROUND {
        if !can_be_ground {
            let message = "ground hangs on no joint, name it as \"parent\" and the body as \"child\"".into();
            checker.fault_in(side, "body", message);
            return None;
        }
        return ground(checker, side);
    }
    let known = root.named("bodies").iter().map(|(n, _)| n.as_str());
    let known: Vec<&str> = can_be_ground.then_some(GROUND).into_iter().chain(known).collect();
    if !known.contains(&side.text("body")?) {
        checker.unknown_name(side, "body", "body", &known);
        return None;
    }
    let body = body_index(checker, root, side, "body")?;
    let facts = BodyFacts::find(root, side.text("body")?)?;
    if facts.is_plane() {
        let message = "a plane is at rest and takes part in no joint, name \"ground\" instead".into();
        checker.fault_in(side, "body", message);
        return None;
    }
    let at = held(checker, side, &facts)?;
    Some(Attachment { body: Some(body), at })
}

fn ground(checker: &mut Checker, side: &Section) -> Option<Attachment> {
    let keys = ["marker", "face", "radius", "coupling"];
    if let Some(key) = keys.into_iter().find(|key| side.item(key).is_some()) {
        checker.fault_in(side, key, "ground has no markers and no parts, give a \"point\" in space".into());
        return None;
    }
    if side.item("point").is_none() {
        let message = "required key is missing: a point in space".into();
        checker.fault(&side.origin, side.path_of("point"), None, message);
        return None;
    }
    let Some(point) = side.vector("point") else {
        if side.numbers("point").is_some() {
            checker.fault_in(side, "point", "a point on ground has 3 coordinates".into());
        }
        return None;
    };
    Some(Attachment { body: None, at: Place::Point(point) })
}
