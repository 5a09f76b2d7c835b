//! Isotropic linear elasticity: material law and kinematics of each model.

pub mod kinematics;
pub mod material;
