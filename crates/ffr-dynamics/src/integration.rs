//! Time integration of first-order systems with rejection, error norms and dense output.

pub mod linearisation;
pub mod dense_output;
pub mod step_control;
pub mod oscillator;
pub mod system;
mod stepping;
mod one_step;
mod dormand_prince;
pub mod events;
mod implicit;
pub mod integrator;

pub use dense_output::DenseOutput;
pub use events::{Crossing, CrossingSearch, Slope};
pub(crate) use implicit::collocation::PAIRS as STAGE_PAIRS;
pub use integrator::{Integrator, Method};
pub use linearisation::{KinematicBlock, Linearisation};
pub use oscillator::{Oscillator, Oscillators};
pub use step_control::{Statistics, StepSettings};
pub use stepping::Step;
pub use system::OdeSystem;
