//! Which nodes share an element.

use super::element::ElementMatrices;
use crate::fault::MeshFault;
use crate::mesh::Mesh;
use crate::ties::Ties;

/// The free nodes that each element moves with.
pub struct Connectivity {
    starts: Vec<usize>,
    nodes: Vec<u32>,
}

impl Connectivity {
    /// That of `mesh`, some of whose nodes follow others.
    pub fn new(mesh: &Mesh, ties: &Ties) -> Self {
        let (mut starts, mut nodes) = (vec![0], Vec::new());
        for element in mesh.elements().iter() {
            let begin = nodes.len();
            for &node in element.nodes {
                match ties.of(node) {
                    None => nodes.push(node),
                    Some(list) => nodes.extend(list.iter().map(|(free, _)| *free)),
                }
            }
            if element.nodes.iter().any(|&n| ties.is_tied(n)) {
                nodes[begin..].sort_unstable();
                let mut kept = begin;
                for i in begin..nodes.len() {
                    if i == begin || nodes[i] != nodes[kept - 1] {
                        nodes[kept] = nodes[i];
                        kept += 1;
                    }
                }
                nodes.truncate(kept);
            }
            starts.push(nodes.len());
        }
        Self { starts, nodes }
    }

    /// Nodes of element `e`.
    pub fn of(&self, e: usize) -> &[u32] {
        &self.nodes[self.starts[e]..self.starts[e + 1]]
    }

    fn n_elements(&self) -> usize {
        self.starts.len() - 1
    }
}

/// Lower triangle of the node-by-node pattern in compressed columns; every column begins with its diagonal entry.
pub struct NodePattern {
    starts: Vec<u32>,
    rows: Vec<u32>,
}

impl NodePattern {
    /// That of `n` nodes.
    ///
    /// # Errors
    /// [`MeshFault::TooLarge`] if the entries of the stiffness matrix do not fit 32-bit indices.
    pub fn new(n: usize, elements: &Connectivity) -> Result<Self, MeshFault> {
        let mut first = vec![0usize; n + 1];
        elements.nodes.iter().for_each(|&a| first[a as usize + 1] += 1);
        (0..n).for_each(|i| first[i + 1] += first[i]);
        let (mut next, mut owners) = (first.clone(), vec![0u32; first[n]]);
        for e in 0..elements.n_elements() {
            for &a in elements.of(e) {
                owners[next[a as usize]] = e as u32;
                next[a as usize] += 1;
            }
        }
        let (mut starts, mut rows) = (vec![0u32], Vec::new());
        let mut mark = vec![u32::MAX; n];
        for column in 0..n as u32 {
            let begin = rows.len();
            for &e in &owners[first[column as usize]..first[column as usize + 1]] {
                for &row in elements.of(e as usize) {
                    if row >= column && std::mem::replace(&mut mark[row as usize], column) != column {
                        rows.push(row);
                    }
                }
            }
            rows[begin..].sort_unstable();
            let entries = 9 * rows.len();
            if entries > u32::MAX as usize {
                return Err(MeshFault::TooLarge { entries });
            }
            starts.push(rows.len() as u32);
        }
        Ok(Self { starts, rows })
    }

    pub fn n_mass(&self) -> usize {
        self.rows.len()
    }

    /// Nine entries a pair of nodes, six of a node with itself.
    pub fn n_stiffness(&self) -> usize {
        9 * self.rows.len() - 3 * (self.starts.len() - 1)
    }

    /// Where the entries of direction `c` of node `column` begin: the columns of earlier nodes hold nine entries per row but three, those of
    /// earlier directions three per row but `0, 1`.
    fn column_start(&self, column: usize, c: usize) -> usize {
        let (begin, end) = (self.starts[column] as usize, self.starts[column + 1] as usize);
        let before = 9 * begin - 3 * column;
        before + (0..c).map(|d| 3 * (end - begin) - d).sum::<usize>()
    }

    /// Adds the matrices of an element with the given nodes.
    pub fn add(&self, nodes: &[u32], element: &ElementMatrices, stiffness: &mut [f64], mass: &mut [f64]) {
        let n = nodes.len();
        for (b, &column) in nodes.iter().enumerate() {
            let range = self.starts[column as usize] as usize..self.starts[column as usize + 1] as usize;
            let rows = &self.rows[range.clone()];
            let starts: [usize; 3] = std::array::from_fn(|c| self.column_start(column as usize, c));
            for (a, &row) in nodes.iter().enumerate().filter(|(_, row)| **row >= column) {
                // Every pair of nodes of an element is in the pattern.
                let Ok(at) = rows.binary_search(&row) else { continue };
                mass[range.start + at] += element.mass[n * b + a];
                let block = &element.stiffness[9 * (n * b + a)..][..9];
                for c in 0..3 {
                    for r in (if at == 0 { c } else { 0 })..3 {
                        stiffness[starts[c] + 3 * at + r - c] += block[3 * c + r];
                    }
                }
            }
        }
    }

    /// Columns and rows of the pattern unknown by unknown.
    pub fn unknowns(&self) -> (Vec<u32>, Vec<u32>) {
        let (mut columns, mut rows) = (vec![0u32], Vec::with_capacity(self.n_stiffness()));
        for column in 0..self.starts.len() - 1 {
            let own = &self.rows[self.starts[column] as usize..self.starts[column + 1] as usize];
            for c in 0..3u32 {
                rows.extend(own.iter().flat_map(|row| (0..3).map(move |r| 3 * row + r)).skip(c as usize));
                columns.push(rows.len() as u32);
            }
        }
        (columns, rows)
    }

    /// Columns and rows of the pattern node by node.
    pub fn into_nodes(self) -> (Vec<u32>, Vec<u32>) {
        (self.starts, self.rows)
    }
}
