//! A body at a touch: which faces meet where it is touched, and what they say of the direction to its partner (docs/theory.md Eqs. C.55, C.56,
//! C.110).

use ffr_dynamics::body::RigidMotion;
use ffr_dynamics::system::force::BodyState;
use iga_core::nurbs::patch::PointBasis;
use iga_core::nurbs::{FaceId, Patch, SAME_PLACE};
use iga_core::surface::{BodySurface, Face, FacePoint};
use nalgebra::{UnitQuaternion, Vector3};

use crate::detection::Nearest;
use crate::record::TargetPlace;
use crate::spec::Geometry;

/// Part of a body's size below which the lines of a net that run around a place are a pole: closest places are known to the root of round-off, and
/// are as far from it.
pub const POLE: f64 = 100.0 * SAME_PLACE;
/// Sweeps over the normals of a cone: those of one place differ by 8 degrees or more, so that a sweep takes 2 % of the error or more.
const SWEEPS: usize = 500;
/// Improvement below which a direction is no better than one before it: what the sweeps leave of a direction inside a cone.
const BETTER: f64 = 1e-6;

/// The unit normal from a target to a contact body at a place where they touch, whose faces have the outward unit normals `target` and `own`
/// there (Eq. C.110): of the directions of the faces, their means and the common normals of edges the one that lies nearest to the normals'
/// cones of both, a face before an edge. None without normals.
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

/// Distance of the unit vector `direction` from the cone of the unit vectors `normals`, by minimisation over one coefficient after the other.
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

/// Those of `faces` that `point` is no farther from than `within`, with the place of each there \[m\].
pub fn faces_at(
    patches: &[Patch],
    faces: &[Face],
    point: &[f64; 3],
    within: f64,
) -> impl Iterator<Item = (Face, FacePoint)> {
    faces.iter().filter_map(move |&face| {
        let found = BodySurface::of_faces(patches, vec![face]).closest(patches, point)?;
        (found.measure <= within).then_some((face, found))
    })
}

/// A body at the touch.
pub struct Side<'a> {
    patches: &'a [Patch],
    faces: Vec<Face>,
    motion: RigidMotion,
    rotation: UnitQuaternion<f64>,
    /// Outward direction in which the partner lies, in the components of the model; zero as long as it is not known.
    outward: [f64; 3],
    size: f64,
}

impl<'a> Side<'a> {
    /// The body of the shape `body` at `pose`, whose partner may lie anywhere.
    pub fn new(body: Geometry<'a>, pose: &BodyState) -> Self {
        let patches = &body.shape.patches;
        let faces = Face::outer(patches, body.is_axisymmetric());
        let points = patches.iter().flat_map(|p| p.control_points());
        let size = points.map(|p| Vector3::from(*p).norm()).fold(0.0, f64::max);
        Self { patches, faces, motion: body.motion(), rotation: pose.rotation, outward: [0.0; 3], size }
    }

    /// The same with its partner in the direction `outward` of space.
    #[must_use]
    pub fn facing(self, outward: &Vector3<f64>) -> Self {
        let in_body = self.rotation.inverse_transform_vector(outward);
        Self { outward: self.motion.components(in_body.as_ref()), ..self }
    }

    /// Largest distance of control points from the origin of the body \[m\].
    pub fn size(&self) -> f64 {
        self.size
    }

    /// Outward normals, in space, of the faces that meet at the place `xi` of `face`; at a pole, which has none, that of the face.
    pub fn normals_in_space(&self, face: FaceId, xi: &[f64; 3]) -> Vec<Vector3<f64>> {
        let in_space = |normal: &Vector3<f64>| self.rotation * self.motion.in_space(&(*normal).into());
        let found: Vec<_> = self.normals_at(&self.point(face, xi)).map(|normal| in_space(&normal)).collect();
        if !found.is_empty() {
            return found;
        }
        let own = Face::new(self.patches, face, self.motion == RigidMotion::Axial);
        let at = own.at(&self.patches[face.patch], xi, &mut PointBasis::default());
        vec![in_space(&Vector3::from(at.normal))]
    }

    /// Position of a place of a face.
    pub fn point(&self, face: FaceId, xi: &[f64; 3]) -> [f64; 3] {
        let parameter = face.parameter(self.patches);
        let mut xi = *xi;
        xi[face.direction] = parameter;
        self.patches[face.patch].point(&xi)
    }

