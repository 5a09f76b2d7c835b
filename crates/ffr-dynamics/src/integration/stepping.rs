//! What a one-step method has besides its stages: time, state and step, the loop's two ends (an
//! attempt accepted, an attempt rejected).

use super::step_control::{Controller, Statistics, StepSettings, smallest_step};
use super::system::OdeSystem;
use crate::error::{DynamicsError, EvaluationFailure, IntegrationFault, Rejection};

/// First step of an implicit method as a share of the time in which the state changes by its own
/// size (Hairer, Nørsett & Wanner, *Solving ODEs I*, II.4).
const FIRST_STEP: f64 = 0.01;

/// An accepted step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step {
    /// Time before the step \[s\].
    pub start: f64,
    /// Time after the step \[s\].
    pub end: f64,
    /// Error norm; 0 with fixed steps.
    pub error: f64,
    /// Trials rejected before this one.
    pub rejected: u32,
}

/// An attempt at a step.
#[derive(Debug, Clone, Copy)]
pub(super) struct StepAttempt {
    /// Its size \[s\].
    pub h: f64,
    /// Time at its end \[s\].
    pub end: f64,
}

/// Why an attempt could not be finished.
pub(super) enum Failure {
    Refused(EvaluationFailure),
    Diverged { iterations: u32, rate: f64 },
    Singular,
    NotFinite,
}

impl Failure {
    /// Whether another derivative may help: the iterations did not converge, or the matrix was
    /// singular.
    pub fn may_be_of_the_derivative(&self) -> bool {
        matches!(self, Self::Diverged { .. } | Self::Singular)
    }
}

impl From<EvaluationFailure> for Failure {
    fn from(refusal: EvaluationFailure) -> Self {
        Self::Refused(refusal)
    }
}

/// Where an integration stands, and how it came there.
#[derive(Debug, Clone)]
pub(super) struct Stepping {
    pub settings: StepSettings,
    pub controller: Controller,
    pub statistics: Statistics,
    /// Time reached \[s\].
    pub t: f64,
    /// State reached.
    pub y: Vec<f64>,
    /// State before the last accepted step.
    pub previous: Vec<f64>,
    /// Proposed next step; 0 where none is known yet \[s\].
    pub h: f64,
    /// Whether the integrator has the rate at `(t, y)`.
    pub is_rate_valid: bool,
    /// Start and end of the last step \[s\].
    pub interval: (f64, f64),
    pub last_refusal: Option<EvaluationFailure>,
    /// Trials rejected in the present step.
    rejected: u32,
    /// What helps the method when its steps become too short.
    remedy: &'static str,
}

impl Stepping {
    /// At time `t` in the state `y`, with a method whose error grows with the step to the power
    /// `order`.
    pub fn new(
        settings: StepSettings,
        order: f64,
        remedy: &'static str,
        t: f64,
        y: &[f64],
    ) -> Result<Self, DynamicsError> {
        settings.check()?;
        Ok(Self {
            settings,
            controller: Controller::new(order),
            statistics: Statistics::default(),
            t,
            y: y.to_vec(),
            previous: y.to_vec(),
            h: 0.0,
            is_rate_valid: false,
            interval: (t, t),
            last_refusal: None,
            rejected: 0,
            remedy,
        })
    }

    pub fn set_max_step(&mut self, max_step: f64) -> Result<(), DynamicsError> {
        let settings = StepSettings { max_step, ..self.settings };
        settings.check()?;
        self.settings = settings;
        Ok(())
    }

    /// Goes on from another time and state with the step size proposed so far.
    pub fn restart(&mut self, t: f64, y: &[f64]) {
        assert_eq!(y.len(), self.y.len(), "a restart keeps the number of equations");
        self.t = t;
        self.y.copy_from_slice(y);
        self.interval = (t, t);
        self.is_rate_valid = false;
        self.controller.forget();
    }

    /// Begins a step: saves the system's inner state and fills `rate` with the rate at `(t, y)` if
    /// it is not there already. Returns an empty step if `t_end` is reached.
    pub fn begin<S: OdeSystem + ?Sized>(
        &mut self,
        system: &mut S,
        t_end: f64,
        rate: &mut [f64],
    ) -> Result<Option<Step>, DynamicsError> {
        assert_eq!(
            system.dimension(),
            self.y.len(),
            "system and integrator have the same number of equations"
        );
        if self.t >= t_end {
            return Ok(Some(Step { start: self.t, end: self.t, error: 0.0, rejected: 0 }));
        }
        if !t_end.is_finite() {
            return Err(self.failure(IntegrationFault::EndTime { end: t_end }));
        }
        system.save();
        self.rejected = 0;
        if !self.is_rate_valid {
            self.find_rate(system, rate)?;
        }
        Ok(None)
    }

