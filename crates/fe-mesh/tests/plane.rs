//! Plane and axisymmetric meshes: matrices by identities and closed forms, the curves around them, divided ones, what makes no body.

use std::f64::consts::{PI, TAU};

use crate::blocks::{block, steel};
use faer::sparse::SparseColMat;
use fe_mesh::element::kind::{ElementKind, Form};
use fe_mesh::element::rules::MassRule;
use fe_mesh::mesh::raw::RawMesh;
use fe_mesh::read::read;
use fe_mesh::refined::RefinedMesh;
use fe_mesh::surface::Surface;
use fe_mesh::{Mesh, MeshSpace};
use iga_core::elasticity::assembly::{AssembledMatrices, assemble};
use iga_core::elasticity::{Material, Model};
use iga_core::extent::measure;
use iga_core::space::Space;
use nalgebra::{DMatrix, DVector};

const MODELS: [Model; 3] =
    [Model::PlaneStrain { thickness: 0.3 }, Model::PlaneStress { thickness: 0.3 }, Model::Axisymmetric];

/// Moves what is inside of the unit square and leaves its edges in place.
fn shaken([x, y, _]: [f64; 3]) -> [f64; 3] {
    let inside = 16.0 * x * (1.0 - x) * y * (1.0 - y);
    [x + 0.06 * inside * (3.0 * y).sin(), y + 0.05 * inside * (2.0 * x).cos(), 0.0]
}

fn square(kind: ElementKind, n: usize, model: Model) -> Mesh {
    let mesh = Mesh::new(block(kind, [n, n, 1], shaken), 1.0).expect("a mesh");
    mesh.of_model(model).expect("of the plane")
}

fn matrices(space: &MeshSpace) -> AssembledMatrices {
    assemble(space, space.mesh().model(), &steel()).expect("matrices")
}

fn of(mesh: &Mesh) -> AssembledMatrices {
    matrices(&MeshSpace::new(mesh.clone(), MassRule::Exact))
}

fn full(lower: &SparseColMat<u32, f64>) -> DMatrix<f64> {
    let mut all = DMatrix::zeros(lower.nrows(), lower.ncols());
    for j in 0..lower.ncols() {
        for p in lower.symbolic().col_range(j) {
            let i = lower.row_idx()[p] as usize;
            (all[(i, j)], all[(j, i)]) = (lower.val()[p], lower.val()[p]);
        }
    }
    all
}

/// Values of a field at the unknowns.
fn values(dofs: &[(u32, u8)], nodes: &[[f64; 3]], field: impl Fn(&[f64; 3]) -> [f64; 2]) -> DVector<f64> {
    DVector::from_fn(dofs.len(), |i, _| field(&nodes[dofs[i].0 as usize])[dofs[i].1 as usize])
}

/// Elastic energy of a strain `xx, yy, zz, xy` in a unit of volume.
fn energy(material: &Material, model: &Model, [x, y, z, shear]: [f64; 4]) -> f64 {
    let (lambda, mu) = model.lame(material);
    let trace = x + y + z;
    0.5 * lambda * trace * trace + mu * (x * x + y * y + z * z) + 0.5 * mu * shear * shear
}

/// Uniform strains of a distorted mesh cost what the material says, rigid motions nothing; the mass is that of the body.
#[test]
fn uniform_strains_cost_what_the_material_says() {
    for kind in ElementKind::PLANE {
        for model in MODELS {
            let mesh = square(kind, 3, model);
            let AssembledMatrices { stiffness, mass, dofs } = of(&mesh);
            let (k, nodes) = (full(&stiffness), mesh.nodes());
            let (volume, strain): (f64, _) = match model {
                Model::Axisymmetric => (PI, [2e-3, -1e-3, 2e-3, 0.0]),
                _ => (0.3, [2e-3, -1e-3, 0.0, 3e-3]),
            };
            let u = values(&dofs, nodes, |[x, y, _]| [strain[0] * x + strain[3] * y, strain[1] * y]);
            let found = 0.5 * u.dot(&(&k * &u));
            let wanted = volume * energy(&steel(), &model, strain);
            // The map of curved elements is no polynomial, the strain is uniform all the same; round-off.
            assert!((found / wanted - 1.0).abs() < 1e-12, "{kind:?} {model:?}: {found} {wanted}");
            let turn = if model == Model::Axisymmetric { 0.0 } else { 1.0 };
            let rigid = values(&dofs, nodes, |[x, y, _]| [turn * (0.2 - y), 0.3 + turn * x]);
            let largest = (&k * rigid).amax() / k.amax();
            assert!(largest < 1e-13, "{kind:?} {model:?}: {largest:e}");
            let ones = DVector::repeat(nodes.len(), 1.0);
            let total = ones.dot(&(full(&mass) * &ones));
            assert!((total / (volume * 7850.0) - 1.0).abs() < 1e-13, "{kind:?} {model:?}: {total}");
        }
    }
}

