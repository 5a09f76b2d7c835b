//! High-frequency shapes and stiffnesses at the contact points, the form that Algorithm 1 of \[A\]
//! works in.
//!
//! The quasistatic displacement of the points is `Φ q` and `K q = Φᵀ f` with diagonal `K`
//! (docs/theory.md Eq. C.11). Any `Φ`, `K` with `Φ K⁻¹ Φᵀ = N_b G N_bᵀ` gives the same forces, so
//! that the compliance alone is enough: its eigenvectors are such shapes and the inverse
//! eigenvalues such stiffnesses (Eq. C.12). Coordinates are then in metres instead of the
//! `m sqrt(kg)` of mass-orthonormal modes.

use faer::{Mat, Side};
use ffr_dynamics::data_error::{DataError, check_square};

use crate::ContactError;

/// Shapes `Φ` (rows of the points) and diagonal stiffness `K` of the quasistatic coordinates.
#[derive(Debug, Clone)]
pub struct ModalBasis {
    /// Shapes at the points, `n_rows × n_hf`.
    pub shapes: Mat<f64>,
    /// Diagonal of the stiffness, `n_hf`, positive.
    pub stiffness: Vec<f64>,
}

impl ModalBasis {
    /// Basis of high-frequency Craig-Bampton modes: `shapes`: rows of the points, one column per
    /// mode; `omega_squared`: squares of the circular frequencies [1/s²].
    ///
    /// # Errors
    /// [`ContactError::Data`] if sizes differ or a value is not positive and finite.
    pub fn from_modes(shapes: Mat<f64>, omega_squared: &[f64]) -> Result<Self, ContactError> {
        if shapes.ncols() != omega_squared.len() {
            let (what, found) = ("frequencies of the modes at the points".into(), omega_squared.len());
            return Err(DataError::Count { what, found, expected: shapes.ncols() }.into());
        }
        if let Some(bad) = omega_squared.iter().find(|&&k| !(k > 0.0 && k.is_finite())) {
            let what = "a squared circular frequency of a high-frequency mode [1/s^2]".into();
            return Err(DataError::OutOfRange { what, value: *bad, range: "> 0 and finite" }.into());
        }
        Ok(Self { shapes, stiffness: omega_squared.to_vec() })
    }

    /// Basis from a compliance, `n_rows × n_rows`, symmetric positive semidefinite [m/N]; its null
    /// space is dropped.
    ///
    /// # Errors
    /// [`ContactError::Data`] if the matrix is not square, has negative eigenvalues beyond round-off, or the
    /// eigenvalues cannot be found.
    pub fn from_compliance(compliance: &Mat<f64>) -> Result<Self, ContactError> {
        let n = compliance.nrows();
        check_square("the compliance of the points", compliance.as_ref(), n)?;
        let eigen = compliance
            .self_adjoint_eigen(Side::Lower)
            .map_err(|_| DataError::NotFinite { what: "an eigenvalue of the compliance".into() })?;
        let values = eigen.S().column_vector();
        let largest = (0..n).map(|k| values[k].abs()).fold(0.0, f64::max);
        // Eigenvalues of a symmetric matrix are found to about n eps of the largest one.
        let round_off = 4.0 * n as f64 * f64::EPSILON * largest;
        // Entries carry the errors of earlier factorisations, so that true negatives are told apart
        // at the root of that.
        let is_bad = |k: &usize| values[*k].is_nan() || values[*k] < -f64::EPSILON.sqrt() * largest;
        if let Some(k) = (0..n).find(is_bad) {
            let what = format!("an eigenvalue of the compliance beside the largest, {largest:e} m/N,");
            return Err(DataError::OutOfRange { what, value: values[k], range: ">= 0" }.into());
        }
        let kept: Vec<usize> = (0..n).filter(|&k| values[k] > round_off).collect();
        let vectors = eigen.U();
        Ok(Self {
            shapes: Mat::from_fn(n, kept.len(), |i, j| vectors[(i, kept[j])]),
            stiffness: kept.iter().map(|&k| 1.0 / values[k]).collect(),
        })
    }

    /// Compliance `Φ K⁻¹ Φᵀ` [m/N].
    pub fn compliance(&self) -> Mat<f64> {
        let scaled = Mat::from_fn(self.shapes.nrows(), self.shapes.ncols(), |i, j| {
            self.shapes[(i, j)] / self.stiffness[j]
        });
        scaled * self.shapes.transpose()
    }

    /// Number of coordinates.
    pub fn n_coordinates(&self) -> usize {
        self.stiffness.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn compliance_is_recovered_and_its_null_space_dropped() {
        let factor = Mat::from_fn(6, 4, |i, j| ((i * 7 + j * 3) % 5) as f64 - 1.5 + f64::from(i == j));
        let compliance = &factor * factor.transpose();
        let basis = ModalBasis::from_compliance(&compliance).unwrap();
        assert_eq!(basis.n_coordinates(), 4);
        let difference = (basis.compliance() - &compliance).norm_max();
        assert!(difference < 1e-13 * compliance.norm_max()); // round-off of the eigenvalues
    }

    #[test]
    fn indefinite_compliance_is_refused() {
        let matrix = Mat::from_fn(2, 2, |i, j| if i == j { [1.0, -0.1][i] } else { 0.0 });
        assert!(ModalBasis::from_compliance(&matrix).is_err());
        assert!(ModalBasis::from_modes(Mat::zeros(2, 1), &[-1.0]).is_err());
        assert!(ModalBasis::from_modes(Mat::zeros(2, 1), &[1.0, 2.0]).is_err());
    }
}
