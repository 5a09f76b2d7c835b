//! Return mapping of all points at once: tangential forces under given normal ones.
//!
//! `min ½ τᵀ(A_TT + D_T)τ + τᵀc` over `|τ_i| <= b_i` (docs/theory.md Eq. F.5): strictly convex, one
//! or two tangential components per point. Its optimality conditions are Coulomb's law for the slip
//! increments `w = (A_TT + D_T)τ + c`: zero where a point sticks, against the force where it slides
//! (Eq. F.6).
//!
//! Newton's method on the sets: a sticking point has all its components free, a sliding one only
//! the turn of its force along the circle (Eq. F.7), so that one symmetric positive definite matrix
//! is factorised. In the plane a sliding point has nothing free, and the method is the active-set
//! method for bounds on both sides. Where exchanges don't gain, as between points that are more than
//! the surface has displacements, sweeps follow that lower F.5 point by point, and Newton's method
//! goes on from the sets that they find.
//!
//! Only loaded points are computed: their block of the compliance is kept as long as they stay the
//! same. A factor is kept until the free directions have turned, or until steps with it no longer
//! reduce the error (Newton's method with a kept matrix). The last step has the exact matrix, or
//! reaches the tolerance without it.

use crate::solver_fault::SolverFault;
use ffr_dynamics::error::EvaluationFailure;

use super::factors::Cholesky;
use super::inverse::SetInverse;

mod blocks;
mod by_inverse;
mod loaded;
mod uncoupled;

pub(crate) use blocks::Blocks;
use loaded::LoadedPoints;

/// Exchanges without progress before sweeps start (Júdice & Pires 1994).
const PATIENCE: usize = 10;
/// Sweeps of the first time; each time they are twice as many.
const FIRST_SWEEPS: usize = 8;
/// Round-off allowance of a slip, in units of `n eps max|c|`.
const SLIP_ROUND_OFF: f64 = 32.0 * f64::EPSILON;
/// Relative excess of a force over its bound up to which the point still sticks: round-off of the
/// solution.
const BOUND_ROUND_OFF: f64 = 1e-13;
/// The factor is kept until one of its directions has turned by this (sine): each step then still
/// gains a digit.
const KEPT_TURN: f64 = 0.1;
/// Steps with a kept factor go on as long as each is smaller than the one before by this factor,
const KEPT_GAIN: f64 = 0.3;
/// and at most for so many steps, which cost about as much as a factorisation.
const KEPT_STEPS: usize = 5;
/// A pivot smaller than this times `n eps` of its diagonal entry is round-off.
const PIVOT_ROUND_OFF: f64 = 64.0 * f64::EPSILON;

/// State of a contact point.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum PointState {
    /// No normal force.
    #[default]
    Open,
    /// Held.
    Stick,
    /// Slides.
    Slip,
}

/// Data of one problem. Tangential components are ordered `n_t * point + component`.
#[derive(Clone, Copy)]
pub(crate) struct TangentialProblem<'a> {
    /// `A_TT` [m/N].
    pub compliance: &'a Blocks,
    /// Compliance of each point's tangential spring [m/N].
    pub springs: &'a [f64],
    /// Slip `c` without tangential forces since the references were last updated \[m\].
    pub slips: &'a [f64],
    /// Bounds `μ λ_i` \[N\].
    pub bounds: &'a [f64],
}

/// A free direction of the forces: component pair and unit vector.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Free {
    point: usize,
    direction: [f64; 2],
}

/// The result of a Newton step.
struct Step {
    /// Whether its matrix was that of the present sets and directions.
    is_exact: bool,
    /// Largest change of a force \[N\].
    size: f64,
}

