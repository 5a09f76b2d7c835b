//! The lowest elastic modes, or all of them, every result checked by an inertia count (Eqs. R.3, R.7 to R.10).

use std::f64::consts::TAU;

use faer::{Mat, MatRef};

use super::dense;
use super::lanczos::{BLOCK, Lanczos};
use super::problem::ElasticProblem;
use crate::DynamicsError;

/// Frequencies closer than this (relative) belong to one multiplet: a coarse net splits the multiplets of a sphere by
/// about its discretisation error.
pub const MULTIPLET_TOLERANCE: f64 = 1e-3;
/// Models up to this size are solved by the dense path, which is then as fast.
const DENSE_SIZE: usize = 400;
/// Modes computed beyond those asked for: the gap for the inertia count lies among them, and the multiplets of a sphere
/// have up to 7 members in the range of interest.
const GUARD: usize = 8;
/// Lanczos residual of wanted modes; the eigenvalue error is about its square.
const CONVERGED: f64 = 1e-7;
/// Lanczos residual of guard modes: eigenvalues to about 1e-8.
const GUARD_CONVERGED: f64 = 1e-4;
/// Residual `|lambda F M x - x|` in the mass norm above which a mode is refused.
const RESIDUAL_LIMIT: f64 = 1e-6;
/// Smallest relative gap between two eigenvalues in which a shift is placed: far above the error of the guard modes.
const SMALLEST_GAP: f64 = 1e-4;
/// Pivot growth above which a count is repeated elsewhere in the gap.
const GROWTH_LIMIT: f64 = 1e4;
/// Rounds of compression, and of restarts for lost copies.
const MAX_ROUNDS: usize = 60;
const MAX_RECOVERIES: usize = 6;

/// Elastic modes of a body.
#[derive(Debug, Clone)]
pub struct EigenModes {
    /// Angular eigenfrequencies in ascending order [rad/s].
    pub omega: Vec<f64>,
    /// Modes, n x len(omega), mass-orthonormal and mass-orthogonal to the rigid modes [1/sqrt(kg)].
    pub shapes: Mat<f64>,
    /// Eigenfrequencies that follow, as far as they were verified; for [`neighbouring_counts`] [rad/s].
    pub following: Vec<f64>,
    /// Largest residual `|lambda F M x - x|` in the mass norm, for unit `x`.
    pub residual: f64,
    /// Number of eigenvalues, rigid ones included, that the inertia count shows below the shift; `None` if all modes were
    /// computed by the dense path, where nothing can be lost.
    pub counted: Option<usize>,
}

/// Counts next to `n` that do not cut a multiplet of `omega` (ascending): `(below, above)`; `None` if `n` cuts none.
///
/// `omega` holds at least one frequency behind the multiplet; if it ends inside, the upper count is its length.
pub fn neighbouring_counts(omega: &[f64], n: usize) -> Option<(usize, usize)> {
    let joined = |i: usize| omega[i] - omega[i - 1] <= MULTIPLET_TOLERANCE * omega[i];
    if n == 0 || n >= omega.len() || !joined(n) {
        return None;
    }
    let below = (1..n).rev().find(|&i| !joined(i)).unwrap_or(0);
    let above = (n + 1..omega.len()).find(|&i| !joined(i)).unwrap_or(omega.len());
    Some((below, above))
}

