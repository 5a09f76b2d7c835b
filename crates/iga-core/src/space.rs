//! The one interface behind which every displacement field on elements looks alike: patches,
//! hierarchical splines, finite element meshes and divided ones.
//!
//! A space is a list of elements, each with parameters of its own, and a list of functions with one
//! control point (node) each. On an element the functions are `R = (C N) / W`: raw functions `N` of
//! the element (B-splines of a level, shape functions of nodes), sparse [`Rows`] `C`, the weight
//! function `W` of its patch, one on meshes. Coincident control points (poles, collapsed edges,
//! seams, interfaces), truncation and hanging nodes are such rows, so that no displacement is
//! multivalued and nothing above a space knows of dependent functions (theory section E.5, part H,
//! section C.10).
//!
//! Functions reproduce the geometry: `Σ_A R_A P_A` is the place of the point, `Σ_A R_A = 1`.

mod combination;
mod rows;
mod tensor_basis;
mod tie;
mod patches;

pub use combination::Combination;
pub use patches::PatchSpace;
pub use rows::Rows;
pub(crate) use tensor_basis::{LocalWeights, evaluate_tensor};

use crate::nurbs::interface::FaceId;
use crate::nurbs::patch::PointBasis;
use crate::quadrature::GaussRule;

/// What the parameters of an element run over.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Cell {
    /// The box between the corners.
    Box,
    /// The lower corner and the points that one parameter at a time is larger by.
    Tetrahedron,
    /// Such a triangle of the first two parameters, times an interval of the third.
    Wedge,
    /// The rectangle of the first two parameters at the lower third one, under an apex over its
    /// middle.
    Pyramid,
}

/// One element of a space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Element {
    /// Index of the patch that the element belongs to; 0 on meshes.
    pub patch: usize,
    /// What its parameters run over.
    pub cell: Cell,
    /// Lower parametric corner.
    pub lower: [f64; 3],
    /// Upper parametric corner.
    pub upper: [f64; 3],
}

impl Element {
    /// Parameters of its middle.
    pub fn centre(&self) -> [f64; 3] {
        let shares = match self.cell {
            Cell::Box => [0.5; 3],
            Cell::Tetrahedron => [0.25; 3],
            Cell::Wedge => [1.0 / 3.0, 1.0 / 3.0, 0.5],
            Cell::Pyramid => [0.5, 0.5, 0.25],
        };
        std::array::from_fn(|d| (1.0 - shares[d]) * self.lower[d] + shares[d] * self.upper[d])
    }
}

/// What points of an element are for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Integrand {
    /// Products of gradients: `p` Gauss points a direction on smooth single-level elements, `p + 1`
    /// elsewhere (theory section E.3).
    Stiffness,
    /// Products of values; exact on straight-sided finite elements.
    Mass,
    /// Gradients at few points: two in each direction for splines, the points of the stiffness for
    /// finite elements.
    Sample,
}

/// Basis values and first derivatives at points of one element.
///
/// Points of a tensor grid are stacked with the first direction running fastest; the functions of
/// one point lie next to each other: entry `q * n_active + a` belongs to point `q` and local
/// function `a`.
#[derive(Debug, Clone, Default)]
pub struct GridBasis {
    /// Number of functions.
    pub n_active: usize,
    /// Number of points.
    pub n_points: usize,
    /// `R_A`.
    pub values: Vec<f64>,
    /// `∂R_A/∂ξ_d` for each direction `d`; zero in directions that the space does not have.
    pub first: [Vec<f64>; 3],
    /// Parameters of the points of a rule ([`Space::tabulate`]).
    pub parameters: Vec<[f64; 3]>,
    /// Weights of the points of a rule; together the volume of the element's parameters.
    pub weights: Vec<f64>,
    /// Buffer of the general path.
    point: PointBasis,
    /// Buffer of rows.
    combined: Vec<f64>,
    /// Coordinates of a grid.
    grid: [Vec<f64>; 3],
}

