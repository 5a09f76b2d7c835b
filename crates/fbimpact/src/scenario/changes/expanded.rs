//! Tables that stand for many: each becomes tables as a user could have written them, and faults of those are told once, at
//! the key that stands in the file.

use std::collections::{HashMap, HashSet};

use result_files::toml_text::document::{Entry, Node, Value};
use result_files::toml_text::fault::Fault;

use super::{copies, pairs};
use crate::scenario::check::Checker;

/// Paths of tables that were made, each with that of the table which stands in the file.
#[derive(Debug, Default)]
pub struct Expanded(HashMap<String, String>);

impl Expanded {
    /// Puts copies of bodies and contacts of many bodies into `document`.
    pub fn new(checker: &mut Checker, document: &mut Node) -> Self {
        let mut made = HashMap::new();
        let Value::Table(root) = &mut document.value else { return Self(made) };
        let mut names = Vec::new();
        if let Some(bodies) = table(root, "bodies") {
            copies::expand(checker, bodies, &mut made);
            names.extend(bodies.iter().map(|entry| entry.key.clone()));
        }
        if let Some(contacts) = table(root, "contacts") {
            pairs::expand(checker, contacts, &names, &mut made);
        }
        Self(made)
    }

    /// The faults with keys as they stand in the file, of those with one place and key the first.
    pub fn told(&self, faults: Vec<Fault>) -> Vec<Fault> {
        let written: HashSet<&str> = self.0.values().map(String::as_str).collect();
        let mut known = HashSet::new();
        let told = |mut fault: Fault| {
            let end = table_end(&fault.key);
            if let Some(path) = self.0.get(&fault.key[..end]) {
                fault.key.replace_range(..end, path);
            }
            let is_of_many = written.contains(&fault.key[..table_end(&fault.key)]);
            let is_told = is_of_many && !known.insert((format!("{:?}", fault.location), fault.key.clone()));
            (!is_told).then_some(fault)
        };
        faults.into_iter().filter_map(told).collect()
    }
}

/// Where the name of the table ends in the path of a key, `bodies.NAME` of `bodies.NAME.velocity[2]`.
fn table_end(key: &str) -> usize {
    key.match_indices(['.', '[']).nth(1).map_or(key.len(), |(end, _)| end)
}

/// The entries of the table `key`.
fn table<'a>(entries: &'a mut [Entry], key: &str) -> Option<&'a mut Vec<Entry>> {
    match &mut entries.iter_mut().find(|e| e.key == key)?.node.value {
        Value::Table(list) => Some(list),
        _ => None,
    }
}
