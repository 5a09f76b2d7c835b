//! Matrices of raw functions and what combinations of them make of these (theory Eq. H.10).

use faer::sparse::{SparseColMat, SymbolicSparseColMat};
use rayon::prelude::*;

use super::batches::{Contribution, Source, n_parts};
use super::element::ElementProducts;
use super::pattern::{Connectivity, NodePattern};
use crate::SplineError;
use crate::elasticity::{Material, MaterialField, Model};
use crate::space::Combination;

/// Mark of what no column has touched yet.
const NONE: u32 = u32::MAX;

/// Stiffness and mass of the raw functions of a combination: for every pair `B` numbers, the block
/// of the stiffness column by column and the mass.
pub(super) struct Combined<'a, const B: usize> {
    pattern: NodePattern,
    blocks: Vec<[f64; B]>,
    /// `B`, a column for each raw function.
    by_raw: &'a SparseColMat<u32, f64>,
    /// `B^T`, a column for each function.
    by_function: SparseColMat<u32, f64>,
}

/// Sums of one column, by raw function and by function.
pub(super) struct Sums<const B: usize> {
    raw: Touched<B>,
    combined: Touched<B>,
}

/// Sums that are zero where the column at hand has not touched them.
struct Touched<const B: usize> {
    sums: Vec<[f64; B]>,
    column: Vec<u32>,
    list: Vec<u32>,
}

/// Materials of some of the elements.
struct Chosen<'a> {
    all: &'a dyn MaterialField,
    elements: &'a [usize],
}

impl MaterialField for Chosen<'_> {
    fn on(&self, e: usize) -> &Material {
        self.all.on(self.elements[e])
    }
}

impl<'a, const B: usize> Combined<'a, B> {
    /// Assembles the matrices of the raw functions; `law` makes blocks `K_AB` from Lamé's constants
    /// and gradient products.
    pub fn new<const G: usize, const D: usize>(
        combination: &'a Combination<'_>,
        model: &Model,
        materials: &dyn MaterialField,
        law: impl Fn(f64, f64, &[[f64; G]; G]) -> [[f64; D]; D] + Copy + Sync,
    ) -> Result<Self, SplineError> {
        let raw = &*combination.raw;
        let connectivity = Connectivity::new(raw);
        let pattern = NodePattern::whole(&connectivity, raw.n_functions())?;
        let mut blocks = vec![[0.0; B]; pattern.rows.len()];
        let elements: Vec<usize> = (0..raw.n_elements()).collect();
        let materials = &Chosen { all: materials, elements: &combination.elements };
        let source =
            Source { space: raw, connectivity: &connectivity, model, materials, elements: &elements };
        let mut tables = vec![vec![0; raw.n_functions()]; n_parts()];
        source.for_each_batch(|slots, contributions| {
            let (mut tasks, mut rest, mut at) = (Vec::new(), &mut blocks[..], 0);
            for own in contributions.chunk_by(|a, b| a.node == b.node) {
                let node = own[0].node as usize;
                let [from, to] = [node, node + 1].map(|n| pattern.start[n] as usize);
                let (column, tail) = std::mem::take(&mut rest)[from - at..].split_at_mut(to - from);
                tasks.push((node, column, own));
                (rest, at) = (tail, to);
            }
            let size = tasks.len().div_ceil(tables.len()).max(1);
            tasks.par_chunks_mut(size).zip(&mut tables).for_each(|(tasks, table)| {
                for (node, column, contributions) in tasks {
                    for (position, &row) in pattern.column(*node).iter().enumerate() {
                        table[row as usize] = position;
                    }
                    for &Contribution { slot, own, .. } in *contributions {
                        add_column(&slots[slot as usize], own as usize, table, column, law);
                    }
                }
            });
        })?;
        let by_raw = &combination.coefficients;
        let by_function = transposed(by_raw);
        Ok(Self { pattern, blocks, by_raw, by_function })
    }

    /// Room for the sums of a column.
    pub fn sums(&self) -> Sums<B> {
        Sums { raw: Touched::new(self.by_raw.ncols()), combined: Touched::new(self.by_raw.nrows()) }
    }

