//! Implicit Runge-Kutta methods with an explicit first stage and one iteration matrix: TR-BDF2, and one of order four
//! (docs/theory.md Eq. T.9 to T.17, T.20, T.21).
//!
//! L-stable, with an error estimate filtered by the iteration matrix. Modes whose period is far below the step are not resolved
//! but damped out; what they lose shows as a loss of the system's energy. It knows nothing of mechanics: size and acceptance of an
//! error are the system's business ([`OdeSystem::damped_error_norm`]).

use super::dense_output::DenseOutput;
use super::jacobian::{Differences, Structure};
use super::linearisation::Linearisation;
use super::newton::IterationMatrix;
use super::step_control::{Statistics, StepSettings};
use super::stepping::{Failure, Step, StepAttempt, Stepping, is_finite};
use super::system::OdeSystem;
use super::tableau::{ESDIRK4, MAX_STAGES, TR_BDF2, Tableau};
use crate::error::{DynamicsError, EvaluationFailure};

/// Error that Newton's method may leave, as a share of the error permitted in a step (Hairer & Wanner, *Solving ODEs II*, IV.8).
const NEWTON_TOLERANCE: f64 = 0.03;
/// Newton iterations in a stage after which the step counts as failed (same source).
const MAX_ITERATIONS: u32 = 7;
/// Convergence rate of Newton's method above which the next step begins with a new Jacobian.
const SLOW_RATE: f64 = 0.2;
/// A step that may grow by less than this keeps its size, and with it the factors (same source, code RADAU5).
const KEPT_GROWTH: f64 = 1.2;
/// First step as a share of the time in which the state changes by its own size (same source, part I, II.4).
const FIRST_STEP: f64 = 0.01;
/// What helps when the steps become too short.
const REMEDY: &str = "look for a force that jumps, or take the explicit method";

/// State, workspace and statistics of an integration.
#[derive(Debug)]
pub struct Esdirk {
    method: &'static Tableau,
    stepping: Stepping,
    /// Whether the derivative may be used in the next step.
    is_derivative_valid: bool,
    /// Whether the derivative was formed at `(t, y)`.
    is_derivative_fresh: bool,
    structure: Structure,
    derivative: Linearisation,
    differences: Differences,
    matrix: IterationMatrix,
    newton: Newton,
    /// Rates of the stages; the first is the rate at `(t, y)` if that is valid.
    k: Vec<Vec<f64>>,
    /// Weighted sum of the rates before a stage, over the weight of its own: `(base - y) / (d h)`.
    shift: Vec<f64>,
    /// State in the middle that the continuous extension passes through.
    middle: Vec<f64>,
    trial: Vec<f64>,
    scratch: Vec<f64>,
    correction: Vec<f64>,
    dense: [Vec<f64>; 4],
}

/// What Newton's method has learned from its last iterations.
#[derive(Debug, Clone, Copy)]
struct Newton {
    /// Factor from the last correction to the error left.
    error_factor: f64,
    /// Slowest convergence rate in the present step.
    rate: f64,
}

impl Esdirk {
    /// TR-BDF2, of order two, for `system` at time `t` in the state `y`.
    ///
    /// # Errors
    /// As [`Esdirk::of_order_four`].
    ///
    /// # Panics
    /// If the length of `y` differs from the system's dimension.
    pub fn tr_bdf2<S: OdeSystem + ?Sized>(
        settings: StepSettings,
        t: f64,
        y: &[f64],
        system: &S,
    ) -> Result<Self, DynamicsError> {
        Self::new(&TR_BDF2, settings, t, y, system)
    }

    /// ESDIRK4(3)6L\[2\]SA, of order four, for `system` at time `t` in the state `y`.
    ///
    /// It keeps the system's [`OdeSystem::kinematics`]; all steps must be taken with that system.
    ///
    /// # Errors
    /// [`DynamicsError::Data`] if a step of the settings is not positive or the kinematics do not fit the state.
    ///
    /// # Panics
    /// If the length of `y` differs from the system's dimension.
    pub fn of_order_four<S: OdeSystem + ?Sized>(
        settings: StepSettings,
        t: f64,
        y: &[f64],
        system: &S,
    ) -> Result<Self, DynamicsError> {
        Self::new(&ESDIRK4, settings, t, y, system)
    }

