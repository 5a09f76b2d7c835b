//! Hierarchical spaces: identities, reference values, exact geometry, seams, prolongation.
#![expect(clippy::unwrap_used, reason = "helpers of tests")]

mod nets;

mod prolongation;
mod patches;
mod properties;

mod random;
mod rational;
mod reference;
mod seams;
