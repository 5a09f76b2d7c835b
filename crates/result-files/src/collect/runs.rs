//! Which runs there are, and what is left of each.
//!
//! A sweep leaves next to `<run>.h5` the files `<run>.exit` (exit code), `<run>.set` (one
//! `KEY=VALUE` a line) and `<run>.log`, so that runs without a result are rows, too.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use super::format::HDF5_TABLE;
use crate::error::ResultError;
use crate::expression::fault::ExpressionFault;
use crate::expression::named::{Cell, NamedExpression};
use crate::expression::source::Source;
use crate::file::fault::Access;
use crate::file::plain_file;
use crate::stored::Stored;
use crate::stored::open;
use crate::stored::peak::Peak;
use crate::stored::scenario_values::{self, Values};
use crate::stored::summary;
use crate::stored::warnings;
use crate::tables::ImpactRow;

/// What is left of a run.
#[derive(Debug, Clone, Default)]
pub struct Run {
    /// Path of the result without `.h5`.
    pub name: String,
    /// Its result, or what is left of it.
    pub file: PathBuf,
    /// `complete`, `interrupted`, `failed`, `running` (killed or still going on), `unreadable` or
    /// `missing` (nothing known).
    pub status: String,
    /// Why, if the run is not complete.
    pub message: String,
    /// Exit code, if it was recorded.
    pub exit_code: Option<i32>,
    /// Values of the scenario; of runs without a result only what was set.
    pub values: Values,
    /// SHA-256 of the scenario file, and of all that the result follows from.
    pub hashes: [String; 2],
    /// Version and commit of the program.
    pub program: String,
    /// Last stored time \[s\].
    pub end_time: Option<f64>,
    /// Stored instants.
    pub n_samples: Option<usize>,
    /// Relative energy drift.
    pub energy_drift: Option<f64>,
    /// Identifiers of its warnings; `None` without a result.
    pub warnings: Option<Vec<String>>,
    /// Seconds in all phases.
    pub wall_time: Option<f64>,
    /// Impacts.
    pub impacts: Vec<ImpactRow>,
    /// Largest reactions of joints, displacements and stresses of points.
    pub peaks: Vec<Peak>,
    /// Extremes of points, final energies and values of expressions.
    pub cells: Vec<Cell>,
    /// Expressions that have no value in its result: the name of the column, and why.
    pub valueless: Vec<(String, ExpressionFault)>,
}

/// Runs in files and directories, in a directory in the order of its sweep or of names, with the
/// values of the expressions `wanted`.
///
/// # Errors
/// [`ResultError::File`] if a directory cannot be read, or if a place is neither a directory nor the name of a run or of a file.
pub fn find(places: &[PathBuf], wanted: &[NamedExpression]) -> Result<Vec<Run>, ResultError> {
    let mut stems = Vec::new();
    for place in places {
        if place.is_dir() {
            stems.extend(in_directory(place)?);
        } else {
            let stem = stem(place);
            // A file that a run was to write may be missing; a name without ending is that of a
            // folder or of traces of a run.
            let has_traces =
                [".h5", ".h5.part", ".exit", ".set", ".log"].iter().any(|end| with_end(&stem, end).exists());
            if stem == *place && !place.exists() && !has_traces {
                let reason = "does not exist: name a folder of results, a result (.h5), or a run by its path without .h5";
                return Err(ResultError::io(place, reason));
            }
            stems.push(stem);
        }
    }
    Ok(stems.iter().map(|stem| read(stem, wanted)).collect())
}

/// `a/b.h5`, `a/b.h5.part`, `a/b.exit` and `a/b.set` are all of the run `a/b`; other files are no
/// runs.
fn known_stem(path: &Path) -> Option<PathBuf> {
    let name = path.file_name()?.to_str()?;
    let stem = [".h5", ".h5.part", ".exit", ".set"].iter().find_map(|end| name.strip_suffix(end))?;
    (!stem.is_empty()).then(|| path.with_file_name(stem))
}

fn stem(path: &Path) -> PathBuf {
    known_stem(path).unwrap_or_else(|| path.to_owned())
}

/// Runs of a folder: those of its plan, if it is that of a sweep, in the order of their values,
/// then all others in the order of their names.
fn in_directory(directory: &Path) -> Result<Vec<PathBuf>, ResultError> {
    let mut found = found_in(directory)?;
    let plan = plain_file::text(&directory.join("plan")).unwrap_or_default();
    let planned = plan.lines().map(|name| directory.join(name));
    let mut runs: Vec<PathBuf> = planned.filter(|run| found.remove(run)).collect();
    runs.extend(found);
    Ok(runs)
}

