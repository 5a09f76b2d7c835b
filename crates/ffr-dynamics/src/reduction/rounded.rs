//! Cholesky factor in single precision, for refinement with the matrix itself (Eq. R.2a).
//!
//! Half the time and half the memory of the factor in double precision, and solves, which are bound by reading it, take half
//! the time. What it lacks in digits is made good by the residual in double precision.

use std::sync::Arc;

use faer::dyn_stack::MemStack;
use faer::reborrow::Reborrow;
use faer::sparse::SparseColMatRef;
use faer::sparse::linalg::cholesky::SymbolicCholeskyRaw;
use faer::sparse::linalg::cholesky::supernodal::SupernodalLltRef;
use faer::{MatMut, Par, Side};

use super::factor::{SymbolicFactor, buffer};
use super::inertia::scaled_to_single;
use super::wide_solve::{self, Entry};
use crate::DynamicsError;

type Row = <f32 as Entry>::Row;
const WIDTH: usize = <f32 as Entry>::WIDTH;

/// A factor with `S A S ~ L L^T` in single precision, `S` the scaling to a unit diagonal.
#[derive(Debug)]
pub(super) struct RoundedFactor {
    symbolic: Arc<SymbolicFactor>,
    values: Vec<f32>,
    scale: Vec<f64>,
    rows: Vec<Row>,
    local: Vec<Row>,
}

impl RoundedFactor {
    /// Factorises a symmetric matrix with the analysed pattern; `None` if a pivot is not positive in single precision.
    pub fn new(
        symbolic: &Arc<SymbolicFactor>,
        matrix: SparseColMatRef<'_, u32, f64>,
        name: &'static str,
    ) -> Result<Option<Self>, DynamicsError> {
        let SymbolicCholeskyRaw::Supernodal(supernodal) = symbolic.symbolic.raw() else { return Ok(None) };
        let (scaled, scale) = scaled_to_single(matrix);
        let scaled = SparseColMatRef::new(matrix.symbolic(), &scaled);
        let mut values = vec![0.0_f32; symbolic.n_entries()];
        let scratch = symbolic.symbolic.factorize_numeric_llt_scratch::<f32>(Par::Seq, Default::default());
        let mut memory = buffer(scratch, name)?;
        let done = symbolic.symbolic.factorize_numeric_llt(
            &mut values,
            scaled,
            Side::Lower,
            Default::default(),
            Par::Seq,
            MemStack::new(&mut memory),
            Default::default(),
        );
        if done.is_err() {
            return Ok(None);
        }
        let rows = vec![f32::ZERO; scale.len()];
        let local = vec![f32::ZERO; wide_solve::largest_supernode(supernodal)];
        Ok(Some(Self { symbolic: Arc::clone(symbolic), values, scale, rows, local }))
    }

    /// Solves `A x = b` in place to the accuracy of the factor.
    pub fn solve_in_place(&mut self, mut x: MatMut<'_, f64>) {
        for first in (0..x.ncols()).step_by(WIDTH) {
            let width = WIDTH.min(x.ncols() - first);
            self.solve_wide(x.as_mut().subcols_mut(first, width));
        }
    }

    fn solve_wide(&mut self, mut x: MatMut<'_, f64>) {
        let SymbolicCholeskyRaw::Supernodal(supernodal) = self.symbolic.symbolic.raw() else {
            unreachable!("the factor was made supernodal")
        };
        // Columns of unit size: they stay in the range of single precision.
        let mut size = [0.0_f64; WIDTH];
        for (j, size) in size.iter_mut().enumerate().take(x.ncols()) {
            *size = x.rb().col(j).iter().zip(&self.scale).map(|(v, s)| (v * s).abs()).fold(0.0, f64::max);
            *size = if *size > 0.0 { *size } else { 1.0 };
        }
        for (row, &i) in self.rows.iter_mut().zip(&self.symbolic.order) {
            let (i, mut filled) = (i as usize, f32::ZERO);
            for (j, value) in filled.iter_mut().enumerate().take(x.ncols()) {
                *value = (x[(i, j)] * self.scale[i] / size[j]) as f32;
            }
            *row = filled;
        }
        let factor = SupernodalLltRef::new(supernodal, &self.values);
        wide_solve::solve(factor, &mut self.rows, &mut self.local);
        for (row, &i) in self.rows.iter().zip(&self.symbolic.order) {
            let i = i as usize;
            for (j, &value) in row.iter().enumerate().take(x.ncols()) {
                x[(i, j)] = f64::from(value) * self.scale[i] * size[j];
            }
        }
    }
}
