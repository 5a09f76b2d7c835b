//! Contacts: pairs of bodies that exist, and settings that go together.

use adaptive::spec::HandOver;
use adaptive::spec::TransferMethod;
use adaptive::spec::{DivisionRule, LowModes};
use contact_qs::law::Friction;

use super::super::check::Checker;
use super::super::model::{
    Constraint, Contact, ContactLaw, ContactModel, ContactPoints, ContactSolver, Interval, PenaltySearch,
    SurfaceContact,
};
use super::super::section::Section;
use super::contact_checks::{check_bodies, check_hertz, check_settings};
use super::contact_facts::ContactFacts;
use super::places::body_index;

/// All contacts; `None` if one of them is at fault.
pub fn contacts(checker: &mut Checker, root: &Section) -> Option<Vec<Contact>> {
    let list = root.named("contacts");
    let mut built: Vec<Contact> = Vec::with_capacity(list.len());
    for (name, section) in list {
        let Some(contact) = contact(checker, root, name, section) else { continue };
        let pair = |c: &Contact| (c.contact_body.min(c.target_body), c.contact_body.max(c.target_body));
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
    let facts = ContactFacts::of(root, section)?;
    let law = if facts.model == "hertz" {
        check_hertz(checker, root, section);
        ContactLaw::Hertz
    } else {
        check_bodies(checker, root, section);
        check_settings(checker, section, &facts);
        ContactLaw::Surface(surface(section, &facts)?)
    };
    let initial_overlap = section.number("initial_overlap")?;
    let (contact_body, target_body) = (contact_body?, target_body?);
    Some(Contact { name: name.to_owned(), contact_body, target_body, law, initial_overlap })
}

fn surface(section: &Section, facts: &ContactFacts<'_>) -> Option<SurfaceContact> {
    let coefficient = section.number("friction")?;
    Some(SurfaceContact {
        model: match facts.model {
            "quasistatic" => ContactModel::Quasistatic,
            "damped" => ContactModel::Damped,
            "dynamic" => ContactModel::Dynamic,
            "coarse" => ContactModel::Coarse,
            _ => ContactModel::Adaptive,
        },
        constraint: constraint(section, facts)?,
        points: match section.text("points")? {
            "gauss" => ContactPoints::Gauss,
            _ => ContactPoints::Greville,
        },
        solver: match section.text("solver")? {
            "broyden" => ContactSolver::Broyden,
            _ => ContactSolver::ActiveSet,
        },
        friction: (coefficient > 0.0).then(|| Friction::new(coefficient)),
        interval: interval(section.table("interval")?)?,
        hand_over: HandOver {
            modes: match section.text("modes")? {
                "own" => LowModes::Own,
                _ => LowModes::Prolonged,
            },
            method: match section.text("transfer")? {
                "printed" => TransferMethod::Printed,
                _ => TransferMethod::MassOrthogonal,
            },
        },
    })
}

fn interval(section: &Section) -> Option<Interval> {
    Some(Interval {
        width: section.number("width"),
        elements: section.integer("elements"),
        target_utilisation: section.number("target_utilisation")?,
        division: match section.text("division")? {
            "printed" => DivisionRule::Printed,
            _ => DivisionRule::Graded,
        },
    })
}

fn constraint(section: &Section, facts: &ContactFacts<'_>) -> Option<Constraint> {
    let penalty = section.table("penalty")?;
    if section.text("constraint")? == "exact" {
        return Some(Constraint::Exact);
    }
    let value = if penalty.given("initial") { Some(penalty.number("initial")?) } else { None };
    let search = match facts.search {
        "until-converged" => PenaltySearch::UntilConverged { tolerance: penalty.number("tolerance")? },
        "until-error" => PenaltySearch::UntilError,
        "fixed" => PenaltySearch::Fixed,
        _ => return None,
    };
    Some(Constraint::Penalty { value, search })
}
