//! Phase two and the loop over batches of elements.

use std::ops::Range;

use faer::sparse::{SparseColMat, SymbolicSparseColMat};
use rayon::prelude::*;

use super::element::{ElementProducts, Workspace, n_rows};
use super::mass;
use super::pattern::{Connectivity, NodePattern, Unknowns, index};
use super::stiffness::{add_columns, axisymmetric_block, solid_block};
use crate::SplineError;
use crate::elasticity::{MaterialField, Model};
use crate::space::Space;

/// Memory for the products of one batch \[bytes\]; large enough to keep every thread busy, small enough for the cache.
const BATCH_BYTES: usize = 6 << 20;
/// Elements of one batch at most.
const MOST_IN_BATCH: usize = 1024;
/// Parts into which a phase is cut, per thread, to balance the load.
const PARTS_PER_THREAD: usize = 4;

/// Stiffness and mass of a free body (the axis of symmetry excepted).
#[derive(Debug, Clone)]
pub struct AssembledMatrices {
    /// Stiffness matrix `K`, lower triangle, unknown by unknown [N/m].
    pub stiffness: SparseColMat<u32, f64>,
    /// Consistent mass matrix `m_AB = ∫ ρ R_A R_B dV`, lower triangle, node by node, the same for every displacement
    /// component \[kg\].
    pub mass: SparseColMat<u32, f64>,
    /// Node and displacement component of every unknown, sorted by node, then component. Radial displacements of nodes on
    /// the axis of an axisymmetric model are zero and have no unknown.
    pub dofs: Vec<(u32, u8)>,
}

/// Assembles stiffness and mass of `model` on `space`, whose elements are of `materials` (theory Eq. E.10 to E.12), on the threads of the current rayon pool.
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

/// Node and displacement component of every unknown that [`assemble`] would number for control points `nodes`: its
/// [`AssembledMatrices::dofs`] without the matrices.
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

/// One node's columns and the contributions that a batch makes to them.
struct ColumnTask<'a> {
    node: u32,
    stiffness: &'a mut [f64],
    mass: &'a mut [f64],
    contributions: &'a [Contribution],
}

/// Function `node` is at place `own` of the element in slot `slot` of the batch.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Contribution {
    node: u32,
    slot: u32,
    own: u32,
}

/// For every row node of the column at hand: its place in the node pattern and its first row in the matrix.
#[derive(Clone)]
struct RowTable {
    position: Vec<u32>,
    offset: Vec<u32>,
}

