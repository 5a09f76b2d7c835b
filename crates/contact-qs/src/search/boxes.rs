//! Boxes and the tree of boxes over the pieces of a surface (theory Eq. C.28).

use nalgebra::{Matrix3, Vector3};

/// An axis-parallel box.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Bounds {
    pub centre: Vector3<f64>,
    pub half: Vector3<f64>,
}

impl Bounds {
    /// Box around points.
    pub fn around(points: impl Iterator<Item = Vector3<f64>>) -> Self {
        let (mut low, mut high) = (Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY));
        for p in points {
            (low, high) = (low.inf(&p), high.sup(&p));
        }
        Self { centre: 0.5 * (low + high), half: 0.5 * (high - low) }
    }

    fn union(&self, other: &Self) -> Self {
        let low = (self.centre - self.half).inf(&(other.centre - other.half));
        let high = (self.centre + self.half).sup(&(other.centre + other.half));
        Self { centre: 0.5 * (low + high), half: 0.5 * (high - low) }
    }

    /// Distance to a point, zero inside.
    pub fn distance_to(&self, point: &Vector3<f64>) -> f64 {
        ((point - self.centre).abs() - self.half).sup(&Vector3::zeros()).norm()
    }

    /// Distance to a box with the same axes, zero if they overlap.
    pub fn distance(&self, other: &Self) -> f64 {
        ((other.centre - self.centre).abs() - self.half - other.half).sup(&Vector3::zeros()).norm()
    }

    /// Smallest `n · x` in the box.
    pub fn lowest(&self, n: &Vector3<f64>) -> f64 {
        n.dot(&self.centre) - n.abs().dot(&self.half)
    }
}

/// Where the frame of the second body stands in that of the first.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Placement {
    pub rotation: Matrix3<f64>,
    pub origin: Vector3<f64>,
    magnitude: Matrix3<f64>,
}

impl Placement {
    pub fn new(rotation: Matrix3<f64>, origin: Vector3<f64>) -> Self {
        Self { rotation, origin, magnitude: rotation.abs() }
    }

    /// A lower bound of the distance between a box of the first body and one of the second: boxes
    /// around the other in each of the two frames.
    pub fn distance(&self, a: &Bounds, b: &Bounds) -> f64 {
        let zero = Vector3::zeros();
        let offset = self.rotation * b.centre + self.origin - a.centre;
        let in_first = (offset.abs() - a.half - self.magnitude * b.half).sup(&zero).norm();
        let back = self.rotation.tr_mul(&offset);
        let in_second = (back.abs() - self.magnitude.tr_mul(&a.half) - b.half).sup(&zero).norm();
        in_first.max(in_second)
    }

    /// How far two nodes are apart along `n`, the unit vector from the second body to the first,
    /// given in both frames: a lower bound of the distance.
    pub fn separation(&self, a: &Disc, b: &Disc, n: &[Vector3<f64>; 2]) -> f64 {
        (a.centre - self.origin).dot(&n[0]) - a.reach(&n[0]) - b.centre.dot(&n[1]) - b.reach(&n[1])
    }
}

/// A flat cylinder around control points, with its axis along their mean normal: its thickness is
/// of second order in the size of the piece, so that it tells apart neighbours of the critical
/// point where boxes do not.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Disc {
    pub centre: Vector3<f64>,
    axis: Vector3<f64>,
    half: f64,
    radius: f64,
}

impl Disc {
    /// Cylinder around points; `normal` need not be of length one.
    fn around(points: &[Vector3<f64>], normal: &Vector3<f64>) -> Self {
        let axis = normal.try_normalize(0.0).unwrap_or_else(Vector3::z);
        let middle = Bounds::around(points.iter().copied()).centre;
        let heights = points.iter().map(|p| axis.dot(&(p - middle)));
        let (low, high) = heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
        let centre = middle + axis * (0.5 * (low + high));
        let aside = |p: &Vector3<f64>| (p - centre - axis * axis.dot(&(p - centre))).norm();
        let radius = points.iter().map(aside).fold(0.0, f64::max);
        Self { centre, axis, half: 0.5 * (high - low), radius }
    }