    /// Whether a plane face through `point` is turned to the partner, but for the angle `parallel` \[rad\] (Eq. C.55).
    pub fn is_flat(&self, point: &[f64; 3], parallel: f64) -> bool {
        let outward = Vector3::from(self.outward);
        self.faces.iter().any(|face| {
            let mut scratch = PointBasis::default();
            let patch = &self.patches[face.id.patch];
            SAMPLES.iter().all(|shares| {
                let at = face.at(patch, &place(face, patch, *shares), &mut scratch);
                let height = (Vector3::from(at.point) - Vector3::from(*point)).dot(&outward);
                let lean = Vector3::from(at.normal).cross(&outward).norm();
                Vector3::from(at.normal).dot(&outward) > 0.5
                    && lean <= parallel
                    && height.abs() <= (parallel + SAME_PLACE) * self.size
            })
        })
    }

    /// Faces that meet at `point`, with their normals there.
    fn faces_at(&self, point: &[f64; 3]) -> impl Iterator<Item = (Face, Vector3<f64>)> {
        faces_at(self.patches, &self.faces, point, 4.0 * SAME_PLACE * self.size).filter_map(
            |(face, found)| {
                let normal = Vector3::from(found.normal);
                (normal.norm() > 0.5 && !self.is_pole(&face, &found.xi)).then_some((face, normal))
            },
        )
    }

    /// Normals of the faces that meet at `point`.
    fn normals_at(&self, point: &[f64; 3]) -> impl Iterator<Item = Vector3<f64>> {
        self.faces_at(point).map(|(_, normal)| normal)
    }

    /// Whether lines of parameters of `face` run together at `xi`: a pole has no normal of its own, what is computed there is round-off, and it is
    /// no edge.
    fn is_pole(&self, face: &Face, xi: &[f64; 3]) -> bool {
        let patch = &self.patches[face.id.patch];
        let (lower, upper) = patch.domain();
        let tangents = face.at(patch, xi, &mut PointBasis::default()).tangents;
        let mut lengths =
            face.directions().zip(tangents).map(|(d, t)| Vector3::from(t).norm() * (upper[d] - lower[d]));
        lengths.any(|length| length <= POLE * self.size)
    }

    /// Number of different normals at `point`: one of a smooth surface, two of an edge, three and more of a corner.
    pub fn n_normals(&self, point: &[f64; 3]) -> usize {
        let mut different: Vec<Vector3<f64>> = Vec::new();
        for normal in self.normals_at(point) {
            if different.iter().all(|known| known.dot(&normal) < ALONG) {
                different.push(normal);
            }
        }
        different.len()
    }

    /// Whether an edge of the solid `target`, which touches the smooth part of a face at `point` of this body and at `there` of its own with the normal
    /// `normal`, lies along that face: at a tenth of the bodies' size from there, it is no farther from it than `slack` \[m\].
    pub fn holds_edge(
        &self,
        (point, normal): (&[f64; 3], &Vector3<f64>),
        (target, there): (&Self, &[f64; 3]),
        slack: f64,
    ) -> bool {
        if self.motion != RigidMotion::Spatial {
            return false;
        }
        let own = BodySurface::of_faces(self.patches, self.faces.clone());
        let length = ALONG_EDGE * self.size.min(target.size);
        let (here, there) = (Vector3::from(*point), Vector3::from(*there));
        let is_inside = |x: &Vector3<f64>| {
            let in_space = target.rotation * (x - there);
            let place = here + self.rotation.inverse_transform_vector(&in_space);
            let found = own.closest(self.patches, &place.into());
            found.is_some_and(|found| {
                let outward = self.rotation * Vector3::from(found.normal);
                // Beside the face the way to it is no longer along the normal, and on an edge of its own points stand.
                found.measure <= slack && outward.dot(normal) < -ALONG && self.n_normals(&found.point) == 1
            })
        };
        let meeting: Vec<Face> = target.faces_at(&there.into()).map(|(face, _)| face).collect();
        let pairs = meeting.iter().enumerate().flat_map(|(i, a)| meeting[..i].iter().map(move |b| [a, b]));
        pairs.into_iter().any(|faces| {
            let ends = target.along_edge(faces, &there, length);
            ends.iter().any(is_inside)
        })
    }

