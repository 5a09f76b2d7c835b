//! From a coarse exact patch to the wanted degrees and elements, finer near points named in metres.

pub mod grading;

use std::collections::{BTreeMap, BTreeSet};

use super::interface::linked::{Linked, linked_directions};
use super::interface::{COINCIDENT, FaceId, FaceNet, coinciding_pairs};
use super::jet::norm;
use super::locate::locate;
use super::patch::PointBasis;
use super::{Patch, Shape};
use crate::SplineError;
use crate::splines::knots::{KnotVector, MAX_DEGREE};
use grading::{Grading, Window};

/// A region of finer elements around a physical point, in the metric of the body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RefinementWindow {
    /// Point of the body around which to refine \[m\].
    pub centre: [f64; 3],
    /// Distance a direction from the centre to either end of the window, along the parameter line
    /// through the centre \[m\].
    pub half_width: [f64; 3],
    /// Equal elements per direction on the part of the window that lies in the body; 0: no
    /// refinement in that direction.
    pub elements: [usize; 3],
    /// Growth of the element size from one element to the next outside the window, >= 1.
    pub ratio: f64,
}

impl RefinementWindow {
    /// The window in parameters, one per direction.
    ///
    /// # Errors
    /// [`SplineError::PointNotFound`] if the centre is not in the patch; [`SplineError::Dimension`] for an impossible width.
    pub fn parametric(&self, patch: &Patch) -> Result<[Option<Window>; 3], SplineError> {
        let centre = locate(patch, &self.centre)?;
        let mut windows = [None; 3];
        for (d, window) in windows.iter_mut().enumerate().take(patch.dimension()) {
            if self.elements[d] == 0 {
                continue;
            }
            let width = self.half_width[d];
            if !(width.is_finite() && width > 0.0) {
                return Err(SplineError::Dimension {
                    name: "half_width",
                    value: width,
                    reason: "must be a positive, finite length in metres",
                });
            }
            *window = Some(Window {
                lower: parameter_at_distance(patch, &centre, d, -width),
                upper: parameter_at_distance(patch, &centre, d, width),
                elements: self.elements[d],
                ratio: self.ratio,
            });
        }
        Ok(windows)
    }
}

/// Parameter in direction `d` at which the arc length along the parameter line from `from` is
/// `|distance|`, upwards for a positive one and downwards for a negative one; the end of the range
/// if the line is shorter (theory Eq. S.9).
pub fn parameter_at_distance(patch: &Patch, from: &[f64; 3], d: usize, distance: f64) -> f64 {
    /// Pieces an element for the arc length: their error is far below round-off of a window's
    /// width.
    const PIECES: usize = 16;
    let mut scratch = PointBasis::default();
    let mut speed = |u: f64| {
        let mut xi = *from;
        xi[d] = u;
        norm(&patch.jet(&xi, 1, &mut scratch).first[d])
    };
    let mut stops: Vec<f64> = patch.knots()[d].breaks();
    if distance < 0.0 {
        stops.reverse();
    }
    let sign = distance.signum();
    let mut u = from[d];
    let mut left = distance.abs();
    for stop in stops.into_iter().filter(|s| (s - from[d]) * sign > 0.0) {
        let start = u;
        for k in 1..=PIECES {
            let next = start + (stop - start) * (k as f64 / PIECES as f64);
            let length = arc_length(&mut speed, u, next);
            if length >= left {
                return solve_arc(&mut speed, u, next, left);
            }
            left -= length;
            u = next;
        }
        u = stop;
    }
    u
}

/// Parameter between `a` and `b` at which the arc length from `a` is `target`: Newton, bisected
/// where it leaves the bracket.
fn solve_arc(speed: &mut impl FnMut(f64) -> f64, a: f64, b: f64, target: f64) -> f64 {
    let (mut near, mut far) = (a, b);
    let mut u = 0.5 * (a + b);
    for _ in 0..60 {
        let miss = arc_length(speed, a, u) - target;
        if miss > 0.0 {
            far = u;
        } else {
            near = u;
        }
        let step = miss / speed(u) * (b - a).signum();
        let inside = |v: f64| (v - near) * (v - far) <= 0.0;
        let next = if inside(u - step) { u - step } else { 0.5 * (near + far) };
        if (next - u).abs() <= 2.0 * f64::EPSILON * u.abs().max((b - a).abs()) {
            return next;
        }
        u = next;
    }
    u
}

