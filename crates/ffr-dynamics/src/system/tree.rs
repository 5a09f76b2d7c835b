//! Bodies in a tree of joints: their motion, linear systems on them in a number of operations linear
//! in bodies and modes, and how large an error of their motion is.

pub(super) mod kinematics;
pub(super) mod bearings;
pub(super) mod solver;
mod error_filter;
pub(super) mod stage_solver;
pub(super) mod error;
