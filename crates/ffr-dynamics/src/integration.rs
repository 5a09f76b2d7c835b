//! Time integration of first-order systems with rejection, error norms and dense output.

pub mod linearisation;
mod jacobian;
pub mod system;
pub mod dense_output;
pub mod step_control;
mod stepping;
pub mod oscillator;
mod one_step;
mod dormand_prince;
mod convergence;
mod held_derivative;
mod newton;
mod tableau;
mod esdirk;
mod collocation;
mod stage_matrix;
mod gauss;
pub mod integrator;
pub mod events;

pub(crate) use collocation::PAIRS as STAGE_PAIRS;
pub use dense_output::DenseOutput;
pub use events::{Crossing, CrossingSearch};
pub use integrator::{Integrator, Method};
pub use linearisation::{KinematicBlock, Linearisation};
pub use oscillator::{Oscillator, Oscillators};
pub use step_control::{Statistics, StepSettings};
pub use stepping::Step;
pub use system::OdeSystem;
