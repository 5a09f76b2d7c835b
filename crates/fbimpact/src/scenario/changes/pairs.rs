//! Contacts of many bodies: `contact_body = "ball-*"` stands for all bodies whose names begin so.

use std::collections::{HashMap, HashSet};

use result_files::toml_text::document::{Entry, Node, Value};
use result_files::toml_text::fault::nearest;

use crate::scenario::check::Checker;
use crate::scenario::section::join;

/// Most contacts that one table stands for; more are beyond any run.
const MOST: usize = 100_000;

/// The name of a body with what the star stands for; nothing if none stands in the table.
type Match<'a> = (&'a str, &'a str);

/// Puts a contact for each pair of bodies in place of those that name many; paths of what was made are noted in `made`.
pub fn expand(
    checker: &mut Checker,
    contacts: &mut Vec<Entry>,
    bodies: &[String],
    made: &mut HashMap<String, String>,
) {
    let mut names: HashSet<String> = contacts.iter().map(|entry| entry.key.clone()).collect();
    for entry in std::mem::take(contacts) {
        let Some([own, other]) = sides(&entry) else {
            contacts.push(entry);
            continue;
        };
        let path = join("contacts", &entry.key);
        let matches = [own, other].map(|(key, node)| matching(checker, &join(&path, key), node, bodies));
        let [Some(owns), Some(others)] = matches else { continue };
        let pairs = pairs(&owns, &others);
        if !(1..=MOST).contains(&pairs.len()) {
            let message = match pairs.len() {
                0 => "leaves no pair of different bodies".to_owned(),
                n => format!("makes {n} contacts, {MOST} are the most; name fewer bodies"),
            };
            checker.fault(&other.1.origin, join(&path, other.0), Some(other.1.shown()), message);
            continue;
        }
        for pair in pairs {
            let ends = pair.iter().filter(|(_, end)| !end.is_empty()).map(|(_, end)| format!("-{end}"));
            let mut contact = Entry { key: entry.key.clone() + &ends.collect::<String>(), ..entry.clone() };
            if !names.insert(contact.key.clone()) {
                let message = format!("contact \"{}\" is there already, choose another name", contact.key);
                checker.fault(&entry.origin, path, None, message);
                break;
            }
            name(&mut contact, pair.map(|(body, _)| body));
            made.insert(join("contacts", &contact.key), path.clone());
            contacts.push(contact);
        }
    }
}

/// The keys that name the bodies of a contact, with their values, if one of them names many.
fn sides(contact: &Entry) -> Option<[(&'static str, &Node); 2]> {
    let Value::Table(keys) = &contact.node.value else { return None };
    let side = |key: &'static str| Some((key, &keys.iter().find(|e| e.key == key)?.node));
    let sides = [side("contact_body")?, side("target_body")?];
    let is_many = |(_, node): &(_, &Node)| matches!(&node.value, Value::Text(text) if text.contains('*'));
    sides.iter().any(is_many).then_some(sides)
}

/// The bodies that the value `node` of the key `key` names; `None` if it is at fault.
fn matching<'a>(
    checker: &mut Checker,
    key: &str,
    node: &'a Node,
    bodies: &'a [String],
) -> Option<Vec<Match<'a>>> {
    let mut fault = |message: &str, suggestion: Option<String>| {
        checker.fault(&node.origin, key.to_owned(), Some(node.shown()), message.to_owned());
        checker.faults.amend_last(|fault| {
            fault.suggestion = suggestion;
        });
        None
    };
    let Value::Text(text) = &node.value else { return fault("must be the name of a body", None) };
    let Some((start, end)) = text.split_once('*') else { return Some(vec![(text, "")]) };
    if end.contains('*') {
        return fault("a name may have one * only", None);
    }
    let matched = |name: &'a String| {
        Some((name.as_str(), name.strip_prefix(start)?.strip_suffix(end)?.trim_matches('-')))
    };
    let found: Vec<Match<'a>> = bodies.iter().filter_map(matched).collect();
    if found.is_empty() {
        return fault("no body has a name like that", nearest(text, bodies.iter().map(String::as_str)));
    }
    Some(found)
}

/// Each pair of different bodies once.
fn pairs<'a>(own: &[Match<'a>], other: &[Match<'a>]) -> Vec<[Match<'a>; 2]> {
    let mut known = HashSet::new();
    let all = own.iter().flat_map(|a| other.iter().map(move |b| [*a, *b]));
    all.filter(|[a, b]| a.0 != b.0 && known.insert([a.0.min(b.0), a.0.max(b.0)])).collect()
}

/// Lets `contact` be one of these bodies.
fn name(contact: &mut Entry, bodies: [&str; 2]) {
    let Value::Table(keys) = &mut contact.node.value else { return };
    for (key, body) in ["contact_body", "target_body"].into_iter().zip(bodies) {
        if let Some(entry) = keys.iter_mut().find(|e| e.key == key) {
            entry.node.value = Value::Text(body.to_owned());
        }
    }
}
