//! Equations of motion of one free body in its floating frame (docs/theory.md Eq. D.7 to D.10).
//!
//! \[A\] (1) with all couplings and all dependence on the elastic coordinates. Deviation from the
//! paper: the unknown of the translation is the acceleration in the inertial frame, so that no term
//! `ω × v` is left in the equations.

use nalgebra::{Matrix3, Vector3};

use super::deformation::{DeformationMaps, DeformationSums, dot};
use crate::body::standard_input_data::inertia_from;
use crate::body::{RigidMotion, StandardInputData};
use crate::error::{EvaluationFailure, MotionFault};
use crate::force::{BodyState, GeneralisedForce};
use crate::rotation::skew;

/// Buffers for one body.
#[derive(Debug, Clone)]
pub(in crate::system) struct BodyWorkspace {
    sums: DeformationSums,
    /// Elastic rows of the inertia's rigid columns `[C_t C_r(q_e)]`.
    pub(in crate::system) coupling: Vec<[f64; 6]>,
    /// Elastic forces, then elastic accelerations.
    pub(in crate::system) elastic: Vec<f64>,
    /// Inertia of the frame at the last [`BodyWorkspace::assemble`], lower triangle.
    rigid: [[f64; 6]; 6],
}

/// Terms of geometric stiffening in the equations of the rigid motion.
#[derive(Debug, Default)]
struct Stiffened {
    mass_moment: Vector3<f64>,
    mass_moment_rate: Vector3<f64>,
    force: Vector3<f64>,
    torque: Vector3<f64>,
}

/// Rigid part of the equations: 6 x 6 inertia and right-hand side, translation first, in the body's
/// frame.
///
/// Only the lower triangle of the inertia is set.
pub(in crate::system) struct RigidPart {
    pub(in crate::system) inertia: [[f64; 6]; 6],
    pub(in crate::system) force: [f64; 6],
}

impl BodyWorkspace {
    /// Buffers for a body.
    pub fn new(data: &StandardInputData, maps: &DeformationMaps) -> Self {
        let n_q = data.n_modes();
        Self {
            sums: maps.sums(data),
            coupling: vec![[0.0; 6]; n_q],
            elastic: vec![0.0; n_q],
            rigid: [[0.0; 6]; 6],
        }
    }

    /// Inertia and forces of the body (Eq. D.7): the rigid part as the result, the rows `[C_t C_r]`
    /// in `coupling`, the elastic forces in `elastic`. Returns the power lost in modal damping as
    /// well \[W\].
    pub(in crate::system) fn assemble(
        &mut self,
        (data, maps): (&StandardInputData, &DeformationMaps),
        state: &BodyState,
        force: &GeneralisedForce,
    ) -> (RigidPart, f64) {
        for (f, ((h, k), q)) in
            self.elastic.iter_mut().zip(force.elastic.iter().zip(&data.modal_stiffness).zip(&state.elastic))
        {
            *f = h - k * q;
        }
        let dissipated_power = data.modal_damping.apply(&state.elastic_rates, &mut self.elastic);
        let rigid = if data.has_rotation() {
            self.turning((data, maps), state, force)
        } else {
            self.translating(data, state, force)
        };
        self.rigid = rigid.inertia;
        (rigid, dissipated_power)
    }

    /// Inertia of the frame (lower triangle) and rows `[C_t C_r(q_e)]` of the last
    /// [`BodyWorkspace::assemble`].
    pub(in crate::system) fn inertia(&self) -> (&[[f64; 6]; 6], &[[f64; 6]]) {
        (&self.rigid, &self.coupling)
    }

    /// Rows `[C_t C_r(q_e)]` and elastic forces of the last [`BodyWorkspace::assemble`].
    pub(in crate::system) fn elastic_part(&self) -> (&[[f64; 6]], &[f64]) {
        (&self.coupling, &self.elastic)
    }

    /// Rigid part of a body that does not turn.
    fn translating(
        &mut self,
        data: &StandardInputData,
        state: &BodyState,
        force: &GeneralisedForce,
    ) -> RigidPart {
        for (row, c) in self.coupling.iter_mut().zip(&data.coupling_translation) {
            *row = [c.x, c.y, c.z, 0.0, 0.0, 0.0];
        }
        let local = state.rotation.inverse_transform_vector(&force.force);
        let mut inertia = [[0.0; 6]; 6];
        for (i, row) in inertia.iter_mut().enumerate() {
            row[i] = data.mass; // of the rotations, which never accelerate, any inertia serves
        }
        RigidPart { inertia, force: [local.x, local.y, local.z, 0.0, 0.0, 0.0] }
    }

