//! What discs and balls ask of a body of splines: its surface along lines, and points inside.

use super::around::{Found, Nearest, Surroundings};
use crate::SplineError;
use crate::elasticity::Model;
use crate::nurbs::Face;
use crate::nurbs::jet::{diagonal, difference, dot, norm};
use crate::nurbs::locate::box_newton::{Sample, minimize};
use crate::nurbs::patch::PointBasis;
use crate::nurbs::{PatchSearch, Shape};
use crate::space::SplineSpace;
use crate::surface::BodySurface;

/// Steepest part of the surface that a disc covers: cosine of the angle between the normals, some
/// 78°.
const STEEPEST: f64 = 0.2;
/// Share of the way to the middle of a face by which the centre is moved where the surface has no
/// normal.
const ASIDE: f64 = 1e-4;

/// A body of splines about a disc or ball.
pub struct Splines<'a> {
    shape: &'a Shape,
    space: &'a dyn SplineSpace,
    model: &'a Model,
    surface: BodySurface,
    searches: Vec<PatchSearch>,
    /// Distance that counts as none: round-off of a search \[m\].
    slack: f64,
}

/// A place in a patch, or on a face of the surface.
#[derive(Debug, Clone, Copy)]
pub struct Start {
    /// Number of the patch, or of the face.
    of: usize,
    xi: [f64; 3],
}

impl<'a> Splines<'a> {
    /// The body `shape` with the functions of `space`, for an extent of the radius `radius`.
    pub fn new(shape: &'a Shape, space: &'a dyn SplineSpace, model: &'a Model, radius: f64) -> Self {
        let size = shape.patches.iter().map(|p| diagonal(p.control_points())).fold(0.0, f64::max);
        Self {
            shape,
            space,
            model,
            surface: BodySurface::new(&shape.patches, *model == Model::Axisymmetric),
            searches: shape.patches.iter().map(|p| PatchSearch::new(p, [None; 3])).collect(),
            slack: 1e-9 * radius + 1e-12 * size,
        }
    }

    /// The place `xi` of `patch`, `fixed` the direction that leads out of the extent.
    fn found(&self, patch: usize, xi: [f64; 3], fixed: Option<usize>, start: Start) -> Found<Start> {
        let element = self.space.find_element(patch, &xi);
        let jet = self.shape.patches[patch].jet(&xi, 1, &mut PointBasis::default());
        let of = self.space.element(element);
        let side = |d: usize| {
            let is_along = d < self.space.dimension() && Some(d) != fixed;
            if is_along { norm(&jet.first[d]) * (of.upper[d] - of.lower[d]) } else { 0.0 }
        };
        Found { element, xi, point: jet.point, sides: std::array::from_fn(side), start }
    }

    fn on_face(&self, start: &Start, target: &[f64; 3], normal: &[f64; 3]) -> Option<(usize, [f64; 3], f64)> {
        let face = self.surface.faces()[start.of];
        let patch = &self.shape.patches[face.id.patch];
        let (mut lower, mut upper) = patch.domain();
        (lower[face.id.direction], upper[face.id.direction]) = (face.parameter, face.parameter);
        let across = |v: &[f64; 3]| {
            let along = dot(v, normal);
            [0, 1, 2].map(|c| v[c] - along * normal[c])
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
        let (xi, value) = minimize(objective, &face.on_face(&start.xi), &lower, &upper);
        let at = face.at(patch, &xi, &mut PointBasis::default());
        let cosine = dot(&at.normal, normal);
        let is_there = (2.0 * value).sqrt() <= self.slack && cosine >= STEEPEST;
        is_there.then_some((start.of, xi, cosine))
    }

    /// The outward normal at `xi` of `face`, or beside it where the parametrisation is singular.
    fn normal_near(&self, face: &Face, xi: &[f64; 3]) -> Option<[f64; 3]> {
        let patch = &self.shape.patches[face.id.patch];
        let (lower, upper) = patch.domain();
        let aside = [0, 1, 2].map(|d| xi[d] + ASIDE * (0.5 * (lower[d] + upper[d]) - xi[d]));
        let normal = |xi: &[f64; 3]| face.at(patch, xi, &mut PointBasis::default()).normal;
        [normal(xi), normal(&aside)].into_iter().find(|n| norm(n) > 0.5)
    }
}

impl Surroundings for Splines<'_> {
    type Start = Start;
    type Fault = SplineError;

    fn model(&self) -> &Model {
        self.model
    }

    fn nearest(&self, point: &[f64; 3]) -> Option<Nearest<Start>> {
        let at = self.surface.closest(&self.shape.patches, point)?;
        let normal = self.normal_near(&self.surface.faces()[at.face], &at.xi);
        let start = Start { of: at.face, xi: at.xi };
        Some(Nearest { distance: at.measure, point: at.point, normal, start })
    }

    /// First from where the last point was, then from the places nearest to the target.
    fn over(&self, target: &[f64; 3], normal: &[f64; 3], start: Start) -> Option<(Found<Start>, f64)> {
        let patches = &self.shape.patches;
        let from = |start: Start| self.on_face(&start, target, normal);
        let nearest = || {
            let at = self.surface.closest(patches, target)?;
            from(Start { of: at.face, xi: at.xi })
        };
        let height = |&(of, xi, _): &(usize, [f64; 3], f64)| {
            let patch = &patches[self.surface.faces()[of].id.patch];
            dot(&difference(&patch.point(&xi), target), normal).abs()
        };
        let everywhere = || {
            let on = |of: usize| {
                let (lower, upper) = patches[self.surface.faces()[of].id.patch].domain();
                let middle = [0, 1, 2].map(|d| 0.5 * (lower[d] + upper[d]));
                from(Start { of, xi: self.surface.closest_from(patches, of, target, &middle).xi })
            };
            let all = (0..self.surface.faces().len()).filter_map(on);
            all.min_by(|a, b| height(a).total_cmp(&height(b)))
        };
        let (of, xi, cosine) = from(start).or_else(nearest).or_else(everywhere)?;
        let id = self.surface.faces()[of].id;
        Some((self.found(id.patch, xi, Some(id.direction), Start { of, xi }), cosine))
    }

    fn inside(&self, target: &[f64; 3], start: Option<Start>) -> Option<Found<Start>> {
        let patches = &self.shape.patches;
        let near =
            start.map(|Start { of, xi }| (of, self.searches[of].closest_from(&patches[of], target, &xi)));
        let again = || {
            let found = self.searches.iter().enumerate().map(|(i, s)| (i, s.closest(&patches[i], target)));
            found.min_by(|a, b| a.1.measure.total_cmp(&b.1.measure))
        };
        let (of, at) = near.filter(|(_, at)| at.measure <= self.slack).or_else(again)?;
        let start = Start { of, xi: at.xi };
        (at.measure <= self.slack).then(|| self.found(of, at.xi, None, start))
    }

    fn check_inside(&self, point: &[f64; 3]) -> Result<(), SplineError> {
        self.shape.locate(point).map(|_| ())
    }

    fn leaves(&self, kind: &'static str, radius: f64, point: [f64; 3]) -> SplineError {
        SplineError::ExtentBeyondBody { kind, radius, point }
    }
}
