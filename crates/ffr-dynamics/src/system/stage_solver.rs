//! The linear systems of implicit stages, by way of the tree (docs/theory.md Eq. M.46 to M.50).
//!
//! `(M + w² K + w D) x = M r - K s` for a complex weight `w`, with the stiffness and damping of modes and joint springs and the inertia
//! of the present pose. The modes of a body are uncoupled once and for all; what is left of it are six rows and columns for each place
//! where a joint holds it, its ports. The work is linear in bodies and modes.

use faer::{Mat, c64};
use nalgebra::{Matrix6, Vector6};

use super::equations::BodyWorkspace;
use super::model::{MultibodyModel, TreeBody};
use super::tree_kinematics::JointKinematics;
use crate::body::{ModalDamping, ModalMass};
use crate::error::DynamicsError;
use crate::integration::STAGE_PAIRS;
use crate::reduction::dense;

type Complex6 = Matrix6<c64>;
type Vector6c = Vector6<c64>;

const ZERO: c64 = c64::new(0.0, 0.0);

/// The modes of one body without coupling, in place of its elastic coordinates: `q = Z z` with `Zᵀ M_e Z = 1`.
#[derive(Debug, Clone)]
struct UncoupledModes {
    /// `Z` (n x n) column by column; empty for the identity.
    shapes: Vec<f64>,
    /// `Zᵀ K_e Z` [rad²/s²].
    stiffness: Vec<f64>,
    /// Diagonal of `Zᵀ D_e Z`; the rest is left out [1/s].
    damping: Vec<f64>,
}

