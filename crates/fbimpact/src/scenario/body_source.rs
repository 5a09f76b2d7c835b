//! Body files, meshes and files of splines that a scenario names.

use std::path::PathBuf;
use std::sync::Arc;

use fe_mesh::Mesh;
use iga_core::nurbs::{FaceId, Patch};

use super::tables::LengthUnit;
use crate::interchange::body_file::BodyFile;

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
    /// SHA-256 of the file and those that it includes.
    pub sha256: String,
    /// Unit of length that the scenario gives it.
    pub units: LengthUnit,
    /// The part that it names.
    pub part: Option<String>,
    /// What is in it, in metres.
    pub mesh: Arc<Mesh>,
}

/// A file of splines that has been read.
#[derive(Debug)]
pub struct SplineSource {
    /// The file, found from the directory of the scenario.
    pub path: PathBuf,
    /// SHA-256 of the file.
    pub sha256: String,
    /// Length of its unit \[m\].
    pub unit: f64,
    /// What is in it, in metres.
    pub given: GivenPatches,
}

/// Patches as they are given, with the pairs of faces that their file says are joined.
#[derive(Debug, Clone, PartialEq)]
pub struct GivenPatches {
    /// The patches.
    pub patches: Vec<Patch>,
    /// Pairs of faces.
    pub joined: Vec<[FaceId; 2]>,
    /// Names that the file gives to faces.
    pub faces: Vec<(String, Vec<FaceId>)>,
}
