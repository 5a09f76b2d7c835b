//! A run kept in memory, for programs that look at the result themselves.

use crate::error::ObserverError;
use crate::record::warning::Warning;
use crate::record::{
    EventRecord, ImpactRecord, PeakRecord, PhaseKind, PhaseRecord, RunLayout, Sample, StressRecord,
    TransferRecord, TrialRecord,
};
use crate::state::RunState;
use crate::state::observer::{Continue, Observer};

/// An observer that keeps everything reported to it, in the order in which it came.
#[derive(Debug, Clone, Default)]
pub struct Recording {
    /// Names and numbers of the parts.
    pub layout: RunLayout,
    /// Stored states.
    pub samples: Vec<Sample>,
    /// Finished phases.
    pub phases: Vec<PhaseRecord>,
    /// Finished impacts.
    pub impacts: Vec<ImpactRecord>,
    /// What contacts did in finished phases.
    pub events: Vec<EventRecord>,
    /// Trials of impacts.
    pub trials: Vec<TrialRecord>,
    /// Changes of models.
    pub transfers: Vec<TransferRecord>,
    /// Warnings.
    pub warnings: Vec<Warning>,
    /// Stresses.
    pub stresses: Vec<StressRecord>,
    /// Largest values of joints and points.
    pub peaks: Vec<PeakRecord>,
    /// Restart points, each with [`Recording::counts`] at its time: what was reported before
    /// belongs to it.
    pub restarts: Vec<(RunState, [usize; 5])>,
    /// Leaves out coordinates of bodies and pressures of contacts, which may be many.
    pub is_brief: bool,
    /// Asks to stop at the first step that ends at or after this time \[s\].
    pub stop_at: Option<f64>,
    /// Asks to stop while a model is built after so many trials.
    pub stop_after_trials: Option<usize>,
}

impl Recording {
    /// Numbers of samples, phases, impacts, trials and transfers.
    pub fn counts(&self) -> [usize; 5] {
        let [samples, phases, impacts] = [self.samples.len(), self.phases.len(), self.impacts.len()];
        [samples, phases, impacts, self.trials.len(), self.transfers.len()]
    }

    /// Largest change of the total energy, relative to that at the start; NaN without samples.
    pub fn energy_drift(&self) -> f64 {
        let Some(first) = self.samples.first() else { return f64::NAN };
        let drifts = self.samples.iter().map(|s| (s.energies.total() / first.energies.total() - 1.0).abs());
        // `max` would drop a NaN.
        drifts.fold(0.0, |most, drift| if drift > most || drift.is_nan() { drift } else { most })
    }
}

impl Observer for Recording {
    fn start(&mut self, layout: &RunLayout) -> Result<(), ObserverError> {
        self.layout = layout.clone();
        Ok(())
    }

    fn sample(&mut self, sample: &Sample) -> Result<(), ObserverError> {
        let mut sample = sample.clone();
        if self.is_brief {
            sample.bodies.clear();
            sample.pressures.clear();
        }
        self.samples.push(sample);
        Ok(())
    }

    fn progress(&mut self, time: f64, _: f64, _: PhaseKind) -> Continue {
        if self.stop_at.is_some_and(|stop| time >= stop) { Continue::Interrupt } else { Continue::Yes }
    }

    fn is_interrupted(&mut self) -> bool {
        self.stop_after_trials.is_some_and(|n| self.trials.len() >= n)
    }

    fn phase(&mut self, record: &PhaseRecord) -> Result<(), ObserverError> {
        self.phases.push(*record);
        Ok(())
    }

    fn peaks(&mut self, _: &RunLayout, peaks: &[PeakRecord]) -> Result<(), ObserverError> {
        self.peaks = peaks.to_vec();
        Ok(())
    }

    fn impact(&mut self, record: &ImpactRecord) -> Result<(), ObserverError> {
        match self.impacts.iter_mut().rev().find(|earlier| earlier.row == record.row) {
            Some(earlier) => *earlier = *record,
            None => self.impacts.push(*record),
        }
        Ok(())
    }

    fn event(&mut self, record: &EventRecord) -> Result<(), ObserverError> {
        self.events.push(*record);
        Ok(())
    }

    fn trial(&mut self, record: &TrialRecord) -> Result<(), ObserverError> {
        self.trials.push(record.clone());
        Ok(())
    }

    fn transfer(&mut self, record: &TransferRecord) -> Result<(), ObserverError> {
        self.transfers.push(record.clone());
        Ok(())
    }

    fn restart_point(&mut self, point: &RunState) -> Result<(), ObserverError> {
        self.restarts.push((point.clone(), self.counts()));
        Ok(())
    }

    fn warning(&mut self, warning: &Warning) -> Result<(), ObserverError> {
        self.warnings.push(warning.clone());
        Ok(())
    }

    fn stress(&mut self, record: &StressRecord) -> Result<(), ObserverError> {
        self.stresses.push(record.clone());
        Ok(())
    }
}
