//! Second-order displacements by which stress makes a body stiffer (docs/theory.md Eq. M.25, M.30).

use nalgebra::Vector3;

/// Geometric stiffness as second-order displacements: `-K_geo` in the order of the shape integrals.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Foreshortening {
    /// `∫ ρ g_ij` at `i n_q + j`.
    pub translation: Vec<Vector3<f64>>,
    /// `∫ ρ X_a g_ij,b` at `i n_c² n_q + (a n_c + b) n_q + j`.
    pub position: Vec<f64>,
}

impl Foreshortening {
    /// Adds `Σ_i x_i G_i` to the rows of first moments.
    pub fn add_moments(&self, x: &[f64], moments: &mut [f64]) {
        for (x, block) in x.iter().zip(self.position.chunks_exact(moments.len().max(1))) {
            moments.iter_mut().zip(block).for_each(|(m, g)| *m += x * g);
        }
    }

    /// `Σ_i x_i ∫ ρ g_ij`.
    pub fn translation_row(&self, x: &[f64], j: usize) -> Vector3<f64> {
        let n = x.len();
        x.iter().enumerate().map(|(i, x)| self.translation[i * n + j] * *x).sum()
    }
}
