//! Readers of Gmsh and Abaqus files: the same mesh from every form, faults with their place, and nothing that panics.

use crate::blocks::{block, mixed, shaken};
use crate::damage::{cases, mutated};
use crate::writers::{Fields, Form, gmsh, inp, nastran};
use fe_mesh::fault::MeshError;
use fe_mesh::mesh::raw::{FaceSource, RawMesh};
use fe_mesh::read::{raw, read};
use fe_mesh::{ElementKind, Mesh};
use iga_core::extent::measure;

const FORMS: [Form; 7] = [
    Form::Text41,
    Form::Binary41,
    Form::BigEndian41,
    Form::Text40,
    Form::Binary40,
    Form::Text22,
    Form::Binary22,
];

fn sample(kind: ElementKind) -> RawMesh {
    let mut raw = block(kind, [2, 1, 1], |x| shaken(x, 0.05).map(|c| 20.0 * c));
    // Numbers of nodes with gaps, in another order.
    let n = raw.nodes.len() as u64;
    raw.node_labels = (0..n).map(|i| 3 * (n - i) + 10).collect();
    raw
}

fn assert_same(a: &Mesh, b: &Mesh, what: &str) {
    assert_eq!(a.elements().len(), b.elements().len(), "{what}");
    for (x, y) in a.elements().iter().zip(b.elements().iter()) {
        assert_eq!((x.kind, x.label), (y.kind, y.label), "{what}");
        for (&i, &j) in x.nodes.iter().zip(y.nodes) {
            assert_eq!(a.node_labels()[i as usize], b.node_labels()[j as usize], "{what}");
            assert_eq!(
                a.nodes()[i as usize].map(f64::to_bits),
                b.nodes()[j as usize].map(f64::to_bits),
                "{what}"
            );
        }
    }
    let faces = |m: &Mesh| {
        let mut all = m.faces().to_vec();
        all.retain(|(name, faces)| !faces.is_empty() && name != "everything");
        all.sort();
        all
    };
    assert_eq!(faces(a), faces(b), "{what}");
    assert_eq!(a.volumes(), b.volumes(), "{what}");
}

#[test]
fn every_form_of_a_file_gives_the_same_mesh() {
    for kind in ElementKind::ALL {
        let raw = sample(kind);
        let expected = Mesh::new(raw.clone(), 1e-3).expect("a mesh");
        assert!((expected.size() - 0.02 * (kind.dimension() as f64).sqrt()).abs() < 1e-15);
        for form in FORMS {
            let bytes = gmsh(&raw, form);
            let found = read(&bytes, 1e-3).unwrap_or_else(|e| panic!("{kind:?} {form:?}: {e}"));
            assert_same(&found, &expected, &format!("{kind:?} {form:?}"));
        }
        if !matches!(kind, ElementKind::Wedge18 | ElementKind::Pyramid14 | ElementKind::Quad9) {
            let found = read(inp(&raw).as_bytes(), 1e-3).unwrap_or_else(|e| panic!("{kind:?} inp: {e}"));
            assert_same(&found, &expected, &format!("{kind:?} inp"));
        }
    }
}

#[test]
fn files_hold_hexahedra_pyramids_and_tetrahedra_together() {
    for kind in [ElementKind::Pyramid5, ElementKind::Pyramid13, ElementKind::Pyramid14] {
        let raw = mixed(kind, [3, 1, 2], |x| shaken(x, 0.05));
        let expected = Mesh::new(raw.clone(), 1e-3).expect("a mesh");
        for form in FORMS {
            let found = read(&gmsh(&raw, form), 1e-3).unwrap_or_else(|e| panic!("{kind:?} {form:?}: {e}"));
            assert_same(&found, &expected, &format!("{kind:?} {form:?}"));
        }
        if kind != ElementKind::Pyramid14 {
            let found = read(inp(&raw).as_bytes(), 1e-3).unwrap_or_else(|e| panic!("{kind:?} inp: {e}"));
            assert_same(&found, &expected, &format!("{kind:?} inp"));
        }
    }
}

