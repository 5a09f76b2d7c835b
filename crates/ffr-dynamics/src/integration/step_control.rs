//! Step size control: proportional-integral controller, limits, statistics (docs/theory.md Eq. T.3,
//! T.4).

use crate::data_error::DataError;
use crate::error::{DynamicsError, EvaluationFailure};

/// Safety factor of the proposed step (Hairer, Nørsett & Wanner, *Solving ODEs I*, II.4).
const SAFETY: f64 = 0.9;
/// Smallest factor from one step to the next (the same source, code DOPRI5).
const MIN_FACTOR: f64 = 0.2;
/// Largest factor from one step to the next (the same source, code DOPRI5).
const MAX_FACTOR: f64 = 10.0;
/// Integral part of the controller as a share of `1/order`: 0.04 for order five (the same source,
/// code DOPRI5).
const INTEGRAL_SHARE: f64 = 0.2;
/// A step that may grow by less than this keeps its size, and with it the factors of an implicit
/// method (Hairer & Wanner, *Solving ODEs II*, IV.8, code RADAU5).
const KEPT_GROWTH: f64 = 1.2;
/// Smallest remembered error; keeps the integral part bounded after error-free steps.
const MIN_ERROR: f64 = 1e-4;
/// Factor of the step after a refusal of the right-hand side or a result that is not finite, where
/// no error is known.
const REFUSAL_FACTOR: f64 = 0.25;

/// How an integrator chooses its steps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepSettings {
    /// First step; `None` lets the integrator find one \[s\].
    pub initial_step: Option<f64>,
    /// Largest step \[s\].
    pub max_step: f64,
    /// Takes every step with `max_step` and without error control; for order tests and comparisons.
    pub is_fixed: bool,
    /// Ends a step in which the right-hand side refused a state with a critical error of a contact
    /// solver, in place of trying a shorter one.
    pub stops_at_errors: bool,
    /// Whether the explicit method takes free vibrations from their closed form (Eq. T.9) in place
    /// of following them.
    pub is_vibration_exact: bool,
}

impl Default for StepSettings {
    fn default() -> Self {
        Self {
            initial_step: None,
            max_step: f64::INFINITY,
            is_fixed: false,
            stops_at_errors: false,
            is_vibration_exact: false,
        }
    }
}

impl StepSettings {
    /// Error-controlled steps up to `max_step` \[s\].
    pub fn with_max_step(max_step: f64) -> Self {
        Self { max_step, ..Self::default() }
    }

    /// Equal steps without error control \[s\].
    pub fn fixed(step: f64) -> Self {
        Self { initial_step: Some(step), max_step: step, is_fixed: true, ..Self::default() }
    }

    /// Refuses steps that are not positive.
    ///
    /// # Errors
    /// [`DynamicsError::Data`] with the offending number.
    pub fn check(&self) -> Result<(), DynamicsError> {
        let is_positive = |h: f64| h > 0.0; // false for NaN
        if !is_positive(self.max_step) || (self.is_fixed && !self.max_step.is_finite()) {
            let what = "the largest time step [s]".into();
            return Err(DataError::OutOfRange { what, value: self.max_step, range: "> 0" }.into());
        }
        match self.initial_step {
            Some(value) if !is_positive(value) || !value.is_finite() => {
                let what = "the first time step [s]".into();
                Err(DataError::OutOfRange { what, value, range: "> 0 and finite" }.into())
            }
            _ => Ok(()),
        }
    }

    /// Whether a refusal ends the step.
    pub(super) fn stops_at(&self, refusal: &EvaluationFailure) -> bool {
        self.stops_at_errors && refusal.kind().is_critical()
    }

    /// Size of the step to try from `t` when `proposed` is wanted, and whether it ends at `t_end`.
    pub(super) fn next_step(&self, t: f64, proposed: f64, t_end: f64) -> (f64, bool) {
        let wanted = proposed.min(self.max_step);
        let left = t_end - t;
        // A remainder below a millionth of a step is round-off of the caller's time grid.
        if left <= wanted * (1.0 + 1e-6) {
            (left, true)
        } else if left < 2.0 * wanted && !self.is_fixed {
            (0.5 * left, false) // two equal steps instead of a full and a tiny one
        } else {
            (wanted, false)
        }
    }
}

