//! B-splines of an element of a level at a point, as products of one table for each direction.

use crate::nurbs::patch::{PointBasis, SECOND_DERIVATIVES};
use crate::splines::basis::basis_derivatives;
use crate::splines::knots::{KnotVector, MAX_DEGREE};

const ROW: usize = 3 * (MAX_DEGREE + 1);

/// One-dimensional tables of an evaluation.
struct Tables {
    values: [[f64; ROW]; 3],
    orders: [usize; 3],
    dimension: usize,
}

impl Tables {
    fn count(&self) -> usize {
        self.orders.iter().product()
    }

    /// Derivative of order `k[d]` in direction `d` of all tensor-product functions.
    fn product(&self, k: [usize; 3], mut put: impl FnMut(usize, f64)) {
        let line = |d: usize| &self.values[d][k[d] * self.orders[d]..(k[d] + 1) * self.orders[d]];
        let (mut at, lines) = (0, [line(0), line(1), line(2)]);
        for c in lines[2] {
            for b in lines[1] {
                let bc = b * c;
                for a in lines[0] {
                    put(at, a * bc);
                    at += 1;
                }
            }
        }
    }

    /// Fills the lists with the tensor-product functions.
    fn fill(&self, n_derivatives: usize, out: &mut PointBasis) {
        self.product([0; 3], |i, v| out.values[i] = v);
        for d in 0..if n_derivatives >= 1 { self.dimension } else { 0 } {
            let order = std::array::from_fn(|k| usize::from(k == d));
            self.product(order, |i, v| out.first[i][d] = v);
        }
        for (s, &(a, b)) in SECOND_DERIVATIVES.iter().enumerate() {
            if n_derivatives >= 2 && b < self.dimension {
                let order = std::array::from_fn(|k| usize::from(k == a) + usize::from(k == b));
                self.product(order, |i, v| out.second[i][s] = v);
            }
        }
    }
}

/// B-splines of element `index` of a level with `knots` at `xi`, with derivatives up to
/// `n_derivatives <= 2`; lists that are not asked for are empty.
pub(super) fn evaluate_level(
    knots: &[KnotVector],
    index: [usize; 3],
    xi: &[f64; 3],
    n_derivatives: usize,
    out: &mut PointBasis,
) {
    debug_assert!(n_derivatives <= 2);
    let mut tables = Tables { values: [[0.0; ROW]; 3], orders: [1; 3], dimension: knots.len() };
    for table in &mut tables.values {
        table[0] = 1.0; // absent directions: the constant function
    }
    for (d, k) in knots.iter().enumerate() {
        tables.orders[d] = k.degree() + 1;
        basis_derivatives(k, index[d], xi[d], n_derivatives, &mut tables.values[d]);
    }
    resize(out, tables.count(), n_derivatives);
    tables.fill(n_derivatives, out);
}

/// Resizes the lists that are asked for and empties the others.
fn resize(out: &mut PointBasis, n: usize, n_derivatives: usize) {
    out.values.clear();
    out.first.clear();
    out.second.clear();
    out.values.resize(n, 0.0);
    out.first.resize(if n_derivatives >= 1 { n } else { 0 }, [0.0; 3]);
    out.second.resize(if n_derivatives >= 2 { n } else { 0 }, [0.0; 6]);
}

/// Multiplies every function by its weight.
pub(super) fn scale(out: &mut PointBasis, weights: impl Iterator<Item = f64>) {
    for (i, w) in weights.enumerate() {
        out.values[i] *= w;
        out.first.get_mut(i).into_iter().flatten().for_each(|v| *v *= w);
        out.second.get_mut(i).into_iter().flatten().for_each(|v| *v *= w);
    }
}
