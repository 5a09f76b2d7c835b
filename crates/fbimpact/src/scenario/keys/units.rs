//! Numbers with a unit: `"10 mm"`, `"20 deg"`, `"210 GPa"`.

use result_files::toml_text::document::{Node, Value};

/// Units with their factors to the first one, which is that of the keys.
type Units = &'static [(&'static str, f64)];

const PI: f64 = std::f64::consts::PI;

const UNITS: &[Units] = &[
    &[("m", 1.0), ("cm", 1e-2), ("mm", 1e-3), ("µm", 1e-6), ("um", 1e-6), ("km", 1e3), ("in", 0.0254)],
    &[("s", 1.0), ("ms", 1e-3), ("µs", 1e-6), ("us", 1e-6), ("min", 60.0)],
    &[("rad", 1.0), ("deg", PI / 180.0), ("°", PI / 180.0)],
    &[("rad/s", 1.0), ("deg/s", PI / 180.0), ("rpm", PI / 30.0), ("1/min", PI / 30.0)],
    &[("m/s", 1.0), ("mm/s", 1e-3), ("km/h", 1.0 / 3.6)],
    &[("m/s²", 1.0), ("m/s2", 1.0), ("mm/s²", 1e-3), ("mm/s2", 1e-3)],
    &[("Hz", 1.0), ("kHz", 1e3), ("MHz", 1e6)],
    &[("Pa", 1.0), ("kPa", 1e3), ("MPa", 1e6), ("GPa", 1e9), ("N/mm²", 1e6), ("N/mm2", 1e6)],
    &[("kg", 1.0), ("g", 1e-3), ("t", 1e3)],
    &[("kg/m³", 1.0), ("kg/m3", 1.0), ("g/cm³", 1e3), ("g/cm3", 1e3), ("t/mm³", 1e12), ("t/mm3", 1e12)],
    &[("kg m²", 1.0), ("kg m2", 1.0), ("kg mm²", 1e-6), ("kg mm2", 1e-6)],
    &[("N", 1.0), ("mN", 1e-3), ("kN", 1e3)],
    &[("N m", 1.0), ("Nm", 1.0), ("N mm", 1e-3), ("Nmm", 1e-3), ("kN m", 1e3)],
    &[("N/m", 1.0), ("N/mm", 1e3), ("kN/m", 1e3)],
    &[("N m/rad", 1.0), ("Nm/rad", 1.0), ("N mm/rad", 1e-3), ("Nmm/rad", 1e-3), ("N m/deg", 180.0 / PI)],
    &[("N s/m", 1.0), ("Ns/m", 1.0), ("N s/mm", 1e3), ("Ns/mm", 1e3)],
    &[("N m s/rad", 1.0), ("Nms/rad", 1.0), ("N mm s/rad", 1e-3), ("N m s/deg", 180.0 / PI)],
    &[("s/m", 1.0), ("s/mm", 1e3)],
    &[("s/rad", 1.0), ("s/deg", 180.0 / PI)],
    &[("m/rad", 1.0), ("mm/rad", 1e-3), ("mm/rev", 0.5e-3 / PI), ("m/rev", 0.5 / PI)],
    &[("rad/m", 1.0), ("rad/mm", 1e3), ("rev/mm", 2e3 * PI), ("rev/m", 2.0 * PI)],
    &[("N/m³", 1.0), ("N/m3", 1.0), ("N/mm³", 1e9), ("N/mm3", 1e9)],
];

/// Units of quantities along a displacement and of the same about an axis, where a key has either
/// by the coordinate that it is of.
const PAIRS: [(&str, &str); 6] = [
    ("m", "rad"),
    ("m/s", "rad/s"),
    ("N", "N m"),
    ("N/m", "N m/rad"),
    ("N s/m", "N m s/rad"),
    ("s/m", "s/rad"),
];

/// All units, a list for every quantity.
pub fn all() -> impl Iterator<Item = Vec<&'static str>> {
    UNITS.iter().map(|units| units.iter().map(|(name, _)| *name).collect())
}

/// Units in which a key with the unit `unit` may be given, its own first; none for numbers without
/// unit. A key whose unit depends on another one has them all between commas, `m, rad`.
pub fn of(unit: &str) -> Vec<(&'static str, f64)> {
    let lists = unit.split(", ").filter_map(|unit| UNITS.iter().find(|units| units[0].0 == unit));
    lists.flat_map(|units| units.iter().copied()).collect()
}

/// Names of the units of `of`.
pub fn names(unit: &str) -> String {
    of(unit).iter().map(|(name, _)| *name).collect::<Vec<_>>().join(", ")
}

