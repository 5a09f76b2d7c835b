//! Nearest and lowest points of a patch or of one of its faces, by bounding boxes and Newton's method.
//!
//! The convex hull property bounds each element by its control points. Elements are visited in the order of their lower
//! bounds; from the best sample of each a Newton search runs over the whole patch, until no element can hold anything
//! better (theory section S.6). With all directions free the nearest point is the inverse of the geometry map.

use super::box_newton::{Sample, minimize};
use super::jet::{difference, dot, norm};
use super::patch::PointBasis;
use super::{Jet, Patch, Shape};
use crate::SplineError;
use crate::bspline::basis_derivatives;
use crate::knots::MAX_DEGREE;
use crate::tensor;

/// A point of a patch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Located {
    /// Parameters.
    pub xi: [f64; 3],
    /// Position [m].
    pub point: [f64; 3],
    /// What was minimised: distance from the target, or height along the direction [m].
    pub measure: f64,
}

/// Bounding boxes and start points of a patch, with some parameters held fixed.
#[derive(Debug, Clone, PartialEq)]
pub struct PatchSearch {
    lower: [f64; 3],
    upper: [f64; 3],
    elements: Vec<ElementBox>,
    /// Parameters and positions, a fixed number an element.
    samples: Vec<([f64; 3], [f64; 3])>,
    samples_per_element: usize,
    size: f64,
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct ElementBox {
    lower: [f64; 3],
    upper: [f64; 3],
}

/// Start points that a direction gets at least, over all its elements: enough to tell the two halves of a closed circle.
const LEAST_SAMPLES: usize = 9;

impl PatchSearch {
    /// Prepares the search on `patch` with the parameters in `fixed` held, such as a face's.
    pub fn new(patch: &Patch, fixed: [Option<f64>; 3]) -> Self {
        let (mut lower, mut upper) = patch.domain();
        for (d, value) in fixed.iter().enumerate().take(patch.dimension()) {
            if let Some(v) = value {
                (lower[d], upper[d]) = (*v, *v);
            }
        }
        let n = patch.dimension();
        let counts = patch.element_counts();
        let mut per_direction = [1; 3];
        for d in 0..n {
            if lower[d] < upper[d] {
                per_direction[d] = LEAST_SAMPLES.div_ceil(counts[d]);
            }
        }
        let mut search = Self {
            lower,
            upper,
            elements: Vec::new(),
            samples: Vec::new(),
            samples_per_element: per_direction.iter().product(),
            size: extent(patch.control_points()),
        };
        let mut scratch = PointBasis::default();
        for e in 0..patch.n_elements() {
            let index = tensor::unflat(&counts, e);
            let on_face =
                |d: usize| lower[d] < upper[d] || patch.knots()[d].find_element(lower[d]) == index[d];
            if !(0..n).all(on_face) {
                continue;
            }
            search.elements.push(bound(patch, e, &index, &lower, &upper));
            let (a, b) = patch.element(e);
            for s in 0..search.samples_per_element {
                let which = tensor::unflat(&per_direction, s);
                let mut xi = lower;
                for d in (0..n).filter(|&d| lower[d] < upper[d]) {
                    xi[d] = a[d] + (b[d] - a[d]) * (which[d] as f64 + 0.5) / per_direction[d] as f64;
                }
                let point = patch.jet_on(e, &xi, 0, &mut scratch).point;
                search.samples.push((xi, point));
            }
        }
        search
    }

    /// Nearest point to `target`; `measure` is the distance [m].
    pub fn closest(&self, patch: &Patch, target: &[f64; 3]) -> Located {
        let mut scratch = PointBasis::default();
        let objective = |xi: &[f64; 3]| half_square(&patch.jet(xi, 2, &mut scratch), target);
        let rank = |p: &[f64; 3]| 0.5 * square(&difference(p, target));
        let limit = |b: &ElementBox| 0.5 * square(&b.outside(target));
        // Below a round-off of the size nothing better can be told.
        let enough = 0.5 * (1e-14 * self.size).powi(2);
        self.finish(patch, self.search(objective, rank, limit, enough), |p| norm(&difference(p, target)))
    }

    /// Nearest point to `target` reached from the parameters `start`, such as the last time step's: one Newton search.
    pub fn closest_from(&self, patch: &Patch, target: &[f64; 3], start: &[f64; 3]) -> Located {
        let mut scratch = PointBasis::default();
        let objective = |xi: &[f64; 3]| half_square(&patch.jet(xi, 2, &mut scratch), target);
        let (xi, _) = minimize(objective, start, &self.lower, &self.upper);
        self.finish(patch, xi, |p| norm(&difference(p, target)))
    }

    /// Lowest point along `direction`: the one with the smallest `n · x`, which is `measure`.
    pub fn lowest(&self, patch: &Patch, direction: &[f64; 3]) -> Located {
        let mut scratch = PointBasis::default();
        let objective = |xi: &[f64; 3]| height(&patch.jet(xi, 2, &mut scratch), direction);
        let rank = |p: &[f64; 3]| dot(p, direction);
        let limit =
            |b: &ElementBox| (0..3).map(|c| (direction[c] * b.lower[c]).min(direction[c] * b.upper[c])).sum();
        let found = self.search(objective, rank, limit, f64::NEG_INFINITY);
        self.finish(patch, found, |p| dot(p, direction))
    }

    fn finish(&self, patch: &Patch, xi: [f64; 3], measure: impl Fn(&[f64; 3]) -> f64) -> Located {
        let point = patch.point(&xi);
        Located { xi, point, measure: measure(&point) }
    }

