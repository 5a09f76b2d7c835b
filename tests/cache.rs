//! Models kept between runs, with the program run as a user would: same results, damaged files, two runs at once, limits.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use tempfile::TempDir;

/// A scenario with fine models, whose cache holds modes and compliances, and one that takes no time.
const ADAPTIVE: &str = "sphere_rod_sphere";
const QUICK: &str = "sphere_on_plane";

struct Place {
    directory: TempDir,
}

impl Place {
    fn new() -> Self {
        Self { directory: tempfile::tempdir().expect("a temporary directory") }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.directory.path().join(name)
    }

    fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_fbimpact"));
        command.args(arguments).current_dir(self.directory.path()).env_remove("FBIMPACT_CACHE");
        command.env("XDG_CACHE_HOME", self.path("home")).env("HOME", self.path("home"));
        command
    }

    fn call(&self, arguments: &[&str]) -> (i32, String) {
        finished(&mut self.command(arguments))
    }

    /// Runs a scenario with the models in `models`; returns the log.
    fn run(&self, scenario: &str, output: &str, more: &[&str]) -> String {
        let (code, log) = self.call(&[&["run", &path_of(scenario), "-o", output], more].concat());
        assert_eq!(code, 0, "{log}");
        log
    }

    /// Whether two results agree to the last bit.
    fn agree(&self, a: &str, b: &str) {
        let (code, table) = self.call(&["compare", a, b, "--rtol", "0", "--atol", "0"]);
        assert_eq!(code, 0, "{table}");
    }

    fn models(&self) -> Vec<PathBuf> {
        let files = fs::read_dir(self.path("models")).expect("a folder").map(|f| f.expect("a file").path());
        let mut models: Vec<PathBuf> =
            files.filter(|f| f.extension().is_some_and(|e| e == "model")).collect();
        models.sort();
        models
    }
}

const MODELS: [&str; 2] = ["--cache-dir", "models"];

fn path_of(scenario: &str) -> String {
    format!("{}/scenarios/{scenario}.toml", env!("CARGO_MANIFEST_DIR"))
}

fn finished(command: &mut Command) -> (i32, String) {
    let output = command.output().expect("the program starts");
    let text = String::from_utf8([output.stdout, output.stderr].concat()).expect("UTF-8");
    (output.status.code().expect("no signal"), text)
}

fn change(path: &Path, place: usize) {
    let mut bytes = fs::read(path).expect("readable");
    let place = place % bytes.len();
    bytes[place] ^= 0x10;
    fs::write(path, bytes).expect("writable");
}

#[test]
fn a_run_with_kept_models_gives_the_same_file_as_one_without() {
    let place = Place::new();
    let log = place.run(ADAPTIVE, "none.h5", &["--no-cache"]);
    assert!(!log.contains("from the cache"), "{log}");
    assert!(!place.path("home").exists() && !place.path("models").exists());
    let log = place.run(ADAPTIVE, "cold.h5", &MODELS);
    // Three bodies of two kinds, both with their modes; two impacts with two fine models each.
    assert!(log.contains("models: 0 from the cache, 6 built"), "{log}");
    let log = place.run(ADAPTIVE, "warm.h5", &MODELS);
    assert!(log.contains("models: 6 from the cache, 0 built"), "{log}");
    place.agree("none.h5", "cold.h5");
    place.agree("none.h5", "warm.h5");
    let (_, info) = place.call(&["info", "warm.h5"]);
    assert!(info.contains("cache"), "{info}");
    // Pictures are made with the modes of the run.
    let (code, log) = place
        .call(&[&["export", "warm.h5", "--vtk", "pictures", "--times", "0:0:1", "-v"], &MODELS[..]].concat());
    assert!(code == 0 && log.contains("model found"), "{log}");
}

#[test]
fn a_damaged_model_is_built_anew_with_a_warning_and_mended() {
    let place = Place::new();
    place.run(QUICK, "cold.h5", &MODELS);
    let [model] = &place.models()[..] else { panic!("one model") };
    let good = fs::read(model).expect("readable");
    // Magic number, name, sizes, counts, values, checksum.
    for byte in [0, 7, 8, 40, 48, 56, 64, 1000, good.len() - 1] {
        change(model, byte);
        let log = place.run(QUICK, "new.h5", &MODELS);
        assert!(log.contains("the model is built anew") && log.contains("0 from the cache"), "{byte}: {log}");
        place.agree("cold.h5", "new.h5");
        assert!(fs::read(model).expect("readable") == good, "byte {byte}");
    }
    for length in [0, 10, 80, good.len() - 1] {
        fs::write(model, &good[..length]).expect("writable");
        let log = place.run(QUICK, "new.h5", &MODELS);
        assert!(log.contains("the model is built anew"), "{length}: {log}");
        place.agree("cold.h5", "new.h5");
    }
}

