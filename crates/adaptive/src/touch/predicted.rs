//! The first touch of a contact if its bodies fly freely, and whether it is one of smooth surfaces, of whole flat faces, or over an edge
//! (docs/theory.md Eqs. C.60, C.61).

use std::sync::Arc;

use contact_qs::search::{SurfaceSite, TouchSettings, first_touch};
use ffr_dynamics::body::RigidMotion;
use ffr_dynamics::system::force::BodyState;
use iga_core::nurbs::SAME_PLACE;
use nalgebra::{UnitQuaternion, Vector3};

use crate::spec::{ContactSpec, HertzSpec, JointSpec, RunSpec, Target};
use crate::surface::{POLE, Surface};
use crate::touch::detection::{Detector, DetectorTarget, Nearest, Search};
use crate::touch::hertz::{HertzLaw, LocalSurface};
use crate::touch::line::middle_of_line;
use crate::touch::local_surface::SurfaceView;
use crate::touch::side::{Moved, Side, touch_direction};
use crate::touch::sites::Surfaces;

/// Which parts of two surfaces touch first: smooth faces, flat faces, edges or lines.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TouchKind {
    /// Smooth parts of both surfaces, as Hertz's theory has it.
    Smooth,
    /// Plane faces that lie on each other.
    Flat,
    /// An edge, a rim or a corner of one of the bodies or of both.
    Edge,
    /// An edge of the target that lies along a face of the contact body, where no contact points stand but perhaps at its ends.
    BetweenPoints,
}

impl TouchKind {
    /// Whether the pressure has a limit when elements shrink; under edges, rims and corners it has none.
    pub fn bounds_pressure(self) -> bool {
        matches!(self, Self::Smooth | Self::Flat)
    }

    /// The parts that touch, in words that follow "touch with".
    pub fn parts(self) -> &'static str {
        match self {
            Self::Smooth => "smooth faces",
            Self::Flat => "flat faces",
            Self::Edge | Self::BetweenPoints => "an edge or a corner",
        }
    }
}

/// Angle \[rad\] by which flat faces may be inclined and still meet as a whole: round-off of angles in files.
const PARALLEL: f64 = 1e-6;
/// Shortest step of the search for a touch, over the simulated time.
const SHORTEST: f64 = 1e-6;

/// Attempts to find an instant before the start at which bodies that touch at the start are apart. Each goes twice as far back as the one before,
/// the last a thousand times as far as their speed along the normal would need.
const LOOKS_BACK: usize = 10;

/// The kind of the first touch of `contact`, with the motions `poses` of the bodies at the start. `None` if it is not known: for bodies that move on
/// joints or under loads, that have no surface, or that do not meet.
pub fn touch_kind(spec: &RunSpec, contact: &ContactSpec, poses: &[BodyState]) -> Option<TouchKind> {
    kind_of_touch((spec, &Surfaces::default()), contact, poses)
}

/// As [`touch_kind`], with surfaces that are known.
pub(crate) fn kind_of_touch(
    (spec, surfaces): (&RunSpec, &Surfaces),
    contact: &ContactSpec,
    poses: &[BodyState],
) -> Option<TouchKind> {
    let (poses, nearest) = touch_in_flight((spec, surfaces), contact, poses)?;
    let moved = Pair::new((spec, surfaces), contact)?;
    let (own, other) = moved.in_motion(&poses);
    let nearest = middle_of_line(own, other, &nearest, PARALLEL).unwrap_or(nearest);
    Some(touch_kind_at(own, other, &nearest, PARALLEL))
}

/// The surfaces of a contact body and its target, none of a plane, with the numbers of the bodies.
struct Pair {
    own: (usize, Arc<dyn Surface>),
    target: Option<(usize, Arc<dyn Surface>)>,
}

impl Pair {
    /// The two surfaces of `contact`; `None` if one of its bodies has none.
    fn new((spec, surfaces): (&RunSpec, &Surfaces), contact: &ContactSpec) -> Option<Self> {
        let of = |body: usize| Some((body, surfaces.of(&spec.bodies[body]).ok()??.surface));
        let target = match contact.target {
            Target::Plane { .. } => None,
            Target::Body(other) => Some(of(other)?),
        };
        Some(Self { own: of(contact.body)?, target })
    }

    fn in_motion<'a>(&'a self, poses: &'a [BodyState]) -> (Moved<'a>, Option<Moved<'a>>) {
        let moved = |(body, surface): &'a (usize, Arc<dyn Surface>)| (surface.as_ref(), &poses[*body]);
        (moved(&self.own), self.target.as_ref().map(moved))
    }
}

/// Motions and nearest places of the first touch of `contact` in free flight; `None` as for [`touch_kind`].
fn touch_in_flight(
    (spec, surfaces): (&RunSpec, &Surfaces),
    contact: &ContactSpec,
    poses: &[BodyState],
) -> Option<(Vec<BodyState>, Nearest)> {
    let other = if let Target::Body(other) = contact.target { Some(other) } else { None };
    if [Some(contact.body), other]
        .into_iter()
        .flatten()
        .any(|body| !is_free(spec, body) && !spec.is_held(body))
    {
        return None;
    }
    Flight::new((spec, surfaces), contact, poses)?.touch(spec.settings.end_time)
}

