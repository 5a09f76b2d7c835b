//! Sparse Cholesky factorisation with one symbolic analysis for many matrices (Eq. R.2).
//!
//! Supernodal, sequential, without allocation in the solves.

use std::sync::Arc;

use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::linalg::cholesky::llt::factor::LltError as PivotError;
use faer::perm::PermRef;
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LltRef, SymbolicCholesky, SymbolicCholeskyRaw, SymmetricOrdering,
    factorize_symbolic_cholesky, supernodal::SupernodalLltRef,
};
use faer::sparse::{FaerError, SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, Mat, MatMut, Par, Side};

use super::memory;
use super::wide_solve::{self, Entry};
use crate::DynamicsError;
use crate::data_error::DataError;

type Row = <f64 as Entry>::Row;
const WIDTH: usize = <f64 as Entry>::WIDTH;
/// Right-hand sides from which they are solved for together by rows.
const MIN_WIDE: usize = 4;

/// Elimination order and pattern of the factor, shared by all matrices of one pattern.
#[derive(Debug)]
pub struct SymbolicFactor {
    pub(super) symbolic: SymbolicCholesky<u32>,
    pub(super) order: Vec<u32>,
}

impl SymbolicFactor {
    /// Analyses the lower triangle `pattern` under the elimination `order` (position p holds the p-th unknown).
    ///
    /// # Errors
    /// [`DynamicsError::FactorTooLarge`] or [`DynamicsError::FactorUncountable`] if no memory holds the factor,
    /// [`DynamicsError::Data`] if `order` is no permutation.
    pub fn new(pattern: SymbolicSparseColMatRef<'_, u32>, order: Vec<u32>) -> Result<Self, DynamicsError> {
        let n = pattern.nrows();
        let mut inverse = vec![u32::MAX; n];
        for (position, &unknown) in order.iter().enumerate() {
            if let Some(slot) = inverse.get_mut(unknown as usize) {
                *slot = position as u32;
            }
        }
        if n == 0 || order.len() != n || inverse.contains(&u32::MAX) {
            let (what, found) = ("unknowns in the order of elimination".into(), order.len());
            return Err(DataError::Count { what, found, expected: n }.into());
        }
        let params = CholeskySymbolicParams {
            supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SUPERNODAL,
            ..Default::default()
        };
        let ordering = SymmetricOrdering::Custom(PermRef::new_checked(&order, &inverse, n));
        let symbolic =
            factorize_symbolic_cholesky(pattern, Side::Lower, ordering, params).map_err(|e| match e {
                FaerError::IndexOverflow => DynamicsError::FactorUncountable { unknowns: n },
                other => failed("the pattern", format!("{other:?}")),
            })?;
        let analysed = Self { symbolic, order };
        // In the shorter format at least.
        analysed.check_memory(size_of::<f32>())?;
        Ok(analysed)
    }

    /// Refuses a factor whose entries, of `bytes` bytes each, have no place in the memory that is free.
    fn check_memory(&self, bytes: usize) -> Result<(), DynamicsError> {
        let bytes = self.symbolic.len_val() as f64 * bytes as f64;
        let (unknowns, gigabytes) = (self.order.len(), 1e-9 * bytes);
        match memory::shortage(bytes) {
            Some(free) => Err(DynamicsError::FactorTooLarge { unknowns, gigabytes, free }),
            None => Ok(()),
        }
    }

    /// Number of unknowns.
    pub fn n_unknowns(&self) -> usize {
        self.order.len()
    }

    /// Whether the elimination ends with the unknowns `last`, in this order.
    pub fn ends_with(&self, last: &[usize]) -> bool {
        let tail = self.order.len().checked_sub(last.len()).map(|first| &self.order[first..]);
        tail.is_some_and(|tail| tail.iter().zip(last).all(|(&a, &b)| a as usize == b))
    }

    /// Stored entries of the factor.
    pub fn n_entries(&self) -> usize {
        self.symbolic.len_val()
    }

