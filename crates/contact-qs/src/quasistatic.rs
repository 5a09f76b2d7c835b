//! The quasistatic contact problem, its solvers, and friction.

pub mod problem;
pub mod compliance;
mod factors;
pub(crate) mod members;
mod inverse;
pub mod active_set;
pub(crate) mod tangential;
pub mod broyden;
pub(crate) mod point_solver;
pub mod modal_basis;
pub mod solver;
pub(crate) mod stick_slip;

pub use active_set::{ActiveSet, SolveReport};
pub use point_solver::Method;
pub use problem::{Problem, ProblemEnergies};
pub use solver::{Quasistatic, ZoneSolver};
pub use tangential::PointState;
