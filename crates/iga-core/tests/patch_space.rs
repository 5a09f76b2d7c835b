//! Tying of coincident functions and evaluation of the tied basis.

use crate::bodies;
use crate::bodies::noise;
use iga_core::elasticity::assembly::assemble;
use iga_core::elasticity::{Material, Model};
use iga_core::nurbs::Patch;
use iga_core::nurbs::interface::FaceId;
use iga_core::nurbs::patch::PointBasis;
use iga_core::space::{Element, GridBasis, Integrand, PatchSpace, Space, SplineSpace, tabulate_spline};
use iga_core::splines::knots::KnotVector;

/// Half disc in `(r, z)` with both ends of the arc collapsed onto the axis: polar coordinates, centre collapsed too.
fn polar_half_disc() -> Patch {
    let w = 0.5f64.sqrt();
    let directions = [(0.0, -1.0, 1.0), (1.0, -1.0, w), (1.0, 0.0, 1.0), (1.0, 1.0, w), (0.0, 1.0, 1.0)];
    let mut points = Vec::new();
    let mut weights = Vec::new();
    for (x, y, w) in directions {
        points.extend([[0.0; 3], [x, y, 0.0]]);
        weights.extend([w, w]);
    }
    let knots = vec![
        KnotVector::uniform(1, 1).unwrap(),
        KnotVector::new(2, vec![0.0, 0.0, 0.0, 0.5, 0.5, 1.0, 1.0, 1.0]).unwrap(),
    ];
    Patch::new(knots, points, weights).unwrap()
}

fn refined_half_disc() -> Patch {
    let knots = [
        KnotVector::uniform(2, 3).unwrap(),
        KnotVector::new(3, vec![0., 0., 0., 0., 0.25, 0.5, 0.5, 0.5, 0.75, 1., 1., 1., 1.]).unwrap(),
    ];
    bodies::refined(&polar_half_disc(), &knots)
}

#[test]
fn collapsed_edge_becomes_one_function() {
    let patch = refined_half_disc();
    let n = patch.n_functions();
    let around = patch.net_size()[1];
    let space = PatchSpace::new(vec![patch]).unwrap();
    assert_eq!(space.n_functions(), n - around + 1);
    assert!((0..around).all(|j| space.functions(0)[j * 5] == 0));
    assert!(bodies::largest(&space.anchors()[0]) < 0.5);
}

#[test]
fn neighbouring_patches_share_the_functions_of_their_interface() {
    let left = bodies::uniform(&bodies::quadrilateral([[0., 0.], [1., 0.], [0., 1.], [1., 1.]]), 2, &[3, 4]);
    let right = bodies::uniform(&bodies::quadrilateral([[1., 0.], [3., 0.], [1., 1.], [3., 1.]]), 2, &[2, 4]);
    let (a, b) = (left.n_functions(), right.n_functions());
    let space = PatchSpace::new(vec![left, right]).unwrap();
    assert_eq!(space.n_functions(), a + b - 6);
    for j in 0..6 {
        assert_eq!(space.functions(0)[4 + 5 * j], space.functions(1)[4 * j]);
    }
    assert_eq!((space.n_elements(), space.element(12).patch, space.find_element(1, &[0.0; 3])), (20, 1, 12));
}

#[test]
fn interior_control_points_are_never_tied() {
    let patch = bodies::uniform(&bodies::quadrilateral([[0., 0.], [1., 0.], [0., 1.], [1., 1.]]), 2, &[3, 3]);
    let mut points = patch.control_points().to_vec();
    points[6] = points[7];
    let patch = Patch::new(patch.knots().to_vec(), points, patch.weights().to_vec()).unwrap();
    assert_eq!(PatchSpace::new(vec![patch]).unwrap().n_functions(), 25);
}

#[test]
fn tied_basis_sums_to_one_and_reproduces_the_geometry() {
    let patch = refined_half_disc();
    let space = PatchSpace::new(vec![patch.clone()]).unwrap();
    let (mut basis, mut active) = (PointBasis::default(), Vec::new());
    for xi in noise(60, 3).chunks(2) {
        let xi = [0.5 + 0.5 * xi[0], 0.5 + 0.5 * xi[1], 0.0];
        let e = space.find_element(0, &xi);
        space.active_functions(e, &mut active);
        space.evaluate(e, &xi, 2, &mut basis);
        assert_eq!((active.len(), basis.first.len()), (basis.values.len(), basis.second.len()));
        let mut sorted = active.clone();
        sorted.sort_unstable();
        sorted.dedup();
        assert_eq!(sorted.len(), active.len());
        assert!((basis.values.iter().sum::<f64>() - 1.0).abs() < 1e-14);
        assert!(basis.first.iter().map(|f| f[0] + f[1]).sum::<f64>().abs() < 1e-12);
        for (c, x) in patch.point(&xi).iter().enumerate() {
            let sum: f64 = active
                .iter()
                .zip(&basis.values)
                .map(|(&a, v)| v * space.control_points()[a as usize][c])
                .sum();
            assert!((sum - x).abs() < 1e-14);
        }
    }
}

/// Forwards everything but `evaluate_grid` and combinations, so that the general path runs, element by element.
pub struct General<'a, S>(pub &'a S);

