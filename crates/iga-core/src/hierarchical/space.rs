//! The rational truncated hierarchical space of one or more patches behind the trait [`Space`]
//! (theory Eq. H.6, H.7).

mod numbering;
mod columns;
mod extraction;
mod seams;
mod tables;
mod combinations;

use super::basis::HierarchicalBasis;
use super::domain::{Leaf, Level, SubdomainHierarchy};
use super::neighbours::Neighbours;
use super::ties::PatchTies;
use crate::SplineError;
use crate::nurbs::Patch;
use crate::nurbs::interface::FaceId;
use crate::nurbs::jet::dot;
use crate::nurbs::patch::{PointBasis, make_rational};
use crate::space::{
    Cell, Combination, Element, GridBasis, Integrand, PatchSpace, Space, SplineSpace, tabulate_spline,
};
use crate::splines::knots::KnotVector;
use crate::splines::tensor;
use columns::Columns;
use combinations::of_level;
use extraction::extraction;
use numbering::{Numbering, Part, first_of_groups};
use tables::{evaluate_level, scale};

/// Functions `R_i = w_i T_i / W` with truncated hierarchical B-splines `T_i` and the weight
/// function `W` of their patch, continuous across faces that patches share (H.9).
///
/// Elements are the leaves of the hierarchies, patch by patch. The functions are numbered by patch,
/// level, then net index, tied ones once; with a single level these are the numbers of the plain
/// patches.
#[derive(Debug, Clone)]
pub struct HierarchicalSpace {
    /// One a patch.
    parts: Vec<Part>,
    neighbours: Neighbours,
    numbering: Numbering,
    weights: Vec<f64>,
    leaves: Vec<Leaf>,
    columns: Columns,
}

impl HierarchicalSpace {
    /// Builds the space of `hierarchy`, whose coarsest level has the knots of `patch`.
    ///
    /// # Errors
    /// As [`HierarchicalSpace::of_patches`].
    pub fn new(patch: &Patch, hierarchy: SubdomainHierarchy) -> Result<Self, SplineError> {
        Self::of_patches(std::slice::from_ref(patch), vec![hierarchy])
    }

    /// Builds the space of `hierarchies`, whose coarsest levels have the knots of `patches`, one
    /// for each. All have the same number of levels, and on each the same knots along faces that
    /// patches share.
    ///
    /// Control points and weights are the coefficients of the patches' homogeneous maps, which the
    /// truncated basis keeps level by level (H.7): the geometry stays as it is.
    ///
    /// # Errors
    /// [`SplineError::Levels`] if knots or numbers of levels differ, or patches meet at an edge or corner without a face;
    /// [`SplineError::OpenSeam`] if a seam or collapsed edge is refined on one side only.
    pub fn of_patches(patches: &[Patch], hierarchies: Vec<SubdomainHierarchy>) -> Result<Self, SplineError> {
        let ties: Vec<PatchTies> = patches.iter().map(PatchTies::detect).collect();
        let neighbours = Neighbours::detect(patches, &ties);
        check_levels(patches, &hierarchies, &neighbours)?;
        check_edges(patches, &ties, &neighbours)?;
        let parts = Part::all(HierarchicalBasis::of_patches(hierarchies, &neighbours, &ties), &ties);
        let numbering = Numbering::new(patches, &parts, &neighbours)?;
        let weights = numbering.representatives.iter().map(|&f| numbering.weights[f as usize]).collect();
        let leaves: Vec<Leaf> = parts.iter().flat_map(|part| part.basis.hierarchy().leaves()).collect();
        let columns = extraction(&parts, &leaves, &numbering);
        let space = Self { parts, neighbours, numbering, weights, leaves, columns };
        space.check_seams()?;
        Ok(space)
    }

    /// The space of the patch itself, as a hierarchy of one level.
    ///
    /// # Errors
    /// As [`HierarchicalSpace::new`].
    pub fn plain(patch: &Patch) -> Result<Self, SplineError> {
        Self::plain_patches(std::slice::from_ref(patch))
    }

    /// The space of the patches themselves, of one level: that of [`crate::space::PatchSpace`].
    ///
    /// # Errors
    /// As [`HierarchicalSpace::of_patches`].
    pub fn plain_patches(patches: &[Patch]) -> Result<Self, SplineError> {
        Self::of_patches(patches, patches.iter().map(|p| SubdomainHierarchy::new(p.knots())).collect())
    }

