//! The rational truncated hierarchical space of one patch behind the trait [`Space`] (theory Eq. H.6, H.7).

use super::basis::HierarchicalBasis;
use super::domain::{Leaf, SubdomainHierarchy};
use super::extraction::Extraction;
use super::numbering::Numbering;
use super::ties::PatchTies;
use crate::SplineError;
use crate::bspline::basis_derivatives;
use crate::knots::{KnotVector, MAX_DEGREE};
use crate::nurbs::Patch;
use crate::nurbs::interface::FaceId;
use crate::nurbs::patch::{PointBasis, SECOND_DERIVATIVES, make_rational};
use crate::space::{Element, Space};
use crate::spline_fault::LevelFault;
use crate::tensor;

/// Functions `R_i = w_i T_i / W` with truncated hierarchical B-splines `T_i` and the weight function `W` of the patch.
///
/// Elements are the leaves of the hierarchy. The functions are numbered by level, then by net index, tied ones once; with
/// a single level these are the numbers of the plain patch.
#[derive(Debug, Clone)]
pub struct HierarchicalSpace {
    basis: HierarchicalBasis,
    ties: PatchTies,
    numbering: Numbering,
    weights: Vec<f64>,
    leaves: Vec<Leaf>,
    extraction: Extraction,
}

impl HierarchicalSpace {
    /// Builds the space of `hierarchy`, whose coarsest level has the knots of `patch`.
    ///
    /// Control points and weights are the coefficients of the patch's homogeneous map, which the truncated basis keeps
    /// level by level (H.7): the geometry stays as it is.
    ///
    /// # Errors
    /// [`SplineError::Levels`] if the knots differ; [`SplineError::OpenSeam`] if a seam or collapsed edge is refined on
    /// one side only.
    pub fn new(patch: &Patch, hierarchy: SubdomainHierarchy) -> Result<Self, SplineError> {
        if hierarchy.levels()[0].knots() != patch.knots() {
            return Err(LevelFault::OtherPatch.into());
        }
        let basis = HierarchicalBasis::new(hierarchy);
        let ties = PatchTies::detect(patch);
        let numbering = Numbering::new(patch, &basis, &ties)?;
        let weights = numbering.representatives.iter().map(|&f| numbering.weights[f as usize]).collect();
        let leaves: Vec<Leaf> = basis.hierarchy().leaves().collect();
        let extraction = Extraction::new(&basis, &leaves, &numbering);
        let space = Self { basis, ties, numbering, weights, leaves, extraction };
        space.check_seams()?;
        Ok(space)
    }

    /// The space of the patch itself, as a hierarchy of one level.
    ///
    /// # Errors
    /// As [`HierarchicalSpace::new`].
    pub fn plain(patch: &Patch) -> Result<Self, SplineError> {
        Self::new(patch, SubdomainHierarchy::new(patch.knots()))
    }

    /// Active functions and regions, before tying.
    pub fn basis(&self) -> &HierarchicalBasis {
        &self.basis
    }

    /// Seams and collapsed edges of the patch.
    pub fn ties(&self) -> &PatchTies {
        &self.ties
    }

    /// Weight of every function; that of the first one of a tied group.
    pub fn weights(&self) -> &[f64] {
        &self.weights
    }

    /// Level and net index of function `f`; those of the first one of a tied group.
    pub fn level_and_index(&self, f: u32) -> (usize, [usize; 3]) {
        self.basis.function(self.numbering.representatives[f as usize])
    }

    /// Function of the space that active function `active` of the basis is; tied ones are one.
    pub fn function_of(&self, active: u32) -> u32 {
        self.numbering.functions[active as usize]
    }

    /// Level and place of element `e`.
    pub fn leaf(&self, e: usize) -> Leaf {
        self.leaves[e]
    }

    /// Functions active on element `e`.
    pub fn functions_on(&self, e: usize) -> &[u32] {
        self.extraction.functions_on(e)
    }

    /// Whether the functions of element `e` are the B-splines of its level, one by one.
    pub fn is_single_level(&self, e: usize) -> bool {
        self.extraction.is_plain(e)
    }

