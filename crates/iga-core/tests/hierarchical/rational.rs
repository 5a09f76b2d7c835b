//! Exact geometry and derivatives on rational patches.

use iga_core::ParameterBox;
use iga_core::hierarchical::{HierarchicalSpace, PatchTies, SubdomainHierarchy};
use iga_core::nurbs::Patch;
use iga_core::nurbs::patch::{PointBasis, SECOND_DERIVATIVES};
use iga_core::space::{Space, SplineSpace};

use super::nets::{PLACES, field, inside, refine_around, ring};

/// Quarter annulus or block refined twice around a region at the outer face.
fn refined_ring(dimension: usize) -> (Patch, HierarchicalSpace) {
    let patch = ring(dimension, 1, 0.4, &[6, 5, 4]);
    let mut hierarchy = SubdomainHierarchy::new(patch.knots());
    let region = ParameterBox { lower: [0.42, 0.9, 0.55], upper: [0.5, 1.0, 0.6] };
    let ties = PatchTies::detect(&patch);
    assert!(ties.is_empty());
    refine_around(&mut hierarchy, [3, 2, 2], &[region], &ties);
    refine_around(&mut hierarchy, [2, 3, 2], &[region], &ties);
    let space = HierarchicalSpace::new(&patch, hierarchy).unwrap();
    (patch, space)
}

#[test]
fn geometry_does_not_change() {
    for dimension in [2, 3] {
        let (patch, space) = refined_ring(dimension);
        assert!(space.leaf(space.n_elements() - 1).level == 2);
        for e in 0..space.n_elements() {
            for place in PLACES {
                let xi = inside(&space.element(e), place);
                let (x, y) = (field(&space, space.control_points(), &xi), patch.point(&xi));
                // Unit size, sums of up to 100 terms.
                assert!((0..3).all(|c| (x[c] - y[c]).abs() < 1e-14 * 4.0), "{x:?} {y:?}");
                let radius = x[0].hypot(x[1]);
                assert!((radius - (0.4 + 0.6 * xi[1])).abs() < 1e-14 * 4.0);
            }
        }
    }
}

#[test]
fn functions_are_really_refined_by_a_tiny_region() {
    let (patch, space) = refined_ring(2);
    let basis = space.basis(0);
    assert!(basis.active_on_level(0).len() < patch.n_functions());
    let of_level = |l| basis.active_on_level(l).len();
    assert!(of_level(1) > 0 && of_level(2) > 0);
    // On the region itself only functions of the last level live.
    for xi in [[0.421, 0.91, 0.0], [0.499, 0.999, 0.0]] {
        let e = space.find_element(0, &xi);
        assert!(space.is_single_level(e) && space.leaf(e).level == 2);
    }
}

#[test]
fn derivatives_are_those_of_the_values() {
    let (_, space) = refined_ring(3);
    let h = 1e-5;
    let (mut here, mut plus, mut minus) =
        (PointBasis::default(), PointBasis::default(), PointBasis::default());
    let mut n_mixed = 0;
    for e in (0..space.n_elements()).step_by(7) {
        n_mixed += usize::from(!space.is_single_level(e));
        let element = space.element(e);
        let xi = inside(&element, PLACES[0]);
        space.evaluate(e, &xi, 2, &mut here);
        for d in 0..3 {
            let size = element.upper[d] - element.lower[d];
            let moved = |s: f64| {
                let mut xi = xi;
                xi[d] += s * h * size;
                xi
            };
            space.evaluate(e, &moved(1.0), 1, &mut plus);
            space.evaluate(e, &moved(-1.0), 1, &mut minus);
            assert_eq!(plus.values.len(), here.values.len());
            for i in 0..here.values.len() {
                let slope = (plus.values[i] - minus.values[i]) / (2.0 * h);
                // Central differences of functions of size 1 in element coordinates: h^2 + 1e-16 / h.
                assert!((slope - here.first[i][d] * size).abs() < 1e-9, "{slope} {}", here.first[i][d]);
                for (s, &(a, b)) in SECOND_DERIVATIVES.iter().enumerate().filter(|(_, pair)| pair.1 == d) {
                    let other = element.upper[a] - element.lower[a];
                    let slope = (plus.first[i][a] - minus.first[i][a]) * other / (2.0 * h);
                    assert!((slope - here.second[i][s] * other * size).abs() < 1e-8, "{a} {b}");
                }
            }
        }
    }
    assert!(n_mixed > 3);
}

