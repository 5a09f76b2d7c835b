//! TR-BDF2: a step of the trapezoidal rule and one of the second backward difference formula (docs/theory.md Eq. T.9 to T.16).
//!
//! L-stable, order two, with a third-order error estimate filtered by the iteration matrix (Bank et al. 1985; Hosea & Shampine
//! 1996; the method behind *ode23tb*). Modes whose period is far below the step are not resolved but damped out; what they
//! lose shows as a loss of the system's energy. It knows nothing of mechanics: size and acceptance of an error are the
//! system's business ([`OdeSystem::damped_error_norm`]).

use super::dense_output::DenseOutput;
use super::dormand_prince::Step;
use super::jacobian::{Differences, Linearisation, Structure};
use super::newton::IterationMatrix;
use super::step_control::{Controller, Statistics, StepSettings, smallest_step};
use super::system::OdeSystem;
use crate::error::{DynamicsError, Rejection};

/// End of the trapezoidal part, with which both parts have the same iteration matrix (Bank et al. 1985).
const GAMMA: f64 = 2.0 - std::f64::consts::SQRT_2;
/// Weight of the implicit rate in both stages (Hosea & Shampine 1996).
const D: f64 = 0.5 * GAMMA;
/// Weight of the two earlier rates in the last stage (same source).
const W: f64 = 0.25 * std::f64::consts::SQRT_2;
/// Second-order minus third-order weights (same source).
const E: [f64; 3] = [(4.0 * W - 1.0) / 3.0, -1.0 / 3.0, 2.0 * D / 3.0];
/// Power of the step with which the error estimate grows.
const ORDER: f64 = 3.0;
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

/// State, workspace and statistics of a TR-BDF2 integration.
#[derive(Debug)]
pub struct TrBdf2 {
    settings: StepSettings,
    controller: Controller,
    statistics: Statistics,
    t: f64,
    y: Vec<f64>,
    /// Proposed next step; 0 where none is known yet.
    h: f64,
    /// Whether `k[0]` is the rate at `(t, y)`.
    is_first_stage_valid: bool,
    /// Whether the derivative may be used in the next step.
    is_derivative_valid: bool,
    /// Whether the derivative was formed at `(t, y)`.
    is_derivative_fresh: bool,
    structure: Structure,
    derivative: Linearisation,
    differences: Differences,
    matrix: IterationMatrix,
    newton: Newton,
    /// Rates at the start and at the ends of the two parts.
    k: [Vec<f64>; 3],
    /// State after the trapezoidal part.
    middle: Vec<f64>,
    trial: Vec<f64>,
    scratch: Vec<f64>,
    correction: Vec<f64>,
    interval: (f64, f64),
    dense: [Vec<f64>; 4],
    last_refusal: Option<Rejection>,
}

/// What Newton's method has learned from its last iterations.
#[derive(Debug, Clone, Copy)]
struct Newton {
    /// Factor from the last correction to the error left.
    outlook: f64,
    /// Slowest convergence rate in the present step.
    rate: f64,
}

/// Why a step could not be finished.
enum Failure {
    Refused(Rejection),
    Diverged { iterations: u32, rate: f64 },
    Singular,
    NotFinite,
}

impl From<Rejection> for Failure {
    fn from(refusal: Rejection) -> Self {
        Self::Refused(refusal)
    }
}

impl TrBdf2 {
    /// An integrator of `system` at time `t` in the state `y`.
    ///
    /// It keeps the system's [`OdeSystem::kinematics`]; all steps must be taken with that system.
    ///
    /// # Errors
    /// [`DynamicsError::Inconsistent`] if a step of the settings is not positive or the kinematics do not fit the state.
    ///
    /// # Panics
    /// If the length of `y` differs from the system's dimension.
    pub fn new<S: OdeSystem + ?Sized>(
        settings: StepSettings,
        t: f64,
        y: &[f64],
        system: &S,
    ) -> Result<Self, DynamicsError> {
        assert_eq!(system.dimension(), y.len(), "the state has the system's number of equations");
        settings.check()?;
        let structure = Structure::of(system)?;
        let zeros = || vec![0.0; y.len()];
        Ok(Self {
            settings,
            controller: Controller::new(ORDER),
            statistics: Statistics::default(),
            t,
            y: y.to_vec(),
            h: 0.0,
            is_first_stage_valid: false,
            is_derivative_valid: false,
            is_derivative_fresh: false,
            derivative: Linearisation::new(structure.unknowns.len()),
            differences: Differences::new(y.len()),
            matrix: IterationMatrix::new(&structure),
            newton: Newton { outlook: 1.0, rate: 0.0 },
            structure,
            k: std::array::from_fn(|_| zeros()),
            middle: zeros(),
            trial: zeros(),
            scratch: zeros(),
            correction: zeros(),
            interval: (t, t),
            dense: std::array::from_fn(|_| zeros()),
            last_refusal: None,
        })
    }

