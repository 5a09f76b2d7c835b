//! Frequencies of one free undeformed body, whatever the frame and the scaling of its modes
//! (docs/theory.md Eq. M.48).
//!
//! In a Buckens frame with mass-orthonormal modes the data themselves tell it. In a tangent frame
//! elastic coordinates move the body as a whole, too; that part is split off here.

use faer::Mat;

use super::equations::{active_directions, factor_active, rigid_inertia, substitute_active};
use crate::body::{ModalMass, StandardInputData};
use crate::error::DynamicsError;
use crate::reduction::blocks::dense;

/// Coupling of elastic and rigid motion, as a share of the elastic inertia, below which it is
/// round-off.
const COUPLING_ROUND_OFF: f64 = 1e-9;

/// Squared angular eigenfrequencies of the free undeformed body, one per mode [rad²/s²].
///
/// # Errors
/// [`DynamicsError::NotPositiveDefinite`] if the inertia of the undeformed body is not.
pub(in crate::system) fn squared_frequencies(data: &StandardInputData) -> Result<Vec<f64>, DynamicsError> {
    let n = data.n_modes();
    if n == 0 {
        return Ok(Vec::new());
    }
    let coupling: Vec<[f64; 6]> = (0..n)
        .map(|j| {
            let (t, r) = (&data.coupling_translation[j], data.coupling_rotation_at_rest(j));
            [t.x, t.y, t.z, r.x, r.y, r.z]
        })
        .collect();
    let active = active_directions(data.motion);
    let mut inertia = rigid_inertia(data.mass, &data.mass_moment, &data.inertia());
    let singular = |pivot| DynamicsError::NotPositiveDefinite { matrix: "inertia of a body", pivot, size: n };
    factor_active(&mut inertia, active).map_err(|_| singular(0))?;
    let mut rigid = coupling.clone();
    rigid.iter_mut().for_each(|row| substitute_active(&inertia, row, active));
    let mut mass = Mat::from_fn(n, n, |i, j| {
        data.modal_mass.entry(i, j) - coupling[i].iter().zip(&rigid[j]).map(|(a, b)| a * b).sum::<f64>()
    });
    dense::symmetrise(&mut mass);
    let is_uncoupled = data.modal_mass == ModalMass::Identity
        && (0..n).all(|j| (1.0 - mass[(j, j)]).abs() < COUPLING_ROUND_OFF);
    if is_uncoupled {
        return Ok(data.modal_stiffness.clone());
    }
    let factor = dense::cholesky(mass, "elastic inertia of a free body")?;
    let mut whitened = Mat::from_fn(n, n, |i, j| if i == j { data.modal_stiffness[i] } else { 0.0 });
    dense::solve_lower(factor.as_ref(), whitened.as_mut());
    let mut whitened = whitened.transpose().to_owned();
    dense::solve_lower(factor.as_ref(), whitened.as_mut());
    dense::symmetrise(&mut whitened);
    dense::symmetric_eigen(whitened.as_ref()).map(|(squared, _)| squared)
}