    fn new<S: OdeSystem + ?Sized>(
        method: &'static Tableau,
        settings: StepSettings,
        t: f64,
        y: &[f64],
        system: &S,
    ) -> Result<Self, DynamicsError> {
        assert_eq!(system.dimension(), y.len(), "the state has the system's number of equations");
        let structure = Structure::of(system)?;
        let zeros = || vec![0.0; y.len()];
        Ok(Self {
            method,
            stepping: Stepping::new(settings, method.order, REMEDY, t, y)?,
            is_derivative_valid: false,
            is_derivative_fresh: false,
            derivative: Linearisation::new(structure.unknowns.len()),
            differences: Differences::new(y.len()),
            matrix: IterationMatrix::new(&structure),
            newton: Newton { error_factor: 1.0, rate: 0.0 },
            structure,
            k: (0..method.n_stages()).map(|_| zeros()).collect(),
            shift: zeros(),
            middle: zeros(),
            trial: zeros(),
            scratch: zeros(),
            correction: zeros(),
            dense: std::array::from_fn(|_| zeros()),
        })
    }

    /// Whether it is TR-BDF2.
    pub(super) fn is_tr_bdf2(&self) -> bool {
        std::ptr::eq(self.method, &TR_BDF2)
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

    /// Changes the largest step \[s\].
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
        self.is_derivative_valid = false;
        self.is_derivative_fresh = false;
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
        self.invalidate();
    }

