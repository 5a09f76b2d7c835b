//! Random and damaged input of every kind: it is read or refused, and nothing panics. `fuzz/` runs the same functions under a fuzzer.

mod bodies;

use crate::beam_file;
use std::path::Path;
use std::process::Command;
use std::sync::LazyLock;

use crate::support::damage::{cases, mutated};

fn result(scenario: &str, end_time: &str) -> Vec<u8> {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("ok.h5");
    let scenario = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios").join(scenario);
    let mut command = Command::new(env!("CARGO_BIN_EXE_fbimpact"));
    command.args(["run", "-q", "--set", &format!("simulation.end_time={end_time}"), "-o"]);
    assert!(command.arg(&path).arg(scenario).status().expect("the program starts").success());
    std::fs::read(path).expect("readable")
}

/// A result with joints, and one with contact pressures.
static RESULTS: LazyLock<[Vec<u8>; 2]> =
    LazyLock::new(|| [result("rigid_double_pendulums.toml", "0.2"), result("sphere_on_plane.toml", "3e-5")]);

static BEAM: LazyLock<Vec<u8>> = LazyLock::new(|| {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("beam.h5");
    beam_file::write_beam(&path);
    std::fs::read(path).expect("readable")
});

/// Letters of the formats.
const LETTERS: &[u8] = b"0123456789-.e[]{}=\"\n#";

#[test]
fn scenario_of_any_bytes_is_valid_or_has_faults() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios");
    let files = std::fs::read_dir(folder)
        .expect("readable")
        .map(|e| e.expect("readable").path())
        .filter(|p| p.is_file());
    let texts: Vec<Vec<u8>> = files.map(|p| std::fs::read(p).expect("readable")).collect();
    cases(600, |bytes| {
        bodies::scenario_text(bytes);
        let which = usize::from(bytes.first().copied().unwrap_or(0)) % texts.len();
        bodies::scenario_text(&mutated(&texts[which], bytes, LETTERS));
    });
}

#[test]
fn nurbs_of_any_numbers_is_built_or_refused() {
    cases(300, bodies::nurbs_data);
}

#[test]
fn damaged_matrices_are_read_or_refused() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/matrix_parts");
    let short = |name: &str, n: usize| {
        let text = std::fs::read_to_string(folder.join(name)).expect("readable");
        text.lines().take(n).map(|l| format!("{l}\n")).collect::<String>().into_bytes()
    };
    let rows = short("bar.sti", 40);
    let market =
        [b"%%MatrixMarket matrix coordinate real symmetric\n9 9 2\n".to_vec(), short("bar.sti", 2)].concat();
    let punch = b"DMIG    KAAX           0       6       2       0\n\
        DMIG*   KAAX                           1               1\n\
        *                      1               1 2.500000000D+02\n\
        DMIG    KAAX    1       1               1       1       -1.25+2\n"
        .to_vec();
    let pairs = b"1,1, 1,1, 2.5\n7,3, 1,1, -1.\n".to_vec();
    let (map, nodes) = (short("bar.dof", 60), short("bar.inp", 30));
    cases(300, |bytes| {
        bodies::matrix_reading(bytes);
        for text in [&rows, &market, &punch, &pairs, &map, &nodes] {
            bodies::matrices(&mutated(text, bytes, LETTERS), (&rows, &map, &nodes));
        }
    });
}

#[test]
fn damaged_body_file_is_read_or_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    cases(80, |bytes| {
        bodies::body_import(bytes, folder.path());
        let path = folder.path().join("damaged.h5");
        std::fs::write(&path, &*BEAM).expect("written");
        bodies::damage(&path, bytes);
        bodies::body_import(&std::fs::read(&path).expect("readable"), folder.path());
    });
}

#[test]
fn damaged_result_is_read_or_refused_by_every_reader() {
    let folder = tempfile::tempdir().expect("a folder");
    cases(8, |bytes| {
        bodies::result_reading(bytes, folder.path());
        let path = folder.path().join("damaged.h5");
        for result in &*RESULTS {
            std::fs::write(&path, result).expect("written");
            bodies::damage(&path, bytes);
            bodies::read_everything(&path, folder.path());
        }
    });
}
