//! Results of many runs in one table: a row per run, whatever became of it.

mod format;
mod runs;
mod table;
mod write;

pub use format::{CSV_TABLE, HDF5_TABLE};
pub use runs::{Run, find};
pub use table::{Column, Table, Values, gather};
pub use write::{csv, hdf5};
