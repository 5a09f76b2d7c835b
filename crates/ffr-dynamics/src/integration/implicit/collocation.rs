//! Coefficients of Gauss collocation with four stages, and the eigenvalues that uncouple its stages
//! (docs/theory.md Eq. T.26 to T.31).
//!
//! Source: Hairer & Wanner, *Solving Ordinary Differential Equations II*, IV.5 and IV.8; Hairer,
//! Lubich & Wanner, *Geometric Numerical Integration*, II.1.

use faer::c64;

/// Number of stages.
pub(super) const STAGES: usize = 4;
/// Number of pairs of conjugate eigenvalues.
pub(crate) const PAIRS: usize = STAGES / 2;

/// Coefficients of Legendre's polynomial of degree four on `[0, 1]` by rising powers.
const LEGENDRE: [f64; STAGES + 1] = [1.0, -20.0, 90.0, -140.0, 70.0];
/// Denominator of the stability function, `det(1 - z A)`, by rising powers: that of the diagonal
/// Padé approximation of `exp`.
const DENOMINATOR: [f64; STAGES + 1] = [1.0, -0.5, 3.0 / 28.0, -1.0 / 84.0, 1.0 / 1680.0];

/// A pair of conjugate eigenvalues of the matrix `A` of the weights of the stages. What belongs to
/// the other of the two is conjugate.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pair {
    /// Eigenvalue with positive imaginary part.
    pub value: c64,
    /// Right eigenvector.
    pub right: [c64; STAGES],
    /// Left eigenvector, with the product 1 with the right one.
    pub left: [c64; STAGES],
    /// Share of `1 / (1 - λ z)` in `z⁴ / det(1 - z A)`.
    pub residue: c64,
}

/// Nodes, weights and eigenvalues.
#[derive(Debug, Clone)]
pub(super) struct Collocation {
    /// Times of the stages as shares of the step, zeros of Legendre's polynomial.
    pub nodes: [f64; STAGES],
    /// Weights of the rates at the end of the step.
    pub weights: [f64; STAGES],
    /// Weights of the rates in each stage, `A`.
    pub stages: [[f64; STAGES]; STAGES],
    /// Weights of the rates in their polynomial's value at the start of the step.
    pub at_start: [f64; STAGES],
    /// Lagrange's polynomials of the nodes by rising powers.
    lagrange: [[f64; STAGES]; STAGES],
    pub pairs: [Pair; PAIRS],
}

impl Collocation {
    pub fn new() -> Self {
        let nodes = [(-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0), (1.0, 1.0)].map(|(side, outer): (f64, f64)| {
            0.5 + 0.5 * side * (3.0 / 7.0 + outer * 2.0 / 7.0 * (6.0_f64 / 5.0).sqrt()).sqrt()
        });
        let lagrange: [[f64; STAGES]; STAGES] = std::array::from_fn(|i| lagrange(&nodes, i));
        let integral = |i: usize, to: f64| -> f64 {
            lagrange[i].iter().enumerate().map(|(k, c)| c * to.powi(k as i32 + 1) / (k + 1) as f64).sum()
        };
        let weights = std::array::from_fn(|i| integral(i, 1.0));
        let stages = nodes.map(|c| std::array::from_fn(|i| integral(i, c)));
        let at_start = lagrange.map(|polynomial| polynomial[0]);
        let pairs = pairs(&nodes, &weights);
        Self { nodes, weights, stages, at_start, lagrange, pairs }
    }

    /// Weights `∫_0^θ` of the rates in the state at the share `theta` of the step, and that of the
    /// defect at its start (Eq. T.31).
    pub fn between(&self, theta: f64) -> ([f64; STAGES], f64) {
        let integral = |polynomial: &[f64]| -> f64 {
            let terms = polynomial.iter().enumerate().rev();
            theta * terms.fold(0.0, |sum, (k, c)| sum * theta + c / (k + 1) as f64)
        };
        (self.lagrange.map(|polynomial| integral(&polynomial)), -integral(&LEGENDRE))
    }
}

/// Share of `z⁴ / det(1 - z A)` that stays for large `z`: `1 / det A`.
pub(super) const STIFF_LIMIT: f64 = 1.0 / DENOMINATOR[STAGES];

/// The error of a step over that of the rate at its start, divided by the step and `(h J)⁴`:
/// `s! / (2 s + 1)!` (Eq. T.30).
pub(super) const ERROR_CONSTANT: f64 = 24.0 / 362_880.0;

/// Lagrange's polynomial of node `i` by rising powers.
fn lagrange(nodes: &[f64; STAGES], i: usize) -> [f64; STAGES] {
    let mut polynomial = [0.0; STAGES];
    polynomial[0] = 1.0;
    let others = (0..STAGES).filter(|j| *j != i);
    for (degree, j) in others.enumerate() {
        // times (τ - c_j) / (c_i - c_j)
        let scale = 1.0 / (nodes[i] - nodes[j]);
        for k in (0..=degree + 1).rev() {
            let lower = if k > 0 { polynomial[k - 1] } else { 0.0 };
            polynomial[k] = scale * (lower - nodes[j] * polynomial[k]);
        }
    }
    polynomial
}

