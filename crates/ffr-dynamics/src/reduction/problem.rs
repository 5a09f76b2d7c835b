//! The elastic part of a body, free or with unknowns clamped: flexibility, products, inertia
//! counts.
//!
//! A free body is held by a statically determinate support `c`. Loads made self-equilibrated by the
//! inertia forces of the rigid motion need no support force, so with `P = 1 - R R^T M`
//!
//! `F = P K_c^-1 P^T` (Eq. R.10, inertia relief)
//!
//! is the exact inverse of `K` on the motions that are mass-orthogonal to the rigid modes `R`.

mod point_support;

use std::sync::Arc;

use faer::{Mat, MatMut, MatRef};

use super::blocks::dense;
use super::blocks::random::Random;
use super::factor::CholeskyFactor;
use super::factor::single_precision::SinglePrecisionFactor;
use super::pencil::{Pencil, check_unknowns};
use super::rigid::RigidModes;
use crate::DynamicsError;
use crate::data_error::DataError;

/// Right-hand sides that one sweep over the factor serves; more do not make it faster and cost
/// memory.
pub(crate) const SOLVE_COLUMNS: usize = 32;

/// Accuracy of the flexibility, in the energy norm, in the search for the space of the eigenmodes,
/// which one solve with a factor in single precision reaches: the stiffness itself picks the modes
/// from the space.
pub(super) const SEARCH_ACCURACY: f64 = CONTRACTION_LIMIT;
/// Accuracy in the energy norm with which the modes are then cleaned up: their frequencies err by
/// its square.
pub(super) const CLEAN_ACCURACY: f64 = 1e-5;
/// Accuracy of the flexibility elsewhere: what double precision leaves of a stiffness matrix.
const FULL_ACCURACY: f64 = 1e-12;
/// A factor in single precision is used if refinement shrinks the error at least by this factor.
const CONTRACTION_LIMIT: f64 = 0.1;
/// Random loads and solves by which that factor is measured; the first solve leaves errors that
/// later ones do not.
const PROBES: usize = 4;
const PROBE_STEPS: usize = 3;
/// Refinements that reach any accuracy asked for with this contraction, and some to spare.
const MAX_REFINEMENTS: usize = 10;

/// The factorised stiffness.
#[derive(Debug)]
enum Factor {
    Double(Arc<CholeskyFactor>),
    /// Refined with `K`; every refinement shrinks the error by `contraction`.
    Single {
        single_precision: SinglePrecisionFactor,
        contraction: f64,
    },
}

/// The elastic eigenproblem `K x = lambda M x` of a free or clamped body.
#[derive(Debug)]
pub struct ElasticProblem<'a> {
    pencil: Pencil<'a>,
    /// Unknowns that really cannot move.
    clamped: Vec<bool>,
    /// Unknowns whose rows are taken out of the factor: the clamped ones, or the support of a free
    /// body.
    held: Vec<bool>,
    factor: Factor,
    rigid: Option<Arc<RigidModes>>,
}

impl<'a> ElasticProblem<'a> {
    /// A free body. The `interface` unknowns are eliminated last, and take part in the support only
    /// if the others cannot hold the body, as where the interface is the whole surface of a thin
    /// body.
    ///
    /// # Errors
    /// [`DynamicsError::Data`] if the data do not fit; [`DynamicsError::NotPositiveDefinite`] if `K` has more zero-energy motions than the
    /// rigid ones.
    pub fn free(body: &'a crate::body::AssembledBody, interface: &[usize]) -> Result<Self, DynamicsError> {
        Self::free_on(Pencil::new(body, interface)?, interface)
    }

    /// As [`Self::free`] with the `pencil` of the body, which eliminates the `interface` unknowns
    /// last.
    ///
    /// # Errors
    /// As [`Self::free`].
    pub fn free_on(pencil: Pencil<'a>, interface: &[usize]) -> Result<Self, DynamicsError> {
        pencil.tell_cost(interface.len());
        let body = pencil.body();
        let rigid = Arc::new(RigidModes::new(body)?);
        let n = body.n_unknowns();
        let mut in_interface = vec![false; n];
        interface.iter().for_each(|&i| in_interface[i] = true);
        let mut support = dense::pivot_rows(rigid.modes.as_ref(), |i| !in_interface[i]);
        if support.len() < rigid.count() {
            support = dense::pivot_rows(rigid.modes.as_ref(), |_| true);
        }
        let mut held = vec![false; n];
        support.iter().for_each(|&i| held[i] = true);
        let clamped = vec![false; n];
        // The compliance of an interface is read from the factor in double precision.
        if interface.is_empty()
            && let Some(problem) = Self::single_precision(pencil.clone(), &clamped, &held, &rigid)?
        {
            return Ok(problem);
        }
        Self::assemble(pencil, clamped, held, Some(rigid))
    }

