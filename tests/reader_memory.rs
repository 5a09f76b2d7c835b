//! Memory that the readers of other programs' files take: less than ten times the size of the file, whatever its format.

#![cfg(target_os = "linux")]

use crate::blocks;
use std::fmt::Write as _;
use std::process::Command;

use crate::writers::{Form, gmsh, inp};
use fbimpact::interchange::matrix_files::{read_map, read_matrix, read_nodes};
use fe_mesh::ElementKind;
use iga_core::files::{write_gismo, write_mfem};
use iga_core::nurbs::Patch;
use iga_core::splines::knots::KnotVector;

/// A line of the process's status \[bytes\].
fn status(key: &str) -> usize {
    let text = std::fs::read_to_string("/proc/self/status").unwrap();
    let line = text.lines().find(|l| l.starts_with(key)).unwrap();
    1024 * line.split_whitespace().nth(1).unwrap().parse::<usize>().unwrap()
}

/// Where the child finds the file and how it is read.
const FILE: &str = "FBIMPACT_READER_MEMORY";
/// What the child prints before its figure.
const TAKEN: &str = "taken: ";

/// Bytes that reading `file` takes in a process of its own beside its bytes, over their number: memory that was given back would hide what is taken.
/// Pages of the program itself count too, some hundred kilobytes to a megabyte: files in which a reader takes much are ten times as large.
fn share(name: &str, kind: &str, file: &[u8]) -> f64 {
    let folder = tempfile::TempDir::new().unwrap();
    let path = folder.path().join("file");
    std::fs::write(&path, file).unwrap();
    let child = Command::new(std::env::current_exe().unwrap())
        .args(["--ignored", "--exact", "reader_memory::child_reads_a_file", "--nocapture"])
        .env(FILE, format!("{kind} {}", path.display()))
        .output()
        .unwrap();
    let said = String::from_utf8(child.stdout).unwrap();
    let taken = said.split(TAKEN).nth(1).and_then(|t| t.split_whitespace().next()).unwrap();
    let share = taken.parse::<f64>().unwrap() / file.len() as f64;
    println!("{name}: {:.1} MB, {share:.1} times", 1e-6 * file.len() as f64);
    share
}

#[test]
#[ignore = "started by the other test, as a process of its own"]
fn child_reads_a_file() {
    let Ok(given) = std::env::var(FILE) else { return };
    let (kind, path) = given.split_once(' ').unwrap();
    let bytes = std::fs::read(path).unwrap();
    let text = || std::str::from_utf8(&bytes).unwrap();
    let before = status("VmRSS");
    match kind {
        "any" => {
            // Whether such a file is read does not matter.
            let (mesh, splines) = (fe_mesh::read::read(&bytes, 1e-3), iga_core::files::read(&bytes, 1e-3));
            let matrix = (read_matrix(text(), None), read_map(text()), read_nodes(text()));
            println!("{:?} {:?} {:?}", mesh.err(), splines.err(), matrix.0.err());
        }
        "mesh" => assert!(fe_mesh::read::read(&bytes, 1e-3).is_ok()),
        "splines" => assert!(iga_core::files::read(&bytes, 1e-3).is_ok()),
        _ => assert!(read_matrix(text(), None).is_ok()),
    }
    println!("{TAKEN}{}", status("VmHWM").saturating_sub(before));
}

/// A block of splines with `n` elements per direction, per patch.
fn patch(n: usize) -> Patch {
    let mut knots = vec![0.0, 0.0];
    knots.extend((0..=n).map(|i| i as f64 / n as f64));
    knots.extend([1.0, 1.0]);
    let knots = KnotVector::new(2, knots).unwrap();
    let m = knots.n_functions();
    let at = |i: usize| i as f64 / (m - 1) as f64 + 0.1234567 / (i + 3) as f64;
    let point = |i: usize| [at(i % m), at(i / m % m), at(i / m / m)];
    let points = (0..m * m * m).map(point).collect();
    Patch::new(vec![knots.clone(), knots.clone(), knots], points, vec![1.0; m * m * m]).unwrap()
}

#[test]
fn readers_take_less_than_ten_times_the_size_of_the_file() {
    let mut worst: Vec<(String, f64)> = Vec::new();
    let mut note = |name: &str, share: f64| worst.push((name.to_owned(), share));
    let raw = blocks::block(ElementKind::Hex8, [40, 40, 40], |x| x.map(|c| 10.0 * c));
    let tetrahedra = blocks::block(ElementKind::Tet10, [14, 14, 14], |x| x.map(|c| 10.0 * c));
    for (kind, raw) in [("hex8", raw), ("tet10", tetrahedra)] {
        let forms = [("4.1 text", Form::Text41), ("4.1 binary", Form::Binary41), ("2.2 text", Form::Text22)];
        for (form, file) in forms.into_iter().chain([("2.2 binary", Form::Binary22)]) {
            let (name, bytes) = (format!("MSH {form}, {kind}"), gmsh(&raw, file));
            note(&name, share(&name, "mesh", &bytes));
        }
        let (name, text) = (format!("input file, {kind}"), inp(&raw));
        note(&name, share(&name, "mesh", text.as_bytes()));
    }
    let patches = [patch(44)];
    for (name, text) in [("G+Smo", write_gismo(&patches, 1e-3)), ("MFEM", write_mfem(&patches, 1e-3))] {
        note(name, share(name, "splines", text.as_bytes()));
    }
    let mut forms = [("row, column, value", String::new()), ("short rows", String::new())]
        .into_iter()
        .chain([
            ("node, component", String::new()),
            ("DMIG", String::new()),
            ("Matrix Market", String::new()),
        ])
        .collect::<Vec<_>>();
    let n = 200_000;
    forms[3].1.push_str("DMIG    KAAX           0       6       2       0\n");
    let _ = writeln!(forms[4].1, "%%MatrixMarket matrix coordinate real symmetric\n{n} {n} {n}");
    for i in 1..=n {
        let value = 1.0e5 / f64::from(i);
        let _ = writeln!(forms[0].1, "{i} {i} {value:.13e}");
        let _ = writeln!(forms[1].1, "{} 1 1", i % 10 + 1);
        let _ = writeln!(forms[2].1, "{i},1, {i},1, {value:.13e}");
        let _ = writeln!(
            forms[3].1,
            "DMIG*   {:<16}{i:>16}{:>16}\n*       {i:>16}{:>16}{value:>16.8E}",
            "KAAX", 1, 1
        );
        let _ = writeln!(forms[4].1, "{i} {i} {value:.13e}");
    }
    for (name, text) in forms {
        note(name, share(name, "matrix", text.as_bytes()));
    }
    let over: Vec<&(String, f64)> = worst.iter().filter(|(_, share)| *share >= 10.0).collect();
    // Claim 13 of docs/verification.md.
    assert!(over.is_empty(), "{over:?}");
}

