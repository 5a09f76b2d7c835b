//! Nested dissection (Eqs. R.1, R.2; George 1973): the elimination order of the sparse
//! factorisation.
//!
//! The graph of the nodes is cut in two across a direction: a coordinate, or the distance from the
//! nodes that are eliminated last. Every place in every direction is tried; in large sets the best
//! separator of each direction then moves to the smallest one nearby (`separator`), as long as
//! that makes it better. The one is taken that is smallest for the sides that it leaves; it
//! is eliminated after both its sides. Nodes without distinct places (all anchors equal) are cut
//! along breadth-first levels, so that any graph gets an order. Cost O(nnz log n), but for the
//! search of small separators, whose cost grows with their size, too.

mod separator;

use faer::sparse::SymbolicSparseColMatRef;
use rayon::prelude::*;

use crate::body::Dof;
use separator::{Part, SortedGraph};

/// Sets of at most this many nodes are not cut any further.
const LEAF: usize = 32;
/// A side must hold at least this part of the nodes: a cheap but lopsided cut only adds depth.
const SMALLEST_SIDE: f64 = 0.2;
/// Sets of at least this many nodes get the smallest separator; smaller ones have no part in the
/// cost.
const LARGE: usize = 200;
/// Layers of neighbours on each side of a separator among which a smaller one is sought.
const LAYERS: usize = 2;
/// Share of each side that may come into these layers: sides stay even.
const MOVABLE: f64 = 0.4;
/// Sets of at least this many nodes are shared among threads.
const SHARED: usize = 2000;

/// Neighbours of every node.
#[derive(Debug, Clone)]
pub struct NodeGraph {
    start: Vec<usize>,
    neighbours: Vec<u32>,
}

impl NodeGraph {
    /// Graph of the nodes whose unknowns meet in the lower triangle `pattern` (unknown by unknown).
    pub fn new(pattern: SymbolicSparseColMatRef<'_, u32>, dofs: &[Dof], n_nodes: usize) -> Self {
        let mut edges: Vec<Vec<u32>> = vec![Vec::new(); n_nodes];
        let mut last_seen = vec![u32::MAX; n_nodes];
        let mut current = u32::MAX;
        for (j, dof) in dofs.iter().enumerate() {
            let a = dof.node;
            if a != current {
                current = a;
                last_seen[a as usize] = a;
            }
            for i in pattern.row_idx_of_col(j) {
                let b = dofs[i].node;
                if last_seen[b as usize] != a {
                    last_seen[b as usize] = a;
                    edges[a as usize].push(b);
                    edges[b as usize].push(a);
                }
            }
        }
        let mut start = vec![0];
        let mut neighbours = Vec::new();
        for list in &mut edges {
            list.sort_unstable();
            list.dedup();
            neighbours.extend_from_slice(list);
            start.push(neighbours.len());
        }
        Self { start, neighbours }
    }

    /// Edges on the shortest way from the nodes `from` to every node; of what is connected with
    /// none of them, one more than all others.
    fn steps_from(&self, from: &[u32]) -> Vec<f64> {
        let mut steps = vec![f64::INFINITY; self.start.len() - 1];
        let mut found = from.to_vec();
        found.iter().for_each(|&a| steps[a as usize] = 0.0);
        let (mut head, mut furthest) = (0, 0.0);
        while let Some(&a) = found.get(head) {
            head += 1;
            furthest = steps[a as usize];
            for &b in self.of(a) {
                if steps[b as usize].is_infinite() {
                    steps[b as usize] = furthest + 1.0;
                    found.push(b);
                }
            }
        }
        steps.iter_mut().filter(|s| s.is_infinite()).for_each(|s| *s = furthest + 1.0);
        steps
    }

    fn of(&self, node: u32) -> &[u32] {
        &self.neighbours[self.start[node as usize]..self.start[node as usize + 1]]
    }
}

