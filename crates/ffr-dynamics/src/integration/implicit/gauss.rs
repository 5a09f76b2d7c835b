//! Gauss collocation with four stages (docs/theory.md Eq. T.26 to T.31).
//!
//! Implicit, symmetric, of order eight: the energy of linear vibration is kept whatever the step,
//! also of modes whose period is far below it; only their phase is lost. The stages are found
//! together by simplified Newton iterations for their rates, which two complex factorisations of
//! the size of the velocities serve. It knows nothing of mechanics: size and acceptance of an error
//! are the system's business ([`OdeSystem::damped_error_norm`]).

use faer::c64;
use nalgebra::{Quaternion, Vector3};

use super::collocation::{Collocation, ERROR_CONSTANT, PAIRS, Pair, STAGES, STIFF_LIMIT};
use super::convergence::Convergence;
use super::held_derivative::HeldDerivative;
use super::stage_matrix::StageMatrix;
use crate::error::DynamicsError;
use crate::integration::linearisation::KinematicBlock;
use crate::integration::one_step::OneStepMethod;
use crate::integration::step_control::worthwhile_growth;
use crate::integration::stepping::{Failure, Step, StepAttempt, Stepping, is_finite};
use crate::integration::system::OdeSystem;
use crate::rotation::quaternion_rate;

/// Power of the step with which the error estimate grows.
pub(in crate::integration) const ORDER: f64 = 9.0;
/// What helps when the steps become too short.
pub(in crate::integration) const REMEDY: &str = "look for a force that jumps, or take the explicit method";
/// A step that has to shrink does so by this factor at least: one further factorisation in place of
/// several.
const LEAST_SHRINKAGE: f64 = 0.85;

/// Stages, factors and dense output of a step.
#[derive(Debug)]
pub(in crate::integration) struct Gauss {
    collocation: Collocation,
    /// Components whose rates depend on the velocities in a way that the iterations need not know:
    /// quaternions, quadratures.
    following: Vec<usize>,
    /// Whether the system solves the linear systems itself, about the start of the step, and
    /// whether it is to be asked to.
    is_solved_by_system: bool,
    asks_system: bool,
    /// The factorised matrices that are used where the system has no solver of its own.
    held: HeldDerivative,
    matrices: [StageMatrix; PAIRS],
    /// Step that the factors belong to; 0 without factors \[s\].
    factorised_step: f64,
    convergence: Convergence,
    /// Rate at the start of the step if that is valid.
    rate: Vec<f64>,
    end_rate: Vec<f64>,
    /// Rates of the stages.
    k: [Vec<f64>; STAGES],
    /// Residuals of the unknowns of the stages, then their corrections.
    residuals: [Vec<f64>; STAGES],
    corrections: [Vec<f64>; STAGES],
    solution: Vec<c64>,
    /// A motion of all unknowns, and the derivative of all rates along it.
    motion: Vec<f64>,
    along: Vec<f64>,
    trial: Vec<f64>,
    scratch: Vec<f64>,
    /// Rate of the collocation polynomial at the start of the step, less the rate there.
    defect: Vec<f64>,
    error: Vec<f64>,
    /// Size of the last step, its rates and its defect, of which modes that are not resolved have
    /// no part.
    last_step: f64,
    last_k: [Vec<f64>; STAGES],
    last_defect: Vec<f64>,
}

impl Gauss {
    /// For `system`, whose [`OdeSystem::kinematics`] it keeps.
    ///
    /// # Errors
    /// [`DynamicsError::Data`] if the kinematics do not fit the state.
    pub fn new<S: OdeSystem + ?Sized>(system: &S) -> Result<Self, DynamicsError> {
        let held = HeldDerivative::new(system)?;
        let structure = &held.structure;
        let (dimension, n) = (system.dimension(), structure.unknowns.len());
        let mut is_solved = vec![false; dimension];
        structure.unknowns.iter().for_each(|i| is_solved[*i] = true);
        for block in &structure.blocks {
            if let KinematicBlock::Vector { position, len, .. } = *block {
                is_solved[position..position + len].fill(true);
            }
        }
        let zeros = |n: usize| vec![0.0; n];
        let stages = |n: usize| std::array::from_fn(|_| zeros(n));
        let collocation = Collocation::new();
        Ok(Self {
            following: (0..dimension).filter(|i| !is_solved[*i]).collect(),
            is_solved_by_system: false,
            asks_system: true,
            held,
            matrices: std::array::from_fn(|m| StageMatrix::new(n, collocation.pairs[m].value)),
            factorised_step: 0.0,
            convergence: Convergence::new(),
            rate: zeros(dimension),
            end_rate: zeros(dimension),
            k: stages(dimension),
            residuals: stages(n),
            corrections: stages(n),
            solution: vec![c64::new(0.0, 0.0); n],
            motion: zeros(n),
            along: zeros(n),
            trial: zeros(dimension),
            scratch: zeros(dimension),
            defect: zeros(dimension),
            error: zeros(dimension),
            last_step: 0.0,
            last_k: stages(dimension),
            last_defect: zeros(dimension),
            collocation,
        })
    }