    /// The space of the patches turned by the rotation matrix `rotation` (rows) about the origin of
    /// their frame: functions of the same numbers and parameters.
    #[must_use]
    pub fn rotated(&self, rotation: &[[f64; 3]; 3]) -> Self {
        let mut turned = self.clone();
        for point in &mut turned.numbering.control_points {
            *point = rotation.map(|row| dot(&row, point));
        }
        turned
    }

    /// Number of patches.
    pub fn n_patches(&self) -> usize {
        self.parts.len()
    }

    /// Active functions and regions of a patch, before tying.
    pub fn basis(&self, patch: usize) -> &HierarchicalBasis {
        &self.parts[patch].basis
    }

    /// Seams and collapsed edges of a patch.
    pub fn ties(&self, patch: usize) -> &PatchTies {
        &self.parts[patch].ties
    }

    /// Faces that patches share.
    pub fn neighbours(&self) -> &Neighbours {
        &self.neighbours
    }

    /// Weight of every function; that of the first one of a tied group.
    pub fn weights(&self) -> &[f64] {
        &self.weights
    }

    /// Level and net index of function `f`; those of the first one of a tied group.
    pub fn level_and_index(&self, f: u32) -> (usize, [usize; 3]) {
        let (patch, active) = self.patch_of_active(self.numbering.representatives[f as usize]);
        self.parts[patch].basis.function(active)
    }

    /// Patch of active function `active` of all patches, and its number there.
    fn patch_of_active(&self, active: u32) -> (usize, u32) {
        let patch = self.parts.partition_point(|p| p.first_active <= active) - 1;
        (patch, active - self.parts[patch].first_active)
    }

    /// Every active function of a patch: its function of the space, level, net index and weight.
    pub(super) fn active_of(&self, patch: usize) -> impl Iterator<Item = (u32, usize, [usize; 3], f64)> + '_ {
        let Part { basis, first_active, .. } = &self.parts[patch];
        (0..basis.n_functions() as u32).map(move |f| {
            let (level, index) = basis.function(f);
            let active = (first_active + f) as usize;
            (self.numbering.functions[active], level, index, self.numbering.weights[active])
        })
    }

    /// Function of the space that active function `active` of the basis of a patch is; tied ones
    /// are one.
    pub fn function_of(&self, patch: usize, active: u32) -> u32 {
        self.numbering.functions[(self.parts[patch].first_active + active) as usize]
    }

    /// Elements of a patch.
    fn elements_of(&self, patch: usize) -> std::ops::Range<usize> {
        let Part { basis, first_element, .. } = &self.parts[patch];
        *first_element..first_element + basis.hierarchy().n_leaves()
    }

    /// Patch of element `e`.
    fn patch_of(&self, e: usize) -> usize {
        self.parts.partition_point(|p| p.first_element <= e) - 1
    }

    /// The level of knots of element `e`, in its patch.
    fn level_of(&self, e: usize) -> &Level {
        &self.parts[self.patch_of(e)].basis.hierarchy().levels()[self.leaves[e].level]
    }

    /// Level and place of element `e`.
    pub fn leaf(&self, e: usize) -> Leaf {
        self.leaves[e]
    }

    /// Functions active on element `e`.
    pub fn functions_on(&self, e: usize) -> &[u32] {
        self.columns.functions(e)
    }

    /// Whether the functions of element `e` are the B-splines of its level, one by one.
    pub fn is_single_level(&self, e: usize) -> bool {
        self.columns.is_plain(e)
    }

    /// Number of stored coefficients of all extraction operators.
    pub fn n_stored(&self) -> usize {
        self.columns.n_stored()
    }

    /// Sums of the numbers `raw` of the B-splines of element `e`, which is not single-level, with
    /// the weighted coefficients of each of its functions.
    pub(super) fn combined(&self, e: usize, raw: &[f64]) -> Vec<f64> {
        self.columns.combined(e, raw)
    }
}

