//! Time integration of first-order systems with rejection, error norms and dense output.

pub mod system;
pub mod dense_output;
pub mod step_control;
pub mod dormand_prince;
pub mod events;

pub use dense_output::DenseOutput;
pub use dormand_prince::{DormandPrince, Step};
pub use events::{Crossing, CrossingSearch};
pub use step_control::{Statistics, StepSettings};
pub use system::OdeSystem;
