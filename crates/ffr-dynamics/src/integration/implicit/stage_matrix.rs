//! The linear systems of a pair of Gauss stages, reduced to the velocities (docs/theory.md
//! Eq. T.28).

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::lu::partial_pivoting as lu;
use faer::perm::PermRef;
use faer::{MatMut, MatRef, Par, c64};

use crate::integration::linearisation::Linearisation;

/// Factors of `1 - h λ A_v - (h λ)² A_s` for a complex `λ`, with buffers.
pub(super) struct StageMatrix {
    n: usize,
    value: c64,
    factors: Vec<c64>,
    permutation: Vec<usize>,
    inverse: Vec<usize>,
    memory: MemBuffer,
}

impl StageMatrix {
    /// For `n` unknowns and the eigenvalue `value` of the method.
    pub fn new(n: usize, value: c64) -> Self {
        let scratch = lu::factor::lu_in_place_scratch::<usize, c64>(n, n, Par::Seq, Default::default())
            .or(lu::solve::solve_in_place_scratch::<usize, c64>(n, 1, Par::Seq));
        Self {
            n,
            value,
            factors: vec![c64::new(0.0, 0.0); n * n],
            permutation: (0..n).collect(),
            inverse: (0..n).collect(),
            memory: MemBuffer::new(scratch),
        }
    }

    /// Factorises the matrix for steps of size `h`; returns whether that is possible: it may be
    /// singular or not finite.
    pub fn factorise(&mut self, derivative: &Linearisation, h: f64) -> bool {
        let n = self.n;
        if n == 0 {
            return true;
        }
        let weight = self.value * h;
        let squared = weight * weight;
        for (j, column) in self.factors.chunks_exact_mut(n).enumerate() {
            let rates = derivative.velocity_column(j).iter().zip(derivative.position_column(j));
            for (a, (by_velocity, by_position)) in column.iter_mut().zip(rates) {
                *a = -(weight * *by_velocity + squared * *by_position);
            }
            column[j] += 1.0;
        }
        if !self.factors.iter().all(|a| a.re.is_finite() && a.im.is_finite()) {
            return false;
        }
        lu::factor::lu_in_place(
            MatMut::from_column_major_slice_mut(&mut self.factors, n, n),
            &mut self.permutation,
            &mut self.inverse,
            Par::Seq,
            MemStack::new(&mut self.memory),
            Default::default(),
        );
        (0..n).all(|i| self.factors[i * n + i].norm_sqr() > 0.0)
    }

    /// Replaces `x` by the solution.
    pub fn solve(&mut self, x: &mut [c64]) {
        let n = self.n;
        if n == 0 {
            return;
        }
        lu::solve::solve_in_place(
            MatRef::from_column_major_slice(&self.factors, n, n),
            MatRef::from_column_major_slice(&self.factors, n, n),
            PermRef::new_checked(&self.permutation, &self.inverse, n),
            MatMut::from_column_major_slice_mut(x, n, 1),
            Par::Seq,
            MemStack::new(&mut self.memory),
        );
    }
}

impl std::fmt::Debug for StageMatrix {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("StageMatrix").field("n", &self.n).field("value", &self.value).finish()
    }
}
