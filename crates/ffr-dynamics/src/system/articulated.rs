//! Accelerations of a tree of flexible bodies in a number of operations linear in the number of bodies (docs/theory.md Eq. M.14 to M.17).
//!
//! From the leaves to ground, each body's own unknowns (elastic accelerations, joint accelerations) are eliminated; what
//! is left is an inertia of six rows and columns at the parent's marker (Featherstone's articulated inertia, with elastic
//! coordinates among the unknowns of a body). Then accelerations follow from ground to the leaves. The factors serve any
//! number of further force vectors, as loop-closing joints need them.

use crate::error::MotionFault;
use nalgebra::Vector3;

use super::equations::dot;
use super::equations::{BodyWorkspace, RigidPart};
use super::force::{BodyState, GeneralisedForce};
use super::model::{MultibodyModel, TreeBody};
use super::tree_kinematics::{JointKinematics, SpatialVector, join};
use crate::body::ModalMass;
use crate::error::EvaluationFailure;

/// Numbers taken together in sums of rows.
const LANES: usize = 4;
/// Pivot, as a share of the diagonal entry it came from, below which an inertia counts as singular: round-off.
const SMALLEST_PIVOT: f64 = 1e-13;

/// Inertia, forces and factors of one body.
#[derive(Debug, Clone)]
pub(super) struct BodyFactors {
    n_modes: usize,
    /// Unknowns of the body: elastic and joint accelerations.
    n_unknowns: usize,
    /// Length of the rows of `motion`, `product` and `matrix`: a multiple of [`LANES`], filled up with zeros.
    stride: usize,
    /// Rigid inertia with that of the bodies outboard of it.
    rigid: [SpatialVector; 6],
    /// Rigid by elastic inertia (6 x n_q).
    coupling: Vec<f64>,
    /// Elastic inertia, upper triangle (n_q x n_q).
    elastic: Vec<f64>,
    /// Whether the elastic inertia has a diagonal only: mass-orthonormal modes, no body on a flexible marker.
    is_diagonal: bool,
    /// Rigid forces.
    force: SpatialVector,
    /// Elastic forces.
    elastic_force: Vec<f64>,
    /// Frame's acceleration by unknowns and parent's marker, six rows.
    motion: Vec<f64>,
    /// Scratch of the same size.
    product: Vec<f64>,
    /// Upper triangle of the eliminated matrix by unknowns and parent's marker, with the forces as last column.
    matrix: Vec<f64>,
    /// Reciprocal pivots.
    pivots: Vec<f64>,
    /// Unknowns found, then the acceleration of the parent's marker.
    pub solution: Vec<f64>,
    /// Acceleration of the frame, less gravity, in the body's axes.
    pub frame: SpatialVector,
    /// Force and moment of the joint on the body, at the parent's marker and in the parent's axes [N, N m].
    pub joint_force: SpatialVector,
}

impl BodyFactors {
    pub fn new(body: &TreeBody) -> Self {
        let (n, m) = (body.layout.n_modes, body.layout.n_velocities);
        let size = n + m + 6;
        let stride = (size + 1).next_multiple_of(LANES);
        Self {
            n_modes: n,
            n_unknowns: n + m,
            stride,
            rigid: [[0.0; 6]; 6],
            coupling: vec![0.0; 6 * n],
            elastic: vec![0.0; n * n],
            is_diagonal: true,
            force: [0.0; 6],
            elastic_force: vec![0.0; n],
            motion: vec![0.0; 6 * stride],
            product: vec![0.0; 6 * stride],
            matrix: vec![0.0; size * stride],
            pivots: vec![0.0; n + m],
            solution: vec![0.0; size],
            frame: [0.0; 6],
            joint_force: [0.0; 6],
        }
    }

