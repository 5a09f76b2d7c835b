//! Two-scale relation: coarse B-splines as combinations of finer ones (theory Eq. H.1).

use crate::SplineError;
use crate::splines::knots::{KnotVector, MAX_DEGREE};

const W: usize = MAX_DEGREE + 1;

/// Coefficients `s_ij` of `N_i^coarse = Σ_j s_ij N_j^fine` for nested knot vectors of one degree.
///
/// A fine function `j` meets at most `p + 1` consecutive coarse ones, so the coefficients are kept
/// by fine function. They are non-negative and, for each `j`, sum to one; those that vanish are
/// exactly zero.
#[derive(Debug, Clone, PartialEq)]
pub struct TwoScale {
    order: usize,
    first: Vec<u32>,
    coefficients: Vec<f64>,
}

/// The coarse coefficients of one function while knots are inserted.
#[derive(Clone, Copy)]
struct Row {
    first: usize,
    values: [f64; W],
}

impl TwoScale {
    /// Inserts the knots that `fine` has beyond `coarse`, one after the other from the right (Boehm
    /// 1980, H.2).
    ///
    /// # Errors
    /// [`SplineError::Levels`] if the degrees differ, or if a knot of `coarse` is missing in `fine`.
    pub fn between(coarse: &KnotVector, fine: &KnotVector) -> Result<Self, SplineError> {
        let missing = |knot| Err(SplineError::Levels(format!("knot {knot} is not among the finer knots")));
        let p = coarse.degree();
        if fine.degree() != p {
            let fine = fine.degree();
            return Err(SplineError::Levels(format!("degree {p} cannot be refined to degree {fine}")));
        }
        let unit = |i| Row { first: i, values: std::array::from_fn(|k| f64::from(u8::from(k == 0))) };
        // Functions up to the place of insertion, and, in reversed order, those behind it, which
        // are done.
        let mut head: Vec<Row> = (0..coarse.n_functions()).map(unit).collect();
        let mut tail: Vec<Row> = Vec::with_capacity(fine.n_functions());
        let (t, s) = (coarse.knots(), fine.knots());
        let mut left = t.len(); // coarse knots not matched yet
        for f in (0..s.len()).rev() {
            if left > 0 && t[left - 1].total_cmp(&s[f]).is_eq() {
                left -= 1;
                continue;
            }
            if left <= p || t[left - 1] > s[f] {
                return missing(t[left.max(1) - 1]);
            }
            let k = left - 1;
            while head.len() > k + 1 {
                tail.extend(head.pop());
            }
            insert_knot(&mut head, &t[..=k], &s[f..], p);
        }
        if left > 0 {
            return missing(t[left - 1]);
        }
        let rows = head.iter().chain(tail.iter().rev());
        let first = rows.clone().map(|r| r.first as u32).collect();
        let coefficients = rows.flat_map(|r| r.values[..=p].iter().copied()).collect();
        Ok(Self { order: p + 1, first, coefficients })
    }

    /// Number of fine functions.
    pub fn n_fine(&self) -> usize {
        self.first.len()
    }

    /// First coarse function that meets fine function `j`, and the coefficients of it and its `p`
    /// successors (zero beyond the last coarse function).
    pub fn row(&self, j: usize) -> (usize, &[f64]) {
        (self.first[j] as usize, &self.coefficients[j * self.order..(j + 1) * self.order])
    }

    /// Coefficient `s_ij`.
    pub fn coefficient(&self, i: usize, j: usize) -> f64 {
        let (first, row) = self.row(j);
        if i < first { 0.0 } else { row.get(i - first).copied().unwrap_or(0.0) }
    }
}

/// Inserts knot `behind[0]` right of the knots `before` into a spline of degree `p`; `behind` are
/// the knots from it on.
fn insert_knot(rows: &mut Vec<Row>, before: &[f64], behind: &[f64], p: usize) {
    let (k, u) = (before.len() - 1, behind[0]);
    rows.push(rows[k]);
    for i in (k + 1 - p..=k).rev() {
        let a = (u - before[i]) / (behind[i + p - k] - before[i]);
        rows[i] = blend(&rows[i - 1], &rows[i], a);
    }
}

