//! Bodies, joints, forces and equations of motion.

pub mod force;
pub mod active;
mod deformation;
mod equations;
mod body_derivative;
mod breaks;
mod free_modes;
mod free_vibration;
pub mod error_scale;
pub mod joints;
pub mod specification;
pub mod stops;
pub mod gear;
pub mod tree;
pub mod model;
mod tree_kinematics;
mod uncoupled_modes;
mod tree_solver;
mod constraint_rows;
mod loop_closure;
mod error_filter;
mod tree_error;
mod tree_derivative;
mod stage_solver;
mod bearings;
mod workspace;
pub mod multibody;
mod assembly;
pub mod reaction;
mod dead_load;
mod small_motion;
pub mod vibration;
pub mod held_damping;
pub mod equilibrium;

pub use active::{Active, ActiveForce};
pub use error_scale::ErrorScale;
pub use force::{BodyState, Findings, ForceElement, ForceEnergies, GeneralisedForce, Motion};
pub use held_damping::OwnDamping;
pub use joints::{
    Bearing, CoordinateForce, FreeDirections, Friction, JointKind, Stop, TimeCourse, TimeFunction,
};
pub use model::MultibodyModel;
pub use multibody::Multibody;
pub use reaction::Reaction;
pub use specification::{Attachment, BodySpec, GROUND, GearSpec, JointSpec, LoadSpec, SystemSpec};
pub use vibration::{SystemMode, SystemModes};