    /// Places of the edge of two faces at the distance `length` from `start` on it, on both sides; its end where it ends before.
    fn along_edge(&self, faces: [&Face; 2], start: &Vector3<f64>, length: f64) -> Vec<Vector3<f64>> {
        let surfaces = faces.map(|face| BodySurface::of_faces(self.patches, vec![*face]));
        let normals = [0, 1].map(|k| {
            surfaces[k].closest(self.patches, &(*start).into()).map(|found| Vector3::from(found.normal))
        });
        let [Some(a), Some(b)] = normals else { return Vec::new() };
        let Some(tangent) = a.cross(&b).try_normalize(1.0 - ALONG) else { return Vec::new() };
        let end = |sign: f64| {
            let mut place = start + sign * length * tangent;
            for surface in surfaces.iter().cycle().take(2 * EDGE_SWEEPS) {
                place = surface.closest(self.patches, &place.into())?.point.into();
            }
            let is_elsewhere = (place - start).norm() > 0.1 * length;
            is_elsewhere.then_some(place)
        };
        [1.0, -1.0].into_iter().filter_map(end).collect()
    }

    /// Whether the surface is smooth at `point`: the faces that meet there have one normal, which lies along the direction to the partner
    /// (Eq. C.56).
    pub fn is_smooth(&self, point: &[f64; 3]) -> bool {
        let outward = Vector3::from(self.outward);
        self.normals_at(point).all(|normal| normal.dot(&outward) > ALONG)
    }
}

/// Part of the bodies' size at which it is looked whether an edge lies along a face.
const ALONG_EDGE: f64 = 0.1;
/// Projections on both faces of an edge in turn that lead to a place on it, from one on a tangent of the edge: faces at right angles need one.
const EDGE_SWEEPS: usize = 8;

/// Cosine of the angle between normals that belong to one smooth surface: 8 degrees, for faces that only approximate one.
const ALONG: f64 = 0.99;

/// Shares of the ranges of a face's parameters at which it is looked at.
const SAMPLES: [[f64; 2]; 5] = [[0.1, 0.2], [0.9, 0.3], [0.5, 0.5], [0.2, 0.8], [0.7, 0.9]];

/// Parameters of `face` at shares of its ranges.
fn place(face: &Face, patch: &Patch, shares: [f64; 2]) -> [f64; 3] {
    let (lower, upper) = patch.domain();
    let mut xi = face.on_face(&lower);
    for (d, share) in face.directions().zip(shares) {
        xi[d] = lower[d] + share * (upper[d] - lower[d]);
    }
    xi
}

/// Cosine beyond which directions are one: that of a touch is taken from the normals themselves.
const SAME: f64 = 1.0 - 1e-12;

/// What the contact body meets at the nearest places of a target that has an edge or a corner there, with the normal of Eq. C.110; `number` counts
/// the target's faces. None where the target is smooth, and where one of its faces has that normal: it is the face that is touched, at its end.
pub fn met_place(
    own: &Side<'_>,
    target: &Side<'_>,
    nearest: &Nearest,
    number: impl Fn(FaceId) -> Option<u32>,
) -> Option<TargetPlace> {
    let (here, there) = (&nearest.contact, nearest.target.as_ref()?);
    if target.n_normals(&target.point(there.face, &there.xi)) < 2 {
        return None;
    }
    let faces = target.normals_in_space(there.face, &there.xi);
    let normal = contact_normal(&faces, &own.normals_in_space(here.face, &here.xi))?;
    if faces.iter().any(|face| face.dot(&normal) > SAME) {
        return None;
    }
    let normal = target.rotation.inverse_transform_vector(&normal).into();
    Some(TargetPlace { face: number(there.face)?, xi: there.xi, normal })
}

/// Gap over the size of a body below which round-off makes the direction between the places.
const ROUND_OFF: f64 = 1e-9;

/// Direction from the target to the contact body: that between the nearest places or, where these are one but for round-off, what the normals of
/// the faces that meet there say (Eq. C.110).
pub fn touch_direction(own: &Side<'_>, other: Option<&Side<'_>>, nearest: &Nearest) -> Vector3<f64> {
    let (Some(target), Some(there)) = (other, nearest.target) else { return nearest.normal };
    if nearest.gap.abs() > ROUND_OFF * own.size() && nearest.normal.norm() > 0.5 {
        return nearest.normal;
    }
    let here = &nearest.contact;
    contact_normal(
        &target.normals_in_space(there.face, &there.xi),
        &own.normals_in_space(here.face, &here.xi),
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
