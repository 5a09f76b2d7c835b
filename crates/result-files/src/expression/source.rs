//! Where names lead in a result.

use std::collections::BTreeSet;

use hdf5::types::VarLenUnicode;
use serde_json::Value as Json;

use super::fault::FaultAt;
use super::parse::{Step, Taken};
use super::value::Value;
use crate::file::hdf5_integrity;
use crate::stored::{Kind, Stored};
use crate::tables::{EventRow, ImpactRow, PhaseRow, TableColumn, TableRow, TransferRow, TrialRow};

/// Name under which the values of the scenario stand.
const SCENARIO: &str = "scenario";
/// Name of the rows of a contact's impacts.
const IMPACTS: &str = "impacts";

/// A further column of tables whose rows have a start and an end.
const DURATION: TableColumn =
    TableColumn { name: "duration", unit: "s", meaning: "time from the start to the end" };

/// A result as expressions see it.
pub struct Source<'a> {
    stored: &'a Stored,
}

/// A place on the way of a path.
enum Place {
    /// A value.
    Value(Value),
    /// A table, one row a map of columns.
    Table(Vec<serde_json::Map<String, Json>>, &'static [TableColumn]),
    /// A group, whose members are named.
    Group(BTreeSet<String>),
}

impl<'a> Source<'a> {
    /// The result `stored`.
    pub fn new(stored: &'a Stored) -> Self {
        Self { stored }
    }

    /// Stored instants \[s\].
    pub fn time(&self) -> &[f64] {
        &self.stored.time
    }

    /// The value that the first of `steps` lead to, and the steps that are left.
    ///
    /// # Errors
    /// The first name that leads nowhere, and the names that there are.
    pub fn find<'s>(&self, steps: &'s [Step]) -> Result<(Value, &'s [Step]), FaultAt> {
        if let Some((first, rest)) = steps.split_first()
            && first.taken == Taken::Name(SCENARIO.into())
        {
            return self.of_scenario(rest, first.at);
        }
        let mut path = String::new();
        for (n, step) in steps.iter().enumerate() {
            let Taken::Name(name) = &step.taken else {
                let names: Vec<String> = self.members(&path).into_iter().collect();
                return Err((
                    step.at,
                    format!("{} is a group of {}; name one", dotted(&path), names.join(", ")),
                ));
            };
            let next = if path.is_empty() { name.clone() } else { format!("{path}/{name}") };
            match self.place(&next).map_err(|reason| (step.at, reason))? {
                Place::Value(value) => return Ok((value, &steps[n + 1..])),
                Place::Table(rows, columns) => {
                    return column(&rows, columns, step.at, &steps[n + 1..], &next);
                }
                Place::Group(members) if members.is_empty() => {
                    return Err((step.at, self.unknown(name, &path)));
                }
                Place::Group(_) => path = next,
            }
        }
        let names: Vec<String> = self.members(&path).into_iter().collect();
        let at = steps.last().map_or(0, |step| step.at);
        Err((at, format!("{} is a group of {}; name one", dotted(&path), names.join(", "))))
    }

    /// What to say of a `name` that the group `path` does not have.
    fn unknown(&self, name: &str, path: &str) -> String {
        let known: Vec<String> = self.members(path).into_iter().collect();
        let holder = if path.is_empty() { "the result".into() } else { dotted(path) };
        let hint = if name.contains('-') { "; a minus sign has a space before it" } else { "" };
        match known.is_empty() {
            true => format!("there is no \"{name}\" in {holder}, which is empty"),
            false => format!("there is no \"{name}\" in {holder}, there are {}{hint}", known.join(", ")),
        }
    }

    /// Names below the group `path`, at the root those that expressions know besides.
    fn members(&self, path: &str) -> BTreeSet<String> {
        let inside = |entry: &str| match path {
            "" => entry.split('/').next().map(str::to_owned),
            _ => entry.strip_prefix(path)?.strip_prefix('/')?.split('/').next().map(str::to_owned),
        };
        let readable =
            self.stored.entries.iter().filter(|(path, entry)| entry.kind != Kind::Other || is_table(path));
        let mut names: BTreeSet<String> = readable.filter_map(|(path, _)| inside(path)).collect();
        if path.is_empty() {
            names.extend(["time".to_owned(), SCENARIO.to_owned()]);
        } else if self.contact_of(&format!("{path}/{IMPACTS}")).is_some() {
            names.insert(IMPACTS.to_owned());
        }
        names
    }

