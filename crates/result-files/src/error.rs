//! Why a result, or a file beside it, cannot be used.

use std::path::PathBuf;

use crate::file::fault::{Access, FileError, FileFault};
use crate::toml_text::fault::Faults;

/// Everything that ends work on result files.
#[derive(Debug, thiserror::Error)]
pub enum ResultError {
    /// A file cannot be read or written.
    #[error(transparent)]
    File(#[from] FileError),
    /// A file of tolerances is not valid.
    #[error(transparent)]
    Tolerances(#[from] Faults),
}

impl ResultError {
    /// What is wrong with the file `path`.
    pub fn io(path: impl Into<PathBuf>, fault: impl Into<FileFault>) -> Self {
        Self::File(FileError::new(path, fault.into()))
    }

    /// What the system answered to an access of the file `path`.
    pub fn system(path: impl Into<PathBuf>, access: Access, source: std::io::Error) -> Self {
        Self::io(path, FileFault::system(access, source))
    }
}