    /// Time reached \[s\].
    pub fn time(&self) -> f64 {
        self.t
    }

    /// State reached.
    pub fn state(&self) -> &[f64] {
        &self.y
    }

    /// State before the last accepted step (at the start of [`DenseOutput::interval`]).
    pub fn previous_state(&self) -> &[f64] {
        &self.dense[0]
    }

    /// Work done since the integrator was made; restarts do not reset it.
    pub fn statistics(&self) -> Statistics {
        self.statistics
    }

    /// Last refusal of the right-hand side with its code, in whatever step; `None` if there never was one.
    pub fn last_refusal(&self) -> Option<&Rejection> {
        self.last_refusal.as_ref()
    }

    /// Step proposed next, 0 if none is known yet \[s\].
    pub fn proposed_step(&self) -> f64 {
        self.h
    }

    /// Changes the largest step \[s\].
    ///
    /// # Errors
    /// [`DynamicsError::Inconsistent`] if it is not positive.
    pub fn set_max_step(&mut self, max_step: f64) -> Result<(), DynamicsError> {
        let settings = StepSettings { max_step, ..self.settings };
        settings.check()?;
        self.settings = settings;
        Ok(())
    }

    /// Says that the right-hand side has changed at the present time (a force switched on, another penalty).
    pub fn invalidate(&mut self) {
        self.is_first_stage_valid = false;
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
        assert_eq!(y.len(), self.y.len(), "a restart keeps the number of equations");
        self.t = t;
        self.y.copy_from_slice(y);
        self.interval = (t, t);
        self.invalidate();
        self.controller = Controller::new(ORDER);
    }