/// The unit of keys, such as `m`, in which each text in `node` counts, with its place; of keys
/// alone whose unit depends on another one.
pub fn given(node: &Node, unit: &str) -> Vec<(usize, &'static str)> {
    if !unit.contains(", ") {
        return Vec::new();
    }
    let of_item = |item: &Node| {
        let Value::Text(text) = &item.value else { return None };
        let (_, name) = split(text)?;
        UNITS.iter().find(|units| units.iter().any(|(known, _)| *known == name)).map(|units| units[0].0)
    };
    match &node.value {
        Value::Array(items) => {
            items.iter().enumerate().filter_map(|(k, item)| Some((k, of_item(item)?))).collect()
        }
        _ => of_item(node).map(|unit| (0, unit)).into_iter().collect(),
    }
}

/// The unit in place of `unit`, one of keys, where the coordinate is an angle, or is none; nothing
/// if it fits already.
pub fn in_place_of(unit: &str, is_angle: bool) -> Option<&'static str> {
    PAIRS.iter().find_map(|(along, about)| match is_angle {
        true => (*along == unit).then_some(*about),
        false => (*about == unit).then_some(*along),
    })
}

/// The unit of keys that `name` is a multiple of, and the factor to it, of all units there are.
pub fn known(name: &str) -> impl Iterator<Item = (&'static str, f64)> {
    let of_list = move |units: &Units| Some((units[0].0, units.iter().find(|(known, _)| *known == name)?.1));
    UNITS.iter().filter_map(of_list)
}

/// The number and the unit of a text such as `10 mm` or `10mm`: a number, a space if anything but a
/// known unit follows, and what follows.
fn split(text: &str) -> Option<(f64, &str)> {
    let text = text.trim();
    if let Some((number, unit)) = text.split_once(' ') {
        return Some((number.parse().ok()?, unit.trim()));
    }
    let start = text.find(|c: char| !c.is_ascii_digit() && !"+-.eE_".contains(c))?;
    let (number, unit) = text.split_at(start);
    let is_known = UNITS.iter().flat_map(|units| units.iter()).any(|(name, _)| *name == unit);
    Some((number.parse().ok().filter(|_| is_known)?, unit))
}

/// `node` with texts that are numbers with a unit replaced by numbers in `unit`, in arrays too;
/// `None` if nothing is to be replaced.
///
/// # Errors
/// What is wrong with the first text whose unit does not belong to `unit`.
pub fn converted(node: &Node, unit: &str) -> Result<Option<Node>, String> {
    let value = match &node.value {
        Value::Text(text) => {
            let Some((number, given)) = split(text) else { return Ok(None) };
            let units = of(unit);
            let Some((_, factor)) = units.iter().find(|(name, _)| *name == given) else {
                return Err(match units.is_empty() {
                    true => format!(
                        "must be a number in SI units, without \"{given}\": units are not understood here"
                    ),
                    false => format!("unknown unit \"{given}\", known here are {}", names(unit)),
                });
            };
            Value::Measured(number * factor, text.clone())
        }
        Value::Array(items) => {
            let found = items.iter().map(|item| converted(item, unit)).collect::<Result<Vec<_>, _>>()?;
            if found.iter().all(Option::is_none) {
                return Ok(None);
            }
            let items = found.into_iter().zip(items).map(|(new, old)| new.unwrap_or_else(|| old.clone()));
            Value::Array(items.collect())
        }
        _ => return Ok(None),
    };
    Ok(Some(Node { value, origin: node.origin.clone() }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_stand_before_their_unit_with_a_space_or_without() {
        let splits =
            [("10 mm", Some((10.0, "mm"))), ("10mm", Some((10.0, "mm"))), ("-1.5e-3m", Some((-1.5e-3, "m")))];
        for (text, split_to) in splits {
            assert_eq!(split(text), split_to, "{text}");
        }
        // What has no unit after a number is a text.
        for text in ["2nd", "mm", "3d.csv", "inf", "-", "7"] {
            assert_eq!(split(text), None, "{text}");
        }
    }

    #[test]
    fn the_unit_of_every_key_is_one_or_has_none_beside_it() {
        // A unit of a key is the first of its list: no list is found by a unit that is not the
        // keys'.
        for units in UNITS {
            assert_eq!(units[0].1.to_bits(), 1.0_f64.to_bits(), "{units:?}");
            let mut names: Vec<&str> = units.iter().map(|(name, _)| *name).collect();
            names.sort_unstable();
            names.dedup();
            assert_eq!(names.len(), units.len());
        }
        assert!(of("–").is_empty() && of("").is_empty());
        for (along, about) in PAIRS {
            assert!(!of(along).is_empty() && !of(about).is_empty(), "{along}, {about}");
        }
    }
}
