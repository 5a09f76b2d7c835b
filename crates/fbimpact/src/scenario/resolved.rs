//! Writes a checked scenario back as TOML, defaults included.

use std::fmt::Write as _;

use super::build::{ContactFacts, hanging_joint};
use super::section::{Checked, Item, Section, join};
use crate::body_file::BodyFile;

/// The scenario as TOML that reads back to the same values. Angles are in radians.
pub fn write(root: &Section) -> String {
    let mut out = String::new();
    Writer { root }.table(root, "", &mut out);
    out
}

/// Writes the tables of a scenario.
struct Writer<'a> {
    root: &'a Section,
}

impl Writer<'_> {
    /// Whether a default has no meaning beside what was given; writing it would be a fault when read back.
    fn is_meaningless(&self, section: &Section, item: &Item) -> bool {
        let is_rigid = section.text("model") == Some("rigid");
        let file = section.body_file();
        let is_imported = file.is_some();
        let is_reduced = file.is_some_and(|f| matches!(f.body, BodyFile::Reduced(_)));
        let is_surface = section.text("model") != Some("hertz");
        !item.given
            && match item.name {
                "discretisation" | "geometric_stiffening" => is_rigid || is_imported,
                "reduction" | "frame" => is_rigid || is_reduced,
                "motion" => {
                    !is_rigid || section.table("geometry").and_then(|g| g.text("shape")) == Some("plane")
                }
                "position" | "velocity" | "angular_velocity" => self.hangs(section),
                "orientation" => section.given("normal"),
                "modes" => !is_surface,
                "ratio" => section.given("modal"),
                "static_answers" => section.text("method") == Some("all"),
                "tolerance" => self.contact(section).is_some_and(|c| c.search != "until-converged"),
                "target_utilisation" => self.contact(section).is_some_and(|c| c.model != "adaptive"),
                "division" => self.contact(section).is_some_and(|c| !c.is_refined()),
                "constraint" | "points" | "solver" | "friction" | "transfer" | "penalty" | "interval" => {
                    !is_surface
                }
                _ => false,
            }
    }

    /// Whether the table is that of a body that hangs on a joint.
    fn hangs(&self, section: &Section) -> bool {
        section.path.strip_prefix("bodies.").is_some_and(|name| hanging_joint(self.root, name).is_some())
    }

    /// The contact that a table is a part of.
    fn contact(&self, section: &Section) -> Option<ContactFacts<'_>> {
        let (name, _) = section.path.strip_prefix("contacts.")?.rsplit_once('.')?;
        let (_, contact) = self.root.named("contacts").iter().find(|(n, _)| n == name)?;
        ContactFacts::of(self.root, contact)
    }

    /// The default of a search for a penalty factor, which depends on the contact model.
    fn search(&self, section: &Section) -> Option<String> {
        let contact = self.contact(section).filter(|_| section.path.ends_with(".penalty"))?;
        (!section.given("search")).then(|| format!("search = {:?}", contact.search))
    }

    fn table(&self, section: &Section, path: &str, out: &mut String) {
        let items = || section.items.iter().filter(|item| !self.is_meaningless(section, item));
        let lines = items().filter_map(|item| Some(format!("{} = {}", item.name, scalar(&item.value)?)));
        for line in lines.chain(self.search(section)) {
            // Writing to a string cannot fail.
            let _ = writeln!(out, "{line}");
        }
        for item in items() {
            self.subtables(item, &join(path, item.name), out);
        }
    }

    fn subtables(&self, item: &Item, path: &str, out: &mut String) {
        let mut header = |open: &str, path: &str, close: &str, section: &Section| {
            let _ = writeln!(out, "\n{open}{path}{close}");
            self.table(section, path, out);
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
}

fn scalar(value: &Checked) -> Option<String> {
    let number = |x: &f64| format!("{x:?}");
    let list = |v: &[f64]| format!("[{}]", v.iter().map(number).collect::<Vec<_>>().join(", "));
    match value {
        Checked::Text(s) | Checked::BodyFile { text: s, .. } => {
            Some(toml::Value::String(s.clone()).to_string())
        }
        Checked::Boolean(b) => Some(b.to_string()),
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
