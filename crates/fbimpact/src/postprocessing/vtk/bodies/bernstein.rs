//! Bernstein polynomials at the equally spaced points of a cell.

use faer::Mat;
use iga_core::splines::bernstein;

/// Values of the Bernstein polynomials of degree `degree` at `points + 1` equally spaced points, a
/// row for each point.
pub fn values(degree: usize, points: usize) -> Mat<f64> {
    bernstein::values(degree, &inset_points(points, 0.0))
}

/// Coefficients from the values at `degree + 1` equally spaced points: the inverse of [`values`].
pub fn coefficients(degree: usize) -> Mat<f64> {
    bernstein::coefficients(&inset_points(degree, 0.0))
}

/// Point `i` of `0..=points` equally spaced ones, the first and the last `inset` inside of 0 and 1.
pub fn inset_point(i: usize, points: usize, inset: f64) -> f64 {
    inset + (1.0 - 2.0 * inset) * i as f64 / points.max(1) as f64
}

fn inset_points(points: usize, inset: f64) -> Vec<f64> {
    (0..=points).map(|i| inset_point(i, points, inset)).collect()
}

/// Values at `points + 1` equally spaced points from values at as many that are inset: one
/// polynomial goes through both.
pub fn extrapolation(points: usize, inset: f64) -> Mat<f64> {
    values(points, points) * bernstein::coefficients(&inset_points(points, inset))
}

#[cfg(test)]
mod tests {
    use super::*;
    use iga_core::splines::bernstein::apply;

    #[test]
    fn extrapolation_is_exact_for_polynomials_of_its_degree() {
        let field = |x: f64| 3.0 - x + 2.0 * x * x - 7.0 * x.powi(3);
        let inner: Vec<[f64; 1]> = (0..4).map(|i| [field(inset_point(i, 3, 0.1))]).collect();
        for (i, value) in apply(&[&extrapolation(3, 0.1)], &inner).iter().enumerate() {
            assert!((value[0] - field(i as f64 / 3.0)).abs() < 1e-13);
        }
    }
}
