//! A matrix that changes by products of two vectors, with its inverse.
//!
//! `(J + c a bᵀ)⁻¹ = J⁻¹ - c J⁻¹a bᵀJ⁻¹ / (1 + c bᵀJ⁻¹a)` (Sherman & Morrison 1950). The work lies
//! in reading the matrices, so that every pass does all it can: both products with the inverse in
//! one, update and norms in another.

use super::conditioned_lu::ConditionedLu;

/// The inverse is made anew where the formula divides by less: it has lost so many digits.
const LEAST_DIVISOR: f64 = 1e-6;

/// Square matrix with its inverse, both column by column.
#[derive(Debug, Clone)]
pub(super) struct ShermanMorrisonInverse {
    matrix: Vec<f64>,
    inverse: Vec<f64>,
    /// Updates since the inverse was made; none if it must be made anew.
    n_updates: Option<usize>,
    /// `‖J‖₁`, `‖J⁻¹‖₁`.
    norms: [f64; 2],
    /// `J⁻¹a` and `bᵀJ⁻¹`.
    left: Vec<f64>,
    right: Vec<f64>,
}

impl ShermanMorrisonInverse {
    /// Room for an `n × n` matrix.
    pub fn new(n: usize) -> Self {
        Self {
            matrix: vec![0.0; n * n],
            inverse: vec![0.0; n * n],
            n_updates: None,
            norms: [0.0; 2],
            left: vec![0.0; n],
            right: vec![0.0; n],
        }
    }

    pub fn copy_from(&mut self, other: &Self) {
        self.matrix.copy_from_slice(&other.matrix);
        self.n_updates = other.n_updates;
        self.norms = other.norms;
        if other.n_updates.is_some() {
            self.inverse.copy_from_slice(&other.inverse);
        }
    }

    /// The matrix, to be set entry by entry.
    pub fn set(&mut self) -> &mut [f64] {
        self.n_updates = None;
        &mut self.matrix
    }

    /// `rcond` in the 1-norm: an estimate from the factors by `lu` where the inverse is made anew,
    /// which happens after `max_updates` as well, exact where it was updated. 0 if the matrix is
    /// singular, NaN if an entry is not finite; there is no inverse then, and solutions are NaN.
    pub fn condition(&mut self, max_updates: usize, lu: &mut ConditionedLu) -> f64 {
        if self.n_updates.is_some_and(|n| n <= max_updates) {
            return 1.0 / (self.norms[0] * self.norms[1]);
        }
        self.n_updates = None;
        let rcond = lu.factorise(&self.matrix);
        if rcond > 0.0 {
            lu.invert(&mut self.inverse);
            self.n_updates = Some(0);
        } else {
            self.inverse.fill(f64::NAN);
        }
        rcond
    }

    /// Replaces `x` by `J⁻¹ rhs`.
    pub fn solve(&self, rhs: &[f64], x: &mut [f64]) {
        x.fill(0.0);
        for (column, factor) in self.inverse.chunks_exact(x.len().max(1)).zip(rhs) {
            x.iter_mut().zip(column).for_each(|(x, a)| *x += factor * a);
        }
    }

    /// Adds `c a bᵀ`.
    pub fn update(&mut self, c: f64, a: &[f64], b: &[f64]) {
        let n = a.len().max(1);
        self.norms = [0.0; 2];
        for (column, b) in self.matrix.chunks_exact_mut(n).zip(b) {
            let size = add_scaled(column, c * b, a);
            self.norms[0] = self.norms[0].max(size);
        }
        let Some(n_updates) = self.n_updates else { return };
        self.left.fill(0.0);
        for ((column, right), a) in self.inverse.chunks_exact(n).zip(&mut self.right).zip(a) {
            self.left.iter_mut().zip(column).for_each(|(l, x)| *l += a * x);
            *right = dot(b, column);
        }
        let divisor = 1.0 + c * dot(b, &self.left);
        // Asked this way round, a NaN is small.
        let is_safe = divisor.abs() > LEAST_DIVISOR;
        if !is_safe {
            self.n_updates = None;
            return;
        }
        for (column, right) in self.inverse.chunks_exact_mut(n).zip(&self.right) {
            let size = add_scaled(column, -c * right / divisor, &self.left);
            self.norms[1] = self.norms[1].max(size);
        }
        self.n_updates = Some(n_updates + 1);
    }
}