/// Elimination order of the unknowns: position p of the result holds the unknown that is eliminated
/// as p-th.
///
/// The unknowns in `last` come at the end, in the order given.
///
/// # Panics
/// If `last` names an unknown that does not exist.
pub fn elimination_order(
    pattern: SymbolicSparseColMatRef<'_, u32>,
    dofs: &[Dof],
    anchors: &[[f64; 3]],
    last: &[usize],
) -> Vec<u32> {
    let graph = NodeGraph::new(pattern, dofs, anchors.len());
    let mut is_last = vec![false; dofs.len()];
    for &i in last {
        is_last[i] = true;
    }
    let mut unknowns: Vec<Vec<u32>> = vec![Vec::new(); anchors.len()];
    for (i, dof) in dofs.iter().enumerate().filter(|&(i, _)| !is_last[i]) {
        unknowns[dof.node as usize].push(i as u32);
    }
    let mut nodes: Vec<u32> =
        (0..anchors.len() as u32).filter(|&a| !unknowns[a as usize].is_empty()).collect();
    let mut last_nodes: Vec<u32> = last.iter().map(|&i| dofs[i].node).collect();
    last_nodes.sort_unstable();
    last_nodes.dedup();
    nested_dissection(&graph, anchors, &last_nodes, &mut nodes);
    let mut order: Vec<u32> = nodes.iter().flat_map(|&a| unknowns[a as usize].iter().copied()).collect();
    order.extend(last.iter().map(|&i| i as u32));
    order
}

/// Puts `nodes` (a subset of the graph's, no repeats) into a nested-dissection order; the nodes
/// `last` come after them.
fn nested_dissection(graph: &NodeGraph, anchors: &[[f64; 3]], last: &[u32], nodes: &mut [u32]) {
    let mut directions: Vec<Vec<f64>> =
        (0..3).map(|axis| anchors.iter().map(|place| place[axis]).collect()).collect();
    if !last.is_empty() {
        let distance = distances(anchors, last);
        directions
            .push(graph.steps_from(last).into_iter().zip(&distance).map(|(steps, d)| steps + d).collect());
        directions.push(distance);
    }
    Cutter::new(graph, anchors, &directions).dissect(nodes);
}

/// Distance of every node from the middle of the nodes `from`, the largest being 1.
fn distances(anchors: &[[f64; 3]], from: &[u32]) -> Vec<f64> {
    let middle: [f64; 3] = std::array::from_fn(|axis| {
        from.iter().map(|&a| anchors[a as usize][axis]).sum::<f64>() / from.len() as f64
    });
    let distance =
        |place: &[f64; 3]| (0..3).map(|axis| (place[axis] - middle[axis]).powi(2)).sum::<f64>().sqrt();
    let mut distances: Vec<f64> = anchors.iter().map(distance).collect();
    let largest = distances.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
    distances.iter_mut().for_each(|d| *d /= largest);
    distances
}

#[derive(Clone, Copy, PartialEq)]
enum Side {
    Outside,
    Left,
    Right,
    Separator,
}

/// Rank of a node that is not cut, and of those on a side that are and are not in a layer.
const OUTSIDE: u32 = u32::MAX;
const IN_LAYER: u32 = OUTSIDE - 1;
const ON_SIDE: u32 = OUTSIDE - 2;

struct Cutter<'a> {
    graph: &'a NodeGraph,
    anchors: &'a [[f64; 3]],
    /// Coordinates of every node, by which they are sorted for a cut.
    directions: &'a [Vec<f64>],
    side: Vec<Side>,
    /// Position of every node along the direction that is tried.
    rank: Vec<u32>,
}

/// A way to cut: the nodes sorted along it, and where.
struct Cut {
    sorted: Vec<u32>,
    at: usize,
    from_left: bool,
}

/// The square of the nodes of the separator against the product of the sides to the power 3/2
/// (Eq. R.1): small separators, even sides.
fn score(separator: usize, left: usize, right: usize) -> f64 {
    (separator as f64).powi(2) / (left as f64 * right as f64).powf(1.5)
}

/// Nodes in two parts that no edge connects, and what separates them.
struct Division {
    left: Vec<u32>,
    right: Vec<u32>,
    separator: Vec<u32>,
}

impl Division {
    fn score(&self) -> f64 {
        score(self.separator.len(), self.left.len(), self.right.len())
    }
}

impl<'a> Cutter<'a> {
    fn new(graph: &'a NodeGraph, anchors: &'a [[f64; 3]], directions: &'a [Vec<f64>]) -> Self {
        let n = anchors.len();
        Self { graph, anchors, directions, side: vec![Side::Outside; n], rank: vec![OUTSIDE; n] }
    }

    fn dissect(&mut self, nodes: &mut [u32]) {
        let division = if nodes.len() > LEAF { self.divide(nodes) } else { None };
        let Some(Division { left, right, mut separator }) = division else {
            self.sweep(nodes);
            return;
        };
        separator.sort_unstable();
        let (first, rest) = nodes.split_at_mut(left.len());
        let (second, third) = rest.split_at_mut(right.len());
        first.copy_from_slice(&left);
        second.copy_from_slice(&right);
        third.copy_from_slice(&separator);
        if first.len().min(second.len()) < SHARED {
            self.dissect(first);
            self.dissect(second);
        } else {
            let mut beside = Cutter::new(self.graph, self.anchors, self.directions);
            rayon::join(|| self.dissect(first), || beside.dissect(second));
        }
    }

