//! Random zones and the classical return mapping.

use super::*;
use crate::quasistatic::problem::add_product;
use faer::Mat;

/// `w = (A_TT + D_T) τ + c`.
fn slip_increments(
    problem: &TangentialProblem<'_>,
    compliance: &Mat<f64>,
    forces: &[f64],
    n_t: usize,
    out: &mut [f64],
) {
    out.copy_from_slice(problem.slips);
    add_product(compliance, forces, out);
    for (k, w) in out.iter_mut().enumerate() {
        *w += problem.springs[k / n_t] * forces[k];
    }
}

/// Points `0..n` with the compliance `A_TT`.
fn blocks(compliance: &Mat<f64>, n_t: usize) -> Blocks {
    let n = compliance.nrows() / n_t;
    let mut blocks = Blocks::new(n, n_t, true);
    (0..n).for_each(|i| {
        blocks.members.add(i);
    });
    for (row, column) in (0..n * n_t).flat_map(|i| (0..=i).map(move |j| (i, j))) {
        blocks.set_tangential(
            (row / n_t, row % n_t),
            (column / n_t, column % n_t),
            compliance[(row, column)],
        );
    }
    blocks
}

fn random(seed: &mut u64) -> f64 {
    *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*seed >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
}

/// Points that are more than the displacements of their surface, as Gauss points of a mesh, with soft
/// springs and uneven bounds: exchanges alone went round for hundreds of steps.
#[test]
fn more_points_than_displacements_settle_soon() {
    let (mut seed, mut most) = (5, 0);
    for (n, n_t) in [(60, 2), (90, 2), (90, 1)] {
        for _ in 0..20 {
            let size = n * n_t;
            let v = Mat::from_fn(size, size / 2, |_, _| random(&mut seed));
            let compliance = &v * v.transpose();
            let springs = vec![1e-3; n];
            let slips: Vec<f64> =
                (0..size).map(|k| 2.0 + random(&mut seed) - f64::from(k as u32 % 2)).collect();
            let bounds: Vec<f64> = (0..n).map(|_| 0.05 * random(&mut seed).abs()).collect();
            let problem = TangentialProblem {
                compliance: &blocks(&compliance, n_t),
                springs: &springs,
                slips: &slips,
                bounds: &bounds,
            };
            let mut forces = vec![0.0; size];
            let mut solver = Tangential::new(n, n_t);
            most = most.max(solver.solve(&problem, 1e-12, &mut forces).unwrap());
            let mut w = vec![0.0; size];
            slip_increments(&problem, &compliance, &forces, n_t, &mut w);
            for (i, bound) in bounds.iter().enumerate() {
                let (f, w) = (pair(&forces, i, n_t), pair(&w, i, n_t));
                let (force, slip) = (f[0].hypot(f[1]), w[0].hypot(w[1]));
                // Round-off of the factorisation, of condition 1e5.
                assert!(
                    force <= bound * (1.0 + 1e-9) && slip * (bound - force) <= 1e-9,
                    "{force} {bound} {slip}"
                );
                assert!(f[0] * w[0] + f[1] * w[1] + force * slip <= 1e-9, "{f:?} {w:?}");
            }
        }
    }
    assert!(most <= 150, "{most}");
}

/// Points of a large zone whose states change little by little: an inverse for all of them makes the same steps as factors of each set.
/// (Forces at the end tell nothing, for Newton's method mends what a wrong matrix does.)
#[test]
fn inverses_of_large_zones_make_the_steps_of_their_factors() {
    for (n_t, n) in [(1, 400), (2, 200)] {
        let (mut seed, size) = (3, n * n_t);
        let v = Mat::from_fn(size, size + 2, |_, _| random(&mut seed));
        let matrix = &v * v.transpose();
        let compliance = blocks(&matrix, n_t);
        let (springs, mut bounds) = (vec![0.1; n], vec![0.0; n]);
        let (mut solver, mut forces) = (Tangential::new(n, n_t), vec![0.0; size]);
        let (mut n_mixed, mut n_served) = (0, 0);
        for step in 0..12 {
            let phase = |k: usize| (0.37 * k as f64 + 0.02 * f64::from(step)).sin();
            let slips: Vec<f64> = (0..size).map(|k| 4.0 * phase(k)).collect();
            // Points open as well.
            let shape = |i: usize| (1.1 * i as f64).sin() + 0.8 - 0.03 * f64::from(step);
            bounds.iter_mut().enumerate().for_each(|(i, b)| *b = 0.6 * shape(i).max(0.0));
            let problem = TangentialProblem {
                compliance: &compliance,
                springs: &springs,
                slips: &slips,
                bounds: &bounds,
            };
            solver.solve(&problem, 1e-12, &mut forces).unwrap();
            // A step from the sets that were found.
            solver.prepare_rates(&problem).unwrap();
            solver.solve_free(&slips);
            let expected = solver.solution[..solver.free.len()].to_vec();
            if solver.solve_by_inverse(&problem, &slips) {
                let size = |sizes: &[f64]| sizes.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
                let off: Vec<f64> = solver.solution.iter().zip(&expected).map(|(a, b)| a - b).collect();
                // Condition of some 1e4.
                assert!(size(&off) < 1e-9 * size(&expected), "{n_t} {step}: {}", size(&off));
                n_served += 1;
            }
            n_mixed += usize::from(
                [PointState::Stick, PointState::Slip].iter().all(|s| solver.states().contains(s)),
            );
        }
        assert!(n_mixed > 8 && n_served > 8, "{n_t}: {n_mixed} {n_served}");
        solver.save();
        assert!(!solver.inverse.has_served());
    }
}

