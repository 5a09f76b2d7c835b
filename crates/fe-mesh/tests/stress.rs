//! Stress and strain at points of meshes, by units of the nodes' displacements.

use crate::blocks::{block, shaken, steel};
use fe_mesh::element::kind::ElementKind;
use fe_mesh::element::rules::MassRule;
use fe_mesh::element::shape::Functions;
use fe_mesh::mesh::Mesh;
use fe_mesh::space::MeshSpace;
use iga_core::elasticity::kinematics::PointState;
use iga_core::elasticity::{Material, MaterialField, Model};
use nalgebra::{Matrix3, Vector3};

fn space(mesh: &Mesh) -> MeshSpace {
    MeshSpace::new(mesh.clone(), MassRule::Exact)
}

/// The state under `u`, three per node, at a point of `mesh`.
fn state(mesh: &Mesh, materials: &dyn MaterialField, (e, xi): (usize, &[f64; 3]), u: &[f64]) -> PointState {
    let mut sum = PointState::default();
    for (node, states) in space(mesh).unit_states(materials, e, xi).expect("no element is folded") {
        for (c, state) in states.iter().enumerate() {
            sum.add_scaled(state, u[3 * node as usize + c]);
        }
    }
    sum
}

/// Largest difference of two lists.
fn difference(a: &[f64; 6], b: &[f64; 6]) -> f64 {
    a.iter().zip(b).fold(0.0, |m, (x, y)| m.max((x - y).abs()))
}

fn field(mesh: &Mesh, gradient: &Matrix3<f64>) -> Vec<f64> {
    let at = |p: &[f64; 3]| gradient * Vector3::from(*p) + Vector3::new(0.1, -0.2, 0.3);
    mesh.nodes().iter().flat_map(|p| <[f64; 3]>::from(at(p))).collect()
}

fn noise(n: usize) -> Vec<f64> {
    (0..n).map(|i| (0.7 + 12.9898 * i as f64).sin()).collect()
}

#[test]
fn states_of_a_linear_field_are_those_of_its_gradient_in_every_element() {
    let gradient = Matrix3::new(1e-3, 2e-4, -3e-4, 5e-4, -7e-4, 1e-4, 2e-4, 6e-4, 4e-4);
    let rows = std::array::from_fn(|i| std::array::from_fn(|j| gradient[(i, j)]));
    let expected = PointState::new(&Model::Solid, &steel(), &rows, 0.0);
    for kind in ElementKind::SOLID {
        let mesh = Mesh::new(block(kind, [2, 2, 2], |x| shaken(x, 0.06)), 1.0).expect("a mesh");
        let u = field(&mesh, &gradient);
        for e in [0, mesh.elements().len() - 1] {
            for xi in kind.node_parameters().iter().chain(&[[0.2, 0.3, 0.1]]) {
                let found = state(&mesh, &steel(), (e, xi), &u);
                // Round-off of some hundred terms, enlarged by the slopes of functions on elements of a tenth.
                let error = difference(&found.strain, &expected.strain);
                assert!(error < 1e-14, "{kind:?}: {error:e}");
                let error = difference(&found.stress, &expected.stress);
                assert!(error < 1e-3 * 1e-9 * steel().lame_lambda(), "{kind:?}: {error:e}");
            }
        }
    }
}

#[test]
fn stress_by_units_is_that_of_the_nodes_interpolated() {
    for kind in ElementKind::SOLID {
        let mesh = Mesh::new(block(kind, [2, 2, 1], |x| shaken(x, 0.06)), 1.0).expect("a mesh");
        let u = noise(3 * mesh.nodes().len());
        let nodal = space(&mesh).nodal_stress(&steel(), &u).expect("no element is folded");
        let largest = nodal.iter().flatten().fold(0.0f64, |m, s| m.max(s.abs()));
        let (e, xi) = (1, [0.2, 0.15, 0.3]);
        let element = mesh.elements().get(e);
        let mut functions = Functions::default();
        element.kind.functions(&xi, &mut functions);
        let parts = || element.nodes.iter().zip(&functions.values);
        let expected = std::array::from_fn(|k| parts().map(|(&n, v)| nodal[n as usize][k] * v).sum());
        let found = state(&mesh, &steel(), (e, &xi), &u);
        assert!(difference(&found.stress, &expected) < 1e-12 * largest, "{kind:?}"); // round-off
    }
}

/// A bar of two materials under an axial force has one stress in both; averages over the border would be wrong in strain.
#[test]
fn elements_of_other_materials_have_no_part_in_it() {
    let raw = block(ElementKind::Hex8, [2, 1, 1], |x| x);
    let raw = fe_mesh::mesh::raw::RawMesh { volumes: vec![("soft".into(), vec![1])], ..raw };
    let mesh = Mesh::new(raw, 1.0).expect("a mesh");
    let soft = Material::new(13e9, 0.3, 1000.0).expect("constants");
    let materials = mesh.materials(&[("soft", soft)], Some(steel())).expect("materials");
    // A strain of its own in each half: continuous displacement.
    let half = 0.5 * mesh.nodes().iter().fold(0.0f64, |m, p| m.max(p[0]));
    let slopes = [1e-3, 5e-3];
    let u: Vec<f64> = mesh
        .nodes()
        .iter()
        .flat_map(|p| [slopes[0] * p[0].min(half) + slopes[1] * (p[0] - half).max(0.0), 0.0, 0.0])
        .collect();
    for (e, slope) in slopes.iter().enumerate() {
        let at = if materials.on(e) == &soft { 1 } else { 0 };
        assert_eq!(at, e, "the block goes along x");
        for xi in [[-1.0, 0.0, 0.0], [0.0; 3], [1.0, 0.0, 0.0]] {
            let found = state(&mesh, &materials, (e, &xi), &u);
            assert!((found.strain[0] - slope).abs() < 1e-15, "{e} {xi:?}: {:e}", found.strain[0]); // round-off
        }
    }
}