    /// The best division across a direction; `None` if nothing is split off.
    fn divide(&mut self, nodes: &[u32]) -> Option<Division> {
        let cuts = self.cuts(nodes);
        let divisions = cuts.iter().map(|cut| self.along(cut)).collect::<Vec<_>>();
        let divisions: Vec<Division> = match nodes.len() {
            SHARED.. => divisions.into_par_iter().map(|division| self.narrowed(division)).collect(),
            LARGE.. => divisions.into_iter().map(|division| self.narrowed(division)).collect(),
            _ => divisions,
        };
        let division = divisions.into_iter().min_by(|p, q| p.score().total_cmp(&q.score()))?;
        // A separator of most nodes splits nothing off: the graph is as good as full.
        (3 * division.separator.len() < nodes.len()).then_some(division)
    }

    /// The best cut of every direction; of breadth-first levels where there is no direction.
    fn cuts(&mut self, nodes: &[u32]) -> Vec<Cut> {
        let mut cuts = Vec::new();
        for d in 0..self.directions.len() {
            let places = nodes.iter().map(|&a| (self.directions[d][a as usize], a)).collect();
            cuts.extend(self.cut(places));
        }
        if cuts.is_empty() {
            let places = self.levels(nodes);
            cuts.extend(self.cut(places));
        }
        cuts
    }

    /// The division by a cut as it is.
    fn along(&mut self, cut: &Cut) -> Division {
        self.mark(&cut.sorted, cut.at);
        let (giving, facing) =
            if cut.from_left { (Side::Left, Side::Right) } else { (Side::Right, Side::Left) };
        let separator: Vec<u32> =
            cut.sorted.iter().copied().filter(|&a| self.touches(a, giving, facing)).collect();
        for &a in &separator {
            self.side[a as usize] = Side::Separator;
        }
        let on = |side: Side| -> Vec<u32> {
            cut.sorted.iter().copied().filter(|&a| self.side[a as usize] == side).collect()
        };
        let (left, right) = (on(Side::Left), on(Side::Right));
        self.unmark(&cut.sorted);
        Division { left, right, separator }
    }

    /// The division whose separator has moved to the smallest one a few layers of neighbours around
    /// it, as often as that makes it better (Eq. R.2).
    fn narrowed(&self, mut division: Division) -> Division {
        let mut rank = vec![OUTSIDE; self.anchors.len()];
        while let Some(next) = self.narrowed_once(&division, &mut rank)
            && next.score() < division.score()
        {
            division = next;
        }
        division
    }

    /// One such move; `None` if a side has no node beyond the layers. All nodes have the rank
    /// [`OUTSIDE`] before and after.
    fn narrowed_once(&self, division: &Division, rank: &mut [u32]) -> Option<Division> {
        let Division { left, right, separator } = division;
        let [before, behind] = [left, right].map(|side| self.layers(separator, side, rank));
        let [first, last] = [&before, &behind].map(|layers| layers.last().map_or(0, Vec::len));
        let sorted = before.iter().rev().flatten().chain(separator).chain(behind.iter().flatten());
        let sorted: Vec<u32> = sorted.copied().collect();
        let n = sorted.len();
        sorted.iter().zip(0..).for_each(|(&a, p)| rank[a as usize] = p);
        let parts = (first > 0 && last > 0).then(|| {
            let ranks = |p: usize| self.graph.of(sorted[p]).iter().map(|&b| rank[b as usize]);
            let graph = SortedGraph::new(n, |p| ranks(p).filter(|&rank| (rank as usize) < n));
            graph.separate(first..n - last)
        });
        let moved = parts.flatten().map(|parts| {
            let on = |part: Part, side: &[u32]| {
                let beyond = side.iter().filter(|&&a| rank[a as usize] == ON_SIDE);
                beyond
                    .chain(sorted.iter().zip(&parts).filter(|(_, p)| **p == part).map(|(a, _)| a))
                    .copied()
                    .collect()
            };
            Division {
                left: on(Part::First, left),
                right: on(Part::Last, right),
                separator: on(Part::Separator, &[]),
            }
        });
        [left, right, separator].into_iter().flatten().for_each(|&a| rank[a as usize] = OUTSIDE);
        moved
    }

