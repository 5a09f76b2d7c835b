//! B-spline basis functions and their derivatives in one direction (theory Eq. S.1, S.2).

use crate::splines::knots::{KnotVector, MAX_DEGREE};

const W: usize = MAX_DEGREE + 1;

/// Values and derivatives up to order `n_derivatives <= 2` of the `p + 1` functions active on
/// element `element` at `u`.
///
/// `out[k * (p + 1) + j]` receives the `k`-th derivative of function `element_span - p + j`; its
/// length must be at least `(n_derivatives + 1)(p + 1)`. The element is named by the caller, so
/// that one-sided values at knots are well defined. Triangular Cox-de Boor scheme; derivatives by
/// differences of the lower-degree functions.
pub fn basis_derivatives(knots: &KnotVector, element: usize, u: f64, n_derivatives: usize, out: &mut [f64]) {
    let p = knots.degree();
    let span = knots.element_span(element);
    debug_assert!(n_derivatives <= 2 && out.len() >= (n_derivatives + 1) * (p + 1));
    let t = knots.knots();
    // rows[d] holds the functions of degree d that are active on the span.
    let mut rows = [[0.0; W]; W];
    rows[0][0] = 1.0;
    for d in 1..=p {
        let mut carry = 0.0;
        for r in 0..d {
            let (lower, upper) = (t[span + 1 + r - d], t[span + 1 + r]);
            let share = rows[d - 1][r] / (upper - lower);
            rows[d][r] = carry + (upper - u) * share;
            carry = (u - lower) * share;
        }
        rows[d][d] = carry;
    }
    out[..=p].copy_from_slice(&rows[p][..=p]);
    for k in 1..=n_derivatives {
        let row = &mut out[k * (p + 1)..(k + 1) * (p + 1)];
        if k > p {
            row.fill(0.0);
            continue;
        }
        let mut values = [0.0; W];
        values[..=p - k].copy_from_slice(&rows[p - k][..=p - k]);
        // Raise the degree from p - k to p, differentiating in each step.
        for d in p - k + 1..=p {
            let mut previous = 0.0;
            for r in 0..=d {
                let next = if r < d { values[r] / (t[span + 1 + r] - t[span + 1 + r - d]) } else { 0.0 };
                values[r] = d as f64 * (previous - next);
                previous = next;
            }
        }
        row.copy_from_slice(&values[..=p]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn knot_vectors() -> Vec<KnotVector> {
        let mut all: Vec<_> = (1..=MAX_DEGREE).map(|p| KnotVector::uniform(p, 4).unwrap()).collect();
        all.push(
            KnotVector::new(3, vec![0., 0., 0., 0., 0.1, 0.1, 0.6, 0.7, 0.7, 0.7, 1., 1., 1., 1.]).unwrap(),
        );
        all
    }

    #[test]
    fn values_sum_to_one_and_derivatives_to_zero() {
        for k in knot_vectors() {
            let n = k.degree() + 1;
            let mut out = vec![0.0; 3 * n];
            for e in 0..k.n_elements() {
                let (a, b) = k.element(e);
                for s in [0.0, 0.3, 0.9, 1.0] {
                    basis_derivatives(&k, e, a + s * (b - a), 2, &mut out);
                    // Round-off of sums of numbers of size p^k / h^k.
                    let scale = n as f64 / (b - a);
                    assert!((out[..n].iter().sum::<f64>() - 1.0).abs() < 1e-14);
                    assert!(out[n..2 * n].iter().sum::<f64>().abs() < 1e-14 * scale * 10.0);
                    assert!(out[2 * n..].iter().sum::<f64>().abs() < 1e-14 * scale * scale * 10.0);
                    assert!(out[..n].iter().all(|&v| v > -1e-15));
                }
            }
        }
    }

    #[test]
    fn derivatives_match_central_differences() {
        for k in knot_vectors() {
            let n = k.degree() + 1;
            let (mut lo, mut hi, mut mid) = (vec![0.0; 3 * n], vec![0.0; 3 * n], vec![0.0; 3 * n]);
            let h = 1e-6; // error h^2 f''' / 6 against round-off eps f / h
            for e in 0..k.n_elements() {
                let (a, b) = k.element(e);
                let u = a + 0.4 * (b - a);
                basis_derivatives(&k, e, u - h, 2, &mut lo);
                basis_derivatives(&k, e, u + h, 2, &mut hi);
                basis_derivatives(&k, e, u, 2, &mut mid);
                for i in 0..2 * n {
                    let difference = (hi[i] - lo[i]) / (2.0 * h);
                    let scale = 1.0 + mid[n..].iter().fold(0.0f64, |m, v| m.max(v.abs()));
                    assert!((difference - mid[n + i]).abs() < 1e-6 * scale, "{k:?} {i}");
                }
            }
        }
    }
}
