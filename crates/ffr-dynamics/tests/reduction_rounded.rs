//! Factors in single precision, refined: the same answers as in double precision (Eqs. R.6, R.13).

use crate::common;
use faer::Mat;
use ffr_dynamics::reduction::ElasticProblem;

/// Entries from which factors of free bodies are made in single precision.
const SINGLE_FROM: usize = 4_000_000;

#[test]
fn refined_single_precision_agrees_with_double() {
    let body = common::block(2, [12; 3], [0.02, 0.02, 0.05]);
    let single = ElasticProblem::free(&body, &[]).unwrap();
    assert!(single.pencil().symbolic().n_entries() >= SINGLE_FROM, "the body is too small for the test");
    // With an interface, the factor is in double precision.
    let double = ElasticProblem::free(&body, &[0]).unwrap();

    let modes = single.lowest_modes(12).unwrap();
    let reference = double.lowest_modes(12).unwrap();
    for (a, b) in modes.omega.iter().zip(&reference.omega) {
        // The modes err by 1e-5 in energy, the frequencies by its square; pairs of bending modes are equal to 1e-12.
        assert!((a / b - 1.0).abs() < 1e-9, "{a} {b}");
    }
    assert_eq!(modes.counted, reference.counted);
    for (a, b) in single.lowest_frequencies(12).unwrap().iter().zip(&reference.omega) {
        // The residual of 1e-3 enters the eigenvalue squared, the frequency by half of that; the contraction of single precision, below 0.03, to the
        // fourth power.
        assert!((a / b - 1.0).abs() < 5e-7, "{a} {b}");
    }

    let load = Mat::from_fn(body.n_unknowns(), 3, |i, j| ((i * (j + 3)) as f64).sin());
    let (mut x, mut y) = (load.clone(), load);
    single.apply_flexibility(x.as_mut());
    double.apply_flexibility(y.as_mut());
    // Round-off: the condition of the supported stiffness, about 1e6, times 1e-16, and some to spare.
    assert!((&x - &y).norm_max() < 1e-8 * y.norm_max());
}
