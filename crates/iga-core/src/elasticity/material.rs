//! Isotropic materials.
