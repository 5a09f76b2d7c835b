//! Residual flexibility of the contact interface (Eqs. R.22 to R.24).
//!
//! `G = Phi_hf,b K_hf^-1 Phi_hf,b^T` is what quasistatic contact needs of all high-frequency modes
//! together. [`ResidualFlexibility`] takes the inverse of the trailing Cholesky block and removes
//! the rigid and low-frequency parts, without any high-frequency mode.

pub mod residual_modes;

use std::sync::Arc;

use faer::{Mat, MatMut, MatRef};

use super::blocks::dense;
use super::factor::CholeskyFactor;
use super::modal::{LowModes, ReducedBasis};
use super::problem::ElasticProblem;
use super::rigid::RigidModes;
use crate::DynamicsError;
use crate::data_error::DataError;

/// Flexibility of a free body at its interface without its rigid motions, `F` of Eq. R.23.
///
/// Owns the factorisation, so it outlives the assembled matrices; clones share it.
#[derive(Debug, Clone)]
pub struct FreeFlexibility {
    factor: Arc<CholeskyFactor>,
    held: Vec<bool>,
    rigid: Arc<RigidModes>,
    interface: Vec<usize>,
    compliance: Mat<f64>,
}

impl FreeFlexibility {
    /// The flexibility of a free problem whose `interface` was eliminated last.
    ///
    /// # Errors
    /// [`DynamicsError::Data`] if the problem is clamped, or was built for another interface.
    pub fn new(problem: &ElasticProblem<'_>, interface: &[usize]) -> Result<Self, DynamicsError> {
        let rigid = problem
            .rigid()
            .ok_or(DataError::NotInModel { model: "clamped", what: "inertia-relief flexibility" })?;
        let factor = problem.factor()?;
        if !factor.symbolic().ends_with(interface) {
            return Err(DataError::ForeignInterface.into());
        }
        let mut flexibility = Self {
            held: problem.held().to_vec(),
            rigid: Arc::clone(rigid),
            interface: interface.to_vec(),
            factor,
            compliance: Mat::zeros(0, 0),
        };
        flexibility.compliance = flexibility.interface_compliance();
        Ok(flexibility)
    }

    /// Displacements of the interface under forces on it in a frame in which the body does not
    /// turn, n_b x n_b \[m/N\].
    pub fn compliance(&self) -> &Mat<f64> {
        &self.compliance
    }

    /// The same without the modes `low` (Eq. R.22). These, all forces and displacements are of the
    /// body turned by `turn`.
    ///
    /// # Errors
    /// [`DynamicsError::Data`] if the modes have not one row per unknown.
    pub fn without(
        self,
        low: LowModes,
        turn: Option<BodyTurn>,
    ) -> Result<ResidualFlexibility, DynamicsError> {
        if low.shapes.nrows() != self.held.len() {
            let (what, found) = ("rows of the modes".into(), low.shapes.nrows());
            return Err(DataError::Count { what, found, expected: self.held.len() }.into());
        }
        let compliance = low.take_out(self.compliance.clone(), &self.interface, turn);
        Ok(ResidualFlexibility { free: self, low, turn, compliance })
    }

    /// Replaces forces (n x k) by displacements, without rigid motions.
    fn apply(&self, mut x: MatMut<'_, f64>) {
        let rigid = &self.rigid;
        let resultant = dense::product(rigid.modes.transpose(), x.as_ref());
        dense::add_product(x.as_mut(), -1.0, rigid.mass_modes.as_ref(), resultant.as_ref());
        self.solve_held(x.as_mut());
        let part = dense::product(rigid.mass_modes.transpose(), x.as_ref());
        dense::add_product(x, -1.0, rigid.modes.as_ref(), part.as_ref());
    }

    fn solve_held(&self, mut x: MatMut<'_, f64>) {
        for (i, _) in self.held.iter().enumerate().filter(|&(_, &held)| held) {
            x.as_mut().row_mut(i).iter_mut().for_each(|v| *v = 0.0);
        }
        self.factor.solve_in_place(x);
    }

    /// From the trailing block of the factor (Eq. R.23).
    fn interface_compliance(&self) -> Mat<f64> {
        let n_b = self.interface.len();
        let rows = |m: &Mat<f64>| Mat::from_fn(n_b, m.ncols(), |i, j| m[(self.interface[i], j)]);
        let mut g = dense::inverse_of_factor(self.factor.trailing_block(n_b).as_ref());
        // Held unknowns have a row of their own in the factor, and no displacement.
        for (i, _) in self.interface.iter().enumerate().filter(|(_, unknown)| self.held[**unknown]) {
            g.row_mut(i).fill(0.0);
            g.col_mut(i).fill(0.0);
        }

        let mut v = self.rigid.mass_modes.clone();
        self.solve_held(v.as_mut());
        let inertia = dense::product(self.rigid.mass_modes.transpose(), v.as_ref());
        let (r_b, v_b) = (rows(&self.rigid.modes), rows(&v));
        dense::add_product(g.as_mut(), -1.0, v_b.as_ref(), r_b.transpose());
        dense::add_product(g.as_mut(), -1.0, r_b.as_ref(), v_b.transpose());
        let weighed = dense::product(r_b.as_ref(), inertia.as_ref());
        dense::add_product(g.as_mut(), 1.0, weighed.as_ref(), r_b.transpose());
        dense::symmetrise(&mut g);
        g
    }
}

