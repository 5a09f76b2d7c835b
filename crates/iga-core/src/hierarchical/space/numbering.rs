//! Numbers, control points and weights of the functions of a rational space (theory Eq. H.7,
//! section H.5).

use std::collections::HashMap;

use crate::SplineError;
use crate::hierarchical::basis::HierarchicalBasis;
use crate::hierarchical::neighbours::Neighbours;
use crate::hierarchical::ties::PatchTies;
use crate::hierarchical::two_scale::TwoScale;
use crate::nurbs::Patch;

/// One patch of a space.
#[derive(Debug, Clone)]
pub(super) struct Part {
    /// Active functions and regions, before tying.
    pub(super) basis: HierarchicalBasis,
    /// Seams and collapsed edges.
    pub(super) ties: PatchTies,
    /// Number of its first active function among those of all patches.
    pub(super) first_active: u32,
    /// Number of its first element.
    pub(super) first_element: usize,
}

impl Part {
    /// The parts of a space, in the order of its patches.
    pub(super) fn all(bases: Vec<HierarchicalBasis>, ties: &[PatchTies]) -> Vec<Self> {
        let (mut parts, mut first_active, mut first_element) = (Vec::new(), 0, 0);
        for (basis, ties) in bases.into_iter().zip(ties) {
            let (n_functions, n_leaves) = (basis.n_functions() as u32, basis.hierarchy().n_leaves());
            parts.push(Self { basis, ties: ties.clone(), first_active, first_element });
            (first_active, first_element) = (first_active + n_functions, first_element + n_leaves);
        }
        parts
    }
}

/// How active functions become functions of the space.
#[derive(Debug, Clone)]
pub(super) struct Numbering {
    /// Function of the space for every active function.
    pub(super) functions: Vec<u32>,
    /// Weight of every active function.
    pub(super) weights: Vec<f64>,
    /// First active function of every function of the space.
    pub(super) representatives: Vec<u32>,
    /// Control point of every function of the space \[m\].
    pub(super) control_points: Vec<[f64; 3]>,
}

impl Numbering {
    /// Numbers the active functions of all patches, tied ones once, in their order.
    ///
    /// # Errors
    /// [`SplineError::Levels`] if the levels do not refine the patches.
    pub(super) fn new(
        patches: &[Patch],
        parts: &[Part],
        neighbours: &Neighbours,
    ) -> Result<Self, SplineError> {
        let (mut points, mut weights) = (Vec::new(), Vec::new());
        for (patch, part) in patches.iter().zip(parts) {
            let (own_points, own_weights) = net_of_active(patch, &part.basis)?;
            points.extend(own_points);
            weights.extend(own_weights);
        }
        let first = first_of_groups(parts, neighbours);
        let (mut functions, mut representatives) = (vec![0; first.len()], Vec::new());
        for (f, &g) in first.iter().enumerate() {
            if f == g as usize {
                functions[f] = representatives.len() as u32;
                representatives.push(g);
            } else {
                functions[f] = functions[g as usize];
            }
        }
        let control_points = representatives.iter().map(|&f| points[f as usize]).collect();
        Ok(Self { functions, weights, representatives, control_points })
    }
}

/// For every active function of all patches the first one of those that are one function with it.
pub(super) fn first_of_groups(parts: &[Part], neighbours: &Neighbours) -> Vec<u32> {
    let mut groups = Groups::new(parts.iter().map(|part| part.basis.n_functions()).sum());
    for part in parts {
        join_ties(part, &mut groups);
    }
    join_neighbours(parts, neighbours, &mut groups);
    groups.first_of_each()
}

/// Joins the functions of a patch that its seams and collapsed sets tie.
fn join_ties(part: &Part, groups: &mut Groups) {
    let Part { basis, ties, first_active: offset, .. } = part;
    if ties.is_empty() {
        return;
    }
    // Functions with one key are one function. Keys: which tie, level, net index without the tied
    // directions.
    let mut seen: HashMap<(usize, usize, [usize; 3]), u32> = HashMap::new();
    for f in 0..basis.n_functions() as u32 {
        let (level, index) = basis.function(f);
        let sizes = basis.hierarchy().levels()[level].net_size();
        let mut join = |key| groups.join(offset + f, *seen.entry(key).or_insert(offset + f));
        for d in (0..3).filter(|&d| ties.seams[d] && (index[d] == 0 || index[d] + 1 == sizes[d])) {
            let mut rest = index;
            rest[d] = 0;
            join((d, level, rest));
        }
        for (k, set) in ties.collapsed.iter().enumerate().filter(|(_, s)| s.holds(&index, &sizes)) {
            let free = |d: usize| set.ends[d].is_none() && !set.along[d];
            let rest = std::array::from_fn(|d| if free(d) { index[d] } else { 0 });
            join((3 + k, if set.is_point() { 0 } else { level }, rest));
        }
    }
}

