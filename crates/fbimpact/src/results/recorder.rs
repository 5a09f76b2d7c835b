//! Writes a run to HDF5 while it goes on.

use std::path::Path;
use std::time::{Duration, Instant};

use adaptive::error::ObserverError;
use adaptive::record::{
    ImpactRecord, PhaseRecord, RunLayout, Sample, StressRecord, Timings, TransferRecord, TrialRecord,
};
use adaptive::spec::BodySpec;
use adaptive::warning::Warning;
use hdf5::plist::file_access::{
    CacheDecreaseMode, CacheIncreaseMode, FlashIncreaseMode, MetadataCacheConfig,
};
use hdf5::types::VarLenUnicode;
use hdf5::{File, Result};
use iga_core::elasticity::Model;

use super::columns::{Column, Stage, TIMINGS};
use super::disk_space::DiskSpace;
use super::journal::{Entry, Journal, Restart, Row};
use super::pressure::Pressures;
use super::series::{ROWS, Table, describe, text_attribute, unicode, write_text};
use super::stress::write_stress;
use super::tables::{self, ImpactRow, PhaseRow, TransferRow, TrialRow};
use super::{FORMAT, FORMAT_VERSION};
use crate::error_text;
use crate::provenance;
use crate::scenario::{Compression, Scenario};

mod layout;
mod restart;

/// Wall time between flushes, so that a killed process loses little.
const FLUSH_INTERVAL: Duration = Duration::from_secs(5);

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

/// Writes samples, records and stresses of one run.
pub struct Recorder {
    compression: Compression,
    /// Body name and model of every stress request.
    stress_models: Vec<(String, Option<Model>)>,
    open: Option<Open>,
    failure: Option<String>,
    seconds: f64,
    last_flush: Instant,
    /// Where a run is taken up from, until that is done.
    restart: Option<Restart>,
    is_taken_up: bool,
}

/// Handles of an open file.
struct Open {
    file: File,
    columns: Vec<Column<f64>>,
    counts: Vec<Column<u32>>,
    pressures: Vec<Pressures>,
    /// Names of the contacts.
    contact_names: Vec<String>,
    disk_space: DiskSpace,
    /// Bytes that the series may take between two flushes.
    room: u64,
    buffered: usize,
    rows: usize,
    phases: Table,
    impacts: Table,
    trials: Table,
    transfers: Table,
    warnings: Table,
    journal: Option<Journal>,
    /// The row stored last.
    row: Row,
}

impl Recorder {
    /// Creates the file `path` with everything that is known before the run.
    ///
    /// # Errors
    /// The text of the HDF5 error.
    pub fn create(path: &Path, scenario: &Scenario, threads: usize) -> Result<Self, ObserverError> {
        let stress_models = scenario.run.stress.iter().map(|line| {
            let body = scenario.run.bodies.get(line.body).and_then(BodySpec::elastic);
            (line.name.clone(), body.map(|body| body.model))
        });
        let mut recorder = Self {
            compression: scenario.compression,
            stress_models: stress_models.collect(),
            open: None,
            failure: None,
            seconds: 0.0,
            last_flush: Instant::now(),
            restart: None,
            is_taken_up: false,
        };
        match Open::create(path, scenario, threads) {
            Ok(open) => recorder.open = Some(open),
            Err(error) => {
                return Err(ObserverError(format!("cannot be written: {}", error_text::of_hdf5(&error))));
            }
        }
        Ok(recorder)
    }

    /// Runs one operation on the file, which is closed after a failure; what was flushed stays readable.
    fn with(&mut self, action: impl FnOnce(&mut Open) -> Result<()>) -> Result<(), ObserverError> {
        let begin = Instant::now();
        let Some(mut open) = self.open.take() else {
            let reason = self.failure.clone().unwrap_or_else(|| "the result file is closed".into());
            return Err(ObserverError(reason));
        };
        let outcome = open.reserve().and_then(|()| action(&mut open));
        self.seconds += begin.elapsed().as_secs_f64();
        match outcome {
            Ok(()) => {
                self.open = Some(open);
                Ok(())
            }
            Err(error) => {
                let reason = format!("results cannot be written: {}", error_text::of_hdf5(&error));
                self.failure = Some(reason.clone());
                Err(ObserverError(reason))
            }
        }
    }

