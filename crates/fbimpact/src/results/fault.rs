//! Why results of a run cannot be written, or the run not be taken up.

use std::io;
use std::path::PathBuf;

use result_files::error_text::{of_hdf5, of_io};
use result_files::file_fault::{FileError, FileFault};

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

/// Why a run cannot be taken up.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ResumeFault {
    /// A run that reached its end.
    #[error(
        "is complete, there is nothing to resume; for a later end start a new run with --set simulation.end_time=..."
    )]
    Complete,
    /// A run that would fail again.
    #[error("is of a run that failed and would fail again, start a new run with another scenario")]
    Failed,
    /// A run without its restart file.
    #[error("cannot be resumed without {}, start the run anew", restart.display())]
    NoRestartFile {
        /// The restart file.
        restart: PathBuf,
    },
    /// No run.
    #[error("no such run: neither it nor {} exists", part.display())]
    NoRun {
        /// The file of a run that has not ended.
        part: PathBuf,
    },
    /// A restart file of another version.
    #[error("was written by another version of the program, start the run anew")]
    OtherVersion,
    /// A file that is no restart file, or not any more.
    #[error("is damaged or no restart file, start the run anew")]
    NotRestartFile,
    /// A restart file that ends within its header.
    #[error("is damaged, start the run anew")]
    Damaged,
}

impl From<ResumeFault> for FileFault {
    fn from(fault: ResumeFault) -> Self {
        Self::contents(fault)
    }
}
