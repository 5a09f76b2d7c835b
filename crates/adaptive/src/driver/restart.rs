//! Where a run can be taken up again: the start of every phase, and free phases now and then.
//!
//! What the state alone does not tell is dropped there (history of the step size control, Jacobians, warm starts of contact
//! solvers and searches), by the run that goes on as by one that is taken up: both then take the same steps to the last bit.
//! Contacts are open there, or just touch, so that no friction history is lost. Within an impact there are no such places: its
//! tries hold fine models, and an impact taken up is simulated again from its start.

use std::time::Instant;

use ffr_dynamics::integration::{Integrator, OdeSystem, StepSettings};
use ffr_dynamics::system::error_scale::ErrorScale;

use super::doubts::Doubts;
use super::{Driver, NumericalDamping, crossing_search};
use crate::error::AdaptiveError;
use crate::plausibility::ledger::EnergyLedger;
use crate::record::{PhaseKind, PhaseRecord, RestartPoint};
use crate::simulation::fill_sample;
use crate::spec::PhaseSettings;

/// Steps of a free phase between restart points: a new Jacobian every so often costs less than a hundredth of them.
const STEPS: u32 = 2000;
/// Relative difference of rates up to which two models have the same coordinates. On the same machine there is none; on another
/// one, round-off enters the modes, whose signs are free: those turn rates around.
const SAME_RATES: f64 = 1e-6;

