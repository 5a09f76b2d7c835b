//! Matrices from raw functions of each level are those of the functions themselves.

use crate::patch_space::General;
use faer::sparse::SparseColMat;
use iga_core::ParameterBox;
use iga_core::elasticity::assembly::assemble;
use iga_core::elasticity::{ElementMaterials, Material, Model};
use iga_core::hierarchical::{HierarchicalSpace, PatchTies, SubdomainHierarchy};
use iga_core::nurbs::Patch;
use iga_core::nurbs::patch::PointBasis;
use iga_core::nurbs::primitives::axisymmetric;
use iga_core::space::{GridBasis, Space};

use super::nets::{refine_around, unit_patch};
use super::patches::{ball, refined_about, regions};

/// Largest difference of two matrices of one pattern, entries relative to the roots of the diagonal
/// entries of their row and column.
fn difference(a: &SparseColMat<u32, f64>, b: &SparseColMat<u32, f64>) -> f64 {
    assert_eq!(a.symbolic().row_idx(), b.symbolic().row_idx());
    let diagonal: Vec<f64> = (0..b.ncols()).map(|j| b[(j, j)].sqrt()).collect();
    let pairs = a.triplet_iter().zip(b.val());
    pairs.map(|(t, b)| (t.val - b).abs() / (diagonal[t.row] * diagonal[t.col])).fold(0.0, f64::max)
}

/// Round-off, 1e-16, of sums of a thousand products. Raw functions about a collapsed side, which
/// are one function together, have entries up to a thousand times as large as what they add up to.
/// A wrong coefficient is off by more than 1e-3.
const ROUND_OFF: f64 = 1e-10;

/// Compares the matrices of a space that has combinations, and all pairs of two materials in its
/// elements, with the element by element ones.
fn check(space: &HierarchicalSpace, model: &Model, name: &str) {
    assert!(!space.combinations().is_empty(), "{name}");
    let materials = vec![Material::new(1.0, 0.3, 2.0).unwrap(), Material::new(1.7, 0.1, 1.0).unwrap()];
    let of_element = (0..space.n_elements()).map(|e| u16::from(e % 3 == 1)).collect();
    let materials = ElementMaterials::new(materials, of_element);
    let (found, expected) =
        (assemble(space, model, &materials).unwrap(), assemble(&General(space), model, &materials).unwrap());
    assert_eq!(found.dofs, expected.dofs, "{name}");
    for (what, a, b) in [("K", &found.stiffness, &expected.stiffness), ("M", &found.mass, &expected.mass)] {
        let error = difference(a, b);
        assert!(error < ROUND_OFF, "{name} {model:?} {what}: {error:e}");
    }
}

/// The ring of the other tests with its directions in the order of a right hand.
fn ring(dimension: usize, n_arcs: usize, inner: f64, elements: &[usize]) -> Patch {
    super::nets::ring(dimension, n_arcs, inner, elements).reversed(0).unwrap()
}

fn refined(patch: &Patch, regions: &[ParameterBox]) -> HierarchicalSpace {
    let ties = PatchTies::detect(patch);
    let mut hierarchy = SubdomainHierarchy::new(patch.knots());
    refine_around(&mut hierarchy, [2, 3, 2], regions, &ties);
    refine_around(&mut hierarchy, [2, 2, 1], regions, &ties);
    HierarchicalSpace::new(patch, hierarchy).unwrap()
}

const PLANE: [Model; 2] = [Model::PlaneStrain { thickness: 0.3 }, Model::PlaneStress { thickness: 0.3 }];

#[test]
fn matrices_of_plane_bodies_are_those_of_their_elements() {
    let corner = ParameterBox { lower: [0.0; 3], upper: [0.1, 0.1, 0.0] };
    let middle = ParameterBox { lower: [0.4, 0.3, 0.0], upper: [0.45, 0.4, 0.0] };
    for model in PLANE {
        for p in 1..=5 {
            let space = refined(&unit_patch(&[p, p], &[6, 5]), &[corner]);
            check(&space, &model, &format!("square of degree {p}"));
        }
        check(&refined(&ring(2, 3, 0.2, &[4, 6]), &[middle]), &model, "ring");
        check(&refined(&ring(2, 4, 0.0, &[4, 6]), &[corner]), &model, "disc about pole and seam");
    }
}

#[test]
fn matrices_of_axisymmetric_bodies_are_those_of_their_elements() {
    let corner = ParameterBox { lower: [0.0; 3], upper: [0.1, 0.1, 0.0] };
    for p in 2..=4 {
        let space = refined(&unit_patch(&[p, p], &[6, 5]), &[corner]);
        check(&space, &Model::Axisymmetric, &format!("disc of degree {p}, on its axis"));
    }
    let ball = axisymmetric::sphere(1.0).unwrap();
    let knots = ball.patches[0].knots().iter().map(|k| super::nets::split(k, 4)).collect();
    let ball = super::nets::refined(&ball.patches[0], knots);
    for region in [corner, ParameterBox { lower: [0.9, 0.0, 0.0], upper: [1.0, 0.1, 0.0] }] {
        check(&refined(&ball, &[region]), &Model::Axisymmetric, "ball");
    }
}