/// Solver for one number of points; holds the last states as a warm start and all buffers.
pub(crate) struct Tangential {
    n_t: usize,
    states: Vec<PointState>,
    /// Unit vectors along the forces of sliding points.
    directions: Vec<[f64; 2]>,
    /// Slip increments `w` of the last solution \[m\].
    increments: Vec<f64>,
    /// `|w_i|/b_i` of sliding points [m/N].
    stretches: Vec<f64>,
    free: Vec<Free>,
    /// Free directions that the factor belongs to.
    factored: Vec<Free>,
    factor: Vec<f64>,
    solution: Vec<f64>,
    /// Inverse for the components of loaded points, these, and its answer.
    inverse: SetInverse,
    components: Vec<usize>,
    answer: Vec<f64>,
    loaded: LoadedPoints,
    cholesky: Cholesky,
    saved: (Vec<PointState>, Vec<[f64; 2]>),
}

impl Tangential {
    /// Solver for `n_points` points with `n_t` tangential components (1 or 2).
    pub fn new(n_points: usize, n_t: usize) -> Self {
        let n = n_points * n_t;
        Self {
            n_t,
            states: vec![PointState::Open; n_points],
            directions: vec![[1.0, 0.0]; n_points],
            increments: vec![0.0; n],
            stretches: vec![0.0; n_points],
            free: Vec::with_capacity(n),
            factored: Vec::with_capacity(n),
            factor: vec![0.0; n * n],
            solution: vec![0.0; n],
            inverse: SetInverse::default(),
            components: Vec::with_capacity(n),
            answer: vec![0.0; n],
            loaded: LoadedPoints::new(n_points, n_t),
            cholesky: Cholesky::new(n),
            saved: (vec![PointState::Open; n_points], vec![[1.0, 0.0]; n_points]),
        }
    }

    pub fn states(&self) -> &[PointState] {
        &self.states
    }

    /// States of the points when they were saved last.
    pub fn saved_states(&self) -> &[PointState] {
        &self.saved.0
    }

    pub fn increments(&self) -> &[f64] {
        &self.increments
    }

    pub fn invalidate(&mut self) {
        self.factored.clear();
        self.inverse.forget();
        self.loaded.forget();
    }

    /// Factors are forgotten, so that solutions after [`Tangential::restore`] are the same in every bit.
    pub fn save(&mut self) {
        self.factored.clear();
        self.inverse.forget();
        self.saved.0.copy_from_slice(&self.states);
        self.saved.1.copy_from_slice(&self.directions);
    }

    pub fn restore(&mut self) {
        self.factored.clear();
        self.inverse.forget();
        self.states.copy_from_slice(&self.saved.0);
        self.directions.copy_from_slice(&self.saved.1);
    }

    /// Solves for `forces`, which hold those of an earlier solution, until slip increments that have to vanish are at most `tolerance`
    /// \[m\], or round-off; returns the number of steps. Slip increments of open points are left as they are.
    ///
    /// # Errors
    /// A slip that is not finite, dependent points without springs, the limit of iterations.
    pub fn solve(
        &mut self,
        problem: &TangentialProblem<'_>,
        tolerance: f64,
        forces: &mut [f64],
    ) -> Result<usize, EvaluationFailure> {
        if !problem.slips.iter().all(|c| c.is_finite()) {
            return Err(SolverFault::NotFinite { value: "tangential displacement" }.into());
        }
        let loaded = problem.slips.iter().enumerate().filter(|(k, _)| problem.bounds[k / self.n_t] > 0.0);
        let largest = loaded.fold(0.0_f64, |m, (_, c)| m.max(c.abs()));
        self.guess(problem, forces);
        self.loaded.gather(&self.states, problem.compliance);
        self.loaded.update_increments(problem, forces, &mut self.increments);
        let limit = 100 + 50 * self.states.len();
        let allowance = SLIP_ROUND_OFF * self.increments.len() as f64 * largest;
        let (mut fewest, mut patience) = (usize::MAX, PATIENCE);
        let (mut n_kept, mut last, mut n_sweeps) = (0, f64::INFINITY, FIRST_SWEEPS);
        for iteration in 1..=limit {
            let step = self.step(problem, n_kept < KEPT_STEPS, forces)?;
            let n_wrong = self.count_wrong(problem, forces, allowance);
            if n_wrong == 0 && self.residual() <= tolerance.max(allowance) {
                return Ok(iteration);
            }
            n_kept = match step.is_exact {
                true => 0,
                false if step.size <= KEPT_GAIN * last => n_kept + 1,
                false => KEPT_STEPS,
            };
            last = if n_wrong == 0 { step.size } else { f64::INFINITY };
            if n_wrong < fewest {
                (fewest, patience) = (n_wrong, PATIENCE);
            } else {
                patience -= 1;
            }
            if patience == 0 {
                (fewest, patience) = (usize::MAX, PATIENCE);
                (0..n_sweeps).for_each(|_| self.sweep(problem, forces));
                n_sweeps *= 2;
            } else if n_wrong > 0 {
                (0..self.states.len()).for_each(|i| self.exchange(i, problem, forces, allowance));
            }
            if n_wrong > 0 || patience == PATIENCE {
                self.loaded.update_increments(problem, forces, &mut self.increments);
            }
        }
        Err(SolverFault::SlidingSet { points: self.states.len(), iterations: limit }.into())
    }

