//! Body files and meshes that a scenario names.

use std::path::PathBuf;
use std::sync::Arc;

use fe_mesh::Mesh;

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

/// A mesh that has been read.
#[derive(Debug)]
pub struct MeshSource {
    /// The file, found from the directory of the scenario.
    pub path: PathBuf,
    /// SHA-256 of the file.
    pub sha256: String,
    /// Unit of length that the scenario gives it.
    pub units: String,
    /// What is in it, in metres.
    pub mesh: Arc<Mesh>,
}
