//! Prolongation between hierarchical spaces, plain and globally refined patches.

use iga_core::ParameterBox;
use iga_core::hierarchical::{HierarchicalSpace, IndexBox, Prolongation, SubdomainHierarchy};
use iga_core::nurbs::Patch;
use iga_core::space::Space;

use super::nets::{PLACES, field, inside, noise, refine_around, refined, ring, split, unit_patch};

/// Fields of size 1, sums of up to 100 products.
const ROUND_OFF: f64 = 1e-13;

fn hierarchy(patch: &Patch, regions: &[(f64, f64)]) -> SubdomainHierarchy {
    let mut hierarchy = SubdomainHierarchy::new(patch.knots());
    for (k, &(lower, upper)) in regions.iter().enumerate() {
        let region = ParameterBox { lower: [lower; 3], upper: [upper; 3] };
        refine_around(&mut hierarchy, [2 + k, 2, 3 - k], &[region], &Default::default());
    }
    hierarchy
}

fn assert_same_field(coarse: &HierarchicalSpace, fine: &HierarchicalSpace) {
    let p = Prolongation::between(coarse, fine).unwrap();
    assert_eq!((p.n_fine(), p.n_coarse()), (fine.n_functions(), coarse.n_functions()));
    let u = noise(coarse.n_functions());
    let v = p.apply(&u);
    for e in 0..fine.n_elements() {
        for place in PLACES {
            let xi = inside(&fine.element(e), place);
            let (x, y) = (field(coarse, &u, &xi), field(fine, &v, &xi));
            assert!((0..3).all(|c| (x[c] - y[c]).abs() < ROUND_OFF), "{xi:?}: {x:?} {y:?}");
        }
    }
}

#[test]
fn fields_do_not_change_under_prolongation() {
    for patch in [ring(2, 1, 0.3, &[8, 8]), ring(3, 1, 0.3, &[7, 6, 6])] {
        let spaces: Vec<HierarchicalSpace> =
            [vec![], vec![(0.5, 0.6)], vec![(0.45, 0.7)], vec![(0.45, 0.7), (0.5, 0.6)]]
                .iter()
                .map(|regions| HierarchicalSpace::new(&patch, hierarchy(&patch, regions)).unwrap())
                .collect();
        for (k, fine) in spaces.iter().enumerate() {
            for coarse in &spaces[..=k] {
                assert_same_field(coarse, fine);
            }
        }
        assert!(Prolongation::between(&spaces[3], &spaces[2]).is_err());
    }
}

#[test]
fn hierarchical_space_lies_in_the_globally_refined_one() {
    let patch = ring(2, 1, 0.3, &[8, 8]);
    let local = HierarchicalSpace::new(&patch, hierarchy(&patch, &[(0.5, 0.6), (0.52, 0.55)])).unwrap();
    let knots = patch.knots().iter().zip([[2, 3], [2, 2]]);
    let global = refined(&patch, knots.map(|(k, n)| split(&split(k, n[0]), n[1])).collect());
    let global = HierarchicalSpace::plain(&global).unwrap();
    assert!(global.n_functions() > 3 * local.n_functions());
    assert_same_field(&local, &global);
    let text = Prolongation::between(&global, &local).unwrap_err().to_string();
    assert!(text.contains("does not contain"), "{text}");
}

#[test]
fn rows_of_a_prolongation_sum_to_one() {
    let patch = ring(2, 1, 0.3, &[8, 8]);
    let coarse = HierarchicalSpace::plain(&patch).unwrap();
    let fine = HierarchicalSpace::new(&patch, hierarchy(&patch, &[(0.5, 0.6)])).unwrap();
    let p = Prolongation::between(&coarse, &fine).unwrap();
    for i in 0..p.n_fine() {
        let sum: f64 = p.row(i).1.iter().sum();
        assert!((sum - 1.0).abs() < ROUND_OFF);
    }
}

#[test]
fn other_geometries_and_shrunken_regions_are_refused() {
    let (a, b) = (ring(2, 1, 0.3, &[8, 8]), ring(2, 1, 0.35, &[8, 8]));
    let plain = |p: &Patch| HierarchicalSpace::plain(p).unwrap();
    let fine = HierarchicalSpace::new(&b, hierarchy(&b, &[(0.5, 0.6)])).unwrap();
    let text = Prolongation::between(&plain(&a), &fine).unwrap_err().to_string();
    assert!(text.contains("geometries differ"), "{text}");
    let text = Prolongation::between(&plain(&unit_patch(&[2, 2], &[8, 8])), &fine).unwrap_err().to_string();
    assert!(text.contains("geometries differ"), "{text}");
    let moved = HierarchicalSpace::new(&b, hierarchy(&b, &[(0.1, 0.2)])).unwrap();
    let text = Prolongation::between(&moved, &fine).unwrap_err().to_string();
    assert!(text.contains("does not reach over"), "{text}");
    assert!(
        HierarchicalSpace::new(&a, SubdomainHierarchy::new(unit_patch(&[2, 2], &[3, 3]).knots())).is_err()
    );
}

#[test]
fn different_level_sequences_may_be_mixed() {
    // 4 parts at once in the coarser space, 2 and 2 in the finer one.
    let patch = unit_patch(&[2, 2], &[8, 8]);
    let all = |n: usize| IndexBox { lower: [0; 3], upper: [n, n, 1] };
    let inner = |a: usize, b: usize| IndexBox { lower: [a, a, 0], upper: [b, b, 1] };
    let mut once = SubdomainHierarchy::new(patch.knots());
    once.refine([4, 4, 1], &[inner(2, 6)]).unwrap();
    let mut twice = SubdomainHierarchy::new(patch.knots());
    twice.refine([2, 2, 1], &[all(8)]).unwrap();
    twice.refine([2, 2, 1], &[inner(4, 13)]).unwrap();
    let once = HierarchicalSpace::new(&patch, once).unwrap();
    let twice = HierarchicalSpace::new(&patch, twice).unwrap();
    assert_same_field(&once, &twice);
}