    /// Takes one step that ends at `t_end` at the latest, and exactly there if it comes near.
    ///
    /// [`OdeSystem::save`] is called before the first attempt, [`OdeSystem::restore`] after each failed one and after differences
    /// of the right-hand side. After the step the inner state of a system with memory belongs to the step's end.
    /// At `t_end` already, nothing happens.
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
        loop {
            let attempt = self.stepping.next_attempt(t_end);
            let outcome = match self.attempt(system, attempt.h) {
                Ok(error) if error <= 1.0 => return Ok(self.accept(system, attempt, error)),
                outcome => outcome,
            };
            system.restore();
            if matches!(outcome, Err(Failure::Diverged { .. } | Failure::Singular))
                && !self.is_derivative_fresh
            {
                self.is_derivative_valid = false; // the same step again with a derivative of its own
                continue;
            }
            self.stepping.reject(attempt.h, t_end, outcome)?;
        }
    }

    /// Steps until `t_end`, calling `observe` after each accepted step; returns the time reached.
    ///
    /// `observe` answers whether to go on.
    ///
    /// # Errors
    /// As [`Esdirk::step`].
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

    /// First step size (Eq. T.16): a small share of the time in which the state changes by its own size; too large, it is rejected.
    fn first_step<S: OdeSystem + ?Sized>(&self, system: &mut S, t_end: f64) -> f64 {
        let largest = self.stepping.settings.max_step.min(t_end - self.stepping.t);
        let size = system.damped_error_norm(&self.stepping.y, &self.stepping.y, &self.stepping.y);
        let rate = system.damped_error_norm(&self.stepping.y, &self.stepping.y, &self.k[0]);
        let is_known = size > 1e-5 && rate > 1e-5 && (size / rate).is_finite();
        let wanted = if is_known { FIRST_STEP * size / rate } else { 1e-3 * largest };
        wanted.min(largest)
    }

    /// All stages of a step of size `h`; leaves the new state in `trial` and returns its error (Eq. T.9 to T.12).
    fn attempt<S: OdeSystem + ?Sized>(&mut self, system: &mut S, h: f64) -> Result<f64, Failure> {
        let method = self.method;
        let weight = method.diagonal * h;
        self.linearise(system, weight)?;
        self.newton.rate = 0.0;
        self.shift.fill(0.0);
        for stage in 1..method.n_stages() {
            self.begin_stage(stage, weight);
            self.solve_stage(system, stage, self.stepping.t + method.nodes[stage] * h, weight)?;
            if let Some(share) = method.middle_weights.get(stage - 1) {
                for (middle, y) in self.middle.iter_mut().zip(&self.trial) {
                    *middle = if stage == 1 { share * y } else { *middle + share * y };
                }
            }
        }
        let error = self.error(system, h);
        if error <= 1.0 && system.has_memory() {
            self.stepping.statistics.evaluations += 1;
            system.rhs(self.stepping.t + h, &self.trial, &mut self.scratch)?;
        }
        Ok(error)
    }

    /// The known part of a stage's state, in `scratch`, and a first guess of its rate (T.20): that of the system linearised about the
    /// stage before, by which unresolved modes never leave their size.
    fn begin_stage(&mut self, stage: usize, weight: f64) {
        let mut factors = [0.0; MAX_STAGES];
        for (factor, a) in factors.iter_mut().zip(self.method.weights[stage - 1]) {
            *factor = a / self.method.diagonal;
        }
        let (known, rest) = self.k.split_at_mut(stage);
        let (last, guess) = (&known[stage - 1], &mut rest[0]);
        // The stage before has an implicit rate of its own, but for the first.
        let own = if stage > 1 { 1.0 } else { 0.0 };
        for (i, shift) in self.shift.iter_mut().enumerate() {
            let sum: f64 = known.iter().zip(&factors).map(|(k, f)| f * k[i]).sum();
            // (base of this stage - state of the one before) / (d h)
            let change = sum - *shift - own * last[i];
            *shift = sum;
            self.scratch[i] = self.stepping.y[i] + weight * sum;
            self.correction[i] = change;
            guess[i] = last[i] + change;
        }
        self.matrix.solve(&self.structure, &self.derivative, &self.stepping.y, guess);
        guess.iter_mut().zip(&self.correction).for_each(|(k, change)| *k -= change);
    }

    /// Derivative and factors for the weight `d h`, where those at hand don't serve.
    fn linearise<S: OdeSystem + ?Sized>(&mut self, system: &mut S, weight: f64) -> Result<(), Failure> {
        if !self.is_derivative_valid {
            let at = (self.stepping.t, self.stepping.y.as_slice());
            self.differences.linearise(
                system,
                &self.structure,
                at,
                &mut self.derivative,
                &mut self.stepping.statistics,
            );
            self.is_derivative_valid = true;
            self.is_derivative_fresh = true;
            self.matrix.clear();
        }
        if !self.matrix.is_for(weight) {
            self.stepping.statistics.factorisations += 1;
            if !self.matrix.factorise(&self.structure, &self.derivative, &self.stepping.y, weight) {
                return Err(Failure::Singular);
            }
        }
        Ok(())
    }

    /// Newton's method for the rate `k[stage] = f(t, base + d h k[stage])` (T.10), `base` in `scratch`; leaves the state in `trial`.
    fn solve_stage<S: OdeSystem + ?Sized>(
        &mut self,
        system: &mut S,
        stage: usize,
        t: f64,
        weight: f64,
    ) -> Result<(), Failure> {
        let mut previous = 0.0;
        // Without an iteration of this stage the last one's convergence is the best guess (Hairer & Wanner II, IV.8).
        let mut error_factor = self.newton.error_factor.max(f64::EPSILON).powf(0.8);
        for iteration in 1..=MAX_ITERATIONS {
            self.place(stage, weight);
            if !is_finite(&self.trial) {
                return Err(Failure::NotFinite);
            }
            self.stepping.statistics.evaluations += 1;
            self.stepping.statistics.iterations += 1;
            let correction = &mut self.correction;
            system.rhs(t, &self.trial, correction)?;
            for (c, k) in correction.iter_mut().zip(&self.k[stage]) {
                *c -= k;
            }
            self.matrix.solve(&self.structure, &self.derivative, &self.stepping.y, correction);
            for (c, k) in correction.iter_mut().zip(&mut self.k[stage]) {
                *k += *c;
                *c *= weight;
            }
            let size = system.damped_error_norm(&self.stepping.y, &self.trial, correction);
            if !size.is_finite() {
                return Err(Failure::NotFinite);
            }
            if iteration > 1 {
                let rate = size / previous;
                self.newton.rate = self.newton.rate.max(rate);
                let left = (MAX_ITERATIONS - iteration) as i32;
                let is_hopeless = rate >= 1.0 || size * rate.powi(left) / (1.0 - rate) > NEWTON_TOLERANCE;
                if is_hopeless && size > NEWTON_TOLERANCE {
                    return Err(Failure::Diverged { iterations: iteration, rate });
                }
                error_factor = if rate < 1.0 { rate / (1.0 - rate) } else { 1.0 };
            }
            if error_factor * size <= NEWTON_TOLERANCE {
                self.newton.error_factor = error_factor;
                self.place(stage, weight);
                return if is_finite(&self.trial) { Ok(()) } else { Err(Failure::NotFinite) };
            }
            previous = size;
        }
        Err(Failure::Diverged { iterations: MAX_ITERATIONS, rate: self.newton.rate })
    }

    /// State of a stage from its rate.
    fn place(&mut self, stage: usize, weight: f64) {
        for ((y, base), k) in self.trial.iter_mut().zip(&self.scratch).zip(&self.k[stage]) {
            *y = base + weight * k;
        }
    }

    /// Filtered error estimate (Eq. T.12).
    fn error<S: OdeSystem + ?Sized>(&mut self, system: &mut S, h: f64) -> f64 {
        if self.stepping.settings.is_fixed {
            return 0.0;
        }
        for (i, e) in self.scratch.iter_mut().enumerate() {
            *e = h * self.k.iter().zip(self.method.error).map(|(k, e)| e * k[i]).sum::<f64>();
        }
        self.matrix.solve(&self.structure, &self.derivative, &self.stepping.y, &mut self.scratch);
        system.damped_error_norm(&self.stepping.y, &self.trial, &self.scratch)
    }

    /// Moves on to the state in `trial`.
    fn accept<S: OdeSystem + ?Sized>(&mut self, system: &mut S, attempt: StepAttempt, error: f64) -> Step {
        let last = self.method.n_stages() - 1;
        system.finish_quadratures(&mut self.trial, &mut self.k[last]);
        self.store_dense_output(attempt.h);
        self.k.swap(0, last);
        self.is_derivative_fresh = false;
        self.is_derivative_valid = self.newton.rate <= SLOW_RATE;
        let growth = self.stepping.controller.accepted(error);
        let kept = if (1.0..KEPT_GROWTH).contains(&growth) { 1.0 } else { growth };
        self.stepping.accept(system, attempt, error, kept, &mut self.trial)
    }

    /// Cubic through start, middle and end with the rate at the end (Eq. T.17).
    fn store_dense_output(&mut self, h: f64) {
        let (c, last) = (self.method.middle, self.method.n_stages() - 1);
        let [start, first, second, third] = &mut self.dense;
        for (i, y) in self.stepping.y.iter().enumerate() {
            let difference = self.trial[i] - y;
            let bulge = (self.middle[i] - y - c * difference) / (c * (1.0 - c));
            let tilt = (difference - h * self.k[last][i] - bulge) / (1.0 - c);
            (start[i], first[i], second[i], third[i]) = (*y, difference, bulge - c * tilt, tilt);
        }
    }
}

impl DenseOutput for Esdirk {
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
        let [d0, d1, d2, d3] = &self.dense;
        assert_eq!(out.len(), d0.len(), "the output is as long as the state");
        for (i, o) in out.iter_mut().enumerate() {
            *o = d0[i] + theta * (d1[i] + rest * (d2[i] + theta * d3[i]));
        }
    }
}
