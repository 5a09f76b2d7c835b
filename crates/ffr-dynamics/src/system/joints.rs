//! Joints: how a child marker may move relative to its parent marker, and the forces within.

pub mod kind;
pub mod forces;
pub mod bearing;
pub(crate) mod form;

pub use bearing::Bearing;
pub use forces::{CoordinateForce, Friction, Stop, TimeCourse, TimeFunction};
pub(crate) use kind::JointPoint;
pub use kind::{FreeDirections, JointColumn, JointKind, JointMotion};
