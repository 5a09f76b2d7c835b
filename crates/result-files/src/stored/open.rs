//! Opens a result file for reading.

use std::path::Path;

use hdf5::File;
use hdf5::types::VarLenUnicode;

use crate::error::ResultError;
use crate::file::fault::Access;
use crate::file::hdf5_integrity;
use crate::file::plain_file;
use crate::words::shown::for_shell;

/// Value of the root attribute `format`.
pub const FORMAT: &str = "fbimpact";
/// Value of the root attribute `format_version`; raised whenever an old reader would misread a new
/// file. The version of files without arrays.
pub const FORMAT_VERSION: u32 = 1;
/// The version of files whose bodies share datasets ([`super::members`]), the latest.
pub const VERSION_OF_ARRAYS: u32 = 2;

/// Opens `path` without a lock, so that a run may still be writing it.
///
/// # Errors
/// [`ResultError::File`] if it cannot be read or is not a result file.
pub fn open(path: &Path) -> Result<File, ResultError> {
    if let Err(e) = plain_file::open(path) {
        return Err(ResultError::system(path, Access::Read, e));
    }
    if path.extension().is_some_and(|ending| ending == "toml") {
        let name = for_shell(path);
        let reason = format!(
            "is a scenario and no result; make one with: fbimpact run {name}, or look at it with: fbimpact check {name}"
        );
        return Err(ResultError::io(path, reason));
    }
    let file = hdf5_integrity::open(path).map_err(|fault| ResultError::io(path, fault))?;
    if attribute(&file, "format").as_deref() != Some(FORMAT) {
        return Err(ResultError::io(path, "is not a result file of fbimpact"));
    }
    // Without a version: of a time before there were any.
    let version = file.attr("format_version").and_then(|a| a.read_scalar::<i64>()).unwrap_or(1);
    if version > i64::from(VERSION_OF_ARRAYS) {
        let written = attribute(&file, "program_version").unwrap_or_else(|| "a later version".to_owned());
        return Err(ResultError::io(
            path,
            format!(
                "has format version {version}, this program reads up to {VERSION_OF_ARRAYS}: read it with fbimpact {written}, which wrote it, or a later one"
            ),
        ));
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

/// Rows of a table; none if there is no such table, as in small copies and in files of earlier
/// versions.
///
/// # Errors
/// Those of HDF5.
pub fn table<T: hdf5::H5Type>(file: &File, name: &str) -> hdf5::Result<Vec<T>> {
    if file.link_exists(name) { hdf5_integrity::rows(&file.dataset(name)?) } else { Ok(Vec::new()) }
}

/// The resolved scenario that the file was made from.
///
/// # Errors
/// Those of HDF5.
pub fn scenario_text(file: &File) -> hdf5::Result<String> {
    hdf5_integrity::text(&file.dataset("scenario")?)
}
