//! A point of a parametrised body with its derivatives, and what follows from them.

use super::patch::{Patch, PointBasis, SECOND_DERIVATIVES};

/// Position and derivatives with respect to the parameters.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Jet {
    /// `x` \[m\].
    pub point: [f64; 3],
    /// `∂x/∂ξ_d`; zero for directions that the patch does not have.
    pub first: [[f64; 3]; 3],
    /// Second derivatives in the order of [`SECOND_DERIVATIVES`].
    pub second: [[f64; 3]; 6],
}

impl Patch {
    /// Point of the patch at parameters `xi` \[m\].
    pub fn point(&self, xi: &[f64; 3]) -> [f64; 3] {
        self.jet(xi, 0, &mut PointBasis::default()).point
    }

    /// Point and derivatives up to `n_derivatives <= 2` at parameters `xi`; `scratch` spares
    /// allocations.
    pub fn jet(&self, xi: &[f64; 3], n_derivatives: usize, scratch: &mut PointBasis) -> Jet {
        self.jet_on(self.find_element(xi), xi, n_derivatives, scratch)
    }

    /// As [`Patch::jet`] on element `e`, so that one-sided values at knots are well defined.
    pub fn jet_on(&self, e: usize, xi: &[f64; 3], n_derivatives: usize, scratch: &mut PointBasis) -> Jet {
        self.evaluate(e, xi, n_derivatives, scratch);
        Jet::combine(scratch, self.active_indices(e).map(|i| self.control_points()[i]))
    }
}

impl Jet {
    /// `Σ R_A P_A` and its derivatives, as far as `basis` holds them. `points` come in the basis's
    /// order.
    pub fn combine(basis: &PointBasis, points: impl Iterator<Item = [f64; 3]>) -> Self {
        let mut jet = Self::default();
        for (a, p) in points.enumerate() {
            add(&mut jet.point, basis.values[a], &p);
            if let Some(first) = basis.first.get(a) {
                for (row, &r) in jet.first.iter_mut().zip(first) {
                    add(row, r, &p);
                }
            }
            if let Some(second) = basis.second.get(a) {
                for (row, &r) in jet.second.iter_mut().zip(second) {
                    add(row, r, &p);
                }
            }
        }
        jet
    }

    /// `∂²x/∂ξ_a∂ξ_b`.
    pub fn second(&self, a: usize, b: usize) -> [f64; 3] {
        let pair = (a.min(b), a.max(b));
        SECOND_DERIVATIVES.iter().position(|&p| p == pair).map_or([0.0; 3], |i| self.second[i])
    }

    /// `det ∂x/∂ξ` of a patch that fills a space of `dimension` 1, 2 or 3 directions; for one
    /// direction the length of the tangent.
    pub fn determinant(&self, dimension: usize) -> f64 {
        let [a, b, c] = &self.first;
        match dimension {
            1 => norm(a),
            2 => a[0] * b[1] - a[1] * b[0],
            _ => dot(a, &cross(b, c)),
        }
    }
}

fn add(sum: &mut [f64; 3], factor: f64, p: &[f64; 3]) {
    for (s, x) in sum.iter_mut().zip(p) {
        *s += factor * x;
    }
}

/// Scalar product.
pub fn dot(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Vector product.
pub fn cross(a: &[f64; 3], b: &[f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Euclidean length.
pub fn norm(a: &[f64; 3]) -> f64 {
    dot(a, a).sqrt()
}

/// Difference `a - b`.
pub fn difference(a: &[f64; 3], b: &[f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// Diagonal of the box around points; zero without points.
pub fn diagonal<'a>(points: impl IntoIterator<Item = &'a [f64; 3]>) -> f64 {
    let mut points = points.into_iter();
    let Some(&first) = points.next() else { return 0.0 };
    let (mut lower, mut upper) = (first, first);
    for p in points {
        for c in 0..3 {
            lower[c] = lower[c].min(p[c]);
            upper[c] = upper[c].max(p[c]);
        }
    }
    norm(&difference(&upper, &lower))
}