/// `∫ speed |du|` by the five-point Gauss rule (nodes and weights in closed form).
fn arc_length(speed: &mut impl FnMut(f64) -> f64, a: f64, b: f64) -> f64 {
    let root = 2.0 * (10.0f64 / 7.0).sqrt();
    let (inner, outer) = ((5.0 - root).sqrt() / 3.0, (5.0 + root).sqrt() / 3.0);
    let s70 = 13.0 * 70f64.sqrt();
    let (w_inner, w_outer) = ((322.0 + s70) / 900.0, (322.0 - s70) / 900.0);
    let (middle, half) = (0.5 * (a + b), 0.5 * (b - a));
    let mut sum = 128.0 / 225.0 * speed(middle);
    for (node, weight) in [(inner, w_inner), (outer, w_outer)] {
        sum += weight * (speed(middle - half * node) + speed(middle + half * node));
    }
    sum * half.abs()
}

/// A patch of the wanted degrees with `elements` elements per direction, finer in the windows; same
/// geometry. New knots are simple, so the basis is `C^(p-1)` at them.
///
/// # Errors
/// [`SplineError::Degree`] for a degree below the patch's own; [`SplineError::NetSize`] if `degrees` or `elements` do not
/// have an entry per direction; [`SplineError::Dimension`] and [`SplineError::PointNotFound`] from
/// the windows.
pub fn refine_near(
    patch: &Patch,
    degrees: &[usize],
    elements: &[usize],
    windows: &[RefinementWindow],
) -> Result<Patch, SplineError> {
    check_counts(patch.dimension(), degrees, elements)?;
    let windows = windows.iter().map(|w| w.parametric(patch)).collect::<Result<Vec<_>, SplineError>>()?;
    let mut fine = patch.clone();
    for d in 0..patch.dimension() {
        let knots = &patch.knots()[d];
        let grading =
            Grading { elements: elements[d], windows: windows.iter().filter_map(|w| w[d]).collect() };
        fine = fine.refine_to(d, &finer(knots, degrees[d], &new_breaks(knots, &grading)?)?)?;
    }
    Ok(fine)
}

fn check_counts(expected: usize, degrees: &[usize], elements: &[usize]) -> Result<(), SplineError> {
    for (what, found) in [("degrees", degrees.len()), ("element counts", elements.len())] {
        if found != expected {
            return Err(SplineError::NetSize { what, found, expected });
        }
    }
    Ok(())
}

/// Breaks of `grading` that `knots` does not have.
fn new_breaks(knots: &KnotVector, grading: &Grading) -> Result<Vec<f64>, SplineError> {
    let existing = knots.breaks();
    let mut breaks = grading.breaks(&existing)?;
    breaks.retain(|u| !existing.contains(u));
    Ok(breaks)
}

/// `knots` raised to `degree` with further `breaks`.
fn finer(knots: &KnotVector, degree: usize, breaks: &[f64]) -> Result<KnotVector, SplineError> {
    if !(knots.degree()..=MAX_DEGREE).contains(&degree) {
        return Err(SplineError::Degree { degree, min: knots.degree(), max: MAX_DEGREE });
    }
    knots.elevated(degree - knots.degree())?.with_knots(breaks)
}

/// What all directions of a group get.
struct Division {
    degree: usize,
    elements: usize,
    /// Parameters of the new breaks, as shares of the range of the first direction.
    shares: Vec<f64>,
}

