//! The same identities over a list of spaces: patches, hierarchical splines, every kind of element, each mesh divided as well.

use crate::blocks::{block, divisible, steel};
use crate::matrices::times as times_matrix;
use crate::refined::largest;
use faer::{Mat, Side};
use fe_mesh::element::rules::MassRule;
use fe_mesh::element::shape::Functions;
use fe_mesh::refined::{CellBall, RefinedMesh};
use fe_mesh::{ElementKind, Mesh, MeshSpace};
use iga_core::ParameterBox;
use iga_core::elasticity::assembly::assemble;
use iga_core::elasticity::kinematics::PointState;
use iga_core::elasticity::mass_properties::MassProperties;
use iga_core::elasticity::recovery::RecoveryWorkspace;
use iga_core::elasticity::{MaterialField, Model};
use iga_core::hierarchical::{HierarchicalSpace, PatchTies, SubdomainHierarchy};
use iga_core::nurbs::Patch;
use iga_core::nurbs::patch::PointBasis;
use iga_core::space::{GridBasis, Integrand, PatchSpace, Space};
use iga_core::splines::knots::KnotVector;
use iga_core::splines::tensor;

/// Rows of the map from the unit cube to the body.
const MAP: [[f64; 3]; 3] = [[1.1, 0.2, 0.0], [0.0, 0.9, -0.1], [0.15, 0.0, 1.0]];
/// Gradient of a displacement.
const GRADIENT: [[f64; 3]; 3] = [[1e-3, 2e-4, -3e-4], [5e-4, -7e-4, 1e-4], [2e-4, 6e-4, 4e-4]];

fn times(rows: &[[f64; 3]; 3], x: &[f64; 3]) -> [f64; 3] {
    rows.map(|row| (0..3).map(|j| row[j] * x[j]).sum())
}

fn mapped(x: [f64; 3]) -> [f64; 3] {
    times(&MAP, &x)
}

/// Where the point with the parameters of an element lies.
type Place<'a> = &'a dyn Fn(usize, &[f64; 3]) -> [f64; 3];