/// Checks that levels are those of the patches, and that patches have the same knots where they
/// meet.
fn check_levels(
    patches: &[Patch],
    hierarchies: &[SubdomainHierarchy],
    neighbours: &Neighbours,
) -> Result<(), SplineError> {
    let expected = hierarchies.first().map_or(0, |h| h.levels().len());
    for (patch, of_patch) in patches.iter().enumerate() {
        let found = hierarchies.get(patch).map_or(0, |h| h.levels().len());
        if found != expected || expected == 0 {
            return Err(SplineError::Levels(format!(
                "patch {patch} has {found} levels, the first one has {expected}"
            )));
        }
        if hierarchies[patch].levels()[0].knots() != of_patch.knots() {
            return Err(SplineError::Levels("the coarsest level has not the knots of the patch".into()));
        }
    }
    for (patch, own) in hierarchies.iter().enumerate() {
        for face in neighbours.of(patch) {
            let there = &hierarchies[face.other.patch];
            for (level, (a, b)) in own.levels().iter().zip(there.levels()).enumerate() {
                let is_same = |d: usize| {
                    face.direction(d).is_none_or(|(other, is_reversed)| {
                        same_breaks(&a.knots()[d], &b.knots()[other], is_reversed)
                    })
                };
                if !(0..a.knots().len()).all(is_same) {
                    let patches = [patch, face.other.patch];
                    return Err(SplineError::Levels(format!(
                        "patches {} and {} have other knots on level {level} along the face that they share",
                        patches[0], patches[1]
                    )));
                }
            }
        }
    }
    Ok(())
}

/// Checks that patches share functions through faces alone: those of the patches themselves are
/// then the ones whose control points coincide.
fn check_edges(patches: &[Patch], ties: &[PatchTies], neighbours: &Neighbours) -> Result<(), SplineError> {
    if patches.len() == 1 {
        return Ok(());
    }
    let plain = patches.iter().map(|p| SubdomainHierarchy::new(p.knots())).collect();
    let parts = Part::all(HierarchicalBasis::of_patches(plain, neighbours, ties), ties);
    let first = first_of_groups(&parts, neighbours);
    let n_functions = first.iter().enumerate().filter(|&(f, first)| f == *first as usize).count();
    match PatchSpace::new(patches.to_vec())?.n_functions() == n_functions {
        true => Ok(()),
        false => Err(SplineError::Levels(
            "patches meet at an edge or a corner without faces that they share around it, and cannot be \
         refined there"
                .into(),
        )),
    }
}

/// Difference of knots, as a share of their range, that is round-off.
const SAME_KNOT: f64 = 1e-12;

/// Whether two knot vectors are the same, one of them from its end if `is_reversed`, in shares of
/// their ranges.
fn same_breaks(a: &KnotVector, b: &KnotVector, is_reversed: bool) -> bool {
    let n = a.knots().len();
    let share = |k: &KnotVector, i: usize| {
        let (first, last) = k.domain();
        (k.knots()[i] - first) / (last - first)
    };
    let partner = |i: usize| if is_reversed { 1.0 - share(b, n - 1 - i) } else { share(b, i) };
    a.degree() == b.degree()
        && b.knots().len() == n
        && (0..n).all(|i| (share(a, i) - partner(i)).abs() <= SAME_KNOT)
}

impl Space for HierarchicalSpace {
    fn dimension(&self) -> usize {
        self.basis(0).hierarchy().dimension()
    }

    fn n_functions(&self) -> usize {
        self.numbering.control_points.len()
    }

    fn control_points(&self) -> &[[f64; 3]] {
        &self.numbering.control_points
    }

    /// Points by which functions are ordered: on one patch their Greville abscissae, in net indices
    /// of the coarsest level, on several their control points.
    fn anchors(&self) -> Vec<[f64; 3]> {
        if self.parts.len() > 1 {
            return self.control_points().to_vec();
        }
        let levels = self.basis(0).hierarchy().levels();
        let abscissae: Vec<Vec<Vec<f64>>> =
            levels.iter().map(|l| l.knots().iter().map(KnotVector::greville).collect()).collect();
        let anchor = |f| {
            let (level, index) = self.level_and_index(f);
            let place = |d: usize| {
                abscissae[level].get(d).map_or(0.0, |own| fractional_index(&abscissae[0][d], own[index[d]]))
            };
            std::array::from_fn(place)
        };
        (0..self.n_functions() as u32).map(anchor).collect()
    }

    fn n_elements(&self) -> usize {
        self.leaves.len()
    }

