//! Curvature and mode shapes of a surface at a place that a search has found.

use ffr_dynamics::body::RigidMotion;
use nalgebra::{Matrix3, Vector3};

use super::bezier::{PieceJet, jet};
use super::deformed::Site;
use super::surface_model::{Piece, SurfaceModel};
use iga_core::splines::bernstein::table;

/// Sine of the angle between the tangents, and ratio of their lengths to those in the middle of the
/// piece, below which the net is singular.
const SINGULAR: f64 = 1e-4;
/// Share of the way to the middle of the piece at which curvatures are taken, once, twice and three
/// times, where the net is singular: they are extrapolated from there.
const ASIDE: f64 = 0.05;
/// Step of differences of the curvature over the parameters of a piece, which turns by less than 30
/// degrees.
const STEP: f64 = 1e-3;

/// The undeformed surface about a place, in the body's frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LocalShape {
    /// Outward unit normal.
    pub normal: Vector3<f64>,
    /// Curvature: a step `u` along the surface turns the normal by `S u`, so that convex surfaces
    /// have positive eigenvalues [1/m].
    pub bending: Matrix3<f64>,
}

impl SurfaceModel {
    /// Normal and curvature at `place`; `None` where the surface has none.
    pub fn local_shape(&self, place: &Site) -> Option<LocalShape> {
        let piece = self.pieces().get(place.piece as usize)?;
        if let Some(shape) = self.regular_shape(piece, place.s) {
            return Some(shape);
        }
        let beside = |share: f64| self.regular_shape(piece, place.s.map(|s| s + share * (0.5 - s)));
        let [a, b, c] = [beside(ASIDE)?, beside(2.0 * ASIDE)?, beside(3.0 * ASIDE)?];
        let normal = (a.normal * 3.0 - b.normal * 3.0 + c.normal).try_normalize(0.0)?;
        Some(LocalShape { normal, bending: a.bending * 3.0 - b.bending * 3.0 + c.bending })
    }

    /// The vector `c` of the tangent plane with `c · u = W : ∂S/∂u`, the change of the curvature
    /// under the weights `weights` over a step `u` along the surface; zero where the net is
    /// singular.
    pub fn bending_slope(&self, place: &Site, weights: &Matrix3<f64>) -> Vector3<f64> {
        let Some(piece) = self.pieces().get(place.piece as usize) else { return Vector3::zeros() };
        let here = self.undeformed(piece, place.s);
        let Some((tangents, _)) = self.regular_tangents(piece, &here) else { return Vector3::zeros() };
        let duals = duals(&tangents);
        let mut sum = Vector3::zeros();
        for (d, dual) in duals.iter().enumerate().filter(|(d, _)| piece.degrees[*d] > 0) {
            let at = |s: f64| {
                let mut moved = place.s;
                moved[d] = s.clamp(0.0, 1.0);
                Some((moved[d], self.regular_shape(piece, moved)?.bending.component_mul(weights).sum()))
            };
            if let (Some(low), Some(high)) = (at(place.s[d] - STEP), at(place.s[d] + STEP)) {
                sum += dual * ((high.1 - low.1) / (high.0 - low.0));
            }
        }
        sum
    }

    /// Replaces `out` by the displacements at `place` under a unit of each mode, in the body's
    /// frame.
    pub fn shapes_at(&self, place: &Site, out: &mut [Vector3<f64>]) {
        let Some(piece) = self.pieces().get(place.piece as usize) else { return };
        let [a, b] = [table(piece.degrees[0], place.s[0]), table(piece.degrees[1], place.s[1])];
        let n = piece.degrees[0] + 1;
        let weight = |k: usize| a[0][k % n] * b[0][k / n];
        let total: f64 = self.net(piece).iter().enumerate().map(|(k, h)| weight(k) * h[3]).sum();
        for (out, shape) in out.iter_mut().zip(self.weighted_shapes(piece)) {
            let sum = shape.iter().enumerate();
            *out = sum.fold(Vector3::zeros(), |sum, (k, u)| sum + Vector3::from(*u) * weight(k)) / total;
        }
    }

    fn undeformed(&self, piece: &Piece, s: [f64; 2]) -> PieceJet {
        jet(piece.degrees, self.net(piece), s)
    }

    fn regular_shape(&self, piece: &Piece, s: [f64; 2]) -> Option<LocalShape> {
        let here = self.undeformed(piece, s);
        let (tangents, normal) = self.regular_tangents(piece, &here)?;
        let bent = |k: usize| normal.dot(&here.second[k]);
        let [first, second] = duals(&tangents);
        let along = first * first.transpose() * bent(0);
        let bending = match self.motion() {
            RigidMotion::Spatial => {
                let mixed = first * second.transpose();
                along + (mixed + mixed.transpose()) * bent(1) + second * second.transpose() * bent(2)
            }
            RigidMotion::Planar => along,
            // The parallel circle; on the axis both curvatures are one.
            RigidMotion::Axial => {
                let meridian = bent(0) / tangents[0].norm_squared();
                let radius = here.point.x;
                let parallel = if radius > STEP * self.size() { -normal.x / radius } else { meridian };
                along + Vector3::y() * Vector3::y().transpose() * parallel
            }
        };
        Some(LocalShape { normal, bending: -bending })
    }

