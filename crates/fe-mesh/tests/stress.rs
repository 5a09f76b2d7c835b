//! Stress and strain at points of meshes, by units of the nodes' displacements.

use crate::blocks::{block, shaken};
use fe_mesh::kind::ElementKind;
use fe_mesh::matrices::{Constants, Materials};
use fe_mesh::mesh::Mesh;
use fe_mesh::shape::Functions;
use fe_mesh::stress::{PointState, stress};
use nalgebra::{Matrix3, Vector3};

const STEEL: Constants = Constants { lambda: 121.2e9, mu: 80.8e9, density: 7850.0 };
const SOFT: Constants = Constants { lambda: 10e9, mu: 5e9, density: 1000.0 };

/// The state under `u`, three per node.
fn state(units: &[(u32, [PointState; 3])], u: &[f64]) -> PointState {
    let mut sum = PointState::default();
    for (node, states) in units {
        for (c, state) in states.iter().enumerate() {
            let value = u[3 * *node as usize + c];
            sum.strain += state.strain * value;
            sum.stress += state.stress * value;
        }
    }
    sum
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
    let strain = 0.5 * (gradient + gradient.transpose());
    for kind in ElementKind::ALL {
        let mesh = Mesh::new(block(kind, [2, 2, 2], |x| shaken(x, 0.06)), 1.0).expect("a mesh");
        let (materials, u) = (Materials::uniform(STEEL), field(&mesh, &gradient));
        for e in [0, mesh.elements().len() - 1] {
            for xi in kind.node_parameters().iter().chain(&[[0.2, 0.3, 0.1]]) {
                let found = state(&mesh.unit_states(e, xi, &materials), &u);
                // Round-off of some hundred terms, enlarged by the slopes of functions on elements of a tenth.
                assert!(
                    (found.strain - strain).amax() < 1e-14,
                    "{kind:?}: {:e}",
                    (found.strain - strain).amax()
                );
                let error = (found.stress - stress(&STEEL, &gradient)).amax();
                assert!(error < 1e-3 * 1e-9 * STEEL.lambda, "{kind:?}: {error:e}");
            }
        }
    }
}

#[test]
fn stress_by_units_is_that_of_the_nodes_interpolated() {
    for kind in ElementKind::ALL {
        let mesh = Mesh::new(block(kind, [2, 2, 1], |x| shaken(x, 0.06)), 1.0).expect("a mesh");
        let (materials, u) = (Materials::uniform(STEEL), noise(3 * mesh.nodes().len()));
        let nodal = mesh.nodal_stress(&materials, &u);
        let largest = nodal.iter().map(Matrix3::amax).fold(0.0, f64::max);
        let (e, xi) = (1, [0.2, 0.15, 0.3]);
        let element = mesh.elements().get(e);
        let mut functions = Functions::default();
        element.kind.functions(&xi, &mut functions);
        let parts = element.nodes.iter().zip(&functions.values).map(|(&n, v)| nodal[n as usize] * *v);
        let expected: Matrix3<f64> = parts.sum();
        let found = state(&mesh.unit_states(e, &xi, &materials), &u);
        assert!((found.stress - expected).amax() < 1e-12 * largest, "{kind:?}"); // round-off
    }
}

/// A bar of two materials under an axial force has one stress in both; averages over the border would be wrong in strain.
#[test]
fn elements_of_other_materials_have_no_part_in_it() {
    let raw = block(ElementKind::Hex8, [2, 1, 1], |x| x);
    let raw = fe_mesh::raw::RawMesh { volumes: vec![("soft".into(), vec![1])], ..raw };
    let mesh = Mesh::new(raw, 1.0).expect("a mesh");
    let materials = Materials::by_group(&mesh, &[("soft", SOFT)], Some(STEEL)).expect("materials");
    // A strain of its own in each half: continuous displacement.
    let half = 0.5 * mesh.nodes().iter().fold(0.0f64, |m, p| m.max(p[0]));
    let slopes = [1e-3, 5e-3];
    let u: Vec<f64> = mesh
        .nodes()
        .iter()
        .flat_map(|p| [slopes[0] * p[0].min(half) + slopes[1] * (p[0] - half).max(0.0), 0.0, 0.0])
        .collect();
    for (e, slope) in slopes.iter().enumerate() {
        let at = if materials.of(e) == &SOFT { 1 } else { 0 };
        assert_eq!(at, e, "the block goes along x");
        for xi in [[-1.0, 0.0, 0.0], [0.0; 3], [1.0, 0.0, 0.0]] {
            let found = state(&mesh.unit_states(e, &xi, &materials), &u);
            assert!((found.strain[(0, 0)] - slope).abs() < 1e-15, "{e} {xi:?}: {:e}", found.strain[(0, 0)]); // round-off
        }
    }
}
