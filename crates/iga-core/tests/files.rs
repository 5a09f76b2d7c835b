//! Files of splines of other programs: what is written is read again, every form gives the same body, faults name the line, and nothing
//! panics.

use crate::damage::{cases, mutated};
use iga_core::elasticity::Model;
use iga_core::elasticity::mass_properties::MassProperties;
use iga_core::files::{SplineFile, read, write_gismo, write_mfem};
use iga_core::nurbs::joining::join;
use iga_core::nurbs::primitives::{SphereNet, axisymmetric, plane, solid, sphere};
use iga_core::nurbs::{FaceId, Patch, Shape};

/// A ball of seven patches of 10 mm, its patches turned against each other, with weights and nodes as MFEM numbers and writes them.
const BALL: &str = include_str!("files/ball_nodes.mesh");
/// A pipe of four patches, 8 mm inside, 10 mm outside, 30 mm long, in the same form.
const PIPE: &str = include_str!("files/pipe_nodes.mesh");
/// A tube of one patch in the form of G+Smo: knots to 4, a seam, left-handed, a comment before the declaration.
const TUBE: &str = include_str!("files/tube.xml");

fn shapes() -> Vec<(&'static str, Shape, Model)> {
    let plain = Model::PlaneStrain { thickness: 1.0 };
    vec![
        ("cube net", sphere::sphere(0.01, SphereNet::Cube).expect("a ball"), Model::Solid),
        ("spindle net", sphere::sphere(0.01, SphereNet::Spindle).expect("a ball"), Model::Solid),
        ("shells", sphere::sphere(0.01, SphereNet::Shells).expect("a ball"), Model::Solid),
        ("cylinder", solid::cylinder(0.01, 0.03).expect("a cylinder"), Model::Solid),
        ("tube", solid::hollow_cylinder(0.008, 0.01, 0.03).expect("a tube"), Model::Solid),
        ("box", solid::cuboid([0.1, 0.2, 0.3]).expect("a box"), Model::Solid),
        ("disc", plane::disc(0.01).expect("a disc"), plain),
        ("rectangle", plane::rectangle(0.1, 0.3).expect("a rectangle"), plain),
        ("rod", axisymmetric::rod(0.01, 0.1).expect("a rod"), Model::Axisymmetric),
    ]
}

fn volume(patches: &[Patch], model: &Model) -> f64 {
    let joined = join(patches, &[]).unwrap_or_else(|e| panic!("{e}"));
    MassProperties::of(&joined.shape, model).expect("regular").volume
}

#[test]
fn what_is_written_is_read_again() {
    for (name, shape, model) in shapes() {
        for unit in [1.0, 1e-3] {
            for (form, text) in
                [("gismo", write_gismo(&shape.patches, unit)), ("mfem", write_mfem(&shape.patches, unit))]
            {
                let file = read(text.as_bytes(), unit).unwrap_or_else(|e| panic!("{name} {form}: {e}"));
                assert_eq!(file.patches.len(), shape.patches.len(), "{name} {form}");
                assert!(file.notes.is_empty(), "{name} {form}: {:?}", file.notes);
                for (a, b) in file.patches.iter().zip(&shape.patches) {
                    assert_eq!((a.knots(), a.weights()), (b.knots(), b.weights()), "{name} {form}");
                    for (p, q) in a.control_points().iter().zip(b.control_points()) {
                        // Two roundings: by the unit and back.
                        let close = p.iter().zip(q).all(|(x, y)| (x - y).abs() <= 4.5e-16 * y.abs());
                        assert!(close, "{name} {form}: {p:?} {q:?}");
                    }
                }
                let joined =
                    join(&file.patches, &file.joined).unwrap_or_else(|e| panic!("{name} {form}: {e}"));
                let expected = MassProperties::of(&shape, &model).expect("regular").volume;
                let found = MassProperties::of(&joined.shape, &model).expect("regular").volume;
                assert!((found / expected - 1.0).abs() < 1e-13, "{name} {form}"); // round-off of sums
                // Each pair of neighbours stands in the file.
                let n_joined = if shape.patches.len() == 7 { 18 } else { 0 };
                let seams = usize::from(name == "tube" && form == "gismo");
                assert!(
                    form == "gismo" && shape.patches.len() == 1 || file.joined.len() == n_joined + seams,
                    "{name} {form}: {}",
                    file.joined.len()
                );
            }
        }
    }
}

#[test]
fn nodes_in_the_order_of_mfem_make_the_same_bodies() {
    let exact = 4.0 / 3.0 * std::f64::consts::PI * 1e-6;
    let ball = read(BALL.as_bytes(), 1e-3).expect("a ball");
    assert_eq!((ball.patches.len(), ball.joined.len()), (7, 18));
    assert!(join(&ball.patches, &ball.joined).is_ok());
    assert!((volume(&ball.patches, &Model::Solid) / exact - 1.0).abs() < 1e-12);
    let pipe = read(PIPE.as_bytes(), 1e-3).expect("a pipe");
    assert_eq!((pipe.patches.len(), pipe.joined.len()), (4, 4));
    let exact = std::f64::consts::PI * (1e-4 - 0.64e-4) * 0.03;
    assert!((volume(&pipe.patches, &Model::Solid) / exact - 1.0).abs() < 1e-12);
}

