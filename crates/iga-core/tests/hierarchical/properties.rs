//! Identities of the bases on mixed levels with several boxes.

use std::collections::HashMap;

use iga_core::SplineError;
use iga_core::hierarchical::truncation::{OperatorBuilder, Truncation};
use iga_core::hierarchical::{
    HierarchicalBasis, HierarchicalSpace, IndexBox, Prolongation, SubdomainHierarchy,
};
use iga_core::nurbs::Patch;
use iga_core::nurbs::patch::PointBasis;
use iga_core::space::{Space, SplineSpace};
use iga_core::splines::knots::KnotVector;
use nalgebra::DMatrix;

use super::nets::{PLACES, identity_patch, inside, unit_patch};

/// Round-off of sums of up to a few hundred products of numbers up to 1.
const ROUND_OFF: f64 = 1e-13;

fn cut(dimension: usize, lower: [usize; 3], upper: [usize; 3]) -> IndexBox {
    let mut b = IndexBox { lower, upper };
    for d in dimension..3 {
        (b.lower[d], b.upper[d]) = (0, 1);
    }
    b
}

/// Three levels, 3 × 2 × 1 and then 2 × 3 × 2 parts, two boxes on the first level: at a corner and inside or at the far end.
fn mixed(dimension: usize, p: usize) -> (Patch, SubdomainHierarchy) {
    let n = p + if dimension == 3 { 2 } else { 4 };
    let patch = unit_patch(&vec![p; dimension], &vec![n; dimension]);
    let mut hierarchy = SubdomainHierarchy::new(patch.knots());
    let far = cut(dimension, [n - 2, n - 2, n - 2], [n, n, n]);
    let corner = cut(dimension, [0; 3], [p + 1, p + 1, p + 1]);
    hierarchy.refine([3, 2, 1], &[corner, far]).unwrap();
    // In the first direction at the second level elements 0.. belong to the corner; a box that touches no end needs p + 1.
    // Thin in the other directions where the elements would be many.
    let m = if dimension == 3 && p > 3 { 2 } else { p + 1 };
    hierarchy.refine([2, 3, 2], &[cut(dimension, [1, 0, 0], [p + 2, m, m])]).unwrap();
    (patch, hierarchy)
}

#[test]
fn truncated_functions_sum_to_one_on_every_leaf() {
    for dimension in 1..=3 {
        for p in 1..=5 {
            let (_, hierarchy) = mixed(dimension, p);
            let basis = HierarchicalBasis::new(hierarchy);
            let mut n_mixed = 0;
            for leaf in basis.hierarchy().leaves() {
                let mut builder = OperatorBuilder::default();
                let operator = builder.build(&basis, &leaf, Truncation::Truncated);
                let n = (p + 1).pow(dimension as u32);
                if operator.rows.is_empty() {
                    assert_eq!(operator.functions.len(), n);
                    continue;
                }
                n_mixed += 1;
                for c in 0..n {
                    let sum: f64 = operator.rows.iter().skip(c).step_by(n).sum();
                    assert!((sum - 1.0).abs() < ROUND_OFF, "dimension {dimension} p {p}: {sum}");
                }
                assert!(operator.rows.iter().all(|&v| v >= 0.0));
            }
            assert!(n_mixed > 0, "no element carries several levels");
        }
    }
}

#[test]
fn coefficients_are_the_same_on_all_elements_of_a_spline_and_stored_once() {
    let (mut all_stored, mut all_met) = (0, 0);
    for (dimension, p) in (1..=3).flat_map(|dimension| (1..=4).map(move |p| (dimension, p))) {
        let (patch, hierarchy) = mixed(dimension, p);
        let space = HierarchicalSpace::new(&patch, hierarchy).unwrap();
        let (basis, mut builder) = (space.basis(0), OperatorBuilder::default());
        let (mut known, mut n_met) = (HashMap::new(), 0);
        for (e, leaf) in basis.hierarchy().leaves().enumerate().filter(|&(e, _)| !space.is_single_level(e)) {
            assert_eq!(space.leaf(e).index, leaf.index);
            let operator = builder.build(basis, &leaf, Truncation::Truncated);
            let here = IndexBox { lower: leaf.index, upper: leaf.index.map(|i| i + 1) };
            let splines = basis.hierarchy().levels()[leaf.level].functions_on(&here);
            let rows = operator.rows.chunks(splines.elements().count());
            for (row, &function) in rows.zip(&operator.functions) {
                for (m, &c) in splines.elements().zip(row).filter(|(_, c)| **c != 0.0) {
                    let first = *known.entry((leaf.level, m, function)).or_insert(c);
                    assert!((first - c).abs() < ROUND_OFF, "dimension {dimension} p {p}: {first} and {c}");
                    n_met += 1;
                }
            }
        }
        assert_eq!(space.n_stored(), known.len(), "dimension {dimension} p {p}");
        (all_stored, all_met) = (all_stored + known.len(), all_met + n_met);
    }
    // Each stands on several elements.
    assert!(all_met > 4 * all_stored, "{all_met} and {all_stored}");
}