    /// Factors for steps of size `h` about the start of the step, where those at hand don't serve.
    fn factorise<S: OdeSystem + ?Sized>(
        &mut self,
        stepping: &mut Stepping,
        system: &mut S,
        h: f64,
    ) -> Result<(), Failure> {
        if self.is_solved_by_system {
            stepping.statistics.factorisations += 1;
            let mut pairs = self.collocation.pairs.iter().enumerate();
            self.is_solved_by_system = pairs.all(|(m, pair)| system.factorise_held(m, pair.value * h));
        }
        if self.is_solved_by_system {
            return Ok(());
        }
        if self.held.renew(stepping, system) {
            self.factorised_step = 0.0;
        }
        // A clock's round-off changes `h` in its last digits; the factors may differ by that much
        // and more.
        let is_factorised = (self.factorised_step - h).abs() <= 1e-9 * h;
        if !is_factorised {
            stepping.statistics.factorisations += 1;
            self.factorised_step = 0.0;
            for matrix in &mut self.matrices {
                if !matrix.factorise(&self.held.derivative, h) {
                    return Err(Failure::Singular);
                }
            }
            self.factorised_step = h;
        }
        Ok(())
    }

    /// Replaces `solution` by the solution of the system of pair `m` with `scale A_s motion` added
    /// to it (Eq. T.28).
    fn solve_pair<S: OdeSystem + ?Sized>(&mut self, system: &mut S, m: usize, scale: c64) {
        if self.is_solved_by_system {
            system.solve_held(m, &mut self.solution, scale, &self.motion);
            return;
        }
        for (x, along) in self.solution.iter_mut().zip(&self.along) {
            *x += scale * *along;
        }
        self.matrices[m].solve(&mut self.solution);
    }

    /// Sets `along` to `A_s motion`, which the system adds by itself where it holds its derivative.
    fn find_change_along(&mut self) {
        if self.is_solved_by_system {
            return;
        }
        self.along.fill(0.0);
        for (j, speed) in self.motion.iter().enumerate().filter(|(_, speed)| speed.abs() > 0.0) {
            let column = self.held.derivative.position_column(j);
            self.along.iter_mut().zip(column).for_each(|(a, d)| *a += speed * d);
        }
    }

    /// First guess of the rates: those of the system linearised about the start of the step
    /// (Eq. T.29).
    fn guess<S: OdeSystem + ?Sized>(&mut self, system: &mut S, y: &[f64], h: f64) {
        for (v, i) in self.motion.iter_mut().zip(&self.held.structure.unknowns) {
            *v = y[*i];
        }
        self.find_change_along();
        self.corrections.iter_mut().for_each(|c| c.fill(0.0));
        for m in 0..PAIRS {
            let pair = self.collocation.pairs[m];
            let ones: c64 = pair.left.iter().sum();
            let times: c64 = pair.left.iter().zip(self.collocation.nodes).map(|(l, c)| l * (c * h)).sum();
            for (x, i) in self.solution.iter_mut().zip(&self.held.structure.unknowns) {
                *x = ones * self.rate[*i];
            }
            self.solve_pair(system, m, times);
            add_pair(&pair, &self.solution, &mut self.corrections);
        }
        for (k, correction) in self.k.iter_mut().zip(&self.corrections) {
            k.copy_from_slice(&self.rate);
            self.held.structure.unknowns.iter().zip(correction).for_each(|(i, c)| k[*i] = *c);
        }
        self.move_vectors(y, h);
        for stage in 0..STAGES {
            self.place(y, h, stage);
            for block in &self.held.structure.blocks {
                if let KinematicBlock::Rotation { quaternion, velocity } = *block {
                    let range = quaternion..quaternion + 4;
                    let omega = Vector3::from_column_slice(&self.trial[velocity..velocity + 3]);
                    quaternion_rate(&self.trial[range.clone()], &omega, &mut self.k[stage][range]);
                }
            }
        }
    }

