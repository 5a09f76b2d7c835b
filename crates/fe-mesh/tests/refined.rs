//! Meshes divided about a place, by identities: the part stays as it is, and so do all displacements of the mesh before.

use crate::balls::Ball;
use crate::blocks::{block, divisible, shaken, steel, volume};
use crate::matrices::times;
use faer::sparse::SparseColMat;
use fe_mesh::element::kind::Form;
use fe_mesh::element::rules::MassRule;
use fe_mesh::element::shape::Functions;
use fe_mesh::fault::MeshFault;
use fe_mesh::refined::{CellBall, RefinedMesh};
use fe_mesh::surface::Surface;
use fe_mesh::{ElementKind, Mesh, MeshSpace};
use iga_core::elasticity::Model;
use iga_core::elasticity::assembly::{AssembledMatrices, assemble};
use iga_core::extent::measure;

const PYRAMIDS: [ElementKind; 3] = [ElementKind::Pyramid5, ElementKind::Pyramid13, ElementKind::Pyramid14];
/// More pieces than any of these meshes has.
const MOST: usize = 200_000;

fn distance(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    (0..3).map(|d| (a[d] - b[d]).powi(2)).sum::<f64>().sqrt()
}

/// Divides the elements that hold `point` or come near it `levels` times.
fn about(mesh: &Mesh, point: [f64; 3], levels: u8) -> RefinedMesh {
    let wanted = |ball: &CellBall| ball.level < levels && distance(&ball.centre, &point) <= ball.radius;
    RefinedMesh::new(mesh, wanted, MOST).unwrap()
}

/// Length of the blocks: those of pyramids are divided at their hexahedra.
fn length(kind: ElementKind) -> f64 {
    if kind.form() == Form::Pyramid { 2.0 } else { 1.0 }
}

/// A curved block of two or three elements per direction of every kind; with pyramids twice as long, so that they are away from the place where it is divided.
fn parts(kind: ElementKind) -> Mesh {
    let curved = |x: [f64; 3]| {
        let [x, y, z] = shaken(x, 0.04);
        [x + 0.15 * y * y, 1.2 * y + 0.1 * (x + z) * x, z - 0.12 * x * y]
    };
    let length = length(kind);
    let long = |x: [f64; 3]| {
        let [x, y, z] = curved(x);
        [length * x, y, z]
    };
    Mesh::new(divisible(kind, [3, 2, 2], long), 1.0).unwrap()
}

fn matrices(refined: &RefinedMesh) -> AssembledMatrices {
    assemble(&MeshSpace::divided(refined, MassRule::Exact), &Model::Solid, &steel()).unwrap()
}

/// A sum over `nodes` with the weights `values` in terms of free nodes.
fn in_free(refined: &RefinedMesh, nodes: &[u32], values: &[f64]) -> Vec<(u32, f64)> {
    let mut sum = Vec::new();
    for (&node, value) in nodes.iter().zip(values) {
        match refined.followed(node) {
            [] => sum.push((node, *value)),
            list => sum.extend(list.iter().map(|(m, w)| (*m, w * value))),
        }
    }
    sum
}

pub fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |m, x| m.max(x.abs()))
}

/// Elements that `refined` has more than `mesh`.
fn n_pieces(refined: &RefinedMesh, mesh: &Mesh) -> usize {
    refined.mesh().elements().len() - mesh.elements().len()
}

#[test]
fn a_divided_mesh_keeps_volume_mass_inertia_and_surface() {
    for kind in ElementKind::SOLID {
        let mesh = parts(kind);
        let corner = *mesh.nodes().last().unwrap();
        for point in [corner, [0.4, 0.5, 0.45]] {
            let refined = about(&mesh, point, 4);
            assert!(n_pieces(&refined, &mesh) >= 28 && refined.n_free() < refined.mesh().nodes().len());
            let change = volume(refined.mesh()) / volume(&mesh) - 1.0;
            // Rules of the mass integrate the determinant exactly: sums over some thousand points.
            assert!(change.abs() < 1e-12, "{kind:?}: {change:e}");
            let area = |mesh: &Mesh| measure(&mesh.part_of(mesh.surface()));
            // Area elements are roots: what the rule of larger sides leaves.
            assert!((area(refined.mesh()) / area(&mesh) - 1.0).abs() < 1e-4, "{kind:?}");
            for (name, faces) in mesh.faces() {
                let (_, own) = refined.mesh().faces().iter().find(|(n, _)| n == name).unwrap();
                let of = |mesh: &Mesh, faces| measure(&mesh.part_of(faces));
                let change = of(refined.mesh(), own) / of(&mesh, faces) - 1.0;
                assert!(change.abs() < 1e-3, "{kind:?}, {name}: {change:e}");
            }
        }
    }
}

