//! One outer face of a body and its differential geometry.

use std::f64::consts::TAU;

use crate::nurbs::Patch;
use crate::nurbs::interface::{COINCIDENT, FaceId, FaceNet, coinciding_pairs};
use crate::nurbs::jet::{Jet, cross, diagonal, dot, norm};
use crate::nurbs::patch::PointBasis;

/// A face of a patch, seen as a piece of the body's surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Face {
    /// Which face of which patch.
    pub id: FaceId,
    /// Value of the fixed parameter.
    pub parameter: f64,
    /// Number of parametric directions of the patch.
    pub dimension: usize,
    /// Whether the model is axisymmetric: areas carry `2 pi r`.
    pub axisymmetric: bool,
}

/// Geometry of the surface at a point.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SurfacePoint {
    /// Position \[m\].
    pub point: [f64; 3],
    /// Derivatives of the position along the face's directions, rising; the second one is zero in
    /// two dimensions.
    pub tangents: [[f64; 3]; 2],
    /// Outward unit normal; zero where the face is singular (a pole), so that no direction can be
    /// given.
    pub normal: [f64; 3],
    /// Area (in plane models length) a unit of the face's parameters; axisymmetric faces carry
    /// `2 pi r`.
    pub area: f64,
}

impl Face {
    /// Face `id` of a body.
    pub fn new(patches: &[Patch], id: FaceId, axisymmetric: bool) -> Self {
        let dimension = patches[id.patch].dimension();
        Self { id, parameter: id.parameter(patches), dimension, axisymmetric }
    }

    /// The faces that bound the body outwards: not collapsed to a line or point, not on the axis
    /// `r = 0` of an axisymmetric model, not shared with another patch and not tied to another face
    /// of the same patch (a seam).
    pub fn outer(patches: &[Patch], axisymmetric: bool) -> Vec<Self> {
        let ids = FaceId::all(patches);
        let nets: Vec<_> = ids.iter().map(|&id| FaceNet::new(patches, id)).collect();
        let mut is_shared = vec![false; ids.len()];
        for (a, b, _) in coinciding_pairs(&nets, COINCIDENT) {
            (is_shared[a], is_shared[b]) = (true, true);
        }
        let mut faces = Vec::new();
        for (i, &id) in ids.iter().enumerate() {
            let face = Self::new(patches, id, axisymmetric);
            let limit = COINCIDENT * nets[i].extent();
            let on_axis = axisymmetric && nets[i].points().iter().all(|p| p[0].abs() <= limit);
            if !is_shared[i] && !on_axis && !face.is_collapsed(&patches[id.patch]) {
                faces.push(face);
            }
        }
        faces
    }

    /// Directions that run along the face.
    pub fn directions(&self) -> impl Iterator<Item = usize> + use<> {
        self.id.tangents(self.dimension)
    }

    /// Degrees of `patch`, which it belongs to, along the face; zero in the direction that a curve
    /// does not have.
    pub fn degrees(&self, patch: &Patch) -> [usize; 2] {
        let mut degrees = [0; 2];
        for (degree, d) in degrees.iter_mut().zip(self.directions()) {
            *degree = patch.knots()[d].degree();
        }
        degrees
    }

    /// Sign that turns the product of the tangents (of a curve: the tangent times the normal of its
    /// plane) outwards, for a patch with `det J > 0`.
    pub fn orientation(&self) -> f64 {
        let outwards = if self.id.upper { 1.0 } else { -1.0 };
        let is_swapped = match self.dimension {
            2 => self.id.direction != 0,
            _ => self.id.direction == 1,
        };
        if is_swapped { -outwards } else { outwards }
    }

    /// Whether the surface Jacobian vanishes all over the face.
    pub fn is_collapsed(&self, patch: &Patch) -> bool {
        const SHARES: [f64; 3] = [0.21, 0.47, 0.83];
        let plane = Self { axisymmetric: false, ..*self };
        let (lower, upper) = patch.domain();
        let mut scratch = PointBasis::default();
        (0..9).all(|sample| {
            let mut xi = lower;
            for (d, s) in self.directions().zip([SHARES[sample % 3], SHARES[sample / 3]]) {
                xi[d] = lower[d] + s * (upper[d] - lower[d]);
            }
            let extent: f64 = self.directions().map(|d| upper[d] - lower[d]).product();
            let size = diagonal(patch.control_points());
            let limit = COINCIDENT * size.powi(self.directions().count() as i32);
            plane.at(patch, &xi, &mut scratch).area * extent <= limit
        })
    }

    /// The parametric point of the face next to `xi`: its fixed parameter replaced by the face's.
    pub fn on_face(&self, xi: &[f64; 3]) -> [f64; 3] {
        let mut xi = *xi;
        xi[self.id.direction] = self.parameter;
        xi
    }

