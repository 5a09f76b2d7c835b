//! Elimination by a front that passes over a set of nodes (Eq. R.1; King 1970).
//!
//! The front are the nodes that are coupled to an eliminated one and not yet eliminated themselves.
//! It begins as far as possible from the border, the nodes outside that are eliminated later, and
//! what it meets of the border stays with it. Always the node of the front is eliminated that brings
//! the fewest new ones, of equal ones that which was met first. A column of the factor is the front at
//! its elimination, so that order and cost are found together.

/// What an elimination costs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Cost {
    /// Sum of the squares of the columns.
    pub work: f64,
    /// Entries of the factor.
    pub entries: f64,
}

impl Cost {
    /// More than any.
    pub const INFINITE: Self = Self { work: f64::INFINITY, entries: f64::INFINITY };

    /// Of `n` nodes all coupled to each other and to `border` more, which stay.
    pub fn full(n: usize, border: usize) -> Self {
        let mut cost = Self { work: 0.0, entries: 0.0 };
        (border + 1..=border + n).for_each(|column| cost.add(column));
        cost
    }

    /// Adds the elimination of a column.
    fn add(&mut self, column: usize) {
        self.work += (column as f64).powi(2);
        self.entries += column as f64;
    }

    /// Whether neither exceeds that of `other`.
    pub fn is_within(&self, other: &Self) -> bool {
        self.work <= other.work && self.entries <= other.entries
    }
}

impl std::ops::Add for Cost {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self { work: self.work + other.work, entries: self.entries + other.entries }
    }
}

/// A set of nodes, numbered first, and its border behind them.
#[derive(Debug, Clone)]
pub(super) struct Bordered {
    n_inner: usize,
    start: Vec<usize>,
    neighbours: Vec<u32>,
}

impl Bordered {
    /// The graph in which `rows` are the neighbours of one node after the other; of two neighbours
    /// each names the other.
    pub fn new<I: Iterator<Item = u32>>(n_inner: usize, rows: impl Iterator<Item = I>) -> Self {
        let (mut start, mut neighbours) = (vec![0], Vec::new());
        for row in rows {
            neighbours.extend(row);
            start.push(neighbours.len());
        }
        Self { n_inner, start, neighbours }
    }

    fn len(&self) -> usize {
        self.start.len() - 1
    }

    fn of(&self, node: u32) -> &[u32] {
        &self.neighbours[self.start[node as usize]..self.start[node as usize + 1]]
    }

    fn is_inner(&self, node: u32) -> bool {
        (node as usize) < self.n_inner
    }

    /// The inner nodes, those nearest to the border first; without border seen from a node that is
    /// as far as possible from another one. Pieces without connection follow each other.
    fn nearest_first(&self) -> Vec<u32> {
        let border: Vec<u32> = (self.n_inner as u32..self.len() as u32).collect();
        let mut found = self.breadth_first(&border);
        if border.is_empty() {
            let end: Vec<u32> = found.last().copied().into_iter().collect();
            found = self.breadth_first(&end);
        }
        found.retain(|&a| self.is_inner(a));
        found
    }

    fn breadth_first(&self, from: &[u32]) -> Vec<u32> {
        let mut found = from.to_vec();
        let mut is_found = vec![false; self.len()];
        found.iter().for_each(|&a| is_found[a as usize] = true);
        let mut head = 0;
        for seed in 0..self.n_inner as u32 {
            while let Some(&a) = found.get(head) {
                head += 1;
                for &b in self.of(a) {
                    if !std::mem::replace(&mut is_found[b as usize], true) {
                        found.push(b);
                    }
                }
            }
            if !std::mem::replace(&mut is_found[seed as usize], true) {
                found.push(seed);
            }
        }
        found
    }

