//! Touches along a whole straight line of a curved face, such as that of a cylinder that lies on a plane (docs/theory.md Eqs. C.120, C.121).
//!
//! Of such a line the search for the nearest places finds any one, often its end, where an edge seems to touch. The interval of the contact lies
//! about the middle of the line and is as long as the face.

use iga_core::nurbs::{Patch, SAME_PLACE};
use iga_core::surface::{BodySurface, Face};
use nalgebra::Vector3;

use contact_qs::search::SurfaceSite;
use ffr_dynamics::body::RigidMotion;
use ffr_dynamics::system::force::BodyState;

use crate::detection::Nearest;
use crate::local_surface::SurfaceView;
use crate::spec::Geometry;
use crate::touch_side::{Side, touch_direction};

/// Angle \[rad\] by which the normal at the nearest place may miss the direction to the partner: places across the curved direction are known to the
/// root of round-off, and bodies that ring turn by less.
const ACROSS: f64 = 1e-3;
/// Curvature times size of a body below which a surface is flat: round-off of its net.
const FLAT: f64 = 1e-6;
/// Shares of the line at which it is looked at.
const PLACES: [f64; 5] = [0.0, 0.25, 0.5, 0.75, 1.0];

/// The touch `nearest` of a contact body and a target, shapes with their motions (a plane without the latter), at the middle of the straight
/// line of a face along which they touch; `None` if they do not. Lines may be inclined by the angle `parallel` \[rad\].
pub fn middle_of_line(
    (own, pose): (Geometry<'_>, &BodyState),
    other: Option<(Geometry<'_>, &BodyState)>,
    nearest: &Nearest,
    parallel: f64,
) -> Option<Nearest> {
    if own.motion() != RigidMotion::Spatial {
        return None;
    }
    let (side, target) = (Side::new(own, pose), other.map(|(shape, pose)| Side::new(shape, pose)));
    let normal = touch_direction(&side, target.as_ref(), nearest);
    let outward = pose.rotation.inverse_transform_vector(&-normal);
    let patches = &own.shape.patches;
    let place = Vector3::from(side.point(nearest.contact.face, &nearest.contact.xi));
    let near = SAME_PLACE * side.size();
    let slack = parallel * side.size();
    for face in Face::outer(patches, false) {
        let Some(found) = BodySurface::of_faces(patches, vec![face]).closest(patches, &place.into()) else {
            continue;
        };
        if found.measure > 4.0 * near {
            continue;
        }
        for d in face.directions() {
            let line = Line::new(patches, &face, &found.xi, d);
            let is_touched = line.is_straight(near)
                && line.points.iter().all(|p| (p - place).dot(&outward).abs() <= slack);
            let view =
                is_touched.then(|| SurfaceView::new((own, 1.0), &pose.rotation, face.id, &line.middle));
            let Some(view) = view.flatten().filter(|view| (view.outward + normal).norm() <= ACROSS) else {
                continue;
            };
            let is_curved =
                |view: &SurfaceView| view.surface.curvatures.iter().any(|c| c.abs() * side.size() > FLAT);
            let in_space = |p: &Vector3<f64>| pose.position + pose.rotation * p;
            let contact = |point: &Vector3<f64>| SurfaceSite {
                face: face.id,
                xi: line.middle,
                point: in_space(point),
                ..nearest.contact
            };
            let middle = contact(&line.points[PLACES.len() / 2]);
            let Some((shape, at)) = other else {
                return is_curved(&view).then_some(Nearest { contact: middle, ..*nearest });
            };
            let on_target = |point: &Vector3<f64>| nearest_on(shape, at, &in_space(point));
            let is_along = |point: &Vector3<f64>| {
                on_target(point).is_some_and(|(_, distance)| (distance - nearest.gap.abs()).abs() <= slack)
            };
            if line.points.iter().all(is_along) {
                let (there, _) = on_target(&line.points[PLACES.len() / 2])?;
                let on_target = SurfaceView::new((shape, 1.0), &at.rotation, there.face, &there.xi)?;
                let is_line = is_curved(&view) || is_curved(&on_target);
                return is_line.then_some(Nearest { contact: middle, target: Some(there), ..*nearest });
            }
        }
    }
    None
}

/// The line of a face through a place along one of its parameters.
struct Line {
    points: [Vector3<f64>; PLACES.len()],
    /// Parameters of the middle.
    middle: [f64; 3],
}

impl Line {
    fn new(patches: &[Patch], face: &Face, xi: &[f64; 3], d: usize) -> Self {
        let patch = &patches[face.id.patch];
        let (lower, upper) = patch.domain();
        let at = |share: f64| {
            let mut there = face.on_face(xi);
            there[d] = lower[d] + share * (upper[d] - lower[d]);
            there
        };
        Self { points: PLACES.map(|share| Vector3::from(patch.point(&at(share)))), middle: at(0.5) }
    }

    /// Whether its points lie on a straight line, but for the distance `near` \[m\], and it has a length.
    fn is_straight(&self, near: f64) -> bool {
        let [first, .., last] = self.points;
        let Some(along) = (last - first).try_normalize(4.0 * near) else { return false };
        self.points.iter().all(|p| (p - first).cross(&along).norm() <= near)
    }
}

/// The place of `shape` in the motion `pose` that is nearest to a point of space, and its distance \[m\].
fn nearest_on(shape: Geometry<'_>, pose: &BodyState, point: &Vector3<f64>) -> Option<(SurfaceSite, f64)> {
    let patches = &shape.shape.patches;
    let in_body = pose.rotation.inverse_transform_vector(&(point - pose.position));
    let surface = BodySurface::of_faces(patches, Face::outer(patches, shape.is_axisymmetric()));
    let found = surface.closest(patches, &in_body.into())?;
    let face = surface.faces()[found.face].id;
    let position = pose.position + pose.rotation * Vector3::from(found.point);
    Some((SurfaceSite { face, element: 0, xi: found.xi, point: position }, found.measure))
}
