//! Algorithm 1 of \[A\]: Newton's method with Broyden updates for `f_qs(q) = q - K⁻¹ h(q) = 0`.
//!
//! `h = Φᵀλ`, `λ_i = <-(g⁰ + Φq)_i> / D_i` (docs/theory.md Eq. C.11): the penalty forces at the
//! displaced points. The code follows the listing line by line; what the listing leaves open is
//! settled so:
//!
//! * **First call.** There is no Jacobian yet: `k_jac` starts at `k_jac^max`, so that line 5
//!   computes one.
//! * **`error`** is never set to zero in the listing. It is zero at the start and becomes zero
//!   again in the reset of lines 23-26; otherwise the second trial could only return the error of
//!   the first.
//! * **Lines 10-14.** `rcond` of a matrix with a NaN is NaN and compares false, so that error 2 is
//!   reached through line 12; here a Jacobian with any entry that is not finite has `rcond` NaN. As
//!   in the listing, lines 15-17 run in spite of an error, and a step below `ε` ends the call
//!   successfully even then (a solution is a solution).
//! * **Line 16** divides by `|Δq|²`. When `Δq` is round-off of `q` the update would be noise over
//!   noise and is left out.
//! * **Line 15** solves with `J`, line 10 asks for its condition. The listing factorises it in
//!   every pass; here its inverse follows the update of line 16 by Sherman and Morrison's formula,
//!   which costs `n²` instead of `n³` operations, and is made anew from `J` after `MAX_UPDATES` and
//!   where the formula divides by little. `rcond` of an updated matrix is exact, not estimated.
//! * **Line 20** can be reached twice; the second time line 30 ends the call "successfully" with
//!   whatever state was reached. Where the listing jumps to and fro between two sets of touching
//!   points that state is up to a quarter beside the solution. So it is taken, with a mark in the
//!   report, only if the last step was within `√eps` of the coordinates; otherwise the call fails
//!   at its iteration limit, and the integrator tries a shorter step from the last Jacobian.
//! * **Line 28** leaves before line 35, `k_jac` stays; the caller restores a saved state or stops.
//! * **Line 35** sets `k_jac = 0`, so that the next call starts with the Jacobian carried over and
//!   computes a new one only in its passes 16 and 31, or after a reset. Without contact changes one
//!   Jacobian serves a whole impact.
//! * **No penetration at `q = 0`**: then `q = 0` solves the equation exactly. It is taken without
//!   running the listing, and the Jacobian is kept.
//!
//! **Finite differences.** \[A\] uses MATLAB's *odenumjac*, which adapts steps between `eps^(7/8)`
//! and `eps^(1/4)` of a typical value. `f_qs` is piecewise linear, so that steps have no truncation
//! error, only round-off and the risk to switch a point: the step of coordinate `j` moves the
//! surface by at most `eps^(1/4)` of the deepest penetration `P` at `q`,
//! `h_j = eps^(1/4) P / max_i |Φ_ij|` (Eq. C.13). With `eps^(1/2)` the round-off of the quotient,
//! 1e-8 of the largest entry, would hide any singularity from the test `rcond < 1e-10`.

pub mod conditioned_lu;
mod sherman_morrison;

use crate::solver_fault::SolverFault;
use faer::Mat;
use ffr_dynamics::error::{EvaluationFailure, FailureKind};

use crate::quasistatic::SolveReport;
use crate::quasistatic::problem::{add_product, depth};
use conditioned_lu::ConditionedLu;
use sherman_morrison::ShermanMorrisonInverse;

/// Updates of an inverse after which it is made anew: each adds round-off of some `n eps` of it.
const MAX_UPDATES: usize = 50;

/// Limits and tolerances of Algorithm 1, by default those of \[A\] section 3.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BroydenSettings {
    /// Uses of a Jacobian after which a new one is computed, `k_jac^max`.
    pub max_jacobian_uses: usize,
    /// Newton steps per trial, `k_max`.
    pub max_steps: usize,
    /// Largest change of a coordinate at convergence, `ε`, in the unit of the coordinates.
    pub tolerance: f64,
    /// Smallest reciprocal condition number.
    pub min_rcond: f64,
}

impl Default for BroydenSettings {
    fn default() -> Self {
        Self { max_jacobian_uses: 15, max_steps: 45, tolerance: 1e-15, min_rcond: 1e-10 }
    }
}

/// What a call hands to the next one: `q`, `J`, `k_jac`.
#[derive(Debug, Clone)]
struct Carried {
    coordinates: Vec<f64>,
    jacobian: ShermanMorrisonInverse,
    uses: usize,
}

impl Carried {
    fn copy_from(&mut self, other: &Self) {
        self.coordinates.copy_from_slice(&other.coordinates);
        self.jacobian.copy_from(&other.jacobian);
        self.uses = other.uses;
    }
}

