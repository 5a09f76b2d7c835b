//! Joints: how a child marker may move relative to its parent marker, and the forces within.

pub mod kind;
pub mod forces;

pub use forces::{CoordinateForce, TimeFunction};
pub(crate) use kind::JointPoint;
pub use kind::{JointColumn, JointKind, JointMotion};
