//! A tensor-product NURBS patch (theory Eq. S.4, S.5): knot vectors, control points and weights.

use crate::SplineError;
use crate::splines::basis::basis_derivatives;
use crate::splines::knots::{KnotVector, MAX_DEGREE};
use crate::splines::tensor;

/// A NURBS patch with 1, 2 or 3 parametric directions in space.
#[derive(Debug, Clone, PartialEq)]
pub struct Patch {
    knots: Vec<KnotVector>,
    control_points: Vec<[f64; 3]>,
    weights: Vec<f64>,
}

/// Rational basis functions that are active at one point, in the local order of the element.
#[derive(Debug, Clone, Default)]
pub struct PointBasis {
    /// `R_A`.
    pub values: Vec<f64>,
    /// `∂R_A/∂ξ_d`.
    pub first: Vec<[f64; 3]>,
    /// Second derivatives in the order 00, 11, 22, 01, 02, 12.
    pub second: Vec<[f64; 6]>,
}

/// Pairs of directions in the order of [`PointBasis::second`].
pub const SECOND_DERIVATIVES: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];

impl Patch {
    /// Checks and takes a patch.
    ///
    /// # Errors
    /// [`SplineError::NetSize`], [`SplineError::Weight`], [`SplineError::ControlPoint`]; [`SplineError::Knots`] unless one to
    /// three knot vectors are given.
    pub fn new(
        knots: Vec<KnotVector>,
        control_points: Vec<[f64; 3]>,
        weights: Vec<f64>,
    ) -> Result<Self, SplineError> {
        if !(1..=3).contains(&knots.len()) {
            return Err(SplineError::Knots(format!("{} directions, 1 to 3 are possible", knots.len())));
        }
        let expected = knots.iter().map(KnotVector::n_functions).product();
        for (what, found) in [("control points", control_points.len()), ("weights", weights.len())] {
            if found != expected {
                return Err(SplineError::NetSize { what, found, expected });
            }
        }
        if let Some(index) = weights.iter().position(|w| !(w.is_finite() && *w > 0.0)) {
            return Err(SplineError::Weight { index, value: weights[index] });
        }
        if let Some(index) = control_points.iter().position(|p| p.iter().any(|x| !x.is_finite())) {
            return Err(SplineError::ControlPoint { index });
        }
        Ok(Self { knots, control_points, weights })
    }

    /// The same patch with all lengths multiplied by `factor`.
    ///
    /// # Errors
    /// [`SplineError::ControlPoint`] for a product that is no number.
    pub fn scaled(mut self, factor: f64) -> Result<Self, SplineError> {
        for x in self.control_points.iter_mut().flatten() {
            *x *= factor;
        }
        Self::new(self.knots, self.control_points, self.weights)
    }

    /// The same geometry with direction `direction` run through backwards.
    ///
    /// # Errors
    /// As [`KnotVector::reversed`]; [`SplineError::Knots`] for a direction that does not exist.
    pub fn reversed(&self, direction: usize) -> Result<Self, SplineError> {
        let sizes = self.net_size();
        let mut knots = self.knots.clone();
        let reversed = self.direction(direction)?.reversed()?;
        knots[direction] = reversed;
        let stride: usize = sizes[..direction].iter().product();
        let n = sizes[direction];
        let from = |i: usize| {
            let along = i / stride % n;
            i - along * stride + (n - 1 - along) * stride
        };
        let all = 0..self.n_functions();
        let points = all.clone().map(|i| self.control_points[from(i)]).collect();
        Self::new(knots, points, all.map(|i| self.weights[from(i)]).collect())
    }

    /// The same geometry over parameters from 0 to 1 in each direction.
    ///
    /// # Errors
    /// As [`KnotVector::over_unit_range`].
    pub fn over_unit_ranges(&self) -> Result<Self, SplineError> {
        let knots = self.knots.iter().map(KnotVector::over_unit_range).collect::<Result<_, _>>()?;
        Self::new(knots, self.control_points.clone(), self.weights.clone())
    }

    /// Number of parametric directions.
    pub fn dimension(&self) -> usize {
        self.knots.len()
    }

    /// Knot vectors, one per direction.
    pub fn knots(&self) -> &[KnotVector] {
        &self.knots
    }

