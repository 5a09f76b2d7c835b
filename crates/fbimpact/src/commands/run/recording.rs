//! A simulation with its file, its progress line and the wish to stop.

use std::cmp::Ordering;
use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Instant;

use adaptive::error::ObserverError;
use adaptive::record::warning::{Warning, WarningKind};
use adaptive::record::{
    EventRecord, ImpactRecord, PeakRecord, PhaseKind, PhaseRecord, RunLayout, Sample, StressRecord,
    TransferRecord, TrialRecord,
};
use adaptive::state::RunState;
use adaptive::state::observer::{Continue, Observer, Stage};
use indicatif::ProgressBar;
use result_files::file::fault::FileFault;

use super::stop::{Held, Stop};
use crate::error::AppError;
use crate::progress::Progress;
use crate::results::fault::RecordingFault;
use crate::results::journal::{Header, Journal};
use crate::results::{OutputFile, Recorder, Status};
use crate::scenario::Scenario;
use crate::simulate::{Ending, RunReport};

/// Warnings of one kind that are printed: as many as fit a screen.
const MOST_TOLD: usize = 10;

/// A function that runs a scenario, see [`crate::simulate::simulate`].
pub type Simulation = fn(&Scenario, &mut dyn Observer, usize) -> Result<RunReport, AppError>;

/// Runs `simulation` and records it in `output`, whatever way it ends.
///
/// # Errors
/// That of the run, or of writing.
pub fn record(
    scenario: &Scenario,
    output: OutputFile,
    n_threads: usize,
    (stop, bar, begin): (&Stop, ProgressBar, Instant),
    simulation: impl FnOnce(&Scenario, &mut dyn Observer, usize) -> Result<RunReport, AppError>,
) -> Result<(), AppError> {
    let part = output.part().to_owned();
    let recorder = Recorder::create(&part, scenario, n_threads);
    let mut recorder = recorder.map_err(|fault| AppError::io(&part, fault))?;
    recorder.keep(Journal::create(output.restart(), Header::new(scenario))?);
    finish(recorder, output, (stop, bar, begin), |observer| simulation(scenario, observer, n_threads))
}

/// Runs `simulation`, recorded by `recorder` in `output`, and closes the file whatever way it ends.
///
/// # Errors
/// That of the run, or of writing.
pub fn finish(
    recorder: Recorder,
    output: OutputFile,
    (stop, bar, begin): (&Stop, ProgressBar, Instant),
    simulation: impl FnOnce(&mut dyn Observer) -> Result<RunReport, AppError>,
) -> Result<(), AppError> {
    let part = output.part().to_owned();
    let progress = Progress::new(bar.clone());
    stop.hold(Held { output, recorder: Some(recorder), is_restart_own: true, bar, time: 0.0 });
    let mut observer = RunObserver { progress, stop, n_impacts: 0, told: BTreeMap::new() };
    let outcome = simulation(&mut observer);
    observer.progress.finish();
    let Held { output, recorder, .. } = stop.take();
    let recorder = &mut recorder.expect("it was given above");
    if let Some(fault) = recorder.failure() {
        // The rows that reached the disk stay in the part file, and the run can be taken up once
        // there is space.
        return Err(AppError::io(part, FileFault::contents(fault)));
    }
    if recorder.is_taken_up() && matches!(outcome, Err(AppError::Model(_))) {
        // Another machine or version may be the reason: where the run came from, it can still be
        // taken up.
        return outcome.map(|_| ());
    }
    let (status, message, timings) = match &outcome {
        Ok(report) if report.ending == Ending::Complete => {
            (Status::Complete, String::new(), Some((report.timings, begin)))
        }
        Ok(report) => {
            let message = format!("interrupted at t = {:.9e} s", report.time);
            (Status::Interrupted, message, Some((report.timings, begin)))
        }
        Err(error) => (Status::Failed, error.to_string(), None),
    };
    if status == Status::Failed && recorder.n_samples() == 0 {
        output.remove_restart();
        output.discard();
        return outcome.map(|_| ());
    }
    recorder
        .finish(status, &message, timings)
        .map_err(|fault| AppError::io(&part, FileFault::contents(fault)))?;
    let path = output.finish(status)?;
    let report = outcome.inspect_err(|_| {
        tracing::warn!("the results up to the failure are in {}", path.display());
    })?;
    if report.ending == Ending::Interrupted {
        return Err(AppError::Interrupted { time: report.time, output: path });
    }
    tracing::info!("{} written after {:.2} s", path.display(), begin.elapsed().as_secs_f64());
    Ok(())
}

/// Passes a run on to the file, the progress display and the wish to stop.
struct RunObserver<'a> {
    progress: Progress,
    stop: &'a Stop,
    /// Impacts that have been logged.
    n_impacts: u32,
    /// How many warnings of each kind were given.
    told: BTreeMap<WarningKind, usize>,
}