impl UncoupledModes {
    fn new(body: &TreeBody) -> Result<Self, DynamicsError> {
        let data = &body.data;
        let n = data.n_modes();
        let damping = |i: usize, j: usize| match &data.modal_damping {
            ModalDamping::None => 0.0,
            ModalDamping::PerMode(d) => {
                if i == j {
                    d[i]
                } else {
                    0.0
                }
            }
            ModalDamping::Full(d) => d[(i, j)],
        };
        if data.modal_mass == ModalMass::Identity || n == 0 {
            return Ok(Self {
                shapes: Vec::new(),
                stiffness: data.modal_stiffness.clone(),
                damping: (0..n).map(|j| damping(j, j)).collect(),
            });
        }
        let factor = dense::cholesky(data.modal_mass.to_matrix(n), "modal mass matrix")?;
        let mut whitened = Mat::from_fn(n, n, |i, j| if i == j { data.modal_stiffness[i] } else { 0.0 });
        dense::solve_lower(factor.as_ref(), whitened.as_mut());
        let mut whitened = whitened.transpose().to_owned();
        dense::solve_lower(factor.as_ref(), whitened.as_mut());
        dense::symmetrise(&mut whitened);
        let (stiffness, mut shapes) = dense::symmetric_eigen(whitened.as_ref())?;
        dense::solve_lower_transposed(factor.as_ref(), shapes.as_mut());
        let along = |k: usize| -> f64 {
            let pairs = (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
            pairs.map(|(i, j)| shapes[(i, k)] * damping(i, j) * shapes[(j, k)]).sum()
        };
        Ok(Self {
            stiffness,
            damping: (0..n).map(along).collect(),
            shapes: (0..n).flat_map(|k| shapes.col(k).iter().copied().collect::<Vec<_>>()).collect(),
        })
    }

    /// Rows of elastic coordinates (6 x n) as rows of modes.
    fn rows(&self, rows: &[f64], out: &mut [f64]) {
        let n = self.stiffness.len();
        if self.shapes.is_empty() {
            out.copy_from_slice(rows);
            return;
        }
        for (row, out) in rows.chunks_exact(n).zip(out.chunks_exact_mut(n)) {
            for (o, shape) in out.iter_mut().zip(self.shapes.chunks_exact(n)) {
                *o = shape.iter().zip(row).map(|(a, b)| a * b).sum();
            }
        }
    }

    /// Forces on elastic coordinates as forces on modes.
    fn forces(&self, forces: &[c64], out: &mut [c64]) {
        if self.shapes.is_empty() {
            out.copy_from_slice(forces);
            return;
        }
        for (o, shape) in out.iter_mut().zip(self.shapes.chunks_exact(forces.len())) {
            *o = shape.iter().zip(forces).map(|(a, b)| b * a).sum();
        }
    }

    /// Adds the elastic coordinates of the modes `modes` to `out`.
    fn add_coordinates(&self, modes: &[c64], out: &mut [c64]) {
        if self.shapes.is_empty() {
            out.iter_mut().zip(modes).for_each(|(o, m)| *o += m);
            return;
        }
        for (mode, shape) in modes.iter().zip(self.shapes.chunks_exact(out.len())) {
            out.iter_mut().zip(shape).for_each(|(o, s)| *o += mode * s);
        }
    }
}

/// The pose held of one body, real; rows belong to uncoupled modes.
#[derive(Debug, Clone)]
struct Pose {
    /// Inertia of the frame.
    rigid: Matrix6<f64>,
    /// Coupling of frame and modes (6 x n).
    coupling: Vec<f64>,
    /// Rows of the own port (6 x n), the frame's motion less what the deformation adds where the joint holds it.
    own_rows: Vec<f64>,
    /// Rows of the parent's port (6 x n of the parent).
    parent_rows: Vec<f64>,
    /// From the frame of the parent to its port.
    at_parent: Matrix6<f64>,
    /// From the parent's port to the own frame.
    across: Matrix6<f64>,
    /// Motions of the frame by the free velocities of the joint; the rest are zero.
    joint: Matrix6<f64>,
    /// Stiffness and damping of the joint's free velocities.
    springs: [[f64; 2]; 6],
}

/// Factors of one body for one weight.
#[derive(Debug, Clone)]
struct Factors {
    /// Reciprocal impedance of the modes, `1 / (1 + w d + w² ω²)`.
    modes: Vec<c64>,
    /// Inverse of the frame's inertia without the modes.
    frame: Complex6,
    /// Compliance between the ports, row by row, children's first, the own one last; eliminated from the first on.
    ports: Vec<Complex6>,
    /// `(1 + Λ_kk A_k)⁻¹` of each child's port.
    gates: Vec<Complex6>,
    /// Force of the joint by the motion that its port lacks.
    held: Complex6,
    /// Force of the joint by the forces along its free velocities; velocities by those forces; velocities by the motion that its port has
    /// in excess.
    by_joint_force: Complex6,
    joint_mobility: Complex6,
    joint_share: Complex6,
    /// Inertia that the parent's port feels.
    felt: Complex6,
}

/// Right-hand side and solution of one body.
#[derive(Debug, Clone)]
struct Course {
    modes: Vec<c64>,
    scratch: Vec<c64>,
    joint_force: Vector6c,
    /// Motions of the ports, without what later ports bring.
    ports: Vec<Vector6c>,
    /// Forces on the ports.
    forces: Vec<Vector6c>,
    /// Force on the parent's port where that is held.
    given: Vector6c,
    /// Motion of the parent's port.
    parent: Vector6c,
}

/// Solver for the systems of both pairs of stages about one pose.
#[derive(Debug, Clone)]
pub(super) struct StageSolver {
    modes: Vec<UncoupledModes>,
    children: Vec<Vec<usize>>,
    poses: Vec<Pose>,
    factors: [Vec<Factors>; STAGE_PAIRS],
    weights: [c64; STAGE_PAIRS],
    courses: Vec<Course>,
    scratch: Vec<f64>,
}

impl StageSolver {
    /// # Errors
    /// [`DynamicsError`] if the modes of a body cannot be uncoupled.
    pub fn new(model: &MultibodyModel) -> Result<Self, DynamicsError> {
        let modes = model.bodies.iter().map(UncoupledModes::new).collect::<Result<Vec<_>, _>>()?;
        let mut children = vec![Vec::new(); model.bodies.len()];
        for &i in &model.order {
            if let Some(p) = model.bodies[i].joint.parent.body {
                children[p].push(i);
            }
        }
        let n_modes = |i: usize| model.bodies[i].layout.n_modes;
        let poses = model.bodies.iter().enumerate().map(|(i, body)| {
            let of_parent = body.joint.parent.body.filter(|_| body.joint.parent.marker.n_modes() > 0);
            let has_own = !body.joint.child.is_still();
            let mut springs = [[0.0; 2]; 6];
            for (spring, k) in springs.iter_mut().zip(body.joint.free_velocities()) {
                if let Some(force) = body.joint.coordinates.get(k) {
                    *spring = [force.stiffness, force.damping];
                }
            }
            Pose {
                rigid: Matrix6::zeros(),
                coupling: vec![0.0; 6 * n_modes(i)],
                own_rows: vec![0.0; if has_own { 6 * n_modes(i) } else { 0 }],
                parent_rows: vec![0.0; of_parent.map_or(0, |p| 6 * n_modes(p))],
                at_parent: Matrix6::identity(),
                across: Matrix6::identity(),
                joint: Matrix6::zeros(),
                springs,
            }
        });
        let factors: Vec<Factors> =
            (0..modes.len()).map(|i| Factors::new(n_modes(i), children[i].len())).collect();
        let courses = (0..modes.len()).map(|i| Course::new(n_modes(i), children[i].len()));
        let largest = (0..modes.len()).map(n_modes).max().unwrap_or(0);
        Ok(Self {
            poses: poses.collect(),
            courses: courses.collect(),
            factors: std::array::from_fn(|_| factors.clone()),
            weights: [ZERO; STAGE_PAIRS],
            scratch: vec![0.0; 6 * largest],
            modes,
            children,
        })
    }

