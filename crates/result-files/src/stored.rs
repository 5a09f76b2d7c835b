//! A stored result: how it is opened, what it tells of its run, and the list of its datasets that
//! `compare`, `thin` and `collect` read.

pub mod chosen_sizes;
pub mod impacts;
pub mod members;
pub mod open;
pub mod peak;
pub mod pressure_series;
pub mod scenario_values;
pub mod stages;
pub mod thin;
pub mod warnings;
pub mod summary;

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::path::{Path, PathBuf};

use hdf5::types::{TypeDescriptor, VarLenUnicode};
use hdf5::{Dataset, File, Group};

use crate::error::ResultError;
use crate::file::fault::FileFault;
use crate::file::hdf5_integrity;

use crate::tables::ImpactRow;

/// Groups whose datasets have one row a stored instant.
const SERIES_GROUPS: [&str; 8] =
    [members::ARRAYS, "energies", "momentum", "bodies", "contacts", "points", "joints", "gears"];

/// Group of lists that are as long as it happens: contact pressures.
const LISTS: &str = "pressure";

/// What a dataset holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Numbers, one row a stored instant.
    Series,
    /// Numbers that do not change with time.
    Fixed,
    /// A table, a list or texts.
    Other,
}

/// A dataset of a result.
#[derive(Debug, Clone, PartialEq)]
pub struct Entry {
    /// What it holds.
    pub kind: Kind,
    /// Its lengths.
    pub shape: Vec<usize>,
    /// Unit, empty if it has none.
    pub unit: String,
    /// Path of the same dataset under the name at which it was met first.
    pub same: Option<String>,
    /// The dataset of all bodies that it is one body's part of, and which.
    pub part: Option<(String, usize)>,
}

impl Entry {
    /// How many numbers each row has.
    pub fn width(&self) -> usize {
        self.shape.iter().skip(1).product()
    }
}

/// An open result file.
#[derive(Debug)]
pub struct Stored {
    path: PathBuf,
    file: File,
    /// Stored instants \[s\].
    pub time: Vec<f64>,
    /// Every dataset but `/time` and `/scenario`, by path without the leading slash.
    pub entries: BTreeMap<String, Entry>,
    /// Impacts.
    pub impacts: Vec<ImpactRow>,
    /// The resolved scenario as TOML; empty if there is none.
    pub scenario: String,
}

impl Stored {
    /// Opens a result file.
    ///
    /// # Errors
    /// [`ResultError::File`] if the file cannot be read, is damaged or is not a result file.
    pub fn open(path: &Path) -> Result<Self, ResultError> {
        let file = open::open(path)?;
        let damaged = |e: hdf5::Error| ResultError::io(path, FileFault::part(e));
        let time = match file.link_exists("time") {
            true => file.dataset("time").and_then(|d| hdf5_integrity::rows::<f64>(&d)).map_err(damaged)?,
            false => Vec::new(),
        };
        if let Some(i) = (0..time.len()).find(|i| !time[*i].is_finite() || (*i > 0 && time[*i] < time[i - 1]))
        {
            let value = time[i];
            let reason =
                format!("/time holds {value} at row {i}, times must be finite and must not decrease");
            return Err(ResultError::io(path, reason));
        }
        let mut entries = BTreeMap::new();
        walk(&file, "", time.len(), (&mut entries, &mut Met::new())).map_err(damaged)?;
        members::share_out(&file, &mut entries).map_err(damaged)?;
        let impacts = impacts::impacts(&file).map_err(damaged)?;
        let scenario = match file.link_exists("scenario") {
            true => open::scenario_text(&file).map_err(damaged)?,
            false => String::new(),
        };
        Ok(Self { path: path.to_owned(), file, time, entries, impacts, scenario })
    }

    /// The file as it was named.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The HDF5 file.
    pub fn file(&self) -> &File {
        &self.file
    }

    /// A root attribute, or an empty text.
    pub fn attribute(&self, name: &str) -> String {
        open::attribute(&self.file, name).unwrap_or_default()
    }

