//! The table of many runs: columns for the run, for scenario values that differ among the runs, for
//! joints, for points, energies and expressions, for impacts.

use std::collections::BTreeSet;

use super::runs::Run;
use crate::expression::named::Cell;
use crate::stored::peak::{Peak, SeriesPeak};
use crate::tables::ImpactRow;

/// Cells of a column.
#[derive(Debug, Clone, PartialEq)]
pub enum Values {
    /// Numbers, `None` where there is none.
    Numbers(Vec<Option<f64>>),
    /// Texts.
    Texts(Vec<String>),
}

/// A column.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// Name.
    pub name: String,
    /// Unit; empty for texts and for scenario values, whose unit is that of the key.
    pub unit: String,
    /// Cells.
    pub values: Values,
}

/// Columns of one length.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Table {
    /// Columns.
    pub columns: Vec<Column>,
    /// Rows.
    pub n_rows: usize,
}

/// A column of the impacts.
type ImpactColumn = (&'static str, &'static str, fn(&ImpactRow) -> f64);

/// Columns of the impacts.
const IMPACT: [ImpactColumn; 15] = [
    ("start", "s", |i| i.start),
    ("end", "s", |i| i.end),
    ("duration", "s", |i| i.end - i.start),
    ("peak_force", "N", |i| i.peak_force),
    ("peak_time", "s", |i| i.peak_time),
    ("impulse", "N s", |i| i.impulse),
    ("approach_velocity", "m/s", |i| i.approach_velocity),
    ("separation_velocity", "m/s", |i| i.separation_velocity),
    ("restitution", "–", |i| i.restitution),
    ("peak_force_uncertainty", "N", |i| i.peak_force_uncertainty),
    ("peak_time_uncertainty", "s", |i| i.peak_time_uncertainty),
    ("duration_uncertainty", "s", |i| i.duration_uncertainty),
    ("impulse_uncertainty", "N s", |i| i.impulse_uncertainty),
    ("separation_velocity_uncertainty", "m/s", |i| i.separation_velocity_uncertainty),
    ("restitution_uncertainty", "–", |i| i.restitution_uncertainty),
];

/// Columns of a largest value: what its name goes on with, whether they are times.
type PeakColumn = (&'static str, bool, fn(&SeriesPeak) -> f64);

const PEAK: [PeakColumn; 3] = [
    ("", false, |peak| peak.value),
    ("_time", true, |peak| peak.time),
    ("_uncertainty", false, |peak| peak.band),
];

/// A row: a run, and for the long form one of its impacts.
type Row<'a> = (&'a Run, Option<(usize, &'a ImpactRow)>);

/// Gathers runs: one row per run with columns `<contact>[<number>].<feature>`, or, if `is_long`,
/// one row per impact, and one for each run without.
pub fn gather(runs: &[Run], is_long: bool) -> Table {
    let rows: Vec<Row<'_>> = if is_long {
        runs.iter().flat_map(impact_rows).collect()
    } else {
        runs.iter().map(|run| (run, None)).collect()
    };
    let mut columns = run_columns(&rows);
    columns.extend(scenario_columns(&rows, &varying(runs)));
    let of = |run: &Run| {
        let named = |p: &Peak| (p.quantity.group, p.place.clone(), p.quantity.name, p.quantity.unit);
        run.peaks.iter().map(named).collect::<Vec<_>>()
    };
    for (group, place, quantity, unit) in runs.iter().flat_map(of).collect::<BTreeSet<_>>() {
        for (end, is_time, of) in PEAK {
            let name = format!("{group}.{place}.{quantity}{end}");
            let is_it =
                |p: &&Peak| p.place == place && (p.quantity.group, p.quantity.name) == (group, quantity);
            columns.push(numbers(&name, if is_time { "s" } else { unit }, &rows, |(run, _)| {
                run.peaks.iter().find(is_it).map(|peak| of(&peak.peak))
            }));
        }
    }
    columns.extend(cell_columns(&rows));
    if is_long {
        columns.push(texts("contact", &rows, |(_, impact)| {
            impact.map_or_else(String::new, |(_, i)| i.contact.as_str().to_owned())
        }));
        columns.push(numbers("impact", "–", &rows, |(_, impact)| impact.map(|(n, _)| n as f64)));
        for (name, unit, of) in IMPACT {
            columns.push(numbers(name, unit, &rows, |(_, impact)| impact.map(|(_, i)| of(i))));
        }
    } else {
        for (contact, number) in impacts_seen(runs) {
            for (name, unit, of) in IMPACT {
                let name = format!("{contact}[{number}].{name}");
                columns.push(numbers(&name, unit, &rows, |(run, _)| nth(run, &contact, number).map(of)));
            }
        }
    }
    Table { columns, n_rows: rows.len() }
}

/// Columns of the cells that runs have, in the order in which they first occur.
fn cell_columns(rows: &[Row<'_>]) -> Vec<Column> {
    let mut seen: Vec<&Cell> = Vec::new();
    for cell in rows.iter().flat_map(|(run, _)| &run.cells) {
        if seen.iter().all(|known| known.name != cell.name) {
            seen.push(cell);
        }
    }
    let column = |cell: &Cell| {
        numbers(&cell.name, &cell.unit, rows, |(run, _)| {
            run.cells.iter().find(|own| own.name == cell.name).map(|own| own.number)
        })
    };
    seen.into_iter().map(column).collect()
}

/// Impacts of a run with their numbers within their contact, from 1, or one row without.
fn impact_rows(run: &Run) -> Vec<Row<'_>> {
    let number = |i: usize| {
        let contact = &run.impacts[i].contact;
        run.impacts[..=i].iter().filter(|other| other.contact == *contact).count()
    };
    let rows: Vec<Row<'_>> =
        run.impacts.iter().enumerate().map(|(i, impact)| (run, Some((number(i), impact)))).collect();
    if rows.is_empty() { vec![(run, None)] } else { rows }
}

fn nth<'a>(run: &'a Run, contact: &str, number: usize) -> Option<&'a ImpactRow> {
    run.impacts.iter().filter(|i| i.contact.as_str() == contact).nth(number.checked_sub(1)?)
}

