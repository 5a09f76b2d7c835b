//! Scenarios run in memory, reference tables, and comparisons of histories.

use std::ops::Deref;
use std::path::{Path, PathBuf};

use adaptive::model::RunModel;
use adaptive::record::{ImpactRecord, Sample};
use adaptive::run::recording::Recording;
use fbimpact::commands::scenario_file;
use fbimpact::scenario::{self, Scenario};
use fbimpact::simulate::simulate;

/// Everything a run reports, kept in memory.
#[derive(Debug)]
pub struct Trace {
    recording: Recording,
    /// Why the run ended early, if it did.
    pub failure: Option<String>,
}

impl Deref for Trace {
    type Target = Recording;

    fn deref(&self) -> &Recording {
        &self.recording
    }
}

impl Trace {
    /// Times of the stored states \[s\].
    pub fn times(&self) -> Vec<f64> {
        self.samples.iter().map(|s| s.time).collect()
    }

    /// A number of every stored state.
    pub fn history(&self, f: impl Fn(&Sample) -> f64) -> Vec<f64> {
        self.samples.iter().map(f).collect()
    }

    /// Normal force of the first contact in every stored state \[N\].
    pub fn force(&self) -> Vec<f64> {
        self.history(|s| s.contacts[0].normal_force)
    }

    /// The only impact.
    pub fn impact(&self) -> &ImpactRecord {
        assert_eq!(self.impacts.len(), 1, "one impact in {:?}, failure: {:?}", self.impacts, self.failure);
        &self.impacts[0]
    }

    /// Largest distance between the force of this run and another one, as a share of the other one's peak.
    pub fn force_difference(&self, other: &Self) -> f64 {
        let (times, force) = (self.times(), self.force());
        let there = other.times().into_iter().zip(other.force());
        let largest = there.map(|(t, f)| (interpolate(&times, &force, t) - f).abs()).fold(0.0, f64::max);
        largest / other.impact().peak_force
    }

    /// Mean forces of consecutive intervals of length `window` up to `end` \[N\].
    pub fn mean_forces(&self, window: f64, end: f64) -> Vec<f64> {
        let (times, force) = (self.times(), self.force());
        let mut impulse = vec![0.0];
        for i in 1..times.len() {
            impulse.push(impulse[i - 1] + 0.5 * (times[i] - times[i - 1]) * (force[i] + force[i - 1]));
        }
        let at = |i: usize| interpolate(&times, &impulse, i as f64 * window);
        (0..(end / window) as usize).map(|i| (at(i + 1) - at(i)) / window).collect()
    }
}

/// The shipped scenario `name` with changes.
pub fn shipped(name: &str, set: &[&str]) -> Scenario {
    let path = root().join("scenarios").join(name).with_extension("toml");
    let set: Vec<_> = set.iter().map(|s| s.parse().expect("valid --set")).collect();
    scenario_file::read(&path, &set).unwrap_or_else(|e| panic!("{e}"))
}

/// The shipped scenario `name` without the keys of mesh and modes, which the program then chooses, with changes.
pub fn without_sizes(name: &str, set: &[&str]) -> Scenario {
    let path = root().join("scenarios").join(name).with_extension("toml");
    let text = std::fs::read_to_string(&path).expect("a scenario");
    let is_kept = |line: &&str| !["discretisation", "reduction"].iter().any(|key| line.starts_with(key));
    let text: Vec<&str> = text.lines().filter(is_kept).collect();
    let set: Vec<_> = set.iter().map(|s| s.parse().expect("valid --set")).collect();
    scenario::parse(&path, text.join("\n").as_bytes(), &set).unwrap_or_else(|e| panic!("{e}"))
}

/// A scenario from its text.
pub fn parsed(text: &str) -> Scenario {
    scenario::parse(Path::new("test.toml"), text.as_bytes(), &[]).unwrap_or_else(|e| panic!("{e}"))
}

/// All models of a scenario.
pub fn built(scenario: &Scenario) -> RunModel {
    RunModel::build(&scenario.run).unwrap_or_else(|e| panic!("{e}"))
}

/// Runs a shipped scenario with changes on one thread.
pub fn run(name: &str, set: &[&str]) -> Trace {
    run_on(1, name, set)
}

/// Runs a shipped scenario with changes on `threads` threads.
pub fn run_on(threads: usize, name: &str, set: &[&str]) -> Trace {
    record(Recording::default(), threads, name, set)
}

/// Runs a shipped scenario with changes, reporting to `recording`.
pub fn record(recording: Recording, threads: usize, name: &str, set: &[&str]) -> Trace {
    recorded(recording, threads, &shipped(name, set))
}

