//! The tree that the joints form: every body is the child of one joint at most, and nothing is a
//! descendant of itself.

use super::super::super::section::Section;

/// A joint, as far as the tree is concerned.
#[derive(Debug, Clone, Copy)]
pub struct Link<'a> {
    /// Name of the joint.
    pub name: &'a str,
    /// Body of the file nearer to ground; none on ground.
    pub parent: Option<usize>,
    /// Body of the file that is the child of the joint.
    pub child: Option<usize>,
    /// Whether the joint is a constraint between bodies that are children of other joints.
    pub closes_loop: bool,
}

/// Reports bodies that are children of two joints, and joints that form a cycle.
pub fn check(root: &Section, joints: &[Link<'_>]) {
    let bodies = root.named("bodies");
    let mut carried: Vec<Option<&Link<'_>>> = vec![None; bodies.len()];
    for joint in joints.iter().filter(|j| !j.closes_loop) {
        let Some(slot) = joint.child.and_then(|b| carried.get_mut(b)) else { continue };
        let Some(first) = slot else {
            *slot = Some(joint);
            continue;
        };
        if let Some(side) = side(root, joint, "child") {
            let message = format!(
                "is over-constrained: it is the child of joint \"{}\" already; set closes_loop = true on one of the two",
                first.name
            );
            side.fault("body", message);
        }
    }
    for start in 0..carried.len() {
        report_cycle(root, &carried, start);
    }
}

/// The table of one side of a joint.
fn side<'a>(root: &'a Section, joint: &Link<'_>, side: &str) -> Option<&'a Section> {
    root.one_of("joints", joint.name)?.table(side)
}

/// Reports the cycle whose first body in the order of the file is `start`, if there is one.
fn report_cycle(root: &Section, carried: &[Option<&Link<'_>>], start: usize) {
    let name = |body: usize| root.named("bodies").get(body).map_or("", |(name, _)| name.as_str());
    let mut path = format!("\"{}\"", name(start));
    let mut body = start;
    for _ in 0..carried.len() {
        let Some(joint) = carried[body] else { return };
        let Some(parent) = joint.parent else { return };
        path += &format!(" -> joint \"{}\" -> \"{}\"", joint.name, name(parent));
        if parent == start {
            let Some(first) = carried[start] else { return };
            if let Some(side) = side(root, first, "parent") {
                let message = format!(
                    "joints form a cycle: {path}; turn a joint around or set closes_loop = true on one"
                );
                side.fault("body", message);
            }
            return;
        }
        if parent < start {
            return; // not on a cycle, or on one that an earlier body reports
        }
        body = parent;
    }
}
