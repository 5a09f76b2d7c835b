//! Nearest and lowest points of a patch or of one of its faces, by bounding boxes and Newton's
//! method.
//!
//! The convex hull property bounds each element by its Bézier points. Elements are visited in the
//! order of their lower bounds; from the best sample of each a Newton search runs over the whole
//! patch, until no element can hold anything better (theory section S.6). With all directions free
//! the nearest point is the inverse of the geometry map.

pub mod box_newton;

use super::jet::{cross, diagonal, difference, dot, norm};
use super::patch::PointBasis;
use super::{Jet, Patch, Prolongation, Shape};
use crate::SplineError;
use crate::splines::basis::basis_derivatives;
use crate::splines::knots::{KnotVector, MAX_DEGREE};
use crate::splines::tensor;
use box_newton::{Sample, minimize};

/// A point of a patch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Located {
    /// Parameters.
    pub xi: [f64; 3],
    /// Position \[m\].
    pub point: [f64; 3],
    /// What was minimised: distance from the target, or height along the direction \[m\].
    pub measure: f64,
}

/// Bounding boxes and start points of a patch, with some parameters held fixed.
#[derive(Debug, Clone, PartialEq)]
pub struct PatchSearch {
    lower: [f64; 3],
    upper: [f64; 3],
    elements: Vec<ElementBox>,
    /// Parameters and positions, a fixed number per element.
    samples: Vec<([f64; 3], [f64; 3])>,
    samples_per_element: usize,
    size: f64,
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct ElementBox {
    lower: [f64; 3],
    upper: [f64; 3],
}

/// Newton steps of an inversion: from a neighbouring point it takes three or four.
const MAX_INVERSE_STEPS: usize = 10;

/// Start points that a direction gets at least, over all its elements: enough to tell the two
/// halves of a closed circle.
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
            size: diagonal(patch.control_points()),
        };
        let hull = BezierNet::new(patch, &lower, &upper);
        let mut scratch = PointBasis::default();
        for e in 0..patch.n_elements() {
            let index = tensor::multi_index(&counts, e);
            let on_face =
                |d: usize| lower[d] < upper[d] || patch.knots()[d].find_element(lower[d]) == index[d];
            if !(0..n).all(on_face) {
                continue;
            }
            search.elements.push(hull.bound(&index));
            let (a, b) = patch.element(e);
            for s in 0..search.samples_per_element {
                let which = tensor::multi_index(&per_direction, s);
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

    /// Nearest point to `target`; `measure` is the distance \[m\].
    pub fn closest(&self, patch: &Patch, target: &[f64; 3]) -> Located {
        self.closest_below(patch, target, f64::INFINITY)
            .unwrap_or_else(|| self.closest_from(patch, target, &self.lower))
    }

    /// Nearest point to `target` if it is nearer than `below` \[m\].
    pub fn closest_below(&self, patch: &Patch, target: &[f64; 3], below: f64) -> Option<Located> {
        let mut scratch = PointBasis::default();
        let objective = |xi: &[f64; 3]| half_square(&patch.jet(xi, 2, &mut scratch), target);
        let rank = |p: &[f64; 3]| 0.5 * square(&difference(p, target));
        let limit = |b: &ElementBox| 0.5 * square(&b.outside(target));
        // Below a round-off of the size nothing better can be told.
        let enough = 0.5 * (1e-14 * self.size).powi(2);
        let found = self.search(objective, rank, limit, enough, 0.5 * below * below)?;
        Some(self.finish(patch, found, |p| norm(&difference(p, target))))
    }

    /// A lower bound of the distance to `target` \[m\].
    pub fn distance_bound(&self, target: &[f64; 3]) -> f64 {
        self.elements.iter().map(|b| norm(&b.outside(target))).fold(f64::INFINITY, f64::min)
    }

    /// Nearest point to `target` reached from the parameters `start`, such as the last time step's:
    /// one Newton search.
    pub fn closest_from(&self, patch: &Patch, target: &[f64; 3], start: &[f64; 3]) -> Located {
        let mut scratch = PointBasis::default();
        let objective = |xi: &[f64; 3]| half_square(&patch.jet(xi, 2, &mut scratch), target);
        let (xi, _) = minimize(objective, start, &self.lower, &self.upper);
        self.finish(patch, xi, |p| norm(&difference(p, target)))
    }

    /// Parameters of the point `target` of the patch by Newton's method for `x(ξ) = target` from
    /// `start`, which needs first derivatives alone (theory Eq. S.22); `None` if it has not come
    /// within `within` \[m\], as from far away or near collapsed faces, where the map has no
    /// inverse.
    pub fn inverse_from(
        &self,
        patch: &Patch,
        target: &[f64; 3],
        (start, within): (&[f64; 3], f64),
        scratch: &mut PointBasis,
    ) -> Option<[f64; 3]> {
        let mut xi = *start;
        for _ in 0..MAX_INVERSE_STEPS {
            let jet = patch.jet(&xi, 1, scratch);
            let rest = difference(target, &jet.point);
            let step = newton_step(&jet, patch.dimension(), &rest)?;
            xi = std::array::from_fn(|d| (xi[d] + step[d]).max(self.lower[d]).min(self.upper[d]));
            if norm(&rest) <= within {
                return Some(xi);
            }
        }
        None
    }

    /// Lowest point along `direction`: the one with the smallest `n · x`, which is `measure`.
    pub fn lowest(&self, patch: &Patch, direction: &[f64; 3]) -> Located {
        let height_of = |p: &[f64; 3]| dot(p, direction);
        let found = self.lowest_below(patch, direction, f64::INFINITY);
        found.unwrap_or_else(|| self.finish(patch, self.lower, height_of))
    }

    /// Lowest point along `direction` if it is lower than `below` \[m\].
    pub fn lowest_below(&self, patch: &Patch, direction: &[f64; 3], below: f64) -> Option<Located> {
        let mut scratch = PointBasis::default();
        let objective = |xi: &[f64; 3]| height(&patch.jet(xi, 2, &mut scratch), direction);
        let rank = |p: &[f64; 3]| dot(p, direction);
        let limit = |b: &ElementBox| b.lowest(direction);
        let found = self.search(objective, rank, limit, f64::NEG_INFINITY, below)?;
        Some(self.finish(patch, found, |p| dot(p, direction)))
    }

    /// A lower bound of `n · x` \[m\].
    pub fn height_bound(&self, direction: &[f64; 3]) -> f64 {
        self.elements.iter().map(|b| b.lowest(direction)).fold(f64::INFINITY, f64::min)
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
        below: f64,
    ) -> Option<[f64; 3]> {
        let mut order: Vec<(f64, usize)> =
            self.elements.iter().enumerate().map(|(e, b)| (limit(b), e)).collect();
        order.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (mut best, mut value) = (None, below);
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
                (best, value) = (Some(xi), found);
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

    /// Smallest `n · x` in the box.
    fn lowest(&self, direction: &[f64; 3]) -> f64 {
        (0..3).map(|c| (direction[c] * self.lower[c]).min(direction[c] * self.upper[c])).sum()
    }
}

/// Homogeneous control points of the Bézier pieces of a patch or face: the tightest hulls that knot
/// insertion gives.
struct BezierNet {
    net: Vec<[f64; 4]>,
    sizes: [usize; 3],
    /// Degrees of the free directions, zero for fixed ones.
    degrees: [usize; 3],
}

impl BezierNet {
    fn new(patch: &Patch, lower: &[f64; 3], upper: &[f64; 3]) -> Self {
        let (mut net, mut sizes, mut degrees) = (patch.homogeneous(), [1; 3], [0; 3]);
        sizes[..patch.dimension()].copy_from_slice(&patch.net_size());
        for (d, knots) in patch.knots().iter().enumerate() {
            if lower[d] < upper[d] {
                let p = knots.degree();
                let inner = knots.breaks();
                let missing = inner[1..inner.len() - 1]
                    .iter()
                    .flat_map(|&u| std::iter::repeat_n(u, p - knots.multiplicity(u)));
                let missing: Vec<f64> = missing.collect();
                // Full multiplicity at inner breaks is always a valid refinement.
                if let Ok(operator) =
                    knots.with_knots(&missing).and_then(|fine| Prolongation::new(knots, &fine))
                {
                    net = operator.apply(&net, &mut sizes, d);
                }
                degrees[d] = p;
            } else {
                net = restrict(&net, &mut sizes, d, knots, lower[d]);
            }
        }
        Self { net, sizes, degrees }
    }

    /// Box around the Bézier points of an element.
    fn bound(&self, index: &[usize; 3]) -> ElementBox {
        let range = |d: usize| {
            let first = self.degrees[d] * index[d];
            first..=first + self.degrees[d]
        };
        let mut b = ElementBox { lower: [f64::INFINITY; 3], upper: [f64::NEG_INFINITY; 3] };
        for k in range(2) {
            for j in range(1) {
                for i in range(0) {
                    let h = &self.net[i + self.sizes[0] * (j + self.sizes[1] * k)];
                    for c in 0..3 {
                        b.lower[c] = b.lower[c].min(h[c] / h[3]);
                        b.upper[c] = b.upper[c].max(h[c] / h[3]);
                    }
                }
            }
        }
        b
    }
}

/// The net at a fixed parameter of direction `d`.
fn restrict(net: &[[f64; 4]], sizes: &mut [usize; 3], d: usize, knots: &KnotVector, u: f64) -> Vec<[f64; 4]> {
    let e = knots.find_element(u);
    let first = knots.element_span(e) - knots.degree();
    let mut values = [0.0; MAX_DEGREE + 1];
    basis_derivatives(knots, e, u, 0, &mut values);
    let stride: usize = sizes[..d].iter().product();
    let mut layer = Vec::with_capacity(net.len() / sizes[d]);
    for slab in net.chunks_exact(stride * sizes[d]) {
        for offset in 0..stride {
            let mut sum = [0.0; 4];
            for (k, value) in values.iter().enumerate().take(knots.degree() + 1) {
                for (s, h) in sum.iter_mut().zip(&slab[(first + k) * stride + offset]) {
                    *s += value * h;
                }
            }
            layer.push(sum);
        }
    }
    sizes[d] = 1;
    layer
}

/// The change of parameters that moves a point with the derivatives of `jet` by `way`; `None` where
/// the map of the `dimension` directions is singular.
fn newton_step(jet: &Jet, dimension: usize, way: &[f64; 3]) -> Option<[f64; 3]> {
    let axis = |d: usize| std::array::from_fn(|c| f64::from(u8::from(c == d)));
    let [a, b, c]: [[f64; 3]; 3] =
        std::array::from_fn(|d| if d < dimension { jet.first[d] } else { axis(d) });
    let (bc, ca, ab) = (cross(&b, &c), cross(&c, &a), cross(&a, &b));
    let determinant = dot(&a, &bc);
    let step = [&bc, &ca, &ab].map(|n| dot(n, way) / determinant);
    step.iter().all(|s| s.is_finite()).then_some(step)
}

/// Half the squared distance with derivatives.
fn half_square(jet: &Jet, target: &[f64; 3]) -> Sample {
    Sample::half_square(&jet.point, &jet.first, |a, b| jet.second(a, b), target)
}

/// Height along `direction` with derivatives.
fn height(jet: &Jet, direction: &[f64; 3]) -> Sample {
    Sample::height(&jet.point, &jet.first, |a, b| jet.second(a, b), direction)
}

fn square(v: &[f64; 3]) -> f64 {
    dot(v, v)
}

/// Part of a body's size within which places are one: a point that misses the body by less lies in
/// it, places on two faces are the same. Nearest places minimise the square of a distance, which
/// tells them to the root of round-off, 1.5e-8 of the size; near poles a few times that.
pub const SAME_PLACE: f64 = 1e-7;
/// Share of that within which a search has met its point.
const SURE: f64 = 0.01;
/// How many times as far off a search may be beside a pole, where it moves hardly along the lines
/// that run together.
const BESIDE_POLES: f64 = 100.0;
/// Steps, and cuts of one, by which such a search is brought to its point.
const CLOSER: [usize; 2] = [60, 30];

impl PatchSearch {
    /// The place of the patch nearest to `target`, met to round-off if it lies in the patch, beside
    /// poles too.
    fn met(&self, patch: &Patch, target: &[f64; 3]) -> Located {
        let found = self.closest(patch, target);
        let unit = SAME_PLACE * self.size;
        if found.measure <= SURE * unit || found.measure.is_nan() || found.measure > BESIDE_POLES * unit {
            return found;
        }
        let closer =
            self.finish(patch, self.closer(patch, target, &found.xi), |p| norm(&difference(p, target)));
        if closer.measure < found.measure { closer } else { found }
    }

    /// Parameters nearer to `target` than `start` by Newton's method for `x(ξ) = target`, which
    /// unlike the minimum of a square scales the directions by themselves. A step ends before the
    /// bounds, where the map may be singular.
    fn closer(&self, patch: &Patch, target: &[f64; 3], start: &[f64; 3]) -> [f64; 3] {
        let mut scratch = PointBasis::default();
        let free = |d: usize| self.lower[d] < self.upper[d];
        let slack = |d: usize| 1e-9 * (self.upper[d] - self.lower[d]);
        let inside = |d: usize, x: f64| x.max(self.lower[d] + slack(d)).min(self.upper[d] - slack(d));
        let mut xi = std::array::from_fn(|d| if free(d) { inside(d, start[d]) } else { start[d] });
        let mut jet = patch.jet(&xi, 1, &mut scratch);
        let mut rest = difference(target, &jet.point);
        for _ in 0..CLOSER[0] {
            let Some(step) = newton_step(&jet, patch.dimension(), &rest) else { break };
            let room = |d: usize| {
                let bound = if step[d] > 0.0 { self.upper[d] } else { self.lower[d] };
                if step[d].abs() > 0.0 { 0.9 * ((bound - xi[d]) / step[d]).abs() } else { 1.0 }
            };
            let mut length = (0..3).filter(|&d| free(d)).map(room).fold(1.0, f64::min);
            let mut accepted = None;
            for _ in 0..CLOSER[1] {
                let trial = std::array::from_fn(|d| xi[d] + length * step[d]);
                let there = patch.jet(&trial, 1, &mut scratch);
                let left = difference(target, &there.point);
                if norm(&left) < norm(&rest) {
                    accepted = Some((trial, there, left));
                    break;
                }
                length *= 0.5;
            }
            let Some(next) = accepted else { break };
            (xi, jet, rest) = next;
        }
        xi
    }
}

/// Parameters of the physical point `point` inside a patch: the inverse of the geometry map.
/// Parameters do not change under refinement, so the search is cheapest on the coarse patch.
///
/// # Errors
/// [`SplineError::PointNotFound`] if the nearest point of the patch is farther away than [`SAME_PLACE`] of its size.
pub fn locate(patch: &Patch, point: &[f64; 3]) -> Result<[f64; 3], SplineError> {
    let search = PatchSearch::new(patch, [None; 3]);
    let found = search.met(patch, point);
    // Not a number fails the comparison.
    if found.measure <= SAME_PLACE * search.size {
        return Ok(found.xi);
    }
    Err(SplineError::PointNotFound { point: *point, distance: found.measure })
}

impl Shape {
    /// Patch and parameters of a physical point inside the body: the first patch that it is in but
    /// for a hundredth of what counts as in the body, else the nearest.
    ///
    /// # Errors
    /// [`SplineError::PointNotFound`] with the distance to the nearest patch if that is more than [`SAME_PLACE`] of the body's size.
    pub fn locate(&self, point: &[f64; 3]) -> Result<(usize, [f64; 3]), SplineError> {
        let within = SAME_PLACE * diagonal(self.patches.iter().flat_map(|patch| patch.control_points()));
        let (mut nearest, mut place) = (f64::INFINITY, None);
        for (index, patch) in self.patches.iter().enumerate() {
            let search = PatchSearch::new(patch, [None; 3]);
            let found = search.met(patch, point);
            if found.measure < nearest {
                (nearest, place) = (found.measure, Some((index, found.xi)));
            }
            // Not a number fails the comparison.
            if found.measure <= SURE * SAME_PLACE * search.size {
                break;
            }
        }
        let lost = SplineError::PointNotFound { point: *point, distance: nearest };
        place.filter(|_| nearest <= within).ok_or(lost)
    }
}
