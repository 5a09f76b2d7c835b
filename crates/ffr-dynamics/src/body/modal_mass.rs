//! Mass matrix of the elastic coordinates: the identity, or any symmetric positive definite one.

use faer::{Mat, MatRef};

use crate::data_error::DataError;
use crate::error::DynamicsError;

/// Pivot of a Cholesky factorisation, as a share of the diagonal entry, below which modes count as
/// linearly dependent.
///
/// Modes shifted by rigid motions stay independent; round-off of a matrix of 100 modes is about
/// 1e-14.
const SMALLEST_PIVOT: f64 = 1e-12;

/// Modal mass matrix `M_e` (docs/theory.md Eq. M.3).
#[derive(Debug, Clone, PartialEq, Default)]
pub enum ModalMass {
    /// Mass-orthonormal modes.
    #[default]
    Identity,
    /// Modes of another frame, or imported ones.
    Full(FullModalMass),
}

/// A symmetric positive definite modal mass matrix, row by row.
#[derive(Debug, Clone, PartialEq)]
pub struct FullModalMass {
    size: usize,
    matrix: Vec<f64>,
}

impl FullModalMass {
    /// The matrix, symmetrised and checked by a Cholesky factorisation.
    ///
    /// # Errors
    /// [`DynamicsError::Data`] if it is not square or not symmetric; [`DynamicsError::NotPositiveDefinite`].
    pub fn new(matrix: MatRef<'_, f64>) -> Result<Self, DynamicsError> {
        let n = matrix.nrows();
        // Symmetric to the round-off of sums over many control points.
        let is_symmetric = matrix.ncols() == n
            && (0..n).all(|i| {
                (0..i).all(|j| {
                    let scale = (matrix[(i, i)] * matrix[(j, j)]).abs().sqrt();
                    (matrix[(i, j)] - matrix[(j, i)]).abs() <= 1e-9 * scale
                })
            });
        if !is_symmetric {
            return Err(DataError::NotSymmetric { what: "the modal mass matrix".into() }.into());
        }
        let mut whole = vec![0.0; n * n];
        for i in 0..n {
            for j in 0..n {
                whole[i * n + j] = 0.5 * (matrix[(i, j)] + matrix[(j, i)]);
            }
        }
        let mut factor = whole.clone();
        for i in 0..n {
            for j in 0..=i {
                let sum: f64 = (0..j).map(|k| factor[i * n + k] * factor[j * n + k]).sum();
                let rest = whole[i * n + j] - sum;
                if i != j {
                    factor[i * n + j] = rest / factor[j * n + j];
                } else if rest > SMALLEST_PIVOT * whole[i * n + i] {
                    factor[i * n + i] = rest.sqrt();
                } else {
                    return Err(DynamicsError::NotPositiveDefinite {
                        matrix: "modal mass matrix",
                        pivot: i,
                        size: n,
                    });
                }
            }
        }
        Ok(Self { size: n, matrix: whole })
    }

    /// Row `i`.
    pub fn row(&self, i: usize) -> &[f64] {
        &self.matrix[i * self.size..(i + 1) * self.size]
    }
}

impl ModalMass {
    /// The matrix, the identity where it is within `tolerance` of it.
    ///
    /// # Errors
    /// As [`FullModalMass::new`].
    pub fn from_matrix(matrix: MatRef<'_, f64>, tolerance: f64) -> Result<Self, DynamicsError> {
        let n = matrix.nrows();
        let is_identity = matrix.ncols() == n
            && (0..n).all(|i| {
                (0..n).all(|j| (matrix[(i, j)] - if i == j { 1.0 } else { 0.0 }).abs() <= tolerance)
            });
        if is_identity { Ok(Self::Identity) } else { FullModalMass::new(matrix).map(Self::Full) }
    }

    /// Entry `(i, j)`.
    pub fn entry(&self, i: usize, j: usize) -> f64 {
        match self {
            Self::Identity => f64::from(u8::from(i == j)),
            Self::Full(full) => full.row(i)[j],
        }
    }

    /// The matrix for `n` modes.
    pub fn to_matrix(&self, n: usize) -> Mat<f64> {
        Mat::from_fn(n, n, |i, j| self.entry(i, j))
    }

    /// `xᵀ M_e x`. Does not allocate.
    pub fn square(&self, x: &[f64]) -> f64 {
        match self {
            Self::Identity => x.iter().map(|v| v * v).sum(),
            Self::Full(full) => x
                .iter()
                .enumerate()
                .map(|(i, v)| v * full.row(i).iter().zip(x).map(|(m, w)| m * w).sum::<f64>())
                .sum(),
        }
    }
}
