//! Rational Bézier pieces with one or two parameters in `[0, 1]`: evaluation and interpolation (theory Eq. C.27).
//!
//! A curve is a piece whose second degree is zero, so that one code serves plane, axisymmetric and solid models.

use iga_core::knots::MAX_DEGREE;
use nalgebra::Vector3;

const W: usize = MAX_DEGREE + 1;

/// Homogeneous point `(w x, w y, w z, w)`.
pub(super) type Homogeneous = [f64; 4];

/// Position on a piece with first and second derivatives; second ones in the order 00, 01, 11.
#[derive(Debug, Clone, Copy)]
pub(super) struct PieceJet {
    pub point: Vector3<f64>,
    pub first: [Vector3<f64>; 2],
    pub second: [Vector3<f64>; 3],
}

/// Bernstein polynomials of degree `p` at `s` with two derivatives: `out[k][i]`.
///
/// The row of degree `d + 1` is a mean of shifted rows of degree `d`; derivatives are differences of lower rows.
fn bernstein(p: usize, s: f64) -> [[f64; W]; 3] {
    let mut out = [[0.0; W]; 3];
    if p == 0 {
        out[0][0] = 1.0;
        return out;
    }
    // Two zeros ahead of the row and behind it, so that differences need no special ends.
    let mut row = [0.0; W + 4];
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

/// Point and derivatives of a piece at `s`.
pub(super) fn jet(degrees: [usize; 2], net: &[Homogeneous], s: [f64; 2]) -> PieceJet {
    let (a, b) = (bernstein(degrees[0], s[0]), bernstein(degrees[1], s[1]));
    let n = degrees[0] + 1;
    // Homogeneous sums: value, 0, 1, 00, 01, 11.
    let mut sums = [[0.0; 4]; 6];
    for (j, row) in net.chunks_exact(n).enumerate() {
        let mut along = [[0.0; 4]; 3];
        for (i, h) in row.iter().enumerate() {
            for (line, a) in along.iter_mut().zip(&a) {
                for c in 0..4 {
                    line[c] += a[i] * h[c];
                }
            }
        }
        for c in 0..4 {
            sums[0][c] += b[0][j] * along[0][c];
            sums[1][c] += b[0][j] * along[1][c];
            sums[2][c] += b[1][j] * along[0][c];
            sums[3][c] += b[0][j] * along[2][c];
            sums[4][c] += b[1][j] * along[1][c];
            sums[5][c] += b[2][j] * along[0][c];
        }
    }
    let inverse = 1.0 / sums[0][3];
    let vector = |h: &Homogeneous| Vector3::new(h[0], h[1], h[2]);
    let point = vector(&sums[0]) * inverse;
    let first = [1, 2].map(|k| (vector(&sums[k]) - point * sums[k][3]) * inverse);
    let second = [(3, 0, 0), (4, 0, 1), (5, 1, 1)].map(|(k, d, e)| {
        let cross = first[d] * sums[1 + e][3] + first[e] * sums[1 + d][3];
        (vector(&sums[k]) - cross - point * sums[k][3]) * inverse
    });
    PieceJet { point, first, second }
}

/// Interpolation of polynomials of degree `p` at `p + 1` nodes, both ends among them.
#[derive(Debug, Clone)]
pub(super) struct Interpolation {
    /// Nodes in `[0, 1]`.
    pub nodes: Vec<f64>,
    /// Bernstein coefficients from values at the nodes, row by row.
    inverse: Vec<f64>,
}

impl Interpolation {
    /// Chebyshev nodes of the second kind; the only one of degree 0 is 0.
    pub fn new(p: usize) -> Self {
        let n = p + 1;
        let nodes: Vec<f64> = (0..n)
            .map(
                |i| if p == 0 { 0.0 } else { 0.5 - 0.5 * (std::f64::consts::PI * i as f64 / p as f64).cos() },
            )
            .collect();
        let matrix = faer::Mat::from_fn(n, n, |i, j| bernstein(p, nodes[i])[0][j]);
        let mut identity = faer::Mat::<f64>::identity(n, n);
        faer::linalg::solvers::Solve::solve_in_place(&matrix.partial_piv_lu(), identity.as_mut());
        let inverse = (0..n * n).map(|k| identity[(k / n, k % n)]).collect();
        Self { nodes, inverse }
    }

    /// Coefficient `i` as weights of the values at the nodes.
    pub fn row(&self, i: usize) -> &[f64] {
        let n = self.nodes.len();
        &self.inverse[i * n..(i + 1) * n]
    }
}

/// Bernstein coefficients of a tensor-product polynomial from its values at the nodes, first direction fastest.
pub(super) fn coefficients(rules: [&Interpolation; 2], values: &[f64], out: &mut Vec<f64>) {
    let n = rules.map(|r| r.nodes.len());
    out.clear();
    for j in 0..n[1] {
        for i in 0..n[0] {
            let mut sum = 0.0;
            for (line, b) in values.chunks_exact(n[0]).zip(rules[1].row(j)) {
                sum += b * line.iter().zip(rules[0].row(i)).map(|(v, a)| v * a).sum::<f64>();
            }
            out.push(sum);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A rational bicubic-quadratic piece.
    fn net() -> Vec<Homogeneous> {
        (0..12)
            .map(|k| {
                let (i, j, w) = ((k % 4) as f64, (k / 4) as f64, 1.0 + 0.1 * ((k * 7) % 5) as f64);
                [w * i, w * (j + 0.1 * i * i), w * (0.3 * i * j - 0.2 * j * j), w]
            })
            .collect()
    }

    #[test]
    fn derivatives_agree_with_differences() {
        let (net, degrees, h) = (net(), [3, 2], 1e-5);
        let s = [0.3, 0.7];
        let here = jet(degrees, &net, s);
        for d in 0..2 {
            let moved = |by: f64| {
                let mut s = s;
                s[d] += by;
                jet(degrees, &net, s)
            };
            let (low, high) = (moved(-h), moved(h));
            // Central differences: h^2 times third derivatives of order 10.
            let limit = 1e-8;
            assert!(((high.point - low.point) / (2.0 * h) - here.first[d]).norm() < limit);
            for e in 0..2 {
                let slope = (high.first[e] - low.first[e]) / (2.0 * h);
                assert!((slope - here.second[d + e]).norm() < limit);
            }
        }
    }

    #[test]
    fn interpolation_returns_the_coefficients_of_every_degree() {
        for p in 0..=MAX_DEGREE {
            let (a, b) = (Interpolation::new(p), Interpolation::new(2));
            let given: Vec<f64> = (0..(p + 1) * 3).map(|k| ((k * 5 + 2) % 7) as f64).collect();
            let mut values = Vec::new();
            for t in &b.nodes {
                for s in &a.nodes {
                    let (x, y) = (bernstein(p, *s)[0], bernstein(2, *t)[0]);
                    values.push((0..given.len()).map(|k| given[k] * x[k % (p + 1)] * y[k / (p + 1)]).sum());
                }
            }
            let mut found = Vec::new();
            coefficients([&a, &b], &values, &mut found);
            for (f, g) in found.iter().zip(&given) {
                // Condition of the Bernstein basis of degree 9 is below 1e4.
                assert!((f - g).abs() < 1e-11, "{p}");
            }
        }
    }
}
