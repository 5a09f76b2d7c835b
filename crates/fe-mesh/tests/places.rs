//! Faces, discs, balls and points of a mesh, and the checks of it.

use crate::blocks::{block, shaken};
use fe_mesh::element::rules::MassRule;
use fe_mesh::mesh::raw::{FaceSource, RawMesh};
use fe_mesh::{ElementKind, Mesh, MeshSpace};
use iga_core::extent::{centroid, measure};
use iga_core::space::Space;

fn mesh(kind: ElementKind) -> Mesh {
    Mesh::new(block(kind, [3, 3, 3], |x| shaken(x, 0.05)), 1.0).expect("a mesh")
}

#[test]
fn faces_have_their_area_centre_and_outward_normal() {
    for kind in ElementKind::SOLID {
        let mesh = mesh(kind);
        assert_eq!(mesh.face_names().count(), 6);
        let total: usize = mesh.faces().iter().map(|(_, faces)| faces.len()).sum();
        assert_eq!(total, mesh.surface().len());
        for (name, axis, end) in [("x-", 0, 0.0), ("x+", 0, 1.0), ("y+", 1, 1.0), ("z-", 2, 0.0)] {
            let part = mesh.face_part(name).expect("a face");
            assert!((measure(&part) - 1.0).abs() < 1e-13);
            for d in 0..3 {
                let expected = if d == axis { end } else { 0.5 };
                assert!((centroid(&part)[d] - expected).abs() < 1e-13, "{kind:?} {name}");
            }
            let (mut at, mut places) = (fe_mesh::locate::SidePoint::default(), Vec::new());
            for &face in mesh.face_group(name).expect("a face") {
                let (side, nodes) = mesh.face(face);
                mesh.places(&nodes, &mut places);
                at.evaluate(side, &places, &[0.2, 0.3]);
                assert!(at.area[axis] * (end - 0.5) > 0.0, "{kind:?} {name}");
            }
        }
    }
}

#[test]
fn points_are_found_in_their_elements() {
    for kind in ElementKind::SOLID {
        let mesh = mesh(kind);
        let mut functions = fe_mesh::element::shape::Functions::default();
        for point in [[0.3, 0.41, 0.77], [0.05, 0.9, 0.5], [1.0, 0.25, 0.6], [0.0, 0.0, 0.0]] {
            let (e, xi) = mesh.locate(&point).expect("inside");
            let element = mesh.elements().get(e);
            element.kind.functions(&xi, &mut functions);
            for d in 0..3 {
                let x: f64 = functions
                    .values
                    .iter()
                    .zip(element.nodes)
                    .map(|(v, &n)| v * mesh.nodes()[n as usize][d])
                    .sum();
                assert!((x - point[d]).abs() < 1e-9, "{kind:?} {point:?}");
            }
        }
        let lost = mesh.locate(&[1.3, 0.5, 0.5]).expect_err("outside").to_string();
        assert!(lost.contains("nearest distance 3.000e-1"), "{lost}");
    }
}

/// Slopes of pyramids jump at their apex.
#[test]
fn points_at_the_apex_of_pyramids_are_found() {
    for kind in [ElementKind::Pyramid5, ElementKind::Pyramid13, ElementKind::Pyramid14] {
        let mesh = Mesh::new(block(kind, [1, 2, 1], |x| shaken(x, 0.05)), 1.0).expect("a mesh");
        let mut functions = fe_mesh::element::shape::Functions::default();
        for n in 0..200u32 {
            let apex = mesh.elements().get(if n % 2 == 0 { 0 } else { 6 }).nodes[4];
            // From nothing to a tenth of an element, in directions that hold no pattern.
            let away = 0.1 * 10.0_f64.powi(-((n / 2) as i32 % 16)) * f64::from(u8::from(n > 1));
            let direction = [1.7, 2.9, 4.3].map(|c| (c * f64::from(n)).sin());
            let place = mesh.nodes()[apex as usize];
            let point: [f64; 3] = std::array::from_fn(|d| place[d] + away * direction[d]);
            let (e, xi) = mesh.locate(&point).expect("inside");
            let element = mesh.elements().get(e);
            element.kind.functions(&xi, &mut functions);
            for d in 0..3 {
                let parts = functions.values.iter().zip(element.nodes);
                let x: f64 = parts.map(|(v, &n)| v * mesh.nodes()[n as usize][d]).sum();
                assert!((x - point[d]).abs() < 1e-9, "{kind:?} {point:?}");
            }
        }
    }
}

#[test]
fn discs_and_balls_have_their_measure() {
    for kind in ElementKind::SOLID {
        let mesh = mesh(kind);
        let disc = mesh.around(&[0.5, 0.45, 1.0], 0.3).expect("a disc");
        let area = std::f64::consts::PI * 0.09;
        // The rule is exact in a plane.
        assert!((measure(&disc) / area - 1.0).abs() < 1e-12);
        assert!((centroid(&disc)[1] - 0.45).abs() < 1e-12 && (centroid(&disc)[2] - 1.0).abs() < 1e-12);
        let ball = mesh.around(&[0.5, 0.5, 0.45], 0.2).expect("a ball");
        assert!((measure(&ball) / (4.0 / 3.0 * std::f64::consts::PI * 0.008) - 1.0).abs() < 1e-12);
        for (point, radius, word) in [([0.1, 0.5, 1.0], 0.3, "disc"), ([0.15, 0.5, 0.5], 0.2, "ball")] {
            let fault = mesh.around(&point, radius).expect_err("leaves the body").to_string();
            assert!(fault.contains(word) && fault.contains("smaller radius"), "{fault}");
        }
        // Elements and parameters are those of the points.
        let space = MeshSpace::new(mesh.clone(), MassRule::Exact);
        for point in disc.iter().chain(&ball) {
            let functions = space.functions_at(point.element, &point.xi);
            for d in 0..3 {
                let sum: f64 = functions.iter().map(|(node, v)| v * mesh.nodes()[*node as usize][d]).sum();
                assert!((sum - point.point[d]).abs() < 1e-12, "{sum} {}", point.point[d]);
            }
        }
    }
}