    fn element(&self, e: usize) -> Element {
        let index = self.leaves[e].index;
        let (mut lower, mut upper) = ([0.0; 3], [0.0; 3]);
        for (d, k) in self.level_of(e).knots().iter().enumerate() {
            (lower[d], upper[d]) = k.element(index[d]);
        }
        Element { patch: self.patch_of(e), cell: Cell::Box, lower, upper }
    }

    fn tabulate(&self, e: usize, integrand: Integrand, out: &mut GridBasis) {
        tabulate_spline(self, e, integrand, out);
    }

    fn active_functions(&self, e: usize, out: &mut Vec<u32>) {
        out.clear();
        out.extend_from_slice(self.functions_on(e));
    }

    fn evaluate(&self, e: usize, xi: &[f64; 3], n_derivatives: usize, out: &mut PointBasis) {
        evaluate_level(self.level_of(e).knots(), self.leaves[e].index, xi, n_derivatives, out);
        if self.is_single_level(e) {
            scale(out, self.functions_on(e).iter().map(|&f| self.weights[f as usize]));
        } else {
            self.columns.combine(e, out);
        }
        make_rational(out);
    }

    /// Sets of the elements of a level of a patch whose functions are not its B-splines, one by
    /// one.
    fn combinations(&self) -> Vec<Combination<'_>> {
        let place = |e: &usize| (self.patch_of(*e), self.leaves[*e].level);
        let elements: Vec<usize> = (0..self.leaves.len()).filter(|&e| !self.is_single_level(e)).collect();
        let sets = elements.chunk_by(|a, b| place(a) == place(b));
        sets.map(|set| of_level(self, &self.columns, self.level_of(set[0]), &self.leaves, set)).collect()
    }
}

impl SplineSpace for HierarchicalSpace {
    fn find_element(&self, patch: usize, xi: &[f64; 3]) -> usize {
        let part = &self.parts[patch];
        part.first_element + part.basis.hierarchy().find_leaf(xi).1
    }

    /// `p` where the functions are the B-splines of one level that is `C^(p-1)` on both sides;
    /// `p + 1` elsewhere and also for `p = 1` or a single element between two ends, where `p`
    /// points would leave energy-free motions.
    fn gauss_counts(&self, e: usize) -> [usize; 3] {
        let leaf = self.leaves[e];
        let mut counts = [1; 3];
        for (d, k) in self.level_of(e).knots().iter().enumerate() {
            let (p, (lower, upper), (start, end)) = (k.degree(), k.element(leaf.index[d]), k.domain());
            let is_smooth = (lower <= start || k.multiplicity(lower) == 1)
                && (upper >= end || k.multiplicity(upper) == 1)
                && (lower > start || upper < end);
            counts[d] = if is_smooth && p > 1 && self.is_single_level(e) { p } else { p + 1 };
        }
        counts
    }

    /// The abscissae of a function are those of the B-spline of its level that it was truncated
    /// from. Inside a region of one level, at least the degree away from its border, these are the
    /// points of a plain patch with the knots of that level.
    fn greville(&self, face: FaceId) -> Vec<(u32, [f64; 3])> {
        let mut found = Vec::new();
        let mut first = 0;
        let basis = self.basis(face.patch);
        for (l, level) in basis.hierarchy().levels().iter().enumerate() {
            let sizes = level.net_size();
            let abscissae: Vec<Vec<f64>> = level.knots().iter().map(KnotVector::greville).collect();
            let layer = if face.upper { sizes[face.direction] - 1 } else { 0 };
            let active = basis.active_on_level(l);
            for (number, &flat) in active.iter().enumerate() {
                let index = tensor::multi_index(&sizes, flat);
                if index[face.direction] == layer {
                    let place = |d: usize| abscissae.get(d).map_or(0.0, |own| own[index[d]]);
                    found.push((
                        self.function_of(face.patch, (first + number) as u32),
                        std::array::from_fn(place),
                    ));
                }
            }
            first += active.len();
        }
        found
    }
}

/// Place of `u` among rising abscissae, linear in between.
fn fractional_index(abscissae: &[f64], u: f64) -> f64 {
    let above = abscissae.partition_point(|&g| g < u).clamp(1, abscissae.len() - 1);
    let (a, b) = (abscissae[above - 1], abscissae[above]);
    // Abscissae may coincide at knots of full multiplicity.
    let share = if b > a { ((u - a) / (b - a)).clamp(0.0, 1.0) } else { 1.0 };
    (above - 1) as f64 + share
}