/// The reason for which Hertz's law does not hold where a relative curvature is zero or negative.
const ALONG_LINE: &str = "surfaces touch along a line or lie in each other";

/// The reason for which Hertz's law `law` does not hold for the first touch of `contact`; `None` if it holds, or if the touch is not known.
pub(crate) fn no_hertz_point(
    (spec, surfaces): (&RunSpec, &Surfaces),
    contact: &ContactSpec,
    law: &HertzSpec,
    poses: &[BodyState],
) -> Option<&'static str> {
    if law.spheres(contact.target).is_some() {
        return None;
    }
    let (poses, nearest) = touch_in_flight((spec, surfaces), contact, poses)?;
    let moved = Pair::new((spec, surfaces), contact)?;
    let (own, other) = moved.in_motion(&poses);
    if middle_of_line(own, other, &nearest, PARALLEL).is_some() {
        return Some(ALONG_LINE);
    }
    match touch_kind_at(own, other, &nearest, PARALLEL) {
        TouchKind::Flat => return Some("flat faces touch"),
        TouchKind::Edge | TouchKind::BetweenPoints => return Some("an edge, a rim or a corner touches"),
        TouchKind::Smooth => {}
    }
    let view = |(surface, pose): Moved<'_>, site: &SurfaceSite| {
        SurfaceView::new(surface, 1.0, &pose.rotation, &surface.place(site.face, &site.xi))
    };
    let own_view = view(own, &nearest.contact)?;
    if own.0.motion() == RigidMotion::Axial && own_view.point[0].abs() > POLE * own.0.reach() {
        return Some("bodies touch along a ring");
    }
    let other = match (other, &nearest.target) {
        (Some(other), Some(site)) => view(other, site)?.surface,
        _ => LocalSurface::plane(1.0),
    };
    HertzLaw::new(&[own_view.surface, other]).is_none().then_some(ALONG_LINE)
}

/// The kind of touch at the places `nearest` of a contact body and a target, which are given as surfaces with their motions; without a target that of
/// a body and a plane. Flat faces meet as a whole if they are inclined by no more than the angle `parallel` \[rad\].
pub fn touch_kind_at(
    own: Moved<'_>,
    other: Option<Moved<'_>>,
    nearest: &Nearest,
    parallel: f64,
) -> TouchKind {
    let (own, target) = (Side::new(own), other.map(Side::new));
    let normal = touch_direction(&own, target.as_ref(), nearest);
    let (own, target) = (own.facing(&-normal), target.map(|side| side.facing(&normal)));
    let own_point = own.place(&nearest.contact).point;
    let target_point = target.as_ref().zip(nearest.target).map(|(side, site)| side.place(&site).point);
    let both = || std::iter::once((&own, own_point)).chain(target.as_ref().zip(target_point));
    if both().all(|(side, point)| side.is_flat(&point, parallel)) {
        TouchKind::Flat
    } else if both().all(|(side, point)| side.is_smooth(&point)) {
        TouchKind::Smooth
    } else if target.as_ref().zip(target_point).is_some_and(|(target, point)| {
        let slack = (parallel + SAME_PLACE) * own.size().min(target.size());
        own.holds_edge((&own_point, &normal), (target, &point), slack)
    }) {
        TouchKind::BetweenPoints
    } else {
        TouchKind::Edge
    }
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
    fn new(
        (spec, surfaces): (&RunSpec, &Surfaces),
        contact: &ContactSpec,
        poses: &'a [BodyState],
    ) -> Option<Self> {
        let model = |body: usize| Some(surfaces.of(&spec.bodies[body]).ok()??.model);
        let own = model(contact.body)?;
        let size = own.radius();
        let (target, other) = match contact.target {
            Target::Plane { point, normal } => (DetectorTarget::plane(point, normal), None),
            Target::Body(other) => (DetectorTarget::Body(other, model(other)?), Some(other)),
        };
        let detector = Detector::new(contact.body, own, target);
        let gravity = spec.settings.gravity;
        let falls = |body: &usize| !spec.is_held(*body);
        let bodies: Vec<usize> = [Some(contact.body), other].into_iter().flatten().filter(falls).collect();
        // Gravity accelerates two free bodies alike, so that they do not approach each other by it.
        let acceleration = if bodies.len() == 2 { 0.0 } else { gravity.norm() };
        let overlap = contact.initial_overlap;
        Some(Self { detector, poses, bodies, gravity, acceleration, size, overlap })
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
            let gap = self.detector.nearest(&poses, &mut search)?.gap;
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
        // The direction between bodies is not defined when they touch: the instant just before is taken, even if it is before the start.
        let speed = self.detector.closing_speed_bound(&self.at(time));
        let mut back = 2.0 * (settings.gap - gap.min(0.0)) / speed;
        for _ in 0..LOOKS_BACK {
            let poses = self.at(time - back);
            let nearest = self.detector.nearest(&poses, &mut search).ok()?;
            if nearest.gap > 0.0 {
                let has_direction = nearest.normal.norm() > 0.5;
                return has_direction.then_some((poses, nearest));
            }
            back *= 2.0;
        }
        None
    }
}