impl RunObserver<'_> {
    fn record(
        &self,
        action: impl FnOnce(&mut Recorder) -> Result<(), Arc<RecordingFault>>,
    ) -> Result<(), ObserverError> {
        let recorded =
            self.stop.with(|held| action(held.recorder.as_mut().expect("a run that goes on has a recorder")));
        recorded.map_err(ObserverError::new)
    }
}

impl Observer for RunObserver<'_> {
    fn stage(&mut self, stage: Stage<'_>) {
        self.progress.stage(match stage {
            Stage::Sizes => Some("choosing meshes and modes".into()),
            Stage::Bodies => Some("building the models of the bodies".into()),
            Stage::FineModels { contact, body, target: None } => {
                Some(format!("contact \"{contact}\": building the fine model of \"{body}\""))
            }
            Stage::FineModels { contact, body, target: Some(target) } => Some(format!(
                "contact \"{contact}\": building the fine models of \"{body}\" and \"{target}\""
            )),
            Stage::Motion => None,
        });
    }

    fn start(&mut self, layout: &RunLayout) -> Result<(), ObserverError> {
        self.progress.set_span(layout.time_span, layout.contacts.is_empty());
        self.record(|recorder| recorder.start(layout))
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), ObserverError> {
        self.record(|recorder| recorder.sample(sample))
    }

    fn progress(&mut self, time: f64, step: f64, phase: PhaseKind) -> Continue {
        self.progress.step(time, step, phase);
        self.stop.with(|held| held.time = time);
        if self.stop.is_asked() { Continue::Interrupt } else { Continue::Yes }
    }

    fn is_interrupted(&mut self) -> bool {
        self.stop.is_asked()
    }

    fn phase(&mut self, record: &PhaseRecord) -> Result<(), ObserverError> {
        tracing::debug!(
            "{:?} phase from {:.9e} s to {:.9e} s: {} steps, {} rejected, {} evaluations, {:.3} s",
            record.kind,
            record.start,
            record.end,
            record.steps,
            record.rejected,
            record.evaluations,
            record.wall_time
        );
        self.record(|recorder| recorder.phase(record))
    }

    fn impact(&mut self, record: &ImpactRecord) -> Result<(), ObserverError> {
        let goes_on = if record.row < self.n_impacts { " goes on" } else { "" };
        self.n_impacts = self.n_impacts.max(record.row + 1);
        tracing::info!(
            "impact at {:.6e} s{goes_on}: {:.5e} s long, peak {:.6} N, impulse {:.6e} N s, restitution {}",
            record.start,
            record.end - record.start,
            record.peak_force,
            record.impulse,
            crate::commands::ratio(record.restitution)
        );
        self.record(|recorder| recorder.impact(record))
    }

    fn event(&mut self, record: &EventRecord) -> Result<(), ObserverError> {
        self.record(|recorder| recorder.event(record))
    }

    fn trial(&mut self, record: &TrialRecord) -> Result<(), ObserverError> {
        tracing::debug!(
            "trial {} of impact {}: {} ({})",
            record.number,
            record.impact + 1,
            record.outcome.identifier(),
            record.reason
        );
        self.record(|recorder| recorder.trial(record))
    }

    fn restart_point(&mut self, point: &RunState) -> Result<(), ObserverError> {
        self.record(|recorder| recorder.restart_point(point))
    }

    fn transfer(&mut self, record: &TransferRecord) -> Result<(), ObserverError> {
        tracing::debug!(
            "{} at {:.9e} s: energy {:.9e} J before, {:.9e} J after",
            record.direction.identifier(),
            record.time,
            record.energy_before,
            record.energy_after
        );
        self.record(|recorder| recorder.transfer(record))
    }

    fn warning(&mut self, warning: &Warning) -> Result<(), ObserverError> {
        let told = self.told.entry(warning.kind).or_default();
        *told += 1;
        match (*told).cmp(&MOST_TOLD) {
            Ordering::Less => tracing::warn!("{}", warning.line()),
            Ordering::Equal => {
                let kind = warning.kind.identifier();
                tracing::warn!(
                    "{}; `fbimpact info` shows all further ones of the kind {kind}",
                    warning.line()
                );
            }
            Ordering::Greater => {}
        }
        self.record(|recorder| recorder.warning(warning))
    }

    fn peaks(&mut self, layout: &RunLayout, peaks: &[PeakRecord]) -> Result<(), ObserverError> {
        self.record(|recorder| recorder.peaks(layout, peaks))
    }

    fn stress(&mut self, record: &StressRecord) -> Result<(), ObserverError> {
        self.record(|recorder| recorder.stress(record))
    }
}
