//! Gears: joints with coordinates, ratios that do not contradict each other.

use adaptive::spec::{GearSpec, JointSpec};
use ffr_dynamics::system::gear::{GearJoint, check};

use super::super::check::Checker;
use super::super::section::Section;

/// The gears that are free of faults; `joints` are those of the tree.
pub fn gears(checker: &mut Checker, root: &Section, joints: &[JointSpec]) -> Vec<GearSpec> {
    let facts: Vec<GearJoint<'_>> = joints.iter().map(gear_joint).collect();
    let mut built = Vec::new();
    let mut accepted = Vec::new();
    for (name, section) in root.named("gears") {
        let (first, second) =
            (side(checker, root, section, "first", joints), side(checker, root, section, "second", joints));
        let (Some(first), Some(second), Some(ratio)) = (first, second, section.number("ratio")) else {
            continue;
        };
        let named = |(joint, k): (usize, usize)| (joints[joint].name.clone(), k);
        accepted.push(ffr_dynamics::system::GearSpec {
            name: name.clone(),
            first: named(first),
            second: named(second),
            ratio,
            offset: 0.0,
        });
        if let Err(fault) = check(&accepted, &facts) {
            checker.fault_in(section, "ratio", fault.to_string());
            accepted.pop();
            continue;
        }
        built.push(GearSpec { name: name.clone(), first, second, ratio });
    }
    built
}

/// What gears ask of a joint: which of its motions are prescribed; rates have no places before the run.
fn gear_joint(joint: &JointSpec) -> GearJoint<'_> {
    let is_free = |k: usize| joint.coordinates.get(k).is_none_or(|c| c.motion.is_none());
    GearJoint { name: &joint.name, kind: joint.kind, rates: std::array::from_fn(|k| is_free(k).then_some(k)) }
}

/// Joint and coordinate that `key` and `key_coordinate` name.
fn side(
    checker: &mut Checker,
    root: &Section,
    section: &Section,
    key: &str,
    joints: &[JointSpec],
) -> Option<(usize, usize)> {
    let name = section.text(key)?;
    let Some((_, joint)) = root.named("joints").iter().find(|(other, _)| other == name) else {
        let known: Vec<&str> = root.named("joints").iter().map(|(name, _)| name.as_str()).collect();
        checker.unknown_name(section, key, "joint", &known);
        return None;
    };
    if joint.boolean("closes_loop") == Some(true) {
        checker.fault_in(
            section,
            key,
            format!("joint \"{name}\" closes a loop and has no coordinates; name one of the tree"),
        );
        return None;
    }
    let index = joints.iter().position(|joint| joint.name == name)?;
    let kind = joints[index].kind;
    let coordinates = kind.quaternion().unwrap_or(kind.n_velocities());
    let number = format!("{key}_coordinate");
    let Some(k) = section.integer(&number) else {
        if coordinates == 1 {
            return Some((index, 0));
        }
        let message = match coordinates {
            0 => format!(
                "joint \"{name}\" is {} and has no coordinate for a gear: a displacement, or an angle about an axis",
                kind.name()
            ),
            n => format!(
                "joint \"{name}\" has {n} coordinates for a gear; add \"{number}\", from 0 to {}",
                n - 1
            ),
        };
        checker.fault_in(section, key, message);
        return None;
    };
    if k >= coordinates {
        checker.fault_in(
            section,
            &number,
            format!(
                "joint \"{name}\" is {} and has {coordinates} coordinates for a gear, counted from 0",
                kind.name()
            ),
        );
        return None;
    }
    Some((index, k))
}