    /// The inner nodes in the order in which a front eliminates them, and what that costs; `None` if
    /// it costs more than `limit`, or clearly will.
    pub fn by_front(&self, limit: &Cost) -> Option<(Vec<u32>, Cost)> {
        let mut starts = self.nearest_first();
        let mut front = Front::new(self);
        let mut order = Vec::with_capacity(self.n_inner);
        let mut is_eliminated = vec![false; self.n_inner];
        let mut cost = Cost::full(0, 0);
        while order.len() < self.n_inner {
            let Some(node) = front.take() else {
                // A piece is done; the next one has its own part of the border.
                front.forget_border();
                let start = starts.pop()?;
                if !is_eliminated[start as usize] {
                    front.meet(start);
                }
                continue;
            };
            front.meet_neighbours(node);
            is_eliminated[node as usize] = true;
            order.push(node);
            let column = 1 + front.nodes.len() + front.border.len();
            cost.add(column);
            // Half a column for each of the rest: a front that has grown wide shrinks at its end only.
            let rest = (self.n_inner - order.len()) as f64;
            let column = 0.5 * column as f64;
            let at_least = Cost { work: rest * column * column, entries: rest * column };
            if order.len() % 16 == 0 && !(cost + at_least).is_within(limit) {
                return None;
            }
        }
        cost.is_within(limit).then_some((order, cost))
    }
}

struct Front<'a> {
    graph: &'a Bordered,
    /// Inner nodes in the order in which they were met.
    nodes: Vec<u32>,
    border: Vec<u32>,
    is_met: Vec<bool>,
    /// Neighbours of every node that have not been met.
    n_new: Vec<u32>,
}

impl<'a> Front<'a> {
    fn new(graph: &'a Bordered) -> Self {
        let n_new = (0..graph.len() as u32).map(|a| graph.of(a).len() as u32).collect();
        Self { graph, nodes: Vec::new(), border: Vec::new(), is_met: vec![false; graph.len()], n_new }
    }

    fn meet(&mut self, node: u32) {
        self.is_met[node as usize] = true;
        for &a in self.graph.of(node) {
            self.n_new[a as usize] -= 1;
        }
        if self.graph.is_inner(node) { &mut self.nodes } else { &mut self.border }.push(node);
    }

    fn meet_neighbours(&mut self, node: u32) {
        let graph = self.graph;
        for &a in graph.of(node) {
            if !self.is_met[a as usize] {
                self.meet(a);
            }
        }
    }

    /// Takes out the node that brings the fewest new ones, the first of them.
    fn take(&mut self) -> Option<u32> {
        let (mut at, mut fewest) = (0, u32::MAX);
        for (k, &node) in self.nodes.iter().enumerate() {
            let n_new = self.n_new[node as usize];
            if n_new < fewest {
                (at, fewest) = (k, n_new);
                if n_new == 0 {
                    break;
                }
            }
        }
        (fewest < u32::MAX).then(|| self.nodes.remove(at))
    }

    fn forget_border(&mut self) {
        for node in std::mem::take(&mut self.border) {
            self.is_met[node as usize] = false;
            for &a in self.graph.of(node) {
                self.n_new[a as usize] += 1;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Bordered, Cost};

    #[test]
    fn a_front_on_a_strip_goes_towards_the_border_and_is_as_wide_as_the_strip() {
        // 30 columns of 3 nodes, each coupled to all of its column and of those beside it, the last
        // column the border.
        let beside = |a: u32| {
            let column = a / 3;
            (3 * column.saturating_sub(1)..(3 * column + 6).min(90)).filter(move |&b| b != a)
        };
        let graph = Bordered::new(87, (0..90).map(beside));
        let (order, cost) = graph.by_front(&Cost::INFINITE).unwrap();
        assert!(order.windows(2).all(|pair| pair[0] / 3 <= pair[1] / 3), "{order:?}");
        // A column of the factor: the rest of the strip's column and the next one.
        assert_eq!(cost, Cost { work: 29.0 * (36.0 + 25.0 + 16.0), entries: 29.0 * 15.0 });
        assert_eq!(graph.by_front(&Cost { entries: 434.0, ..cost }), None);
    }

    #[test]
    fn pieces_meet_their_own_borders() {
        // Two chains of three nodes, each with one node of the border: 0-1-2-6, 3-4-5-7.
        let rows: [&[u32]; 8] = [&[1], &[0, 2], &[1, 6], &[4], &[3, 5], &[4, 7], &[2], &[5]];
        let graph = Bordered::new(6, rows.iter().map(|row| row.iter().copied()));
        let (order, cost) = graph.by_front(&Cost::INFINITE).unwrap();
        assert!(order == [0, 1, 2, 3, 4, 5] || order == [3, 4, 5, 0, 1, 2], "{order:?}");
        assert_eq!(cost, Cost { work: 24.0, entries: 12.0 });
    }
}