/// The solid kind that a plane one is the section of.
fn extruded(kind: ElementKind) -> ElementKind {
    match kind {
        ElementKind::Tri3 => ElementKind::Wedge6,
        ElementKind::Tri6 => ElementKind::Wedge15,
        ElementKind::Quad4 => ElementKind::Hex8,
        ElementKind::Quad8 => ElementKind::Hex20,
        _ => ElementKind::Hex27,
    }
}

/// A solid of one layer whose displacements do not depend on z, and lie in the plane, is the body in plane strain: matrices of solids agree with those of CalculiX.
#[test]
fn plane_strain_is_a_solid_held_in_its_plane() {
    for kind in ElementKind::PLANE {
        let mesh = square(kind, 2, Model::PlaneStrain { thickness: 0.3 });
        let lifted = |[x, y, z]: [f64; 3]| {
            let [x, y, _] = shaken([x, y, 0.0]);
            [x, y, 0.3 * z]
        };
        let solid = Mesh::new(block(extruded(kind), [2, 2, 1], lifted), 1.0).expect("a mesh");
        let (own, whole) = (of(&mesh), of(&solid));
        let near = |a: &[f64; 3], b: &[f64; 3]| (a[0] - b[0]).hypot(a[1] - b[1]) < 1e-12;
        let under = |n: u32| {
            let place = &solid.nodes()[n as usize];
            mesh.nodes().iter().position(|x| near(x, place)).expect("a node below")
        };
        let spread = DMatrix::from_fn(whole.dofs.len(), own.dofs.len(), |i, j| {
            let ((n, c), (m, d)) = (whole.dofs[i], own.dofs[j]);
            f64::from(u8::from(c == d && under(n) == m as usize))
        });
        let error = full(&own.stiffness) - spread.transpose() * full(&whole.stiffness) * &spread;
        // Sums of a few dozen products.
        let scale = full(&own.stiffness).amax();
        assert!(error.amax() < 1e-12 * scale, "{kind:?}: {:e}", error.amax() / scale);
        let nodes = DMatrix::from_fn(solid.nodes().len(), mesh.nodes().len(), |n, m| {
            f64::from(u8::from(under(n as u32) == m))
        });
        let error = full(&own.mass) - nodes.transpose() * full(&whole.mass) * &nodes;
        // The wedge with six nodes has three points in the triangle for its mass, which its determinant, that
        // of a straight triangle, does not mind.
        assert!(error.amax() < 1e-13 * full(&own.mass).amax(), "{kind:?}: {:e}", error.amax());
    }
}

/// A thick ring, `1 <= r <= 2` and `n` elements through its wall, held in its plane, under a pressure of 1 Pa inside: error of the work of that
/// (Lamé: `u = A r + B / r`).
fn ring_error(kind: ElementKind, n: usize) -> f64 {
    let raw = block(kind, [n, 1, 1], |[x, y, _]| [1.0 + x, 0.2 * y, 0.0]);
    let mesh = Mesh::new(raw, 1.0).and_then(|m| Ok(m.of_model(Model::Axisymmetric)?)).expect("a mesh");
    let AssembledMatrices { stiffness, dofs, .. } = of(&mesh);
    let free: Vec<usize> = (0..dofs.len()).filter(|&i| dofs[i].1 == 0).collect();
    let k = full(&stiffness);
    let k = DMatrix::from_fn(free.len(), free.len(), |i, j| k[(free[i], free[j])]);
    let mut force = vec![0.0; mesh.nodes().len()];
    let space = MeshSpace::new(mesh.clone(), MassRule::Exact);
    for point in mesh.face_part("x-").expect("the bore") {
        for (node, value) in space.functions_at(point.element, &point.xi) {
            force[node as usize] += point.weight * value;
        }
    }
    let load = DVector::from_fn(free.len(), |i, _| force[dofs[free[i]].0 as usize]);
    let found = k.lu().solve(&load).expect("a regular matrix");
    let (lambda, mu) = (steel().lame_lambda(), steel().shear_modulus());
    // No pressure outside: 2 (λ + μ) A = 2 μ B / 4, inside 2 (λ + μ) A - 2 μ B = -1.
    let b = 1.0 / (1.5 * mu);
    let wanted = mu * b / (4.0 * (lambda + mu)) + b;
    (load.dot(&found) / (load.sum() * wanted) - 1.0).abs()
}