/// Springs and gaps of the points with the shapes there: the data of `f_qs`.
#[derive(Debug, Clone, Copy)]
pub struct ModalProblem<'a> {
    /// Normal shapes of the coordinates at the points, `n_points × n_hf`.
    pub shapes: &'a Mat<f64>,
    /// Diagonal stiffness `K` of the coordinates, `n_hf`.
    pub stiffness: &'a [f64],
    /// Compliances `1/(c_p w_i)` of the penalty springs, positive [m/N].
    pub springs: &'a [f64],
    /// Gaps `g⁰` without quasistatic displacement \[m\].
    pub gaps: &'a [f64],
}

impl ModalProblem<'_> {
    /// Replaces `gaps` by `g⁰ + Φq` and `forces` by the penalty forces there.
    fn forces(&self, coordinates: &[f64], gaps: &mut [f64], forces: &mut [f64]) {
        gaps.copy_from_slice(self.gaps);
        add_product(self.shapes, coordinates, gaps);
        self.springs_forces(gaps, forces);
    }

    /// Penalty forces at gaps `gaps`.
    fn springs_forces(&self, gaps: &[f64], forces: &mut [f64]) {
        for ((force, gap), spring) in forces.iter_mut().zip(gaps).zip(self.springs) {
            *force = if *gap < 0.0 { -gap / spring } else { 0.0 };
        }
    }

    /// Coordinate `j` of `K⁻¹ Φᵀ forces`.
    fn pushed(&self, j: usize, forces: &[f64]) -> f64 {
        self.shapes.col_as_slice(j).iter().zip(forces).map(|(s, f)| s * f).sum::<f64>() / self.stiffness[j]
    }
}

/// Solver after Algorithm 1 of \[A\], for fixed numbers of points and coordinates.
pub struct Broyden {
    settings: BroydenSettings,
    carried: Carried,
    saved: Carried,
    lu: ConditionedLu,
    residual: Vec<f64>,
    step: Vec<f64>,
    gaps: Vec<f64>,
    shifted_gaps: Vec<f64>,
    shifted_forces: Vec<f64>,
}

impl Broyden {
    /// Solver for `n_points` points and `n_coordinates` coordinates, without a Jacobian yet.
    pub fn new(settings: BroydenSettings, n_points: usize, n_coordinates: usize) -> Self {
        let carried = Carried {
            coordinates: vec![0.0; n_coordinates],
            jacobian: ShermanMorrisonInverse::new(n_coordinates),
            uses: settings.max_jacobian_uses,
        };
        Self {
            settings,
            saved: carried.clone(),
            carried,
            lu: ConditionedLu::new(n_coordinates),
            residual: vec![0.0; n_coordinates],
            step: vec![0.0; n_coordinates],
            gaps: vec![0.0; n_points],
            shifted_gaps: vec![0.0; n_points],
            shifted_forces: vec![0.0; n_points],
        }
    }

    /// Quasistatic coordinates `q` of the last call.
    pub fn coordinates(&self) -> &[f64] {
        &self.carried.coordinates
    }

    /// Remembers coordinates, Jacobian and its counter.
    pub fn save(&mut self) {
        self.saved.copy_from(&self.carried);
    }

    /// Returns to the remembered coordinates, Jacobian and counter.
    pub fn restore(&mut self) {
        self.carried.copy_from(&self.saved);
    }

    /// Solves `problem` for `forces` \[N\].
    ///
    /// # Errors
    /// Singular: the Jacobian is, to `min_rcond`. Not finite: it, or a gap. Iteration limit: the
    /// steps are used up and the coordinates still change by more than `√eps` of them.
    ///
    /// # Panics
    /// If sizes differ from those given to [`Broyden::new`].
    pub fn solve(
        &mut self,
        problem: &ModalProblem<'_>,
        forces: &mut [f64],
    ) -> Result<SolveReport, EvaluationFailure> {
        let (n_points, n) = (self.gaps.len(), self.carried.coordinates.len());
        assert!(
            problem.shapes.nrows() == n_points && problem.shapes.ncols() == n && problem.stiffness.len() == n,
            "modal contact problem of {} x {} for a solver of {n_points} x {n}",
            problem.shapes.nrows(),
            problem.shapes.ncols()
        );
        let start = depth(problem.gaps);
        if start.is_nan() {
            return Err(SolverFault::NotFinite { value: "contact gap" }.into());
        }
        if start <= 0.0 {
            self.carried.coordinates.fill(0.0);
            forces.fill(0.0);
            return Ok(SolveReport::default());
        }
        self.run(problem, start, forces)
    }

