//! NURBS patches: geometry, refinement and named exact shapes.

pub mod patch;
pub mod refine;
pub mod shape;
pub mod primitives;

pub use patch::Patch;
pub use shape::Shape;
