//! What one-step methods do each in their own way, and the loop that they share.

use super::stepping::{Failure, Step, StepAttempt, Stepping};
use super::system::OdeSystem;
use crate::error::DynamicsError;

/// Stages, error and dense output of a one-step method. Time, state and step are in [`Stepping`].
pub(super) trait OneStepMethod {
    /// Rate at the start of the next step, valid if [`Stepping::is_rate_valid`].
    fn rate(&mut self) -> &mut [f64];

    /// Size of the first step \[s\].
    fn first_step<S: OdeSystem + ?Sized>(
        &mut self,
        stepping: &mut Stepping,
        system: &mut S,
        t_end: f64,
    ) -> f64;

    /// Prepares a step, whose rate is known.
    fn begin<S: OdeSystem + ?Sized>(&mut self, _stepping: &mut Stepping, _system: &mut S) {}

    /// All stages of a step of size `h`; keeps the new state and returns the norm of its error.
    fn attempt<S: OdeSystem + ?Sized>(
        &mut self,
        stepping: &mut Stepping,
        system: &mut S,
        h: f64,
    ) -> Result<f64, Failure>;

    /// Moves on to the state of the last attempt.
    fn accept<S: OdeSystem + ?Sized>(
        &mut self,
        stepping: &mut Stepping,
        system: &mut S,
        attempt: StepAttempt,
        error: f64,
    ) -> Step;

    /// Whether the same step is worth another attempt after `failure`, with a derivative of its own.
    fn renews_for(&mut self, _failure: &Failure) -> bool {
        false
    }

    /// Says that the right-hand side has changed.
    fn invalidate(&mut self) {}

    /// State at the share `theta` of the last step, which began in the state `start`.
    fn interpolate(&self, start: &[f64], theta: f64, out: &mut [f64]);
}

/// One step that ends at `t_end` at the latest: attempts until one is accepted.
pub(super) fn advance<M: OneStepMethod, S: OdeSystem + ?Sized>(
    method: &mut M,
    stepping: &mut Stepping,
    system: &mut S,
    t_end: f64,
) -> Result<Step, DynamicsError> {
    if let Some(empty) = stepping.begin(system, t_end, method.rate())? {
        return Ok(empty);
    }
    if stepping.h <= 0.0 {
        let wanted = stepping.settings.initial_step;
        stepping.h = wanted.unwrap_or_else(|| method.first_step(stepping, system, t_end));
    }
    method.begin(stepping, system);
    loop {
        let attempt = stepping.next_attempt(t_end);
        let outcome = match method.attempt(stepping, system, attempt.h) {
            Ok(error) if error <= 1.0 => return Ok(method.accept(stepping, system, attempt, error)),
            outcome => outcome,
        };
        system.restore();
        let is_renewed = outcome.as_ref().is_err_and(|failure| method.renews_for(failure));
        if !is_renewed {
            stepping.reject(attempt.h, t_end, outcome)?;
        }
    }
}
