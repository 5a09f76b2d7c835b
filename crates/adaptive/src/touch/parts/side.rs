//! A body at a touch: the faces that meet where it is touched, and the direction to its partner
//! that follows from their normals (docs/theory.md Eqs. C.60 to C.62).

use contact_qs::search::SurfaceSite;
use ffr_dynamics::body::RigidMotion;
use ffr_dynamics::force::BodyState;
use iga_core::nurbs::SAME_PLACE;
use nalgebra::{UnitQuaternion, Vector3};

use crate::record::{TargetPlace, TouchedPart};
use crate::surface::{ALONG, Surface, SurfacePlace};
use crate::touch::detection::Nearest;
use crate::touch::tolerances::{ALONG_EDGE, OPENING, ROUND_OFF, SAME_DIRECTION};

/// Limit of the sweeps over the normals of a cone: the normals at a place differ by 8 degrees or
/// more, so that each sweep reduces the error by 2 % or more.
const SWEEPS: usize = 500;
/// Halvings of the way along an edge in the search for the end of a face under it: to a billionth of
/// the bodies' size, as places are known.
const HALVINGS: usize = 30;
/// Improvement below which a direction does not count as better than an earlier one: the error that
/// the sweeps leave.
const BETTER: f64 = 1e-6;

/// The unit normal from a target to a contact body at a place where they touch, whose faces have
/// the outward unit normals `target` and `own` there (Eq. C.62): of the directions of the faces,
/// their means and the common normals of edges the one that lies nearest to the normals' cones of
/// both, a face before an edge. None without normals.
pub fn contact_normal(target: &[Vector3<f64>], own: &[Vector3<f64>]) -> Option<Vector3<f64>> {
    let own: Vec<Vector3<f64>> = own.iter().map(|n| -n).collect();
    let means = target.iter().flat_map(|t| own.iter().map(move |o| t + o));
    let edges = |normals: &[Vector3<f64>]| -> Vec<Vector3<f64>> {
        let pairs =
            normals.iter().enumerate().flat_map(|(i, a)| normals[..i].iter().map(move |b| a.cross(b)));
        pairs.collect()
    };
    let (first, second) = (edges(target), edges(&own));
    let crossed = first.iter().flat_map(|a| second.iter().flat_map(move |b| [a.cross(b), b.cross(a)]));
    let candidates = target.iter().chain(&own).copied().chain(means).chain(crossed);
    let mut best: Option<(f64, Vector3<f64>)> = None;
    for direction in candidates.filter_map(|d| d.try_normalize(1e-3)) {
        let error = beyond_cone(&direction, target).max(beyond_cone(&direction, &own));
        if best.is_none_or(|(least, _)| error < least - BETTER) {
            best = Some((error, direction));
        }
    }
    best.map(|(_, direction)| direction)
}

/// Distance of the unit vector `direction` from the cone of the unit vectors `normals`, by
/// minimisation over one coefficient after the other.
fn beyond_cone(direction: &Vector3<f64>, normals: &[Vector3<f64>]) -> f64 {
    let mut coefficients = vec![0.0_f64; normals.len()];
    let mut rest = *direction;
    for _ in 0..SWEEPS {
        for (normal, coefficient) in normals.iter().zip(&mut coefficients) {
            let next = (*coefficient + rest.dot(normal)).max(0.0);
            rest -= normal * (next - *coefficient);
            *coefficient = next;
        }
    }
    rest.norm()
}

/// A surface with the motion of its body.
pub type Moved<'a> = (&'a dyn Surface, &'a BodyState);

/// A body at the touch.
pub struct Side<'a> {
    surface: &'a dyn Surface,
    rotation: UnitQuaternion<f64>,
    /// Outward direction in which the partner lies, in the components of the model; zero as long as
    /// it is not known.
    outward: Vector3<f64>,
    size: f64,
}

impl<'a> Side<'a> {
    /// The body of a surface in its motion, whose partner may lie anywhere.
    pub fn new((surface, pose): Moved<'a>) -> Self {
        Self { surface, rotation: pose.rotation, outward: Vector3::zeros(), size: surface.reach() }
    }

    /// This side with its partner in the direction `outward`, given in space.
    #[must_use]
    pub fn facing(self, outward: &Vector3<f64>) -> Self {
        let in_body = self.rotation.inverse_transform_vector(outward);
        Self { outward: self.surface.motion().components(in_body.as_ref()).into(), ..self }
    }

    /// Largest distance of its points from the origin of the body \[m\].
    pub fn size(&self) -> f64 {
        self.size
    }

    /// The part of the surface that lies within `depth` \[m\] of the plane of a touch at `origin`,
    /// however far aside.
    pub fn part(&self, origin: [f64; 3], depth: f64) -> TouchedPart {
        TouchedPart { origin, outward: self.outward.into(), depth, radius: f64::INFINITY }
    }

    /// The place of this body that a search has found.
    pub fn place(&self, found: &SurfaceSite) -> SurfacePlace {
        self.surface.place(found.face, &found.xi)
    }

