//! A run from its start.

use std::time::Instant;

use adaptive::model::check_unbuilt;
use adaptive::prepared::Prepared;
use indicatif::ProgressBar;

use super::recording::record;
use super::stop::{Held, Stop};
use crate::cache;
use crate::cli::RunArguments;
use crate::error::AppError;
use crate::progress::Progress;
use crate::results::OutputFile;
use crate::results::journal::{Header, Journal};
use crate::scenario::Scenario;
use crate::simulate::simulate_prepared;
use crate::simulate::sizing::sized_for;

/// Chooses the sizes that `scenario` leaves open and runs it to `output` from the start; the command began at `begin`.
///
/// # Errors
/// Every [`AppError`]; after a failed or interrupted run the results so far are kept.
pub(super) fn begin(
    scenario: &Scenario,
    output: OutputFile,
    (arguments, n_threads): (&RunArguments, usize),
    stop: &Stop,
    (bar, begin): (ProgressBar, Instant),
) -> Result<(), AppError> {
    // What a run refuses whatever its meshes are comes before they are chosen, which may take
    // minutes.
    let run = match Prepared::new(&scenario.run)
        .and_then(|run| check_unbuilt(&run, &scenario.wishes).map(|()| run))
    {
        Ok(run) => run,
        Err(error) => {
            output.discard();
            bar.finish_and_clear();
            return Err(error.into());
        }
    };
    // A run that is killed while sizes are chosen can be taken up, too. The restart file of an
    // earlier run stays until this one begins.
    let is_restart_own = !output.restart().exists();
    if is_restart_own {
        match Journal::create(output.restart(), Header::new(scenario)) {
            Ok(journal) => drop(journal),
            Err(error) => {
                output.discard();
                return Err(error.into());
            }
        }
    }
    stop.hold(Held { output, recorder: None, is_restart_own, bar: bar.clone(), time: 0.0 });
    let cache = cache::open(&arguments.cache.settings());
    // The result shall hold the sizes that the run has.
    let progress = Progress::new(bar.clone());
    progress.stage(Some("choosing meshes and numbers of modes".into()));
    let choosing = Instant::now();
    let scenario = sized_for(scenario, &run, n_threads, &cache);
    let sizes = choosing.elapsed().as_secs_f64();
    drop(progress);
    let held = stop.take();
    // A run that was told to stop meanwhile begins nothing.
    if stop.is_asked() {
        return Err(held.close());
    }
    let output = held.output;
    let scenario = match scenario {
        Ok(scenario) => scenario,
        Err(error) => {
            bar.finish_and_clear();
            if is_restart_own {
                output.remove_restart();
            }
            output.discard();
            return Err(error);
        }
    };
    let outcome = record(&scenario, output, n_threads, (stop, bar, begin), |_, observer, threads| {
        let preparation = begin.elapsed().as_secs_f64() - sizes;
        let run = run.with_sizes(&scenario.run)?;
        let mut report = simulate_prepared(run, None, observer, threads, &cache)?;
        (report.timings.preparation, report.timings.sizes) = (preparation, sizes);
        Ok(report)
    });
    cache::log_use(&cache);
    outcome
}