    /// Inertia and forces of the body alone (Eq. D.7); returns the power lost in modal damping \[W\].
    pub fn load(
        &mut self,
        body: &TreeBody,
        state: &BodyState,
        force: &GeneralisedForce,
        workspace: &mut BodyWorkspace,
    ) -> f64 {
        let (RigidPart { inertia, force }, power) = workspace.assemble(&body.data, state, force);
        for i in 0..6 {
            for j in 0..6 {
                self.rigid[i][j] = inertia[i.max(j)][i.min(j)];
            }
        }
        self.force = force;
        let n = self.n_modes;
        let (coupling, elastic_force) = workspace.elastic_part();
        self.elastic_force.copy_from_slice(elastic_force);
        for (j, row) in coupling.iter().enumerate() {
            for (r, c) in row.iter().enumerate() {
                self.coupling[r * n + j] = *c;
            }
        }
        match &body.data.modal_mass {
            ModalMass::Identity => {
                if !self.is_diagonal {
                    self.elastic.fill(0.0);
                }
                self.elastic.iter_mut().step_by(n + 1).for_each(|m| *m = 1.0);
                self.is_diagonal = true;
            }
            ModalMass::Full(full) => {
                self.is_diagonal = false;
                for (i, row) in self.elastic.chunks_exact_mut(n.max(1)).enumerate() {
                    row.copy_from_slice(full.row(i));
                }
            }
        }
        power
    }

    /// Multiplies the diagonal of the elastic inertia, so that elastic coordinates give way less than joints.
    pub fn weigh_elastic(&mut self, weight: f64) {
        self.elastic.iter_mut().step_by(self.n_modes + 1).for_each(|m| *m *= weight);
    }

    /// Adds `weight` times a diagonal stiffness to the elastic inertia.
    pub fn stiffen(&mut self, stiffness: &[f64], weight: f64) {
        for (m, k) in self.elastic.iter_mut().step_by(self.n_modes + 1).zip(stiffness) {
            *m += weight * k;
        }
    }

    /// Eliminates the body's unknowns (Eq. M.15).
    ///
    /// `joint_forces` act along the free velocities.
    pub fn eliminate(
        &mut self,
        body: &TreeBody,
        edge: &JointKinematics,
        joint_forces: &[f64],
    ) -> Result<(), EvaluationFailure> {
        self.fill_motion(edge);
        self.fill_products(edge);
        self.fill_matrix(edge, joint_forces);
        let n = self.n_unknowns;
        let mut k = 0;
        if self.has_separate_modes(edge) {
            self.eliminate_modes(body)?;
            k = self.n_modes;
        }
        // Two pivots at a time: half the traffic of the updates.
        while k < n {
            self.scale_pivot(body, k)?;
            if k + 1 == n {
                self.update_rows(k, None);
                break;
            }
            self.update_row(k, k + 1);
            self.scale_pivot(body, k + 1)?;
            self.update_rows(k, Some(k + 1));
            k += 2;
        }
        Ok(())
    }

    /// Whether the modes know of each other only through the frame: the work is then linear in their number.
    fn has_separate_modes(&self, edge: &JointKinematics) -> bool {
        self.is_diagonal && edge.elastic_rows.is_empty()
    }

    /// Eliminates modes that know of each other only through the frame.
    fn eliminate_modes(&mut self, body: &TreeBody) -> Result<(), EvaluationFailure> {
        let (n, size, width) = (self.n_modes, self.n_unknowns + 6, self.stride);
        for k in 0..n {
            self.scale_pivot(body, k)?;
        }
        let start = n - n % LANES;
        let (modes, rest) = self.matrix.split_at_mut(n * width);
        for (row, reciprocal) in modes.chunks_exact(width).zip(&self.pivots) {
            for (i, below) in (n..size).zip(rest.chunks_exact_mut(width)) {
                axpy(-row[i] * reciprocal, &row[start..], &mut below[start..]);
            }
        }
        Ok(())
    }

    /// Checks pivot `k` and stores its reciprocal.
    fn scale_pivot(&mut self, body: &TreeBody, k: usize) -> Result<(), EvaluationFailure> {
        let pivot = self.matrix[k * self.stride + k];
        let is_positive = pivot > SMALLEST_PIVOT * self.pivots[k]; // the diagonal before elimination; false for NaN
        if !is_positive {
            let coordinates = if k < self.n_modes { "elastic coordinates" } else { "joint coordinates" };
            return Err(MotionFault::Inertia { coordinates, body: body.name.clone() }.into());
        }
        self.pivots[k] = 1.0 / pivot;
        Ok(())
    }

