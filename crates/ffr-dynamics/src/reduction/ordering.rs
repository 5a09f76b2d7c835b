//! Geometric nested dissection (Eq. R.1; George 1973): the elimination order of the sparse factorisation.
//!
//! The graph of the nodes is cut where the anchors say, every direction is tried and the one with the smallest separator
//! taken; a separator is eliminated after both its sides. Nodes without distinct places (all anchors equal) are cut along
//! breadth-first levels, so that any graph gets an order. Cost O(nnz log n).

use faer::sparse::SymbolicSparseColMatRef;

use crate::body::Dof;

/// Sets of at most this many nodes are not cut any further.
const LEAF: usize = 32;
/// A side must hold at least this part of the nodes: a cheap but lopsided cut only adds depth.
const SMALLEST_SIDE: f64 = 0.2;

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

    fn of(&self, node: u32) -> &[u32] {
        &self.neighbours[self.start[node as usize]..self.start[node as usize + 1]]
    }
}

/// Elimination order of the unknowns: position p of the result holds the unknown that is eliminated as p-th.
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
    nested_dissection(&graph, anchors, &mut nodes);
    let mut order: Vec<u32> = nodes.iter().flat_map(|&a| unknowns[a as usize].iter().copied()).collect();
    order.extend(last.iter().map(|&i| i as u32));
    order
}

/// Puts `nodes` (a subset of the graph's, no repeats) into a nested-dissection order.
pub fn nested_dissection(graph: &NodeGraph, anchors: &[[f64; 3]], nodes: &mut [u32]) {
    let mut cutter = Cutter { graph, anchors, side: vec![Side::Outside; anchors.len()] };
    cutter.dissect(nodes);
}

#[derive(Clone, Copy, PartialEq)]
enum Side {
    Outside,
    Left,
    Right,
    Separator,
}

struct Cutter<'a> {
    graph: &'a NodeGraph,
    anchors: &'a [[f64; 3]],
    side: Vec<Side>,
}

/// A way to cut: the nodes sorted along it, and where.
struct Cut {
    sorted: Vec<u32>,
    at: usize,
    separator: usize,
    from_left: bool,
}

impl Cutter<'_> {
    fn dissect(&mut self, nodes: &mut [u32]) {
        let best = if nodes.len() > LEAF { self.best_cut(nodes) } else { None };
        let Some(cut) = best else {
            self.sweep(nodes);
            return;
        };
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
        let mut parts = on(Side::Left);
        let n_left = parts.len();
        parts.extend(on(Side::Right));
        self.unmark(&cut.sorted);
        nodes[..parts.len()].copy_from_slice(&parts);
        nodes[parts.len()..].copy_from_slice(&separator);
        let (sides, separator) = nodes.split_at_mut(parts.len());
        let (left, right) = sides.split_at_mut(n_left);
        self.dissect(left);
        self.dissect(right);
        separator.sort_unstable();
    }

    /// Orders an undivided part so that elimination moves towards what is eliminated later: along each direction towards the
    /// side where nodes are coupled to the outside, the direction with the clearest such side last to change.
    ///
    /// A sweep that starts at the far side meets the separators late, and its fronts stay small until then.
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

    /// The cut with the smallest separator of the coordinate directions; breadth-first levels where there is no direction.
    fn best_cut(&mut self, nodes: &[u32]) -> Option<Cut> {
        let mut best: Option<Cut> = None;
        for axis in 0..3 {
            let places = nodes.iter().map(|&a| (self.anchors[a as usize][axis], a)).collect();
            let cut = self.cut(places);
            if let Some(cut) = cut
                && best.as_ref().is_none_or(|b| cut.separator < b.separator)
            {
                best = Some(cut);
            }
        }
        if best.is_none() {
            let places = self.levels(nodes);
            best = self.cut(places);
        }
        // A separator of most nodes splits nothing off: the graph is as good as full.
        best.filter(|cut| 3 * cut.separator < nodes.len())
    }

    /// Cuts between two different places as near to the median as possible.
    fn cut(&mut self, mut places: Vec<(f64, u32)>) -> Option<Cut> {
        places.sort_unstable_by(|p, q| p.0.total_cmp(&q.0).then(p.1.cmp(&q.1)));
        let n = places.len();
        let extent = places[n - 1].0 - places[0].0;
        let differ = |at: usize| places[at].0 - places[at - 1].0 > 1e-9 * extent;
        let at = (1..n).filter(|&at| differ(at)).min_by_key(|&at| at.abs_diff(n / 2))?;
        if (at.min(n - at) as f64) < SMALLEST_SIDE * n as f64 {
            return None;
        }
        let sorted: Vec<u32> = places.into_iter().map(|(_, a)| a).collect();
        self.mark(&sorted, at);
        let left = sorted[..at].iter().filter(|&&a| self.touches(a, Side::Left, Side::Right)).count();
        let right = sorted[at..].iter().filter(|&&a| self.touches(a, Side::Right, Side::Left)).count();
        self.unmark(&sorted);
        Some(Cut { sorted, at, separator: left.min(right), from_left: left <= right })
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

    /// Breadth-first level of every node, seen from a node at the rim of the graph; further pieces follow on.
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
