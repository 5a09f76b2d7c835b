//! Reduced flexible bodies in the floating frame of reference: matrices in, motion out.
//!
//! The crate takes sparse mass and stiffness matrices ([`body::AssembledBody`]), reduces them, sets
//! up the equations of motion and integrates them in time. It knows no splines, no contact law and
//! no file format: forces enter through [`force::ForceElement`].
//!
//! SI units, radians. Equation numbers refer to `docs/theory.md`.

pub mod data_error;
pub mod rotation;
pub mod memory;
pub mod error;
pub mod body;
pub mod reduction;
pub mod integration;
pub mod force;
pub mod kinematics;
pub mod interchange;
pub mod system;

pub use error::DynamicsError;
