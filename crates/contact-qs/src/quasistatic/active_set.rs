//! Active-set solver: a semismooth Newton method with one small Cholesky factorisation per change
//! of the set.
//!
//! For a set `a` of points in contact the forces follow from `(A_aa + D_aa) λ_a = -g⁰_a`
//! (docs/theory.md Eq. C.8). Points with tension leave the set and penetrating points enter it, all
//! at once (Eq. C.9): that is Newton's method on `min(λ, g + Dλ) = 0`. It needs two or three sets,
//! one when the last set is still right. Full exchanges may cycle; when the number of wrong points
//! has not fallen for ten exchanges, single exchanges of the highest wrong index follow until it
//! does. That is block principal pivoting, which ends for every positive definite `A + D` (Júdice &
//! Pires 1994, after Murty's least-index rule).
//!
//! Tolerance (Eq. C.10): a point enters only if it penetrates by more than the round-off of its
//! gap, `32 n_a eps max(-g⁰)`; it leaves at any tension. So no point can go in and out on round-off
//! alone.
//!
//! Large sets that change by few points while compliance and springs stay are solved by the inverse of their
//! union (Eq. C.95), made once a few factorisations of its subsets have shown that it pays.

use crate::solver_fault::SolverFault;
use ffr_dynamics::error::EvaluationFailure;

use super::factors::Cholesky;
use super::inverse::SetInverse;
use super::problem::{OPEN, Problem};

/// Full exchanges without progress before single exchanges start.
const PATIENCE: usize = 10; // Júdice & Pires 1994
/// Round-off allowance of a gap, in units of `n_a eps max(-g⁰)`: a sum of `n_a + 1` products, with
/// a margin.
const GAP_ROUND_OFF: f64 = 32.0 * f64::EPSILON;
/// A pivot smaller than this times `n_a` eps of its diagonal entry is round-off: the set is
/// dependent.
const PIVOT_ROUND_OFF: f64 = 64.0 * f64::EPSILON;

/// What a solution took.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct SolveReport {
    /// Whether Algorithm 1 ended at its iteration limit with a solution of lower accuracy (not
    /// critical, \[A\] section 3).
    pub hit_iteration_limit: bool,
    /// Sets tried, or Newton steps.
    pub iterations: usize,
    /// Cholesky factorisations, or finite-difference Jacobians.
    pub factorisations: usize,
    /// Exchanges of a single point, or resets of Algorithm 1.
    pub fallbacks: usize,
}

impl SolveReport {
    /// Adds what another solution took.
    pub(crate) fn add(&mut self, other: Self) {
        self.hit_iteration_limit |= other.hit_iteration_limit;
        self.iterations += other.iterations;
        self.factorisations += other.factorisations;
        self.fallbacks += other.fallbacks;
    }
}

/// Active-set solver for one number of points; holds the last set as a warm start and all buffers.
pub struct ActiveSet {
    active: Vec<bool>,
    saved: Vec<bool>,
    members: Vec<usize>,
    /// The set that `factor` belongs to; empty if none.
    factored: Vec<usize>,
    factor: Vec<f64>,
    solution: Vec<f64>,
    slack: Vec<f64>,
    cholesky: Cholesky,
    patience: usize,
    inverse: SetInverse,
    /// Whether the last forces are those of `inverse`.
    is_by_inverse: bool,
}

impl ActiveSet {
    /// Solver for `n_points` points, with an empty set.
    pub fn new(n_points: usize) -> Self {
        Self {
            active: vec![false; n_points],
            saved: vec![false; n_points],
            members: Vec::with_capacity(n_points),
            factored: Vec::with_capacity(n_points),
            factor: vec![0.0; n_points * n_points],
            solution: vec![0.0; n_points],
            slack: vec![0.0; n_points],
            cholesky: Cholesky::new(n_points),
            patience: PATIENCE,
            inverse: SetInverse::default(),
            is_by_inverse: false,
        }
    }

