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
/// Why it cannot be read, in words for users.
pub fn open(path: &Path) -> Result<File, String> {
    if let Ok(Some(at)) = heaps::unreadable(path) {
        return Err(format!("the texts at byte {at} are damaged, copy the file again or make it anew"));
    }
    let file = File::with_options().with_fapl(|p| p.file_locking(false)).open(path);
    file.map_err(|e| error_text::of_hdf5(&e))
}
