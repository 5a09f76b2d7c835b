//! Pseudo-random data and a compliance of half-space type for the tests.

use faer::Mat;

/// Linear congruential generator with the constants of Knuth's MMIX.
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(2_862_933_555_777_941_757).wrapping_add(3_037_000_493))
    }

    /// Uniform in (-1, 1).
    pub fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    pub fn matrix(&mut self, rows: usize, columns: usize) -> Mat<f64> {
        Mat::from_fn(rows, columns, |_, _| self.next())
    }

    /// `scale V Vᵀ` with `rank` columns: positive semidefinite, definite for `rank >= n`.
    pub fn semidefinite(&mut self, n: usize, rank: usize, scale: f64) -> Mat<f64> {
        let v = self.matrix(n, rank);
        let product = &v * v.transpose();
        Mat::from_fn(n, n, |i, j| 0.5 * scale * (product[(i, j)] + product[(j, i)]))
    }
}

/// Compliance of `n` neighbours in a row as on an elastic surface: falls off with the distance [m/N].
pub fn surface_compliance(n: usize, size: f64) -> Mat<f64> {
    Mat::from_fn(n, n, |i, j| size / (1.0 + i.abs_diff(j) as f64))
}

/// Gaps of a parabola pressed in by `depth` with `n` points \[m\].
pub fn parabola(n: usize, depth: f64) -> Vec<f64> {
    (0..n).map(|i| depth * (3.0 * (2.0 * i as f64 / (n - 1) as f64 - 1.0).powi(2) - 1.0)).collect()
}
