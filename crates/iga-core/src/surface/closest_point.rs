//! Closest and lowest points of a body's surface.

use crate::nurbs::Patch;
use crate::nurbs::face::Face;
use crate::nurbs::locate::{Located, PatchSearch};
use crate::nurbs::patch::PointBasis;

/// A point found on a face.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FacePoint {
    /// Index into [`BodySurface::faces`].
    pub face: usize,
    /// Parameters in the face's patch.
    pub xi: [f64; 3],
    /// Position \[m\].
    pub point: [f64; 3],
    /// Outward unit normal; zero at a pole of the parametrisation.
    pub normal: [f64; 3],
    /// Distance from the target, or height along the direction \[m\].
    pub measure: f64,
}

/// Outer faces of a body, prepared for searching.
#[derive(Debug, Clone, PartialEq)]
pub struct BodySurface {
    faces: Vec<Face>,
    searches: Vec<PatchSearch>,
}

impl BodySurface {
    /// Prepares all outer faces of a body.
    pub fn new(patches: &[Patch], axisymmetric: bool) -> Self {
        Self::of_faces(patches, Face::outer(patches, axisymmetric))
    }

    /// Prepares the given faces.
    pub fn of_faces(patches: &[Patch], faces: Vec<Face>) -> Self {
        let searches =
            faces.iter().map(|f| PatchSearch::new(&patches[f.id.patch], f.id.fixed(patches))).collect();
        Self { faces, searches }
    }

    /// The faces.
    pub fn faces(&self) -> &[Face] {
        &self.faces
    }

    /// Closest point of the surface to `target`; `measure` is the distance \[m\], never negative:
    /// the side follows from the normal. `None` only for a surface without faces or a target that
    /// is not finite.
    pub fn closest(&self, patches: &[Patch], target: &[f64; 3]) -> Option<FacePoint> {
        let bound = |search: &PatchSearch| search.distance_bound(target);
        self.best(patches, bound, |search, patch, below| search.closest_below(patch, target, below))
    }

    /// The surface point with the smallest `n · x`, the first to touch a plane with normal `n`
    /// below the body.
    pub fn lowest(&self, patches: &[Patch], direction: &[f64; 3]) -> Option<FacePoint> {
        let bound = |search: &PatchSearch| search.height_bound(direction);
        self.best(patches, bound, |search, patch, below| search.lowest_below(patch, direction, below))
    }

    /// Closest point on one face from known parameters, such as the last time step's.
    pub fn closest_from(
        &self,
        patches: &[Patch],
        face: usize,
        target: &[f64; 3],
        xi: &[f64; 3],
    ) -> FacePoint {
        let patch = &patches[self.faces[face].id.patch];
        self.complete(patches, face, &self.searches[face].closest_from(patch, target, xi))
    }

    /// Visits the faces in the order of their bounds; each one only has to beat the best so far.
    fn best(
        &self,
        patches: &[Patch],
        bound: impl Fn(&PatchSearch) -> f64,
        find: impl Fn(&PatchSearch, &Patch, f64) -> Option<Located>,
    ) -> Option<FacePoint> {
        let mut order: Vec<(f64, usize)> =
            self.searches.iter().enumerate().map(|(i, s)| (bound(s), i)).collect();
        order.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (mut best, mut measure) = (None, f64::INFINITY);
        for (_, face) in order.into_iter().filter(|(bound, _)| bound.is_finite()) {
            let patch = &patches[self.faces[face].id.patch];
            if let Some(found) = find(&self.searches[face], patch, measure) {
                measure = found.measure;
                best = Some((face, found));
            }
        }
        best.map(|(face, found)| self.complete(patches, face, &found))
    }

    fn complete(&self, patches: &[Patch], face: usize, found: &Located) -> FacePoint {
        let of = &self.faces[face];
        let at = of.at(&patches[of.id.patch], &found.xi, &mut PointBasis::default());
        FacePoint { face, xi: found.xi, point: found.point, normal: at.normal, measure: found.measure }
    }
}
