//! NURBS patches: geometry, faces, refinement and named exact shapes.

pub mod patch;
pub mod jet;
pub mod refine;
pub mod interface;
pub mod face;
pub mod shape;
pub mod primitives;
pub mod locate;
pub mod local;
pub mod joining;
pub mod cutting;

pub use face::{Face, SurfacePoint};
pub use interface::FaceId;
pub use jet::Jet;
pub use local::grading::{Grading, Window};
pub use local::{RefinementWindow, refine_near};
pub use locate::{Located, PatchSearch, SAME_PLACE, locate};
pub use patch::Patch;
pub use refine::Prolongation;
pub use shape::symmetry::Symmetry;
pub use shape::{Shape, SingularSet};
