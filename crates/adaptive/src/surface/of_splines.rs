//! The surface of a body of splines, flexible or rigid: the outer faces of its exact shape.

use std::sync::{Arc, OnceLock};

use contact_qs::ContactError;
use contact_qs::search::SurfaceModel;
use ffr_dynamics::body::RigidMotion;
use iga_core::elasticity::Model;
use iga_core::nurbs::Face;
use iga_core::nurbs::jet::{difference, norm};
use iga_core::nurbs::patch::PointBasis;
use iga_core::nurbs::shape::lengths::lengths;
use iga_core::nurbs::{FaceId, Patch, SAME_PLACE, Shape};
use iga_core::surface::{BodySurface, FacePoint};
use nalgebra::Vector3;

use super::turned_net::regular_view;
use super::{ALONG_LINE, Foot, LocalShape, StraightLine, Surface, SurfacePlace};
use crate::spec::body::rigid_motion;

/// Part of a body's size below which the lines of a net that run around a place are a pole: closest
/// places are known to the root of round-off, and are as far from it.
pub const POLE: f64 = 100.0 * SAME_PLACE;
/// Cosine of the angle between normals that belong to one smooth surface: 8 degrees, for faces that
/// only approximate one.
pub const ALONG: f64 = 0.99;
/// Shares of the ranges of a face's parameters at which it is looked at.
const SAMPLES: [[f64; 2]; 5] = [[0.1, 0.2], [0.9, 0.3], [0.5, 0.5], [0.2, 0.8], [0.7, 0.9]];
/// Steps along a part of a plane face in which its extent is looked for: a quarter of a circle then misses it by 0.5 % at most.
const FACE_STEPS: usize = 8;
/// Projections on both faces of an edge in turn that lead to a place on it, from one on a tangent
/// of the edge: faces at right angles need one.
const EDGE_SWEEPS: usize = 8;

/// Outer faces of a shape.
pub struct SplineSurface {
    shape: Arc<Shape>,
    model: Model,
    /// All faces, outer or not, by number.
    ids: Vec<FaceId>,
    outer: Vec<Face>,
    size: f64,
    /// Searches on all outer faces.
    whole: OnceLock<BodySurface>,
    /// Searches on each of them.
    single: Vec<OnceLock<BodySurface>>,
}

impl SplineSurface {
    /// The surface of `shape`, a body of the kinematics `model`.
    pub fn of(shape: &Arc<Shape>, model: &Model) -> Arc<Self> {
        let outer = Face::outer(&shape.patches, *model == Model::Axisymmetric);
        let points = shape.patches.iter().flat_map(|p| p.control_points());
        Arc::new(Self {
            ids: FaceId::all(&shape.patches),
            size: points.map(|p| Vector3::from(*p).norm()).fold(0.0, f64::max),
            whole: OnceLock::new(),
            single: outer.iter().map(|_| OnceLock::new()).collect(),
            outer,
            shape: Arc::clone(shape),
            model: *model,
        })
    }

    fn patches(&self) -> &[Patch] {
        &self.shape.patches
    }

    fn whole(&self) -> &BodySurface {
        self.whole.get_or_init(|| BodySurface::of_faces(self.patches(), self.outer.clone()))
    }

    /// Searches on the outer face `i`.
    fn single(&self, i: usize) -> &BodySurface {
        self.single[i].get_or_init(|| BodySurface::of_faces(self.patches(), vec![self.outer[i]]))
    }

    /// The face of number `face`.
    fn face(&self, face: u32) -> Face {
        Face::new(self.patches(), self.ids[face as usize], self.model == Model::Axisymmetric)
    }

    fn number(&self, id: FaceId) -> u32 {
        self.ids.iter().position(|known| *known == id).unwrap_or_default() as u32
    }

    /// The place at the parameters `xi` of `face`.
    fn place_on(&self, face: &Face, xi: &[f64; 3]) -> SurfacePlace {
        let xi = face.on_face(xi);
        SurfacePlace { face: self.number(face.id), xi, point: self.patches()[face.id.patch].point(&xi) }
    }