    /// Column `own` of `B K B^T` from its diagonal down: `K B^T e`, then `B` times it.
    pub fn sum_column(&self, own: usize, sums: &mut Sums<B>) {
        let Sums { raw, combined } = sums;
        raw.start();
        combined.start();
        for (m, c) in entries(&self.by_function, own) {
            let blocks = &self.blocks[self.pattern.start[m] as usize..];
            for (&row, block) in self.pattern.column(m).iter().zip(blocks) {
                raw.add(row, own as u32, c, block);
            }
        }
        for &m in &raw.list {
            let sum = &raw.sums[m as usize];
            let (rows, values) = column(self.by_raw, m as usize);
            let first = rows.partition_point(|&a| (a as usize) < own);
            for (&a, &c) in rows[first..].iter().zip(&values[first..]) {
                combined.add(a, own as u32, c, sum);
            }
        }
    }

    /// Calls `take` for the functions that share elements with function `own`, from it on, with the
    /// sums.
    pub fn for_each_row(&self, sums: &Sums<B>, mut take: impl FnMut(usize, &[f64; B])) {
        for &a in &sums.combined.list {
            take(a as usize, &sums.combined.sums[a as usize]);
        }
    }
}

impl<const B: usize> Touched<B> {
    fn new(n: usize) -> Self {
        Self { sums: vec![[0.0; B]; n], column: vec![NONE; n], list: Vec::new() }
    }

    /// Forgets what has been touched.
    fn start(&mut self) {
        self.list.clear();
    }

    /// Adds `c` times `block` to the sum at `at`, for column `column`.
    #[inline]
    fn add(&mut self, at: u32, column: u32, c: f64, block: &[f64; B]) {
        let sum = &mut self.sums[at as usize];
        if self.column[at as usize] != column {
            self.column[at as usize] = column;
            self.list.push(at);
            *sum = block.map(|b| c * b);
        } else {
            sum.iter_mut().zip(block).for_each(|(s, b)| *s += c * b);
        }
    }
}

/// Adds the blocks of an element to the column of the function at its place `own`; `position` tells
/// where each row is in it.
fn add_column<const G: usize, const D: usize, const B: usize>(
    element: &ElementProducts,
    own: usize,
    position: &[usize],
    column: &mut [[f64; B]],
    law: impl Fn(f64, f64, &[[f64; G]; G]) -> [[f64; D]; D] + Copy + Sync,
) {
    let n = element.nodes.len();
    let (lambda, mu, density) = element.constants;
    // Products are there for pairs A >= B: those above are the transposed ones.
    let product = |a: usize, i: usize, b: usize, j: usize| element.gradients[G * n * (G * b + j) + G * a + i];
    for (a, &node) in element.nodes.iter().enumerate() {
        let h = std::array::from_fn(|i| {
            std::array::from_fn(|j| if a >= own { product(a, i, own, j) } else { product(own, j, a, i) })
        });
        let block = law(lambda, mu, &h);
        let sum = &mut column[position[node as usize]];
        for (i, row) in block.iter().enumerate() {
            for (j, value) in row.iter().enumerate() {
                sum[D * j + i] += value;
            }
        }
        sum[B - 1] += density * element.values[n * a.min(own) + a.max(own)];
    }
}

/// Rows and values of a column.
fn column(matrix: &SparseColMat<u32, f64>, j: usize) -> (&[u32], &[f64]) {
    let range = matrix.symbolic().col_range(j);
    (&matrix.symbolic().row_idx()[range.clone()], &matrix.val()[range])
}

/// Rows with the values of a column.
fn entries(matrix: &SparseColMat<u32, f64>, j: usize) -> impl Iterator<Item = (usize, f64)> {
    let (rows, values) = column(matrix, j);
    rows.iter().map(|&r| r as usize).zip(values.iter().copied())
}

/// The transposed matrix.
fn transposed(matrix: &SparseColMat<u32, f64>) -> SparseColMat<u32, f64> {
    let mut starts = vec![0u32; matrix.nrows() + 1];
    matrix.symbolic().row_idx().iter().for_each(|&r| starts[r as usize + 1] += 1);
    for r in 0..matrix.nrows() {
        starts[r + 1] += starts[r];
    }
    let mut next = starts.clone();
    let n = matrix.val().len();
    let (mut rows, mut values) = (vec![0; n], vec![0.0; n]);
    for j in 0..matrix.ncols() {
        for (r, value) in entries(matrix, j) {
            let at = next[r] as usize;
            (rows[at], values[at]) = (j as u32, value);
            next[r] += 1;
        }
    }
    let symbolic = SymbolicSparseColMat::new_checked(matrix.ncols(), matrix.nrows(), starts, None, rows);
    SparseColMat::new(symbolic, values)
}
