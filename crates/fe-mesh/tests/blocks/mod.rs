//! Blocks of every kind of element for the tests.

use std::cmp::Ordering;
use std::collections::BTreeMap;

use fe_mesh::element::kind::{ElementKind, Form};
use fe_mesh::element::rules::MassRule;
use fe_mesh::mesh::raw::{Elements, FaceSource, RawMesh};
use fe_mesh::{Mesh, MeshSpace};
use iga_core::elasticity::Material;
use iga_core::elasticity::mass_properties::MassProperties;

/// Steel.
pub fn steel() -> Material {
    Material::new(210e9, 0.3, 7850.0).expect("constants of steel")
}

/// Integrals of `mesh`, of every element times `factor`.
pub fn integrals(mesh: &Mesh, factor: &dyn Fn(usize) -> f64) -> MassProperties {
    let space = MeshSpace::new(mesh.clone(), MassRule::Exact);
    MassProperties::of_space(&space, mesh.model(), factor).expect("no element is folded")
}

/// Volume of `mesh`.
pub fn volume(mesh: &Mesh) -> f64 {
    integrals(mesh, &|_| 1.0).volume
}

/// Kind and corners of an element.
type Piece = (ElementKind, Vec<[usize; 3]>);

/// Corners of a cube of the width two.
const CUBE: [[usize; 3]; 8] =
    [[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0], [0, 0, 2], [2, 0, 2], [2, 2, 2], [0, 2, 2]];
/// Its middle.
const MIDDLE: [usize; 3] = [1, 1, 1];

fn pick(list: &[usize]) -> Vec<[usize; 3]> {
    list.iter().map(|&i| CUBE[i]).collect()
}

/// Corners of the pyramid between a side of the cube and its middle.
fn pyramid(side: &[u8]) -> Vec<[usize; 3]> {
    // Seen from inside the side turns the other way.
    let ring: Vec<usize> = side.iter().rev().map(|&c| c as usize).collect();
    [&pick(&ring)[..], &[MIDDLE]].concat()
}

/// Corners of the elements into which [`CUBE`] is cut.
fn pieces(form: Form) -> Vec<Vec<[usize; 3]>> {
    match form {
        Form::Hexahedron => vec![CUBE.to_vec()],
        Form::Quadrilateral => vec![pick(&[0, 1, 2, 3])],
        Form::Triangle => vec![pick(&[0, 1, 2]), pick(&[0, 2, 3])],
        Form::Pyramid => ElementKind::Hex8.sides().iter().map(|side| pyramid(side)).collect(),
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

/// A block `[0, 1]³`, of plane kinds a square, of `n` cells along each direction, its nodes moved by `map`; groups of faces are "x-" to "z+".
pub fn block(kind: ElementKind, n: [usize; 3], map: impl Fn([f64; 3]) -> [f64; 3]) -> RawMesh {
    built(n, map, |_| pieces(kind.form()).into_iter().map(|corners| (kind, corners)).collect())
}

/// The hexahedra, pyramids and tetrahedra that fit to the pyramids `kind`.
pub fn companions(kind: ElementKind) -> [ElementKind; 3] {
    match kind {
        ElementKind::Pyramid13 => [ElementKind::Hex20, kind, ElementKind::Tet10],
        ElementKind::Pyramid14 => [ElementKind::Hex27, kind, ElementKind::Tet10],
        _ => [ElementKind::Hex8, ElementKind::Pyramid5, ElementKind::Tet4],
    }
}

/// A block as [`block`] whose first cells along x are hexahedra, the last ones tetrahedra; those in the layer between them are five pyramids, which turn a side each to a
/// hexahedron, to each other or outwards, and two tetrahedra.
pub fn mixed(kind: ElementKind, n: [usize; 3], map: impl Fn([f64; 3]) -> [f64; 3]) -> RawMesh {
    let [hexahedron, _, tetrahedron] = companions(kind);
    let of = |kind: ElementKind| pieces(kind.form()).into_iter().map(move |corners| (kind, corners));
    built(n, map, |x| match x.cmp(&(n[0] / 2)) {
        Ordering::Less => of(hexahedron).collect(),
        Ordering::Greater => of(tetrahedron).collect(),
        Ordering::Equal => {
            let sides = [0, 1, 2, 4, 5].map(|side| (kind, pyramid(ElementKind::Hex8.sides()[side])));
            // The side towards larger x is cut as the neighbour's is.
            let cut = [[1, 6, 2], [1, 5, 6]].map(|of| (tetrahedron, [&pick(&of)[..], &[MIDDLE]].concat()));
            sides.into_iter().chain(cut).collect()
        }
    })
}

/// A block that can be divided at small x: [`block`], with pyramids [`mixed`] of three cells more along x.
pub fn divisible(kind: ElementKind, n: [usize; 3], map: impl Fn([f64; 3]) -> [f64; 3]) -> RawMesh {
    match kind.form() {
        Form::Pyramid => mixed(kind, [n[0] + 3, n[1], n[2]], map),
        _ => block(kind, n, map),
    }
}

/// The block of `n` cells with the elements `of` a cell by its place along x, the corners of which are those of [`CUBE`] and [`MIDDLE`].
fn built(n: [usize; 3], map: impl Fn([f64; 3]) -> [f64; 3], of: impl Fn(usize) -> Vec<Piece>) -> RawMesh {
    let mut numbers: BTreeMap<[usize; 3], u32> = BTreeMap::new();
    let mut mesh = RawMesh { elements: Elements::default(), ..RawMesh::default() };
    let mut lattice = Vec::new();
    for cell in (0..n[0] * n[1] * n[2]).map(|c| [c % n[0], c / n[0] % n[1], c / n[0] / n[1]]) {
        for (kind, piece) in of(cell[0]) {
            let corners: Vec<[usize; 3]> =
                piece.iter().map(|p| [0, 1, 2].map(|d| 4 * cell[d] + 2 * p[d])).collect();
            let mean = |of: &[u8]| {
                [0, 1, 2].map(|d| of.iter().map(|&c| corners[c as usize][d]).sum::<usize>() / of.len())
            };
            let mut places = corners.clone();
            places.extend(kind.middles().into_iter().map(mean));
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
    let at = |place: &[usize; 3]| [0, 1, 2].map(|d| 0.25 * place[d] as f64 / n[d] as f64);
    mesh.nodes = lattice.iter().map(|place| map(at(place))).collect();
    mesh.node_labels = (1..=lattice.len() as u64).collect();
    mesh.volumes = vec![("all".into(), (0..mesh.elements.len() as u32).collect())];
    for (name, d, end) in [("x-", 0, 0), ("x+", 0, 1), ("y-", 1, 0), ("y+", 1, 1), ("z-", 2, 0), ("z+", 2, 1)]
    {
        let on = |place: &[usize; 3]| place[d] == 4 * n[d] * end;
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
