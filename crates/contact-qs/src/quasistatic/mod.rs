//! The quasistatic contact problem, its two solvers, and friction.

pub mod problem;
pub mod active_set;
pub mod conditioned_lu;
mod sherman_morrison;
pub mod modal_basis;
pub mod broyden;
pub(crate) mod point_solver;
pub mod solver;
pub(crate) mod tangential;
pub(crate) mod sliding_work;
pub(crate) mod stick_slip;

pub use active_set::{ActiveSet, SolveReport};
pub use broyden::{Broyden, BroydenSettings};
pub use modal_basis::ModalBasis;
pub use point_solver::Method;
pub use problem::{Problem, ProblemEnergies};
pub use solver::{Quasistatic, ZoneSolver};
pub use tangential::PointState;