    /// Takes one step that ends at `t_end` at the latest, and exactly there if it comes near.
    ///
    /// [`OdeSystem::save`] is called before the first try, [`OdeSystem::restore`] after each failed one and after differences
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
        assert_eq!(
            system.dimension(),
            self.y.len(),
            "system and integrator have the same number of equations"
        );
        if self.t >= t_end {
            return Ok(Step { start: self.t, end: self.t, error: 0.0, rejected: 0 });
        }
        if !t_end.is_finite() {
            return Err(self.failure(format!("the end time is {t_end} s, must be finite")));
        }
        system.save();
        self.prepare(system, t_end)?;
        let mut rejected = 0;
        loop {
            let (h, is_last) = self.settings.next_step(self.t, self.h, t_end);
            let tried = self.attempt(system, h);
            let outcome = match tried {
                Ok(error) if error <= 1.0 => {
                    let end = if is_last { t_end } else { self.t + h };
                    return Ok(self.accept(system, end, h, error, rejected));
                }
                other => other,
            };
            system.restore();
            if matches!(outcome, Err(Failure::Diverged { .. } | Failure::Singular))
                && !self.is_derivative_fresh
            {
                self.is_derivative_valid = false; // the same step again with a derivative of its own
                continue;
            }
            rejected += 1;
            self.statistics.rejected += 1;
            let shrunk = h * self.controller.rejected(outcome.as_ref().ok().copied());
            if self.settings.is_fixed || shrunk < smallest_step(self.t, t_end) {
                return Err(self.underflow(shrunk, outcome));
            }
            self.note(outcome);
            self.h = shrunk;
        }
    }

    /// Steps until `t_end`, calling `observe` after each accepted step; returns the time reached.
    ///
    /// `observe` answers whether to go on.
    ///
    /// # Errors
    /// As [`TrBdf2::step`].
    pub fn run<S: OdeSystem + ?Sized>(
        &mut self,
        system: &mut S,
        t_end: f64,
        mut observe: impl FnMut(&mut S, &Self) -> bool,
    ) -> Result<f64, DynamicsError> {
        while self.t < t_end {
            self.step(system, t_end)?;
            if !observe(system, self) {
                break;
            }
        }
        Ok(self.t)
    }

    /// First rate and first step size, where they are not known.
    fn prepare<S: OdeSystem + ?Sized>(&mut self, system: &mut S, t_end: f64) -> Result<(), DynamicsError> {
        if !self.is_first_stage_valid {
            if let Some(i) = self.y.iter().position(|v| !v.is_finite()) {
                return Err(self.failure(format!("component {i} of the starting state is not finite")));
            }
            self.statistics.evaluations += 1;
            if let Err(refusal) = system.rhs(self.t, &self.y, &mut self.k[0]) {
                let reason = format!("no forces at the starting state: {}", refusal.reason);
                self.statistics.refused += 1;
                self.last_refusal = Some(refusal);
                return Err(self.failure(reason));
            }
            if let Some(i) = self.k[0].iter().position(|v| !v.is_finite()) {
                return Err(self.failure(format!("rate {i} of the starting state is not finite")));
            }
            self.is_first_stage_valid = true;
        }
        if self.h <= 0.0 {
            self.h = match self.settings.initial_step {
                Some(h) => h,
                None => self.first_step(system, t_end),
            };
        }
        Ok(())
    }

    /// First step size (Eq. T.16): a small share of the time in which the state changes by its own size; too large, it is rejected.
    fn first_step<S: OdeSystem + ?Sized>(&self, system: &S, t_end: f64) -> f64 {
        let largest = self.settings.max_step.min(t_end - self.t);
        let size = system.damped_error_norm(&self.y, &self.y, &self.y);
        let rate = system.damped_error_norm(&self.y, &self.y, &self.k[0]);
        let is_known = size > 1e-5 && rate > 1e-5 && (size / rate).is_finite();
        let wanted = if is_known { FIRST_STEP * size / rate } else { 1e-3 * largest };
        wanted.min(largest)
    }

    /// Both parts of a step of size `h`; leaves the new state in `trial` and returns its error (Eq. T.9 to T.12).
    fn attempt<S: OdeSystem + ?Sized>(&mut self, system: &mut S, h: f64) -> Result<f64, Failure> {
        self.linearise(system, D * h)?;
        self.newton.rate = 0.0;
        let weight = D * h;
        // First guesses (T.11) are those of the linearised system: unresolved modes never leave their size.
        let [k0, k1, _] = &mut self.k;
        k1.copy_from_slice(k0);
        self.matrix.solve(&self.structure, &self.derivative, &self.y, k1);
        for ((k1, k0), (base, y)) in k1.iter_mut().zip(&*k0).zip(self.scratch.iter_mut().zip(&self.y)) {
            *k1 = 2.0 * *k1 - k0;
            *base = y + weight * k0;
        }
        self.solve_stage(system, 1, self.t + GAMMA * h, weight)?;
        std::mem::swap(&mut self.middle, &mut self.trial);

        let [k0, k1, k2] = &mut self.k;
        for ((k2, k1), k0) in k2.iter_mut().zip(&*k1).zip(&*k0) {
            *k2 = k1 - (D - W) / D * (k0 + k1);
        }
        self.matrix.solve(&self.structure, &self.derivative, &self.y, k2);
        for (i, base) in self.scratch.iter_mut().enumerate() {
            k2[i] += (D - W) / D * (k0[i] + k1[i]);
            *base = self.y[i] + h * W * (k0[i] + k1[i]);
        }
        self.solve_stage(system, 2, self.t + h, weight)?;
        let error = self.error(system, h);
        if error <= 1.0 && system.has_memory() {
            self.statistics.evaluations += 1;
            system.rhs(self.t + h, &self.trial, &mut self.scratch)?;
        }
        Ok(error)
    }

    /// Derivative and factors for the weight `d h`, where those at hand don't serve.
    fn linearise<S: OdeSystem + ?Sized>(&mut self, system: &mut S, weight: f64) -> Result<(), Failure> {
        if !self.is_derivative_valid {
            let at = (self.t, self.y.as_slice());
            self.differences.linearise(
                system,
                &self.structure,
                at,
                &mut self.derivative,
                &mut self.statistics,
            );
            self.is_derivative_valid = true;
            self.is_derivative_fresh = true;
            self.matrix.clear();
        }
        if !self.matrix.is_for(weight) {
            self.statistics.factorisations += 1;
            if !self.matrix.factorise(&self.structure, &self.derivative, &self.y, weight) {
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
        let mut outlook = self.newton.outlook.max(f64::EPSILON).powf(0.8);
        for iteration in 1..=MAX_ITERATIONS {
            self.place(stage, weight);
            if !is_finite(&self.trial) {
                return Err(Failure::NotFinite);
            }
            self.statistics.evaluations += 1;
            self.statistics.iterations += 1;
            let correction = &mut self.correction;
            system.rhs(t, &self.trial, correction)?;
            for (c, k) in correction.iter_mut().zip(&self.k[stage]) {
                *c -= k;
            }
            self.matrix.solve(&self.structure, &self.derivative, &self.y, correction);
            for (c, k) in correction.iter_mut().zip(&mut self.k[stage]) {
                *k += *c;
                *c *= weight;
            }
            let size = system.damped_error_norm(&self.y, &self.trial, correction);
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
                outlook = if rate < 1.0 { rate / (1.0 - rate) } else { 1.0 };
            }
            if outlook * size <= NEWTON_TOLERANCE {
                self.newton.outlook = outlook;
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
    fn error<S: OdeSystem + ?Sized>(&mut self, system: &S, h: f64) -> f64 {
        if self.settings.is_fixed {
            return 0.0;
        }
        let [k0, k1, k2] = &self.k;
        for (i, e) in self.scratch.iter_mut().enumerate() {
            *e = h * (E[0] * k0[i] + E[1] * k1[i] + E[2] * k2[i]);
        }
        self.matrix.solve(&self.structure, &self.derivative, &self.y, &mut self.scratch);
        system.damped_error_norm(&self.y, &self.trial, &self.scratch)
    }

    /// Moves on to the state in `trial`.
    fn accept<S: OdeSystem + ?Sized>(
        &mut self,
        system: &mut S,
        end: f64,
        h: f64,
        error: f64,
        rejected: u32,
    ) -> Step {
        self.store_dense_output(h);
        let start = self.t;
        self.t = end;
        self.interval = (start, end);
        std::mem::swap(&mut self.y, &mut self.trial);
        self.k.swap(0, 2);
        self.is_first_stage_valid = !system.project(self.t, &mut self.y);
        self.statistics.steps += 1;
        self.is_derivative_fresh = false;
        self.is_derivative_valid = self.newton.rate <= SLOW_RATE;
        let growth = self.controller.accepted(error);
        let proposed = if (1.0..KEPT_GROWTH).contains(&growth) { h } else { h * growth };
        // A step cut short by the caller's end time says nothing against the longer one proposed before.
        let is_cut_short = rejected == 0 && proposed >= h;
        self.h = if is_cut_short { proposed.max(self.h) } else { proposed };
        if self.settings.is_fixed {
            self.h = self.settings.max_step;
        }
        Step { start, end, error, rejected }
    }

    /// Cubic through start, middle and end with the rate at the end (Eq. T.17).
    fn store_dense_output(&mut self, h: f64) {
        for i in 0..self.y.len() {
            let difference = self.trial[i] - self.y[i];
            let bulge = (self.middle[i] - self.y[i] - GAMMA * difference) / (GAMMA * (1.0 - GAMMA));
            let tilt = (difference - h * self.k[2][i] - bulge) / (1.0 - GAMMA);
            self.dense[0][i] = self.y[i];
            self.dense[1][i] = difference;
            self.dense[2][i] = bulge - GAMMA * tilt;
            self.dense[3][i] = tilt;
        }
    }

    /// Books a failed try.
    fn note(&mut self, outcome: Result<f64, Failure>) {
        if let Err(Failure::Refused(refusal)) = outcome {
            self.statistics.refused += 1;
            self.last_refusal = Some(refusal);
        }
    }

    fn failure(&self, reason: String) -> DynamicsError {
        DynamicsError::Integration { time: self.t, reason }
    }

    fn underflow(&mut self, h: f64, outcome: Result<f64, Failure>) -> DynamicsError {
        let reason = match &outcome {
            Err(Failure::Refused(refusal)) => refusal.reason.clone(),
            Err(Failure::Diverged { iterations, rate }) => {
                format!(
                    "Newton's method gave up after {iterations} iterations with convergence rate {rate:.3}"
                )
            }
            Err(Failure::Singular) => "the iteration matrix is singular or not finite".to_string(),
            Ok(error) if error.is_finite() => format!("error norm {error:.3e}, limit 1"),
            Ok(_) | Err(Failure::NotFinite) => "the solution is not finite".to_string(),
        };
        self.note(outcome);
        let remedy = if self.settings.is_fixed {
            "take a smaller fixed step"
        } else {
            "look for a force that jumps, or take the explicit method"
        };
        self.failure(format!("step fell to {h:.3e} s, last rejection: {reason}; {remedy}"))
    }
}

fn is_finite(x: &[f64]) -> bool {
    x.iter().all(|v| v.is_finite())
}

impl DenseOutput for TrBdf2 {
    fn interval(&self) -> (f64, f64) {
        self.interval
    }

    fn dimension(&self) -> usize {
        self.y.len()
    }

    fn interpolate(&self, t: f64, out: &mut [f64]) {
        let (start, end) = self.interval;
        if end <= start {
            out.copy_from_slice(&self.y);
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
