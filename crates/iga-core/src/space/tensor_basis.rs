//! Rational functions of an element on a tensor grid, from tables of one direction each.

use super::GridBasis;
use crate::quadrature::MAX_GAUSS;
use crate::splines::basis::basis_derivatives;
use crate::splines::knots::{KnotVector, MAX_DEGREE};

/// Values and first derivatives of the one-dimensional functions at one grid coordinate.
const ROW: usize = 2 * (MAX_DEGREE + 1);

/// One-dimensional tables of one direction.
struct Table {
    order: usize,
    rows: [[f64; ROW]; MAX_GAUSS],
}

impl Table {
    fn values(&self, q: usize) -> (&[f64], &[f64]) {
        self.rows[q][..2 * self.order].split_at(self.order)
    }
}

/// Weights of the functions of an element: that of the first one first, and how far the next one in
/// each direction is from it.
pub(crate) struct LocalWeights<'a> {
    /// The weights from that of the first function on.
    pub weights: &'a [f64],
    /// Distance of neighbours in each direction.
    pub strides: [usize; 3],
}

/// Rational basis of element `index` of a net with `knots` on a tensor grid: products of
/// one-dimensional tables, then division by the weight function (theory Eq. S.4).
pub(crate) fn evaluate_tensor(
    knots: &[KnotVector],
    index: [usize; 3],
    local: &LocalWeights<'_>,
    grid: [&[f64]; 3],
    out: &mut GridBasis,
) {
    let mut tables = [(); 3].map(|()| Table { order: 1, rows: [[1.0; ROW]; MAX_GAUSS] });
    for (d, k) in knots.iter().enumerate() {
        debug_assert!(grid[d].len() <= MAX_GAUSS);
        tables[d].order = k.degree() + 1;
        for (row, &u) in tables[d].rows.iter_mut().zip(grid[d]) {
            basis_derivatives(k, index[d], u, 1, row);
        }
    }
    let n = tables.iter().map(|t| t.order).product();
    out.resize(n, grid.iter().map(|g| g.len()).product());
    let mut q = 0;
    for q2 in 0..grid[2].len() {
        for q1 in 0..grid[1].len() {
            for q0 in 0..grid[0].len() {
                let at = q * n..(q + 1) * n;
                let [f0, f1, f2] = &mut out.first;
                let slots =
                    [&mut out.values[at.clone()], &mut f0[at.clone()], &mut f1[at.clone()], &mut f2[at]];
                weighted_products(&tables, [q0, q1, q2], local, slots);
                q += 1;
            }
        }
    }
    for q in 0..out.n_points {
        divide_by_weight(out, q, knots.len());
    }
}

/// `w N` and its parametric derivatives at one grid point.
fn weighted_products(
    tables: &[Table; 3],
    q: [usize; 3],
    local: &LocalWeights<'_>,
    [values, d0, d1, d2]: [&mut [f64]; 4],
) {
    let (n0, m0) = tables[0].values(q[0]);
    let (n1, m1) = tables[1].values(q[1]);
    let (n2, m2) = tables[2].values(q[2]);
    let order = n0.len();
    let mut start = 0;
    for k in 0..n2.len() {
        for j in 0..n1.len() {
            let (plain, along1, along2) = (n1[j] * n2[k], m1[j] * n2[k], n1[j] * m2[k]);
            let w = &local.weights[j * local.strides[1] + k * local.strides[2]..][..order];
            let row = start..start + order;
            let (v, a) = (&mut values[row.clone()], &mut d0[row.clone()]);
            let (b, c) = (&mut d1[row.clone()], &mut d2[row]);
            for i in 0..order {
                let wn = w[i] * n0[i];
                v[i] = wn * plain;
                a[i] = w[i] * m0[i] * plain;
                b[i] = wn * along1;
                c[i] = wn * along2;
            }
            start += order;
        }
    }
}

fn divide_by_weight(out: &mut GridBasis, q: usize, dimension: usize) {
    let at = q * out.n_active..(q + 1) * out.n_active;
    let values = &mut out.values[at.clone()];
    let inverse = 1.0 / values.iter().sum::<f64>();
    for v in values.iter_mut() {
        *v *= inverse;
    }
    for (d, first) in out.first.iter_mut().enumerate() {
        let first = &mut first[at.clone()];
        if d >= dimension {
            first.fill(0.0);
            continue;
        }
        let slope = first.iter().sum::<f64>();
        for (f, v) in first.iter_mut().zip(values.iter()) {
            *f = (*f - v * slope) * inverse;
        }
    }
}
