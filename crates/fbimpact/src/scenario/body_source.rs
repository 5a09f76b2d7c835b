//! A body file that a scenario names.

use std::path::PathBuf;

use crate::body_file::BodyFile;

/// A body file that has been read.
#[derive(Debug)]
pub struct BodySource {
    /// The file, found from the directory of the scenario.
    pub path: PathBuf,
    /// SHA-256 of the file.
    pub sha256: String,
    /// What is in it.
    pub body: BodyFile,
}
