//! What can be wrong with a file that is read or written.

use std::error::Error;
use std::fmt;
use std::io;
use std::path::PathBuf;

use crate::error_text::{of_hdf5, of_io};
use crate::hdf5_integrity::OpenFault;

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
    /// HDF5 did not write it.
    #[error("cannot be written: {}", of_hdf5(.0))]
    Unwritten(hdf5::Error),
    /// A complete file that cannot be renamed.
    #[error("cannot be given its final name {}: {source}", target.display())]
    FinalName {
        /// The name.
        target: PathBuf,
        /// The answer of the system.
        source: io::Error,
    },
    /// What is in the file, or should be, with an enumeration of its own: bodies, matrices, figures.
    #[error(transparent)]
    Contents(Box<dyn Error + Send + Sync>),
    /// Inputs that do not make what the file is to hold.
    #[error("cannot be made: {0}")]
    Unmade(Box<dyn Error + Send + Sync>),
    /// Bytes that are no text.
    #[error("is no text; write it in its text form")]
    NoText,
    /// What a result does not hold.
    #[error(transparent)]
    Result(#[from] ResultFault),
    /// Why a run cannot write to a file.
    #[error(transparent)]
    Output(#[from] OutputFault),
    /// A folder of runs of something else.
    #[error("holds files and no {mark}, name a new folder with -o")]
    ForeignFolder {
        /// The file that marks folders of runs.
        mark: &'static str,
    },
    /// A folder without anything to collect.
    #[error("holds no results (.h5) and no traces of runs (.exit, .set)")]
    NothingToCollect,
    /// A place to collect from that does not exist.
    #[error("does not exist: name a folder of results, a result (.h5), or a run by its path without .h5")]
    NoRuns,
}

impl FileFault {
    /// What the system answered to an access of a file.
    pub fn system(access: Access, source: io::Error) -> Self {
        Self::System { access, source }
    }

    /// What is wrong with the contents of a file.
    pub fn contents(fault: impl Into<Box<dyn Error + Send + Sync>>) -> Self {
        Self::Contents(fault.into())
    }
}

/// What a result file does not hold.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ResultFault {
    /// No file of HDF5, or a damaged one.
    #[error("is not a readable HDF5 file: {0}")]
    NotHdf5(#[from] OpenFault),
    /// A file of another program.
    #[error("is not a result file of fbimpact")]
    Foreign,
    /// Something that HDF5 cannot read.
    #[error("has a part that cannot be read: {}", of_hdf5(.0))]
    Part(hdf5::Error),
    /// A dataset that cannot be read.
    #[error("/{name} cannot be read: {}", of_hdf5(source))]
    Dataset {
        /// Its path.
        name: String,
        /// Why.
        source: hdf5::Error,
    },
    /// A table, or group of series, that cannot be read.
    #[error("has no readable {what}: {}", of_hdf5(source))]
    Table {
        /// What it holds, or its path.
        what: String,
        /// Why.
        source: hdf5::Error,
    },
    /// Times that are none.
    #[error("/time holds {value} at row {row}, times must be finite and must not decrease")]
    Time {
        /// The row, from 0.
        row: usize,
        /// What it holds \[s\].
        value: f64,
    },
    /// A run that stored nothing.
    #[error("has no stored states")]
    NoStates,
    /// A run that stored nothing that figures show.
    #[error("has no stored states, there is nothing to draw")]
    NothingToDraw,
    /// States of a body that are not complete.
    #[error("has fewer states of body \"{body}\" than instants")]
    FewStates {
        /// Name of the body.
        body: String,
    },
    /// Numbers of phases that are not complete.
    #[error("has no readable phases: there are fewer than instants")]
    FewPhases,
    /// Pressures, places and areas of different lengths.
    #[error("has no readable pressures of contact \"{contact}\": their lengths do not fit together")]
    PressureLengths {
        /// Name of the contact.
        contact: String,
    },
}

/// Why nothing can be written under a name.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OutputFault {
    /// A name that HDF5 cannot take.
    #[error("is no name in UTF-8, which HDF5 needs; choose another name with -o")]
    NotUtf8,
    /// A directory.
    #[error("is a directory, name a file with -o")]
    Directory,
    /// A directory that there is not.
    #[error("directory {} does not exist, create it or choose another one", directory.display())]
    NoDirectory {
        /// The directory.
        directory: PathBuf,
    },
    /// Something else than a file.
    #[error("is a device or pipe, name a file with -o")]
    Device,
    /// A file that no run wrote.
    #[error("exists and is not a result file, choose another name or add --force")]
    NoResult,
    /// A file that is there already.
    #[error("exists, choose another name or add --force")]
    Exists,
    /// Links in a circle.
    #[error("is a link to itself, name a file with -o")]
    LinkToItself,
    /// A file that is being written.
    #[error("another run is writing this file, choose another name with -o")]
    Locked,
    /// A file that others take each time it is free.
    #[error("other runs keep replacing this file, choose another name with -o")]
    Replaced,
    /// The scenario.
    #[error("is the scenario itself, name another output")]
    Scenario,
    /// A file that the scenario reads.
    #[error("is the file of body \"{body}\", name another output")]
    BodyFile {
        /// Name of the body.
        body: String,
    },
    /// A file that the command reads.
    #[error("is read as well, name another output")]
    Input,
}
