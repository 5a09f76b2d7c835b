//! What the crate's models are compared with: bases and compliances by the shortest way from eigenmodes.

use faer::Mat;
use ffr_dynamics::DynamicsError;
use ffr_dynamics::body::AssembledBody;
use ffr_dynamics::reduction::{ElasticProblem, ReducedBasis};

/// The `n_modes` lowest elastic modes of the free body.
pub fn modal_truncation(body: &AssembledBody, n_modes: usize) -> Result<ReducedBasis, DynamicsError> {
    let problem = ElasticProblem::free(body, &[])?;
    Ok(ReducedBasis::from_modes(problem.lowest_modes(n_modes)?, problem.free_rigid()?))
}

/// Residual flexibility from the high-frequency modes of `basis`, `Σ φ φᵀ/ω²` at the unknowns `interface` [m/N] (Eq. R.22).
pub fn modal_compliance(basis: &ReducedBasis, interface: &[usize]) -> Mat<f64> {
    let scaled = Mat::from_fn(interface.len(), basis.n_modes() - basis.n_low, |i, j| {
        let mode = basis.n_low + j;
        basis.shapes[(interface[i], mode)] / basis.omega[mode]
    });
    &scaled * scaled.transpose()
}