    /// Layers of neighbours of the `separator` on a `side`: [`LAYERS`] unless they take more than a
    /// share of it, and one more, which stays on the side.
    fn layers(&self, separator: &[u32], side: &[u32], rank: &mut [u32]) -> Vec<Vec<u32>> {
        side.iter().for_each(|&a| rank[a as usize] = ON_SIDE);
        let (mut layers, mut taken): (Vec<Vec<u32>>, _) = (Vec::new(), 0);
        while layers.len() <= LAYERS && taken as f64 <= MOVABLE * side.len() as f64 {
            let mut layer = Vec::new();
            for &a in layers.last().map_or(separator, Vec::as_slice) {
                for &b in self.graph.of(a) {
                    if rank[b as usize] == ON_SIDE {
                        rank[b as usize] = IN_LAYER;
                        layer.push(b);
                    }
                }
            }
            taken += layer.len();
            layers.push(layer);
        }
        layers
    }

    /// Orders an undivided part so that elimination moves towards what is eliminated later: along
    /// each direction towards the side where nodes are coupled to the outside, the direction with
    /// the clearest such side last to change.
    ///
    /// A sweep that starts at the far side meets the separators late, and its fronts stay small
    /// until then.
    fn sweep(&mut self, nodes: &mut [u32]) {
        self.mark(nodes, nodes.len());
        let is_rim =
            |a: u32| self.graph.of(a).iter().any(|&b| b != a && self.side[b as usize] == Side::Outside);
        let rim: Vec<u32> = nodes.iter().copied().filter(|&a| is_rim(a)).collect();
        self.unmark(nodes);
        let mean = |set: &[u32], axis: usize| {
            set.iter().map(|&a| self.anchors[a as usize][axis]).sum::<f64>() / set.len().max(1) as f64
        };
        let bias: [f64; 3] =
            std::array::from_fn(
                |axis| {
                    if rim.is_empty() { 0.0 } else { mean(&rim, axis) - mean(nodes, axis) }
                },
            );
        let mut axes = [2, 1, 0];
        axes.sort_by(|&a, &b| bias[b].abs().total_cmp(&bias[a].abs()));
        let anchors = self.anchors;
        let key = |a: u32, axis: usize| {
            let place = anchors[a as usize][axis];
            if bias[axis] < 0.0 { -place } else { place }
        };
        nodes.sort_unstable_by(|&a, &b| {
            let along = |axis: &usize| key(a, *axis).total_cmp(&key(b, *axis));
            axes.iter().map(along).find(|o| o.is_ne()).unwrap_or_else(|| a.cmp(&b))
        });
    }

    /// The best cut between two different places.
    fn cut(&mut self, mut positions: Vec<(f64, u32)>) -> Option<Cut> {
        positions.sort_unstable_by(|p, q| p.0.total_cmp(&q.0).then(p.1.cmp(&q.1)));
        let n = positions.len();
        let extent = positions[n - 1].0 - positions[0].0;
        let sorted: Vec<u32> = positions.iter().map(|&(_, a)| a).collect();
        let (left, right) = self.separators(&sorted);
        let (mut best, mut lowest) = (None, f64::INFINITY);
        let smallest = (SMALLEST_SIDE * n as f64).ceil() as usize;
        for at in smallest.max(1)..=n.saturating_sub(smallest).min(n - 1) {
            if positions[at].0 - positions[at - 1].0 <= 1e-9 * extent {
                continue;
            }
            for (separator, from_left) in [(left[at], true), (right[at], false)] {
                let (a, b) = if from_left { (at - separator, n - at) } else { (at, n - at - separator) };
                let this = score(separator, a, b);
                if a > 0 && b > 0 && this < lowest {
                    (best, lowest) = (Some((at, from_left)), this);
                }
            }
        }
        best.map(|(at, from_left)| Cut { sorted, at, from_left })
    }