    /// Points of the last set.
    pub fn active(&self) -> &[bool] {
        &self.active
    }

    /// Forgets the factorisation; to be called when compliance or springs have changed.
    pub fn invalidate(&mut self) {
        self.factored.clear();
        self.inverse.invalidate();
    }

    /// Remembers the set.
    pub fn save(&mut self) {
        self.saved.copy_from_slice(&self.active);
    }

    /// Returns to the remembered set.
    pub fn restore(&mut self) {
        self.active.copy_from_slice(&self.saved);
    }

    /// Solves `problem` for `forces` \[N\], starting from the last set.
    ///
    /// # Errors
    /// A gap that is not finite; points of the set that are dependent and have no penalty springs
    /// (more points than surface functions with the exact constraint); the limit of iterations.
    ///
    /// # Panics
    /// If sizes differ from the number of points given to [`ActiveSet::new`].
    pub fn solve(
        &mut self,
        problem: &Problem<'_>,
        forces: &mut [f64],
    ) -> Result<SolveReport, EvaluationFailure> {
        let n = self.active.len();
        assert!(
            problem.gaps.len() == n && problem.springs.len() == n && forces.len() == n,
            "contact problem with {} gaps and {} forces for a solver of {n} points",
            problem.gaps.len(),
            forces.len()
        );
        let depth = problem.depth();
        if depth.is_nan() {
            return Err(SolverFault::NotFinite { value: "contact gap" }.into());
        }
        forces.fill(0.0);
        let mut report = SolveReport::default();
        if depth <= 0.0 {
            self.active.fill(false);
            self.members.clear();
            self.is_by_inverse = false;
            self.slack.copy_from_slice(problem.gaps);
            return Ok(report);
        }
        if !self.active.contains(&true) {
            self.active.iter_mut().zip(problem.gaps).for_each(|(a, &g)| *a = g < 0.0);
        }
        self.iterate(problem, depth, &mut report)?;
        for (&i, &force) in self.members.iter().zip(&self.solution) {
            forces[i] = force;
        }
        Ok(report)
    }

    /// Exchanges points until every one is right.
    fn iterate(
        &mut self,
        problem: &Problem<'_>,
        depth: f64,
        report: &mut SolveReport,
    ) -> Result<(), EvaluationFailure> {
        let n = self.active.len();
        // Practice needs a handful; single exchanges have needed at most about 2 n in random tests.
        let limit = 100 + 50 * n;
        let (mut fewest_wrong, mut patience) = (n + 1, self.patience);
        while report.iterations < limit {
            report.iterations += 1;
            self.forces_of_set(problem, report)?;
            let tolerance = GAP_ROUND_OFF * self.members.len().max(1) as f64 * depth;
            self.slacks(problem);
            let (n_wrong, highest) = self.count_wrong(tolerance);
            if n_wrong == 0 {
                return Ok(());
            }
            if n_wrong < fewest_wrong {
                (fewest_wrong, patience) = (n_wrong, self.patience);
            } else {
                patience = patience.saturating_sub(1);
            }
            if patience > 0 {
                self.exchange(tolerance);
            } else {
                report.fallbacks += 1;
                self.active[highest] = !self.active[highest];
            }
        }
        Err(SolverFault::ActiveSet { points: n, iterations: limit }.into())
    }

    /// Solves Eq. C.8 for the points of the set; the factor is kept as long as the set stays the
    /// same, an inverse as long as all points are among those that it was made for.
    fn forces_of_set(
        &mut self,
        problem: &Problem<'_>,
        report: &mut SolveReport,
    ) -> Result<(), EvaluationFailure> {
        self.members.clear();
        self.members.extend(self.active.iter().enumerate().filter(|(_, a)| **a).map(|(i, _)| i));
        let m = self.members.len();
        if self.solve_by_inverse(problem, |i| -problem.gaps[i], report) {
            return self.check_forces(m);
        }
        if m > 0 && self.factored != self.members {
            report.factorisations += 1;
            self.factorise(problem)?;
            self.inverse.note(&self.members, self.active.len());
        }
        for (x, &i) in self.solution.iter_mut().zip(&self.members) {
            *x = -problem.gaps[i];
        }
        self.cholesky.solve(&self.factor, &mut self.solution[..m]);
        self.check_forces(m)
    }

