//! Parts of a body that carry markers: whole groups of faces, discs on the surface, balls inside,
//! as quadrature points.

use std::cmp::Ordering;

use crate::element::jacobian::{PointOf, determinant, dot, inverse, minus, norm};
use crate::element::kind::{ElementKind, SideKind};
use crate::fault::MeshFault;
use crate::locate::{OnSurface, SidePoint, bounds, parameters};
use crate::mesh::Mesh;
use crate::mesh::boundary::Face;
use iga_core::elasticity::Model;
use iga_core::extent::ExtentPoint;
use iga_core::extent::around::{Found, Nearest, Surroundings, around};

/// Iterations that bring a point of a disc onto the surface.
const MAX_STEPS: usize = 30;
/// How far beyond the edges of a side, in its parameters, a point lies on it, and beside the line
/// along which it is sought, in the size of the side: round-off.
const ROUND_OFF: f64 = 1e-9;

/// A side, or an element, near the centre of an extent.
struct Near<Of, Kind> {
    of: Of,
    kind: Kind,
    places: Vec<[f64; 3]>,
    centre: [f64; 3],
    reach: f64,
}

impl<Of, Kind> Near<Of, Kind> {
    fn new(of: Of, kind: Kind, places: Vec<[f64; 3]>) -> Self {
        let (low, high) = bounds(&places);
        let centre = std::array::from_fn(|d| 0.5 * (low[d] + high[d]));
        Self { of, kind, places, centre, reach: 0.5 * norm(&minus(&high, &low)) }
    }

    fn is_within(&self, point: &[f64; 3], distance: f64) -> bool {
        norm(&minus(&self.centre, point)) <= distance + self.reach
    }
}

/// The surroundings of an extent in a mesh.
struct About<'a> {
    mesh: &'a Mesh,
    radius: f64,
    sides: Vec<Near<Face, SideKind>>,
    elements: Vec<Near<usize, ElementKind>>,
}

impl Mesh {
    /// The whole group of faces `name`, with the Gauss points of its sides.
    ///
    /// # Errors
    /// As [`Mesh::face_group`].
    pub fn face_part(&self, name: &str) -> Result<Vec<ExtentPoint>, MeshFault> {
        Ok(self.part_of(self.face_group(name)?))
    }

    /// The sides `faces`.
    pub fn part_of(&self, faces: &[Face]) -> Vec<ExtentPoint> {
        let (mut part, mut at, mut places) = (Vec::new(), SidePoint::default(), Vec::new());
        for &face in faces {
            let (kind, nodes) = self.face(face);
            self.places(&nodes, &mut places);
            for rule in kind.rule() {
                at.evaluate(kind, &places, &rule.xi);
                let (element, xi) = (face.element as usize, self.in_element(face, &rule.xi));
                part.push(ExtentPoint {
                    element,
                    xi,
                    point: at.position,
                    weight: rule.weight * norm(&at.area) * self.model().measure(&at.position),
                });
            }
        }
        part
    }

    /// What lies within `radius` of `point`, see [`around`].
    ///
    /// # Errors
    /// [`MeshFault::BeyondBody`] if it leaves the body, [`MeshFault::PointNotFound`] if the point does.
    pub fn around(&self, point: &[f64; 3], radius: f64) -> Result<Vec<ExtentPoint>, MeshFault> {
        let side = |&face: &Face| {
            let (kind, nodes) = self.face(face);
            let places = nodes.iter().map(|&n| self.nodes()[n as usize]).collect();
            Some(Near::new(face, kind, places)).filter(|near| near.is_within(point, 2.0 * radius))
        };
        let element = |(e, element): (usize, crate::mesh::raw::Element<'_>)| {
            let places = element.nodes.iter().map(|&n| self.nodes()[n as usize]).collect();
            Some(Near::new(e, element.kind, places)).filter(|near| near.is_within(point, radius))
        };
        let sides = self.surface().iter().filter_map(side).collect();
        let elements = self.elements().iter().enumerate().filter_map(element).collect();
        around(&About { mesh: self, radius, sides, elements }, point, radius)
    }
}

