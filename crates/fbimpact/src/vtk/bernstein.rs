//! Between values at equally spaced points of an element and its Bernstein coefficients, direction by direction.

use nalgebra::DMatrix;

/// Values of the Bernstein polynomials of degree `degree` at `points + 1` equally spaced points, a row a point.
pub fn values(degree: usize, points: usize) -> DMatrix<f64> {
    inset_values(degree, points, 0.0)
}

/// The same at points of which the outermost lie `inset` inside of the ends.
fn inset_values(degree: usize, points: usize, inset: f64) -> DMatrix<f64> {
    DMatrix::from_fn(points + 1, degree + 1, |row, k| {
        let x = inset_point(row, points, inset);
        binomial(degree, k) * x.powi(k as i32) * (1.0 - x).powi((degree - k) as i32)
    })
}

/// Coefficients from the values at `degree + 1` equally spaced points: the inverse of [`values`].
///
/// # Panics
/// Never: Bernstein polynomials are independent.
pub fn coefficients(degree: usize) -> DMatrix<f64> {
    values(degree, degree).try_inverse().expect("Bernstein polynomials are independent")
}

/// Point `i` of `0..=points` equally spaced ones, the first and the last `inset` inside of 0 and 1.
pub fn inset_point(i: usize, points: usize, inset: f64) -> f64 {
    inset + (1.0 - 2.0 * inset) * i as f64 / points.max(1) as f64
}

/// Values at `points + 1` equally spaced points from values at as many that are inset: one polynomial goes through both.
///
/// # Panics
/// Never: Bernstein polynomials are independent.
pub fn extrapolation(points: usize, inset: f64) -> DMatrix<f64> {
    let inner = inset_values(points, points, inset);
    values(points, points) * inner.try_inverse().expect("Bernstein polynomials are independent")
}

fn binomial(n: usize, k: usize) -> f64 {
    (1..=k).fold(1.0, |c, i| c * (n + 1 - i) as f64 / i as f64)
}

/// Applies one matrix a direction to a net of `net`, whose first direction runs fastest.
///
/// # Panics
/// If the net does not have as many entries as the matrices have columns.
pub fn apply<const N: usize>(matrices: &[&DMatrix<f64>], net: &[[f64; N]]) -> Vec<[f64; N]> {
    assert_eq!(
        net.len(),
        matrices.iter().map(|m| m.ncols()).product::<usize>(),
        "net and matrices must agree"
    );
    let mut out = net.to_vec();
    let mut stride = 1;
    for m in matrices {
        let mut next = Vec::with_capacity(out.len() / m.ncols() * m.nrows());
        for slab in out.chunks_exact(stride * m.ncols()) {
            for row in 0..m.nrows() {
                for offset in 0..stride {
                    let mut sum = [0.0; N];
                    for k in 0..m.ncols() {
                        let from = &slab[k * stride + offset];
                        sum.iter_mut().zip(from).for_each(|(s, v)| *s += m[(row, k)] * v);
                    }
                    next.push(sum);
                }
            }
        }
        out = next;
        stride *= m.nrows();
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coefficients_and_values_are_inverse() {
        let net: Vec<[f64; 2]> = (0..60).map(|i| [f64::from(i).sin(), f64::from(i * i).cos()]).collect();
        let (to, from) = ([2, 3, 4].map(|p| values(p, p)), [2, 3, 4].map(coefficients));
        let there = apply(&to.each_ref(), &net);
        let back = apply(&from.each_ref(), &there);
        for (a, b) in net.iter().flatten().zip(back.iter().flatten()) {
            // The inverse of degree 4 multiplies round-off by less than 100.
            assert!((a - b).abs() < 1e-13);
        }
    }

    #[test]
    fn extrapolation_is_exact_for_polynomials_of_its_degree() {
        let field = |x: f64| 3.0 - x + 2.0 * x * x - 7.0 * x.powi(3);
        let inner: Vec<[f64; 1]> = (0..4).map(|i| [field(inset_point(i, 3, 0.1))]).collect();
        for (i, value) in apply(&[&extrapolation(3, 0.1)], &inner).iter().enumerate() {
            assert!((value[0] - field(i as f64 / 3.0)).abs() < 1e-13);
        }
    }

    #[test]
    fn bernstein_polynomials_sum_to_one_and_reproduce_lines() {
        let v = values(5, 7);
        for row in 0..8 {
            let sum: f64 = v.row(row).sum();
            let line: f64 = (0..6).map(|k| v[(row, k)] * k as f64 / 5.0).sum();
            assert!((sum - 1.0).abs() < 1e-15 && (line - row as f64 / 7.0).abs() < 1e-15);
        }
    }
}