    /// Cholesky factor of a symmetric positive definite matrix with the analysed pattern; `name` is for messages.
    ///
    /// # Errors
    /// [`DynamicsError::NotPositiveDefinite`] with the unknown whose pivot fails, [`DynamicsError::FactorTooLarge`].
    pub fn cholesky(
        self: &Arc<Self>,
        matrix: SparseColMatRef<'_, u32, f64>,
        name: &'static str,
    ) -> Result<CholeskyFactor, DynamicsError> {
        self.check_memory(size_of::<f64>())?;
        let mut values = vec![0.0; self.symbolic.len_val()];
        let scratch = self.symbolic.factorize_numeric_llt_scratch::<f64>(Par::Seq, Default::default());
        let mut memory = buffer(scratch, name)?;
        let done = self.symbolic.factorize_numeric_llt(
            &mut values,
            matrix,
            Side::Lower,
            Default::default(),
            Par::Seq,
            MemStack::new(&mut memory),
            Default::default(),
        );
        if let Err(PivotError::NonPositivePivot { index }) = done {
            let pivot = self.order.get(index).map_or(index, |&i| i as usize);
            return Err(DynamicsError::NotPositiveDefinite { matrix: name, pivot, size: self.order.len() });
        }
        let factor = CholeskyFactor { symbolic: Arc::clone(self), values };
        if let Some(position) = factor.first_bad_pivot() {
            let pivot = self.order[position] as usize;
            return Err(DynamicsError::NotPositiveDefinite { matrix: name, pivot, size: self.order.len() });
        }
        Ok(factor)
    }
}

/// A sparse Cholesky factor `L` with `A = L L^T` in the elimination order.
#[derive(Debug)]
pub struct CholeskyFactor {
    symbolic: Arc<SymbolicFactor>,
    values: Vec<f64>,
}

/// Memory for solves with a [`CholeskyFactor`], for up to a fixed number of right-hand sides.
pub struct SolveWorkspace {
    memory: MemBuffer,
    columns: usize,
    /// Eight right-hand sides by rows, and those of one supernode.
    rows: Vec<Row>,
    local: Vec<Row>,
}

impl std::fmt::Debug for SolveWorkspace {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("SolveWorkspace").field("columns", &self.columns).finish_non_exhaustive()
    }
}

impl CholeskyFactor {
    /// The analysis behind the factor.
    pub fn symbolic(&self) -> &Arc<SymbolicFactor> {
        &self.symbolic
    }

    /// Workspace for solves with up to `columns` right-hand sides.
    pub fn workspace(&self, columns: usize) -> SolveWorkspace {
        let scratch = self.symbolic.symbolic.solve_in_place_scratch::<f64>(columns, Par::Seq);
        let is_wide = columns >= MIN_WIDE;
        let largest = match self.symbolic.symbolic.raw() {
            SymbolicCholeskyRaw::Supernodal(s) if is_wide => wide_solve::largest_supernode(s),
            _ => 0,
        };
        let n = if largest > 0 { self.symbolic.n_unknowns() } else { 0 };
        SolveWorkspace {
            memory: MemBuffer::new(scratch),
            columns,
            rows: vec![[0.0; WIDTH]; n],
            local: vec![[0.0; WIDTH]; largest],
        }
    }

    /// Solves `A x = b` in place for all columns at once; allocates nothing.
    ///
    /// # Panics
    /// If `x` has not one row per unknown.
    pub fn solve_in_place(&self, mut x: MatMut<'_, f64>, workspace: &mut SolveWorkspace) {
        assert_eq!(x.nrows(), self.symbolic.n_unknowns(), "right-hand side and factor differ in size");
        if x.ncols() >= MIN_WIDE && !workspace.local.is_empty() {
            for first in (0..x.ncols()).step_by(WIDTH) {
                let width = WIDTH.min(x.ncols() - first);
                self.solve_wide(x.as_mut().subcols_mut(first, width), workspace);
            }
            return;
        }
        let factor = LltRef::new(&self.symbolic.symbolic, &self.values);
        let n = x.ncols();
        for first in (0..n).step_by(workspace.columns.max(1)) {
            let width = workspace.columns.max(1).min(n - first);
            let part = x.as_mut().subcols_mut(first, width);
            factor.solve_in_place_with_conj(Conj::No, part, Par::Seq, MemStack::new(&mut workspace.memory));
        }
    }

