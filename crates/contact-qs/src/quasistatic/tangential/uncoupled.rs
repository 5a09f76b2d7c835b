//! Points without compliance, every one for itself.

use crate::solver_fault::SolverFault;
use ffr_dynamics::error::EvaluationFailure;

use super::{PointState, Tangential, TangentialProblem, pair};

impl Tangential {
    /// Solves for `forces` without compliance, every point for itself: the classical return mapping
    /// (Eq. F.3).
    ///
    /// # Errors
    /// A slip that is not finite.
    pub fn return_to_bounds(
        &mut self,
        &TangentialProblem { springs, slips, bounds, .. }: &TangentialProblem<'_>,
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

    /// Rates of forces \[N/s\] and slip increments [m/s] at the solution of [`Tangential::return_to_bounds`] when slips change at
    /// `slip_rates` [m/s] and the bounds `bounds` at `bound_rates` \[N/s\]; zero of open points.
    pub fn rates_of_points(
        &self,
        springs: &[f64],
        bounds: &[f64],
        (slip_rates, bound_rates): (&[f64], &[f64]),
        (rates, increment_rates): (&mut [f64], &mut [f64]),
    ) {
        rates.fill(0.0);
        increment_rates.fill(0.0);
        for i in (0..self.states.len()).filter(|&i| self.states[i] != PointState::Open) {
            let (slip, e) = (pair(slip_rates, i, self.n_t), self.directions[i]);
            let along = slip[0] * e[0] + slip[1] * e[1];
            let increment = pair(&self.increments, i, self.n_t);
            let distance = increment[0].hypot(increment[1]) + springs[i] * bounds[i];
            for a in 0..self.n_t {
                let k = self.n_t * i + a;
                if self.states[i] == PointState::Stick {
                    rates[k] = -slip[a] / springs[i];
                    continue;
                }
                // The turn of the force is across it and does no work.
                increment_rates[k] = slip[a] + springs[i] * bound_rates[i] * e[a];
                rates[k] = bound_rates[i] * e[a] - bounds[i] * (slip[a] - along * e[a]) / distance;
            }
        }
    }
}
