//! Every short scenario still gives the result it gave: a rerun agrees with its trace in tests/reference/traces.

use std::path::Path;

use assert_cmd::Command;

fn fbimpact(arguments: &[&str]) -> (i32, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_fbimpact"));
    let output = command.args(arguments).output().expect("the program starts");
    let text = [output.stdout, output.stderr].concat();
    (output.status.code().expect("no signal"), String::from_utf8(text).expect("UTF-8"))
}

fn rerun_agrees(name: &str) {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let trace = root.join(format!("tests/reference/traces/{name}.h5"));
    let size = std::fs::metadata(&trace).expect("there is a trace").len();
    assert!(size < 200_000, "{size} bytes are too many for a trace");
    let directory = tempfile::tempdir().expect("a temporary directory");
    let new = directory.path().join("new.h5");
    let scenario = root.join(format!("scenarios/{name}.toml"));
    let text = |path: &Path| path.to_str().expect("UTF-8").to_owned();
    // Ten modes of the disc cut through a pair of equal frequencies: which one of the pair is taken is up to rounding, so that the
    // result moves between processors. Its trace has eleven. Velocities at the end of the rod jump where points let go: steps of other
    // ends sample them elsewhere, so that the trace of sphere, rod and sphere has the steps that it was made with.
    let sets = std::fs::read_to_string(trace.with_extension("set")).unwrap_or_default();
    let sets: Vec<&str> = sets.lines().flat_map(|line| ["--set", line]).collect();
    let (code, log) = fbimpact(&[&["run", &text(&scenario), "-q", "-o", &text(&new)], &sets[..]].concat());
    assert_eq!(code, 0, "{log}");
    let (code, table) = fbimpact(&["compare", &text(&new), &text(&trace)]);
    assert_eq!(code, 0, "{table}");
}

macro_rules! traces {
    ($($name:ident)*) => {
        $(#[test] fn $name() { rerun_agrees(stringify!($name)); })*

        #[test]
        fn every_trace_has_its_test() {
            let directory = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/reference/traces");
            let files = std::fs::read_dir(directory).expect("readable").map(|e| e.expect("readable").file_name());
            let name = |f: std::ffi::OsString| f.to_string_lossy().strip_suffix(".h5").map(str::to_owned);
            let mut names: Vec<String> = files.filter_map(name).collect();
            names.sort();
            assert_eq!(names, [$(stringify!($name)),*]);
        }
    };
}

// In the order of names; cylinder_modes is a speed benchmark without motion.
traces! {
    flexible_pendulum
    rigid_double_pendulums
    rod_on_plane
    rotating_disc
    sphere_on_plane
    sphere_rod_sphere
    spinning_beam
}
