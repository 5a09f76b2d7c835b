//! Cholesky factor in single precision, for refinement with the matrix itself (Eq. R.6).
//!
//! Half the time and half the memory of the factor in double precision, and solves, which are bound
//! by reading it, take half the time. What it lacks in digits is made good by the residual in
//! double precision.

use std::sync::Arc;

use faer::MatMut;
use faer::reborrow::Reborrow;
use faer::sparse::SparseColMatRef;

use super::SymbolicFactor;
use super::entry::Entry;
use super::numeric::Kind;
use super::tree_solve::TreeSolve;

const WIDTH: usize = <f32 as Entry>::WIDTH;

/// A factor with `C A C ~ L S L^T` in single precision, `S` the signs of the pivots, `C` the
/// scaling to a unit diagonal.
#[derive(Debug)]
pub(in crate::reduction) struct SinglePrecisionFactor {
    symbolic: Arc<SymbolicFactor>,
    values: Vec<f32>,
    scale: Vec<f64>,
}

impl SinglePrecisionFactor {
    /// Factorises a symmetric matrix with the analysed pattern, rows and columns of `held` unknowns,
    /// if there are any, reduced to their diagonal; `None` if a pivot is not positive, or zero, in
    /// single precision.
    ///
    /// # Panics
    /// If the matrix has not as many entries as the pattern.
    pub fn new(
        symbolic: &Arc<SymbolicFactor>,
        matrix: SparseColMatRef<'_, u32, f64>,
        held: &[bool],
        kind: Kind,
    ) -> Option<Self> {
        let scale: Vec<f64> =
            diagonal_of(matrix).iter().map(|d| 1.0 / d.abs().sqrt().max(f64::MIN_POSITIVE)).collect();
        let by_position: Vec<f64> = symbolic.order().iter().map(|&i| scale[i as usize]).collect();
        let value = symbolic.values(matrix, held);
        let scaled = |number: usize, i: usize, j: usize| {
            (value(number, i, j) * by_position[i] * by_position[j]) as f32
        };
        let values = symbolic.factorise(matrix, scaled, kind).ok()?;
        Some(Self { symbolic: Arc::clone(symbolic), values, scale })
    }

    /// Entries of the factor.
    pub fn values(&self) -> &[f32] {
        &self.values
    }

    /// `C`, by unknowns.
    pub fn scale(&self) -> &[f64] {
        &self.scale
    }

    /// Solves `A x = b` in place to the accuracy of the factor.
    pub fn solve_in_place(&self, mut x: MatMut<'_, f64>) {
        let mut rows = vec![f32::ZERO_ROW; self.scale.len()];
        for first in (0..x.ncols()).step_by(WIDTH) {
            let width = WIDTH.min(x.ncols() - first);
            self.solve_wide(x.as_mut().subcols_mut(first, width), &mut rows);
        }
    }

    fn solve_wide(&self, mut x: MatMut<'_, f64>, rows: &mut [<f32 as Entry>::Row]) {
        // Columns of unit size: they stay in the range of single precision.
        let mut size = [0.0_f64; WIDTH];
        for (j, size) in size.iter_mut().enumerate().take(x.ncols()) {
            *size = x.rb().col(j).iter().zip(&self.scale).map(|(v, s)| (v * s).abs()).fold(0.0, f64::max);
            *size = if *size > 0.0 { *size } else { 1.0 };
        }
        for (row, &i) in rows.iter_mut().zip(self.symbolic.order()) {
            let (i, mut filled) = (i as usize, f32::ZERO_ROW);
            for (j, value) in filled.iter_mut().enumerate().take(x.ncols()) {
                *value = (x[(i, j)] * self.scale[i] / size[j]) as f32;
            }
            *row = filled;
        }
        let factor = TreeSolve { layout: &self.symbolic.layout, values: &self.values };
        factor.solve(rows);
        for (row, &i) in rows.iter().zip(self.symbolic.order()) {
            let i = i as usize;
            for (j, &value) in row.iter().enumerate().take(x.ncols()) {
                x[(i, j)] = f64::from(value) * self.scale[i] * size[j];
            }
        }
    }
}

/// Diagonal of a symmetric matrix.
pub(in crate::reduction) fn diagonal_of(matrix: SparseColMatRef<'_, u32, f64>) -> Vec<f64> {
    let entry = |j: usize| matrix.row_idx_of_col(j).zip(matrix.val_of_col(j)).find(|&(i, _)| i == j);
    (0..matrix.ncols()).map(|j| entry(j).map_or(0.0, |(_, &a)| a)).collect()
}