#[test]
fn lower_orders_agree_with_higher_ones_and_leave_lists_empty() {
    let (_, space) = refined_ring(2);
    let (mut full, mut part) = (PointBasis::default(), PointBasis::default());
    for e in 0..space.n_elements() {
        let xi = inside(&space.element(e), PLACES[1]);
        space.evaluate(e, &xi, 2, &mut full);
        for n in 0..2 {
            space.evaluate(e, &xi, n, &mut part);
            assert_eq!(part.values, full.values);
            assert_eq!((part.first.len(), part.second.len()), (n * full.first.len(), 0));
            assert!(
                part.first.iter().zip(&full.first).all(|(a, b)| a.map(f64::to_bits) == b.map(f64::to_bits))
            );
        }
        assert_eq!(full.values.len(), space.functions_on(e).len());
    }
}

#[test]
fn one_level_is_the_plain_patch() {
    let patch = ring(3, 1, 0.4, &[3, 2, 2]);
    let space = HierarchicalSpace::plain(&patch).unwrap();
    assert_eq!(space.control_points().len(), patch.n_functions());
    assert_eq!(space.n_elements(), patch.n_elements());
    let (mut a, mut b, mut active) = (PointBasis::default(), PointBasis::default(), Vec::new());
    for e in 0..patch.n_elements() {
        active.clear();
        patch.active_functions(e, &mut active);
        assert_eq!(space.functions_on(e), active);
        let (lower, upper) = patch.element(e);
        assert_eq!((space.element(e).lower, space.element(e).upper), (lower, upper));
        let xi = inside(&space.element(e), PLACES[0]);
        patch.evaluate(e, &xi, 2, &mut a);
        space.evaluate(e, &xi, 2, &mut b);
        for i in 0..active.len() {
            assert!((a.values[i] - b.values[i]).abs() < 1e-15);
            // Second derivatives reach 100.
            assert!(a.second[i].iter().zip(&b.second[i]).all(|(x, y)| (x - y).abs() < 1e-12));
        }
    }
    // Anchors are the net indices.
    let sizes = patch.net_size();
    for (f, anchor) in space.anchors().iter().enumerate() {
        let index = iga_core::splines::tensor::multi_index(&sizes, f);
        assert!((0..3).all(|d| (anchor[d] - index[d] as f64).abs() < 1e-12));
    }
}

/// The largest hierarchy of the adaptive algorithm: five levels with up to ten knots inserted in each element.
#[test]
fn five_levels_of_eleven_parts_stay_small() {
    let patch = ring(2, 1, 0.4, &[16, 16]);
    let region = ParameterBox { lower: [0.371_234, 1.0, 0.0], upper: [0.371_236, 1.0, 0.0] };
    let mut hierarchy = SubdomainHierarchy::new(patch.knots());
    for _ in 0..4 {
        refine_around(&mut hierarchy, [11, 11, 1], &[region], &PatchTies::default());
    }
    // 16 * 11^4 elements per direction on the finest level, of which a few dozen exist.
    assert_eq!(hierarchy.levels()[4].element_counts(), [234_256, 234_256, 1]);
    let space = HierarchicalSpace::new(&patch, hierarchy).unwrap();
    assert!(space.n_elements() < 10_000, "{}", space.n_elements());
    for e in (0..space.n_elements()).step_by(5) {
        let xi = inside(&space.element(e), PLACES[0]);
        let (x, y) = (field(&space, space.control_points(), &xi), patch.point(&xi));
        // B-splines at a point between knots 3e-7 apart: 1e-16 / 3e-7 relative in each factor, damped by their sum.
        assert!((0..2).all(|c| (x[c] - y[c]).abs() < 1e-13), "{x:?} {y:?}");
    }
}
