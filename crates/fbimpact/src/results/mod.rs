//! The result file: HDF5 in, HDF5 out. The only part of the program that knows the file format.
//!
//! Layout: `docs/results.md`. [`Recorder`] writes while a run goes on, [`summary`] reads a finished file.
//!
//! What stands between a run and the weak points of HDF5, and the test that fails without it:
//!
//! | guard | without it | test |
//! |---|---|---|
//! | `disk_space`: room on the disk before a flush | a full disk leaves a file that cannot be read | `faults`: `run_on_a_full_disk_...` |
//! | `recorder`: metadata stay in memory between flushes | a killed run of many bodies leaves one that cannot be read | `results`: `between_flushes_...` |
//! | `disk_space::trim` | a small result is twice as long | `results`: `everything_written_...` |
//! | `series::unicode` without NUL | a title ends the run | `series` |
//! | `hdf5_integrity`: shapes compared with what is stored | reading takes memory until the process is stopped | `damaged`: `shape_larger_...` |
//! | `hdf5_integrity`: lengths of texts | the same | `damaged`: `text_longer_...` |
//! | `hdf5_integrity::heaps` | reading never ends | `damaged`: `heap_of_texts_...` |

mod scales;
mod series;
pub mod pressure;
pub mod pressure_series;
pub mod tables;
pub mod columns;
pub mod stress;
mod file;
mod disk_space;
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