fn impacts_seen(runs: &[Run]) -> BTreeSet<(String, usize)> {
    let rows = runs.iter().flat_map(impact_rows);
    rows.filter_map(|(_, impact)| impact.map(|(n, i)| (i.contact.as_str().to_owned(), n))).collect()
}

fn run_columns(rows: &[Row<'_>]) -> Vec<Column> {
    vec![
        texts("run", rows, |(run, _)| run.name.clone()),
        texts("status", rows, |(run, _)| run.status.clone()),
        numbers("exit_code", "–", rows, |(run, _)| run.exit_code.map(f64::from)),
        texts("message", rows, |(run, _)| run.message.clone()),
        numbers("end_time", "s", rows, |(run, _)| run.end_time),
        numbers("samples", "–", rows, |(run, _)| run.n_samples.map(|n| n as f64)),
        numbers("energy_drift", "–", rows, |(run, _)| run.energy_drift),
        numbers("warnings", "–", rows, |(run, _)| run.warnings.as_ref().map(|w| w.len() as f64)),
        texts("warning", rows, |(run, _)| run.warnings.as_ref().map_or_else(String::new, |w| w.join(" "))),
        numbers("wall_time", "s", rows, |(run, _)| run.wall_time),
        numbers("impacts", "–", rows, |(run, _)| run.n_samples.map(|_| run.impacts.len() as f64)),
        texts("scenario_sha256", rows, |(run, _)| run.hashes[0].clone()),
        texts("inputs_sha256", rows, |(run, _)| run.hashes[1].clone()),
        texts("program", rows, |(run, _)| run.program.clone()),
    ]
}

/// Scenario keys whose values differ among the runs with results, and those that only runs without
/// a result name.
fn varying(runs: &[Run]) -> BTreeSet<String> {
    let with: Vec<&Run> = runs.iter().filter(|r| r.n_samples.is_some()).collect();
    let without = runs.iter().filter(|r| r.n_samples.is_none());
    let keys: BTreeSet<&String> = with.iter().flat_map(|r| r.values.keys()).collect();
    let differs = |key: &&String| with.windows(2).any(|w| w[0].values.get(*key) != w[1].values.get(*key));
    let set = without.flat_map(|r| r.values.keys().cloned());
    keys.into_iter().filter(differs).cloned().chain(set).collect()
}

/// A column of numbers if all values are numbers.
fn scenario_column(rows: &[Row<'_>], key: &str) -> Column {
    let name = format!("set.{key}");
    let is_number = |row: &Row<'_>| value(row, key).is_none_or(|v| v.parse::<f64>().is_ok());
    if rows.iter().all(is_number) {
        return numbers(&name, "", rows, |row| value(row, key).and_then(|v| v.parse().ok()));
    }
    texts(&name, rows, |row| value(row, key).unwrap_or_default().to_owned())
}

/// Columns of the keys `varying`. Of vectors of numbers, the components that differ are columns of
/// numbers as well, `set.KEY[2]`: runs without a result know their vectors, or components that were
/// set alone.
fn scenario_columns(rows: &[Row<'_>], varying: &BTreeSet<String>) -> Vec<Column> {
    let mut columns: Vec<Column> = varying.iter().map(|key| scenario_column(rows, key)).collect();
    for key in varying {
        let Some(size) = vector_size(rows, key) else { continue };
        for i in 0..size {
            let own = format!("{key}[{i}]");
            let component = |row: &Row<'_>| {
                let alone = || value(row, &own).and_then(|v| v.parse().ok());
                value(row, key).and_then(vector).map(|v| v[i]).or_else(alone)
            };
            let mut seen = rows.iter().filter_map(component);
            let first = seen.next();
            if seen.any(|x| Some(x) != first) {
                let name = format!("set.{own}");
                columns.retain(|column| column.name != name);
                columns.push(numbers(&name, "", rows, component));
            }
        }
    }
    columns
}

/// Components of the values of a key, if there are any and all are vectors of so many numbers.
fn vector_size(rows: &[Row<'_>], key: &str) -> Option<usize> {
    let vectors: Option<Vec<Vec<f64>>> = rows.iter().filter_map(|row| value(row, key)).map(vector).collect();
    let vectors = vectors?;
    let size = vectors.first()?.len();
    vectors.iter().all(|v| v.len() == size).then_some(size)
}

/// The numbers of a list.
fn vector(text: &str) -> Option<Vec<f64>> {
    let inside = text.strip_prefix('[')?.strip_suffix(']')?;
    inside.split(',').map(|number| number.trim().parse().ok()).collect()
}

fn value<'a>(row: &Row<'a>, key: &str) -> Option<&'a str> {
    row.0.values.get(key).map(String::as_str)
}

fn texts<'a>(name: &str, rows: &[Row<'a>], of: impl Fn(&Row<'a>) -> String) -> Column {
    Column {
        name: name.to_owned(),
        unit: String::new(),
        values: Values::Texts(rows.iter().map(of).collect()),
    }
}

fn numbers<'a>(name: &str, unit: &str, rows: &[Row<'a>], of: impl Fn(&Row<'a>) -> Option<f64>) -> Column {
    // What has no meaning is no number.
    let values = rows.iter().map(|row| of(row).filter(|x| !x.is_nan())).collect();
    Column { name: name.to_owned(), unit: unit.to_owned(), values: Values::Numbers(values) }
}
