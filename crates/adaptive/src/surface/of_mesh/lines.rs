//! Straight lines in the surface of a mesh, such as those of a cylinder.

use nalgebra::Vector3;

use super::{MeshSurface, SAME_PLANE};
use crate::surface::{ALONG_LINE, LocalShape, StraightLine, Surface, SurfacePlace, least_at};

/// Smaller curvature over the larger one below which a surface may be one of straight lines: what a
/// paraboloid through nodes errs by.
const STRAIGHT: f64 = 0.1;
/// Curvature times size of a body below which a surface is flat: lines of a plane are not told.
const FLAT: f64 = 1e-3;
/// Angle by which the direction of a fitted paraboloid may err \[rad\].
const TURN: f64 = 0.3;
/// Steps of the search for the direction of a line: each leaves 0.62 of the angle.
const TURNS: usize = 40;
/// Halvings of a length in the search for the end of a line.
const HALVINGS: usize = 40;

impl MeshSurface {
    /// See [`Surface::lines_through`]: the line in the direction of the smaller curvature, if that
    /// is one.
    pub(super) fn straight_lines(&self, point: &[f64; 3]) -> Vec<StraightLine> {
        if self.mesh.model().dimension() == 2 {
            return Vec::new();
        }
        let Some(foot) = self.nearest(point) else { return Vec::new() };
        let mut lines: Vec<StraightLine> = Vec::new();
        for place in self.sides_at(&foot.place) {
            let Some(line) = self.shape_at(&place).and_then(|shape| self.line(&place, &shape)) else {
                continue;
            };
            let ends = |line: &StraightLine| [line.points[0], line.points[ALONG_LINE.len() - 1]];
            let [a, b] = ends(&line);
            let is_known = |known: &StraightLine| {
                let [c, d] = ends(known);
                let apart = ((a - c).norm() + (b - d).norm()).min((a - d).norm() + (b - c).norm());
                apart <= 4.0 * self.near()
            };
            if !lines.iter().any(is_known) {
                lines.push(line);
            }
        }
        lines
    }

    fn near(&self) -> f64 {
        4.0 * SAME_PLANE * (self as &dyn Surface).reach()
    }

    /// A line through `place`, where the surface has the shape `shape`, that goes on to edges of
    /// the part on both sides. It is sought along the edges of sides, along the smaller curvature
    /// as fitted, and where the surface stays nearest.
    fn line(&self, place: &SurfacePlace, shape: &LocalShape) -> Option<StraightLine> {
        let size = self.length();
        let [a, b] = shape.curvatures.map(f64::abs);
        // Of the two principal directions, the first belongs to the larger curvature with its sign.
        let (large, small, along) = if a > b { (a, b, shape.tangents[1]) } else { (b, a, shape.tangents[0]) };
        if large * size < FLAT || small > STRAIGHT * large {
            return None;
        }
        let side = &self.sides()[place.face as usize];
        let node = |k: usize| Vector3::from(self.mesh.nodes()[side.nodes[k % side.n_edges()] as usize]);
        let edges = (0..side.n_edges()).filter_map(|k| (node(k + 1) - node(k)).try_normalize(0.0));
        let is_along = |edge: &Vector3<f64>| edge.dot(&along).abs() > TURN.cos();
        let nearest = self.nearest_direction(place, shape, &along);
        let mut candidates = edges.filter(is_along).chain([along, nearest]);
        candidates.find_map(|direction| self.line_along(place, shape, &direction))
    }

    /// The direction, not far from `along`, in which the surface is nearest to the line at the
    /// distance of a side.
    fn nearest_direction(
        &self,
        place: &SurfacePlace,
        shape: &LocalShape,
        along: &Vector3<f64>,
    ) -> Vector3<f64> {
        let (start, aside) = (Vector3::from(place.point), shape.normal.cross(along));
        let reach = self.length_at(place);
        let beside = |direction: &Vector3<f64>| {
            let distance =
                |x: Vector3<f64>| self.nearest(&x.into()).map_or(f64::INFINITY, |foot| foot.distance);
            distance(start + reach * direction).min(distance(start - reach * direction))
        };
        let turned = |angle: f64| (along * angle.cos() + aside * angle.sin()).normalize();
        turned(least_at([-TURN, TURN], TURNS, |angle| beside(&turned(angle))))
    }

    /// The line through `place` along `direction`, if it lies in the surface from one edge of the
    /// part to another.
    fn line_along(
        &self,
        place: &SurfacePlace,
        shape: &LocalShape,
        direction: &Vector3<f64>,
    ) -> Option<StraightLine> {
        let start = Vector3::from(place.point);
        let ends = [-1.0, 1.0].map(|sign| self.end_of(&start, &(sign * direction)));
        (ends[1] - ends[0]).try_normalize(self.near())?;
        let is_edge = |end: &Vector3<f64>| self.normals_at(&(*end).into()).len() > 1;
        let points = ALONG_LINE.map(|share| ends[0] + share * (ends[1] - ends[0]));
        let is_on_surface =
            |x: &Vector3<f64>| self.nearest(&(*x).into()).is_some_and(|foot| foot.distance <= self.near());
        if !ends.iter().all(is_edge) || !points.iter().all(is_on_surface) {
            return None;
        }
        let middle = self.nearest(&points[ALONG_LINE.len() / 2].into())?.place;
        Some(StraightLine { points, middle: self.turned_to(&middle, &shape.normal) })
    }

    /// Where the line from `start` along the unit vector `direction` leaves the surface.
    fn end_of(&self, start: &Vector3<f64>, direction: &Vector3<f64>) -> Vector3<f64> {
        let is_on_surface = |reach: f64| {
            let point = start + reach * direction;
            self.nearest(&point.into()).is_some_and(|foot| foot.distance <= self.near())
        };
        let [mut inside, mut outside] = [0.0, self.length()];
        for _ in 0..HALVINGS {
            let middle = 0.5 * (inside + outside);
            if is_on_surface(middle) { inside = middle } else { outside = middle }
        }
        start + inside * direction
    }
}