/// Work done so far.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Statistics {
    /// Accepted steps.
    pub steps: u64,
    /// Rejected steps, whatever the reason.
    pub rejected: u64,
    /// Of these, steps in which the right-hand side refused a state (contact solver without a
    /// solution).
    pub refused: u64,
    /// Evaluations of the right-hand side, refused ones included.
    pub evaluations: u64,
    /// Newton iterations; 0 for explicit methods.
    pub iterations: u64,
    /// Jacobians formed; 0 for explicit methods.
    pub jacobians: u64,
    /// Iteration matrices factorised; 0 for explicit methods.
    pub factorisations: u64,
}

/// Proportional-integral controller (Eq. T.4).
#[derive(Debug, Clone)]
pub(super) struct Controller {
    /// Exponent of the error, `1/k - 3/4 beta` (the same source as above, IV.2).
    alpha: f64,
    /// Exponent of the previous error.
    beta: f64,
    previous_error: f64,
    follows_rejection: bool,
}

impl Controller {
    /// For an error estimate that grows with the step to the power `order`.
    pub(super) fn new(order: f64) -> Self {
        let beta = INTEGRAL_SHARE / order;
        let alpha = 1.0 / order - 0.75 * beta;
        Self { alpha, beta, previous_error: MIN_ERROR, follows_rejection: false }
    }

    /// Forgets the steps so far.
    pub(super) fn forget(&mut self) {
        (self.previous_error, self.follows_rejection) = (MIN_ERROR, false);
    }

    /// Factor from the accepted step with error `error` to the next one.
    pub(super) fn accepted(&mut self, error: f64) -> f64 {
        let wanted = SAFETY * error.max(1e-300).powf(-self.alpha) * self.previous_error.powf(self.beta);
        let largest = if self.follows_rejection { 1.0 } else { MAX_FACTOR };
        self.previous_error = error.max(MIN_ERROR);
        self.follows_rejection = false;
        wanted.clamp(MIN_FACTOR, largest)
    }

    /// Factor from the step rejected with error `error` to its repetition; without a finite error,
    /// a fixed one.
    pub(super) fn rejected(&mut self, error: Option<f64>) -> f64 {
        self.follows_rejection = true;
        match error {
            Some(e) if e.is_finite() => (SAFETY * e.powf(-self.alpha)).clamp(MIN_FACTOR, 1.0),
            _ => REFUSAL_FACTOR,
        }
    }
}

/// Growth `growth` of a step, 1 where it is not worth other factors.
pub(super) fn worthwhile_growth(growth: f64) -> f64 {
    if (1.0..KEPT_GROWTH).contains(&growth) { 1.0 } else { growth }
}

/// Smallest step that still moves the clock by a meaningful amount on the way from `t` to `t_end`
/// \[s\].
pub(super) fn smallest_step(t: f64, t_end: f64) -> f64 {
    16.0 * f64::EPSILON * t.abs().max(t_end.abs())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn growth_is_forbidden_right_after_a_rejection() {
        let mut controller = Controller::new(5.0);
        assert!(controller.rejected(Some(20.0)) < 1.0);
        assert!(controller.accepted(1e-3) <= 1.0);
        assert!(controller.accepted(1e-3) > 1.0);
    }

    #[test]
    fn settings_refuse_steps_that_are_not_positive() {
        for max_step in [0.0, -1.0, f64::NAN] {
            assert!(StepSettings::with_max_step(max_step).check().is_err());
        }
        assert!(StepSettings { initial_step: Some(f64::NAN), ..Default::default() }.check().is_err());
        assert!(StepSettings::fixed(f64::INFINITY).check().is_err());
        assert!(StepSettings::default().check().is_ok());
    }
}