    fn check_forces(&mut self, m: usize) -> Result<(), EvaluationFailure> {
        if self.solution[..m].iter().all(|x| x.is_finite()) {
            Ok(())
        } else {
            self.invalidate();
            Err(SolverFault::NotFinite { value: "contact force" }.into())
        }
    }

    /// Solves for the set `members` with the right-hand side `rhs` by the inverse of a larger one, if that pays and
    /// is well-conditioned.
    fn solve_by_inverse(
        &mut self,
        problem: &Problem<'_>,
        rhs: impl Fn(usize) -> f64,
        report: &mut SolveReport,
    ) -> bool {
        self.is_by_inverse = false;
        if self.factored == self.members || !self.inverse.serves(&self.members) {
            return false;
        }
        let entry =
            |i: usize, j: usize| problem.compliance[(i, j)] + if i == j { problem.springs[i] } else { 0.0 };
        // The factor gives its place to that of the union.
        self.factored.clear();
        if !self.inverse.make(entry, &mut self.factor) {
            return false;
        }
        let mut places = self.solution.iter_mut();
        let found = |_, force: f64| places.by_ref().take(1).for_each(|x| *x = force);
        let done = self.inverse.solve(&self.active, rhs, found);
        report.factorisations += usize::from(done == Some(true));
        self.is_by_inverse = done.is_some();
        self.is_by_inverse
    }

    /// Cholesky factor of `A_aa + D_aa`.
    fn factorise(&mut self, problem: &Problem<'_>) -> Result<(), EvaluationFailure> {
        let m = self.members.len();
        self.factored.clear();
        for (column, &j) in self.members.iter().enumerate() {
            let source = problem.compliance.col_as_slice(j);
            let target = &mut self.factor[column * m..(column + 1) * m];
            for (entry, &i) in target.iter_mut().zip(&self.members) {
                *entry = source[i];
            }
            target[column] += problem.springs[j];
        }
        let is_definite = self.cholesky.factorise(&mut self.factor, m);
        let limit = PIVOT_ROUND_OFF * m as f64;
        let dependent = |(k, &i): (usize, &usize)| {
            let diagonal = problem.compliance[(i, i)] + problem.springs[i];
            let pivot = self.factor[k * m + k] * self.factor[k * m + k];
            // Asked this way round, a NaN counts as dependent.
            let is_independent = pivot > limit * diagonal;
            !is_independent
        };
        if !is_definite || self.members.iter().enumerate().any(dependent) {
            let is_exact = self.members.iter().any(|&i| problem.springs[i] <= 0.0);
            return Err(SolverFault::SingularCompliance { points: m, is_exact }.into());
        }
        self.factored.extend_from_slice(&self.members);
        Ok(())
    }

    /// Replaces `rhs`, one value per point, by the solution of `(A_aa + D_aa) x_a = rhs_a` on the
    /// set of the last solution, zero outside it.
    pub(crate) fn solve_on_set(&mut self, rhs: &mut [f64]) {
        if self.is_by_inverse {
            self.slack.copy_from_slice(rhs);
            rhs.fill(0.0);
            let of = &self.slack;
            // Its factor is that of the last solution, which did not fail.
            let _ = self.inverse.solve(&self.active, |i| of[i], |i, x| rhs[i] = x);
            return;
        }
        let m = self.factored.len();
        if !self.active.contains(&true) {
            rhs.fill(0.0);
            return;
        }
        for (x, &i) in self.slack.iter_mut().zip(&self.factored) {
            *x = rhs[i];
        }
        self.cholesky.solve(&self.factor, &mut self.slack[..m]);
        rhs.fill(0.0);
        for (&x, &i) in self.slack.iter().zip(&self.factored) {
            rhs[i] = x;
        }
    }