    /// Tangents, that of a curve with a unit vector across, and the outward normal; `None` where
    /// the net is singular.
    fn regular_tangents(&self, piece: &Piece, here: &PieceJet) -> Option<([Vector3<f64>; 2], Vector3<f64>)> {
        let of = |jet: &PieceJet| [jet.first[0], self.across().unwrap_or(jet.first[1])];
        let (tangents, usual) = (of(here), of(&self.undeformed(piece, [0.5; 2])));
        let lengths = tangents.map(|t| t.norm());
        let product = tangents[0].cross(&tangents[1]);
        let is_long = lengths.iter().zip(&usual).all(|(length, usual)| *length > SINGULAR * usual.norm());
        let is_regular = is_long && product.norm() > SINGULAR * lengths[0] * lengths[1];
        is_regular.then(|| (tangents, product * (piece.orientation / product.norm())))
    }
}

/// The vectors of the plane of two others with `dual_i · t_j = δ_ij`.
fn duals([a, b]: &[Vector3<f64>; 2]) -> [Vector3<f64>; 2] {
    let (aa, ab, bb) = (a.norm_squared(), a.dot(b), b.norm_squared());
    let determinant = aa * bb - ab * ab;
    [(a * bb - b * ab) / determinant, (b * aa - a * ab) / determinant]
}

#[cfg(test)]
mod tests {
    use super::*;
    use iga_core::nurbs::primitives::sphere::ellipsoid;

    #[test]
    fn curvatures_of_an_ellipsoid_are_those_of_its_equation() {
        let axes = [2.0, 1.5, 1.0];
        let shape = ellipsoid(axes).unwrap();
        let model = SurfaceModel::rigid(RigidMotion::Spatial, &shape.patches).unwrap();
        let inverse = Matrix3::from_diagonal(&Vector3::from(axes.map(|a: f64| 1.0 / (a * a))));
        let mut compared = 0;
        for piece in 0..model.n_pieces() as u32 {
            for s in [[0.5, 0.5], [0.1, 0.8], [0.0, 0.3], [1.0, 1.0]] {
                let place = Site { piece, s };
                let found = model.local_shape(&place).unwrap();
                let point = model.undeformed(&model.pieces()[piece as usize], s).point;
                let gradient = inverse * point * 2.0;
                let normal = gradient.normalize();
                let project = Matrix3::identity() - normal * normal.transpose();
                let expected = project * inverse * 2.0 * project / gradient.norm();
                // Round-off over the regularity of the net, or extrapolation over a twentieth of a
                // piece.
                let is_regular = model.regular_shape(&model.pieces()[piece as usize], s).is_some();
                let limit = if is_regular { 1e-6 } else { 2e-2 };
                let error = (found.bending - expected).norm() / expected.norm();
                assert!(error < limit, "{piece} {s:?}: {error:e}, regular: {is_regular}");
                assert!((found.normal - normal).norm() < limit);
                compared += 1;
            }
        }
        assert_eq!(compared, 4 * model.n_pieces());
    }

    #[test]
    fn slopes_of_the_curvature_are_those_of_its_equation() {
        let axes = [2.0, 1.5, 1.0];
        let shape = ellipsoid(axes).unwrap();
        let model = SurfaceModel::rigid(RigidMotion::Spatial, &shape.patches).unwrap();
        let inverse = Matrix3::from_diagonal(&Vector3::from(axes.map(|a: f64| 1.0 / (a * a))));
        // Of the level surface through any point.
        let bending = |x: &Vector3<f64>| {
            let gradient = inverse * x * 2.0;
            let n = gradient.normalize();
            let project = Matrix3::identity() - n * n.transpose();
            project * inverse * 2.0 * project / gradient.norm()
        };
        let place = Site { piece: 3, s: [0.4, 0.6] };
        let jet = model.undeformed(&model.pieces()[3], place.s);
        let weights = Matrix3::new(0.7, 0.2, -0.1, 0.2, 0.4, 0.3, -0.1, 0.3, 0.9);
        let shape = model.local_shape(&place).unwrap();
        let project = Matrix3::identity() - shape.normal * shape.normal.transpose();
        let weights = project * weights * project;
        let slope = model.bending_slope(&place, &weights);
        for tangent in jet.first {
            let step = 1e-5;
            let at = |h: f64| bending(&(jet.point + tangent * h)).component_mul(&weights).sum();
            let expected = (at(step) - at(-step)) / (2.0 * step);
            // Central differences of both: the square of a thousandth.
            assert!(
                (slope.dot(&tangent) - expected).abs() < 1e-5 * weights.norm() * tangent.norm(),
                "{expected}"
            );
        }
    }
}