impl LowModes {
    /// `G` (Eq. R.22) at the unknowns `interface` of a body turned by `turn`, whose modes these
    /// are, from the compliance `free` ([`FreeFlexibility`]) of the body as it was.
    pub fn take_out(&self, mut free: Mat<f64>, interface: &[usize], turn: Option<BodyTurn>) -> Mat<f64> {
        if let Some(turn) = turn {
            turn.turn(free.as_mut());
            turn.turn(free.as_mut().transpose_mut());
        }
        let scaled = Mat::from_fn(interface.len(), self.omega.len(), |i, j| {
            self.shapes[(interface[i], j)] / self.omega[j]
        });
        dense::add_product(free.as_mut(), -1.0, scaled.as_ref(), scaled.transpose());
        dense::symmetrise(&mut free);
        free
    }
}

/// A rotation of a body whose unknowns are all components of its nodes, one node after the other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BodyTurn {
    /// Rows of the rotation.
    pub rotation: [[f64; 3]; 3],
    /// Components of a node, the first two or all three.
    pub n_components: usize,
}

impl BodyTurn {
    /// Turns the vectors of nodes in the columns of `x`.
    pub fn turn(&self, x: MatMut<'_, f64>) {
        self.rotate(x, |to, from| self.rotation[to][from]);
    }

    /// Turns them back.
    pub fn turn_back(&self, x: MatMut<'_, f64>) {
        self.rotate(x, |to, from| self.rotation[from][to]);
    }

    fn rotate(&self, mut x: MatMut<'_, f64>, entry: impl Fn(usize, usize) -> f64) {
        let n = self.n_components;
        debug_assert!(n <= 3 && x.nrows().is_multiple_of(n), "whole nodes");
        for j in 0..x.ncols() {
            for first in (0..x.nrows()).step_by(n) {
                let mut vector = [0.0; 3];
                (0..n).for_each(|c| vector[c] = x[(first + c, j)]);
                (0..n).for_each(|to| {
                    x[(first + to, j)] = (0..n).map(|from| entry(to, from) * vector[from]).sum();
                });
            }
        }
    }
}

/// Flexibility of a free body without its rigid and low-frequency motions:
/// `u_hf = F f - Phi_lf omega_lf^-2 Phi_lf^T f`.
#[derive(Debug)]
pub struct ResidualFlexibility {
    free: FreeFlexibility,
    low: LowModes,
    turn: Option<BodyTurn>,
    compliance: Mat<f64>,
}

impl ResidualFlexibility {
    /// Route 2 on a free problem whose `interface` was eliminated last; the first `n_low` shapes of
    /// `low` are removed.
    ///
    /// # Errors
    /// As [`FreeFlexibility::new`] and [`FreeFlexibility::without`].
    pub fn new(
        problem: &ElasticProblem<'_>,
        interface: &[usize],
        low: &ReducedBasis,
    ) -> Result<Self, DynamicsError> {
        FreeFlexibility::new(problem, interface)?.without(low.low_modes(), None)
    }

    /// Number of unknowns of the body.
    pub fn n_unknowns(&self) -> usize {
        self.free.held.len()
    }

    /// Interface unknowns, in the order of [`Self::compliance`].
    pub fn interface(&self) -> &[usize] {
        &self.free.interface
    }

    /// The low-frequency modes that are taken out, n x n_low.
    fn low_modes(&self) -> MatRef<'_, f64> {
        self.low.shapes.as_ref()
    }

    /// `G`, n_b x n_b, symmetric positive semidefinite [m/N].
    pub fn compliance(&self) -> &Mat<f64> {
        &self.compliance
    }

    /// Replaces forces on all unknowns (n x k) \[N\] by the quasistatic displacements \[m\].
    ///
    /// # Panics
    /// If `x` has not one row per unknown.
    pub fn apply(&self, mut x: MatMut<'_, f64>) {
        let low = self.low.shapes.as_ref();
        let mut amplitudes = dense::product(low.transpose(), x.as_ref());
        for j in 0..amplitudes.ncols() {
            for (i, omega) in self.low.omega.iter().enumerate() {
                amplitudes[(i, j)] /= omega * omega;
            }
        }
        if let Some(turn) = &self.turn {
            turn.turn_back(x.as_mut());
        }
        self.free.apply(x.as_mut());
        if let Some(turn) = &self.turn {
            turn.turn(x.as_mut());
        }
        dense::add_product(x, -1.0, low, amplitudes.as_ref());
    }

    /// Quasistatic displacement of all unknowns \[m\] under forces at the interface unknowns \[N\].
    ///
    /// # Panics
    /// If there is not one force per interface unknown.
    pub fn displacement(&self, interface_forces: &[f64]) -> Vec<f64> {
        assert_eq!(interface_forces.len(), self.interface().len(), "one force per interface unknown");
        let mut x = Mat::zeros(self.n_unknowns(), 1);
        for (&i, &force) in self.interface().iter().zip(interface_forces) {
            x[(i, 0)] = force;
        }
        self.apply(x.as_mut());
        x.col(0).iter().copied().collect()
    }
}
