//! Two undeformed bodies, or one and a plane, until they touch, if they fly freely.

use contact_qs::search::{Detector, TouchSettings, first_touch};
use ffr_dynamics::force::BodyState;
use iga_core::nurbs::SAME_PLACE;
use nalgebra::{UnitQuaternion, Vector3};

use crate::spec::{ContactSpec, JointSpec, RunSpec};
use crate::touch::detection::{Nearest, Search};

/// Shortest step of the search for a touch, over the simulated time.
const SHORTEST: f64 = 1e-6;
/// Attempts to find an instant before the start at which bodies that touch at the start are apart.
/// Each goes twice as far back as the one before, the last a thousand times as far as their speed
/// along the normal would need.
const LOOKS_BACK: usize = 10;

/// Motions and nearest places of the first touch of `contact`, with the motions `poses` at the
/// start, between the surfaces of `detector`. `None` for bodies that move on joints or under loads,
/// or that do not meet before the end of the run.
pub(super) fn touch_in_flight(
    spec: &RunSpec,
    detector: Detector,
    contact: &ContactSpec,
    poses: &[BodyState],
) -> Option<(Vec<BodyState>, Nearest)> {
    if contact.bodies().any(|body| !is_free(spec, body) && !spec.is_held(body)) {
        return None;
    }
    Flight::new(spec, detector, contact, poses).touch(spec.settings.end_time)
}

/// Whether nothing but gravity and contacts acts on body `body`.
fn is_free(spec: &RunSpec, body: usize) -> bool {
    let holds = |joint: &JointSpec| [joint.parent.body, joint.child.body].contains(&Some(body));
    !spec.joints.iter().chain(&spec.loops).any(holds)
        && spec.loads.iter().all(|load| load.at.body != Some(body))
}

/// Two undeformed bodies, or one and a plane, in free flight.
struct Flight<'a> {
    detector: Detector,
    poses: &'a [BodyState],
    /// Indices of the bodies that fly freely; the others are held.
    bodies: Vec<usize>,
    gravity: Vector3<f64>,
    /// Growth of the closing speed [m/s²].
    acceleration: f64,
    size: f64,
    /// Overlap that is allowed at the start \[m\].
    overlap: f64,
}

impl<'a> Flight<'a> {
    fn new(spec: &RunSpec, detector: Detector, contact: &ContactSpec, poses: &'a [BodyState]) -> Self {
        let size = detector.own.model.radius();
        let gravity = spec.settings.gravity;
        let bodies: Vec<usize> = contact.bodies().filter(|body| !spec.is_held(*body)).collect();
        // Gravity accelerates two free bodies alike, so that they do not approach each other by it.
        let acceleration = if bodies.len() == 2 { 0.0 } else { gravity.norm() };
        let overlap = contact.initial_overlap;
        Self { detector, poses, bodies, gravity, acceleration, size, overlap }
    }

    /// Motions after the time `t`: parabolas, and turns at constant rate.
    fn at(&self, t: f64) -> Vec<BodyState> {
        let mut poses = self.poses.to_vec();
        for &body in &self.bodies {
            let pose = &mut poses[body];
            pose.position += pose.velocity * t + self.gravity * (0.5 * t * t);
            pose.velocity += self.gravity * t;
            pose.rotation *= UnitQuaternion::from_scaled_axis(pose.angular_velocity_in_body * t);
            (pose.elastic, pose.elastic_rates) = (Vec::new(), Vec::new());
        }
        poses
    }

    /// Motions and nearest places at the first touch before `end`; none if there is none.
    fn touch(&self, end: f64) -> Option<(Vec<BodyState>, Nearest)> {
        let mut search = Search::new();
        let settings = TouchSettings {
            gap: SAME_PLACE * self.size,
            time: f64::EPSILON * end,
            shortest: SHORTEST * end,
            acceleration: self.acceleration,
        };
        let mut sample = |t: f64| {
            let poses = self.at(t);
            let gap = search.nearest(&self.detector, &poses)?.gap;
            Ok((gap, self.detector.closing_speed_bound(&poses)))
        };
        // Bodies that lie on each other touch, whether they close or not.
        let at_start = sample(0.0).ok()?.0;
        let (time, gap) = if at_start <= settings.gap {
            (0.0, at_start)
        } else {
            let touch = first_touch([0.0, end], &settings, sample).ok()??;
            (touch.time, touch.gap)
        };
        if gap < -settings.gap - self.overlap {
            return None; // refused for its overlap
        }
        // The direction between bodies is not defined when they touch: the instant just before is
        // taken, even if it is before the start.
        let speed = self.detector.closing_speed_bound(&self.at(time));
        let mut back = 2.0 * (settings.gap - gap.min(0.0)) / speed;
        for _ in 0..LOOKS_BACK {
            let poses = self.at(time - back);
            let nearest = search.nearest(&self.detector, &poses).ok()?;
            if nearest.gap > 0.0 {
                let has_direction = nearest.normal.norm() > 0.5;
                return has_direction.then_some((poses, nearest));
            }
            back *= 2.0;
        }
        None
    }
}