    /// Solves for up to eight columns at once, with right-hand sides by rows.
    fn solve_wide(&self, mut x: MatMut<'_, f64>, workspace: &mut SolveWorkspace) {
        let (SymbolicCholeskyRaw::Supernodal(supernodal), Some(perm)) =
            (self.symbolic.symbolic.raw(), self.symbolic.symbolic.perm())
        else {
            unreachable!("a wide workspace belongs to a supernodal factor with an elimination order");
        };
        let (order, _) = perm.arrays();
        for (row, &i) in workspace.rows.iter_mut().zip(order) {
            *row = [0.0; WIDTH];
            for (j, value) in row.iter_mut().enumerate().take(x.ncols()) {
                *value = x[(i as usize, j)];
            }
        }
        let factor = SupernodalLltRef::new(supernodal, &self.values);
        wide_solve::solve(factor, &mut workspace.rows, &mut workspace.local);
        for (row, &i) in workspace.rows.iter().zip(order) {
            for (j, value) in row.iter().enumerate().take(x.ncols()) {
                x[(i as usize, j)] = *value;
            }
        }
    }

    /// The trailing block `L_bb` (n_b x n_b, lower) of the last `n_b` unknowns of the elimination order: `L_bb L_bb^T` is
    /// the Schur complement on them (Eq. R.14).
    ///
    /// # Panics
    /// If there are fewer than `n_b` unknowns.
    pub fn trailing_block(&self, n_b: usize) -> Mat<f64> {
        let first = self.symbolic.n_unknowns().checked_sub(n_b).expect("the block is part of the matrix");
        let mut block = Mat::zeros(n_b, n_b);
        self.for_each_column(|column, rows, values| {
            if column >= first {
                for (row, &value) in rows.zip(values).filter(|&(row, _)| row >= column) {
                    block[(row - first, column - first)] = value;
                }
            }
        });
        block
    }

    fn first_bad_pivot(&self) -> Option<usize> {
        let mut bad = None;
        self.for_each_column(|column, rows, values| {
            let pivot =
                rows.zip(values).find(|&(row, _)| row == column).map_or(f64::NAN, |(_, &value)| value);
            if bad.is_none() && !(pivot.is_finite() && pivot > 0.0) {
                bad = Some(column);
            }
        });
        bad
    }

    /// Calls `visit(column, rows, values)` for every column of `L` in the elimination order.
    fn for_each_column(&self, mut visit: impl FnMut(usize, &mut dyn Iterator<Item = usize>, &[f64])) {
        let SymbolicCholeskyRaw::Supernodal(supernodal) = self.symbolic.symbolic.raw() else {
            return;
        };
        let factor = SupernodalLltRef::new(supernodal, &self.values);
        for s in 0..supernodal.n_supernodes() {
            let block = factor.supernode(s);
            let width = block.val().ncols();
            let own = block.start()..block.start() + width;
            for j in 0..width {
                let column = block.val().col(j).try_as_col_major().expect("supernodes are stored by columns");
                let mut rows = own.clone().chain(block.pattern().iter().map(|&i| i as usize));
                visit(block.start() + j, &mut rows, column.as_slice());
            }
        }
    }
}

pub(super) fn buffer(scratch: StackReq, matrix: &'static str) -> Result<MemBuffer, DynamicsError> {
    MemBuffer::try_new(scratch).map_err(|_| failed(matrix, "not enough memory".into()))
}

pub(super) fn failed(matrix: &'static str, reason: String) -> DynamicsError {
    DynamicsError::Factorisation { matrix, reason }
}
