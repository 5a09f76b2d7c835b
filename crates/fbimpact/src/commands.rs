//! The commands. Each returns its result or an [`AppError`]; only [`crate::main_with`] maps that to
//! an exit code.

pub mod scenario_file;
pub mod prepare;
pub mod run;
mod many_runs;
pub mod converge;
pub mod drop;
pub mod results;
pub mod bodies;
pub mod program;

use std::io::Write;
use std::path::Path;

use indicatif::ProgressBar;
use result_files::file::fault::FileFault;
use result_files::file::output::Gate;
use result_files::words::shown::shown;

use crate::error::{AppError, CommandFault};
use crate::scenario::Scenario;

/// A ratio for people, a dash where there is none.
fn ratio(x: f64) -> String {
    if x.is_finite() { format!("{x:.6}") } else { "-".to_owned() }
}

/// Writes to standard output; a reader that closed the pipe is no error.
///
/// # Errors
/// [`AppError::Io`] if writing fails for another reason.
pub fn print(text: &str) -> Result<(), AppError> {
    let mut out = std::io::stdout().lock();
    match out.write_all(shown(text).as_bytes()).and_then(|()| out.flush()) {
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(AppError::io("standard output", FileFault::Stream(e)))
        }
        _ => Ok(()),
    }
}

/// The gate for outputs of a command that reads `scenario`.
pub fn gate_of(scenario: &Scenario, force: bool) -> Gate {
    let own = (scenario.source.path.clone(), "the scenario itself".to_owned());
    Gate::new(std::iter::once(own).chain(scenario.files.iter().cloned()), force)
}

/// A body of a scenario and the file to which it is written.
#[derive(Debug, Clone, Copy)]
pub struct BodyExport<'a> {
    /// Scenario file.
    pub scenario: &'a Path,
    /// Name of the body.
    pub body: &'a str,
    /// File to be written.
    pub output: &'a Path,
    /// Whether it may replace a file of others.
    pub force: bool,
}

/// What a command computes with.
#[derive(Clone, Copy)]
pub struct Means<'a> {
    /// Threads that are asked for; 0 stands for all cores.
    pub threads: usize,
    /// Tells how far the work is.
    pub bar: &'a ProgressBar,
}

/// Number of the body that `--body` names, among those of a scenario.
fn body_index<'a>(name: &str, bodies: impl Iterator<Item = &'a String>) -> Result<usize, AppError> {
    let known: Vec<String> = bodies.cloned().collect();
    let index = known.iter().position(|known| known == name);
    index.ok_or_else(|| CommandFault::unknown_body("--body", name, "scenario", &known).into())
}

/// The body that `--body` names has no full model to export.
fn no_full_model(name: &str, what: &str) -> AppError {
    CommandFault::argument("--body", name, format!("the body is {what}, name a flexible one with a shape"))
        .into()
}

/// Threads per core of the machine at most: more only take memory and time.
const MOST_PER_CORE: usize = 4;

/// Sets up the thread pool and returns the number of threads; 0 asks for all cores, more than a few
/// per core are not started. Comes before the scenario is read, for body files are checked with
/// linear algebra.
///
/// # Errors
/// [`AppError::Threads`] if the threads cannot be started.
pub fn threads(wanted: usize) -> Result<usize, AppError> {
    // One thread in the linear algebra, all threads over elements and bodies: its barriers spin
    // (docs/decisions).
    faer::set_global_parallelism(faer::Par::Seq);
    let cores = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    let most = MOST_PER_CORE * cores;
    if wanted > most {
        tracing::warn!("{most} threads are used in place of {wanted}, the machine has {cores} cores");
    }
    rayon::ThreadPoolBuilder::new()
        .num_threads(wanted.min(most))
        .build_global()
        .map_err(|source| AppError::Threads { threads: wanted, source })?;
    Ok(rayon::current_num_threads())
}