#[test]
fn displacements_are_continuous_over_hanging_sides_and_hold_those_of_the_mesh_before() {
    for kind in ElementKind::SOLID {
        let mesh = parts(kind);
        let refined = about(&mesh, [0.4, 0.5, 0.45], 4);
        let all = refined.mesh().nodes();
        for node in refined.n_free()..all.len() {
            let list = refined.followed(node as u32);
            assert!(list.iter().all(|(m, _)| (*m as usize) < refined.n_free()), "{kind:?}");
            let sum: f64 = list.iter().map(|(_, w)| w).sum();
            // A few dozen products of numbers of order one.
            assert!((sum - 1.0).abs() < 1e-13, "{kind:?}: {sum}");
            let place: [f64; 3] =
                [0, 1, 2].map(|d| list.iter().map(|(m, w)| w * all[*m as usize][d]).sum::<f64>());
            assert!(distance(&place, &all[node]) < 1e-13, "{kind:?}: {place:?}, {:?}", all[node]);
        }
        // Any values at the nodes of the mesh before, seen from both.
        let value = |node: u32| (1.7 * f64::from(node)).sin();
        let free: Vec<f64> = (0..refined.n_free())
            .map(|n| refined.functions_before(&mesh, n).iter().map(|(m, w)| w * value(*m)).sum())
            .collect();
        let mut functions = Functions::default();
        let centre = [0.21, 0.26, 0.3];
        for element in refined.mesh().elements().iter() {
            element.kind.functions(&centre, &mut functions);
            let list = in_free(&refined, element.nodes, &functions.values);
            let found: f64 = list.iter().map(|(m, w)| w * free[*m as usize]).sum();
            let mut places = Vec::new();
            refined.mesh().places(element.nodes, &mut places);
            let point = fe_mesh::element::jacobian::position(&functions.values, &places);
            let (e, xi) = mesh.locate(&point).unwrap();
            let of = mesh.elements().get(e);
            of.kind.functions(&xi, &mut functions);
            let wanted: f64 = of.nodes.iter().zip(&functions.values).map(|(n, v)| v * value(*n)).sum();
            // Newton's method finds the point to 1e-9 of the element, where fields of order one vary by as much.
            assert!((found - wanted).abs() < 1e-8, "{kind:?}: {found}, {wanted}");
        }
    }
}

#[test]
fn fields_agree_from_both_sides_of_every_seam() {
    for kind in ElementKind::SOLID {
        check_seams(kind, &about(&parts(kind), [0.4, 0.5, 0.45], 4));
    }
    // All but pyramids, so that these have nodes of others on all of their sides that are not their own.
    for kind in PYRAMIDS {
        let mesh = parts(kind);
        let is_other = |ball: &CellBall| {
            let is_pyramid = mesh.elements().iter().any(|e| {
                let at = |d: usize| {
                    let sum: f64 = e.nodes.iter().map(|&n| mesh.nodes()[n as usize][d]).sum();
                    sum / e.nodes.len() as f64
                };
                e.kind == kind && distance(&[at(0), at(1), at(2)], &ball.centre) < 1e-9
            });
            ball.level < 1 && !is_pyramid
        };
        let refined = RefinedMesh::new(&mesh, is_other, MOST).unwrap();
        let n_pyramids = |mesh: &Mesh| mesh.elements().iter().filter(|e| e.kind == kind).count();
        assert_eq!((n_pyramids(&mesh), n_pyramids(refined.mesh())), (20, 20));
        assert_eq!(refined.mesh().elements().len(), 20 + 8 * (mesh.elements().len() - 20));
        check_seams(kind, &refined);
    }
}

