//! The modes behind a residual flexibility: what of the interface's own vibration quasistatic
//! contact leaves out (docs/theory.md Eqs. R.25, R.26).
//!
//! The quasistatic displacements `X = F_res B` under unit forces at the interface span all that an
//! interface can do beyond the rigid and low-frequency motions. On their span stiffness is the
//! compliance `G = Bᵀ X` itself, and the mass matrix makes modes of them, as many as there are
//! interface unknowns.

use faer::Mat;

use super::ResidualFlexibility;
use crate::DynamicsError;
use crate::body::AssembledBody;
use crate::reduction::blocks::dense;
use crate::reduction::problem::SOLVE_COLUMNS;

/// High-frequency modes of an interface.
#[derive(Debug, Clone, PartialEq)]
pub struct ResidualModes {
    /// Angular eigenfrequencies, ascending [rad/s].
    pub omega: Vec<f64>,
    /// Displacements of the interface unknowns in the mass-orthonormal modes, n_b x n_b
    /// [1/sqrt(kg)].
    pub interface_shapes: Mat<f64>,
}

impl ResidualModes {
    /// The modes of `residual`, which was made from the matrices of `body`. Takes `n n_b` numbers
    /// of memory.
    ///
    /// # Errors
    /// [`DynamicsError::NotPositiveDefinite`] if interface unknowns depend on each other or on the low-frequency motions;
    /// [`DynamicsError::Factorisation`] if the eigenvalue iteration fails.
    pub fn new(residual: &ResidualFlexibility, body: &AssembledBody) -> Result<Self, DynamicsError> {
        let (interface, low) = (residual.interface(), residual.low_modes());
        let (n, n_b) = (body.n_unknowns(), interface.len());
        let mut x = Mat::from_fn(n, n_b, |i, j| if i == interface[j] { 1.0 } else { 0.0 });
        residual.apply(x.as_mut());
        let mut mass = Mat::zeros(n_b, n_b);
        let mut shared = Mat::zeros(low.ncols(), n_b);
        for first in (0..n_b).step_by(SOLVE_COLUMNS) {
            let width = SOLVE_COLUMNS.min(n_b - first);
            let momenta = body.mass_product(x.as_ref().subcols(first, width));
            mass.as_mut()
                .subcols_mut(first, width)
                .copy_from(dense::product(x.transpose(), momenta.as_ref()));
            shared
                .as_mut()
                .subcols_mut(first, width)
                .copy_from(dense::product(low.transpose(), momenta.as_ref()));
        }
        // What low-frequency modes that are not quite the body's own have in common with them stays
        // theirs.
        dense::add_product(mass.as_mut(), -1.0, shared.transpose(), shared.as_ref());
        dense::symmetrise(&mut mass);
        let modes = PencilModes::new(residual.compliance(), mass)?;
        Ok(Self { interface_shapes: modes.shapes(), omega: modes.omega })
    }
}

/// Modes `M v = ω⁻² G v` of static answers `X` to unit loads, whose stiffness is their compliance
/// `G = L Lᵀ` (Eq. R.26).
///
/// By the factor of `G`, whose condition is the better one: the highest modes keep their digits.
pub(in crate::reduction) struct PencilModes {
    /// Angular eigenfrequencies, ascending [rad/s].
    pub omega: Vec<f64>,
    l: Mat<f64>,
    /// `ω w`, mode by mode.
    scaled: Mat<f64>,
}

impl PencilModes {
    /// # Errors
    /// [`DynamicsError::NotPositiveDefinite`] if answers depend on each other; [`DynamicsError::Factorisation`].
    pub fn new(compliance: &Mat<f64>, mass: Mat<f64>) -> Result<Self, DynamicsError> {
        let l = dense::cholesky(compliance.clone(), "the residual compliance")?;
        let mut half = mass;
        dense::solve_lower(l.as_ref(), half.as_mut());
        let mut reduced = half.transpose().to_owned();
        dense::solve_lower(l.as_ref(), reduced.as_mut());
        dense::symmetrise(&mut reduced);
        let (periods, vectors) = dense::symmetric_eigen(reduced.as_ref())?;
        let size = periods.len();
        if let Some(pivot) = periods.iter().position(|p| p.is_nan() || *p <= 0.0) {
            let matrix = "the mass of static answers";
            return Err(DynamicsError::NotPositiveDefinite { matrix, pivot, size });
        }
        // Ascending in frequency.
        let omega: Vec<f64> = periods.iter().rev().map(|p| 1.0 / p.sqrt()).collect();
        let scaled = Mat::from_fn(size, size, |i, j| vectors[(i, size - 1 - j)] * omega[j]);
        Ok(Self { omega, l, scaled })
    }

    /// Mass-orthonormal modes where the loads act: `ω L w`.
    pub fn shapes(&self) -> Mat<f64> {
        dense::product(self.l.as_ref(), self.scaled.as_ref())
    }

    /// The modes in terms of the answers: `ω L⁻ᵀ w`.
    pub fn coordinates(&self) -> Mat<f64> {
        let mut coordinates = self.scaled.clone();
        dense::solve_lower_transposed(self.l.as_ref(), coordinates.as_mut());
        coordinates
    }
}
