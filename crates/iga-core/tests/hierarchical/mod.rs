//! Hierarchical spaces: identities, reference values, exact geometry, seams, prolongation.

mod combinations;
mod nets;

mod prolongation;
mod patches;
mod properties;

mod random;
mod rational;
mod reference;
mod seams;
