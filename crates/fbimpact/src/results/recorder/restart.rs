//! The recorder's side of the restart file: everything stored is noted there, and a run taken up
//! begins with what it holds.

use std::sync::Arc;

use adaptive::state::RunState;

use super::super::fault::RecordingFault;
use super::super::journal::{Entries, Entry, Journal, Restart};
use super::{Open, Recorded, Recorder};

impl Recorder {
    /// Keeps everything in `journal`, too, from which the run can be taken up.
    pub fn keep(&mut self, journal: Journal) {
        if let Some(open) = &mut self.open {
            open.journal = Some(journal);
        }
    }

    /// Begins with what the run that is taken up at `restart` has reported up to there, and goes on
    /// in its restart file.
    ///
    /// # Errors
    /// [`RecordingFault`] if one of the files cannot be written.
    pub fn take_up(&mut self, restart: Restart) -> Result<(), Arc<RecordingFault>> {
        let count = restart.resumptions + 1;
        self.keep(restart.go_on().map_err(RecordingFault::GoOn)?);
        (self.restart, self.is_taken_up) = (Some(restart), true);
        self.with(|open| Ok(open.file.attr("resumptions")?.write_scalar(&count)?))
    }

    /// Whether this run was taken up.
    pub fn is_taken_up(&self) -> bool {
        self.is_taken_up
    }

    /// Keeps a state from which the run can be taken up.
    ///
    /// # Errors
    /// [`RecordingFault`] if the restart file cannot be written.
    pub fn restart_point(&mut self, point: &RunState) -> Result<(), Arc<RecordingFault>> {
        self.with(|open| {
            open.note(&Entry::Restart(Box::new(point.clone())))?;
            open.journal.as_mut().map_or(Ok(()), |j| j.flush().map_err(RecordingFault::Restart))
        })
    }
}

impl Open {
    /// Appends a record to the restart file, if there is one.
    pub(super) fn note(&mut self, entry: &Entry) -> Recorded<()> {
        self.journal.as_mut().map_or(Ok(()), |j| j.append(entry).map_err(RecordingFault::Restart))
    }

    /// How many numbers each row of every series has.
    pub(super) fn widths(&self) -> Vec<u64> {
        let columns = self.columns.iter().map(|c| c.series.width() as u64);
        let counts = self.counts.iter().map(|c| c.series.width() as u64);
        columns.chain(counts).chain([self.contacts.len() as u64]).collect()
    }

    /// Writes what the restart file holds up to the restart point.
    pub(super) fn replay(&mut self, restart: &Restart) -> Recorded<()> {
        let mut entries = Entries::open(&restart.path).map_err(RecordingFault::Reread)?;
        while entries.position() < restart.length {
            match entries.next_entry().map_err(RecordingFault::Reread)?.ok_or(RecordingFault::OtherRun)? {
                Entry::Layout(widths) if widths != self.widths() => return Err(RecordingFault::OtherRun),
                Entry::Row(row) => {
                    let (mut numbers, mut counts) = (row.numbers.as_slice(), row.counts.as_slice());
                    let is_whole = self.columns.iter_mut().all(|c| c.push_row(&mut numbers))
                        && self.counts.iter_mut().all(|c| c.push_row(&mut counts))
                        && self.push_contacts(&row.contacts)?;
                    if !is_whole || !numbers.is_empty() || !counts.is_empty() {
                        return Err(RecordingFault::OtherRun);
                    }
                    self.count_row(false)?;
                    if self.buffered == 0 {
                        // Room is kept for what is written between two flushes.
                        self.flush()?;
                        self.reserve()?;
                    }
                }
                entry => self.enter(&entry)?,
            }
        }
        self.write_series()?;
        Ok(self.flush()?)
    }
}
