//! Writes a checked scenario back as TOML, defaults included.

use std::fmt::Write as _;

use super::section::{Checked, Item, Section, join};

/// The scenario as TOML that reads back to the same values. Angles are in radians.
pub fn write(root: &Section) -> String {
    let mut out = String::new();
    table(root, "", &mut out);
    out
}

/// Whether a default has no meaning beside what was given; writing it would be a fault when read back.
fn is_meaningless(section: &Section, item: &Item) -> bool {
    !item.given
        && match item.name {
            "discretisation" | "reduction" | "frame" => section.text("model") == Some("rigid"),
            "orientation" => section.given("normal"),
            "elements" => section.given("knots"),
            "modes" => section.text("method") == Some("all"),
            "initial" => section.given("value"),
            _ => false,
        }
}

fn table(section: &Section, path: &str, out: &mut String) {
    let items = || section.items.iter().filter(|item| !is_meaningless(section, item));
    for item in items() {
        if let Some(value) = scalar(&item.value) {
            // Writing to a string cannot fail.
            let _ = writeln!(out, "{} = {value}", item.name);
        }
    }
    for item in items() {
        subtables(item, &join(path, item.name), out);
    }
}

fn subtables(item: &Item, path: &str, out: &mut String) {
    let mut header = |open: &str, path: &str, close: &str, section: &Section| {
        let _ = writeln!(out, "\n{open}{path}{close}");
        table(section, path, out);
    };
    match &item.value {
        Checked::Table(section) => header("[", path, "]", section),
        Checked::Tables(list) => list.iter().for_each(|s| header("[[", path, "]]", s)),
        Checked::Named(list) => {
            for (name, section) in list {
                header("[", &join(path, name), "]", section);
            }
        }
        _ => {}
    }
}

fn scalar(value: &Checked) -> Option<String> {
    let number = |x: &f64| format!("{x:?}");
    let list = |v: &[f64]| format!("[{}]", v.iter().map(number).collect::<Vec<_>>().join(", "));
    match value {
        Checked::Text(s) => Some(toml::Value::String(s.clone()).to_string()),
        Checked::Number(x) => Some(number(x)),
        Checked::Integer(i) => Some(i.to_string()),
        Checked::Numbers(v) => Some(list(v)),
        Checked::Lists(rows) => {
            Some(format!("[{}]", rows.iter().map(|r| list(r)).collect::<Vec<_>>().join(", ")))
        }
        Checked::Counts(v) if v.len() == 1 => Some(v[0].to_string()),
        Checked::Counts(v) => {
            Some(format!("[{}]", v.iter().map(u64::to_string).collect::<Vec<_>>().join(", ")))
        }
        Checked::Table(_) | Checked::Named(_) | Checked::Tables(_) | Checked::Invalid => None,
    }
}
