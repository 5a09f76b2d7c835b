//! Linear systems whose matrix is near one with kept factors.
//!
//! Generalised minimal residuals (Saad & Schultz 1986), with the kept factors on the right: a matrix that differs in `k` ranks is
//! solved in `k + 1` steps, in fewer where the differences are small.

use crate::quasistatic::factors::Lu;
use crate::quasistatic::problem::dot;

/// Steps that cost about as much as a factorisation.
const MAX_STEPS: usize = 20;

/// Factors of a matrix, and room for solutions with others near it.
pub(super) struct KeptFactor {
    /// Rows of the matrix in use; zero: none.
    n: usize,
    lu: Lu,
    /// Orthonormal residuals, one after the other, and a buffer.
    basis: Vec<f64>,
    buffer: Vec<f64>,
    /// Columns of the triangular factor of their products.
    columns: [[f64; MAX_STEPS + 1]; MAX_STEPS],
}

impl KeptFactor {
    /// Room for matrices of up to `n` rows.
    pub fn new(n: usize) -> Self {
        Self {
            n: 0,
            lu: Lu::new(n, 1),
            basis: vec![0.0; (MAX_STEPS + 1) * n],
            buffer: vec![0.0; n],
            columns: [[0.0; MAX_STEPS + 1]; MAX_STEPS],
        }
    }

    /// Whether there are factors.
    pub fn is_made(&self) -> bool {
        self.n > 0
    }

    /// Forgets the factors.
    pub fn forget(&mut self) {
        self.n = 0;
    }

    /// Takes the factors of the matrix of `n` rows that `fill` writes column by column.
    pub fn factorise(&mut self, n: usize, fill: impl FnOnce(&mut [f64])) {
        self.n = n;
        self.lu.factorise(n, fill);
    }

    /// Replaces `x` by the solution of the factorised system.
    pub fn solve(&mut self, x: &mut [f64]) {
        self.lu.solve(x);
    }

    /// Replaces `x` by the solution of the system whose matrix `apply` multiplies vectors by, until what is left is `tolerance` of
    /// the right-hand side; false, and `x` as it was, if that takes longer than new factors.
    pub fn solve_near(
        &mut self,
        mut apply: impl FnMut(&[f64], &mut [f64]),
        tolerance: f64,
        x: &mut [f64],
    ) -> bool {
        let (n, start) = (self.n, norm(x));
        if start == 0.0 {
            return true;
        }
        let (mut rotations, mut left) = ([[1.0, 0.0]; MAX_STEPS], [0.0; MAX_STEPS + 1]);
        left[0] = start;
        self.basis.iter_mut().zip(&*x).for_each(|(v, x)| *v = x / start);
        for k in 0..MAX_STEPS {
            let buffer = &mut self.buffer[..n];
            buffer.copy_from_slice(&self.basis[k * n..(k + 1) * n]);
            self.lu.solve(buffer);
            let (known, next) = self.basis.split_at_mut((k + 1) * n);
            let next = &mut next[..n];
            apply(buffer, next);
            let column = &mut self.columns[k];
            for (entry, v) in column.iter_mut().zip(known.chunks_exact(n)) {
                *entry = dot(v, next);
                next.iter_mut().zip(v).for_each(|(w, v)| *w -= *entry * v);
            }
            let size = norm(next);
            for (i, [c, s]) in rotations[..k].iter().enumerate() {
                [column[i], column[i + 1]] =
                    [c * column[i] + s * column[i + 1], c * column[i + 1] - s * column[i]];
            }
            let pivot = column[k].hypot(size);
            rotations[k] = [column[k] / pivot, size / pivot];
            column[k] = pivot;
            [left[k], left[k + 1]] = [rotations[k][0] * left[k], -rotations[k][1] * left[k]];
            if !pivot.is_finite() {
                return false;
            }
            if left[k + 1].abs() <= tolerance * start {
                self.sum_up(&mut left[..=k], x);
                return true;
            }
            next.iter_mut().for_each(|w| *w /= size);
        }
        false
    }

    /// The solution `x` of the steps whose triangular system has the right-hand side `left`.
    fn sum_up(&mut self, left: &mut [f64], x: &mut [f64]) {
        for k in (0..left.len()).rev() {
            left[k] /= self.columns[k][k];
            let (before, factor) = left.split_at_mut(k);
            before.iter_mut().zip(&self.columns[k]).for_each(|(rest, entry)| *rest -= entry * factor[0]);
        }
        x.fill(0.0);
        for (v, factor) in self.basis.chunks_exact(self.n).zip(&*left) {
            x.iter_mut().zip(v).for_each(|(x, v)| *x += factor * v);
        }
        self.solve(x);
    }
}

fn norm(x: &[f64]) -> f64 {
    dot(x, x).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Columns of the identity with entries about it; from `rank` on they are those of the kept matrix.
    fn matrix(n: usize, rank: usize) -> Vec<f64> {
        let entry = |i: usize, j: usize| {
            let turned = if j < rank { 0.3 * ((5 * i + 3 * j) as f64).cos() } else { 0.0 };
            f64::from(u8::from(i == j)) + 0.2 * ((i + 2 * j) as f64).sin() + turned
        };
        (0..n * n).map(|k| entry(k % n, k / n)).collect()
    }

    #[test]
    fn matrices_of_another_rank_take_as_many_steps() {
        let n = 40;
        let mut factor = KeptFactor::new(n + 3);
        factor.factorise(n, |out| out.copy_from_slice(&matrix(n, 0)));
        for (rank, most) in [(0, 1), (3, 4), (8, 9), (n, usize::MAX)] {
            let (columns, mut steps) = (matrix(n, rank), 0);
            let product = |v: &[f64], out: &mut [f64]| {
                out.fill(0.0);
                for (column, v) in columns.chunks_exact(n).zip(v) {
                    out.iter_mut().zip(column).for_each(|(o, a)| *o += a * v);
                }
            };
            let rhs: Vec<f64> = (0..n).map(|i| (0.7 * i as f64).cos()).collect();
            let mut x = rhs.clone();
            let done = factor.solve_near(
                |v, out| {
                    steps += 1;
                    product(v, out);
                },
                1e-12,
                &mut x,
            );
            if !done {
                assert!(rank == n && x == rhs, "{rank}");
                continue;
            }
            assert!(steps <= most, "{rank} {steps}");
            let mut back = vec![0.0; n];
            product(&x, &mut back);
            // Condition of some ten.
            assert!(back.iter().zip(&rhs).all(|(a, b)| (a - b).abs() < 1e-11), "{rank}");
        }
    }
}
