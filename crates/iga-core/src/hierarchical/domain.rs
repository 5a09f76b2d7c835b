//! Levels of knots and the nested regions in which they are used (theory Eq. H.3).

use super::index_box::{IndexBox, covers, difference, disjoint};
use super::two_scale::TwoScale;
use crate::SplineError;
use crate::splines::knots::KnotVector;

/// One level: its knots, its region and how it continues into the next level.
#[derive(Debug, Clone)]
pub struct Level {
    knots: Vec<KnotVector>,
    /// Elements `[first, end)` in the support of every function, per direction.
    supports: [Vec<[u32; 2]>; 3],
    /// Relation to the previous level; empty on level 0.
    two_scale: Vec<TwoScale>,
    /// Element of the previous level that holds each element, per direction; empty on level 0.
    parents: [Vec<u32>; 3],
    /// The region `Ω^l`: disjoint boxes of elements of this level.
    region: Vec<IndexBox>,
    /// The part of it that is `Ω^(l+1)`.
    refined: Vec<IndexBox>,
    /// Disjoint boxes of leaf elements with the number of the first of them.
    leaf_boxes: Vec<(IndexBox, usize)>,
}

/// A leaf element: an element of level `level` that is not refined further.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Leaf {
    /// Its level.
    pub level: usize,
    /// Its place among the elements of that level.
    pub index: [usize; 3],
}

/// A sequence of nested knot levels and nested regions `Ω^0 ⊇ Ω^1 ⊇ …` over one patch.
///
/// Level 0 covers the patch. Each call of [`SubdomainHierarchy::refine`] adds a level whose region
/// is a union of boxes of elements of the level before. Elements may be split into any number of
/// parts, another one in each direction and level.
#[derive(Debug, Clone)]
pub struct SubdomainHierarchy {
    levels: Vec<Level>,
    n_leaves: usize,
}

impl Level {
    fn new(knots: Vec<KnotVector>, region: Vec<IndexBox>) -> Self {
        let mut supports: [Vec<[u32; 2]>; 3] = std::array::from_fn(|_| vec![[0, 1]]);
        for (list, k) in supports.iter_mut().zip(&knots) {
            *list = function_supports(k);
        }
        let (two_scale, refined, leaf_boxes) = (Vec::new(), Vec::new(), Vec::new());
        Self { knots, supports, two_scale, parents: Default::default(), region, refined, leaf_boxes }
    }

    /// Knot vectors, one per direction.
    pub fn knots(&self) -> &[KnotVector] {
        &self.knots
    }

    /// Relation of each direction to the previous level; empty on level 0.
    pub fn two_scale(&self) -> &[TwoScale] {
        &self.two_scale
    }

    /// The region `Ω^l`, as disjoint boxes of elements of this level.
    pub fn region(&self) -> &[IndexBox] {
        &self.region
    }

    /// The part of the region that the next level refines, as disjoint boxes of elements of this
    /// level.
    pub fn refined(&self) -> &[IndexBox] {
        &self.refined
    }

    /// Elements per direction; 1 in directions that the patch does not have.
    pub fn element_counts(&self) -> [usize; 3] {
        std::array::from_fn(|d| self.knots.get(d).map_or(1, KnotVector::n_elements))
    }

    /// Number of functions in each direction; 1 in directions that the patch does not have.
    pub fn net_size(&self) -> [usize; 3] {
        std::array::from_fn(|d| self.supports[d].len())
    }

    /// Elements in the support of tensor-product function `index`.
    pub fn support(&self, index: &[usize; 3]) -> IndexBox {
        let range = |d: usize| self.supports[d][index[d]];
        IndexBox {
            lower: std::array::from_fn(|d| range(d)[0] as usize),
            upper: std::array::from_fn(|d| range(d)[1] as usize),
        }
    }

    /// The functions that do not vanish everywhere in a box of elements.
    pub fn functions_on(&self, elements: &IndexBox) -> IndexBox {
        let mut functions = IndexBox::whole([1; 3]);
        for (d, k) in self.knots.iter().enumerate() {
            functions.lower[d] = k.element_span(elements.lower[d]) - k.degree();
            functions.upper[d] = k.element_span(elements.upper[d] - 1) + 1;
        }
        functions
    }

    /// The element that holds `xi`, clamped into the patch.
    pub fn find_element(&self, xi: &[f64; 3]) -> [usize; 3] {
        std::array::from_fn(|d| self.knots.get(d).map_or(0, |k| k.find_element(xi[d])))
    }

