//! Quotient graph of the unknowns: those with the same neighbours, as the displacement components
//! of a node, are one vertex.
//!
//! A tenth of the edges is left, and the analysis of the elimination costs as much less.

use faer::sparse::SymbolicSparseColMatRef;

/// Vertices in the order of their elimination, numbered from 0.
#[derive(Debug)]
pub(in crate::reduction) struct Quotient {
    /// First position of each vertex in the elimination order, and the number of unknowns.
    pub first: Vec<u32>,
    /// Vertices from this one on are eliminated last, one unknown each, each a neighbour of the
    /// next.
    pub tail: usize,
    start: Vec<usize>,
    neighbours: Vec<u32>,
}

impl Quotient {
    /// The quotient of the symmetric matrix with the lower triangle `pattern` under a permutation
    /// `order`, whose last `n_last` unknowns keep their places.
    pub fn new(pattern: SymbolicSparseColMatRef<'_, u32>, order: &[u32], n_last: usize) -> Self {
        let n = order.len();
        let is_twin = twins(pattern);
        let mut first: Vec<u32> = Vec::new();
        let mut vertex = vec![0; n];
        let mut tail = 0;
        for (p, &unknown) in order.iter().enumerate() {
            let joins =
                p > 0 && p < n - n_last && order[p - 1] + 1 == unknown && is_twin[order[p - 1] as usize];
            if p == n - n_last {
                tail = first.len();
            }
            if !joins {
                first.push(p as u32);
            }
            vertex[unknown as usize] = first.len() as u32 - 1;
        }
        if n_last == 0 {
            tail = first.len();
        }
        let n_vertices = first.len();
        first.push(n as u32);
        let mut edges: Vec<[u32; 2]> = Vec::new();
        let mut seen = vec![u32::MAX; n_vertices];
        for v in 0..n_vertices {
            let unknown = order[first[v] as usize] as usize;
            seen[v] = v as u32;
            for i in pattern.row_idx_of_col(unknown) {
                let w = vertex[i];
                if seen[w as usize] != v as u32 {
                    seen[w as usize] = v as u32;
                    edges.push([v as u32, w]);
                }
            }
        }
        // Nothing comes between two of the unknowns that are eliminated last.
        edges.extend((tail + 1..n_vertices).map(|v| [v as u32 - 1, v as u32]));
        let (start, neighbours) = both_ways(n_vertices, &edges);
        Self { first, tail, start, neighbours }
    }

    /// Number of vertices.
    pub fn len(&self) -> usize {
        self.start.len() - 1
    }

    /// Vertices that share a matrix entry with `vertex`; the last ones of all may stand here twice.
    pub fn neighbours(&self, vertex: usize) -> &[u32] {
        &self.neighbours[self.start[vertex]..self.start[vertex + 1]]
    }

    /// Number of unknowns of `vertex`.
    pub fn weight(&self, vertex: usize) -> u32 {
        self.first[vertex + 1] - self.first[vertex]
    }
}

/// Whether each unknown has, itself included, the same neighbours as the next one.
fn twins(pattern: SymbolicSparseColMatRef<'_, u32>) -> Vec<bool> {
    let n = pattern.ncols();
    let mut equal = vec![true; n];
    let mut column_of = vec![usize::MAX; n];
    for j in 0..n {
        let mut below = 0;
        for i in pattern.row_idx_of_col(j).filter(|&i| i > j) {
            column_of[i] = j;
            below += 1;
        }
        for i in pattern.row_idx_of_col(j).filter(|&i| i > j) {
            if i + 1 < n && column_of[i + 1] != j {
                equal[i] = false;
            }
            if i > j + 1 && column_of[i - 1] != j {
                equal[i - 1] = false;
            }
        }
        if j + 1 == n || column_of[j + 1] != j {
            equal[j] = false;
            continue;
        }
        let mut next = pattern.row_idx_of_col(j + 1).filter(|&i| i > j + 1);
        let mut count = 0;
        let is_subset = next.all(|i| {
            count += 1;
            column_of[i] == j
        });
        equal[j] &= is_subset && count + 1 == below;
    }
    equal
}

/// Neighbours of every vertex from a list of edges: where each begins, and all of them.
fn both_ways(n: usize, edges: &[[u32; 2]]) -> (Vec<usize>, Vec<u32>) {
    let mut start = vec![0; n + 1];
    for vertex in edges.iter().flatten() {
        start[*vertex as usize + 1] += 1;
    }
    for v in 0..n {
        start[v + 1] += start[v];
    }
    let mut next = start.clone();
    let mut neighbours = vec![0; start[n]];
    for &[a, b] in edges {
        for (from, to) in [(a, b), (b, a)] {
            neighbours[next[from as usize]] = to;
            next[from as usize] += 1;
        }
    }
    (start, neighbours)
}
