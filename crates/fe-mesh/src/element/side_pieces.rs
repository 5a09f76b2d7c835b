//! Sides cut into pieces, on which their functions are Bernstein polynomials.
//!
//! A triangle is cut through its centroid and the middles of its edges into three quadrilaterals, a
//! quadrilateral through its centre into four: one at each corner. With the bilinear map of the
//! unit square to such a piece, functions of degree `p` in the parameters of the side have the
//! degree `p` in each direction of the square, so that nothing is lost. A curve is cut into halves,
//! whose functions have degree zero in the second direction.

use crate::element::kind::SideKind;
use crate::element::shape::Functions;

/// A quadrilateral of a side: the unit square under a bilinear map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SidePiece {
    /// Parameters of the side at the places (0, 0), (1, 0), (1, 1) and (0, 1) of the square; the
    /// first is a corner of the side, the third its centroid. They turn as the corners of the side
    /// do.
    pub corners: [[f64; 2]; 4],
}

impl SidePiece {
    /// Parameters of the side at the place `s` of the square.
    pub fn parameters(&self, [s, t]: [f64; 2]) -> [f64; 2] {
        let weights = [(1.0 - s) * (1.0 - t), s * (1.0 - t), s * t, (1.0 - s) * t];
        [0, 1].map(|d| weights.iter().zip(&self.corners).map(|(w, c)| w * c[d]).sum())
    }
}

impl SideKind {
    /// Degrees of the functions of a side in the directions of its pieces.
    pub fn degrees(self) -> [usize; 2] {
        match self {
            Self::Line2 => [1, 0],
            Self::Line3 => [2, 0],
            Self::Tri3 | Self::Quad4 => [1; 2],
            Self::Tri6 | Self::Quad8 | Self::Quad9 => [2; 2],
        }
    }

    /// The pieces of a side, one at each corner, in the order of the corners.
    pub fn pieces(self) -> Vec<SidePiece> {
        let n = self.n_corners();
        if self.is_curve() {
            let half = |a: f64, b: f64| SidePiece { corners: [[a, 0.0], [b, 0.0], [b, 1.0], [a, 1.0]] };
            return vec![half(-1.0, 0.0), half(0.0, 1.0)];
        }
        let corners = &self.node_parameters()[..n];
        let middle = |a: [f64; 2], b: [f64; 2]| [0, 1].map(|d| 0.5 * (a[d] + b[d]));
        let centre = [0, 1].map(|d| corners.iter().map(|c| c[d]).sum::<f64>() / n as f64);
        let piece = |k: usize| {
            let (before, here, after) = (corners[(k + n - 1) % n], corners[k], corners[(k + 1) % n]);
            SidePiece { corners: [here, middle(here, after), centre, middle(before, here)] }
        };
        (0..n).map(piece).collect()
    }

    /// Bernstein coefficients of the side's functions on `piece`, a row per node, the first
    /// direction fastest.
    pub fn bernstein(self, piece: &SidePiece) -> Vec<Vec<f64>> {
        let [p, q] = self.degrees();
        let mut functions = Functions::default();
        let mut samples = vec![Vec::with_capacity((p + 1) * (q + 1)); self.n_nodes()];
        for j in 0..=q {
            for i in 0..=p {
                let at = [i as f64 / p as f64, j as f64 / q.max(1) as f64];
                self.functions(&piece.parameters(at), &mut functions);
                samples.iter_mut().zip(&functions.values).for_each(|(row, value)| row.push(*value));
            }
        }
        if p == 2 {
            samples.iter_mut().for_each(|row| interpolate(row, q));
        }
        samples
    }
}

/// Bernstein coefficients, quadratic in the first direction and of degree `q` in the second, from the
/// values at ends and middles: the middle one is `2 f(1/2) - (f(0) + f(1))/2`.
fn interpolate(values: &mut [f64], q: usize) {
    let line = |values: &mut [f64], [a, b, c]: [usize; 3]| {
        values[b] = 2.0 * values[b] - 0.5 * (values[a] + values[c]);
    };
    (0..=q).for_each(|j| line(values, [3 * j, 3 * j + 1, 3 * j + 2]));
    if q == 2 {
        (0..3).for_each(|i| line(values, [i, 3 + i, 6 + i]));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values of the Bernstein polynomials of degree `p` at `t`.
    fn polynomials(p: usize, t: f64) -> Vec<f64> {
        let u = 1.0 - t;
        match p {
            0 => vec![1.0],
            1 => vec![u, t],
            _ => vec![u * u, 2.0 * u * t, t * t],
        }
    }

    #[test]
    fn pieces_carry_the_functions_of_their_side_exactly() {
        for kind in SideKind::ALL {
            let [p, q] = kind.degrees();
            for piece in kind.pieces() {
                let rows = kind.bernstein(&piece);
                for s in [[0.0, 0.0], [0.3, 0.8], [1.0, 0.1], [0.61, 0.07]] {
                    let mut functions = Functions::default();
                    kind.functions(&piece.parameters(s), &mut functions);
                    let [u, v] = [polynomials(p, s[0]), polynomials(q, s[1])];
                    for (row, value) in rows.iter().zip(&functions.values) {
                        let terms = row.iter().enumerate().map(|(k, c)| c * u[k % (p + 1)] * v[k / (p + 1)]);
                        // A sum of nine terms of order one.
                        assert!((terms.sum::<f64>() - value).abs() < 1e-14, "{kind:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn pieces_cover_their_side_once_and_turn_as_it_does() {
        for kind in SideKind::ALL {
            let area = |p: SidePiece| -> f64 {
                let c = p.corners;
                (0..4).map(|i| 0.5 * (c[i][0] * c[(i + 1) % 4][1] - c[(i + 1) % 4][0] * c[i][1])).sum()
            };
            let areas: Vec<f64> = kind.pieces().into_iter().map(area).collect();
            let whole = [2.0, 0.5, 4.0][kind.n_corners() - 2];
            assert!(areas.iter().all(|a| *a > 0.0), "{kind:?}");
            // Round-off of a dozen products.
            assert!((areas.iter().sum::<f64>() - whole).abs() < 1e-14, "{kind:?}");
        }
    }
}
