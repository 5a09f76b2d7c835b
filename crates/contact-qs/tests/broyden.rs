//! Algorithm 1 of [A]: agreement with the active set, error codes, carried state.

use crate::common::{Random, parabola, surface_compliance};
use contact_qs::quasistatic::broyden::ModalProblem;
use contact_qs::quasistatic::broyden::{Broyden, BroydenSettings};
use contact_qs::quasistatic::modal_basis::ModalBasis;
use contact_qs::quasistatic::{ActiveSet, Problem, SolveReport};
use faer::Mat;
use ffr_dynamics::error::EvaluationFailure;
use ffr_dynamics::error::FailureKind;

const N: usize = 14;

struct Case {
    compliance: Mat<f64>,
    basis: ModalBasis,
    springs: Vec<f64>,
}

impl Case {
    fn new(spring: f64) -> Self {
        let compliance = surface_compliance(N, 1e-8);
        let basis = ModalBasis::from_compliance(&compliance).unwrap();
        Self { compliance, basis, springs: vec![spring; N] }
    }

    fn solver(&self, settings: BroydenSettings) -> Broyden {
        Broyden::new(settings, N, self.basis.n_coordinates())
    }

    fn broyden(
        &self,
        solver: &mut Broyden,
        gaps: &[f64],
    ) -> Result<(Vec<f64>, SolveReport), EvaluationFailure> {
        let mut forces = vec![0.0; N];
        let ModalBasis { shapes, stiffness } = &self.basis;
        let report =
            solver.solve(&ModalProblem { shapes, stiffness, springs: &self.springs, gaps }, &mut forces)?;
        Ok((forces, report))
    }

    fn active_set(&self, gaps: &[f64]) -> Vec<f64> {
        let mut forces = vec![0.0; N];
        let problem = Problem { compliance: &self.compliance, springs: &self.springs, gaps };
        ActiveSet::new(N).solve(&problem, &mut forces).unwrap();
        forces
    }
}

fn largest_difference(a: &[f64], b: &[f64]) -> f64 {
    let size = b.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    a.iter().zip(b).fold(0.0, |m: f64, (x, y)| m.max((x - y).abs())) / size
}

#[test]
fn both_solvers_agree_over_a_whole_approach() {
    // Penalty springs 0.1, 1 and 10 times as soft as the surface.
    for spring in [1e-9, 1e-8, 1e-7] {
        let case = Case::new(spring);
        // ε tightened so that the difference shows the equations, not the stopping rule: q is about 1e-6 m here.
        let mut solver = case.solver(BroydenSettings { tolerance: 1e-19, ..BroydenSettings::default() });
        for step in 1..=40 {
            let depth = 1e-6 * (std::f64::consts::PI * f64::from(step) / 41.0).sin();
            let gaps = parabola(N, depth);
            let (forces, report) = case.broyden(&mut solver, &gaps).unwrap();
            assert!(!report.hit_iteration_limit, "{spring} {step}");
            let difference = largest_difference(&forces, &case.active_set(&gaps));
            assert!(difference < 1e-10, "{spring} {step}: {difference}");
        }
    }
}

#[test]
fn one_jacobian_serves_many_calls() {
    let case = Case::new(1e-8);
    let mut solver = case.solver(BroydenSettings::default());
    let gaps = parabola(N, 1e-6);
    let (_, first) = case.broyden(&mut solver, &gaps).unwrap();
    assert_eq!(first.factorisations, 1, "the first call has no Jacobian and computes one");
    let mut jacobians = 0;
    for step in 1..=30 {
        // The set stays: Broyden needs no new Jacobian, for k_jac restarts at 0 in every call (line 35).
        let gaps = parabola(N, 1e-6 * (1.0 + 1e-4 * f64::from(step)));
        let (_, report) = case.broyden(&mut solver, &gaps).unwrap();
        jacobians += report.factorisations;
    }
    assert_eq!(jacobians, 0);
}

#[test]
fn modes_and_compliance_give_the_same_forces() {
    let case = Case::new(5e-9);
    // Another basis of the same compliance: any Φ Q with K -> Qᵀ K Q diagonal; here scaled as mass-orthonormal modes are.
    let mut random = Random::new(3);
    let scales: Vec<f64> = (0..case.basis.n_coordinates()).map(|_| 50.0 * (1.5 + random.next())).collect();
    let shapes = Mat::from_fn(N, scales.len(), |i, j| case.basis.shapes[(i, j)] * scales[j]);
    let omega_squared: Vec<f64> = case.basis.stiffness.iter().zip(&scales).map(|(k, s)| k * s * s).collect();
    let modal = Case {
        basis: ModalBasis::from_modes(shapes, &omega_squared).unwrap(),
        compliance: case.compliance.clone(),
        springs: case.springs.clone(),
    };
    let gaps = parabola(N, 1e-6);
    let settings = BroydenSettings { tolerance: 1e-19, ..BroydenSettings::default() };
    let (a, _) = case.broyden(&mut case.solver(settings), &gaps).unwrap();
    let settings = BroydenSettings { tolerance: 1e-21, ..settings }; // the coordinates are 25 to 125 times smaller
    let (b, _) = modal.broyden(&mut modal.solver(settings), &gaps).unwrap();
    assert!(largest_difference(&a, &b) < 1e-10);
}

