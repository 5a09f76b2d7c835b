//! Faults of contacts that involve several keys: bodies that cannot take their part, settings
//! without meaning.

use adaptive::spec::contact::{DivisionRule, InterfaceModes, LowModes, TransferMethod, Treatment};
use contact_qs::search::way_between;
use ffr_dynamics::body::RigidMotion;
use nalgebra::Vector3;

use super::facts::ContactFacts;
use crate::scenario::build::joints::inboard_joint;
use crate::scenario::build::places::{BodyFacts, motion_in_words};
use crate::scenario::keys::Named;
use crate::scenario::section::Section;
use crate::scenario::tables::{ContactModel, ReductionMethod, Search, ShapeName, Solver};

/// Reports bodies that Hertz's law knows nothing of.
pub fn check_hertz(root: &Section, section: &Section) {
    let facts = |key| section.text(key).and_then(|name| BodyFacts::find(root, name));
    let (contact, target) = (facts("contact_body"), facts("target_body"));
    let has_flat_faces =
        |body: &BodyFacts<'_>| matches!(body.shape, Some(ShapeName::Box | ShapeName::Rectangle));
    let is_flat = |body: &BodyFacts<'_>| body.is_plane() || has_flat_faces(body);
    let are_flat = [&contact, &target].into_iter().flatten().all(is_flat);
    for (key, body) in [("contact_body", &contact), ("target_body", &target)] {
        let Some(body) = body else { continue };
        let fault = if body.is_plane() {
            (key == "contact_body").then_some("must be a body, exchange contact_body and target_body")
        } else if body.mesh.is_some() {
            Some(
                "must have a shape with model \"hertz\", a mesh has no curvature of its own; choose model = \"adaptive\"",
            )
        } else if body.shape.is_none() || body.file.is_some() {
            Some("has no surface to touch; Hertz's law needs a body with \"geometry\"")
        } else if has_flat_faces(body) && are_flat {
            Some(
                "has flat faces alone, as the other has, of which Hertz's law knows nothing; choose model = \"adaptive\", of rigid bodies \"coarse\"",
            )
        } else {
            None
        };
        if let Some(message) = fault {
            section.fault(key, message);
        }
    }
    let (Some(contact), Some(target)) = (contact, target) else { return };
    if !target.is_plane() && contact.motion() != target.motion() {
        let [contact, target] = [contact, target].map(|body| motion_in_words(body.motion()));
        let message = format!("must be {contact} as the contact body is, it is {target}");
        section.fault("target_body", message);
    }
    if contact.motion() == RigidMotion::Axial && section.number("friction").is_some_and(|f| f > 0.0) {
        let message = "has no effect with model \"hertz\" between bodies that move along one axis";
        section.fault("friction", message);
    }
    check_normal(&contact, &target);
    check_shared_space(root, section, [&contact, &target]);
}

