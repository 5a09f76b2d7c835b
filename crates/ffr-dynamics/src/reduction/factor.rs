//! Sparse Cholesky factorisation with one symbolic analysis for many matrices (Eq. R.3).
//!
//! Supernodal, on the threads of the current rayon pool, with the same bits for any number of them.

mod entry;
mod entry_positions;
mod layout;
pub(super) mod numeric;
mod panel_solve;
mod quotient;
mod supernodes;
mod tree_solve;
pub(super) mod single_precision;

use std::sync::Arc;

use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Mat, MatMut};

use crate::DynamicsError;
use crate::data_error::DataError;
use crate::memory::Shortage;
use entry::Entry;
use entry_positions::EntryPositions;
use layout::Layout;
use numeric::Kind;
use quotient::Quotient;
use supernodes::Supernodes;
use tree_solve::TreeSolve;

const WIDTH: usize = <f64 as Entry>::WIDTH;

/// Elimination order and pattern of the factor, shared by all matrices of one pattern.
#[derive(Debug)]
pub struct SymbolicFactor {
    pub(super) layout: Layout,
    pub(super) positions: EntryPositions,
}

impl SymbolicFactor {
    /// Analyses the lower triangle `pattern` under the elimination `order` (position p holds the
    /// p-th unknown).
    ///
    /// The elimination follows an equivalent order, in which subtrees of the elimination tree are
    /// together; the last `n_last` unknowns keep their places.
    ///
    /// # Errors
    /// [`DynamicsError::FactorTooLarge`] if no memory holds the factor, [`DynamicsError::Data`] if `order` is no permutation.
    ///
    /// # Panics
    /// If `n_last` exceeds the number of unknowns.
    pub fn new(
        pattern: SymbolicSparseColMatRef<'_, u32>,
        order: Vec<u32>,
        n_last: usize,
    ) -> Result<Self, DynamicsError> {
        let n = pattern.nrows();
        let mut is_there = vec![false; n];
        for &unknown in &order {
            if let Some(slot) = is_there.get_mut(unknown as usize) {
                *slot = true;
            }
        }
        if n == 0 || order.len() != n || is_there.contains(&false) {
            let (what, found) = ("unknowns in the order of elimination".into(), order.len());
            return Err(DataError::Count { what, found, expected: n }.into());
        }
        assert!(n_last <= n, "more unknowns are last than there are");
        let quotient = Quotient::new(pattern, &order, n_last);
        let layout = Layout::new(Supernodes::new(&quotient, &order));
        // In the shorter format at least.
        refuse_if(&layout, size_of::<f32>(), crate::memory::shortage)?;
        let positions = EntryPositions::new(pattern, &layout.supernodes.order);
        Ok(Self { layout, positions })
    }

    /// Refuses a factor whose entries, of `bytes` bytes each, have no place in the memory that is
    /// free.
    pub(super) fn check_memory(&self, bytes: usize) -> Result<(), DynamicsError> {
        refuse_if(&self.layout, bytes, crate::memory::shortage)
    }

    /// As [`Self::check_memory`] for a factor beside that of the body's stiffness.
    pub(super) fn check_memory_beside(&self, bytes: usize) -> Result<(), DynamicsError> {
        refuse_if(&self.layout, bytes, crate::memory::shortage_beside)
    }

    /// Elimination order: position p holds the p-th unknown.
    pub fn order(&self) -> &[u32] {
        &self.layout.supernodes.order
    }

    /// Number of unknowns.
    pub fn n_unknowns(&self) -> usize {
        self.order().len()
    }

    /// Whether the elimination ends with the unknowns `last`, in this order.
    pub fn ends_with(&self, last: &[usize]) -> bool {
        let order = self.order();
        let tail = order.len().checked_sub(last.len()).map(|first| &order[first..]);
        tail.is_some_and(|tail| tail.iter().zip(last).all(|(&a, &b)| a as usize == b))
    }

    /// Stored entries of the factor.
    pub fn n_entries(&self) -> usize {
        self.layout.n_values()
    }

    /// Multiplications and additions that a factorisation takes.
    pub fn work(&self) -> f64 {
        self.layout.roots().iter().map(|&s| self.layout.work[s as usize]).sum()
    }

    /// Entries of the factor of a `matrix` with the analysed pattern: those of its entries that
    /// `value(number, row, column)` gives, row and column in the order of elimination. The error is
    /// the position of the pivot that fails.
    fn factorise<T: Entry>(
        &self,
        matrix: SparseColMatRef<'_, u32, f64>,
        value: impl Fn(usize, usize, usize) -> T + Sync,
        kind: Kind,
    ) -> Result<Vec<T>, usize> {
        let n_entries = matrix.val().len();
        assert_eq!(n_entries, self.positions.len(), "the matrix has another pattern than was analysed");
        numeric::factorise(&self.layout, (matrix.symbolic(), &self.positions), value, kind)
    }

