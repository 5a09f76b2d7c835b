//! What can be wrong with a body file.

use std::path::PathBuf;

use ffr_dynamics::DynamicsError;
use result_files::file::error_text;
use result_files::file::hdf5_integrity::OpenFault;
use thiserror::Error;

/// A body file that cannot be read or written.
#[derive(Debug, Error)]
#[error("{}: {fault}", path.display())]
pub struct BodyFileError {
    /// The file.
    pub path: PathBuf,
    /// What is wrong with it.
    #[source]
    pub fault: Box<BodyFault>,
}

/// What is wrong with a body file. Texts read after the file's name.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum BodyFault {
    /// There is no such file, or it is not HDF5.
    #[error("cannot be opened as an HDF5 file: {0}")]
    NotHdf5(#[from] OpenFault),
    /// A complete file that cannot be given its name.
    #[error("cannot be written: {}", error_text::of_io(.0))]
    Unwritten(#[from] std::io::Error),
    /// An attribute has another value than the format asks for.
    #[error("attribute {name} of {at} is {found}, expected {expected}")]
    Attribute {
        /// Path of the group or dataset.
        at: String,
        /// Name of the attribute.
        name: String,
        /// What is possible.
        expected: String,
        /// What was found.
        found: String,
    },
    /// A dataset or group is missing.
    #[error("{what} {path} is missing, expected {expected}")]
    Missing {
        /// "dataset" or "group".
        what: &'static str,
        /// Its path.
        path: String,
        /// Its shape and meaning.
        expected: String,
    },
    /// A dataset has the wrong shape.
    #[error("dataset {path} has the shape {found:?}, expected {expected}")]
    Shape {
        /// Its path.
        path: String,
        /// The shape asked for.
        expected: String,
        /// The shape found.
        found: Vec<usize>,
    },
    /// A dataset holds numbers of the wrong type, or a number that it must not hold.
    #[error("dataset {path} holds {found}, {allowed}")]
    Numbers {
        /// Its path.
        path: String,
        /// The type, or the number and where it stands.
        found: String,
        /// What it may hold, in a sentence of its own.
        allowed: String,
    },
    /// A name that HDF5 cannot hold.
    #[error("the name \"{name}\" cannot be stored: it is empty, has a slash or is a dot")]
    Name {
        /// The name.
        name: String,
    },
    /// The numbers do not make a body.
    #[error("{at}: {source}")]
    Data {
        /// Path of the group or dataset that is at fault, as far as known.
        at: String,
        /// What does not fit.
        source: DynamicsError,
    },
    /// The library failed.
    #[error("HDF5: {}", error_text::of_hdf5(.0))]
    Hdf5(#[from] hdf5::Error),
}

impl BodyFault {
    /// An index in the dataset `path` that is negative or larger than `last`; its position is
    /// counted along the stored numbers.
    pub(super) fn index(path: String, position: usize, value: i64, last: i64) -> Self {
        let found = format!("the index {value} at position {position}");
        Self::Numbers { path, found, allowed: format!("possible are 0 to {last}") }
    }
}
