//! The result file as a run writes it; what a finished one holds is known to `result-files`.
//!
//! Layout: `docs/results.md`. [`Recorder`] writes while a run goes on, [`result_files::stored::summary`]
//! reads a finished file.
//!
//! What stands between a run and the weak points of HDF5, and the test that fails without it:
//!
//! | guard | without it | test |
//! |---|---|---|
//! | `disk_space`: room on the disk before a flush | a full disk leaves a file that cannot be read | `faults`: `run_on_a_full_disk_...` |
//! | `recorder`: metadata stay in memory between flushes | a killed run of many bodies leaves one that cannot be read | `results`: `between_flushes_...` |
//! | `disk_space::trim` | a small result is twice as long | `results`: `everything_written_...` |
//! | `dataset::unicode` without NUL | a title ends the run | `dataset` |
//! | `hdf5_integrity`: shapes compared with what is stored | reading takes memory until the process is stopped | `damaged`: `shape_larger_...` |
//! | `hdf5_integrity`: lengths of texts | the same | `damaged`: `text_longer_...` |
//! | `hdf5_integrity::heaps` | reading never ends | `damaged`: `heap_of_texts_...` |

pub mod stress;
mod disk_space;
mod series;
pub mod pressure;
pub mod columns;
pub mod fault;
pub mod rows;
pub mod journal;
mod recorder;
mod file;
pub mod left;
pub mod reference;

pub use file::{OutputFile, RESULT, linked, part_path, restart_path};
pub use recorder::{Recorder, Status};
