//! Regions in parameters to boxes of elements that really refine something (theory section H.6).
//!
//! A function is refined only if its whole support is, so a region must be grown by the degree, across seams and around
//! collapsed edges.

use super::domain::SubdomainHierarchy;
use super::index_box::IndexBox;
use super::ties::PatchTies;
use crate::SplineError;
use crate::knots::KnotVector;
use crate::parameter_box::ParameterBox;
use crate::spline_fault::LevelFault;

/// Distance from a knot, relative to the element, within which an end of a region counts as lying on it.
const ON_KNOT: f64 = 1e-9;

impl SubdomainHierarchy {
    /// Boxes of elements of the last level that contain `regions`, grown by `by` elements in every direction.
    ///
    /// What reaches a seam goes on at its other side, by one element at least; what touches an edge that collapses onto a
    /// line is carried all around it. So seams and collapsed edges see the same refinement from all sides.
    ///
    /// # Errors
    /// [`SplineError::Levels`] if a region is not a box of finite numbers or lies outside the patch.
    pub fn elements_around(
        &self,
        regions: &[ParameterBox],
        by: [usize; 3],
        ties: &PatchTies,
    ) -> Result<Vec<IndexBox>, SplineError> {
        let mut all = Vec::new();
        for region in regions {
            all.extend(self.around(region, by, ties)?);
        }
        Ok(all)
    }

    fn around(
        &self,
        region: &ParameterBox,
        by: [usize; 3],
        ties: &PatchTies,
    ) -> Result<Vec<IndexBox>, SplineError> {
        let level = &self.levels()[self.levels().len() - 1];
        let mut boxes = vec![IndexBox::whole([1; 3])];
        for (d, k) in level.knots().iter().enumerate() {
            let (lower, upper) = elements_in_direction(k, region.lower[d], region.upper[d], ties.seams[d])?;
            let pieces = grow(lower, upper, by[d], k.n_elements(), ties.seams[d]);
            let with = |b: &IndexBox, &(l, u): &(usize, usize)| {
                let mut b = *b;
                (b.lower[d], b.upper[d]) = (l, u);
                b
            };
            boxes = boxes.iter().flat_map(|b| pieces.iter().map(move |p| with(b, p))).collect();
        }
        let sizes = level.element_counts();
        for b in &mut boxes {
            carry_around(b, &sizes, ties);
        }
        Ok(boxes)
    }
}

/// Elements `lower..upper` of one direction that contain an interval; with a seam they may reach below 0 or above `n`.
fn elements_in_direction(
    k: &KnotVector,
    lower: f64,
    upper: f64,
    seam: bool,
) -> Result<(i64, i64), SplineError> {
    let (start, end) = k.domain();
    let period = end - start;
    let reach = if seam { period } else { 0.0 };
    if !(lower <= upper && lower <= end && start <= upper && upper - lower <= f64::MAX) {
        return Err(LevelFault::Region { region: [lower, upper], domain: [start, end] }.into());
    }
    let n = k.n_elements() as i64;
    if seam && upper - lower >= period {
        return Ok((0, n));
    }
    // Element of a parameter that is moved into the patch by whole turns, and the elements of those turns.
    let locate = |u: f64, towards: f64| {
        let turn = if u < start { -1.0 } else { f64::from(u8::from(u > end)) };
        let inside = if seam { u - turn * reach } else { u.clamp(start, end) };
        let (a, b) = k.element(k.find_element(inside));
        // Step off a knot into the region.
        let e = k.find_element(inside + towards * ON_KNOT * (b - a)) as i64;
        if seam { e + turn as i64 * n } else { e }
    };
    let (first, last) = (locate(lower, 1.0), locate(upper, -1.0));
    Ok((first, last.max(first) + 1))
}

/// Grows an interval of elements, and cuts it into pieces inside `0..n`.
fn grow(lower: i64, upper: i64, by: usize, n: usize, seam: bool) -> Vec<(usize, usize)> {
    let (n, by) = (n as i64, by as i64);
    let (mut lower, mut upper) = (lower - by, upper + by);
    if seam {
        if lower <= 0 {
            lower = lower.min(-1);
        }
        if upper >= n {
            upper = upper.max(n + 1);
        }
    }
    if upper - lower >= n || !seam {
        let whole = upper - lower >= n && seam;
        let range = if whole { (0, n) } else { (lower.max(0), upper.min(n)) };
        return vec![(range.0 as usize, range.1 as usize)];
    }
    let piece = |turn: i64| ((lower + turn).max(0), (upper + turn).min(n));
    let pieces = [-n, 0, n].map(piece);
    pieces.iter().filter(|(l, u)| l < u).map(|&(l, u)| (l as usize, u as usize)).collect()
}

/// Extends a box that touches an edge collapsed onto a line over the whole direction that collapses.
fn carry_around(b: &mut IndexBox, sizes: &[usize; 3], ties: &PatchTies) {
    // Extending one direction may make the box touch another such edge: three directions, three rounds.
    for _ in 0..3 {
        for set in ties.collapsed.iter().filter(|s| !s.is_point()) {
            let touches = (0..3).all(|d| match set.ends[d] {
                None => true,
                Some(false) => b.lower[d] == 0,
                Some(true) => b.upper[d] == sizes[d],
            });
            for d in (0..3).filter(|&d| touches && set.along[d]) {
                (b.lower[d], b.upper[d]) = (0, sizes[d]);
            }
        }
    }
}
