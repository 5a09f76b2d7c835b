//! Contacts: pairs of bodies that exist, and settings that go together.

use super::super::check::Checker;
use super::super::model::{Constraint, Contact, ContactModel, ContactPoints, ContactSolver, Interval};
use super::super::section::Section;
use super::{body_index, model_and_shape};

/// All contacts; `None` if one of them is at fault.
pub fn contacts(checker: &mut Checker, root: &Section) -> Option<Vec<Contact>> {
    let list = root.named("contacts");
    let mut built: Vec<Contact> = Vec::with_capacity(list.len());
    for (name, section) in list {
        let Some(contact) = contact(checker, root, name, section) else { continue };
        let pair = |c: &Contact| (c.contact_body, c.target_body);
        if let Some(same) = built.iter().find(|c| pair(c) == pair(&contact)) {
            let message = format!("contact \"{}\" has the same pair of bodies already", same.name);
            checker.fault_in(section, "contact_body", message);
        }
        built.push(contact);
    }
    (built.len() == list.len()).then_some(built)
}

fn contact(checker: &mut Checker, root: &Section, name: &str, section: &Section) -> Option<Contact> {
    let contact_body = body_index(checker, root, section, "contact_body");
    let target_body = body_index(checker, root, section, "target_body");
    if contact_body.is_some() && contact_body == target_body {
        let message = "must differ from contact_body, a body does not touch itself".into();
        checker.fault_in(section, "target_body", message);
        return None;
    }
    check_bodies(checker, root, section);
    check_settings(checker, section);
    let interval = section.table("interval")?;
    Some(Contact {
        name: name.to_owned(),
        contact_body: contact_body?,
        target_body: target_body?,
        model: match section.text("model")? {
            "dynamic" => ContactModel::Dynamic,
            _ => ContactModel::Quasistatic,
        },
        constraint: constraint(checker, section)?,
        points: match section.text("points")? {
            "gauss" => ContactPoints::Gauss,
            _ => ContactPoints::Greville,
        },
        solver: match section.text("solver")? {
            "broyden" => ContactSolver::Broyden,
            _ => ContactSolver::ActiveSet,
        },
        friction: section.number("friction")?,
        interval: Interval { width: interval.number("width"), elements: interval.integer("elements") },
    })
}

fn constraint(checker: &mut Checker, section: &Section) -> Option<Constraint> {
    let penalty = section.table("penalty")?;
    penalty.text("search")?;
    if penalty.given("value") && penalty.given("initial") {
        let message = "either \"value\" or \"initial\" can be given, they mean the same".into();
        checker.fault_in(penalty, "value", message);
        return None;
    }
    let key = if penalty.given("value") { "value" } else { "initial" };
    let value = penalty.number(key)?;
    Some(match section.text("constraint")? {
        "exact" => Constraint::Exact,
        _ => Constraint::Penalty { value },
    })
}

/// Reports bodies that cannot take their part in the contact.
fn check_bodies(checker: &mut Checker, root: &Section, section: &Section) {
    let facts = |key| section.text(key).and_then(|name| model_and_shape(root, name));
    let (contact, target) = (facts("contact_body"), facts("target_body"));
    if contact.is_some_and(|(model, _)| model == "rigid") {
        let message = "must be a flexible body, for it carries the contact points".into();
        checker.fault_in(section, "contact_body", message);
    }
    if target.is_some_and(|(_, shape)| shape != "plane") {
        let message = "must be a rigid body with shape \"plane\", other targets are not supported yet".into();
        checker.fault_in(section, "target_body", message);
    }
    let body = |key| {
        let name = section.text(key)?;
        root.named("bodies").iter().find(|(n, _)| n == name).map(|(_, body)| body)
    };
    let method = body("contact_body").and_then(|b| b.table("reduction")?.text("method"));
    if section.text("model") == Some("quasistatic") && method.is_some_and(|m| m != "craig-bampton") {
        let message = "\"quasistatic\" needs a contact body with reduction method \"craig-bampton\", \
                       \"modal\" and \"all\" go with \"dynamic\"";
        checker.fault_in(section, "model", message.into());
    }
    // The normal must lie in the space of the contact body's model.
    let (Some((model, _)), Some(plane)) = (contact, body("target_body")) else { return };
    let Some(normal) = plane.vector::<3>("normal") else { return };
    let size = normal.iter().fold(0.0_f64, |a, x| a.max(x.abs()));
    let leaves = |components: &[usize]| components.iter().any(|&i| normal[i].abs() > 1e-12 * size);
    let (at_fault, words) = match model {
        "axisymmetric" => (leaves(&[0, 1]), "along z"),
        "plane-strain" | "plane-stress" => (leaves(&[2]), "in the plane (x, y)"),
        _ => (false, ""),
    };
    if at_fault {
        let message = format!("must be {words}, for it meets a body with model \"{model}\"");
        checker.fault_in(plane, "normal", message);
    }
}

/// Reports settings that exclude each other.
fn check_settings(checker: &mut Checker, section: &Section) {
    if let Some(interval) = section.table("interval")
        && interval.given("elements")
        && !interval.given("width")
    {
        checker.fault_in(interval, "elements", "needs \"width\" beside it".into());
    }
    if section.text("model") == Some("dynamic") && section.text("solver") == Some("broyden") {
        let message = "has no effect with model \"dynamic\", where no quasistatic state is solved for".into();
        checker.fault_in(section, "solver", message);
    }
    if section.text("constraint") != Some("exact") {
        return;
    }
    let needs = [("model", "quasistatic"), ("points", "greville"), ("solver", "active-set")];
    for (key, needed) in needs {
        if section.text(key).is_some_and(|value| value != needed) {
            let message = format!("must be \"{needed}\" with constraint \"exact\"");
            checker.fault_in(section, key, message);
        }
    }
}