    /// Outer faces that `point` is no farther from than round-off, with the place of each there,
    /// poles included.
    fn faces_at(&self, point: &[f64; 3]) -> impl Iterator<Item = (usize, FacePoint)> {
        let within = 4.0 * SAME_PLACE * self.size;
        (0..self.outer.len()).filter_map(move |i| {
            let found = self.single(i).closest(self.patches(), point)?;
            (found.measure <= within).then_some((i, found))
        })
    }

    /// The faces at `point` with their normals; those that have a pole there are left out.
    fn regular_at(&self, point: &[f64; 3]) -> impl Iterator<Item = (usize, Vector3<f64>)> {
        self.faces_at(point).filter_map(|(i, found)| {
            let normal = Vector3::from(found.normal);
            (normal.norm() > 0.5 && !self.is_pole(&self.outer[i], &found.xi)).then_some((i, normal))
        })
    }

    /// Whether lines of parameters of `face` run together at `xi`: a pole has no normal of its own,
    /// what is computed there is round-off, and it is no edge.
    fn is_pole(&self, face: &Face, xi: &[f64; 3]) -> bool {
        let patch = &self.patches()[face.id.patch];
        let (lower, upper) = patch.domain();
        let tangents = face.at(patch, xi, &mut PointBasis::default()).tangents;
        let mut lengths =
            face.directions().zip(tangents).map(|(d, t)| Vector3::from(t).norm() * (upper[d] - lower[d]));
        lengths.any(|length| length <= POLE * self.size)
    }

    /// The line of `face` through `xi` along its parameter `d`, if that is straight.
    fn line(&self, face: &Face, xi: &[f64; 3], d: usize) -> Option<StraightLine> {
        let patch = &self.patches()[face.id.patch];
        let (lower, upper) = patch.domain();
        let at = |share: f64| {
            let mut there = face.on_face(xi);
            there[d] = lower[d] + share * (upper[d] - lower[d]);
            there
        };
        let points = ALONG_LINE.map(|share| Vector3::from(patch.point(&at(share))));
        let near = SAME_PLACE * self.size;
        let along = (points[ALONG_LINE.len() - 1] - points[0]).try_normalize(4.0 * near)?;
        let is_straight = points.iter().all(|p| (p - points[0]).cross(&along).norm() <= near);
        is_straight.then(|| StraightLine { points, middle: self.place_on(face, &at(0.5)) })
    }

    /// Places of the edge of two outer faces at the distance `length` from `start` on it, on both
    /// sides; its end where it ends before.
    fn along_edge(&self, faces: [usize; 2], start: &Vector3<f64>, length: f64) -> Vec<Vector3<f64>> {
        let patches = self.patches();
        let surfaces = faces.map(|i| self.single(i));
        let normals = [0, 1]
            .map(|k| surfaces[k].closest(patches, &(*start).into()).map(|found| Vector3::from(found.normal)));
        let [Some(a), Some(b)] = normals else { return Vec::new() };
        let Some(tangent) = a.cross(&b).try_normalize(1.0 - ALONG) else { return Vec::new() };
        let end = |sign: f64| {
            let mut place = start + sign * length * tangent;
            for surface in surfaces.iter().cycle().take(2 * EDGE_SWEEPS) {
                place = surface.closest(patches, &place.into())?.point.into();
            }
            let is_elsewhere = (place - start).norm() > 0.1 * length;
            is_elsewhere.then_some(place)
        };
        [1.0, -1.0].into_iter().filter_map(end).collect()
    }
}

/// A part of a face between knots.
struct FacePart {
    face: Face,
    lower: [f64; 3],
    upper: [f64; 3],
}

impl FacePart {
    /// Parameters at shares of its ranges.
    fn at_shares(&self, shares: [f64; 2]) -> [f64; 3] {
        let mut xi = self.lower;
        for (d, share) in self.face.directions().zip(shares) {
            xi[d] += share * (self.upper[d] - self.lower[d]);
        }
        xi
    }
}