/// `column += factor a`; returns the sum of the sizes.
fn add_scaled(column: &mut [f64], factor: f64, a: &[f64]) -> f64 {
    let mut sums = [0.0; 8];
    let (mut entries, mut others) = (column.chunks_exact_mut(8), a.chunks_exact(8));
    for (x, a) in (&mut entries).zip(&mut others) {
        for ((x, a), sum) in x.iter_mut().zip(a).zip(&mut sums) {
            *x += factor * a;
            *sum += x.abs();
        }
    }
    let mut rest = 0.0;
    for (x, a) in entries.into_remainder().iter_mut().zip(others.remainder()) {
        *x += factor * a;
        rest += x.abs();
    }
    sums.iter().sum::<f64>() + rest
}

/// Scalar product in eight parts.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 8];
    let (x, y) = (a.chunks_exact(8), b.chunks_exact(8));
    let rest: f64 = x.remainder().iter().zip(y.remainder()).map(|(x, y)| x * y).sum();
    for (x, y) in x.zip(y) {
        for ((x, y), sum) in x.iter().zip(y).zip(&mut sums) {
            *sum += x * y;
        }
    }
    sums.iter().sum::<f64>() + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Some matrix with a dominant diagonal.
    fn matrix(n: usize) -> ShermanMorrisonInverse {
        let mut matrix = ShermanMorrisonInverse::new(n);
        for (k, entry) in matrix.set().iter_mut().enumerate() {
            *entry = if k % (n + 1) == 0 { 4.0 } else { ((7 * k) as f64).sin() };
        }
        matrix
    }

    #[test]
    fn updated_inverse_solves_like_a_new_one() {
        for n in [1, 5, 12, 37] {
            let mut lu = ConditionedLu::new(n);
            let mut updated = matrix(n);
            updated.condition(10, &mut lu);
            for k in 0..10 {
                let vector =
                    |f: f64| (0..n).map(|i| (f * (i + k) as f64).cos() / n as f64).collect::<Vec<_>>();
                updated.update(0.7, &vector(1.3), &vector(2.9));
            }
            let rcond = updated.condition(10, &mut lu);
            let mut again = updated.clone();
            let estimate = again.condition(0, &mut lu);
            // Hager's estimate of the norm is a lower bound, within a factor three of it.
            assert!(estimate >= rcond * (1.0 - 1e-12) && estimate < 3.0 * rcond, "{n}: {rcond} {estimate}");
            let rhs: Vec<f64> = (0..n).map(|i| i as f64).collect();
            let (mut x, mut y) = (vec![0.0; n], vec![0.0; n]);
            updated.solve(&rhs, &mut x);
            again.solve(&rhs, &mut y);
            let size = y.iter().fold(0.0_f64, |m, y| m.max(y.abs()));
            // Round-off of ten updates times the condition number, below 1e3.
            assert!(x.iter().zip(&y).all(|(x, y)| (x - y).abs() <= 1e-11 * size), "{n}");
        }
    }

    #[test]
    fn update_to_a_singular_matrix_is_noticed() {
        let mut lu = ConditionedLu::new(2);
        let mut one = ShermanMorrisonInverse::new(2);
        one.set().copy_from_slice(&[1.0, 0.0, 0.0, 1.0]);
        assert!((one.condition(10, &mut lu) - 1.0).abs() < 1e-15); // round-off
        one.update(-1.0, &[1.0, 0.0], &[1.0, 0.0]);
        assert!(one.condition(10, &mut lu) < f64::MIN_POSITIVE);
        let mut x = [0.0; 2];
        one.solve(&[1.0, 1.0], &mut x);
        assert!(x.iter().all(|x| x.is_nan()));
    }
}