/// Elements of the boundary name faces by their attribute: as written, one each; as one attribute, all of them; inside of the body, none.
#[test]
fn attributes_of_the_boundary_are_names_of_faces() {
    let cube = solid::cuboid([1.0; 3]).expect("a box").patches;
    let text = write_mfem(&cube, 1.0);
    let faces = read(text.as_bytes(), 1.0).expect("a box").faces;
    let outer = FaceId::all(&cube);
    assert_eq!(faces.len(), 6);
    assert!(outer.iter().all(|id| faces.iter().filter(|(_, ids)| *ids == [*id]).count() == 1), "{faces:?}");
    let mut same = text.clone();
    (2..=6).for_each(|i| same = same.replace(&format!("\n{i} 3 "), "\n1 3 "));
    let faces = read(same.as_bytes(), 1.0).expect("a box").faces;
    assert!(faces.len() == 1 && faces[0].0 == "1" && faces[0].1.len() == 6, "{faces:?}");
    // Two vertices of different faces are no face.
    let line = text.lines().find(|l| l.starts_with("1 3 ")).expect("a face");
    let wrong = read(text.replacen(line, "1 3 0 1 2 6", 1).as_bytes(), 1.0).expect("a box");
    assert!(wrong.faces.len() == 5 && wrong.notes[0].contains("1 of 6 elements"), "{:?}", wrong.notes);
}

#[test]
fn tube_of_gismo_has_its_volume() {
    let SplineFile { patches, notes, .. } = read(TUBE.as_bytes(), 1e-3).expect("a tube");
    let joined = join(&patches, &[]).expect("a tube");
    let exact = std::f64::consts::PI * (1e-4 - 0.64e-4) * 0.03;
    assert!((volume(&patches, &Model::Solid) / exact - 1.0).abs() < 1e-12);
    assert_eq!(joined.shape.faces.len(), 4, "a seam is no outer face");
    assert!(joined.notes[0].contains("left-handed") && notes.is_empty(), "{:?} {notes:?}", joined.notes);
}

#[test]
fn faults_name_the_line_and_the_remedy() {
    let cube = write_gismo(&solid::cuboid([1.0; 3]).expect("a box").patches, 1.0);
    let shells = write_gismo(&sphere::sphere(1.0, SphereNet::Shells).expect("a ball").patches, 1.0);
    let mesh = write_mfem(&solid::cuboid([1.0; 3]).expect("a box").patches, 1.0);
    let attributes: String = (0..101).map(|i| format!(" attribute_of_no_meaning_{i}=\"1\"")).collect();
    let crowded = format!("<!-- <{} --><xml{attributes}>", "=".repeat(80));
    for (text, words) in [
        ("solid cube\n".to_owned(), &["line 1", "neither XML of G+Smo", "MFEM NURBS mesh v1.0"][..]),
        (cube.replace("</Geometry>", ""), &["line ", "no XML"]),
        ("<xml></xml>".to_owned(), &["no Geometry", "TensorNurbs3"]),
        (cube.replace("0.5", "zero"), &["line ", "a number expected in coefs", "zero"]),
        (cube.replacen("degree=\"1\"", "degree=\"x\"", 1), &["line 7", "a degree expected"]),
        (cube.replacen("degree=\"1\"", "degree=\"12\"", 1), &["line 7", "degree 12 is not supported"]),
        (cube.replacen("1.0 1.0</Knot", "1.0 1.0 1.0</Knot", 1), &["line 7", "end knots"]),
        (cube.replacen(" geoDim=\"3\"", " geoDim=\"3\" format=\"B64Float64\"", 1), &["B64Float64", "ASCII"]),
        (cube.replacen(" geoDim=\"3\"", " geoDim=\"4\"", 1), &["geoDim = \"4\""]),
        (
            cube.replace("  </coefs>", "1 2 3\n  </coefs>"),
            &["line ", "numbers in coefs: 27 found, 24 are needed"],
        ),
        (cube.replacen("<weights>1.0", "<weights>-1.0", 1), &["line 3", "weight 0 is -1"]),
        (
            shells.replace("id_range\">0 6", "id_range\">0 9000000000000000000"),
            &["MultiPatch names the geometry 7"],
        ),
        (shells.replace("id=\"3\"", "id=\"2\""), &["a second Geometry with id 2"]),
        (cube.replacen("<xml>", &crowded, 1), &["no XML", "a tag has more than 100 attributes"]),
        (
            shells.replace("type=\"id_range\">0 6", "type=\"id_list\">0 1 2 1"),
            &["a MultiPatch with geometry 1 twice", "once"],
        ),
        (cube.replacen("<xml>", &format!("<xml>{}", "<a b=''/>".repeat(500)), 1), &["no XML", "tags"]),
        (cube.replacen("<xml>", &format!("<xml><!-- {} -->", "=".repeat(500)), 1), &["no XML", "attributes"]),
        (shells.replace("<interfaces>\n0 1", "<interfaces>\n0 9"), &["an interface names the side 9"]),
        (mesh.replace("v1.0", "v2.0"), &["line 1", "MFEM NURBS mesh v2.0", "v1.1"]),
        (mesh.replace("NURBS mesh", "NURBS NC-patch mesh"), &["NC-patch", "whole faces"]),
        (
            mesh.replace("\ndimension\n3\n\nelements", "\ndimension\n1\n\nelements"),
            &["line 4", "1 directions"],
        ),
        (mesh.replace("1 5 0 1 2", "1 4 0 1 2"), &["line 8", "element 0 of kind 4", "cubes"]),
        (mesh.replace("1 5 0 1 2", "1 5 0 0 2"), &["line 8", "vertex twice"]),
        (mesh.replace("vertices\n8", "vertices\n7"), &["names vertex 7"]),
        (mesh.replace("elements\n1\n", "elements\n99999999999\n"), &["line 7", "ends within the elements"]),
        (mesh.replacen("1 2 0.0 0.0 1.0 1.0", "1 99999999 0.0 0.0 1.0 1.0", 1), &["ends within patch 0"]),
        (mesh[..mesh.len() - 30].to_owned(), &["the file ends within patch 0"]),
        (mesh.replace("\n0.5 0.5 0.5 1.0", "\n0.5 0.5 0.5 0.0"), &["weight 7 is 0"]),
        (
            PIPE.replace("FiniteElementCollection: NURBS", "FiniteElementCollection: NURBS5"),
            &["NURBS5", "other degrees"],
        ),
        (PIPE.replace("\nweights", "\nperiodic"), &["\"periodic\"", "joined anyway"]),
        (PIPE.replacen("edges\n32\n", "edges\n31\n", 1), &["line ", "vertices expected"]),
    ] {
        let text = read(text.as_bytes(), 1.0).expect_err(words[0]).to_string();
        assert!(words.iter().all(|w| text.contains(w)), "{words:?}: {text}");
    }
    let latin = read(b"<xml>\n<!-- gr\xf6sse --></xml>", 1.0).expect_err("no text").to_string();
    assert!(latin.contains("line 2: not text"), "{latin}");
}

