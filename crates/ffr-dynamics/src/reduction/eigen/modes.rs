//! Elastic modes of a body, and the multiplets among them.

use faer::Mat;

/// Frequencies closer than this (relative) belong to one multiplet: a coarse net splits the
/// multiplets of a sphere by about its discretisation error.
pub const MULTIPLET_TOLERANCE: f64 = 1e-3;

/// Elastic modes of a body.
#[derive(Debug, Clone)]
pub struct EigenModes {
    /// Angular eigenfrequencies in ascending order [rad/s].
    pub omega: Vec<f64>,
    /// Modes, n x len(omega), mass-orthonormal and mass-orthogonal to the rigid modes [1/sqrt(kg)].
    pub shapes: Mat<f64>,
    /// Eigenfrequencies that follow, as far as they were verified; for [`neighbouring_counts`]
    /// [rad/s].
    pub following: Vec<f64>,
    /// Largest residual `|lambda F M x - x|` in the mass norm, for unit `x`, before the last
    /// improvement of the modes; the eigenvalue error is of the order of its square.
    pub residual: f64,
    /// Number of eigenvalues, rigid ones included, that the inertia count shows below the shift;
    /// `None` if all modes were computed by the dense path, where nothing can be lost.
    pub counted: Option<usize>,
    /// How often the count showed lost copies of multiple modes, which were then found by a further
    /// search.
    pub recoveries: usize,
}

/// Counts next to `n` that do not cut a multiplet of `omega` (ascending): `(below, above)`; `None`
/// if `n` cuts none.
///
/// `omega` holds at least one frequency behind the multiplet; if it ends inside, the upper count is
/// its length.
pub fn neighbouring_counts(omega: &[f64], n: usize) -> Option<(usize, usize)> {
    let joined = |i: usize| omega[i] - omega[i - 1] <= MULTIPLET_TOLERANCE * omega[i];
    if n == 0 || n >= omega.len() || !joined(n) {
        return None;
    }
    let below = (1..n).rev().find(|&i| !joined(i)).unwrap_or(0);
    let above = (n + 1..omega.len()).find(|&i| !joined(i)).unwrap_or(omega.len());
    Some((below, above))
}