impl<S: SplineSpace> Space for General<'_, S> {
    fn dimension(&self) -> usize {
        self.0.dimension()
    }
    fn n_functions(&self) -> usize {
        self.0.n_functions()
    }
    fn control_points(&self) -> &[[f64; 3]] {
        self.0.control_points()
    }
    fn anchors(&self) -> Vec<[f64; 3]> {
        self.0.anchors()
    }
    fn n_elements(&self) -> usize {
        self.0.n_elements()
    }
    fn element(&self, e: usize) -> Element {
        self.0.element(e)
    }
    fn tabulate(&self, e: usize, integrand: Integrand, out: &mut GridBasis) {
        tabulate_spline(self, e, integrand, out);
    }
    fn active_functions(&self, e: usize, out: &mut Vec<u32>) {
        self.0.active_functions(e, out);
    }
    fn evaluate(&self, e: usize, xi: &[f64; 3], n_derivatives: usize, out: &mut PointBasis) {
        self.0.evaluate(e, xi, n_derivatives, out);
    }
}

impl<S: SplineSpace> SplineSpace for General<'_, S> {
    fn find_element(&self, patch: usize, xi: &[f64; 3]) -> usize {
        self.0.find_element(patch, xi)
    }
    fn gauss_counts(&self, e: usize) -> [usize; 3] {
        self.0.gauss_counts(e)
    }
    fn greville(&self, face: FaceId) -> Vec<(u32, [f64; 3])> {
        self.0.greville(face)
    }
}

#[test]
fn tensor_evaluation_equals_point_by_point_evaluation() {
    let cylinder = bodies::uniform(&bodies::cylinder(0.3, 1.0), 3, &[2, 3, 2]);
    for patch in [refined_half_disc(), cylinder] {
        let space = PatchSpace::new(vec![patch]).unwrap();
        let (mut fast, mut general) = (GridBasis::default(), GridBasis::default());
        for e in 0..space.n_elements() {
            let element = space.element(e);
            let grid: Vec<Vec<f64>> = (0..3)
                .map(|d| {
                    let at = |s: f64| element.lower[d] + s * (element.upper[d] - element.lower[d]);
                    if d < space.dimension() { vec![at(0.1), at(0.5), at(0.8)] } else { vec![0.0] }
                })
                .collect();
            let grid = [&grid[0][..], &grid[1][..], &grid[2][..]];
            space.evaluate_grid(e, grid, &mut fast);
            General(&space).evaluate_grid(e, grid, &mut general);
            assert_eq!((fast.n_active, fast.n_points), (general.n_active, general.n_points));
            let close = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(x, y)| (x - y).abs() < 1e-12); // round-off
            assert!(close(&fast.values, &general.values));
            assert!((0..3).all(|d| close(&fast.first[d], &general.first[d])));
        }
    }
}

#[test]
fn general_evaluation_assembles_the_same_matrices() {
    let material = Material::new(210e9, 0.3, 7850.0).unwrap();
    let space = PatchSpace::new(vec![refined_half_disc()]).unwrap();
    let fast = assemble(&space, &Model::Axisymmetric, &material).unwrap();
    let general = assemble(&General(&space), &Model::Axisymmetric, &material).unwrap();
    assert_eq!(fast.dofs, general.dofs);
    for (a, b) in [(&fast.stiffness, &general.stiffness), (&fast.mass, &general.mass)] {
        let scale = bodies::largest(a.val());
        assert!(a.val().iter().zip(b.val()).all(|(x, y)| (x - y).abs() < 1e-13 * scale)); // round-off
    }
}

#[test]
fn linear_displacements_balance_across_a_patch_interface() {
    let left = bodies::uniform(&bodies::quadrilateral([[0., 0.], [1., 0.], [0., 1.], [1.3, 1.]]), 2, &[2, 3]);
    let right =
        bodies::uniform(&bodies::quadrilateral([[1., 0.], [3., 0.], [1.3, 1.], [3., 1.]]), 2, &[3, 3]);
    let space = PatchSpace::new(vec![left, right]).unwrap();
    let material = Material::new(210e9, 0.3, 7850.0).unwrap();
    let matrices = assemble(&space, &Model::PlaneStrain { thickness: 1.0 }, &material).unwrap();
    let gradient = [[1e-3, 2e-3, 0.0], [-1e-3, 3e-3, 0.0], [0.0; 3]];
    let u = bodies::linear_field(space.control_points(), 2, gradient, [0.0; 3]);
    let force = bodies::multiply(&matrices.stiffness, &bodies::at_unknowns(&matrices.dofs, &u, 2));
    let (mut inside, mut n_inside) = (0.0f64, 0);
    for (f, &(node, _)) in force.iter().zip(&matrices.dofs) {
        let [x, y, _] = space.control_points()[node as usize];
        if x > 1e-9 && x < 3.0 - 1e-9 && y > 1e-9 && y < 1.0 - 1e-9 {
            (inside, n_inside) = (inside.max(f.abs()), n_inside + 1);
        }
    }
    assert_eq!(n_inside, 2 * (2 + 3 + 1) * 3); // three rows inside, the interface one node of each
    assert!(inside < 1e-12 * bodies::largest(&force)); // round-off
}

#[test]
fn gauss_counts_grow_beside_collapsed_edges_and_rough_knots_only() {
    let space = PatchSpace::new(vec![refined_half_disc()]).unwrap();
    // Three elements along the radius (the first one touches the centre), four around with a C^0 line in the middle.
    for e in 0..12 {
        let expected = match (e % 3, e / 3) {
            (0, _) => [3, 4, 1],
            (_, 1 | 2) => [2, 4, 1],
            _ => [2, 3, 1],
        };
        assert_eq!(space.gauss_counts(e), expected, "element {e}");
    }
    let single = PatchSpace::new(vec![bodies::disc(1.0)]).unwrap();
    assert_eq!(single.gauss_counts(0), [3, 3, 1]);
}

#[test]
fn spaces_without_patches_or_with_mixed_dimensions_are_refused() {
    assert!(PatchSpace::new(vec![]).is_err());
    assert!(PatchSpace::new(vec![bodies::disc(1.0), bodies::cylinder(1.0, 1.0)]).is_err());
}
