//! `fbimpact run`: simulates a scenario and writes the result file.

use std::path::{Path, PathBuf};

use indicatif::ProgressBar;

use super::recording::record;
use super::stop::{Held, Stop};
use super::{check_distinct, threads};
use crate::cache::{self, CacheSettings};
use crate::cli::RunArguments;
use crate::error::AppError;
use crate::progress::Progress;
use crate::results::OutputFile;
use crate::results::journal::{Header, Journal};
use crate::scenario::{self, Scenario};
use crate::simulate::simulate_with;
use crate::sizing::sized;

/// Runs a scenario file.
///
/// # Errors
/// Every [`AppError`]; after a failed or interrupted run the results so far are kept.
pub fn run(arguments: &RunArguments, bar: ProgressBar) -> Result<(), AppError> {
    let n_threads = threads(arguments.threads)?;
    // Fine models are built during the run, on the pool of the process. A second run in one process finds it there.
    let _ = rayon::ThreadPoolBuilder::new().num_threads(n_threads).build_global();
    match (&arguments.resume, &arguments.scenario) {
        (Some(output), _) => super::resume::resume(output, arguments, n_threads, bar),
        (None, Some(path)) => run_scenario(path, arguments, n_threads, bar),
        // The command line asks for one of them.
        (None, None) => Err(AppError::Command("name a scenario, or a result with --resume".into())),
    }
}

fn run_scenario(
    path: &Path,
    arguments: &RunArguments,
    n_threads: usize,
    bar: ProgressBar,
) -> Result<(), AppError> {
    let scenario = scenario::read(path, &arguments.set.set)?;
    let target = match &arguments.output {
        Some(target) => target.clone(),
        None => default_output(path),
    };
    check_distinct(&scenario, &target)?;
    let stop = Stop::listen(arguments.until_eof);
    let output = OutputFile::claim(&target, arguments.force)?;
    begin(&scenario, output, (arguments, n_threads), &stop, bar)
}

/// Chooses the sizes that `scenario` leaves open and runs it to `output` from the start.
///
/// # Errors
/// As [`run`].
pub(super) fn begin(
    scenario: &Scenario,
    output: OutputFile,
    (arguments, n_threads): (&RunArguments, usize),
    stop: &Stop,
    bar: ProgressBar,
) -> Result<(), AppError> {
    // A run that is killed while sizes are chosen can be taken up, too.
    drop(Journal::create(output.restart(), Header::new(scenario))?);
    stop.hold(Held { output, recorder: None, bar: bar.clone(), time: 0.0 });
    let cache = cache::open(&CacheSettings::new(&arguments.cache));
    // The result shall hold the sizes that the run has.
    let progress = Progress::new(bar.clone());
    progress.stage(Some("choosing meshes and numbers of modes".into()));
    let scenario = sized(scenario, n_threads, &cache);
    drop(progress);
    let output = stop.take().output;
    let scenario = match scenario {
        Ok(scenario) => scenario,
        Err(error) => {
            bar.finish_and_clear();
            output.remove_restart();
            output.discard();
            return Err(error);
        }
    };
    let outcome = record(&scenario, output, n_threads, stop, bar, |scenario, observer, threads| {
        simulate_with(scenario, None, observer, threads, &cache)
    });
    cache::log_use(&cache);
    outcome
}

/// The scenario's name with `.h5`, in the working directory.
fn default_output(scenario: &Path) -> PathBuf {
    let mut name = scenario.file_stem().unwrap_or(scenario.as_os_str()).to_owned();
    name.push(".h5");
    PathBuf::from(name)
}