impl ElasticProblem<'_> {
    /// The `n_modes` lowest elastic modes, verified by an inertia count.
    ///
    /// Block Lanczos, or the dense path for small models and when a large part of the modes is wanted.
    ///
    /// # Errors
    /// [`DynamicsError::TooManyModes`]; [`DynamicsError::Eigenmodes`] if the iteration does not converge or the count does not
    /// agree after all restarts.
    pub fn lowest_modes(&self, n_modes: usize) -> Result<EigenModes, DynamicsError> {
        let available = self.n_elastic();
        if n_modes > available {
            return Err(DynamicsError::TooManyModes { wanted: n_modes, available });
        }
        if self.n_unknowns() <= DENSE_SIZE || 2 * capacity(n_modes + 2 * GUARD) > available {
            let mut all = self.all_modes()?;
            all.following = all.omega.split_off(n_modes);
            all.shapes = all.shapes.as_ref().subcols(0, n_modes).to_owned();
            return Ok(all);
        }
        Search { problem: self, n_modes, want: n_modes + GUARD }.run()
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
        Ok(EigenModes { omega, shapes, following: Vec::new(), residual: 0.0, counted: None })
    }

    /// `K` and `M` as dense matrices on the unknowns `free`.
    fn dense_matrices(&self, free: &[usize]) -> (Mat<f64>, Mat<f64>) {
        let (n, m) = (self.n_unknowns(), free.len());
        let (mut k_dense, mut m_dense) = (Mat::zeros(m, m), Mat::zeros(m, m));
        for first in (0..m).step_by(BLOCK) {
            let width = BLOCK.min(m - first);
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

/// Elastic modes of dense `(K, M)` with rigid modes `R` (`R^T M R = 1`, may have no columns): eigenvalues in ascending
/// order and mass-orthonormal vectors, n x (n - r) (Eq. R.10).
///
/// Works with the inverse on the complement of `R`, so that low eigenvalues keep their digits beside very high ones; the
/// high part is then solved once more with `K` itself.
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
    for &c in &support {
        for i in (0..n).filter(|&i| i != c) {
            held[(i, c)] = 0.0;
            held[(c, i)] = 0.0;
        }
        response.row_mut(c).fill(0.0);
    }
    let factor = dense::cholesky(held, "the supported stiffness matrix")?;
    dense::solve_lower(factor.as_ref(), response.as_mut());
    // B = (M E)^T K_c^-1 (M E) as a Gram matrix; the held rows add nothing because their loads are zero.
    let mut flexibility = dense::product(response.transpose(), response.as_ref());
    dense::symmetrise(&mut flexibility);
    let (theta, vectors) = dense::symmetric_eigen(flexibility.as_ref())?;

    let n_e = theta.len();
    let largest = theta.last().copied().unwrap_or(0.0);
    let smallest = theta.iter().fold(largest, |a, t| a.min(t.abs())).max(f64::EPSILON * largest);
    // The inverse errs by epsilon against its largest eigenvalue, K against its own: split where both lose equally.
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

/// Room for the basis of a Lanczos run.
fn capacity(want: usize) -> usize {
    (4 * want + 40).max(140).next_multiple_of(BLOCK)
}

/// A search for the lowest modes.
struct Search<'p, 'a> {
    problem: &'p ElasticProblem<'a>,
    n_modes: usize,
    want: usize,
}

/// Ritz pairs after the clean-up.
struct Cleaned {
    lambda: Vec<f64>,
    vectors: Mat<f64>,
    residual: f64,
}

impl Search<'_, '_> {
    fn run(mut self) -> Result<EigenModes, DynamicsError> {
        let mut run = Lanczos::new(self.problem, capacity(self.n_modes + 2 * GUARD))?;
        let mut at_least = self.want + 2 * BLOCK;
        let mut last = (0, 0, 0.0);
        for _ in 0..MAX_RECOVERIES {
            self.iterate(&mut run, at_least)?;
            let ritz = run.ritz()?;
            let cleaned = self.clean(run.vectors(&ritz, self.want).as_ref())?;
            let Some(gap) = self.widest_gap(&cleaned.lambda) else {
                // The guard modes are all one cluster: look further up, as far as the basis has room.
                self.want += BLOCK;
                if self.want > self.n_modes + 2 * GUARD {
                    return Err(self.failure(&cleaned, 0, "no gap behind the modes, ask for more or fewer"));
                }
                at_least = self.want + 2 * BLOCK;
                continue;
            };
            let counted = self.count(&cleaned.lambda, gap)?;
            let expected = counted - self.problem.n_rigid().min(counted);
            if expected == gap {
                return self.finish(cleaned, gap, counted);
            }
            last = (gap, expected, cleaned.lambda[gap - 1]);
            if expected < gap {
                break;
            }
            tracing::debug!(
                found = gap,
                expected,
                "copies of multiple modes were lost, restarting beside them"
            );
            let theta: Vec<f64> = cleaned.lambda.iter().map(|l| 1.0 / l).collect();
            run.keep(cleaned.vectors.as_ref(), &theta);
            run.restart_random()?;
            at_least = theta.len() + 10 * BLOCK;
        }
        let (found, expected, lambda) = last;
        let reason = "the count does not agree, try another number of modes".to_owned();
        Err(DynamicsError::Eigenmodes { found, expected, frequency: lambda.sqrt() / TAU, reason })
    }

    /// Runs until wanted and guard modes have converged and the basis holds `at_least` vectors.
    fn iterate(&self, run: &mut Lanczos<'_, '_>, at_least: usize) -> Result<(), DynamicsError> {
        let mut worst = f64::INFINITY;
        let mut steps = 0;
        for _ in 0..MAX_ROUNDS {
            while run.has_room() {
                run.step()?;
                steps += 1;
                if run.size() < at_least || steps % 3 != 0 {
                    continue;
                }
                let ritz = run.ritz()?;
                let wanted = ritz.residuals[..self.n_modes].iter().fold(0.0, |a: f64, &r| a.max(r));
                let guards = ritz.residuals[self.n_modes..self.want].iter().fold(0.0, |a: f64, &r| a.max(r));
                worst = wanted;
                if wanted <= CONVERGED && guards <= GUARD_CONVERGED {
                    return Ok(());
                }
            }
            let ritz = run.ritz()?;
            run.compress(&ritz, self.want + (run.size() - self.want) / 3);
        }
        let reason = format!("residual {worst:.1e} after {steps} blocks, limit {CONVERGED:.0e}");
        Err(DynamicsError::Eigenmodes { found: 0, expected: self.n_modes, frequency: f64::INFINITY, reason })
    }

    /// One more multiplication and a Rayleigh-Ritz step with `K` and `M` (Eq. R.9).
    fn clean(&self, vectors: MatRef<'_, f64>) -> Result<Cleaned, DynamicsError> {
        let mut x = self.multiply(vectors);
        let (lambda, rotation) = rayleigh_ritz(self.problem, x.as_ref())?;
        x = dense::product(x.as_ref(), rotation.as_ref());
        let mut error = self.multiply(x.as_ref());
        for j in 0..x.ncols() {
            for i in 0..x.nrows() {
                error[(i, j)] = lambda[j] * error[(i, j)] - x[(i, j)];
            }
        }
        let mass_error = self.problem.mass_product(error.as_ref());
        let norm = |j: usize| (error.col(j).transpose() * mass_error.col(j)).max(0.0).sqrt();
        let residual = (0..self.n_modes).map(norm).fold(0.0, f64::max);
        let cleaned = Cleaned { lambda, vectors: x, residual };
        if residual.is_nan() || residual > RESIDUAL_LIMIT {
            let reason = format!("residual {residual:.1e} after the clean-up, limit {RESIDUAL_LIMIT:.0e}");
            return Err(self.failure(&cleaned, 0, &reason));
        }
        Ok(cleaned)
    }

    fn multiply(&self, x: MatRef<'_, f64>) -> Mat<f64> {
        let mut y = self.problem.mass_product(x);
        self.problem.apply_flexibility(y.as_mut());
        y
    }

    /// Number of modes below the widest gap that leaves all wanted modes below it.
    fn widest_gap(&self, lambda: &[f64]) -> Option<usize> {
        let width = |k: usize| (lambda[k] - lambda[k - 1]) / lambda[k];
        (self.n_modes.max(1)..lambda.len() - 1)
            .filter(|&k| width(k) > SMALLEST_GAP)
            .max_by(|&a, &b| width(a).total_cmp(&width(b)))
    }

    /// Eigenvalues below the gap behind mode `gap`, by inertia; repeated elsewhere in the gap if a pivot is close to zero.
    fn count(&self, lambda: &[f64], gap: usize) -> Result<usize, DynamicsError> {
        let (below, above) = (lambda[gap - 1], lambda[gap]);
        let mut best: Option<super::Inertia> = None;
        for part in [0.5, 0.38, 0.63] {
            let inertia = self.problem.inertia(below + part * (above - below))?;
            if best.is_none_or(|b| inertia.growth < b.growth) {
                best = Some(inertia);
            }
            if inertia.growth <= GROWTH_LIMIT {
                break;
            }
        }
        let best = best.filter(|b| b.growth.is_finite());
        best.map(|b| b.negative).ok_or_else(|| DynamicsError::Factorisation {
            matrix: "K - mu M",
            reason: "a pivot vanishes for every shift in the gap".into(),
        })
    }

    fn finish(&self, cleaned: Cleaned, gap: usize, counted: usize) -> Result<EigenModes, DynamicsError> {
        let omega: Vec<f64> = cleaned.lambda.iter().map(|l| l.sqrt()).collect();
        let shapes = cleaned.vectors.as_ref().subcols(0, self.n_modes).to_owned();
        Ok(EigenModes {
            following: omega[self.n_modes..gap + 1].to_vec(),
            omega: omega[..self.n_modes].to_vec(),
            shapes,
            residual: cleaned.residual,
            counted: Some(counted),
        })
    }

    fn failure(&self, cleaned: &Cleaned, found: usize, reason: &str) -> DynamicsError {
        let frequency = cleaned.lambda.last().map_or(0.0, |l| l.max(0.0).sqrt() / TAU);
        DynamicsError::Eigenmodes { found, expected: self.n_modes, frequency, reason: reason.to_owned() }
    }
}

/// Eigenvalues in ascending order and coefficients of the mass-orthonormal Ritz vectors in the span of `x`.
fn rayleigh_ritz(
    problem: &ElasticProblem<'_>,
    x: MatRef<'_, f64>,
) -> Result<(Vec<f64>, Mat<f64>), DynamicsError> {
    let mut k = dense::product(x.transpose(), problem.stiffness_product(x).as_ref());
    let mut m = dense::product(x.transpose(), problem.mass_product(x).as_ref());
    // Unit diagonal first: the columns are as long as their flexibility.
    let scale: Vec<f64> = (0..x.ncols()).map(|j| 1.0 / m[(j, j)].sqrt()).collect();
    for j in 0..x.ncols() {
        for i in 0..x.ncols() {
            k[(i, j)] *= scale[i] * scale[j];
            m[(i, j)] *= scale[i] * scale[j];
        }
    }
    dense::symmetrise(&mut k);
    let l = dense::cholesky(m, "the projected mass matrix")?;
    dense::solve_lower(l.as_ref(), k.as_mut());
    let mut k = k.transpose().to_owned();
    dense::solve_lower(l.as_ref(), k.as_mut());
    dense::symmetrise(&mut k);
    let (lambda, mut rotation) = dense::symmetric_eigen(k.as_ref())?;
    dense::solve_lower_transposed(l.as_ref(), rotation.as_mut());
    for j in 0..rotation.ncols() {
        for i in 0..rotation.nrows() {
            rotation[(i, j)] *= scale[i];
        }
    }
    Ok((lambda, rotation))
}