/// Runs a scenario on one thread.
pub fn run_scenario(scenario: &Scenario) -> Trace {
    recorded(Recording::default(), 1, scenario)
}

fn recorded(mut recording: Recording, threads: usize, scenario: &Scenario) -> Trace {
    let end = simulate(scenario, &mut recording, threads);
    Trace { recording, failure: end.err().map(|e| e.to_string()) }
}

/// Columns of `tests/reference/<name>.csv` by name.
pub struct Table {
    names: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl Table {
    /// Reads a table.
    pub fn read(name: &str) -> Self {
        let path = root().join("tests/reference").join(name).with_extension("csv");
        let text = std::fs::read_to_string(&path).expect("reference table");
        let mut lines = text.lines().filter(|l| !l.starts_with('#'));
        let fields = |line: &str| line.split(',').map(str::to_owned).collect::<Vec<_>>();
        let names = fields(lines.next().expect("column names"));
        Self { names, rows: lines.map(fields).collect() }
    }

    /// A column as text.
    pub fn text(&self, name: &str) -> Vec<&str> {
        let column = self.names.iter().position(|n| n == name).expect("column");
        self.rows.iter().map(|r| r[column].as_str()).collect()
    }

    /// A column of numbers.
    pub fn column(&self, name: &str) -> Vec<f64> {
        self.text(name).iter().map(|x| x.parse().expect("number")).collect()
    }
}

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

/// Linear interpolation of `y(x)` at `at`; the end values outside.
pub fn interpolate(x: &[f64], y: &[f64], at: f64) -> f64 {
    let i = x.partition_point(|&v| v <= at);
    if i == 0 || i == x.len() {
        return y[i.saturating_sub(1)];
    }
    let s = (at - x[i - 1]) / (x[i] - x[i - 1]);
    y[i - 1] + s * (y[i] - y[i - 1])
}

/// Largest distance between a history and a reference at the reference's times up to the history's end, as a share of the
/// reference's largest absolute value.
pub fn deviation(times: &[f64], values: &[f64], reference_times: &[f64], reference: &[f64]) -> f64 {
    let end = times[times.len() - 1];
    let peak = reference.iter().fold(0.0f64, |m, v| m.max(v.abs()));
    let pairs = reference_times.iter().zip(reference).filter(|(t, _)| **t <= end);
    pairs.map(|(&t, v)| (interpolate(times, values, t) - v).abs()).fold(0.0, f64::max) / peak
}

/// Asserts that `value` lies within `tolerance` (relative) of `expected`, and prints the figure for docs/verification.md.
#[track_caller]
pub fn assert_close(what: &str, value: f64, expected: f64, tolerance: f64) {
    let error = value / expected - 1.0;
    println!("{what}: {value:.8e}, expected {expected:.8e}, {:.2e} off", error);
    assert!(
        error.abs() <= tolerance,
        "{what}: {value:e} is {error:e} off {expected:e}, allowed {tolerance:e}"
    );
}

/// Asserts that `value` is at most `limit`, and prints the figure for docs/verification.md.
#[track_caller]
pub fn assert_below(what: &str, value: f64, limit: f64) {
    println!("{what}: {value:.3e}, limit {limit:.1e}");
    // Asked this way round, a NaN fails.
    assert!(value <= limit, "{what}: {value:e} exceeds {limit:e}");
}

/// Scenario with a free steel cylinder, radius 10 mm, length 20 mm, of `elements` cubic elements per direction.
pub fn steel_cylinder(elements: usize, modes: usize) -> String {
    format!(
        r#"
        simulation = {{ end_time = 1.0 }}
        materials.steel = {{ youngs_modulus = 210.0e9, poissons_ratio = 0.3, density = 7850.0 }}
        [bodies.cylinder]
        material = "steel"
        geometry = {{ shape = "cylinder", radius = 10.0e-3, length = 20.0e-3 }}
        discretisation = {{ degree = 3, elements = {elements} }}
        reduction = {{ method = "modal", modes = {modes} }}
        "#
    )
}

/// The first ten frequencies of that cylinder by a Ritz method with polynomials \[Hz\]; doubles for circumferential orders 1, 2.
pub fn cylinder_frequencies() -> Vec<f64> {
    let table = Table::read("cylinder_ritz");
    let count = table.column("multiplicity");
    let pairs = table.column("frequency").into_iter().zip(count);
    pairs.flat_map(|(f, n)| std::iter::repeat_n(f, n as usize)).take(10).collect()
}
