//! Parts of a body that carry markers: whole groups of faces, discs on the surface, balls inside, as quadrature points.

use std::cmp::Ordering;

use crate::boundary::Face;
use crate::fault::MeshFault;
use crate::jacobian::{PointOf, cross, dot, minus, norm};
use crate::kind::{ElementKind, SideKind};
use crate::locate::{OnSurface, SidePoint, bounds, parameters};
use crate::mesh::Mesh;
use iga_core::extent::ON_SURFACE;

/// Parts of a radius: as many as elements, between these.
const PARTS: [usize; 2] = [2, 16];
/// Gauss points of each part of a radius.
const LINE: [(f64, f64); 3] =
    [(-0.774_596_669_241_483_4, 5.0 / 9.0), (0.0, 8.0 / 9.0), (0.774_596_669_241_483_4, 5.0 / 9.0)];
/// Iterations that bring a point of a disc onto the surface.
const MAX_STEPS: usize = 30;

/// Quadrature points of a part with the functions that are not zero there.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Part {
    points: Vec<([f64; 3], f64)>,
    starts: Vec<usize>,
    functions: Vec<(u32, f64)>,
}

impl Part {
    fn push(&mut self, point: [f64; 3], weight: f64, nodes: &[u32], values: &[f64]) {
        self.starts.push(self.functions.len());
        self.points.push((point, weight));
        self.functions.extend(nodes.iter().copied().zip(values.iter().copied()));
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// Position \[m\] and area, inside a body volume, \[m² or m³\] of point `i`, and the nodes whose functions are not zero there, each with
    /// its value.
    ///
    /// # Panics
    /// If there is no such point.
    pub fn point(&self, i: usize) -> ([f64; 3], f64, &[(u32, f64)]) {
        let end = self.starts.get(i + 1).copied().unwrap_or(self.functions.len());
        let (point, weight) = self.points[i];
        (point, weight, &self.functions[self.starts[i]..end])
    }

    /// Area or volume \[m² or m³\].
    pub fn measure(&self) -> f64 {
        self.points.iter().map(|(_, weight)| weight).sum()
    }

    /// Centroid \[m\].
    pub fn centroid(&self) -> [f64; 3] {
        let total = self.measure();
        [0, 1, 2].map(|d| self.points.iter().map(|(p, w)| p[d] * w).sum::<f64>() / total)
    }
}

/// A face near a disc.
struct NearFace {
    kind: SideKind,
    nodes: Vec<u32>,
    places: Vec<[f64; 3]>,
    centre: [f64; 3],
    reach: f64,
}

/// An element near a ball.
struct NearElement<'a> {
    kind: ElementKind,
    nodes: &'a [u32],
    places: Vec<[f64; 3]>,
    centre: [f64; 3],
    reach: f64,
}

impl Mesh {
    /// The whole group of faces `name`, with the Gauss points of its sides.
    ///
    /// # Errors
    /// As [`Mesh::face_group`].
    pub fn face_part(&self, name: &str) -> Result<Part, MeshFault> {
        Ok(self.part_of(self.face_group(name)?))
    }

    /// The sides `faces`.
    pub fn part_of(&self, faces: &[Face]) -> Part {
        let (mut part, mut at, mut places) = (Part::default(), SidePoint::default(), Vec::new());
        for &face in faces {
            let (kind, nodes) = self.face(face);
            self.places(&nodes, &mut places);
            for point in kind.rule() {
                at.evaluate(kind, &places, &point.xi);
                part.push(at.position, point.weight * norm(&at.area), &nodes, &at.functions.values);
            }
        }
        part
    }

    /// What lies within `radius` of `point`: of a point on the surface what lies over a disc in the plane that touches it there, of one inside a ball.
    ///
    /// # Errors
    /// [`MeshFault::BeyondBody`] if it leaves the body, [`MeshFault::PointNotFound`] if the point does.
    pub fn around(&self, point: &[f64; 3], radius: f64) -> Result<Part, MeshFault> {
        let lost = MeshFault::PointNotFound { point: *point, distance: f64::INFINITY };
        let nearest = self.nearest(point).ok_or(lost)?;
        if nearest.distance <= ON_SURFACE * radius {
            return self.disc(&nearest, radius).ok_or(MeshFault::BeyondBody {
                kind: "disc",
                radius,
                point: *point,
            });
        }
        self.locate(point)?;
        self.ball(point, radius).ok_or(MeshFault::BeyondBody { kind: "ball", radius, point: *point })
    }

