//! Eigenmodes, rigid modes, ordering and factorisation on bodies assembled by hand.

use crate::common;
use std::f64::consts::PI;

use crate::common::{block, chain, cylinder, from_identity, gram, unknowns_at};
use crate::oracles::modal_truncation;
use faer::Mat;
use ffr_dynamics::DynamicsError;
use ffr_dynamics::body::AssembledBody;
use ffr_dynamics::reduction::ordering::elimination_order;
use ffr_dynamics::reduction::{ElasticProblem, Pencil, RigidModes, all_modes, neighbouring_counts};

/// Orthonormality after the clean-up: round-off of sums over a few thousand terms.
const ORTHONORMAL: f64 = 1e-12;
/// Dense and Lanczos path: eigenvalues agree to the square of the Lanczos residual, plus round-off of the stiffness
/// (highest over lowest eigenvalue about 1e5).
const SAME_FREQUENCY: f64 = 1e-10;

fn relative_difference(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| (x / y - 1.0).abs()).fold(0.0, f64::max)
}

fn check_mass_orthonormal(body: &AssembledBody, shapes: &Mat<f64>, rigid: &RigidModes) {
    let product = body.mass_product(shapes.as_ref());
    assert!(from_identity(&gram(shapes, &product)) < ORTHONORMAL);
    assert!(gram(&rigid.modes, &product).norm_max() < ORTHONORMAL);
}

#[test]
fn elimination_order_is_a_permutation_with_the_interface_last() {
    let body = block(2, [5, 4, 3], [1.0, 0.8, 0.5]);
    let interface = unknowns_at(&body, |p| p[2] > 0.249);
    let order = elimination_order(body.stiffness.symbolic(), &body.dofs, &body.anchors, &interface);
    let mut sorted = order.clone();
    sorted.sort_unstable();
    assert!(sorted.iter().enumerate().all(|(i, &u)| i == u as usize));
    assert!(order[order.len() - interface.len()..].iter().zip(&interface).all(|(&a, &b)| a as usize == b));
}

#[test]
fn nested_dissection_fills_less_than_the_natural_order_even_without_places() {
    let mut body = block(1, [40, 40, 0], [1.0, 1.0, 1.0]);
    let natural: Vec<u32> = (0..body.dofs.len() as u32).collect();
    let entries = |order| {
        ffr_dynamics::reduction::SymbolicFactor::new(body.stiffness.symbolic(), order, 0).unwrap().n_entries()
    };
    let unordered = entries(natural);
    let placed = entries(elimination_order(body.stiffness.symbolic(), &body.dofs, &body.anchors, &[]));
    body.anchors.fill([0.0; 3]);
    let levels = {
        let order = elimination_order(body.stiffness.symbolic(), &body.dofs, &body.anchors, &[]);
        ffr_dynamics::reduction::SymbolicFactor::new(body.stiffness.symbolic(), order, 0).unwrap().n_entries()
    };
    assert!(3 * placed < 2 * unordered, "{placed} of {unordered}");
    assert!(levels < unordered, "{levels} of {unordered}");
}

#[test]
fn dissection_does_not_depend_on_the_axes_of_the_body() {
    // A bar of 8 x 8 x 20 elements whose anchors lie at 45 degrees to all planes: no plane across an axis is a good cut.
    let mut body = block(2, [8, 8, 20], [1.0, 1.0, 2.5]);
    let entries = |body: &AssembledBody| {
        let order = elimination_order(body.stiffness.symbolic(), &body.dofs, &body.anchors, &[]);
        ffr_dynamics::reduction::SymbolicFactor::new(body.stiffness.symbolic(), order, 0).unwrap().n_entries()
    };
    let straight = entries(&body);
    let turn = nalgebra::Rotation3::from_euler_angles(0.0, 0.7, 0.7);
    for place in &mut body.anchors {
        *place = (turn * nalgebra::Vector3::from(*place)).into();
    }
    let turned = entries(&body);
    // Planes across the axes alone make half as many again; a third more is asked for.
    assert!(3 * turned < 4 * straight, "{turned} of {straight}");
}

