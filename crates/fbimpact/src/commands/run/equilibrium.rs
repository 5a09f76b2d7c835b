//! `fbimpact static`: the pose in which a scenario is in equilibrium, as a result with one state.

use std::fmt::Write as _;
use std::path::Path;

use indicatif::ProgressBar;
use result_files::stored::Stored;
use result_files::words::table::{Shown, table};
use serde_json::{Map, Value, json};

use super::{default_output, run};
use crate::cli::{RunArguments, StaticArguments};
use crate::commands::print;
use crate::error::AppError;

/// Finds the equilibrium, writes it and prints what acts in it.
///
/// # Errors
/// As [`run`].
pub fn equilibrium(arguments: StaticArguments, bar: ProgressBar) -> Result<(), AppError> {
    let StaticArguments { scenario, output, json, mut set, threads, memory, force, cache } = arguments;
    let output = output.unwrap_or_else(|| default_output(&scenario, "static.h5"));
    set.set.push("simulation.start=\"static-only\"".parse().expect("a key and a value"));
    let arguments = RunArguments {
        scenario: Some(scenario),
        output: Some(output.clone()),
        set,
        threads,
        memory,
        force,
        update: false,
        dry_run: false,
        resume: None,
        until_eof: false,
        cache,
    };
    run(&arguments, bar)?;
    let state = State::read(&output)?;
    print(&if json { format!("{:#}\n", state.json()) } else { state.for_people() })
}

/// Forces in an equilibrium.
struct State {
    contacts: Vec<Row>,
    joints: Vec<Row>,
    points: Vec<Row>,
}

/// What is there of one contact, joint or point: its name, and values in the order of the columns.
struct Row {
    name: String,
    values: Vec<f64>,
}

/// Dataset and heading of every column of a table.
type Columns = &'static [(&'static str, &'static str)];

const CONTACTS: Columns = &[
    ("normal_force", "normal force [N]"),
    ("friction_force", "friction [N]"),
    ("penetration", "penetration [m]"),
    ("contact_area", "area [m²]"),
];
const JOINTS: Columns = &[("reaction_force", "reaction [N]"), ("reaction_moment", "moment [N m]")];
const POINTS: Columns = &[("von_mises", "von Mises [Pa]")];

impl State {
    fn read(file: &Path) -> Result<Self, AppError> {
        let stored = Stored::open(file)?;
        let rows = |group: &str, columns: &[(&str, &str)]| -> Result<Vec<Row>, AppError> {
            let Ok(found) = stored.file().group(group) else { return Ok(Vec::new()) };
            let mut rows = Vec::new();
            for name in found.member_names().unwrap_or_default() {
                let mut values = Vec::new();
                for (column, _) in columns {
                    let path = format!("{group}/{name}/{column}");
                    // Size of a vector; the one state is the first.
                    values.push(match stored.file().link_exists(&path) {
                        true => stored.values(&path)?.iter().map(|x| x * x).sum::<f64>().sqrt(),
                        false => f64::NAN,
                    });
                }
                rows.push(Row { name, values });
            }
            Ok(rows)
        };
        let points = rows("points", POINTS)?.into_iter().filter(|row| row.values[0].is_finite()).collect();
        Ok(Self { contacts: rows("contacts", CONTACTS)?, joints: rows("joints", JOINTS)?, points })
    }

    fn tables(&self) -> [(&'static str, &[Row], Columns); 3] {
        [
            ("contacts", &self.contacts, CONTACTS),
            ("joints", &self.joints, JOINTS),
            ("points", &self.points, POINTS),
        ]
    }

    /// Writing to a string cannot fail.
    fn for_people(&self) -> String {
        let mut out = String::new();
        for (title, rows, columns) in self.tables() {
            let mut shown = vec![Shown::text(title, 20, |_, row: &Row| row.name.clone())];
            let texts: [fn(usize, &Row) -> String; 4] =
                [|_, r| value(r, 0), |_, r| value(r, 1), |_, r| value(r, 2), |_, r| value(r, 3)];
            shown.extend(
                columns.iter().zip(texts).map(|((_, heading), text)| Shown::number(*heading, 18, text)),
            );
            table(rows, &shown, &mut out);
        }
        if out.is_empty() {
            let _ = writeln!(out, "in equilibrium; there are neither contacts nor joints");
        }
        out
    }

    fn json(&self) -> Value {
        let of = |row: &Row, columns: &[(&str, &str)]| -> Value {
            columns
                .iter()
                .zip(&row.values)
                .map(|((column, _), value)| ((*column).to_owned(), json!(value)))
                .collect::<Map<_, _>>()
                .into()
        };
        let tables = self.tables().into_iter().map(|(title, rows, columns)| {
            let rows: Map<String, Value> =
                rows.iter().map(|row| (row.name.clone(), of(row, columns))).collect();
            (title.to_owned(), rows.into())
        });
        tables.collect::<Map<_, _>>().into()
    }
}

fn value(row: &Row, column: usize) -> String {
    format!("{:.6e}", row.values[column])
}
