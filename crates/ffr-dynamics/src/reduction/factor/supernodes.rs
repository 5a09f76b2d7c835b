//! Elimination tree and supernodes of a Cholesky factor (Eq. R.4; Liu 1990).
//!
//! Columns with the same rows below them form a supernode: a dense block. Small supernodes are
//! merged with their parents where that adds few zeros (Ashcraft and Grimes 1989).

use std::collections::BinaryHeap;

use super::quotient::Quotient;

/// No parent.
pub(super) const NONE: u32 = u32::MAX;
/// Supernodes up to so many columns may hold this share of zeros after a merger.
const RELAXED: [(u64, f64); 4] = [(4, 1.0), (16, 0.8), (48, 0.1), (u64::MAX, 0.05)];

/// Supernodes in postorder: every subtree is a range of them, and of the columns.
#[derive(Debug)]
pub(in crate::reduction) struct Supernodes {
    /// Elimination order: position p holds the p-th unknown.
    pub order: Vec<u32>,
    /// First column of each supernode, and the number of columns.
    pub first: Vec<u32>,
    /// Parent of each supernode, or [`NONE`].
    pub parent: Vec<u32>,
    pattern_start: Vec<usize>,
    pattern: Vec<u32>,
}

impl Supernodes {
    /// Supernodes of the factor of a matrix under the elimination order of `quotient`, which was
    /// made with `order`; the order becomes an equivalent one, with the same fill and the same
    /// unknowns last.
    pub fn new(quotient: &Quotient, order: &[u32]) -> Self {
        let tree = elimination_tree(quotient);
        let post = postorder(&tree);
        let mut blocks = Blocks::fundamental(quotient, &post);
        blocks.merge();
        blocks.number(quotient, order)
    }

    /// Number of supernodes.
    pub fn len(&self) -> usize {
        self.parent.len()
    }

    /// Columns of supernode `s`.
    pub fn columns(&self, s: usize) -> std::ops::Range<usize> {
        self.first[s] as usize..self.first[s + 1] as usize
    }

    /// Rows below the columns of supernode `s`, ascending.
    pub fn pattern(&self, s: usize) -> &[u32] {
        &self.pattern[self.pattern_range(s)]
    }

    /// Where [`Self::pattern`] stands among the patterns of all supernodes.
    pub fn pattern_range(&self, s: usize) -> std::ops::Range<usize> {
        self.pattern_start[s]..self.pattern_start[s + 1]
    }
}

/// Parent of every vertex in the elimination tree (Liu's algorithm with compressed paths).
fn elimination_tree(quotient: &Quotient) -> Vec<u32> {
    let n = quotient.len();
    let (mut parent, mut ancestor) = (vec![NONE; n], vec![NONE; n]);
    for v in 0..n {
        for &w in quotient.neighbours(v) {
            let mut w = w as usize;
            while w < v {
                let next = std::mem::replace(&mut ancestor[w], v as u32);
                if next == NONE {
                    parent[w] = v as u32;
                    break;
                }
                w = next as usize;
            }
        }
    }
    parent
}

/// Vertices of a forest in postorder, children and roots in ascending order: what is at the end as
/// a chain stays there.
fn postorder(parent: &[u32]) -> Vec<u32> {
    let n = parent.len();
    // Lists of children, the first at the head.
    let (mut head, mut next) = (vec![NONE; n + 1], vec![NONE; n]);
    for v in (0..n).rev() {
        let slot = if parent[v] == NONE { n } else { parent[v] as usize };
        next[v] = std::mem::replace(&mut head[slot], v as u32);
    }
    let mut order = Vec::with_capacity(n);
    let mut path = Vec::new();
    let mut at = head[n];
    loop {
        if at != NONE {
            path.push(at);
            at = head[at as usize];
            continue;
        }
        let Some(done) = path.pop() else { return order };
        order.push(done);
        at = next[done as usize];
    }
}

