//! Discs on the surface: a polar rule in the tangent plane, carried to the surface along the normal.
//!
//! With the normals `n` of the surface and `n₀` at the centre, an area `dA₀` of the plane is `dA = dA₀ / (n · n₀)` of the
//! surface. In two dimensions the disc is a line through the centre, from the axis outwards if the centre lies on it.

use super::{Around, ExtentPoint, composite, directions};
use crate::SplineError;
use crate::elasticity::Model;
use crate::nurbs::box_newton::{Sample, minimize};
use crate::nurbs::jet::{cross, difference, dot, norm};
use crate::nurbs::patch::PointBasis;
use crate::surface::{BodySurface, Face, FacePoint};

/// Parts of the radius beyond which a disc is not divided further: 64 × 256 points.
const MOST_PARTS: usize = 16;
/// Steepest part of the surface that a disc covers: cosine of the angle between the normals, some 78°.
const STEEPEST: f64 = 0.2;
/// Share of the way to the middle of a face by which the centre is moved where the surface has no normal.
const ASIDE: f64 = 1e-4;
/// Part of the radius within which a centre counts as lying on the axis.
const ON_AXIS: f64 = 1e-9;

/// Points of the disc about the surface point `centre`.
///
/// # Errors
/// [`SplineError::ExtentBeyondBody`] if the disc reaches beyond an edge of the surface or around the body.
pub fn points(
    body: &Around<'_>,
    surface: &BodySurface,
    centre: &FacePoint,
) -> Result<Vec<ExtentPoint>, SplineError> {
    let disc = Disc::new(body, surface, centre)?;
    let coarse = disc.points(super::LEAST_PARTS)?;
    let parts = body.parts(body.smallest_element(&coarse), MOST_PARTS);
    let points = if parts == super::LEAST_PARTS { coarse } else { disc.points(parts)? };
    Ok(points.into_iter().map(|(p, _)| p).collect())
}

struct Disc<'a> {
    body: &'a Around<'a>,
    surface: &'a BodySurface,
    centre: FacePoint,
    normal: [f64; 3],
    /// Unit vectors across the normal; the second one is zero in two dimensions.
    across: [[f64; 3]; 2],
}

impl<'a> Disc<'a> {
    fn new(body: &'a Around<'a>, surface: &'a BodySurface, centre: &FacePoint) -> Result<Self, SplineError> {
        let face = surface.faces()[centre.face];
        let normal = normal_near(body, &face, &centre.xi).ok_or_else(|| body.leaves("disc"))?;
        let first = if body.space.dimension() == 2 {
            [normal[1], -normal[0], 0.0]
        } else {
            let least = (0..3).min_by(|&i, &j| normal[i].abs().total_cmp(&normal[j].abs())).unwrap_or(0);
            let mut axis = [0.0; 3];
            axis[least] = 1.0;
            unit(&cross(&normal, &axis))
        };
        let second = if body.space.dimension() == 2 { [0.0; 3] } else { cross(&normal, &first) };
        Ok(Self { body, surface, centre: *centre, normal, across: [first, second] })
    }

    /// Points on the surface with the directions that are fixed on their faces.
    fn points(&self, parts: usize) -> Result<Vec<(ExtentPoint, Option<usize>)>, SplineError> {
        let mut found = Vec::new();
        let mut start = (self.centre.face, self.centre.xi);
        for ([a, b], weight) in self.plane(parts) {
            let target =
                [0, 1, 2].map(|c| self.centre.point[c] + a * self.across[0][c] + b * self.across[1][c]);
            let (face, xi, cosine) = self.carried(&target, start).ok_or_else(|| self.body.leaves("disc"))?;
            let id = self.surface.faces()[face].id;
            found.push((self.body.at(id.patch, xi, weight / cosine), Some(id.direction)));
            start = (face, xi);
        }
        Ok(found)
    }

    /// Points of the tangent plane with their measures.
    fn plane(&self, parts: usize) -> Vec<([f64; 2], f64)> {
        let radius = self.body.radius;
        if self.body.space.dimension() == 2 {
            let is_on_axis =
                *self.body.model == Model::Axisymmetric && self.centre.point[0] <= ON_AXIS * radius;
            let outwards = if self.across[0][0] < 0.0 { -1.0 } else { 1.0 };
            let line = if is_on_axis {
                composite(0.0, radius, parts).into_iter().map(|(s, w)| (outwards * s, w)).collect()
            } else {
                composite(-radius, radius, 2 * parts)
            };
            return line.into_iter().map(|(s, w)| ([s, 0.0], w)).collect();
        }
        let n = 16 * parts;
        let share = std::f64::consts::TAU / n as f64;
        let mut points = Vec::new();
        for (rho, w) in composite(0.0, radius, parts) {
            points.extend(directions(n).map(|(cos, sin)| ([rho * cos, rho * sin], rho * w * share)));
        }
        points
    }

