//! Flat faces of a target that are narrower than the elements under them (docs/theory.md Eq. C.102).

use contact_qs::search::SurfaceSite;
use nalgebra::Vector3;

use super::Touch;
use super::side::{Moved, Side};
use crate::surface::SurfacePlace;
use crate::touch::detection::Nearest;

/// Part of the contact body's face beyond which that of the target is not narrow: bars that meet with their ends yield as waves
/// along them say, not as a half space under a punch.
const BESIDE: f64 = 0.5;

/// The middle of what touches where flat faces of a contact body and a target do, and its extents along the face
/// of the contact body \[m\], if one of them is smaller than `least` says of the place and than half of that face. Faces may be inclined by
/// the angle `parallel` \[rad\].
pub fn narrow_face(
    own: Moved<'_>,
    other: Moved<'_>,
    touch: &Touch,
    parallel: f64,
    least: impl FnOnce(&SurfacePlace) -> Option<[f64; 2]>,
) -> Option<(Nearest, [f64; 2])> {
    let (side, target) = (Side::new(own).facing(&-touch.normal), Side::new(other).facing(&touch.normal));
    let here = side.facing_place(&touch.nearest.contact);
    let there = target.place(touch.nearest.target.as_ref()?);
    // What lies beyond the end of the contact body touches at this end at most.
    let onto = |(to, from): (Moved<'_>, Moved<'_>), point: &[f64; 3]| {
        to.0.nearest(&in_body(to, &in_space(from, point))).map(|foot| foot.place)
    };
    let face = target.flat_face(&there.point, parallel);
    let feet: Vec<[f64; 3]> =
        face.iter().filter_map(|point| Some(onto((own, other), point)?.point)).collect();
    let axes = own.0.shape_at(&here)?.tangents.map(|t| t.try_normalize(0.0).unwrap_or_default());
    let extents = axes.map(|axis| extent(&range(&feet, &axis)));
    let whole = side.flat_face(&here.point, parallel);
    let least = least(&here)?;
    let is_narrow =
        |d: usize| extents[d] > 0.0 && extents[d] < least[d].min(BESIDE * extent(&range(&whole, &axes[d])));
    if !(0..2).any(is_narrow) {
        return None;
    }
    let across = (axes[1] - axes[0] * axes[0].dot(&axes[1])).try_normalize(0.0).unwrap_or_default();
    let middle = |axis: &Vector3<f64>| {
        let [low, high] = range(&feet, axis);
        (0.5 * (low + high) - Vector3::from(here.point).dot(axis)) * axis
    };
    let way = middle(&axes[0]) + middle(&across);
    let middle: [f64; 3] = (Vector3::from(here.point) + way).into();
    let as_found = |moved: Moved<'_>, place: &SurfacePlace| SurfaceSite {
        face: place.face,
        xi: place.xi,
        point: in_space(moved, &place.point),
    };
    let contact = side.facing_place(&as_found(own, &own.0.nearest(&middle)?.place));
    let there = target.facing_place(&as_found(other, &onto((other, own), &contact.point)?));
    let nearest =
        Nearest { contact: as_found(own, &contact), target: Some(as_found(other, &there)), ..touch.nearest };
    // A curve has one direction.
    let longest = extents[0].max(extents[1]);
    Some((nearest, extents.map(|extent| if extent > 0.0 { extent } else { longest })))
}

/// Least and largest place of `points` along `axis` \[m\].
fn range(points: &[[f64; 3]], axis: &Vector3<f64>) -> [f64; 2] {
    let along = points.iter().map(|point| Vector3::from(*point).dot(axis));
    along.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], x| [a.min(x), b.max(x)])
}

fn extent([low, high]: &[f64; 2]) -> f64 {
    high - low
}

/// A point of the model of a body in its motion \[m\].
fn in_space((surface, pose): Moved<'_>, point: &[f64; 3]) -> Vector3<f64> {
    pose.position + pose.rotation * surface.motion().in_space(point)
}

/// A point of space in the components of the model of a body in its motion \[m\].
fn in_body((surface, pose): Moved<'_>, point: &Vector3<f64>) -> [f64; 3] {
    surface.motion().components(pose.rotation.inverse_transform_vector(&(point - pose.position)).as_ref())
}