    /// Number of separator nodes for a cut in front of every position, on its left and on its
    /// right.
    fn separators(&mut self, sorted: &[u32]) -> (Vec<usize>, Vec<usize>) {
        for (p, &a) in sorted.iter().enumerate() {
            self.rank[a as usize] = p as u32;
        }
        let n = sorted.len();
        // A node is in the separator of all cuts between itself and its furthest neighbour: where
        // that begins and ends.
        let (mut left, mut right) = (vec![(0, 0); n + 2], vec![(0, 0); n + 2]);
        for (p, &a) in sorted.iter().enumerate() {
            let (mut lowest, mut highest) = (p, p);
            for &b in self.graph.of(a) {
                let rank = self.rank[b as usize];
                if rank != OUTSIDE {
                    lowest = lowest.min(rank as usize);
                    highest = highest.max(rank as usize);
                }
            }
            left[p + 1].0 += 1;
            left[highest + 1].1 += 1;
            right[lowest + 1].0 += 1;
            right[p + 1].1 += 1;
        }
        for &a in sorted {
            self.rank[a as usize] = OUTSIDE;
        }
        (running(&left), running(&right))
    }

    fn touches(&self, node: u32, own: Side, other: Side) -> bool {
        self.side[node as usize] == own && self.graph.of(node).iter().any(|&b| self.side[b as usize] == other)
    }

    fn mark(&mut self, sorted: &[u32], at: usize) {
        for (p, &a) in sorted.iter().enumerate() {
            self.side[a as usize] = if p < at { Side::Left } else { Side::Right };
        }
    }

    fn unmark(&mut self, nodes: &[u32]) {
        for &a in nodes {
            self.side[a as usize] = Side::Outside;
        }
    }

    /// Breadth-first level of every node, seen from a node at the rim of the graph; further pieces
    /// follow on.
    fn levels(&mut self, nodes: &[u32]) -> Vec<(f64, u32)> {
        let far = self.breadth_first(nodes, nodes[0]);
        let from = far.last().map_or(nodes[0], |&(_, a)| a);
        self.breadth_first(nodes, from)
    }

    fn breadth_first(&mut self, nodes: &[u32], from: u32) -> Vec<(f64, u32)> {
        self.mark(nodes, nodes.len());
        let mut found: Vec<(f64, u32)> = Vec::with_capacity(nodes.len());
        let mut level = 0.0;
        for &seed in std::iter::once(&from).chain(nodes) {
            if self.side[seed as usize] != Side::Left {
                continue;
            }
            let mut head = found.len();
            self.side[seed as usize] = Side::Right;
            found.push((level, seed));
            while head < found.len() {
                let (depth, a) = found[head];
                head += 1;
                level = depth + 1.0;
                for &b in self.graph.of(a) {
                    if self.side[b as usize] == Side::Left {
                        self.side[b as usize] = Side::Right;
                        found.push((level, b));
                    }
                }
            }
        }
        self.unmark(nodes);
        found
    }
}

/// How many intervals are open, given how many begin and end at every position.
fn running(changes: &[(usize, usize)]) -> Vec<usize> {
    let mut open = 0;
    let count = |&(begin, end): &(usize, usize)| {
        open = open + begin - end;
        open
    };
    changes.iter().map(count).collect()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::{NodeGraph, nested_dissection};

    #[test]
    fn a_mesh_graded_towards_what_comes_last_is_cut_around_it() {
        // Rings of 12 nodes, each half as far again from the middle as the one inside it; all nodes
        // of a ring are neighbours of each other's neighbours on it and of those beside them on the
        // next ones. Every straight line through the middle crosses all 40 rings twice.
        let (n_rings, n_around) = (40usize, 12usize);
        let number = |ring: usize, k: usize| (ring * n_around + k % n_around) as u32;
        let mut graph = NodeGraph { start: vec![0], neighbours: Vec::new() };
        let mut anchors = Vec::new();
        for ring in 0..n_rings {
            for k in 0..n_around {
                for beside in ring.saturating_sub(1)..(ring + 2).min(n_rings) {
                    graph.neighbours.extend([n_around - 1, 0, 1].map(|d| number(beside, k + d)));
                }
                graph.start.push(graph.neighbours.len());
                let (angle, radius) = (TAU * k as f64 / n_around as f64, 1.5_f64.powi(ring as i32));
                anchors.push([radius * angle.cos(), radius * angle.sin(), 0.0]);
            }
        }
        let last: Vec<u32> = (0..n_around).map(|k| number(0, k)).collect();
        let mut nodes: Vec<u32> = (number(1, 0)..number(n_rings, 0)).collect();
        nested_dissection(&graph, &anchors, &last, &mut nodes);
        // What is eliminated at the end is one ring.
        let ring = |node: u32| node as usize / n_around;
        let end = &nodes[nodes.len() - n_around..];
        assert!(end.iter().all(|&a| ring(a) == ring(end[0])), "{end:?}");
        assert!((10..30).contains(&ring(end[0])), "{end:?}");
    }
}
