//! Random hierarchies.

use iga_core::ParameterBox;
use iga_core::hierarchical::{HierarchicalSpace, PatchTies, Prolongation, SubdomainHierarchy};
use iga_core::nurbs::Patch;
use iga_core::space::{Space, SplineSpace};
use proptest::prelude::*;

use super::nets::{PLACES, field, inside, noise, refine_around, ring, unit_patch};

/// A region by its middle and half width a direction.
fn region() -> impl Strategy<Value = ParameterBox> {
    prop::array::uniform3((0.0..1.0f64, 0.0..0.2f64)).prop_map(|r| ParameterBox {
        lower: r.map(|(m, h)| (m - h).max(-0.1)),
        upper: r.map(|(m, h)| (m + h).min(1.1)),
    })
}

fn patch() -> impl Strategy<Value = Patch> {
    prop_oneof![
        (1usize..5, 3usize..9).prop_map(|(p, n)| unit_patch(&[p], &[n])),
        (1usize..4, 1usize..4, 3usize..9).prop_map(|(p, q, n)| unit_patch(&[p, q], &[n, n + 1])),
        (1usize..3, 4usize..6).prop_map(|(p, n)| unit_patch(&[p, 2, 1], &[n, 4, 3])),
        (prop_oneof![Just(1usize), Just(4)], prop_oneof![Just(0.0), Just(0.4)])
            .prop_map(|(arcs, inner)| ring(2, arcs, inner, &[3, 4])),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn geometry_and_fields_of_the_patch_are_kept(
        patch in patch(),
        levels in prop::collection::vec((prop::array::uniform3(1usize..5), prop::collection::vec(region(), 1..3)), 1..3),
    ) {
        let ties = PatchTies::detect(&patch);
        let mut hierarchy = SubdomainHierarchy::new(patch.knots());
        let mut regions = levels[0].1.clone();
        for (parts, more) in &levels {
            // Later regions are parts of the first ones.
            for (r, m) in regions.iter_mut().zip(more) {
                let middle: [f64; 3] =
                    std::array::from_fn(|d| m.lower[d].clamp(r.lower[d].max(0.0), r.upper[d].min(1.0)));
                r.lower = std::array::from_fn(|d| 0.5 * (r.lower[d] + middle[d]));
                r.upper = std::array::from_fn(|d| 0.5 * (r.upper[d] + middle[d]));
            }
            let parts = [parts[0] + 1, parts[1], parts[2]];
            refine_around(&mut hierarchy, parts, &regions, &ties);
        }
        prop_assert!(hierarchy.levels().iter().skip(1).all(|l| !l.region().is_empty()));
        let space = HierarchicalSpace::new(&patch, hierarchy).unwrap();
        let coarse = HierarchicalSpace::plain(&patch).unwrap();
        let prolongation = Prolongation::between(&coarse, &space).unwrap();
        let u = noise(coarse.n_functions());
        let v = prolongation.apply(&u);
        for e in 0..space.n_elements() {
            let xi = inside(&space.element(e), PLACES[e % 2]);
            prop_assert_eq!(space.find_element(0, &xi), e);
            let (x, y) = (field(&space, space.control_points(), &xi), patch.point(&xi));
            // Round-off of sums of up to 100 terms of size 1.
            prop_assert!((0..3).all(|c| (x[c] - y[c]).abs() < 1e-13));
            let (x, y) = (field(&coarse, &u, &xi), field(&space, &v, &xi));
            prop_assert!((0..3).all(|c| (x[c] - y[c]).abs() < 1e-13));
        }
        // Where a region is, functions of the finest level are alone (a pole's function belongs to all levels).
        for r in &regions {
            let inner: [f64; 3] = std::array::from_fn(|d| 0.5 * (r.lower[d].clamp(0.0, 1.0) + r.upper[d].clamp(0.0, 1.0)));
            let e = space.find_element(0, &inner);
            let last = space.basis(0).hierarchy().levels().len() - 1;
            prop_assert_eq!(space.leaf(e).level, last);
            for &f in space.functions_on(e) {
                let at_origin = space.control_points()[f as usize].iter().all(|x| x.abs() < 1e-12);
                let is_pole = at_origin && !space.ties(0).collapsed.is_empty();
                prop_assert!(is_pole || space.level_and_index(f).0 == last);
            }
        }
    }
}