    /// Takes over the pose of the bodies and their inertia.
    pub fn hold(&mut self, model: &MultibodyModel, edges: &[JointKinematics], bodies: &[BodyWorkspace]) {
        for (i, body) in model.bodies.iter().enumerate() {
            let (edge, pose, modes) = (&edges[i], &mut self.poses[i], &self.modes[i]);
            let n = body.layout.n_modes;
            let (inertia, coupling) = bodies[i].inertia();
            pose.rigid = Matrix6::from_fn(|r, c| inertia[r.max(c)][r.min(c)]);
            let rows = &mut self.scratch[..6 * n];
            for (j, row) in coupling.iter().enumerate() {
                (0..6).for_each(|r| rows[r * n + j] = row[r]);
            }
            modes.rows(rows, &mut pose.coupling);
            if !pose.own_rows.is_empty() {
                modes.rows(&edge.elastic_rows, &mut pose.own_rows);
                pose.own_rows.iter_mut().for_each(|x| *x = -*x);
            }
            if let Some(p) = body.joint.parent.body.filter(|_| !pose.parent_rows.is_empty()) {
                self.modes[p].rows(&edge.parent_rows, &mut pose.parent_rows);
            }
            let unit = |j: usize| -> [f64; 6] { std::array::from_fn(|k| if k == j { 1.0 } else { 0.0 }) };
            for j in 0..6 {
                let across = edge.at_frame(&unit(j), &[], &[]);
                pose.across.set_column(j, &Vector6::from(across));
                let at = edge.at_parent_marker_of_frame(&unit(j));
                pose.at_parent.set_column(j, &Vector6::from(at));
            }
            for (j, column) in edge.columns.iter().enumerate().take(body.layout.n_velocities) {
                pose.joint.set_column(j, &Vector6::from(*column));
            }
        }
    }

    /// Factors for the weight `weight` of pair `pair`; returns whether they exist.
    pub fn factorise(&mut self, model: &MultibodyModel, pair: usize, weight: c64) -> bool {
        self.weights[pair] = weight;
        model.order.iter().rev().all(|&i| self.factorise_body(model, pair, i))
    }