    /// Takes pivot row `k` out of row `i`.
    fn update_row(&mut self, k: usize, i: usize) {
        let width = self.stride;
        let (above, below) = self.matrix.split_at_mut(i * width);
        let pivot_row = &above[k * width..(k + 1) * width];
        axpy(-pivot_row[i] * self.pivots[k], &pivot_row[i..], &mut below[i..width]);
    }

    /// Takes pivot rows `k` and `l` out of all rows after the last of them.
    fn update_rows(&mut self, k: usize, l: Option<usize>) {
        let (width, size) = (self.stride, self.n_unknowns + 6);
        let last = l.unwrap_or(k);
        let (above, below) = self.matrix.split_at_mut((last + 1) * width);
        let first = &above[k * width..(k + 1) * width];
        let second = &above[last * width..(last + 1) * width];
        let weight = if l.is_some() { self.pivots[last] } else { 0.0 };
        for (i, row) in (last + 1..size).zip(below.chunks_exact_mut(width)) {
            let (a, b) = (first[i] * self.pivots[k], second[i] * weight);
            if a == 0.0 && b == 0.0 {
                continue; // modes that no marker couples
            }
            // Entries left of the diagonal come along, and are never used.
            let start = i - i % LANES;
            for ((x, f), s) in row[start..].iter_mut().zip(&first[start..]).zip(&second[start..]) {
                *x -= a * f + b * s;
            }
        }
    }

    /// Rows of `motion`: elastic, joint, parent's marker.
    fn fill_motion(&mut self, edge: &JointKinematics) {
        let n = self.n_modes;
        let lever = edge.turn * -edge.lever.cross_matrix();
        for (r, row) in self.motion.chunks_exact_mut(self.stride).enumerate() {
            if !edge.elastic_rows.is_empty() {
                row[..n].copy_from_slice(&edge.elastic_rows[r * n..(r + 1) * n]);
            }
            for (x, column) in row[n..self.n_unknowns].iter_mut().zip(&edge.columns) {
                *x = column[r];
            }
            let marker = &mut row[self.n_unknowns..];
            for c in 0..3 {
                marker[c] = if r < 3 { edge.turn[(r, c)] } else { 0.0 };
                marker[3 + c] = if r < 3 { lever[(r, c)] } else { edge.turn[(r - 3, c)] };
            }
        }
    }

    /// Rows of `product`: half the rigid inertia times `motion`, plus the coupling.
    fn fill_products(&mut self, edge: &JointKinematics) {
        let n = self.n_modes;
        let start = if edge.elastic_rows.is_empty() { n - n % LANES } else { 0 };
        for (r, row) in self.product.chunks_exact_mut(self.stride).enumerate() {
            row[..n].copy_from_slice(&self.coupling[r * n..(r + 1) * n]);
            row[n..].fill(0.0);
            add_spatial(&self.rigid[r].map(|m| 0.5 * m), &self.motion, self.stride, start, &mut row[start..]);
        }
    }