#[test]
fn sets_and_surfaces_of_input_files() {
    let raw = sample(ElementKind::Hex8);
    let text = inp(&raw)
        + "*ELSET, ELSET=both, GENERATE\n1, 1000000000000, 1\n*ELSET, ELSET=again\nboth, 1\n\
           *SURFACE, NAME=under, TYPE=ELEMENT\nboth, S1\n*SURFACE, NAME=left\n1, S6\n\
           *MATERIAL, NAME=M\n*ELASTIC\n1., 0.3\n*STEP\n*NODE\nnothing is read here\n";
    let mesh = read(text.as_bytes(), 1.0).expect("a mesh");
    assert_eq!(mesh.volume_group("again").expect("a set"), [0, 1]);
    assert_eq!(mesh.face_group("under").expect("a face").len(), 2);
    assert_eq!(mesh.face_group("under"), mesh.face_group("z-"));
    assert_eq!(mesh.face_group("left"), mesh.face_group("x-"));
    let notes = mesh.notes().join("\n");
    assert!(notes.contains("*MATERIAL (line") && notes.contains("*ELASTIC"), "{notes}");
}

#[test]
fn one_part_with_one_instance() {
    let raw = sample(ElementKind::Tet10);
    let body = inp(&raw);
    let text = format!(
        "*HEADING\nfrom another program\n*PART, NAME=P\n{body}*END PART\n*ASSEMBLY, NAME=A\n*INSTANCE, NAME=P-1, PART=P\n0., 0., 0.\n\
         *END INSTANCE\n*NSET, NSET=one, INSTANCE=P-1\nP-1.{}\n*NODE\n1, 0., 0., 0.\n\
         *ELEMENT, TYPE=MASS\n1, 1\n*END ASSEMBLY\n",
        raw.node_labels[0]
    );
    let mesh = read(text.as_bytes(), 1.0).expect("a mesh");
    assert_eq!(mesh.faces().iter().filter(|(name, _)| name == "one").count(), 1);
    let notes = mesh.notes().join("\n");
    assert!(
        notes.contains("*NODE of the assembly (line") && notes.contains("*ELEMENT of the assembly"),
        "{notes}"
    );
}

/// Nodes of a file with one tetrahedron, whose nodes have the numbers 1 to 4.
fn nodes_of(head: &str, nodes: &str) -> Result<Vec<[f64; 3]>, MeshError> {
    let text = format!("{head}\n*NODE\n{nodes}\n*ELEMENT, TYPE=C3D4\n1, 1, 2, 3, 4\n");
    let text = if head.starts_with("*NODE") { text.replacen("\n*NODE\n", "\n", 1) } else { text };
    raw(text.as_bytes()).map(|mesh| mesh.nodes)
}

#[test]
fn axes_and_kinds_of_coordinates_are_obeyed() {
    let plain = "1, 1, 2, 3\n2, 2, 2, 3\n3, 1, 3, 3\n4, 1, 2, 4";
    let half = 0.5_f64.sqrt();
    for (head, nodes, first) in [
        ("*HEADING", plain, [1.0, 2.0, 3.0]),
        ("*NODE, SYSTEM=R", plain, [1.0, 2.0, 3.0]),
        // Empty fields are zero, wherever they stand.
        ("*HEADING", "1, , 2.\n2, 1,,1\n3,,,\n4, 1, 2, 4", [0.0, 2.0, 0.0]),
        (
            "*NODE, SYSTEM=C, NSET=A",
            "1, 2., 45., 3.\n2, 2,,3\n3, 1, 3, 3\n4, 1, 2, 4",
            [2.0 * half, 2.0 * half, 3.0],
        ),
        ("*SYSTEM\n10, 20, 30", plain, [11.0, 22.0, 33.0]),
        // The first axis along y, the third stays; alike with a third point.
        ("*SYSTEM\n0, 0, 5, 0, 1, 5", plain, [-2.0, 1.0, 8.0]),
        ("*SYSTEM\n0, 0, 5, 0, 1, 5\n-1, 0, 5", plain, [-2.0, 1.0, 8.0]),
        // Axes z, y and -x.
        ("*SYSTEM\n, , , , , 2\n0, 7, 0", plain, [-3.0, 2.0, 1.0]),
        ("*SYSTEM\n1, 1, 1\n*SYSTEM", plain, [1.0, 2.0, 3.0]),
    ] {
        let found = nodes_of(head, nodes).unwrap_or_else(|e| panic!("{head}: {e}"))[0];
        let off = (0..3).map(|c| (found[c] - first[c]).abs()).fold(0.0, f64::max);
        assert!(off < 1e-14, "{head}: {found:?}");
    }
    for (head, words) in [
        ("*NODE, SYSTEM=S", &["line 1", "*NODE, SYSTEM=S", "(C)"][..]),
        ("*SYSTEM\n0, 0, 0, 1, 0, 1", &["line 1", "*SYSTEM", "third point"]),
        ("*SYSTEM\n0, 0, 0, 1, 0, 1\n2, 0, 2", &["line 1", "on a line"]),
        ("*SYSTEM\n1, 0, 0, 1, 0, 0", &["line 1", "without a direction"]),
        ("*SYSTEM\n1, 0, nan", &["line 2", "a coordinate expected"]),
        ("*SYSTEM\n1, 0, x", &["line 2", "a coordinate expected"]),
    ] {
        let text = nodes_of(head, plain).expect_err("refused").to_string();
        assert!(words.iter().all(|w| text.contains(w)), "{head}: {text}");
    }
}