    /// Looks whether the file holds what each of its datasets claims.
    ///
    /// # Errors
    /// [`ResultError::File`] with the first that claims more, or lies in another file.
    pub fn check(&self) -> Result<(), ResultError> {
        let of =
            |(name, entry): (&'_ String, &'_ Entry)| entry.part.as_ref().map_or(name, |(all, _)| all).clone();
        let names: BTreeSet<String> =
            self.entries.iter().map(of).chain(["time", "scenario"].map(String::from)).collect();
        let mut there = names.iter().filter(|name| self.file.link_exists(name));
        let checked = there.try_for_each(|name| hdf5_integrity::check(&self.file.dataset(name)?));
        checked.map_err(|e| ResultError::io(&self.path, FileFault::part(e)))
    }

    /// All numbers of a dataset in the order of rows.
    ///
    /// # Errors
    /// [`ResultError::File`] if they cannot be read.
    pub fn values(&self, name: &str) -> Result<Vec<f64>, ResultError> {
        let part = self.entries.get(name).and_then(|entry| entry.part.as_ref());
        let read = match part {
            Some((all, index)) => self.file.dataset(all).and_then(|d| members::part(&d, *index)),
            None => self.file.dataset(name).and_then(|d| hdf5_integrity::rows::<f64>(&d)),
        };
        read.map_err(|source| {
            let what = format!("/{name} cannot be read").into();
            ResultError::io(&self.path, FileFault::Hdf5 { what, source })
        })
    }
}

/// Groups that have been met, by what HDF5 tells them apart with: the path of each, none while what is in it is being read, or where
/// groups lie in it.
type Met = HashMap<String, Option<String>>;

/// Notes the datasets of a group and of those in it. A group without groups may have several names, as contacts that never touch have;
/// other groups have one, for links could lead in circles.
fn walk(
    group: &Group,
    at: &str,
    n_times: usize,
    (out, met): (&mut BTreeMap<String, Entry>, &mut Met),
) -> hdf5::Result<()> {
    let token = format!("{:?}", group.loc_info()?.token);
    match met.get(&token) {
        Some(Some(first)) if first.split('/').next() == at.split('/').next() => {
            let inside = format!("{first}/");
            let own = out.range(inside.clone()..).take_while(|(path, _)| path.starts_with(&inside));
            let own = own.map(|(path, entry)| {
                (
                    format!("{at}/{}", &path[inside.len()..]),
                    Entry { same: Some(path.clone()), ..entry.clone() },
                )
            });
            let own: Vec<_> = own.collect();
            out.extend(own);
            return Ok(());
        }
        Some(_) => {
            let reason = format!("/{at} is another name of a group of this file, take it out");
            return Err(hdf5::Error::from(reason));
        }
        None => {}
    }
    met.insert(token.clone(), None);
    let mut has_groups = false;
    for name in group.member_names()? {
        let path = if at.is_empty() { name.clone() } else { format!("{at}/{name}") };
        if path == "time" || path == "scenario" {
            continue;
        }
        match group.group(&name) {
            Ok(child) => {
                has_groups = true;
                walk(&child, &path, n_times, (out, met))?;
            }
            Err(_) => {
                let entry = entry(&group.dataset(&name)?, &path, n_times);
                out.insert(path, entry);
            }
        }
    }
    if !has_groups {
        met.insert(token, Some(at.to_owned()));
    }
    Ok(())
}

fn entry(dataset: &Dataset, path: &str, n_times: usize) -> Entry {
    let shape = dataset.shape();
    let top = path.split('/').next().unwrap_or_default();
    let is_number = top != LISTS
        && dataset.dtype().and_then(|t| t.to_descriptor()).is_ok_and(|t| {
            matches!(t, TypeDescriptor::Float(_) | TypeDescriptor::Integer(_) | TypeDescriptor::Unsigned(_))
        });
    let is_series = (SERIES_GROUPS.contains(&top) || path == "phase")
        && !path.ends_with("/eigenfrequencies")
        && shape.first() == Some(&n_times);
    let kind = match (is_number, is_series) {
        (false, _) => Kind::Other,
        (true, true) => Kind::Series,
        (true, false) => Kind::Fixed,
    };
    let unit = dataset.attr("unit").and_then(|a| a.read_scalar::<VarLenUnicode>());
    Entry {
        kind,
        shape,
        unit: unit.map_or_else(|_| String::new(), |u| u.as_str().to_owned()),
        same: None,
        part: None,
    }
}
