//! Phase two: sums of the products of elements, column by column.

use faer::sparse::{SparseColMat, SymbolicSparseColMat};
use rayon::prelude::*;

use super::batches::{Contribution, Source, n_parts};
use super::combined::Combined;
use super::element::ElementProducts;
use super::mass;
use super::pattern::{Connectivity, NodePattern, Unknowns, index};
use super::stiffness::{NodeColumns, add_columns, axisymmetric_block, solid_block};
use crate::SplineError;
use crate::elasticity::{MaterialField, Model};
use crate::space::{Combination, Space};

/// Stiffness and mass of a free body (the axis of symmetry excepted).
#[derive(Debug, Clone)]
pub struct AssembledMatrices {
    /// Stiffness matrix `K`, lower triangle, unknown by unknown [N/m].
    pub stiffness: SparseColMat<u32, f64>,
    /// Consistent mass matrix `m_AB = ∫ ρ R_A R_B dV`, lower triangle, node by node, the same for
    /// every displacement component \[kg\].
    pub mass: SparseColMat<u32, f64>,
    /// Node and displacement component of every unknown, sorted by node, then component. Radial
    /// displacements of nodes on the axis of an axisymmetric model are zero and have no unknown.
    pub dofs: Vec<(u32, u8)>,
}

/// Assembles stiffness and mass of `model` on `space`, whose elements are of `materials` (theory
/// Eq. E.10 to E.12), on the threads of the current rayon pool.
///
/// The result does not depend on the number of threads, to the last bit.
///
/// # Errors
/// [`SplineError::Folded`] and [`SplineError::Radius`] for impossible geometry, [`SplineError::Dimension`] for an impossible
/// thickness, [`SplineError::TooLarge`] for more entries than 32-bit indices can name.
///
/// # Panics
/// If the space has another number of directions than the model.
pub fn assemble(
    space: &dyn Space,
    model: &Model,
    materials: &dyn MaterialField,
) -> Result<AssembledMatrices, SplineError> {
    assert_eq!(space.dimension(), model.dimension(), "parametric directions of space and model");
    model.validate()?;
    let connectivity = Connectivity::new(space);
    let pattern = NodePattern::new(&connectivity, space.n_functions())?;
    let unknowns = Unknowns::new(model, space.control_points());
    let (columns, rows) = scalar_pattern(&pattern, &unknowns)?;
    let mut target = Target {
        model,
        materials,
        stiffness: vec![0.0; rows.len()],
        mass: vec![0.0; pattern.rows.len()],
        columns,
        pattern,
        unknowns,
    };
    target.fill(space, &connectivity)?;
    let Target { stiffness, mass, columns, pattern, unknowns, .. } = target;
    let (n, n_nodes) = (unknowns.n_unknowns(), space.n_functions());
    let symbolic = SymbolicSparseColMat::new_checked(n, n, columns, None, rows);
    let nodal = SymbolicSparseColMat::new_checked(n_nodes, n_nodes, pattern.start, None, pattern.rows);
    Ok(AssembledMatrices {
        stiffness: SparseColMat::new(symbolic, stiffness),
        mass: SparseColMat::new(nodal, mass),
        dofs: unknowns.table(),
    })
}

/// Node and displacement component of every unknown that [`assemble`] would number for control
/// points `nodes`: its [`AssembledMatrices::dofs`] without the matrices.
pub fn unknowns(model: &Model, nodes: &[[f64; 3]]) -> Vec<(u32, u8)> {
    Unknowns::new(model, nodes).table()
}

