//! Gears: joints with coordinates, ratios that do not contradict each other.

use adaptive::spec::{GearSpec, JointSpec};
use ffr_dynamics::system::model::gear::{GearJoint, check};

use super::super::keys::units;
use super::super::section::Section;

/// The gears that are free of faults; `joints` are those of the tree.
pub fn gears(root: &Section, joints: &[JointSpec]) -> Vec<GearSpec> {
    let facts: Vec<GearJoint<'_>> = joints.iter().map(gear_joint).collect();
    let mut built = Vec::new();
    let mut accepted = Vec::new();
    for (name, section) in root.named("gears") {
        let (first, second) = (side(root, section, "first", joints), side(root, section, "second", joints));
        let (Some(first), Some(second), Some(ratio)) = (first, second, section.number("ratio")) else {
            continue;
        };
        if check_unit(section, [first, second].map(|(joint, k)| joints[joint].kind.is_angle(k))).is_none() {
            continue;
        }
        let named = |(joint, k): (usize, usize)| (joints[joint].name.clone(), k);
        accepted.push(ffr_dynamics::system::GearSpec {
            name: name.clone(),
            first: named(first),
            second: named(second),
            ratio,
            offset: 0.0,
        });
        if let Err(fault) = check(&accepted, &facts) {
            section.fault("ratio", fault.to_string());
            accepted.pop();
            continue;
        }
        built.push(GearSpec { name: name.clone(), first, second, ratio });
    }
    built
}

/// Faults a ratio whose unit is not that of the second coordinate by that of the first; they are
/// angles or displacements.
fn check_unit(section: &Section, are_angles: [bool; 2]) -> Option<()> {
    let given = section.item("ratio").and_then(|item| item.units.first());
    let [first, second] = are_angles.map(|is_angle| if is_angle { "rad" } else { "m" });
    let wanted = format!("{second}/{first}");
    if given.is_none_or(|(_, unit)| *unit == wanted) {
        return Some(());
    }
    let message = match first == second {
        true => "wrong unit: both coordinates are of one kind, the ratio is a plain number".to_owned(),
        false => format!("wrong unit: the ratio is in {wanted}, known here are {}", units::names(&wanted)),
    };
    section.refuse("ratio", message)
}

/// What gears ask of a joint: which of its motions are prescribed; rates have no places before the
/// run.
fn gear_joint(joint: &JointSpec) -> GearJoint<'_> {
    let is_free = |k: usize| joint.coordinates.get(k).is_none_or(|c| c.motion.is_none());
    GearJoint { name: &joint.name, kind: joint.kind, rates: std::array::from_fn(|k| is_free(k).then_some(k)) }
}

/// Joint and coordinate that `key` and `key_coordinate` name.
fn side(root: &Section, section: &Section, key: &str, joints: &[JointSpec]) -> Option<(usize, usize)> {
    let name = section.text(key)?;
    let Some(joint) = root.one_of("joints", name) else {
        let known: Vec<&str> = root.named("joints").iter().map(|(name, _)| name.as_str()).collect();
        section.unknown_name(key, "joint", &known);
        return None;
    };
    if joint.boolean("closes_loop") == Some(true) {
        return section.refuse(
            key,
            format!("joint \"{name}\" closes a loop and has no coordinates; name one of the tree"),
        );
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
        return section.refuse(key, message);
    };
    if k >= coordinates {
        return section.refuse(
            &number,
            format!(
                "joint \"{name}\" is {} and has {coordinates} coordinates for a gear, counted from 0",
                kind.name()
            ),
        );
    }
    Some((index, k))
}
