//! The surface of an undeformed body, whatever it is made of: faces with parameters, normals,
//! curvatures, edges, and what is nearest.
//!
//! What touches what, and where, is asked here and nowhere else; a new kind of body answers it
//! once. Faces have numbers: of splines those of [`iga_core::nurbs::FaceId::all`], of a mesh those
//! of its sides. Positions and directions are those of the model's components: `(x, y, z)`,
//! `(x, y, 0)` or `(r, z, 0)`.

use std::sync::Arc;

use contact_qs::ContactError;
use contact_qs::search::SurfaceModel;
use ffr_dynamics::body::RigidMotion;
use nalgebra::Vector3;

use crate::record::TouchedPart;
use crate::spec::BodyKind;
use primitive::Primitive;

pub mod primitive;
mod of_mesh;
pub mod turned_net;
mod of_splines;
pub mod smooth_fit;

pub use of_mesh::MeshSurface;
pub use of_splines::{ALONG, POLE, SplineSurface};

/// A place on the surface of an undeformed body. Refinement of splines moves neither faces nor
/// parameters, so that a place of the exact shape is one of every discretisation of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfacePlace {
    /// Number of the face.
    pub face: u32,
    /// Parameters there, of the face's patch; of a side of a mesh its own two.
    pub xi: [f64; 3],
    /// Undeformed position \[m\].
    pub point: [f64; 3],
}

/// The place of a surface that is nearest to a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Foot {
    /// The place.
    pub place: SurfacePlace,
    /// Outward unit normal there; zero where the face has none.
    pub normal: Vector3<f64>,
    /// Distance of the point from it, never negative \[m\].
    pub distance: f64,
}

/// The shape of a surface about a place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LocalShape {
    /// Principal curvatures, larger first, positive where the body is convex [1/m].
    pub curvatures: [f64; 2],
    /// Direction of the first, a unit vector; zero where there is none.
    pub direction: Vector3<f64>,
    /// Two directions along the surface, those of the parameters of a face, or of the principal
    /// curvatures; not of unit length.
    pub tangents: [Vector3<f64>; 2],
    /// Outward unit normal.
    pub normal: Vector3<f64>,
}

impl LocalShape {
    /// The same with the first direction that of `across`, where all are alike: of planes and spheres.
    pub fn turned(self, across: &Vector3<f64>) -> Self {
        let [first, second] = self.curvatures;
        let across = (across - across.dot(&self.normal) * self.normal).try_normalize(0.0);
        match across.filter(|_| (first - second).abs() <= 0.0) {
            Some(across) => {
                Self { direction: across, tangents: [across, self.normal.cross(&across)], ..self }
            }
            None => self,
        }
    }
}

/// Where `value` is least between `low` and `high`, by `steps` golden sections; it has one minimum there.
pub fn least_at([mut low, mut high]: [f64; 2], steps: usize, value: impl Fn(f64) -> f64) -> f64 {
    let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
    for _ in 0..steps {
        let (c, d) = (high - golden * (high - low), low + golden * (high - low));
        if value(c) <= value(d) { high = d } else { low = c }
    }
    0.5 * (low + high)
}

/// Shares of a straight line at which it is looked at.
pub const ALONG_LINE: [f64; 5] = [0.0, 0.25, 0.5, 0.75, 1.0];

/// A straight line that lies in a surface, from one end to the other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StraightLine {
    /// Its points at the shares [`ALONG_LINE`] \[m\].
    pub points: [Vector3<f64>; ALONG_LINE.len()],
    /// The place in its middle.
    pub middle: SurfacePlace,
}

impl StraightLine {
    /// From its first point to the last \[m\].
    pub fn way(&self) -> Vector3<f64> {
        self.points[ALONG_LINE.len() - 1] - self.points[0]
    }
}

/// The surface of an undeformed body.
pub trait Surface: Send + Sync {
    /// Rigid motions of the body.
    fn motion(&self) -> RigidMotion;

    /// Points whose hull holds the surface, or nearly so: control points, nodes \[m\].
    fn points(&self) -> Box<dyn Iterator<Item = &[f64; 3]> + '_>;

    /// Longest way through the body \[m\].
    fn length(&self) -> f64;

    /// Number of faces.
    fn n_faces(&self) -> usize;

    /// The place at the parameters `xi` of the face of number `face`.
    fn place(&self, face: u32, xi: &[f64; 3]) -> SurfacePlace;

    /// Whether two faces have the same two directions, so that widths along them mean the same.
    fn share_directions(&self, faces: [u32; 2]) -> bool;

    /// The surface for searches, without modes.
    ///
    /// # Errors
    /// [`ContactError`] without an outer face.
    fn search_model(&self) -> Result<SurfaceModel, ContactError>;