    /// States and forces to start from: points that have just been loaded slide against their slip, the others keep state and force.
    fn guess(&mut self, problem: &TangentialProblem<'_>, forces: &mut [f64]) {
        for i in 0..self.states.len() {
            if problem.bounds[i] <= 0.0 {
                self.states[i] = PointState::Open;
                forces[self.n_t * i..self.n_t * (i + 1)].fill(0.0);
                continue;
            }
            if self.states[i] == PointState::Open {
                let slip = pair(problem.slips, i, self.n_t);
                let size = slip[0].hypot(slip[1]);
                self.states[i] = PointState::Stick;
                if size > 0.0 {
                    self.states[i] = PointState::Slip;
                    self.directions[i] = slip.map(|c| -c / size);
                }
            }
            if self.states[i] == PointState::Slip {
                self.slide(i, problem.bounds[i], forces);
            }
        }
    }

    /// Sets the force of point `i` to `bound` along its direction.
    fn slide(&self, i: usize, bound: f64, forces: &mut [f64]) {
        for (force, direction) in forces[self.n_t * i..self.n_t * (i + 1)].iter_mut().zip(self.directions[i])
        {
            *force = bound * direction;
        }
    }

    /// One Newton step on the present sets, with the factor of an earlier step where it is near enough.
    fn step(
        &mut self,
        problem: &TangentialProblem<'_>,
        may_keep: bool,
        forces: &mut [f64],
    ) -> Result<Step, EvaluationFailure> {
        self.collect_free();
        let is_exact = !(may_keep && self.is_near_factored()) || self.is_factored();
        let is_new = !self.is_factored() && is_exact;
        if is_new {
            self.stretch_sliding(problem);
        }
        let increments = std::mem::take(&mut self.increments);
        let is_done = is_new && self.solve_by_inverse(problem, &increments);
        let outcome = if is_new && !is_done { self.factorise(problem) } else { Ok(()) };
        if outcome.is_ok() && !is_done {
            self.solve_free(&increments);
        }
        self.increments = increments;
        outcome?;
        if !self.solution[..self.free.len()].iter().all(|x| x.is_finite()) {
            self.factored.clear();
            return Err(SolverFault::NotFinite { value: "friction force" }.into());
        }
        let size = self.solution[..self.free.len()].iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        self.add_free(forces);
        self.turn(problem, forces);
        self.loaded.update_increments(problem, forces, &mut self.increments);
        Ok(Step { is_exact, size })
    }

    /// Whether the factor depends on no direction and belongs to the present sets.
    fn is_factored(&self) -> bool {
        let has_turns = self.n_t == 2 && self.states.contains(&PointState::Slip);
        !has_turns && self.factored == self.free
    }

    /// Whether the factor belongs to the present sets with directions not far from the present ones.
    fn is_near_factored(&self) -> bool {
        let is_near = |a: &Free, b: &Free| {
            let [x, y] = [0, 1].map(|c| a.direction[c] - b.direction[c]);
            a.point == b.point && x * x + y * y <= KEPT_TURN * KEPT_TURN
        };
        self.factored.len() == self.free.len()
            && self.factored.iter().zip(&self.free).all(|(a, b)| is_near(a, b))
    }

