//! A small copy of a result: what `compare` needs of it and no more.

use std::path::Path;

use hdf5::types::VarLenUnicode;
use hdf5::{File, Group, Result};
use ndarray::ArrayD;

use crate::dataset::{text_attribute, unicode, write_text};
use crate::error::ResultError;
use crate::file::fault::FileFault;
use crate::file::whole_file;
use crate::stored::open::FORMAT_VERSION;
use crate::stored::{Entry, Kind, Stored};
use crate::tables::{self, ImpactRow};

/// Root attributes that are copied.
const ATTRIBUTES: [&str; 6] = ["format", "program_version", "created", "title", "status", "message"];

/// Whether a dataset goes into a small copy. Elastic coordinates are many, and what they do shows
/// in energies and points; the others say how a result was reached.
fn is_kept(name: &str, entry: &Entry) -> bool {
    let is_modal = name.starts_with("bodies/") && name.contains("/elastic_");
    entry.kind != Kind::Other && !is_modal && name != "phase" && !name.starts_with("timings/")
}

/// Rows to keep: the first and last and at most `n` in all, as evenly among the stored ones as
/// possible.
fn rows(stored: usize, n: usize) -> Vec<usize> {
    if stored <= n {
        return (0..stored).collect();
    }
    let n = n.max(2);
    (0..n).map(|i| i * (stored - 1) / (n - 1)).collect()
}

/// Writes a small copy of `source` with at most `n` instants to the new file `target`, in single
/// precision except for time.
///
/// # Errors
/// [`ResultError::File`] if one of the files cannot be read or written.
pub fn write(source: &Stored, target: &Path, n: usize) -> std::result::Result<(), ResultError> {
    let fail = |e: hdf5::Error| ResultError::io(target, FileFault::unwritten(e));
    // Version 1.8 files, as those of a run; the lock of the output would refuse HDF5's own.
    let mut builder = File::with_options();
    let file = builder.with_fapl(|p| p.libver_v110().file_locking(false)).create(target).map_err(fail)?;
    let rows = rows(source.time.len(), n);
    header(source, &file, &rows).map_err(fail)?;
    let kept = || source.entries.iter().filter(|(name, entry)| is_kept(name, entry));
    for (name, entry) in kept().filter(|(_, entry)| entry.same.is_none()) {
        let values = source.values(name)?;
        let (shape, values) = match entry.kind {
            Kind::Series => {
                let width = entry.width();
                let pick = |r: &usize| values[r * width..(r + 1) * width].iter().copied();
                let shape: Vec<usize> = [&[rows.len()], &entry.shape[1..]].concat();
                (shape, rows.iter().flat_map(pick).collect())
            }
            _ => (entry.shape.clone(), values),
        };
        dataset(&file, name, shape, &values, &entry.unit).map_err(fail)?;
    }
    for (name, first) in kept().filter_map(|(name, entry)| Some((name, entry.same.as_ref()?))) {
        let path = name.rsplit_once('/').map_or("", |(path, _)| path);
        let link = |_| file.link_hard(&format!("/{first}"), &format!("/{name}"));
        group(&file, path).and_then(link).map_err(fail)?;
    }
    whole_file::close(file).map_err(fail)
}

fn header(source: &Stored, file: &File, rows: &[usize]) -> Result<()> {
    for name in ATTRIBUTES {
        text_attribute(file, name, &source.attribute(name))?;
    }
    file.new_attr::<u32>().create("format_version")?.write_scalar(&FORMAT_VERSION)?;
    let scenario = write_text(file, "scenario", &source.scenario)?;
    if let Ok(hash) = source.file().dataset("scenario").and_then(|d| d.attr("sha256")) {
        let hash = hash.read_scalar::<VarLenUnicode>()?;
        text_attribute(&scenario, "sha256", hash.as_str())?;
    }
    let times: Vec<f64> = rows.iter().map(|i| source.time[*i]).collect();
    let time = file.new_dataset::<f64>().shuffle().deflate(9).chunk(times.len().max(1)).shape(times.len());
    let time = time.create("time")?;
    time.write_raw(&times)?;
    text_attribute(&time, "unit", "s")?;
    let mut table = tables::create::<ImpactRow>(file)?;
    source.impacts.iter().try_for_each(|row| table.push(row.clone()))
}

#[expect(clippy::cast_possible_truncation, reason = "single precision is the point: 6e-8 of a value")]
fn dataset(file: &File, name: &str, shape: Vec<usize>, values: &[f64], unit: &str) -> Result<()> {
    let (group, leaf) = match name.rsplit_once('/') {
        Some((path, leaf)) => (group(file, path)?, leaf),
        None => (file.as_group()?, name),
    };
    let values: Vec<f32> = values.iter().map(|x| *x as f32).collect();
    let is_scalar = shape.is_empty() || shape.contains(&0);
    let builder = group.new_dataset::<f32>();
    let builder = if is_scalar { builder } else { builder.shuffle().deflate(9).chunk(shape.clone()) };
    let dataset = builder.shape(shape.clone()).create(leaf)?;
    let array = ArrayD::from_shape_vec(shape, values).map_err(|e| hdf5::Error::from(e.to_string()))?;
    if !array.is_empty() {
        dataset.write(array.view())?;
    }
    dataset.new_attr::<VarLenUnicode>().create("unit")?.write_scalar(&unicode(unit)?)
}

/// The group at `path`, made if there is none.
fn group(file: &File, path: &str) -> Result<Group> {
    let mut group = file.as_group()?;
    for part in path.split('/') {
        group = if group.link_exists(part) { group.group(part)? } else { group.create_group(part)? };
    }
    Ok(group)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kept_rows_are_few_increasing_and_hold_both_ends() {
        for (stored, n) in [(0, 5), (1, 5), (5, 5), (6, 5), (1000, 7), (1000, 1)] {
            let rows = rows(stored, n);
            assert!(rows.len() <= n.max(2) && rows.windows(2).all(|w| w[0] < w[1]), "{stored} {n} {rows:?}");
            assert!(stored == 0 || (rows[0] == 0 && rows[rows.len() - 1] == stored - 1), "{rows:?}");
        }
    }
}
