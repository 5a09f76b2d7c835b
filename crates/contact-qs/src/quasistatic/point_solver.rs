//! The solver of a zone's normal problem, as chosen by settings.

use faer::Mat;
use ffr_dynamics::error::EvaluationFailure;

use super::active_set::{ActiveSet, SolveReport};
use super::problem::{Problem, add_product};
use crate::quasistatic::broyden::{Broyden, BroydenSettings, ModalProblem};

/// Which solver finds the point forces.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Method {
    /// Active-set solver; the default.
    #[default]
    ActiveSet,
    /// Algorithm 1 of \[A\]; needs a finite penalty factor.
    Broyden(BroydenSettings),
}

/// Solver of the point forces with its state.
pub(crate) enum PointSolver {
    ActiveSet(Box<ActiveSet>),
    Broyden(Box<Modal>),
}

/// Algorithm 1 with the modes of the compliance.
pub(crate) struct Modal {
    solver: Broyden,
    stiffness: Vec<f64>,
    normal_shapes: Mat<f64>,
}

impl PointSolver {
    pub fn active_set(n_points: usize) -> Self {
        Self::ActiveSet(Box::new(ActiveSet::new(n_points)))
    }

    /// Algorithm 1 with modes of stiffness `stiffness`, whose shapes along the normal are to be
    /// set.
    pub fn broyden(settings: BroydenSettings, n_points: usize, stiffness: Vec<f64>) -> Self {
        let n = stiffness.len();
        let (solver, normal_shapes) = (Broyden::new(settings, n_points, n), Mat::zeros(n_points, n));
        Self::Broyden(Box::new(Modal { solver, stiffness, normal_shapes }))
    }

    /// Whether finite penalty factors are needed.
    pub fn needs_springs(&self) -> bool {
        matches!(self, Self::Broyden(_))
    }

    /// Normal displacements of the points in each mode, to be changed, `n_points × n_modes`; none
    /// for the active-set solver.
    pub fn normal_shapes(&mut self) -> Option<&mut Mat<f64>> {
        match self {
            Self::ActiveSet(_) => None,
            Self::Broyden(modal) => Some(&mut modal.normal_shapes),
        }
    }

    /// To be called when the compliance or the springs have changed.
    pub fn invalidate(&mut self) {
        if let Self::ActiveSet(solver) = self {
            solver.invalidate();
        }
    }

    /// Solves for the point forces `forces` of a zone with normal compliance `compliance`, of which
    /// Algorithm 1 has the modes.
    pub fn solve(
        &mut self,
        compliance: &Mat<f64>,
        springs: &[f64],
        gaps: &[f64],
        forces: &mut [f64],
    ) -> Result<SolveReport, EvaluationFailure> {
        match self {
            Self::ActiveSet(solver) => solver.solve(&Problem { compliance, springs, gaps }, forces),
            Self::Broyden(modal) => {
                let Modal { solver, stiffness, normal_shapes: shapes } = modal.as_mut();
                solver.solve(&ModalProblem { shapes, stiffness, springs, gaps }, forces)
            }
        }
    }

    /// Replaces `out` by the displacements of the points under `forces`, found by the last solution of `problem`.
    pub fn displacements(&self, problem: &Problem<'_>, forces: &[f64], out: &mut [f64]) {
        match self {
            Self::ActiveSet(solver) => solver.displacements(problem, forces, out),
            Self::Broyden(_) => {
                out.fill(0.0);
                add_product(problem.compliance, forces, out);
            }
        }
    }

    /// Replaces `rhs`, one value per point, by the solution of `(A_aa + D_aa) x_a = rhs_a` on the
    /// last active set, zero outside it; false if the solver is not the active-set solver.
    pub fn solve_on_set(&mut self, rhs: &mut [f64]) -> bool {
        let Self::ActiveSet(solver) = self else { return false };
        solver.solve_on_set(rhs);
        true
    }

    pub fn save(&mut self) {
        match self {
            Self::ActiveSet(solver) => solver.save(),
            Self::Broyden(modal) => modal.solver.save(),
        }
    }

    pub fn restore(&mut self) {
        match self {
            Self::ActiveSet(solver) => solver.restore(),
            Self::Broyden(modal) => modal.solver.restore(),
        }
    }
}
