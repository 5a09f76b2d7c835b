//! What can be wrong with a file that is read or written.

use std::borrow::Cow;
use std::error::Error;
use std::fmt;
use std::io;
use std::path::PathBuf;

use crate::file::error_text::{of_hdf5, of_io};
use crate::file::hdf5_integrity::OpenFault;

/// A file, or folder, that cannot be read or written.
#[derive(Debug, thiserror::Error)]
#[error("{}: {fault}", path.display())]
pub struct FileError {
    /// The file.
    pub path: PathBuf,
    /// What is wrong with it.
    pub fault: Box<FileFault>,
}

impl FileError {
    /// What is wrong with the file `path`.
    pub fn new(path: impl Into<PathBuf>, fault: FileFault) -> Self {
        Self { path: path.into(), fault: Box::new(fault) }
    }
}

/// What a program asks of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Access {
    /// To read it.
    Read,
    /// To write it.
    Write,
    /// To create it.
    Create,
    /// To remove it.
    Remove,
    /// To find the program itself.
    Find,
    /// To start a program.
    Start,
    /// To ask whether a program that was started has ended.
    Watch,
}

impl fmt::Display for Access {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Read => "read",
            Self::Write => "written",
            Self::Create => "created",
            Self::Remove => "removed",
            Self::Find => "found",
            Self::Start => "started",
            Self::Watch => "watched",
        })
    }
}

/// What is wrong with a file. Texts read after its name.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FileFault {
    /// The system refused.
    #[error("cannot be {access}: {}", of_io(source))]
    System {
        /// What was asked for.
        access: Access,
        /// The answer.
        source: io::Error,
    },
    /// Standard output takes no more.
    #[error("{0}")]
    Stream(io::Error),
    /// No file of HDF5, or a damaged one.
    #[error("is not a readable HDF5 file: {0}")]
    NotHdf5(#[from] OpenFault),
    /// HDF5 did not read or write something.
    #[error("{what}: {}", of_hdf5(source))]
    Hdf5 {
        /// What cannot be done.
        what: Cow<'static, str>,
        /// Why.
        source: hdf5::Error,
    },
    /// Where the file is, what it is called, or what it holds does not serve.
    #[error("{0}")]
    Unfit(Cow<'static, str>),
    /// What is in the file, or should be, with an enumeration of its own: bodies, matrices,
    /// figures.
    #[error(transparent)]
    Contents(Box<dyn Error + Send + Sync>),
    /// Inputs that do not make what the file is to hold.
    #[error("cannot be made: {0}")]
    Unmade(Box<dyn Error + Send + Sync>),
}

impl From<&'static str> for FileFault {
    fn from(reason: &'static str) -> Self {
        Self::Unfit(reason.into())
    }
}

impl From<String> for FileFault {
    fn from(reason: String) -> Self {
        Self::Unfit(reason.into())
    }
}

impl FileFault {
    /// What the system answered to an access of a file.
    pub fn system(access: Access, source: io::Error) -> Self {
        Self::System { access, source }
    }

    /// HDF5 did not write the file.
    pub fn unwritten(source: hdf5::Error) -> Self {
        Self::Hdf5 { what: "cannot be written".into(), source }
    }

    /// Something in a result that HDF5 cannot read.
    pub fn part(source: hdf5::Error) -> Self {
        Self::Hdf5 { what: "has a part that cannot be read".into(), source }
    }

    /// What is wrong with the contents of a file.
    pub fn contents(fault: impl Into<Box<dyn Error + Send + Sync>>) -> Self {
        Self::Contents(fault.into())
    }
}