#[test]
fn a_thick_ring_under_pressure_widens_as_lame_says() {
    for (kind, order) in [
        (ElementKind::Quad8, 4.0),
        (ElementKind::Quad9, 4.0),
        (ElementKind::Tri6, 4.0),
        (ElementKind::Quad4, 2.0),
        (ElementKind::Tri3, 2.0),
    ] {
        let [coarse, fine] = [8, 16].map(|n| ring_error(kind, n));
        // Work has twice the order of the strains; a quarter is left for higher ones.
        assert!((coarse / fine).log2() > order - 0.25, "{kind:?}: {coarse:e} {fine:e}");
        assert!(fine < if kind.is_quadratic() { 1e-5 } else { 2e-2 }, "{kind:?}: {fine:e}");
    }
}

/// An annulus sector about the origin, from the positive x axis to the positive y axis.
fn sector([x, y, _]: [f64; 3]) -> [f64; 3] {
    let (sin, cos) = (0.25 * TAU * y).sin_cos();
    [(1.0 + x) * cos, (1.0 + x) * sin, 0.0]
}

#[test]
fn the_curve_around_a_mesh_has_its_length_and_turns_outwards() {
    for kind in ElementKind::PLANE {
        for (model, factor) in MODELS.map(|m| (m, m.thickness())) {
            // The corners turn clockwise: the mesh is turned over.
            let raw = block(kind, [2, 8, 1], |[x, y, z]| sector([y, x, z]));
            let raw = RawMesh { faces: Vec::new(), ..raw };
            let named = block(kind, [2, 8, 1], |[x, y, z]| sector([x, y, z]));
            let turned = Mesh::new(raw, 1.0).and_then(|m| Ok(m.of_model(model)?)).expect("a mesh");
            assert!(turned.elements().iter().all(|e| {
                let [a, b, c] = [0, 1, 2].map(|i| turned.nodes()[e.nodes[i] as usize]);
                (b[0] - a[0]) * (c[1] - a[1]) > (b[1] - a[1]) * (c[0] - a[0])
            }));
            let mesh = Mesh::new(named, 1.0).and_then(|m| Ok(m.of_model(model)?)).expect("a mesh");
            let outer = mesh.face_part("x+").expect("the outer arc");
            // Of an axisymmetric body half a sphere.
            let wanted = factor.map_or(TAU * 4.0, |thickness| PI * thickness);
            let error = (measure(&outer) / wanted - 1.0).abs();
            // Chords of an angle θ are short by θ²/24 in length and θ²/12 in their mean radius, parabolas by the square of that.
            assert!(error < if kind.is_quadratic() { 2e-5 } else { 5e-3 }, "{kind:?} {model:?}: {error:e}");
            let surface = Surface::new(&mesh);
            let mut at = fe_mesh::locate::SidePoint::default();
            for (side, face) in surface.sides().iter().zip(mesh.surface()) {
                let places: Vec<_> = side.nodes.iter().map(|&n| mesh.nodes()[n as usize]).collect();
                at.evaluate(side.kind, &places, &[0.1, 0.0]);
                let (xi, e) =
                    (mesh.in_element(*face, &[0.1, 0.0]), mesh.elements().get(face.element as usize));
                let middle = e.nodes.iter().fold([0.0; 2], |m, &n| {
                    [0, 1].map(|d| m[d] + mesh.nodes()[n as usize][d] / e.nodes.len() as f64)
                });
                let outwards = (0..2).map(|d| at.area[d] * (at.position[d] - middle[d])).sum::<f64>();
                assert!(outwards > 0.0, "{kind:?}: {xi:?}");
            }
            // The sides on the axis are none of an axisymmetric body, the other end and the arcs are.
            let n_sides = if model == Model::Axisymmetric { 18 } else { 20 };
            assert_eq!(surface.sides().len(), n_sides, "{kind:?} {model:?}");
            assert_eq!(mesh.face_group("y+").is_err(), model == Model::Axisymmetric);
            let open =
                surface.sides().iter().flat_map(|s| &s.neighbours[..2]).filter(|n| n.is_none()).count();
            assert_eq!(open, if model == Model::Axisymmetric { 2 } else { 0 });
        }
    }
}

