//! Isotropic linear elasticity: material law and kinematics of each model, and what follows from
//! them in any space of displacements: matrices, mass properties, stress.

pub mod material;
pub mod model;
pub mod kinematics;
pub mod mapping;
pub mod assembly;
pub mod mass_properties;
pub mod recovery;

pub use material::{ElementMaterials, Material, MaterialField};
pub use model::Model;
