//! A body's exact geometry: patches, named points, singular lines.

use std::collections::BTreeMap;

use super::Patch;

/// Where a parametrisation is singular: all parameter points of `patch` whose fixed parameters agree.
#[derive(Debug, Clone, PartialEq)]
pub struct SingularSet {
    /// Index of the patch.
    pub patch: usize,
    /// Fixed value a direction, `None` where it runs freely.
    pub parameters: [Option<f64>; 3],
    /// Name for messages, such as "pole z = +r".
    pub name: String,
}

/// Exact geometry of a body in its own frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Shape {
    /// The patches; neighbours share coincident control points.
    pub patches: Vec<Patch>,
    /// Named points [m], in the model's components (`(r, z)` for axisymmetric shapes).
    pub markers: BTreeMap<String, [f64; 3]>,
    /// Singular points, lines and faces of the parametrisation.
    pub singular: Vec<SingularSet>,
}
