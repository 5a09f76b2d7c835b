//! Opens a result file for reading.

use std::path::Path;

use hdf5::File;
use hdf5::types::VarLenUnicode;

use crate::error::ResultError;
use crate::file::fault::Access;
use crate::file::hdf5_integrity;
use crate::file::plain_file;

/// Value of the root attribute `format`.
pub const FORMAT: &str = "fbimpact";
/// Value of the root attribute `format_version`; raised whenever an old reader would misread a new
/// file.
pub const FORMAT_VERSION: u32 = 1;

/// Opens `path` without a lock, so that a run may still be writing it.
///
/// # Errors
/// [`ResultError::File`] if it cannot be read or is not a result file.
pub fn open(path: &Path) -> Result<File, ResultError> {
    if let Err(e) = plain_file::open(path) {
        return Err(ResultError::system(path, Access::Read, e));
    }
    let file = hdf5_integrity::open(path).map_err(|fault| ResultError::io(path, fault))?;
    if attribute(&file, "format").as_deref() != Some(FORMAT) {
        return Err(ResultError::io(path, "is not a result file of fbimpact"));
    }
    Ok(file)
}

/// A text attribute of the root.
pub fn attribute(file: &File, name: &str) -> Option<String> {
    let value: VarLenUnicode = file.attr(name).ok()?.read_scalar().ok()?;
    Some(value.as_str().to_owned())
}

/// Attribute of `/scenario`: SHA-256 of what the result follows from.
pub const INPUTS: &str = "inputs_sha256";

/// A text attribute of `/scenario`, or an empty text.
pub fn of_scenario(file: &File, name: &str) -> String {
    let value = || file.dataset("scenario").ok()?.attr(name).ok()?.read_scalar::<VarLenUnicode>().ok();
    value().map(|text| text.as_str().to_owned()).unwrap_or_default()
}

/// The resolved scenario that the file was made from.
///
/// # Errors
/// Those of HDF5.
pub fn scenario_text(file: &File) -> hdf5::Result<String> {
    hdf5_integrity::text(&file.dataset("scenario")?)
}
