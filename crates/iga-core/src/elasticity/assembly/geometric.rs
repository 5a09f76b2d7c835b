//! Geometric stiffness of stresses that displacement fields cause (theory Eq. E.13).

use faer::linalg::matmul::matmul;
use faer::sparse::{SparseColMat, SymbolicSparseColMat};
use faer::{Accum, MatMut, MatRef, Par};
use rayon::prelude::*;

use super::element::Workspace;
use super::pattern::{Connectivity, NodePattern};
use crate::SplineError;
use crate::elasticity::kinematics::PointState;
use crate::elasticity::{Material, MaterialField, Model};
use crate::space::{Integrand, Space};

/// Elements whose products are kept at a time, per thread.
const BATCH: usize = 16;

/// Node by node matrices `∫ ∇R_Aᵀ σ ∇R_B dV` (theory Eq. E.13), lower triangle, the same for every
/// displacement component, of the stress `σ` that each of the displacement `fields` causes \[N/m\].
///
/// A field is node-major: component `c` of function `A` at `A * n_components + c` \[m\]. The
/// matrices are linear in the fields; rigid motions give zero. Added to the stiffness they make the
/// body stiffer where it is pulled and softer where it is pressed. The result does not depend on
/// the number of threads.
///
/// # Errors
/// [`SplineError::Folded`] for impossible geometry, [`SplineError::Dimension`] for an impossible thickness,
/// [`SplineError::TooLarge`] for more entries than 32-bit indices can name.
///
/// # Panics
/// If the model is axisymmetric, whose radial and axial components have different matrices, or a
/// field has not one entry for each function and component.
pub fn geometric_stiffness(
    space: &dyn Space,
    model: &Model,
    materials: &dyn MaterialField,
    fields: &[Vec<f64>],
) -> Result<Vec<SparseColMat<u32, f64>>, SplineError> {
    assert!(*model != Model::Axisymmetric, "an axisymmetric body has no geometric stiffness node by node");
    let n_nodes = space.n_functions();
    let size = n_nodes * model.dimension();
    assert!(fields.iter().all(|f| f.len() == size), "fields of {size} control values");
    model.validate()?;
    let connectivity = Connectivity::new(space);
    let pattern = NodePattern::new(&connectivity, n_nodes)?;
    let mut values = vec![vec![0.0; pattern.rows.len()]; fields.len()];
    let threads = rayon::current_num_threads();
    let mut slots: Vec<Slot> = std::iter::repeat_with(Slot::default).take(BATCH * threads).collect();
    let mut workers: Vec<Worker> = std::iter::repeat_with(Worker::default).take(threads).collect();
    let n_elements = space.n_elements();
    for start in (0..n_elements).step_by(slots.len()) {
        let slots = &mut slots[..(BATCH * threads).min(n_elements - start)];
        let fill = |(part, (slots, worker)): (usize, (&mut [Slot], &mut Worker))| {
            slots.iter_mut().enumerate().try_for_each(|(i, slot)| {
                let e = start + part * BATCH + i;
                worker.work.evaluate(space, model, (e, Integrand::Stiffness), &mut slot.nodes)?;
                slot.products.resize_with(fields.len(), Vec::new);
                worker.sort_gradients(model.dimension(), slot.nodes.len());
                for (field, product) in fields.iter().zip(&mut slot.products) {
                    worker.product(model, materials.on(e), &slot.nodes, field, product);
                }
                Ok::<(), SplineError>(())
            })
        };
        slots.par_chunks_mut(BATCH).zip(&mut workers).enumerate().try_for_each(fill)?;
        let slots = &*slots;
        values.par_iter_mut().enumerate().for_each(|(f, values)| {
            slots.iter().for_each(|slot| slot.add(f, &pattern, values));
        });
    }
    let symbolic = SymbolicSparseColMat::new_checked(n_nodes, n_nodes, pattern.start, None, pattern.rows);
    Ok(values.into_iter().map(|v| SparseColMat::new(symbolic.clone(), v)).collect())
}

