//! The seam through which a run reports while it goes on.
//!
//! The driver calls an [`Observer`]; writing files, drawing progress and stopping on a signal are
//! the observer's business.

use crate::error::ObserverError;
use crate::record::warning::Warning;
use crate::record::{
    EventRecord, ImpactRecord, PeakRecord, PhaseKind, PhaseRecord, RunLayout, Sample, StressRecord,
    TransferRecord, TrialRecord,
};
use crate::state::RunState;

/// The answer of an observer to a sample: whether the run goes on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Continue {
    /// Go on.
    Yes,
    /// Stop after this step, for the user asked for it.
    Interrupt,
}

/// The work that a run is doing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage<'a> {
    /// Chooses meshes and numbers of modes.
    Sizes,
    /// Builds the models of all bodies.
    Bodies,
    /// Builds fine models for a contact.
    FineModels {
        /// Name of the contact.
        contact: &'a str,
        /// Name of the contact body.
        body: &'a str,
        /// Name of the target; none on a plane.
        target: Option<&'a str>,
    },
    /// Makes time steps.
    Motion,
}

/// Receives a run as it goes on.
pub trait Observer {
    /// Called before work that takes no time steps and may take long, and with [`Stage::Motion`]
    /// after it.
    fn stage(&mut self, _stage: Stage<'_>) {}

    /// Called once before the first sample.
    ///
    /// # Errors
    /// [`ObserverError`] ends the run.
    fn start(&mut self, layout: &RunLayout) -> Result<(), ObserverError>;

    /// Called at every stored instant.
    ///
    /// # Errors
    /// [`ObserverError`] ends the run.
    fn sample(&mut self, sample: &Sample) -> Result<(), ObserverError>;

    /// Called after every accepted step, stored or not, with the time reached and the step size;
    /// cheap.
    fn progress(&mut self, time: f64, step: f64, phase: PhaseKind) -> Continue;

    /// Asked between the stages of work that takes no time steps, such as building a fine model:
    /// whether the user wants the run to stop. Cheap.
    fn is_interrupted(&mut self) -> bool {
        false
    }

    /// Called at the end of every phase.
    ///
    /// # Errors
    /// [`ObserverError`] ends the run.
    fn phase(&mut self, record: &PhaseRecord) -> Result<(), ObserverError>;

    /// Called at the end of every impact, and again with the same row if another touch joins it.
    ///
    /// # Errors
    /// [`ObserverError`] ends the run.
    fn impact(&mut self, record: &ImpactRecord) -> Result<(), ObserverError>;

    /// Called with what contacts did in a phase at the end of it, in the order of time.
    ///
    /// # Errors
    /// [`ObserverError`] ends the run.
    fn event(&mut self, record: &EventRecord) -> Result<(), ObserverError>;

    /// Called at the end of every trial.
    ///
    /// # Errors
    /// [`ObserverError`] ends the run.
    fn trial(&mut self, record: &TrialRecord) -> Result<(), ObserverError>;

    /// Called after every change of the model.
    ///
    /// # Errors
    /// [`ObserverError`] ends the run.
    fn transfer(&mut self, record: &TransferRecord) -> Result<(), ObserverError>;

    /// Called at states from which the run can be taken up again; everything reported before
    /// belongs to it, nothing reported later.
    ///
    /// # Errors
    /// [`ObserverError`] ends the run.
    fn restart_point(&mut self, _state: &RunState) -> Result<(), ObserverError> {
        Ok(())
    }

    /// Called at every warning, once for a kind and a subject.
    ///
    /// # Errors
    /// [`ObserverError`] ends the run.
    fn warning(&mut self, _warning: &Warning) -> Result<(), ObserverError> {
        Ok(())
    }

    /// Called at the end of the run with the largest values of the joints and points of `layout`.
    ///
    /// # Errors
    /// [`ObserverError`] ends the run.
    fn peaks(&mut self, _layout: &RunLayout, _peaks: &[PeakRecord]) -> Result<(), ObserverError> {
        Ok(())
    }

    /// Called when a stress request has been evaluated.
    ///
    /// # Errors
    /// [`ObserverError`] ends the run.
    fn stress(&mut self, record: &StressRecord) -> Result<(), ObserverError>;
}
