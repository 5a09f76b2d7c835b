//! Factors on the resolution: of bodies and contacts that exist.

use adaptive::spec::{BodyFactors, ContactFactors};

use super::super::check::Checker;
use super::super::keys::names;
use super::super::model::{Body, Contact, Resolution};
use super::super::section::Section;

/// The `[resolution]` table; no factors without one. `None` if it is at fault.
pub fn resolution(
    checker: &mut Checker,
    root: &Section,
    bodies: &[Body],
    contacts: &[Contact],
) -> Option<Resolution> {
    let Some(section) = root.table("resolution") else {
        let (bodies, contacts) =
            (vec![Default::default(); bodies.len()], vec![Default::default(); contacts.len()]);
        return (!root.given("resolution")).then_some(Resolution { bodies, contacts, tolerance: 1.0 });
    };
    let of_all = BodyFactors { modes: section.integer("modes")?, mesh: section.integer("mesh")? };
    let mut factors = vec![of_all; bodies.len()];
    for (index, own) in single(checker, section, "bodies", &mut bodies.iter().map(|b| b.name.as_str())) {
        let [modes, mesh] = ["modes", "mesh"].map(|key| own.integer(key));
        factors[index] =
            BodyFactors { modes: modes.unwrap_or(of_all.modes), mesh: mesh.unwrap_or(of_all.mesh) };
    }
    let of_contacts = ContactFactors { zone: section.integer("zone")?, penalty: section.number("penalty")? };
    let mut contact_factors = vec![of_contacts; contacts.len()];
    for (index, own) in single(checker, section, "contacts", &mut contacts.iter().map(|c| c.name.as_str())) {
        let (zone, penalty) = (own.integer("zone"), own.number("penalty"));
        contact_factors[index] = ContactFactors {
            zone: zone.unwrap_or(of_contacts.zone),
            penalty: penalty.unwrap_or(of_contacts.penalty),
        };
    }
    Some(Resolution { bodies: factors, contacts: contact_factors, tolerance: section.number("tolerance")? })
}

/// The tables of `section.key` with the index of each name among `known`; names that are not there are faults.
fn single<'a>(
    checker: &mut Checker,
    section: &'a Section,
    key: &str,
    known: &mut dyn Iterator<Item = &str>,
) -> Vec<(usize, &'a Section)> {
    let known: Vec<&str> = known.collect();
    let mut found = Vec::new();
    for (name, own) in section.named(key) {
        match known.iter().position(|k| k == name) {
            Some(index) => found.push((index, own)),
            None => {
                let message =
                    format!("there is none of this name, known are {}", names(known.iter().copied()));
                checker.fault(&own.origin, own.path.clone(), None, message);
            }
        }
    }
    found
}