/// Reports bodies that cannot take their part in the contact.
pub fn check_bodies(root: &Section, section: &Section) {
    let facts = |key| section.text(key).and_then(|name| BodyFacts::find(root, name));
    let (contact, target) = (facts("contact_body"), facts("target_body"));
    let mut is_imported = false;
    for (key, body) in [("contact_body", contact), ("target_body", target)] {
        if body.is_some_and(|b| b.file.is_some()) {
            let message = "must be a body with a shape, one from a file has no surface to touch";
            section.fault(key, message);
            is_imported = true;
        }
    }
    if is_imported {
        return;
    }
    if contact.is_some_and(|body| body.is_rigid) {
        check_rigid(section, [contact.as_ref(), target.as_ref()]);
    }
    for (key, body) in [("contact_body", contact), ("target_body", target)] {
        if body.is_some_and(|body| body.is_rigid && body.shape.is_none()) {
            let message = "has no surface to touch, for it has a mass but no shape; give it \"geometry\" and \"material\" in their place";
            section.fault(key, message);
        }
    }
    let method = contact.and_then(|b| b.section.table("reduction")?.choice::<ReductionMethod>("method"));
    if let Some(model) = section.choice::<ContactModel>("model")
        && model.is(|of| of.interface_modes().is_some_and(InterfaceModes::need_bounds))
        && method.is_some_and(|m| m != ReductionMethod::CraigBampton)
    {
        let message = format!(
            "\"{}\" needs a contact body with reduction method \"craig-bampton\", \
             \"modal\" and \"all\" go with \"adaptive\", \"dynamic\" and \"coarse\"",
            model.name()
        );
        section.fault("model", message);
    }
    let (Some(contact), Some(target)) = (contact, target) else { return };
    if !contact.is_rigid && !target.is_rigid && contact.components != target.components {
        let message = format!(
            "must have model \"{}\" as the contact body has, it is \"{}\"",
            contact.components.name(),
            target.components.name()
        );
        section.fault("target_body", message);
    }
    if target.is_rigid && !target.is_plane() && contact.motion() != target.motion() {
        let motion = contact.motion().name();
        let own = if contact.is_rigid { ("motion", motion) } else { ("model", contact.components.name()) };
        let message =
            format!("must have motion = \"{motion}\", for it meets a body with {} \"{}\"", own.0, own.1);
        section.fault("target_body", message);
    }
    check_normal(&contact, &target);
    check_shared_space(root, section, [&contact, &target]);
}

