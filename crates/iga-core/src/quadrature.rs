//! Gauss-Legendre and Gauss-Lobatto quadrature (theory Eqs. E.9, C.56).

use std::f64::consts::PI;
use std::sync::OnceLock;

/// Largest number of points per direction that [`GaussRule::new`] builds.
pub const MAX_GAUSS: usize = 16;

/// Gauss-Legendre rule on `[-1, 1]`: `n` points integrate polynomials up to degree `2 n - 1`
/// exactly.
#[derive(Debug, Clone, PartialEq)]
pub struct GaussRule {
    /// Points, rising.
    pub points: Vec<f64>,
    /// Weights; their sum is 2.
    pub weights: Vec<f64>,
}

impl GaussRule {
    /// The rule with `n` points: Newton's method on the Legendre polynomial `P_n`.
    ///
    /// # Panics
    /// Unless `1 <= n <= 16`.
    pub fn new(n: usize) -> Self {
        assert!((1..=MAX_GAUSS).contains(&n), "{n} Gauss points, 1 to {MAX_GAUSS} are possible");
        let (mut points, mut weights) = (vec![0.0; n], vec![0.0; n]);
        for i in 0..n.div_ceil(2) {
            // Tricomi's estimate of the i-th root from the right; Newton needs at most six steps
            // from it.
            let mut x = (PI * (i as f64 + 0.75) / (n as f64 + 0.5)).cos();
            let (mut value, mut slope) = legendre(n, x);
            for _ in 0..10 {
                x -= value / slope;
                (value, slope) = legendre(n, x);
            }
            if 2 * i + 1 == n {
                x = 0.0;
                slope = legendre(n, x).1;
            }
            let w = 2.0 / ((1.0 - x * x) * slope * slope);
            (points[i], points[n - 1 - i]) = (-x, x);
            (weights[i], weights[n - 1 - i]) = (w, w);
        }
        Self { points, weights }
    }

    /// Rules with 1, 2, … [`MAX_GAUSS`] points; entry `n - 1` has `n` points.
    pub fn all() -> Vec<Self> {
        (1..=MAX_GAUSS).map(Self::new).collect()
    }

    /// The rule with `n` points, computed once.
    ///
    /// # Panics
    /// Unless `1 <= n <= 16`.
    pub fn with(n: usize) -> &'static Self {
        static ALL: OnceLock<Vec<GaussRule>> = OnceLock::new();
        &ALL.get_or_init(Self::all)[n - 1]
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// Never true: a rule has at least one point.
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// Points on the interval `[lower, upper]`, appended to `out`; weights scale with
    /// `(upper - lower) / 2`.
    pub fn points_on(&self, lower: f64, upper: f64, out: &mut Vec<f64>) {
        let (middle, half) = (0.5 * (lower + upper), 0.5 * (upper - lower));
        out.extend(self.points.iter().map(|x| middle + half * x));
    }
}

/// Gauss-Lobatto rule on `[-1, 1]`, both ends among its points: `n` points integrate polynomials up
/// to degree `2 n - 3` exactly.
#[derive(Debug, Clone, PartialEq)]
pub struct LobattoRule {
    /// Points, rising from -1 to 1.
    pub points: Vec<f64>,
    /// Weights, all positive; their sum is 2.
    pub weights: Vec<f64>,
}

impl LobattoRule {
    /// The rule with `n` points: the ends, and the extrema of the Legendre polynomial `P_{n-1}`
    /// between them.
    ///
    /// # Panics
    /// Unless `2 <= n <= 16`.
    pub fn new(n: usize) -> Self {
        assert!((2..=MAX_GAUSS).contains(&n), "{n} Lobatto points, 2 to {MAX_GAUSS} are possible");
        let degree = n - 1;
        let (mut points, mut weights) = (vec![0.0; n], vec![0.0; n]);
        for i in 0..n.div_ceil(2) {
            let x = if i == 0 { 1.0 } else { extremum(degree, i) };
            let value = if i == 0 { 1.0 } else { legendre(degree, x).0 };
            let w = 2.0 / ((n * degree) as f64 * value * value);
            (points[i], points[n - 1 - i]) = (-x, x);
            (weights[i], weights[n - 1 - i]) = (w, w);
        }
        Self { points, weights }
    }
}