#[test]
fn factor_solves_the_supported_stiffness() {
    let body = block(2, [4, 3, 3], [1.0, 0.8, 0.5]);
    let base = unknowns_at(&body, |p| p[2] < -0.249);
    let problem = ElasticProblem::clamped(Pencil::new(&body, &[]).unwrap(), &base).unwrap();
    let n = body.n_unknowns();
    // More columns than the workspace holds: the solve goes in parts.
    let force = Mat::from_fn(n, 45, |i, j| ((7 * i + 3 * j) % 11) as f64 - 5.0);
    let mut x = force.clone();
    problem.solve_held(x.as_mut());
    let back = body.stiffness_product(x.as_ref());
    let free = (0..n).filter(|i| !base.contains(i));
    for i in free {
        for j in 0..45 {
            // Forces of size 5; backward stable solve, condition number about 1e3.
            assert!((back[(i, j)] - force[(i, j)]).abs() < 1e-9);
        }
    }
}

#[test]
fn rigid_modes_are_mass_orthonormal_and_strain_nothing() {
    for body in [
        block(2, [4, 3, 3], [1.0, 0.8, 0.5]),
        block(3, [4, 3, 0], [1.0, 0.8, 0.0]),
        cylinder(2, [3, 6], 0.01, 0.04),
    ] {
        let rigid = RigidModes::new(&body).unwrap();
        assert_eq!(rigid.count(), body.motion.count());
        assert!(from_identity(&gram(&rigid.modes, &rigid.mass_modes)) < ORTHONORMAL);
        let energy = gram(&rigid.modes, &body.stiffness_product(rigid.modes.as_ref()));
        let first = modal_truncation(&body, 1).unwrap().omega[0].powi(2);
        assert!(energy.norm_max() < 1e-10 * first, "{:e}", energy.norm_max() / first);
    }
}

#[test]
fn mass_properties_of_box_and_cylinder_match_closed_forms() {
    // Polynomials of degree two are integrated exactly: round-off only.
    const EXACT: f64 = 1e-12;
    let (a, b, c) = (1.0, 0.8, 0.5);
    let properties = RigidModes::new(&block(2, [3, 2, 2], [a, b, c])).unwrap().mass_properties;
    let mass = common::DENSITY * a * b * c;
    assert!((properties.mass / mass - 1.0).abs() < EXACT);
    assert!((properties.inertia[2][2] / (mass * (a * a + b * b) / 12.0) - 1.0).abs() < EXACT);
    assert!(properties.inertia[0][1].abs() < EXACT * mass);

    let (r, l) = (0.01, 0.04);
    let properties = RigidModes::new(&cylinder(2, [2, 3], r, l)).unwrap().mass_properties;
    let mass = common::DENSITY * PI * r * r * l;
    assert!((properties.mass / mass - 1.0).abs() < EXACT);
    assert!((properties.centre[2] - 0.5 * l).abs() < EXACT * l);
    assert!((properties.inertia[2][2] / (0.5 * mass * r * r) - 1.0).abs() < EXACT);
    assert!((properties.inertia[0][0] / (mass * (r * r / 4.0 + l * l / 12.0)) - 1.0).abs() < EXACT);
}

#[test]
fn chain_frequencies_match_the_closed_form_on_both_paths() {
    let exact = |n: usize, j: usize| 2.0 * (3.0e6_f64 / 0.2).sqrt() * (j as f64 * PI / (2 * n) as f64).sin();
    for (n, wanted) in [(60, 59), (3000, 12)] {
        let body = chain(n, 0.2, 3.0e6);
        let modes = ElasticProblem::free(&body, &[]).unwrap().lowest_modes(wanted).unwrap();
        assert_eq!(modes.counted.is_some(), n > 1000, "the path that ran");
        let expected: Vec<f64> = (1..=wanted).map(|j| exact(n, j)).collect();
        // 3000 masses: the stiffness entries are 1e6 times the lowest eigenvalue.
        assert!(relative_difference(&modes.omega, &expected) < 1e-9);
    }
}