#[test]
fn every_coarse_function_is_reproduced() {
    for dimension in 1..=3 {
        for p in 1..=5 {
            let (patch, hierarchy) = mixed(dimension, p);
            let space = HierarchicalSpace::new(&patch, hierarchy).unwrap();
            assert!(space.n_functions() > patch.n_functions());
            let coarse = HierarchicalSpace::plain(&patch).unwrap();
            let prolongation = Prolongation::between(&coarse, &space).unwrap();
            let (mut fine, mut plain, mut active) =
                (PointBasis::default(), PointBasis::default(), Vec::new());
            let mut sums = vec![0.0; patch.n_functions()];
            // One point per element, and not every element of the largest cases.
            let step = if dimension == 3 { p } else { 1 };
            for e in (0..space.n_elements()).step_by(step) {
                let xi = inside(&space.element(e), PLACES[e % 2]);
                space.evaluate(e, &xi, 0, &mut fine);
                sums.fill(0.0);
                for (&f, r) in space.functions_on(e).iter().zip(&fine.values) {
                    let (columns, values) = prolongation.row(f as usize);
                    columns.iter().zip(values).for_each(|(&j, v)| sums[j as usize] += v * r);
                }
                let parent = patch.find_element(&xi);
                patch.evaluate(parent, &xi, 0, &mut plain);
                active.clear();
                patch.active_functions(parent, &mut active);
                active.iter().zip(&plain.values).for_each(|(&j, v)| sums[j as usize] -= v);
                let worst = sums.iter().fold(0.0f64, |m, s| m.max(s.abs()));
                assert!(worst < ROUND_OFF, "dimension {dimension} p {p} element {e}: {worst:.2e}");
            }
        }
    }
}

/// Values of all functions of a basis at `(p + 1)` points per direction of every leaf: points by functions.
fn collocation(basis: &HierarchicalBasis, kind: Truncation) -> DMatrix<f64> {
    let dimension = basis.hierarchy().dimension();
    let mut rows = Vec::new();
    for leaf in basis.hierarchy().leaves() {
        let level = &basis.hierarchy().levels()[leaf.level];
        let patch = identity_patch(level.knots().to_vec());
        let sizes: Vec<usize> = patch.element_counts();
        let e = iga_core::splines::tensor::flat_index(&sizes, &leaf.index[..dimension]);
        let mut builder = OperatorBuilder::default();
        let operator = builder.build(basis, &leaf, kind);
        let n = patch.n_active();
        let (lower, upper) = patch.element(e);
        let orders: Vec<usize> = level.knots().iter().map(|k| k.degree() + 1).collect();
        for q in 0..n {
            let k = iga_core::splines::tensor::multi_index(&orders, q);
            let xi = std::array::from_fn(|d| {
                let s = orders.get(d).map_or(0.0, |&m| (k[d] as f64 + 0.5) / m as f64);
                lower[d] + s * (upper[d] - lower[d])
            });
            let mut local = PointBasis::default();
            patch.evaluate(e, &xi, 0, &mut local);
            let mut row = vec![0.0; basis.n_functions()];
            for (r, &f) in operator.functions.iter().enumerate() {
                row[f as usize] = match operator.rows.get(r * n..(r + 1) * n) {
                    Some(c) => c.iter().zip(&local.values).map(|(a, b)| a * b).sum(),
                    None => local.values[r],
                };
            }
            rows.push(row);
        }
    }
    DMatrix::from_fn(rows.len(), basis.n_functions(), |i, j| rows[i][j])
}

/// Rank of a matrix through the eigenvalues of its Gram matrix, which squares its condition: bases of degree up to 3 have
/// condition numbers up to 1e3, so the smallest eigenvalue stays above 1e-8 of the largest and round-off below 1e-13.
fn rank(a: &DMatrix<f64>) -> usize {
    let eigenvalues = (a.transpose() * a).symmetric_eigenvalues();
    let largest = eigenvalues.iter().fold(0.0f64, |m, v| m.max(*v));
    eigenvalues.iter().filter(|v| **v > 1e-11 * largest).count()
}

#[test]
fn functions_are_linearly_independent_and_both_bases_span_one_space() {
    for (dimension, p) in [(1, 1), (1, 2), (1, 3), (1, 5), (2, 1), (2, 2), (3, 1)] {
        let (_, hierarchy) = mixed(dimension, p);
        let basis = HierarchicalBasis::new(hierarchy);
        let n = basis.n_functions();
        let truncated = collocation(&basis, Truncation::Truncated);
        let plain = collocation(&basis, Truncation::Plain);
        assert_eq!((rank(&truncated), rank(&plain)), (n, n), "dimension {dimension} p {p}");
        let m = truncated.nrows();
        let both =
            DMatrix::from_fn(m, 2 * n, |i, j| if j < n { truncated[(i, j)] } else { plain[(i, j - n)] });
        assert_eq!(rank(&both), n, "dimension {dimension} p {p}");
    }
}

