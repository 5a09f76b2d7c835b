//! The one interface behind which every spline space looks alike: plain patches here, hierarchical ones elsewhere.
//!
//! A space is a list of elements, each an axis-parallel box in the parameters of one patch, and a list of functions with
//! one control point each. Functions whose control points coincide (poles, axes' collapsed edges, seams, patch interfaces)
//! are *tied*: they are one function of the space, so that no displacement is multivalued (theory section E.5).

mod patches;
mod tie;

pub use patches::PatchSpace;

use crate::nurbs::interface::FaceId;
use crate::nurbs::patch::PointBasis;

/// One element of a space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Element {
    /// Index of the patch that the element belongs to.
    pub patch: usize,
    /// Lower parametric corner.
    pub lower: [f64; 3],
    /// Upper parametric corner.
    pub upper: [f64; 3],
}

/// Basis values and first derivatives at all points of a tensor grid on one element.
///
/// Points are stacked with the first direction running fastest; the functions of one point lie next to each other:
/// entry `q * n_active + a` belongs to point `q` and local function `a`.
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
    /// Buffer of the general path.
    point: PointBasis,
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

    /// Values at point `q`.
    pub fn values_at(&self, q: usize) -> &[f64] {
        &self.values[q * self.n_active..(q + 1) * self.n_active]
    }

    /// First derivatives at point `q`, one list per direction.
    pub fn first_at(&self, q: usize) -> [&[f64]; 3] {
        self.first.each_ref().map(|f| &f[q * self.n_active..(q + 1) * self.n_active])
    }
}

/// A spline space over the parametric domain of a body.
///
/// Functions are numbered globally after tying. On an element they are stacked in the order of
/// [`Space::active_functions`], every one once.
pub trait Space: Sync {
    /// Number of parametric directions: 1, 2 or 3.
    fn dimension(&self) -> usize;

    /// Number of functions after tying.
    fn n_functions(&self) -> usize;

    /// Control point of every function \[m\].
    fn control_points(&self) -> &[[f64; 3]];

    /// Places for ordering unknowns: a point per function such that functions with overlapping supports are near
    /// each other. Net indices for a single patch, control points otherwise.
    fn anchors(&self) -> Vec<[f64; 3]>;

    /// Number of elements.
    fn n_elements(&self) -> usize;

    /// Element `e`.
    fn element(&self, e: usize) -> Element;

    /// The element of patch `patch` that holds `xi`; points outside are clamped.
    fn find_element(&self, patch: usize, xi: &[f64; 3]) -> usize;

    /// Gauss points per direction that integrate the element's matrices: `p` on smooth single-level elements, `p + 1`
    /// elsewhere (theory section E.3).
    fn gauss_counts(&self, e: usize) -> [usize; 3];

    /// Replaces `out` by the functions active on element `e`.
    fn active_functions(&self, e: usize, out: &mut Vec<u32>);

    /// Basis at parametric point `xi` of element `e`, with derivatives up to `n_derivatives <= 2`.
    fn evaluate(&self, e: usize, xi: &[f64; 3], n_derivatives: usize, out: &mut PointBasis);

    /// Functions whose net entries lie on face `face` of a patch, each with its Greville abscissae there (theory Eq. S.12). A function
    /// that is tied (pole, seam, interface) comes once for every net entry.
    fn greville(&self, face: FaceId) -> Vec<(u32, [f64; 3])>;

    /// Functions that are not zero at parametric point `xi` of element `e`, with their values.
    fn functions_at(&self, e: usize, xi: &[f64; 3]) -> Vec<(u32, f64)> {
        let (mut basis, mut active) = (PointBasis::default(), Vec::new());
        self.evaluate(e, xi, 0, &mut basis);
        self.active_functions(e, &mut active);
        active.into_iter().zip(basis.values).filter(|(_, value)| value.abs() > 0.0).collect()
    }

    /// Basis and first derivatives at the tensor grid `grid[0] × grid[1] × grid[2]` of parametric points of element `e`;
    /// directions that the space does not have carry one point.
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
                    let n = point.values.len();
                    out.resize(n, n_points);
                    out.values[q * n..(q + 1) * n].copy_from_slice(&point.values);
                    for (d, first) in out.first.iter_mut().enumerate() {
                        for (slot, g) in first[q * n..(q + 1) * n].iter_mut().zip(&point.first) {
                            *slot = g[d];
                        }
                    }
                    q += 1;
                }
            }
        }
        out.point = point;
    }
}
