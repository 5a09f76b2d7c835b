//! Points in elements and on the surface.

use std::cmp::Ordering;

use crate::element::jacobian::{
    PointOf, cross, derivatives, dot, element_map, inverse, minus, norm, position,
};
use crate::element::kind::{ElementKind, Form, SideKind};
use crate::element::shape::Functions;
use crate::fault::MeshFault;
use crate::mesh::Mesh;
use crate::mesh::boundary::Face;

/// Iterations of Newton's method; elements that are not folded need fewer than ten.
const MAX_STEPS: usize = 30;
/// Parameters count as equal within this.
const ROUND_OFF: f64 = 1e-9;
/// Distance from the surface, as a share of the size of the element there, up to which a point
/// outside is taken to lie on it: sides of a mesh do not follow a curved part exactly.
const OUTSIDE: f64 = 0.05;

/// A point of the surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OnSurface {
    /// The face.
    pub face: Face,
    /// Parameters of its side.
    pub eta: [f64; 2],
    /// Position \[m\].
    pub point: [f64; 3],
    /// Distance from the point that was sought \[m\].
    pub distance: f64,
}

/// Position, area element and outward normal on a side. A curve, the side of a plane element, is taken a
/// unit thick: its second tangent is the unit vector out of the plane.
#[derive(Debug, Clone, Default)]
pub struct SidePoint {
    /// Functions by parameters.
    pub functions: Functions<2>,
    /// Position \[m\].
    pub position: [f64; 3],
    /// Derivatives of the position by the parameters.
    pub tangents: [[f64; 3]; 2],
    /// Outward normal times the area element.
    pub area: [f64; 3],
}

impl SidePoint {
    /// Evaluates everything at the parameters `eta` of a side with nodes at `places`.
    pub fn evaluate(&mut self, kind: SideKind, places: &[[f64; 3]], eta: &[f64; 2]) {
        kind.functions(eta, &mut self.functions);
        self.position = position(&self.functions.values, places);
        let map = derivatives(&self.functions.slopes, places);
        self.tangents = [0, 1].map(|j| [0, 1, 2].map(|i: usize| map[i][j]));
        if kind.is_curve() {
            self.tangents[1] = [0.0, 0.0, 1.0];
        }
        self.area = cross(&self.tangents[0], &self.tangents[1]);
    }
}

/// How far parameters lie outside of the domain of `form`; negative inside.
fn excess(form: Form, xi: &[f64; 3]) -> f64 {
    let most = |all: &[f64]| all.iter().fold(f64::NEG_INFINITY, |m, x| m.max(*x));
    match form {
        Form::Tetrahedron => most(&[-xi[0], -xi[1], -xi[2], xi[0] + xi[1] + xi[2] - 1.0]),
        Form::Hexahedron => most(&xi.map(|x| x.abs() - 1.0)),
        Form::Wedge => most(&[-xi[0], -xi[1], xi[0] + xi[1] - 1.0, xi[2].abs() - 1.0]),
        Form::Triangle => most(&[-xi[0], -xi[1], xi[0] + xi[1] - 1.0]),
        Form::Quadrilateral => most(&[xi[0].abs() - 1.0, xi[1].abs() - 1.0]),
        Form::Pyramid => most(&[-xi[2], xi[0].abs() + xi[2] - 1.0, xi[1].abs() + xi[2] - 1.0]),
    }
}

/// The nearest parameters in the domain of a side, up to its skewness.
fn clamped(kind: SideKind, [x, y]: [f64; 2]) -> [f64; 2] {
    if kind.is_curve() {
        return [x.clamp(-1.0, 1.0), 0.0];
    }
    if kind.n_corners() == 4 {
        return [x.clamp(-1.0, 1.0), y.clamp(-1.0, 1.0)];
    }
    if x >= 0.0 && y >= 0.0 && x + y <= 1.0 {
        return [x, y];
    }
    let along = (0.5 * (1.0 + x - y)).clamp(0.0, 1.0);
    let candidates = [[x.clamp(0.0, 1.0), 0.0], [0.0, y.clamp(0.0, 1.0)], [along, 1.0 - along]];
    let distance = |c: &[f64; 2]| (c[0] - x).powi(2) + (c[1] - y).powi(2);
    candidates.into_iter().min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap_or([x, y])
}

