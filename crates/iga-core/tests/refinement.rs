//! Refinement changes the space, never the geometry.

use iga_core::SplineError;
use iga_core::nurbs::{Grading, Patch, Prolongation, Window};
use iga_core::splines::knots::KnotVector;
use proptest::prelude::*;

// A point is a quotient of two sums of at most (p + 1)^3 products, before and after refinement.
const ROUND_OFF: f64 = 1e-14;

/// A patch with repeated interior knots and scattered points of size one.
fn patch(degrees: &[usize], repeats: &[usize], seed: u64) -> Patch {
    let knots: Vec<KnotVector> = degrees
        .iter()
        .zip(repeats)
        .map(|(&p, &m)| {
            let mut all = vec![0.0; p + 1];
            all.extend(std::iter::repeat_n(0.3, m.min(p)));
            all.push(0.7);
            all.extend(vec![1.0; p + 1]);
            KnotVector::new(p, all).unwrap()
        })
        .collect();
    let n: usize = knots.iter().map(KnotVector::n_functions).product();
    let mut state = seed;
    let mut random = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    let points = (0..n).map(|_| [random(), random(), random()]).collect();
    let weights = (0..n).map(|_| 0.3 + random()).collect();
    Patch::new(knots, points, weights).unwrap()
}

fn largest_difference(a: &Patch, b: &Patch, samples: &[[f64; 3]]) -> f64 {
    let distance = |xi: &[f64; 3]| {
        let (p, q) = (a.point(xi), b.point(xi));
        (0..3).map(|c| (p[c] - q[c]).abs()).fold(0.0, f64::max)
    };
    samples.iter().map(distance).fold(0.0, f64::max)
}

/// The same geometry with the degree of one direction raised.
fn elevated(patch: &Patch, direction: usize, by: usize) -> Result<Patch, SplineError> {
    patch.refine_to(direction, &patch.knots()[direction].elevated(by)?)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn elevation_and_insertion_keep_every_point(
        degrees in prop::collection::vec(1usize..4, 1..=3),
        repeats in prop::collection::vec(1usize..4, 3),
        seed in any::<u64>(),
        direction in 0usize..3,
        by in 0usize..4,
        more in prop::collection::vec(0.001f64..0.999, 0..5),
        samples in prop::collection::vec([0.0f64..1.0, 0.0f64..1.0, 0.0f64..1.0], 8),
    ) {
        let coarse = patch(&degrees, &repeats, seed);
        let d = direction % degrees.len();
        let higher = elevated(&coarse, d, by).unwrap();
        prop_assert!(largest_difference(&coarse, &higher, &samples) < ROUND_OFF);
        let inserted = coarse.insert_knots(d, &more).unwrap();
        prop_assert!(largest_difference(&coarse, &inserted, &samples) < ROUND_OFF);
        let both = higher.insert_knots(d, &more).unwrap();
        let other_way = elevated(&inserted, d, by).unwrap();
        prop_assert!(largest_difference(&coarse, &both, &samples) < ROUND_OFF);
        prop_assert!(largest_difference(&coarse, &other_way, &samples) < ROUND_OFF);
    }

    #[test]
    fn prolongation_rows_are_convex_combinations(
        p in 1usize..5,
        by in 0usize..3,
        m in 1usize..5,
        exponents in prop::collection::vec(0.0f64..12.0, 0..8),
    ) {
        // Knots that crowd to the lower end, spacings from 1 to 1e-12.
        let coarse = patch(&[p], &[m], 1).knots()[0].clone();
        let more: Vec<f64> = exponents.iter().map(|e| 0.5 * 10f64.powf(-e)).collect();
        let fine = coarse.elevated(by).unwrap().with_knots(&more).unwrap();
        let operator = Prolongation::new(&coarse, &fine).unwrap();
        for i in 0..operator.n_fine() {
            let (first, entries) = operator.row(i);
            prop_assert!(first + entries.len() <= operator.n_coarse());
            prop_assert!(entries.iter().all(|&v| v >= 0.0));
            prop_assert!((entries.iter().sum::<f64>() - 1.0).abs() < ROUND_OFF);
        }
    }

    #[test]
    fn gradings_keep_existing_breaks_and_leave_no_slivers(
        elements in 1usize..40,
        windows in prop::collection::vec((-0.2f64..1.2, -4.0f64..-0.3, 1usize..24, 1.0f64..3.0), 0..4),
        inner in prop::option::of(0.05f64..0.95),
    ) {
        let windows: Vec<Window> = windows
            .into_iter()
            .map(|(at, exponent, elements, ratio)| {
                let half = 10f64.powf(exponent);
                Window { lower: at - half, upper: at + half, elements, ratio }
            })
            .collect();
        let existing: Vec<f64> = [0.0].into_iter().chain(inner).chain([1.0]).collect();
        let finest = windows.iter().map(Window::size).fold(1.0 / elements.max(2) as f64, f64::min).min(0.05);
        // Ratio one never grows: a fine window near the range may ask for too many elements.
        if let Ok(breaks) = (Grading { elements, windows: windows.clone() }).breaks(&existing) {
            prop_assert!(existing.iter().all(|u| breaks.contains(u)));
            let sizes: Vec<f64> = breaks.windows(2).map(|w| w[1] - w[0]).collect();
            // Ends nearer than half an element are joined, and counts are rounded up.
            prop_assert!(sizes.iter().all(|&h| h > 0.25 * finest), "{breaks:?}");
            KnotVector::from_breaks(3, &breaks).unwrap();
        } else {
            prop_assert!(windows.iter().any(|w| w.ratio < 1.02));
        }
    }
}

#[test]
fn knots_of_full_multiplicity_split_a_patch_into_bezier_pieces() {
    let coarse = patch(&[3], &[1], 7);
    let fine = coarse.insert_knots(0, &[0.3, 0.3, 0.7, 0.7, 0.5, 0.5, 0.5]).unwrap();
    assert_eq!(fine.knots()[0].n_functions(), 3 * fine.n_elements() + 1);
    // An interpolated control point lies on the curve.
    let p = fine.point(&[0.5, 0.0, 0.0]);
    let on_net = fine.control_points().iter().any(|q| (0..3).all(|c| (p[c] - q[c]).abs() < ROUND_OFF));
    assert!(on_net);
}

#[test]
fn impossible_refinements_are_refused_with_the_numbers() {
    let coarse = patch(&[2, 2], &[1, 1], 3);
    for (result, word) in [
        (elevated(&coarse, 0, 8), "degree 10"),
        (coarse.insert_knots(2, &[0.5]), "direction 2"),
        (coarse.insert_knots(0, &[1.0]), "not inside"),
        (coarse.insert_knots(0, &[f64::NAN]), "not inside"),
        (coarse.insert_knots(1, &[0.3, 0.3]), "stands 3 times"),
        (coarse.refine_to(0, &KnotVector::uniform(2, 4).unwrap()), "are needed"),
        (coarse.refine_to(0, &KnotVector::uniform(1, 4).unwrap()), "cannot be lowered"),
        (coarse.refine_to(0, &KnotVector::from_breaks(2, &[0.0, 0.3, 0.7, 2.0]).unwrap()), "range"),
    ] {
        let text = result.unwrap_err().to_string();
        assert!(text.contains(word), "{text}");
    }
}
