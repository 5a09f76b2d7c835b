//! The quasistatic contact problem and its two solvers.

pub mod problem;
pub mod active_set;
pub mod broyden;