    /// The entries of a `matrix` whose rows and columns of `held` unknowns are reduced to their
    /// diagonal, for [`Self::factorise`]; nothing is held if the list is empty.
    fn values<'m>(
        &self,
        matrix: SparseColMatRef<'m, u32, f64>,
        held: &[bool],
    ) -> impl Fn(usize, usize, usize) -> f64 + Sync + use<'m> {
        let values = matrix.val();
        let is_held: Vec<bool> = match held {
            [] => vec![false; self.n_unknowns()],
            _ => self.order().iter().map(|&i| held[i as usize]).collect(),
        };
        move |number, row, column| match row != column && (is_held[row] || is_held[column]) {
            true => 0.0,
            false => values[number],
        }
    }

    /// Cholesky factor of a symmetric positive definite matrix with the analysed pattern; `name` is
    /// for messages.
    ///
    /// # Errors
    /// [`DynamicsError::NotPositiveDefinite`] with the unknown whose pivot fails, [`DynamicsError::FactorTooLarge`].
    ///
    /// # Panics
    /// If the matrix has not as many entries as the pattern.
    pub fn cholesky(
        self: &Arc<Self>,
        matrix: SparseColMatRef<'_, u32, f64>,
        name: &'static str,
    ) -> Result<CholeskyFactor, DynamicsError> {
        self.cholesky_held(matrix, &[], name)
    }

    /// As [`Self::cholesky`] with rows and columns of `held` unknowns, if there are any, reduced to
    /// their diagonal.
    pub(super) fn cholesky_held(
        self: &Arc<Self>,
        matrix: SparseColMatRef<'_, u32, f64>,
        held: &[bool],
        name: &'static str,
    ) -> Result<CholeskyFactor, DynamicsError> {
        self.check_memory(size_of::<f64>())?;
        match self.factorise(matrix, self.values(matrix, held), Kind::Definite) {
            Ok(values) => Ok(CholeskyFactor { symbolic: Arc::clone(self), values }),
            Err(position) => {
                let pivot = self.order()[position] as usize;
                Err(DynamicsError::NotPositiveDefinite { matrix: name, pivot, size: self.n_unknowns() })
            }
        }
    }

    /// Factor of a symmetric matrix with pivots of either sign; `None` if one vanishes.
    pub(super) fn indefinite(
        self: &Arc<Self>,
        matrix: SparseColMatRef<'_, u32, f64>,
    ) -> Option<CholeskyFactor> {
        let values = self.factorise(matrix, self.values(matrix, &[]), Kind::Indefinite).ok()?;
        Some(CholeskyFactor { symbolic: Arc::clone(self), values })
    }
}

/// Refuses a factor whose entries, of `bytes` bytes each, `shortage` finds no memory for.
fn refuse_if(
    layout: &Layout,
    bytes: usize,
    shortage: impl Fn(f64) -> Option<Shortage>,
) -> Result<(), DynamicsError> {
    let bytes = layout.n_values() as f64 * bytes as f64;
    let (unknowns, gigabytes) = (layout.supernodes.order.len(), 1e-9 * bytes);
    match shortage(bytes) {
        Some(Shortage { free, room }) => {
            Err(DynamicsError::FactorTooLarge { unknowns, gigabytes, free, room })
        }
        None => Ok(()),
    }
}

/// A sparse Cholesky factor `L` with `A = L L^T` in the elimination order, or `A = L S L^T` with
/// the signs `S` of the pivots.
#[derive(Debug)]
pub struct CholeskyFactor {
    symbolic: Arc<SymbolicFactor>,
    values: Vec<f64>,
}

impl CholeskyFactor {
    /// The analysis behind the factor.
    pub fn symbolic(&self) -> &Arc<SymbolicFactor> {
        &self.symbolic
    }

    /// Its entries.
    pub(super) fn values(&self) -> &[f64] {
        &self.values
    }

    /// Solves `A x = b` in place for all columns, eight at a time, on the threads of the current
    /// rayon pool.
    ///
    /// # Panics
    /// If `x` has not one row per unknown.
    pub fn solve_in_place(&self, mut x: MatMut<'_, f64>) {
        assert_eq!(x.nrows(), self.symbolic.n_unknowns(), "right-hand side and factor differ in size");
        let solve = TreeSolve { layout: &self.symbolic.layout, values: &self.values };
        let order = self.symbolic.order();
        let mut rows = vec![<f64 as Entry>::ZERO_ROW; order.len()];
        for first in (0..x.ncols()).step_by(WIDTH) {
            let width = WIDTH.min(x.ncols() - first);
            let mut x = x.as_mut().subcols_mut(first, width);
            for (row, &i) in rows.iter_mut().zip(order) {
                *row = <f64 as Entry>::ZERO_ROW;
                for (j, value) in row.iter_mut().enumerate().take(width) {
                    *value = x[(i as usize, j)];
                }
            }
            solve.solve(&mut rows);
            for (row, &i) in rows.iter().zip(order) {
                for (j, value) in row.iter().enumerate().take(width) {
                    x[(i as usize, j)] = *value;
                }
            }
        }
    }

    /// The trailing block `L_bb` (n_b x n_b, lower) of the last `n_b` unknowns of the elimination
    /// order: `L_bb L_bb^T` is the Schur complement on them (Eq. R.20).
    ///
    /// # Panics
    /// If there are fewer than `n_b` unknowns.
    pub fn trailing_block(&self, n_b: usize) -> Mat<f64> {
        let first = self.symbolic.n_unknowns().checked_sub(n_b).expect("the block is part of the matrix");
        let mut block = Mat::zeros(n_b, n_b);
        let layout = &self.symbolic.layout;
        for s in 0..layout.supernodes.len() {
            let columns = layout.supernodes.columns(s);
            if columns.end <= first {
                continue;
            }
            for panel in layout.panels(s) {
                let rows = panel.first..columns.end;
                let rows =
                    || rows.clone().chain(layout.supernodes.pattern(s).iter().map(|&row| row as usize));
                let values = self.values[panel.values..].chunks_exact(panel.n_rows);
                for (column, values) in
                    (panel.first..panel.end).zip(values).filter(|&(column, _)| column >= first)
                {
                    for (row, &value) in rows().zip(values).filter(|&(row, _)| row >= column) {
                        block[(row - first, column - first)] = value;
                    }
                }
            }
        }
        block
    }
}
