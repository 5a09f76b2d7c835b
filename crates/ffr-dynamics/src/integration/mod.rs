//! Time integration of first-order systems with rejection, error norms and dense output.

pub mod system;
pub mod step_control;
pub mod dormand_prince;
pub mod events;

pub use system::OdeSystem;
