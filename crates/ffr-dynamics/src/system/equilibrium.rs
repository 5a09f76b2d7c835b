//! Static start: elastic coordinates that do not accelerate (docs/theory.md Eq. M.24).

use std::ops::DerefMut;

use faer::Mat;
use faer::prelude::Solve;

use super::active::ActiveForce;
use super::multibody::Multibody;
use crate::error::{DynamicsError, StaticStartFault};
use crate::integration::OdeSystem;

/// Share of the elastic energy that the last correction may have.
const TOLERANCE: f64 = 1e-24;
/// Share below which corrections that do not shrink any more are round-off: that of forces at a joint, 1e-16, counts as often as the
/// body outweighs what little of it the joint moves at once, some millions of times in a model with all its modes.
const ROUND_OFF: f64 = 1e-16;
/// Corrections; each gains several digits, as elastic forces outweigh the change of all others by deformation.
const MAX_CORRECTIONS: usize = 40;

impl<F: DerefMut<Target: ActiveForce>> Multibody<F> {
    /// Sets the elastic coordinates in `y` such that `d²q_e/dt² = 0` at time `t`, and their rates to zero.
    ///
    /// Joint coordinates are held; joint velocities are set to zero as well. The joints are free to accelerate: released
    /// from this state, the bodies begin to move without vibration.
    ///
    /// # Errors
    /// [`DynamicsError::StaticStart`] if the corrections do not converge (too soft bodies), a force element refuses, or there are
    /// loop-closing joints, which the deformation would open.
    pub fn static_start(&mut self, t: f64, y: &mut [f64]) -> Result<(), DynamicsError> {
        let fail = |fault| Err(DynamicsError::StaticStart(fault));
        if !self.model.loops.is_empty() {
            return fail(StaticStartFault::LoopClosing);
        }
        let layouts: Vec<_> = self.model.bodies.iter().map(|b| b.layout).collect();
        for layout in &layouts {
            y[layout.velocities()].fill(0.0);
            y[layout.elastic_rates()].fill(0.0);
        }
        // Place in the state, place among the rates, stiffness.
        let mut unknowns = Vec::new();
        for (layout, body) in layouts.iter().zip(&self.model.bodies) {
            let places = layout.elastic().zip(layout.rates_elastic()).zip(&body.data.modal_stiffness);
            unknowns.extend(places.map(|((state, rate), k)| (state, rate, *k)));
        }
        if unknowns.is_empty() {
            return Ok(());
        }
        let mut rates = vec![0.0; self.dimension()];
        let mut last = f64::INFINITY;
        for _ in 0..MAX_CORRECTIONS {
            if let Err(refusal) = self.rhs(t, y, &mut rates) {
                return fail(refusal.into());
            }
            let correction = self.elastic_correction(&unknowns);
            let (mut moved, mut stored) = (0.0, 0.0);
            for ((state, _, k), change) in unknowns.iter().zip(&correction) {
                y[*state] += change;
                moved += k * change * change;
                stored += k * y[*state] * y[*state];
            }
            if !moved.is_finite() {
                break;
            }
            if moved <= TOLERANCE * stored || (moved <= ROUND_OFF * stored && moved >= last) {
                return Ok(());
            }
            last = moved;
        }
        fail(StaticStartFault::NotConverged { corrections: MAX_CORRECTIONS })
    }

    /// Change of the elastic coordinates that takes their accelerations away if all forces but the elastic ones stay.
    fn elastic_correction(&mut self, unknowns: &[(usize, usize, f64)]) -> Vec<f64> {
        let n = unknowns.len();
        let mut mobility = Mat::<f64>::zeros(n, n);
        for (j, (_, rate, _)) in unknowns.iter().enumerate() {
            let response = self.workspace.unit_response(&self.model, *rate);
            for (i, (_, rate, _)) in unknowns.iter().enumerate() {
                mobility[(i, j)] = response[*rate];
            }
        }
        let acceleration = Mat::from_fn(n, 1, |i, _| self.workspace.accelerations.rates[unknowns[i].1]);
        let force = mobility.partial_piv_lu().solve(&acceleration);
        unknowns.iter().enumerate().map(|(i, (_, _, k))| force[(i, 0)] / k).collect()
    }
}