/// Values at free nodes that no smooth field has: what is continuous then is so by the ties alone.
fn check_seams(kind: ElementKind, refined: &RefinedMesh) {
    let fine = refined.mesh();
    let value = |node: u32| (1.7 * f64::from(node)).sin();
    let at = |nodes: &[u32], values: &[f64]| -> f64 {
        in_free(refined, nodes, values).iter().map(|(m, w)| w * value(*m)).sum()
    };
    let (mut functions, mut places, mut n_seen) = (Functions::default(), Vec::new(), 0);
    let boxes: Vec<_> = fine
        .elements()
        .iter()
        .map(|e| {
            fine.places(e.nodes, &mut places);
            fe_mesh::locate::bounds(&places)
        })
        .collect();
    for element in fine.elements().iter().step_by(7) {
        let corners = element.kind.corners();
        for side in element.kind.sides() {
            let share = 1.0 / side.len() as f64;
            let mut xi = [0, 1, 2].map(|d| side.iter().map(|&c| share * corners[c as usize][d]).sum::<f64>());
            // Off the middle, where no node is.
            let towards = corners[side[0] as usize];
            xi = [0, 1, 2].map(|d| 0.63 * xi[d] + 0.37 * towards[d]);
            element.kind.functions(&xi, &mut functions);
            fine.places(element.nodes, &mut places);
            let point = fe_mesh::element::jacobian::position(&functions.values, &places);
            let own = at(element.nodes, &functions.values);
            for (other, (low, high)) in fine.elements().iter().zip(&boxes) {
                if (0..3).any(|d| point[d] < low[d] || point[d] > high[d]) {
                    continue;
                }
                fine.places(other.nodes, &mut places);
                let Some(there) = fe_mesh::locate::parameters(other.kind, &places, &point) else {
                    continue;
                };
                other.kind.functions(&there, &mut functions);
                let found = at(other.nodes, &functions.values);
                n_seen += usize::from(other.nodes != element.nodes);
                // Parameters are found to 1e-9 of the element.
                assert!((found - own).abs() < 1e-7, "{kind:?}: {found}, {own} at {point:?}");
            }
        }
    }
    assert!(n_seen > 100, "{kind:?}: {n_seen}");
}

