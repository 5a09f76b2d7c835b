//! Numbers with a unit: `"10 mm"`, `"20 deg"`, `"210 GPa"`.

use super::document::{Node, Value};

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
    &[("N/m³", 1.0), ("N/m3", 1.0), ("N/mm³", 1e9), ("N/mm3", 1e9)],
];

/// All units, a list for every quantity.
pub fn all() -> impl Iterator<Item = Vec<&'static str>> {
    UNITS.iter().map(|units| units.iter().map(|(name, _)| *name).collect())
}

/// Units in which a key with the unit `unit` may be given, its own first; none for numbers without unit.
pub fn of(unit: &str) -> Units {
    UNITS.iter().find(|units| units[0].0 == unit).copied().unwrap_or_default()
}

/// The number and the unit of a text such as `10 mm`: a number, a space and anything.
fn split(text: &str) -> Option<(f64, &str)> {
    let (number, unit) = text.trim().split_once(' ')?;
    Some((number.parse().ok()?, unit.trim()))
}

/// `node` with texts that are numbers with a unit replaced by numbers in `unit`, in arrays too; `None` if nothing is to be replaced.
///
/// # Errors
/// What is wrong with the first text whose unit does not belong to `unit`.
pub fn converted(node: &Node, unit: &str) -> Result<Option<Node>, String> {
    let value = match &node.value {
        Value::Text(text) => {
            let Some((number, given)) = split(text) else { return Ok(None) };
            let units = of(unit);
            let Some((_, factor)) = units.iter().find(|(name, _)| *name == given) else {
                return Err(match units {
                    [] => format!(
                        "must be a number in SI units, without \"{given}\": units are not understood here"
                    ),
                    _ => {
                        let known: Vec<&str> = units.iter().map(|(name, _)| *name).collect();
                        format!("unknown unit \"{given}\", known here are {}", known.join(", "))
                    }
                });
            };
            Value::Float(number * factor)
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
    fn the_unit_of_every_key_is_one_or_has_none_beside_it() {
        // A unit of a key is the first of its list: no list is found by a unit that is not the keys'.
        for units in UNITS {
            assert_eq!(units[0].1.to_bits(), 1.0_f64.to_bits(), "{units:?}");
            let mut names: Vec<&str> = units.iter().map(|(name, _)| *name).collect();
            names.sort_unstable();
            names.dedup();
            assert_eq!(names.len(), units.len());
        }
        assert!(of("–").is_empty() && of("").is_empty());
    }
}
