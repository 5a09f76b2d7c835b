//! Vibration of one free undeformed body, whatever the frame and the scaling of its modes (docs/theory.md Eq. M.26).
//!
//! In a Buckens frame with mass-orthonormal modes the data themselves tell it. In a tangent frame elastic coordinates move
//! the body as a whole, too; that part is split off here.

use faer::Mat;

use super::equations::{active_directions, factor_active, rigid_inertia, substitute_active};
use crate::body::{ModalMass, StandardInputData};
use crate::error::DynamicsError;
use crate::reduction::dense;

/// Coupling of elastic and rigid motion, as a share of the elastic inertia, below which it is round-off.
const COUPLING_ROUND_OFF: f64 = 1e-9;

/// Eigenfrequencies of the free body, and what takes elastic rates to the rates of its modes.
#[derive(Debug, Clone, Default)]
pub(super) struct FreeModes {
    /// Squared angular eigenfrequencies [rad²/s²].
    pub squared_frequencies: Vec<f64>,
    /// `None` if the elastic coordinates are those of the modes.
    transform: Option<Transform>,
}

#[derive(Debug, Clone)]
struct Transform {
    /// Motion of the body as a whole by each elastic rate: rows of `C M_rr⁻¹`, in body axes.
    rigid: Vec<[f64; 6]>,
    /// Modal coordinates by elastic coordinates, `Zᵀ M̂`, row by row.
    modal: Vec<f64>,
}

impl FreeModes {
    /// Modes of the free body.
    ///
    /// # Errors
    /// [`DynamicsError::NotPositiveDefinite`] if the inertia of the undeformed body is not.
    pub fn new(data: &StandardInputData) -> Result<Self, DynamicsError> {
        let n = data.n_modes();
        let own = || Self { squared_frequencies: data.modal_stiffness.clone(), transform: None };
        if n == 0 {
            return Ok(own());
        }
        let coupling: Vec<[f64; 6]> = (0..n)
            .map(|j| {
                let (t, r) = (&data.coupling_translation[j], data.coupling_rotation_at_rest(j));
                [t.x, t.y, t.z, r.x, r.y, r.z]
            })
            .collect();
        let active = active_directions(data.motion);
        let mut inertia = rigid_inertia(data.mass, &data.mass_moment, &data.inertia());
        let singular =
            |pivot| DynamicsError::NotPositiveDefinite { matrix: "inertia of a body", pivot, size: n };
        factor_active(&mut inertia, active).map_err(|_| singular(0))?;
        let mut rigid = coupling.clone();
        rigid.iter_mut().for_each(|row| substitute_active(&inertia, row, active));
        let mut mass = Mat::from_fn(n, n, |i, j| {
            data.modal_mass.entry(i, j) - coupling[i].iter().zip(&rigid[j]).map(|(a, b)| a * b).sum::<f64>()
        });
        dense::symmetrise(&mut mass);
        let is_own = data.modal_mass == ModalMass::Identity
            && (0..n).all(|j| (1.0 - mass[(j, j)]).abs() < COUPLING_ROUND_OFF);
        if is_own {
            return Ok(own());
        }
        let factor = dense::cholesky(mass, "elastic inertia of a free body")?;
        let mut whitened = Mat::from_fn(n, n, |i, j| if i == j { data.modal_stiffness[i] } else { 0.0 });
        dense::solve_lower(factor.as_ref(), whitened.as_mut());
        let mut whitened = whitened.transpose().to_owned();
        dense::solve_lower(factor.as_ref(), whitened.as_mut());
        dense::symmetrise(&mut whitened);
        let (squared_frequencies, vectors) = dense::symmetric_eigen(whitened.as_ref())?;
        let modal = dense::product(vectors.transpose(), factor.transpose());
        let modal = (0..n * n).map(|i| modal[(i / n, i % n)]).collect();
        Ok(Self { squared_frequencies, transform: Some(Transform { rigid, modal }) })
    }

    /// Lowest angular eigenfrequency; 0 for rigid bodies [rad/s].
    pub fn lowest(&self) -> f64 {
        let lowest = self.squared_frequencies.iter().copied().fold(f64::INFINITY, f64::min);
        if lowest.is_finite() { lowest.sqrt() } else { 0.0 }
    }

    /// Adds the motion of the body as a whole by elastic rates to that of its frame, in body axes.
    pub fn add_rigid(&self, elastic_rates: &[f64], frame: &mut [f64; 6]) {
        let Some(Transform { rigid, .. }) = &self.transform else { return };
        for (row, rate) in rigid.iter().zip(elastic_rates) {
            frame.iter_mut().zip(row).for_each(|(f, r)| *f += r * rate);
        }
    }

    /// Whether elastic rates move the body as a whole.
    pub fn moves_body(&self) -> bool {
        self.transform.is_some()
    }

    /// Twice the energy of vibration; a mode of squared frequency above `highest` counts for `highest / ω_j²` of it (Eq. T.18).
    pub fn cut_energy(&self, coordinates: &[f64], rates: &[f64], highest: f64) -> f64 {
        let mode = |j: usize| match &self.transform {
            None => (coordinates[j], rates[j]),
            Some(Transform { modal, .. }) => {
                let n = coordinates.len();
                let row = &modal[j * n..(j + 1) * n];
                let sum = |x: &[f64]| row.iter().zip(x).map(|(a, b)| a * b).sum::<f64>();
                (sum(coordinates), sum(rates))
            }
        };
        let terms = self.squared_frequencies.iter().enumerate().map(|(j, k)| {
            let (q, rate) = mode(j);
            (k * q * q + rate * rate) * (highest / k).min(1.0)
        });
        terms.sum()
    }
}
