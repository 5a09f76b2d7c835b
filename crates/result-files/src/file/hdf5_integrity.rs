//! Reading HDF5 files that may be damaged: what the library takes on trust and pays for with memory
//! or time is checked first.
//!
//! Headers and indices of the files that this program writes have checksums, which the library
//! compares; the texts of tables and their lengths have none, and files of other programs may have
//! none at all.

mod dataset;
mod foreign;
mod heaps;

pub use dataset::{check, rows, scalar, text};
pub use foreign::forbid;

use std::path::Path;

use hdf5::File;

use crate::file::{error_text, plain_file};

/// Opens `path` for reading without a lock, so that a run may still be writing it.
///
/// # Errors
/// [`OpenFault::System`], [`OpenFault::Texts`], [`OpenFault::Link`], [`OpenFault::Hdf5`].
pub fn open(path: &Path) -> Result<File, OpenFault> {
    forbid();
    plain_file::open(path).map_err(OpenFault::System)?;
    if let Ok(Some(at)) = heaps::unreadable(path) {
        return Err(OpenFault::Texts { at });
    }
    let file = File::with_options().with_fapl(|p| p.file_locking(false)).open(path);
    let file = file.map_err(OpenFault::Hdf5)?;
    match foreign::external_link(&file) {
        Some(name) => Err(OpenFault::Link { name }),
        None => Ok(file),
    }
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
    /// A link into another file.
    #[error(
        "/{name} is a link into another file, which is not followed; copy what it leads to into this file"
    )]
    Link {
        /// Path of the link, without the first slash.
        name: String,
    },
    /// The library refuses it.
    #[error("{}", error_text::of_hdf5(.0))]
    Hdf5(hdf5::Error),
}