#[test]
fn tetrahedra_halved_across_a_line_hang_no_node_and_hold_displacements_of_the_mesh_before() {
    for kind in [ElementKind::Tet4, ElementKind::Tet10] {
        let mesh = parts(kind);
        // About the line along y through (0.45, ., 0.4): edges longer across it than their middles are away.
        let across = |x: &[f64; 3]| (x[0] - 0.45).hypot(x[2] - 0.4);
        let length = |[a, b]: [&[f64; 3]; 2]| {
            let length = (a[0] - b[0]).hypot(a[2] - b[2]);
            let middle = [0, 1, 2].map(|d| 0.5 * (a[d] + b[d]));
            (length > 0.02 && length >= across(&middle)).then_some(length)
        };
        let refined = RefinedMesh::at_edges(&mesh, length, MOST).unwrap();
        let fine = refined.mesh();
        // No node follows others: none hangs.
        assert_eq!(refined.n_free(), fine.nodes().len());
        let change = volume(fine) / volume(&mesh) - 1.0;
        assert!(change.abs() < 1e-12, "{kind:?}: {change:e}");
        check_seams(kind, &refined);
        let AssembledMatrices { stiffness, mass, .. } = matrices(&refined);
        let turn: Vec<f64> = fine.nodes().iter().flat_map(|x| [-x[1], x[0], 0.0]).collect();
        assert!(largest(&times(&stiffness, &turn)) < 1e-12 * largest(stiffness.val()), "{kind:?}");
        let total = times(&mass, &vec![1.0; fine.nodes().len()]).iter().sum::<f64>();
        assert!((total / (steel().density() * volume(&mesh)) - 1.0).abs() < 1e-12, "{kind:?}");
        // A displacement of the mesh before has the energy that it had there: 4e-3 is what rules of curved elements leave.
        let before = matrices(&about(&mesh, [9.0; 3], 1)).stiffness;
        let wave = |n: u32| (0..3).map(move |c| (1.7 * f64::from(3 * n + c)).sin());
        let coarse: Vec<f64> = (0..mesh.nodes().len() as u32).flat_map(wave).collect();
        let value = |(n, w): (u32, f64), c: usize| w * coarse[3 * n as usize + c];
        let at =
            |n: usize, c: usize| refined.functions_before(&mesh, n).into_iter().map(|f| value(f, c)).sum();
        let prolonged: Vec<f64> = (0..refined.n_free()).flat_map(|n| [0, 1, 2].map(|c| at(n, c))).collect();
        let energy = |k: &SparseColMat<u32, f64>, u: &[f64]| -> f64 {
            times(k, u).iter().zip(u).map(|(f, u)| f * u).sum()
        };
        let ratio = energy(&stiffness, &prolonged) / energy(&before, &coarse);
        let limit = if kind == ElementKind::Tet4 { 1e-12 } else { 4e-3 };
        assert!((ratio - 1.0).abs() < limit, "{kind:?}: {ratio}");
        // Pieces at the line stay long: none along it is below a quarter of the sides before.
        let wide = |x: &[f64; 3]| across(x) < 0.05;
        let near =
            fine.elements().iter().filter(|e| e.nodes.iter().all(|n| wide(&fine.nodes()[*n as usize])));
        let extent = |nodes: &[u32], of: &dyn Fn(&[f64; 3]) -> f64| {
            let all = nodes.iter().map(|n| of(&fine.nodes()[*n as usize]));
            let (low, high) =
                all.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (f64::min(a, x), f64::max(b, x)));
            high - low
        };
        let found: Vec<[f64; 2]> =
            near.map(|e| [extent(e.nodes, &|x| x[0]), extent(e.nodes, &|x| x[1])]).collect();
        let mean = |d: usize| found.iter().map(|x| x[d]).sum::<f64>() / found.len() as f64;
        assert!(mean(0) < 0.02 && mean(1) > 6.0 * mean(0), "{kind:?}: {} {}", mean(0), mean(1));
        // Each halving of the width adds as many.
        let count = |finest: f64| {
            let finer = |ends: [&[f64; 3]; 2]| length(ends).filter(|length| *length > finest);
            n_pieces(&RefinedMesh::at_edges(&mesh, finer, MOST).unwrap(), &mesh)
        };
        let counts = [0.16, 0.08, 0.04, 0.02].map(count);
        assert!(counts[3] - counts[2] < 2 * (counts[2] - counts[1]), "{kind:?}: {counts:?}");
        assert!(matches!(RefinedMesh::at_edges(&mesh, length, 100), Err(MeshFault::TooFine { .. })));
    }
    let hexahedra = parts(ElementKind::Hex20);
    assert!(matches!(RefinedMesh::at_edges(&hexahedra, |_| None, MOST), Err(MeshFault::Undivided { .. })));
}

