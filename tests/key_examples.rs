//! Every key of the scenario that is not for experts stands in an example of the page `docs/examples.md`; whether the examples run,
//! `scripts/check_documents.py` looks.

use std::collections::BTreeSet;

use adaptive::record::warning::WarningKind;
use fbimpact::scenario::keys::{Choice, Key, Kind};
use fbimpact::scenario::tables;
use toml::{Table, Value};

const PAGE: &str = include_str!("../docs/examples.md");

/// Keys for experts, for comparisons with other methods, and those that the program writes.
const EXPERT: [&str; 7] =
    ["division", "transfer", "mass_points", "static_answers", "fixed_interface_modes", "net", "file_sha256"];

/// The scenarios of the page.
fn scenarios() -> Vec<Table> {
    let blocks = PAGE.split("```toml\n").skip(1).filter_map(|rest| rest.split("```").next());
    blocks.map(|text| text.parse().unwrap_or_else(|e| panic!("{e}:\n{text}"))).collect()
}

/// Looks for every one of `keys` in `given`, which are all tables that may hold them, and notes those that are in none.
fn look(keys: &'static [Key], given: &[&Table], path: &str, missing: &mut BTreeSet<String>) {
    for key in keys {
        if EXPERT.contains(&key.name) {
            continue;
        }
        let at = format!("{path}.{}", key.name);
        let degrees = format!("{}_deg", key.name);
        let values: Vec<&Value> =
            given.iter().filter_map(|table| table.get(key.name).or_else(|| table.get(&degrees))).collect();
        if values.is_empty() {
            missing.insert(at);
            continue;
        }
        let tables: Vec<&Table> = values.iter().filter_map(|value| value.as_table()).collect();
        match &key.kind {
            Kind::Table(keys) => look(keys, &tables, &at, missing),
            Kind::Named(keys) | Kind::NamedByFile(keys) => {
                let named: Vec<&Table> =
                    tables.iter().flat_map(|t| t.values()).filter_map(Value::as_table).collect();
                look(keys, &named, &at, missing);
            }
            Kind::Tables(keys) => {
                let rows = values.iter().filter_map(|value| value.as_array()).flatten();
                look(keys, &rows.filter_map(Value::as_table).collect::<Vec<_>>(), &at, missing);
            }
            Kind::Variants { tag, variants } => {
                for variant in *variants {
                    let chosen =
                        |t: &&&Table| t.get(*tag).and_then(Value::as_str) == Some(variant.choice.name);
                    let chosen: Vec<&Table> = tables.iter().filter(chosen).copied().collect();
                    look(variant.keys, &chosen, &format!("{at}({})", variant.choice.name), missing);
                }
            }
            _ => {}
        }
    }
}

/// All tables anywhere in `value`.
fn tables_in<'a>(value: &'a Value, all: &mut Vec<&'a Table>) {
    match value {
        Value::Table(table) => {
            all.push(table);
            table.values().for_each(|inner| tables_in(inner, all));
        }
        Value::Array(rows) => rows.iter().for_each(|inner| tables_in(inner, all)),
        _ => {}
    }
}

#[test]
fn every_key_stands_in_an_example() {
    let scenarios = scenarios();
    let mut missing = BTreeSet::new();
    look(tables::SCENARIO, &scenarios.iter().collect::<Vec<_>>(), "", &mut missing);
    // Quantities over time are the same wherever they stand.
    let values: Vec<Value> = scenarios.iter().cloned().map(Value::Table).collect();
    let mut all = Vec::new();
    values.iter().for_each(|value| tables_in(value, &mut all));
    for curve in tables::CurveKind::VARIANTS {
        let chosen = |t: &&&Table| t.get("kind").and_then(Value::as_str) == Some(curve.choice.name);
        let chosen: Vec<&Table> = all.iter().filter(chosen).copied().collect();
        look(curve.keys, &chosen, &format!("{{{}}}", curve.choice.name), &mut missing);
    }
    assert!(missing.is_empty(), "docs/examples.md has no example of {missing:#?}");
}

#[test]
fn every_kind_of_body_and_joint_stands_in_an_example() {
    fn of<'a>(keys: &'a [Key], name: &str) -> &'a [Choice] {
        match keys.iter().find(|key| key.name == name).map(|key| &key.kind) {
            Some(Kind::Choice(choices)) => choices,
            _ => panic!("{name} is no choice"),
        }
    }
    let section = |name: &str| match tables::SCENARIO.iter().find(|key| key.name == name).map(|key| &key.kind)
    {
        Some(Kind::Named(keys)) => *keys,
        _ => panic!("{name} is no section"),
    };
    for (name, key) in [("joints", "type"), ("bodies", "motion")] {
        for choice in of(section(name), key) {
            let is_there = scenarios().iter().any(|scenario| {
                let entries =
                    scenario.get(name).and_then(Value::as_table).into_iter().flat_map(|t| t.values());
                entries.filter_map(|e| e.get(key)?.as_str()).any(|value| value == choice.name)
            });
            // The default of a key needs no example.
            assert!(is_there || choice.name == "spatial", "no example of {key} = \"{}\"", choice.name);
        }
    }
}

#[test]
fn every_kind_of_warning_has_its_remedy_on_the_page_of_warnings() {
    let page = include_str!("../docs/warnings.md");
    for kind in WarningKind::ALL {
        let row = format!("\n| `{}` |", kind.identifier());
        assert!(page.contains(&row), "docs/warnings.md has no row of {kind:?}");
    }
}