/// The places of those of `parts` that hang together with the one nearest to `point`: two do that have a
/// place in common, but for `near` \[m\].
fn connected(mut parts: Vec<Vec<[f64; 3]>>, point: &[f64; 3], near: f64) -> Vec<[f64; 3]> {
    let distance = |x: &[f64; 3], y: &[f64; 3]| norm(&difference(x, y));
    let least = |part: &Vec<[f64; 3]>| part.iter().map(|x| distance(x, point)).fold(f64::INFINITY, f64::min);
    let first = (0..parts.len()).min_by(|a, b| least(&parts[*a]).total_cmp(&least(&parts[*b])));
    let mut face = first.map_or_else(Vec::new, |first| parts.swap_remove(first));
    let is_met = |face: &[[f64; 3]], part: &[[f64; 3]]| {
        part.iter().any(|x| face.iter().any(|y| distance(x, y) <= near))
    };
    while let Some(next) = parts.iter().position(|part| is_met(&face, part)) {
        face.append(&mut parts.swap_remove(next));
    }
    face
}

/// The parts of `face` between the knots of its patch.
fn parts(face: &Face, patch: &Patch) -> Vec<FacePart> {
    let (lower, upper) = patch.domain();
    let whole = FacePart { face: *face, lower: face.on_face(&lower), upper: face.on_face(&upper) };
    face.directions().fold(vec![whole], |parts, d| {
        let breaks = patch.knots()[d].breaks();
        let cut = |part: FacePart| -> Vec<FacePart> {
            let between = |ends: &[f64]| {
                let mut cut = FacePart { ..part };
                (cut.lower[d], cut.upper[d]) = (ends[0], ends[1]);
                cut
            };
            breaks.windows(2).map(between).collect()
        };
        parts.into_iter().flat_map(cut).collect()
    })
}

impl Surface for SplineSurface {
    fn motion(&self) -> RigidMotion {
        rigid_motion(&self.model)
    }