#[test]
fn tetrahedra_halved_about_an_ellipse_are_of_its_lengths_and_keep_their_shape() {
    let mesh = parts(ElementKind::Tet10);
    // Of a tetrahedron: volume over that of the even one with the same sum of squares of edges, lengths in units of `by`.
    let quality = |mesh: &Mesh, nodes: &[u32], by: [f64; 3]| {
        let at = |k: usize| [0, 1, 2].map(|d| mesh.nodes()[nodes[k] as usize][d] / by[d]);
        let edge = |a: usize, b: usize| [0, 1, 2].map(|d| at(b)[d] - at(a)[d]);
        let [u, v, w] = [edge(0, 1), edge(0, 2), edge(0, 3)];
        let volume = (u[0] * (v[1] * w[2] - v[2] * w[1])
            + u[1] * (v[2] * w[0] - v[0] * w[2])
            + u[2] * (v[0] * w[1] - v[1] * w[0]))
            / 6.0;
        let squares = [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)]
            .map(|(a, b)| edge(a, b).iter().map(|x| x * x).sum::<f64>());
        6.0 * 2.0_f64.sqrt() * volume / (squares.iter().sum::<f64>() / 6.0).powf(1.5)
    };
    let least = |mesh: &Mesh, by: &dyn Fn(&[f64; 3]) -> [f64; 3]| {
        let all = mesh.elements().iter().map(|e| {
            let corner = |d: usize, k: usize| mesh.nodes()[e.nodes[k] as usize][d];
            let middle = [0, 1, 2].map(|d| (0..4).map(|k| 0.25 * corner(d, k)).sum::<f64>());
            quality(mesh, e.nodes, by(&middle))
        });
        all.fold(f64::INFINITY, f64::min)
    };
    let beyond = |x: &[f64; 3]| 0.7 * distance(x, &[0.45, 0.5, 0.4]);
    for longer in [1.0, 4.0] {
        let divided = |finest: f64| {
            let lengths = [finest, longer * finest, finest];
            let length = |[a, b]: [&[f64; 3]; 2]| {
                let middle = [0, 1, 2].map(|d| 0.5 * (a[d] + b[d]));
                let beyond = beyond(&middle);
                let share = |d: usize| ((a[d] - b[d]) / lengths[d].max(beyond)).powi(2);
                let length = (0..3).map(share).sum::<f64>().sqrt();
                (length > 1.0).then(|| length * finest.max(beyond))
            };
            let refined = RefinedMesh::at_edges(&mesh, length, MOST).unwrap();
            // No edge is left that is to be halved.
            for element in refined.mesh().elements().iter() {
                let corner = |k: usize| &refined.mesh().nodes()[element.nodes[k] as usize];
                let edges = [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)];
                assert!(edges.iter().all(|&(a, b)| length([corner(a), corner(b)]).is_none()));
            }
            refined
        };
        let refined = divided(0.02);
        assert_eq!(refined.n_free(), refined.mesh().nodes().len());
        let change = volume(refined.mesh()) / volume(&mesh) - 1.0;
        assert!(change.abs() < 1e-12, "{change:e}");
        check_seams(ElementKind::Tet10, &refined);
        // In the lengths that are wanted where they lie, pieces are a fifth as even as the worst element, at least.
        let wanted = |x: &[f64; 3]| [0.02, longer * 0.02, 0.02].map(|h: f64| h.max(beyond(x)));
        let (before, after) = (least(&mesh, &|_| [1.0; 3]), least(refined.mesh(), &wanted));
        let counts = [0.16, 0.08, 0.04, 0.02].map(|h| n_pieces(&divided(h), &mesh));
        assert!(after > before / 5.0, "{before} {after}");
        // Each halving adds as many.
        assert!(counts[3] - counts[2] < 2 * (counts[2] - counts[1]), "{counts:?}");
    }
}

