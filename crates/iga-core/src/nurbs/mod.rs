//! NURBS patches: geometry, refinement and named exact shapes.

pub mod jet;
pub mod patch;
pub mod refine;
pub mod grading;
pub mod shape;
pub mod primitives;

pub use grading::{Grading, Window};
pub use jet::Jet;
pub use patch::Patch;
pub use refine::Prolongation;
pub use shape::{Shape, SingularSet};
