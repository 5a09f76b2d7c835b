//! Implicit Runge-Kutta methods with an explicit first stage and one iteration matrix: TR-BDF2, and
//! one of order four (docs/theory.md Eq. T.13 to T.23).
//!
//! L-stable, with an error estimate filtered by the iteration matrix. Modes whose period is far
//! below the step are not resolved but damped out; what they lose shows as a loss of the system's
//! energy. It knows nothing of mechanics: size and acceptance of an error are the system's business
//! ([`OdeSystem::damped_error_norm`]).

use super::convergence::Convergence;
use super::held_derivative::HeldDerivative;
use super::newton::IterationMatrix;
use super::tableau::{MAX_STAGES, Tableau};
use crate::error::DynamicsError;
use crate::integration::one_step::OneStepMethod;
use crate::integration::step_control::worthwhile_growth;
use crate::integration::stepping::{Failure, Step, StepAttempt, Stepping, is_finite};
use crate::integration::system::OdeSystem;

/// What helps when the steps become too short.
pub(in crate::integration) const REMEDY: &str = "look for a force that jumps, or take the explicit method";

/// Stages, factors and dense output of a step.
#[derive(Debug)]
pub(in crate::integration) struct Esdirk {
    method: &'static Tableau,
    held: HeldDerivative,
    matrix: IterationMatrix,
    convergence: Convergence,
    /// Rates of the stages; the first is the rate at the start of the step if that is valid.
    k: Vec<Vec<f64>>,
    /// Weighted sum of the rates before a stage, over the weight of its own: `(base - y) / (d h)`.
    shift: Vec<f64>,
    /// State in the middle that the continuous extension passes through.
    middle: Vec<f64>,
    trial: Vec<f64>,
    scratch: Vec<f64>,
    correction: Vec<f64>,
    dense: [Vec<f64>; 3],
}

impl Esdirk {
    /// The method of `method` for `system`, whose [`OdeSystem::kinematics`] it keeps.
    ///
    /// # Errors
    /// [`DynamicsError::Data`] if the kinematics do not fit the state.
    pub fn new<S: OdeSystem + ?Sized>(method: &'static Tableau, system: &S) -> Result<Self, DynamicsError> {
        let held = HeldDerivative::new(system)?;
        let dimension = system.dimension();
        let zeros = || vec![0.0; dimension];
        Ok(Self {
            method,
            matrix: IterationMatrix::new(&held.structure),
            convergence: Convergence::new(),
            held,
            k: (0..method.n_stages()).map(|_| zeros()).collect(),
            shift: zeros(),
            middle: zeros(),
            trial: zeros(),
            scratch: zeros(),
            correction: zeros(),
            dense: std::array::from_fn(|_| zeros()),
        })
    }

    /// The known part of a stage's state, in `scratch`, and a first guess of its rate (T.18): that
    /// of the system linearised about the stage before, by which unresolved modes never leave their
    /// size.
    fn begin_stage(&mut self, y: &[f64], stage: usize, weight: f64) {
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
            self.scratch[i] = y[i] + weight * sum;
            self.correction[i] = change;
            guess[i] = last[i] + change;
        }
        self.matrix.solve(&self.held.structure, &self.held.derivative, y, guess);
        guess.iter_mut().zip(&self.correction).for_each(|(k, change)| *k -= change);
    }

    /// Derivative and factors for the weight `d h`, where those at hand don't serve.
    fn linearise<S: OdeSystem + ?Sized>(
        &mut self,
        stepping: &mut Stepping,
        system: &mut S,
        weight: f64,
    ) -> Result<(), Failure> {
        if self.held.renew(stepping, system) {
            self.matrix.clear();
        }
        if !self.matrix.is_for(weight) {
            stepping.statistics.factorisations += 1;
            if !self.matrix.factorise(&self.held.structure, &self.held.derivative, &stepping.y, weight) {
                return Err(Failure::Singular);
            }
        }
        Ok(())
    }

    /// Newton's method for the rate `k[stage] = f(t, base + d h k[stage])` (T.14), `base` in
    /// `scratch`; leaves the state in `trial`.
    fn solve_stage<S: OdeSystem + ?Sized>(
        &mut self,
        stepping: &mut Stepping,
        system: &mut S,
        stage: usize,
        (t, weight): (f64, f64),
    ) -> Result<(), Failure> {
        let mut iterations = self.convergence.begin();
        loop {
            self.place(stage, weight);
            if !is_finite(&self.trial) {
                return Err(Failure::NotFinite);
            }
            stepping.statistics.evaluations += 1;
            stepping.statistics.iterations += 1;
            let correction = &mut self.correction;
            system.rhs(t, &self.trial, correction)?;
            for (c, k) in correction.iter_mut().zip(&self.k[stage]) {
                *c -= k;
            }
            self.matrix.solve(&self.held.structure, &self.held.derivative, &stepping.y, correction);
            for (c, k) in correction.iter_mut().zip(&mut self.k[stage]) {
                *k += *c;
                *c *= weight;
            }
            let size = system.damped_error_norm(&stepping.y, &self.trial, correction);
            if self.convergence.is_reached(&mut iterations, size)? {
                self.place(stage, weight);
                return if is_finite(&self.trial) { Ok(()) } else { Err(Failure::NotFinite) };
            }
        }
    }

    /// State of a stage from its rate.
    fn place(&mut self, stage: usize, weight: f64) {
        for ((y, base), k) in self.trial.iter_mut().zip(&self.scratch).zip(&self.k[stage]) {
            *y = base + weight * k;
        }
    }

    /// Filtered error estimate (Eq. T.16).
    fn error<S: OdeSystem + ?Sized>(&mut self, stepping: &Stepping, system: &mut S, h: f64) -> f64 {
        if stepping.settings.is_fixed {
            return 0.0;
        }
        for (i, e) in self.scratch.iter_mut().enumerate() {
            *e = h * self.k.iter().zip(self.method.error).map(|(k, e)| e * k[i]).sum::<f64>();
        }
        self.matrix.solve(&self.held.structure, &self.held.derivative, &stepping.y, &mut self.scratch);
        system.damped_error_norm(&stepping.y, &self.trial, &self.scratch)
    }

    /// Cubic through start, middle and end with the rate at the end (Eq. T.17).
    fn store_dense_output(&mut self, y: &[f64], h: f64) {
        let (c, last) = (self.method.middle, self.method.n_stages() - 1);
        let [first, second, third] = &mut self.dense;
        for (i, y) in y.iter().enumerate() {
            let difference = self.trial[i] - y;
            let bulge = (self.middle[i] - y - c * difference) / (c * (1.0 - c));
            let tilt = (difference - h * self.k[last][i] - bulge) / (1.0 - c);
            (first[i], second[i], third[i]) = (difference, bulge - c * tilt, tilt);
        }
    }
}

