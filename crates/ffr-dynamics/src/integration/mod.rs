//! Time integration of first-order systems with rejection, error norms and dense output.

pub mod linearisation;
pub mod jacobian;
pub mod system;
pub mod dense_output;
pub mod step_control;
mod stepping;
pub mod oscillator;
pub mod dormand_prince;
mod newton;
mod tableau;
pub mod esdirk;
pub mod integrator;
pub mod events;

pub use dense_output::DenseOutput;
pub use dormand_prince::DormandPrince;
pub use esdirk::Esdirk;
pub use events::{Crossing, CrossingSearch};
pub use integrator::{Integrator, Method};
pub use linearisation::{KinematicBlock, Linearisation};
pub use oscillator::{Oscillator, Oscillators};
pub use step_control::{Statistics, StepSettings};
pub use stepping::Step;
pub use system::OdeSystem;
