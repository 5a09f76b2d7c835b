//! Reading HDF5 files that may be damaged: what the library takes on trust and pays for with memory or time is checked first.
//!
//! Headers and indices of the files that this program writes have checksums, which the library compares; the texts of tables and
//! their lengths have none, and files of other programs may have none at all.

mod dataset;
mod heaps;

pub use dataset::{rows, text};

use std::path::Path;

use hdf5::File;

use crate::error_text;

/// Opens `path` for reading without a lock, so that a run may still be writing it.
///
/// # Errors
/// [`OpenFault::Texts`], [`OpenFault::Hdf5`].
pub fn open(path: &Path) -> Result<File, OpenFault> {
    if let Ok(Some(at)) = heaps::unreadable(path) {
        return Err(OpenFault::Texts { at });
    }
    let file = File::with_options().with_fapl(|p| p.file_locking(false)).open(path);
    file.map_err(OpenFault::Hdf5)
}

/// Why a file cannot be opened as one of HDF5.
#[derive(Debug, thiserror::Error)]
pub enum OpenFault {
    /// The system does not let it be read.
    #[error("{}", error_text::of_io(.0))]
    System(std::io::Error),
    /// Texts whose place in the file makes no sense.
    #[error("the texts at byte {at} are damaged, copy the file again or make it anew")]
    Texts {
        /// Where they are.
        at: u64,
    },
    /// The library refuses it.
    #[error("{}", error_text::of_hdf5(.0))]
    Hdf5(hdf5::Error),
}
