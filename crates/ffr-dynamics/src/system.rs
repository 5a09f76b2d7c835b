//! Bodies, joints and equations of motion.

pub mod joints;
pub mod free_body;
pub mod model;
mod tree;
mod loops;
pub mod multibody;
pub mod reaction;
pub mod vibration;
mod assembly;
pub mod equilibrium;

pub use joints::{
    Bearing, CoordinateForce, FreeDirections, Friction, JointKind, Stop, TimeCourse, TimeFunction,
};
pub use model::MultibodyModel;
pub use model::specification::{Attachment, BodySpec, GROUND, GearSpec, JointSpec, LoadSpec, SystemSpec};
pub use multibody::Multibody;
pub use multibody::error_scale::ErrorScale;
pub use reaction::Reaction;
pub use vibration::held_damping::OwnDamping;
pub use vibration::pressed::PressedMode;
pub use vibration::{SystemMode, SystemModes};
