//! States of a run on their way to the output: when they are due, and what is noted of them.

use ffr_dynamics::integration::{DenseOutput, OdeSystem, Step};

use super::Driver;
use crate::error::AdaptiveError;
use crate::model::RunModel;
use crate::record::PhaseKind;
use crate::spec::Start;
use crate::state::simulation::{fill_places, fill_sample};

impl Driver<'_> {
    /// Stores the states due up to time `t` of the last step.
    pub(super) fn store_until(&mut self, t: f64) -> Result<(), AdaptiveError> {
        let of_hits = self.interval_of_hits(self.integrator.interval());
        if let Some(interval) = of_hits {
            let first = self.integrator.interval().0 + interval;
            self.run.next_output = self.run.next_output.min(first);
        }
        while self.run.next_output <= t {
            self.integrator.interpolate(self.run.next_output, &mut self.interpolated);
            self.evaluate(self.run.next_output)?;
            self.report(self.run.next_output)?;
            self.note_gaps(self.run.next_output)?;
            self.watch(self.run.next_output, PhaseKind::Free)?;
            let stretched = self.settings.free_share * (self.run.next_output - self.work.start);
            let interval = self.run.free_interval.max(stretched);
            self.run.next_output += of_hits.map_or(interval, |of_hits| of_hits.min(interval));
        }
        Ok(())
    }

    /// Whether the run is at its start and bodies may overlap there, or are pressed together: then the
    /// trials of the impact that it begins with store that instant.
    pub(super) fn begins_with_overlap(&self) -> bool {
        let may_overlap = || self.model.contacts.iter().any(|c| c.allowed_overlap > 0.0);
        self.integrator.time() <= 0.0 && (self.settings.start == Start::Static || may_overlap())
    }

    /// Notes the present state without storing it.
    pub(super) fn note(&mut self) -> Result<(), AdaptiveError> {
        self.interpolated.copy_from_slice(self.integrator.state());
        let t = self.integrator.time();
        self.evaluate(t)?;
        self.local_deformation.begin(t, self.model.observed.points.len());
        self.fill(t);
        self.check_ledger()
    }

    /// Stores the present state.
    pub(super) fn store(&mut self) -> Result<(), AdaptiveError> {
        self.note()?;
        self.send()
    }

    /// Notes the state at the end of the step of an impact just accepted, which the forces were
    /// evaluated at last, and stores it if that is due.
    pub(super) fn store_step(&mut self) -> Result<(), AdaptiveError> {
        self.interpolated.copy_from_slice(self.integrator.state());
        let t = self.integrator.time();
        self.fill(t);
        self.keep_energy();
        if t >= self.next_state() {
            self.send()?;
        }
        self.watch(t, self.pace.kind())?;
        self.check_ledger()
    }

    /// When the next state of an impact is to be stored.
    fn next_state(&self) -> f64 {
        let Self { run, settings, .. } = self;
        let least = match self.pace.kind() {
            PhaseKind::Lasting => settings.impact_interval.max(run.free_interval),
            PhaseKind::Free | PhaseKind::Impact => settings.impact_interval,
        };
        // A share of the time since the start of the phase at its own end.
        let stretched =
            settings.phase_share * (run.last_output - self.work.start) / (1.0 - settings.phase_share);
        run.last_output + least.max(stretched)
    }

    /// Stores the states due in the implicit step of a lasting contact just accepted, and notes that at its end, which the forces were
    /// evaluated at last.
    pub(super) fn store_lasting(&mut self, step: Step) -> Result<(), AdaptiveError> {
        self.pace.passed();
        let mut due = self.next_state();
        if due < step.end {
            // Within the step forces are those of its start, friction's memory among it.
            self.model.system.restore();
            while due < step.end {
                self.integrator.interpolate(due, &mut self.interpolated);
                self.evaluate(due)?;
                self.fill(due);
                self.send()?;
                self.watch(due, PhaseKind::Lasting)?;
                self.check_ledger()?;
                due = self.next_state();
            }
            self.interpolated.copy_from_slice(self.integrator.state());
            self.evaluate(step.end)?;
        }
        self.store_step()
    }

    /// Stores the state noted last, if that has not been done.
    pub(super) fn store_noted(&mut self) -> Result<(), AdaptiveError> {
        if self.output.is_noted { self.send() } else { Ok(()) }
    }

    /// Evaluates forces and accelerations in the state `interpolated` at time `t`.
    pub(super) fn evaluate(&mut self, t: f64) -> Result<(), AdaptiveError> {
        let outcome = self.model.system.evaluate_accelerations(t, &self.interpolated);
        outcome.map_err(|refusal| AdaptiveError::refused(t, refusal))
    }

    /// Reports the state `interpolated` at time `t`, which the forces were evaluated at last.
    pub(super) fn report(&mut self, t: f64) -> Result<(), AdaptiveError> {
        // Outside of impacts no contact force acts; what acts at the start of the run has no past.
        self.local_deformation.begin(t, self.model.observed.points.len());
        self.fill(t);
        self.send()?;
        self.check_ledger()
    }

    /// Notes the state `interpolated` at time `t`, which the forces were evaluated at last.
    pub(super) fn fill(&mut self, t: f64) {
        let RunModel { system, observed, .. } = &mut *self.model;
        fill_sample(system, observed, t, &self.interpolated, &mut self.output.sample);
        self.measure_dents(t);
        let RunModel { system, observed, .. } = &*self.model;
        let sample = &mut self.output.sample;
        self.local_deformation.add_to(&mut sample.points, &observed.points, system.last_evaluation().0);
        self.run.peaks.note(t, sample);
        sample.phase = self.run.n_phases;
        if !self.settings.pressure {
            sample.pressures.clear();
        }
        sample.energies.gravity -= self.gravity_datum;
        let is_dissipative = self.integrator.method().is_dissipative();
        self.run.numerical.record(&mut sample.energies, is_dissipative);
        self.imbalance = self.run.ledger.record(&sample.energies);
        self.output.is_noted = true;
    }

    /// Takes a force-free step to `end` at most, and fills in joints and points at its end for
    /// [`Driver::note_peaks`].
    pub(super) fn free_step(&mut self, end: f64) -> Result<Step, AdaptiveError> {
        let RunModel { system, observed, .. } = &mut *self.model;
        let step = self.integrator.step(system, end).map_err(AdaptiveError::Dynamics)?;
        fill_places(system, observed, step.end, self.integrator.state(), &mut self.output.sample);
        Ok(step)
    }

    /// Notes what is largest at the end of the force-free step just taken.
    pub(super) fn note_peaks(&mut self) {
        self.run.peaks.note(self.integrator.time(), &self.output.sample);
    }

    /// Takes the dents at observed points at time `t`, which the forces were evaluated at last.
    pub(super) fn measure_dents(&mut self, t: f64) {
        let RunModel { system, observed, contacts, .. } = &*self.model;
        if !observed.points.is_empty() {
            let slots = &self.slots;
            self.local_deformation.update(t, system, |i| slots[i].fine(), |i| contacts[i].loads_interface);
        }
    }

    /// Reports the state noted last.
    pub(super) fn send(&mut self) -> Result<(), AdaptiveError> {
        self.run.last_output = self.output.sample.time;
        self.output.send()
    }
}
