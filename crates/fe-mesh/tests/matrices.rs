//! Stiffness and mass matrices by identities, on distorted and curved meshes.

use crate::blocks::{block, integrals, mixed, shaken, steel, volume};
use faer::sparse::SparseColMat;
use fe_mesh::element::rules::MassRule;
use fe_mesh::mesh::raw::RawMesh;
use fe_mesh::{ElementKind, Mesh, MeshSpace};
use iga_core::elasticity::assembly::{AssembledMatrices, assemble};
use iga_core::elasticity::kinematics::PointState;
use iga_core::elasticity::{Material, MaterialField, Model};

fn matrices(mesh: &Mesh) -> AssembledMatrices {
    assemble(&MeshSpace::new(mesh.clone(), MassRule::Exact), &Model::Solid, &steel()).expect("matrices")
}

/// Product with a symmetric matrix of which the lower half is given.
pub fn times(matrix: &SparseColMat<u32, f64>, x: &[f64]) -> Vec<f64> {
    let mut y = vec![0.0; x.len()];
    for j in 0..matrix.ncols() {
        for p in matrix.symbolic().col_range(j) {
            let (i, value) = (matrix.row_idx()[p] as usize, matrix.val()[p]);
            y[i] += value * x[j];
            if i != j {
                y[j] += value * x[i];
            }
        }
    }
    y
}

/// Straight-sided elements of different shapes: the middles of edges lie in the middle.
fn straight(kind: ElementKind, n: [usize; 3]) -> Mesh {
    Mesh::new(straightened(block(kind, n, |x| shaken(x, 0.06))), 1.0).expect("a mesh")
}

fn straightened(mut raw: RawMesh) -> RawMesh {
    let (nodes, elements) = (&mut raw.nodes, &raw.elements);
    for element in elements.iter() {
        let kind = element.kind;
        let parameters = kind.node_parameters();
        for (k, xi) in parameters.iter().enumerate().skip(kind.n_corners()) {
            let mut functions = fe_mesh::element::shape::Functions::default();
            kind.linear().functions(xi, &mut functions);
            let place = (0..3).map(|d| {
                functions
                    .values
                    .iter()
                    .zip(element.nodes)
                    .map(|(v, &n)| v * nodes[n as usize][d])
                    .sum::<f64>()
            });
            let place: Vec<f64> = place.collect();
            nodes[element.nodes[k] as usize] = [place[0], place[1], place[2]];
        }
    }
    raw
}

#[test]
fn rigid_motions_cost_nothing_and_have_their_inertia() {
    for kind in ElementKind::SOLID {
        let mesh = Mesh::new(block(kind, [2, 3, 2], |x| shaken(x, 0.06)), 1.0).expect("a mesh");
        let matrices = matrices(&mesh);
        let scale = matrices.stiffness.val().iter().fold(0.0f64, |m, v| m.max(v.abs()));
        for motion in 0..6 {
            let field: Vec<f64> = mesh
                .nodes()
                .iter()
                .flat_map(|[x, y, z]| match motion {
                    3 => [0.0, -z, *y],
                    4 => [*z, 0.0, -x],
                    5 => [-y, *x, 0.0],
                    d => [0, 1, 2].map(|c| f64::from(u8::from(c == d))),
                })
                .collect();
            let force = times(&matrices.stiffness, &field);
            // Sums of some hundred products of the size of the largest entry.
            let largest = force.iter().fold(0.0f64, |m, f| m.max(f.abs()));
            assert!(largest < 1e-12 * scale, "{kind:?} motion {motion}: {:e}", largest / scale);
        }
        let ones = vec![1.0; mesh.nodes().len()];
        let mass: f64 = times(&matrices.mass, &ones).iter().sum();
        let properties = integrals(&mesh, &|_| steel().density());
        assert!((mass / properties.volume - 1.0).abs() < 1e-13);
        // Moments of inertia from the matrix are those of the integrals, whose rule is the same.
        let column =
            |d: usize| mesh.nodes().iter().map(|p| p[d] - properties.centre()[d]).collect::<Vec<_>>();
        let product =
            |a: &[f64], b: &[f64]| times(&matrices.mass, a).iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
        let (x, y) = (column(0), column(1));
        let about_z = product(&x, &x) + product(&y, &y);
        assert!((about_z / properties.central_inertia()[2][2] - 1.0).abs() < 1e-12, "{kind:?}");
    }
}

#[test]
fn mass_of_a_block_is_exact_on_straight_sided_elements() {
    for kind in ElementKind::SOLID {
        let mesh = straight(kind, [2, 2, 2]);
        let p = integrals(&mesh, &|_| 1.0);
        assert!((p.volume - 1.0).abs() < 1e-13, "{kind:?}: {:e}", p.volume - 1.0);
        // Moments have degree two more. Trilinear maps have determinants of degree two in each direction, which two points do not integrate together with a
        // square; the rules of the quadratic kinds do, and those of tetrahedra of both orders.
        if !matches!(kind, ElementKind::Hex8 | ElementKind::Wedge6) {
            for d in 0..3 {
                assert!((p.centre()[d] - 0.5).abs() < 1e-13, "{kind:?}");
                assert!((6.0 * p.central_inertia()[d][d] - 1.0).abs() < 1e-12, "{kind:?}");
            }
        }
    }
}

