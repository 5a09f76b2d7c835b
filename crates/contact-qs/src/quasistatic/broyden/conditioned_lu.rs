//! Dense LU factorisation with an estimate of the reciprocal condition number.
//!
//! `rcond = 1 / (‖J‖₁ est‖J⁻¹‖₁)` (docs/theory.md Eq. C.15): Hager's estimator with Higham's extra
//! vector (Higham 1988), as in LAPACK's `gecon` and MATLAB's `rcond`, which \[A\] uses. A lower
//! bound of `‖J⁻¹‖₁`, in practice within a factor 3.

use crate::quasistatic::factors::Lu;

/// Most refinements of the estimate (Higham 1988, as in LAPACK).
const MAX_REFINEMENTS: usize = 5;

/// Columns of an inverse found together.
const BUNDLE: usize = 64;

/// Factors of one square matrix of fixed size, with buffers.
pub struct ConditionedLu {
    n: usize,
    lu: Lu,
    probe: Vec<f64>,
    signs: Vec<f64>,
}

impl ConditionedLu {
    /// Room for an `n × n` matrix.
    pub fn new(n: usize) -> Self {
        Self { n, lu: Lu::new(n, BUNDLE), probe: vec![0.0; n], signs: vec![0.0; n] }
    }

    /// Factorises the column-major `matrix` and returns its estimated `rcond`: 0 if singular, NaN
    /// if an entry is not finite (nothing is factorised then).
    ///
    /// # Panics
    /// If the size differs from that given to [`ConditionedLu::new`].
    pub fn factorise(&mut self, matrix: &[f64]) -> f64 {
        let n = self.n;
        assert_eq!(matrix.len(), n * n, "matrix size");
        if n == 0 {
            return 1.0;
        }
        let mut norm = 0.0_f64;
        for column in matrix.chunks_exact(n) {
            let sum: f64 = column.iter().map(|a| a.abs()).sum();
            if !sum.is_finite() {
                return f64::NAN;
            }
            norm = norm.max(sum);
        }
        self.lu.factorise(n, |target| target.copy_from_slice(matrix));
        if self.lu.is_singular() {
            return 0.0;
        }
        let rcond = 1.0 / (norm * self.inverse_norm());
        // An overflow of the inverse: singular to working precision.
        if rcond.is_finite() { rcond } else { 0.0 }
    }

    /// Replaces the columns of `x`, at most `BUNDLE`, by `J⁻¹` times them.
    pub fn solve(&mut self, x: &mut [f64]) {
        self.lu.solve(x);
    }

    /// Replaces `inverse`, column by column, by `J⁻¹`.
    pub fn invert(&mut self, inverse: &mut [f64]) {
        let n = self.n;
        inverse.fill(0.0);
        inverse.iter_mut().step_by(n + 1).for_each(|x| *x = 1.0);
        if n == 0 {
            return;
        }
        // In bundles, which need no more room than what is there.
        inverse.chunks_mut(n * BUNDLE.min(n)).for_each(|columns| self.solve(columns));
    }

    /// `‖J⁻¹ probe‖₁`, the product left in the probe.
    fn image_norm(&mut self) -> f64 {
        self.lu.solve(&mut self.probe);
        self.probe.iter().map(|x| x.abs()).sum()
    }

    /// Estimate of `‖J⁻¹‖₁`.
    fn inverse_norm(&mut self) -> f64 {
        let n = self.n;
        self.probe.fill(1.0 / n as f64);
        let mut estimate = self.image_norm();
        let mut last = usize::MAX;
        for _ in 0..MAX_REFINEMENTS {
            // Gradient of the norm: the most promising unit vector is its largest entry.
            let mut changed = false;
            for (sign, x) in self.signs.iter_mut().zip(&self.probe) {
                let new = if *x < 0.0 { -1.0 } else { 1.0 };
                changed |= new * *sign < 0.5;
                *sign = new;
            }
            if !changed && last != usize::MAX {
                break;
            }
            self.probe.copy_from_slice(&self.signs);
            self.lu.solve_transposed(&mut self.probe);
            let next = largest(&self.probe);
            if next == last {
                break;
            }
            last = next;
            self.probe.fill(0.0);
            self.probe[next] = 1.0;
            let norm = self.image_norm();
            if norm <= estimate {
                break;
            }
            estimate = norm;
        }
        // Higham's safeguard against cancellation in the search above.
        for (i, x) in self.probe.iter_mut().enumerate() {
            let size = 1.0 + i as f64 / (n.max(2) - 1) as f64;
            *x = if i % 2 == 0 { size } else { -size };
        }
        estimate.max(2.0 * self.image_norm() / (3.0 * n as f64))
    }
}

/// Index of the entry of largest size.
fn largest(x: &[f64]) -> usize {
    let mut best = 0;
    for (i, value) in x.iter().enumerate() {
        if value.abs() > x[best].abs() {
            best = i;
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rcond_of_a_diagonal_matrix_is_the_ratio_of_its_entries() {
        let mut lu = ConditionedLu::new(3);
        let rcond = lu.factorise(&[2.0, 0.0, 0.0, 0.0, 1e-6, 0.0, 0.0, 0.0, 5.0]);
        assert!((rcond - 2e-7).abs() < 1e-20); // round-off
        let mut x = [2.0, 1e-6, 10.0];
        lu.solve(&mut x);
        assert!(x.iter().zip([1.0, 1.0, 2.0]).all(|(a, b)| (a - b).abs() < 1e-15)); // round-off
    }

    #[test]
    fn rcond_is_within_a_factor_three_of_the_exact_value() {
        // Pseudo-random matrices whose inverse norm is found column by column.
        let mut seed = 1_u64;
        let mut random = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        for n in [1, 2, 5, 12, 30] {
            let matrix: Vec<f64> = (0..n * n).map(|_| random()).collect();
            let mut lu = ConditionedLu::new(n);
            let rcond = lu.factorise(&matrix);
            let norm = |m: &[f64]| m.chunks(n).map(|c| c.iter().map(|x| x.abs()).sum()).fold(0.0, f64::max);
            let mut inverse = vec![0.0; n * n];
            for j in 0..n {
                inverse[j * n + j] = 1.0;
                lu.solve(&mut inverse[j * n..(j + 1) * n]);
            }
            let exact = 1.0 / (norm(&matrix) * norm(&inverse));
            // The estimate never exceeds the true norm of the inverse (round-off allowed for).
            assert!(rcond >= exact * (1.0 - 1e-12) && rcond < 3.0 * exact, "{n}: {rcond} {exact}");
        }
    }

    #[test]
    fn singular_and_not_finite_matrices_are_told_apart() {
        let mut lu = ConditionedLu::new(2);
        assert!(lu.factorise(&[1.0, 2.0, 2.0, 4.0]) < f64::MIN_POSITIVE);
        assert!(lu.factorise(&[1.0, f64::INFINITY, 0.0, 1.0]).is_nan());
        assert!(lu.factorise(&[1.0, f64::NAN, 0.0, 1.0]).is_nan());
    }
}