#[test]
fn free_rod_frequencies_match_elementary_theory() {
    // Slender axisymmetric rod: f_j = j c / 2 l, Love's correction -(nu j pi r / 2 l)^2 is 2e-5 for j = 2.
    let body = cylinder(3, [2, 24], 0.01, 1.0);
    let omega = modal_truncation(&body, 2).unwrap().omega;
    let speed = (common::YOUNG / common::DENSITY).sqrt();
    for (j, w) in omega.iter().enumerate() {
        assert!((w / ((j + 1) as f64 * PI * speed) - 1.0).abs() < 1e-4);
    }
}

#[test]
fn cube_and_bar_keep_every_copy_of_multiple_frequencies() {
    for body in [block(2, [5, 5, 5], [1.0, 1.0, 1.0]), block(1, [12, 4, 4], [2.0, 0.6, 0.6])] {
        let problem = ElasticProblem::free(&body, &[]).unwrap();
        let modes = problem.lowest_modes(24).unwrap();
        assert!(modes.counted.is_some(), "block Lanczos ran");
        let dense = problem.all_modes().unwrap();
        let difference = relative_difference(&modes.omega, &dense.omega);
        assert!(difference < SAME_FREQUENCY, "{difference:e}");
        check_mass_orthonormal(&body, &modes.shapes, problem.rigid().unwrap());
        assert!(modes.residual < 1e-6, "{:e}", modes.residual);
    }
}

#[test]
fn frequencies_alone_are_those_of_the_modes_and_none_is_missing() {
    for body in [block(2, [5, 5, 5], [1.0, 1.0, 1.0]), block(1, [12, 4, 4], [2.0, 0.6, 0.6])] {
        let problem = ElasticProblem::free(&body, &[]).unwrap();
        let omega = problem.lowest_frequencies(24).unwrap();
        // The residual of 1e-3 enters the eigenvalue squared, the frequency by half of that.
        let difference = relative_difference(&omega, &problem.all_modes().unwrap().omega);
        assert!(difference < 5e-7, "{difference:e}");
    }
}

#[test]
fn count_moves_behind_a_multiplet_that_the_wanted_modes_cut() {
    let body = block(2, [5, 5, 5], [1.0, 1.0, 1.0]);
    let problem = ElasticProblem::free(&body, &[]).unwrap();
    let omega = problem.all_modes().unwrap().omega;
    let joined = |i: usize| omega[i] / omega[i - 1] - 1.0 < 1e-9;
    let cut = (2..30).find(|&n| joined(n) && joined(n + 1)).expect("a cube has triple frequencies");
    let modes = problem.lowest_modes(cut).unwrap();
    assert_eq!(modes.omega.len(), cut);
    // The rigid modes and at least both further copies lie below the shift, and one frequency above it is reported.
    assert!(modes.counted.unwrap() >= 6 + cut + 2, "{:?}", modes.counted);
    assert_eq!(modes.following.len(), modes.counted.unwrap() - 6 - cut + 1);
    assert!((modes.following[1] / omega[cut + 1] - 1.0).abs() < 1e-6);
}

#[test]
fn square_plate_has_double_frequencies_and_the_neighbouring_counts_avoid_them() {
    let body = block(3, [12, 12, 0], [1.0, 1.0, 0.0]);
    let problem = ElasticProblem::free(&body, &[]).unwrap();
    let modes = problem.lowest_modes(12).unwrap();
    assert!(modes.counted.is_some(), "block Lanczos ran");
    let double =
        (1..12).find(|&i| modes.omega[i] / modes.omega[i - 1] - 1.0 < 1e-9).expect("a double frequency");
    assert_eq!(neighbouring_counts(&modes.omega, double), Some((double - 1, double + 1)));
    assert_eq!(neighbouring_counts(&modes.omega, double + 1), None);
    let cut = modal_truncation(&body, double).unwrap();
    assert_eq!(cut.multiplet, Some((double - 1, double + 1)));
}

