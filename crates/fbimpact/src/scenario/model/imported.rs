//! Bodies from files.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use ffr_dynamics::body::RigidMotion;
use ffr_dynamics::interchange::{FullBody, ReducedModel};

use super::{Damping, Reduction};

/// What was read from a body file.
#[derive(Debug, Clone)]
pub struct FromFile<T> {
    /// The file, found from the directory of the scenario.
    pub path: PathBuf,
    /// SHA-256 of the file.
    pub sha256: String,
    /// What is in it.
    pub value: Arc<T>,
}

impl<T> PartialEq for FromFile<T> {
    /// Whether the files have the same contents.
    fn eq(&self, other: &Self) -> bool {
        self.sha256 == other.sha256
    }
}

/// A body from a file.
#[derive(Debug, Clone, PartialEq)]
pub enum ImportedBody {
    /// Reduced already.
    Reduced(FromFile<ReducedModel>),
    /// Matrices, to be reduced.
    Full {
        /// Matrices and markers.
        body: FromFile<FullBody>,
        /// Reduced basis.
        reduction: Reduction,
        /// Damping of the elastic coordinates.
        damping: Option<Damping>,
        /// Marker that a tangent frame follows; a Buckens frame without one.
        frame: Option<String>,
    },
}

impl ImportedBody {
    /// The file.
    pub fn path(&self) -> &Path {
        match self {
            Self::Reduced(reduced) => &reduced.path,
            Self::Full { body, .. } => &body.path,
        }
    }

    /// Rigid motions of the body.
    pub fn motion(&self) -> RigidMotion {
        match self {
            Self::Reduced(reduced) => reduced.value.data().motion,
            Self::Full { body, .. } => body.value.body().motion,
        }
    }
}
