//! The one interface behind which every spline space looks alike: plain patches here, hierarchical ones elsewhere.
//!
//! A space is a list of elements, each an axis-parallel box in the parameters of one patch, and a list of functions with
//! one control point each. Functions whose control points coincide (poles, axes' collapsed edges, seams, patch interfaces)
//! are *tied*: they are one function of the space, so that no displacement is multivalued (theory section S.3).

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

/// A spline space over the parametric domain of a body.
///
/// Functions are numbered globally after tying. On an element they are stacked in the order of
/// [`Space::active_functions`], every one once.
pub trait Space: Sync {
    /// Number of parametric directions: 1, 2 or 3.
    fn dimension(&self) -> usize;

    /// Number of functions after tying.
    fn n_functions(&self) -> usize;

    /// Control point of every function [m].
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

    /// Gauss points a direction that integrate the element's matrices: `p` on smooth single-level elements, `p + 1`
    /// elsewhere (theory section E.3).
    fn gauss_counts(&self, e: usize) -> [usize; 3];

    /// Replaces `out` by the functions active on element `e`.
    fn active_functions(&self, e: usize, out: &mut Vec<u32>);

    /// Basis at parametric point `xi` of element `e`, with derivatives up to `n_derivatives <= 2`.
    fn evaluate(&self, e: usize, xi: &[f64; 3], n_derivatives: usize, out: &mut PointBasis);
}