    /// `motionᵀ product + productᵀ motion` with the elastic inertia, upper triangle, and the forces.
    fn fill_matrix(&mut self, edge: &JointKinematics, joint_forces: &[f64]) {
        let (n, n_unknowns, size) = (self.n_modes, self.n_unknowns, self.n_unknowns + 6);
        let width = self.stride;
        let is_still = edge.elastic_rows.is_empty();
        let is_separate = self.has_separate_modes(edge);
        let mut rigid_force = self.force;
        for (f, row) in rigid_force.iter_mut().zip(&self.rigid) {
            *f -= dot(row, &edge.bias);
        }
        for i in 0..size {
            let row = &mut self.matrix[i * width..(i + 1) * width];
            let start = i - i % LANES;
            let first = if is_still { start.max(n - n % LANES) } else { start };
            // Between the diagonal and there, rows of separate modes have never been written.
            row[if is_separate { first } else { start }..].fill(0.0);
            let mut force = 0.0;
            if i < n {
                let last = if is_separate { i + 1 } else { n };
                row[i..last].copy_from_slice(&self.elastic[i * n + i..i * n + last]);
                force = self.elastic_force[i];
            } else if i < n_unknowns {
                force = joint_forces[i - n];
            }
            let column = |rows: &[f64]| -> SpatialVector { std::array::from_fn(|r| rows[r * width + i]) };
            let (motion, product) = (column(&self.motion), column(&self.product));
            add_spatial(&product, &self.motion, width, first, &mut row[first..]);
            if i >= n || !is_still {
                add_spatial(&motion, &self.product, width, start, &mut row[start..]);
                force += dot(&motion, &rigid_force);
            }
            if i < n {
                force -= (0..6).map(|r| self.coupling[r * n + i] * edge.bias[r]).sum::<f64>();
            }
            row[size] = force;
            if i < n_unknowns {
                self.pivots[i] = row[i];
            }
        }
    }

    /// Inertia left at the parent's marker, entry `(i, j)`.
    fn left(&self, i: usize, j: usize) -> f64 {
        self.matrix[(self.n_unknowns + i.min(j)) * self.stride + self.n_unknowns + i.max(j)]
    }

    /// Force left at the parent's marker.
    fn left_force(&self) -> SpatialVector {
        let column = self.n_unknowns + 6;
        std::array::from_fn(|i| self.matrix[(self.n_unknowns + i) * self.stride + column])
    }

    /// Adds what is left of `child` to this body (Eq. M.16).
    pub fn add_child(&mut self, child: &Self, edge: &JointKinematics) {
        let n = self.n_modes;
        let mut force = child.left_force();
        let arm = edge.parent_point.arm.cross_matrix();
        // Columns: inertia by the frame's motion.
        let mut by_frame = [[0.0; 6]; 6];
        for (i, row) in by_frame.iter_mut().enumerate() {
            for j in 0..3 {
                row[j] = child.left(i, j);
                row[3 + j] =
                    child.left(i, 3 + j) - (0..3).map(|k| child.left(i, k) * arm[(k, j)]).sum::<f64>();
            }
            force[i] -= (0..6).map(|k| child.left(i, k) * edge.parent_bias[k]).sum::<f64>();
        }
        for i in 0..3 {
            let moment: SpatialVector =
                std::array::from_fn(|j| (0..3).map(|k| arm[(k, i)] * by_frame[k][j]).sum());
            axpy(1.0, &by_frame[i], &mut self.rigid[i]);
            axpy(1.0, &by_frame[3 + i], &mut self.rigid[3 + i]);
            axpy(-1.0, &moment, &mut self.rigid[3 + i]);
        }
        add_at_marker(&force, edge, &mut self.force, &mut self.elastic_force);
        if edge.parent_rows.is_empty() {
            return;
        }
        self.is_diagonal = false;
        let rows = &edge.parent_rows;
        for (s, coupling) in self.coupling.chunks_exact_mut(n).enumerate() {
            let column: SpatialVector = std::array::from_fn(|r| by_frame[r][s]);
            add_spatial(&column, rows, n, 0, coupling);
        }
        let left: [SpatialVector; 6] = std::array::from_fn(|i| std::array::from_fn(|j| child.left(i, j)));
        for (i, elastic) in self.elastic.chunks_exact_mut(n).enumerate() {
            let column: SpatialVector = std::array::from_fn(|r| rows[r * n + i]);
            add_spatial(&left.map(|row| dot(&row, &column)), rows, n, i, &mut elastic[i..]);
        }
    }

