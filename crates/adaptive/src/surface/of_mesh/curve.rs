//! The curve that bounds a plane or axisymmetric mesh.

use fe_mesh::locate::SidePoint;
use ffr_dynamics::body::RigidMotion;
use nalgebra::{DMatrix, DVector, Vector3};

use super::{MeshSurface, SAME_POINT};
use crate::surface::{LocalShape, Surface, SurfacePlace};

/// Least number of nodes to which a parabola is fitted for the curvature; it has three unknowns.
const FITTED: usize = 5;

impl MeshSurface {
    /// [`Surface::shape_at`] of such a curve: the curvature of the parabola that fits the nodes around by
    /// least squares, in axisymmetric models with that of the parallel circle.
    pub(super) fn shape_of_curve(&self, place: &SurfacePlace, at: &SidePoint) -> Option<LocalShape> {
        let (is_axial, radius) = (self.motion() == RigidMotion::Axial, place.point[0]);
        let is_on_axis = is_axial && radius <= SAME_POINT * self.longest_edge(place.face as usize);
        let mut tangent = Vector3::from(at.tangents[0]).try_normalize(0.0)?;
        if is_on_axis {
            tangent = Vector3::new(1.0_f64.copysign(tangent[0]), 0.0, 0.0);
        }
        let normal = Vector3::new(tangent[1], -tangent[0], 0.0);
        let (centre, places) = (Vector3::from(place.point), self.around(place, FITTED));
        let size = places.iter().map(|x| (x - centre).norm()).fold(0.0, f64::max);
        let along: Vec<f64> = places.iter().map(|x| (x - centre).dot(&tangent) / size).collect();
        let matrix = DMatrix::from_fn(places.len(), 3, |i, j| [1.0, along[i], 0.5 * along[i] * along[i]][j]);
        let heights = DVector::from_fn(places.len(), |i, _| (places[i] - centre).dot(&normal) / size);
        let fit = matrix.svd(true, true).solve(&heights, 1e-10).ok()?;
        let bend = -fit[2] / size;
        let around = match (is_axial, is_on_axis) {
            (true, true) => bend,
            (true, false) => normal[0] / radius,
            (false, _) => 0.0,
        };
        let (curvatures, tangents) = ([bend.max(around), bend.min(around)], [tangent, Vector3::zeros()]);
        Some(LocalShape { curvatures, direction: tangent, tangents, normal })
    }
}
