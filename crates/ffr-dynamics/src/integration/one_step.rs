//! What one-step methods do each in their own way, and the loop that they share.

use super::step_control::smallest_step;
use super::stepping::{Failure, Step, StepAttempt, Stepping};
use super::system::OdeSystem;
use crate::error::DynamicsError;

/// Repetitions of a step that goes beyond a change of the right-hand side's form; each knows the
/// place better than the one before.
const MAX_CUTS: u32 = 8;
/// Share by which a repeated step aims behind the change, so that the next one begins with the new
/// form.
const BEHIND: f64 = 1e-7;
/// Share of a step that may lie behind the change: a force that sets in with the displacement is
/// late by the square of that.
const OVERSHOT: f64 = 1e-6;

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

    /// State at the end of the last attempt.
    fn trial(&self) -> &[f64];

    /// Moves on to the state of the last attempt.
    fn accept<S: OdeSystem + ?Sized>(
        &mut self,
        stepping: &mut Stepping,
        system: &mut S,
        attempt: StepAttempt,
        error: f64,
    ) -> Step;

    /// Whether the same step is worth another attempt after `failure`, with a derivative of its
    /// own.
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
    let is_fixed = stepping.settings.is_fixed;
    let goal = if is_fixed { t_end } else { t_end.min(system.next_break(stepping.t)) };
    if !is_fixed {
        stepping.h = stepping.h.min(system.longest_step(stepping.t));
    }
    method.begin(stepping, system);
    let (mut cut, mut n_cuts) = (None, if is_fixed { MAX_CUTS } else { 0 });
    loop {
        let attempt = cut.take().unwrap_or_else(|| stepping.next_attempt(goal));
        let outcome = match method.attempt(stepping, system, attempt.h) {
            Ok(error) if error <= 1.0 => {
                let shorter =
                    (n_cuts < MAX_CUTS).then(|| shorter(method, stepping, system, attempt)).flatten();
                if shorter.is_none() {
                    return Ok(method.accept(stepping, system, attempt, error));
                }
                (cut, n_cuts) = (shorter, n_cuts + 1);
                system.restore();
                continue;
            }
            outcome => outcome,
        };
        system.restore();
        let is_renewed = outcome.as_ref().is_err_and(|failure| method.renews_for(failure));
        if !is_renewed {
            stepping.reject(attempt.h, goal, outcome)?;
        }
    }
}

/// The step that ends just behind the place where the right-hand side changes its form, if
/// `attempt` goes farther.
fn shorter<M: OneStepMethod, S: OdeSystem + ?Sized>(
    method: &M,
    stepping: &Stepping,
    system: &S,
    StepAttempt { h, .. }: StepAttempt,
) -> Option<StepAttempt> {
    let share = system.change_of_form(stepping.t, &stepping.y, method.trial(), h)?;
    let wanted = share * h * (1.0 + BEHIND) + 4.0 * smallest_step(stepping.t, stepping.t + h);
    (wanted < (1.0 - OVERSHOT) * h).then_some(StepAttempt { h: wanted, end: stepping.t + wanted })
}
