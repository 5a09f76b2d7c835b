//! Smallest sets of nodes that separate two ends of a graph (Menger 1927; Even and Tarjan 1975;
//! Eq. R.2).
//!
//! As many paths as the graph has room for are led from one end to the other, no two of them
//! through the same node, by augmentation along shortest ways. Where nothing more passes, one node
//! of every path is full: these separate the ends, and no smaller set does.

use std::ops::Range;

/// No node.
const NONE: u32 = u32::MAX;
/// Level of a place that no path reaches, or that has been tried without success.
const CLOSED: u32 = u32::MAX;

/// A graph whose nodes stand in an order, by which its ends are named;
/// `neighbours[start[i]..start[i + 1]]` are those of node `i`, which may name itself.
#[derive(Debug, Clone)]
pub(super) struct SortedGraph {
    pub start: Vec<usize>,
    pub neighbours: Vec<u32>,
}

/// Where a node stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Part {
    /// With the first nodes.
    First,
    /// With the last nodes.
    Last,
    /// Between them.
    Separator,
}

impl SortedGraph {
    fn len(&self) -> usize {
        self.start.len() - 1
    }

    fn of(&self, node: usize) -> &[u32] {
        &self.neighbours[self.start[node]..self.start[node + 1]]
    }

    /// The smallest set of the nodes `between` that separates the nodes before from those behind;
    /// of two such sets, the one nearest to the first and the one nearest to the last nodes, that
    /// which leaves the more even parts. `None` if a node before has a neighbour behind.
    pub fn separate(&self, between: Range<usize>) -> Option<Vec<Part>> {
        let is_open = |i: usize| self.of(i).iter().all(|&j| (j as usize) < between.end);
        if !(0..between.start).all(is_open) {
            return None;
        }
        let mut flow = Flow::new(self, between);
        while flow.find_levels() {
            flow.augment();
        }
        let (near_first, near_last) = (flow.parts_near_first(), flow.parts_near_last());
        Some(if smaller_part(&near_first) >= smaller_part(&near_last) { near_first } else { near_last })
    }
}

/// Nodes of the smaller part.
fn smaller_part(parts: &[Part]) -> usize {
    let count = |part: Part| parts.iter().filter(|&&p| p == part).count();
    count(Part::First).min(count(Part::Last))
}

/// A node as a path passes it: it arrives, and it leaves. A node between the ends lets one path
/// through.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Gate {
    Arrive(usize),
    Leave(usize),
}

impl Gate {
    fn index(self) -> usize {
        match self {
            Self::Arrive(node) => 2 * node,
            Self::Leave(node) => 2 * node + 1,
        }
    }
}

/// Paths from the first nodes to the last ones.
struct Flow<'a> {
    graph: &'a SortedGraph,
    between: Range<usize>,
    /// The nodes before and behind every node on its path.
    previous: Vec<u32>,
    next: Vec<u32>,
    /// Steps of the shortest way from the first nodes to every gate on which one more path can
    /// come.
    level: Vec<u32>,
    /// Steps of the shortest way to the last nodes.
    length: u32,
    /// Ways out of every gate that have been tried.
    tried: Vec<u32>,
}

impl<'a> Flow<'a> {
    fn new(graph: &'a SortedGraph, between: Range<usize>) -> Self {
        let n = graph.len();
        Self {
            graph,
            between,
            previous: vec![NONE; n],
            next: vec![NONE; n],
            level: vec![CLOSED; 2 * n],
            length: CLOSED,
            tried: vec![0; 2 * n],
        }
    }

    fn is_first(&self, node: usize) -> bool {
        node < self.between.start
    }

    fn is_last(&self, node: usize) -> bool {
        node >= self.between.end
    }

    fn is_used(&self, node: usize) -> bool {
        self.next[node] != NONE
    }

    /// The way numbered `k` on which one more path can go on from `gate`; `Some(None)` if this one
    /// leads nowhere, `None` behind the last.
    ///
    /// A new path may take back a piece of an earlier one: where it arrives at a used node, it goes
    /// back to the node before that.
    fn way(&self, gate: Gate, k: usize) -> Option<Option<Gate>> {
        match gate {
            Gate::Leave(node) => {
                let neighbours = self.graph.of(node);
                match neighbours.get(k) {
                    Some(&to) => {
                        let to = to as usize;
                        Some((to != node && !self.is_first(to)).then_some(Gate::Arrive(to)))
                    }
                    None if k > neighbours.len() => None,
                    None => Some((!self.is_first(node) && self.is_used(node)).then_some(Gate::Arrive(node))),
                }
            }
            Gate::Arrive(_) if k > 0 => None,
            Gate::Arrive(node) if !self.is_used(node) => Some(Some(Gate::Leave(node))),
            Gate::Arrive(node) => {
                let before = self.previous[node] as usize;
                Some((!self.is_first(before)).then_some(Gate::Leave(before)))
            }
        }
    }

