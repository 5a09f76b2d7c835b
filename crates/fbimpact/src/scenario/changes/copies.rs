//! `[bodies.NAME.copies]`: bodies in place of one.

use std::collections::{HashMap, HashSet};

use result_files::toml_text::document::{Entry, Node, Origin, Value};

use super::arrangements::{Pose, poses};
use crate::scenario::check::Checker;
use crate::scenario::section::join;
use crate::scenario::tables::COPIED;

/// Puts copies in place of the bodies that ask for them; paths of what was made are noted in `made`.
pub fn expand(checker: &mut Checker, bodies: &mut Vec<Entry>, made: &mut HashMap<String, String>) {
    let key_of = |entry: &Entry| match &entry.node.value {
        Value::Table(keys) => keys.iter().position(|e| e.key == "copies"),
        _ => None,
    };
    let given: HashSet<String> = bodies.iter().map(|entry| entry.key.clone()).collect();
    for mut entry in std::mem::take(bodies) {
        let Some(at) = key_of(&entry) else {
            bodies.push(entry);
            continue;
        };
        let Value::Table(keys) = &mut entry.node.value else { continue };
        let path = join("bodies", &entry.key);
        let asked: Vec<Entry> =
            keys.iter().filter(|e| COPIED.iter().any(|k| is(e, k.name))).cloned().collect();
        let section = checker.section(COPIED, &asked, &path, &entry.node.origin, None);
        let origin = keys.remove(at).node.origin;
        let Some(poses) = poses(&section) else {
            bodies.push(entry);
            continue;
        };
        for (i, pose) in poses.iter().enumerate() {
            let mut copy = Entry { key: format!("{}-{}", entry.key, i + 1), ..entry.clone() };
            if given.contains(&copy.key) {
                let message = format!("body \"{}\" has the name of copy {}, choose another", copy.key, i + 1);
                checker.fault(&origin, join(&path, "copies"), None, message);
                break;
            }
            place(&mut copy.node, pose, &origin);
            made.insert(join("bodies", &copy.key), path.clone());
            bodies.push(copy);
        }
    }
}

/// Whether `entry` gives the key `name`, in degrees or not.
fn is(entry: &Entry, name: &str) -> bool {
    entry.key == name || entry.key.strip_suffix("_deg") == Some(name)
}

/// Gives a body the pose of a copy.
fn place(body: &mut Node, pose: &Pose, origin: &Origin) {
    let Value::Table(keys) = &mut body.value else { return };
    for (key, numbers) in pose.keys() {
        let number = |x: &f64| Node { value: Value::Float(*x), origin: origin.clone() };
        let node = Node { value: Value::Array(numbers.iter().map(number).collect()), origin: origin.clone() };
        keys.retain(|entry| !is(entry, key));
        keys.push(Entry { key: key.to_owned(), origin: origin.clone(), node });
    }
}
