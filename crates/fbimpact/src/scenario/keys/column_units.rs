//! Units in the names of columns, as programs and instruments write them: `F [kN]`, `Force (lbf)`, `Time / ms`, `Force in kN`, `t_ms`,
//! `Time msec`. A unit is converted or refused, and never passed over.

use super::units;

/// Other names of units, with the unit of keys and the factor to it.
const OTHERS: &[(&str, &str, f64)] = &[
    ("sec", "s", 1.0),
    ("second", "s", 1.0),
    ("msec", "s", 1e-3),
    ("millisec", "s", 1e-3),
    ("millisecond", "s", 1e-3),
    ("usec", "s", 1e-6),
    ("µsec", "s", 1e-6),
    ("microsec", "s", 1e-6),
    ("microsecond", "s", 1e-6),
    ("ns", "s", 1e-9),
    ("nsec", "s", 1e-9),
    ("minute", "s", 60.0),
    ("h", "s", 3600.0),
    ("hour", "s", 3600.0),
    ("newton", "N", 1.0),
    ("millinewton", "N", 1e-3),
    ("kilonewton", "N", 1e3),
    ("MN", "N", 1e6),
    // The kilogram-force and the pound-force by definition: 9.80665 m/s² of 1 kg and of 0.45359237 kg.
    ("kgf", "N", 9.80665),
    ("kp", "N", 9.80665),
    ("lbf", "N", 4.448_221_615_260_5),
    ("klbf", "N", 4_448.221_615_260_5),
    ("kip", "N", 4_448.221_615_260_5),
    ("metre", "m", 1.0),
    ("meter", "m", 1.0),
    ("millimetre", "m", 1e-3),
    ("millimeter", "m", 1e-3),
    ("micron", "m", 1e-6),
    ("nm", "m", 1e-9),
    ("inch", "m", 0.0254),
    ("ft", "m", 0.3048),
    ("foot", "m", 0.3048),
    ("radian", "rad", 1.0),
    ("degree", "rad", std::f64::consts::PI / 180.0),
    ("rev/min", "rad/s", std::f64::consts::PI / 30.0),
    ("ft/s", "m/s", 0.3048),
    ("in/s", "m/s", 0.0254),
    ("mph", "m/s", 0.447_04),
    ("g", "m/s²", 9.80665),
    ("ft/s²", "m/s²", 0.3048),
    ("bar", "Pa", 1e5),
    ("psi", "Pa", 6_894.757_293_168),
    ("newton metre", "N m", 1.0),
    ("newton meter", "N m", 1.0),
    // 4.4482216152605 N by 0.3048 m and by 0.0254 m.
    ("lbf ft", "N m", 1.355_817_948_331_400_4),
    ("ft lbf", "N m", 1.355_817_948_331_400_4),
    ("lbf in", "N m", 0.112_984_829_027_616_7),
    ("in lbf", "N m", 0.112_984_829_027_616_7),
];

/// Signs that are units, but of nothing that a key is: raw signals, and the pound, which is a mass or a force.
const NEVER: [&str; 9] = ["V", "mV", "µV", "mA", "lb", "lbs", "pound", "volt", "dB"];

