//! The active-set solver against optimality conditions, brute force and limits.

use crate::common::{Random, parabola, surface_compliance};
use contact_qs::quasistatic::{ActiveSet, Problem};
use faer::Mat;
use faer::linalg::solvers::Solve;
use ffr_dynamics::error::FailureKind;
use proptest::prelude::*;

/// Solves and returns forces and deformed gaps.
fn solve(problem: &Problem<'_>) -> (Vec<f64>, Vec<f64>) {
    let n = problem.n_points();
    let (mut forces, mut gaps) = (vec![0.0; n], vec![0.0; n]);
    ActiveSet::new(n).solve(problem, &mut forces).unwrap();
    problem.deformed_gaps(&forces, &mut gaps);
    (forces, gaps)
}

/// How far forces are from the optimality conditions (Eq. C.6).
#[derive(Debug, Clone, Copy, Default, PartialEq)]
struct KktResidual {
    /// Largest violation of `g + Dλ >= 0` \[m\].
    gap: f64,
    /// Largest tension `-λ_i` \[N\].
    tension: f64,
    /// Largest `|λ_i (g + Dλ)_i|` \[J\].
    complementarity: f64,
}

/// Distance of `forces`, whose deformed gaps are `deformed`, from the optimality conditions.
fn kkt_residual(problem: &Problem<'_>, forces: &[f64], deformed: &[f64]) -> KktResidual {
    let mut residual = KktResidual::default();
    for (i, &force) in forces.iter().enumerate() {
        let slack = deformed[i] + problem.springs[i] * force;
        residual.gap = residual.gap.max(-slack);
        residual.tension = residual.tension.max(-force);
        residual.complementarity = residual.complementarity.max((force * slack).abs());
    }
    residual
}

/// Best of all `2^n` sets.
fn brute_force(problem: &Problem<'_>) -> Vec<f64> {
    let n = problem.n_points();
    for set in 0..1_u32 << n {
        let members: Vec<usize> = (0..n).filter(|i| set >> i & 1 == 1).collect();
        let m = members.len();
        let matrix = Mat::from_fn(m, m, |i, j| {
            problem.compliance[(members[i], members[j])]
                + if i == j { problem.springs[members[i]] } else { 0.0 }
        });
        let rhs = Mat::from_fn(m, 1, |i, _| -problem.gaps[members[i]]);
        let solution = matrix.partial_piv_lu().solve(&rhs);
        let mut forces = vec![0.0; n];
        members.iter().enumerate().for_each(|(k, &i)| forces[i] = solution[(k, 0)]);
        let mut gaps = vec![0.0; n];
        problem.deformed_gaps(&forces, &mut gaps);
        let residual = kkt_residual(problem, &forces, &gaps);
        // Random sets are separated by far more than round-off.
        if residual.gap < 1e-10 && residual.tension < 1e-10 {
            return forces;
        }
    }
    panic!("a strictly convex problem has a solution");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn random_problems_match_brute_force(
        n in 1_usize..7, seed in 0_u64..1_000_000, exact in any::<bool>(), shift in -1.0..1.0_f64
    ) {
        let mut random = Random::new(seed);
        let compliance = random.semidefinite(n, n + 3, 1.0);
        let springs: Vec<f64> = (0..n).map(|_| if exact { 0.0 } else { 0.1 + random.next().abs() }).collect();
        let gaps: Vec<f64> = (0..n).map(|_| random.next() + shift).collect();
        let problem = Problem { compliance: &compliance, springs: &springs, gaps: &gaps };
        let (forces, _) = solve(&problem);
        let expected = brute_force(&problem);
        let size = expected.iter().fold(1.0, |m: f64, f| m.max(f.abs()));
        for (a, b) in forces.iter().zip(&expected) {
            // Condition numbers of such Gram matrices stay below 1e5.
            prop_assert!((a - b).abs() < 1e-9 * size, "{:?} {:?}", forces, expected);
        }
    }

    #[test]
    fn optimality_conditions_hold_for_any_size_and_rank(
        n in 2_usize..60, seed in 0_u64..1_000_000, rank in 1_usize..40, stiffness in -2.0..4.0_f64
    ) {
        let mut random = Random::new(seed);
        // Fewer columns than points: only the springs make the problem strictly convex.
        let compliance = random.semidefinite(n, rank, 1.0);
        let springs = vec![10_f64.powf(-stiffness); n];
        let gaps: Vec<f64> = (0..n).map(|_| random.next()).collect();
        let problem = Problem { compliance: &compliance, springs: &springs, gaps: &gaps };
        let (forces, deformed) = solve(&problem);
        let residual = kkt_residual(&problem, &forces, &deformed);
        // Round-off of A λ: n eps |A| |λ|, sizes here up to 60, 40 and 1e4.
        prop_assert!(residual.gap < 1e-9 && residual.complementarity < 1e-5, "{:?}", residual);
        prop_assert!(residual.tension <= 0.0);
        // λ is the penalty force at the deformed gap, w c_p <-g>.
        for ((force, gap), spring) in forces.iter().zip(&deformed).zip(&springs) {
            prop_assert!((force * spring - (-gap).max(0.0)).abs() < 1e-9);
        }
    }
}