    /// Half of its extent along the unit vector `n`.
    fn reach(&self, n: &Vector3<f64>) -> f64 {
        let cosine = n.dot(&self.axis);
        self.half * cosine.abs() + self.radius * (1.0 - cosine * cosine).max(0.0).sqrt()
    }
}

/// A node of the tree: a piece or two further nodes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Node {
    pub bounds: Bounds,
    pub disc: Disc,
    pub kind: NodeKind,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum NodeKind {
    Piece(u32),
    Children([u32; 2]),
}

/// What the tree is built over: control points of a piece, the box around them, and a normal as
/// long as the piece is large.
#[derive(Debug, Clone)]
pub(super) struct Leaf {
    pub points: Vec<Vector3<f64>>,
    pub bounds: Bounds,
    pub normal: Vector3<f64>,
}

/// Binary tree over pieces, split at the median of the longest side; the root comes first.
pub(super) fn tree(leaves: &[Leaf]) -> Vec<Node> {
    let mut nodes = Vec::with_capacity(2 * leaves.len());
    let mut order: Vec<u32> = (0..leaves.len() as u32).collect();
    if !leaves.is_empty() {
        grow(leaves, &mut order, &mut nodes);
    }
    nodes
}

fn grow(leaves: &[Leaf], order: &mut [u32], nodes: &mut Vec<Node>) -> u32 {
    let number = nodes.len() as u32;
    let of = |i: &u32| &leaves[*i as usize];
    let normal: Vector3<f64> = order.iter().map(|i| of(i).normal).sum();
    let points: Vec<Vector3<f64>> = order.iter().flat_map(|i| of(i).points.iter().copied()).collect();
    let disc = Disc::around(&points, &normal);
    let first = of(&order[0]).bounds;
    let bounds = order.iter().fold(first, |b, i| b.union(&of(i).bounds));
    nodes.push(Node { bounds, disc, kind: NodeKind::Piece(order[0]) });
    if order.len() > 1 {
        let axis = Bounds::around(order.iter().map(|i| of(i).bounds.centre)).half.imax();
        let place = |i: &u32| of(i).bounds.centre[axis];
        order.sort_by(|i, j| place(i).total_cmp(&place(j)));
        let (left, right) = order.split_at_mut(order.len() / 2);
        let children = [grow(leaves, left, nodes), grow(leaves, right, nodes)];
        nodes[number as usize].kind = NodeKind::Children(children);
    }
    number
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(shift: f64) -> Vec<Vector3<f64>> {
        (0..20)
            .map(|k| {
                let (x, y) = (0.1 * f64::from(k % 5) + shift, 0.1 * f64::from(k / 5));
                Vector3::new(x, y, 0.3 * x * x - 0.2 * x * y + shift)
            })
            .collect()
    }

    #[test]
    fn bounds_are_never_above_the_distance() {
        let (a, b) = (points(0.0), points(0.4));
        for k in 0..50 {
            let turn = nalgebra::Rotation3::from_euler_angles(0.1 * f64::from(k), 0.07, -0.2 * f64::from(k));
            let placement = Placement::new(*turn.matrix(), Vector3::new(0.3, -0.1, 0.02 * f64::from(k)));
            let moved = |p: &Vector3<f64>| placement.rotation * p + placement.origin;
            let mut least = (f64::INFINITY, Vector3::zeros());
            for x in &a {
                for r in b.iter().map(|y| x - moved(y)) {
                    if r.norm() < least.0 {
                        least = (r.norm(), r.normalize());
                    }
                }
            }
            let boxes = [&a, &b].map(|p| Bounds::around(p.iter().copied()));
            let round_off = 1e-14;
            assert!(placement.distance(&boxes[0], &boxes[1]) <= least.0 + round_off);
            let discs = [&a, &b].map(|p| Disc::around(p, &Vector3::new(0.2, -0.1, 1.0)));
            let n = [least.1, placement.rotation.tr_mul(&least.1)];
            assert!(placement.separation(&discs[0], &discs[1], &n) <= least.0 + round_off);
        }
    }
}
