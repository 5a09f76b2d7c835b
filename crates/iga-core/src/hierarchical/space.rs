//! The rational truncated hierarchical space of one patch behind the trait [`Space`] (theory Eq. H.6, H.7).

use std::ops::Range;

use rayon::prelude::*;

use super::basis::HierarchicalBasis;
use super::domain::{Leaf, SubdomainHierarchy};
use super::ties::PatchTies;
use super::truncation::{ElementOperator, Truncation, element_operator};
use super::two_scale::TwoScale;
use crate::SplineError;
use crate::bspline::basis_derivatives;
use crate::knots::{KnotVector, MAX_DEGREE};
use crate::nurbs::Patch;
use crate::nurbs::patch::{PointBasis, SECOND_DERIVATIVES, make_rational};
use crate::space::{Element, Space};

/// Mark of elements whose functions are the B-splines of their level, so that no operator is kept.
const PLAIN: usize = usize::MAX;

/// Functions `R_i = w_i T_i / W` with truncated hierarchical B-splines `T_i` and the weight function `W` of the patch.
///
/// Elements are the leaves of the hierarchy. The functions are numbered by level, then by net index, tied ones once; with
/// a single level these are the numbers of the plain patch.
#[derive(Debug, Clone)]
pub struct HierarchicalSpace {
    basis: HierarchicalBasis,
    ties: PatchTies,
    /// Active function that stands for each function of the space.
    representatives: Vec<u32>,
    control_points: Vec<[f64; 3]>,
    weights: Vec<f64>,
    leaves: Vec<Leaf>,
    /// Functions of element `e`: `functions[starts[e]..starts[e + 1]]`.
    starts: Vec<usize>,
    functions: Vec<u32>,
    /// Where in `row_ends` the rows of an element begin, or [`PLAIN`].
    operators: Vec<usize>,
    /// Entries of row `r`: `row_ends[r]..row_ends[r + 1]`.
    row_ends: Vec<usize>,
    /// Local B-spline of each entry.
    columns: Vec<u16>,
    /// Coefficients times weights.
    entries: Vec<f64>,
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
            let reason = "the coarsest level has not the knots of the patch".into();
            return Err(SplineError::Levels { reason });
        }
        let basis = HierarchicalBasis::new(hierarchy);
        let ties = PatchTies::detect(patch);
        let (points, all_weights) = net_of_active(patch, &basis)?;
        let first = ties.first_of_group(&basis);
        let (mut number, mut representatives) = (vec![0; first.len()], Vec::new());
        for (f, &g) in first.iter().enumerate() {
            if f == g as usize {
                number[f] = representatives.len() as u32;
                representatives.push(g);
            } else {
                number[f] = number[g as usize];
            }
        }
        let leaves: Vec<Leaf> = basis.hierarchy().leaves().collect();
        let operators: Vec<ElementOperator> =
            leaves.par_iter().map(|leaf| element_operator(&basis, leaf, Truncation::Truncated)).collect();
        let mut space = Self {
            control_points: representatives.iter().map(|&f| points[f as usize]).collect(),
            weights: representatives.iter().map(|&f| all_weights[f as usize]).collect(),
            starts: vec![0],
            functions: Vec::new(),
            operators: Vec::with_capacity(leaves.len()),
            row_ends: Vec::new(),
            columns: Vec::new(),
            entries: Vec::new(),
            basis,
            ties,
            representatives,
            leaves,
        };
        for operator in operators {
            space.store(&operator, &number, &all_weights);
        }
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
        self.basis.function(self.representatives[f as usize])
    }

    /// Level and place of element `e`.
    pub fn leaf(&self, e: usize) -> Leaf {
        self.leaves[e]
    }

    /// Functions active on element `e`.
    pub fn functions_on(&self, e: usize) -> &[u32] {
        &self.functions[self.starts[e]..self.starts[e + 1]]
    }

    /// Whether the functions of element `e` are the B-splines of its level, one by one.
    pub fn is_single_level(&self, e: usize) -> bool {
        self.operators[e] == PLAIN
    }

    /// Number of stored coefficients of all extraction operators.
    pub fn n_stored(&self) -> usize {
        self.entries.len()
    }

    /// Entries of local function `row` of element `e`, which is not single-level: local B-splines and weighted
    /// coefficients.
    pub(super) fn row(&self, e: usize, row: usize) -> (&[u16], &[f64]) {
        let at = self.operators[e] + row;
        let range: Range<usize> = self.row_ends[at]..self.row_ends[at + 1];
        (&self.columns[range.clone()], &self.entries[range])
    }

    /// Keeps the operator of the next element, rows of tied functions added up and multiplied by the weights.
    fn store(&mut self, operator: &ElementOperator, number: &[u32], weights: &[f64]) {
        let begin = self.functions.len();
        let n = operator.functions.len();
        // Place of each row among the functions of the element.
        let mut places = Vec::with_capacity(n);
        for &f in &operator.functions {
            let (g, w) = (number[f as usize], weights[f as usize]);
            let is_first = self.representatives[g as usize] == f;
            let known = if is_first { None } else { self.functions[begin..].iter().position(|&h| h == g) };
            places.push((known.unwrap_or(self.functions.len() - begin), w));
            if known.is_none() {
                self.functions.push(g);
            }
        }
        self.starts.push(self.functions.len());
        let own_weights = self.functions[begin..].iter().map(|&g| self.weights[g as usize].to_bits());
        let is_plain = operator.rows.is_empty()
            && self.functions.len() - begin == n
            && own_weights.eq(places.iter().map(|(_, w)| w.to_bits()));
        if is_plain {
            self.operators.push(PLAIN);
            return;
        }
        self.operators.push(self.row_ends.len());
        let width = if operator.rows.is_empty() { n } else { operator.rows.len() / n };
        let mut sums = vec![0.0; width * (self.functions.len() - begin)];
        for (r, &(place, w)) in places.iter().enumerate() {
            let sum = &mut sums[place * width..(place + 1) * width];
            match operator.rows.get(r * width..(r + 1) * width) {
                Some(row) => sum.iter_mut().zip(row).for_each(|(s, v)| *s += w * v),
                None => sum[r] += w,
            }
        }
        for sum in sums.chunks_exact(width) {
            self.row_ends.push(self.entries.len());
            for (c, &v) in sum.iter().enumerate().filter(|(_, v)| **v != 0.0) {
                self.columns.push(c as u16);
                self.entries.push(v);
            }
        }
        self.row_ends.push(self.entries.len());
    }

    /// Values and derivatives of the B-splines of an element's level, as rows of a table a direction.
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
        self.control_points.len()
    }

    fn control_points(&self) -> &[[f64; 3]] {
        &self.control_points
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
}