    fn disc(&self, centre: &OnSurface, radius: f64) -> Option<Part> {
        let mut at = SidePoint::default();
        let (kind, nodes) = self.face(centre.face);
        let mut places = Vec::new();
        self.places(&nodes, &mut places);
        at.evaluate(kind, &places, &centre.eta);
        let normal = at.area.map(|x| x / norm(&at.area));
        let size = norm(&minus(&places[0], &places[1]));
        let along = at.tangents[0].map(|x| x / norm(&at.tangents[0]));
        let across = cross(&normal, &along);
        let near: Vec<NearFace> = self
            .surface()
            .iter()
            .map(|&face| self.near_face(face))
            .filter(|f| norm(&minus(&f.centre, &centre.point)) <= 2.0 * radius + f.reach)
            .collect();
        let parts = ((radius / size).ceil() as usize).clamp(PARTS[0], PARTS[1]);
        let n_directions = 12 * parts;
        let mut part = Part::default();
        for i in 0..parts {
            for (s, w) in LINE {
                let step = radius / parts as f64;
                let (r, weight) = ((i as f64 + 0.5 + 0.5 * s) * step, 0.5 * w * step);
                for k in 0..n_directions {
                    let angle = std::f64::consts::TAU * (k as f64 + 0.5) / n_directions as f64;
                    let (sin, cos) = angle.sin_cos();
                    let start: [f64; 3] =
                        std::array::from_fn(|d| centre.point[d] + r * (cos * along[d] + sin * across[d]));
                    let area = weight * r * std::f64::consts::TAU / n_directions as f64;
                    let (face, eta) = drop_onto(&near, &start, &normal, 2.0 * radius)?;
                    at.evaluate(face.kind, &face.places, &eta);
                    let slope = dot(&at.area, &normal) / norm(&at.area);
                    part.push(at.position, area / slope, &face.nodes, &at.functions.values);
                }
            }
        }
        Some(part)
    }

    fn near_face(&self, face: Face) -> NearFace {
        let (kind, nodes) = self.face(face);
        let mut places = Vec::new();
        self.places(&nodes, &mut places);
        let (low, high) = bounds(&places);
        let centre = std::array::from_fn(|d| 0.5 * (low[d] + high[d]));
        NearFace { kind, nodes, places, centre, reach: 0.5 * norm(&minus(&high, &low)) }
    }

    fn ball(&self, centre: &[f64; 3], radius: f64) -> Option<Part> {
        let near = self.near_elements(centre, radius);
        let smallest =
            near.iter().map(|e| norm(&minus(&e.places[0], &e.places[1]))).fold(f64::INFINITY, f64::min);
        let parts = ((radius / smallest).ceil() as usize).clamp(PARTS[0], PARTS[1] / 2);
        let (mut part, mut at) = (Part::default(), PointOf::default());
        for (place, volume) in ball_rule(parts) {
            let point: [f64; 3] = std::array::from_fn(|d| centre[d] + radius * place[d]);
            let (element, xi) = near.iter().find_map(|e| {
                let is_near = norm(&minus(&e.centre, &point)) <= e.reach;
                Some((e, is_near.then(|| parameters(e.kind, &e.places, &point)).flatten()?))
            })?;
            at.evaluate(element.kind, &element.places, &xi);
            part.push(at.position, volume * radius.powi(3), element.nodes, &at.functions.values);
        }
        Some(part)
    }

    fn near_elements(&self, point: &[f64; 3], radius: f64) -> Vec<NearElement<'_>> {
        let near = |element: crate::raw::Element<'_>| {
            let mut places = Vec::new();
            self.places(element.nodes, &mut places);
            let (low, high) = bounds(&places);
            let centre: [f64; 3] = std::array::from_fn(|d| 0.5 * (low[d] + high[d]));
            (places, centre, 0.5 * norm(&minus(&high, &low)))
        };
        let mut all = Vec::new();
        for e in 0..self.elements().len() {
            let element = self.elements().get(e);
            let (places, centre, reach) = near(element);
            if norm(&minus(&centre, point)) <= radius + reach {
                all.push(NearElement { kind: element.kind, nodes: element.nodes, places, centre, reach });
            }
        }
        all
    }
}