/// Joins active functions with their partners across shared faces.
fn join_neighbours(parts: &[Part], neighbours: &Neighbours, groups: &mut Groups) {
    for (patch, part) in parts.iter().enumerate() {
        for face in neighbours.of(patch) {
            let there = &parts[face.other.patch];
            for f in 0..part.basis.n_functions() as u32 {
                let (level, index) = part.basis.function(f);
                let sizes = [part, there].map(|p| p.basis.hierarchy().levels()[level].net_size());
                if face.holds(&index, &sizes[0])
                    && let Some(other) =
                        there.basis.number(level, &face.partner(&index, [&sizes[0], &sizes[1]]))
                {
                    groups.join(part.first_active + f, there.first_active + other);
                }
            }
        }
    }
}

/// Control points and weights of all active functions: for each the coefficient of the patch's
/// homogeneous map in the B-splines of its own level (H.7).
fn net_of_active(patch: &Patch, basis: &HierarchicalBasis) -> Result<(Vec<[f64; 3]>, Vec<f64>), SplineError> {
    let sizes = patch.net_size();
    let (mut points, mut weights) = (Vec::new(), Vec::new());
    for (l, level) in basis.hierarchy().levels().iter().enumerate() {
        let relations: Result<Vec<_>, _> =
            patch.knots().iter().zip(level.knots()).map(|(c, f)| TwoScale::between(c, f)).collect();
        let (relations, own) = (relations?, level.net_size());
        for &flat in basis.active_on_level(l) {
            let index = crate::splines::tensor::multi_index(&own, flat);
            let mut sum = [0.0; 4];
            for_each_coarse(&relations, &index, |coarse, share| {
                let a = crate::splines::tensor::flat_index(&sizes, &coarse[..sizes.len()]);
                let (w, x) = (share * patch.weights()[a], patch.control_points()[a]);
                for (s, v) in sum.iter_mut().zip([w * x[0], w * x[1], w * x[2], w]) {
                    *s += v;
                }
            });
            points.push([sum[0] / sum[3], sum[1] / sum[3], sum[2] / sum[3]]);
            weights.push(sum[3]);
        }
    }
    Ok((points, weights))
}

/// Calls `visit(coarse index, coefficient)` for the coarse tensor-product functions that meet fine
/// function `index`.
fn for_each_coarse(relations: &[TwoScale], index: &[usize; 3], mut visit: impl FnMut([usize; 3], f64)) {
    let rows: [(usize, &[f64]); 3] =
        std::array::from_fn(|d| relations.get(d).map_or((0, &[1.0][..]), |r| r.row(index[d])));
    for (k, c) in rows[2].1.iter().enumerate().filter(|(_, c)| **c != 0.0) {
        for (j, b) in rows[1].1.iter().enumerate().filter(|(_, b)| **b != 0.0) {
            for (i, a) in rows[0].1.iter().enumerate().filter(|(_, a)| **a != 0.0) {
                visit([rows[0].0 + i, rows[1].0 + j, rows[2].0 + k], a * b * c);
            }
        }
    }
}

/// Groups of functions that are one; each is known by its first member.
struct Groups {
    first: Vec<u32>,
}

impl Groups {
    /// `n_functions` groups of one function each.
    fn new(n_functions: usize) -> Self {
        Self { first: (0..n_functions as u32).collect() }
    }

    /// Joins the groups of two functions.
    fn join(&mut self, f: u32, other: u32) {
        let (a, b) = (self.root(f), self.root(other));
        self.first[a.max(b) as usize] = a.min(b);
    }

    fn root(&self, mut f: u32) -> u32 {
        while self.first[f as usize] != f {
            f = self.first[f as usize];
        }
        f
    }

    /// For every function the first one of its group.
    fn first_of_each(&self) -> Vec<u32> {
        (0..self.first.len() as u32).map(|f| self.root(f)).collect()
    }
}
