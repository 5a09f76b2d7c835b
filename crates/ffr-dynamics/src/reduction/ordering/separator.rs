//! Smallest sets of nodes that separate two ends of a graph (Menger 1927; Even and Tarjan 1975;
//! Eq. R.2).
//!
//! As many paths as the graph has room for are led from one end to the other, no two of them
//! through the same node, by augmentation along shortest ways. Where nothing more passes, one node
//! of every path is full: these separate the ends, and no smaller set does.
//!
//! Neighbours are rows of bits, so that one step of a search looks at 64 of them: points of a
//! spline have some hundred neighbours, most of them found already. Words without a bit are left out: neighbours in a
//! mesh that is divided about a contact stand far apart along a direction.

use std::ops::Range;

/// No node.
const NONE: u32 = u32::MAX;

/// A graph whose nodes stand in an order, by which its ends are named.
#[derive(Debug, Clone)]
pub(super) struct SortedGraph {
    /// Where in `words` the row of every node stands.
    start: Vec<usize>,
    /// Number and bits of the words of [`Bits`] with neighbours, and with the node itself, in ascending order.
    words: Vec<(u32, u64)>,
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
    /// The graph in which `neighbours` of a node, in any order, are those named; of two neighbours
    /// each names the other.
    pub fn new<I: Iterator<Item = u32>>(n: usize, neighbours: impl Fn(usize) -> I) -> Self {
        let mut graph = Self { start: vec![0], words: Vec::new() };
        let mut row = Vec::new();
        for node in 0..n {
            row.clear();
            row.extend(neighbours(node).chain([node as u32]));
            row.sort_unstable();
            let start = graph.words.len();
            for &j in &row {
                match graph.words[start..].last_mut() {
                    Some((word, bits)) if *word == j / 64 => *bits |= 1 << (j % 64),
                    _ => graph.words.push((j / 64, 1 << (j % 64))),
                }
            }
            graph.start.push(graph.words.len());
        }
        graph
    }

    fn len(&self) -> usize {
        self.start.len() - 1
    }

    /// The neighbours of a node and itself: number and bits of every word.
    fn row(&self, node: usize) -> impl Iterator<Item = (usize, u64)> {
        self.words[self.start[node]..self.start[node + 1]].iter().map(|&(word, bits)| (word as usize, bits))
    }

    /// The last neighbour of a node.
    fn last_of(&self, node: usize) -> usize {
        let (word, bits) = self.words[self.start[node + 1] - 1];
        64 * word as usize + 63 - bits.leading_zeros() as usize
    }