    fn factorise_body(&mut self, model: &MultibodyModel, pair: usize, i: usize) -> bool {
        let Self { modes, children, poses, factors, weights, .. } = self;
        let (weight, pose, modes, children) = (weights[pair], &poses[i], &modes[i], &children[i]);
        let factors = &mut factors[pair];
        // The children's inertia is complete; the body's own factors are taken out while they are filled.
        let mut own = std::mem::take(&mut factors[i]);
        for ((g, k), d) in own.modes.iter_mut().zip(&modes.stiffness).zip(&modes.damping) {
            *g = 1.0 / (1.0 + weight * *d + weight * weight * *k);
        }
        let Some(frame) =
            (complex(&pose.rigid) - weighed(&pose.coupling, &own.modes, &pose.coupling)).try_inverse()
        else {
            return false;
        };
        own.frame = frame;
        let n_ports = children.len() + 1;
        let port = |b: usize| -> (&[f64], Matrix6<f64>) {
            match children.get(b) {
                Some(&child) => (&poses[child].parent_rows, poses[child].at_parent),
                None => (&pose.own_rows, Matrix6::identity()),
            }
        };
        for a in 0..n_ports {
            let (rows, lever) = port(a);
            let moved = (complex(&lever) - weighed(rows, &own.modes, &pose.coupling)) * own.frame;
            for b in 0..n_ports {
                let (other_rows, other_lever) = port(b);
                let other = complex(&other_lever) - weighed(other_rows, &own.modes, &pose.coupling);
                own.ports[a * n_ports + b] =
                    moved * other.transpose() + weighed(rows, &own.modes, other_rows);
            }
        }
        for (k, &child) in children.iter().enumerate() {
            let felt = factors[child].felt;
            let Some(gate) = (Complex6::identity() + own.ports[k * n_ports + k] * felt).try_inverse() else {
                return false;
            };
            own.gates[k] = gate;
            for a in k + 1..n_ports {
                let left = own.ports[a * n_ports + k] * felt * gate;
                for b in k + 1..n_ports {
                    let change = left * own.ports[k * n_ports + b];
                    own.ports[a * n_ports + b] -= change;
                }
            }
        }
        let n_joint = model.bodies[i].layout.n_velocities;
        let is_regular = own.close_joint(pose, weight, n_joint);
        factors[i] = own;
        is_regular
    }

    /// Replaces `x`, the velocities `r` in the order of rates, by the solution with `s` the real `motion` times `scale`.
    pub fn solve(
        &mut self,
        model: &MultibodyModel,
        pair: usize,
        x: &mut [c64],
        (scale, motion): (c64, &[f64]),
    ) {
        let weight = self.weights[pair];
        for &i in model.order.iter().rev() {
            let (body, factor) = (&model.bodies[i], &self.factors[pair][i]);
            let course = &mut self.courses[i];
            course.load(body, &self.poses[i], weight, x, (scale, motion));
            let Course { modes, scratch, .. } = course;
            self.modes[i].forces(scratch, modes);
            scratch.copy_from_slice(modes);
            let frame = factor.respond(&self.poses[i], &mut self.courses[i].scratch, Vector6c::zeros());
            let n_ports = self.children[i].len() + 1;
            for (b, &child) in self.children[i].iter().enumerate() {
                let pose = &self.poses[child];
                let moved = rows_times(&pose.parent_rows, &self.courses[i].scratch);
                self.courses[i].ports[b] = complex(&pose.at_parent) * frame + moved;
            }
            let moved = rows_times(&self.poses[i].own_rows, &self.courses[i].scratch);
            self.courses[i].ports[n_ports - 1] = frame + moved;
            for (k, &child) in self.children[i].iter().enumerate() {
                let given = self.courses[child].given;
                let felt = &self.factors[pair][child].felt;
                let ports = &mut self.courses[i].ports;
                let at = factor.gates[k] * (ports[k] + factor.ports[k * n_ports + k] * given);
                let force = given - felt * at;
                for (b, moved) in ports.iter_mut().enumerate().skip(k + 1) {
                    *moved += factor.ports[b * n_ports + k] * force;
                }
            }
            let course = &mut self.courses[i];
            let free = course.ports[n_ports - 1];
            let force = factor.held * free - factor.by_joint_force * course.joint_force;
            course.given = complex(&self.poses[i].across).transpose() * force;
        }
        for &i in &model.order {
            self.place(model, pair, i, x);
        }
    }

