//! NURBS patches: geometry, refinement and named exact shapes.

pub mod jet;
pub mod patch;
pub mod refine;
pub mod grading;
pub mod symmetry;
pub mod shape;
pub mod lengths;
pub mod primitives;
pub mod box_newton;
pub mod locate;
pub mod interface;
pub mod linked;
pub mod local;
pub mod joining;
pub mod cutting;

pub use grading::{Grading, Window};
pub use interface::FaceId;
pub use jet::Jet;
pub use local::{RefinementWindow, refine_near};
pub use locate::{Located, PatchSearch, SAME_PLACE, locate};
pub use patch::Patch;
pub use refine::Prolongation;
pub use shape::{Shape, SingularSet};
pub use symmetry::Symmetry;