/// A supernode while they are formed; vertices are in postorder.
#[derive(Debug)]
struct Block {
    /// First vertex and end of those that it was formed of.
    vertices: (u32, u32),
    /// Vertices below, ascending; the first `skipped` have become its own.
    pattern: Vec<u32>,
    skipped: usize,
    /// Columns, rows below, zeros among the entries.
    width: u64,
    below: u64,
    zeros: u64,
    parent: u32,
    /// Whether it holds unknowns that must stay last.
    is_tail: bool,
    /// Blocks merged with it, in the order of their columns; the block itself comes behind them.
    merged: Vec<u32>,
    is_merged: bool,
}

impl Block {
    fn pattern(&self) -> &[u32] {
        &self.pattern[self.skipped..]
    }
}

struct Blocks {
    blocks: Vec<Block>,
    /// Vertex of the quotient at every place of the postorder.
    post: Vec<u32>,
    weight: Vec<u64>,
}

impl Blocks {
    /// Fundamental supernodes: chains of vertices with one child each whose patterns follow from
    /// each other.
    fn fundamental(quotient: &Quotient, post: &[u32]) -> Self {
        let n = post.len();
        let mut rank = vec![0; n];
        post.iter().enumerate().for_each(|(p, &v)| rank[v as usize] = p as u32);
        let weight: Vec<u64> = post.iter().map(|&v| u64::from(quotient.weight(v as usize))).collect();
        let mut blocks: Vec<Block> = Vec::new();
        // Blocks whose pattern begins with a vertex, and the block in whose pattern a vertex was
        // seen last.
        let mut children: Vec<Vec<u32>> = vec![Vec::new(); n];
        let mut seen = vec![NONE; n];
        for v in 0..n {
            let below: Vec<u32> =
                quotient.neighbours(post[v] as usize).iter().map(|&w| rank[w as usize]).collect();
            let below = || below.iter().copied().filter(|&w| w as usize > v);
            let from = std::mem::take(&mut children[v]);
            let continued = match from[..] {
                [c] if blocks[c as usize].vertices.1 as usize == v
                    && below().all(|w| seen[w as usize] == c) =>
                {
                    Some(c)
                }
                _ => None,
            };
            let at = continued.unwrap_or(blocks.len() as u32);
            if continued.is_some() {
                let block = &mut blocks[at as usize];
                block.vertices.1 += 1;
                block.skipped += 1;
            } else {
                let mut pattern = Vec::new();
                let inherited = from.iter().flat_map(|&c| blocks[c as usize].pattern()[1..].iter().copied());
                for w in inherited.chain(below()) {
                    if std::mem::replace(&mut seen[w as usize], at) != at {
                        pattern.push(w);
                    }
                }
                pattern.sort_unstable();
                let vertices = (v as u32, v as u32 + 1);
                blocks.push(Block {
                    vertices,
                    pattern,
                    skipped: 0,
                    width: 0,
                    below: 0,
                    zeros: 0,
                    parent: NONE,
                    is_tail: false,
                    merged: Vec::new(),
                    is_merged: false,
                });
            }
            let block = &mut blocks[at as usize];
            block.width += weight[v];
            block.is_tail |= post[v] as usize >= quotient.tail;
            if let Some(&next) = block.pattern().first() {
                children[next as usize].push(at);
            }
        }
        let mut block_of = vec![0; n];
        for (b, block) in blocks.iter().enumerate() {
            block_of[block.vertices.0 as usize..block.vertices.1 as usize].fill(b as u32);
        }
        for block in &mut blocks {
            block.below = block.pattern().iter().map(|&w| weight[w as usize]).sum();
            block.parent = block.pattern().first().map_or(NONE, |&w| block_of[w as usize]);
        }
        Self { blocks, post: post.to_vec(), weight }
    }

