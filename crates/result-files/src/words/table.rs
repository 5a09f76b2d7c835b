//! Tables of a result for people. A heading has the unit that its column is declared with.

use std::fmt::Write as _;

use crate::tables::TableRow;

/// A column of a table for people.
pub struct Shown<T> {
    heading: String,
    width: usize,
    is_left: bool,
    text: fn(usize, &T) -> String,
}

impl<T> Shown<T> {
    /// A column `width` wide with numbers, which stand to the right; `text` gets the number of the
    /// row, from 0, and the row.
    pub fn number(heading: impl Into<String>, width: usize, text: fn(usize, &T) -> String) -> Self {
        Self { heading: heading.into(), width, is_left: false, text }
    }

    /// A column with texts, which stand to the left; as the last one it needs no width.
    pub fn text(heading: impl Into<String>, width: usize, text: fn(usize, &T) -> String) -> Self {
        Self { heading: heading.into(), width, is_left: true, text }
    }

    fn padded(&self, text: &str) -> String {
        let width = self.width;
        if self.is_left { format!("{text:<width$}") } else { format!("{text:>width$}") }
    }
}

/// `name` with the unit of the column `column` of table `T`.
///
/// # Panics
/// If the table has no such column.
pub fn heading<T: TableRow>(column: &str, name: &str) -> String {
    let declared = T::COLUMNS.iter().find(|c| c.name == column);
    with_unit(name, declared.expect("tables for people show columns that are declared").unit)
}

/// A heading with its unit.
pub fn with_unit(name: &str, unit: &str) -> String {
    format!("{name} [{unit}]")
}

/// Appends a table, a blank line before it; nothing without rows. Writing to a string cannot fail.
pub fn table<T>(rows: &[T], columns: &[Shown<T>], out: &mut String) {
    if rows.is_empty() {
        return;
    }
    let line = |cells: Vec<String>| cells.join(" ");
    let _ = writeln!(out, "\n{}", line(columns.iter().map(|c| c.padded(&c.heading)).collect()));
    for (n, row) in rows.iter().enumerate() {
        let _ = writeln!(out, "{}", line(columns.iter().map(|c| c.padded(&(c.text)(n, row))).collect()));
    }
}
