//! Regions in parameters to boxes of elements that really refine something (theory section H.6).
//!
//! A function is refined only if its whole support is, so a region must be grown by the degree,
//! across seams and around collapsed edges.

use super::domain::{Level, SubdomainHierarchy};
use super::index_box::IndexBox;
use super::neighbours::{Neighbours, SharedFace};
use super::ties::PatchTies;
use crate::SplineError;
use crate::splines::knots::KnotVector;
use crate::splines::parameter_box::ParameterBox;

/// Distance from a knot, relative to the element, within which an end of a region counts as lying
/// on it.
const ON_KNOT: f64 = 1e-9;

/// Elements of a patch; beyond its ends, where they may reach, those of its neighbours are meant.
type Stretch = [(i64, i64); 3];

impl SubdomainHierarchy {
    /// Boxes of elements of the last level that contain `regions`, grown by `by` elements in every
    /// direction.
    ///
    /// What reaches a seam goes on at its other side, by one element at least; what touches an edge
    /// that collapses onto a line is carried all around it. So seams and collapsed edges see the
    /// same refinement from all sides.
    ///
    /// # Errors
    /// [`SplineError::Levels`] if a region is not a box of finite numbers or lies outside the patch.
    pub fn elements_around(
        &self,
        regions: &[ParameterBox],
        by: [usize; 3],
        ties: &PatchTies,
    ) -> Result<Vec<IndexBox>, SplineError> {
        let mut boxes = Vec::new();
        for region in regions {
            for stretch in self.around(region, by, ties)? {
                boxes.push(self.inside(&stretch, ties));
            }
        }
        Ok(boxes)
    }

    /// The last level.
    fn finest(&self) -> &Level {
        &self.levels()[self.levels().len() - 1]
    }

    /// Pieces of elements around a region, which do not reach beyond seams.
    fn around(
        &self,
        region: &ParameterBox,
        by: [usize; 3],
        ties: &PatchTies,
    ) -> Result<Vec<Stretch>, SplineError> {
        let mut stretches: Vec<Stretch> = vec![[(0, 1); 3]];
        for (d, k) in self.finest().knots().iter().enumerate() {
            let (lower, upper) = elements_in_direction(k, region.lower[d], region.upper[d], ties.seams[d])?;
            let pieces = grow(lower, upper, by[d], k.n_elements(), ties.seams[d]);
            let with = |s: &Stretch, piece: &(i64, i64)| {
                let mut s = *s;
                s[d] = *piece;
                s
            };
            stretches = stretches.iter().flat_map(|s| pieces.iter().map(move |p| with(s, p))).collect();
        }
        Ok(stretches)
    }

    /// The part of a stretch that lies in the patch, carried around collapsed edges.
    fn inside(&self, stretch: &Stretch, ties: &PatchTies) -> IndexBox {
        let sizes = self.finest().element_counts();
        let mut b = IndexBox {
            lower: std::array::from_fn(|d| stretch[d].0.max(0) as usize),
            upper: std::array::from_fn(|d| stretch[d].1.clamp(0, sizes[d] as i64) as usize),
        };
        carry_around(&mut b, &sizes, ties);
        b
    }
}

