//! The elastic part of a body, free or with unknowns clamped: flexibility, products, inertia counts.
//!
//! A free body is held by a statically determinate support `c`. Loads made self-equilibrated by the inertia forces of the
//! rigid motion need no support force, so with `P = 1 - R R^T M`
//!
//! `F = P K_c^-1 P^T` (Eq. R.6, inertia relief)
//!
//! is the exact inverse of `K` on the motions that are mass-orthogonal to the rigid modes `R`.

use std::sync::{Arc, Mutex, PoisonError};

use faer::{Mat, MatMut, MatRef};

use super::dense;
use super::factor::{CholeskyFactor, SolveWorkspace};
use super::inertia::Inertia;
use super::pencil::{Pencil, check_unknowns};
use super::rigid::RigidModes;
use crate::DynamicsError;

/// Right-hand sides that one sweep over the factor serves; more do not make it faster and cost memory.
pub(crate) const SOLVE_COLUMNS: usize = 32;

/// The elastic eigenproblem `K x = lambda M x` of a free or clamped body.
#[derive(Debug)]
pub struct ElasticProblem<'a> {
    pencil: Pencil<'a>,
    /// Unknowns that really cannot move.
    clamped: Vec<bool>,
    /// Unknowns whose rows are taken out of the factor: the clamped ones, or the support of a free body.
    held: Vec<bool>,
    factor: Arc<CholeskyFactor>,
    rigid: Option<Arc<RigidModes>>,
    workspace: Mutex<SolveWorkspace>,
}

impl<'a> ElasticProblem<'a> {
    /// A free body. The `interface` unknowns are eliminated last and take no part in the support.
    ///
    /// # Errors
    /// [`DynamicsError::Inconsistent`] if the data do not fit or too few unknowns outside the interface are left for the
    /// support; [`DynamicsError::NotPositiveDefinite`] if `K` has more zero-energy motions than the rigid ones.
    pub fn free(body: &'a crate::body::AssembledBody, interface: &[usize]) -> Result<Self, DynamicsError> {
        let pencil = Pencil::new(body, interface)?;
        let rigid = Arc::new(RigidModes::new(body)?);
        let n = body.n_unknowns();
        let mut in_interface = vec![false; n];
        interface.iter().for_each(|&i| in_interface[i] = true);
        let support = dense::pivot_rows(rigid.modes.as_ref(), |i| !in_interface[i]);
        if support.len() < rigid.count() {
            let reason = format!(
                "the {} unknowns outside the interface hold {} of {} rigid motions, make the interface smaller",
                n - interface.len(),
                support.len(),
                rigid.count()
            );
            return Err(DynamicsError::Inconsistent { reason });
        }
        let mut held = vec![false; n];
        support.iter().for_each(|&i| held[i] = true);
        Self::assemble(pencil, vec![false; n], held, Some(rigid))
    }

    /// The body of `pencil` with the unknowns `fixed` clamped.
    ///
    /// # Errors
    /// [`DynamicsError::Inconsistent`] if the clamped unknowns leave a rigid motion free.
    pub fn clamped(pencil: Pencil<'a>, fixed: &[usize]) -> Result<Self, DynamicsError> {
        let body = pencil.body();
        check_unknowns(fixed, body.n_unknowns())?;
        let mut clamped = vec![false; body.n_unknowns()];
        fixed.iter().for_each(|&i| clamped[i] = true);
        if let Ok(rigid) = RigidModes::new(body) {
            let held = dense::pivot_rows(rigid.modes.as_ref(), |i| clamped[i]).len();
            if held < rigid.count() {
                let reason = format!(
                    "the {} clamped unknowns leave {} rigid motions free, add points that are not in line",
                    fixed.len(),
                    rigid.count() - held
                );
                return Err(DynamicsError::Inconsistent { reason });
            }
        }
        let held = clamped.clone();
        Self::assemble(pencil, clamped, held, None)
    }

