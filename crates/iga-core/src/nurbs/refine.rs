//! Degree elevation and knot insertion: finer spaces, same geometry.
//!
//! Both are one operator. A spline of degree `p` on `Ξ` has on a finer knot vector `τ` of degree
//! `q >= p` the coefficients
//!
//! `ĉ_i = C(q, p)^-1 Σ_S F(τ_S)`, `S ⊂ {i+1 … i+q}`, `|S| = p`     (theory Eq. S.6)
//!
//! with `F` its polar form on the coarse span that holds `τ_i`. Each `F(τ_S)` is a row of discrete
//! B-splines (Cohen, Lyche & Riesenfeld 1980), hence a convex combination of `p + 1` neighbouring
//! coefficients: positive weights stay positive and nothing cancels, however uneven the knots are.
//! The work grows linearly with the net.

use super::Patch;
use crate::SplineError;
use crate::splines::knots::{KnotVector, MAX_DEGREE};

/// The matrix that takes spline coefficients on a coarse knot vector to those on a finer one:
/// `p + 1` entries per row, none negative, each row summing to one.
#[derive(Debug, Clone, PartialEq)]
pub struct Prolongation {
    n_coarse: usize,
    width: usize,
    first: Vec<usize>,
    values: Vec<f64>,
}

impl Prolongation {
    /// Builds the matrix from `coarse` to `fine` (theory Eq. S.6).
    ///
    /// # Errors
    /// [`SplineError::Knots`] unless the splines on `coarse` are splines on `fine`: same range, degree at least as high, and
    /// every coarse knot present at least as often plus the rise of the degree.
    pub fn new(coarse: &KnotVector, fine: &KnotVector) -> Result<Self, SplineError> {
        check_nested(coarse, fine)?;
        let (p, q) = (coarse.degree(), fine.degree());
        let subsets: Vec<u32> = (0..1u32 << q).filter(|s| s.count_ones() as usize == p).collect();
        let share = 1.0 / subsets.len() as f64;
        let width = p + 1;
        let mut values = vec![0.0; fine.n_functions() * width];
        let mut first = Vec::with_capacity(fine.n_functions());
        for (i, row) in values.chunks_exact_mut(width).enumerate() {
            let start = fine.knots()[i];
            let span = coarse.element_span(coarse.find_element(start));
            first.push(span - p);
            for &subset in &subsets {
                let mut arguments = [0.0; MAX_DEGREE];
                let chosen = (0..q).filter(|j| subset >> j & 1 == 1);
                for (argument, j) in arguments.iter_mut().zip(chosen) {
                    *argument = fine.knots()[i + 1 + j];
                }
                let weights = discrete_bsplines(coarse, span, &arguments[..p]);
                for (value, weight) in row.iter_mut().zip(&weights) {
                    *value += share * weight;
                }
            }
        }
        Ok(Self { n_coarse: coarse.n_functions(), width, first, values })
    }

    /// Number of coarse coefficients (columns).
    pub fn n_coarse(&self) -> usize {
        self.n_coarse
    }

    /// Number of fine coefficients (rows).
    pub fn n_fine(&self) -> usize {
        self.first.len()
    }

    /// Row `i`: the first column and the entries from there on.
    pub fn row(&self, i: usize) -> (usize, &[f64]) {
        (self.first[i], &self.values[i * self.width..(i + 1) * self.width])
    }

    /// Applies the matrix along `direction` of a net with `sizes` entries per direction;
    /// `sizes[direction]` is updated.
    ///
    /// # Panics
    /// If `net` does not have the product of `sizes` entries or `sizes[direction]` is not
    /// [`Prolongation::n_coarse`].
    pub fn apply<const N: usize>(
        &self,
        net: &[[f64; N]],
        sizes: &mut [usize],
        direction: usize,
    ) -> Vec<[f64; N]> {
        assert_eq!(net.len(), sizes.iter().product::<usize>(), "net and sizes must agree");
        assert_eq!(sizes[direction], self.n_coarse, "the operator is for another net");
        let stride: usize = sizes[..direction].iter().product();
        let block = stride * self.n_coarse;
        let mut fine = Vec::with_capacity(net.len() / self.n_coarse * self.n_fine());
        for slab in net.chunks_exact(block) {
            for i in 0..self.n_fine() {
                let (first, entries) = self.row(i);
                for offset in 0..stride {
                    let mut sum = [0.0; N];
                    for (k, entry) in entries.iter().enumerate() {
                        let from = &slab[(first + k) * stride + offset];
                        for (s, v) in sum.iter_mut().zip(from) {
                            *s += entry * v;
                        }
                    }
                    fine.push(sum);
                }
            }
        }
        sizes[direction] = self.n_fine();
        fine
    }
}