    /// The smallest set of the nodes `between` that separates the nodes before from those behind;
    /// of two such sets, the one nearest to the first and the one nearest to the last nodes, that
    /// which leaves the more even parts. `None` if a node before has a neighbour behind.
    pub fn separate(&self, between: Range<usize>) -> Option<Vec<Part>> {
        if (0..between.start).any(|i| self.last_of(i) >= between.end) {
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

/// A set of nodes.
#[derive(Debug, Clone)]
struct Bits(Vec<u64>);

impl Bits {
    fn of(nodes: Range<usize>, n: usize) -> Self {
        let mut bits = Self(vec![0; n.div_ceil(64)]);
        nodes.for_each(|i| bits.insert(i));
        bits
    }

    fn has(&self, node: usize) -> bool {
        self.0[node / 64] >> (node % 64) & 1 == 1
    }

    fn insert(&mut self, node: usize) {
        self.0[node / 64] |= 1 << (node % 64);
    }

    /// Takes a node out; whether it was in.
    fn take(&mut self, node: usize) -> bool {
        let was_in = self.has(node);
        self.0[node / 64] &= !(1 << (node % 64));
        was_in
    }

    /// Takes out all nodes of a row, and hands them on.
    fn take_all(&mut self, row: impl Iterator<Item = (usize, u64)>, mut with: impl FnMut(usize)) {
        for (word, bits) in row {
            let mut found = bits & self.0[word];
            self.0[word] ^= found;
            while found != 0 {
                with(64 * word + found.trailing_zeros() as usize);
                found &= found - 1;
            }
        }
    }

    /// Takes out the first node of a row that is in.
    fn take_first(&mut self, mut row: impl Iterator<Item = (usize, u64)>) -> Option<usize> {
        let (word, found) = row.find_map(|(word, bits)| {
            let found = bits & self.0[word];
            (found != 0).then_some((word, found))
        })?;
        let node = 64 * word + found.trailing_zeros() as usize;
        self.take(node);
        Some(node)
    }
}

/// Paths from the first nodes to the last ones.
///
/// A path arrives at a node, and it leaves it; a node between the ends lets one path through. One
/// more path may take back a piece of an earlier one: where it arrives at a used node, it goes back
/// to the node before that, and leaves this one, or goes further back. So arrivals and departures
/// alternate, and each departure follows one arrival only.
struct Flow<'a> {
    graph: &'a SortedGraph,
    between: Range<usize>,
    /// The nodes before and behind every node on its path.
    previous: Vec<u32>,
    next: Vec<u32>,
    /// Nodes at which one more path can arrive after so many departures, at most those of the
    /// shortest way, and where it has not yet been tried.
    levels: Vec<Bits>,
    /// Departures of the shortest way from the first to the last nodes.
    length: usize,
    /// Nodes at which no path can arrive, or which none can leave, once no way is left.
    no_arrival: Bits,
    no_departure: Bits,
}

impl<'a> Flow<'a> {
    fn new(graph: &'a SortedGraph, between: Range<usize>) -> Self {
        let n = graph.len();
        let all = Bits::of(between.clone(), n);
        Self {
            graph,
            between,
            previous: vec![NONE; n],
            next: vec![NONE; n],
            levels: Vec::new(),
            length: 0,
            no_arrival: all.clone(),
            no_departure: all,
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

    /// The node that is left next after arrival at `node`: itself, or the one before on the path
    /// that is taken back.
    fn departure(&self, node: usize) -> Option<usize> {
        if !self.is_used(node) {
            return Some(node);
        }
        let before = self.previous[node] as usize;
        (!self.is_first(before)).then_some(before)
    }

    /// Breadth-first levels; whether one more path is possible.
    fn find_levels(&mut self) -> bool {
        let n = self.graph.len();
        let mut no_arrival = Bits::of(self.between.clone(), n);
        let mut no_departure = no_arrival.clone();
        self.levels.clear();
        let mut departures: Vec<usize> = (0..self.between.start).collect();
        while !departures.is_empty() {
            if departures.iter().any(|&node| self.is_last(self.graph.last_of(node))) {
                self.length = self.levels.len();
                return true;
            }
            let mut level = Bits::of(0..0, n);
            let mut following = Vec::new();
            for node in departures {
                no_arrival.take_all(self.graph.row(node), |to| {
                    level.insert(to);
                    if let Some(from) = self.departure(to)
                        && no_departure.take(from)
                    {
                        following.push(from);
                    }
                });
            }
            self.levels.push(level);
            departures = following;
        }
        (self.no_arrival, self.no_departure) = (no_arrival, no_departure);
        false
    }

    /// Leads as many paths as possible along shortest ways.
    fn augment(&mut self) {
        let mut path = Vec::new();
        for first in 0..self.between.start {
            while let Some(last) = self.shortest_path(first, &mut path) {
                self.lead(first, &path, last);
            }
        }
    }

    /// The nodes at which a shortest way from the node `first` arrives, one after the other, into
    /// `path`; the last node where it ends.
    fn shortest_path(&mut self, first: usize, path: &mut Vec<usize>) -> Option<usize> {
        path.clear();
        loop {
            let from = match path.last() {
                Some(&node) => self.departure(node),
                None => Some(first),
            };
            if let Some(from) = from {
                if path.len() == self.length {
                    let last = self.graph.last_of(from);
                    if self.is_last(last) {
                        return Some(last);
                    }
                } else if let Some(to) = self.levels[path.len()].take_first(self.graph.row(from)) {
                    path.push(to);
                    continue;
                }
            }
            // Nothing goes on from here.
            path.pop()?;
        }
    }

    /// Leads one more path from the node `first` over the arrivals of `path` to the node `last`.
    fn lead(&mut self, first: usize, path: &[usize], last: usize) {
        // Pieces that are taken back are free before the new ones take what they need.
        let departures: Vec<usize> = path.iter().filter_map(|&node| self.departure(node)).collect();
        for (&node, &from) in path.iter().zip(&departures) {
            if node != from {
                self.next[from] = NONE;
                self.previous[node] = NONE;
            }
        }
        let ends = path.iter().copied().chain([last]);
        for (from, to) in [first].into_iter().chain(departures).zip(ends) {
            if from == to {
                continue;
            }
            if !self.is_first(from) {
                self.next[from] = to as u32;
            }
            if !self.is_last(to) {
                self.previous[to] = from as u32;
            }
        }
    }

    /// The parts if the separator is the full nodes that one more path would reach first; the
    /// search is the last one, which has found no way.
    fn parts_near_first(&self) -> Vec<Part> {
        self.parts(|node| match (self.no_arrival.has(node), self.no_departure.has(node)) {
            (_, false) => Part::First,
            (false, true) => Part::Separator,
            (true, true) => Part::Last,
        })
    }

    /// The parts if the separator is the full nodes from which one more path would reach the last
    /// nodes.
    fn parts_near_last(&self) -> Vec<Part> {
        // The ways of `find_levels` backwards.
        let all = Bits::of(self.between.clone(), self.graph.len());
        let (mut no_arrival, mut no_departure) = (all.clone(), all);
        let mut arrivals: Vec<usize> = (self.between.end..self.graph.len()).collect();
        while let Some(node) = arrivals.pop() {
            no_departure.take_all(self.graph.row(node), |from| {
                let arrival = if self.is_used(from) { self.next[from] as usize } else { from };
                if !self.is_last(arrival) && no_arrival.take(arrival) {
                    arrivals.push(arrival);
                }
            });
        }
        self.parts(|node| match (no_arrival.has(node), no_departure.has(node)) {
            (false, _) => Part::Last,
            (true, false) => Part::Separator,
            (true, true) => Part::First,
        })
    }

    fn parts(&self, part: impl Fn(usize) -> Part) -> Vec<Part> {
        let of = |node: usize| match (self.is_first(node), self.is_last(node)) {
            (true, _) => Part::First,
            (_, true) => Part::Last,
            _ => part(node),
        };
        (0..self.graph.len()).map(of).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::{Part, SortedGraph};

    /// The graph of the edges `is_edge(i, j)`, `i < j`.
    fn graph(n: usize, is_edge: impl Fn(usize, usize) -> bool) -> SortedGraph {
        SortedGraph::new(n, |i| {
            let is_edge = &is_edge;
            (0..n).filter(move |&j| i != j && is_edge(i.min(j), i.max(j))).map(|j| j as u32)
        })
    }

    fn neighbours(graph: &SortedGraph, node: usize) -> Vec<usize> {
        let of_word = |(word, bits): (usize, u64)| {
            (0..64).filter(move |b| bits >> b & 1 == 1).map(move |b| 64 * word + b)
        };
        graph.row(node).flat_map(of_word).collect()
    }

    fn check_divides(graph: &SortedGraph, parts: &[Part]) {
        for i in (0..parts.len()).filter(|&i| parts[i] == Part::First) {
            assert!(neighbours(graph, i).iter().all(|&j| parts[j] != Part::Last), "{i}");
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
            for j in neighbours(graph, i) {
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
                assert!((0..2).any(|i| neighbours(&graph, i).iter().any(|&j| j >= n - 2)));
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
            let smallest = smallest.map(|n| n as usize);
            assert_eq!(Some(n_between(&parts)), smallest, "case {case}");
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
            neighbours(graph, i).into_iter().filter(|&j| j != i).for_each(|j| capacity[2 * i + 1][2 * j] = n);
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