    /// Solution of body `i` from the motion of the parent's port; leaves the motions of its children's ports.
    fn place(&mut self, model: &MultibodyModel, pair: usize, i: usize, x: &mut [c64]) {
        let (layout, factor, pose) = (&model.bodies[i].layout, &self.factors[pair][i], &self.poses[i]);
        let n_ports = self.children[i].len() + 1;
        let own = n_ports - 1;
        let lacking = complex(&pose.across) * self.courses[i].parent - self.courses[i].ports[own];
        let joint_force = self.courses[i].joint_force;
        let velocities = factor.joint_mobility * joint_force - factor.joint_share * lacking;
        for (x, u) in x[layout.rates_joint()].iter_mut().zip(velocities.iter()) {
            *x += u;
        }
        self.courses[i].forces[own] = factor.held * lacking + factor.by_joint_force * joint_force;
        let mut on_frame = self.courses[i].forces[own];
        for (k, &child) in self.children[i].iter().enumerate().rev() {
            let given = self.courses[child].given;
            let course = &mut self.courses[i];
            let mut moved = course.ports[k] + factor.ports[k * n_ports + k] * given;
            for b in k + 1..n_ports {
                moved += factor.ports[k * n_ports + b] * course.forces[b];
            }
            let at = factor.gates[k] * moved;
            course.forces[k] = given - self.factors[pair][child].felt * at;
            self.courses[child].parent = at;
            on_frame += complex(&self.poses[child].at_parent).transpose() * self.courses[i].forces[k];
        }
        let Course { modes, forces, .. } = &mut self.courses[i];
        add_transposed(&pose.own_rows, &forces[own], modes);
        for (k, &child) in self.children[i].iter().enumerate() {
            add_transposed(&self.poses[child].parent_rows, &forces[k], modes);
        }
        factor.respond(pose, modes, on_frame);
        self.modes[i].add_coordinates(modes, &mut x[layout.rates_elastic()]);
    }
}

impl Default for Factors {
    /// Nothing: does not allocate.
    fn default() -> Self {
        let zero = Complex6::zeros();
        Self {
            modes: Vec::new(),
            frame: zero,
            ports: Vec::new(),
            gates: Vec::new(),
            held: zero,
            by_joint_force: zero,
            joint_mobility: zero,
            joint_share: zero,
            felt: zero,
        }
    }
}

impl Factors {
    fn new(n_modes: usize, n_children: usize) -> Self {
        let zero = Complex6::zeros();
        Self {
            modes: vec![ZERO; n_modes],
            ports: vec![zero; (n_children + 1) * (n_children + 1)],
            gates: vec![zero; n_children],
            ..Self::default()
        }
    }

    /// What the joint with `n` free velocities does with the compliance of its port.
    fn close_joint(&mut self, pose: &Pose, weight: c64, n: usize) -> bool {
        let Some(stiffness) = self.ports.last().and_then(|own| own.try_inverse()) else { return false };
        let joint = complex(&pose.joint);
        let by_velocity = stiffness * joint;
        let mut felt_by_joint = joint.transpose() * by_velocity;
        for (k, [stiffness, damping]) in pose.springs.iter().enumerate() {
            let spring = weight * *damping + weight * weight * *stiffness;
            felt_by_joint[(k, k)] += if k < n { spring } else { c64::new(1.0, 0.0) };
        }
        let Some(mobility) = felt_by_joint.try_inverse() else { return false };
        self.joint_mobility = mobility;
        self.by_joint_force = by_velocity * mobility;
        self.joint_share = mobility * by_velocity.transpose();
        self.held = stiffness - self.by_joint_force * by_velocity.transpose();
        let across = complex(&pose.across);
        self.felt = across.transpose() * self.held * across;
        self.felt.iter().all(|x| x.re.is_finite() && x.im.is_finite())
    }