impl Shape {
    /// The shape with the wanted degrees and `elements` elements per direction on every patch,
    /// finer in the windows. Directions that shared faces turn into one another get the highest
    /// degree and the most elements that one of them is to have.
    ///
    /// # Errors
    /// As [`refine_near`]; [`SplineError::MultiPatch`] for windows on a shape of several patches,
    /// or if patches that share a face would get different knots on it.
    pub fn refined(
        &self,
        degrees: &[usize],
        elements: &[usize],
        windows: &[RefinementWindow],
    ) -> Result<Self, SplineError> {
        let n_patches = self.patches.len();
        let patches = match &self.patches[..] {
            [patch] => vec![refine_near(patch, degrees, elements, windows)?],
            _ if !windows.is_empty() => {
                let reason = "elements of a place of their own (refine, interval.elements of a contact) need a shape of one patch; leave them out, or give another net";
                return Err(SplineError::MultiPatch { n_patches, reason });
            }
            patches => divided(patches, degrees, elements)?,
        };
        let pairs = |patches: &[Patch]| {
            let nets: Vec<_> = FaceId::all(patches).iter().map(|&id| FaceNet::new(patches, id)).collect();
            coinciding_pairs(&nets, COINCIDENT).iter().map(|&(a, b, _)| (a, b)).collect::<Vec<_>>()
        };
        let after = pairs(&patches);
        if pairs(&self.patches).iter().any(|pair| after.binary_search(pair).is_err()) {
            let reason = "patches share a face but not its knots";
            return Err(SplineError::MultiPatch { n_patches, reason });
        }
        Ok(Self { patches, ..self.clone() })
    }

    /// How many functions [`Self::refined`] has without windows, those that patches share counted on
    /// each: knots of lower continuity bring more than their elements.
    ///
    /// # Errors
    /// As [`refine_near`].
    pub fn n_functions(&self, degrees: &[usize], elements: &[usize]) -> Result<usize, SplineError> {
        let along = |(knots, (degree, elements)): (&KnotVector, (&usize, &usize))| {
            let breaks = new_breaks(knots, &Grading::uniform(*elements))?;
            Ok(finer(knots, *degree, &breaks)?.n_functions())
        };
        let of_patch = |patch: &Patch| -> Result<usize, SplineError> {
            patch.knots().iter().zip(degrees.iter().zip(elements)).map(along).product()
        };
        self.patches.iter().map(of_patch).sum()
    }
}

/// Patches divided group by group of their directions.
fn divided(patches: &[Patch], degrees: &[usize], elements: &[usize]) -> Result<Vec<Patch>, SplineError> {
    let linked = linked_directions(patches);
    let mut groups: BTreeMap<usize, Division> = BTreeMap::new();
    for (patch, links) in patches.iter().zip(&linked) {
        check_counts(patch.dimension(), degrees, elements)?;
        for (d, link) in links.iter().enumerate() {
            let group =
                groups.entry(link.group).or_insert(Division { degree: 0, elements: 0, shares: Vec::new() });
            group.degree = group.degree.max(degrees[d]);
            group.elements = group.elements.max(elements[d]);
        }
    }
    let mut is_known = BTreeSet::new();
    for (patch, links) in patches.iter().zip(&linked) {
        for (link, knots) in links.iter().zip(patch.knots()) {
            // The first of a group comes first.
            if let (true, Some(group)) = (is_known.insert(link.group), groups.get_mut(&link.group)) {
                let (a, b) = knots.domain();
                let breaks = new_breaks(knots, &Grading::uniform(group.elements))?;
                group.shares = breaks.iter().map(|u| (u - a) / (b - a)).collect();
            }
        }
    }
    let refine = |(patch, links): (&Patch, &Vec<Linked>)| {
        let mut fine = patch.clone();
        for (d, link) in links.iter().enumerate() {
            let knots = &patch.knots()[d];
            let ((a, b), group) = (knots.domain(), &groups[&link.group]);
            let share = |s: &f64| if link.is_reversed { b - s * (b - a) } else { a + s * (b - a) };
            let breaks: Vec<f64> = group.shares.iter().map(share).collect();
            fine = fine.refine_to(d, &finer(knots, group.degree, &breaks)?)?;
        }
        Ok(fine)
    };
    patches.iter().zip(&linked).map(refine).collect()
}
