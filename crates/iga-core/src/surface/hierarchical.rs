//! Greville points of the functions of a hierarchical space on faces (theory Eq. S.12, section H.3).

use super::collocation::{Candidate, CollocationPoint, collocate};
use super::face::Face;
use crate::hierarchical::HierarchicalSpace;
use crate::nurbs::Patch;

/// Greville points of the functions of a hierarchical space on the faces of its patch, with their tributary areas.
///
/// The point of a function is the Greville point of the B-spline of its level that it was truncated from; its area is that
/// of the truncated function. Inside a region of one level, at least the degree away from its border, these are the points
/// of a plain patch with the knots of that level. Tied functions as in [`super::greville_points`].
pub fn hierarchical_greville_points(
    space: &HierarchicalSpace,
    patch: &Patch,
    faces: &[Face],
) -> Vec<CollocationPoint> {
    let basis = space.basis();
    let mut candidates = Vec::new();
    let mut first = 0;
    for (l, level) in basis.hierarchy().levels().iter().enumerate() {
        let sizes = level.net_size();
        let abscissae: Vec<Vec<f64>> = level.knots().iter().map(|k| k.greville()).collect();
        let active = basis.active_on_level(l);
        for (number, &flat) in active.iter().enumerate() {
            let index = crate::tensor::unflat(&sizes, flat);
            for (f, face) in faces.iter().enumerate() {
                let d = face.id.direction;
                if index[d] != if face.id.upper { sizes[d] - 1 } else { 0 } {
                    continue;
                }
                let mut xi = [0.0; 3];
                for (u, values) in
                    xi.iter_mut().zip(&abscissae).enumerate().map(|(d, (u, v))| (u, v[index[d]]))
                {
                    *u = values;
                }
                let function = space.function_of((first + number) as u32);
                candidates.push(Candidate { face: f, function, xi: face.on_face(&xi) });
            }
        }
        first += active.len();
    }
    collocate(space, std::slice::from_ref(patch), faces, &candidates)
}
