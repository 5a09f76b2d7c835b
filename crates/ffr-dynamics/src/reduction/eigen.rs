//! The lowest elastic modes, or all of them, every result checked by an inertia count (Eqs. R.7,
//! R.11 to R.16).

pub mod modes;
pub mod lanczos;
pub mod neighbours;
mod search;

use faer::{Mat, MatRef};

use super::blocks::dense;
use super::problem::{ElasticProblem, SOLVE_COLUMNS};
use crate::DynamicsError;
use modes::EigenModes;
use search::{CANDIDATES, Goal, Search, capacity};

/// Models up to this size are solved by the dense path, which is then as fast.
const DENSE_SIZE: usize = 400;

impl ElasticProblem<'_> {
    /// The `n_modes` lowest elastic modes, verified by an inertia count.
    ///
    /// Block Lanczos, or the dense path for small models and when a large part of the modes is
    /// wanted.
    ///
    /// # Errors
    /// [`DynamicsError::TooManyModes`]; [`DynamicsError::Eigenmodes`] if the iteration does not converge or the count does not
    /// agree after all restarts.
    pub fn lowest_modes(&self, n_modes: usize) -> Result<EigenModes, DynamicsError> {
        self.lowest(n_modes, Goal::Modes, &[])
    }

    /// The `n_modes` lowest angular eigenfrequencies of elastic modes [rad/s], rising, to some
    /// 1e-6, verified by an inertia count (Eq. R.14): for whom the modes do not matter, in less
    /// than half the time if there are many.
    ///
    /// # Errors
    /// As [`Self::lowest_modes`].
    pub fn lowest_frequencies(&self, n_modes: usize) -> Result<Vec<f64>, DynamicsError> {
        self.lowest_frequencies_below(n_modes, &[])
    }

    /// As [`Self::lowest_frequencies`] where `bounds` are known that they do not exceed [rad/s]:
    /// those of a model whose motions are among this one's. None found above its bound stands for
    /// the count.
    ///
    /// # Errors
    /// As [`Self::lowest_modes`].
    pub fn lowest_frequencies_below(
        &self,
        n_modes: usize,
        bounds: &[f64],
    ) -> Result<Vec<f64>, DynamicsError> {
        let bounds: Vec<f64> = bounds.iter().map(|w| w * w).collect();
        Ok(self.lowest(n_modes, Goal::Frequencies, &bounds)?.omega)
    }

    fn lowest(&self, n_modes: usize, goal: Goal, bounds: &[f64]) -> Result<EigenModes, DynamicsError> {
        let available = self.n_elastic();
        if n_modes > available {
            return Err(DynamicsError::TooManyModes { wanted: n_modes, available });
        }
        if self.n_unknowns() <= DENSE_SIZE || 2 * capacity(n_modes + CANDIDATES) > available {
            let mut all = self.all_modes()?;
            all.following = all.omega.split_off(n_modes);
            all.shapes = all.shapes.as_ref().subcols(0, n_modes).to_owned();
            return Ok(all);
        }
        let found = Search::new(self, n_modes, goal).below(bounds).run();
        match found {
            Err(why) if self.is_single_precision() => {
                tracing::debug!(%why, "no modes in single precision, trying double");
                Search::new(&self.in_double_precision()?, n_modes, goal).below(bounds).run()
            }
            found => found,
        }
    }

    /// All elastic modes by the dense path, O(n³).
    ///
    /// # Errors
    /// [`DynamicsError::NotPositiveDefinite`] or [`DynamicsError::Factorisation`].
    pub fn all_modes(&self) -> Result<EigenModes, DynamicsError> {
        let free: Vec<usize> = (0..self.n_unknowns()).filter(|&i| !self.clamped_unknowns()[i]).collect();
        let (k, m) = self.dense_matrices(&free);
        let rigid = match self.rigid() {
            Some(r) => Mat::from_fn(free.len(), r.count(), |i, j| r.modes[(free[i], j)]),
            None => Mat::zeros(free.len(), 0),
        };
        let (lambda, reduced) = elastic_modes_dense(k.as_ref(), m.as_ref(), rigid.as_ref())?;
        let mut shapes = Mat::zeros(self.n_unknowns(), lambda.len());
        for j in 0..lambda.len() {
            for (i, &unknown) in free.iter().enumerate() {
                shapes[(unknown, j)] = reduced[(i, j)];
            }
        }
        let omega = lambda.iter().map(|l| l.sqrt()).collect();
        Ok(EigenModes { omega, shapes, following: Vec::new(), residual: 0.0, counted: None, recoveries: 0 })
    }

    /// `K` and `M` as dense matrices on the unknowns `free`.
    fn dense_matrices(&self, free: &[usize]) -> (Mat<f64>, Mat<f64>) {
        let (n, m) = (self.n_unknowns(), free.len());
        let (mut k_dense, mut m_dense) = (Mat::zeros(m, m), Mat::zeros(m, m));
        for first in (0..m).step_by(SOLVE_COLUMNS) {
            let width = SOLVE_COLUMNS.min(m - first);
            let unit = Mat::from_fn(n, width, |i, j| if i == free[first + j] { 1.0 } else { 0.0 });
            let (k, mass) = (self.stiffness_product(unit.as_ref()), self.mass_product(unit.as_ref()));
            for j in 0..width {
                for (i, &row) in free.iter().enumerate() {
                    k_dense[(i, first + j)] = k[(row, j)];
                    m_dense[(i, first + j)] = mass[(row, j)];
                }
            }
        }
        (k_dense, m_dense)
    }
}

