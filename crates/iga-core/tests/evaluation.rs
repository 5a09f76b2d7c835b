//! Rational basis functions against identities and differences.

use iga_core::nurbs::Patch;
use iga_core::nurbs::patch::{PointBasis, SECOND_DERIVATIVES};
use iga_core::splines::knots::KnotVector;

fn patch(dimension: usize) -> Patch {
    let all = [
        KnotVector::new(2, vec![0.0, 0.0, 0.0, 0.4, 0.4, 1.0, 1.0, 1.0]).unwrap(),
        KnotVector::new(3, vec![0.0, 0.0, 0.0, 0.0, 0.6, 1.0, 1.0, 1.0, 1.0]).unwrap(),
        KnotVector::uniform(1, 2).unwrap(),
    ];
    let knots = all[..dimension].to_vec();
    let n: usize = knots.iter().map(KnotVector::n_functions).product();
    let points = (0..n).map(|i| [(i as f64).sin(), (1.7 * i as f64).cos(), 0.1 * i as f64]).collect();
    let weights = (0..n).map(|i| 1.0 + 0.5 * (2.3 * i as f64).sin()).collect();
    Patch::new(knots, points, weights).unwrap()
}

#[test]
fn rational_functions_sum_to_one_and_their_derivatives_to_zero() {
    for dimension in 1..=3 {
        let patch = patch(dimension);
        let mut basis = PointBasis::default();
        for e in 0..patch.n_elements() {
            let (lower, upper) = patch.element(e);
            let xi = [0, 1, 2].map(|d| lower[d] + 0.3 * (upper[d] - lower[d]));
            assert_eq!(patch.find_element(&xi), e);
            patch.evaluate(e, &xi, 2, &mut basis);
            assert_eq!(basis.values.len(), patch.n_active());
            // Round-off of sums of derivatives up to p^2 / h^2 = 50.
            assert!((basis.values.iter().sum::<f64>() - 1.0).abs() < 1e-14);
            for d in 0..3 {
                assert!(basis.first.iter().map(|g| g[d]).sum::<f64>().abs() < 1e-13);
            }
            for d in 0..6 {
                assert!(basis.second.iter().map(|g| g[d]).sum::<f64>().abs() < 1e-12);
            }
        }
    }
}

#[test]
fn rational_derivatives_match_central_differences() {
    let h = 1e-6; // error h^2 f''' / 6 against round-off eps f / h
    for dimension in 1..=3 {
        let patch = patch(dimension);
        let mut scratch = PointBasis::default();
        let xi = [0.37, 0.55, 0.2];
        let mut xi_in = [0.0; 3];
        xi_in[..dimension].copy_from_slice(&xi[..dimension]);
        let jet = patch.jet(&xi_in, 2, &mut scratch);
        for d in 0..dimension {
            let shifted = |s: f64| {
                let mut at = xi_in;
                at[d] += s * h;
                patch.jet(&at, 1, &mut PointBasis::default())
            };
            let (plus, minus) = (shifted(1.0), shifted(-1.0));
            for c in 0..3 {
                let slope = (plus.point[c] - minus.point[c]) / (2.0 * h);
                assert!((slope - jet.first[d][c]).abs() < 1e-7);
                for &(a, b) in SECOND_DERIVATIVES.iter().filter(|(a, b)| (*a == d) && *b < dimension) {
                    let slope = (plus.first[b][c] - minus.first[b][c]) / (2.0 * h);
                    assert!((slope - jet.second(a, b)[c]).abs() < 1e-6, "{a} {b} {c}");
                }
            }
        }
    }
}