    /// Control points `P_A` \[m\].
    pub fn control_points(&self) -> &[[f64; 3]] {
        &self.control_points
    }

    /// Weights `w_A`.
    pub fn weights(&self) -> &[f64] {
        &self.weights
    }

    /// Number of functions in each direction.
    pub fn net_size(&self) -> Vec<usize> {
        self.knots.iter().map(KnotVector::n_functions).collect()
    }

    /// Elements per direction.
    pub fn element_counts(&self) -> Vec<usize> {
        self.knots.iter().map(KnotVector::n_elements).collect()
    }

    /// Number of functions of the patch.
    pub fn n_functions(&self) -> usize {
        self.control_points.len()
    }

    /// Number of non-empty elements of the patch.
    pub fn n_elements(&self) -> usize {
        self.knots.iter().map(KnotVector::n_elements).product()
    }

    /// Number of functions that are active on an element: `Π (p_d + 1)`.
    pub fn n_active(&self) -> usize {
        self.knots.iter().map(|k| k.degree() + 1).product()
    }

    /// Lower and upper parametric corner of an element.
    pub fn element(&self, e: usize) -> ([f64; 3], [f64; 3]) {
        let index = self.element_index(e);
        let (mut lower, mut upper) = ([0.0; 3], [0.0; 3]);
        for (d, k) in self.knots.iter().enumerate() {
            (lower[d], upper[d]) = k.element(index[d]);
        }
        (lower, upper)
    }

    /// Lower and upper corner of the parametric domain.
    pub fn domain(&self) -> ([f64; 3], [f64; 3]) {
        let (mut lower, mut upper) = ([0.0; 3], [0.0; 3]);
        for (d, k) in self.knots.iter().enumerate() {
            (lower[d], upper[d]) = k.domain();
        }
        (lower, upper)
    }

    /// The element that holds a parametric point; points outside are clamped into the patch.
    pub fn find_element(&self, xi: &[f64; 3]) -> usize {
        self.knots.iter().zip(xi).rev().fold(0, |e, (k, &u)| e * k.n_elements() + k.find_element(u))
    }

    /// Net indices of the functions active on element `e`, first direction fastest.
    pub fn active_indices(&self, e: usize) -> impl Iterator<Item = usize> + use<> {
        let index = self.element_index(e);
        let (mut first, mut n, mut sizes) = ([0; 3], [1; 3], [1; 3]);
        for (d, k) in self.knots.iter().enumerate() {
            first[d] = k.element_span(index[d]) - k.degree();
            n[d] = k.degree() + 1;
            sizes[d] = k.n_functions();
        }
        (first[2]..first[2] + n[2]).flat_map(move |k| {
            (first[1]..first[1] + n[1]).flat_map(move |j| {
                let row = sizes[0] * (j + sizes[1] * k) + first[0];
                row..row + n[0]
            })
        })
    }

    /// Appends the net indices of the functions active on element `e`, first direction fastest.
    pub fn active_functions(&self, e: usize, out: &mut Vec<u32>) {
        out.extend(self.active_indices(e).map(|i| i as u32));
    }

    fn element_index(&self, e: usize) -> [usize; 3] {
        let mut counts = [1; 3];
        for (count, k) in counts.iter_mut().zip(&self.knots) {
            *count = k.n_elements();
        }
        tensor::multi_index(&counts, e)
    }

    /// The weight function `W = Σ w_A N_A` at parameters `xi`, which refinement keeps (theory
    /// Eq. S.4).
    pub fn weight_function(&self, xi: &[f64; 3]) -> f64 {
        let mut tables = [[0.0; MAX_DEGREE + 1]; 3];
        let (mut first, mut counts, mut sizes) = ([0; 3], [1; 3], [1; 3]);
        for (d, k) in self.knots.iter().enumerate() {
            let e = k.find_element(xi[d]);
            basis_derivatives(k, e, xi[d], 0, &mut tables[d]);
            first[d] = k.element_span(e) - k.degree();
            (counts[d], sizes[d]) = (k.degree() + 1, k.n_functions());
        }
        for table in &mut tables[self.dimension()..] {
            table[0] = 1.0;
        }
        let mut sum = 0.0;
        for k in 0..counts[2] {
            for j in 0..counts[1] {
                let row = sizes[0] * (first[1] + j + sizes[1] * (first[2] + k)) + first[0];
                let line: f64 = (0..counts[0]).map(|i| tables[0][i] * self.weights[row + i]).sum();
                sum += line * tables[1][j] * tables[2][k];
            }
        }
        sum
    }

