//! Quadrature on named faces.

use super::ExtentPoint;
use crate::SplineError;
use crate::elasticity::Model;
use crate::nurbs::Face;
use crate::nurbs::Shape;
use crate::nurbs::interface::FaceId;
use crate::nurbs::patch::PointBasis;
use crate::quadrature::GaussRule;
use crate::space::SplineSpace;

/// Gauss points of the elements of `space` on the face called `name`: `count` of an element per
/// direction, in `parts` parts.
///
/// # Errors
/// [`SplineError::UnknownFace`] with the names that there are.
pub fn points(
    shape: &Shape,
    space: &dyn SplineSpace,
    model: &Model,
    name: &str,
    count: impl Fn(usize) -> [usize; 3],
    parts: usize,
) -> Result<Vec<ExtentPoint>, SplineError> {
    let Some(ids) = shape.faces.get(name) else {
        let known = shape.faces.keys().cloned().collect();
        return Err(SplineError::UnknownFace { name: name.to_owned(), known });
    };
    let rules = GaussRule::all();
    let mut points = Vec::new();
    for e in 0..space.n_elements() {
        let element = space.element(e);
        for id in ids.iter().filter(|id| id.patch == element.patch) {
            let ends = if id.upper { element.upper } else { element.lower };
            let parameter = id.parameter(&shape.patches);
            let width = element.upper[id.direction] - element.lower[id.direction];
            if (ends[id.direction] - parameter).abs() > AT_END * width {
                continue;
            }
            let side = Side { shape, model, id: *id, element: e, bounds: [element.lower, element.upper] };
            side.add(&rules, count(e), parts, &mut points);
        }
    }
    Ok(points)
}

/// Part of an element within which its end counts as the end of the parameter range: round-off of
/// knots.
const AT_END: f64 = 1e-9;

/// The side of an element that lies on a face.
struct Side<'a> {
    shape: &'a Shape,
    model: &'a Model,
    id: FaceId,
    element: usize,
    bounds: [[f64; 3]; 2],
}

impl Side<'_> {
    fn add(&self, rules: &[GaussRule], counts: [usize; 3], parts: usize, out: &mut Vec<ExtentPoint>) {
        // Areas are those of the plane of the model; its measure makes them areas in space.
        let face = Face::new(&self.shape.patches, self.id, false);
        let patch = &self.shape.patches[self.id.patch];
        let along = |d: usize| -> Vec<(f64, f64)> {
            if d == self.id.direction || d >= patch.dimension() {
                return vec![(face.parameter, 1.0)];
            }
            let rule = &rules[counts[d] - 1];
            let (lower, size) = (self.bounds[0][d], (self.bounds[1][d] - self.bounds[0][d]) / parts as f64);
            let part = |i: usize| {
                let (start, mut points) = (lower + i as f64 * size, Vec::with_capacity(rule.len()));
                rule.points_on(start, start + size, &mut points);
                points.into_iter().zip(rule.weights.iter().map(|w| 0.5 * size * w)).collect::<Vec<_>>()
            };
            (0..parts).flat_map(part).collect()
        };
        let [first, second, third] = [along(0), along(1), along(2)];
        let mut scratch = PointBasis::default();
        for &(z, wz) in &third {
            for &(y, wy) in &second {
                for &(x, wx) in &first {
                    let at = face.at(patch, &[x, y, z], &mut scratch);
                    let weight = wx * wy * wz * at.area * self.model.measure(&at.point);
                    let xi = face.on_face(&[x, y, z]);
                    out.push(ExtentPoint { element: self.element, xi, point: at.point, weight });
                }
            }
        }
    }
}
