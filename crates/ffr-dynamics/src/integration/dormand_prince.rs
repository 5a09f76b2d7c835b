//! Dormand-Prince 5(4) with dense output (docs/theory.md Eq. T.1 to T.5), free vibrations being exact (T.22 to T.25).
//!
//! Explicit, seven stages, the last of which is the first of the next step. It knows nothing of mechanics: size and
//! acceptance of an error are the system's business ([`OdeSystem::error_norm`]).

use super::dense_output::DenseOutput;
use super::oscillator::{Oscillators, Vibration};
use super::step_control::{Statistics, StepSettings};
use super::stepping::{Failure, Step, StepAttempt, Stepping, is_finite};
use super::system::OdeSystem;
use crate::error::{DynamicsError, EvaluationFailure};

/// Nodes (Dormand & Prince 1980; Hairer, Nørsett & Wanner, *Solving ODEs I*, Table II.5.2).
const C: [f64; 7] = [0.0, 1.0 / 5.0, 3.0 / 10.0, 4.0 / 5.0, 8.0 / 9.0, 1.0, 1.0];
/// Stage coefficients (same source); the last row is the fifth-order solution.
const A: [[f64; 6]; 7] = [
    [0.0; 6],
    [1.0 / 5.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    [3.0 / 40.0, 9.0 / 40.0, 0.0, 0.0, 0.0, 0.0],
    [44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0, 0.0, 0.0, 0.0],
    [19372.0 / 6561.0, -25360.0 / 2187.0, 64448.0 / 6561.0, -212.0 / 729.0, 0.0, 0.0],
    [9017.0 / 3168.0, -355.0 / 33.0, 46732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18656.0, 0.0],
    [35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0],
];
/// Fifth-order minus fourth-order weights (same source).
const E: [f64; 7] =
    [71.0 / 57600.0, 0.0, -71.0 / 16695.0, 71.0 / 1920.0, -17253.0 / 339200.0, 22.0 / 525.0, -1.0 / 40.0];
/// Weights of the last coefficient of the dense output (same source, II.6, code DOPRI5).
const D: [f64; 7] = [
    -12715105075.0 / 11282082432.0,
    0.0,
    87487479700.0 / 32700410799.0,
    -10690763975.0 / 1880347072.0,
    701980252875.0 / 199316789632.0,
    -1453857185.0 / 822651844.0,
    69997945.0 / 29380423.0,
];
/// Power of the step with which the error estimate grows.
const ORDER: f64 = 5.0;
/// Share of the tolerance aimed at by the first step (same source, II.4).
const FIRST_STEP_ERROR: f64 = 0.01;
/// What helps when the steps become too short.
const REMEDY: &str = "loosen the tolerance or soften the stiffest force";

/// State, workspace and statistics of a Dormand-Prince integration.
#[derive(Debug, Clone)]
pub struct DormandPrince {
    stepping: Stepping,
    /// Rates of the stages; the first is the rate at `(t, y)` if that is valid.
    k: [Vec<f64>; 7],
    trial: Vec<f64>,
    scratch: Vec<f64>,
    dense: [Vec<f64>; 5],
    vibration: Vibration<7>,
}

impl DormandPrince {
    /// An integrator at time `t` in the state `y`.
    ///
    /// # Errors
    /// [`DynamicsError::Data`] if a step of the settings is not positive.
    pub fn new(settings: StepSettings, t: f64, y: &[f64]) -> Result<Self, DynamicsError> {
        let zeros = || vec![0.0; y.len()];
        Ok(Self {
            stepping: Stepping::new(settings, ORDER, REMEDY, t, y)?,
            k: std::array::from_fn(|_| zeros()),
            trial: zeros(),
            scratch: zeros(),
            dense: std::array::from_fn(|_| zeros()),
            vibration: Vibration::new(C),
        })
    }

    /// Makes room for the free vibrations of a system, so that its first step allocates nothing.
    pub(super) fn make_room(&mut self, of: Oscillators<'_>) {
        if self.stepping.settings.is_vibration_exact {
            self.vibration.take_over(of);
        }
    }

    /// Time reached \[s\].
    pub fn time(&self) -> f64 {
        self.stepping.t
    }

    /// State reached.
    pub fn state(&self) -> &[f64] {
        &self.stepping.y
    }

    /// State before the last accepted step (at the start of [`DenseOutput::interval`]).
    pub fn previous_state(&self) -> &[f64] {
        &self.dense[0]
    }

    /// Work done since the integrator was made; restarts do not reset it.
    pub fn statistics(&self) -> Statistics {
        self.stepping.statistics
    }

    /// Last refusal of the right-hand side, in whatever step; `None` if there never was one.
    pub fn last_refusal(&self) -> Option<&EvaluationFailure> {
        self.stepping.last_refusal.as_ref()
    }

    /// Step proposed next, 0 if none is known yet \[s\].
    pub fn proposed_step(&self) -> f64 {
        self.stepping.h
    }

    /// Changes the largest step, for instance at the start of an impact \[s\].
    ///
    /// # Errors
    /// [`DynamicsError::Data`] if it is not positive.
    pub fn set_max_step(&mut self, max_step: f64) -> Result<(), DynamicsError> {
        self.stepping.set_max_step(max_step)
    }

    /// Whether critical errors of the right-hand side end a step, [`StepSettings::stops_at_errors`].
    pub fn stop_at_errors(&mut self, stops: bool) {
        self.stepping.settings.stops_at_errors = stops;
    }

    /// Says that the right-hand side has changed at the present time (a force switched on, another penalty).
    pub fn invalidate(&mut self) {
        self.stepping.is_rate_valid = false;
    }

    /// Goes on from another time and state with the step size proposed so far.
    ///
    /// The dense output of the last step is lost. The system's inner state is not touched: to go back into the last step,
    /// call [`OdeSystem::restore`] as well, which takes it to the step's start. For a state of another size make a new integrator.
    ///
    /// # Panics
    /// If the length of `y` differs from the dimension.
    pub fn restart(&mut self, t: f64, y: &[f64]) {
        self.stepping.restart(t, y);
    }

    /// Takes one step that ends at `t_end` at the latest, and exactly there if it comes near.
    ///
    /// [`OdeSystem::save`] is called before the first attempt, [`OdeSystem::restore`] after each rejected one.
    /// After the step the system's inner state belongs to its end. At `t_end` already, nothing happens.
    ///
    /// # Errors
    /// [`DynamicsError::Integration`] when the step has shrunk until it no longer moves the clock, or the state is not
    /// finite, or the right-hand side refuses the state reached. The integrator stays at the last accepted state.
    ///
    /// # Panics
    /// If the system has another number of equations than the integrator.
    pub fn step<S: OdeSystem + ?Sized>(&mut self, system: &mut S, t_end: f64) -> Result<Step, DynamicsError> {
        if let Some(empty) = self.stepping.begin(system, t_end, &mut self.k[0])? {
            return Ok(empty);
        }
        if self.stepping.h <= 0.0 {
            let wanted = self.stepping.settings.initial_step;
            self.stepping.h = wanted.unwrap_or_else(|| self.first_step(system, t_end));
        }
        let is_exact = self.stepping.settings.is_vibration_exact;
        let oscillators = if is_exact { system.oscillators() } else { Oscillators::default() };
        self.vibration.begin(oscillators, &self.stepping.y, &self.k[0]);
        if !self.stepping.settings.is_fixed {
            self.stepping.h = self.stepping.h.min(self.vibration.longest_step());
        }
        loop {
            let attempt = self.stepping.next_attempt(t_end);
            match self.attempt(system, attempt.h) {
                Ok(error) if error <= 1.0 => return Ok(self.accept(system, attempt, error)),
                outcome => {
                    system.restore();
                    self.stepping.reject(attempt.h, t_end, outcome)?;
                }
            }
        }
    }

    /// Steps until `t_end`, calling `observe` after each accepted step; returns the time reached.
    ///
    /// `observe` answers whether to go on.
    ///
    /// # Errors
    /// As [`DormandPrince::step`].
    pub fn run<S: OdeSystem + ?Sized>(
        &mut self,
        system: &mut S,
        t_end: f64,
        mut observe: impl FnMut(&mut S, &Self) -> bool,
    ) -> Result<f64, DynamicsError> {
        while self.stepping.t < t_end {
            self.step(system, t_end)?;
            if !observe(system, self) {
                break;
            }
        }
        Ok(self.stepping.t)
    }

    /// First step size (Eq. T.5): the change of the right-hand side over a small Euler step tells the time scale.
    fn first_step<S: OdeSystem + ?Sized>(&mut self, system: &mut S, t_end: f64) -> f64 {
        let largest = self.stepping.settings.max_step.min(t_end - self.stepping.t);
        let size = system.error_norm(&self.stepping.y, &self.stepping.y, &self.stepping.y);
        let rate = system.error_norm(&self.stepping.y, &self.stepping.y, &self.k[0]);
        let is_known = size > 1e-5 && rate > 1e-5 && (size / rate).is_finite();
        let mut h = if is_known { 0.01 * size / rate } else { 1e-3 * largest }.min(largest);
        for _ in 0..4 {
            for ((trial, y), k) in self.trial.iter_mut().zip(&self.stepping.y).zip(&self.k[0]) {
                *trial = y + h * k;
            }
            self.stepping.statistics.evaluations += 1;
            let outcome = system.rhs(self.stepping.t + h, &self.trial, &mut self.k[1]);
            system.restore();
            for ((s, k1), k0) in self.scratch.iter_mut().zip(&self.k[1]).zip(&self.k[0]) {
                *s = (k1 - k0) / h;
            }
            let change = system.error_norm(&self.stepping.y, &self.stepping.y, &self.scratch);
            if outcome.is_ok() && change.is_finite() && rate.is_finite() {
                let steepest = rate.max(change);
                let by_change =
                    if steepest > 1e-15 { (FIRST_STEP_ERROR / steepest).powf(0.2) } else { largest };
                return (100.0 * h).min(by_change).min(largest);
            }
            h *= 0.01;
        }
        h
    }

    /// Stages 2 to 7 and the error norm; the new state is left in `trial`.
    fn attempt<S: OdeSystem + ?Sized>(&mut self, system: &mut S, h: f64) -> Result<f64, Failure> {
        self.vibration.prepare(h);
        for stage in 1..7 {
            let (known, rest) = self.k.split_at_mut(stage);
            combine(&mut self.trial, h, &A[stage][..stage], known);
            for (x, y) in self.trial.iter_mut().zip(&self.stepping.y) {
                *x += y;
            }
            self.vibration.place(stage, &A[stage][..stage], &mut self.trial);
            if !is_finite(&self.trial) {
                return Err(Failure::NotFinite);
            }
            self.stepping.statistics.evaluations += 1;
            system.rhs(self.stepping.t + C[stage] * h, &self.trial, &mut rest[0])?;
            self.vibration.take(stage, &self.trial, &rest[0]);
        }
        combine(&mut self.scratch, h, &E, &self.k);
        self.vibration.place_error(&E, &A[6], &mut self.scratch);
        if !is_finite(&self.k[6]) {
            return Err(Failure::NotFinite); // earlier stages that are not finite show in the state tried
        }
        if self.stepping.settings.is_fixed {
            return Ok(0.0);
        }
        Ok(system.error_norm(&self.stepping.y, &self.trial, &self.scratch))
    }

    /// Moves on to the state in `trial`.
    fn accept<S: OdeSystem + ?Sized>(&mut self, system: &mut S, attempt: StepAttempt, error: f64) -> Step {
        system.finish_quadratures(&mut self.trial, &mut self.k[6]);
        self.store_dense_output(attempt.h);
        self.vibration.end(&A[6], &D, &mut self.trial);
        self.k.swap(0, 6);
        let growth = self.stepping.controller.accepted(error);
        self.stepping.accept(system, attempt, error, growth, &mut self.trial)
    }

    /// Coefficients of the fourth-order interpolant (Eq. T.2).
    fn store_dense_output(&mut self, h: f64) {
        combine(&mut self.dense[4], h, &D, &self.k);
        for i in 0..self.stepping.y.len() {
            let difference = self.trial[i] - self.stepping.y[i];
            let third = h * self.k[0][i] - difference;
            self.dense[0][i] = self.stepping.y[i];
            self.dense[1][i] = difference;
            self.dense[2][i] = third;
            self.dense[3][i] = difference - h * self.k[6][i] - third;
        }
    }
}

/// `out = h Σ_i weights_i k_i`, skipping zero weights.
fn combine(out: &mut [f64], h: f64, weights: &[f64], k: &[Vec<f64>]) {
    out.fill(0.0);
    for (&weight, stage) in weights.iter().zip(k).filter(|(w, _)| w.abs() > 0.0) {
        let factor = h * weight;
        for (o, value) in out.iter_mut().zip(stage) {
            *o += factor * value;
        }
    }
}

impl DenseOutput for DormandPrince {
    fn interval(&self) -> (f64, f64) {
        self.stepping.interval
    }

    fn dimension(&self) -> usize {
        self.stepping.y.len()
    }

    fn interpolate(&self, t: f64, out: &mut [f64]) {
        let (start, end) = self.stepping.interval;
        if end <= start {
            out.copy_from_slice(&self.stepping.y);
            return;
        }
        let theta = (t - start) / (end - start);
        let rest = 1.0 - theta;
        let [d0, d1, d2, d3, d4] = &self.dense;
        assert_eq!(out.len(), d0.len(), "the output is as long as the state");
        for (i, o) in out.iter_mut().enumerate() {
            *o = d0[i] + theta * (d1[i] + rest * (d2[i] + theta * (d3[i] + rest * d4[i])));
        }
        self.vibration.interpolate(theta, out);
    }
}