    /// Why writing failed, if it did.
    pub fn failure(&self) -> Option<&str> {
        self.failure.as_deref()
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
    /// [`ObserverError`] if the file cannot be written.
    pub fn start(&mut self, layout: &RunLayout) -> Result<(), ObserverError> {
        let compression = self.compression;
        let restart = self.restart.take();
        self.with(|open| {
            open.layout(layout, compression)?;
            match restart.filter(|r| r.point.is_some()) {
                Some(restart) => open.replay(&restart),
                None => open.note(&Entry::Layout(open.widths())),
            }
        })
    }

    /// Stores an instant.
    ///
    /// # Errors
    /// [`ObserverError`] if the file cannot be written.
    pub fn sample(&mut self, sample: &Sample) -> Result<(), ObserverError> {
        let due = self.last_flush.elapsed() >= FLUSH_INTERVAL;
        if due {
            self.last_flush = Instant::now();
        }
        self.with(|open| open.sample(sample, due))
    }

    /// Stores a phase and flushes.
    ///
    /// # Errors
    /// [`ObserverError`] if the file cannot be written.
    pub fn phase(&mut self, record: &PhaseRecord) -> Result<(), ObserverError> {
        self.with(|open| {
            open.record(&Entry::Phase(*record))?;
            open.write_series()?;
            open.flush()
        })
    }

    /// Stores an impact.
    ///
    /// # Errors
    /// [`ObserverError`] if the file cannot be written.
    pub fn impact(&mut self, record: &ImpactRecord) -> Result<(), ObserverError> {
        self.with(|open| open.record(&Entry::Impact(*record)))
    }

    /// Stores a trial.
    ///
    /// # Errors
    /// [`ObserverError`] if the file cannot be written.
    pub fn trial(&mut self, record: &TrialRecord) -> Result<(), ObserverError> {
        self.with(|open| open.record(&Entry::Trial(record.clone())))
    }

    /// Stores a change of the model.
    ///
    /// # Errors
    /// [`ObserverError`] if the file cannot be written.
    pub fn transfer(&mut self, record: &TransferRecord) -> Result<(), ObserverError> {
        self.with(|open| open.record(&Entry::Transfer(record.clone())))
    }

    /// Stores a warning.
    ///
    /// # Errors
    /// [`ObserverError`] if the file cannot be written.
    pub fn warning(&mut self, warning: &Warning) -> Result<(), ObserverError> {
        self.with(|open| open.record(&Entry::Warning(warning.clone())))
    }

    /// Stores stresses along a line; a later record of the same name takes the place of an earlier one.
    ///
    /// # Errors
    /// [`ObserverError`] if the file cannot be written.
    pub fn stress(&mut self, record: &StressRecord) -> Result<(), ObserverError> {
        let model = self.stress_models.iter().find(|(n, _)| *n == record.name).and_then(|(_, m)| *m);
        self.with(|open| write_stress(&open.file, record, model))
    }

    /// Writes what is buffered, the timings and the status, and closes the file.
    ///
    /// # Errors
    /// [`ObserverError`] if the file cannot be written.
    pub fn finish(
        &mut self,
        status: Status,
        message: &str,
        timings: Option<Timings>,
    ) -> Result<(), ObserverError> {
        let seconds = self.seconds;
        self.with(|open| {
            let begin = Instant::now();
            open.write_series()?;
            if let Some(mut timings) = timings {
                // Rows were written while the run went on.
                timings.integration = (timings.integration - seconds).max(0.0);
                timings.output = seconds + begin.elapsed().as_secs_f64();
                write_timings(&open.file, &timings)?;
            }
            text_attribute(&open.file, "message", message)?;
            text_attribute(&open.file, "status", status.name())?;
            open.flush()
        })?;
        // Closed first, then cut.
        let Some(Open {
            file,
            columns,
            counts,
            pressures,
            disk_space,
            phases,
            impacts,
            trials,
            transfers,
            warnings,
            ..
        }) = self.open.take()
        else {
            return Ok(());
        };
        let end = file.size();
        drop((columns, counts, pressures, phases, impacts, trials, transfers, warnings, file));
        disk_space
            .trim(end)
            .map_err(|e| ObserverError(format!("results cannot be written: {}", error_text::of_hdf5(&e))))
    }
}

/// Keeps metadata in memory between flushes, so that what is on disk is always the state of the last flush: a full disk or
/// a killed process then costs the rows since that flush and no more. Measured: no more memory, 3 us more a row.
fn metadata_only_on_flush() -> MetadataCacheConfig {
    MetadataCacheConfig {
        evictions_enabled: false,
        incr_mode: CacheIncreaseMode::Off,
        flash_incr_mode: FlashIncreaseMode::Off,
        decr_mode: CacheDecreaseMode::Off,
        ..MetadataCacheConfig::default()
    }
}

impl Open {
    fn create(path: &Path, scenario: &Scenario, threads: usize) -> Result<Self> {
        // Version 1.8 of the format: readable everywhere, and after a crash without repair. The lock is OutputFile's.
        let file = File::with_options()
            .with_fapl(|p| p.libver_v18().file_locking(false).mdc_config(&metadata_only_on_flush()))
            .create(path)?;
        let mut disk_space = DiskSpace::new(path)?;
        disk_space.reserve(file.size(), 0)?;
        text_attribute(&file, "format", FORMAT)?;
        file.new_attr::<u32>().create("format_version")?.write_scalar(&FORMAT_VERSION)?;
        for (name, value) in provenance::attributes() {
            text_attribute(&file, name, &value)?;
        }
        file.new_attr::<u32>().create("resumptions")?.write_scalar(&0_u32)?;
        file.new_attr::<u64>().create("threads")?.write_scalar(&(threads as u64))?;
        text_attribute(&file, "title", &scenario.title)?;
        text_attribute(&file, "status", "running")?;
        text_attribute(&file, "message", "")?;
        let text = write_text(&file, "scenario", &scenario.source.resolved)?;
        text_attribute(&text, "sha256", &scenario.source.sha256)?;
        // Body files are found beside it from any folder.
        let path = std::path::absolute(&scenario.source.path);
        let path = path.as_ref().unwrap_or(&scenario.source.path);
        text_attribute(&text, "file", &path.display().to_string())?;
        text_attribute(
            &text,
            "description",
            "Scenario with overrides applied and defaults filled in, as TOML.",
        )?;
        let phases = tables::create::<PhaseRow>(&file)?;
        let impacts = tables::create::<ImpactRow>(&file)?;
        let trials = tables::create::<TrialRow>(&file)?;
        let transfers = tables::create::<TransferRow>(&file)?;
        let warnings = Table::create::<VarLenUnicode>(&file, "warnings", "", WARNINGS)?;
        file.flush()?;
        disk_space.renew();
        Ok(Self {
            file,
            contact_names: Vec::new(),
            disk_space,
            room: 0,
            columns: Vec::new(),
            counts: Vec::new(),
            pressures: Vec::new(),
            buffered: 0,
            rows: 0,
            phases,
            impacts,
            trials,
            transfers,
            warnings,
            journal: None,
            row: Row::default(),
        })
    }

