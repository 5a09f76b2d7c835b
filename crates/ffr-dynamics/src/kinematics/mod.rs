//! Rotations and points that move with flexible bodies.

pub mod marker;
pub mod rotation;