    /// Rates of the positions from those of the velocities.
    fn move_vectors(&mut self, y: &[f64], h: f64) {
        for block in &self.held.structure.blocks {
            let KinematicBlock::Vector { position, velocity, len } = *block else { continue };
            for i in 0..len {
                let rates: [f64; STAGES] = std::array::from_fn(|j| self.k[j][velocity + i]);
                for (k, weights) in self.k.iter_mut().zip(&self.collocation.stages) {
                    k[position + i] = y[velocity + i] + h * sum(weights, &rates);
                }
            }
        }
    }

    /// Sets `trial` to the state of stage `stage`.
    fn place(&mut self, y: &[f64], h: f64, stage: usize) {
        combine(y, h, &self.collocation.stages[stage], &self.k, &mut self.trial);
    }

    /// The stages by simplified Newton iterations for their rates; leaves the state at the end in
    /// `trial` (Eq. T.27, T.28).
    fn solve<S: OdeSystem + ?Sized>(
        &mut self,
        stepping: &mut Stepping,
        system: &mut S,
        h: f64,
    ) -> Result<(), Failure> {
        self.convergence.begin_step();
        let mut iterations = self.convergence.begin();
        loop {
            stepping.statistics.iterations += 1;
            for stage in 0..STAGES {
                self.place(&stepping.y, h, stage);
                if !is_finite(&self.trial) {
                    return Err(Failure::NotFinite);
                }
                stepping.statistics.evaluations += 1;
                let t = stepping.t + self.collocation.nodes[stage] * h;
                system.rhs(t, &self.trial, &mut self.scratch)?;
                let k = &mut self.k[stage];
                for (r, i) in self.residuals[stage].iter_mut().zip(&self.held.structure.unknowns) {
                    *r = self.scratch[*i] - k[*i];
                }
                self.following.iter().for_each(|i| k[*i] = self.scratch[*i]);
            }
            self.correct(system, &stepping.y, h);
            combine(&stepping.y, h, &self.collocation.weights, &self.k, &mut self.trial);
            if !is_finite(&self.trial) {
                return Err(Failure::NotFinite);
            }
            // What is left changes the energy, of modes that are not resolved as well: it counts in
            // full.
            let size = system.error_norm(&stepping.y, &self.trial, &self.scratch);
            // Quadratures are those of the stages before the last correction, which is to be below
            // the permitted error.
            if self.convergence.is_reached(&mut iterations, size)? && size <= 1.0 {
                return Ok(());
            }
        }
    }

    /// Corrects the rates by the residuals; leaves what that does to the state at the end in
    /// `scratch`.
    fn correct<S: OdeSystem + ?Sized>(&mut self, system: &mut S, y: &[f64], h: f64) {
        self.motion.fill(0.0);
        self.along.fill(0.0);
        self.corrections.iter_mut().for_each(|c| c.fill(0.0));
        for m in 0..PAIRS {
            let pair = self.collocation.pairs[m];
            for (j, x) in self.solution.iter_mut().enumerate() {
                *x = pair.left.iter().zip(&self.residuals).map(|(l, r)| l * r[j]).sum();
            }
            self.solve_pair(system, m, c64::new(0.0, 0.0));
            add_pair(&pair, &self.solution, &mut self.corrections);
        }
        self.scratch.fill(0.0);
        for (j, i) in self.held.structure.unknowns.iter().enumerate() {
            for (k, correction) in self.k.iter_mut().zip(&self.corrections) {
                k[*i] += correction[j];
            }
            let corrections: [f64; STAGES] = std::array::from_fn(|s| self.corrections[s][j]);
            self.scratch[*i] = h * sum(&self.collocation.weights, &corrections);
        }
        self.move_vectors(y, h);
        let g = &self.collocation;
        let mut first = 0;
        for block in &self.held.structure.blocks {
            let (_, len) = block.unknowns();
            // The positions' part: h² Σ b_j (1 - c_j) δ_j.
            let moved = |i: usize| -> f64 {
                let parts =
                    (0..STAGES).map(|s| g.weights[s] * (1.0 - g.nodes[s]) * self.corrections[s][first + i]);
                h * h * parts.sum::<f64>()
            };
            match *block {
                KinematicBlock::Vector { position, .. } => {
                    (0..len).for_each(|i| self.scratch[position + i] = moved(i));
                }
                KinematicBlock::Rotation { quaternion, .. } => {
                    let range = quaternion..quaternion + 4;
                    let turn = Vector3::new(moved(0), moved(1), moved(2));
                    quaternion_rate(&y[range.clone()], &turn, &mut self.scratch[range.clone()]);
                    for (k, weights) in self.k.iter_mut().zip(&g.stages) {
                        let change = |i: usize| -> f64 {
                            (0..STAGES).map(|s| h * weights[s] * self.corrections[s][first + i]).sum()
                        };
                        let mut rate = [0.0; 4];
                        quaternion_rate(
                            &y[range.clone()],
                            &Vector3::new(change(0), change(1), change(2)),
                            &mut rate,
                        );
                        k[range.clone()].iter_mut().zip(rate).for_each(|(k, r)| *k += r);
                    }
                }
                KinematicBlock::Plain { .. } => {}
            }
            first += len;
        }
    }