impl Target<'_> {
    fn fill(&mut self, space: &dyn Space, connectivity: &Connectivity) -> Result<(), SplineError> {
        let threads = rayon::current_num_threads();
        let n_parts = PARTS_PER_THREAD * threads;
        // Elements of locally refined spaces differ much in size: the largest would leave batches of the others too small to share.
        let bytes = |e| 8 * connectivity.functions(e).len().pow(2) * (n_rows(self.model).pow(2) + 1);
        let batches = batches(space.n_elements(), n_parts, bytes);
        let most = batches.iter().map(Range::len).max().unwrap_or_default();
        let mut slots: Vec<ElementProducts> = std::iter::repeat_with(Default::default).take(most).collect();
        let mut workers: Vec<Workspace> = std::iter::repeat_with(Default::default).take(n_parts).collect();
        let zeros = vec![0; space.n_functions()];
        let mut tables = vec![RowTable { position: zeros.clone(), offset: zeros }; n_parts];
        let mut contributions = Vec::new();
        for batch in batches {
            let slots = &mut slots[..batch.len()];
            let size = slots.len().div_ceil(n_parts);
            slots.par_chunks_mut(size).enumerate().zip(&mut workers).try_for_each(|((part, chunk), w)| {
                chunk.iter_mut().enumerate().try_for_each(|(i, slot)| {
                    let e = batch.start + part * size + i;
                    w.products(space, self.model, self.materials.on(e), e, slot)
                })
            })?;
            self.scatter(slots, &mut contributions, &mut tables);
            // Slots that have held large elements would add up to more than a batch.
            let share = BATCH_BYTES / slots.len();
            slots.iter_mut().for_each(|slot| slot.shrink_to(share));
        }
        Ok(())
    }

    /// Adds the products of a batch, column by column.
    fn scatter(
        &mut self,
        slots: &[ElementProducts],
        contributions: &mut Vec<Contribution>,
        tables: &mut [RowTable],
    ) {
        contributions.clear();
        for (slot, element) in slots.iter().enumerate() {
            let entry = |(own, &node)| Contribution { node, slot: slot as u32, own: own as u32 };
            contributions.extend(element.nodes.iter().enumerate().map(entry));
        }
        contributions.sort_unstable();
        let (mut tasks, mut stiffness, mut mass) = (Vec::new(), &mut self.stiffness[..], &mut self.mass[..]);
        let (mut stiffness_at, mut mass_at) = (0, 0);
        for contributions in contributions.chunk_by(|a, b| a.node == b.node) {
            let node = contributions[0].node as usize;
            let unknowns = [node, node + 1].map(|n| self.columns[self.unknowns.start[n] as usize] as usize);
            let entries = [node, node + 1].map(|n| self.pattern.start[n] as usize);
            tasks.push(ColumnTask {
                node: node as u32,
                stiffness: cut(&mut stiffness, &mut stiffness_at, unknowns),
                mass: cut(&mut mass, &mut mass_at, entries),
                contributions,
            });
        }
        let size = tasks.len().div_ceil(tables.len()).max(1);
        let (pattern, unknowns) = (&self.pattern, &self.unknowns);
        tasks.par_chunks_mut(size).zip(tables).for_each(|(tasks, table)| {
            for task in tasks {
                table.load(task.node as usize, pattern, unknowns);
                for c in task.contributions {
                    let (element, own) = (&slots[c.slot as usize], c.own as usize);
                    let (lambda, mu, density) = element.constants;
                    mass::add_column(element, own, density, &table.position, task.mass);
                    let (offset, values) = (&table.offset[..], &mut *task.stiffness);
                    match self.model {
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
            }
        });
    }
}

/// Cuts `0..n_elements` into batches whose products take `bytes` of each of their elements, together no more than [`BATCH_BYTES`] where `least` elements do not take more.
fn batches(n_elements: usize, least: usize, bytes: impl Fn(usize) -> usize) -> Vec<Range<usize>> {
    let (mut all, mut start, mut sum) = (Vec::new(), 0, 0);
    for e in 0..n_elements {
        let (length, own) = (e - start, bytes(e));
        if length >= MOST_IN_BATCH || length >= least && sum + own > BATCH_BYTES {
            all.push(start..e);
            (start, sum) = (e, 0);
        }
        sum += own;
    }
    if start < n_elements {
        all.push(start..n_elements);
    }
    all
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn batches_hold_every_element_once_and_no_more_than_memory_allows() {
        // A few large elements among many small ones, as at the ends of a refined zone.
        let bytes = |e: usize| if e % 100 == 7 { BATCH_BYTES / 3 } else { BATCH_BYTES / 500 };
        let all = batches(5000, 8, bytes);
        let joined: Vec<usize> = all.iter().cloned().flatten().collect();
        assert_eq!(joined, (0..5000).collect::<Vec<_>>());
        assert!(all.iter().all(|b| b.clone().map(bytes).sum::<usize>() <= BATCH_BYTES));
        // Three large ones fill a batch at most, so that batches end later than the largest would let them.
        assert!(all.len() < 5000 / 100, "{}", all.len());
        assert_eq!(batches(20, 8, |_| BATCH_BYTES), [0..8, 8..16, 16..20]);
        assert_eq!(batches(3000, 8, |_| 1).len(), 3000usize.div_ceil(MOST_IN_BATCH));
        assert!(batches(0, 8, |_| 1).is_empty());
    }
}