/// The parameters `xi` after a step of Newton's method.
fn moved(form: Form, xi: &[f64; 3], step: &[f64; 3]) -> [f64; 3] {
    // Far outside the map may fold; a point of the element is never further than its own size.
    let long = norm(step).max(1.0);
    let step = step.map(|s| s / long);
    if form != Form::Pyramid {
        return std::array::from_fn(|d| (xi[d] + step[d]).clamp(-3.0, 3.0));
    }
    // The same step of the distance from the apex and of the ratios to it, in which the map has no
    // kink there.
    let w = 1.0 - xi[2];
    let next = (w - step[2]).clamp(0.1 * w.max(0.0), 3.0);
    let ratio = |d: usize| {
        let ratio = if w > 0.0 { (xi[d] + step[d] + xi[d] / w * step[2]) / w } else { step[d] / next };
        if ratio.is_finite() { ratio.clamp(-2.0, 2.0) } else { 0.0 }
    };
    [next * ratio(0), next * ratio(1), 1.0 - next]
}

/// Parameters of `point` in an element with nodes at `places`, if it lies there.
pub fn parameters(kind: ElementKind, places: &[[f64; 3]], point: &[f64; 3]) -> Option<[f64; 3]> {
    let mut xi = match kind.form() {
        Form::Tetrahedron => [0.25; 3],
        Form::Hexahedron | Form::Quadrilateral => [0.0; 3],
        Form::Wedge | Form::Triangle => [1.0 / 3.0, 1.0 / 3.0, 0.0],
        Form::Pyramid => [0.0, 0.0, 0.25],
    };
    let mut at = PointOf::default();
    for _ in 0..MAX_STEPS {
        at.evaluate(kind, places, &xi);
        if at.determinant.abs().partial_cmp(&0.0) != Some(Ordering::Greater) {
            return None;
        }
        let rest = minus(point, &at.position);
        let map = element_map(kind, &at.functions.slopes, places);
        let inverse = inverse(&map, at.determinant);
        let step = inverse.map(|row| dot(&row, &rest));
        xi = moved(kind.form(), &xi, &step);
        if norm(&step) < 1e-13 {
            break;
        }
    }
    at.evaluate(kind, places, &xi);
    let reach = norm(&minus(&places[0], &places[1]));
    let is_there = norm(&minus(point, &at.position)) < ROUND_OFF * reach;
    (is_there && excess(kind.form(), &xi) <= ROUND_OFF).then_some(xi)
}

/// Box around points, widened by a share of its size: sides may bulge beyond their nodes.
pub fn bounds(places: &[[f64; 3]]) -> ([f64; 3], [f64; 3]) {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for place in places {
        for d in 0..3 {
            low[d] = low[d].min(place[d]);
            high[d] = high[d].max(place[d]);
        }
    }
    let wider = 0.25 * norm(&minus(&high, &low));
    (low.map(|x| x - wider), high.map(|x| x + wider))
}

fn contains(&(low, high): &([f64; 3], [f64; 3]), point: &[f64; 3]) -> bool {
    (0..3).all(|d| low[d] <= point[d] && point[d] <= high[d])
}

/// Distance from a box, zero inside.
fn box_distance((low, high): &([f64; 3], [f64; 3]), point: &[f64; 3]) -> f64 {
    norm(&std::array::from_fn(|d| (low[d] - point[d]).max(point[d] - high[d]).max(0.0)))
}

impl Mesh {
    /// Element and parameters of a point; one that lies a little outside, as points of curved parts
    /// do, is moved to the surface.
    ///
    /// # Errors
    /// [`MeshFault::PointNotFound`].
    pub fn locate(&self, point: &[f64; 3]) -> Result<(usize, [f64; 3]), MeshFault> {
        let mut places = Vec::new();
        for (e, element) in self.elements().iter().enumerate() {
            self.places(element.nodes, &mut places);
            if !contains(&bounds(&places), point) {
                continue;
            }
            if let Some(xi) = parameters(element.kind, &places, point) {
                return Ok((e, xi));
            }
        }
        let lost = |distance| MeshFault::PointNotFound { point: *point, distance };
        let nearest = self.nearest(point).ok_or_else(|| lost(f64::INFINITY))?;
        let (_, nodes) = self.face(nearest.face);
        self.places(&nodes, &mut places);
        let size = norm(&minus(&places[0], &places[1]));
        if nearest.distance > OUTSIDE * size {
            return Err(lost(nearest.distance));
        }
        Ok((nearest.face.element as usize, self.in_element(nearest.face, &nearest.eta)))
    }