fn found_in(directory: &Path) -> Result<BTreeSet<PathBuf>, ResultError> {
    let fail = |e: std::io::Error| ResultError::system(directory, Access::Read, e);
    let mut stems = BTreeSet::new();
    for entry in std::fs::read_dir(directory).map_err(fail)? {
        let path = entry.map_err(fail)?.path();
        stems.extend(known_stem(&path).filter(|_| path.is_file() && !HDF5_TABLE.is_own(&path)));
    }
    Ok(stems)
}

fn with_end(stem: &Path, end: &str) -> PathBuf {
    let mut name = stem.as_os_str().to_owned();
    name.push(end);
    PathBuf::from(name)
}

fn read(stem: &Path, wanted: &[NamedExpression]) -> Run {
    let (result, part) = (with_end(stem, ".h5"), with_end(stem, ".h5.part"));
    let file = if !result.exists() && part.exists() { part } else { result };
    let exit = plain_file::text(&with_end(stem, ".exit")).unwrap_or_default();
    let mut run = Run {
        name: stem.display().to_string(),
        file: file.clone(),
        exit_code: exit.trim().parse().ok(),
        ..Run::default()
    };
    if !file.exists() {
        let is_failed = run.exit_code.is_some_and(|code| code != 0);
        run.status = if is_failed { "failed" } else { "missing" }.to_owned();
        let log = plain_file::text(&with_end(stem, ".log")).unwrap_or_default();
        run.message = complaint(&log).unwrap_or("no result file").to_owned();
    } else if let Err(error) = fill(&mut run, &file, wanted) {
        run.status = "unreadable".to_owned();
        run.message = error.to_string();
    }
    if run.values.is_empty() {
        run.values = set_values(&plain_file::text(&with_end(stem, ".set")).unwrap_or_default());
    }
    run
}

/// The first line of a log that is no progress.
fn complaint(log: &str) -> Option<&str> {
    let is_progress = |l: &&str| [" INFO", " WARN", "DEBUG"].iter().any(|level| l.starts_with(level));
    log.lines().filter(|l| !l.trim().is_empty()).find(|l| !is_progress(l))
}

/// `KEY=VALUE` a line.
fn set_values(text: &str) -> Values {
    let pairs = text.lines().filter_map(|line| line.split_once('='));
    pairs.map(|(key, value)| (key.trim().to_owned(), scenario_values::shown(value.trim()))).collect()
}

fn fill(run: &mut Run, file: &Path, wanted: &[NamedExpression]) -> Result<(), ResultError> {
    let stored = Stored::open(file)?;
    run.status = stored.attribute("status");
    run.message = stored.attribute("message");
    run.values = scenario_values::read(&stored.scenario);
    run.hashes = ["sha256", open::INPUTS].map(|name| open::of_scenario(stored.file(), name));
    run.program = format!("{} {}", stored.attribute("program_version"), stored.attribute("commit"));
    run.end_time = stored.time.last().copied();
    run.n_samples = Some(stored.time.len());
    run.impacts.clone_from(&stored.impacts);
    let source = Source::new(&stored);
    // What a small copy, or a run without an instant, does not have is empty.
    let usual = usual_cells(&stored);
    run.cells = usual.iter().filter_map(|cell| cell.cells(&source).ok()).flatten().collect();
    for expression in wanted {
        match expression.cells(&source) {
            Ok(cells) => run.cells.extend(cells),
            Err(fault) => run.valueless.push((expression.name.clone(), fault)),
        }
    }
    // What a small copy or a run that was killed does not have stays empty.
    if let Ok(summary) = summary::read(file) {
        run.energy_drift = summary.energy_drift;
        run.peaks = summary.peaks;
        let identifiers = summary.warnings.iter().map(|line| warnings::identifier(line).to_owned());
        run.warnings = Some(identifiers.collect());
        let phases = &summary.phases;
        run.wall_time = (!phases.is_empty()).then(|| phases.iter().map(|p| p.wall_time).sum());
    }
    Ok(())
}

/// What every table has of energies: what there are at the end.
fn usual_cells(stored: &Stored) -> Vec<NamedExpression> {
    let inside = stored.entries.keys().filter_map(|path| path.strip_prefix("energies/")?.split('/').next());
    let names: BTreeSet<&str> = inside.collect();
    let texts = names.iter().map(|name| format!("energies.{name}.final=energies.\"{name}\"[-1]"));
    texts.filter_map(|text| text.parse().ok()).collect()
}
