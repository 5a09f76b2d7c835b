//! How a stored table is recognised, as different from a result.

use crate::file::output::Kind;

/// Value of the root attribute `format` of a table.
pub const TABLE_FORMAT: &str = "fbimpact-table";
/// Columns with which every table begins.
const FIRST_COLUMNS: &str = "run,status,exit_code,message,end_time,samples,energy_drift,";

/// A table in HDF5.
pub const HDF5_TABLE: Kind = Kind::hdf5("a table that fbimpact wrote", TABLE_FORMAT);
/// A table in CSV.
pub const CSV_TABLE: Kind = Kind::marked("a table that fbimpact wrote", FIRST_COLUMNS);