    /// Takes the forces of sliding points back to the circle.
    fn turn(&mut self, problem: &TangentialProblem<'_>, forces: &mut [f64]) {
        for free in &self.free {
            let i = free.point;
            if self.states[i] == PointState::Slip {
                let force = pair(forces, i, 2);
                let size = force[0].hypot(force[1]);
                self.directions[i] = force.map(|f| f / size);
                for a in 0..2 {
                    forces[2 * i + a] = problem.bounds[i] * self.directions[i][a];
                }
            }
        }
    }

    /// Replaces `forces` by `sizes` along the directions of sliding points, zero elsewhere.
    fn forces_on_directions(&self, sizes: &[f64], forces: &mut [f64]) {
        forces.fill(0.0);
        for (i, state) in self.states.iter().enumerate() {
            if *state == PointState::Slip {
                for a in 0..self.n_t {
                    forces[self.n_t * i + a] = sizes[i] * self.directions[i][a];
                }
            }
        }
    }

    /// Adds the solution along the free directions.
    fn add_free(&self, forces: &mut [f64]) {
        for (free, &x) in self.free.iter().zip(&self.solution) {
            for a in 0..self.n_t {
                forces[self.n_t * free.point + a] += free.direction[a] * x;
            }
        }
    }

    /// Free directions of the present sets.
    fn collect_free(&mut self) {
        self.free.clear();
        for (i, state) in self.states.iter().enumerate() {
            match state {
                PointState::Open => {}
                PointState::Stick => {
                    let units = [[1.0, 0.0], [0.0, 1.0]];
                    self.free.extend(units[..self.n_t].iter().map(|&direction| Free { point: i, direction }));
                }
                PointState::Slip if self.n_t == 2 => {
                    let [x, y] = self.directions[i];
                    self.free.push(Free { point: i, direction: [-y, x] });
                }
                PointState::Slip => {}
            }
        }
    }

    /// Cholesky factor of the projection of `A_TT + D_T` on the free directions, with `|w_i|/b_i`
    /// of sliding points on the diagonal (Eq. F.7). Its lower half is made of the lower half of the
    /// projection.
    fn factorise(&mut self, problem: &TangentialProblem<'_>) -> Result<(), EvaluationFailure> {
        let (m, n_t) = (self.free.len(), self.n_t);
        self.factored.clear();
        if m == 0 {
            return Ok(());
        }
        for (column, &q) in self.free.iter().enumerate() {
            let (displacement, points) = self.loaded.displacement(q.point, &q.direction);
            let target = &mut self.factor[column * m..(column + 1) * m];
            for (entry, p) in target[column..].iter_mut().zip(&self.free[column..]) {
                let [x, y] = pair(displacement, points.place(p.point), n_t);
                *entry = p.direction[0] * x + p.direction[1] * y;
            }
            let mut added = problem.springs[q.point];
            if self.states[q.point] == PointState::Slip {
                added += self.stretches[q.point];
            }
            target[column] += added;
        }
        let largest = (0..m).map(|k| self.factor[k * m + k]).fold(0.0, f64::max);
        let limit = PIVOT_ROUND_OFF * m as f64 * largest;
        // What yields to no force, as a point on an axis of symmetry, needs none to be held.
        for k in 0..m {
            if self.factor[k * m + k] <= limit {
                (0..k).for_each(|column| self.factor[column * m + k] = 0.0);
                self.factor[k * m..(k + 1) * m].fill(0.0);
                self.factor[k * m + k] = if largest > 0.0 { largest } else { 1.0 };
            }
        }
        let is_definite = self.cholesky.factorise(&mut self.factor, m);
        let is_regular = |k: usize| self.factor[k * m + k] * self.factor[k * m + k] > limit;
        if !is_definite || !(0..m).all(is_regular) {
            let is_exact = self.free.iter().any(|q| problem.springs[q.point] <= 0.0);
            return Err(SolverFault::SingularTangential { directions: m, is_exact }.into());
        }
        self.factored.extend_from_slice(&self.free);
        Ok(())
    }