/// Eigenvalues of `A` with eigenvectors in closed form.
fn pairs(nodes: &[f64; STAGES], weights: &[f64; STAGES]) -> [Pair; PAIRS] {
    let values = eigenvalues();
    let upper: Vec<c64> = values.iter().copied().filter(|v| v.im > 0.0).collect();
    std::array::from_fn(|m| {
        let value = upper[m];
        let right = eigenvector(nodes, value);
        // The nodes are symmetric: Aᵀ B P = B P A, with the weights B and the reversed order P.
        let reversed: [c64; STAGES] = std::array::from_fn(|i| right[STAGES - 1 - i] * weights[i]);
        let product: c64 = (0..STAGES).map(|i| reversed[i] * right[i]).sum();
        let others = values.iter().filter(|other| (**other - value).norm() > 1e-6);
        let denominator: c64 = others.map(|other| c64::new(1.0, 0.0) - other / value).product();
        Pair {
            value,
            right,
            left: reversed.map(|x| x / product),
            residue: value.powi(-(STAGES as i32)) / denominator,
        }
    })
}

/// Values at the nodes of the polynomial `q'` with `∫_0^t q' = λ q' + P_4`, which is an
/// eigenvector, for `P_4` vanishes there.
fn eigenvector(nodes: &[f64; STAGES], value: c64) -> [c64; STAGES] {
    let mut q = [c64::new(0.0, 0.0); STAGES + 1];
    q[STAGES] = c64::new(LEGENDRE[STAGES], 0.0);
    for k in (1..STAGES).rev() {
        q[k] = value * q[k + 1] * (k + 1) as f64 + LEGENDRE[k];
    }
    nodes.map(|c| (1..=STAGES).map(|k| q[k] * (k as f64 * c.powi(k as i32 - 1))).sum())
}

/// Zeros of `λ⁴ det(1 - A / λ)` by the method of Durand and Kerner.
fn eigenvalues() -> [c64; STAGES] {
    let polynomial = |x: c64| DENOMINATOR.iter().fold(c64::new(0.0, 0.0), |sum, c| sum * x + c);
    let mut zeros: [c64; STAGES] = std::array::from_fn(|k| c64::from_polar(0.2, 0.4 + 1.57 * k as f64));
    for _ in 0..200 {
        for k in 0..STAGES {
            let others: c64 = (0..STAGES).filter(|j| *j != k).map(|j| zeros[k] - zeros[j]).product();
            zeros[k] = zeros[k] - polynomial(zeros[k]) / others;
        }
    }
    zeros
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sums of some ten terms of order one, and Legendre's coefficients of order 100.
    const ROUND_OFF: f64 = 1e-13;

    #[test]
    fn stages_integrate_cubics_and_the_step_polynomials_of_degree_seven() {
        let g = Collocation::new();
        for degree in 0..2 * STAGES {
            let power = |c: f64| c.powi(degree as i32);
            let exact = 1.0 / (degree + 1) as f64;
            let sum: f64 = g.weights.iter().zip(g.nodes).map(|(b, c)| b * power(c)).sum();
            assert!((sum - exact).abs() < ROUND_OFF, "degree {degree}");
            for (row, node) in g.stages.iter().zip(g.nodes).filter(|_| degree < STAGES) {
                let stage: f64 = row.iter().zip(g.nodes).map(|(a, c)| a * power(c)).sum();
                assert!((stage - exact * node.powi(degree as i32 + 1)).abs() < ROUND_OFF);
            }
        }
        let eighth: f64 = g.weights.iter().zip(g.nodes).map(|(b, c)| b * c.powi(8)).sum();
        assert!((eighth - 1.0 / 9.0).abs() > 1e-5, "and no more");
    }

    #[test]
    fn eigenvectors_uncouple_the_stages() {
        let g = Collocation::new();
        for (m, pair) in g.pairs.iter().enumerate() {
            for i in 0..STAGES {
                let applied: c64 = (0..STAGES).map(|j| pair.right[j] * g.stages[i][j]).sum();
                assert!((applied - pair.value * pair.right[i]).norm() < 1e-11 * pair.right[i].norm());
                let transposed: c64 = (0..STAGES).map(|j| pair.left[j] * g.stages[j][i]).sum();
                assert!((transposed - pair.value * pair.left[i]).norm() < 1e-11 * pair.left[i].norm());
            }
            for (l, other) in g.pairs.iter().enumerate() {
                let product: c64 = pair.left.iter().zip(other.right).map(|(a, b)| a * b).sum();
                assert!((product - if m == l { 1.0 } else { 0.0 }).norm() < ROUND_OFF);
            }
        }
    }

    #[test]
    fn shares_of_the_pairs_sum_up_to_the_filter_of_the_error() {
        let g = Collocation::new();
        let filter = |z: c64| {
            let pairs = g.pairs.iter().map(|p| {
                let one = |value: c64, residue: c64| residue / (c64::new(1.0, 0.0) - value * z);
                one(p.value, p.residue) + one(p.value.conj(), p.residue.conj())
            });
            pairs.sum::<c64>() + STIFF_LIMIT
        };
        for z in [c64::new(0.0, 0.3), c64::new(-2.0, 1.0), c64::new(0.0, 40.0)] {
            let determinant = DENOMINATOR.iter().rev().fold(c64::new(0.0, 0.0), |sum, c| sum * z + c);
            // Shares of order 1/det A cancel.
            assert!((filter(z) - z.powi(4) / determinant).norm() < 1e-10 * STIFF_LIMIT, "{z}");
        }
    }

    #[test]
    fn the_weights_between_lead_from_the_start_to_the_end() {
        let g = Collocation::new();
        let (start, defect_at_start) = g.between(0.0);
        let (end, defect_at_end) = g.between(1.0);
        assert!(start.iter().all(|w| w.abs() < ROUND_OFF) && defect_at_start.abs() < ROUND_OFF);
        assert!(end.iter().zip(g.weights).all(|(w, b)| (w - b).abs() < ROUND_OFF));
        assert!(defect_at_end.abs() < ROUND_OFF);
    }
}