#[test]
fn runs_at_once_share_a_folder() {
    let place = Place::new();
    let start = |output: &str| {
        let scenario = path_of(QUICK);
        let arguments = [&["run", &scenario, "-o", output][..], &MODELS].concat();
        let mut command = place.command(&arguments);
        command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().expect("the program starts")
    };
    let outputs: Vec<String> = (0..4).map(|i| format!("{i}.h5")).collect();
    let runs: Vec<_> = outputs.iter().map(|output| start(output)).collect();
    for run in runs {
        let output = run.wait_with_output().expect("it ends");
        let log = String::from_utf8(output.stderr).expect("UTF-8");
        assert!(output.status.success() && !log.contains("WARN"), "{log}");
    }
    outputs.iter().for_each(|output| place.agree("0.h5", output));
    assert_eq!(place.models().len(), 1);
    let log = place.run(QUICK, "warm.h5", &MODELS);
    assert!(log.contains("models: 1 from the cache"), "{log}");
    place.agree("0.h5", "warm.h5");
}

#[test]
fn other_definitions_have_other_models() {
    let place = Place::new();
    place.run(QUICK, "a.h5", &MODELS);
    let more = ["--set", "bodies.ball.reduction.modes=9"];
    for set in [more, ["--set", "materials.aluminium.density=2789.0000000000005"]] {
        let log = place.run(QUICK, "b.h5", &[&MODELS[..], &set].concat());
        assert!(log.contains("models: 0 from the cache, 1 built"), "{log}");
    }
    let log = place.run(QUICK, "b.h5", &[&MODELS[..], &["--set", "simulation.end_time=1e-5"]].concat());
    assert!(log.contains("models: 1 from the cache, 0 built"), "{log}");
}

#[test]
fn the_environment_names_the_folder_or_switches_it_off() {
    let place = Place::new();
    let run = |variable: Option<&str>| {
        let mut command = place.command(&["run", &path_of(QUICK), "-o", "a.h5"]);
        variable.iter().for_each(|value| {
            command.env("FBIMPACT_CACHE", value);
        });
        let (code, log) = finished(&mut command);
        assert_eq!(code, 0, "{log}");
        log
    };
    assert!(!run(Some("off")).contains("models:"));
    assert!(!place.path("home").exists() && !place.path("off").exists());
    run(Some("models"));
    assert_eq!(place.models().len(), 1);
    assert!(!place.path("home").exists());
    run(None);
    #[cfg(target_os = "linux")]
    assert!(place.path("home/fbimpact/CACHEDIR.TAG").exists());
}

#[test]
fn a_folder_that_cannot_be_written_costs_one_warning() {
    let place = Place::new();
    fs::write(place.path("models"), "a file").expect("writable");
    let log = place.run(ADAPTIVE, "a.h5", &MODELS);
    assert_eq!(log.matches("models cannot be kept in models").count(), 1, "{log}");
}

#[test]
fn the_folder_keeps_to_its_limit() {
    let place = Place::new();
    place.run(QUICK, "a.h5", &[&MODELS[..], &["--cache-limit", "0"]].concat());
    assert!(!place.path("models").exists());
    let limit = ["--cache-limit", "0.0001"]; // 105 KiB
    place.run(ADAPTIVE, "a.h5", &[&MODELS[..], &limit].concat());
    let size: u64 = place.models().iter().map(|m| fs::metadata(m).expect("there").len()).sum();
    assert!(size > 0 && size <= 107_374, "{size}");
}

#[test]
fn cache_shows_and_clears_the_folder() {
    let place = Place::new();
    assert_eq!(
        place.call(&["cache", "info", "--cache-dir", "models"]),
        (0, "models\n0 models, 0.0 MiB\n".into())
    );
    place.run(QUICK, "a.h5", &MODELS);
    fs::write(place.path("models/notes.txt"), "mine").expect("writable");
    let (code, text) = place.call(&["cache", "info", "--cache-dir", "models"]);
    assert!(code == 0 && text.starts_with("models\n1 model, "), "{text}");
    let (code, text) = place.call(&["cache", "clear", "--cache-dir", "models"]);
    assert!(code == 0 && text.ends_with("removed\n"), "{text}");
    assert!(place.models().is_empty() && place.path("models/notes.txt").exists());
    assert_eq!(place.call(&["cache", "fly"]).0, 2);
    assert_eq!(place.call(&["run", "a.toml", "--no-cache", "--cache-dir", "models"]).0, 2);
    assert_eq!(place.call(&["run", "a.toml", "--cache-limit", "-1"]).0, 2);
}