#[test]
fn penalty_far_too_high_gives_code_1() {
    // Springs 1e13 times stiffer than the surface, beside coordinates that the points in contact do not feel.
    let case = Case::new(1e-21);
    let mut solver = case.solver(BroydenSettings::default());
    let error = case.broyden(&mut solver, &parabola(N, 1e-6)).unwrap_err();
    assert_eq!(error.kind(), FailureKind::Singular, "{error}");
    // With a sensible factor the same solver recovers by its reset.
    let sensible = Case::new(1e-8);
    let gaps = parabola(N, 1e-6);
    let (forces, _) = sensible.broyden(&mut solver, &gaps).unwrap();
    // ε = 1e-15 m of 1e-6 m.
    assert!(largest_difference(&forces, &sensible.active_set(&gaps)) < 1e-8);
}

#[test]
fn jacobian_that_is_not_finite_gives_code_2() {
    let case = Case::new(1e-320); // forces overflow
    let mut solver = case.solver(BroydenSettings::default());
    assert_eq!(case.broyden(&mut solver, &parabola(N, 1e-6)).unwrap_err().kind(), FailureKind::NotFinite);
    let gaps = [f64::NAN; N];
    assert_eq!(case.broyden(&mut solver, &gaps).unwrap_err().kind(), FailureKind::NotFinite);
}

#[test]
fn iteration_limit_gives_code_minus_1_after_one_reset_and_is_no_error() {
    let case = Case::new(1e-8);
    // No step is ever below zero.
    let mut solver = case.solver(BroydenSettings { tolerance: 0.0, ..BroydenSettings::default() });
    let gaps = parabola(N, 1e-6);
    let (forces, report) = case.broyden(&mut solver, &gaps).unwrap();
    assert_eq!((report.hit_iteration_limit, report.iterations, report.fallbacks), (true, 90, 1));
    // First call: passes 1, 16, 31; after the reset the same again (lines 4 to 8 with k_jac = 15).
    assert_eq!(report.factorisations, 6);
    assert!(largest_difference(&forces, &case.active_set(&gaps)) < 1e-10);
}

#[test]
fn state_that_still_changes_at_the_iteration_limit_is_rejected_with_code_minus_1() {
    let case = Case::new(1e-8);
    // The parabola needs some ten steps from zero, for points open on the way.
    let mut solver = case.solver(BroydenSettings { max_steps: 3, ..BroydenSettings::default() });
    let gaps = parabola(N, 1e-6);
    solver.save();
    let error = case.broyden(&mut solver, &gaps).unwrap_err();
    assert_eq!(error.kind(), FailureKind::IterationLimit, "{error}");
    assert!(error.to_string().contains("not converged"), "{error}");
    // A saved state leads on, as the integrator needs it.
    solver.restore();
    assert_eq!(case.broyden(&mut solver, &[1e-9; N]).unwrap().0, vec![0.0; N]);
}

#[test]
fn new_jacobians_come_in_passes_16_and_31_when_one_is_carried_over() {
    let case = Case::new(1e-8);
    let mut solver = case.solver(BroydenSettings { tolerance: 0.0, ..BroydenSettings::default() });
    let gaps = parabola(N, 1e-6);
    case.broyden(&mut solver, &gaps).unwrap();
    let (_, report) = case.broyden(&mut solver, &gaps).unwrap();
    // Trial 1 starts with k_jac = 0: passes 16 and 31; trial 2 with k_jac = 15: passes 1, 16 and 31.
    assert_eq!((report.iterations, report.factorisations), (90, 5));
}

#[test]
fn no_penetration_leaves_the_jacobian_and_clears_the_coordinates() {
    let case = Case::new(1e-8);
    let mut solver = case.solver(BroydenSettings::default());
    let gaps = parabola(N, 1e-6);
    case.broyden(&mut solver, &gaps).unwrap();
    assert!(solver.coordinates().iter().any(|&q| q != 0.0));
    let (forces, report) = case.broyden(&mut solver, &[1e-9; N]).unwrap();
    assert_eq!((forces, report.iterations), (vec![0.0; N], 0));
    assert!(solver.coordinates().iter().all(|&q| q == 0.0));
    assert_eq!(case.broyden(&mut solver, &gaps).unwrap().1.factorisations, 0);
}

#[test]
fn restored_solver_repeats_bit_for_bit() {
    let case = Case::new(1e-8);
    let mut solver = case.solver(BroydenSettings::default());
    case.broyden(&mut solver, &parabola(N, 1e-6)).unwrap();
    solver.save();
    let next = parabola(N, 1.2e-6);
    let first = case.broyden(&mut solver, &next).unwrap();
    assert_ne!(first, case.broyden(&mut solver, &next).unwrap(), "the state must have changed");
    solver.restore();
    assert_eq!(first, case.broyden(&mut solver, &next).unwrap());
}