#[test]
fn matrices_of_solids_are_those_of_their_elements() {
    let corner = ParameterBox { lower: [0.0; 3], upper: [0.1; 3] };
    for (degrees, elements) in [([2, 2, 2], [4, 4, 3]), ([3, 2, 1], [4, 3, 3]), ([4, 4, 4], [3, 3, 3])] {
        check(&refined(&unit_patch(&degrees, &elements), &[corner]), &Model::Solid, &format!("{degrees:?}"));
    }
    check(&refined(&ring(3, 1, 0.3, &[4, 3, 3]), &[corner]), &Model::Solid, "block of a ring");
    let top = ParameterBox { lower: [0.4, 0.0, 0.9], upper: [0.5, 0.1, 1.0] };
    check(&refined(&ring(3, 4, 0.0, &[2, 5, 6]), &[top]), &Model::Solid, "cylinder about its axis");
}

#[test]
fn matrices_of_several_patches_are_those_of_their_elements() {
    check_regions(0..1, 1);
}

#[test]
#[ignore = "second tier: half a minute"]
fn matrices_of_several_patches_are_those_of_their_elements_wherever_they_are_refined() {
    check_regions(0..usize::MAX, 2);
}

/// Refined `by` so many elements about each region.
fn check_regions(numbers: std::ops::Range<usize>, by: usize) {
    let patches = ball();
    for (k, regions) in regions(&patches).iter().enumerate().filter(|(k, _)| numbers.contains(k)) {
        check(&refined_about(&patches, regions, by), &Model::Solid, &format!("ball, regions {k}"));
    }
}

#[test]
fn raw_functions_are_one_together_and_reproduce_the_geometry() {
    let region = ParameterBox { lower: [0.0; 3], upper: [0.1, 0.1, 0.1] };
    let space = refined(&ring(3, 1, 0.3, &[4, 3, 3]), &[region]);
    let (mut own, mut raw, mut grid) = (PointBasis::default(), PointBasis::default(), GridBasis::default());
    let (mut functions, mut numbers) = (Vec::new(), Vec::new());
    for set in space.combinations() {
        for (k, &e) in set.elements.iter().enumerate() {
            let element = space.element(e);
            assert_eq!(set.raw.element(k), element);
            let xi = super::nets::inside(&element, [0.3, 0.6, 0.2]);
            space.evaluate(e, &xi, 2, &mut own);
            set.raw.evaluate(k, &xi, 2, &mut raw);
            set.raw.evaluate_grid(k, [&xi[..1], &xi[1..2], &xi[2..]], &mut grid);
            space.active_functions(e, &mut functions);
            set.raw.active_functions(k, &mut numbers);
            assert!((raw.values.iter().sum::<f64>() - 1.0).abs() < 1e-14); // round-off
            for (i, f) in functions.iter().enumerate() {
                let row = set.functions.binary_search(f).unwrap();
                let (mut value, mut first, mut second) = (0.0, [0.0; 3], [0.0; 6]);
                for (m, &number) in numbers.iter().enumerate() {
                    let c = set.coefficients.get(row, number as usize).copied().unwrap_or_default();
                    value += c * raw.values[m];
                    (0..3).for_each(|d| first[d] += c * raw.first[m][d]);
                    (0..6).for_each(|d| second[d] += c * raw.second[m][d]);
                }
                let close = |a: f64, b: f64, scale: f64| (a - b).abs() < 1e-13 * scale; // round-off
                assert!(close(value, own.values[i], 1.0));
                // Elements are as small as 1/36 of the patch.
                assert!((0..3).all(|d| close(first[d], own.first[i][d], 40.0)));
                assert!((0..6).all(|d| close(second[d], own.second[i][d], 1600.0)));
            }
            let place = |list: &[f64], numbers: &[u32], points: &[[f64; 3]]| -> [f64; 3] {
                std::array::from_fn(|c| {
                    list.iter().zip(numbers).map(|(r, &f)| r * points[f as usize][c]).sum()
                })
            };
            let x = place(&own.values, &functions, space.control_points());
            for values in [&raw.values, &grid.values] {
                let y = place(values, &numbers, set.raw.control_points());
                assert!((0..3).all(|c| (x[c] - y[c]).abs() < 1e-14)); // round-off
            }
        }
    }
}

#[test]
fn every_number_of_threads_gives_the_same_bits() {
    let region = ParameterBox { lower: [0.0; 3], upper: [0.1; 3] };
    let space = refined(&ring(3, 1, 0.3, &[5, 4, 4]), &[region]);
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let material = Material::new(1.0, 0.3, 1.0).unwrap();
        let matrices = pool.install(|| assemble(&space, &Model::Solid, &material).unwrap());
        let all = matrices.stiffness.val().iter().chain(matrices.mass.val());
        all.map(|v| v.to_bits()).collect::<Vec<_>>()
    };
    let one = run(1);
    assert!([2, 3, 5].iter().all(|&threads| run(threads) == one));
}
