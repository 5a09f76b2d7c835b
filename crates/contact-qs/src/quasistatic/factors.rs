//! Factors of dense matrices, column by column, with the room that they are made in.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt;
use faer::linalg::lu::partial_pivoting as lu;
use faer::perm::PermRef;
use faer::{MatMut, MatRef, Par};

/// Room for Cholesky factors.
pub(crate) struct Cholesky(MemBuffer);

impl Cholesky {
    /// Of matrices of up to `n` rows.
    pub fn new(n: usize) -> Self {
        let scratch = llt::factor::cholesky_in_place_scratch::<f64>(n, Par::Seq, Default::default());
        Self(MemBuffer::new(scratch))
    }

    /// Puts the factor of the first `n` rows and columns in the lower half of `matrix`; false if that is not positive definite.
    pub fn factorise(&mut self, matrix: &mut [f64], n: usize) -> bool {
        let matrix = MatMut::from_column_major_slice_mut(&mut matrix[..n * n], n, n);
        let stack = MemStack::new(&mut self.0);
        llt::factor::cholesky_in_place(matrix, Default::default(), Par::Seq, stack, Default::default())
            .is_ok()
    }

    /// Replaces `x` by the solution of the system whose factor is `factor`.
    pub fn solve(&mut self, factor: &[f64], x: &mut [f64]) {
        let n = x.len();
        if n > 0 {
            let factor = MatRef::from_column_major_slice(&factor[..n * n], n, n);
            let x = MatMut::from_column_major_slice_mut(x, n, 1);
            llt::solve::solve_in_place(factor, x, Par::Seq, MemStack::new(&mut self.0));
        }
    }
}

/// LU factors of a matrix with exchanges of its rows.
pub(crate) struct Lu {
    n: usize,
    factors: Vec<f64>,
    permutation: [Vec<usize>; 2],
    memory: MemBuffer,
}

impl Lu {
    /// Room for matrices of up to `n` rows, and for solutions with up to `width` right-hand sides.
    pub fn new(n: usize, width: usize) -> Self {
        let scratch = lu::factor::lu_in_place_scratch::<usize, f64>(n, n, Par::Seq, Default::default())
            .or(lu::solve::solve_in_place_scratch::<usize, f64>(n, width, Par::Seq))
            .or(lu::solve::solve_transpose_in_place_scratch::<usize, f64>(n, 1, Par::Seq));
        Self {
            n,
            factors: vec![0.0; n * n],
            permutation: [(); 2].map(|()| (0..n).collect()),
            memory: MemBuffer::new(scratch),
        }
    }

    /// Takes the factors of the matrix of `n` rows that `fill` writes.
    pub fn factorise(&mut self, n: usize, fill: impl FnOnce(&mut [f64])) {
        self.n = n;
        let matrix = &mut self.factors[..n * n];
        fill(matrix);
        let matrix = MatMut::from_column_major_slice_mut(matrix, n, n);
        let [to, back] = &mut self.permutation;
        let stack = MemStack::new(&mut self.memory);
        lu::factor::lu_in_place(matrix, &mut to[..n], &mut back[..n], Par::Seq, stack, Default::default());
    }

    /// Whether a pivot is zero.
    pub fn is_singular(&self) -> bool {
        (0..self.n).any(|i| self.factors[i * self.n + i] == 0.0)
    }

    /// Replaces the columns of `x` by the solutions of the factorised system.
    pub fn solve(&mut self, x: &mut [f64]) {
        self.solve_by(x, |factors, permutation, x, stack| {
            lu::solve::solve_in_place(factors, factors, permutation, x, Par::Seq, stack);
        });
    }

    /// Replaces `x` by the solution of the system with the transposed matrix.
    pub fn solve_transposed(&mut self, x: &mut [f64]) {
        self.solve_by(x, |factors, permutation, x, stack| {
            lu::solve::solve_transpose_in_place(factors, factors, permutation, x, Par::Seq, stack);
        });
    }

    fn solve_by(
        &mut self,
        x: &mut [f64],
        solve: impl FnOnce(MatRef<'_, f64>, PermRef<'_, usize>, MatMut<'_, f64>, &mut MemStack),
    ) {
        let n = self.n;
        if n == 0 {
            return;
        }
        let factors = MatRef::from_column_major_slice(&self.factors[..n * n], n, n);
        let [to, back] = &self.permutation;
        let permutation = PermRef::new_checked(&to[..n], &back[..n], n);
        let x = MatMut::from_column_major_slice_mut(x, n, x.len() / n);
        solve(factors, permutation, x, MemStack::new(&mut self.memory));
    }
}