    /// `|w_i|/b_i` of sliding points, which resists the turn of their forces.
    fn stretch_sliding(&mut self, problem: &TangentialProblem<'_>) {
        for i in 0..self.states.len() {
            if self.states[i] == PointState::Slip {
                let (w, e) = (pair(&self.increments, i, self.n_t), self.directions[i]);
                self.stretches[i] = (-(w[0] * e[0] + w[1] * e[1]) / problem.bounds[i]).max(0.0);
            }
        }
    }

    /// Amplitudes of the free directions that cancel `residual`, in `solution`.
    fn solve_free(&mut self, residual: &[f64]) {
        let (m, n_t) = (self.free.len(), self.n_t);
        for (x, free) in self.solution.iter_mut().zip(&self.free) {
            let w = pair(residual, free.point, n_t);
            *x = -(w[0] * free.direction[0] + w[1] * free.direction[1]);
        }
        self.cholesky.solve(&self.factor, &mut self.solution[..m]);
    }

    /// Takes all points as open, before [`Self::note`].
    pub fn open_all(&mut self) {
        self.factored.clear();
        self.states.fill(PointState::Open);
    }

    /// Notes the state of point `i` in a solution that was found elsewhere, and its slip increment unless it is open.
    pub fn note(&mut self, i: usize, state: PointState, increment: &[f64; 2]) {
        self.states[i] = state;
        if state != PointState::Open {
            self.increments[self.n_t * i..self.n_t * (i + 1)].copy_from_slice(&increment[..self.n_t]);
        }
    }

    /// Sets the slip increments of open points.
    pub fn set_open_increments(&mut self, increment: impl Fn(usize, usize) -> f64) {
        for (i, increments) in self.increments.chunks_exact_mut(self.n_t).enumerate() {
            if self.states[i] == PointState::Open {
                increments.iter_mut().enumerate().for_each(|(a, w)| *w = increment(i, a));
            }
        }
    }

    /// Takes `forces` next to those `wanted` within the bounds, and the slip increments under them, for which nothing is solved.
    pub fn take(&mut self, problem: &TangentialProblem<'_>, wanted: &[f64], forces: &mut [f64]) {
        for (i, bound) in problem.bounds.iter().enumerate() {
            let [x, y] = pair(wanted, i, self.n_t);
            let size = x.hypot(y);
            let share = if size > *bound { bound / size } else { 1.0 };
            self.states[i] = match (*bound > 0.0, share < 1.0) {
                (false, _) => PointState::Open,
                (true, false) => PointState::Stick,
                (true, true) => PointState::Slip,
            };
            if self.states[i] == PointState::Slip {
                self.directions[i] = [x / size, y / size];
            }
            for k in self.n_t * i..self.n_t * (i + 1) {
                forces[k] = share * wanted[k];
            }
        }
        self.factored.clear();
        if problem.compliance.yields() {
            self.loaded.gather(&self.states, problem.compliance);
            self.loaded.update_increments(problem, forces, &mut self.increments);
            return;
        }
        for (k, slip) in self.increments.iter_mut().enumerate() {
            *slip = problem.slips[k] + problem.springs[k / self.n_t] * forces[k];
        }
    }

    /// Whether point `i` is in the wrong state.
    fn is_wrong(&self, i: usize, problem: &TangentialProblem<'_>, forces: &[f64], tolerance: f64) -> bool {
        match self.states[i] {
            PointState::Open => false,
            PointState::Stick => {
                let [x, y] = pair(forces, i, self.n_t);
                x.hypot(y) > problem.bounds[i] * (1.0 + BOUND_ROUND_OFF)
            }
            PointState::Slip => {
                let (w, e) = (pair(&self.increments, i, self.n_t), self.directions[i]);
                w[0] * e[0] + w[1] * e[1] > tolerance
            }
        }
    }

    /// Largest slip increment that has to vanish: of sticking points, and across the forces of sliding ones.
    fn residual(&self) -> f64 {
        let of_point = |(i, state): (usize, &PointState)| {
            let (w, e) = (pair(&self.increments, i, self.n_t), self.directions[i]);
            match state {
                PointState::Open => 0.0,
                PointState::Stick => w[0].hypot(w[1]),
                PointState::Slip if self.n_t == 2 => (w[0] * e[1] - w[1] * e[0]).abs(),
                PointState::Slip => 0.0,
            }
        };
        self.states.iter().enumerate().map(of_point).fold(0.0, f64::max)
    }