impl GridBasis {
    /// Makes room for `n_points` points of `n_active` functions.
    pub fn resize(&mut self, n_active: usize, n_points: usize) {
        (self.n_active, self.n_points) = (n_active, n_points);
        self.values.resize(n_active * n_points, 0.0);
        for first in &mut self.first {
            first.resize(n_active * n_points, 0.0);
        }
    }

    /// Makes the functions of element `e` from raw ones: the rows `rows` of each point's.
    pub fn combine(&mut self, rows: &Rows, e: usize) {
        let [first, second, third] = &mut self.first;
        for list in [&mut self.values, first, second, third] {
            self.combined.clear();
            list.chunks_exact(self.n_active).for_each(|raw| rows.combine(e, raw, &mut self.combined));
            std::mem::swap(list, &mut self.combined);
        }
        self.n_active = rows.functions(e).len();
    }

    /// Takes the functions at the point `q` from those evaluated there, of `n_points`.
    pub fn set_point(&mut self, q: usize, n_points: usize, basis: &PointBasis) {
        let n = basis.values.len();
        self.resize(n, n_points);
        self.values[q * n..(q + 1) * n].copy_from_slice(&basis.values);
        for (d, first) in self.first.iter_mut().enumerate() {
            for (slot, g) in first[q * n..(q + 1) * n].iter_mut().zip(&basis.first) {
                *slot = g[d];
            }
        }
    }

    /// Takes all of `other`.
    pub fn copy_from(&mut self, other: &Self) {
        (self.n_active, self.n_points) = (other.n_active, other.n_points);
        self.values.clone_from(&other.values);
        self.first.iter_mut().zip(&other.first).for_each(|(own, from)| own.clone_from(from));
        self.parameters.clone_from(&other.parameters);
        self.weights.clone_from(&other.weights);
    }

    /// Values at point `q`.
    pub fn values_at(&self, q: usize) -> &[f64] {
        &self.values[q * self.n_active..(q + 1) * self.n_active]
    }

    /// First derivatives at point `q`, one list per direction.
    pub fn first_at(&self, q: usize) -> [&[f64]; 3] {
        self.first.each_ref().map(|f| &f[q * self.n_active..(q + 1) * self.n_active])
    }
}

impl PointBasis {
    /// Makes the functions of element `e` from raw ones: the rows `rows` of every list that is not
    /// empty.
    pub fn combine(&mut self, rows: &Rows, e: usize) {
        let n_raw = self.values.len();
        let raw = std::mem::take(&mut self.values);
        self.values.reserve(n_raw);
        rows.combine(e, &raw, &mut self.values);
        rows.combine_all(e, &mut self.first);
        rows.combine_all(e, &mut self.second);
    }
}

/// Displacement fields on the elements of a body.
///
/// Functions are numbered globally, dependent ones not at all. On an element they are stacked in
/// the order of [`Space::active_functions`], every one once.
pub trait Space: Send + Sync {
    /// Number of parametric directions: 1, 2 or 3.
    fn dimension(&self) -> usize;

    /// Number of functions.
    fn n_functions(&self) -> usize;

    /// Control point of every function, on meshes its node \[m\].
    fn control_points(&self) -> &[[f64; 3]];

    /// Places for ordering unknowns: a point per function such that functions with overlapping
    /// supports are near each other. Net indices for a single patch, control points otherwise.
    fn anchors(&self) -> Vec<[f64; 3]>;

    /// Number of elements.
    fn n_elements(&self) -> usize;

    /// Element `e`.
    fn element(&self, e: usize) -> Element;

    /// Replaces `out` by the functions active on element `e`.
    fn active_functions(&self, e: usize, out: &mut Vec<u32>);

    /// Basis at parametric point `xi` of element `e`, with derivatives up to `n_derivatives <= 2`;
    /// on meshes first ones at most.
    fn evaluate(&self, e: usize, xi: &[f64; 3], n_derivatives: usize, out: &mut PointBasis);

    /// Basis and first derivatives at the points of the rule that element `e` has for `integrand`,
    /// with parameters and weights.
    fn tabulate(&self, e: usize, integrand: Integrand, out: &mut GridBasis);

    /// Whether masses of element `e` are integrated by the points of its stiffness.
    fn has_one_rule(&self, _e: usize) -> bool {
        true
    }

