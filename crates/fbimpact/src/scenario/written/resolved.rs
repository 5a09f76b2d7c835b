//! Writes a checked scenario back as TOML, defaults included.

use std::fmt::Write as _;

use crate::scenario::build::{ContactFacts, peak_tolerance};
use crate::scenario::conditions::Scope;
use crate::scenario::keys::Named;
use crate::scenario::section::{Checked, Section, join};
use crate::scenario::tables::Search;

/// The scenario as TOML that reads back to the same values. Angles are in radians.
pub fn write(root: &Section) -> String {
    let mut out = String::new();
    table(Scope::of(root), "", &mut out);
    out
}

/// Writes a table without defaults that have no meaning: they would be faults when read back.
fn table(scope: Scope<'_>, path: &str, out: &mut String) {
    let items = || scope.section.items.iter().filter(|item| scope.unmet(item).is_none());
    let lines = items().filter_map(|item| Some(format!("{} = {}", item.name, scalar(&item.value)?)));
    for line in lines.chain(penalty_defaults(scope)) {
        // Writing to a string cannot fail.
        let _ = writeln!(out, "{line}");
    }
    for item in items() {
        let (open, close) = if matches!(item.value, Checked::Tables(_)) { ("[[", "]]") } else { ("[", "]") };
        for (name, section) in item.value.subtables() {
            let parts = [item.name, name].into_iter().filter(|part| !part.is_empty());
            let path = parts.fold(path.to_owned(), |path, part| join(&path, part));
            let _ = writeln!(out, "\n{open}{path}{close}");
            table(scope.inner(section), &path, out);
        }
    }
}

/// The defaults of a search for a penalty factor, which depend on the contact model and the level
/// of accuracy.
fn penalty_defaults(scope: Scope<'_>) -> Vec<String> {
    let Scope { root, section, around, .. } = scope;
    let contact = around.filter(|_| section.path.ends_with(".penalty"));
    let Some(facts) = contact.and_then(|contact| ContactFacts::of(root, contact)) else { return Vec::new() };
    let has_tolerance = facts.search != Some(Search::UntilConverged) || section.given("tolerance");
    let tolerance = (!has_tolerance).then(|| format!("tolerance = {:?}", peak_tolerance(root, section)));
    let search = facts.search.filter(|_| !section.given("search"));
    let search = search.map(|search| format!("search = {:?}", search.name()));
    tolerance.into_iter().chain(search).collect()
}

fn scalar(value: &Checked) -> Option<String> {
    let number = |x: &f64| format!("{x:?}");
    let list = |v: &[f64]| format!("[{}]", v.iter().map(number).collect::<Vec<_>>().join(", "));
    match value {
        Checked::Text(s)
        | Checked::BodyFile { text: s, .. }
        | Checked::MeshFile { text: s, .. }
        | Checked::SplineFile { text: s, .. } => Some(toml::Value::String(s.clone()).to_string()),
        Checked::Names(names) => Some(format!("{names:?}")),
        Checked::NameLists(lists) => {
            let texts =
                |names: &[String]| names.iter().map(|n| format!("{n:?}")).collect::<Vec<_>>().join(", ");
            let all: Vec<_> =
                lists.iter().map(|(name, names)| format!("{name} = [{}]", texts(names))).collect();
            Some(format!("{{ {} }}", all.join(", ")))
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
