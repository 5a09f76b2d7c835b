//! Rotation vectors and their rates (docs/theory.md Eq. M.5, M.6).
//!
//! The rotation `exp(ϑ~)` of a rotation vector that moves at `ϑ'` has the angular velocity
//! `J(ϑ) ϑ'` in the frame that it rotates into, with `J = E + a ϑ~ + b ϑ~²`,
//! `a = (1 - cos θ) / θ²`, `b = (θ - sin θ) / θ³`.

use nalgebra::{Matrix3, Vector3};

use super::skew;

/// Terms of the series below `θ² = 1`; the first one left out is 1 / 22! of the first.
const N_TERMS: usize = 9;
/// `(-1)^k / (2 k + 2)!` and `(-1)^k / (2 k + 3)!`.
const SERIES: [[f64; N_TERMS]; 2] = [series(2), series(3)];

const fn series(first: usize) -> [f64; N_TERMS] {
    let mut terms = [0.0; N_TERMS];
    let mut factorial = if first == 2 { 2.0 } else { 6.0 };
    let mut sign = 1.0;
    let mut k = 0;
    while k < N_TERMS {
        terms[k] = sign / factorial;
        sign = -sign;
        factorial *= ((2 * k + first + 1) * (2 * k + first + 2)) as f64;
        k += 1;
    }
    terms
}

/// A power series and its derivative.
fn polynomial(terms: &[f64; N_TERMS], x: f64) -> (f64, f64) {
    terms.iter().rev().fold((0.0, 0.0), |(value, slope), c| (value * x + c, slope * x + value))
}

/// `a`, `b`, and their derivatives by `θ`, divided by `θ`.
fn coefficients(x: f64) -> [f64; 4] {
    if x < 1.0 {
        let (a, a_slope) = polynomial(&SERIES[0], x);
        let (b, b_slope) = polynomial(&SERIES[1], x);
        return [a, b, 2.0 * a_slope, 2.0 * b_slope];
    }
    let theta = x.sqrt();
    let (sin, cos) = theta.sin_cos();
    let (a, b) = ((1.0 - cos) / x, (theta - sin) / (x * theta));
    [a, b, (sin / theta - 2.0 * a) / x, (a - 3.0 * b) / x]
}

/// Angular velocity of a rotation vector in motion, and what its acceleration has beyond `J ϑ''`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RotationVectorRates {
    /// `J(ϑ)`.
    pub jacobian: Matrix3<f64>,
    /// Angular velocity `J ϑ'`.
    pub spin: Vector3<f64>,
    /// `J' ϑ'`.
    pub bias: Vector3<f64>,
}

impl RotationVectorRates {
    /// Rates of the rotation whose vector `vector` changes at `rate` (Eq. M.5, M.6).
    pub fn new(vector: &Vector3<f64>, rate: &Vector3<f64>) -> Self {
        let [a, b, a_slope, b_slope] = coefficients(vector.norm_squared());
        let tilde = skew(vector);
        let first = vector.cross(rate);
        let second = vector.cross(&first);
        let stretch = vector.dot(rate);
        Self {
            jacobian: Matrix3::identity() + tilde * a + tilde * tilde * b,
            spin: rate + first * a + second * b,
            bias: first * (a_slope * stretch) + second * (b_slope * stretch) + rate.cross(&first) * b,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::UnitQuaternion;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn spin_and_bias_are_derivatives_of_the_exponential(
            vector in prop::array::uniform3(-1.2..1.2f64),
            rate in prop::array::uniform3(-2.0..2.0f64),
        ) {
            let (vector, rate) = (Vector3::from(vector), Vector3::from(rate));
            let at = |t: f64| UnitQuaternion::from_scaled_axis(vector + rate * t);
            // Central differences of step 1e-5: truncation of order h² times rates of order 10,
            // round-off eps / h.
            let h = 1e-5;
            let turned = (at(h) * at(-h).inverse()).scaled_axis() / (2.0 * h);
            let rates = RotationVectorRates::new(&vector, &rate);
            prop_assert!((turned - rates.spin).norm() < 1e-8);
            prop_assert!((rates.jacobian * rate - rates.spin).norm() < 1e-13); // round-off
            let ends = [-h, h].map(|t| RotationVectorRates::new(&(vector + rate * t), &rate).spin);
            prop_assert!(((ends[1] - ends[0]) / (2.0 * h) - rates.bias).norm() < 1e-7);
        }
    }

    #[test]
    fn series_meets_the_closed_form() {
        let (below, above) = (coefficients(1.0 - 1e-12), coefficients(1.0));
        for (series, closed) in below.iter().zip(above) {
            assert!((series - closed).abs() < 1e-12); // distance of the two arguments
        }
    }
}