    /// Motion of the frame under `force` on it and the forces `modes` on the modes, which become their motion.
    fn respond(&self, pose: &Pose, modes: &mut [c64], force: Vector6c) -> Vector6c {
        modes.iter_mut().zip(&self.modes).for_each(|(m, g)| *m *= g);
        let frame = self.frame * (force - rows_times(&pose.coupling, modes));
        let n = modes.len();
        for (r, a) in frame.iter().enumerate() {
            let row = &pose.coupling[r * n..(r + 1) * n];
            for ((m, g), c) in modes.iter_mut().zip(&self.modes).zip(row) {
                *m -= g * a * c;
            }
        }
        frame
    }
}

impl Course {
    fn new(n_modes: usize, n_children: usize) -> Self {
        Self {
            modes: vec![ZERO; n_modes],
            scratch: vec![ZERO; n_modes],
            joint_force: Vector6c::zeros(),
            ports: vec![Vector6c::zeros(); n_children + 1],
            forces: vec![Vector6c::zeros(); n_children + 1],
            given: Vector6c::zeros(),
            parent: Vector6c::zeros(),
        }
    }

    /// Forces `-(w² K + w D) r - K s` on elastic coordinates, in `scratch`, and along the joint's velocities.
    fn load(&mut self, body: &TreeBody, pose: &Pose, weight: c64, x: &[c64], (scale, motion): (c64, &[f64])) {
        let (squared, elastic) = (weight * weight, body.layout.rates_elastic());
        let coordinates = x[elastic.clone()].iter().zip(&motion[elastic]);
        for ((f, k), (r, s)) in self.scratch.iter_mut().zip(&body.data.modal_stiffness).zip(coordinates) {
            *f = -(squared * r + scale * *s) * *k;
        }
        if let ModalDamping::PerMode(damping) = &body.data.modal_damping {
            let rates = damping.iter().zip(&x[body.layout.rates_elastic()]);
            self.scratch.iter_mut().zip(rates).for_each(|(f, (d, r))| *f -= weight * r * *d);
        }
        self.joint_force = Vector6c::zeros();
        for (k, at) in body.layout.rates_joint().enumerate() {
            let [stiffness, damping] = pose.springs[k];
            self.joint_force[k] =
                -(squared * x[at] + scale * motion[at]) * stiffness - weight * x[at] * damping;
        }
        self.parent = Vector6c::zeros();
    }
}

fn complex(matrix: &Matrix6<f64>) -> Complex6 {
    matrix.map(|x| c64::new(x, 0.0))
}

/// `rows diag(weights) othersᵀ` of two sets of six rows; no rows count as zero.
fn weighed(rows: &[f64], weights: &[c64], others: &[f64]) -> Complex6 {
    let mut out = Complex6::zeros();
    if rows.is_empty() || others.is_empty() {
        return out;
    }
    let n = weights.len();
    for (r, row) in rows.chunks_exact(n).enumerate() {
        for (c, other) in others.chunks_exact(n).enumerate() {
            let (mut re, mut im) = (0.0, 0.0);
            for ((a, b), g) in row.iter().zip(other).zip(weights) {
                let product = a * b;
                re += product * g.re;
                im += product * g.im;
            }
            out[(r, c)] = c64::new(re, im);
        }
    }
    out
}

/// Six rows times a vector.
fn rows_times(rows: &[f64], vector: &[c64]) -> Vector6c {
    let mut out = Vector6c::zeros();
    if !vector.is_empty() {
        for (o, row) in out.iter_mut().zip(rows.chunks_exact(vector.len())) {
            *o = row.iter().zip(vector).map(|(a, b)| b * a).sum();
        }
    }
    out
}

/// Adds the transpose of six rows times `factors`.
fn add_transposed(rows: &[f64], factors: &Vector6c, out: &mut [c64]) {
    if !out.is_empty() {
        for (row, factor) in rows.chunks_exact(out.len()).zip(factors.iter()) {
            out.iter_mut().zip(row).for_each(|(o, x)| *o += factor * x);
        }
    }
}