    /// Merges blocks with their parents where few zeros are added.
    fn merge(&mut self) {
        let n = self.blocks.len();
        let mut children: Vec<Vec<u32>> = vec![Vec::new(); n];
        for b in 0..n {
            // Those with the longest patterns fit best; of equal ones the last, which may stand
            // next to the parent.
            let key = |blocks: &[Block], c: u32| (blocks[c as usize].below, c);
            let mut candidates: BinaryHeap<(u64, u32)> =
                std::mem::take(&mut children[b]).into_iter().map(|c| key(&self.blocks, c)).collect();
            let mut kept = Vec::new();
            while let Some((_, c)) = candidates.pop() {
                match self.zeros_with(b, c as usize) {
                    Some(zeros) => {
                        let child = &mut self.blocks[c as usize];
                        child.is_merged = true;
                        let (width, mut columns) = (child.width, std::mem::take(&mut child.merged));
                        columns.push(c);
                        let parent = &mut self.blocks[b];
                        columns.append(&mut parent.merged);
                        parent.merged = columns;
                        parent.width += width;
                        parent.zeros = zeros;
                        let more = std::mem::take(&mut children[c as usize]);
                        candidates.extend(more.into_iter().map(|c| key(&self.blocks, c)));
                    }
                    None => kept.push(c),
                }
            }
            for &c in &kept {
                self.blocks[c as usize].parent = b as u32;
            }
            children[b] = kept;
            if self.blocks[b].parent != NONE {
                children[self.blocks[b].parent as usize].push(b as u32);
            }
        }
    }

    /// Zeros of the block that parent `b` and child `c` would form, if they are few.
    fn zeros_with(&self, b: usize, c: usize) -> Option<u64> {
        let (parent, child) = (&self.blocks[b], &self.blocks[c]);
        if parent.is_tail && !child.is_tail {
            return None;
        }
        let width = parent.width + child.width;
        let zeros = parent.zeros + child.zeros + child.width * (parent.width + parent.below - child.below);
        let entries = width * (width + 1) / 2 + width * parent.below;
        let is_allowed =
            |&(limit, share): &(u64, f64)| width <= limit && zeros as f64 <= share * entries as f64;
        RELAXED.iter().any(is_allowed).then_some(zeros)
    }

    /// Numbers blocks in postorder and unknowns with them.
    fn number(self, quotient: &Quotient, order: &[u32]) -> Supernodes {
        let kept: Vec<u32> =
            (0..self.blocks.len() as u32).filter(|&b| !self.blocks[b as usize].is_merged).collect();
        let mut number = vec![NONE; self.blocks.len()];
        kept.iter().enumerate().for_each(|(k, &b)| number[b as usize] = k as u32);
        let parents: Vec<u32> = kept
            .iter()
            .map(|&b| match self.blocks[b as usize].parent {
                NONE => NONE,
                p => number[p as usize],
            })
            .collect();
        let post = postorder(&parents);
        let mut rank = vec![0; post.len()];
        post.iter().enumerate().for_each(|(p, &k)| rank[k as usize] = p as u32);
        let mut new_order = Vec::with_capacity(order.len());
        let mut first = vec![0];
        // Where each vertex (of the postorder) begins now.
        let mut place = vec![0; self.post.len()];
        for &k in &post {
            let block = &self.blocks[kept[k as usize] as usize];
            for &m in block.merged.iter().chain([&kept[k as usize]]) {
                let (begin, end) = self.blocks[m as usize].vertices;
                for v in begin..end {
                    place[v as usize] = new_order.len() as u32;
                    let vertex = self.post[v as usize] as usize;
                    let positions = quotient.first[vertex] as usize..quotient.first[vertex + 1] as usize;
                    new_order.extend_from_slice(&order[positions]);
                }
            }
            first.push(new_order.len() as u32);
        }
        let (mut pattern_start, mut pattern) = (vec![0], Vec::new());
        for &k in &post {
            let mut rows: Vec<(u32, u32)> = self.blocks[kept[k as usize] as usize]
                .pattern()
                .iter()
                .map(|&v| (place[v as usize], self.weight[v as usize] as u32))
                .collect();
            rows.sort_unstable();
            pattern.extend(rows.iter().flat_map(|&(at, weight)| at..at + weight));
            pattern_start.push(pattern.len());
        }
        let parent = post
            .iter()
            .map(|&k| match parents[k as usize] {
                NONE => NONE,
                p => rank[p as usize],
            })
            .collect();
        Supernodes { order: new_order, first, parent, pattern_start, pattern }
    }
}