/// Products of one element, one matrix a field, column-major `n x n`.
#[derive(Default)]
struct Slot {
    nodes: Vec<u32>,
    products: Vec<Vec<f64>>,
}

impl Slot {
    /// Adds the element's part of field `f` to the entries of the lower triangle.
    fn add(&self, f: usize, pattern: &NodePattern, values: &mut [f64]) {
        let n = self.nodes.len();
        for (b, &column) in self.nodes.iter().enumerate() {
            let first = pattern.start[column as usize] as usize;
            let rows = pattern.column(column as usize);
            let mut at = 0;
            for (a, &row) in self.nodes.iter().enumerate().skip(b) {
                // Nodes of the element rise, as the rows of the column do, and are among them.
                while rows[at] != row {
                    at += 1;
                }
                values[first + at] += self.products[f][b * n + a];
            }
        }
    }
}

/// Buffers of one thread.
#[derive(Default)]
struct Worker {
    work: Workspace,
    /// Gradients times the root of the volume: a column of `n` functions for each point and
    /// direction.
    gradients: Vec<f64>,
    /// The same, multiplied by the stress.
    stressed: Vec<f64>,
}

impl Worker {
    fn sort_gradients(&mut self, n_c: usize, n: usize) {
        self.gradients.clear();
        for q in 0..self.work.n_points() {
            let (rows, _) = self.work.gradients_at(q);
            for i in 0..n_c {
                self.gradients.extend(rows.iter().skip(i).step_by(n_c));
            }
        }
        debug_assert_eq!(self.gradients.len(), n * n_c * self.work.n_points());
    }

    fn product(
        &mut self,
        model: &Model,
        material: &Material,
        nodes: &[u32],
        field: &[f64],
        out: &mut Vec<f64>,
    ) {
        let (n, n_c) = (nodes.len(), model.dimension());
        let columns = n_c * self.work.n_points();
        self.stressed.clear();
        self.stressed.resize(n * columns, 0.0);
        for q in 0..self.work.n_points() {
            let own = q * n * n_c..(q + 1) * n * n_c;
            let gradients = &self.gradients[own.clone()];
            let stress = stress(model, material, nodes, field, gradients, self.work.gradients_at(q).1);
            for (i, column) in self.stressed[own].chunks_exact_mut(n).enumerate() {
                for (j, gradient) in gradients.chunks_exact(n).enumerate() {
                    column.iter_mut().zip(gradient).for_each(|(s, g)| *s += stress[i][j] * g);
                }
            }
        }
        out.resize(n * n, 0.0);
        let left = MatRef::from_column_major_slice(&self.stressed, n, columns);
        let right = MatRef::from_column_major_slice(&self.gradients, n, columns);
        let product = MatMut::from_column_major_slice_mut(&mut out[..n * n], n, n);
        matmul(product, Accum::Replace, left, right.transpose(), 1.0, Par::Seq);
    }
}

/// Stress tensor in the model's components at one point; `gradients` are those of all functions,
/// direction by direction, times `root`.
fn stress(
    model: &Model,
    material: &Material,
    nodes: &[u32],
    field: &[f64],
    gradients: &[f64],
    root: f64,
) -> [[f64; 3]; 3] {
    let n_c = model.dimension();
    let mut gradient = [[0.0; 3]; 3];
    for (j, slopes) in gradients.chunks_exact(nodes.len()).enumerate() {
        for (&node, slope) in nodes.iter().zip(slopes) {
            let control = &field[node as usize * n_c..][..n_c];
            gradient.iter_mut().zip(control).for_each(|(row, u)| row[j] += u * slope / root);
        }
    }
    let s = PointState::new(model, material, &gradient, 0.0).stress;
    [[s[0], s[3], s[5]], [s[3], s[1], s[4]], [s[5], s[4], s[2]]]
}
