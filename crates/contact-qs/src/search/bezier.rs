//! Rational Bézier pieces with one or two parameters in `[0, 1]`: evaluation (theory Eq. C.27).
//!
//! A curve is a piece whose second degree is zero, so that one code serves plane, axisymmetric and
//! solid models.

use iga_core::splines::bernstein::table;
use nalgebra::Vector3;

/// Homogeneous point `(w x, w y, w z, w)`.
pub(super) type Homogeneous = [f64; 4];

/// Position on a piece with first and second derivatives; second ones in the order 00, 01, 11.
#[derive(Debug, Clone, Copy)]
pub(super) struct PieceJet {
    pub point: Vector3<f64>,
    pub first: [Vector3<f64>; 2],
    pub second: [Vector3<f64>; 3],
}

/// Point and derivatives of a piece at `s`.
pub(super) fn jet(degrees: [usize; 2], net: &[Homogeneous], s: [f64; 2]) -> PieceJet {
    let (a, b) = (table(degrees[0], s[0]), table(degrees[1], s[1]));
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
}
