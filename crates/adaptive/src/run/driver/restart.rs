//! Where a run can be taken up again: the start of every phase, and every so many steps of free
//! phases.
//!
//! All history outside of the [`RunState`] is discarded at a restart point (step size control,
//! Jacobians, warm starts of contact solvers and searches), also in the run that goes on: both then
//! take the same steps to the last bit. Contacts are open there, or just touch, so that no friction
//! history is lost. Within an impact there are no restart points: its trials hold fine models, and
//! an impact taken up is simulated again from its start.

use ffr_dynamics::integration::{Integrator, Method, OdeSystem, StepSettings};
use ffr_dynamics::system::multibody::error_scale::ErrorScale;

use super::{Driver, crossing_search};
use crate::error::{AdaptiveError, RestartFault};
use crate::record::PhaseKind;
use crate::spec::PhaseSettings;
use crate::state::RunState;
use crate::state::impact_monitor::ImpactMonitor;
use crate::state::simulation::{System, fill_sample};

/// Steps of a free phase between restart points: a new Jacobian every so often costs less than a
/// hundredth of them.
const STEPS: u32 = 2000;
/// Relative difference of rates up to which two models have the same coordinates. On the same
/// machine there is none; on another one, round-off enters the modes, whose signs are free: those
/// turn rates around.
const SAME_RATES: f64 = 1e-6;

impl Driver<'_> {
    /// Begins a phase, and marks its start.
    pub(super) fn begin_phase(&mut self, kind: PhaseKind) -> Result<(), AdaptiveError> {
        self.begin_part();
        self.work.start = self.integrator.time();
        // Another method finds a step size of its own; so does an impact, whose vibrations are
        // followed.
        let is_same = self.integrator.method() == self.method(kind) && kind == PhaseKind::Free;
        self.mark(kind, if is_same { self.integrator.proposed_step() } else { 0.0 })
    }

    /// Marks a restart point after every so many steps of a free phase.
    pub(super) fn mark_restart_point_if_due(&mut self) -> Result<(), AdaptiveError> {
        self.work.unmarked += 1;
        if self.work.unmarked < STEPS || self.integrator.time() >= self.settings.end_time {
            return Ok(());
        }
        self.mark(PhaseKind::Free, self.integrator.proposed_step())
    }

    /// Integration method of phases of the kind `kind`.
    pub(super) fn method(&self, kind: PhaseKind) -> Method {
        let (phase, _) = self.phase_settings(kind);
        phase.method.unwrap_or_else(|| default_method(kind, &self.model.system))
    }

    fn phase_settings(&self, kind: PhaseKind) -> (PhaseSettings, f64) {
        match kind {
            PhaseKind::Free => (self.settings.free, self.settings.free.max_step),
            PhaseKind::Impact => (self.settings.impact, self.impact_step),
            PhaseKind::Lasting => (self.settings.lasting, self.settings.lasting.max_step),
        }
    }

    /// Reports the present state as one to take the run up from, and goes on as if that had been
    /// done.
    fn mark(&mut self, kind: PhaseKind, step: f64) -> Result<(), AdaptiveError> {
        let (time, state) = (self.integrator.time(), self.integrator.state().to_vec());
        self.run.rates = self.renew(kind, (time, &state), step)?;
        self.run.phase = self.phase_record(kind);
        (self.run.time, self.run.state, self.run.step) = (time, state, step);
        self.run.loads = self.linear.averages();
        self.linear.begin(&self.run.loads, time);
        self.marked_hits.clone_from(&self.run.hits);
        Ok(self.output.observer.restart_point(&self.run)?)
    }

    /// Goes on from `state`, which another run has reported as a restart point.
    pub(super) fn restore(&mut self, state: &RunState) -> Result<(), AdaptiveError> {
        let (time, y) = (state.time, &state.state);
        let refuse = |fault| AdaptiveError::Restart { time, fault };
        let fits = y.len() == self.interpolated.len()
            && state.contacts.len() == self.slots.len()
            && state.hits.len() == self.stops.len()
            && state.stress.len() == self.run.stress.len();
        if !fits {
            return Err(refuse(RestartFault::OtherNumbers));
        }
        self.run.clone_from(state);
        self.linear.begin(&state.loads, time);
        self.marked_hits.clone_from(&state.hits);
        self.work.start = state.phase.start;
        for (slot, contact) in self.slots.iter_mut().zip(&state.contacts) {
            slot.monitor = ImpactMonitor::after(contact.impact);
        }
        self.restore_laws()?;
        // The ledger asks for the state stored last. A contact that refuses the state does so again
        // in the first step.
        self.interpolated.copy_from_slice(y);
        if self.model.system.evaluate_accelerations(time, y).is_ok() {
            let (system, observed) = (&mut self.model.system, &self.model.observed);
            let sample = &mut self.output.sample;
            fill_sample(system, observed, time, y, sample);
            sample.energies.gravity -= self.gravity_datum;
            sample.energies.numerical = state.numerical.removed;
        }
        let rates = self.renew(state.phase.kind, (time, y), state.step)?;
        if !are_same(&rates, &state.rates) {
            return Err(refuse(RestartFault::OtherCoordinates));
        }
        self.begin_part();
        (self.work.part.start, self.work.part.carried) = (state.phase.start, state.phase);
        Ok(())
    }

    /// A new integrator in the state `y` at time `t`, and nothing else that remembers; returns the
    /// rates.
    fn renew(
        &mut self,
        kind: PhaseKind,
        (t, y): (f64, &[f64]),
        step: f64,
    ) -> Result<Vec<f64>, AdaptiveError> {
        self.replace_integrator(kind, (t, y), step)?;
        self.work.unmarked = 0;
        if !self.is_settled_start() {
            self.model.forget();
        }
        self.forget_searches();
        let mut rates = vec![0.0; y.len()];
        let outcome = self.model.system.rhs(t, y, &mut rates);
        Ok(if outcome.is_ok() { rates } else { Vec::new() })
    }
}