    fn search(
        &self,
        mut objective: impl FnMut(&[f64; 3]) -> Sample,
        rank: impl Fn(&[f64; 3]) -> f64,
        limit: impl Fn(&ElementBox) -> f64,
        enough: f64,
    ) -> [f64; 3] {
        let mut order: Vec<(f64, usize)> =
            self.elements.iter().enumerate().map(|(e, b)| (limit(b), e)).collect();
        order.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (mut best, mut value) = (self.lower, f64::INFINITY);
        for (bound, e) in order {
            if bound >= value || value <= enough {
                break;
            }
            let n = self.samples_per_element;
            let starts = &self.samples[e * n..(e + 1) * n];
            let Some((start, _)) = starts.iter().min_by(|a, b| rank(&a.1).total_cmp(&rank(&b.1))) else {
                continue;
            };
            let (xi, found) = minimize(&mut objective, start, &self.lower, &self.upper);
            if found < value {
                (best, value) = (xi, found);
            }
        }
        best
    }
}

impl ElementBox {
    /// Vector from the box to a point outside it, zero inside.
    fn outside(&self, p: &[f64; 3]) -> [f64; 3] {
        [0, 1, 2].map(|c| p[c] - p[c].max(self.lower[c]).min(self.upper[c]))
    }
}

/// Box around the control points of the functions that do not vanish on the element at the fixed parameters.
fn bound(patch: &Patch, e: usize, index: &[usize; 3], lower: &[f64; 3], upper: &[f64; 3]) -> ElementBox {
    let mut rows = [[1.0; MAX_DEGREE + 1]; 3];
    let mut orders = [1; 3];
    for (d, k) in patch.knots().iter().enumerate() {
        orders[d] = k.degree() + 1;
        if lower[d] >= upper[d] {
            basis_derivatives(k, index[d], lower[d], 0, &mut rows[d]);
        }
    }
    let mut b = ElementBox { lower: [f64::INFINITY; 3], upper: [f64::NEG_INFINITY; 3] };
    for (local, i) in patch.active_indices(e).enumerate() {
        let at = tensor::unflat(&orders, local);
        if (0..3).all(|d| rows[d][at[d]] > 0.0) {
            for (c, x) in patch.control_points()[i].iter().enumerate() {
                b.lower[c] = b.lower[c].min(*x);
                b.upper[c] = b.upper[c].max(*x);
            }
        }
    }
    b
}

/// Half the squared distance with derivatives.
fn half_square(jet: &Jet, target: &[f64; 3]) -> Sample {
    let r = difference(&jet.point, target);
    let distance = norm(&r);
    let rounding = 4.0 * f64::EPSILON * (norm(&jet.point) + norm(target));
    let mut sample =
        Sample { value: 0.5 * square(&r), noise: rounding * (distance + rounding), ..Sample::default() };
    for a in 0..3 {
        sample.gradient[a] = dot(&r, &jet.first[a]);
        for b in 0..3 {
            sample.hessian[a][b] = dot(&jet.first[a], &jet.first[b]) + dot(&r, &jet.second(a, b));
        }
    }
    sample
}

/// Height along `direction` with derivatives.
fn height(jet: &Jet, direction: &[f64; 3]) -> Sample {
    let mut sample = Sample {
        value: dot(&jet.point, direction),
        noise: 4.0 * f64::EPSILON * norm(&jet.point) * norm(direction),
        ..Sample::default()
    };
    for a in 0..3 {
        sample.gradient[a] = dot(direction, &jet.first[a]);
        for b in 0..3 {
            sample.hessian[a][b] = dot(direction, &jet.second(a, b));
        }
    }
    sample
}

fn square(v: &[f64; 3]) -> f64 {
    dot(v, v)
}

/// Diagonal of the box around points.
pub(crate) fn extent(points: &[[f64; 3]]) -> f64 {
    let span = |c: usize| {
        let values = points.iter().map(|p| p[c]);
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
        high - low
    };
    norm(&[span(0), span(1), span(2)])
}

/// How far a point may miss the body and still count as inside, relative to the body's size.
const INSIDE: f64 = 1e-9;

/// Parameters of the physical point `point` inside a patch: the inverse of the geometry map. Parameters do not change under
/// refinement, so the search is cheapest on the coarse patch.
///
/// # Errors
/// [`SplineError::PointNotFound`] if the nearest point of the patch is farther away than a billionth of its size.
pub fn locate(patch: &Patch, point: &[f64; 3]) -> Result<[f64; 3], SplineError> {
    let search = PatchSearch::new(patch, [None; 3]);
    let found = search.closest(patch, point);
    // Not a number fails the comparison.
    if found.measure <= INSIDE * search.size {
        return Ok(found.xi);
    }
    Err(SplineError::PointNotFound { point: *point, distance: found.measure })
}

impl Shape {
    /// Patch and parameters of a physical point inside the body; the first patch that holds it.
    ///
    /// # Errors
    /// [`SplineError::PointNotFound`] with the distance to the nearest patch.
    pub fn locate(&self, point: &[f64; 3]) -> Result<(usize, [f64; 3]), SplineError> {
        let mut nearest = f64::INFINITY;
        for (index, patch) in self.patches.iter().enumerate() {
            match locate(patch, point) {
                Ok(xi) => return Ok((index, xi)),
                Err(SplineError::PointNotFound { distance, .. }) => nearest = nearest.min(distance),
                Err(other) => return Err(other),
            }
        }
        Err(SplineError::PointNotFound { point: *point, distance: nearest })
    }
}
