//! Files, whatever they hold: read as files and nothing else, written in whole or not at all, HDF5
//! that may be damaged, and what can be wrong with any of them.

pub mod error_text;
pub mod plain_file;
pub mod hdf5_integrity;
pub mod fault;
pub mod whole_file;
pub mod output;