    /// Sets of elements on which the functions combine raw ones with the same coefficients, so that
    /// matrices of the raw functions say all about them; no element is in two. None where elements
    /// have about as many functions as raw ones.
    fn combinations(&self) -> Vec<Combination<'_>> {
        Vec::new()
    }

    /// Functions that are not zero at parametric point `xi` of element `e`, with their values.
    fn functions_at(&self, e: usize, xi: &[f64; 3]) -> Vec<(u32, f64)> {
        let (mut basis, mut active) = (PointBasis::default(), Vec::new());
        self.evaluate(e, xi, 0, &mut basis);
        self.active_functions(e, &mut active);
        active.into_iter().zip(basis.values).filter(|(_, value)| value.abs() > 0.0).collect()
    }

    /// Basis and first derivatives at the tensor grid `grid[0] × grid[1] × grid[2]` of parametric
    /// points of element `e`; directions that the space does not have carry one point.
    ///
    /// The general path evaluates point by point; spaces with tensor structure override it.
    fn evaluate_grid(&self, e: usize, grid: [&[f64]; 3], out: &mut GridBasis) {
        let mut point = std::mem::take(&mut out.point);
        let n_points = grid.iter().map(|g| g.len()).product();
        let mut q = 0;
        for &z in grid[2] {
            for &y in grid[1] {
                for &x in grid[0] {
                    self.evaluate(e, &[x, y, z], 1, &mut point);
                    out.set_point(q, n_points, &point);
                    q += 1;
                }
            }
        }
        out.point = point;
    }
}

/// A space whose elements are boxes of the parameters of patches.
pub trait SplineSpace: Space {
    /// The element of patch `patch` that holds `xi`; points outside are clamped.
    fn find_element(&self, patch: usize, xi: &[f64; 3]) -> usize;

    /// Gauss points per direction that integrate the element's matrices: `p` on smooth single-level
    /// elements, `p + 1` elsewhere (theory section E.3).
    fn gauss_counts(&self, e: usize) -> [usize; 3];

    /// Functions whose net entries lie on face `face` of a patch, each with its Greville abscissae
    /// there (theory Eq. S.19). A function that is tied (pole, seam, interface) comes once for
    /// every net entry.
    fn greville(&self, face: FaceId) -> Vec<(u32, [f64; 3])>;
}

/// [`Space::tabulate`] of splines: Gauss points of the box of the element.
pub fn tabulate_spline(space: &dyn SplineSpace, e: usize, integrand: Integrand, out: &mut GridBasis) {
    let counts = if integrand == Integrand::Sample { [2; 3] } else { space.gauss_counts(e) };
    tabulate_box(space, e, counts, out);
}

/// The basis at the tensor grid of `counts` Gauss points per direction of the box of element `e`,
/// with parameters and weights.
pub(crate) fn tabulate_box(space: &dyn Space, e: usize, counts: [usize; 3], out: &mut GridBasis) {
    let rule = counts.map(GaussRule::with);
    let element = space.element(e);
    let mut grid = std::mem::take(&mut out.grid);
    let mut scale = 1.0;
    for (d, (grid, rule)) in grid.iter_mut().zip(rule).enumerate() {
        grid.clear();
        if d < space.dimension() {
            rule.points_on(element.lower[d], element.upper[d], grid);
            scale *= 0.5 * (element.upper[d] - element.lower[d]);
        } else {
            grid.push(0.0);
        }
    }
    space.evaluate_grid(e, grid.each_ref().map(Vec::as_slice), out);
    out.parameters.clear();
    out.weights.clear();
    let counts = grid.each_ref().map(Vec::len);
    for q in 0..out.n_points {
        let index = [q % counts[0], q / counts[0] % counts[1], q / (counts[0] * counts[1])];
        let weights = (0..space.dimension()).map(|d| rule[d].weights[index[d]]);
        out.weights.push(weights.fold(scale, |product, w| product * w));
        out.parameters.push([0, 1, 2].map(|d| grid[d][index[d]]));
    }
    out.grid = grid;
}
