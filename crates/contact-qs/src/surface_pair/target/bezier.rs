//! Bernstein polynomials of one element of a target, and the fit of functions to them.
//!
//! [`iga_core::splines::bernstein`] has the same to round-off. Projections and the deformation of the zone are iterated to a tolerance of 1e-8,
//! so that other round-off here moves results (docs/decisions/0024-searches-for-closest-points.md).

use iga_core::splines::knots::MAX_DEGREE;
use nalgebra::DMatrix;

/// Longest list of Bernstein polynomials per direction.
pub(in crate::surface_pair) const MAX_ORDER: usize = MAX_DEGREE + 1;

/// Values, first and second derivatives of the Bernstein polynomials of one degree.
pub(in crate::surface_pair) type Table = [[f64; MAX_ORDER]; 3];

/// Bernstein polynomials of degree `p` at `t` in `[0, 1]`.
pub(in crate::surface_pair) fn values(p: usize, t: f64, out: &mut [f64; MAX_ORDER]) {
    out[0] = 1.0;
    (1..=p).for_each(|d| step(d, t, out));
}

/// Polynomials of degree `d` from those of degree `d - 1`.
fn step(d: usize, t: f64, out: &mut [f64; MAX_ORDER]) {
    let mut carry = 0.0;
    for value in &mut out[..d] {
        let old = *value;
        *value = carry + (1.0 - t) * old;
        carry = t * old;
    }
    out[d] = carry;
}

/// Bernstein polynomials of degree `p` with two derivatives for `t` at `t` in `[0, 1]`; entries
/// beyond `p` are not touched.
pub(in crate::surface_pair) fn table(p: usize, t: f64, table: &mut Table) {
    let mut lower = [0.0; MAX_ORDER];
    if p >= 2 {
        let mut once = [0.0; MAX_ORDER];
        values(p - 2, t, &mut lower);
        raise(p - 1, &lower, &mut once);
        raise(p, &once, &mut table[2]);
        step(p - 1, t, &mut lower);
    } else {
        table[2][..=p].fill(0.0);
        values(0, t, &mut lower);
    }
    if p >= 1 {
        raise(p, &lower, &mut table[1]);
        step(p, t, &mut lower);
    } else {
        table[1][0] = 0.0;
    }
    table[0][..=p].copy_from_slice(&lower[..=p]);
}

/// Derivative of a combination of degree `p - 1` raised to degree `p`: `p (b_(i-1) - b_i)`.
fn raise(p: usize, lower: &[f64; MAX_ORDER], out: &mut [f64; MAX_ORDER]) {
    for i in 0..=p {
        let before = if i > 0 { lower[i - 1] } else { 0.0 };
        let here = if i < p { lower[i] } else { 0.0 };
        out[i] = p as f64 * (before - here);
    }
}

/// Place of sample `i` of the fit of degree `p`, ends included.
pub(in crate::surface_pair) fn sample(p: usize, i: usize) -> f64 {
    if p == 0 { 0.5 } else { i as f64 / p as f64 }
}

/// Matrix that takes the values at the samples to Bernstein coefficients.
pub(super) fn fit(p: usize) -> DMatrix<f64> {
    let rows: Vec<[f64; MAX_ORDER]> = (0..=p)
        .map(|i| {
            let mut row = [0.0; MAX_ORDER];
            values(p, sample(p, i), &mut row);
            row
        })
        .collect();
    let collocation = DMatrix::from_fn(p + 1, p + 1, |i, k| rows[i][k]);
    collocation.try_inverse().expect("Bernstein polynomials at distinct samples are independent")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn derivatives_are_those_of_the_polynomials() {
        for p in 1..=5 {
            let (t, h) = (0.37, 1e-6);
            let at = |t: f64| {
                let mut out = [[0.0; MAX_ORDER]; 3];
                table(p, t, &mut out);
                out
            };
            let (low, here, high) = (at(t - h), at(t), at(t + h));
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
    fn fit_recovers_coefficients() {
        for p in 0..=6 {
            let coefficients: Vec<f64> = (0..=p).map(|k| (1.3 * k as f64).sin()).collect();
            let fit = fit(p);
            let at = |i: usize| -> f64 {
                let mut row = [0.0; MAX_ORDER];
                values(p, sample(p, i), &mut row);
                row.iter().zip(&coefficients).map(|(b, c)| b * c).sum()
            };
            for (k, c) in coefficients.iter().enumerate() {
                let found: f64 = (0..=p).map(|i| fit[(k, i)] * at(i)).sum();
                assert!((found - c).abs() < 1e-12); // condition of degree 6 about 1e3
            }
        }
    }
}
