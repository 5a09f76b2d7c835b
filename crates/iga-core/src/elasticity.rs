//! Isotropic linear elasticity: material law and kinematics of each model.

pub mod material;
pub mod model;
pub mod kinematics;

pub use material::{ElementMaterials, Material, MaterialField};
pub use model::Model;
