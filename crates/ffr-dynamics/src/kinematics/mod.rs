//! Rotations and points that move with flexible bodies.

pub mod rotation;
pub mod marker;

pub use marker::FlexiblePoint;