/// Column starts and row indices of the lower triangle, unknown by unknown.
fn scalar_pattern(pattern: &NodePattern, unknowns: &Unknowns) -> Result<(Vec<u32>, Vec<u32>), SplineError> {
    let n_nodes = unknowns.first_component.len();
    let length =
        |node: usize| pattern.column(node).iter().map(|&r| unknowns.count(r as usize) as usize).sum();
    let mut total = 0;
    for node in 0..n_nodes {
        let (free, longest): (usize, usize) = (unknowns.count(node) as usize, length(node));
        total += free * longest - free * free.saturating_sub(1) / 2;
    }
    index(total)?;
    let (mut columns, mut rows) = (Vec::with_capacity(unknowns.n_unknowns() + 1), Vec::with_capacity(total));
    columns.push(0);
    for node in 0..n_nodes {
        let first = rows.len();
        for &row in pattern.column(node) {
            rows.extend(unknowns.start[row as usize]..unknowns.start[row as usize + 1]);
        }
        let longest = rows.len() - first;
        columns.push(rows.len() as u32);
        for skipped in 1..unknowns.count(node) as usize {
            rows.extend_from_within(first + skipped..first + longest);
            columns.push(rows.len() as u32);
        }
    }
    Ok((columns, rows))
}

/// The matrices under construction.
struct Target<'a> {
    model: &'a Model,
    materials: &'a dyn MaterialField,
    pattern: NodePattern,
    unknowns: Unknowns,
    columns: Vec<u32>,
    stiffness: Vec<f64>,
    mass: Vec<f64>,
}

/// One node's columns and what a phase adds to them: element products, or a combination of raw
/// ones.
struct ColumnTask<'a, T> {
    node: u32,
    stiffness: &'a mut [f64],
    mass: &'a mut [f64],
    added: T,
}

/// For every row node of the column at hand: its place in the node pattern and its first row in the
/// matrix.
#[derive(Clone)]
struct RowTable {
    position: Vec<u32>,
    offset: Vec<u32>,
}

