//! Bodies, forces and equations of motion.

pub mod force;
pub mod free_bodies;
