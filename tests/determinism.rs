//! The built program run again, on one thread, on two, and with kept models: the same files in every bit, apart from times.

use std::fs;
use std::path::Path;
use std::process::Command;

use hdf5::types::{TypeDescriptor, VarLenUnicode};
use result_files::tables::{EventRow, ImpactRow, PhaseRow, TransferRow, TrialRow};
use tempfile::TempDir;

/// Solid balls aslant with spin and friction: fine models of both, the search for the penalty factor, a pair with sticking and
/// sliding points, over the first part of the impact. Soft balls have a wide contact and small models.
const BALLS: &str = r#"
[simulation]
end_time = 1.2e-5

[materials.plastic]
youngs_modulus = 2.1e9
poissons_ratio = 0.4
density = 1140.0

[bodies.upper]
material = "plastic"
geometry = { shape = "sphere", radius = 5.0e-3 }
discretisation = { degree = 2, elements = [4, 2, 2] }
reduction = { method = "craig-bampton", modes = 3 }
position = [0.0, 0.0, 5.00001e-3]
velocity = [0.5, 0.0, -2.0]
angular_velocity = [0.0, 5.0, 3.0]

[bodies.lower]
material = "plastic"
geometry = { shape = "sphere", radius = 5.0e-3 }
discretisation = { degree = 2, elements = [4, 2, 2] }
reduction = { method = "craig-bampton", modes = 3 }
position = [0.0, 0.0, -5.0e-3]

[contacts.impact]
contact_body = "upper"
target_body = "lower"
model = "adaptive"
friction = 0.3
interval = { elements = 4 }
"#;

/// Every dataset of a result with its contents, one per line, floating-point numbers by their bits; times of the machine left out.
fn contents(path: &Path) -> Vec<String> {
    let file = result_files::file::hdf5_integrity::open(path).expect("readable");
    let mut lines = Vec::new();
    collect(&file, &mut lines);
    lines.sort();
    lines
}

fn collect(group: &hdf5::Group, lines: &mut Vec<String>) {
    for dataset in group.datasets().expect("readable") {
        let name = dataset.name();
        if !name.starts_with("/timings/") {
            lines.push(format!("{name} {:?} {}", dataset.shape(), values(&name, &dataset)));
        }
    }
    group.groups().expect("readable").iter().for_each(|child| collect(child, lines));
}

fn values(name: &str, dataset: &hdf5::Dataset) -> String {
    match name {
        "/phases" => {
            let mut rows: Vec<PhaseRow> = dataset.read_raw().expect("rows");
            rows.iter_mut().for_each(|row| row.wall_time = 0.0);
            exactly(&rows)
        }
        "/tries" => {
            let mut rows: Vec<TrialRow> = dataset.read_raw().expect("rows");
            rows.iter_mut().for_each(|row| (row.wall_time, row.cpu_time) = (0.0, 0.0));
            exactly(&rows)
        }
        "/impacts" => exactly(&dataset.read_raw::<ImpactRow>().expect("rows")),
        "/events" => exactly(&dataset.read_raw::<EventRow>().expect("rows")),
        "/transfers" => exactly(&dataset.read_raw::<TransferRow>().expect("rows")),
        _ => match dataset.dtype().and_then(|t| t.to_descriptor()).expect("a type") {
            TypeDescriptor::Float(_) => {
                let numbers = dataset.read_raw::<f64>().expect("numbers");
                format!("{:x?}", numbers.iter().map(|x| x.to_bits()).collect::<Vec<_>>())
            }
            TypeDescriptor::Integer(_) | TypeDescriptor::Unsigned(_) => {
                exactly(&dataset.read_raw::<i64>().expect("numbers"))
            }
            TypeDescriptor::VarLenUnicode => exactly(&dataset.read_raw::<VarLenUnicode>().expect("text")),
            other => panic!("{name} is of a type that this test does not read: {other}"),
        },
    }
}

/// Digits of this form are those of every bit.
fn exactly<T: std::fmt::Debug>(rows: &[T]) -> String {
    format!("{rows:?}")
}

struct Runs {
    directory: TempDir,
}

impl Runs {
    /// Runs the scenario, returns the log.
    fn run(&self, name: &str, options: &[&str]) -> String {
        let mut command = Command::new(env!("CARGO_BIN_EXE_fbimpact"));
        command
            .current_dir(self.directory.path())
            .env_remove("FBIMPACT_CACHE")
            .env_remove("RAYON_NUM_THREADS");
        command.args(["run", "balls.toml", "-o", name]).args(options);
        let output = command.output().expect("the program starts");
        let log = String::from_utf8(output.stderr).expect("UTF-8");
        assert!(output.status.success(), "{name}: {log}");
        log
    }

    fn contents(&self, name: &str) -> Vec<String> {
        contents(&self.directory.path().join(name))
    }

    fn assert_same(&self, name: &str) {
        let (first, other) = (self.contents("first.h5"), self.contents(name));
        for (a, b) in first.iter().zip(&other) {
            assert!(a == b, "{name}: {}", a.split(' ').next().unwrap_or_default());
        }
        assert_eq!(first.len(), other.len(), "{name}");
        let mut command = Command::new(env!("CARGO_BIN_EXE_fbimpact"));
        command.current_dir(self.directory.path());
        command.args(["compare", name, "first.h5", "--rtol", "0", "--atol", "0"]);
        let output = command.output().expect("the program starts");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stdout));
    }
}

#[test]
fn solid_balls_give_the_same_file_again_on_any_threads_and_with_kept_models() {
    let runs = Runs { directory: tempfile::tempdir().expect("a temporary directory") };
    fs::write(runs.directory.path().join("balls.toml"), BALLS).expect("writable");
    let kept = ["--cache-dir", "models"];
    runs.run("first.h5", &kept);
    let first = runs.contents("first.h5");
    // All kinds of datasets were read, and there was something to compare.
    for name in ["/time", "/tries", "/phases", "/bodies/upper/elastic_coordinates", "/contacts/impact/force"]
    {
        assert!(first.iter().any(|line| line.starts_with(&format!("{name} "))), "{name}");
    }
    let file =
        result_files::file::hdf5_integrity::open(&runs.directory.path().join("first.h5")).expect("readable");
    let sliding: Vec<f64> =
        file.dataset("contacts/impact/sliding_points").and_then(|d| d.read_raw()).expect("numbers");
    assert!(sliding.iter().any(|n| *n > 0.0));
    runs.run("one.h5", &["--no-cache", "--threads", "1"]);
    runs.assert_same("one.h5");
    let log = runs.run("kept.h5", &kept);
    assert!(log.contains("from the cache, 0 built"), "{log}");
    runs.assert_same("kept.h5");
}
