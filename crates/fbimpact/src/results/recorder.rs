//! Writes a run to HDF5 while it goes on.

use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use adaptive::record::warning::Warning;
use adaptive::record::{
    EventRecord, ImpactRecord, PeakRecord, PhaseRecord, RunLayout, Sample, StressRecord, Timings,
    TransferRecord, TrialRecord,
};
use adaptive::spec::BodySpec;
use iga_core::elasticity::Model;
use result_files::dataset::text_attribute;
use result_files::file::fault::FileFault;

use super::columns::{Axes, TIMINGS};
use super::fault::RecordingFault;
use super::journal::{Entry, Restart};
use super::stress::write_stress;
use crate::scenario::{Compression, Scenario};

mod contacts;
mod layout;
mod open_file;
mod restart;

use open_file::{Open, write_peaks, write_timings};

/// Wall time between flushes, so that a killed process loses little.
const FLUSH_INTERVAL: Duration = Duration::from_secs(5);

/// Datasets of a body, contact, point or joint at most, with their scales.
const DATASETS_PER_GROUP: usize = 14;

/// What `/warnings` holds.
pub const WARNINGS: &str =
    "Warnings of the run, a line each: identifier, subject, what was found; what to change.";

/// Attribute `status` of a result file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Status {
    /// The end time was reached.
    Complete,
    /// The user stopped the run.
    Interrupted,
    /// The run failed.
    Failed,
}

impl Status {
    /// Value of the attribute.
    pub fn name(self) -> &'static str {
        match self {
            Self::Complete => "complete",
            Self::Interrupted => "interrupted",
            Self::Failed => "failed",
        }
    }
}

/// The result of an operation on the open file.
type Recorded<T> = Result<T, RecordingFault>;

/// Bodies that have a group each at most, unless the scenario says otherwise: a dataset takes 1.4 kB and 40 kB of memory, five a body.
const MOST_GROUPS: usize = 500;

/// How the series of a run are stored.
#[derive(Debug, Clone, Copy)]
pub(super) struct FileForm {
    /// How chunks are compressed.
    compression: Compression,
    /// Whether the motion of all bodies is in datasets that they share.
    arrays: bool,
}

impl FileForm {
    fn of(scenario: &Scenario) -> Self {
        let is_many = scenario.run.bodies.len() > MOST_GROUPS;
        Self { compression: scenario.compression, arrays: scenario.arrays.unwrap_or(is_many) }
    }
}

/// Writes samples, records and stresses of one run.
pub struct Recorder {
    form: FileForm,
    /// Body name and model of every stress request.
    stress_models: Vec<(String, Option<Model>)>,
    open: Option<Open>,
    failure: Option<Arc<RecordingFault>>,
    seconds: f64,
    last_flush: Instant,
    /// Where a run is taken up from, until that is done.
    restart: Option<Restart>,
    is_taken_up: bool,
}

impl Recorder {
    /// Creates the file `path` with everything that is known before the run.
    ///
    /// # Errors
    /// [`FileFault::Hdf5`], or [`FileFault::System`] if the disk is full.
    pub fn create(path: &Path, scenario: &Scenario, threads: usize) -> Result<Self, FileFault> {
        let stress_models = scenario.run.stress.iter().map(|line| {
            let body = scenario.run.bodies.get(line.body).and_then(BodySpec::elastic);
            (line.name.clone(), body.map(|body| body.model))
        });
        let form = FileForm::of(scenario);
        let mut recorder = Self {
            form,
            stress_models: stress_models.collect(),
            open: None,
            failure: None,
            seconds: 0.0,
            last_flush: Instant::now(),
            restart: None,
            is_taken_up: false,
        };
        recorder.open = Some(Open::create(path, scenario, form, threads)?);
        Ok(recorder)
    }

    /// Runs one operation on the file, which is closed after a failure; what was flushed stays
    /// readable.
    fn with(&mut self, action: impl FnOnce(&mut Open) -> Recorded<()>) -> Result<(), Arc<RecordingFault>> {
        let begin = Instant::now();
        let Some(mut open) = self.open.take() else {
            return Err(self.failure.clone().unwrap_or_else(|| Arc::new(RecordingFault::Closed)));
        };
        let outcome = open.reserve().and_then(|()| action(&mut open));
        self.seconds += begin.elapsed().as_secs_f64();
        match outcome {
            Ok(()) => {
                self.open = Some(open);
                Ok(())
            }
            Err(fault) => {
                let fault = Arc::new(fault);
                self.failure = Some(fault.clone());
                Err(fault)
            }
        }
    }

    /// Why writing failed, if it did.
    pub fn failure(&self) -> Option<Arc<RecordingFault>> {
        self.failure.clone()
    }

    /// Whether the datasets exist, with what a run that is taken up stored before.
    pub fn has_begun(&self) -> bool {
        self.open.as_ref().is_some_and(|o| !o.columns.is_empty())
    }

    /// Number of samples stored.
    pub fn n_samples(&self) -> usize {
        self.open.as_ref().map_or(0, |o| o.rows)
    }