/// `a upper + (1 - a) lower`, starting at the first entry that is not zero.
fn blend(lower: &Row, upper: &Row, a: f64) -> Row {
    let mut sum = [0.0; 2 * W];
    for (slot, v) in sum.iter_mut().zip(&lower.values) {
        *slot = (1.0 - a) * v;
    }
    let shift = upper.first - lower.first;
    for (slot, v) in sum.iter_mut().skip(shift).zip(&upper.values) {
        *slot += a * v;
    }
    let start = sum.iter().position(|&v| v != 0.0).unwrap_or(0).min(W);
    debug_assert!(sum[start + W..].iter().all(|&v| v == 0.0));
    Row { first: lower.first + start, values: std::array::from_fn(|k| sum[start + k]) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::splines::basis::basis_derivatives;

    fn split(k: &KnotVector, parts: usize) -> KnotVector {
        let mut knots = k.knots().to_vec();
        for e in 0..k.n_elements() {
            let (a, b) = k.element(e);
            knots.extend((1..parts).map(|i| a + (b - a) * i as f64 / parts as f64));
        }
        knots.sort_by(f64::total_cmp);
        KnotVector::new(k.degree(), knots).unwrap()
    }

    fn values(k: &KnotVector, u: f64) -> Vec<f64> {
        let e = k.find_element(u);
        let p = k.degree();
        let (mut all, mut local) = (vec![0.0; k.n_functions()], vec![0.0; p + 1]);
        basis_derivatives(k, e, u, 0, &mut local);
        all[k.element_span(e) - p..=k.element_span(e)].copy_from_slice(&local);
        all
    }

    #[test]
    fn coarse_functions_are_reproduced_by_fine_ones() {
        for p in 1..=MAX_DEGREE {
            let mut knots = vec![0.0; p + 1];
            knots.extend(if p > 1 { &[0.2, 0.3, 0.3, 0.75][..] } else { &[0.2, 0.3, 0.75] });
            knots.extend(vec![1.0; p + 1]);
            let coarse = KnotVector::new(p, knots).unwrap();
            for parts in [1, 2, 3, 7] {
                let fine = split(&coarse, parts);
                let relation = TwoScale::between(&coarse, &fine).unwrap();
                assert_eq!(relation.n_fine(), fine.n_functions());
                for step in 0..=40 {
                    let u = step as f64 / 40.0;
                    let (c, f) = (values(&coarse, u), values(&fine, u));
                    for (i, ci) in c.iter().enumerate() {
                        let sum: f64 =
                            f.iter().enumerate().map(|(j, fj)| relation.coefficient(i, j) * fj).sum();
                        // convex combinations of convex combinations: round-off only
                        assert!((sum - ci).abs() < 1e-14, "p {p} parts {parts} u {u}: {sum} {ci}");
                    }
                }
            }
        }
    }

    #[test]
    fn coefficients_are_not_negative_and_sum_to_one() {
        let coarse = KnotVector::uniform(4, 5).unwrap();
        let relation = TwoScale::between(&coarse, &split(&coarse, 3)).unwrap();
        for j in 0..relation.n_fine() {
            let (_, row) = relation.row(j);
            assert!(row.iter().all(|&v| v >= 0.0));
            assert!((row.iter().sum::<f64>() - 1.0).abs() < 1e-15 * 4.0);
        }
    }

    #[test]
    fn knots_that_are_not_nested_are_refused() {
        let (a, b) = (KnotVector::uniform(2, 3).unwrap(), KnotVector::uniform(2, 4).unwrap());
        let text = TwoScale::between(&a, &b).unwrap_err().to_string();
        assert!(text.contains("not among the finer knots"), "{text}");
        assert!(TwoScale::between(&b, &a).is_err());
        let other = KnotVector::uniform(3, 6).unwrap();
        assert!(TwoScale::between(&a, &other).is_err());
    }
}