    /// The contact whose impacts `path` names.
    fn contact_of(&self, path: &str) -> Option<String> {
        let contact = path.strip_prefix("contacts/")?.strip_suffix("/impacts")?;
        let is_there = self.stored.entries.contains_key(&format!("contacts/{contact}/normal_force"));
        is_there.then(|| contact.to_owned())
    }

    fn place(&self, path: &str) -> Result<Place, String> {
        if path == "time" {
            let rows = Some(self.stored.time.len());
            let time =
                Value { data: self.stored.time.clone(), rows, is_over_time: true, ..Value::number(0.0, "s") };
            return Ok(Place::Value(time));
        }
        let of_contact = self.contact_of(path);
        if path == "impacts" || of_contact.is_some() {
            let rows = self.stored.impacts.iter();
            let rows = rows.filter(|i| of_contact.as_ref().is_none_or(|name| i.contact.as_str() == name));
            return Ok(Place::Table(rows.map(TableRow::json).collect(), ImpactRow::COLUMNS));
        }
        match path {
            "events" => return self.table::<EventRow>(),
            "phases" => return self.table::<PhaseRow>(),
            "tries" => return self.table::<TrialRow>(),
            "transfers" => return self.table::<TransferRow>(),
            _ => {}
        }
        let Some(entry) = self.stored.entries.get(path) else { return Ok(Place::Group(self.members(path))) };
        if entry.kind == Kind::Other {
            return Err("holds no numbers that expressions read".into());
        }
        let data = self.stored.values(path).map_err(|e| e.to_string())?;
        let rows = entry.shape.first().copied();
        let width = (entry.shape.len() > 1).then(|| entry.width());
        let labels = width.map(|w| self.labels(path, w)).unwrap_or_default();
        let is_over_time = entry.kind == Kind::Series;
        let n = rows.unwrap_or(1) * width.unwrap_or(1);
        if data.len() < n {
            return Err("is shorter than it says".into());
        }
        Ok(Place::Value(Value { data, rows, width, labels, unit: entry.unit.clone(), is_over_time }))
    }

    fn table<T: TableRow>(&self) -> Result<Place, String> {
        let read = self.stored.file().dataset(T::NAME).and_then(|d| hdf5_integrity::rows::<T>(&d));
        let rows = read.map_err(|e| crate::file::error_text::of_hdf5(&e))?;
        Ok(Place::Table(rows.iter().map(TableRow::json).collect(), T::COLUMNS))
    }

    /// Names of the components of the dataset `path`, `width` of them.
    fn labels(&self, path: &str, width: usize) -> Vec<String> {
        let (group, name) = path.rsplit_once('/').unwrap_or(("", path));
        let scale = match name {
            "stress" | "strain" => format!("{group}/component"),
            "rotation" => "wxyz".into(),
            "coordinates" | "velocities" => format!("{group}/{name}_names"),
            _ => "xyz".into(),
        };
        let read = self.stored.file().dataset(&scale).and_then(|d| hdf5_integrity::rows::<VarLenUnicode>(&d));
        let labels = read.unwrap_or_default();
        if labels.len() == width {
            labels.iter().map(|l| l.as_str().to_owned()).collect()
        } else {
            Vec::new()
        }
    }

    /// A number or a list of numbers of the scenario.
    fn of_scenario<'s>(&self, steps: &'s [Step], at: usize) -> Result<(Value, &'s [Step]), FaultAt> {
        let table: toml::Table = self
            .stored
            .scenario
            .parse()
            .map_err(|_| (at, "the result holds no readable scenario".to_owned()))?;
        let (mut value, mut place) = (toml::Value::Table(table), at);
        for (n, step) in steps.iter().enumerate() {
            if let Some(found) = numbers(&value) {
                return Ok((found, &steps[n..]));
            }
            place = step.at;
            let next = match (&step.taken, &value) {
                (Taken::Name(name), toml::Value::Table(table)) => table.get(name).cloned().ok_or_else(|| {
                    let known: Vec<&str> = table.keys().map(String::as_str).collect();
                    format!("there is no \"{name}\" in the scenario here, there are {}", known.join(", "))
                }),
                (Taken::Index(i), toml::Value::Array(list)) => {
                    let found = usize::try_from(*i).ok().and_then(|i| list.get(i)).cloned();
                    found.ok_or_else(|| format!("[{i}] is not there, there are {} entries", list.len()))
                }
                _ => Err("leads nowhere in the scenario".into()),
            };
            value = next.map_err(|reason| (step.at, reason))?;
        }
        match (numbers(&value), &value) {
            (Some(found), _) => Ok((found, &[])),
            (None, toml::Value::Table(table)) => {
                let known: Vec<&str> = table.keys().map(String::as_str).collect();
                Err((place, format!("is a table of {}; name one", known.join(", "))))
            }
            (None, other) => Err((place, format!("is {}, not a number", other.type_str()))),
        }
    }
}

