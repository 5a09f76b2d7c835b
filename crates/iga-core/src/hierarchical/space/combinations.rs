//! Raw functions of the elements of one level: its B-splines, rational as the patch (theory
//! Eq. H.10).

use faer::sparse::{SparseColMat, SymbolicSparseColMat};

use super::columns::Columns;
use super::tables::{evaluate_level, scale};
use crate::hierarchical::IndexBox;
use crate::hierarchical::domain::{Leaf, Level};
use crate::nurbs::patch::{PointBasis, make_rational};
use crate::space::{
    Combination, Element, GridBasis, Integrand, LocalWeights, Space, SplineSpace, evaluate_tensor,
    tabulate_box,
};
use crate::splines::knots::KnotVector;
use crate::splines::tensor;

/// Elements of one level of a patch with its B-splines: `Q_m = v_m N_m / W`.
struct LevelSpace<'a> {
    space: &'a dyn SplineSpace,
    knots: &'a [KnotVector],
    /// The elements: their numbers in the space and their places on the level.
    elements: Vec<(usize, [usize; 3])>,
    /// B-splines that do not vanish on an element.
    n_local: usize,
    /// Their numbers, element by element.
    numbers: Vec<u32>,
    /// Their weights `v_m = Σ_i C_im`, element by element.
    weights: Vec<f64>,
    /// `Σ_i B_im P_i` of each.
    control_points: Vec<[f64; 3]>,
}

/// The combination of `elements`, which are leaves of one level of a patch of the space and none of
/// them plain in `all`.
pub(super) fn of_level<'a>(
    space: &'a dyn SplineSpace,
    all: &Columns,
    level: &'a Level,
    leaves: &[Leaf],
    elements: &[usize],
) -> Combination<'a> {
    let sizes = level.net_size();
    let mut places = Vec::new();
    for &e in elements {
        let lower = leaves[e].index;
        let functions = level.functions_on(&IndexBox { lower, upper: lower.map(|i| i + 1) });
        places.extend(functions.elements().map(|f| tensor::flat_index(&sizes, &f)));
    }
    let n_local = places.len() / elements.len();
    let mut of_level = places.clone();
    of_level.sort_unstable();
    of_level.dedup();
    let number = |place: &usize| of_level.partition_point(|p| p < place) as u32;
    let numbers: Vec<u32> = places.iter().map(number).collect();
    let entries = entries(all, elements, &numbers, of_level.len());
    let mut functions: Vec<u32> = entries.iter().flatten().map(|&(f, _)| f).collect();
    functions.sort_unstable();
    functions.dedup();
    let (mut starts, mut rows, mut values) = (vec![0u32], Vec::new(), Vec::new());
    let (mut weights, mut control_points) = (Vec::new(), Vec::new());
    for column in &entries {
        let weight: f64 = column.iter().map(|(_, c)| c).sum();
        let mut point = [0.0; 3];
        for &(f, c) in column {
            rows.push(functions.partition_point(|&g| g < f) as u32);
            values.push(c / weight);
            let control = &space.control_points()[f as usize];
            point.iter_mut().zip(control).for_each(|(x, p)| *x += c / weight * p);
        }
        starts.push(rows.len() as u32);
        weights.push(weight);
        control_points.push(point);
    }
    let size = (functions.len(), of_level.len());
    let symbolic = SymbolicSparseColMat::new_checked(size.0, size.1, starts, None, rows);
    let coefficients = SparseColMat::new(symbolic, values);
    let weights = numbers.iter().map(|&m| weights[m as usize]).collect();
    let own = elements.iter().map(|&e| (e, leaves[e].index)).collect();
    let knots = level.knots();
    let raw = LevelSpace { space, knots, elements: own, n_local, numbers, weights, control_points };
    Combination { elements: elements.to_vec(), raw: Box::new(raw), functions, coefficients }
}

/// For each of `n` B-splines the functions with a part of it, rising, and the coefficients `C_im`.
fn entries(all: &Columns, elements: &[usize], numbers: &[u32], n: usize) -> Vec<Vec<(u32, f64)>> {
    let (mut entries, n_local) = (vec![Vec::new(); n], numbers.len() / elements.len());
    for (&e, own) in elements.iter().zip(numbers.chunks_exact(n_local)) {
        for (m, &number) in own.iter().enumerate() {
            let column: &mut Vec<(u32, f64)> = &mut entries[number as usize];
            if column.is_empty() {
                column.extend(all.column(e, m));
                column.sort_unstable_by_key(|&(f, _)| f);
            }
        }
    }
    entries
}

impl LevelSpace<'_> {
    /// Numbers and weights of the functions of element `e`.
    fn local(&self, e: usize) -> (&[u32], &[f64]) {
        let own = e * self.n_local..(e + 1) * self.n_local;
        (&self.numbers[own.clone()], &self.weights[own])
    }
}

impl Space for LevelSpace<'_> {
    fn dimension(&self) -> usize {
        self.space.dimension()
    }

    fn n_functions(&self) -> usize {
        self.control_points.len()
    }

    fn control_points(&self) -> &[[f64; 3]] {
        &self.control_points
    }

    fn anchors(&self) -> Vec<[f64; 3]> {
        self.control_points.clone()
    }

    fn n_elements(&self) -> usize {
        self.elements.len()
    }

    fn element(&self, e: usize) -> Element {
        self.space.element(self.elements[e].0)
    }

    fn active_functions(&self, e: usize, out: &mut Vec<u32>) {
        out.clear();
        out.extend_from_slice(self.local(e).0);
    }

    fn evaluate(&self, e: usize, xi: &[f64; 3], n_derivatives: usize, out: &mut PointBasis) {
        evaluate_level(self.knots, self.elements[e].1, xi, n_derivatives, out);
        scale(out, self.local(e).1.iter().copied());
        make_rational(out);
    }

    fn tabulate(&self, e: usize, integrand: Integrand, out: &mut GridBasis) {
        let counts =
            if integrand == Integrand::Sample { [2; 3] } else { self.space.gauss_counts(self.elements[e].0) };
        tabulate_box(self, e, counts, out);
    }

    fn evaluate_grid(&self, e: usize, grid: [&[f64]; 3], out: &mut GridBasis) {
        let mut strides = [0; 3];
        let mut stride = 1;
        for (slot, k) in strides.iter_mut().zip(self.knots) {
            (*slot, stride) = (stride, stride * (k.degree() + 1));
        }
        let weights = self.local(e).1;
        evaluate_tensor(self.knots, self.elements[e].1, &LocalWeights { weights, strides }, grid, out);
    }
}