#[test]
fn cards_that_make_geometry_are_refused() {
    let good = inp(&sample(ElementKind::Hex8));
    for (card, words) in [
        ("*NGEN\n1, 2, 1\n", "*NGEN"),
        ("*NFILL\nA, B, 3\n", "*NFILL"),
        ("*NCOPY, CHANGE NUMBER=10, OLD SET=A, SHIFT\n", "*NCOPY"),
        ("*NMAP, TYPE=RECTANGULAR\n", "*NMAP"),
        ("*ELGEN\n1, 3\n", "*ELGEN"),
        ("*elcopy, element shift=10, old set=A, shift nodes=10\n", "*ELCOPY"),
        ("*NSET, NSET=A, ELSET=NOWHERE\n", "NOWHERE"),
        ("*ELEMENT, TYPE=C3D4\n900, 10,, 13, 16, 19\n", "the number of a node or element"),
    ] {
        let text = refused(format!("{good}{card}").as_bytes());
        assert!(text.contains(words) && text.contains("line "), "{card}: {text}");
    }
}

#[test]
fn comments_stand_anywhere() {
    for kind in [ElementKind::Hex20, ElementKind::Tet10] {
        let good = inp(&sample(kind));
        let expected = read(good.as_bytes(), 1.0).expect("a mesh");
        let commented: String = good.lines().map(|line| format!("{line}\n** a comment, 1, 2\n")).collect();
        assert_same(&read(commented.as_bytes(), 1.0).expect("a mesh"), &expected, "comments");
        // Empty lines and comments within a card and an element that goes on.
        let broken = "*NODE\n1,0,0,0\n2,1,0,0\n3,0,1,0\n4,0,0,1\n*ELEMENT,\n** of one\nTYPE=C3D4\n7, 1, 2,\n** next\n\n3, 4\n";
        assert_eq!(read(broken.as_bytes(), 1.0).expect("a mesh").elements().len(), 1);
    }
}

#[test]
fn a_set_of_nodes_is_that_of_elements() {
    let text = inp(&sample(ElementKind::Hex8)) + "*ELSET, ELSET=E\n1\n*NSET, NSET=N, ELSET=E\n";
    let mesh = raw(text.as_bytes()).expect("a mesh");
    let Some((_, FaceSource::Nodes(nodes))) = mesh.faces.iter().find(|(name, _)| name == "N") else {
        panic!()
    };
    assert_eq!(nodes.len(), 8);
}

#[test]
fn a_volume_in_two_groups_of_version_2_is_one_volume() {
    let text = |second: &str| {
        format!(
            "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n2\n3 1 \"a\"\n3 2 \"b\"\n$EndPhysicalNames\n$Nodes\n5\n\
             1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 1 1 1\n$EndNodes\n$Elements\n4\n1 4 2 1 1 1 2 3 4\n2 4 2 1 1 2 3 4 5\n\
             {second}$EndElements\n"
        )
    };
    let mesh = read(text("3 4 2 2 1 1 2 3 4\n4 4 2 2 1 2 3 4 5\n").as_bytes(), 1.0).expect("a mesh");
    assert_eq!(mesh.elements().len(), 2);
    assert_eq!((mesh.volume_group("a"), mesh.volume_group("b")), (Ok(&[0, 1][..]), Ok(&[0, 1][..])));
    // The same element twice in one group stays a fault.
    let twice = refused(text("3 4 2 1 1 1 2 3 4\n4 4 2 1 1 2 3 4 5\n").as_bytes());
    assert!(twice.contains("share one side"), "{twice}");
}