    fn assemble(
        pencil: Pencil<'a>,
        clamped: Vec<bool>,
        held: Vec<bool>,
        rigid: Option<Arc<RigidModes>>,
    ) -> Result<Self, DynamicsError> {
        let factor = Arc::new(pencil.cholesky(0.0, &held)?);
        let workspace = Mutex::new(factor.workspace(SOLVE_COLUMNS));
        Ok(Self { pencil, clamped, held, factor, rigid, workspace })
    }

    /// The pair of matrices.
    pub fn pencil(&self) -> &Pencil<'a> {
        &self.pencil
    }

    /// Factor of the supported or clamped stiffness matrix.
    pub fn factor(&self) -> &Arc<CholeskyFactor> {
        &self.factor
    }

    /// Rigid modes of a free body.
    pub fn rigid(&self) -> Option<&Arc<RigidModes>> {
        self.rigid.as_ref()
    }

    /// Unknowns without rows in the factor.
    pub fn held(&self) -> &[bool] {
        &self.held
    }

    /// Unknowns that are clamped.
    pub fn clamped_unknowns(&self) -> &[bool] {
        &self.clamped
    }

    /// Number of rigid modes, 0 if clamped.
    pub fn n_rigid(&self) -> usize {
        self.rigid.as_ref().map_or(0, |r| r.count())
    }

    /// Number of unknowns, clamped ones included.
    pub fn n_unknowns(&self) -> usize {
        self.clamped.len()
    }

    /// Number of elastic modes there are.
    pub fn n_elastic(&self) -> usize {
        self.clamped.iter().filter(|&&c| !c).count() - self.n_rigid()
    }

    /// Replaces forces (n x k) by the displacements `F f`, mass-orthogonal to the rigid modes.
    pub fn apply_flexibility(&self, mut x: MatMut<'_, f64>) {
        if let Some(rigid) = &self.rigid {
            let resultant = dense::product(rigid.modes.transpose(), x.as_ref());
            dense::add_product(x.as_mut(), -1.0, rigid.mass_modes.as_ref(), resultant.as_ref());
        }
        self.solve_held(x.as_mut());
        self.remove_rigid(x);
    }

    /// `K_c^-1 f` with zero at the held unknowns.
    pub fn solve_held(&self, mut x: MatMut<'_, f64>) {
        self.clear(x.as_mut(), &self.held);
        let mut workspace = self.workspace.lock().unwrap_or_else(PoisonError::into_inner);
        self.factor.solve_in_place(x, &mut workspace);
    }

    /// Makes displacements (n x k) mass-orthogonal to the rigid modes and zero where clamped.
    pub fn remove_rigid(&self, mut x: MatMut<'_, f64>) {
        if let Some(rigid) = &self.rigid {
            let part = dense::product(rigid.mass_modes.transpose(), x.as_ref());
            dense::add_product(x.as_mut(), -1.0, rigid.modes.as_ref(), part.as_ref());
        } else {
            self.clear(x, &self.clamped);
        }
    }

    fn clear(&self, mut x: MatMut<'_, f64>, which: &[bool]) {
        for (i, _) in which.iter().enumerate().filter(|&(_, &held)| held) {
            x.as_mut().row_mut(i).iter_mut().for_each(|v| *v = 0.0);
        }
    }

    /// `M x`.
    pub fn mass_product(&self, x: MatRef<'_, f64>) -> Mat<f64> {
        self.pencil.body().mass_product(x)
    }

    /// `K x`.
    pub fn stiffness_product(&self, x: MatRef<'_, f64>) -> Mat<f64> {
        self.pencil.body().stiffness_product(x)
    }

    /// Inertia of `K - mu M`; rigid modes count as eigenvalues below any positive `mu`.
    ///
    /// # Errors
    /// [`DynamicsError::Factorisation`] if memory runs out.
    pub fn inertia(&self, mu: f64) -> Result<Inertia, DynamicsError> {
        self.pencil.inertia(mu, &self.clamped)
    }

    /// As [`Self::inertia`] in single precision; `None` if the matrix is small, or the factor too inaccurate to count.
    ///
    /// # Errors
    /// [`DynamicsError::Factorisation`] if memory runs out.
    pub fn inertia_single(&self, mu: f64) -> Result<Option<Inertia>, DynamicsError> {
        self.pencil.inertia_single(mu, &self.clamped)
    }
}