/// Place of `u` among rising abscissae, linear in between.
fn fractional_index(abscissae: &[f64], u: f64) -> f64 {
    let above = abscissae.partition_point(|&g| g < u).clamp(1, abscissae.len() - 1);
    let (a, b) = (abscissae[above - 1], abscissae[above]);
    // Abscissae may coincide at knots of full multiplicity.
    let share = if b > a { ((u - a) / (b - a)).clamp(0.0, 1.0) } else { 1.0 };
    (above - 1) as f64 + share
}

/// Control points and weights of all active functions: for each the coefficient of the patch's homogeneous map in the
/// B-splines of its own level (H.7).
fn net_of_active(patch: &Patch, basis: &HierarchicalBasis) -> Result<(Vec<[f64; 3]>, Vec<f64>), SplineError> {
    let sizes = patch.net_size();
    let (mut points, mut weights) = (Vec::new(), Vec::new());
    for (l, level) in basis.hierarchy().levels().iter().enumerate() {
        let relations: Result<Vec<_>, _> =
            patch.knots().iter().zip(level.knots()).map(|(c, f)| TwoScale::between(c, f)).collect();
        let (relations, own) = (relations?, level.net_size());
        for &flat in basis.active_on_level(l) {
            let index = crate::tensor::unflat(&own, flat);
            let mut sum = [0.0; 4];
            for_each_coarse(&relations, &index, |coarse, share| {
                let a = crate::tensor::flat(&sizes, &coarse[..sizes.len()]);
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

/// Calls `visit(coarse index, coefficient)` for the coarse tensor-product functions that meet fine function `index`.
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