    /// The body of `pencil` with the unknowns `fixed` clamped.
    ///
    /// # Errors
    /// [`DynamicsError::Data`] if the clamped unknowns leave a rigid motion free.
    pub fn clamped(pencil: Pencil<'a>, fixed: &[usize]) -> Result<Self, DynamicsError> {
        let body = pencil.body();
        check_unknowns(fixed, body.n_unknowns())?;
        let mut clamped = vec![false; body.n_unknowns()];
        fixed.iter().for_each(|&i| clamped[i] = true);
        if let Ok(rigid) = RigidModes::new(body) {
            let held = dense::pivot_rows(rigid.modes.as_ref(), |i| clamped[i]).len();
            if held < rigid.count() {
                let (support, free) = (format!("the {} clamped unknowns", fixed.len()), rigid.count() - held);
                return Err(
                    DataError::NotHeld { support, free, remedy: "add points that are not in line" }.into()
                );
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
        Ok(Self { pencil, clamped, held, factor: Factor::Double(factor), rigid })
    }

    /// The free body with a factor in single precision; `None` if the model is small or the factor
    /// not accurate enough.
    fn single_precision(
        pencil: Pencil<'a>,
        clamped: &[bool],
        held: &[bool],
        rigid: &Arc<RigidModes>,
    ) -> Result<Option<Self>, DynamicsError> {
        let Some(single_precision) = pencil.single_precision(held)? else { return Ok(None) };
        let factor = Factor::Single { single_precision, contraction: 0.0 };
        let (clamped, held) = (clamped.to_vec(), held.to_vec());
        let mut problem = Self { pencil, clamped, held, factor, rigid: Some(Arc::clone(rigid)) };
        let measured = problem.measure_contraction();
        tracing::debug!(contraction = measured, "stiffness factorised in single precision");
        if let Factor::Single { contraction, .. } = &mut problem.factor {
            *contraction = measured;
        }
        if measured <= CONTRACTION_LIMIT {
            return Ok(Some(problem));
        }
        problem.pencil.note_too_few_digits();
        Ok(None)
    }

    /// The same problem with a factor in double precision.
    pub(super) fn in_double_precision(&self) -> Result<Self, DynamicsError> {
        Self::assemble(self.pencil.clone(), self.clamped.clone(), self.held.clone(), self.rigid.clone())
    }

    /// Whether the factor is in single precision.
    pub(super) fn is_single_precision(&self) -> bool {
        self.contraction().is_some()
    }

    /// By how much a refinement shrinks the error of a factor in single precision.
    pub(super) fn contraction(&self) -> Option<f64> {
        match self.factor {
            Factor::Single { contraction, .. } => Some(contraction),
            Factor::Double(_) => None,
        }
    }

    /// The pair of matrices.
    pub fn pencil(&self) -> &Pencil<'a> {
        &self.pencil
    }

    /// Factor of the supported or clamped stiffness matrix in double precision; made anew if the
    /// problem was factorised in single precision, as large free bodies without interface are.
    ///
    /// # Errors
    /// [`DynamicsError::NotPositiveDefinite`] or [`DynamicsError::Factorisation`].
    pub fn factor(&self) -> Result<Arc<CholeskyFactor>, DynamicsError> {
        match &self.factor {
            Factor::Double(factor) => Ok(Arc::clone(factor)),
            Factor::Single { .. } => self.pencil.cholesky(0.0, &self.held).map(Arc::new),
        }
    }

    /// Rigid modes of a free body.
    pub fn rigid(&self) -> Option<&Arc<RigidModes>> {
        self.rigid.as_ref()
    }

    /// Rigid modes, of a problem that must be free.
    ///
    /// # Errors
    /// [`DynamicsError::Data`] if it is clamped.
    pub fn free_rigid(&self) -> Result<Arc<RigidModes>, DynamicsError> {
        let missing = DataError::NotInModel { model: "clamped", what: "floating frame" };
        Ok(self.rigid.clone().ok_or(missing)?)
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
    pub fn apply_flexibility(&self, x: MatMut<'_, f64>) {
        self.flexibility_within(FULL_ACCURACY, x);
    }

    /// As [`Self::apply_flexibility`], with a relative error of about `accuracy` in the energy norm
    /// if the factor is in single precision.
    pub(super) fn flexibility_within(&self, accuracy: f64, mut x: MatMut<'_, f64>) {
        if let Some(rigid) = &self.rigid {
            let resultant = dense::product(rigid.modes.transpose(), x.as_ref());
            dense::add_product(x.as_mut(), -1.0, rigid.mass_modes.as_ref(), resultant.as_ref());
        }
        match &self.factor {
            Factor::Double(..) => self.solve_held(x.as_mut()),
            Factor::Single { single_precision, contraction } => {
                self.refine(
                    single_precision,
                    x.as_mut(),
                    |d| self.remove_rigid(d),
                    |change, _| change * contraction <= accuracy,
                );
            }
        }
        self.remove_rigid(x);
    }

    /// `K_c^-1 f` with zero at the held unknowns.
    pub fn solve_held(&self, mut x: MatMut<'_, f64>) {
        self.clear(x.as_mut(), &self.held);
        match &self.factor {
            Factor::Double(factor) => factor.solve_in_place(x),
            Factor::Single { single_precision, contraction } => {
                self.refine(single_precision, x, |_| (), |change, _| change * contraction <= FULL_ACCURACY);
            }
        }
    }

    /// Solves `K_c x = b` in place by refinement (Eq. R.6): `x <- x + P^-1 (b - K x)` with the
    /// rounded factor `P`.
    ///
    /// `project` takes out of a correction what `K` does not see. It ends when
    /// `is_enough(change, refinement)` of the largest relative change of a column in the energy
    /// norm.
    fn refine(
        &self,
        single_precision: &SinglePrecisionFactor,
        mut x: MatMut<'_, f64>,
        project: impl Fn(MatMut<'_, f64>),
        mut is_enough: impl FnMut(f64, usize) -> bool,
    ) {
        let load = x.to_owned();
        let mut residual = load.clone();
        x.fill(0.0);
        for refinement in 0..=MAX_REFINEMENTS {
            let mut correction = residual.clone();
            self.clear(correction.as_mut(), &self.held);
            single_precision.solve_in_place(correction.as_mut());
            project(correction.as_mut());
            x += &correction;
            let change = largest_ratio(correction.as_ref(), residual.as_ref(), x.as_ref(), load.as_ref());
            if is_enough(change, refinement) {
                return;
            }
            residual = &load - self.stiffness_product(x.as_ref());
            self.clear(residual.as_mut(), &self.clamped);
        }
    }

    /// By how much a refinement shrinks the error of a smooth answer; not a number, or large, if it
    /// does not.
    fn measure_contraction(&self) -> f64 {
        let Factor::Single { single_precision, .. } = &self.factor else { return 0.0 };
        let mut random = Random::new(0x5eed);
        let start = Mat::from_fn(self.n_unknowns(), PROBES, |_, _| random.next());
        let mut x = self.mass_product(start.as_ref());
        if let Some(rigid) = &self.rigid {
            let resultant = dense::product(rigid.modes.transpose(), x.as_ref());
            dense::add_product(x.as_mut(), -1.0, rigid.mass_modes.as_ref(), resultant.as_ref());
        }
        let mut changes = [f64::NAN; PROBE_STEPS];
        self.refine(
            single_precision,
            x.as_mut(),
            |d| self.remove_rigid(d),
            |change, step| {
                changes[step] = change;
                step + 1 == PROBE_STEPS
            },
        );
        changes[PROBE_STEPS - 1] / changes[PROBE_STEPS - 2]
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
}

/// Largest ratio, over the columns, of the energies of a correction and of the whole answer, as a
/// ratio of lengths.
fn largest_ratio(
    correction: MatRef<'_, f64>,
    residual: MatRef<'_, f64>,
    x: MatRef<'_, f64>,
    load: MatRef<'_, f64>,
) -> f64 {
    let energy = |a: MatRef<'_, f64>, b: MatRef<'_, f64>, j: usize| (a.col(j).transpose() * b.col(j)).abs();
    let ratios = (0..x.ncols()).map(|j| {
        let whole = energy(x, load, j);
        if whole > 0.0 { (energy(correction, residual, j) / whole).sqrt() } else { 0.0 }
    });
    ratios.fold(0.0, |a: f64, r| if r.is_nan() || a.is_nan() { f64::NAN } else { a.max(r) })
}
