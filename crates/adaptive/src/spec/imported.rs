//! Bodies from files.

use std::sync::Arc;

use ffr_dynamics::body::RigidMotion;
use ffr_dynamics::interchange::{FullBody, ReducedModel};

use nalgebra::Vector3;

use super::body::FlexibleSpec;

/// A body from a file.
#[derive(Debug, Clone)]
pub enum ImportedSpec {
    /// Reduced already.
    Reduced(Arc<ReducedModel>),
    /// Matrices, to be reduced.
    Full {
        /// Matrices and markers.
        body: Arc<FullBody>,
        /// How it is reduced, damped and framed: a tangent frame follows a marker of the file.
        flexible: Box<FlexibleSpec>,
    },
}

impl PartialEq for ImportedSpec {
    /// Whether both are the same body in memory, reduced alike.
    fn eq(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Reduced(a), Self::Reduced(b)) => Arc::ptr_eq(a, b),
            (Self::Full { body: a, flexible: f }, Self::Full { body: b, flexible: g }) => {
                Arc::ptr_eq(a, b) && f == g
            }
            _ => false,
        }
    }
}

impl ImportedSpec {
    /// Number of unknowns of its matrices; none of a reduced body.
    pub fn n_unknowns(&self) -> usize {
        if let Self::Full { body, .. } = self { body.body().dofs.len() } else { 0 }
    }

    /// Its markers and where they are in the body's frame \[m\].
    pub fn markers(&self) -> Vec<(String, Vector3<f64>)> {
        match self {
            Self::Reduced(model) => model.markers().iter().map(|m| (m.name.clone(), m.position)).collect(),
            Self::Full { body, .. } => {
                body.markers().iter().map(|(name, weights)| (name.clone(), weights.position())).collect()
            }
        }
    }

    /// Rigid motions of the body.
    pub fn motion(&self) -> RigidMotion {
        match self {
            Self::Reduced(model) => model.data().motion,
            Self::Full { body, .. } => body.body().motion,
        }
    }
}
