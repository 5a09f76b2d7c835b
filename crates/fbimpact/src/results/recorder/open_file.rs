//! The result file while it is open: datasets, buffers, and the record of each in the restart file.

use std::path::Path;

use adaptive::record::{PeakOf, PeakRecord, RunLayout, Sample, Timings};
use hdf5::File;
use hdf5::plist::file_access::{
    CacheDecreaseMode, CacheIncreaseMode, FlashIncreaseMode, MetadataCacheConfig,
};
use hdf5::types::VarLenUnicode;
use result_files::dataset::{Table, describe, text_attribute, unicode, write_text};
use result_files::file::fault::{Access, FileFault};
use result_files::stored::open::{FORMAT, FORMAT_VERSION, INPUTS};
use result_files::stored::peak::{QUANTITIES, SeriesPeak, write_peak};
use result_files::tables::{self, EventRow, ImpactRow, PhaseRow, TransferRow, TrialRow};

use super::super::columns::{Axes, Column, Stage, TIMINGS};
use super::super::disk_space::DiskSpace;
use super::super::fault::RecordingFault;
use super::super::journal::{ContactRow, Entry, Journal, Row};
use super::super::rows;
use super::super::series::half_node;
use super::contacts::Contacts;
use super::{DATASETS_PER_GROUP, FileForm, Recorded, WARNINGS};
use crate::process::provenance;
use crate::scenario::Scenario;

/// Handles of an open file.
pub(super) struct Open {
    pub(super) file: File,
    pub(super) columns: Vec<Column<f64>>,
    pub(super) counts: Vec<Column<u32>>,
    pub(super) contacts: Contacts,
    /// What the axes of all series are; none before they are there.
    pub(super) axes: Option<Axes>,
    /// Names of the contacts.
    pub(super) contact_names: Vec<String>,
    pub(super) disk_space: DiskSpace,
    /// Bytes that the series may take between two flushes.
    pub(super) room: u64,
    pub(super) buffered: usize,
    /// Rows after which the buffers are written.
    pub(super) block: usize,
    pub(super) rows: usize,
    pub(super) phases: Table,
    pub(super) impacts: Table,
    pub(super) events: Table,
    pub(super) trials: Table,
    pub(super) transfers: Table,
    pub(super) warnings: Table,
    pub(super) journal: Option<Journal>,
    /// The row stored last.
    pub(super) row: Row,
}