    /// Gaps of the points outside the set that anything can press.
    fn slacks(&mut self, problem: &Problem<'_>) {
        for (i, gap) in problem.gaps.iter().enumerate() {
            let moved = if self.is_pressable(problem, i) { self.displacement(problem, i) } else { 0.0 };
            self.slack[i] = gap + moved;
        }
    }

    /// Whether point `i` stands outside the set, and something can press it.
    fn is_pressable(&self, problem: &Problem<'_>, i: usize) -> bool {
        !self.active[i] && problem.gaps[i] < 0.5 * OPEN
    }

    /// Displacement of point `i` outside the set under the last forces.
    fn displacement(&self, problem: &Problem<'_>, i: usize) -> f64 {
        if let Some(known) = self.inverse.displacement(i).filter(|_| self.is_by_inverse) {
            return known;
        }
        // The compliance is symmetric: a row is a column; and positive semidefinite: a point that yields to no force of its
        // own is moved by none.
        let column = problem.compliance.col_as_slice(i);
        if column[i] == 0.0 { 0.0 } else { dot_at(column, &self.members, &self.solution) }
    }

    /// Replaces `out` by the displacements `A forces` of all points under `forces`, which the last solution of `problem` has
    /// found: of points of the set they follow from (C.8), of the others it knows them.
    pub(crate) fn displacements(&self, problem: &Problem<'_>, forces: &[f64], out: &mut [f64]) {
        for (i, u) in out.iter_mut().enumerate() {
            *u = match (self.active[i], self.is_pressable(problem, i)) {
                (true, _) => -problem.gaps[i] - problem.springs[i] * forces[i],
                (false, true) => self.slack[i] - problem.gaps[i],
                (false, false) => self.displacement(problem, i),
            };
        }
    }

    /// Number and highest index of the points that are on the wrong side.
    fn count_wrong(&self, tolerance: f64) -> (usize, usize) {
        let (mut n_wrong, mut highest, mut k) = (0, 0, 0);
        for (i, &active) in self.active.iter().enumerate() {
            let wrong = if active { self.solution[k] < 0.0 } else { self.slack[i] < -tolerance };
            k += usize::from(active);
            if wrong {
                (n_wrong, highest) = (n_wrong + 1, i);
            }
        }
        (n_wrong, highest)
    }

    /// Moves every wrong point to the other side (Eq. C.9).
    fn exchange(&mut self, tolerance: f64) {
        let mut k = 0;
        for (i, active) in self.active.iter_mut().enumerate() {
            if *active {
                *active = self.solution[k] >= 0.0;
                k += 1;
            } else {
                *active = self.slack[i] < -tolerance;
            }
        }
    }
}