    fn sample(&mut self, sample: &Sample, flush: bool) -> Result<()> {
        let Row { mut numbers, mut counts, mut pressures } = std::mem::take(&mut self.row);
        numbers.clear();
        counts.clear();
        self.columns.iter_mut().for_each(|c| c.push(sample, &mut numbers));
        self.counts.iter_mut().for_each(|c| c.push(sample, &mut counts));
        pressures.resize(self.pressures.len(), Vec::new());
        for (i, (points, series)) in pressures.iter_mut().zip(&mut self.pressures).enumerate() {
            points.clear();
            points.extend(sample.pressures.get(i).into_iter().flatten());
            series.push(points);
        }
        let entry = Entry::Row(Row { numbers, counts, pressures });
        self.note(&entry)?;
        if let Entry::Row(row) = entry {
            self.row = row; // its memory is used again
        }
        self.count_row(flush)?;
        if flush { self.flush() } else { Ok(()) }
    }

    /// Notes a record in the restart file, and puts it where it belongs.
    fn record(&mut self, entry: &Entry) -> Result<()> {
        self.note(entry)?;
        self.enter(entry)
    }

    /// Puts a record into its table; what belongs to none is left.
    fn enter(&mut self, entry: &Entry) -> Result<()> {
        match entry {
            Entry::Phase(record) => self.phases.push(PhaseRow::new(record)?),
            Entry::Impact(record) => {
                self.impacts.push(ImpactRow::new(record, &self.contact_name(record.contact))?)
            }
            Entry::Trial(record) => self.trials.push(TrialRow::new(record)?),
            Entry::Transfer(record) => {
                self.transfers.push(TransferRow::new(record, &self.contact_name(record.contact))?)
            }
            Entry::Warning(warning) => self.warnings.push(unicode(&warning.line())?),
            Entry::Header(_) | Entry::Layout(_) | Entry::Row(_) | Entry::Restart(_) | Entry::Resumed => {
                Ok(())
            }
        }
    }