impl Driver<'_> {
    /// Begins a phase, and marks its start.
    pub(super) fn enter(&mut self, kind: PhaseKind) -> Result<(), AdaptiveError> {
        self.carried = PhaseRecord::default();
        self.before_phase = self.statistics();
        self.phase_clock = Instant::now();
        self.phase_start = self.integrator.time();
        // Another method finds a step size of its own.
        let is_same = self.integrator.method() == self.phase_settings(kind).0.method;
        self.mark(kind, if is_same { self.integrator.proposed_step() } else { 0.0 })
    }

    /// Counts a step of a free phase, and marks some.
    pub(super) fn mark_now_and_then(&mut self) -> Result<(), AdaptiveError> {
        self.unmarked += 1;
        if self.unmarked < STEPS || self.integrator.time() >= self.settings.end_time {
            return Ok(());
        }
        self.mark(PhaseKind::Free, self.integrator.proposed_step())
    }

    fn phase_settings(&self, kind: PhaseKind) -> (PhaseSettings, f64) {
        match kind {
            PhaseKind::Free => (self.settings.free, self.settings.free.max_step),
            PhaseKind::Impact => (self.settings.impact, self.impact_step),
        }
    }

    /// Reports the present state as one to take the run up from, and goes on as if that had been done.
    fn mark(&mut self, kind: PhaseKind, step: f64) -> Result<(), AdaptiveError> {
        let state = self.integrator.state().to_vec();
        let rates = self.renew(kind, (self.integrator.time(), &state), step)?;
        let point = RestartPoint {
            time: self.integrator.time(),
            state,
            rates,
            step,
            phase: self.phase_record(kind),
            n_phases: self.n_phases,
            n_impacts: self.n_impacts,
            n_refined: self.n_refined,
            last_output: self.last_output,
            next_output: self.next_output,
            removed: self.numerical.removed,
            total_energy: self.numerical.total,
            ledger_start: self.ledger.start,
            ledger: [self.ledger.scale, self.ledger.lowered],
            gaps: self.doubts.gaps.clone(),
            warned: self.doubts.given.clone(),
            knowledge: self.model.adaptive.iter().map(|(_, contact)| contact.knowledge).collect(),
            stress: self.model.stress_states(),
        };
        Ok(self.observer.restart_point(&point)?)
    }

    /// Goes on from `point`, which another run has marked.
    pub(super) fn restore(&mut self, point: &RestartPoint) -> Result<(), AdaptiveError> {
        let refuse = |reason: &str| AdaptiveError::Restart { time: point.time, reason: reason.into() };
        let fits = point.state.len() == self.interpolated.len()
            && point.knowledge.len() == self.model.adaptive.len()
            && point.gaps.len() == self.model.contacts.len()
            && self.model.set_stress_states(&point.stress);
        if !fits {
            return Err(refuse("the models have other numbers of coordinates, contacts or requests"));
        }
        for ((_, contact), knowledge) in self.model.adaptive.iter_mut().zip(&point.knowledge) {
            contact.knowledge = *knowledge;
        }
        (self.n_phases, self.n_impacts, self.n_refined) = (point.n_phases, point.n_impacts, point.n_refined);
        (self.phase_start, self.next_output) = (point.phase.start, point.next_output);
        self.numerical = NumericalDamping { removed: point.removed, total: point.total_energy };
        let [scale, lowered] = point.ledger;
        self.ledger = EnergyLedger { start: point.ledger_start, scale, lowered };
        self.doubts = Doubts { given: point.warned.clone(), gaps: point.gaps.clone() };
        // The ledger asks for the state stored last. A contact that refuses the state does so again in the first step.
        self.interpolated.copy_from_slice(&point.state);
        if self.model.system.evaluate_accelerations(point.time, &point.state).is_ok() {
            let (system, observed) = (&mut self.model.system, &self.model.observed);
            fill_sample(system, observed, point.time, &point.state, &mut self.sample);
            self.sample.energies.gravity -= self.gravity_datum;
            self.sample.energies.numerical = point.removed;
        }
        self.last_output = point.last_output;
        let rates = self.renew(point.phase.kind, (point.time, &point.state), point.step)?;
        if !are_same(&rates, &point.rates) {
            return Err(refuse(
                "the models have other coordinates, as built on another machine or by another version",
            ));
        }
        self.carried = point.phase;
        self.before_phase = self.statistics();
        self.phase_clock = Instant::now();
        Ok(())
    }

    /// A new integrator in the state `y` at time `t`, and nothing else that remembers; returns the rates.
    fn renew(
        &mut self,
        kind: PhaseKind,
        (t, y): (f64, &[f64]),
        step: f64,
    ) -> Result<Vec<f64>, AdaptiveError> {
        let (phase, max_step) = self.phase_settings(kind);
        let steps = StepSettings {
            initial_step: (step > 0.0).then_some(step),
            ..StepSettings::with_max_step(max_step)
        };
        self.earlier = self.statistics();
        self.integrator = Integrator::new(phase.method, steps, t, y, &self.model.system)
            .map_err(AdaptiveError::Dynamics)?;
        let scale = ErrorScale { relative: phase.tolerance, velocity_floor: phase.velocity_floor };
        self.model.system.set_error_scale(scale).map_err(AdaptiveError::Dynamics)?;
        self.unmarked = 0;
        self.apart_until.fill(f64::NEG_INFINITY);
        self.model.forget();
        let mut rates = vec![0.0; y.len()];
        let outcome = self.model.system.rhs(t, y, &mut rates);
        Ok(if outcome.is_ok() { rates } else { Vec::new() })
    }
}

impl Driver<'_> {
    /// Goes on in an impact with a state `y` of another size at time `t`.
    pub(super) fn resize(&mut self, t: f64, y: &[f64]) -> Result<(), AdaptiveError> {
        let (phase, max_step) = self.phase_settings(PhaseKind::Impact);
        self.earlier = self.statistics();
        let steps = StepSettings::with_max_step(max_step);
        self.integrator = Integrator::new(phase.method, steps, t, y, &self.model.system)
            .map_err(AdaptiveError::Dynamics)?;
        self.crossing = crossing_search(y.len(), self.impact_step.min(self.settings.free.max_step));
        self.interpolated.clear();
        self.interpolated.extend_from_slice(y);
        Ok(())
    }
}

/// Whether two vectors agree but for round-off.
fn are_same(a: &[f64], b: &[f64]) -> bool {
    let norm = |x: &mut dyn Iterator<Item = f64>| x.map(|v| v * v).sum::<f64>().sqrt();
    let difference = norm(&mut a.iter().zip(b).map(|(a, b)| a - b));
    a.len() == b.len() && difference <= SAME_RATES * norm(&mut b.iter().copied())
}
