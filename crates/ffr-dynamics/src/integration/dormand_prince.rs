//! Dormand-Prince 5(4) with dense output (docs/theory.md Eq. T.1 to T.5), free vibrations being
//! exact (T.9 to T.12).
//!
//! Explicit, seven stages, the last of which is the first of the next step. It knows nothing of
//! mechanics: size and acceptance of an error are the system's business
//! ([`OdeSystem::error_norm`]).

use super::one_step::OneStepMethod;
use super::oscillator::{Oscillators, Vibration};
use super::step_control::smallest_step;
use super::stepping::{Failure, Step, StepAttempt, Stepping, is_finite};
use super::system::OdeSystem;

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
pub(super) const ORDER: f64 = 5.0;
/// Share of the tolerance aimed at by the first step (same source, II.4).
const FIRST_STEP_ERROR: f64 = 0.01;
/// Share of a step before whose end a given force is the one at its end.
const BEFORE_END: f64 = 1e-9;
/// What helps when the steps become too short.
pub(super) const REMEDY: &str = "loosen the tolerance or soften the stiffest force";

/// Stages, dense output and vibrations of a step.
#[derive(Debug, Clone)]
pub(super) struct DormandPrince {
    /// Rates of the stages; the first is the rate at the start of the step if that is valid.
    k: [Vec<f64>; 7],
    trial: Vec<f64>,
    scratch: Vec<f64>,
    dense: [Vec<f64>; 4],
    vibration: Vibration<7>,
}

impl DormandPrince {
    /// For a system of `dimension` equations.
    pub fn new(dimension: usize) -> Self {
        let zeros = || vec![0.0; dimension];
        Self {
            k: std::array::from_fn(|_| zeros()),
            trial: zeros(),
            scratch: zeros(),
            dense: std::array::from_fn(|_| zeros()),
            vibration: Vibration::new(C),
        }
    }

    /// Makes room for the free vibrations of a system, so that its first step allocates nothing.
    pub fn make_room(&mut self, of: Oscillators<'_>) {
        self.vibration.take_over(of);
    }

    /// Coefficients of the fourth-order interpolant (Eq. T.2).
    fn store_dense_output(&mut self, y: &[f64], h: f64) {
        let [first, second, third, last] = &mut self.dense;
        combine(last, h, &D, &self.k);
        for (i, y) in y.iter().enumerate() {
            let difference = self.trial[i] - y;
            let slope = h * self.k[0][i] - difference;
            first[i] = difference;
            second[i] = slope;
            third[i] = difference - h * self.k[6][i] - slope;
        }
    }
}

impl OneStepMethod for DormandPrince {
    fn rate(&mut self) -> &mut [f64] {
        &mut self.k[0]
    }

    /// First step size (Eq. T.5): the change of the right-hand side over a small Euler step tells
    /// the time scale.
    fn first_step<S: OdeSystem + ?Sized>(
        &mut self,
        stepping: &mut Stepping,
        system: &mut S,
        t_end: f64,
    ) -> f64 {
        let largest = stepping.settings.max_step.min(t_end - stepping.t);
        let size = system.error_norm(&stepping.y, &stepping.y, &stepping.y);
        let rate = system.error_norm(&stepping.y, &stepping.y, &self.k[0]);
        let is_known = size > 1e-5 && rate > 1e-5 && (size / rate).is_finite();
        let mut h = if is_known { 0.01 * size / rate } else { 1e-3 * largest }.min(largest);
        for _ in 0..4 {
            for ((trial, y), k) in self.trial.iter_mut().zip(&stepping.y).zip(&self.k[0]) {
                *trial = y + h * k;
            }
            stepping.statistics.evaluations += 1;
            let outcome = system.rhs(stepping.t + h, &self.trial, &mut self.k[1]);
            system.restore();
            for ((s, k1), k0) in self.scratch.iter_mut().zip(&self.k[1]).zip(&self.k[0]) {
                *s = (k1 - k0) / h;
            }
            let change = system.error_norm(&stepping.y, &stepping.y, &self.scratch);
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

    fn begin<S: OdeSystem + ?Sized>(&mut self, stepping: &mut Stepping, system: &mut S) {
        let is_exact = stepping.settings.is_vibration_exact;
        let oscillators = if is_exact { system.oscillators() } else { Oscillators::default() };
        self.vibration.begin(oscillators, &stepping.y, &self.k[0]);
        self.vibration.begin_supply(|forces| system.supply(stepping.t, &stepping.y, forces));
        if !stepping.settings.is_fixed {
            stepping.h = stepping.h.min(self.vibration.longest_step());
        }
    }

    /// Stages 2 to 7 and the error norm.
    fn attempt<S: OdeSystem + ?Sized>(
        &mut self,
        stepping: &mut Stepping,
        system: &mut S,
        h: f64,
    ) -> Result<f64, Failure> {
        self.vibration.prepare(h);
        for stage in 1..7 {
            let (known, rest) = self.k.split_at_mut(stage);
            combine(&mut self.trial, h, &A[stage][..stage], known);
            for (x, y) in self.trial.iter_mut().zip(&stepping.y) {
                *x += y;
            }
            self.vibration.place(stage, &A[stage][..stage], &mut self.trial);
            if !is_finite(&self.trial) {
                return Err(Failure::NotFinite);
            }
            stepping.statistics.evaluations += 1;
            system.rhs(stepping.t + C[stage] * h, &self.trial, &mut rest[0])?;
            self.vibration.take(stage, &self.trial, &rest[0]);
        }
        combine(&mut self.scratch, h, &E, &self.k);
        self.vibration.place_error(&E, &A[6], &mut self.scratch);
        if !is_finite(&self.k[6]) {
            return Err(Failure::NotFinite); // earlier stages that are not finite show in the state tried
        }
        if stepping.settings.is_fixed {
            return Ok(0.0);
        }
        Ok(system.error_norm(&stepping.y, &self.trial, &self.scratch))
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
        system.finish_quadratures(&mut self.trial, &mut self.k[6]);
        // Steps end where given forces jump.
        let end = attempt.end - (BEFORE_END * attempt.h).max(smallest_step(stepping.t, attempt.end));
        self.vibration.end_supply(|forces| system.supply(end, &self.trial, forces));
        self.store_dense_output(&stepping.y, attempt.h);
        self.vibration.end(&A[6], &D, &mut self.trial);
        self.vibration.end_supplied(&A[6], &D, &mut self.trial);
        self.k.swap(0, 6);
        let growth = stepping.controller.accepted(error);
        stepping.accept(system, attempt, error, growth, &mut self.trial)
    }

    fn interpolate(&self, start: &[f64], theta: f64, out: &mut [f64]) {
        let rest = 1.0 - theta;
        let [d1, d2, d3, d4] = &self.dense;
        for (i, o) in out.iter_mut().enumerate() {
            *o = start[i] + theta * (d1[i] + rest * (d2[i] + theta * (d3[i] + rest * d4[i])));
        }
        self.vibration.interpolate(theta, out);
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