    /// Breadth-first levels; whether one more path is possible.
    fn find_levels(&mut self) -> bool {
        self.level.fill(CLOSED);
        self.tried.fill(0);
        self.length = CLOSED;
        let mut queue: Vec<Gate> = (0..self.between.start).map(Gate::Leave).collect();
        for gate in &queue {
            self.level[gate.index()] = 0;
        }
        let mut head = 0;
        while let Some(&gate) = queue.get(head) {
            head += 1;
            let level = self.level[gate.index()] + 1;
            if level > self.length {
                break;
            }
            let mut k = 0;
            while let Some(way) = self.way(gate, k) {
                k += 1;
                match way {
                    Some(Gate::Arrive(node)) if self.is_last(node) => self.length = level,
                    Some(to) if self.level[to.index()] == CLOSED => {
                        self.level[to.index()] = level;
                        queue.push(to);
                    }
                    _ => {}
                }
            }
        }
        self.length != CLOSED
    }

    /// Leads as many paths as possible along shortest ways.
    fn augment(&mut self) {
        let mut path = Vec::new();
        for first in 0..self.between.start {
            while let Some(last) = self.shortest_path(first, &mut path) {
                self.lead(&path, last);
            }
        }
    }

    /// A shortest way from the node `first` into `path`, and the last node where it ends.
    fn shortest_path(&mut self, first: usize, path: &mut Vec<Gate>) -> Option<usize> {
        path.clear();
        path.push(Gate::Leave(first));
        while let Some(&gate) = path.last() {
            let level = if path.len() == 1 { 0 } else { self.level[gate.index()] };
            let k = self.tried[gate.index()] as usize;
            let Some(way) = self.way(gate, k) else {
                // Nothing goes on from here.
                self.level[gate.index()] = CLOSED;
                path.pop();
                continue;
            };
            self.tried[gate.index()] += 1;
            match way {
                Some(Gate::Arrive(node)) if self.is_last(node) && level + 1 == self.length => {
                    return Some(node);
                }
                Some(to) if self.level[to.index()] == level + 1 && level + 1 < self.length => path.push(to),
                _ => {}
            }
        }
        None
    }

    /// Leads one more path along `path` to the node `last`; its gates are closed until the next
    /// levels.
    fn lead(&mut self, path: &[Gate], last: usize) {
        for pair in path.windows(2) {
            if let [Gate::Arrive(node), Gate::Leave(before)] = pair
                && node != before
            {
                self.next[*before] = NONE;
                self.previous[*node] = NONE;
            }
        }
        let steps = path.windows(2).filter_map(|pair| match pair {
            [Gate::Leave(from), Gate::Arrive(to)] if from != to => Some((*from, *to)),
            _ => None,
        });
        let end = path.last().map(|gate| match gate {
            Gate::Arrive(node) | Gate::Leave(node) => (*node, last),
        });
        for (from, to) in steps.chain(end) {
            if !self.is_first(from) {
                self.next[from] = to as u32;
            }
            if !self.is_last(to) {
                self.previous[to] = from as u32;
            }
        }
        for gate in &path[1..] {
            self.level[gate.index()] = CLOSED;
        }
    }

    /// The parts if the separator is the full nodes that one more path would reach first; the
    /// levels are those of the last search.
    fn parts_near_first(&self) -> Vec<Part> {
        let is_reached = |gate: Gate| self.level[gate.index()] != CLOSED;
        let part = |node: usize| match (is_reached(Gate::Arrive(node)), is_reached(Gate::Leave(node))) {
            (_, true) => Part::First,
            (true, false) => Part::Separator,
            (false, false) => Part::Last,
        };
        self.parts(part)
    }

    /// The parts if the separator is the full nodes from which one more path would reach the last
    /// nodes.
    fn parts_near_last(&self) -> Vec<Part> {
        let reaches = self.reaching_last();
        let reaches = |gate: Gate| reaches[gate.index()];
        let part = |node: usize| match (reaches(Gate::Arrive(node)), reaches(Gate::Leave(node))) {
            (true, _) => Part::Last,
            (false, true) => Part::Separator,
            (false, false) => Part::First,
        };
        self.parts(part)
    }