#[test]
fn exact_constraint_is_the_limit_of_the_penalty() {
    let n = 25;
    let compliance = surface_compliance(n, 1e-8);
    let gaps = parabola(n, 1e-6);
    let total = |spring: f64| {
        let springs = vec![spring; n];
        let (forces, gaps) = solve(&Problem { compliance: &compliance, springs: &springs, gaps: &gaps });
        (forces.iter().sum::<f64>(), gaps.iter().fold(0.0, |m: f64, g| m.max(-g)))
    };
    let (exact, penetration) = total(0.0);
    assert!(penetration < 1e-18, "{penetration}"); // round-off of gaps of 1e-6
    let errors: Vec<f64> = [1e-11, 1e-12, 1e-13].iter().map(|&s| (total(s).0 / exact - 1.0).abs()).collect();
    // First order in the spring compliance.
    for pair in errors.windows(2) {
        assert!((pair[0] / pair[1]).log10() > 0.9, "{errors:?}");
    }
    assert!(errors[2] < 1e-4);
}

#[test]
fn energies_sum_to_half_the_work_of_the_gaps() {
    let n = 12;
    let compliance = surface_compliance(n, 1e-8);
    let (springs, gaps) = (vec![2e-9; n], parabola(n, 1e-6));
    let problem = Problem { compliance: &compliance, springs: &springs, gaps: &gaps };
    let (forces, deformed) = solve(&problem);
    let energies = problem.energies(&forces, &deformed);
    let work: f64 = -0.5 * forces.iter().zip(&gaps).map(|(f, g)| f * g).sum::<f64>();
    assert!(energies.elastic > 0.0 && energies.penalty > 0.0);
    assert!((energies.elastic + energies.penalty - work).abs() < 1e-13 * work); // identity, round-off
}

#[test]
fn warm_start_needs_one_set_and_no_factorisation() {
    let n = 30;
    let compliance = surface_compliance(n, 1e-8);
    let springs = vec![1e-9; n];
    let mut solver = ActiveSet::new(n);
    let mut forces = vec![0.0; n];
    let gaps = parabola(n, 1e-6);
    let cold = solver
        .solve(&Problem { compliance: &compliance, springs: &springs, gaps: &gaps }, &mut forces)
        .unwrap();
    assert!(cold.iterations > 1, "the case must change the set");
    let nearby: Vec<f64> = gaps.iter().map(|g| g - 1e-12).collect();
    let problem = Problem { compliance: &compliance, springs: &springs, gaps: &nearby };
    let warm = solver.solve(&problem, &mut forces).unwrap();
    assert_eq!((warm.iterations, warm.factorisations), (1, 0));
    let mut cold_forces = vec![0.0; n];
    ActiveSet::new(n).solve(&problem, &mut cold_forces).unwrap();
    assert_eq!(forces, cold_forces, "a warm start must not change a bit of the result");
}

#[test]
fn restored_solver_repeats_bit_for_bit() {
    let n = 30;
    let compliance = surface_compliance(n, 1e-8);
    let springs = vec![1e-9; n];
    let run = |solver: &mut ActiveSet, depth: f64| {
        let (mut forces, gaps) = (vec![0.0; n], parabola(n, depth));
        let report = solver
            .solve(&Problem { compliance: &compliance, springs: &springs, gaps: &gaps }, &mut forces)
            .unwrap();
        (forces, report.iterations)
    };
    let mut solver = ActiveSet::new(n);
    run(&mut solver, 1e-6);
    solver.save();
    let set = solver.active().to_vec();
    let first = run(&mut solver, 1.1e-6);
    let parting = vec![1.0; n];
    let mut forces = vec![0.0; n];
    solver
        .solve(&Problem { compliance: &compliance, springs: &springs, gaps: &parting }, &mut forces)
        .unwrap();
    assert!(solver.active().iter().all(|a| !a), "the state must have changed");
    solver.restore();
    assert_eq!(solver.active(), set);
    assert_eq!(run(&mut solver, 1.1e-6), first);
}

#[test]
fn no_contact_gives_no_force_and_touching_points_do_not_cycle() {
    let compliance = surface_compliance(4, 1e-8);
    for gaps in [[1e-6; 4], [0.0; 4], [0.0, 1e-6, 0.0, 1e-9]] {
        let (forces, _) = solve(&Problem { compliance: &compliance, springs: &[0.0; 4], gaps: &gaps });
        assert_eq!(forces, [0.0; 4]);
    }
    // The second point is just touched by the deformation of the first: λ and g are both round-off.
    let gaps = [-1e-6, -0.5e-6, 1.0, 1.0];
    let (forces, _) = solve(&Problem { compliance: &compliance, springs: &[0.0; 4], gaps: &gaps });
    assert!((forces[0] - 100.0).abs() < 1e-10 && forces[1].abs() < 1e-10);
}

#[test]
fn dependent_points_without_springs_are_rejected_with_code_1() {
    let n = 10;
    let compliance = Random::new(7).semidefinite(n, 4, 1e-8);
    let gaps = vec![-1e-6; n];
    let mut forces = vec![0.0; n];
    let mut solver = ActiveSet::new(n);
    let exact = Problem { compliance: &compliance, springs: &vec![0.0; n], gaps: &gaps };
    assert_eq!(solver.solve(&exact, &mut forces).unwrap_err().kind(), FailureKind::Singular);
    // With springs the same points are no problem, and the solver is as good as new.
    let springs = vec![1e-10; n];
    solver.invalidate();
    solver.solve(&Problem { springs: &springs, ..exact }, &mut forces).unwrap();
    assert!(forces.iter().sum::<f64>() > 0.0);
}

#[test]
fn values_that_are_not_finite_are_rejected_with_code_2() {
    let compliance = surface_compliance(2, 1e-8);
    let mut forces = [0.0; 2];
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let problem = Problem { compliance: &compliance, springs: &[0.0; 2], gaps: &[-1e-6, bad] };
        assert_eq!(
            ActiveSet::new(2).solve(&problem, &mut forces).unwrap_err().kind(),
            FailureKind::NotFinite
        );
    }
}
