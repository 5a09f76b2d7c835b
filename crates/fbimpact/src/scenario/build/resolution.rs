//! Factors on the resolution: of bodies and contacts that exist.

use adaptive::spec::{BodyFactors, ContactFactors, Resolution};

use super::super::keys::names;
use super::super::section::Section;

/// The factors of the `[resolution]` table for bodies and contacts of these names, in their order,
/// and that on the permitted errors of steps; no factors without a table. `None` if it is at fault.
pub fn resolution(root: &Section, bodies: &[&str], contacts: &[&str]) -> Option<(Resolution, f64)> {
    let Some(section) = root.table("resolution") else {
        let (bodies, contacts) =
            (vec![Default::default(); bodies.len()], vec![Default::default(); contacts.len()]);
        return (!root.given("resolution")).then_some((Resolution { bodies, contacts }, 1.0));
    };
    let of_all = BodyFactors { modes: section.integer("modes")?, mesh: section.integer("mesh")? };
    let mut factors = vec![of_all; bodies.len()];
    for (index, own) in single(section, "bodies", bodies) {
        let [modes, mesh] = ["modes", "mesh"].map(|key| own.integer(key));
        factors[index] =
            BodyFactors { modes: modes.unwrap_or(of_all.modes), mesh: mesh.unwrap_or(of_all.mesh) };
    }
    let of_contacts = ContactFactors { zone: section.integer("zone")?, penalty: section.number("penalty")? };
    let mut contact_factors = vec![of_contacts; contacts.len()];
    for (index, own) in single(section, "contacts", contacts) {
        let (zone, penalty) = (own.integer("zone"), own.number("penalty"));
        contact_factors[index] = ContactFactors {
            zone: zone.unwrap_or(of_contacts.zone),
            penalty: penalty.unwrap_or(of_contacts.penalty),
        };
    }
    Some((Resolution { bodies: factors, contacts: contact_factors }, section.number("tolerance")?))
}

/// The tables of `section.key` with the index of each name among `known`; names that are not there
/// are faults.
fn single<'a>(section: &'a Section, key: &str, known: &[&str]) -> Vec<(usize, &'a Section)> {
    let mut found = Vec::new();
    for (name, own) in section.named(key) {
        match known.iter().position(|k| k == name) {
            Some(index) => found.push((index, own)),
            None => {
                let message =
                    format!("there is none of this name, known are {}", names(known.iter().copied()));
                own.fault_here(message);
            }
        }
    }
    found
}
