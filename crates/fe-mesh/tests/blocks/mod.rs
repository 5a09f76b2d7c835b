//! Blocks of every kind of element for the tests.

use std::collections::BTreeMap;

use fe_mesh::kind::{ElementKind, Form};
use fe_mesh::raw::{Elements, FaceSource, RawMesh};
use fe_mesh::rules::MassRule;
use fe_mesh::{Mesh, MeshSpace};
use iga_core::elasticity::{Material, Model};
use iga_core::mass_properties::MassProperties;

/// Steel.
pub fn steel() -> Material {
    Material::new(210e9, 0.3, 7850.0).expect("constants of steel")
}

/// Integrals of `mesh`, of every element times `factor`.
pub fn integrals(mesh: &Mesh, factor: &dyn Fn(usize) -> f64) -> MassProperties {
    let space = MeshSpace::new(mesh.clone(), MassRule::Exact);
    MassProperties::of_space(&space, &Model::Solid, factor).expect("no element is folded")
}

/// Volume of `mesh`.
pub fn volume(mesh: &Mesh) -> f64 {
    integrals(mesh, &|_| 1.0).volume
}

/// Corners of the elements into which a unit cube is cut.
fn pieces(form: Form) -> Vec<Vec<[usize; 3]>> {
    let cube = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]];
    let pick = |list: &[usize]| list.iter().map(|&i| cube[i]).collect::<Vec<_>>();
    match form {
        Form::Hexahedron => vec![cube.to_vec()],
        Form::Wedge => vec![pick(&[0, 1, 2, 4, 5, 6]), pick(&[0, 2, 3, 4, 6, 7])],
        // Six tetrahedra about the diagonal.
        Form::Tetrahedron => {
            [[0, 1, 2, 6], [0, 2, 3, 6], [0, 3, 7, 6], [0, 7, 4, 6], [0, 4, 5, 6], [0, 5, 1, 6]]
                .iter()
                .map(|list| pick(list))
                .collect()
        }
    }
}

/// A block `[0, 1]³` of `n` cells along each direction, its nodes moved by `map`; groups of faces are "x-" to "z+".
pub fn block(kind: ElementKind, n: [usize; 3], map: impl Fn([f64; 3]) -> [f64; 3]) -> RawMesh {
    let mut numbers: BTreeMap<[usize; 3], u32> = BTreeMap::new();
    let mut mesh = RawMesh { elements: Elements::default(), ..RawMesh::default() };
    let mut lattice = Vec::new();
    for cell in (0..n[0] * n[1] * n[2]).map(|c| [c % n[0], c / n[0] % n[1], c / n[0] / n[1]]) {
        for piece in pieces(kind.form()) {
            let corners: Vec<[usize; 3]> =
                piece.iter().map(|p| [0, 1, 2].map(|d| 2 * (cell[d] + p[d]))).collect();
            let mean = |of: &[u8]| {
                [0, 1, 2].map(|d| of.iter().map(|&c| corners[c as usize][d]).sum::<usize>() / of.len())
            };
            let mut places = corners.clone();
            if kind.n_nodes() > corners.len() {
                places.extend(kind.edges().iter().map(|edge| mean(edge)));
            }
            if matches!(kind, ElementKind::Hex27 | ElementKind::Wedge18) {
                places.extend(kind.sides().iter().filter(|s| s.len() == 4).map(|s| mean(s)));
            }
            if kind == ElementKind::Hex27 {
                places.push(mean(&[0, 1, 2, 3, 4, 5, 6, 7]));
            }
            let nodes: Vec<u32> = places
                .iter()
                .map(|place| {
                    *numbers.entry(*place).or_insert_with(|| {
                        lattice.push(*place);
                        lattice.len() as u32 - 1
                    })
                })
                .collect();
            let label = mesh.elements.len() as u64 + 1;
            mesh.elements.push(kind, label, nodes.into_iter());
        }
    }
    let at = |place: &[usize; 3]| [0, 1, 2].map(|d| 0.5 * place[d] as f64 / n[d] as f64);
    mesh.nodes = lattice.iter().map(|place| map(at(place))).collect();
    mesh.node_labels = (1..=lattice.len() as u64).collect();
    mesh.volumes = vec![("all".into(), (0..mesh.elements.len() as u32).collect())];
    for (name, d, end) in [("x-", 0, 0), ("x+", 0, 1), ("y-", 1, 0), ("y+", 1, 1), ("z-", 2, 0), ("z+", 2, 1)]
    {
        let on = |place: &[usize; 3]| place[d] == 2 * n[d] * end;
        let nodes = (0..lattice.len() as u32).filter(|&i| on(&lattice[i as usize])).collect();
        mesh.faces.push((name.into(), FaceSource::Nodes(nodes)));
    }
    mesh
}

/// Moves what is inside of the unit cube and leaves its sides in place; lines stay nearly straight if `amount` is small.
pub fn shaken([x, y, z]: [f64; 3], amount: f64) -> [f64; 3] {
    let inside = 64.0 * x * (1.0 - x) * y * (1.0 - y) * z * (1.0 - z);
    [
        x + amount * inside * (3.0 * y + 2.0 * z).sin(),
        y + amount * inside * (2.0 * x - z).cos(),
        z - amount * inside * (x + 4.0 * y).sin(),
    ]
}