#[test]
fn several_boxes_that_touch_are_one_region() {
    let patch = unit_patch(&[2, 2], &[8, 8]);
    let whole = [cut(2, [1, 1, 0], [6, 6, 1])];
    let parts = [cut(2, [1, 1, 0], [4, 6, 1]), cut(2, [3, 1, 0], [6, 4, 1]), cut(2, [3, 3, 0], [6, 6, 1])];
    let build = |boxes: &[IndexBox]| {
        let mut hierarchy = SubdomainHierarchy::new(patch.knots());
        hierarchy.refine([3, 2, 1], boxes).unwrap();
        HierarchicalBasis::new(hierarchy)
    };
    let (a, b) = (build(&whole), build(&parts));
    assert_eq!(a.hierarchy().n_leaves(), b.hierarchy().n_leaves());
    for l in 0..2 {
        assert_eq!(a.active_on_level(l), b.active_on_level(l));
    }
}

#[test]
fn leaves_tile_the_patch_and_are_found_again() {
    let (patch, hierarchy) = mixed(3, 2);
    let space = HierarchicalSpace::new(&patch, hierarchy).unwrap();
    let mut volume = 0.0;
    for e in 0..space.n_elements() {
        let element = space.element(e);
        volume += (0..3).map(|d| element.upper[d] - element.lower[d]).product::<f64>();
        assert_eq!(space.find_element(0, &inside(&element, PLACES[0])), e);
        assert_eq!(space.find_element(0, &element.lower), e);
    }
    assert!((volume - 1.0).abs() < ROUND_OFF);
    // Points outside are clamped.
    assert_eq!(space.find_element(0, &[-1.0; 3]), space.find_element(0, &[0.0; 3]));
    assert_eq!(space.find_element(0, &[2.0; 3]), space.find_element(0, &[1.0; 3]));
}

#[test]
fn boxes_that_refine_nothing_or_are_not_nested_are_refused() {
    let knots = vec![KnotVector::uniform(3, 10).unwrap(); 2];
    let text = |hierarchy: &mut SubdomainHierarchy, parts, b| {
        hierarchy.refine(parts, &[b]).map(|()| String::new()).unwrap_or_else(|e: SplineError| e.to_string())
    };
    let mut hierarchy = SubdomainHierarchy::new(&knots);
    // Three elements inside hold no support of a cubic function, four do; at the end of the patch one is enough.
    assert!(text(&mut hierarchy, [2, 2, 1], cut(2, [3, 2, 0], [6, 8, 1])).contains("too small"));
    assert!(text(&mut hierarchy, [2, 2, 1], cut(2, [9, 2, 0], [12, 8, 1])).contains("not inside"));
    assert!(text(&mut hierarchy, [2, 2, 1], cut(2, [4, 2, 0], [4, 8, 1])).contains("no element"));
    assert!(text(&mut hierarchy, [1, 1, 5], cut(2, [0, 0, 0], [9, 9, 1])).contains("refines nothing"));
    assert!(text(&mut hierarchy, [0, 2, 1], cut(2, [0, 0, 0], [9, 9, 1])).contains("refines nothing"));
    assert!(hierarchy.refine([2, 2, 1], &[]).is_err());
    assert_eq!(hierarchy.levels().len(), 1);
    assert_eq!(text(&mut hierarchy, [2, 2, 1], cut(2, [3, 2, 0], [7, 8, 1])), "");
    assert!(text(&mut hierarchy, [2, 2, 1], cut(2, [5, 4, 0], [9, 8, 1])).contains("refine more"));
    assert_eq!(text(&mut hierarchy, [2, 3, 1], cut(2, [6, 4, 0], [10, 8, 1])), "");
}

#[test]
fn coarse_knots_keep_their_multiplicity_on_finer_levels() {
    let knots = KnotVector::new(3, vec![0., 0., 0., 0., 0.25, 0.5, 0.5, 0.75, 1., 1., 1., 1.]).unwrap();
    let mut hierarchy = SubdomainHierarchy::new(&[knots]);
    hierarchy.refine([3, 1, 1], &[cut(1, [0; 3], [4; 3])]).unwrap();
    let fine = &hierarchy.levels()[1].knots()[0];
    assert_eq!((fine.multiplicity(0.5), fine.multiplicity(0.25), fine.n_elements()), (2, 1, 12));
    // Wholly refined: only functions of the last level are active.
    let basis = HierarchicalBasis::new(hierarchy);
    assert_eq!(basis.active_on_level(0).len(), 0);
    assert_eq!(basis.n_functions(), basis.hierarchy().levels()[1].knots()[0].n_functions());
}

#[test]
fn single_level_smooth_elements_take_fewer_gauss_points() {
    let (patch, hierarchy) = mixed(2, 3);
    let space = HierarchicalSpace::new(&patch, hierarchy).unwrap();
    let (mut few, mut many) = (0, 0);
    for e in 0..space.n_elements() {
        match (space.gauss_counts(e), space.is_single_level(e)) {
            ([3, 3, 1], true) => few += 1,
            ([4, 4, 1], false) => many += 1,
            other => panic!("element {e}: {other:?}"),
        }
    }
    assert!(few > 0 && many > 0);
}