    /// Geometry at parameters `xi` of `patch`; the fixed parameter is taken from the face.
    pub fn at(&self, patch: &Patch, xi: &[f64; 3], scratch: &mut PointBasis) -> SurfacePoint {
        self.geometry(&patch.jet(&self.on_face(xi), 1, scratch))
    }

    /// Geometry from position and first derivatives, of the undeformed or of a deformed body
    /// (theory Eq. S.17).
    pub fn geometry(&self, jet: &Jet) -> SurfacePoint {
        let mut tangents = [[0.0; 3]; 2];
        for (t, d) in tangents.iter_mut().zip(self.directions()) {
            *t = jet.first[d];
        }
        let sign = if self.id.upper { 1.0 } else { -1.0 };
        // Increasing the fixed parameter leads along this vector if det J > 0.
        let (across, largest) = match (self.dimension, self.id.direction) {
            (1, _) => (jet.first[0], norm(&jet.first[0])),
            (2, 0) => ([tangents[0][1], -tangents[0][0], 0.0], norm(&tangents[0])),
            (2, _) => ([-tangents[0][1], tangents[0][0], 0.0], norm(&tangents[0])),
            (_, 1) => (cross(&tangents[1], &tangents[0]), norm(&tangents[0]) * norm(&tangents[1])),
            _ => (cross(&tangents[0], &tangents[1]), norm(&tangents[0]) * norm(&tangents[1])),
        };
        let length = norm(&across);
        // Parallel tangents: what is left is the round-off of their product.
        let regular = length > 1e-12 * largest && length > 0.0;
        let normal = if regular { across.map(|c| sign * c / length) } else { [0.0; 3] };
        let element = if self.dimension == 1 { 1.0 } else { length };
        let area = if self.axisymmetric { TAU * jet.point[0].abs() * element } else { element };
        SurfacePoint { point: jet.point, tangents, normal, area: if regular { area } else { 0.0 } }
    }

    /// Principal curvatures [1/m], larger first, positive where the body is convex (`1/R` on a
    /// sphere); zero for the direction across a plane model. Axisymmetric: meridian and
    /// circumference (theory Eq. S.18). `None` where the face is singular. `jet` needs second
    /// derivatives.
    pub fn curvatures(&self, jet: &Jet) -> Option<[f64; 2]> {
        let at = self.geometry(jet);
        if norm(&at.normal) < 0.5 {
            return None;
        }
        let mut directions = self.directions();
        let (Some(a), b) = (directions.next(), directions.next()) else { return Some([0.0; 2]) };
        let bend = |a: usize, b: usize| -dot(&jet.second(a, b), &at.normal);
        let [t, s] = &at.tangents;
        let Some(b) = b else {
            let meridian = bend(a, a) / dot(t, t);
            // On the axis both curvatures agree; r = 0 up to round-off of the tangent's length.
            let on_axis = jet.point[0].abs() < 1e-9 * norm(t);
            let around = match (self.axisymmetric, on_axis) {
                (true, true) => meridian,
                (true, false) => at.normal[0] / jet.point[0],
                (false, _) => 0.0,
            };
            return Some([meridian.max(around), meridian.min(around)]);
        };
        let (e, f, g) = (dot(t, t), dot(t, s), dot(s, s));
        let (l, m, n) = (bend(a, a), bend(a, b), bend(b, b));
        let determinant = e * g - f * f;
        let mean = 0.5 * (l * g - 2.0 * m * f + n * e) / determinant;
        let gauss = (l * n - m * m) / determinant;
        let spread = (mean * mean - gauss).max(0.0).sqrt();
        Some([mean + spread, mean - spread])
    }

    /// Unit tangent along which the face of a solid bends by the larger one of
    /// [`Face::curvatures`], `κ₁`: `(II - κ₁ I) v = 0` with the fundamental forms `I` and `II` in
    /// the parameters. Along a curve the curve's tangent; any direction where both curvatures are
    /// equal. `None` where the face is singular. `jet` needs second derivatives.
    pub fn first_direction(&self, jet: &Jet) -> Option<[f64; 3]> {
        let [largest, _] = self.curvatures(jet)?;
        let at = self.geometry(jet);
        let mut directions = self.directions();
        let [t, s] = &at.tangents;
        let unit = |v: [f64; 3]| {
            let length = norm(&v);
            (length > 0.0).then(|| v.map(|x| x / length))
        };
        let (Some(a), Some(b)) = (directions.next(), directions.next()) else { return unit(*t) };
        let bend = |a: usize, b: usize| -dot(&jet.second(a, b), &at.normal);
        let along = [bend(a, a) - largest * dot(t, t), bend(a, b) - largest * dot(t, s)];
        let across = [along[1], bend(b, b) - largest * dot(s, s)];
        // Either row tells the direction, the longer one with more digits.
        let row = if along[0].hypot(along[1]) >= across[0].hypot(across[1]) { along } else { across };
        unit(std::array::from_fn(|c| row[1] * t[c] - row[0] * s[c])).or_else(|| unit(*t))
    }
}
