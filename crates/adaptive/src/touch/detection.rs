//! Watches a pair that is not in contact: nearest points, first touch (\[A\] (7), Fig. 2).

use std::time::{Duration, Instant};

use contact_qs::search::{Detector, SearchWorkspace, SurfaceSite};
use contact_qs::{ContactError, Proximity};
use ffr_dynamics::force::BodyState;
use nalgebra::Vector3;

/// Where two surfaces are nearest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Nearest {
    /// Gap, negative when they overlap \[m\].
    pub gap: f64,
    /// On the contact body.
    pub contact: SurfaceSite,
    /// On the target; none on a plane.
    pub target: Option<SurfaceSite>,
    /// Unit normal in the inertial frame, towards the contact body.
    pub normal: Vector3<f64>,
}

/// A search between the surfaces of a pair: where the last one ended, and what all have cost.
pub struct Search {
    workspace: SearchWorkspace,
    elapsed: Duration,
}

impl Search {
    /// Before the first search.
    pub fn new() -> Self {
        Self { workspace: SearchWorkspace::new(), elapsed: Duration::ZERO }
    }

    /// Forgets where the last search ended: the next one depends on the motions alone.
    pub fn forget(&mut self) {
        self.workspace.forget();
    }

    /// Gap and nearest points of the surfaces of `detector` in the motions `bodies`.
    ///
    /// # Errors
    /// [`ContactError`] for motions that are not finite, or a plane that leaves the model's symmetry.
    pub fn nearest(&mut self, detector: &Detector, bodies: &[BodyState]) -> Result<Nearest, ContactError> {
        let begin = Instant::now();
        let found = detector.nearest(bodies, &mut self.workspace);
        self.elapsed += begin.elapsed();
        let Proximity { gap, sites: [contact, target], normal, .. } = found?;
        let target = detector.target.as_ref().body().map(|_| target);
        Ok(Nearest { gap, contact, target, normal })
    }

    /// Time spent so far.
    pub fn elapsed(&self) -> Duration {
        self.elapsed
    }
}

impl Default for Search {
    fn default() -> Self {
        Self::new()
    }
}