    /// The error of the step: what the defect at its start grows to (Eq. T.30); leaves it in
    /// `error` and the defect in `defect`.
    fn find_error<S: OdeSystem + ?Sized>(&mut self, system: &mut S, y: &[f64], h: f64) {
        let at_start = self.collocation.at_start;
        for (i, d) in self.defect.iter_mut().enumerate() {
            *d = (0..STAGES).map(|s| at_start[s] * self.k[s][i]).sum::<f64>() - self.rate[i];
        }
        let mut first = 0;
        for block in &self.held.structure.blocks {
            let (_, len) = block.unknowns();
            let motion = &mut self.motion[first..first + len];
            match *block {
                KinematicBlock::Vector { position, .. } => {
                    motion.copy_from_slice(&self.defect[position..position + len]);
                }
                KinematicBlock::Rotation { quaternion, .. } => {
                    let range = quaternion..quaternion + 4;
                    let (q, d) = (read(&y[range.clone()]), read(&self.defect[range]));
                    let turn = q.conjugate() * d * (2.0 / q.norm_squared());
                    motion.copy_from_slice(&[turn.i, turn.j, turn.k]);
                }
                KinematicBlock::Plain { .. } => motion.fill(0.0),
            }
            first += len;
        }
        self.find_change_along();
        let [velocities, positions, ..] = &mut self.corrections;
        for (v, i) in velocities.iter_mut().zip(&self.held.structure.unknowns) {
            *v = STIFF_LIMIT * self.defect[*i];
        }
        positions.fill(0.0);
        for m in 0..PAIRS {
            let pair = self.collocation.pairs[m];
            for (x, i) in self.solution.iter_mut().zip(&self.held.structure.unknowns) {
                *x = c64::new(self.defect[*i], 0.0);
            }
            self.solve_pair(system, m, pair.value * h);
            let by_velocity = 2.0 * pair.residue;
            let by_position = by_velocity * pair.value * h;
            let [velocities, positions, ..] = &mut self.corrections;
            for ((x, v), p) in self.solution.iter().zip(velocities).zip(positions) {
                *v += (by_velocity * x).re;
                *p += (by_position * x).re;
            }
        }
        self.spread_error(y, h);
    }

    /// The error of all components from that of the unknowns and of their positions, the first two
    /// of `corrections`.
    fn spread_error(&mut self, y: &[f64], h: f64) {
        let [velocities, positions, ..] = &self.corrections;
        self.error.fill(0.0);
        let (scale, mut first) = (ERROR_CONSTANT * h, 0);
        for block in &self.held.structure.blocks {
            let (unknown, len) = block.unknowns();
            for i in 0..len {
                self.error[unknown + i] = scale * velocities[first + i];
            }
            match *block {
                KinematicBlock::Vector { position, .. } => {
                    (0..len).for_each(|i| self.error[position + i] = scale * positions[first + i]);
                }
                KinematicBlock::Rotation { quaternion, .. } => {
                    let turn = scale * Vector3::from_column_slice(&positions[first..first + 3]);
                    let range = quaternion..quaternion + 4;
                    quaternion_rate(&y[range.clone()], &turn, &mut self.error[range]);
                }
                KinematicBlock::Plain { .. } => {}
            }
            first += len;
        }
    }
}

impl OneStepMethod for Gauss {
    fn rate(&mut self) -> &mut [f64] {
        &mut self.rate
    }