    /// Number of stored coefficients of all extraction operators.
    pub fn n_stored(&self) -> usize {
        self.extraction.n_stored()
    }

    /// Entries of local function `row` of element `e`, which is not single-level: local B-splines and weighted
    /// coefficients.
    pub(super) fn row(&self, e: usize, row: usize) -> (&[u16], &[f64]) {
        self.extraction.row(e, row)
    }

    /// Values and derivatives of the B-splines of an element's level, as rows of a table per direction.
    fn tables(&self, leaf: &Leaf, xi: &[f64; 3], n_derivatives: usize) -> Tables {
        let mut tables = Tables { values: [[0.0; ROW]; 3], orders: [1; 3], dimension: self.dimension() };
        for table in &mut tables.values {
            table[0] = 1.0; // absent directions: the constant function
        }
        for (d, k) in self.basis.hierarchy().levels()[leaf.level].knots().iter().enumerate() {
            tables.orders[d] = k.degree() + 1;
            basis_derivatives(k, leaf.index[d], xi[d], n_derivatives, &mut tables.values[d]);
        }
        tables
    }
}

const ROW: usize = 3 * (MAX_DEGREE + 1);

/// One-dimensional tables of an evaluation.
struct Tables {
    values: [[f64; ROW]; 3],
    orders: [usize; 3],
    dimension: usize,
}

impl Tables {
    fn count(&self) -> usize {
        self.orders.iter().product()
    }

    /// Derivative of order `k[d]` in direction `d` of all tensor-product functions.
    fn product(&self, k: [usize; 3], mut put: impl FnMut(usize, f64)) {
        let line = |d: usize| &self.values[d][k[d] * self.orders[d]..(k[d] + 1) * self.orders[d]];
        let (mut at, lines) = (0, [line(0), line(1), line(2)]);
        for c in lines[2] {
            for b in lines[1] {
                let bc = b * c;
                for a in lines[0] {
                    put(at, a * bc);
                    at += 1;
                }
            }
        }
    }

    /// Fills the lists behind entry `from` with the tensor-product functions.
    fn fill(&self, n_derivatives: usize, from: usize, out: &mut PointBasis) {
        self.product([0; 3], |i, v| out.values[from + i] = v);
        for d in 0..if n_derivatives >= 1 { self.dimension } else { 0 } {
            let order = std::array::from_fn(|k| usize::from(k == d));
            self.product(order, |i, v| out.first[from + i][d] = v);
        }
        for (s, &(a, b)) in SECOND_DERIVATIVES.iter().enumerate() {
            if n_derivatives >= 2 && b < self.dimension {
                let order = std::array::from_fn(|k| usize::from(k == a) + usize::from(k == b));
                self.product(order, |i, v| out.second[from + i][s] = v);
            }
        }
    }
}

/// Resizes the lists that are asked for and empties the others.
fn resize(out: &mut PointBasis, n: usize, n_derivatives: usize) {
    out.values.clear();
    out.first.clear();
    out.second.clear();
    out.values.resize(n, 0.0);
    out.first.resize(if n_derivatives >= 1 { n } else { 0 }, [0.0; 3]);
    out.second.resize(if n_derivatives >= 2 { n } else { 0 }, [0.0; 6]);
}

/// Sum of `coefficients` times the entries `columns` of `list`.
fn combine<const N: usize>(list: &[[f64; N]], columns: &[u16], coefficients: &[f64]) -> [f64; N] {
    let mut sum = [0.0; N];
    for (&c, v) in columns.iter().zip(coefficients) {
        for (s, x) in sum.iter_mut().zip(&list[c as usize]) {
            *s += v * x;
        }
    }
    sum
}

impl Space for HierarchicalSpace {
    fn dimension(&self) -> usize {
        self.basis.hierarchy().dimension()
    }

    fn n_functions(&self) -> usize {
        self.numbering.control_points.len()
    }

    fn control_points(&self) -> &[[f64; 3]] {
        &self.numbering.control_points
    }