/// Keeps metadata in memory between flushes, so that what is on disk is always the state of the
/// last flush: a full disk or a killed process then costs the rows since that flush and no more.
/// Measured: no more memory, 3 us more per row.
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
    pub(super) fn create(
        path: &Path,
        scenario: &Scenario,
        form: FileForm,
        threads: usize,
    ) -> Result<Self, FileFault> {
        // Version 1.8 of the format: readable everywhere, and after a crash without repair. The
        // lock is OutputFile's.
        let bodies = if form.arrays { 0 } else { scenario.run.bodies.len() };
        let groups = bodies + scenario.run.contacts.len();
        let file = File::with_options()
            .with_fapl(|p| p.libver_v18().file_locking(false).mdc_config(&metadata_only_on_flush()))
            .with_fcpl(|p| p.istore_k(half_node(DATASETS_PER_GROUP * groups)))
            .create(path)
            .map_err(FileFault::unwritten)?;
        let disk_space = DiskSpace::new(path).and_then(|mut space| {
            space.reserve(file.size(), 0)?;
            Ok(space)
        });
        let disk_space = disk_space.map_err(|e| FileFault::system(Access::Write, e))?;
        Self::begin(file, disk_space, scenario, threads).map_err(FileFault::unwritten)
    }

    /// Writes what is known of the run before it begins.
    fn begin(
        file: File,
        mut disk_space: DiskSpace,
        scenario: &Scenario,
        threads: usize,
    ) -> hdf5::Result<Self> {
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
        text_attribute(&text, INPUTS, &scenario.source.inputs_sha256)?;
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
        let events = tables::create::<EventRow>(&file)?;
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
            contacts: Contacts::default(),
            axes: None,
            buffered: 0,
            block: 1,
            rows: 0,
            phases,
            impacts,
            events,
            trials,
            transfers,
            warnings,
            journal: None,
            row: Row::default(),
        })
    }

    /// Closes the file, then cuts it to its length.
    pub(super) fn close(self) -> Recorded<()> {
        let Self {
            file,
            columns,
            counts,
            contacts,
            axes,
            mut disk_space,
            phases,
            impacts,
            events,
            trials,
            transfers,
            warnings,
            ..
        } = self;
        drop((columns, counts, contacts, axes, phases, impacts, events, trials, transfers, warnings, file));
        disk_space.trim().map_err(RecordingFault::Space)
    }

    pub(super) fn sample(&mut self, sample: &Sample, flush: bool) -> Recorded<()> {
        let Row { mut numbers, mut counts, .. } = std::mem::take(&mut self.row);
        numbers.clear();
        counts.clear();
        self.columns.iter_mut().for_each(|c| c.push(sample, &mut numbers));
        self.counts.iter_mut().for_each(|c| c.push(sample, &mut counts));
        let entry = Entry::Row(Row { numbers, counts, contacts: self.contacts.changed(sample) });
        self.note(&entry)?;
        if let Entry::Row(row) = entry {
            self.push_contacts(&row.contacts)?;
            self.row = row; // its memory is used again
        }
        self.count_row(flush)?;
        if flush { Ok(self.flush()?) } else { Ok(()) }
    }

    /// Buffers the rows of contacts that have changed; false if one fits none.
    pub(super) fn push_contacts(&mut self, rows: &[ContactRow]) -> Recorded<bool> {
        let Some(axes) = &self.axes else { return Ok(rows.is_empty()) };
        self.contacts.push(&self.file, &mut self.disk_space, axes, rows)
    }

    /// Notes a record in the restart file, and puts it where it belongs.
    pub(super) fn record(&mut self, entry: &Entry) -> Recorded<()> {
        self.note(entry)?;
        Ok(self.enter(entry)?)
    }

    /// Puts a record into its table; what belongs to none is left.
    pub(super) fn enter(&mut self, entry: &Entry) -> hdf5::Result<()> {
        match entry {
            Entry::Phase(record) => self.phases.push(rows::phase(record)?),
            Entry::Impact(record) => {
                let row = rows::impact(record, &self.contact_name(record.contact))?;
                self.impacts.put(record.row as usize, row)
            }
            Entry::Event(record) => {
                self.events.push(rows::event(record, &self.contact_name(record.contact))?)
            }
            Entry::Trial(record) => self.trials.push(rows::trial(record)?),
            Entry::Transfer(record) => {
                self.transfers.push(rows::transfer(record, &self.contact_name(record.contact))?)
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

    pub(super) fn count_row(&mut self, flush: bool) -> hdf5::Result<()> {
        self.buffered += 1;
        self.rows += 1;
        if self.buffered >= self.block || flush { self.write_series() } else { Ok(()) }
    }

    pub(super) fn flush(&mut self) -> hdf5::Result<()> {
        self.file.flush()?;
        self.disk_space.renew();
        Ok(())
    }

    /// Makes sure that all that is written up to the next flush has its place on the disk.
    pub(super) fn reserve(&mut self) -> Recorded<()> {
        let bytes = self.room + self.contacts.bytes_needed();
        let reserved = self.disk_space.reserve(self.file.size(), bytes);
        reserved.map_err(RecordingFault::Space)
    }

    pub(super) fn write_series(&mut self) -> hdf5::Result<()> {
        self.buffered = 0;
        // Time comes first: a reader of a broken file finds no row without its time.
        self.columns.iter_mut().try_for_each(|c| c.series.write())?;
        self.contacts.write()?;
        self.counts.iter_mut().try_for_each(|c| c.series.write())
    }
}

/// Writes the largest values of joints and points as attributes of the datasets that are there; those of
/// a run that is taken up again replace earlier ones.
pub(super) fn write_peaks(file: &File, layout: &RunLayout, peaks: &[PeakRecord]) -> hdf5::Result<()> {
    for peak in peaks {
        let index = peak.index as usize;
        let (name, quantity) = match peak.of {
            PeakOf::ReactionForce => (layout.joints.get(index).map(|j| &j.name), &QUANTITIES[0]),
            PeakOf::ReactionMoment => (layout.joints.get(index).map(|j| &j.name), &QUANTITIES[1]),
            PeakOf::Displacement => (layout.points.get(index).map(|p| &p.name), &QUANTITIES[2]),
            PeakOf::Speed => (layout.points.get(index).map(|p| &p.name), &QUANTITIES[3]),
            PeakOf::VonMises => (layout.points.get(index).map(|p| &p.name), &QUANTITIES[4]),
        };
        let group = name.map(|name| format!("{}/{name}", quantity.group));
        let Some(group) = group.filter(|path| file.link_exists(path)) else { continue };
        let group = file.group(&group)?;
        if group.link_exists(quantity.series) {
            let (band, note) = (peak.band.band, peak.band.note().to_owned());
            let peak = SeriesPeak { value: peak.value, time: peak.time, band, note };
            write_peak(&group.dataset(quantity.series)?, &peak)?;
        }
    }
    Ok(())
}

/// Writes the wall seconds of the stages.
pub(super) fn write_timings(file: &File, timings: &Timings) -> hdf5::Result<()> {
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