    /// Unknowns from the acceleration of the parent's marker (Eq. M.17).
    pub fn substitute(&mut self, marker: &SpatialVector, edge: &JointKinematics) {
        let (n, size) = (self.n_unknowns, self.n_unknowns + 6);
        let width = self.stride;
        self.solution[n..].copy_from_slice(marker);
        let is_separate = self.has_separate_modes(edge);
        for k in (0..n).rev() {
            let row = &self.matrix[k * width..(k + 1) * width];
            let first = if is_separate { (k + 1).max(self.n_modes) } else { k + 1 };
            let sum = dot(&row[first..size], &self.solution[first..]);
            self.solution[k] = (row[size] - sum) * self.pivots[k];
        }
        let force = self.left_force();
        self.joint_force =
            std::array::from_fn(|i| (0..6).map(|j| self.left(i, j) * marker[j]).sum::<f64>() - force[i]);
        self.frame = edge.at_frame(marker, &self.solution[..self.n_modes], &self.solution[self.n_modes..n]);
        self.frame.iter_mut().zip(&edge.bias).for_each(|(a, b)| *a += b);
    }

    /// Elastic accelerations.
    pub fn elastic_accelerations(&self) -> &[f64] {
        &self.solution[..self.n_modes]
    }

    /// Joint accelerations of free velocities.
    pub fn joint_accelerations(&self) -> &[f64] {
        &self.solution[self.n_modes..self.n_unknowns]
    }
}

/// Adds a force at the parent's marker to the forces on the parent's frame and modes.
pub(super) fn add_at_marker(
    force: &SpatialVector,
    edge: &JointKinematics,
    frame: &mut SpatialVector,
    elastic: &mut [f64],
) {
    let f = Vector3::new(force[0], force[1], force[2]);
    let moment = edge.parent_point.arm.cross(&f);
    for i in 0..3 {
        frame[i] += force[i];
        frame[3 + i] += force[3 + i] + moment[i];
    }
    if !edge.parent_rows.is_empty() {
        let n = elastic.len();
        for (row, f) in edge.parent_rows.chunks_exact(n).zip(force) {
            axpy(*f, row, elastic);
        }
    }
}

/// Accelerations of all bodies; inertia and forces have been loaded (Eq. M.14 to M.17).
///
/// `joint_forces` has a slot of six per body, for its free velocities.
pub(super) fn solve_tree(
    model: &MultibodyModel,
    edges: &[JointKinematics],
    joint_forces: &[SpatialVector],
    factors: &mut [BodyFactors],
) -> Result<(), EvaluationFailure> {
    for &i in model.order.iter().rev() {
        let body = &model.bodies[i];
        factors[i].eliminate(body, &edges[i], &joint_forces[i][..body.layout.n_velocities])?;
        if let Some(p) = body.joint.parent.body {
            let [parent, child] =
                factors.get_disjoint_mut([p, i]).expect("a body is not its own parent: cycles are refused");
            parent.add_child(child, &edges[i]);
        }
    }
    for &i in &model.order {
        let marker = match model.bodies[i].joint.parent.body {
            // Gravity acts like an acceleration of ground.
            None => join(&-model.gravity, &Vector3::zeros()),
            Some(p) => {
                let mut at = edges[i].at_parent_marker(&factors[p].frame, factors[p].elastic_accelerations());
                at.iter_mut().zip(&edges[i].parent_bias).for_each(|(a, b)| *a += b);
                at
            }
        };
        factors[i].substitute(&marker, &edges[i]);
    }
    Ok(())
}

/// Answer of the tree to further forces with the factors of the last [`solve_tree`].
#[derive(Debug, Clone)]
pub(super) struct Response {
    /// Forces on the frames, in body axes; used up by the solution.
    pub force: Vec<SpatialVector>,
    /// Modal forces of all bodies, in the order of rates (joint slots are not used); used up by the solution.
    pub elastic_force: Vec<f64>,
    /// Accelerations of all coordinates, in the order of rates.
    pub rates: Vec<f64>,
    /// Accelerations of the frames, in body axes.
    pub frames: Vec<SpatialVector>,
    /// Forces of the joints at the parents' markers, in the parents' axes.
    pub joint_forces: Vec<SpatialVector>,
    scratch: Vec<f64>,
}

impl Response {
    pub fn new(model: &MultibodyModel) -> Self {
        let n = model.bodies.len();
        let largest = model.bodies.iter().map(|b| b.layout.n_rates()).max().unwrap_or(0);
        Self {
            force: vec![[0.0; 6]; n],
            elastic_force: vec![0.0; model.n_rates()],
            rates: vec![0.0; model.n_rates()],
            frames: vec![[0.0; 6]; n],
            joint_forces: vec![[0.0; 6]; n],
            scratch: vec![0.0; largest + 6],
        }
    }