impl Surroundings for About<'_> {
    type Start = ();
    type Fault = MeshFault;

    fn model(&self) -> &Model {
        self.mesh.model()
    }

    fn nearest(&self, point: &[f64; 3]) -> Option<Nearest<()>> {
        let OnSurface { face, eta, point, distance } = self.mesh.nearest(point)?;
        let (kind, nodes) = self.mesh.face(face);
        let (mut at, mut places) = (SidePoint::default(), Vec::new());
        self.mesh.places(&nodes, &mut places);
        at.evaluate(kind, &places, &eta);
        let length = norm(&at.area);
        let normal = (length > 0.0).then(|| at.area.map(|x| x / length));
        Some(Nearest { distance, point, normal, start: () })
    }

    /// The point over `target` along `normal`: on the nearest side, if it is no further away than
    /// the diameter of the disc.
    fn over(&self, target: &[f64; 3], normal: &[f64; 3], _start: ()) -> Option<(Found<()>, f64)> {
        let hits = self.sides.iter().filter_map(|near| Some((near, hit(near, target, normal)?)));
        let reached = hits.filter(|(_, (_, height))| height.abs() <= 2.0 * self.radius);
        let (near, (eta, _)) = reached.min_by(|a, b| a.1.1.abs().total_cmp(&b.1.1.abs()))?;
        let mut at = SidePoint::default();
        at.evaluate(near.kind, &near.places, &eta);
        let (element, xi) = (near.of.element as usize, self.mesh.in_element(near.of, &eta));
        let first = norm(&minus(&near.places[0], &near.places[1]));
        let found = Found { element, xi, point: at.position, sides: [first, 0.0, 0.0], start: () };
        Some((found, dot(&at.area, normal) / norm(&at.area)))
    }

    fn inside(&self, target: &[f64; 3], _start: Option<()>) -> Option<Found<()>> {
        let near = self.elements.iter().filter(|near| near.is_within(target, 0.0));
        let mut found = near.filter_map(|near| Some((near, parameters(near.kind, &near.places, target)?)));
        let (near, xi) = found.next()?;
        let mut at = PointOf::default();
        at.evaluate(near.kind, &near.places, &xi);
        let first = norm(&minus(&near.places[0], &near.places[1]));
        Some(Found { element: near.of, xi, point: at.position, sides: [first, 0.0, 0.0], start: () })
    }

    fn check_inside(&self, point: &[f64; 3]) -> Result<(), MeshFault> {
        self.mesh.locate(point).map(|_| ())
    }

    fn leaves(&self, kind: &'static str, radius: f64, point: [f64; 3]) -> MeshFault {
        MeshFault::BeyondBody { kind, radius, point }
    }
}

/// Parameters at which a line through `start` along `normal` meets a side from outside, and the
/// height there.
fn hit(near: &Near<Face, SideKind>, start: &[f64; 3], normal: &[f64; 3]) -> Option<([f64; 2], f64)> {
    let beside = |to: &[f64; 3]| {
        let height = dot(to, normal);
        norm(&std::array::from_fn(|d| to[d] - height * normal[d]))
    };
    if beside(&minus(&near.centre, start)) > near.reach {
        return None;
    }
    let is_triangle = near.kind.n_corners() == 3;
    let mut eta = if is_triangle { [1.0 / 3.0; 2] } else { [0.0; 2] };
    let (mut height, mut at) = (0.0_f64, SidePoint::default());
    for _ in 0..MAX_STEPS {
        at.evaluate(near.kind, &near.places, &eta);
        // x(eta) - height normal = start, linearised; the unknowns are the changes of eta and the
        // new height.
        let rest = minus(start, &at.position);
        let map: [[f64; 3]; 3] = std::array::from_fn(|i| [at.tangents[0][i], at.tangents[1][i], -normal[i]]);
        let size = determinant(&map);
        if size.abs().partial_cmp(&0.0) != Some(Ordering::Greater) {
            break;
        }
        let step = inverse(&map, size).map(|row| dot(&row, &rest));
        let long = step[0].hypot(step[1]).max(1.0);
        eta = [eta[0] + step[0] / long, eta[1] + step[1] / long];
        height = step[2];
        if step[0].hypot(step[1]) < 1e-13 {
            break;
        }
    }
    let is_inside = if is_triangle {
        eta[0] >= -ROUND_OFF && eta[1] >= -ROUND_OFF && eta[0] + eta[1] <= 1.0 + ROUND_OFF
    } else {
        eta.iter().all(|x| x.abs() <= 1.0 + ROUND_OFF)
    };
    at.evaluate(near.kind, &near.places, &eta);
    let is_on_line = beside(&minus(&at.position, start)) < ROUND_OFF * near.reach;
    (is_inside && is_on_line && dot(&at.area, normal) > 0.0).then_some((eta, height))
}