/// The `p + 1` discrete B-splines `span - p ..= span` of `coarse` for the polar arguments
/// `arguments`, rising.
fn discrete_bsplines(coarse: &KnotVector, span: usize, arguments: &[f64]) -> [f64; MAX_DEGREE + 1] {
    let t = coarse.knots();
    let mut row = [0.0; MAX_DEGREE + 1];
    row[0] = 1.0;
    for (d, &x) in (1..).zip(arguments) {
        let mut carry = 0.0;
        for r in 0..d {
            let (lower, upper) = (t[span + 1 + r - d], t[span + 1 + r]);
            let value = row[r];
            // An argument beyond the interval meets a coefficient that is exactly zero: the fine
            // knots hold all coarse ones.
            let share = if value == 0.0 { 0.0 } else { value / (upper - lower) };
            row[r] = carry + (upper - x) * share;
            carry = (x - lower) * share;
        }
        row[d] = carry;
    }
    row
}

fn check_nested(coarse: &KnotVector, fine: &KnotVector) -> Result<(), SplineError> {
    let fail = |fault: String| Err(SplineError::Knots(fault));
    let (p, q) = (coarse.degree(), fine.degree());
    if q < p {
        return fail(format!("degree {p} cannot be lowered to {q}"));
    }
    let ends = |k: &KnotVector| [k.domain().0.to_bits(), k.domain().1.to_bits()];
    if ends(coarse) != ends(fine) {
        return fail(format!(
            "range {coarse:?} is refined by {fine:?}",
            coarse = coarse.domain(),
            fine = fine.domain()
        ));
    }
    for knot in coarse.breaks() {
        let (times, least) = (fine.multiplicity(knot), coarse.multiplicity(knot) + q - p);
        if times < least {
            return fail(format!(
                "knot {knot} stands {times} times in the finer vector, {least} times are needed"
            ));
        }
    }
    Ok(())
}

impl Patch {
    /// The same geometry with further knots in `direction`, repeated as often as they are listed.
    ///
    /// # Errors
    /// [`SplineError::Knots`] for knots outside the open range, too often repeated, or a direction that does not exist.
    pub fn insert_knots(&self, direction: usize, knots: &[f64]) -> Result<Self, SplineError> {
        let fine = self.direction(direction)?.with_knots(knots)?;
        self.refine_to(direction, &fine)
    }

    /// The same geometry on any finer knot vector of `direction`.
    ///
    /// # Errors
    /// As [`Prolongation::new`]; [`SplineError::Knots`] for a direction that does not exist.
    pub fn refine_to(&self, direction: usize, fine: &KnotVector) -> Result<Self, SplineError> {
        let operator = Prolongation::new(self.direction(direction)?, fine)?;
        let mut sizes = self.net_size();
        let net = operator.apply(&self.homogeneous(), &mut sizes, direction);
        let mut knots = self.knots().to_vec();
        knots[direction] = fine.clone();
        Self::from_homogeneous(knots, &net)
    }

    /// Homogeneous control points `(w x, w y, w z, w)`.
    pub fn homogeneous(&self) -> Vec<[f64; 4]> {
        let lift = |(p, &w): (&[f64; 3], &f64)| [p[0] * w, p[1] * w, p[2] * w, w];
        self.control_points().iter().zip(self.weights()).map(lift).collect()
    }

    /// A patch from homogeneous control points.
    ///
    /// # Errors
    /// As [`Patch::new`].
    pub fn from_homogeneous(knots: Vec<KnotVector>, net: &[[f64; 4]]) -> Result<Self, SplineError> {
        let points = net.iter().map(|h| [h[0] / h[3], h[1] / h[3], h[2] / h[3]]).collect();
        Self::new(knots, points, net.iter().map(|h| h[3]).collect())
    }

    pub(super) fn direction(&self, direction: usize) -> Result<&KnotVector, SplineError> {
        let dimension = self.dimension();
        let missing =
            || SplineError::Knots(format!("direction {direction} does not exist, the patch has {dimension}"));
        self.knots().get(direction).ok_or_else(missing)
    }
}