    fn parts(&self, part: impl Fn(usize) -> Part) -> Vec<Part> {
        let of = |node: usize| match (self.is_first(node), self.is_last(node)) {
            (true, _) => Part::First,
            (_, true) => Part::Last,
            _ => part(node),
        };
        (0..self.graph.len()).map(of).collect()
    }

    /// Gates from which one more path would reach the last nodes: the ways of [`Self::way`]
    /// backwards.
    fn reaching_last(&self) -> Vec<bool> {
        let mut reaches = vec![false; self.level.len()];
        let mut queue: Vec<Gate> = (self.between.end..self.graph.len()).map(Gate::Arrive).collect();
        while let Some(gate) = queue.pop() {
            let mut add = |gate: Gate| {
                if !std::mem::replace(&mut reaches[gate.index()], true) {
                    queue.push(gate);
                }
            };
            match gate {
                Gate::Arrive(node) => {
                    let is_between = |&&from: &&u32| self.between.contains(&(from as usize));
                    let neighbours = self.graph.of(node).iter().filter(is_between);
                    neighbours
                        .filter(|&&from| from as usize != node)
                        .for_each(|&from| add(Gate::Leave(from as usize)));
                    if !self.is_last(node) && self.is_used(node) {
                        add(Gate::Leave(node));
                    }
                }
                Gate::Leave(node) if !self.is_used(node) => add(Gate::Arrive(node)),
                Gate::Leave(node) => {
                    let behind = self.next[node] as usize;
                    if !self.is_last(behind) {
                        add(Gate::Arrive(behind));
                    }
                }
            }
        }
        reaches
    }
}

#[cfg(test)]
mod tests {
    use super::{Part, SortedGraph};

    /// The graph of the edges `is_edge(i, j)`, `i < j`.
    fn graph(n: usize, is_edge: impl Fn(usize, usize) -> bool) -> SortedGraph {
        let mut graph = SortedGraph { start: vec![0], neighbours: Vec::new() };
        for i in 0..n {
            let is_neighbour = |&j: &usize| i == j || is_edge(i.min(j), i.max(j));
            graph.neighbours.extend((0..n).filter(is_neighbour).map(|j| j as u32));
            graph.start.push(graph.neighbours.len());
        }
        graph
    }

    fn check_divides(graph: &SortedGraph, parts: &[Part]) {
        for i in (0..parts.len()).filter(|&i| parts[i] == Part::First) {
            assert!(graph.of(i).iter().all(|&j| parts[j as usize] != Part::Last), "{i}");
        }
    }

    fn n_between(parts: &[Part]) -> usize {
        parts.iter().filter(|&&p| p == Part::Separator).count()
    }

    /// Whether the nodes `between` that are not in the set `removed` connect the first nodes with
    /// the last ones.
    fn is_connected(graph: &SortedGraph, between: &std::ops::Range<usize>, removed: u32) -> bool {
        let is_removed = |i: usize| between.contains(&i) && removed >> (i - between.start) & 1 == 1;
        let mut found: Vec<usize> = (0..between.start).collect();
        let mut seen: Vec<bool> = (0..graph.len()).map(|i| i < between.start).collect();
        while let Some(i) = found.pop() {
            for j in graph.of(i).iter().map(|&j| j as usize) {
                if !is_removed(j) && !std::mem::replace(&mut seen[j], true) {
                    found.push(j);
                }
            }
        }
        seen[between.end..].iter().any(|&s| s)
    }