    /// Rigid part of a body that turns; subtracts centrifugal and Coriolis forces from the elastic
    /// ones (Eq. D.8).
    fn turning(
        &mut self,
        (data, maps): (&StandardInputData, &DeformationMaps),
        state: &BodyState,
        force: &GeneralisedForce,
    ) -> RigidPart {
        maps.sum(data, &state.elastic, &state.elastic_rates, &mut self.sums);
        self.couple(data);
        let omega = &state.angular_velocity_in_body;
        let (q, rates) = (&state.elastic, &state.elastic_rates);
        let (mut mass_moment, mut mass_moment_rate) = (data.mass_moment, Vector3::zeros());
        for ((c, q), rate) in data.coupling_translation.iter().zip(q).zip(rates) {
            mass_moment += c * *q;
            mass_moment_rate += c * *rate;
        }
        let stiffened = data.foreshortening.as_ref().map(|_| self.stiffen(state));
        if let Some(effect) = &stiffened {
            mass_moment += effect.mass_moment;
            mass_moment_rate += effect.mass_moment_rate;
        }
        // Elastic part of h_omega: Σ_ab centrifugal_ab Q_j,ab + 2 ω · ax(∫ ρ (du/dt) φ_jᵀ).
        let centrifugal = omega * omega.transpose() - Matrix3::identity() * omega.norm_squared();
        // Changes of the second moment Σ q_j (P_jᵀ + Q_j), and Π = Σ dq_j/dt Q_j.
        let (mut change, mut spin) = (Matrix3::zeros(), Matrix3::zeros());
        let (n_q, n_c) = (data.n_modes(), data.motion.n_components());
        for (a, b) in (0..n_c).flat_map(|a| (0..n_c).map(move |b| (a, b))) {
            let row = (a * n_c + b) * n_q..(a * n_c + b + 1) * n_q;
            let moments = &self.sums.moments()[row.clone()];
            change[(a, b)] += dot(moments, q);
            change[(b, a)] += dot(&data.position_shape[row], q);
            spin[(a, b)] = dot(moments, rates);
            let weight = centrifugal[(a, b)];
            self.elastic.iter_mut().zip(moments).for_each(|(f, m)| *f -= weight * m);
        }
        let axes = if n_c == 3 { omega.as_slice() } else { &omega.as_slice()[2..] };
        for (weight, moment_rates) in axes.iter().zip(self.sums.moment_rates().chunks_exact(n_q.max(1))) {
            self.elastic.iter_mut().zip(moment_rates).for_each(|(f, r)| *f -= 2.0 * weight * r);
        }
        let second = data.second_moment + 0.5 * (change + change.transpose());
        let inertia = inertia_from(&second);
        let local = state.rotation.inverse_transform_vector(&force.force);
        let mut f = local - omega.cross(&(omega.cross(&mass_moment) + 2.0 * mass_moment_rate));
        let gyroscopic = 2.0 * (omega * spin.trace() - spin.tr_mul(omega));
        let mut torque = force.torque_in_body - omega.cross(&(inertia * omega)) - gyroscopic;
        if let Some(effect) = &stiffened {
            f -= effect.force;
            torque -= effect.torque;
        }
        RigidPart {
            inertia: rigid_inertia(data.mass, &mass_moment, &inertia),
            force: [f.x, f.y, f.z, torque.x, torque.y, torque.z],
        }
    }

    /// Adds geometric stiffening to the coupling with translation (Eq. M.44); returns what it does
    /// to the rigid part.
    fn stiffen(&mut self, state: &BodyState) -> Stiffened {
        let (q, rates) = (&state.elastic, &state.elastic_rates);
        let n_q = q.len();
        let mut effect = Stiffened::default();
        for (j, row) in self.coupling.iter_mut().enumerate() {
            let [by_q, by_rate] = self.sums.moved(j, n_q);
            row.iter_mut().zip(by_q.iter()).for_each(|(c, g)| *c += g);
            effect.mass_moment += by_q * (0.5 * q[j]);
            effect.mass_moment_rate += by_q * rates[j];
            effect.force += by_rate * rates[j];
        }
        // ∫ ρ X × g_ij, twice contracted with the rates; in a plane about z alone.
        let turned = self.sums.turned().chunks_exact(n_q.max(1));
        let first = 3 - turned.len();
        turned.zip(first..).for_each(|(turned, axis)| effect.torque[axis] = dot(turned, rates));
        effect
    }

