//! Memory that the readers of other programs' files take: less than ten times the size of the file, whatever its format.

#![cfg(target_os = "linux")]

use crate::blocks;
use std::fmt::Write as _;
use std::process::Command;

use crate::writers::{Form, gmsh, inp};
use fbimpact::matrix_files::read_matrix;
use fe_mesh::ElementKind;
use iga_core::files::{write_gismo, write_mfem};
use iga_core::knots::KnotVector;
use iga_core::nurbs::Patch;

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
#[ignore = "a part of the other test"]
fn child_reads_a_file() {
    let Ok(given) = std::env::var(FILE) else { return };
    let (kind, path) = given.split_once(' ').unwrap();
    let bytes = std::fs::read(path).unwrap();
    let text = || std::str::from_utf8(&bytes).unwrap();
    let before = status("VmRSS");
    match kind {
        "mesh" => assert!(fe_mesh::read::read(&bytes, 1e-3).is_ok()),
        "splines" => assert!(iga_core::files::read(&bytes, 1e-3).is_ok()),
        _ => assert!(read_matrix(text(), None).is_ok()),
    }
    println!("{TAKEN}{}", status("VmHWM").saturating_sub(before));
}

/// A block of splines with `n` elements a direction, a patch.
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
    // The bound of the project.
    assert!(over.is_empty(), "{over:?}");
}
