//! Why results of a run cannot be written.

use std::io;

use result_files::file::error_text::{of_hdf5, of_io};
use result_files::file::fault::FileError;

/// Why results cannot be written while a run goes on.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RecordingFault {
    /// The file cannot be written to.
    #[error("results cannot be written: {}", of_hdf5(.0))]
    Results(#[from] hdf5::Error),
    /// The disk has no room for what comes next.
    #[error("results cannot be written: {}", of_io(.0))]
    Space(io::Error),
    /// The restart file cannot be written to.
    #[error("results cannot be written: the restart file: {}", of_io(.0))]
    Restart(io::Error),
    /// The restart file cannot be read again.
    #[error("results cannot be written: {0}")]
    Reread(FileError),
    /// The restart file cannot be gone on with.
    #[error(transparent)]
    GoOn(FileError),
    /// What the restart file holds belongs to other datasets.
    #[error("results cannot be written: the restart file belongs to another run")]
    OtherRun,
    /// The file was closed before.
    #[error("the result file is closed")]
    Closed,
}