fn is_table(path: &str) -> bool {
    [ImpactRow::NAME, EventRow::NAME, PhaseRow::NAME, TrialRow::NAME, TransferRow::NAME].contains(&path)
}

fn dotted(path: &str) -> String {
    path.replace('/', ".")
}

/// A number, a truth as 1 or 0, or a list of numbers; none if it is something else.
fn numbers(value: &toml::Value) -> Option<Value> {
    let number = |value: &toml::Value| match value {
        toml::Value::Float(x) => Some(*x),
        toml::Value::Integer(i) => Some(*i as f64),
        toml::Value::Boolean(b) => Some(f64::from(u8::from(*b))),
        _ => None,
    };
    match value {
        toml::Value::Array(list) if !list.is_empty() => {
            let data = list.iter().map(number).collect::<Option<Vec<f64>>>()?;
            let labels =
                if data.len() == 3 { ["x", "y", "z"].map(str::to_owned).to_vec() } else { Vec::new() };
            Some(Value { width: Some(data.len()), data, labels, ..Value::number(0.0, "") })
        }
        other => number(other).map(|x| Value::number(x, "")),
    }
}

/// The column of a table that the first name among `steps` names; what stands before it is taken of
/// its rows.
fn column<'s>(
    rows: &[serde_json::Map<String, Json>],
    columns: &[TableColumn],
    at: usize,
    steps: &'s [Step],
    path: &str,
) -> Result<(Value, &'s [Step]), FaultAt> {
    let is_span = ["start", "end"].iter().all(|end| columns.iter().any(|c| c.name == *end));
    let columns: Vec<&TableColumn> = columns.iter().chain(is_span.then_some(&DURATION)).collect();
    let known = || columns.iter().map(|c| c.name).collect::<Vec<_>>().join(", ");
    let named = steps.iter().position(|step| matches!(step.taken, Taken::Name(_)));
    let Some((n, Taken::Name(name))) = named.map(|n| (n, &steps[n].taken)) else {
        return Err((at, format!("{} is a table; name one of its columns {}", dotted(path), known())));
    };
    let place = steps[n].at;
    let Some(column) = columns.iter().find(|c| c.name == name) else {
        return Err((
            place,
            format!("there is no column \"{name}\" in {}, there are {}", dotted(path), known()),
        ));
    };
    let cell = |row: &serde_json::Map<String, Json>| -> Option<Vec<f64>> {
        if column.name == DURATION.name {
            let at = |name: &str| row.get(name).and_then(Json::as_f64).unwrap_or(f64::NAN);
            return Some(vec![at("end") - at("start")]);
        }
        match row.get(column.name)? {
            // What is no number is null.
            Json::Null => Some(vec![f64::NAN]),
            Json::Number(x) => x.as_f64().map(|x| vec![x]),
            Json::Array(list) => Some(list.iter().map(|x| x.as_f64().unwrap_or(f64::NAN)).collect()),
            _ => None,
        }
    };
    let cells: Option<Vec<Vec<f64>>> = rows.iter().map(cell).collect();
    let Some(cells) = cells else { return Err((place, format!("the column \"{name}\" holds texts"))) };
    let width = cells.first().map(Vec::len).filter(|w| *w > 1);
    let data: Vec<f64> = cells.into_iter().flatten().collect();
    let mut value = Value { data, rows: Some(rows.len()), width, ..Value::number(0.0, column.unit) };
    for step in &steps[..n] {
        let taken = match step.taken {
            Taken::Index(i) => value.index(i),
            Taken::Range(from, to) => value.range(from, to),
            Taken::Name(_) => continue,
        };
        value = taken.map_err(|reason| (step.at, reason))?;
    }
    Ok((value, &steps[n + 1..]))
}