#[test]
fn small_files_take_little_memory_and_time() {
    // Three knot vectors of a few thousand knots ask for 1e11 control points.
    let knots = |n: usize| {
        format!(
            "1 {n} 0 {} 1",
            (0..n).map(|i| format!("{:.6} ", i as f64 / (n - 1) as f64)).collect::<String>()
        )
    };
    let huge = PIPE.replacen("1 2 0 0 1 1", &knots(5000), 1).replacen("1 2 0 0 1 1", &knots(5000), 1);
    let huge = huge.replacen("2 3 0 0 0 1 1 1", &knots(5000), 1);
    assert_ne!(huge, PIPE);
    let fault = read(huge.as_bytes(), 1.0).expect_err("refused").to_string();
    assert!(
        ["ends within the weights", "different knots", "knots in all"]
            .iter()
            .any(|words| fault.contains(words)),
        "{fault}"
    );
    // Trees as deep and as wide as bytes allow are refused before they are made.
    for text in ["<a>".repeat(300_000), format!("<xml>{}</xml>", "<a/>".repeat(300_000))] {
        let fault = read(text.as_bytes(), 1.0).expect_err("refused").to_string();
        assert!(fault.contains("no XML"), "{fault}");
    }
}

/// Letters of the formats.
const LETTERS: &[u8] = b"0123456789-.e,<>/\" \n";

/// Reads what came of a file, and joins what is read.
fn survives(bytes: &[u8]) {
    if let Ok(file) = read(bytes, 1e-3) {
        let points: usize = file.patches.iter().map(Patch::n_functions).sum();
        assert!(2 * points <= bytes.len(), "a control point takes two characters at least");
        drop(join(&file.patches, &file.joined));
    }
}

#[test]
fn damaged_files_are_read_or_refused() {
    let cube = solid::cuboid([1.0; 3]).expect("a box").patches;
    let disc = plane::disc(1.0).expect("a disc").patches;
    let pipe = read(PIPE.as_bytes(), 1.0).expect("a pipe").patches;
    let files: Vec<Vec<u8>> = vec![
        PIPE.into(),
        TUBE.into(),
        write_gismo(&cube, 1.0).into(),
        write_mfem(&disc, 1.0).into(),
        write_gismo(&pipe, 1.0).into(),
        write_mfem(&pipe, 1.0).into(),
    ];
    for file in &files {
        // Cut at some hundred places.
        (0..file.len()).step_by(1 + file.len() / 200).for_each(|n| survives(&file[..n]));
    }
    cases(300, |bytes| {
        survives(bytes);
        files.iter().for_each(|file| survives(&mutated(file, bytes, LETTERS)));
    });
}
