//! Bodies, forces and equations of motion.

pub mod force;
pub mod equations;
mod body_derivative;
pub mod layout;
pub mod error_scale;
pub mod free_bodies;

pub use error_scale::ErrorScale;
pub use force::{BodyState, ForceElement, ForceEnergies, GeneralisedForce};
pub use free_bodies::{FreeBodies, FreeBody};
