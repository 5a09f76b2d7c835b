//! The table of impacts, of results of earlier versions as well.

use hdf5::types::{TypeDescriptor, VarLenUnicode};
use hdf5::{File, H5Type, Result};

use crate::file::hdf5_integrity;
use crate::tables::{ImpactRow, TableRow};

/// A row before impacts had bands. HDF5 leaves columns that a file does not have as they are in memory.
#[derive(H5Type, Clone)]
#[repr(C)]
struct RowWithoutBands {
    contact: VarLenUnicode,
    start: f64,
    end: f64,
    peak_force: f64,
    peak_time: f64,
    impulse: f64,
    approach_velocity: f64,
    separation_velocity: f64,
    restitution: f64,
}

impl From<RowWithoutBands> for ImpactRow {
    fn from(row: RowWithoutBands) -> Self {
        Self {
            contact: row.contact,
            start: row.start,
            end: row.end,
            peak_force: row.peak_force,
            peak_time: row.peak_time,
            impulse: row.impulse,
            approach_velocity: row.approach_velocity,
            separation_velocity: row.separation_velocity,
            restitution: row.restitution,
            peak_force_uncertainty: f64::NAN,
            duration_uncertainty: f64::NAN,
            impulse_uncertainty: f64::NAN,
            separation_velocity_uncertainty: f64::NAN,
            restitution_uncertainty: f64::NAN,
            uncertainty: VarLenUnicode::new(),
            peak_time_uncertainty: f64::NAN,
        }
    }
}

/// Rows of the table of impacts of `file`; none if there is no such table.
///
/// # Errors
/// As [`hdf5_integrity::rows`].
pub fn impacts(file: &File) -> Result<Vec<ImpactRow>> {
    if !file.link_exists(ImpactRow::NAME) {
        return Ok(Vec::new());
    }
    let dataset = file.dataset(ImpactRow::NAME)?;
    let descriptor = dataset.dtype()?.to_descriptor()?;
    let has = |name: &str| match &descriptor {
        TypeDescriptor::Compound(row) => row.fields.iter().any(|field| field.name == name),
        _ => true, // no table, which reading tells
    };
    if !has("uncertainty") {
        let rows: Vec<RowWithoutBands> = hdf5_integrity::rows(&dataset)?;
        return Ok(rows.into_iter().map(ImpactRow::from).collect());
    }
    let mut rows: Vec<ImpactRow> = hdf5_integrity::rows(&dataset)?;
    if !has("peak_time_uncertainty") {
        rows.iter_mut().for_each(|row| row.peak_time_uncertainty = f64::NAN);
    }
    Ok(rows)
}
