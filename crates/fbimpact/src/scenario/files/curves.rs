//! Quantities over time from text files: columns of numbers take the place of the lists of a table,
//! so that the resolved scenario holds them.

use std::io::Read;
use std::path::Path;

use result_files::file::plain_file;

use super::columns::{Column, Fault, KEYS, columns};
use crate::scenario::check::Checker;
use crate::scenario::section::{Checked, Item, Section};
use crate::scenario::tables::CurveKind;

/// Largest file: 64 MiB are a million instants.
const MOST: u64 = 64 << 20;

/// Reads the files of all tables over time below `section`; files are sought in `directory`.
pub fn read_all(checker: &mut Checker, section: &mut Section, directory: &Path) {
    let is_table = section.choice("kind") == Some(CurveKind::Table) && section.item("file").is_some();
    // Both a file and lists: the conditions of the keys tell.
    if is_table && !section.given("times") && !section.given("values") {
        read_one(checker, section, directory);
    }
    for item in &mut section.items {
        match &mut item.value {
            Checked::Table(inner) => read_all(checker, inner, directory),
            Checked::Named(list) => {
                list.iter_mut().for_each(|(_, inner)| read_all(checker, inner, directory))
            }
            Checked::Tables(list) => list.iter_mut().for_each(|inner| read_all(checker, inner, directory)),
            _ => {}
        }
    }
}

fn read_one(checker: &mut Checker, section: &mut Section, directory: &Path) {
    let Some(name) = section.text("file") else { return };
    let wanted = ["time_column", "value_column"].map(|key| section.text(key).map(str::to_owned));
    let quantities = ["s", section.quantity];
    checker.files.push((directory.join(name), "a table of the scenario".to_owned()));
    let found = text(&directory.join(name)).and_then(|text| columns(&text, &wanted, quantities));
    let columns = match found {
        Ok(columns) => columns,
        Err(Fault { key, message }) => {
            section.fault(key, format!("{name}{message}"));
            Default::default()
        }
    };
    let Some(origin) = section.item("file").map(|item| item.origin.clone()) else { return };
    section.items.retain(|item| !KEYS.contains(&item.name));
    // In the order of their declarations, behind the kind.
    for (at, (name, Column { numbers, unit })) in (1..).zip(["times", "values"].into_iter().zip(columns)) {
        let value = if numbers.is_empty() { Checked::Invalid } else { Checked::Numbers(numbers) };
        let shown = "the file".to_owned();
        section.items.insert(
            at.min(section.items.len()),
            Item {
                units: unit.map(|unit| (0, unit)).into_iter().collect(),
                given: true,
                ..Item::new(name, value, origin.clone(), shown)
            },
        );
    }
}

fn text(path: &Path) -> Result<String, Fault> {
    let fail = |e: std::io::Error| {
        Fault::of_file(format_args!(" cannot be read: {}", result_files::file::error_text::of_io(&e)))
    };
    let file = plain_file::open(path).map_err(fail)?;
    let mut bytes = Vec::new();
    file.take(MOST + 1).read_to_end(&mut bytes).map_err(fail)?;
    if bytes.len() as u64 > MOST {
        return Err(Fault::of_file(format_args!(" is longer than {} MiB", MOST >> 20)));
    }
    String::from_utf8(bytes).map_err(|_| Fault::of_file(" is no UTF-8 text"))
}
