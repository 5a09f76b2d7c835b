//! `fbimpact run --resume`: goes on with a run that was interrupted or killed.

use std::path::{Path, PathBuf};
use std::time::Instant;

use indicatif::ProgressBar;
use result_files::file::fault::FileFault;
use result_files::stored::open::{attribute, open};

use super::begin::begin;
use super::recording::finish;
use super::stop::Stop;
use crate::cache;
use crate::cli::RunArguments;
use crate::error::AppError;
use crate::process::provenance;
use crate::results::journal::{self, Restart};
use crate::results::{OutputFile, Recorder, linked, part_path, restart_path};
use crate::scenario::{self, Scenario};
use crate::simulate::simulate_with;

/// Goes on with the run that was to write `output`, or whose part file `output` is.
///
/// # Errors
/// [`AppError::Io`] if there is nothing to go on with or another run is at it, [`AppError::Scenario`] if a file that the scenario
/// names has changed, otherwise as a run.
pub fn resume(
    output: &Path,
    arguments: &RunArguments,
    n_threads: usize,
    stop: &Stop,
    (bar, began): (ProgressBar, Instant),
) -> Result<(), AppError> {
    let target = linked(&target(output))?;
    check_unfinished(&target)?;
    stop.begin();
    let output = OutputFile::claim_again(&target, arguments.force)?;
    let restart = journal::read(output.restart()).map_err(AppError::from);
    let prepared = restart.and_then(|r| Ok((scenario_of(&r)?, r)));
    let (scenario, restart) = match prepared {
        Ok(prepared) => prepared,
        Err(error) => {
            output.release();
            return Err(error);
        }
    };
    compare_versions(&restart);
    let Some(point) = restart.point.clone() else {
        tracing::info!("{} starts anew: no state was stored", target.display());
        return begin(&scenario, output, (arguments, n_threads), stop, (bar, began));
    };
    tracing::info!("{} is taken up at t = {:.9e} s", target.display(), point.time);
    let part = output.part().to_owned();
    let mut recorder =
        Recorder::create(&part, &scenario, n_threads).map_err(|fault| AppError::io(&part, fault))?;
    recorder.take_up(restart).map_err(|fault| AppError::io(&part, FileFault::contents(fault)))?;
    let cache = cache::open(&arguments.cache.settings());
    let preparation = began.elapsed().as_secs_f64();
    let outcome = finish(recorder, output, (stop, bar, began), |observer| {
        let mut report = simulate_with(&scenario, Some(&point), observer, n_threads, &cache)?;
        report.timings.preparation = preparation;
        Ok(report)
    });
    cache::log_use(&cache);
    outcome
}

/// The result that the run writes in the end.
fn target(output: &Path) -> PathBuf {
    match output.extension() {
        Some(ending) if ending == "part" || ending == "restart" => output.with_extension(""),
        _ => output.to_owned(),
    }
}

/// Refuses results for which there is nothing to do, and those with nothing to go on from.
fn check_unfinished(target: &Path) -> Result<(), AppError> {
    let fail = |path: &Path, reason: String| Err(AppError::io(path, reason));
    let (part, restart) = (part_path(target), restart_path(target));
    let status =
        if target.is_file() { open(target).ok().and_then(|f| attribute(&f, "status")) } else { None };
    match status.as_deref() {
        // A run that replaces an earlier result has its own part file.
        Some("complete") if !part.exists() => {
            return fail(
                target,
                "is complete, there is nothing to resume; for a later end start a new run with --set simulation.end_time=..."
                    .into(),
            );
        }
        Some("failed") if !restart.exists() && !part.exists() => {
            return fail(
                target,
                "is of a run that failed and would fail again, start a new run with another scenario".into(),
            );
        }
        _ => {}
    }
    if restart.exists() {
        return Ok(());
    }
    if target.exists() || part.exists() {
        let reason = format!("cannot be resumed without {}, start the run anew", restart.display());
        return fail(if part.exists() { &part } else { target }, reason);
    }
    fail(target, format!("no such run: neither it nor {} exists", part.display()))
}

/// The scenario of the run.
fn scenario_of(restart: &Restart) -> Result<Scenario, AppError> {
    let header = &restart.header;
    // Errors name the file; bodies are sought beside it and must have the checksums of the resolved
    // scenario.
    let mut scenario = scenario::parse(Path::new(&header.absolute), header.resolved.as_bytes(), &[])?;
    scenario.source.path = PathBuf::from(&header.scenario);
    scenario.source.sha256.clone_from(&header.sha256);
    scenario.source.inputs_sha256.clone_from(&header.inputs_sha256);
    // With the reasons of the sizes chosen, which stand in comments.
    scenario.source.resolved.clone_from(&header.resolved);
    Ok(scenario)
}

fn compare_versions(restart: &Restart) {
    let Restart { header, path, .. } = restart;
    if header.version != provenance::VERSION || header.commit != provenance::build().commit {
        tracing::warn!(
            "{} is of version {} ({}), this is {} ({}): the parts of the result may not fit to the last digit",
            path.display(),
            header.version,
            header.commit,
            provenance::VERSION,
            provenance::build().commit
        );
    }
}
