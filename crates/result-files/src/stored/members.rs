//! The bodies and contacts of a result, wherever their series are: in a group of their own, `/bodies/NAME/position`, or in datasets that
//! all of them share, `/arrays/bodies/position` (time × body × component), as runs of many bodies have them.

use std::collections::{BTreeMap, HashMap};
use std::mem::take;

use hdf5::types::VarLenUnicode;
use hdf5::{Dataset, File, Group, H5Type, Result};
use ndarray::{Ix1, Ix2, s};

use super::{Entry, Kind};
use crate::file::hdf5_integrity;

/// Group of the datasets that all members of another group share.
pub const ARRAYS: &str = "arrays";
/// Dataset of the names of the members in their order.
pub const NAMES: &str = "name";

/// Members of one group of a file.
#[derive(Debug, Clone)]
pub struct Members {
    own: Option<Group>,
    all: Option<Group>,
    names: Vec<String>,
    places: HashMap<String, usize>,
}

impl Members {
    /// The members of the group `kind`; none if there is no such group.
    ///
    /// # Errors
    /// Those of HDF5.
    pub fn of(file: &File, kind: &str) -> Result<Self> {
        let group = |path: &str| if file.link_exists(path) { file.group(path).map(Some) } else { Ok(None) };
        let own = group(kind)?;
        let all = if file.link_exists(ARRAYS) { group(&format!("{ARRAYS}/{kind}"))? } else { None };
        let mut names = all.as_ref().map_or_else(|| Ok(Vec::new()), names)?;
        let places: HashMap<_, _> = names.iter().cloned().zip(0..).collect();
        let others = own.as_ref().map_or_else(|| Ok(Vec::new()), Group::member_names)?;
        names.extend(others.into_iter().filter(|name| !places.contains_key(name)));
        Ok(Self { own, all, names, places })
    }

    /// Their names.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// The group that the member `name` has for itself.
    pub fn group(&self, name: &str) -> Option<Group> {
        self.own.as_ref().filter(|own| own.link_exists(name))?.group(name).ok()
    }

    /// Whether the member `name` has the series `series`.
    pub fn has(&self, name: &str, series: &str) -> bool {
        let shared =
            || self.places.contains_key(name) && self.all.as_ref().is_some_and(|all| all.link_exists(series));
        self.group(name).is_some_and(|own| own.link_exists(series)) || shared()
    }

    /// The numbers of a series of the member `name` in the order of rows.
    ///
    /// # Errors
    /// Those of HDF5, and if there is none.
    pub fn rows<T: H5Type>(&self, name: &str, series: &str) -> Result<Vec<T>> {
        let own = self.group(name).filter(|own| own.link_exists(series));
        match (own, self.places.get(name), &self.all) {
            (Some(own), ..) => hdf5_integrity::rows(&own.dataset(series)?),
            (None, Some(index), Some(all)) => part(&all.dataset(series)?, *index),
            _ => Err(hdf5::Error::from(format!("there is no {series} of {name}"))),
        }
    }
}

fn names(group: &Group) -> Result<Vec<String>> {
    let names = hdf5_integrity::rows::<VarLenUnicode>(&group.dataset(NAMES)?)?;
    Ok(names.iter().map(|name| name.as_str().to_owned()).collect())
}

/// The numbers of member `index` of a dataset that all share.
///
/// # Errors
/// Those of HDF5, and if the dataset has no such member.
pub fn part<T: H5Type>(dataset: &Dataset, index: usize) -> Result<Vec<T>> {
    hdf5_integrity::check(dataset)?;
    match dataset.shape()[..] {
        [_, n] if index < n => Ok(dataset.read_slice::<T, _, Ix1>(s![.., index])?.into_iter().collect()),
        [_, n, _] if index < n => {
            Ok(dataset.read_slice::<T, _, Ix2>(s![.., index, ..])?.into_iter().collect())
        }
        _ => Err(hdf5::Error::from(format!("{} has no member {index}", dataset.name()))),
    }
}

/// Puts the parts of all members in place of the datasets that they share, under the names that they have where each has a group.
///
/// # Errors
/// Those of HDF5.
pub fn share_out(file: &File, entries: &mut BTreeMap<String, Entry>) -> Result<()> {
    let begin = format!("{ARRAYS}/");
    let is_shared = |(path, _): &(String, Entry)| path.starts_with(&begin);
    let (shared, own): (Vec<_>, Vec<_>) = take(entries).into_iter().partition(is_shared);
    *entries = own.into_iter().collect();
    let mut known: HashMap<String, Vec<String>> = HashMap::new();
    for (path, entry) in shared {
        let [_, kind, series] = path.split('/').collect::<Vec<_>>()[..] else { continue };
        if series == NAMES || entry.shape.len() < 2 {
            continue;
        }
        if !known.contains_key(kind) {
            known.insert(kind.to_owned(), names(&file.group(&format!("{begin}{kind}"))?)?);
        }
        let shape = [&entry.shape[..1], &entry.shape[2..]].concat();
        for (index, name) in known[kind].iter().enumerate().take(entry.shape[1]) {
            let part = Some((path.clone(), index));
            let own = Entry { shape: shape.clone(), kind: Kind::Series, part, ..entry.clone() };
            entries.insert(format!("{kind}/{name}/{series}"), own);
        }
    }
    Ok(())
}