#[test]
fn a_curved_body_has_the_volume_of_its_sides() {
    // The volume of a mesh follows from its surface alone, ∮ x · n dA / 3, whose integrand has degree six at most on triangles.
    for kind in [
        ElementKind::Tet10,
        ElementKind::Hex20,
        ElementKind::Hex27,
        ElementKind::Wedge15,
        ElementKind::Wedge18,
        ElementKind::Pyramid13,
        ElementKind::Pyramid14,
    ] {
        let bent = |[x, y, z]: [f64; 3]| [x + 0.15 * y * y, y * (1.0 + 0.2 * z), z + 0.1 * x * (1.0 - x)];
        let mesh = Mesh::new(block(kind, [2, 2, 2], bent), 1.0).expect("a mesh");
        let volume = volume(&mesh);
        let mut flux = 0.0;
        let (mut at, mut places) = (fe_mesh::locate::SidePoint::default(), Vec::new());
        for &face in mesh.surface() {
            let (side, nodes) = mesh.face(face);
            mesh.places(&nodes, &mut places);
            for point in side.rule() {
                at.evaluate(side, &places, &point.xi);
                flux += point.weight * (0..3).map(|d| at.position[d] * at.area[d]).sum::<f64>() / 3.0;
            }
        }
        // On triangles x · n dA is of degree 2 + 2 = 4, on quadrilaterals of degree 5 in each direction: exact.
        assert!((flux / volume - 1.0).abs() < 1e-13, "{kind:?}: {:e}", flux / volume - 1.0);
    }
}

#[test]
fn constant_strain_leaves_no_force_inside() {
    let blocks = ElementKind::SOLID.map(|kind| (kind, straight(kind, [3, 3, 3])));
    let pyramids = [ElementKind::Pyramid5, ElementKind::Pyramid13, ElementKind::Pyramid14];
    // Hexahedra, pyramids and tetrahedra.
    let together = |kind| {
        let mesh = Mesh::new(straightened(mixed(kind, [5, 3, 3], |x| shaken(x, 0.06))), 1.0).expect("a mesh");
        assert_eq!(mesh.face_names().count(), 6);
        (kind, mesh)
    };
    for (kind, mesh) in blocks.into_iter().chain(pyramids.map(together)) {
        let gradient = [[1.0, 0.3, 0.0], [0.2, 0.0, -0.4], [0.1, -0.5, 0.7]];
        let matrices = matrices(&mesh);
        let field: Vec<f64> = mesh
            .nodes()
            .iter()
            .flat_map(|x| gradient.map(|row: [f64; 3]| (0..3).map(|j| row[j] * x[j]).sum::<f64>()))
            .collect();
        let force = times(&matrices.stiffness, &field);
        let (mut inside, mut outside) = (0.0f64, 0.0f64);
        for (node, f) in mesh.nodes().iter().zip(force.as_chunks::<3>().0) {
            let is_inside = node.iter().all(|x| (1e-9..1.0 - 1e-9).contains(x));
            let size = f.iter().fold(0.0f64, |m, x| m.max(x.abs()));
            *(if is_inside { &mut inside } else { &mut outside }) =
                size.max(if is_inside { inside } else { outside });
        }
        assert!(outside > 0.0 && inside < 1e-12 * outside, "{kind:?}: {:e}", inside / outside);
        // One stress at every node, the apexes of pyramids among them: round-off of some dozen terms.
        let wanted = PointState::new(&Model::Solid, &steel(), &gradient, 0.0).stress;
        let largest = wanted.iter().fold(0.0f64, |m, s| m.max(s.abs()));
        let space = MeshSpace::new(mesh, MassRule::Exact);
        for stress in space.nodal_stress(&steel(), &field).expect("no element is folded") {
            let off = stress.iter().zip(&wanted).fold(0.0f64, |m, (a, b)| m.max((a - b).abs()));
            assert!(off < 1e-12 * largest, "{kind:?}: {:e}", off / largest);
        }
    }
}

#[test]
fn threads_do_not_change_a_bit() {
    let mesh = straight(ElementKind::Tet10, [4, 4, 4]);
    let on = |n: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n).build().expect("a pool");
        pool.install(|| matrices(&mesh))
    };
    let (one, three) = (on(1), on(3));
    assert!(one.stiffness.val() == three.stiffness.val() && one.mass.val() == three.mass.val());
}

#[test]
fn materials_go_by_group() {
    let mut raw = block(ElementKind::Hex8, [2, 1, 1], |x| x);
    raw.volumes = vec![("left".into(), vec![0]), ("right".into(), vec![1])];
    let mesh = Mesh::new(raw, 1.0).expect("a mesh");
    let light = Material::new(210e9, 0.3, 1000.0).expect("constants");
    let materials = mesh.materials(&[("left", steel()), ("right", light)], None).expect("materials");
    let p = integrals(&mesh, &|e| materials.on(e).density());
    assert!((p.volume - 0.5 * 8850.0).abs() < 1e-9);
    let rest = mesh.materials(&[("left", steel())], Some(light)).expect("materials");
    assert_eq!(rest.on(1), &light);
    let missing = mesh.materials(&[("left", steel())], None).expect_err("one group is missing").to_string();
    assert!(missing.contains("element 2 is in 0"), "{missing}");
    let unknown = mesh.materials(&[("top", steel())], None).expect_err("unknown").to_string();
    assert!(unknown.contains("\"top\"") && unknown.contains("\"left\", \"right\""), "{unknown}");
}
