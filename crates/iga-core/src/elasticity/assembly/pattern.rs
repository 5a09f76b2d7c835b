//! Sparsity pattern of a space, node by node, and the numbering of unknowns.

use rayon::prelude::*;

use crate::SplineError;
use crate::elasticity::Model;
use crate::space::Space;

/// Functions of every element, as one list.
pub(crate) struct Connectivity {
    start: Vec<usize>,
    functions: Vec<u32>,
}

impl Connectivity {
    pub fn new(space: &dyn Space) -> Self {
        let (mut start, mut functions, mut active) = (vec![0], Vec::new(), Vec::new());
        for e in 0..space.n_elements() {
            space.active_functions(e, &mut active);
            functions.extend_from_slice(&active);
            start.push(functions.len());
        }
        Self { start, functions }
    }

    pub fn functions(&self, e: usize) -> &[u32] {
        &self.functions[self.start[e]..self.start[e + 1]]
    }

    fn n_elements(&self) -> usize {
        self.start.len() - 1
    }

    /// Elements of every function, rising.
    fn transposed(&self, n_functions: usize) -> Self {
        let mut start = vec![0; n_functions + 1];
        for &f in &self.functions {
            start[f as usize + 1] += 1;
        }
        for i in 0..n_functions {
            start[i + 1] += start[i];
        }
        let (mut next, mut elements) = (start.clone(), vec![0; self.functions.len()]);
        for e in 0..self.n_elements() {
            for &f in self.functions(e) {
                elements[next[f as usize]] = e as u32;
                next[f as usize] += 1;
            }
        }
        Self { start, functions: elements }
    }
}

/// The node-by-node pattern or its lower triangle, in compressed columns, rows rising; a column of
/// the triangle holds its diagonal entry first.
pub(crate) struct NodePattern {
    pub start: Vec<u32>,
    pub rows: Vec<u32>,
}

/// Columns that one task of the pattern works off.
const COLUMNS_PER_TASK: usize = 256;

impl NodePattern {
    /// The lower triangle.
    ///
    /// # Errors
    /// [`SplineError::TooLarge`] if the entries do not fit 32-bit indices.
    pub fn new(connectivity: &Connectivity, n_nodes: usize) -> Result<Self, SplineError> {
        Self::of(connectivity, n_nodes, |column| column)
    }

    /// The whole pattern.
    ///
    /// # Errors
    /// As [`NodePattern::new`].
    pub fn whole(connectivity: &Connectivity, n_nodes: usize) -> Result<Self, SplineError> {
        Self::of(connectivity, n_nodes, |_| 0)
    }

    /// Rows from `first` of each column on.
    fn of(
        connectivity: &Connectivity,
        n_nodes: usize,
        first: fn(usize) -> usize,
    ) -> Result<Self, SplineError> {
        let elements = connectivity.transposed(n_nodes);
        let n_tasks = n_nodes.div_ceil(COLUMNS_PER_TASK);
        let parts: Vec<(Vec<u32>, Vec<u32>)> = (0..n_tasks)
            .into_par_iter()
            .map_init(
                || vec![u32::MAX; n_nodes],
                |marks, t| {
                    let columns = t * COLUMNS_PER_TASK..((t + 1) * COLUMNS_PER_TASK).min(n_nodes);
                    columns_of(connectivity, &elements, (columns, first), marks)
                },
            )
            .collect();
        let total = parts.iter().map(|(_, rows)| rows.len()).sum();
        index(total)?;
        let (mut start, mut rows) = (vec![0u32], Vec::with_capacity(total));
        for (counts, part) in parts {
            for count in counts {
                start.push(start[start.len() - 1] + count);
            }
            rows.extend_from_slice(&part);
        }
        Ok(Self { start, rows })
    }

    pub fn column(&self, node: usize) -> &[u32] {
        &self.rows[self.start[node] as usize..self.start[node + 1] as usize]
    }
}

/// Entry counts and row lists, from the row `first` on, of a range of columns; `marks` holds for
/// every node the last column that took it.
fn columns_of(
    connectivity: &Connectivity,
    elements: &Connectivity,
    (columns, first): (std::ops::Range<usize>, fn(usize) -> usize),
    marks: &mut [u32],
) -> (Vec<u32>, Vec<u32>) {
    let (mut counts, mut rows) = (Vec::new(), Vec::new());
    for node in columns {
        let start = rows.len();
        for &e in elements.functions(node) {
            for &f in connectivity.functions(e as usize) {
                if f as usize >= first(node) && marks[f as usize] != node as u32 {
                    marks[f as usize] = node as u32;
                    rows.push(f);
                }
            }
        }
        rows[start..].sort_unstable();
        counts.push((rows.len() - start) as u32);
    }
    (counts, rows)
}

/// Numbering of unknowns: by node, then component, without the components held by the axis of
/// symmetry.
pub(crate) struct Unknowns {
    /// First unknown of each node; the last entry is the number of unknowns.
    pub start: Vec<u32>,
    /// First free component of each node: 1 on the axis of an axisymmetric model, 0 elsewhere.
    pub first_component: Vec<u8>,
}

/// Control points nearer to the axis than this part of the largest radius lie on it.
const AXIS_TOLERANCE: f64 = 1e-9;

impl Unknowns {
    pub fn new(model: &Model, nodes: &[[f64; 3]]) -> Self {
        let limit = AXIS_TOLERANCE * nodes.iter().fold(0.0f64, |m, x| m.max(x[0].abs()));
        let is_held = |x: &[f64; 3]| *model == Model::Axisymmetric && x[0].abs() <= limit;
        let first_component: Vec<u8> = nodes.iter().map(|x| u8::from(is_held(x))).collect();
        let mut start = vec![0];
        for first in &first_component {
            start.push(start[start.len() - 1] + model.dimension() as u32 - u32::from(*first));
        }
        Self { start, first_component }
    }

    pub fn count(&self, node: usize) -> u32 {
        self.start[node + 1] - self.start[node]
    }

    pub fn n_unknowns(&self) -> usize {
        self.start[self.start.len() - 1] as usize
    }

    /// Node and component of every unknown.
    pub fn table(&self) -> Vec<(u32, u8)> {
        let node = |n: usize| {
            let first = self.first_component[n];
            (first..first + self.count(n) as u8).map(move |c| (n as u32, c))
        };
        (0..self.first_component.len()).flat_map(node).collect()
    }
}

/// A count as 32-bit index.
///
/// # Errors
/// [`SplineError::TooLarge`] if it does not fit.
pub(crate) fn index(entries: usize) -> Result<u32, SplineError> {
    u32::try_from(entries).map_err(|_| SplineError::TooLarge { entries })
}
