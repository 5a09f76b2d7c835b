//! Hierarchical spaces in three directions: three levels, about 5000 leaves, degree 3.

use divan::Bencher;
use iga_core::hierarchical::{HierarchicalSpace, IndexBox, Prolongation, SubdomainHierarchy};
use iga_core::nurbs::Patch;
use iga_core::nurbs::patch::PointBasis;
use iga_core::space::Space;
use iga_core::splines::knots::KnotVector;
use iga_core::splines::tensor;

fn main() {
    let (patch, hierarchy) = case();
    let space = HierarchicalSpace::new(&patch, hierarchy).expect("the boxes are nested");
    let n_single = (0..space.n_elements()).filter(|&e| space.is_single_level(e)).count();
    let most = (0..space.n_elements()).map(|e| space.functions_on(e).len()).max();
    divan::Divan::from_args().main();
    let report = format!(
        "{} leaves ({n_single} single-level), {} functions, up to {most:?} on an element, {} coefficients stored",
        space.n_elements(),
        space.n_functions(),
        space.n_stored()
    );
    #[expect(clippy::print_stdout, reason = "size of the case beside its times")]
    {
        println!("{report}");
    }
}

fn case() -> (Patch, SubdomainHierarchy) {
    let knots = vec![KnotVector::uniform(3, 12).expect("valid knots"); 3];
    let sizes: Vec<usize> = knots.iter().map(KnotVector::n_functions).collect();
    let abscissae = knots[0].greville();
    let n = tensor::count(&sizes);
    let points = (0..n).map(|a| tensor::multi_index(&sizes, a).map(|i| abscissae[i])).collect();
    let patch = Patch::new(knots, points, vec![1.0; n]).expect("valid net");
    let mut hierarchy = SubdomainHierarchy::new(patch.knots());
    let first = IndexBox { lower: [3, 3, 7], upper: [9, 9, 12] };
    hierarchy.refine([2, 2, 2], &[first]).expect("large enough");
    let second = IndexBox { lower: [8, 8, 19], upper: [16, 16, 24] };
    hierarchy.refine([2, 2, 2], &[second]).expect("large enough");
    (patch, hierarchy)
}

#[divan::bench]
fn build_space(bencher: Bencher) {
    bencher.with_inputs(case).bench_values(|(patch, h)| HierarchicalSpace::new(&patch, h).expect("nested"));
}

#[divan::bench]
fn prolong_from_plain_patch(bencher: Bencher) {
    let (patch, hierarchy) = case();
    let coarse = HierarchicalSpace::plain(&patch).expect("valid");
    let fine = HierarchicalSpace::new(&patch, hierarchy).expect("nested");
    bencher.bench(|| Prolongation::between(&coarse, &fine).expect("nested"));
}

/// Values and first derivatives at one point of every single-level (or every other) leaf.
fn evaluate(bencher: Bencher, single: bool) {
    let (patch, hierarchy) = case();
    let space = HierarchicalSpace::new(&patch, hierarchy).expect("nested");
    let elements: Vec<usize> =
        (0..space.n_elements()).filter(|&e| space.is_single_level(e) == single).take(1000).collect();
    let mut basis = PointBasis::default();
    bencher.bench_local(|| {
        for &e in &elements {
            let element = space.element(e);
            let xi = std::array::from_fn(|d| 0.3 * element.lower[d] + 0.7 * element.upper[d]);
            space.evaluate(e, &xi, 1, &mut basis);
        }
    });
}

#[divan::bench]
fn evaluate_1000_single_level(bencher: Bencher) {
    evaluate(bencher, true);
}

#[divan::bench]
fn evaluate_1000_mixed(bencher: Bencher) {
    evaluate(bencher, false);
}

#[divan::bench]
fn evaluate_1000_plain_patch(bencher: Bencher) {
    let (patch, _) = case();
    let mut basis = PointBasis::default();
    bencher.bench_local(|| {
        for e in 0..1000 {
            let (a, b) = patch.element(e);
            let xi = std::array::from_fn(|d| 0.3 * a[d] + 0.7 * b[d]);
            patch.evaluate(e, &xi, 1, &mut basis);
        }
    });
}