    fn count_wrong(&self, problem: &TangentialProblem<'_>, forces: &[f64], tolerance: f64) -> usize {
        (0..self.states.len()).filter(|&i| self.is_wrong(i, problem, forces, tolerance)).count()
    }

    /// Moves the force of one loaded point after the other down the slope of F.5, by no more than its
    /// own yield allows, and back to its bound: none of these steps raises F.5. Sets are those that
    /// the forces end with.
    fn sweep(&mut self, problem: &TangentialProblem<'_>, forces: &mut [f64]) {
        self.loaded.update_increments(problem, forces, &mut self.increments);
        for slot in 0..self.loaded.points.list().len() {
            let (i, n_t) = (self.loaded.points.list()[slot], self.n_t);
            let (increment, stiffest) = self.loaded.increment(slot, problem.springs[i]);
            let (old, bound) = (pair(forces, i, n_t), problem.bounds[i]);
            // What yields to no force needs none.
            let way = if stiffest > 0.0 { 1.0 / stiffest } else { 0.0 };
            let mut new = [0, 1].map(|a| old[a] - way * increment[a]);
            let size = new[0].hypot(new[1]);
            self.states[i] = if size > bound { PointState::Slip } else { PointState::Stick };
            if size > bound {
                self.directions[i] = new.map(|f| f / size);
                new = self.directions[i].map(|d| d * bound);
            }
            forces[n_t * i..n_t * (i + 1)].copy_from_slice(&new[..n_t]);
            self.loaded.add_force(slot, problem.springs[i], [new[0] - old[0], new[1] - old[1]]);
        }
    }

    /// Moves point `i` to the other state if it is in the wrong one.
    fn exchange(&mut self, i: usize, problem: &TangentialProblem<'_>, forces: &mut [f64], tolerance: f64) {
        if !self.is_wrong(i, problem, forces, tolerance) {
            return;
        }
        if self.states[i] == PointState::Stick {
            let force = pair(forces, i, self.n_t);
            let size = force[0].hypot(force[1]);
            self.directions[i] = force.map(|f| f / size);
            self.states[i] = PointState::Slip;
            self.slide(i, problem.bounds[i], forces);
        } else {
            self.states[i] = PointState::Stick;
        }
    }

    /// Prepares [`Tangential::rates`] at the solution of `problem`.
    ///
    /// # Errors
    /// As [`Tangential::solve`].
    pub fn prepare_rates(&mut self, problem: &TangentialProblem<'_>) -> Result<(), EvaluationFailure> {
        self.loaded.gather(&self.states, problem.compliance);
        self.stretch_sliding(problem);
        self.collect_free();
        self.factorise(problem)
    }

    /// Rates of forces and of slip increments of loaded points on the present sets (Eq. F.11), when the bounds change
    /// at `bound_rates` \[N/s\] and `c` at `drift` [m/s]. [`Tangential::prepare_rates`] comes
    /// first.
    pub fn rates(
        &mut self,
        problem: &TangentialProblem<'_>,
        bound_rates: &[f64],
        drift: &[f64],
        rates: &mut [f64],
        slip_rates: &mut [f64],
    ) {
        let rate_problem = TangentialProblem { bounds: bound_rates, slips: drift, ..*problem };
        self.forces_on_directions(bound_rates, rates);
        self.loaded.update_increments(&rate_problem, rates, slip_rates);
        self.solve_free(slip_rates);
        self.add_free(rates);
        self.loaded.update_increments(&rate_problem, rates, slip_rates);
    }
}

/// Tangential components of point `i`, the second zero in the plane.
fn pair(values: &[f64], i: usize, n_t: usize) -> [f64; 2] {
    [values[n_t * i], if n_t == 2 { values[n_t * i + 1] } else { 0.0 }]
}

#[cfg(test)]
mod tests;
