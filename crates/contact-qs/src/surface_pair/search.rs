//! The smallest gap of a pair at any distance, from nothing but the motion.

use ffr_dynamics::system::force::BodyState;

use super::SurfacePair;
use super::motion::Relative;
use super::projection::{Displaced, Functions, Samples};
use super::target::TargetSurface;

/// Buffers of a search.
pub(super) struct SearchBuffers {
    functions: Functions,
    samples: Samples,
    points: Vec<[f64; 3]>,
    nodes: Vec<[f64; 3]>,
}

impl SearchBuffers {
    pub fn new(surface: &TargetSurface, n_points: usize) -> Self {
        Self {
            functions: Functions::new(surface),
            samples: Samples::new(surface),
            points: vec![[0.0; 3]; n_points],
            nodes: vec![[0.0; 3]; surface.nodes.len()],
        }
    }
}

impl SurfacePair {
    /// Smallest gap without quasistatic displacement and the normal there in the target's components; none if a value is not
    /// a number or the bodies cannot meet. Starts from samples of the surface, so that it is a function of the motion alone.
    pub(super) fn nearest(
        &self,
        bodies: &[BodyState],
        buffers: &mut SearchBuffers,
    ) -> Option<(f64, [f64; 3])> {
        let (own, target) = self.states(bodies);
        let relative = Relative::new(self.motion, own, target).ok()?;
        let SearchBuffers { functions, samples, points, nodes } = buffers;
        self.place_low(own, target, points, nodes);
        let displaced = Displaced { surface: &self.surface, nodes };
        samples.update(displaced);
        let mut smallest = (f64::INFINITY, [f64::NAN; 3]);
        for point in points.iter() {
            let point = relative.point(point);
            let found = displaced.closest_from(&samples.nearest(&point), &point, functions);
            let gap = found.distance(&point);
            // min() would hide a NaN
            if gap.is_nan() {
                return None;
            }
            if gap < smallest.0 {
                smallest = (gap, found.normal);
            }
        }
        Some(smallest)
    }
}