    /// Parameters in its element of the point with the parameters `eta` of the side `face`.
    pub fn in_element(&self, face: Face, eta: &[f64; 2]) -> [f64; 3] {
        let kind = self.elements().get(face.element as usize).kind;
        let (side, local) = kind.side_nodes(face.side as usize);
        let nodes = kind.node_parameters();
        let places: Vec<[f64; 3]> = local.iter().map(|&k| nodes[k as usize]).collect();
        let mut functions = Functions::default();
        side.functions(eta, &mut functions);
        position(&functions.values, &places)
    }

    /// The point of the surface nearest to `point`; where several are sought, one [`SurfaceSearch`]
    /// serves all.
    pub fn nearest(&self, point: &[f64; 3]) -> Option<OnSurface> {
        SurfaceSearch::new(self).nearest(self, point)
    }
}

/// Boxes around the sides of a mesh, by which nearest points of its surface are found.
#[derive(Debug, Clone)]
pub struct SurfaceSearch {
    boxes: Vec<([f64; 3], [f64; 3])>,
}

impl SurfaceSearch {
    /// Boxes around the sides of `mesh`.
    pub fn new(mesh: &Mesh) -> Self {
        let mut places = Vec::new();
        let around = |&face: &Face| {
            mesh.places(&mesh.face(face).1, &mut places);
            bounds(&places)
        };
        Self { boxes: mesh.surface().iter().map(around).collect() }
    }

    /// The point of the surface of `mesh` nearest to `point`; of sides at the same distance that of
    /// the first.
    pub fn nearest(&self, mesh: &Mesh, point: &[f64; 3]) -> Option<OnSurface> {
        let least = |i: usize| box_distance(&self.boxes[i], point);
        let first = (0..self.boxes.len()).min_by(|a, b| least(*a).total_cmp(&least(*b)))?;
        let mut places = Vec::new();
        let mut on_side = |i: usize| {
            let face = mesh.surface()[i];
            let (kind, nodes) = mesh.face(face);
            mesh.places(&nodes, &mut places);
            let (eta, point, distance) = nearest_on_side(kind, &places, point);
            OnSurface { face, eta, point, distance }
        };
        let mut best = on_side(first);
        for i in (0..self.boxes.len()).filter(|i| *i != first) {
            if least(i) > best.distance {
                continue;
            }
            let found = on_side(i);
            if found.distance < best.distance || (found.distance <= best.distance && found.face < best.face) {
                best = found;
            }
        }
        best.distance.is_finite().then_some(best)
    }
}

/// Parameters, position and distance of the point of a side nearest to `point`.
fn nearest_on_side(kind: SideKind, places: &[[f64; 3]], point: &[f64; 3]) -> ([f64; 2], [f64; 3], f64) {
    let mut at = SidePoint::default();
    let mut best = ([0.0; 2], [0.0; 3], f64::INFINITY);
    let see = |at: &mut SidePoint, eta: [f64; 2], best: &mut ([f64; 2], [f64; 3], f64)| {
        at.evaluate(kind, places, &eta);
        let distance = norm(&minus(&at.position, point));
        if distance < best.2 {
            *best = (eta, at.position, distance);
        }
    };
    let steps = 4;
    for i in 0..=steps {
        for j in 0..=steps {
            let grid = [i, j].map(|k| f64::from(k) / f64::from(steps));
            let eta = if kind.n_corners() == 3 { grid } else { grid.map(|x| 2.0 * x - 1.0) };
            see(&mut at, clamped(kind, eta), &mut best);
        }
    }
    let mut eta = best.0;
    for _ in 0..MAX_STEPS {
        at.evaluate(kind, places, &eta);
        // Gauss-Newton on the distance, which converges fast where the surface is much flatter than
        // the point is near.
        let rest = minus(point, &at.position);
        let [u, v] = at.tangents;
        let (a, b, c) = (dot(&u, &u), dot(&u, &v), dot(&v, &v));
        let determinant = a * c - b * b;
        if determinant.partial_cmp(&0.0) != Some(Ordering::Greater) {
            break;
        }
        let (p, q) = (dot(&u, &rest), dot(&v, &rest));
        let next =
            clamped(kind, [eta[0] + (c * p - b * q) / determinant, eta[1] + (a * q - b * p) / determinant]);
        let change = (next[0] - eta[0]).abs() + (next[1] - eta[1]).abs();
        eta = next;
        see(&mut at, eta, &mut best);
        if change < 1e-14 {
            break;
        }
    }
    best
}