/// The unit of keys and the factor to it.
pub type Found = (&'static str, f64);

/// How clearly a name says that a unit follows.
#[derive(Clone, Copy, PartialEq)]
enum Mark {
    /// Brackets, a slash between blanks: nothing else stands there.
    Sure,
    /// A slash in a word or `in`: a quotient or a place may follow.
    Likely,
    /// A blank: part of the name, perhaps.
    Blank,
    /// An underscore, or nothing at all: part of the name, mostly.
    Weak,
}

/// The unit in the name of a column, one in which a key with the unit `unit` may be given. `None` of a name without unit, or if the key
/// has none.
///
/// # Errors
/// What is wrong with a unit that does not belong to `unit`, and with what may be one.
pub fn of_name(name: &str, unit: &str) -> Result<Option<Found>, String> {
    if units::of(unit).is_empty() {
        return Ok(None);
    }
    let (given, mark) = marked(name.trim());
    if is_empty(&given) {
        return Ok(None);
    }
    // A column of inches may be meant, or something that is in.
    let is_in = given == "in" && mark == Mark::Blank;
    match read(&given, unit).filter(|_| !is_in) {
        Some(found) => Ok(Some(found)),
        None if is_refused(&given, mark, unit) => Err(refusal(&given, unit)),
        None => Ok(None),
    }
}

/// The unit that a cell below the names holds: `ms`, `[ms]`, `(ms)`; `None` if it holds none.
///
/// # Errors
/// What is wrong with anything else.
pub fn of_cell(cell: &str, unit: &str) -> Result<Option<Found>, String> {
    let bare = cell.trim().trim_matches(['[', ']', '(', ')', '<', '>', '{', '}']).trim();
    if is_empty(bare) || units::of(unit).is_empty() {
        return Ok(None);
    }
    read(bare, unit).map(Some).ok_or_else(|| refusal(bare, unit))
}

fn is_empty(unit: &str) -> bool {
    matches!(unit, "" | "-" | "–" | "1")
}

/// What stands where a unit does, and how clearly that is so.
fn marked(name: &str) -> (String, Mark) {
    for (open, close) in [('[', ']'), ('(', ')'), ('{', '}'), ('<', '>')] {
        // A remark may follow in brackets of its own.
        let behind = name.split_once(open).map(|(_, behind)| behind);
        if let Some((inside, _)) = behind.and_then(|behind| behind.split_once(close)) {
            return (inside.trim().to_owned(), Mark::Sure);
        }
    }
    let words: Vec<&str> = name.split_whitespace().collect();
    // "Torque N m" ends with two words.
    let pair = words.get(1..).map(|behind| behind[behind.len().saturating_sub(2)..].join(" "));
    let pair = pair.filter(|pair| units::known(&normal(pair)).next().is_some());
    if let Some((_, behind)) = name.split_once(" / ") {
        (behind.trim().to_owned(), Mark::Sure)
    } else if let Some((_, behind)) = name.split_once(" in ") {
        (behind.trim().to_owned(), Mark::Likely)
    } else if let [_, .., last] = words[..] {
        (pair.unwrap_or_else(|| last.to_owned()), Mark::Blank)
    } else if let Some((_, behind)) = name.split_once('/') {
        (behind.to_owned(), Mark::Likely)
    } else {
        // A name may be a unit and nothing else.
        (name.rsplit_once(['_', ':']).map_or(name, |(_, behind)| behind).to_owned(), Mark::Weak)
    }
}

/// How `given` may be spelt. Words count in any letters; signs as they are, for m and M are different prefixes.
fn spellings(given: &str) -> Vec<String> {
    let sign = normal(given);
    let word = sign.to_lowercase();
    let singular = match word.as_str() {
        "feet" => Some("foot"),
        "inches" => Some("inch"),
        _ => word.strip_suffix('s').filter(|one| one.len() > 2 && one.chars().all(char::is_alphabetic)),
    };
    let singular = singular.map(str::to_owned);
    let mut all = vec![sign];
    all.extend(singular);
    all.extend((word.len() > 3).then_some(word));
    all
}

/// `given` as a unit of a key with the unit `unit`.
fn read(given: &str, unit: &str) -> Option<Found> {
    let is_own = |found: &Found| unit.split(", ").any(|own| own == found.0);
    spellings(given).iter().find_map(|name| all_of(name).find(is_own))
}

/// What `name` is a unit of.
fn all_of(name: &str) -> impl Iterator<Item = Found> {
    units::known(name).chain(OTHERS.iter().filter(move |o| o.0 == name).map(|o| (o.1, o.2)))
}

/// Whether `given`, which is no unit of `unit`, is one of something else or may be meant as one.
fn is_refused(given: &str, mark: Mark, unit: &str) -> bool {
    let names = spellings(given);
    let is_unit = |name: &String| all_of(name).next().is_some() || NEVER.contains(&name.as_str());
    // KN, MS: in other letters the prefix is another one.
    let is_nearly = || units::of(unit).iter().any(|(known, _)| known.eq_ignore_ascii_case(&names[0]));
    match mark {
        Mark::Sure => true,
        Mark::Likely | Mark::Blank => names.iter().any(is_unit) || is_nearly(),
        // F_in and F_t are forces.
        Mark::Weak => OTHERS.iter().any(|o| o.0 == names[0] && (3..6).contains(&o.0.len())),
    }
}

fn refusal(given: &str, unit: &str) -> String {
    let names = units::names(unit);
    let first = units::of(unit).first().map_or("", |(name, _)| *name);
    format!(
        "\"{given}\" is no unit of this column: end its name with one in brackets, [{first}], and convert its numbers; known here are {names}"
    )
}

/// A word in letters that are spelt in one way: `N·m` and `N*m` are `N m`, `s^2` is `s²`.
fn normal(given: &str) -> String {
    let text = given.replace('μ', "µ").replace("**", "^").replace("^2", "²").replace("^3", "³");
    let text = text.replace(['·', '⋅', '*', '-', '.'], " ").replace("/sec", "/s");
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_in_any_common_form_are_converted() {
        for name in [
            "F [kN]",
            "F(kN)",
            "force / kN",
            "F_kN",
            "F/kN",
            "Force kN",
            "Force in kN",
            "Force {kN}",
            "Force <kN>",
            "Force:kN",
            "Force (kilonewtons)",
            "Force Kilonewton",
            "F [kN] (measured)",
            "Channel 1 (kN)",
            "Force [ kN ]",
        ] {
            assert_eq!(of_name(name, "N"), Ok(Some(("N", 1e3))), "{name}");
        }
        for (name, unit, found) in [
            ("Time (msec)", "s", ("s", 1e-3)),
            ("Time (usec)", "s", ("s", 1e-6)),
            ("Time ms", "s", ("s", 1e-3)),
            ("t [μs]", "s", ("s", 1e-6)),
            ("Zeit in sec", "s", ("s", 1.0)),
            ("Seconds (Seconds)", "s", ("s", 1.0)),
            ("Force (lbf)", "N", ("N", 4.448_221_615_260_5)),
            ("Force / lbf", "N", ("N", 4.448_221_615_260_5)),
            ("F_lbf", "N", ("N", 4.448_221_615_260_5)),
            ("F [MN]", "N", ("N", 1e6)),
            ("angle [deg]", "m, rad", ("rad", std::f64::consts::PI / 180.0)),
            ("angle in degrees", "m, rad", ("rad", std::f64::consts::PI / 180.0)),
            ("Torque [N·m]", "N m", ("N m", 1.0)),
            ("Torque N m", "N m", ("N m", 1.0)),
            ("Torque N-mm", "N m", ("N m", 1e-3)),
            ("a [m/s^2]", "m/s²", ("m/s²", 1.0)),
            ("a (g)", "m/s²", ("m/s²", 9.80665)),
            ("travel (inches)", "m", ("m", 0.0254)),
            ("travel [in]", "m", ("m", 0.0254)),
            ("speed [m/sec]", "m/s", ("m/s", 1.0)),
            ("ms", "s", ("s", 1e-3)),
        ] {
            assert_eq!(of_name(name, unit), Ok(Some(found)), "{name}");
        }
    }

    #[test]
    fn what_is_no_unit_is_a_name_and_what_is_another_one_is_refused() {
        for name in [
            "F",
            "F_contact",
            "F [-]",
            "pressure/area",
            "F_in",
            "F_t",
            "Force on the left",
            "Force in bolt",
            "",
            "Sensor 3",
            "F ()",
        ] {
            assert_eq!(of_name(name, "N"), Ok(None), "{name}");
        }
        assert_eq!(of_name("F [kN]", ""), Ok(None));
        for name in [
            "F [kipf]",
            "F [s]",
            "F (ms)",
            "F / mm",
            "F/mm",
            "Force (V)",
            "Force V",
            "Force [mV]",
            "Force KN",
            "Force Mn",
            "Force (measured)",
            "Force / a",
            "Force in V",
            "Force lb",
            "Force (pounds)",
            "Force mm",
            "Force in",
            "F_psi",
            "Force [% of 3 kN]",
        ] {
            let message = of_name(name, "N").expect_err(name);
            assert!(message.contains("[N]") && message.ends_with("known here are N, mN, kN"), "{message}");
        }
        for name in ["Time MS", "travel in", "Time (samples)"] {
            assert!(of_name(name, if name.starts_with('t') { "m" } else { "s" }).is_err(), "{name}");
        }
        assert_eq!(of_cell("[ms]", "s"), Ok(Some(("s", 1e-3))));
        assert_eq!((of_cell("", "s"), of_cell("-", "s"), of_cell("kip", "")), (Ok(None), Ok(None), Ok(None)));
        assert!(of_cell("V", "N").is_err() && of_cell("run 3", "N").is_err());
    }

    #[test]
    fn other_names_have_the_units_of_keys() {
        for (name, unit, factor) in OTHERS {
            assert!(!units::of(unit).is_empty() && *factor > 0.0, "{name}");
            assert_eq!(normal(name), *name);
        }
        // By definition: a pound of 0.45359237 kg under 9.80665 m/s², on a square inch, at a foot.
        let pound: f64 = 0.453_592_37 * 9.80665;
        for (name, exact) in [
            ("lbf", pound),
            ("psi", pound / 0.0254_f64.powi(2)),
            ("lbf ft", pound * 0.3048),
            ("lbf in", pound * 0.0254),
        ] {
            let stated = OTHERS.iter().find(|o| o.0 == name).map_or(0.0, |o| o.2);
            // psi is stated to 13 digits; the others are exact to round-off.
            assert!((stated / exact - 1.0).abs() < 1e-12, "{name} {exact:?}");
        }
    }
}