    /// The same, on the face of those that meet there that is turned to the partner.
    pub fn facing_place(&self, found: &SurfaceSite) -> SurfacePlace {
        self.surface.turned_to(&self.place(found), &self.outward)
    }

    /// Outward normals, in space, of the faces that meet at `place`; at a pole, which has none,
    /// that of the face.
    pub fn normals_in_space(&self, place: &SurfacePlace) -> Vec<Vector3<f64>> {
        let in_space = |n: &Vector3<f64>| self.rotation * self.surface.motion().in_space(n.as_ref());
        let found = self.surface.normals_at(&place.point);
        if found.is_empty() {
            return vec![in_space(&self.surface.normal(place))];
        }
        found.iter().map(in_space).collect()
    }

    /// Whether a plane face through `point` is turned to the partner, but for the angle `parallel`
    /// \[rad\] (Eq. C.60).
    pub fn is_flat(&self, point: &[f64; 3], parallel: f64) -> bool {
        self.surface.has_flat_face(point, &self.outward, parallel)
    }

    /// Places all over this face; none without one \[m\].
    pub fn flat_face(&self, point: &[f64; 3], parallel: f64) -> Vec<[f64; 3]> {
        self.surface.flat_face(point, &self.outward, parallel)
    }

    /// Number of different normals at `point`: one of a smooth surface, two of an edge, three and
    /// more of a corner.
    pub fn n_normals(&self, point: &[f64; 3]) -> usize {
        self.surface.parts_at(point).len()
    }

    /// The edge of the solid `target` that lies along a face of this body, if there is one. It touches
    /// the smooth part of the face at `point` of this body and `there` of the target with the normal
    /// `normal`, and is no farther from it than `slack` \[m\] at a tenth of the bodies' size.
    pub fn edge_over(
        &self,
        point: &[f64; 3],
        normal: &Vector3<f64>,
        target: &Self,
        there: &[f64; 3],
        slack: f64,
    ) -> Option<EdgeOver> {
        if self.surface.motion() != RigidMotion::Spatial {
            return None;
        }
        let here = Vector3::from(*point);
        // Places beside the face do not count, nor do edges of this body, where contact points stand.
        let under = |way: &Vector3<f64>| {
            let place = here + self.rotation.inverse_transform_vector(way);
            let found = self.surface.nearest(&place.into())?;
            let outward = self.rotation * found.normal;
            (found.distance <= slack && outward.dot(normal) < -ALONG)
                .then(|| self.n_normals(&found.place.point) == 1)
        };
        target.edge_where(there, (self.size.min(target.size), slack), under)
    }

    /// The edge of this solid through `there`, no farther aside than `slack` of bodies that are `least` large \[m\], as far as something
    /// lies `under` a way in space from there, which also tells whether it is smooth.
    pub fn edge_where(
        &self,
        there: &[f64; 3],
        (least, slack): (f64, f64),
        under: impl Fn(&Vector3<f64>) -> Option<bool>,
    ) -> Option<EdgeOver> {
        let start = Vector3::from(*there);
        let over = |way: &Vector3<f64>| under(&(self.rotation * way));
        let is_edge = |way: &Vector3<f64>| {
            let found = self.surface.nearest(&(start + way).into());
            found.is_some_and(|found| found.distance <= slack && self.n_normals(&found.place.point) > 1)
        };
        let ways = self.surface.along_edges(there, ALONG_EDGE * least).into_iter().map(|end| end - start);
        let way = ways.into_iter().find(|way| over(way) == Some(true))?;
        if !is_edge(&(0.5 * way)) {
            return Some(EdgeOver::Bent);
        }
        let farthest = 2.0 * least * way.normalize();
        let end = |farthest: Vector3<f64>| {
            let [mut inside, mut outside] = [0.0, 1.0];
            for _ in 0..HALVINGS {
                let middle = 0.5 * (inside + outside);
                let way = middle * farthest;
                if over(&way).is_some() && is_edge(&way) { inside = middle } else { outside = middle }
            }
            inside * farthest
        };
        Some(EdgeOver::Straight([end(-farthest), end(farthest)]))
    }

    /// Whether `point` lies on an edge, or in the plane on a corner, from which both faces open by [`OPENING`] at least against the plane
    /// of the touch.
    pub fn is_tip(&self, point: &[f64; 3]) -> bool {
        let faces = self.surface.parts_at(point);
        faces.len() == 2 && faces.iter().all(|face| face.dot(&self.outward) < OPENING.cos())
    }

    /// Outward direction in which the partner lies, in the components of the model; zero as long as it is not known.
    pub fn outward(&self) -> [f64; 3] {
        self.outward.into()
    }

    /// Whether the surface is smooth at `point`: the faces that meet there have one normal, which
    /// lies along the direction to the partner (Eq. C.61).
    pub fn is_smooth(&self, point: &[f64; 3]) -> bool {
        let normals = self.surface.normals_at(point);
        let all_within = |cosine: f64| normals.iter().all(|normal| normal.dot(&self.outward) > cosine);
        all_within(ALONG) || normals.len() == 1 && all_within(self.surface.smooth_cosine())
    }
}