/// Calls `check` with every space of the body, its name, and the place of its points.
fn for_each_space(check: &dyn Fn(&str, &dyn Space, Place<'_>)) {
    for degree in 1..=3 {
        let knots: Vec<KnotVector> = (0..3).map(|_| KnotVector::uniform(degree, 3).unwrap()).collect();
        let sizes: Vec<usize> = knots.iter().map(KnotVector::n_functions).collect();
        let greville: Vec<Vec<f64>> = knots.iter().map(KnotVector::greville).collect();
        let point = |a: usize| {
            let index = tensor::multi_index(&sizes, a);
            mapped(std::array::from_fn(|d| greville[d][index[d]]))
        };
        let n = sizes.iter().product();
        let patch = Patch::new(knots.clone(), (0..n).map(point).collect(), vec![1.0; n]).unwrap();
        let place = |_: usize, xi: &[f64; 3]| mapped(*xi);
        let plain = PatchSpace::new(vec![patch.clone()]).unwrap();
        check(&format!("patch of degree {degree}"), &plain, &place);
        let mut hierarchy = SubdomainHierarchy::new(patch.knots());
        let corner = ParameterBox { lower: [0.0; 3], upper: [0.2; 3] };
        let boxes = hierarchy.elements_around(&[corner], [degree; 3], &PatchTies::detect(&patch)).unwrap();
        hierarchy.refine([2; 3], &boxes).unwrap();
        let refined = HierarchicalSpace::new(&patch, hierarchy).unwrap();
        check(&format!("hierarchy of degree {degree}"), &refined, &place);
    }
    for kind in ElementKind::SOLID {
        let mesh = Mesh::new(block(kind, [2, 1, 1], mapped), 1.0).unwrap();
        check(kind.name(), &MeshSpace::new(mesh.clone(), MassRule::Exact), &|e, xi| place_in(&mesh, e, xi));
        let corner = mapped([0.0, 0.1, 0.2]);
        let is_near = |ball: &CellBall| {
            let aside: f64 = (0..3).map(|d| (ball.centre[d] - corner[d]).powi(2)).sum();
            ball.level < 1 && aside.sqrt() < ball.radius && ball.centre[0] < 0.5
        };
        let mesh = Mesh::new(divisible(kind, [2, 1, 1], mapped), 1.0).unwrap();
        let divided = RefinedMesh::new(&mesh, is_near, 10_000).unwrap();
        assert!(divided.n_free() < divided.mesh().nodes().len(), "{kind:?}: nothing hangs");
        let space = MeshSpace::divided(&divided, MassRule::Exact);
        check(&format!("divided {}", kind.name()), &space, &|e, xi| place_in(divided.mesh(), e, xi));
    }
}

/// By all nodes of the element, those that hang among them.
fn place_in(mesh: &Mesh, e: usize, xi: &[f64; 3]) -> [f64; 3] {
    let element = mesh.elements().get(e);
    let (mut functions, mut places) = (Functions::default(), Vec::new());
    element.kind.functions(xi, &mut functions);
    mesh.places(element.nodes, &mut places);
    fe_mesh::element::jacobian::position(&functions.values, &places)
}

#[test]
fn functions_sum_to_one_and_to_the_place() {
    for_each_space(&|name, space, place| {
        let (mut rule, mut basis, mut active) = (GridBasis::default(), PointBasis::default(), Vec::new());
        for e in 0..space.n_elements() {
            space.active_functions(e, &mut active);
            space.tabulate(e, Integrand::Mass, &mut rule);
            let mut volume = 0.0;
            for (q, xi) in rule.parameters.iter().enumerate() {
                space.evaluate(e, xi, 1, &mut basis);
                // Sums of some dozen numbers below one; slopes are some units.
                assert!((basis.values.iter().sum::<f64>() - 1.0).abs() < 1e-13, "{name}");
                for d in 0..3 {
                    assert!(basis.first.iter().map(|f| f[d]).sum::<f64>().abs() < 1e-12, "{name}");
                    let sum = active.iter().zip(&basis.values);
                    let sum: f64 = sum.map(|(&a, v)| v * space.control_points()[a as usize][d]).sum();
                    assert!((sum - place(e, xi)[d]).abs() < 1e-13, "{name}: {sum}");
                }
                // Tables are what is evaluated.
                let same = rule.values_at(q).iter().zip(&basis.values).all(|(a, b)| (a - b).abs() < 1e-14);
                assert!(same && rule.values_at(q).len() == active.len(), "{name}");
                volume += rule.weights[q];
            }
            let element = space.element(e);
            let box_volume: f64 = (0..3).map(|d| element.upper[d] - element.lower[d]).product();
            let shares = [1.0, 1.0 / 6.0, 0.5, 1.0 / 3.0].map(|share| (volume / box_volume - share).abs());
            assert!(shares.iter().any(|s| *s < 1e-14), "{name}: {volume}");
            space.evaluate(e, &element.centre(), 0, &mut basis);
            assert!((basis.values.iter().sum::<f64>() - 1.0).abs() < 1e-13, "{name}");
        }
    });
}

#[test]
fn stiffness_has_six_free_motions_and_mass_is_that_of_the_body() {
    for_each_space(&|name, space, _| {
        let matrices = assemble(space, &Model::Solid, &steel()).unwrap();
        let (stiffness, n) = (&matrices.stiffness, 3 * space.n_functions());
        let places = space.control_points();
        let scale = largest(stiffness.val());
        for motion in 0..6 {
            let of = |[x, y, z]: &[f64; 3]| match motion {
                3 => [0.0, -z, *y],
                4 => [*z, 0.0, -x],
                5 => [-y, *x, 0.0],
                d => [0, 1, 2].map(|c| f64::from(u8::from(c == d))),
            };
            let force = times_matrix(stiffness, &places.iter().flat_map(of).collect::<Vec<_>>());
            // Sums of some hundred products of the size of the largest entry.
            assert!(largest(&force) < 1e-12 * scale, "{name}, motion {motion}");
        }
        let mut dense = Mat::<f64>::zeros(n, n);
        for j in 0..n {
            for p in stiffness.symbolic().col_range(j) {
                dense[(stiffness.row_idx()[p] as usize, j)] = stiffness.val()[p];
            }
        }
        let mut values = dense.self_adjoint_eigenvalues(Side::Lower).unwrap();
        values.sort_by(f64::total_cmp);
        let top = values[n - 1];
        // Zero ones are round-off of the largest; the first of the others is some thousandths of it or more.
        assert!(values[5].abs() < 1e-13 * top && values[6] > 1e-7 * top, "{name}: {:?}", &values[..8]);
        let mass: f64 = times_matrix(&matrices.mass, &vec![1.0; n / 3]).iter().sum();
        assert!((mass / (steel().density() * volume()) - 1.0).abs() < 1e-12, "{name}: {mass}");
    });
}

/// Volume of the body: the determinant of its map.
fn volume() -> f64 {
    let [a, b, c] = MAP;
    fe_mesh::element::jacobian::determinant(&[a, b, c])
}

#[test]
fn moments_are_those_of_the_block() {
    // The unit cube has ∫ u_i = 1/2, ∫ u_i u_j = 1/4, on the diagonal 1/3.
    let first = mapped([0.5; 3]).map(|x| x * volume());
    let cube = |i: usize, j: usize| if i == j { 1.0 / 3.0 } else { 0.25 };
    for_each_space(&|name, space, _| {
        let found = MassProperties::of_space(space, &Model::Solid, &|_| 1.0).unwrap();
        assert!((found.volume / volume() - 1.0).abs() < 1e-13, "{name}");
        for (i, row) in MAP.iter().enumerate() {
            assert!((found.first_moment[i] - first[i]).abs() < 1e-13, "{name}");
            for (j, other) in MAP.iter().enumerate() {
                let pairs = (0..3).flat_map(|k| (0..3).map(move |l| (k, l)));
                let second: f64 = pairs.map(|(k, l)| row[k] * other[l] * cube(k, l)).sum();
                assert!((found.second_moment[i][j] - volume() * second).abs() < 1e-13, "{name}: {i} {j}");
            }
        }
        let heavy = MassProperties::of_space(space, &Model::Solid, &|e| steel().on(e).density()).unwrap();
        assert!((heavy.volume / (steel().density() * volume()) - 1.0).abs() < 1e-13, "{name}");
    });
}

#[test]
fn a_linear_field_has_one_stress_and_no_force_inside() {
    let expected = PointState::new(&Model::Solid, &steel(), &GRADIENT, 0.0);
    let inverse = fe_mesh::element::jacobian::inverse(&MAP, volume());
    for_each_space(&|name, space, _| {
        let u: Vec<f64> = space.control_points().iter().flat_map(|x| times(&GRADIENT, x)).collect();
        let (mut work, mut rule) = (RecoveryWorkspace::default(), GridBasis::default());
        for e in 0..space.n_elements() {
            space.tabulate(e, Integrand::Sample, &mut rule);
            for xi in &rule.parameters {
                let found = work.stress(space, &Model::Solid, &steel(), &u, e, xi).unwrap();
                let scale = largest(&expected.stress);
                for (a, b) in found.stress.iter().zip(&expected.stress) {
                    assert!((a - b).abs() < 1e-12 * scale, "{name}: {a:e}, {b:e}"); // round-off
                }
            }
        }
        let force = times_matrix(&assemble(space, &Model::Solid, &steel()).unwrap().stiffness, &u);
        // Functions whose control points lie inside are zero on the surface.
        let is_inside = |x: &[f64; 3]| times(&inverse, x).iter().all(|u| (1e-9..1.0 - 1e-9).contains(u));
        for (x, f) in space.control_points().iter().zip(force.as_chunks::<3>().0) {
            assert!(!is_inside(x) || largest(f) < 1e-12 * largest(&force), "{name}: {f:?}");
        }
    });
}

#[test]
fn functions_of_a_divided_mesh_are_those_of_its_nodes() {
    for kind in ElementKind::SOLID {
        let mesh = Mesh::new(divisible(kind, [2, 1, 1], mapped), 1.0).unwrap();
        let divided = RefinedMesh::new(&mesh, |ball| ball.level < 1 && ball.centre[0] < 0.5, 10_000).unwrap();
        let space = MeshSpace::divided(&divided, MassRule::Exact);
        // Any values at free nodes, and those that follow at the others.
        let value = |node: u32| (1.7 * f64::from(node)).sin();
        let at_node = |node: u32| match divided.followed(node) {
            [] => value(node),
            list => list.iter().map(|(m, w)| w * value(*m)).sum(),
        };
        let mut functions = Functions::default();
        for e in 0..space.n_elements() {
            let (element, xi) = (divided.mesh().elements().get(e), space.element(e).centre());
            element.kind.functions(&xi, &mut functions);
            let wanted: f64 = element.nodes.iter().zip(&functions.values).map(|(n, v)| v * at_node(*n)).sum();
            let found: f64 = space.functions_at(e, &xi).iter().map(|(f, v)| v * value(*f)).sum();
            assert!((found - wanted).abs() < 1e-13, "{kind:?}: {found}, {wanted}"); // round-off
        }
    }
}