/// A divided mesh has the fields of the one before: uniform strains cost the same, nothing tears.
#[test]
fn divided_meshes_have_the_fields_of_the_mesh_before() {
    for kind in ElementKind::PLANE {
        for model in MODELS {
            let mesh = square(kind, 3, model);
            let near = |ball: &fe_mesh::refined::CellBall| {
                let away = (ball.centre[0] - 1.0).hypot(ball.centre[1] - 0.4) - ball.radius;
                ball.level < 3 && away < 0.05
            };
            let refined = RefinedMesh::new(&mesh, near, 10_000).expect("a divided mesh");
            assert!(refined.mesh().elements().len() > 30 && refined.n_free() < refined.mesh().nodes().len());
            let space = MeshSpace::divided(&refined, MassRule::Exact);
            let (fine, coarse) = (matrices(&space), of(&mesh));
            // A field of the mesh before, at nodes that follow no other.
            let field = |[x, y, _]: &[f64; 3]| [1e-3 * x * (1.0 + y * x), 1e-3 * (x - y * y)];
            let before = values(&coarse.dofs, mesh.nodes(), field);
            let number = |n: u32, c: u8| coarse.dofs.iter().position(|dof| *dof == (n, c));
            let after = DVector::from_fn(fine.dofs.len(), |i, _| {
                let (node, c) = fine.dofs[i];
                let functions = refined.functions_before(&mesh, node as usize);
                functions.iter().filter_map(|(n, w)| Some(w * before[number(*n, c)?])).sum()
            });
            let product = |m: &SparseColMat<u32, f64>, u: &DVector<f64>| u.dot(&(full(m) * u));
            let (k, l) = (product(&coarse.stiffness, &before), product(&fine.stiffness, &after));
            // Not the same on curved elements, nor where radii stand below: rules of smaller elements are more exact.
            let is_exact = kind == ElementKind::Tri3 && model != Model::Axisymmetric;
            assert!((l / k - 1.0).abs() < if is_exact { 1e-12 } else { 2e-3 }, "{kind:?} {model:?}: {k} {l}");
        }
    }
}

fn fault(raw: RawMesh, model: Model) -> String {
    Mesh::new(raw, 1.0).and_then(|m| Ok(m.of_model(model)?)).expect_err("no body").to_string()
}

#[test]
fn what_makes_no_plane_body_is_told_with_a_remedy() {
    let flat = || block(ElementKind::Quad8, [2, 2, 1], |x| x);
    let bent = block(ElementKind::Quad8, [2, 2, 1], |[x, y, _]| [x, y, 0.1 * x * x]);
    assert!(fault(bent, MODELS[0]).contains("off their plane"));
    assert!(fault(flat(), Model::Solid).contains("plane-stress"));
    assert!(fault(block(ElementKind::Hex8, [1; 3], |x| x), MODELS[1]).contains("gmsh -2"));
    let left = block(ElementKind::Tri6, [2, 2, 1], |[x, y, z]| [x - 0.5, y, z]);
    assert!(fault(left, Model::Axisymmetric).contains("an axisymmetric section lies at x >= 0"));
    let mesh = Mesh::new(flat(), 1.0).expect("a mesh").of_model(Model::Axisymmetric).expect("a section");
    let axis = mesh.face_group("x-").expect_err("the axis is no face").to_string();
    assert!(axis.contains("the axis of a section"), "{axis}");
}

/// A deck as it is written for a section: sides by numbers, a set of nodes, lines on its edge, a reduced element.
#[test]
fn decks_of_plane_models() {
    let nodes = "*NODE\n1,0,0\n2,2,0\n3,2,1\n4,0,1\n5,1,0\n6,2,.5\n7,1,1\n8,0,.5\n";
    let rest = "*SURFACE, NAME=under\nall, S1\n*NSET, NSET=right\n2, 3, 6\n*ELEMENT, TYPE=T3D3, ELSET=over\n9, 3, 4, 7\n\
                *ELEMENT, TYPE=B32, ELSET=left\n10, 4, 8, 1\n";
    for (order, side) in [("1, 2, 3, 4, 5, 6, 7, 8", "under"), ("1, 4, 3, 2, 8, 7, 6, 5", "left")] {
        let text = format!("{nodes}*ELEMENT, TYPE=CAX8R, ELSET=all\n1, {order}\n{rest}");
        let mesh = read(text.as_bytes(), 1.0).expect("a mesh");
        let mesh = mesh.of_model(Model::PlaneStress { thickness: 1.0 }).expect("a body");
        assert_eq!(mesh.elements().get(0).kind.form(), Form::Quadrilateral);
        assert_eq!(mesh.volume_group("all").expect("a set"), [0]);
        // S1 lies between the first two corners of the deck, whichever way they turn.
        assert_eq!(mesh.face_group("under"), mesh.face_group(side));
        let length = |name: &str| measure(&mesh.face_part(name).expect("a face"));
        assert!((length("over") - 2.0).abs() < 1e-14 && (length("left") - 1.0).abs() < 1e-14);
        assert!((length("right") - 1.0).abs() < 1e-14);
        let notes = mesh.notes().join("\n");
        assert!(notes.contains("CAX8R (line") && notes.contains("made for rotational symmetry"), "{notes}");
    }
}