/// An edge of a target that lies along a face of the contact body.
pub enum EdgeOver {
    /// A straight one: from the place of the touch to both ends of the part that lies there, in the
    /// target's frame \[m\].
    Straight([Vector3<f64>; 2]),
    /// A curved one.
    Bent,
}

/// Largest distance of an edge from a face along which it lies, inclined by the angle `parallel` \[rad\]
/// at most \[m\].
pub fn slack(own: &Side<'_>, target: &Side<'_>, parallel: f64) -> f64 {
    (parallel + SAME_PLACE) * own.size().min(target.size())
}

/// The place of an edge or a corner of the target that the contact body meets, with the normal of
/// Eq. C.62. None if the target is smooth there, or if one of its faces has this normal: then the
/// face is touched, at its end. Of a straight edge along a face, which may be inclined by the angle
/// `parallel` \[rad\], the place is the middle of the part that lies there.
pub fn met_place(own: &Side<'_>, target: &Side<'_>, nearest: &Nearest, parallel: f64) -> Option<TargetPlace> {
    let (here, there) = (own.place(&nearest.contact), target.place(nearest.target.as_ref()?));
    if target.n_normals(&there.point) < 2 {
        return None;
    }
    let faces = target.normals_in_space(&there);
    let normal = contact_normal(&faces, &own.normals_in_space(&here))?;
    if faces.iter().any(|face| face.dot(&normal) > SAME_DIRECTION) {
        return None;
    }
    let slack = slack(own, target, parallel);
    let along = match own.edge_over(&here.point, &normal, target, &there.point, slack) {
        Some(EdgeOver::Straight([from, to])) => {
            let half = 0.5 * (to - from);
            [own.rotation.inverse_transform_vector(&(target.rotation * half)).into(), half.into()]
        }
        Some(EdgeOver::Bent) | None => [[0.0; 3]; 2],
    };
    let normal = target.rotation.inverse_transform_vector(&normal).into();
    Some(TargetPlace { face: there.face, xi: there.xi, normal, along, ..TargetPlace::default() })
}

/// Direction from the target to the contact body: between the nearest places or, where these agree
/// up to round-off, from the normals of the faces that meet there (Eq. C.62).
pub fn touch_direction(own: &Side<'_>, other: Option<&Side<'_>>, nearest: &Nearest) -> Vector3<f64> {
    let (Some(target), Some(there)) = (other, nearest.target) else { return nearest.normal };
    if nearest.gap.abs() > ROUND_OFF * own.size() && nearest.normal.norm() > 0.5 {
        return nearest.normal;
    }
    contact_normal(
        &target.normals_in_space(&target.place(&there)),
        &own.normals_in_space(&own.place(&nearest.contact)),
    )
    .unwrap_or(nearest.normal)
}

#[cfg(test)]
mod tests {
    use super::*;

    const X: Vector3<f64> = Vector3::new(1.0, 0.0, 0.0);
    const Y: Vector3<f64> = Vector3::new(0.0, 1.0, 0.0);
    const Z: Vector3<f64> = Vector3::new(0.0, 0.0, 1.0);

    fn check(target: &[Vector3<f64>], own: &[Vector3<f64>], expected: Vector3<f64>) {
        let found = contact_normal(target, own).expect("normals");
        // Round-off of unit vectors, and what sweeps leave of a cone.
        assert!((found - expected.normalize()).norm() < 1e-9, "{found} for {expected}");
    }

    #[test]
    fn a_face_has_the_normal_over_edges_and_corners() {
        check(&[Z, X], &[-Z], Z); // an edge of the target under a face
        check(&[X, Z], &[-Z], Z);
        check(&[Z], &[X, -Z], Z);
        check(&[Z], &[(X - 3.0 * Z).normalize(), (-X - Z).normalize()], Z); // an edge that leans
        check(&[Z], &[(X - Z).normalize(), (Y - Z).normalize(), (-X - Y - 2.0 * Z).normalize()], Z);
    }

    #[test]
    fn rims_that_lie_on_each_other_have_the_normal_of_their_ends() {
        check(&[X, Z], &[X, -Z], Z);
        check(&[Z, -X], &[-Z, -X], Z);
    }

    #[test]
    fn crossing_edges_have_their_common_normal() {
        let along = |a: Vector3<f64>, sign: f64| [(sign * Z + a).normalize(), (sign * Z - a).normalize()];
        check(&along(X, 1.0), &along(Y, -1.0), Z);
        check(&along(X, 1.0), &along((X + Y).normalize(), -1.0), Z);
    }

    #[test]
    fn smooth_surfaces_share_their_normal() {
        let lean = 1e-3 * X;
        check(&[(Z + lean).normalize()], &[(lean - Z).normalize()], Z);
    }
}