/// Product of the entries `places` of `column` with `x`, in four sums side by side: one would wait for each addition.
fn dot_at(column: &[f64], places: &[usize], x: &[f64]) -> f64 {
    let (mut sums, x) = ([0.0; 4], &x[..places.len()]);
    let (fours, of_fours) = (places.chunks_exact(4), x.chunks_exact(4));
    let rest = fours.remainder().iter().zip(of_fours.remainder());
    let rest: f64 = rest.map(|(&j, x)| column[j] * x).sum();
    for (places, x) in fours.zip(of_fours) {
        sums.iter_mut().zip(places).zip(x).for_each(|((sum, &j), x)| *sum += column[j] * x);
    }
    (sums[0] + sums[1]) + (sums[2] + sums[3]) + rest
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quasistatic::problem::add_product;
    use faer::Mat;

    #[test]
    fn single_exchanges_find_the_same_set_as_full_ones() {
        let mut seed = 5_u64;
        let mut random = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
        };
        let mut n_single = 0;
        for n in [2, 5, 9, 14] {
            for _ in 0..30 {
                let v = Mat::from_fn(n, n + 2, |_, _| random());
                let compliance = &v * v.transpose();
                let gaps: Vec<f64> = (0..n).map(|_| random()).collect();
                let problem = Problem { compliance: &compliance, springs: &vec![0.0; n], gaps: &gaps };
                let (mut full, mut single) = (vec![0.0; n], vec![0.0; n]);
                ActiveSet::new(n).solve(&problem, &mut full).unwrap();
                let mut solver = ActiveSet { patience: 0, ..ActiveSet::new(n) };
                n_single += solver.solve(&problem, &mut single).unwrap().fallbacks;
                // The same set gives the same bits.
                assert_eq!(full, single);
            }
        }
        assert!(n_single > 100, "single exchanges must have run");
    }

    /// Springs of a thousandth of what the points yield, and gaps that let few of them go and come back, as those
    /// of a flat face do: the sets are those of solvers that factorise each one, the forces equal to round-off.
    #[test]
    fn sets_that_change_little_are_solved_by_an_inverse() {
        let n = 480;
        let away = |i: usize, j: usize| (i as f64 - j as f64).abs();
        let compliance = Mat::from_fn(n, n, |i, j| 1.0 / (1.0 + away(i, j)));
        let springs = vec![0.3; n];
        let (mut solver, mut forces, mut expected) = (ActiveSet::new(n), vec![0.0; n], vec![0.0; n]);
        let mut n_by_inverse = 0;
        for step in 0..20 {
            // A part that lifts off grows and shrinks; one point is out of reach.
            let lifted = 10 * (10 - usize::abs_diff(step, 10));
            let gap = |i: usize| if i < lifted { 0.5 } else { -1.0 - 0.1 * (0.3 * (i + step) as f64).sin() };
            let gaps: Vec<f64> = (0..n).map(|i| if i == n - 1 { OPEN } else { gap(i) }).collect();
            let problem = Problem { compliance: &compliance, springs: &springs, gaps: &gaps };
            solver.solve(&problem, &mut forces).unwrap();
            let mut fresh = ActiveSet::new(n);
            fresh.solve(&problem, &mut expected).unwrap();
            assert_eq!(solver.active(), fresh.active());
            let largest = expected.iter().fold(0.0, |a: f64, b| a.max(*b));
            // Condition of some hundred, sums of five hundred terms.
            assert!(forces.iter().zip(&expected).all(|(a, b)| (a - b).abs() < 1e-11 * largest));
            let [mut u, mut product] = [(); 2].map(|()| vec![0.0; n]);
            solver.displacements(&problem, &forces, &mut u);
            add_product(&compliance, &expected, &mut product);
            let farthest = product.iter().fold(0.0, |a: f64, b| a.max(*b));
            // All points, in the set and open, by factor and inverse, and the one that nothing can press.
            assert!(u.iter().zip(&product).all(|(a, b)| (a - b).abs() < 1e-11 * farthest));
            let [mut x, mut y] = [(); 2].map(|()| (0..n).map(|i| (i as f64).cos()).collect::<Vec<_>>());
            solver.solve_on_set(&mut x);
            fresh.solve_on_set(&mut y);
            assert!(x.iter().zip(&y).all(|(a, b)| (a - b).abs() < 1e-11));
            n_by_inverse += usize::from(solver.is_by_inverse);
            if step == 14 {
                // Another matrix: the inverse has paid, and is made anew.
                solver.invalidate();
            }
        }
        assert!(n_by_inverse > 12, "{n_by_inverse} of 20 sets");
        // Open all over: nothing of the solution before is left.
        let gaps = vec![1.0; n];
        let problem = Problem { compliance: &compliance, springs: &springs, gaps: &gaps };
        solver.solve(&problem, &mut forces).unwrap();
        solver.displacements(&problem, &forces, &mut expected);
        assert_eq!(expected, vec![0.0; n]);
    }
}