#[test]
fn neighbouring_counts_handle_the_ends() {
    let omega = [1.0, 2.0, 2.0, 2.0, 3.0];
    assert_eq!(neighbouring_counts(&omega, 1), None);
    assert_eq!(neighbouring_counts(&omega, 2), Some((1, 4)));
    assert_eq!(neighbouring_counts(&omega, 3), Some((1, 4)));
    assert_eq!(neighbouring_counts(&omega, 4), None);
    assert_eq!(neighbouring_counts(&omega, 0), None);
    assert_eq!(neighbouring_counts(&omega, 5), None);
}

#[test]
fn inertia_counts_the_eigenvalues_below_the_shift() {
    let body = block(2, [4, 3, 3], [1.0, 0.8, 0.5]);
    let problem = ElasticProblem::free(&body, &[]).unwrap();
    let omega = problem.all_modes().unwrap().omega;
    for n in [1, 7, 40, omega.len() / 2] {
        let mu = (0.5 * (omega[n - 1] + omega[n])).powi(2);
        assert_eq!(problem.pencil().inertia(mu, problem.clamped_unknowns()).unwrap().negative, n + 6);
    }
    assert_eq!(problem.pencil().inertia(-1.0, problem.clamped_unknowns()).unwrap().negative, 0);
}

#[test]
fn eigenvalues_next_to_a_shift_are_those_of_the_whole_spectrum() {
    let body = block(2, [5, 4, 3], [1.0, 0.8, 0.5]);
    let problem = ElasticProblem::free(&body, &[]).unwrap();
    let lambda: Vec<f64> = problem.all_modes().unwrap().omega.iter().map(|w| w * w).collect();
    for n in [1, 20, 90] {
        let mu = 0.5 * (lambda[n - 1] + lambda[n]);
        let found = problem.pencil().neighbours(mu, 5, n + 7).unwrap();
        assert_eq!((found.below, found.next.len()), (n + 6, 6));
        let counted = problem.pencil().neighbours(mu, 5, n + 6).unwrap();
        assert_eq!((counted.below, counted.next.len()), (n + 6, 0), "their number decides");
        // Residuals of 1e-3 leave their square of the distance from the shift.
        let near = |a: f64, b: f64| (a - b).abs() < 1e-5 * (b - mu).abs();
        for (next, expected) in found.next.iter().zip(&lambda[n - 1..]) {
            assert!(near(*next, *expected), "{next} and {expected}");
        }
    }
}

#[test]
fn frequencies_below_their_bounds_need_no_count() {
    let body = block(2, [5, 4, 3], [1.0, 0.8, 0.5]);
    let problem = ElasticProblem::free(&body, &[]).unwrap();
    let counted = problem.lowest_frequencies(10).unwrap();
    // A bound that is broken is no reason to fail: the frequencies are counted then.
    for factor in [1.01, 1.0, 0.99] {
        let bounds: Vec<f64> = counted.iter().map(|w| factor * w).collect();
        assert_eq!(problem.lowest_frequencies_below(10, &bounds).unwrap(), counted);
    }
}

#[test]
fn single_precision_count_agrees_or_abstains() {
    let body = block(2, [4, 3, 3], [1.0, 0.8, 0.5]);
    let problem = ElasticProblem::free(&body, &[]).unwrap();
    let omega = problem.all_modes().unwrap().omega;
    let symbolic = problem.pencil().symbolic();
    let held = vec![false; body.n_unknowns()];
    for n in [1, 7, 40, omega.len() / 2] {
        let (below, above) = (omega[n - 1].powi(2), omega[n].powi(2));
        let shifted = problem.pencil().combination(-0.5 * (below + above), &held);
        let inertia = symbolic.inertia_single(shifted.as_ref()).unwrap().expect("a sound factor");
        assert_eq!(inertia.negative, n + 6);
        assert_eq!(symbolic.inertia_double(shifted.as_ref()).unwrap().negative, n + 6);
        // Single precision leaves 6e-8 of the stiffness, highest over lowest eigenvalue about 1e4.
        assert!(inertia.contraction.unwrap() < 0.1, "{inertia:?}");
        // A shift within the error of single precision: the factor cannot tell the sign, so it must not count.
        let shifted = problem.pencil().combination(-below * (1.0 + 1e-12), &held);
        assert_eq!(symbolic.inertia_single(shifted.as_ref()).unwrap(), None);
    }
}

