//! How a stored table is recognised, as different from a result.

use std::path::Path;

use hdf5::types::VarLenUnicode;

use crate::file::hdf5_integrity;

/// Value of the root attribute `format` of a table.
pub const TABLE_FORMAT: &str = "fbimpact-table";

/// Whether a file is a table that [`super::write::hdf5`] wrote.
pub fn is_table(path: &Path) -> bool {
    let format = || {
        hdf5_integrity::open(path).ok()?.attr("format").and_then(|a| a.read_scalar::<VarLenUnicode>()).ok()
    };
    format().is_some_and(|format| format.as_str() == TABLE_FORMAT)
}