impl OneStepMethod for Esdirk {
    fn rate(&mut self) -> &mut [f64] {
        &mut self.k[0]
    }

    fn first_step<S: OdeSystem + ?Sized>(
        &mut self,
        stepping: &mut Stepping,
        system: &mut S,
        t_end: f64,
    ) -> f64 {
        stepping.first_implicit_step(system, &self.k[0], t_end)
    }

    /// All stages of a step of size `h`; leaves the new state in `trial` and returns its error
    /// (Eq. T.13 to T.16).
    fn attempt<S: OdeSystem + ?Sized>(
        &mut self,
        stepping: &mut Stepping,
        system: &mut S,
        h: f64,
    ) -> Result<f64, Failure> {
        let method = self.method;
        let weight = method.diagonal * h;
        self.linearise(stepping, system, weight)?;
        self.convergence.begin_step();
        self.shift.fill(0.0);
        for stage in 1..method.n_stages() {
            self.begin_stage(&stepping.y, stage, weight);
            self.solve_stage(stepping, system, stage, (stepping.t + method.nodes[stage] * h, weight))?;
            if let Some(share) = method.middle_weights.get(stage - 1) {
                for (middle, y) in self.middle.iter_mut().zip(&self.trial) {
                    *middle = if stage == 1 { share * y } else { *middle + share * y };
                }
            }
        }
        let error = self.error(stepping, system, h);
        if error <= 1.0 && system.has_memory() {
            stepping.statistics.evaluations += 1;
            system.rhs(stepping.t + h, &self.trial, &mut self.scratch)?;
        }
        Ok(error)
    }

    fn trial(&self) -> &[f64] {
        &self.trial
    }

    fn accept<S: OdeSystem + ?Sized>(
        &mut self,
        stepping: &mut Stepping,
        system: &mut S,
        attempt: StepAttempt,
        error: f64,
    ) -> Step {
        let last = self.method.n_stages() - 1;
        system.finish_quadratures(&mut self.trial, &mut self.k[last]);
        self.store_dense_output(&stepping.y, attempt.h);
        self.k.swap(0, last);
        self.held.end_step(self.convergence.keeps_derivative());
        let growth = worthwhile_growth(stepping.controller.accepted(error));
        stepping.accept(system, attempt, error, growth, &mut self.trial)
    }

    fn renews_for(&mut self, failure: &Failure) -> bool {
        self.held.renews_for(failure)
    }

    fn invalidate(&mut self) {
        self.held.invalidate();
    }

    fn interpolate(&self, start: &[f64], theta: f64, out: &mut [f64]) {
        let rest = 1.0 - theta;
        let [d1, d2, d3] = &self.dense;
        for (i, o) in out.iter_mut().enumerate() {
            *o = start[i] + theta * (d1[i] + rest * (d2[i] + theta * d3[i]));
        }
    }
}