fn refused(bytes: &[u8]) -> String {
    read(bytes, 1.0).expect_err("refused").to_string()
}

#[test]
fn faults_name_the_place_and_the_remedy() {
    let good = String::from_utf8(gmsh(&sample(ElementKind::Tet10), Form::Text41)).expect("text");
    for (bytes, words) in [
        (b"$MeshFormat\n4.2 0 8\n$EndMeshFormat\n".to_vec(), &["line 2", "MSH version 4.2", "msh41"][..]),
        (b"$MeshFormat\n4.1 0 8\n$EndMeshFormat\n".to_vec(), &["no $Nodes"]),
        (good.replace("$EndNodes", "").into_bytes(), &["line ", "$EndNodes", "found \"$Elements\""]),
        (good.as_bytes()[..good.len() / 2].to_vec(), &["line ", "the file ends within $Nodes"]),
        (
            good.replacen("3 1 11 ", "3 1 29 ", 1).into_bytes(),
            &["element 1 is a type 29 of Gmsh", "-order 2"],
        ),
        (
            b"$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$PartitionedEntities\n".to_vec(),
            &["line 4", "without partitions"],
        ),
        (
            b"$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n1 99999999999999 1 1\n".to_vec(),
            &["line 6", "ends within $Nodes"],
        ),
        (b"*NODE\n1, 0, 0, zero\n".to_vec(), &["line 2", "a coordinate expected", "zero"]),
        (b"*NODE\n1, 0, 0, 0\n*ELEMENT, TYPE=C3D7\n".to_vec(), &["line 3", "C3D7", "C3D10"]),
        (
            b"*NODE\n1, 0, 0, 0\n*ELEMENT, TYPE=C3D4\n7, 1, 1, 2, 1\n".to_vec(),
            &["line 4", "element 7 names node 2"],
        ),
        (b"*NODE\n1, 0, 0, 0\n*ELEMENT, TYPE=C3D4\n7, 1, 1,\n".to_vec(), &["ends within an element"]),
        (b"*NODE\n1,0,0,0\n1,0,0,1\n*NSET, NSET=A\n1\n".to_vec(), &["node 1 stands in the file twice"]),
        (b"*NODE\n1,0,0,nan\n".to_vec(), &["node 1 has a coordinate"]),
        (b"*NODE\n1,0,0,0\n*INCLUDE, INPUT=a.inp\n".to_vec(), &["\"a.inp\"", "one file"]),
        (b"*NODE\n1,0,0,0\n*ELSET, ELSET=A\nB\n".to_vec(), &["set \"A\" names the set \"B\""]),
        (
            b"*NODE\n1,0,0,0\n2,1,0,0\n3,0,1,0\n4,0,0,1\n*ELEMENT, TYPE=C3D4\n1,1,2,3,4\n*SURFACE, NAME=A\n1, T1\n".to_vec(),
            &["line 9", "S1 to S6"],
        ),
    ] {
        let text = refused(&bytes);
        assert!(words.iter().all(|w| text.contains(w)), "{words:?}: {text}");
    }
}

#[test]
fn short_files_do_not_make_large_sets() {
    // Each set has the one before twice: 2^60 members without a limit.
    let mut text = inp(&sample(ElementKind::Tet4));
    text += "*ELSET, ELSET=S0\n1, 2, 3\n";
    for i in 1..60 {
        text += &format!("*ELSET, ELSET=S{i}\nS{}, S{}\n", i - 1, i - 1);
    }
    assert!(refused(text.as_bytes()).contains("more than a file of this size has room for"));
    // A volume in a thousand groups, each of which gets all of its elements.
    let elements: String = (1..=1000).map(|i| format!("{i} 1 2 3 4\n")).collect();
    let text = format!(
        "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Entities\n0 0 0 1\n1 0 0 0 0 0 0 1000 {}0\n$EndEntities\n$Nodes\n1 4 1 4\n3 1 0 4\n1 2 3 4\n\
         0 0 0\n1 0 0\n0 1 0\n0 0 1\n$EndNodes\n$Elements\n1 1000 1 1000\n3 1 4 1000\n{elements}$EndElements\n",
        "7 ".repeat(1000)
    );
    let fault = refused(text.as_bytes());
    assert!(
        fault.contains("more than a file of this size has room for") && fault.contains("line "),
        "{fault}"
    );
    // Thousands of cards that are not read are noted by the first of them.
    let many: String = (0..3000).map(|i| format!("*CARD{i}\n")).collect();
    let mesh = read(format!("{}{many}", inp(&sample(ElementKind::Tet4))).as_bytes(), 1.0).unwrap();
    let note = mesh.notes().iter().find(|n| n.contains("cards that are not read")).unwrap();
    assert!(note.contains("*CARD0") && note.contains('…') && note.len() < 1000, "{note}");
}