/// Reports what a rigid contact body does not go with: flexible targets, models with zones.
fn check_rigid(section: &Section, [contact, target]: [Option<&BodyFacts<'_>>; 2]) {
    if contact.is_some_and(BodyFacts::is_plane) {
        section.fault("contact_body", "must be a body, exchange contact_body and target_body");
        return;
    }
    if target.is_some_and(|body| !body.is_rigid) {
        let message = "must be a flexible body where the target is one, for its points yield; exchange contact_body and target_body";
        section.fault("contact_body", message);
        return;
    }
    if section.choice("model").is_none_or(|model: ContactModel| model.is(Treatment::has_fine_zone)) {
        let message = "must be \"coarse\" between rigid bodies (contact points all over the contact body, on springs: flat faces, edges, \
                       corners) or \"hertz\" (smooth faces that are curved against each other)";
        section.fault("model", message);
    }
}

/// Reports a plane whose normal leaves the space of the contact body's model.
fn check_normal(contact: &BodyFacts<'_>, target: &BodyFacts<'_>) {
    if !target.is_plane() {
        return;
    }
    let plane = target.section;
    let Some(normal) = plane.vector::<3>("normal") else { return };
    let size = normal.iter().fold(0.0_f64, |a, x| a.max(x.abs()));
    let leaves = |components: &[usize]| components.iter().any(|&i| normal[i].abs() > 1e-12 * size);
    let (at_fault, words) = match contact.motion() {
        RigidMotion::Axial => (leaves(&[0, 1]), "along z"),
        RigidMotion::Planar => (leaves(&[2]), "in the plane (x, y)"),
        RigidMotion::Spatial => (false, ""),
    };
    if at_fault {
        let model = contact.components.name();
        let message = format!("must be {words}, for it meets a body with model \"{model}\"");
        plane.fault("normal", message);
    }
}

/// Reports bodies that lie in different planes or on different axes where their models have one;
/// where joints place them, the run does.
fn check_shared_space(root: &Section, section: &Section, bodies: [&BodyFacts<'_>; 2]) {
    let is_joined = |key| section.text(key).is_some_and(|name| inboard_joint(root, name).is_some());
    if bodies[1].is_plane() || is_joined("contact_body") || is_joined("target_body") {
        return;
    }
    let [Some(first), Some(second)] = bodies.map(|body| body.section.vector::<3>("position")) else { return };
    let places = [first, second].map(Vector3::from);
    if let Err(fault) = way_between(bodies[0].motion(), places.each_ref()) {
        section.fault("target_body", format!("must lie where the contact body moves: {fault} (position)"));
    }
}

/// Reports settings that exclude each other.
pub fn check_settings(section: &Section, facts: &ContactFacts) {
    check_solver(section, facts);
    if let Some(penalty) = section.table("penalty") {
        check_penalty(section, penalty, facts);
    }
    if let Some(interval) = section.table("interval") {
        check_interval(interval, facts);
    }
    check_transfer(section, facts);
}

fn check_solver(section: &Section, facts: &ContactFacts) {
    let has_state = facts.model.is(Treatment::is_static);
    let is_broyden = section.choice("solver") == Some(Solver::Broyden);
    if is_broyden && !has_state {
        let message = format!(
            "has no effect with model \"{}\", where no quasistatic state is solved for",
            facts.model.name()
        );
        section.fault("solver", message);
    }
    if is_broyden && section.number("friction").is_some_and(|f| f > 0.0) {
        let message = "must be \"active-set\" with friction, Algorithm 1 knows normal forces alone";
        section.fault("solver", message);
    }
    if !facts.is_exact {
        return;
    }
    let law = if facts.model.is_massless() { "model \"massless\"" } else { "constraint \"exact\"" };
    if !has_state {
        let message = "must be \"adaptive\" or \"quasistatic\" with constraint \"exact\"";
        section.fault("model", message);
    }
    if facts.has_mesh && facts.model.is_massless() {
        let message = "must be \"quasistatic\" or another model with a penalty factor where a body is a mesh: corners of its sides have no \
                       area of their own, so that contact is watched at more points than the boundary has unknowns";
        section.fault("model", message);
        return;
    }
    if facts.has_mesh {
        let message = "must be \"penalty\" where a body is a mesh: corners of its sides have no area of their own, so that \
                       contact is watched at more points than the constraint has unknowns for";
        section.fault("constraint", message);
        return;
    }
    for (key, needed) in [("points", "greville"), ("solver", "active-set")] {
        if section.text(key).is_some_and(|value| value != needed) {
            section.fault(key, format!("must be \"{needed}\" with {law}"));
        }
    }
}

fn check_transfer(section: &Section, facts: &ContactFacts) {
    let has_own = section.choice("modes") == Some(LowModes::Fine);
    if has_own && !facts.is_refined() {
        let message = format!(
            "must be \"prolonged\" with model \"{}\" here, whose bodies keep one model; \"adaptive\" has fine models",
            facts.model.name()
        );
        section.fault("modes", message);
    } else if has_own && facts.has_mesh {
        section.fault("modes", "must be \"prolonged\" with a body that is a mesh");
    }
    if section.choice("transfer") == Some(TransferMethod::Printed) && !has_own {
        section.fault("transfer", "\"printed\" has a meaning with modes = \"own\" only");
    }
}

fn check_penalty(section: &Section, penalty: &Section, facts: &ContactFacts) {
    if facts.model.is_massless() {
        return; // the whole table is without a meaning
    }
    if matches!(facts.search, None | Some(Search::Fixed)) {
        return;
    }
    if !facts.model.is(Treatment::is_searched) {
        let message = format!(
            "must be \"fixed\" with model \"{}\", searches are made with \"adaptive\" only",
            facts.model.name()
        );
        penalty.fault("search", message);
    }
    if facts.is_exact {
        let message = "has no meaning with constraint \"exact\", which has no penalty factor";
        penalty.fault("search", message);
    }
    if facts.search == Some(Search::UntilError) && section.choice("solver") == Some(Solver::ActiveSet) {
        let message =
            "must not be \"until-error\", for the active-set solver never fails; choose solver = \"broyden\"";
        penalty.fault("search", message);
    }
}

fn check_interval(interval: &Section, facts: &ContactFacts) {
    if interval.given("elements")
        && !interval.given("width")
        && !facts.is_refined()
        && facts.model.is(Treatment::has_fine_zone)
    {
        interval.fault("elements", "needs \"width\" beside it");
    }
    if facts.has_mesh && interval.choice("division") == Some(DivisionRule::Printed) {
        let message = "\"printed\" is for bodies of splines, elements of a mesh are halved; leave it out";
        interval.fault("division", message);
    }
}