    /// Name of a contact by its index.
    fn contact_name(&self, index: u32) -> String {
        let name = usize::try_from(index).ok().and_then(|i| self.contact_names.get(i)).cloned();
        name.unwrap_or_else(|| index.to_string())
    }

    fn count_row(&mut self, flush: bool) -> Result<()> {
        self.buffered += 1;
        self.rows += 1;
        if self.buffered >= ROWS || flush { self.write_series() } else { Ok(()) }
    }

    fn flush(&mut self) -> Result<()> {
        self.file.flush()?;
        self.disk_space.renew();
        Ok(())
    }

    /// Makes sure that all that is written up to the next flush has its place on the disk.
    fn reserve(&mut self) -> Result<()> {
        let pressures: u64 = self.pressures.iter().map(Pressures::bytes_needed).sum();
        self.disk_space.reserve(self.file.size(), self.room + pressures)
    }

    fn write_series(&mut self) -> Result<()> {
        self.buffered = 0;
        // Time comes first: a reader of a broken file finds no row without its time.
        self.columns.iter_mut().try_for_each(|c| c.series.write())?;
        // The lists before their lengths: no instant has more points than there are.
        self.pressures.iter_mut().try_for_each(Pressures::write)?;
        self.counts.iter_mut().try_for_each(|c| c.series.write())
    }
}

fn write_timings(file: &File, timings: &Timings) -> Result<()> {
    let group = file.create_group("timings")?;
    for Stage { name, description, seconds } in TIMINGS {
        let dataset = group.new_dataset::<f64>().create(name)?;
        dataset.write_scalar(&seconds(timings))?;
        describe(&dataset, "s", description)?;
    }
    let used = timings.cache;
    let reduction = group.dataset("reduction")?;
    reduction.new_attr::<u64>().create("fine_models")?.write_scalar(&used.fine_models)?;
    let dataset = group.new_dataset::<f64>().create("cache")?;
    dataset.write_scalar(&used.seconds)?;
    describe(&dataset, "s", "Reading and writing models that are kept between runs.")?;
    for (name, value) in [("hits", used.hits), ("misses", used.misses)] {
        dataset.new_attr::<u64>().create(name)?.write_scalar(&value)?;
    }
    Ok(())
}
