//! Modal truncation (Eqs. R.17, R.18), and what every reduction hands over.

use std::sync::Arc;

use faer::Mat;

use super::eigen::modes::{EigenModes, neighbouring_counts};
use super::problem::ElasticProblem;
use super::rigid::RigidModes;
use crate::DynamicsError;
use crate::body::AssembledBody;

/// Elastic shapes of a reduced body.
///
/// `shapes^T M shapes = 1`, `shapes^T K shapes = diag(omega²)`; the shapes are mass-orthogonal to
/// the rigid modes, so they belong to the Buckens (mean-axis) frame.
#[derive(Debug, Clone)]
pub struct ReducedBasis {
    /// Shapes, n x n_q [1/sqrt(kg)].
    pub shapes: Mat<f64>,
    /// Angular eigenfrequencies, one per shape, ascending [rad/s].
    pub omega: Vec<f64>,
    /// Number of low-frequency (dynamic) shapes: the first `n_low`.
    pub n_low: usize,
    /// Rigid modes of the unreduced body.
    pub rigid: Arc<RigidModes>,
    /// Mode counts next to `n_low` that do not cut through a multiplet of equal frequencies, if
    /// `n_low` does.
    pub multiplet: Option<(usize, usize)>,
    /// Loads whose static answers the shapes have (see [`super::static_answers`]); none of a basis
    /// of eigenmodes alone. Where all shapes are low-frequency, the static answers are the last of
    /// them.
    pub static_loads: Vec<usize>,
}

/// Low-frequency modes of a free body, whose motion is dynamic.
#[derive(Debug, Clone)]
pub struct LowModes {
    /// Mass-orthonormal shapes, n x n_low [1/sqrt(kg)].
    pub shapes: Mat<f64>,
    /// Angular frequencies \[rad/s\].
    pub omega: Vec<f64>,
}

impl ReducedBasis {
    /// The same basis on a finer model of the body, whose unknowns it moves by `shapes` and whose
    /// rigid modes are `rigid`.
    pub fn prolonged(&self, shapes: Mat<f64>, rigid: Arc<RigidModes>) -> Self {
        let Self { omega, n_low, static_loads, .. } = self;
        let (omega, static_loads) = (omega.clone(), static_loads.clone());
        Self { shapes, omega, n_low: *n_low, rigid, multiplet: None, static_loads }
    }

    /// The low-frequency shapes.
    pub fn low_modes(&self) -> LowModes {
        let shapes = self.shapes.as_ref().subcols(0, self.n_low).to_owned();
        LowModes { shapes, omega: self.omega[..self.n_low].to_vec() }
    }

    /// Number of shapes.
    pub fn n_modes(&self) -> usize {
        self.omega.len()
    }

    /// Number of the first static answer among the shapes, which is that of the free modes; of a
    /// basis with interface modes, in which static answers are mixed with others, the number of all
    /// shapes.
    pub fn first_static(&self) -> usize {
        let n = self.n_modes();
        if self.n_low == n { n.saturating_sub(self.static_loads.len()) } else { n }
    }

    /// Basis from verified eigenmodes, all of them low-frequency.
    pub fn from_modes(modes: EigenModes, rigid: Arc<RigidModes>) -> Self {
        let n_low = modes.omega.len();
        let known: Vec<f64> = modes.omega.iter().chain(&modes.following).copied().collect();
        let multiplet = neighbouring_counts(&known, n_low);
        Self { shapes: modes.shapes, omega: modes.omega, n_low, rigid, multiplet, static_loads: Vec::new() }
    }

    /// The same basis with the first `n` shapes only.
    pub fn truncated(&self, n: usize) -> Self {
        let n = n.min(self.n_modes());
        Self {
            shapes: self.shapes.as_ref().subcols(0, n).to_owned(),
            omega: self.omega[..n].to_vec(),
            n_low: self.n_low.min(n),
            rigid: Arc::clone(&self.rigid),
            multiplet: neighbouring_counts(&self.omega, n).or(self.multiplet.filter(|_| n == self.n_low)),
            static_loads: if n == self.n_modes() { self.static_loads.clone() } else { Vec::new() },
        }
    }
}

/// Every elastic mode of the free body, all dynamic; dense, for models of up to a few thousand
/// unknowns.
///
/// # Errors
/// As [`ElasticProblem::free`] and [`ElasticProblem::all_modes`].
pub fn all_modes(body: &AssembledBody) -> Result<ReducedBasis, DynamicsError> {
    let problem = ElasticProblem::free(body, &[])?;
    Ok(ReducedBasis::from_modes(problem.all_modes()?, problem.free_rigid()?))
}
