//! Sides cut into quadrilaterals, on which their functions are Bernstein polynomials.
//!
//! A triangle is cut through its centroid and the middles of its edges into three quadrilaterals, a
//! quadrilateral through its centre into four: one at each corner. With the bilinear map of the
//! unit square to such a piece, functions of degree `p` in the parameters of the side have the
//! degree `p` in each direction of the square, so that nothing is lost.

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
    /// Degree of the functions of a side in each direction of its pieces.
    pub fn degree(self) -> usize {
        match self {
            Self::Tri3 | Self::Quad4 => 1,
            Self::Tri6 | Self::Quad8 | Self::Quad9 => 2,
        }
    }

    /// The pieces of a side, one at each corner, in the order of the corners.
    pub fn pieces(self) -> Vec<SidePiece> {
        let n = self.n_corners();
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
        let p = self.degree();
        let mut functions = Functions::default();
        let mut samples = vec![Vec::with_capacity((p + 1) * (p + 1)); self.n_nodes()];
        for j in 0..=p {
            for i in 0..=p {
                let at = [i, j].map(|k| k as f64 / p as f64);
                self.functions(&piece.parameters(at), &mut functions);
                samples.iter_mut().zip(&functions.values).for_each(|(row, value)| row.push(*value));
            }
        }
        if p == 2 {
            samples.iter_mut().for_each(|row| interpolate(row));
        }
        samples
    }
}

/// Biquadratic Bernstein coefficients from the values at ends and middles: the middle one is
/// `2 f(1/2) - (f(0) + f(1))/2`.
fn interpolate(values: &mut [f64]) {
    let line = |values: &mut [f64], [a, b, c]: [usize; 3]| {
        values[b] = 2.0 * values[b] - 0.5 * (values[a] + values[c]);
    };
    (0..3).for_each(|j| line(values, [3 * j, 3 * j + 1, 3 * j + 2]));
    (0..3).for_each(|i| line(values, [i, 3 + i, 6 + i]));
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values of the Bernstein polynomials of degree `p` at `t`.
    fn polynomials(p: usize, t: f64) -> Vec<f64> {
        let u = 1.0 - t;
        if p == 1 { vec![u, t] } else { vec![u * u, 2.0 * u * t, t * t] }
    }

    #[test]
    fn pieces_carry_the_functions_of_their_side_exactly() {
        for kind in SideKind::ALL {
            let p = kind.degree();
            for piece in kind.pieces() {
                let rows = kind.bernstein(&piece);
                for s in [[0.0, 0.0], [0.3, 0.8], [1.0, 0.1], [0.61, 0.07]] {
                    let mut functions = Functions::default();
                    kind.functions(&piece.parameters(s), &mut functions);
                    let [u, v] = s.map(|t| polynomials(p, t));
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
            let whole = if kind.n_corners() == 3 { 0.5 } else { 4.0 };
            assert!(areas.iter().all(|a| *a > 0.0), "{kind:?}");
            // Round-off of a dozen products.
            assert!((areas.iter().sum::<f64>() - whole).abs() < 1e-14, "{kind:?}");
        }
    }
}
