//! The result file: HDF5 in, HDF5 out. The only part of the program that knows the file format.
//!
//! Layout: `docs/results.md`. [`Recorder`] writes while a run goes on, [`summary`] reads a finished file.

mod scales;
mod series;
pub mod pressure;
pub mod tables;
pub mod columns;
mod stress;
mod file;
mod space;
pub mod journal;
mod recorder;
pub mod open;
pub mod reactions;
pub mod warnings;
pub mod summary;
pub mod stored;
pub mod text;
pub mod thin;
pub mod reference;

pub use file::{OutputFile, linked, part_path, restart_path};
pub use recorder::{Recorder, Status};

/// Value of the root attribute `format`.
pub const FORMAT: &str = "fbimpact";
/// Value of the root attribute `format_version`; raised whenever an old reader would misread a new file.
pub const FORMAT_VERSION: u32 = 1;
