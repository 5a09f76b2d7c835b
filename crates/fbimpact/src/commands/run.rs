//! `fbimpact run`: simulates a scenario and writes the result file.

pub mod stop;
pub mod recording;
mod begin;
mod resume;
pub mod equilibrium;

use std::path::{Path, PathBuf};
use std::time::Instant;

use indicatif::ProgressBar;

use super::prepare::check::tell_units;
use super::{gate_of, threads};
use crate::cli::RunArguments;
use crate::commands::scenario_file;
use crate::error::{AppError, CommandFault};
use crate::results::left::{Left, left};
use crate::results::{OutputFile, RESULT, linked};
use begin::begin;
use stop::Stop;

/// Runs a scenario file.
///
/// # Errors
/// Every [`AppError`]; after a failed or interrupted run the results so far are kept.
pub fn run(arguments: &RunArguments, bar: ProgressBar) -> Result<(), AppError> {
    let started = (bar, Instant::now());
    let stop = Stop::listen(arguments.until_eof);
    let n_threads = threads(arguments.threads)?;
    if let Some(gigabytes) = arguments.memory {
        ffr_dynamics::memory::limit((1e9 * gigabytes) as u64);
    }
    match (&arguments.resume, &arguments.scenario) {
        (Some(output), _) => resume::resume(output, arguments, n_threads, &stop, started),
        (None, Some(path)) => run_scenario(path, arguments, n_threads, &stop, started),
        // The command line asks for one of them.
        (None, None) => Err(CommandFault::request("name a scenario, or a result with --resume").into()),
    }
}

fn run_scenario(
    path: &Path,
    arguments: &RunArguments,
    n_threads: usize,
    stop: &Stop,
    started: (ProgressBar, Instant),
) -> Result<(), AppError> {
    let scenario = scenario_file::read(path, &arguments.set.set)?;
    let target = match &arguments.output {
        Some(target) => target.clone(),
        None => default_output(path, "h5"),
    };
    gate_of(&scenario, arguments.force).check(&linked(&target)?, RESULT)?;
    let left = if arguments.update { left(&target, &scenario.source.inputs_sha256)? } else { Left::Nothing };
    if arguments.dry_run {
        return if left == Left::Complete { Ok(()) } else { Err(AppError::NotCurrent { output: target }) };
    }
    match left {
        Left::Complete => {
            tracing::info!("{} is complete, of this scenario, its files and this program", target.display());
            return Ok(());
        }
        Left::Part => match resume::resume(&target, arguments, n_threads, stop, started.clone()) {
            // As on another kind of machine.
            Err(error) if [4, 6].contains(&error.code()) => tracing::warn!("{error}; the run is made anew"),
            outcome => return outcome,
        },
        Left::Nothing => {}
    }
    tell_units(None, &scenario);
    stop.begin();
    let output = OutputFile::claim(&target, arguments.force)?;
    begin(&scenario, output, (arguments, n_threads), stop, started)
}

/// The scenario's name with `ending`, in the working directory.
fn default_output(scenario: &Path, ending: &str) -> PathBuf {
    let mut name = scenario.file_stem().unwrap_or(scenario.as_os_str()).to_owned();
    name.push(".");
    name.push(ending);
    PathBuf::from(name)
}