    /// Element of the previous level that holds element `index`.
    pub fn parent(&self, index: &[usize; 3]) -> [usize; 3] {
        std::array::from_fn(|d| self.parents[d].get(index[d]).map_or(0, |&e| e as usize))
    }

    /// Boxes of elements of this level that fill a box of the previous one.
    fn children(&self, parents: &IndexBox) -> IndexBox {
        let mut children = IndexBox::whole([1; 3]);
        for d in 0..self.knots.len() {
            let first = |e: usize| self.parents[d].partition_point(|&q| (q as usize) < e);
            (children.lower[d], children.upper[d]) = (first(parents.lower[d]), first(parents.upper[d]));
        }
        children
    }
}

impl SubdomainHierarchy {
    /// One level with the given knots, one vector per direction.
    pub fn new(knots: &[KnotVector]) -> Self {
        let mut level = Level::new(knots.to_vec(), Vec::new());
        level.region = vec![IndexBox::whole(level.element_counts())];
        let mut hierarchy = Self { levels: vec![level], n_leaves: 0 };
        hierarchy.number_leaves();
        hierarchy
    }

    /// Adds a level: every element of the last level inside `boxes` is split into `parts[d]` equal
    /// parts in direction `d`. Boxes are boxes of elements of the last level so far; they may touch
    /// and overlap.
    ///
    /// # Errors
    /// [`SplineError::Levels`] if no direction is split, or one into zero parts; [`SplineError::RefinedBox`] if a box is
    /// empty, lies outside the last region, or is too small for its degree, so that no function
    /// would be refined.
    pub fn refine(&mut self, parts: [usize; 3], boxes: &[IndexBox]) -> Result<(), SplineError> {
        let parts = &parts[..self.dimension()];
        let coarse = &self.last().knots;
        if parts.contains(&0) || parts.iter().all(|&n| n == 1) {
            return Err(SplineError::Levels(format!(
                "a level that splits elements into {:?} parts refines nothing",
                parts.to_vec()
            )));
        }
        let knots: Result<Vec<_>, _> = coarse.iter().zip(parts).map(|(k, &n)| split(k, n)).collect();
        self.refine_knots(knots?, boxes)
    }

    /// Adds a level with any knots that contain those of the last level.
    ///
    /// # Errors
    /// As [`SubdomainHierarchy::refine`]; [`SplineError::Levels`] if the knots are not nested.
    pub fn refine_knots(&mut self, knots: Vec<KnotVector>, boxes: &[IndexBox]) -> Result<(), SplineError> {
        self.check_boxes(boxes, &disjoint(boxes))?;
        self.follow_knots(knots, boxes)
    }

    /// Adds a level that the neighbours of a patch need: `boxes` may be too small to refine a
    /// function, and there may be none.
    ///
    /// # Errors
    /// [`SplineError::Levels`] if the knots are not nested; [`SplineError::RefinedBox`] if a box lies outside the last region.
    pub fn follow_knots(&mut self, knots: Vec<KnotVector>, boxes: &[IndexBox]) -> Result<(), SplineError> {
        let last = self.last();
        if knots.len() != last.knots.len() {
            let (found, expected) = (knots.len(), last.knots.len());
            return Err(SplineError::Levels(format!("{found} directions after {expected}")));
        }
        if let Some(b) = boxes.iter().find(|b| !covers(&last.region, b)) {
            return Err(self.outside(b));
        }
        let refined = disjoint(boxes);
        let mut level = Level::new(knots, Vec::new());
        for (d, (coarse, fine)) in last.knots.iter().zip(&level.knots).enumerate() {
            level.two_scale.push(TwoScale::between(coarse, fine)?);
            let middle = |(a, b): (f64, f64)| 0.5 * (a + b);
            let parent = |e| coarse.find_element(middle(fine.element(e))) as u32;
            level.parents[d] = (0..fine.n_elements()).map(parent).collect();
        }
        level.region = refined.iter().map(|b| level.children(b)).collect();
        let l = self.levels.len() - 1;
        self.levels[l].refined = refined;
        self.levels.push(level);
        self.number_leaves();
        Ok(())
    }

