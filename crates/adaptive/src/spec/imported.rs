//! Bodies from files.

use std::sync::Arc;

use ffr_dynamics::body::RigidMotion;
use ffr_dynamics::interchange::{FullBody, ReducedModel};

use super::reduction::{DampingSpec, ReductionSpec};

/// A body from a file.
#[derive(Debug, Clone)]
pub enum ImportedSpec {
    /// Reduced already.
    Reduced(Arc<ReducedModel>),
    /// Matrices, to be reduced.
    Full {
        /// Matrices and markers.
        body: Arc<FullBody>,
        /// Reduced basis.
        reduction: ReductionSpec,
        /// Whether the basis has the static answers to the body's joints and loads.
        static_answers: bool,
        /// Damping of the elastic coordinates.
        damping: DampingSpec,
        /// Marker that a tangent frame follows; a Buckens frame without one.
        frame: Option<String>,
    },
}

impl PartialEq for ImportedSpec {
    /// Whether both are the same body in memory, reduced alike.
    fn eq(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Reduced(a), Self::Reduced(b)) => Arc::ptr_eq(a, b),
            (
                Self::Full { body: a, reduction: r, static_answers: s, damping: d, frame: f },
                Self::Full { body, reduction, static_answers, damping, frame },
            ) => Arc::ptr_eq(a, body) && (r, s, d, f) == (reduction, static_answers, damping, frame),
            _ => false,
        }
    }
}

impl ImportedSpec {
    /// Rigid motions of the body.
    pub fn motion(&self) -> RigidMotion {
        match self {
            Self::Reduced(model) => model.data().motion,
            Self::Full { body, .. } => body.body().motion,
        }
    }

    /// Lets the frame of a body with matrices follow `marker`; a reduced body has its frame.
    pub fn set_frame_marker(&mut self, marker: String) {
        if let Self::Full { frame, .. } = self {
            *frame = Some(marker);
        }
    }
}