fn fault(raw: RawMesh) -> String {
    Mesh::new(raw, 1.0).expect_err("makes no body").to_string()
}

#[test]
fn what_makes_no_body_is_named() {
    let good = || block(ElementKind::Hex8, [2, 1, 1], |x| x);
    assert!(fault(RawMesh::default()).contains("no solid or plane elements"));
    let mirrored = block(ElementKind::Tet10, [1, 1, 1], |[x, y, z]| [-x, y, z]);
    assert!(fault(mirrored).contains("element 1 (tet10) is inside out"));
    let mut raw = block(ElementKind::Hex20, [1, 1, 1], |x| x);
    raw.nodes[0] = [1.5; 3];
    let text = fault(raw);
    assert!(text.contains("element 1 (hex20)") && text.contains("folded at a corner"), "{text}");
    let mut raw = good();
    let far: Vec<u32> = raw.elements.get(0).nodes.to_vec();
    raw.elements.push(ElementKind::Hex8, 9, far.into_iter());
    assert!(fault(raw).contains("elements 1, 2 and 9 share one side"));
    let mut raw = good();
    let n = raw.nodes.len() as u32;
    let more: Vec<[f64; 3]> =
        raw.elements.get(0).nodes.iter().map(|&i| raw.nodes[i as usize].map(|x| x + 3.0)).collect();
    raw.nodes.extend(more);
    raw.node_labels.extend(100..108);
    raw.elements.push(ElementKind::Hex8, 7, n..n + 8);
    let text = fault(raw);
    assert!(text.contains("2 parts") && text.contains("\"all\", \"element 7\""), "{text}");
    // The middle of an edge between two elements is there twice.
    let mut raw = block(ElementKind::Hex20, [2, 1, 1], |x| x);
    let mut nodes: Vec<u32> = raw.elements.get(1).nodes.to_vec();
    let shared = nodes.iter().position(|n| *n == raw.elements.get(0).nodes[9]).expect("a shared node");
    nodes[shared] = raw.nodes.len() as u32;
    raw.nodes.push([0.5, 0.5, 0.0]);
    raw.node_labels.push(99);
    let mut elements = fe_mesh::mesh::raw::Elements::default();
    elements.push(ElementKind::Hex20, 1, raw.elements.get(0).nodes.iter().copied());
    elements.push(ElementKind::Hex20, 2, nodes.into_iter());
    raw.elements = elements;
    let text = fault(raw);
    assert!(text.contains("elements 1 and 2 share the corners"), "{text}");
    let mut raw = good();
    raw.elements.push(ElementKind::Tet10, 5, 0..10);
    assert!(fault(raw).contains("element 1 is a hex8, element 5 a tet10"));
    let mut raw = good();
    raw.elements.push(ElementKind::Tet4, 5, [0, 1, 1, 2].into_iter());
    assert!(fault(raw).contains("element 5 names node 2 twice"));
}

#[test]
fn elements_are_one_body_whatever_their_numbers() {
    // All orders of twelve nodes that two blocks with a common side may have, in steps that hold no pattern.
    for seed in 0..200u64 {
        let mut raw = block(ElementKind::Hex8, [2, 1, 1], |x| x);
        let n = raw.nodes.len();
        let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
        let mut numbers: Vec<u32> = (0..n as u32).collect();
        for i in (1..n).rev() {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            numbers.swap(i, (state >> 33) as usize % (i + 1));
        }
        let mut nodes = raw.nodes.clone();
        (0..n).for_each(|i| nodes[numbers[i] as usize] = raw.nodes[i]);
        raw.nodes = nodes;
        raw.elements.renumber(&numbers);
        raw.faces.clear();
        assert!(Mesh::new(raw, 1.0).is_ok(), "{numbers:?}");
    }
}

#[test]
fn what_is_doubtful_is_noted() {
    let mut raw = block(ElementKind::Tet4, [2, 2, 2], |x| x);
    raw.nodes.push([9.0; 3]);
    raw.node_labels.push(77);
    raw.faces.push(("inside".into(), FaceSource::Corners(vec![[0, 1, 2, 3]])));
    let mesh = Mesh::new(raw, 1000.0).expect("a mesh");
    let notes = mesh.notes().join("\n");
    for word in ["too stiff", "left out: 77", "unit of length", "group \"inside\" are no sides"] {
        assert!(notes.contains(word), "{word}: {notes}");
    }
    let text = mesh.face_group("inside").expect_err("no sides").to_string();
    assert!(text.contains("no side on the surface"), "{text}");
    let text = mesh.face_group("top").expect_err("no group").to_string();
    assert!(text.contains("\"x-\", \"x+\""), "{text}");
}