    fn first_step<S: OdeSystem + ?Sized>(
        &mut self,
        stepping: &mut Stepping,
        system: &mut S,
        t_end: f64,
    ) -> f64 {
        stepping.first_implicit_step(system, &self.rate, t_end)
    }

    fn begin<S: OdeSystem + ?Sized>(&mut self, _stepping: &mut Stepping, system: &mut S) {
        if !self.is_solved_by_system && self.asks_system {
            self.is_solved_by_system = system.hold();
        }
    }

    fn attempt<S: OdeSystem + ?Sized>(
        &mut self,
        stepping: &mut Stepping,
        system: &mut S,
        h: f64,
    ) -> Result<f64, Failure> {
        self.factorise(stepping, system, h)?;
        self.guess(system, &stepping.y, h);
        self.solve(stepping, system, h)?;
        self.find_error(system, &stepping.y, h);
        let error = if stepping.settings.is_fixed {
            0.0
        } else {
            system.damped_error_norm(&stepping.y, &self.trial, &self.error)
        };
        if error <= 1.0 {
            stepping.statistics.evaluations += 1;
            system.rhs(stepping.t + h, &self.trial, &mut self.end_rate)?;
            if !is_finite(&self.end_rate) {
                return Err(Failure::NotFinite);
            }
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
        self.is_solved_by_system = self.asks_system && system.hold(); // evaluated last at the end, where the next step starts
        system.finish_quadratures(&mut self.trial, &mut self.end_rate);
        self.last_step = attempt.h;
        std::mem::swap(&mut self.last_k, &mut self.k);
        let share = 1.0 / (ERROR_CONSTANT * attempt.h * STIFF_LIMIT);
        for ((last, d), e) in self.last_defect.iter_mut().zip(&self.defect).zip(&self.error) {
            *last = d - share * e;
        }
        std::mem::swap(&mut self.rate, &mut self.end_rate);
        self.held.end_step(self.convergence.keeps_derivative());
        let growth = worthwhile_growth(stepping.controller.accepted(error));
        let growth = if growth < 1.0 { growth.min(LEAST_SHRINKAGE) } else { growth };
        stepping.accept(system, attempt, error, growth, &mut self.trial)
    }

    fn renews_for(&mut self, failure: &Failure) -> bool {
        if self.is_solved_by_system && failure.may_be_of_the_derivative() {
            // The same step again by differences, whatever the system knows.
            (self.is_solved_by_system, self.asks_system) = (false, false);
            self.held.invalidate();
            return true;
        }
        self.held.renews_for(failure)
    }

    fn invalidate(&mut self) {
        self.is_solved_by_system = false;
        self.asks_system = true;
        self.held.invalidate();
    }

    fn interpolate(&self, start: &[f64], theta: f64, out: &mut [f64]) {
        let (weights, of_defect) = self.collocation.between(theta);
        combine(start, self.last_step, &weights, &self.last_k, out);
        let factor = self.last_step * of_defect;
        out.iter_mut().zip(&self.last_defect).for_each(|(o, d)| *o += factor * d);
    }
}

/// `out = y + h Σ weights_i k_i`.
fn combine(y: &[f64], h: f64, weights: &[f64; STAGES], k: &[Vec<f64>; STAGES], out: &mut [f64]) {
    let [a, b, c, d] = weights.map(|w| h * w);
    let [k0, k1, k2, k3] = k;
    let rates = k0.iter().zip(k1).zip(k2.iter().zip(k3));
    for ((o, y), ((k0, k1), (k2, k3))) in out.iter_mut().zip(y).zip(rates) {
        *o = y + ((a * k0 + b * k1) + (c * k2 + d * k3));
    }
}

fn sum(weights: &[f64; STAGES], values: &[f64; STAGES]) -> f64 {
    weights.iter().zip(values).map(|(w, x)| w * x).sum()
}

/// Adds what the solution of a pair and its conjugate bring to the stages.
fn add_pair(pair: &Pair, solution: &[c64], stages: &mut [Vec<f64>; STAGES]) {
    for (stage, weight) in stages.iter_mut().zip(pair.right) {
        let (re, im) = (2.0 * weight.re, 2.0 * weight.im);
        for (s, x) in stage.iter_mut().zip(solution) {
            *s += re * x.re - im * x.im;
        }
    }
}

fn read(x: &[f64]) -> Quaternion<f64> {
    Quaternion::new(x[0], x[1], x[2], x[3])
}