/// Points and volumes of a rule for the ball of radius one, each radius cut into `parts`.
fn ball_rule(parts: usize) -> Vec<([f64; 3], f64)> {
    let (levels, n_directions) = (2 * parts, 8 * parts);
    let mut rule = Vec::new();
    for i in 0..parts {
        for (s, w) in LINE {
            let step = 1.0 / parts as f64;
            let (r, weight) = ((i as f64 + 0.5 + 0.5 * s) * step, 0.5 * w * step);
            for (level, (t, v)) in (0..levels).flat_map(|level| LINE.map(|point| (level, point))) {
                let height = ((level as f64 + 0.5 + 0.5 * t) / levels as f64).mul_add(2.0, -1.0);
                let width = (1.0 - height * height).max(0.0).sqrt();
                let share = weight * r * r * v / levels as f64 * std::f64::consts::TAU / n_directions as f64;
                rule.extend((0..n_directions).map(|k| {
                    let (sin, cos) =
                        (std::f64::consts::TAU * (k as f64 + 0.5) / n_directions as f64).sin_cos();
                    ([r * width * cos, r * width * sin, r * height], share)
                }));
            }
        }
    }
    rule
}

/// The face that a line through `start` along `normal` meets from outside, nearest to `start` and no further than `reach`.
fn drop_onto<'a>(
    near: &'a [NearFace],
    start: &[f64; 3],
    normal: &[f64; 3],
    reach: f64,
) -> Option<(&'a NearFace, [f64; 2])> {
    let mut best: Option<(&NearFace, [f64; 2], f64)> = None;
    let mut at = SidePoint::default();
    for face in near {
        let to = minus(&face.centre, start);
        let height = dot(&to, normal);
        let aside = norm(&std::array::from_fn(|d| to[d] - height * normal[d]));
        if aside > face.reach {
            continue;
        }
        let is_triangle = face.kind.n_corners() == 3;
        let mut eta = if is_triangle { [1.0 / 3.0; 2] } else { [0.0; 2] };
        let mut up = 0.0;
        for _ in 0..MAX_STEPS {
            at.evaluate(face.kind, &face.places, &eta);
            // x(eta) - up normal = start, linearised; the unknowns are the changes of eta and the new height.
            let rest = minus(start, &at.position);
            let map: [[f64; 3]; 3] =
                std::array::from_fn(|i| [at.tangents[0][i], at.tangents[1][i], -normal[i]]);
            let determinant = crate::jacobian::determinant(&map);
            if determinant.abs().partial_cmp(&0.0) != Some(Ordering::Greater) {
                break;
            }
            let step = crate::jacobian::inverse(&map, determinant).map(|row| dot(&row, &rest));
            let long = step[0].hypot(step[1]).max(1.0);
            eta = [eta[0] + step[0] / long, eta[1] + step[1] / long];
            up = step[2];
            if step[0].hypot(step[1]) < 1e-13 {
                break;
            }
        }
        let slack = 1e-9;
        let is_inside = if is_triangle {
            eta[0] >= -slack && eta[1] >= -slack && eta[0] + eta[1] <= 1.0 + slack
        } else {
            eta.iter().all(|x| x.abs() <= 1.0 + slack)
        };
        at.evaluate(face.kind, &face.places, &eta);
        let miss = {
            let to = minus(&at.position, start);
            let height = dot(&to, normal);
            norm(&std::array::from_fn(|d| to[d] - height * normal[d]))
        };
        let is_hit = is_inside && miss < 1e-9 * face.reach && dot(&at.area, normal) > 0.0;
        if is_hit && up.abs() <= reach && best.as_ref().is_none_or(|b| up.abs() < b.2) {
            best = Some((face, eta, up.abs()));
        }
    }
    best.map(|(face, eta, _)| (face, eta))
}
