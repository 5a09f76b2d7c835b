//! The smallest gap of a pair at any distance, from nothing but the motion.

use ffr_dynamics::force::BodyState;

use super::SurfacePair;
use super::projection::normal_walk::SLACK;
use super::projection::warm_start::WarmStart;
use super::projection::{Displaced, Functions, Samples};
use super::relative_pose::RelativePose;
use super::target::TargetSurface;

/// Buffers of a search.
pub(super) struct SearchBuffers {
    functions: Functions,
    samples: Samples,
    points: Vec<[f64; 3]>,
    nodes: Vec<[f64; 3]>,
    normals: Vec<[f64; 3]>,
}

impl SearchBuffers {
    pub fn new(surface: &TargetSurface, n_points: usize) -> Self {
        Self {
            functions: Functions::new(surface),
            samples: Samples::new(surface),
            points: vec![[0.0; 3]; n_points],
            nodes: vec![[0.0; 3]; surface.nodes.len()],
            normals: vec![[0.0; 3]; surface.n_normals()],
        }
    }
}

/// The point that is nearest to the target.
#[derive(Debug, Clone, Copy)]
pub(super) struct NearestPoint {
    /// Its gap \[m\].
    pub gap: f64,
    /// Normal of the target there, in the target's components.
    pub normal: [f64; 3],
    /// Its place under the low modes, in the contact body's components \[m\].
    pub place: [f64; 3],
}

impl SurfacePair {
    /// The nearest point, without quasistatic displacement; none if a value is not a number or the
    /// bodies cannot meet. A function of the motion to round-off: points near where the last
    /// evaluation saw them are projected from their places there, or left out if others are nearer
    /// for certain, the others from samples of the surface.
    pub(super) fn nearest(
        &self,
        bodies: &[BodyState],
        start: &WarmStart,
        buffers: &mut SearchBuffers,
    ) -> Option<NearestPoint> {
        let (own, target) = self.states(bodies);
        let relative = RelativePose::new(self.motion, own, target).ok()?;
        let SearchBuffers { functions, samples, points, nodes, normals } = buffers;
        self.place_low(own, target, points, nodes);
        self.surface.normals(nodes, normals);
        let displaced = Displaced { surface: &self.surface, nodes, normals, slack: SLACK };
        let proximity = &start.proximity;
        let shift = if start.is_known { proximity.shift(nodes) } else { f64::INFINITY };
        let is_close = |i: usize, point: &[f64; 3]| shift + proximity.moved(i, point) < self.rim_reach;
        let unknown = NearestPoint { gap: f64::INFINITY, normal: [f64::NAN; 3], place: [f64::NAN; 3] };
        let (mut smallest, mut is_sampled) = (unknown, false);
        // Points in contact first: they tell which others may be left out.
        let touching = (0..points.len()).filter(|i| proximity.gaps[*i] <= 0.0);
        for i in touching.chain((0..points.len()).filter(|i| proximity.gaps[*i] > 0.0)) {
            let point = relative.transform_point(&points[i]);
            let is_known = is_close(i, &point);
            if is_known && proximity.least_gap(i, &point, shift) > smallest.gap {
                continue;
            }
            let from = is_known.then_some(start.places[i]);
            let search = (&mut *samples, &mut is_sampled);
            let found = self.project_point((i, &point), from, &relative, (displaced, functions), search);
            let gap = found.distance(&point);
            // min() would hide a NaN
            if gap.is_nan() {
                return None;
            }
            if gap < smallest.gap {
                smallest = NearestPoint { gap, normal: found.normal, place: points[i] };
            }
        }
        Some(smallest)
    }
}