    /// Face and parameters of the surface point on the line along the normal through `target`, with the cosine of the angle
    /// between the normals; first from where the last point was, then from the places nearest to the target.
    fn carried(&self, target: &[f64; 3], start: (usize, [f64; 3])) -> Option<(usize, [f64; 3], f64)> {
        let patches = &self.body.shape.patches;
        if let Some((xi, cosine)) = self.on_face(start.0, &start.1, target) {
            return Some((start.0, xi, cosine));
        }
        let nearest = self.surface.closest(patches, target)?;
        if let Some((xi, cosine)) = self.on_face(nearest.face, &nearest.xi, target) {
            return Some((nearest.face, xi, cosine));
        }
        let height = |xi: &[f64; 3], face: usize| {
            let patch = &patches[self.surface.faces()[face].id.patch];
            dot(&difference(&patch.point(xi), target), &self.normal).abs()
        };
        let on = |face: usize| {
            let (lower, upper) = patches[self.surface.faces()[face].id.patch].domain();
            let middle = [0, 1, 2].map(|d| 0.5 * (lower[d] + upper[d]));
            let near = self.surface.closest_from(patches, face, target, &middle);
            self.on_face(face, &near.xi, target).map(|(xi, cosine)| (face, xi, cosine))
        };
        let all = (0..self.surface.faces().len()).filter_map(on);
        all.min_by(|a, b| height(&a.1, a.0).total_cmp(&height(&b.1, b.0)))
    }

    fn on_face(&self, face: usize, start: &[f64; 3], target: &[f64; 3]) -> Option<([f64; 3], f64)> {
        let face = self.surface.faces()[face];
        let patch = &self.body.shape.patches[face.id.patch];
        let (mut lower, mut upper) = patch.domain();
        (lower[face.id.direction], upper[face.id.direction]) = (face.parameter, face.parameter);
        let across = |v: &[f64; 3]| {
            let along = dot(v, &self.normal);
            [0, 1, 2].map(|c| v[c] - along * self.normal[c])
        };
        let mut scratch = PointBasis::default();
        let objective = |xi: &[f64; 3]| {
            let jet = patch.jet(xi, 2, &mut scratch);
            let d = across(&difference(&jet.point, target));
            let distance = norm(&d);
            let rounding = 4.0 * f64::EPSILON * (norm(&jet.point) + norm(target));
            let mut sample = Sample {
                value: 0.5 * distance * distance,
                noise: rounding * (distance + rounding),
                ..Sample::default()
            };
            for a in 0..3 {
                sample.gradient[a] = dot(&d, &jet.first[a]);
                for b in 0..3 {
                    sample.hessian[a][b] =
                        dot(&across(&jet.first[a]), &jet.first[b]) + dot(&d, &jet.second(a, b));
                }
            }
            sample
        };
        let (xi, value) = minimize(objective, &face.on_face(start), &lower, &upper);
        let at = face.at(patch, &xi, &mut PointBasis::default());
        let cosine = dot(&at.normal, &self.normal);
        let is_there = (2.0 * value).sqrt() <= self.body.slack() && cosine >= STEEPEST;
        is_there.then_some((xi, cosine))
    }
}

/// The outward normal at `xi` of `face`, or beside it where the parametrisation is singular.
fn normal_near(body: &Around<'_>, face: &Face, xi: &[f64; 3]) -> Option<[f64; 3]> {
    let patch = &body.shape.patches[face.id.patch];
    let (lower, upper) = patch.domain();
    let aside = [0, 1, 2].map(|d| xi[d] + ASIDE * (0.5 * (lower[d] + upper[d]) - xi[d]));
    let normal = |xi: &[f64; 3]| face.at(patch, xi, &mut PointBasis::default()).normal;
    [normal(xi), normal(&aside)].into_iter().find(|n| norm(n) > 0.5)
}

fn unit(v: &[f64; 3]) -> [f64; 3] {
    let length = norm(v);
    v.map(|c| c / length)
}
