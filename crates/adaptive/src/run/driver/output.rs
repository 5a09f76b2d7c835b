//! What a run reports: states as they are reached, and within impacts only those of the trial that
//! is accepted.

use crate::error::AdaptiveError;
use crate::record::{ImpactRecord, PhaseRecord, Sample, TransferRecord};
use crate::state::observer::Observer;

/// Reports to the observer, at once or when a trial is accepted.
pub(super) struct Output<'a> {
    /// Receives the run.
    pub observer: &'a mut dyn Observer,
    /// The state noted last.
    pub sample: Sample,
    /// Whether it waits to be stored.
    pub is_noted: bool,
    /// States and changes of the model that wait for the trial to be accepted.
    pending: Vec<Pending>,
    /// Hits of stops that wait to be reported.
    hits: Vec<ImpactRecord>,
    is_buffering: bool,
}

/// What is reported once a trial is accepted.
enum Pending {
    /// A stored state.
    Sample(Box<Sample>),
    /// A change of the model.
    Transfer(Box<TransferRecord>),
    /// A part of the phase, which is over.
    Phase(PhaseRecord),
}

impl<'a> Output<'a> {
    /// Reports to `observer`.
    pub fn new(observer: &'a mut dyn Observer) -> Self {
        Self {
            observer,
            sample: Sample::default(),
            is_noted: false,
            pending: Vec::new(),
            hits: Vec::new(),
            is_buffering: false,
        }
    }

    /// Keeps states back from now on, if `is_buffering`, until [`Output::flush`].
    pub fn buffer(&mut self, is_buffering: bool) {
        self.is_buffering = is_buffering;
    }

    /// Reports the state noted last.
    ///
    /// # Errors
    /// [`AdaptiveError::Observer`].
    pub fn send(&mut self) -> Result<(), AdaptiveError> {
        self.is_noted = false;
        if self.is_buffering {
            self.pending.push(Pending::Sample(Box::new(self.sample.clone())));
            return Ok(());
        }
        Ok(self.observer.sample(&self.sample)?)
    }

    /// Reports the hit of a stop later.
    pub fn hit(&mut self, record: ImpactRecord) {
        self.hits.push(record);
    }

    /// Forgets the hits of a trial.
    pub fn discard_hits(&mut self) {
        self.hits.clear();
    }

    /// Reports the hits that waited, in rows from `next` on, and how many these are.
    ///
    /// # Errors
    /// [`AdaptiveError::Observer`].
    pub fn send_hits(&mut self, next: u32) -> Result<u32, AdaptiveError> {
        let n = self.hits.len() as u32;
        for (row, hit) in (next..).zip(self.hits.drain(..)) {
            self.observer.impact(&ImpactRecord { row, ..hit })?;
        }
        Ok(n)
    }

    /// Reports a change of the model when the trial is accepted.
    pub fn transfer(&mut self, record: TransferRecord) {
        self.pending.push(Pending::Transfer(Box::new(record)));
    }

    /// Reports a part of the running phase, at once or when the trial is accepted.
    ///
    /// # Errors
    /// [`AdaptiveError::Observer`].
    pub fn phase(&mut self, record: PhaseRecord) -> Result<(), AdaptiveError> {
        if self.is_buffering {
            self.pending.push(Pending::Phase(record));
            return Ok(());
        }
        Ok(self.observer.phase(&record)?)
    }

    /// Forgets what a trial would have reported; changes of the model up to the time `start` stay,
    /// for fine models that stay keep the record of their coming.
    pub fn discard_after(&mut self, start: f64) {
        self.pending.retain(|p| matches!(p, Pending::Transfer(r) if r.time <= start));
    }

    /// Forgets the changes of the model by contact `i`.
    pub fn discard_transfers_of(&mut self, i: usize) {
        self.pending.retain(|p| !matches!(p, Pending::Transfer(r) if r.contact as usize == i));
    }

    /// Reports what waited.
    ///
    /// # Errors
    /// [`AdaptiveError::Observer`].
    pub fn flush(&mut self) -> Result<(), AdaptiveError> {
        self.is_buffering = false;
        for pending in self.pending.drain(..) {
            match pending {
                Pending::Sample(sample) => self.observer.sample(&sample)?,
                Pending::Transfer(record) => self.observer.transfer(&record)?,
                Pending::Phase(record) => self.observer.phase(&record)?,
            }
        }
        Ok(())
    }
}