    fn find_rate<S: OdeSystem + ?Sized>(
        &mut self,
        system: &mut S,
        rate: &mut [f64],
    ) -> Result<(), DynamicsError> {
        if let Some(component) = self.y.iter().position(|v| !v.is_finite()) {
            return Err(self.failure(IntegrationFault::State { component }));
        }
        self.statistics.evaluations += 1;
        if let Err(refusal) = system.rhs(self.t, &self.y, rate) {
            self.note(refusal.clone());
            return Err(self.failure(IntegrationFault::NoForces(refusal)));
        }
        if let Some(component) = rate.iter().position(|v| !v.is_finite()) {
            return Err(self.failure(IntegrationFault::Rate { component }));
        }
        self.is_rate_valid = true;
        Ok(())
    }

    /// First step size of an implicit method (Eq. T.23): a small share of the time in which the
    /// state changes by its own size at the rate `rate`; too large, it is rejected.
    pub fn first_implicit_step<S: OdeSystem + ?Sized>(
        &self,
        system: &mut S,
        rate: &[f64],
        t_end: f64,
    ) -> f64 {
        let largest = self.settings.max_step.min(t_end - self.t);
        let size = system.damped_error_norm(&self.y, &self.y, &self.y);
        let rate = system.damped_error_norm(&self.y, &self.y, rate);
        let is_known = size > 1e-5 && rate > 1e-5 && (size / rate).is_finite();
        let wanted = if is_known { FIRST_STEP * size / rate } else { 1e-3 * largest };
        wanted.min(largest)
    }

    /// The step to be tried next on the way to `t_end`.
    pub fn next_attempt(&self, t_end: f64) -> StepAttempt {
        let (h, is_last) = self.settings.next_step(self.t, self.h, t_end);
        StepAttempt { h, end: if is_last { t_end } else { self.t + h } }
    }

    /// Moves on to the state in `trial`, and proposes a step `growth` times as long.
    pub fn accept<S: OdeSystem + ?Sized>(
        &mut self,
        system: &mut S,
        StepAttempt { h, end }: StepAttempt,
        error: f64,
        growth: f64,
        trial: &mut Vec<f64>,
    ) -> Step {
        let start = self.t;
        self.t = end;
        self.interval = (start, end);
        std::mem::swap(&mut self.previous, &mut self.y);
        std::mem::swap(&mut self.y, trial);
        self.is_rate_valid = !system.project(self.t, &mut self.y);
        self.statistics.steps += 1;
        let proposed = h * growth;
        // A step cut short by the caller's end time says nothing against the longer one proposed
        // before.
        let is_cut_short = self.rejected == 0 && proposed >= h;
        self.h = if is_cut_short { proposed.max(self.h) } else { proposed };
        if self.settings.is_fixed {
            self.h = self.settings.max_step;
        }
        Step { start, end, error, rejected: self.rejected }
    }

    /// Books an attempt of size `h` that failed or has too large an error, and proposes a shorter
    /// one, or says why there is none.
    pub fn reject(&mut self, h: f64, t_end: f64, outcome: Result<f64, Failure>) -> Result<(), DynamicsError> {
        self.rejected += 1;
        self.statistics.rejected += 1;
        let shrunk = h * self.controller.rejected(outcome.as_ref().ok().copied());
        let is_critical = matches!(&outcome, Err(Failure::Refused(r)) if self.settings.stops_at(r));
        let is_shortest = self.settings.is_fixed || shrunk < smallest_step(self.t, t_end);
        let rejection = (is_critical || is_shortest).then(|| rejection(&outcome));
        if let Err(Failure::Refused(refusal)) = outcome {
            self.note(refusal);
        }
        match rejection {
            Some(rejection) if is_critical => Err(self.failure(IntegrationFault::Critical(rejection))),
            Some(rejection) => Err(self.underflow(shrunk, rejection)),
            None => {
                self.h = shrunk;
                Ok(())
            }
        }
    }

    fn note(&mut self, refusal: EvaluationFailure) {
        self.statistics.refused += 1;
        self.last_refusal = Some(refusal);
    }

    fn underflow(&self, step: f64, rejection: Rejection) -> DynamicsError {
        let remedy = if self.settings.is_fixed { "take a smaller fixed step" } else { self.remedy };
        self.failure(IntegrationFault::StepTooShort { step, rejection, remedy })
    }

    fn failure(&self, fault: IntegrationFault) -> DynamicsError {
        DynamicsError::Integration { time: self.t, fault }
    }
}

/// Why an attempt was rejected.
fn rejection(outcome: &Result<f64, Failure>) -> Rejection {
    match outcome {
        Err(Failure::Refused(refusal)) => Rejection::Refused(refusal.clone()),
        &Err(Failure::Diverged { iterations, rate }) => Rejection::Diverged { iterations, rate },
        Err(Failure::Singular) => Rejection::Singular,
        &Ok(norm) if norm.is_finite() => Rejection::Error { norm },
        Ok(_) | Err(Failure::NotFinite) => Rejection::NotFinite,
    }
}

pub(super) fn is_finite(x: &[f64]) -> bool {
    x.iter().all(|v| v.is_finite())
}
