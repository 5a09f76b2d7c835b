//! Body files: unreduced bodies of other finite element programs, and reduced bodies to be used
//! again (docs/body-file.md).
//!
//! The only place that knows their HDF5 layout. What is in a file is checked by
//! [`ffr_dynamics::interchange`].

mod fault;
mod dataset;
mod full;
mod reduced;
mod read;
mod write;

use std::sync::Arc;

use ffr_dynamics::body::RigidMotion;
use ffr_dynamics::interchange::{FullBody, ReducedModel};
use result_files::file::output::Kind;

pub use fault::{BodyFault, BodyFileError};
pub use read::read;
pub use write::{write_full, write_reduced};

/// Value of the root attribute `format`.
pub const FORMAT: &str = "fbimpact-body";
/// A body file.
pub const KIND: Kind = Kind::hdf5("a body file", FORMAT);
/// Value of the root attribute `format_version`; raised whenever an old reader would misread a new
/// file.
pub const FORMAT_VERSION: u32 = 1;

/// What a body file holds.
#[derive(Debug, Clone)]
pub enum BodyFile {
    /// Matrices of an unreduced body.
    Full(Arc<FullBody>),
    /// A reduced body.
    Reduced(Arc<ReducedModel>),
}

impl BodyFile {
    /// Rigid motions of the body.
    pub fn motion(&self) -> RigidMotion {
        match self {
            Self::Full(full) => full.body().motion,
            Self::Reduced(reduced) => reduced.data().motion,
        }
    }

    /// Names of the markers.
    pub fn markers(&self) -> Vec<&str> {
        match self {
            Self::Full(full) => full.markers().iter().map(|(name, _)| name.as_str()).collect(),
            Self::Reduced(reduced) => reduced.markers().iter().map(|m| m.name.as_str()).collect(),
        }
    }

    /// Names of the points that are no markers: for output only.
    pub fn points(&self) -> Vec<&str> {
        match self {
            Self::Full(full) => {
                let names = full.points().iter().map(|(name, _)| name.as_str());
                names.filter(|name| full.markers().iter().all(|(marker, _)| marker != name)).collect()
            }
            Self::Reduced(reduced) => {
                let names = reduced.points().iter().map(|(name, _)| name.as_str());
                names.filter(|name| reduced.markers().iter().all(|m| m.name != *name)).collect()
            }
        }
    }
}