    /// No forces.
    pub fn clear(&mut self) {
        self.force.fill([0.0; 6]);
        self.elastic_force.fill(0.0);
    }

    /// Accelerations by the forces alone, without velocities and gravity.
    pub fn solve(&mut self, model: &MultibodyModel, edges: &[JointKinematics], factors: &[BodyFactors]) {
        for &i in model.order.iter().rev() {
            let BodyFactors { n_modes, n_unknowns, stride, motion, matrix, pivots, .. } = &factors[i];
            let (n, size) = (*n_unknowns, n_unknowns + 6);
            let layout = &model.bodies[i].layout;
            let x = &mut self.scratch[..size];
            x.fill(0.0);
            x[..*n_modes].copy_from_slice(&self.elastic_force[layout.rates_elastic()]);
            for (f, row) in self.force[i].iter().zip(motion.chunks_exact(*stride)) {
                axpy(*f, row, x);
            }
            for k in 0..n {
                let row = &matrix[k * stride..(k + 1) * stride];
                let scaled = x[k] * pivots[k];
                axpy(-scaled, &row[k + 1..size], &mut x[k + 1..]);
            }
            self.rates[layout.rates_offset..layout.rates_offset + n].copy_from_slice(&x[..n]);
            let left: SpatialVector = std::array::from_fn(|c| x[n + c]);
            self.joint_forces[i] = left.map(|f| -f);
            if let Some(p) = model.bodies[i].joint.parent.body {
                let elastic = model.bodies[p].layout.rates_elastic();
                add_at_marker(&left, &edges[i], &mut self.force[p], &mut self.elastic_force[elastic]);
            }
        }
        for &i in &model.order {
            let (factor, layout) = (&factors[i], &model.bodies[i].layout);
            let (n, size) = (factor.n_unknowns, factor.n_unknowns + 6);
            let marker = match model.bodies[i].joint.parent.body {
                None => [0.0; 6],
                Some(p) => {
                    let elastic = &self.rates[model.bodies[p].layout.rates_elastic()];
                    edges[i].at_parent_marker(&self.frames[p], elastic)
                }
            };
            let x = &mut self.scratch[..size];
            x[n..].copy_from_slice(&marker);
            for k in (0..n).rev() {
                let row = &factor.matrix[k * factor.stride..(k + 1) * factor.stride];
                let sum = dot(&row[k + 1..size], &x[k + 1..]);
                x[k] = (self.rates[layout.rates_offset + k] - sum) * factor.pivots[k];
            }
            self.rates[layout.rates_offset..layout.rates_offset + n].copy_from_slice(&x[..n]);
            for (r, f) in self.joint_forces[i].iter_mut().enumerate() {
                *f += (0..6).map(|c| factor.left(r, c) * marker[c]).sum::<f64>();
            }
            self.frames[i] = edges[i].at_frame(&marker, &x[..factor.n_modes], &x[factor.n_modes..n]);
        }
    }
}

/// `y += a x`.
fn axpy(a: f64, x: &[f64], y: &mut [f64]) {
    for (y, x) in y.iter_mut().zip(x) {
        *y += a * x;
    }
}

/// Adds a combination of six rows of length `stride`, from column `first` on.
fn add_spatial(weights: &SpatialVector, rows: &[f64], stride: usize, first: usize, to: &mut [f64]) {
    let n = to.len();
    let row = |r: usize| &rows[r * stride + first..r * stride + first + n];
    let (a, b, c, d, e, f) = (row(0), row(1), row(2), row(3), row(4), row(5));
    let [u, v, w, x, y, z] = *weights;
    for (i, sum) in to.iter_mut().enumerate() {
        // Two chains of sums: they need not wait for each other.
        *sum += (u * a[i] + v * b[i] + w * c[i]) + (x * d[i] + y * e[i] + z * f[i]);
    }
}