    #[test]
    fn separators_of_random_graphs_divide_and_none_is_smaller() {
        let mut state = 1u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as f64 / (1u64 << 31) as f64
        };
        let (mut n_separated, mut n_together) = (0, 0);
        for case in 0..300 {
            let n = 8 + case % 9;
            let density = 0.1 + 0.4 * random();
            let edges: Vec<bool> = (0..n * n).map(|_| random() < density).collect();
            let graph = graph(n, |i, j| edges[i * n + j]);
            let between = 2..n - 2;
            let Some(parts) = graph.separate(between.clone()) else {
                assert!((0..2).any(|i| graph.of(i).iter().any(|&j| j as usize >= n - 2)));
                n_together += 1;
                continue;
            };
            n_separated += 1;
            check_divides(&graph, &parts);
            assert!((0..n).all(|i| between.contains(&i) || parts[i] != Part::Separator));
            let smallest = (0..1u32 << between.len())
                .filter(|&removed| !is_connected(&graph, &between, removed))
                .map(u32::count_ones)
                .min();
            assert_eq!(Some(n_between(&parts) as u32), smallest, "case {case}");
        }
        assert!(n_separated > 50 && n_together > 50, "{n_separated}, {n_together}");
    }

    /// Largest number of paths between the ends, one at a time by breadth-first search in a matrix
    /// of capacities.
    fn most_paths(graph: &SortedGraph, between: &std::ops::Range<usize>) -> usize {
        let n = graph.len();
        // Gates as in `Gate::index`, then a source and a sink.
        let mut capacity = vec![vec![0usize; 2 * n + 2]; 2 * n + 2];
        for i in 0..n {
            capacity[2 * i][2 * i + 1] = if between.contains(&i) { 1 } else { n };
            graph
                .of(i)
                .iter()
                .map(|&j| j as usize)
                .filter(|&j| j != i)
                .for_each(|j| capacity[2 * i + 1][2 * j] = n);
        }
        (0..between.start).for_each(|i| capacity[2 * n][2 * i] = n);
        (between.end..n).for_each(|i| capacity[2 * i + 1][2 * n + 1] = n);
        for paths in 0.. {
            let mut from = vec![usize::MAX; 2 * n + 2];
            let mut queue = vec![2 * n];
            let mut head = 0;
            while let Some(&a) = queue.get(head) {
                head += 1;
                for b in 0..2 * n + 2 {
                    if capacity[a][b] > 0 && from[b] == usize::MAX && b != 2 * n {
                        from[b] = a;
                        queue.push(b);
                    }
                }
            }
            if from[2 * n + 1] == usize::MAX {
                return paths;
            }
            let mut b = 2 * n + 1;
            while b != 2 * n {
                let a = from[b];
                capacity[a][b] -= 1;
                capacity[b][a] += 1;
                b = a;
            }
        }
        unreachable!("there are no more paths than nodes")
    }

    #[test]
    fn separators_of_larger_graphs_have_a_node_for_every_path() {
        let mut state = 7u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as f64 / (1u64 << 31) as f64
        };
        for case in 0..60 {
            // Points of a strip, numbered along it, neighbours up to a distance.
            let mut places: Vec<[f64; 2]> = (0..70).map(|_| [6.0 * random(), 2.0 * random()]).collect();
            places.sort_by(|p, q| p[0].total_cmp(&q[0]));
            let near = 0.45 + 0.3 * random();
            let distance = |i: usize, j: usize| {
                (0..2).map(|d| (places[i][d] - places[j][d]).powi(2)).sum::<f64>().sqrt()
            };
            let graph = graph(places.len(), |i, j| distance(i, j) < near);
            let between = 12..58;
            let parts =
                graph.separate(between.clone()).expect("the strip is longer than neighbours are apart");
            check_divides(&graph, &parts);
            assert_eq!(n_between(&parts), most_paths(&graph, &between), "case {case}");
        }
    }

    #[test]
    fn a_path_that_is_taken_back_over_two_nodes_leaves_the_one_between_them_free() {
        // The shortest path 0-3-4-5-19 is found first. The one from 1 arrives at 5 by a longer way,
        // goes back to 3 and leaves 4 free, which the longest one, from 2, needs.
        let chains: [&[usize]; 5] = [
            &[0, 3, 4, 5, 19],
            &[1, 6, 7, 5],
            &[3, 8, 9, 20],
            &[2, 10, 11, 12, 13, 4],
            &[4, 14, 15, 16, 17, 18, 21],
        ];
        let is_edge = |i: usize, j: usize| {
            chains.iter().any(|chain| chain.windows(2).any(|pair| pair == [i, j] || pair == [j, i]))
        };
        let graph = graph(22, is_edge);
        let parts = graph.separate(3..19).unwrap();
        check_divides(&graph, &parts);
        assert_eq!((n_between(&parts), most_paths(&graph, &(3..19))), (3, 3));
    }

    #[test]
    fn a_lattice_is_cut_at_its_waist() {
        // Points of a strip of 21 columns, 9 rows high but 3 at the waist, neighbours in all eight
        // directions, numbered by columns.
        let height = |x: usize| if x.abs_diff(13) < 2 { 3 } else { 9 };
        let places: Vec<(usize, usize)> = (0..21).flat_map(|x| (0..height(x)).map(move |y| (x, y))).collect();
        let is_edge = |i: usize, j: usize| {
            let ((a, b), (c, d)) = (places[i], places[j]);
            a.abs_diff(c) < 2 && b.abs_diff(d) < 2
        };
        let graph = graph(places.len(), is_edge);
        let parts = graph.separate(30..places.len() - 20).unwrap();
        check_divides(&graph, &parts);
        assert_eq!(n_between(&parts), 3);
    }
}