    /// The place nearest to `point`; none of a surface without faces, or of a point that is not
    /// finite.
    fn nearest(&self, point: &[f64; 3]) -> Option<Foot>;

    /// The first place to touch a plane whose normal, towards the body, is `direction`; none of a
    /// surface without faces.
    fn lowest(&self, direction: &Vector3<f64>) -> Option<SurfacePlace>;

    /// Outward unit normal at `place`; zero at a pole.
    fn normal(&self, place: &SurfacePlace) -> Vector3<f64>;

    /// Outward unit normals of the faces, or of the smooth parts, that meet at `point` of the
    /// surface; none at a pole.
    fn normals_at(&self, point: &[f64; 3]) -> Vec<Vector3<f64>>;

    /// The largest cosine of the angle between a direction and the one normal of a smooth surface
    /// at which they are no longer one direction: what the surface turns by between faces or sides
    /// that stand for a smooth part.
    fn smooth_cosine(&self) -> f64;

    /// Curvatures at `place`; none where the surface has none.
    fn shape_at(&self, place: &SurfacePlace) -> Option<LocalShape>;

    /// The simple shape of which faces about `place` are an approximation, and how far these reach from it \[m\]; none of
    /// exact faces, nor if the shape is none that is known.
    fn primitive_at(&self, _place: &SurfacePlace) -> Option<(Primitive, f64)> {
        None
    }

    /// The point of `place` as a place of the face, among those that meet there, whose normal is
    /// nearest to `direction`.
    fn turned_to(&self, place: &SurfacePlace, direction: &Vector3<f64>) -> SurfacePlace;

    /// Places all over the plane face through `point` that has the outward normal `outward`, but for the angle
    /// `parallel` \[rad\] (Eq. C.60), its rim among them; none without one \[m\].
    fn flat_face(&self, point: &[f64; 3], outward: &Vector3<f64>, parallel: f64) -> Vec<[f64; 3]>;

    /// Whether there is one.
    fn has_flat_face(&self, point: &[f64; 3], outward: &Vector3<f64>, parallel: f64) -> bool {
        !self.flat_face(point, outward, parallel).is_empty()
    }

    /// Straight lines of the surface through `point`, along which it may touch; none of a plane or
    /// axisymmetric body.
    fn lines_through(&self, point: &[f64; 3]) -> Vec<StraightLine>;

    /// How far from the place of `part`, in the plane of the touch, the faces go on that lie as near
    /// to this plane as the part, whatever its radius \[m\]; infinite of a surface that is not
    /// divided into small ones.
    fn spread(&self, _part: &TouchedPart) -> f64 {
        f64::INFINITY
    }

    /// Places of the edges through `point` at the distance `length` from it, on both sides; their
    /// ends where they end before.
    fn along_edges(&self, point: &[f64; 3], length: f64) -> Vec<Vector3<f64>>;
}

impl dyn Surface + '_ {
    /// Largest distance of its points from the origin of the body \[m\].
    pub fn reach(&self) -> f64 {
        self.points().map(|p| Vector3::from(*p).norm()).fold(0.0, f64::max)
    }

    /// Outward unit normals of the smooth parts that meet at `point`, each once: one of a smooth surface, two of an edge, three and
    /// more of a corner.
    pub fn parts_at(&self, point: &[f64; 3]) -> Vec<Vector3<f64>> {
        let mut different: Vec<Vector3<f64>> = Vec::new();
        for normal in self.normals_at(point) {
            if different.iter().all(|known| known.dot(&normal) < ALONG) {
                different.push(normal);
            }
        }
        different
    }

    /// Extent along the unit vector `direction` \[m\]; infinite of a surface without one.
    pub fn extent_along(&self, direction: &Vector3<f64>) -> f64 {
        let heights = self.points().map(|p| Vector3::from(*p).dot(direction));
        let (low, high) =
            heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), h| (f64::min(a, h), f64::max(b, h)));
        if high > low { high - low } else { f64::INFINITY }
    }
}

/// The undeformed surface of a body; none of one that has none to touch.
pub fn of_body(kind: &BodyKind) -> Option<Arc<dyn Surface>> {
    if let Some(meshed) = kind.meshed() {
        return Some(MeshSurface::of(&meshed.mesh));
    }
    kind.geometry().map(|of| SplineSurface::of(of.shape, of.model) as Arc<dyn Surface>)
}

/// Where that what the surface of a body is made from lies in memory, which bodies may share; none
/// of a body without a surface.
pub(crate) fn address(kind: &BodyKind) -> Option<usize> {
    if let Some(meshed) = kind.meshed() {
        return Some(Arc::as_ptr(&meshed.mesh).addr());
    }
    kind.geometry().map(|of| Arc::as_ptr(of.shape).addr())
}
