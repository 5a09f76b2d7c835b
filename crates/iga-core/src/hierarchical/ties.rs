//! Which functions of a patch are one function: seams, poles and other collapsed edges (theory
//! section H.5).
//!
//! On a hierarchical space coincident control points do not tell: functions of different levels may
//! share a control point by accident. So the ties are read off the coarsest control net, as
//! properties of its faces and edges, and then hold for the functions of every level there.

use crate::nurbs::Patch;
use crate::nurbs::interface::FaceId;
use crate::nurbs::jet::{diagonal, difference, norm};
use crate::splines::tensor;

/// Distance below which control points coincide, relative to the size of the net (round-off of
/// exact nets).
const COINCIDENCE: f64 = 1e-9;

/// A face or edge of the parameter box on which the geometry does not change along some directions.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CollapsedSet {
    /// Fixed end a direction: `Some(false)` lower, `Some(true)` upper, `None` free.
    pub ends: [Option<bool>; 3],
    /// Free directions along which the geometry does not change.
    pub along: [bool; 3],
}

/// Seams and collapsed faces and edges of a patch.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct PatchTies {
    /// Directions whose lower and upper face are the same surface.
    pub seams: [bool; 3],
    /// Faces and edges that collapse along at least one of their directions.
    pub collapsed: Vec<CollapsedSet>,
}

impl CollapsedSet {
    /// Whether the set is a single point.
    pub fn is_point(&self) -> bool {
        (0..3).all(|d| self.ends[d].is_some() || self.along[d])
    }

    /// Whether entry `index` of a net lies on the face or edge.
    pub(super) fn holds(&self, index: &[usize; 3], sizes: &[usize; 3]) -> bool {
        (0..3).all(|d| match self.ends[d] {
            None => true,
            Some(false) => index[d] == 0,
            Some(true) => index[d] + 1 == sizes[d],
        })
    }
}

impl PatchTies {
    /// Reads the ties off a patch's control points.
    pub fn detect(patch: &Patch) -> Self {
        let mut sizes = [1; 3];
        sizes[..patch.dimension()].copy_from_slice(&patch.net_size());
        let points = patch.control_points();
        let tolerance = COINCIDENCE * diagonal(points);
        // Whether direction `d` moves no control point of the entries chosen between its entries
        // `a` and `b`.
        let still = |d: usize, a: usize, chosen: &dyn Fn(&[usize; 3]) -> bool| {
            (0..points.len()).all(|i| {
                let mut index = tensor::multi_index(&sizes, i);
                let here = points[i];
                !chosen(&index) || {
                    index[d] = a;
                    norm(&difference(&here, &points[tensor::flat_index(&sizes, &index)])) <= tolerance
                }
            })
        };
        let mut ties = Self::default();
        for d in 0..patch.dimension() {
            ties.seams[d] = still(d, 0, &|index| index[d] + 1 == sizes[d]);
        }
        let directions = patch.dimension();
        for code in 0..3usize.pow(directions as u32) {
            let digit = |d: usize| code / 3usize.pow(d as u32) % 3;
            let ends = std::array::from_fn(|d| match digit(d) {
                _ if d >= directions => Some(false),
                0 => None,
                end => Some(end == 2),
            });
            let mut set = CollapsedSet { ends, along: [false; 3] };
            if (0..directions).all(|d| ends[d].is_none()) {
                continue;
            }
            for d in (0..directions).filter(|&d| ends[d].is_none()) {
                set.along[d] = still(d, 0, &|index| set.holds(index, &sizes));
            }
            if set.along.contains(&true) {
                ties.collapsed.push(set);
            }
        }
        ties
    }

    /// Whether `face` of a patch of so many directions collapses along one of those along it.
    pub(super) fn has_collapsed_face(&self, face: &FaceId, dimension: usize) -> bool {
        let is_face = |set: &CollapsedSet| {
            (0..dimension).all(|d| set.ends[d] == (d == face.direction).then_some(face.upper))
        };
        self.collapsed.iter().any(is_face)
    }

    /// Calls `found` for every entry of a net of the given `sizes` that a seam or a line of
    /// collapse makes one function with entry `index`.
    pub(super) fn for_each_partner(
        &self,
        index: &[usize; 3],
        sizes: &[usize; 3],
        mut found: impl FnMut([usize; 3]),
    ) {
        for d in (0..3).filter(|&d| self.seams[d]) {
            let last = sizes[d] - 1;
            if index[d] == 0 || index[d] == last {
                let mut other = *index;
                other[d] = last - index[d];
                found(other);
            }
        }
        for set in self.collapsed.iter().filter(|set| !set.is_point() && set.holds(index, sizes)) {
            for d in (0..3).filter(|&d| set.along[d]) {
                for i in 0..sizes[d] {
                    let mut other = *index;
                    other[d] = i;
                    found(other);
                }
            }
        }
    }

    /// Whether nothing is tied.
    pub fn is_empty(&self) -> bool {
        !self.seams.contains(&true) && self.collapsed.is_empty()
    }
}
