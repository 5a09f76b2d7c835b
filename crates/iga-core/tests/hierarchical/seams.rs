//! Seams, poles and axes under local refinement.

use iga_core::ParameterBox;
use iga_core::SplineError;
use iga_core::hierarchical::{HierarchicalSpace, IndexBox, PatchTies, Prolongation, SubdomainHierarchy};
use iga_core::nurbs::Patch;
use iga_core::space::{Space, SplineSpace};

use super::nets::{field, noise, refine_around, ring};

fn refine(patch: &Patch, region: ParameterBox) -> HierarchicalSpace {
    let ties = PatchTies::detect(patch);
    let mut hierarchy = SubdomainHierarchy::new(patch.knots());
    refine_around(&mut hierarchy, [2, 2, 2], &[region], &ties);
    refine_around(&mut hierarchy, [3, 2, 1], &[region], &ties);
    HierarchicalSpace::new(patch, hierarchy).unwrap()
}

/// A random field has the same value on both sides of the seam, for points all along it.
fn assert_seam_is_closed(space: &HierarchicalSpace, dimension: usize) {
    let coefficients = noise(space.n_functions());
    for k in 0..=60 {
        let z = if dimension == 3 { (k as f64 * 0.377).fract() } else { 0.0 };
        let (a, b) = ([0.0, k as f64 / 60.0, z], [1.0, k as f64 / 60.0, z]);
        let (x, y) = (field(space, &coefficients, &a), field(space, &coefficients, &b));
        assert!((0..3).all(|c| (x[c] - y[c]).abs() < 1e-13), "{a:?}: {x:?} {y:?}");
    }
}

#[test]
fn disc_is_recognised_as_seam_and_pole() {
    let ties = PatchTies::detect(&ring(2, 4, 0.0, &[2, 4]));
    assert_eq!(ties.seams, [true, false, false]);
    assert!(ties.collapsed.iter().all(|s| s.is_point()));
    assert!(ties.collapsed.iter().any(|s| s.ends == [None, Some(false), Some(false)]));
    // A cylinder's axis is a line.
    let ties = PatchTies::detect(&ring(3, 4, 0.0, &[2, 4, 3]));
    assert!(ties.collapsed.iter().any(|s| !s.is_point() && s.along == [true, false, false]));
    assert!(PatchTies::detect(&ring(2, 3, 0.2, &[2, 4])).is_empty());
}

#[test]
fn region_across_the_seam_is_refined_on_both_sides() {
    for (inner, dimension) in [(0.3, 2), (0.0, 2), (0.3, 3), (0.0, 3)] {
        let patch = ring(dimension, 4, inner, &[3, 6, 6]);
        // Straddles the seam; the second region lies on one side but grows across.
        for (lower, upper) in [(-0.02, 0.03), (0.05, 0.08), (0.98, 1.01)] {
            let region = ParameterBox { lower: [lower, 0.8, 0.8], upper: [upper, 1.0, 1.0] };
            let space = refine(&patch, region);
            assert_seam_is_closed(&space, dimension);
            let level = |xi: [f64; 3]| space.leaf(space.find_element(0, &xi)).level;
            assert!(level([0.001, 0.95, 0.95]) > 0 && level([0.999, 0.95, 0.95]) > 0);
        }
    }
}

#[test]
fn region_at_the_pole_keeps_one_value_there() {
    let patch = ring(2, 4, 0.0, &[3, 6]);
    let region = ParameterBox { lower: [0.4, 0.0, 0.0], upper: [0.5, 0.1, 0.0] };
    let space = refine(&patch, region);
    let coefficients = noise(space.n_functions());
    let first = field(&space, &coefficients, &[0.0; 3]);
    for k in 1..50 {
        let x = field(&space, &coefficients, &[k as f64 / 50.0, 0.0, 0.0]);
        assert!((0..3).all(|c| (x[c] - first[c]).abs() < 1e-13));
    }
    // Only a part of the circumference is refined.
    let level = |u: f64| space.leaf(space.find_element(0, &[u, 0.01, 0.0])).level;
    assert!(level(0.45) == 2 && level(0.95) == 0);
}