#[test]
fn random_zones_obey_coulombs_law_and_need_few_sets() {
    let (mut seed, mut most, mut n_stick, mut n_slip) = (9, 0, 0, 0);
    for (n, n_t) in [(2, 1), (9, 1), (30, 1), (2, 2), (9, 2), (30, 2)] {
        for case in 0..60 {
            let size = n * n_t;
            // Condition of some 1e2 to 1e4, as on a surface.
            let v = Mat::from_fn(size, size + 2, |_, _| random(&mut seed));
            let compliance = &v * v.transpose();
            let springs: Vec<f64> = (0..n).map(|_| if case % 2 == 0 { 0.0 } else { 0.1 }).collect();
            let slips: Vec<f64> = (0..size).map(|_| 3.0 * random(&mut seed)).collect();
            let bounds: Vec<f64> = (0..n).map(|_| random(&mut seed).max(0.0)).collect();
            let problem = TangentialProblem {
                compliance: &blocks(&compliance, n_t),
                springs: &springs,
                slips: &slips,
                bounds: &bounds,
            };
            let mut solver = Tangential::new(n, n_t);
            let mut forces = vec![0.0; size];
            most = most.max(solver.solve(&problem, 1e-12, &mut forces).unwrap());
            let mut w = vec![0.0; size];
            slip_increments(&problem, &compliance, &forces, n_t, &mut w);
            // Newton's last step of 1e-8 leaves 1e-16; round-off of the factorisation.
            let tolerance = 1e-9;
            for (i, &bound) in bounds.iter().enumerate() {
                let (f, w) = (pair(&forces, i, n_t), pair(&w, i, n_t));
                let (force, slip) = (f[0].hypot(f[1]), w[0].hypot(w[1]));
                match solver.states()[i] {
                    PointState::Open => assert!(force <= 0.0 && bound <= 0.0),
                    PointState::Stick => {
                        n_stick += 1;
                        assert!(slip < tolerance && force <= bound * (1.0 + 1e-12), "{n} {n_t} {case}");
                    }
                    PointState::Slip => {
                        n_slip += 1;
                        assert!((force - bound).abs() < 1e-12);
                        // Slip against the force, in direction too.
                        let power = f[0] * w[0] + f[1] * w[1];
                        assert!((power + force * slip).abs() < tolerance * (1.0 + slip), "{n} {n_t} {case}");
                    }
                }
            }
        }
    }
    assert!(n_stick > 100 && n_slip > 100 && most < 60, "{n_stick} {n_slip} {most}");
}

#[test]
fn one_point_follows_the_classical_return_mapping() {
    let compliance = Mat::zeros(2, 2);
    let problem = TangentialProblem {
        compliance: &blocks(&compliance, 2),
        springs: &[0.5],
        slips: &[3.0, -4.0],
        bounds: &[2.0],
    };
    let (mut coupled, mut alone) = ([0.0; 2], [0.0; 2]);
    Tangential::new(1, 2).solve(&problem, 1e-12, &mut coupled).unwrap();
    Tangential::new(1, 2).return_to_bounds(&problem, &mut alone).unwrap();
    for (force, expected) in [coupled, alone].iter().zip([[-1.2, 1.6]; 2]) {
        assert!(force.iter().zip(expected).all(|(f, e)| (f - e).abs() < 1e-15)); // round-off
    }
}

#[test]
fn a_point_that_yields_to_no_force_is_held_by_none() {
    // The first point, as one on an axis of symmetry, alone and beside two others that stick.
    for n in [1, 3] {
        let entry = |i: usize, j: usize| if i.min(j) == 0 { 0.0 } else { 1.0 + f64::from(u8::from(i == j)) };
        let compliance = Mat::from_fn(n, n, entry);
        let problem = TangentialProblem {
            compliance: &blocks(&compliance, 1),
            springs: &[0.0; 3][..n],
            slips: &[0.0, 0.5, -0.5][..n],
            bounds: &[1.0; 3][..n],
        };
        let mut forces = vec![0.0; n];
        Tangential::new(n, 1).solve(&problem, 1e-12, &mut forces).unwrap();
        // Twice the force less once its opposite: that of a compliance of one.
        let right =
            forces.iter().zip([0.0, -0.5, 0.5]).all(|(force, expected)| (force - expected).abs() < 1e-15);
        assert!(right, "{forces:?}");
    }
}
