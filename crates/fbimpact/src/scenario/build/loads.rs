//! Loads: bodies that exist and move, components that the model has.

use adaptive::spec::{Attachment, LoadSpec};
use ffr_dynamics::body::RigidMotion;
use nalgebra::UnitQuaternion;

use super::super::body_places::BodyPlaces;
use super::super::section::{AtFault, Section};
use super::built_bodies::BuiltBodies;
use super::curves::curve;
use super::places::{BodyFacts, body_index, held, motion_in_words};

/// Keys of the components, in the order of [`LoadSpec::components`].
const COMPONENTS: [&str; 6] = ["force_x", "force_y", "force_z", "moment_x", "moment_y", "moment_z"];

/// All loads; `None` if one of them, or its body, is at fault.
pub fn loads(root: &Section, bodies: &BuiltBodies) -> Option<Vec<LoadSpec>> {
    let list = root.named("loads");
    let built: Vec<LoadSpec> =
        list.iter().filter_map(|(name, section)| load(root, name, section, bodies)).collect();
    (built.len() == list.len()).then_some(built)
}

fn load(root: &Section, name: &str, section: &Section, bodies: &BuiltBodies) -> Option<LoadSpec> {
    let mut components: [_; 6] = std::array::from_fn(|_| None);
    let mut is_complete = true;
    for (slot, key) in components.iter_mut().zip(COMPONENTS) {
        match curve(section, key) {
            Ok(found) => *slot = found,
            Err(AtFault) => is_complete = false,
        }
    }
    if is_complete && components.iter().all(Option::is_none) {
        let message = "required key is missing: a force or moment, such as \"force_z\"";
        return section.refuse("force_z", message);
    }
    let body = body_index(root, section, "body")?;
    let facts = BodyFacts::find(root, section.text("body")?)?;
    let at = held(section, &facts)?;
    // Components along which the model does not move.
    let missing: &[usize] = match facts.motion() {
        RigidMotion::Axial => &[0, 1, 3, 4, 5],
        RigidMotion::Planar => &[2, 3, 4],
        RigidMotion::Spatial => &[],
    };
    for &i in missing.iter().filter(|&&i| components[i].is_some()) {
        let message = format!("a body that is {} cannot move so", motion_in_words(facts.motion()));
        section.fault(COMPONENTS[i], message);
    }
    let place = bodies.place(section, body, &at, BodyPlaces::held)?;
    // Axes that turn with the place are those of the body.
    let at = Attachment { body: Some(bodies.index(body)?), place, rotation: UnitQuaternion::identity() };
    let is_following = section.boolean("following")?;
    is_complete.then(|| LoadSpec { name: name.to_owned(), at, components, is_following })
}
