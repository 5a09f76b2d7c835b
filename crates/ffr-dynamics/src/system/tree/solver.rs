//! Linear systems of a tree of flexible bodies in a number of operations linear in bodies and modes
//! (docs/theory.md Eq. M.28 to M.31 and M.51).
//!
//! From the leaves to ground, the motion of each body is eliminated; what is left of it is an
//! inertia of six rows and columns at the parent's marker. A body's modes know of each other only
//! through its frame and through the places where joints hold it, six rows each. The way back from
//! ground gives all motions. Accelerations and the implicit stages of an integrator differ in the
//! impedance of modes and joint springs, which is real for the ones and complex for the others.

mod number;
mod pose;
mod factors;
mod answer;

pub(in crate::system) use answer::Answer;
pub(in crate::system) use factors::{FactorisedTree, Impedance, TreeFactors};
pub(in crate::system) use pose::TreePose;
