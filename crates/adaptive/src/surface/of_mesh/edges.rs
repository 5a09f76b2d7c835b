//! Edges of the part that a mesh stands for: chains of edges of sides over which it is not smooth.

use nalgebra::Vector3;

use super::MeshSurface;
use crate::surface::Surface;

/// Cosine of the largest angle at which an edge goes on in another at a node.
const GOES_ON: f64 = 0.5;

impl MeshSurface {
    /// Ends of the edges over which side `i` is not smooth, in the order of the side; none of a curve,
    /// whose edges are points.
    fn creases(&self, i: u32) -> impl Iterator<Item = [u32; 2]> {
        let side = &self.sides()[i as usize];
        (0..if side.kind.is_curve() { 0 } else { side.n_edges() })
            .filter(|e| side.neighbours[*e].is_none_or(|other| !other.is_smooth))
            .map(move |e| side.edge_nodes(e))
    }

    fn node(&self, n: u32) -> Vector3<f64> {
        Vector3::from(self.mesh.nodes()[n as usize])
    }

    /// See [`Surface::along_edges`].
    pub(super) fn places_of_edges(&self, point: &[f64; 3], length: f64) -> Vec<Vector3<f64>> {
        let Some(foot) = self.nearest(point) else { return Vec::new() };
        let start = Vector3::from(foot.place.point);
        let near = super::SAME_POINT * self.longest_edge(foot.place.face as usize);
        let through = |[a, b]: &[u32; 2]| {
            let (from, to) = (self.node(*a), self.node(*b));
            let along = (to - from).normalize();
            let share = (start - from).dot(&along);
            let is_between = share >= -near && share <= (to - from).norm() + near;
            is_between && (start - from - along * share).norm() <= near
        };
        let places = self.sides_at(&foot.place);
        let edges = places.iter().flat_map(|place| self.creases(place.face)).filter(through);
        // An edge belongs to two sides, which run along it against each other: each of them leads
        // one way.
        let ends = edges.filter_map(|[a, b]| self.walk(&start, [a, b], length));
        ends.collect()
    }

    /// The place at the distance `length` from `start` along the chain of edges that begins with
    /// the one from node `a` to node `b`; its end where it ends before, if that is elsewhere.
    fn walk(&self, start: &Vector3<f64>, [mut a, mut b]: [u32; 2], length: f64) -> Option<Vector3<f64>> {
        for _ in 0..self.mesh.nodes().len() {
            let (from, to) = (self.node(a), self.node(b));
            if (to - start).norm() >= length {
                // On the segment, where it leaves the ball about the start.
                let along = (to - from).normalize();
                let nearest = (start - from).dot(&along);
                let aside = (start - from - along * nearest).norm();
                return Some(from + along * (nearest + (length * length - aside * aside).max(0.0).sqrt()));
            }
            let along = (to - from).normalize();
            let ahead = |end: &u32| (self.node(*end) - to).normalize().dot(&along);
            let others = self.at_node(b).iter().flat_map(|i| self.creases(*i));
            let others = others.filter_map(|[c, d]| match (c == b, d == b) {
                (true, _) => Some(d),
                (_, true) => Some(c),
                _ => None,
            });
            let next = others.filter(|end| *end != a).max_by(|c, d| ahead(c).total_cmp(&ahead(d)));
            match next.filter(|end| ahead(end) >= GOES_ON) {
                Some(end) => (a, b) = (b, end),
                None => break,
            }
        }
        let end = self.node(b);
        ((end - start).norm() > 0.1 * length).then_some(end)
    }
}
