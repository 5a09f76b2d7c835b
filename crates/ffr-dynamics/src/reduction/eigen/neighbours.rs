//! Eigenvalues on both sides of a shift, and how many lie below it (Eqs. R.7, R.15).
//!
//! `(K - mu M)^-1 M` has the eigenvalues `1 / (lambda - mu)`. Those next to the shift are the
//! largest on either side and stand after a few blocks, however many lie below; the factor that is
//! solved with tells how many that are.

use faer::{Mat, MatMut, MatRef};

use super::lanczos::{Lanczos, Operator};
use crate::DynamicsError;
use crate::body::{AssembledBody, RigidMotion};
use crate::reduction::pencil::Pencil;
use crate::reduction::pencil::inertia::ShiftedFactor;

/// Lanczos residual of an eigenvalue that stands: its distance from the shift errs by the square.
const CONVERGED: f64 = 1e-3;
/// Basis vectors after which the search is given up.
const CAPACITY: usize = 240;

/// Eigenvalues next to a shift.
#[derive(Debug, Clone, PartialEq)]
pub struct Neighbours {
    /// Number of eigenvalues below the shift, rigid ones included.
    pub below: usize,
    /// The one next to the shift on its lower side, then those above it, in ascending order [(rad/s)²].
    pub next: Vec<f64>,
}

/// `(K - mu M)^-1` on a free body, to the accuracy of the factor.
struct Shifted<'a> {
    body: &'a AssembledBody,
    factor: ShiftedFactor,
}

impl Operator for Shifted<'_> {
    fn n_unknowns(&self) -> usize {
        self.body.n_unknowns()
    }

    fn apply(&self, x: MatMut<'_, f64>) {
        self.factor.solve_in_place(x);
    }

    fn mass_product(&self, x: MatRef<'_, f64>) -> Mat<f64> {
        self.body.mass_product(x)
    }

    /// Rigid modes are eigenvectors like others, far from the shift.
    fn project(&self, _x: MatMut<'_, f64>) {}
}

impl Pencil<'_> {
    /// How many eigenvalues lie below `mu` [(rad/s)²], and the one next to it on its lower side and `n_upper` ones above it, of the
    /// body with no unknown clamped; none of these if they do not converge, as where `mu` sits on an
    /// eigenvalue, if there are no such, or if `most` and more lie below.
    ///
    /// # Errors
    /// [`DynamicsError::FactorTooLarge`] if memory does not suffice.
    pub fn neighbours(&self, mu: f64, n_upper: usize, most: usize) -> Result<Neighbours, DynamicsError> {
        let (inertia, factor) = self.shifted(mu)?;
        let mut found = Neighbours { below: inertia.negative, next: Vec::new() };
        let Some(factor) = factor.filter(|_| found.below < most) else { return Ok(found) };
        let operator = Shifted { body: self.body(), factor };
        let width = if self.body().motion == RigidMotion::Spatial { 8 } else { 4 };
        let mut run = Lanczos::new(&operator, width, CAPACITY)?;
        while run.has_room() {
            run.step()?;
            if run.size() <= n_upper {
                continue;
            }
            let ritz = run.ritz()?;
            let last = ritz.theta.len() - 1;
            let stands =
                ritz.residuals[..n_upper].iter().chain(&ritz.residuals[last..]).all(|r| *r <= CONVERGED);
            if stands && ritz.theta[n_upper - 1] > 0.0 && ritz.theta[last] < 0.0 {
                let lambda = |theta: &f64| mu + 1.0 / theta;
                tracing::debug!(below = found.below, size = run.size(), "eigenvalues next to a shift");
                let next = ritz.theta[last..].iter().take(1).chain(&ritz.theta[..n_upper]);
                found.next = next.map(lambda).collect();
                break;
            }
        }
        Ok(found)
    }
}