    /// Creates all datasets.
    ///
    /// # Errors
    /// [`RecordingFault`] if the file cannot be written.
    pub fn start(&mut self, layout: &RunLayout) -> Result<(), Arc<RecordingFault>> {
        let form = self.form;
        let restart = self.restart.take();
        self.with(|open| {
            open.layout(layout, form)?;
            match restart.filter(|r| r.point.is_some()) {
                Some(restart) => open.replay(&restart),
                None => open.note(&Entry::Layout(open.widths())),
            }
        })
    }

    /// Stores an instant.
    ///
    /// # Errors
    /// [`RecordingFault`] if the file cannot be written.
    pub fn sample(&mut self, sample: &Sample) -> Result<(), Arc<RecordingFault>> {
        let due = self.last_flush.elapsed() >= FLUSH_INTERVAL;
        if due {
            self.last_flush = Instant::now();
        }
        self.with(|open| open.sample(sample, due))
    }

    /// Stores a phase and flushes.
    ///
    /// # Errors
    /// [`RecordingFault`] if the file cannot be written.
    pub fn phase(&mut self, record: &PhaseRecord) -> Result<(), Arc<RecordingFault>> {
        self.with(|open| {
            open.record(&Entry::Phase(*record))?;
            open.write_series()?;
            Ok(open.flush()?)
        })
    }

    /// Stores an impact.
    ///
    /// # Errors
    /// [`RecordingFault`] if the file cannot be written.
    pub fn impact(&mut self, record: &ImpactRecord) -> Result<(), Arc<RecordingFault>> {
        self.with(|open| open.record(&Entry::Impact(*record)))
    }

    /// Stores what a contact did.
    ///
    /// # Errors
    /// [`RecordingFault`] if the file cannot be written.
    pub fn event(&mut self, record: &EventRecord) -> Result<(), Arc<RecordingFault>> {
        self.with(|open| open.record(&Entry::Event(*record)))
    }

    /// Stores a trial.
    ///
    /// # Errors
    /// [`RecordingFault`] if the file cannot be written.
    pub fn trial(&mut self, record: &TrialRecord) -> Result<(), Arc<RecordingFault>> {
        self.with(|open| open.record(&Entry::Trial(record.clone())))
    }

    /// Stores a change of the model.
    ///
    /// # Errors
    /// [`RecordingFault`] if the file cannot be written.
    pub fn transfer(&mut self, record: &TransferRecord) -> Result<(), Arc<RecordingFault>> {
        self.with(|open| open.record(&Entry::Transfer(Box::new(record.clone()))))
    }

    /// Stores a warning.
    ///
    /// # Errors
    /// [`RecordingFault`] if the file cannot be written.
    pub fn warning(&mut self, warning: &Warning) -> Result<(), Arc<RecordingFault>> {
        self.with(|open| open.record(&Entry::Warning(warning.clone())))
    }

    /// Stores stresses along a line; a later record of the same name takes the place of an earlier
    /// one.
    ///
    /// # Errors
    /// [`RecordingFault`] if the file cannot be written.
    pub fn stress(&mut self, record: &StressRecord) -> Result<(), Arc<RecordingFault>> {
        let model = self.stress_models.iter().find(|(n, _)| *n == record.name).and_then(|(_, m)| *m);
        self.with(|open| Ok(write_stress(&open.file, record, model)?))
    }

    /// Stores the largest values of joints and points as attributes of their datasets.
    ///
    /// # Errors
    /// [`RecordingFault`] if the file cannot be written.
    pub fn peaks(&mut self, layout: &RunLayout, peaks: &[PeakRecord]) -> Result<(), Arc<RecordingFault>> {
        self.with(|open| Ok(write_peaks(&open.file, layout, peaks)?))
    }

    /// Writes what is buffered, the timings of a command that began when they say, and the status, and closes the file.
    ///
    /// # Errors
    /// [`RecordingFault`] if the file cannot be written.
    pub fn finish(
        &mut self,
        status: Status,
        message: &str,
        timings: Option<(Timings, Instant)>,
    ) -> Result<(), Arc<RecordingFault>> {
        let seconds = self.seconds;
        self.with(|open| {
            let begin = Instant::now();
            open.write_series()?;
            open.axes.as_ref().map_or(Ok(()), Axes::finish)?;
            if let Some((mut timings, began)) = timings {
                // Rows were written while the run went on.
                timings.integration = (timings.integration - seconds).max(0.0);
                timings.output = seconds + begin.elapsed().as_secs_f64();
                let sum: f64 = TIMINGS.iter().map(|stage| (stage.seconds)(&timings)).sum();
                timings.rest = (began.elapsed().as_secs_f64() - sum).max(0.0);
                write_timings(&open.file, &timings)?;
            }
            text_attribute(&open.file, "message", message)?;
            text_attribute(&open.file, "status", status.name())?;
            Ok(open.flush()?)
        })?;
        self.open.take().map_or(Ok(()), Open::close).map_err(Arc::new)
    }
}
