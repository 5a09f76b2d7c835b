//! Quantities over time from text files: columns of numbers take the place of the lists of a table,
//! so that the resolved scenario holds them.

use std::io::Read;
use std::path::Path;

use result_files::file::plain_file;

use crate::scenario::check::Checker;
use crate::scenario::keys::units;
use crate::scenario::section::{Checked, Item, Section};
use crate::scenario::tables::CurveKind;

/// Largest file: 64 MiB are a million instants.
const MOST: u64 = 64 << 20;

/// Keys that say where numbers are.
const KEYS: [&str; 3] = ["file", "time_column", "value_column"];

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
    let found = text(&directory.join(name)).and_then(|text| columns(&text, &wanted, quantities));
    let columns = match found {
        Ok(columns) => columns,
        Err(Fault { key, message }) => {
            let message = format!("{name}{message}");
            checker.fault_in(section, key, message);
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

/// What is wrong, and the key that it belongs to.
struct Fault {
    key: &'static str,
    /// Follows the name of the file.
    message: String,
}

impl Fault {
    fn of_file(message: impl std::fmt::Display) -> Self {
        Self { key: "file", message: message.to_string() }
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

/// Cells of a line: between commas or semicolons, or else between blanks.
fn cells(line: &str) -> Vec<&str> {
    let separator = [',', ';'].into_iter().find(|c| line.contains(*c));
    match separator {
        Some(c) => line.split(c).map(|cell| cell.trim().trim_matches('"')).collect(),
        None => line.split_whitespace().map(|cell| cell.trim_matches('"')).collect(),
    }
}

/// A column of numbers in the unit of keys.
#[derive(Debug, Clone, Default, PartialEq)]
struct Column {
    numbers: Vec<f64>,
    /// The unit of keys, if the name of the column says one.
    unit: Option<&'static str>,
}

/// Times and values of the columns `wanted`, by their names in the first line or by their numbers
/// from 1; the first and the second one unless said otherwise. Numbers are in the units of keys
/// `quantities`, or in those that the names end with.
fn columns(text: &str, wanted: &[Option<String>; 2], quantities: [&str; 2]) -> Result<[Column; 2], Fault> {
    let lines = text.lines().enumerate().map(|(n, line)| (n + 1, line.trim()));
    let mut lines = lines.filter(|(_, line)| !line.is_empty() && !line.starts_with('#')).peekable();
    let Some((_, first)) = lines.peek() else { return Err(Fault::of_file(" has no line of numbers")) };
    let names = cells(first);
    let has_header = names.iter().any(|cell| cell.parse::<f64>().is_err());
    if has_header {
        lines.next();
    }
    let place = |k: usize| -> Result<usize, Fault> {
        let Some(name) = &wanted[k] else { return Ok(k) };
        let named = names.iter().position(|cell| has_header && cell == name);
        let numbered = name.parse::<usize>().ok().filter(|n| (1..=names.len()).contains(n)).map(|n| n - 1);
        named.or(numbered).ok_or_else(|| {
            let known = if has_header { names.join(", ") } else { format!("numbered 1 to {}", names.len()) };
            Fault { key: KEYS[k + 1], message: format!(" has no column \"{name}\", its columns are {known}") }
        })
    };
    let places = [place(0)?, place(1)?];
    let mut found: [Column; 2] = Default::default();
    let mut factors = [1.0; 2];
    if has_header {
        for (k, &at) in places.iter().enumerate() {
            let Some(name) = names.get(at) else { continue };
            let unit = units::of_column(name, quantities[k])
                .map_err(|message| Fault::of_file(format_args!(", column \"{name}\": {message}")))?;
            if let Some((unit, factor)) = unit {
                (found[k].unit, factors[k]) = (Some(unit), factor);
            }
        }
    }
    for (n, line) in lines {
        let row = cells(line);
        for ((column, factor), &at) in found.iter_mut().zip(factors).zip(&places) {
            let cell = row.get(at).ok_or_else(|| {
                Fault::of_file(format_args!(":{n}: {} columns, column {} is wanted", row.len(), at + 1))
            })?;
            let number = cell.parse::<f64>().ok().filter(|x| x.is_finite());
            let number = number.ok_or_else(|| Fault::of_file(format_args!(":{n}: {cell:?} is no number")))?;
            column.numbers.push(number * factor);
        }
        if let [.., before, now] = found[0].numbers[..]
            && now <= before
        {
            return Err(Fault::of_file(format_args!(
                ":{n}: times must rise, {before:?} is followed by {now:?}"
            )));
        }
    }
    if found[0].numbers.len() < 2 {
        return Err(Fault::of_file(" has fewer than two lines of numbers"));
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str, wanted: [Option<&str>; 2]) -> Result<[Vec<f64>; 2], String> {
        columns(text, &wanted.map(|name| name.map(str::to_owned)), ["s", "N"])
            .map(|columns| columns.map(|column| column.numbers))
            .map_err(|fault| fault.key.to_owned() + &fault.message)
    }

    #[test]
    fn columns_are_found_by_name_number_and_order() {
        let expected = Ok([vec![0.0, 0.5], vec![1.0, -2e3]]);
        assert_eq!(read("0,1\n0.5,-2e3\n", [None, None]), expected);
        assert_eq!(read("# measured\n\nt;x;F\n0;9;1\n0.5;9;-2e3", [Some("t"), Some("F")]), expected);
        assert_eq!(read("1 0 7\n-2e3 0.5 7", [Some("2"), Some("1")]), expected);
        assert_eq!(read("t [ms],F_kN\n0,1e-3\n500,-2", [None, None]), expected);
        assert_eq!(read("\"t [s]\",\"F [N]\"\r\n0,1\r\n0.5,-2e3\r\n", [None, Some("F [N]")]), expected);
    }

    #[test]
    fn faults_tell_line_and_columns() {
        for (text, wanted, words) in [
            ("", [None, None], "file has no line of numbers"),
            ("t,F\n", [None, None], "file has fewer than two"),
            ("t,F\n0,1\n1,x\n", [None, None], "file:3: \"x\" is no number"),
            ("t,F\n0,1\n1\n", [None, None], "file:3: 1 columns, column 2 is wanted"),
            ("t,F\n0,1\n0,2\n", [None, None], "file:3: times must rise, 0.0 is followed by 0.0"),
            ("t,F\n0,1\n1,inf\n", [None, None], "is no number"),
            ("t [ms],F [lbf]\n0,1\n1,2\n", [None, None], "file, column \"F [lbf]\": unknown unit"),
            ("t,F\n0,1\n1,2\n", [None, Some("G")], "value_column has no column \"G\", its columns are t, F"),
            (
                "0,1\n1,2\n",
                [Some("3"), None],
                "time_column has no column \"3\", its columns are numbered 1 to 2",
            ),
        ] {
            let found = read(text, wanted).expect_err(text);
            assert!(found.contains(words), "{text:?}: {found}");
        }
    }
}