impl Target<'_> {
    /// Adds the products of all elements: first of those that stand for themselves, then those of
    /// one combination after the other.
    fn fill(&mut self, space: &dyn Space, connectivity: &Connectivity) -> Result<(), SplineError> {
        let combinations = space.combinations();
        let mut stands_alone = vec![true; space.n_elements()];
        combinations.iter().flat_map(|c| &c.elements).for_each(|&e| stands_alone[e] = false);
        let elements: Vec<usize> = (0..space.n_elements()).filter(|&e| stands_alone[e]).collect();
        let zeros = vec![0; space.n_functions()];
        let mut tables = vec![RowTable { position: zeros.clone(), offset: zeros }; n_parts()];
        let (model, materials) = (self.model, self.materials);
        let source = Source { space, connectivity, model, materials, elements: &elements };
        source.for_each_batch(|slots, contributions| self.scatter(slots, contributions, &mut tables))?;
        for combination in &combinations {
            match model {
                Model::Solid => self.combine::<3, 3, 10>(combination, solid_block::<3>, &mut tables),
                Model::Axisymmetric => self.combine::<3, 2, 5>(combination, axisymmetric_block, &mut tables),
                _ => self.combine::<2, 2, 5>(combination, solid_block::<2>, &mut tables),
            }?;
        }
        Ok(())
    }

    /// Adds the products of a batch, column by column.
    fn scatter(
        &mut self,
        slots: &[ElementProducts],
        contributions: &[Contribution],
        tables: &mut [RowTable],
    ) {
        let model = self.model;
        let columns = contributions.chunk_by(|a, b| a.node == b.node).map(|c| (c[0].node, c));
        self.for_each_column(columns, tables, |task, table, pattern, unknowns| {
            table.load(task.node as usize, pattern, unknowns);
            for c in task.added {
                let (element, own) = (&slots[c.slot as usize], c.own as usize);
                let (lambda, mu, density) = element.constants;
                mass::add_column(element, own, density, &table.position, task.mass);
                let (offset, values) = (&table.offset[..], &mut *task.stiffness);
                match model {
                    Model::Solid => add_columns(element, own, unknowns, offset, values, |h| {
                        solid_block::<3>(lambda, mu, h)
                    }),
                    Model::Axisymmetric => add_columns(element, own, unknowns, offset, values, |h| {
                        axisymmetric_block(lambda, mu, h)
                    }),
                    _ => add_columns(element, own, unknowns, offset, values, |h| {
                        solid_block::<2>(lambda, mu, h)
                    }),
                }
            }
        });
    }

    /// Adds `B K B^T` of the raw matrices of a combination (theory Eq. H.10), column by column. `G`
    /// rows of gradients make `D` components of displacement, `B = D^2 + 1` numbers a pair of
    /// functions.
    fn combine<const G: usize, const D: usize, const B: usize>(
        &mut self,
        combination: &Combination<'_>,
        law: impl Fn(f64, f64, &[[f64; G]; G]) -> [[f64; D]; D] + Copy + Sync,
        tables: &mut [RowTable],
    ) -> Result<(), SplineError> {
        let combined = Combined::<B>::new(combination, self.model, self.materials, law)?;
        let columns = combination.functions.iter().enumerate().map(|(own, &node)| (node, own));
        let mut sums: Vec<_> = std::iter::repeat_with(|| combined.sums()).take(tables.len()).collect();
        let mut workers: Vec<_> = tables.iter_mut().zip(&mut sums).collect();
        self.for_each_column(columns, &mut workers, |task, (table, sums), pattern, unknowns| {
            table.load(task.node as usize, pattern, unknowns);
            combined.sum_column(task.added, sums);
            let mut columns = NodeColumns::<D>::new(task.stiffness, task.node, unknowns);
            combined.for_each_row(sums, |a, sum| {
                let row = combination.functions[a];
                let block = std::array::from_fn(|i| std::array::from_fn(|j| sum[D * j + i]));
                columns.add(row, table.offset[row as usize], &block);
                task.mass[table.position[row as usize] as usize] += sum[B - 1];
            });
        });
        Ok(())
    }

    /// Calls `add` for each of `columns`, which rise, with what is added to it, pattern and
    /// numbering; each of `workers` takes a part of the columns.
    fn for_each_column<T: Send, W: Send>(
        &mut self,
        columns: impl Iterator<Item = (u32, T)>,
        workers: &mut [W],
        add: impl Fn(&mut ColumnTask<'_, T>, &mut W, &NodePattern, &Unknowns) + Sync,
    ) {
        let (mut tasks, mut stiffness, mut mass) = (Vec::new(), &mut self.stiffness[..], &mut self.mass[..]);
        let (mut stiffness_at, mut mass_at) = (0, 0);
        for (node, added) in columns {
            let at = [node as usize, node as usize + 1];
            let unknowns = at.map(|n| self.columns[self.unknowns.start[n] as usize] as usize);
            let entries = at.map(|n| self.pattern.start[n] as usize);
            tasks.push(ColumnTask {
                node,
                stiffness: cut(&mut stiffness, &mut stiffness_at, unknowns),
                mass: cut(&mut mass, &mut mass_at, entries),
                added,
            });
        }
        let size = tasks.len().div_ceil(workers.len()).max(1);
        let (pattern, unknowns) = (&self.pattern, &self.unknowns);
        tasks.par_chunks_mut(size).zip(workers).for_each(|(tasks, worker)| {
            tasks.iter_mut().for_each(|task| add(task, worker, pattern, unknowns));
        });
    }
}

/// Cuts the range `from..to` out of a slice that starts at `at`, and moves the start behind it.
fn cut<'a>(rest: &mut &'a mut [f64], at: &mut usize, [from, to]: [usize; 2]) -> &'a mut [f64] {
    let (_, tail) = std::mem::take(rest).split_at_mut(from - *at);
    let (own, tail) = tail.split_at_mut(to - from);
    (*rest, *at) = (tail, to);
    own
}

impl RowTable {
    fn load(&mut self, node: usize, pattern: &NodePattern, unknowns: &Unknowns) {
        let mut offset = 0;
        for (position, &row) in pattern.column(node).iter().enumerate() {
            self.position[row as usize] = position as u32;
            self.offset[row as usize] = offset;
            offset += unknowns.count(row as usize);
        }
    }
}