    /// The listing; its line numbers stand in the comments.
    fn run(
        &mut self,
        problem: &ModalProblem<'_>,
        start: f64,
        forces: &mut [f64],
    ) -> Result<SolveReport, EvaluationFailure> {
        let mut report = SolveReport::default();
        let (mut k, mut may_reset, mut error) = (1, true, None); // lines 1 and 2
        self.evaluate(problem, forces);
        loop {
            report.iterations += 1;
            if self.carried.uses == self.settings.max_jacobian_uses {
                self.difference_jacobian(problem, start, forces); // line 5
                report.factorisations += 1;
                self.carried.uses = 1;
            } else {
                self.carried.uses += 1; // line 8
            }
            let rcond = self.carried.jacobian.condition(MAX_UPDATES, &mut self.lu);
            if rcond < self.settings.min_rcond {
                error = Some(FailureKind::Singular); // line 11
            } else if rcond.is_nan() {
                error = Some(FailureKind::NotFinite); // line 13
            }
            let change = self.newton_step(problem, forces, rcond.is_nan()); // lines 15 and 16
            if change < self.settings.tolerance {
                break; // line 18
            } else if k == self.settings.max_steps {
                error = Some(FailureKind::IterationLimit); // line 20
            }
            let Some(failure) = error else {
                k += 1; // line 32
                continue;
            };
            if may_reset {
                may_reset = false; // lines 23 to 26
                error = None;
                k = 1;
                self.carried.uses = self.settings.max_jacobian_uses;
                self.carried.coordinates.fill(0.0);
                self.evaluate(problem, forces);
                report.fallbacks += 1;
            } else if failure.is_critical() {
                return Err(critical(failure, rcond).into()); // line 28
            } else {
                let size = self.carried.coordinates.iter().fold(0.0_f64, |m, q| m.max(q.abs()));
                // Asked this way round, a NaN is no solution.
                let is_solution = change <= f64::EPSILON.sqrt() * size;
                if !is_solution {
                    return Err(SolverFault::Broyden { change: change / size }.into());
                }
                report.hit_iteration_limit = true; // line 30
                break;
            }
        }
        self.carried.uses = 0; // line 35
        Ok(report)
    }

    /// Forces and residual `f_qs` at the present coordinates.
    fn evaluate(&mut self, problem: &ModalProblem<'_>, forces: &mut [f64]) {
        problem.forces(&self.carried.coordinates, &mut self.gaps, forces);
        for (j, (r, q)) in self.residual.iter_mut().zip(&self.carried.coordinates).enumerate() {
            *r = q - problem.pushed(j, forces);
        }
    }

    /// Jacobian of `f_qs` by forward differences (Eq. C.13); `start`: deepest penetration at
    /// `q = 0`.
    fn difference_jacobian(&mut self, problem: &ModalProblem<'_>, start: f64, forces: &[f64]) {
        let n = self.residual.len();
        let jacobian = self.carried.jacobian.set();
        let relative = f64::EPSILON.powf(0.25);
        // Without penetration at q only round-off sets a scale: a trace of the starting depth.
        let scale = f64::max(depth(&self.gaps), f64::EPSILON.sqrt() * start);
        for j in 0..n {
            let shape = problem.shapes.col_as_slice(j);
            let column = &mut jacobian[j * n..(j + 1) * n];
            column.fill(0.0);
            column[j] = 1.0;
            let largest = shape.iter().fold(0.0, |m: f64, s| m.max(s.abs()));
            if largest == 0.0 {
                continue; // a coordinate that no point feels
            }
            let h = relative * scale / largest;
            for ((shifted, gap), s) in self.shifted_gaps.iter_mut().zip(&self.gaps).zip(shape) {
                *shifted = gap + h * s;
            }
            problem.springs_forces(&self.shifted_gaps, &mut self.shifted_forces);
            for (shifted, force) in self.shifted_forces.iter_mut().zip(forces) {
                *shifted -= force;
            }
            for (i, entry) in column.iter_mut().enumerate() {
                *entry -= problem.pushed(i, &self.shifted_forces) / h;
            }
        }
    }

    /// Newton step with Broyden's update (lines 15 and 16); returns the largest change of a
    /// coordinate.
    fn newton_step(&mut self, problem: &ModalProblem<'_>, forces: &mut [f64], not_finite: bool) -> f64 {
        if not_finite {
            return f64::NAN; // J⁻¹ f is not a number either
        }
        self.carried.jacobian.solve(&self.residual, &mut self.step);
        let (mut change, mut square, mut size) = (0.0_f64, 0.0, 0.0);
        for (q, s) in self.carried.coordinates.iter_mut().zip(&mut self.step) {
            *s = -*s;
            *q += *s;
            square += *s * *s;
            size += *q * *q;
            // max() would hide a NaN
            change = if s.abs() > change || s.is_nan() { s.abs() } else { change };
        }
        self.evaluate(problem, forces);
        // Good Broyden update (Eq. C.14): J += (Δf - J Δq) Δqᵀ / |Δq|², and J Δq = -f makes the
        // bracket the new residual.
        if square > f64::EPSILON * f64::EPSILON * size {
            self.carried.jacobian.update(1.0 / square, &self.residual, &self.step);
        }
        change
    }
}

/// The critical errors of Algorithm 1.
fn critical(failure: FailureKind, rcond: f64) -> SolverFault {
    match failure {
        FailureKind::Singular => SolverFault::BroydenSingular { rcond },
        _ => SolverFault::BroydenNotFinite,
    }
}
