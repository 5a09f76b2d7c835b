//! All tests of the crate, in one executable: a file that is not named here is not run (`scripts/check_layers.py` looks).
#![expect(clippy::unwrap_used, reason = "a failure there fails the test")]

mod bodies;
mod catalogue;
mod convergence;
mod cutting;
mod elasticity_identities;
mod evaluation;
mod extents;
mod files;
mod gear_tooth;
mod geometric_stiffness;
mod hierarchical;
mod joining;
mod locating;
mod mass_properties;
mod measures;
mod patch_space;
mod patch_test;
mod recovery;
mod refinement;
mod shapes;
mod surface;
#[path = "../../../tests/support/damage.rs"]
mod damage;
