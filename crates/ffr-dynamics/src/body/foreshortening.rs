//! Second-order displacements by which stress makes a body stiffer (docs/theory.md Eq. M.43, M.44).

use nalgebra::Vector3;

/// Geometric stiffness as second-order displacements: `-K_geo` in the order of the shape integrals.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Foreshortening {
    /// `∫ ρ g_ij` at `i n_q + j`.
    pub translation: Vec<Vector3<f64>>,
    /// `∫ ρ X_a g_ij,b` at `i n_c² n_q + (a n_c + b) n_q + j`.
    pub position: Vec<f64>,
}
