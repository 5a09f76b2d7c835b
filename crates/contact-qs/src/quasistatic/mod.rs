//! The quasistatic contact problem and its two solvers.

pub mod problem;
pub mod active_set;
pub mod conditioned_lu;
pub mod modal_basis;
pub mod broyden;
pub mod solver;

pub use active_set::{ActiveSet, SolveReport};
pub use broyden::{Broyden, BroydenSettings};
pub use modal_basis::ModalBasis;
pub use problem::{KktResidual, Problem, ProblemEnergies};
pub use solver::{Method, Quasistatic};
