//! Sparse stiffness and mass matrices.

pub mod pattern;
pub mod mass;
pub mod stiffness;
