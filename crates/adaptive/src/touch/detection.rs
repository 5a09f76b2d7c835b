//! Watches a pair that is not in contact: nearest points, first touch (\[A\] (7), Fig. 2).

use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use contact_qs::search::{Detector, SearchWorkspace, Site, SurfaceSite};
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

/// Ratio of the closing speed between two instants to the larger one at them, at most: a vibration
/// that is resolved has at least three samples per period, and between two samples it is below
/// `1 / cos(π / 3)` of the larger.
pub const BETWEEN_INSTANTS: f64 = 2.0;

/// How far two surfaces are apart at least, as time goes on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Clearance {
    /// What is left of the gap that was found last \[m\].
    pub gap: f64,
    /// When \[s\].
    pub time: f64,
    /// Bound of the closing speed then [m/s].
    pub speed: f64,
}

impl Clearance {
    /// Nothing is known.
    pub const UNKNOWN: Self = Self { gap: 0.0, time: f64::NEG_INFINITY, speed: 0.0 };

    /// Goes on to `time`, when the surfaces of `detector` are in the motions `bodies`; whether they cannot have come as near
    /// as `least` since the last instant, nor at this one if there was none (theory C.28, C.33). No search is made.
    pub fn go_on(&mut self, detector: &Detector, (time, bodies): (f64, &[BodyState]), least: f64) -> bool {
        let speed = detector.closing_speed_bound(bodies);
        let passed = if self.time.is_finite() { time - self.time } else { 0.0 };
        // The larger one of two of which one is not a number would be the other.
        let fastest = if speed.is_nan() { speed } else { speed.max(self.speed) };
        let way = BETWEEN_INSTANTS * fastest * passed;
        let mut is_apart = passed >= 0.0 && self.gap - way > least;
        self.gap = if is_apart { self.gap - way } else { detector.least_gap(bodies) };
        is_apart |= passed >= 0.0 && self.gap - way > least;
        (self.time, self.speed) = (time, speed);
        is_apart
    }
}

/// A search between the surfaces of a pair: where the last one ended, and what all have cost.
pub struct Search {
    last: Option<[Site; 2]>,
    elapsed: Duration,
    workspace: Arc<Mutex<SearchWorkspace>>,
}

impl Search {
    /// Before the first search.
    pub fn new() -> Self {
        Self { last: None, elapsed: Duration::ZERO, workspace: Arc::default() }
    }

    /// One for another pair, with the same buffers: they are as large as the largest bodies need, however many pairs there are.
    pub fn of_another_pair(&self) -> Self {
        Self { workspace: Arc::clone(&self.workspace), ..Self::new() }
    }

    /// Forgets where the last search ended: the next one depends on the motions alone.
    pub fn forget(&mut self) {
        self.last = None;
    }

    /// Gap and nearest points of the surfaces of `detector` in the motions `bodies`.
    ///
    /// # Errors
    /// [`ContactError`] for motions that are not finite, or a plane that leaves the model's symmetry.
    pub fn nearest(&mut self, detector: &Detector, bodies: &[BodyState]) -> Result<Nearest, ContactError> {
        let begin = Instant::now();
        let mut workspace = self.workspace.lock().unwrap_or_else(PoisonError::into_inner);
        workspace.begin_at(self.last);
        let found = detector.nearest(bodies, &mut workspace);
        (self.last, self.elapsed) = (workspace.last(), self.elapsed + begin.elapsed());
        drop(workspace);
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

#[cfg(test)]
mod tests {
    use super::*;
    use contact_qs::search::BodySurface;
    use contact_qs::{Plane, SurfaceModel, Target};
    use ffr_dynamics::body::RigidMotion;
    use iga_core::nurbs::primitives::{SphereNet, sphere};

    const RADIUS: f64 = 0.1;

    /// A ball whose lowest point is `gap` above the floor, and falls at `speed`.
    fn ball(gap: f64, speed: f64) -> [BodyState; 1] {
        let position = Vector3::new(0.0, 0.0, RADIUS + gap);
        [BodyState { position, velocity: Vector3::new(0.0, 0.0, -speed), ..BodyState::at_rest(0) }]
    }

    #[test]
    fn a_clearance_lasts_as_long_as_nothing_can_have_met() {
        let shape = sphere::sphere(RADIUS, SphereNet::Cube).unwrap();
        let model = SurfaceModel::rigid(RigidMotion::Spatial, &shape.patches).unwrap();
        let floor = Plane { point: Vector3::zeros(), normal: Vector3::z_axis() };
        let own = BodySurface { body: 0, model: model.into() };
        let detector = Detector { own, target: Target::Plane(floor) };
        let mut clearance = Clearance::UNKNOWN;
        let mut holds =
            |t: f64, gap: f64, speed: f64| clearance.go_on(&detector, (t, &ball(gap, speed)), 0.0);
        // (time, gap, speed, what is known): the way is 2 × the larger speed × the time since the last instant.
        for (t, gap, speed, expected) in [
            (1.0, 0.010, 1.0, true),    // nothing known: 10 mm at this instant
            (1.004, 0.006, 1.0, true),  // 8 mm of the way are gone, 2 mm are left
            (1.005, 0.005, 1.0, true),  // 2 mm, nothing left: the 5 mm of this instant are more than that way
            (1.008, 0.005, 0.0, false), // 6 mm of way at the earlier speed: more than either
            (1.007, 0.005, 0.0, false), // an instant before: nothing is known on the way to it
            (1.008, 0.005, 0.0, true),  // at rest since
            (1.009, 0.005, f64::NAN, false),
        ] {
            assert_eq!(holds(t, gap, speed), expected, "{t} {gap} {speed}");
        }
        for gap in [-0.001, 0.0, f64::NAN] {
            assert!(!Clearance::UNKNOWN.clone().go_on(&detector, (0.0, &ball(gap, 1.0)), 0.0), "{gap}");
        }
    }
}