/// Boxes of elements of the last levels of patches, a list for each, that contain its `regions`,
/// grown by its `by` elements in every direction.
///
/// As [`SubdomainHierarchy::elements_around`] in each patch; what reaches a shared face goes on in
/// the neighbour, by as many elements as it would reach beyond the end of the patch, one at least.
///
/// # Errors
/// As [`SubdomainHierarchy::elements_around`].
pub fn elements_around(
    hierarchies: &[SubdomainHierarchy],
    regions: &[Vec<ParameterBox>],
    by: &[[usize; 3]],
    (ties, neighbours): (&[PatchTies], &Neighbours),
) -> Result<Vec<Vec<IndexBox>>, SplineError> {
    let mut boxes: Vec<Vec<IndexBox>> = vec![Vec::new(); hierarchies.len()];
    let (mut waiting, mut seen) = (Vec::new(), Vec::new());
    for (patch, own) in hierarchies.iter().enumerate() {
        for region in &regions[patch] {
            for mut stretch in own.around(region, by[patch], &ties[patch])? {
                reach_across(&mut stretch, &own.finest().element_counts(), &ties[patch]);
                waiting.push((patch, stretch));
            }
        }
    }
    waiting.reverse();
    while let Some((patch, mut stretch)) = waiting.pop() {
        let own = &hierarchies[patch];
        let sizes = own.finest().element_counts();
        let b = own.inside(&stretch, &ties[patch]);
        for d in (0..3).filter(|&d| (b.lower[d], b.upper[d]) == (0, sizes[d]) && !ties[patch].seams[d]) {
            // Carried around a collapsed edge: around it other patches may follow.
            if stretch[d].0 > 0 || stretch[d].1 < sizes[d] as i64 {
                stretch[d] = (-1, sizes[d] as i64 + 1);
            }
        }
        if b.is_empty() || seen.contains(&(patch, stretch)) {
            continue;
        }
        seen.push((patch, stretch));
        if !boxes[patch].contains(&b) {
            boxes[patch].push(b);
        }
        for face in neighbours.of(patch) {
            let there = hierarchies[face.other.patch].finest().element_counts();
            waiting.extend(beyond(&stretch, &sizes, face, &there).map(|s| (face.other.patch, s)));
        }
    }
    Ok(boxes)
}

/// Extends a stretch that touches ends of the patch beyond them by one element.
fn reach_across(stretch: &mut Stretch, sizes: &[usize; 3], ties: &PatchTies) {
    for d in (0..3).filter(|&d| !ties.seams[d]) {
        let (lower, upper) = &mut stretch[d];
        if *lower <= 0 {
            *lower = (*lower).min(-1);
        }
        if *upper >= sizes[d] as i64 {
            *upper = (*upper).max(sizes[d] as i64 + 1);
        }
    }
}

/// The part of a stretch beyond the shared face `face`, in the neighbour, whose level has so many
/// elements.
fn beyond(stretch: &Stretch, sizes: &[usize; 3], face: &SharedFace, there: &[usize; 3]) -> Option<Stretch> {
    let (lower, upper) = stretch[face.own.direction];
    let by = if face.own.upper { upper - sizes[face.own.direction] as i64 } else { -lower };
    if by <= 0 {
        return None;
    }
    let mut next = [(0, 1); 3];
    let n = there[face.other.direction] as i64;
    next[face.other.direction] = if face.other.upper { (n - by, n) } else { (0, by) };
    for d in 0..3 {
        let Some((along, is_reversed)) = face.direction(d) else { continue };
        let (lower, upper) = stretch[d];
        let n = sizes[d] as i64;
        next[along] = if is_reversed { (n - upper, n - lower) } else { (lower, upper) };
    }
    Some(next)
}

/// Elements `lower..upper` of one direction that contain an interval; with a seam they may reach
/// below 0 or above `n`.
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
        return Err(SplineError::Levels(format!(
            "region from {lower} to {upper} is not inside the parameters {start} to {end}"
        )));
    }
    let n = k.n_elements() as i64;
    if seam && upper - lower >= period {
        return Ok((0, n));
    }
    // Element of a parameter that is moved into the patch by whole turns, and the elements of those
    // turns.
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

/// Grows an interval of elements; with a seam it is cut into pieces inside `0..n`.
fn grow(lower: i64, upper: i64, by: usize, n: usize, seam: bool) -> Vec<(i64, i64)> {
    let (n, by) = (n as i64, by as i64);
    let (mut lower, mut upper) = (lower - by, upper + by);
    if !seam {
        return vec![(lower, upper)];
    }
    if lower <= 0 {
        lower = lower.min(-1);
    }
    if upper >= n {
        upper = upper.max(n + 1);
    }
    if upper - lower >= n {
        return vec![(0, n)];
    }
    let piece = |turn: i64| ((lower + turn).max(0), (upper + turn).min(n));
    [-n, 0, n].map(piece).into_iter().filter(|(l, u)| l < u).collect()
}

/// Extends a box that touches an edge collapsed onto a line over the whole direction that
/// collapses.
fn carry_around(b: &mut IndexBox, sizes: &[usize; 3], ties: &PatchTies) {
    // Extending one direction may make the box touch another such edge: three directions, three
    // rounds.
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