impl Driver<'_> {
    /// A new integrator for phases of the kind `kind` in the state `y` at time `t`; its first step is to be `step`, 0 if that is not known.
    pub(super) fn replace_integrator(
        &mut self,
        kind: PhaseKind,
        (t, y): (f64, &[f64]),
        step: f64,
    ) -> Result<(), AdaptiveError> {
        let (phase, max_step) = self.phase_settings(kind);
        let steps = StepSettings {
            initial_step: (step > 0.0).then_some(step),
            is_vibration_exact: kind == PhaseKind::Free,
            ..StepSettings::with_max_step(max_step)
        };
        self.work.replaced = self.statistics();
        let method = self.method(kind);
        self.integrator =
            Integrator::new(method, steps, t, y, &self.model.system).map_err(AdaptiveError::Dynamics)?;
        let relative = phase.permitted_error(method);
        let scale = ErrorScale { relative, velocity_floor: phase.velocity_floor };
        self.model.system.set_error_scale(scale).map_err(AdaptiveError::Dynamics)
    }

    /// Goes on in an impact with a state `y` of another size at time `t`.
    pub(super) fn resize(&mut self, t: f64, y: &[f64]) -> Result<(), AdaptiveError> {
        self.replace_integrator(PhaseKind::Impact, (t, y), 0.0)?;
        self.crossing = crossing_search(y.len(), self.impact_step.min(self.settings.free.max_step));
        self.interpolated.clear();
        self.interpolated.extend_from_slice(y);
        Ok(())
    }
}

/// Method for `system` in phases of the kind `kind` unless another is asked for.
pub(super) fn default_method(kind: PhaseKind, system: &System) -> Method {
    let n_modes: usize = system.model().bodies.iter().map(|b| b.data.n_modes()).sum();
    // The explicit method takes these from their closed form.
    let n_alone = system.oscillators().list.len();
    match kind {
        PhaseKind::Free if n_alone < n_modes => Method::Gauss,
        PhaseKind::Free | PhaseKind::Impact => Method::DormandPrince,
        PhaseKind::Lasting => Method::Esdirk4,
    }
}

/// Whether two vectors agree but for round-off.
fn are_same(a: &[f64], b: &[f64]) -> bool {
    let norm = |x: &mut dyn Iterator<Item = f64>| x.map(|v| v * v).sum::<f64>().sqrt();
    let difference = norm(&mut a.iter().zip(b).map(|(a, b)| a - b));
    a.len() == b.len() && difference <= SAME_RATES * norm(&mut b.iter().copied())
}