#[test]
fn a_shift_on_an_eigenvalue_shows_as_pivot_growth_or_harmless() {
    // The chain's K - mu M at mu = k/m has a vanishing first pivot, whatever the order does.
    let body = chain(2, 1.0, 1.0);
    let problem = ElasticProblem::free(&body, &[]).unwrap();
    let inertia = problem.pencil().inertia(1.0, problem.clamped_unknowns()).unwrap();
    assert!(inertia.growth > 1e8);
}

#[test]
fn all_modes_diagonalise_both_matrices_and_recover_static_response() {
    let body = block(2, [3, 2, 2], [1.0, 0.8, 0.5]);
    let basis = all_modes(&body).unwrap();
    assert_eq!(basis.n_modes(), body.n_unknowns() - 6);
    check_mass_orthonormal(&body, &basis.shapes, &basis.rigid);
    let energy = gram(&basis.shapes, &body.stiffness_product(basis.shapes.as_ref()));
    let highest = basis.omega.last().unwrap().powi(2);
    let squares =
        Mat::from_fn(
            basis.n_modes(),
            basis.n_modes(),
            |i, j| if i == j { basis.omega[i].powi(2) } else { 0.0 },
        );
    let off = (&energy - &squares).norm_max() / highest;
    // Round-off of a product over 300 unknowns, and of the split between inverse and stiffness.
    assert!(off < 1e-12, "{off:e}");
    // sum of phi phi^T f / omega^2 = F f
    let force = Mat::from_fn(body.n_unknowns(), 1, |i, _| ((5 * i) % 7) as f64 - 3.0);
    let mut direct = force.clone();
    ElasticProblem::free(&body, &[]).unwrap().apply_flexibility(direct.as_mut());
    let mut amplitudes = basis.shapes.transpose() * &force;
    for (i, omega) in basis.omega.iter().enumerate() {
        amplitudes[(i, 0)] /= omega * omega;
    }
    let modal = &basis.shapes * &amplitudes;
    // Condition number of the model about 1e4.
    assert!((&modal - &direct).norm_max() < 1e-10 * direct.norm_max());
}

#[test]
fn results_repeat_bit_by_bit() {
    let body = block(2, [6, 5, 5], [1.0, 0.8, 0.7]);
    let run = || ElasticProblem::free(&body, &[]).unwrap().lowest_modes(8).unwrap();
    let (a, b) = (run(), run());
    assert!(a.omega.iter().zip(&b.omega).all(|(x, y)| x.to_bits() == y.to_bits()));
}

#[test]
fn errors_name_what_is_wrong() {
    let body = block(1, [2, 2, 2], [1.0, 1.0, 1.0]);
    let problem = ElasticProblem::free(&body, &[]).unwrap();
    let available = body.n_unknowns() - 6;
    assert!(matches!(
        problem.lowest_modes(available + 1),
        Err(DynamicsError::TooManyModes { available: a, .. }) if a == available
    ));
    // One clamped node leaves three rotations.
    let node = unknowns_at(&body, |p| p.iter().all(|x| *x < -0.49));
    let error = ElasticProblem::clamped(Pencil::new(&body, &[]).unwrap(), &node).unwrap_err();
    assert!(error.to_string().contains("3 rigid motions free"), "{error}");
    assert!(Pencil::new(&body, &[0, 0]).is_err());
    assert!(Pencil::new(&body, &[100_000]).is_err());
    let mut broken = body.clone();
    broken.stiffness.val_mut()[5] = f64::NAN;
    let error = Pencil::new(&broken, &[]).unwrap_err();
    assert!(error.to_string().contains("not finite"), "{error}");
    let mut stretched = body.clone();
    stretched.stiffness.val_mut()[0] *= 2.0;
    let error = RigidModes::new(&stretched).unwrap_err();
    assert!(error.to_string().contains("resists rigid motion"), "{error}");
}