/// Files in which few bytes ask for many things: short names, lists that name long ones, lines and trees of one kind of thing. Each is read or refused.
fn hostile() -> Vec<(&'static str, String)> {
    let list = |n: usize, item: &dyn Fn(usize) -> String| (0..n).map(item).collect::<String>();
    let nodes = "*NODE\n1,0,0,0\n2,1,0,0\n3,0,1,0\n4,0,0,1\n";
    let entities =
        format!("$Entities\n0 0 0 1\n1 0 0 0 0 0 0 200000 {}0\n$EndEntities\n", "7 ".repeat(200_000));
    let gmsh = format!(
        "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n{entities}$Nodes\n1 4 1 4\n3 1 0 4\n1 2 3 4\n0 0 0 1 0 0 0 1 0 0 0 1\n\
         $EndNodes\n$Elements\n1 90000 1 90000\n3 1 4 90000\n{}$EndElements\n",
        list(90_000, &|i| format!("{i} 1 2 3 4\n"))
    );
    let net = |n: usize| {
        let knots =
            |n: usize| format!("0 0 {} 1 1", list(n - 3, &|i| format!("{:.4} ", (i + 1) as f64 / n as f64)));
        format!(
            "<Geometry type=\"TensorBSpline2\" id=\"0\"><Basis type=\"TensorBSplineBasis2\"><Basis index=\"0\"><KnotVector degree=\"1\">{}\
             </KnotVector></Basis><Basis index=\"1\"><KnotVector degree=\"1\">0 0 1 1</KnotVector></Basis></Basis><coefs geoDim=\"2\">{}</coefs></Geometry>",
            knots(n),
            list(2 * n - 2, &|i| format!("{} {}\n", i % (n - 1), i / (n - 1)))
        )
    };
    vec![
        ("parameters of a card", format!("*NODE{}\n1,0,0,0\n", ",A".repeat(500_000))),
        ("numbers of an element", format!("{nodes}*ELEMENT,TYPE=C3D4\n{}\n", "1,".repeat(500_000))),
        ("a truss", format!("{nodes}*ELEMENT,TYPE=T3D2\n{}\n", "1,".repeat(500_000))),
        ("unknown cards", format!("{nodes}{}", list(6_000, &|i| format!("*{i:x}\n")).repeat(20))),
        ("small sets", format!("{nodes}{}", list(300_000, &|i| format!("*NSET,NSET={i}\n1\n")))),
        ("sets of sets", {
            let many = list(100_000, &|i| format!("{},0,0,0\n", i + 5));
            format!("{nodes}{many}*NSET,NSET=A,GENERATE\n1,100004\n*NSET,NSET=B\n{}", "A\n".repeat(250_000))
        }),
        ("groups of an entity", gmsh),
        ("sections", {
            let head = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n";
            format!("{head}{}", list(2_000, &|i| format!("${i}\n$End{i}\n")).repeat(20))
        }),
        ("elements of a tree", format!("<xml>{}</xml>", "<a/>".repeat(200_000))),
        ("attributes", format!("<xml{}/>", list(60_000, &|i| format!(" a{i}=''")))),
        ("points of one digit", format!("<xml>{}</xml>", net(100_000))),
        ("a patch named often", {
            let often = "0 ".repeat(500_000);
            format!(
                "<xml>{}<MultiPatch><patches type=\"list\">{often}</patches></MultiPatch></xml>",
                net(100_000)
            )
        }),
        ("boundary of patches", {
            let head = "MFEM NURBS mesh v1.0\ndimension\n2\nelements\n1\n1 3 0 1 2 3\nboundary\n500000\n";
            format!("{head}{}", "1 1 0 1\n".repeat(500_000))
        }),
        ("words of a line", "1 ".repeat(500_000)),
        ("fields of a DMIG", format!("DMIG{}\n", ",".repeat(1_000_000))),
        ("names of a DMIG", list(60_000, &|i| format!("DMIG,{i}\n"))),
        ("an order of unknowns", list(300_000, &|i| format!("{}.1\n", i + 1))),
    ]
}

#[test]
fn small_things_in_great_number_take_less_than_ten_times_the_size_of_the_file() {
    let shares: Vec<(&str, f64)> =
        hostile().iter().map(|(name, text)| (*name, share(name, "any", text.as_bytes()))).collect();
    let over: Vec<&(&str, f64)> = shares.iter().filter(|(_, share)| *share >= 10.0).collect();
    // The bound of the project.
    assert!(over.is_empty(), "{over:?}");
}