    fn check_boxes(&self, boxes: &[IndexBox], union: &[IndexBox]) -> Result<(), SplineError> {
        let last = self.last();
        let fail = |b: &IndexBox, reason| Err(self.fault_of(b, reason));
        for b in boxes {
            if b.is_empty() {
                return fail(b, "it has no element");
            }
            if !covers(&last.region, b) {
                return Err(self.outside(b));
            }
            let refines = |f: [usize; 3]| covers(union, &last.support(&f));
            if !last.functions_on(b).elements().any(refines) {
                return fail(b, "it is too small to hold the support of a function, grow it by the degree");
            }
        }
        if boxes.is_empty() {
            return fail(&IndexBox::whole([0; 3]), "there is none");
        }
        Ok(())
    }

    fn fault_of(&self, b: &IndexBox, reason: &'static str) -> SplineError {
        SplineError::RefinedBox { level: self.levels.len() - 1, lower: b.lower, upper: b.upper, reason }
    }

    fn outside(&self, b: &IndexBox) -> SplineError {
        self.fault_of(b, "it is not inside the region of this level, refine more on the level before")
    }

    fn number_leaves(&mut self) {
        let mut first = 0;
        for level in &mut self.levels {
            level.leaf_boxes.clear();
            for b in difference(&level.region, &level.refined) {
                level.leaf_boxes.push((b, first));
                first += b.count();
            }
        }
        self.n_leaves = first;
    }

    fn last(&self) -> &Level {
        &self.levels[self.levels.len() - 1]
    }

    /// Number of parametric directions.
    pub fn dimension(&self) -> usize {
        self.levels[0].knots.len()
    }

    /// The levels, coarsest first.
    pub fn levels(&self) -> &[Level] {
        &self.levels
    }

    /// Number of leaf elements.
    pub fn n_leaves(&self) -> usize {
        self.n_leaves
    }

    /// All leaf elements in the order of their numbers.
    pub fn leaves(&self) -> impl Iterator<Item = Leaf> + '_ {
        self.levels.iter().enumerate().flat_map(|(level, l)| {
            l.leaf_boxes.iter().flat_map(move |(b, _)| b.elements().map(move |index| Leaf { level, index }))
        })
    }

    /// The leaf that holds `xi` (clamped into the patch) and its number.
    pub fn find_leaf(&self, xi: &[f64; 3]) -> (Leaf, usize) {
        let mut level = 0;
        let mut index = self.levels[0].find_element(xi);
        while self.levels[level].refined.iter().any(|b| b.holds(&index)) {
            level += 1;
            index = self.levels[level].find_element(xi);
        }
        let leaf = Leaf { level, index };
        (leaf, self.leaf_number(&leaf))
    }

    /// Number of a leaf.
    ///
    /// # Panics
    /// If the element is not a leaf.
    pub fn leaf_number(&self, leaf: &Leaf) -> usize {
        let boxes = &self.levels[leaf.level].leaf_boxes;
        let found = boxes.iter().find(|(b, _)| b.holds(&leaf.index));
        let (b, first) = found.expect("the leaf boxes of a level are its region without the refined part");
        let n = b.sizes();
        let at = |d: usize| leaf.index[d] - b.lower[d];
        first + at(0) + n[0] * (at(1) + n[1] * at(2))
    }

    /// The ancestor on level `level` of an element of a finer level.
    pub fn ancestor(&self, leaf: &Leaf, level: usize) -> [usize; 3] {
        let mut index = leaf.index;
        for l in (level + 1..=leaf.level).rev() {
            index = self.levels[l].parent(&index);
        }
        index
    }
}

/// Splits every element into `parts` equal parts; knots there stay as they are, new ones are
/// simple.
fn split(coarse: &KnotVector, parts: usize) -> Result<KnotVector, SplineError> {
    let mut knots = Vec::with_capacity(coarse.knots().len() + coarse.n_elements() * (parts - 1));
    for (i, &u) in coarse.knots().iter().enumerate() {
        knots.push(u);
        if let Some(&next) = coarse.knots().get(i + 1).filter(|&&next| next > u) {
            knots.extend((1..parts).map(|k| u + (next - u) * (k as f64 / parts as f64)));
        }
    }
    KnotVector::new(coarse.degree(), knots)
}

/// Elements `[first, end)` on which each function does not vanish.
fn function_supports(k: &KnotVector) -> Vec<[u32; 2]> {
    let spans: Vec<usize> = (0..k.n_elements()).map(|e| k.element_span(e)).collect();
    let count = |below: usize| spans.partition_point(|&s| s < below) as u32;
    (0..k.n_functions()).map(|i| [count(i), count(i + k.degree() + 1)]).collect()
}
