//! Scenarios from texts, and what their runs record.

use std::path::{Path, PathBuf};

use adaptive::run::recording::Recording;
use fbimpact::scenario::{self, Fault, Scenario};
use fbimpact::simulate::{simulate, system_modes};

/// A folder of that name for files of a test.
pub fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::create_dir_all(&folder).expect("made");
    folder
}

/// The scenario `text` as if it stood in `folder`, with the changes `set`, or its faults.
pub fn parse(folder: &Path, text: &str, set: &[&str]) -> Result<Scenario, Vec<Fault>> {
    let overrides: Vec<_> = set.iter().map(|s| s.parse().expect("a change")).collect();
    scenario::parse(&folder.join("case.toml"), text.as_bytes(), &overrides).map_err(|f| f.list().to_vec())
}

/// The same without faults.
pub fn valid(folder: &Path, text: &str, set: &[&str]) -> Scenario {
    parse(folder, text, set).unwrap_or_else(|faults| panic!("{set:?}: {faults:#?}"))
}

/// What a run of `scenario` records.
pub fn run(scenario: &Scenario) -> Recording {
    run_on(scenario, 1)
}

/// What a run of the scenario `text`, which names no files, records.
pub fn run_text(text: &str) -> Recording {
    run(&valid(Path::new("."), text, &[]))
}

/// The faults of such a scenario, a line each: key and message.
pub fn faults(text: &str) -> String {
    let list = parse(Path::new("."), text, &[]).expect_err("a fault");
    list.iter().map(|fault| format!("{}: {}\n", fault.key, fault.message)).collect()
}

/// What a run of `scenario` on so many threads records.
pub fn run_on(scenario: &Scenario, threads: usize) -> Recording {
    let mut recording = Recording::default();
    simulate(scenario, &mut recording, threads).unwrap_or_else(|e| panic!("{e}"));
    recording
}

/// Why `scenario` is not simulated to its end.
pub fn refusal(scenario: &Scenario) -> String {
    simulate(scenario, &mut Recording::default(), 1).expect_err("refused").to_string()
}

/// Frequencies of the system \[Hz\].
pub fn system_frequencies(scenario: &Scenario) -> Vec<f64> {
    let (_, system) = system_modes(scenario, false, 1).unwrap_or_else(|e| panic!("{e}"));
    system.modes.iter().map(|mode| mode.frequency()).collect()
}