#[test]
fn region_at_an_axis_is_carried_all_around_it() {
    let patch = ring(3, 4, 0.0, &[2, 5, 6]);
    let region = ParameterBox { lower: [0.4, 0.0, 0.9], upper: [0.5, 0.1, 1.0] };
    let space = refine(&patch, region);
    let coefficients = noise(space.n_functions());
    for z in [0.1, 0.77, 0.93, 1.0] {
        let first = field(&space, &coefficients, &[0.0, 0.0, z]);
        for k in 1..20 {
            let x = field(&space, &coefficients, &[k as f64 / 20.0, 0.0, z]);
            assert!((0..3).all(|c| (x[c] - first[c]).abs() < 1e-13), "{z}");
        }
    }
    assert_seam_is_closed(&space, 3);
}

#[test]
fn refinement_on_one_side_of_a_seam_or_around_part_of_an_axis_is_refused() {
    let open = |patch: &Patch, lower, upper| {
        let mut hierarchy = SubdomainHierarchy::new(patch.knots());
        hierarchy.refine([2, 2, 2], &[IndexBox { lower, upper }]).unwrap();
        match HierarchicalSpace::new(patch, hierarchy) {
            Err(SplineError::OpenSeam { what, .. }) => Some(what),
            Err(other) => panic!("{other}"),
            Ok(_) => None,
        }
    };
    let disc = ring(2, 4, 0.0, &[3, 6]);
    assert_eq!(open(&disc, [0, 2, 0], [4, 6, 1]), Some("seam"));
    assert_eq!(open(&disc, [3, 2, 0], [8, 6, 1]), None);
    let cylinder = ring(3, 4, 0.0, &[2, 4, 4]);
    assert_eq!(open(&cylinder, [1, 0, 0], [6, 3, 3]), Some("collapsed edge"));
}

#[test]
fn ties_agree_with_coincident_control_points_of_the_plain_patch() {
    for patch in [ring(2, 4, 0.0, &[2, 3]), ring(3, 4, 0.0, &[1, 2, 2]), ring(3, 4, 0.5, &[1, 2, 2])] {
        let space = HierarchicalSpace::plain(&patch).unwrap();
        let mut distinct: Vec<[f64; 3]> = Vec::new();
        for x in patch.control_points() {
            if distinct.iter().all(|y| (0..3).any(|c| (x[c] - y[c]).abs() > 1e-12)) {
                distinct.push(*x);
            }
        }
        assert_eq!(space.control_points().len(), distinct.len());
        assert!(
            space
                .control_points()
                .iter()
                .zip(&distinct)
                .all(|(a, b)| a.map(f64::to_bits) == b.map(f64::to_bits))
        );
        // Every function once per element.
        for e in 0..space.n_elements() {
            let mut list = space.functions_on(e).to_vec();
            list.sort_unstable();
            list.dedup();
            assert_eq!(list.len(), space.functions_on(e).len());
        }
    }
}

#[test]
fn tied_coefficients_are_prolonged_exactly() {
    let patch = ring(3, 4, 0.0, &[2, 5, 6]);
    let coarse = HierarchicalSpace::plain(&patch).unwrap();
    let fine = refine(&patch, ParameterBox { lower: [-0.02, 0.0, 0.9], upper: [0.03, 1.0, 1.0] });
    let p = Prolongation::between(&coarse, &fine).unwrap();
    let u = noise(coarse.n_functions());
    let v = p.apply(&u);
    for k in 0..300 {
        let s = k as f64 / 299.0;
        let xi = [s, (s * 17.3).fract(), (s * 31.7).fract()];
        let (x, y) = (field(&coarse, &u, &xi), field(&fine, &v, &xi));
        assert!((0..3).all(|c| (x[c] - y[c]).abs() < 1e-13), "{xi:?} {x:?} {y:?}");
    }
}

#[test]
fn elements_at_a_closed_seam_are_as_smooth_as_others() {
    let patch = ring(2, 4, 0.3, &[1, 4]);
    let mut knots = patch.knots().to_vec();
    knots[0] = super::nets::split(&knots[0], 3);
    let space = HierarchicalSpace::plain(&super::nets::refined(&patch, knots)).unwrap();
    assert!((0..space.n_elements()).all(|e| space.is_single_level(e)));
    // Quarters meet at repeated knots: only the middle third of each is smooth on both sides, and the ends of the patch.
    let counts: Vec<usize> = (0..12).map(|e| space.gauss_counts(e)[0]).collect();
    assert_eq!(counts, [2, 2, 3, 3, 2, 3, 3, 2, 3, 3, 2, 2]);
}