#[test]
fn rigid_motions_and_constant_strain_pass_the_patch_test() {
    for kind in ElementKind::SOLID {
        let length = length(kind);
        let straight = |[x, y, z]: [f64; 3]| [1.1 * length * x + 0.2 * y, 0.9 * y - 0.1 * z, z + 0.15 * x];
        for (mesh, is_straight) in
            [(Mesh::new(divisible(kind, [3, 2, 2], straight), 1.0).unwrap(), true), (parts(kind), false)]
        {
            let refined = about(&mesh, [0.45, 0.5, 0.45], 4);
            let AssembledMatrices { stiffness, mass, .. } = matrices(&refined);
            let nodes = refined.free_nodes();
            let scale = largest(stiffness.val());
            let field =
                |of: &dyn Fn(&[f64; 3]) -> [f64; 3]| -> Vec<f64> { nodes.iter().flat_map(of).collect() };
            let turn = field(&|x| [-x[1], x[0], 0.0]);
            // Entries cancel in sums of some hundred.
            assert!(largest(&times(&stiffness, &turn)) < 1e-12 * scale, "{kind:?}");
            let shift = field(&|_| [0.3, -1.0, 0.6]);
            assert!(largest(&times(&stiffness, &shift)) < 1e-12 * scale, "{kind:?}");
            let total = times(&mass, &vec![1.0; nodes.len()]).iter().sum::<f64>();
            let before = steel().density() * volume(&mesh);
            assert!((total / before - 1.0).abs() < 1e-12, "{kind:?}");
            // Constant strain: no forces on nodes inside.
            let stretch = field(&|x| [0.2 * x[0] + 0.1 * x[1], 0.3 * x[1], -0.1 * x[2] + 0.2 * x[0]]);
            let forces = times(&stiffness, &stretch);
            let mut is_outside = vec![false; nodes.len()];
            for &face in refined.mesh().surface() {
                let (side, on) = refined.mesh().face(face);
                let list = in_free(&refined, &on, &vec![1.0; side.n_nodes()]);
                list.iter().for_each(|(n, _)| is_outside[*n as usize] = true);
            }
            let inside = (0..forces.len()).filter(|i| !is_outside[i / 3]).map(|i| forces[i]);
            let most = largest(&inside.collect::<Vec<_>>());
            // Curved elements pass it as far as their rule integrates gradients, which it does to the last bits where the map is affine.
            let limit = if is_straight { 1e-12 } else { 1e-2 };
            assert!(most < limit * largest(&forces), "{kind:?}: {most:e} of {:e}", largest(&forces));
        }
    }
}

#[test]
fn sides_of_one_level_are_neighbours_and_the_division_ends_by_itself() {
    let ball = Ball { radius: 10.0, across: [4, 4], layers: 3, growth: [1.0, 1.0] };
    for kind in [ElementKind::Hex20, ElementKind::Tet10] {
        let mesh = Mesh::new(ball.mesh(kind), 1e-3).unwrap();
        let bottom = [0.0, 0.0, -10e-3];
        let refined = about(&mesh, bottom, 6);
        // Each level adds a number that does not depend on it.
        let counts: Vec<usize> = (3..=6).map(|l| n_pieces(&about(&mesh, bottom, l), &mesh)).collect();
        assert!(counts[3] - counts[2] < 2 * (counts[2] - counts[1]), "{counts:?}");
        let surface = Surface::new(refined.mesh());
        let near = refined.mesh().nearest(&bottom).unwrap();
        let first = refined.mesh().surface().binary_search(&near.face).unwrap();
        assert!(surface.sides()[first].neighbours[..3].iter().all(Option::is_some));
        assert!((volume(refined.mesh()) / volume(&mesh) - 1.0).abs() < 1e-12);
    }
}

#[test]
fn pyramids_that_would_be_divided_are_refused_by_their_number() {
    for kind in PYRAMIDS {
        let mesh = Mesh::new(block(kind, [1, 1, 1], |x| x), 1.0).unwrap();
        let fault = RefinedMesh::new(&mesh, |ball| ball.level < 1 && ball.centre[2] > 0.8, MOST).unwrap_err();
        let text = fault.to_string();
        assert!(matches!(fault, MeshFault::Undivided { element: 2, .. }), "{text}");
        let words = ["element 2 (pyramid", "no pyramids near the touch", "model = \"quasistatic\""];
        assert!(words.iter().all(|word| text.contains(word)), "{text}");
        // A hexahedron beside them is halved once, not twice.
        let mesh = parts(kind);
        let beside = |levels: u8| {
            let wanted = |ball: &CellBall| ball.level < levels && (0.7..1.0).contains(&ball.centre[0]);
            RefinedMesh::new(&mesh, wanted, MOST)
        };
        assert!(beside(1).is_ok());
        assert!(matches!(beside(2), Err(MeshFault::Undivided { .. })));
    }
}

#[test]
fn too_many_pieces_are_refused() {
    let mesh = parts(ElementKind::Tet10);
    let all = RefinedMesh::new(&mesh, |ball| ball.level < 9, 10_000);
    assert!(all.unwrap_err().to_string().contains("10000"));
    let deep = |ball: &CellBall| distance(&ball.centre, &[0.4, 0.5, 0.45]) <= ball.radius;
    assert!(RefinedMesh::new(&mesh, deep, MOST).is_err());
}