    /// Rational basis at `xi` on element `e` with derivatives up to `n_derivatives <= 2`, stacked
    /// as [`Patch::active_functions`]. Lists of higher derivatives are left empty.
    pub fn evaluate(&self, e: usize, xi: &[f64; 3], n_derivatives: usize, out: &mut PointBasis) {
        const ROW: usize = 3 * (MAX_DEGREE + 1);
        let mut tables = [[0.0; ROW]; 3];
        let (mut orders, mut first, mut sizes) = ([1; 3], [0; 3], [1; 3]);
        let index = self.element_index(e);
        for table in &mut tables {
            table[0] = 1.0; // absent directions: the constant function, whose derivatives are zero
        }
        for (d, k) in self.knots.iter().enumerate() {
            orders[d] = k.degree() + 1;
            sizes[d] = k.n_functions();
            first[d] = k.element_span(index[d]) - k.degree();
            basis_derivatives(k, index[d], xi[d], n_derivatives, &mut tables[d]);
        }
        // rows[d][k][i]: k-th derivative of the i-th function of direction d.
        let rows = [0, 1, 2].map(|d| {
            let n = orders[d];
            [&tables[d][..n], &tables[d][n..2 * n], &tables[d][2 * n..3 * n]]
        });
        out.values.clear();
        out.first.clear();
        out.second.clear();
        for k in 0..orders[2] {
            let c = rows[2].map(|r| r[k]);
            for j in 0..orders[1] {
                let b = rows[1].map(|r| r[j]);
                let start = sizes[0] * (first[1] + j + sizes[1] * (first[2] + k)) + first[0];
                let weights = &self.weights[start..start + orders[0]];
                let a = |i: usize, order: usize| weights[i] * rows[0][order][i];
                out.values.extend((0..orders[0]).map(|i| a(i, 0) * (b[0] * c[0])));
                if n_derivatives >= 1 {
                    let factors = [b[0] * c[0], b[1] * c[0], b[0] * c[1]];
                    out.first.extend((0..orders[0]).map(|i| {
                        let v = a(i, 0);
                        [a(i, 1) * factors[0], v * factors[1], v * factors[2]]
                    }));
                }
                if n_derivatives >= 2 {
                    out.second.extend((0..orders[0]).map(|i| {
                        let (v, g, h) = (a(i, 0), a(i, 1), a(i, 2));
                        [
                            h * b[0] * c[0],
                            v * b[2] * c[0],
                            v * b[0] * c[2],
                            g * b[1] * c[0],
                            g * b[0] * c[1],
                            v * b[1] * c[1],
                        ]
                    }));
                }
            }
        }
        make_rational(out);
    }
}

/// Divides weighted B-splines `w N` and their derivatives by the weight function `W = Σ w N`
/// (theory Eq. S.4).
pub(crate) fn make_rational(basis: &mut PointBasis) {
    let total: f64 = basis.values.iter().sum();
    let inverse = 1.0 / total;
    let mut gradient = [0.0; 3];
    for g in &basis.first {
        for (sum, v) in gradient.iter_mut().zip(g) {
            *sum += v;
        }
    }
    let mut hessian = [0.0; 6];
    for h in &basis.second {
        for (sum, v) in hessian.iter_mut().zip(h) {
            *sum += v;
        }
    }
    for value in &mut basis.values {
        *value *= inverse;
    }
    for (first, value) in basis.first.iter_mut().zip(&basis.values) {
        for (f, w) in first.iter_mut().zip(&gradient) {
            *f = (*f - value * w) * inverse;
        }
    }
    for ((second, first), value) in basis.second.iter_mut().zip(&basis.first).zip(&basis.values) {
        for ((s, w), &(a, b)) in second.iter_mut().zip(&hessian).zip(&SECOND_DERIVATIVES) {
            *s = (*s - first[a] * gradient[b] - first[b] * gradient[a] - value * w) * inverse;
        }
    }
}