/// The `i`-th extremum of `P_n` inside `(-1, 1)`, from the right: Newton's method on `P_n'`, whose
/// derivative Legendre's equation gives, from a Chebyshev point.
fn extremum(n: usize, i: usize) -> f64 {
    if 2 * i == n {
        return 0.0;
    }
    let mut x = (PI * i as f64 / n as f64).cos();
    for _ in 0..12 {
        let (value, slope) = legendre(n, x);
        let bend = (2.0 * x * slope - (n * (n + 1)) as f64 * value) / (1.0 - x * x);
        x -= slope / bend;
    }
    x
}

/// `P_n(x)` and its derivative by the three-term recurrence.
fn legendre(n: usize, x: f64) -> (f64, f64) {
    let (mut previous, mut value) = (1.0, x);
    for k in 2..=n {
        let k = k as f64;
        (previous, value) = (value, ((2.0 * k - 1.0) * x * value - (k - 1.0) * previous) / k);
    }
    (value, n as f64 * (x * value - previous) / (x * x - 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rule_integrates_monomials_up_to_twice_its_size() {
        for rule in GaussRule::all() {
            let n = rule.len();
            for power in 0..2 * n {
                let sum: f64 =
                    rule.points.iter().zip(&rule.weights).map(|(x, w)| w * x.powi(power as i32)).sum();
                let exact = if power % 2 == 0 { 2.0 / (power as f64 + 1.0) } else { 0.0 };
                // Round-off of a sum of at most 16 terms of size one; weights carry a few units in
                // the last place.
                assert!((sum - exact).abs() < 2e-14, "n = {n}, power {power}: {sum} against {exact}");
            }
        }
    }

    #[test]
    fn rule_fails_at_the_first_degree_beyond_its_exactness() {
        for rule in GaussRule::all().iter().take(8) {
            let power = 2 * rule.len();
            let sum: f64 = rule.points.iter().zip(&rule.weights).map(|(x, w)| w * x.powi(power as i32)).sum();
            assert!((sum - 2.0 / (power as f64 + 1.0)).abs() > 1e-6);
        }
    }

    #[test]
    fn lobatto_rules_have_both_ends_and_integrate_up_to_twice_their_size_less_three() {
        for n in 2..=MAX_GAUSS {
            let rule = LobattoRule::new(n);
            assert!(rule.points.windows(2).all(|w| w[0] < w[1]) && rule.weights.iter().all(|w| *w > 0.0));
            assert!(
                rule.points[0].to_bits() == (-1.0_f64).to_bits()
                    && rule.points[n - 1].to_bits() == 1.0_f64.to_bits()
            );
            for power in 0..=2 * n - 2 {
                let sum: f64 =
                    rule.points.iter().zip(&rule.weights).map(|(x, w)| w * x.powi(power as i32)).sum();
                let exact = if power % 2 == 0 { 2.0 / (power as f64 + 1.0) } else { 0.0 };
                // Round-off as above; the first degree beyond is missed by far more for the small
                // rules.
                let is_exact = (sum - exact).abs() < 2e-14;
                assert!(is_exact || power == 2 * n - 2, "n = {n}, power {power}: {sum} against {exact}");
                assert!(!(is_exact && power == 2 * n - 2 && n <= 8), "n = {n} is exact beyond its degree");
            }
        }
    }

    #[test]
    fn points_rise_and_are_symmetric() {
        for rule in GaussRule::all() {
            let n = rule.len();
            assert!(rule.points.windows(2).all(|w| w[0] < w[1]));
            assert!(
                (0..n).all(
                    |i| rule.points[i].to_bits() == (-rule.points[n - 1 - i]).to_bits() || 2 * i + 1 == n
                )
            );
            assert!(rule.points[0] > -1.0 && rule.weights.iter().all(|&w| w > 0.0));
        }
    }
}
