//! Nodes that follow others.

use std::collections::BTreeMap;

/// Nodes whose displacement is a weighted sum of those of other nodes. Free nodes come first; those behind them are tied to free ones.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Ties {
    n_free: usize,
    lists: Vec<Vec<(u32, f64)>>,
}

impl Ties {
    /// `n_free` free nodes, behind which those of `lists` follow, each with the free nodes that it is tied to and their weights.
    pub fn new(n_free: usize, lists: Vec<Vec<(u32, f64)>>) -> Self {
        Self { n_free, lists }
    }

    /// Number of free nodes.
    pub fn n_free(&self) -> usize {
        self.n_free
    }

    /// The free nodes that `node` follows, with their weights; none of a free node.
    pub fn of(&self, node: u32) -> Option<&[(u32, f64)]> {
        let tied = (node as usize).checked_sub(self.n_free)?;
        self.lists.get(tied).map(Vec::as_slice)
    }

    /// Whether `node` follows others.
    pub fn is_tied(&self, node: u32) -> bool {
        node as usize >= self.n_free
    }

    /// A sum over `nodes` with the weights `values` in terms of free nodes, rising where one of them is tied.
    pub fn in_free(&self, nodes: &[u32], values: &[f64]) -> Vec<(u32, f64)> {
        let pairs = || nodes.iter().copied().zip(values.iter().copied());
        if nodes.iter().all(|&n| !self.is_tied(n)) {
            return pairs().collect();
        }
        let mut sum: BTreeMap<u32, f64> = BTreeMap::new();
        for (node, value) in pairs() {
            match self.of(node) {
                None => *sum.entry(node).or_default() += value,
                Some(list) => list.iter().for_each(|(m, w)| *sum.entry(*m).or_default() += value * w),
            }
        }
        sum.into_iter().collect()
    }
}