    fn points(&self) -> Box<dyn Iterator<Item = &[f64; 3]> + '_> {
        Box::new(self.patches().iter().flat_map(|p| p.control_points()))
    }

    fn length(&self) -> f64 {
        lengths(&self.shape).into_iter().fold(0.0, f64::max)
    }

    fn n_faces(&self) -> usize {
        self.ids.len()
    }

    fn place(&self, face: u32, xi: &[f64; 3]) -> SurfacePlace {
        self.place_on(&self.face(face), xi)
    }

    fn share_directions(&self, [a, b]: [u32; 2]) -> bool {
        a == b
    }

    fn search_model(&self) -> Result<SurfaceModel, ContactError> {
        SurfaceModel::rigid(self.motion(), self.patches())
    }

    fn nearest(&self, point: &[f64; 3]) -> Option<Foot> {
        let found = self.whole().closest(self.patches(), point)?;
        Some(Foot {
            place: SurfacePlace {
                face: self.number(self.outer[found.face].id),
                xi: found.xi,
                point: found.point,
            },
            normal: found.normal.into(),
            distance: found.measure,
        })
    }

    fn lowest(&self, direction: &Vector3<f64>) -> Option<SurfacePlace> {
        let first = self.whole().lowest(self.patches(), direction.as_ref())?;
        Some(self.place_on(&self.outer[first.face], &first.xi))
    }

    fn normal(&self, place: &SurfacePlace) -> Vector3<f64> {
        let face = self.face(place.face);
        face.at(&self.patches()[face.id.patch], &place.xi, &mut PointBasis::default()).normal.into()
    }

    fn normals_at(&self, point: &[f64; 3]) -> Vec<Vector3<f64>> {
        self.regular_at(point).map(|(_, normal)| normal).collect()
    }

    fn smooth_cosine(&self) -> f64 {
        ALONG
    }

    fn shape_at(&self, place: &SurfacePlace) -> Option<LocalShape> {
        let own = self.face(place.face);
        // Where the net is singular, it has no curvatures to show.
        let turned = match self.model {
            Model::Solid => regular_view(&self.shape, &own, &place.xi).ok()?,
            _ => None,
        };
        let (patch, face, at) = match &turned {
            Some((shape, face, xi)) => (&shape.patches[face.id.patch], *face, *xi),
            None => (&self.patches()[own.id.patch], own, place.xi),
        };
        let jet = patch.jet(&face.on_face(&at), 2, &mut PointBasis::default());
        let geometry = face.geometry(&jet);
        Some(LocalShape {
            curvatures: face.curvatures(&jet)?,
            direction: face.first_direction(&jet).map_or_else(Vector3::zeros, Vector3::from),
            tangents: geometry.tangents.map(Vector3::from),
            normal: geometry.normal.into(),
        })
    }

    fn turned_to(&self, place: &SurfacePlace, direction: &Vector3<f64>) -> SurfacePlace {
        let there = self.faces_at(&place.point).map(|(i, found)| {
            let cosine = Vector3::from(found.normal).dot(direction);
            (cosine, self.place_on(&self.outer[i], &found.xi))
        });
        there.max_by(|a, b| a.0.total_cmp(&b.0)).map_or(*place, |(_, place)| place)
    }

    fn flat_face(&self, point: &[f64; 3], outward: &Vector3<f64>, parallel: f64) -> Vec<[f64; 3]> {
        // A part between knots may be plane where the face as a whole goes on in a fillet.
        let all = self.outer.iter().flat_map(|face| parts(face, &self.patches()[face.id.patch]));
        let is_plane = |part: &FacePart| {
            let mut scratch = PointBasis::default();
            let (face, patch) = (part.face, &self.patches()[part.face.id.patch]);
            SAMPLES.iter().all(|shares| {
                let at = face.at(patch, &part.at_shares(*shares), &mut scratch);
                let height = (Vector3::from(at.point) - Vector3::from(*point)).dot(outward);
                let lean = Vector3::from(at.normal).cross(outward).norm();
                Vector3::from(at.normal).dot(outward) > 0.5
                    && lean <= parallel
                    && height.abs() <= (parallel + SAME_PLACE) * self.size
            })
        };
        let places = |part: FacePart| -> Vec<[f64; 3]> {
            let patch = &self.patches()[part.face.id.patch];
            let share = |k: usize| k as f64 / FACE_STEPS as f64;
            let n = if part.face.directions().count() > 1 { FACE_STEPS } else { 0 };
            let grid = (0..=FACE_STEPS).flat_map(|i| (0..=n).map(move |j| [share(i), share(j)]));
            grid.map(|shares| patch.point(&part.at_shares(shares))).collect()
        };
        let parts: Vec<Vec<[f64; 3]>> = all.filter(is_plane).map(places).collect();
        connected(parts, point, 4.0 * SAME_PLACE * self.size)
    }

    fn lines_through(&self, point: &[f64; 3]) -> Vec<StraightLine> {
        if self.model != Model::Solid {
            return Vec::new();
        }
        let lines = self.faces_at(point).flat_map(|(i, found)| {
            let face = &self.outer[i];
            face.directions().filter_map(move |d| self.line(face, &found.xi, d))
        });
        lines.collect()
    }

    fn along_edges(&self, point: &[f64; 3], length: f64) -> Vec<Vector3<f64>> {
        let meeting: Vec<usize> = self.regular_at(point).map(|(i, _)| i).collect();
        let pairs = meeting.iter().enumerate().flat_map(|(k, a)| meeting[..k].iter().map(move |b| [*a, *b]));
        pairs.flat_map(|faces| self.along_edge(faces, &Vector3::from(*point), length)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn feet_that_do_not_hang_together_are_two_faces() {
        let part = |from: f64| vec![[from, 0.0, 0.0], [from + 1.0, 0.0, 0.0]];
        // Two parts with a common end, and one beside them.
        let parts = || vec![part(5.0), part(1.0), part(0.0)];
        let mut face = connected(parts(), &[0.2, 0.0, 1.0], 1e-9);
        face.sort_by(|a, b| a[0].total_cmp(&b[0]));
        assert_eq!(face.iter().map(|x| x[0]).collect::<Vec<_>>(), [0.0, 1.0, 1.0, 2.0]);
        assert_eq!(connected(parts(), &[5.5, 0.0, 0.0], 1e-9), part(5.0));
        assert!(connected(Vec::new(), &[0.0; 3], 1e-9).is_empty());
    }
}
