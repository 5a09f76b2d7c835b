//! The quasistatic contact problem, its solvers, and friction.

pub mod problem;
pub mod compliance;
mod factors;
mod inverse;
pub mod active_set;
pub(crate) mod tangential;
pub(crate) mod sliding_work;
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
