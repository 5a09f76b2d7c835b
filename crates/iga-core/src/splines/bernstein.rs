//! Bernstein polynomials: values with derivatives, and the coefficients of polynomials known at
//! some points (theory Eqs. C.27, C.37).

use faer::Mat;
use faer::linalg::solvers::Solve;

use crate::splines::knots::MAX_DEGREE;

/// Longest list of Bernstein polynomials of one degree.
pub const MAX_ORDER: usize = MAX_DEGREE + 1;

/// Values, first and second derivatives of the Bernstein polynomials of one degree.
pub type Table = [[f64; MAX_ORDER]; 3];

/// Bernstein polynomials of degree `p` at `s` in `[0, 1]` with two derivatives: `out[k][i]`; zeros
/// beyond `i = p`.
///
/// The row of degree `d + 1` is a mean of shifted rows of degree `d`; derivatives are differences
/// of lower rows.
pub fn table(p: usize, s: f64) -> Table {
    let mut out = [[0.0; MAX_ORDER]; 3];
    if p == 0 {
        out[0][0] = 1.0;
        return out;
    }
    // Two zeros ahead of the row and behind it, so that differences need no special ends.
    let mut row = [0.0; MAX_ORDER + 4];
    row[2] = 1.0;
    let (n, t) = (p as f64, 1.0 - s);
    for d in 0..p - 1 {
        if d + 2 == p {
            let scale = n * (n - 1.0);
            for (slot, r) in out[2].iter_mut().zip(row.windows(3)).take(p + 1) {
                *slot = scale * (r[0] - 2.0 * r[1] + r[2]);
            }
        }
        for i in (2..d + 4).rev() {
            row[i] = t * row[i] + s * row[i - 1];
        }
    }
    let [values, slopes, _] = &mut out;
    for ((value, slope), r) in values.iter_mut().zip(slopes).zip(row[1..].windows(2)).take(p + 1) {
        *value = t * r[1] + s * r[0];
        *slope = n * (r[0] - r[1]);
    }
    out
}

/// Values of the Bernstein polynomials of degree `p`, which may be any, at `points` in `[0, 1]`: a
/// row for each point.
pub fn values(p: usize, points: &[f64]) -> Mat<f64> {
    let mut all = Mat::zeros(points.len(), p + 1);
    let mut row = vec![0.0; p + 1];
    for (k, &s) in points.iter().enumerate() {
        row.fill(0.0);
        row[0] = 1.0;
        for d in 0..p {
            for i in (0..=d + 1).rev() {
                let before = if i > 0 { row[i - 1] } else { 0.0 };
                row[i] = (1.0 - s) * row[i] + s * before;
            }
        }
        row.iter().enumerate().for_each(|(i, value)| all[(k, i)] = *value);
    }
    all
}

/// Coefficients of a polynomial of degree `points.len() - 1` from its values at `points`, which
/// differ: the inverse of [`values`].
pub fn coefficients(points: &[f64]) -> Mat<f64> {
    let n = points.len();
    let mut inverse = Mat::identity(n, n);
    values(n - 1, points).partial_piv_lu().solve_in_place(inverse.as_mut());
    inverse
}

/// Interpolation of polynomials of degree `p` at `p + 1` nodes, both ends among them.
#[derive(Debug, Clone)]
pub struct Interpolation {
    /// Nodes in `[0, 1]`: Chebyshev nodes of the second kind; the only one of degree 0 is 0.
    pub nodes: Vec<f64>,
    /// Takes the values at the nodes to Bernstein coefficients.
    pub coefficients: Mat<f64>,
}

impl Interpolation {
    /// The nodes of degree `p`.
    pub fn new(p: usize) -> Self {
        let node = |i: usize| {
            if p == 0 { 0.0 } else { 0.5 - 0.5 * (std::f64::consts::PI * i as f64 / p as f64).cos() }
        };
        let nodes: Vec<f64> = (0..=p).map(node).collect();
        let coefficients = coefficients(&nodes);
        Self { nodes, coefficients }
    }
}

/// Applies one matrix for each direction to a net of entries, whose first direction runs fastest.
///
/// # Panics
/// If the net does not have as many entries as the matrices have columns.
pub fn apply<const N: usize>(matrices: &[&Mat<f64>], net: &[[f64; N]]) -> Vec<[f64; N]> {
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
    fn derivatives_are_those_of_the_polynomials() {
        for p in 1..=5 {
            let (s, h) = (0.37, 1e-6);
            let (low, here, high) = (table(p, s - h), table(p, s), table(p, s + h));
            assert!((here[0].iter().sum::<f64>() - 1.0).abs() < 1e-15); // round-off
            for order in 0..2 {
                for i in 0..=p {
                    let slope = (high[order][i] - low[order][i]) / (2.0 * h);
                    // Central differences: p³ h² and eps / h.
                    assert!((slope - here[order + 1][i]).abs() < 1e-8, "{p} {order} {i}");
                }
            }
        }
    }

    #[test]
    fn tables_and_matrices_have_the_same_values() {
        for p in 0..=MAX_DEGREE {
            let points = [0.0, 0.2, 0.63, 1.0];
            let all = values(p, &points);
            for (k, s) in points.iter().enumerate() {
                let table = table(p, *s);
                assert!((0..=p).all(|i| (table[0][i] - all[(k, i)]).abs() < 1e-15)); // round-off
            }
        }
    }

    #[test]
    fn interpolation_returns_the_coefficients_of_every_degree() {
        for p in 0..=MAX_DEGREE {
            let rules = [Interpolation::new(p), Interpolation::new(2), Interpolation::new(1)];
            let given: Vec<[f64; 1]> = (0..(p + 1) * 6).map(|k| [((k * 5 + 2) % 7) as f64]).collect();
            let to = rules.each_ref().map(|r| values(r.nodes.len() - 1, &r.nodes));
            let at_nodes = apply(&to.each_ref(), &given);
            let found = apply(&rules.each_ref().map(|r| &r.coefficients), &at_nodes);
            for (f, g) in found.iter().zip(&given) {
                // Condition of the Bernstein basis of degree 9 is below 1e4.
                assert!((f[0] - g[0]).abs() < 1e-11, "{p}");
            }
        }
    }

    #[test]
    fn polynomials_sum_to_one_and_reproduce_lines() {
        let points: Vec<f64> = (0..8).map(|i| f64::from(i) / 7.0).collect();
        let v = values(5, &points);
        for (row, x) in points.iter().enumerate() {
            let sum: f64 = (0..6).map(|k| v[(row, k)]).sum();
            let line: f64 = (0..6).map(|k| v[(row, k)] * k as f64 / 5.0).sum();
            assert!((sum - 1.0).abs() < 1e-15 && (line - x).abs() < 1e-15);
        }
    }
}
