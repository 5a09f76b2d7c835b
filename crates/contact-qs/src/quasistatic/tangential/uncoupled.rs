//! Points without compliance, every one for itself.

use crate::solver_fault::SolverFault;
use ffr_dynamics::error::EvaluationFailure;

use super::{PointState, Tangential, pair};

impl Tangential {
    /// Solves for `forces` without compliance, every point for itself: the classical return mapping
    /// (Eq. F.3).
    ///
    /// # Errors
    /// A slip that is not finite.
    pub fn return_to_bounds(
        &mut self,
        springs: &[f64],
        slips: &[f64],
        bounds: &[f64],
        forces: &mut [f64],
    ) -> Result<(), EvaluationFailure> {
        for i in 0..self.states.len() {
            let slip = pair(slips, i, self.n_t);
            let size = slip[0].hypot(slip[1]);
            if !size.is_finite() {
                return Err(SolverFault::NotFinite { value: "tangential displacement" }.into());
            }
            let held = size / springs[i];
            self.states[i] = if bounds[i] <= 0.0 {
                PointState::Open
            } else if held <= bounds[i] {
                PointState::Stick
            } else {
                PointState::Slip
            };
            let force = if size > 0.0 { held.min(bounds[i]) / size } else { 0.0 };
            if self.states[i] == PointState::Slip {
                self.directions[i] = slip.map(|c| -c / size);
            }
            for (a, c) in slip[..self.n_t].iter().enumerate() {
                let k = self.n_t * i + a;
                forces[k] = -force * c;
                self.increments[k] =
                    if self.states[i] == PointState::Stick { 0.0 } else { c + springs[i] * forces[k] };
            }
        }
        Ok(())
    }

    /// Rates of the slip increments at the solution of [`Tangential::return_to_bounds`], zero where
    /// a point does not slide [m/s]: slips change at `slip_rates` [m/s], bounds at `bound_rates`
    /// \[N/s\].
    pub fn rates_of_points(&self, springs: &[f64], slip_rates: &[f64], bound_rates: &[f64], out: &mut [f64]) {
        out.fill(0.0);
        for i in (0..self.states.len()).filter(|&i| self.states[i] == PointState::Slip) {
            for a in 0..self.n_t {
                // The turn of the force is across it and does no work.
                let k = self.n_t * i + a;
                out[k] = slip_rates[k] + springs[i] * bound_rates[i] * self.directions[i][a];
            }
        }
    }
}