/// Letters of the formats.
const LETTERS: &[u8] = b"0123456789-.e,*$= \n";

/// Reads what came of a file; memory follows from what was read.
fn survives(bytes: &[u8]) {
    if let Ok(mesh) = raw(bytes) {
        let members: usize = mesh.volumes.iter().map(|(_, e)| e.len()).sum();
        let faces = mesh.faces.iter().map(|(_, source)| match source {
            FaceSource::Corners(all) => all.len(),
            FaceSource::Sides(all) => all.len(),
            FaceSource::Nodes(all) => all.len(),
        });
        // In Gmsh's files an element may be in several groups, each of which stands in the file.
        assert!(mesh.nodes.len() + members + faces.sum::<usize>() <= 2 * bytes.len());
        let outcome: Result<Mesh, MeshError> = Mesh::new(mesh, 1.0);
        drop(outcome);
    }
}

#[test]
fn damaged_files_are_read_or_refused() {
    let raw = sample(ElementKind::Hex20);
    let mut files: Vec<Vec<u8>> = FORMS.iter().map(|form| gmsh(&raw, *form)).collect();
    files.push(inp(&raw).into_bytes());
    let part = inp(&raw);
    files.push(format!("*PART, NAME=P\n{part}*END PART\n*INSTANCE, NAME=I, PART=P\n1.\n*END INSTANCE\n*NSET, NSET=N\nI.x-\n").into_bytes());
    files.extend(
        [Fields::Short, Fields::Large, Fields::Free].map(|fields| nastran(&raw, fields).into_bytes()),
    );
    for file in &files {
        // Cut at some hundred places.
        (0..file.len()).step_by(1 + file.len() / 200).for_each(|n| survives(&file[..n]));
    }
    cases(300, |bytes| {
        survives(bytes);
        files.iter().for_each(|file| survives(&mutated(file, bytes, LETTERS)));
    });
}

#[test]
fn files_of_gmsh_itself() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("crates/fe-mesh/tests/gmsh");
    for (name, kind) in [
        ("tet10_text41", ElementKind::Tet10),
        ("tet10_binary41", ElementKind::Tet10),
        ("tet4_text22", ElementKind::Tet4),
        ("hex20_text22", ElementKind::Hex20),
        ("hex20_binary22", ElementKind::Hex20),
        ("hex27_binary41", ElementKind::Hex27),
        ("wedge15_binary22", ElementKind::Wedge15),
        ("wedge18_text41", ElementKind::Wedge18),
        ("pyramid5_binary41", ElementKind::Pyramid5),
        ("pyramid13_binary22", ElementKind::Pyramid13),
        ("pyramid14_text41", ElementKind::Pyramid14),
    ] {
        let bytes = std::fs::read(folder.join(format!("{name}.msh"))).expect("readable");
        let mesh = read(&bytes, 1e-3).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert!(mesh.elements().iter().any(|e| e.kind == kind), "{name}");
        assert_eq!(mesh.volume_group("disc").expect("a group").len(), mesh.elements().len(), "{name}");
        let volume = crate::blocks::volume(&mesh);
        let exact = std::f64::consts::PI * 25e-6 * 3e-3;
        // Eight sides about the rim: chords miss 1 - sin(45°)/45° = 10 % of the area. Parabolas through arcs of the angle a err by a⁴/480 of the
        // area, 8e-4.
        let limit = if kind.is_quadratic() { 1e-3 } else { 0.12 };
        assert!((volume / exact - 1.0).abs() < limit, "{name}: {}", volume / exact - 1.0);
        for face in ["bottom", "top"] {
            let area = measure(&mesh.face_part(face).expect("a face")) / (std::f64::consts::PI * 25e-6);
            assert!((area - 1.0).abs() < limit, "{name} {face}: {area}");
        }
        let sides: usize =
            ["bottom", "top", "jacket"].map(|f| mesh.face_group(f).expect("a face").len()).iter().sum();
        assert_eq!(sides, mesh.surface().len(), "{name}");
    }
}