/// Elastic modes of dense `(K, M)` with rigid modes `R` (`R^T M R = 1`, may have no columns):
/// eigenvalues in ascending order and mass-orthonormal vectors, n x (n - r) (Eq. R.16).
///
/// Works with the inverse on the complement of `R`, so that low eigenvalues keep their digits
/// beside very high ones; the high part is then solved once more with `K` itself.
///
/// # Errors
/// [`DynamicsError::NotPositiveDefinite`] or [`DynamicsError::Factorisation`].
pub fn elastic_modes_dense(
    k: MatRef<'_, f64>,
    m: MatRef<'_, f64>,
    rigid: MatRef<'_, f64>,
) -> Result<(Vec<f64>, Mat<f64>), DynamicsError> {
    let n = k.nrows();
    let l = dense::cholesky(m.to_owned(), "the mass matrix")?;
    let z = dense::orthogonal_complement(dense::product(l.transpose(), rigid).as_ref());
    let mass_basis = dense::product(l.as_ref(), z.as_ref());
    let mut basis = z;
    dense::solve_lower_transposed(l.as_ref(), basis.as_mut());

    let support = dense::pivot_rows(rigid, |_| true);
    let mut held = k.to_owned();
    let mut response = mass_basis.clone();
    // On an interface that just holds the body no stiffness is left: any positive diagonal does for
    // the held rows.
    let diagonal = (0..n).fold(0.0f64, |d, i| d.max(k[(i, i)]));
    for &c in &support {
        for i in (0..n).filter(|&i| i != c) {
            held[(i, c)] = 0.0;
            held[(c, i)] = 0.0;
        }
        held[(c, c)] = diagonal;
        response.row_mut(c).fill(0.0);
    }
    let factor = dense::cholesky(held, "the supported stiffness matrix")?;
    dense::solve_lower(factor.as_ref(), response.as_mut());
    // B = (M E)^T K_c^-1 (M E) as a Gram matrix; the held rows add nothing because their loads are
    // zero.
    let mut flexibility = dense::product(response.transpose(), response.as_ref());
    dense::symmetrise(&mut flexibility);
    let (theta, vectors) = dense::symmetric_eigen(flexibility.as_ref())?;

    let n_e = theta.len();
    let largest = theta.last().copied().unwrap_or(0.0);
    let smallest = theta.iter().fold(largest, |a, t| a.min(t.abs())).max(f64::EPSILON * largest);
    // The inverse errs by epsilon against its largest eigenvalue, K against its own: split where
    // both lose equally.
    let split = (largest * smallest).sqrt();
    let n_low = theta.iter().filter(|&&t| t > split).count();
    let descending = Mat::from_fn(n_e, n_e, |i, j| vectors[(i, n_e - 1 - j)]);
    let mut shapes = dense::product(basis.as_ref(), descending.as_ref());
    let mut lambda: Vec<f64> = theta.iter().rev().take(n_low).map(|t| 1.0 / t).collect();
    if n_low < n_e {
        let high = shapes.as_ref().subcols(n_low, n_e - n_low).to_owned();
        let mut projected = dense::product(high.transpose(), dense::product(k, high.as_ref()).as_ref());
        dense::symmetrise(&mut projected);
        let (values, rotation) = dense::symmetric_eigen(projected.as_ref())?;
        lambda.extend_from_slice(&values);
        let turned = dense::product(high.as_ref(), rotation.as_ref());
        shapes.as_mut().subcols_mut(n_low, n_e - n_low).copy_from(&turned);
    }
    if let Some(bad) = lambda.iter().position(|l| !(l.is_finite() && *l > 0.0)) {
        return Err(DynamicsError::NotPositiveDefinite {
            matrix: "the elastic stiffness",
            pivot: bad,
            size: n_e,
        });
    }
    Ok((lambda, shapes))
}