    /// Greville abscissae, in net indices of the coarsest level.
    fn anchors(&self) -> Vec<[f64; 3]> {
        let levels = self.basis.hierarchy().levels();
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
        let leaf = self.leaves[e];
        let (mut lower, mut upper) = ([0.0; 3], [0.0; 3]);
        for (d, k) in self.basis.hierarchy().levels()[leaf.level].knots().iter().enumerate() {
            (lower[d], upper[d]) = k.element(leaf.index[d]);
        }
        Element { patch: 0, lower, upper }
    }

    fn find_element(&self, _patch: usize, xi: &[f64; 3]) -> usize {
        self.basis.hierarchy().find_leaf(xi).1
    }

    /// `p` where the functions are the B-splines of one level that is `C^(p-1)` on both sides; `p + 1` elsewhere and also
    /// for `p = 1` or a single element between two ends, where `p` points would leave energy-free motions.
    fn gauss_counts(&self, e: usize) -> [usize; 3] {
        let leaf = self.leaves[e];
        let mut counts = [1; 3];
        for (d, k) in self.basis.hierarchy().levels()[leaf.level].knots().iter().enumerate() {
            let (p, (lower, upper), (start, end)) = (k.degree(), k.element(leaf.index[d]), k.domain());
            let is_smooth = (lower <= start || k.multiplicity(lower) == 1)
                && (upper >= end || k.multiplicity(upper) == 1)
                && (lower > start || upper < end);
            counts[d] = if is_smooth && p > 1 && self.is_single_level(e) { p } else { p + 1 };
        }
        counts
    }

    fn active_functions(&self, e: usize, out: &mut Vec<u32>) {
        out.clear();
        out.extend_from_slice(self.functions_on(e));
    }

    fn evaluate(&self, e: usize, xi: &[f64; 3], n_derivatives: usize, out: &mut PointBasis) {
        debug_assert!(n_derivatives <= 2);
        let tables = self.tables(&self.leaves[e], xi, n_derivatives);
        let functions = self.functions_on(e);
        let n = functions.len();
        if self.is_single_level(e) {
            resize(out, n, n_derivatives);
            tables.fill(n_derivatives, 0, out);
            for (i, &f) in functions.iter().enumerate() {
                let w = self.weights[f as usize];
                out.values[i] *= w;
                out.first.get_mut(i).into_iter().flatten().for_each(|v| *v *= w);
                out.second.get_mut(i).into_iter().flatten().for_each(|v| *v *= w);
            }
        } else {
            // The B-splines of the level stand behind the functions while these are made from them.
            resize(out, n + tables.count(), n_derivatives);
            tables.fill(n_derivatives, n, out);
            for i in 0..n {
                let (columns, coefficients) = self.row(e, i);
                let terms = columns.iter().zip(coefficients);
                out.values[i] = terms.map(|(&c, v)| v * out.values[n + c as usize]).sum();
                if n_derivatives >= 1 {
                    out.first[i] = combine(&out.first[n..], columns, coefficients);
                }
                if n_derivatives >= 2 {
                    out.second[i] = combine(&out.second[n..], columns, coefficients);
                }
            }
            out.values.truncate(n);
            out.first.truncate(n);
            out.second.truncate(n);
        }
        make_rational(out);
    }

    /// The abscissae of a function are those of the B-spline of its level that it was truncated from. Inside a region of one level, at
    /// least the degree away from its border, these are the points of a plain patch with the knots of that level.
    fn greville(&self, face: FaceId) -> Vec<(u32, [f64; 3])> {
        let mut found = Vec::new();
        let mut first = 0;
        for (l, level) in self.basis.hierarchy().levels().iter().enumerate() {
            let sizes = level.net_size();
            let abscissae: Vec<Vec<f64>> = level.knots().iter().map(KnotVector::greville).collect();
            let layer = if face.upper { sizes[face.direction] - 1 } else { 0 };
            let active = self.basis.active_on_level(l);
            for (number, &flat) in active.iter().enumerate() {
                let index = tensor::multi_index(&sizes, flat);
                if index[face.direction] == layer {
                    let place = |d: usize| abscissae.get(d).map_or(0.0, |own| own[index[d]]);
                    found.push((self.function_of((first + number) as u32), std::array::from_fn(place)));
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