    /// Rows `[C_t C_r(q_e)]` from the moments of the deformed body.
    fn couple(&mut self, data: &StandardInputData) {
        let (n_q, n_c) = (data.n_modes(), data.motion.n_components());
        let moments = self.sums.moments();
        for (j, (row, c)) in self.coupling.iter_mut().zip(&data.coupling_translation).enumerate() {
            let part =
                |a: usize, b: usize| moments[(a * n_c + b) * n_q + j] - moments[(b * n_c + a) * n_q + j];
            *row = if n_c == 3 {
                [c.x, c.y, c.z, part(1, 2), part(2, 0), part(0, 1)]
            } else {
                [c.x, c.y, c.z, 0.0, 0.0, part(0, 1)]
            };
        }
    }

    /// Moment `(a, b)` of the deformed body with the shapes, `∫ ρ (X + u)_a φ_jb` over `j`.
    pub(super) fn moment(&self, data: &StandardInputData, a: usize, b: usize) -> &[f64] {
        let (n_q, n_c) = (data.n_modes(), data.motion.n_components());
        &self.sums.moments()[(a * n_c + b) * n_q..(a * n_c + b + 1) * n_q]
    }
}

/// Lower triangle of `[m E, -s~; s~, I]`.
pub(super) fn rigid_inertia(mass: f64, mass_moment: &Vector3<f64>, inertia: &Matrix3<f64>) -> [[f64; 6]; 6] {
    let s = skew(mass_moment);
    let mut matrix = [[0.0; 6]; 6];
    for i in 0..3 {
        matrix[i][i] = mass;
        for j in 0..3 {
            matrix[3 + i][j] = s[(i, j)];
            matrix[3 + i][3 + j] = inertia[(i, j)];
        }
    }
    matrix
}

/// Rigid motions that a body may perform, as indices into (x, y, z, rotations about x, y, z) of its
/// frame.
pub(in crate::system) fn active_directions(motion: RigidMotion) -> &'static [usize] {
    match motion {
        RigidMotion::Axial => &[2],
        RigidMotion::Planar => &[0, 1, 5],
        RigidMotion::Spatial => &[0, 1, 2, 3, 4, 5],
    }
}

/// Replaces the lower triangle of the active directions by its Cholesky factor.
pub(super) fn factor_active(l: &mut [[f64; 6]; 6], active: &[usize]) -> Result<(), EvaluationFailure> {
    for (k, &i) in active.iter().enumerate() {
        let scale = l[i][i];
        for (p, &j) in active[..=k].iter().enumerate() {
            let sum: f64 = active[..p].iter().map(|&c| l[i][c] * l[j][c]).sum();
            let rest = l[i][j] - sum;
            if i == j {
                // Round-off of what it was subtracted from is no inertia, and NaN is none either.
                let is_positive = rest > 1e-14 * scale.abs();
                if !is_positive {
                    return Err(MotionFault::FrameInertia { direction: i }.into());
                }
                l[i][i] = rest.sqrt();
            } else {
                l[i][j] = rest / l[j][j];
            }
        }
    }
    Ok(())
}

/// Replaces `x` by the solution with the factor `l`, zero in directions that are not active.
pub(super) fn substitute_active(l: &[[f64; 6]; 6], x: &mut [f64; 6], active: &[usize]) {
    let mut solution = [0.0; 6];
    for (k, &i) in active.iter().enumerate() {
        let sum: f64 = active[..k].iter().map(|&c| l[i][c] * solution[c]).sum();
        solution[i] = (x[i] - sum) / l[i][i];
    }
    for (k, &i) in active.iter().enumerate().rev() {
        let sum: f64 = active[k + 1..].iter().map(|&r| l[r][i] * solution[r]).sum();
        solution[i] = (solution[i] - sum) / l[i][i];
    }
    *x = solution;
}
