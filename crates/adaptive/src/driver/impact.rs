//! Impact phases: tries, each from the same start, until every fine model and penalty factor is acceptable (\[A\] Fig. 2).

use std::time::Instant;

use cpu_time::ProcessTime;
use ffr_dynamics::error::FailureKind;

use super::judgement::{Intervals, Judgement};
use super::{Driver, NumericalDamping, QUIET_STEPS};
use crate::adaptive_contact::FineContact;
use crate::error::AdaptiveError;
use crate::impact_watch::ImpactWatch;
use crate::interval::IntervalAssessment;
use crate::plausibility::ledger::EnergyLedger;
use crate::record::{Continue, PhaseKind, Sample, StressState, TransferRecord};

/// Most tries of one impact: widths change by half at least each time, penalty factors by a factor of ten.
const MAX_TRIES: u32 = 40;
/// Where all tries of an impact start.
pub(super) struct Start {
    pub time: f64,
    pub state: Vec<f64>,
    pub watches: Vec<ImpactWatch>,
    pub stress: Vec<Option<StressState>>,
    pub numerical: NumericalDamping,
    pub ledger: EnergyLedger,
}

/// How an attempt at an impact ended.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Ending {
    /// All contacts are open for good, or the simulated time is up.
    Complete,
    /// The observer asked to stop.
    Interrupted,
    /// An interval of an adaptive contact turned out too small.
    EdgeTouched(usize),
    /// The steps of a trial have passed.
    TrialPassed,
    /// The contact solver failed.
    SolverFailed {
        /// What went wrong.
        failure: FailureKind,
        /// Text for the log.
        reason: String,
    },
}

/// Counters of one try.
pub(super) struct Attempt {
    pub started: Instant,
    /// Processor time at the start; `None` where the system does not tell.
    pub processor: Option<ProcessTime>,
    pub steps: u64,
    pub rejected: u64,
    pub contact_steps: usize,
    /// Stop after so many steps with contact.
    pub trial: Option<usize>,
    pub most_active: Vec<u32>,
    pub last_force: f64,
    pub penalty_start: Vec<f64>,
}

/// Overlap without force, as a share of the interval, that shows that its points missed the contact: far above what the
/// detection of the touch leaves, far below what elastic bodies that touch come closer by.
const MISSED: f64 = 1e-4;

impl Driver<'_> {
    /// Simulates an impact from the present state until every contact has been open for the quiet time; returns whether the
    /// observer stopped the run.
    pub(super) fn impact_phase(&mut self) -> Result<bool, AdaptiveError> {
        let start = Start {
            time: self.integrator.time(),
            state: self.integrator.state().to_vec(),
            watches: self.watches.clone(),
            stress: self.model.stress_states(),
            numerical: self.numerical,
            ledger: self.ledger,
        };
        self.is_buffering = !self.model.adaptive.is_empty();
        let mut intervals = Intervals::new(self.watches.len());
        self.previews.fill(None);
        self.searches.fill(None);
        let touching = self.touching()?;
        self.preview(&touching)?;
        let mut models = self.wake_touching(&intervals.widths);
        let mut trial = self.restart_searches();
        for number in 1..=MAX_TRIES {
            let mut attempt = self.begin(trial);
            let built = std::mem::replace(&mut models, Ok(()));
            let ending = match built.and_then(|()| self.simulate(&mut attempt, &intervals.widths)) {
                Ok(ending) => ending,
                Err(AdaptiveError::Interrupted) => Ending::Interrupted,
                Err(error) => return self.fail(&attempt, number, &[], error),
            };
            let verdicts = self.assess(&ending);
            let judgement = match self.judge(&ending, &verdicts, &mut intervals, number) {
                Ok(judgement) => judgement,
                Err(error) => return self.fail(&attempt, number, &verdicts, error),
            };
            match judgement {
                Judgement::Accept { reason } => {
                    let outcome = if ending == Ending::Interrupted { "interrupted" } else { "accepted" };
                    self.log(&attempt, number, outcome, &reason, &verdicts)?;
                    self.learn(&verdicts);
                    self.finish()?;
                    return Ok(ending == Ending::Interrupted);
                }
                Judgement::Again { reason, trial: next } => {
                    self.log(&attempt, number, "rejected", &reason, &verdicts)?;
                    trial = next;
                    if number < MAX_TRIES {
                        models = self.rewind(&start, &intervals.widths);
                    }
                }
            }
        }
        self.flush()?;
        Err(self.no_model(intervals.latest, MAX_TRIES))
    }

    /// Reports a try that ends the run, with what it computed, and passes `error` on.
    fn fail(
        &mut self,
        attempt: &Attempt,
        number: u32,
        verdicts: &[Option<IntervalAssessment>],
        error: AdaptiveError,
    ) -> Result<bool, AdaptiveError> {
        self.log(attempt, number, "failed", &error.to_string(), verdicts)?;
        self.store_noted()?;
        self.flush()?;
        Err(error)
    }

    fn begin(&mut self, trial: Option<usize>) -> Attempt {
        self.fine.iter_mut().flatten().for_each(FineContact::clear);
        // Stored before the impact; states of a try given up do not count.
        (self.last_output, self.is_noted) = (self.integrator.time(), false);
        self.lowered = None;
        if self.integrator.time() <= 0.0 && self.model.contacts.iter().any(|c| c.allowed_overlap > 0.0) {
            // The energy of an overlap that is allowed is there from the start.
            self.ledger.start = None;
        }
        self.dents.begin(self.integrator.time(), self.model.observed.points.len());
        let statistics = self.statistics();
        let penalties = self.model.system.forces().iter().map(|f| f.contact.penalty());
        Attempt {
            started: Instant::now(),
            processor: ProcessTime::try_now().ok(),
            steps: statistics.steps,
            rejected: statistics.rejected,
            contact_steps: 0,
            trial,
            most_active: vec![0; self.watches.len()],
            last_force: self.integrator.time(),
            penalty_start: penalties.collect(),
        }
    }

    /// Integrates until the impact is over or the attempt is known to be in vain.
    fn simulate(
        &mut self,
        attempt: &mut Attempt,
        widths: &[Option<[f64; 2]>],
    ) -> Result<Ending, AdaptiveError> {
        let quiet = self.settings.quiet_time.unwrap_or(QUIET_STEPS * self.impact_step);
        for i in 0..self.watches.len() {
            self.begin_watch(i)?;
        }
        self.model.offer_to_stress(self.integrator.time(), &self.fine);
        while self.integrator.time() < self.settings.end_time {
            let stops = self.fine.iter().flatten().any(|f| f.search.stops_at_errors());
            self.integrator.stop_at_errors(stops);
            let step = match self.integrator.step(&mut self.model.system, self.settings.end_time) {
                Ok(step) => step,
                Err(source) => {
                    let refusal =
                        self.integrator.last_refusal().filter(|r| r.kind.may_depend_on_penalty()).cloned();
                    let Some(refusal) = refusal else { return Err(AdaptiveError::Dynamics(source)) };
                    if self.lower_penalty(refusal.kind)? {
                        attempt.trial = None; // the second phase of Fig. 3 simulates the whole impact
                        continue;
                    }
                    return Ok(Ending::SolverFailed { failure: refusal.kind, reason: refusal.reason });
                }
            };
            if let Some((i, time)) = self.joining(step)? {
                self.repeat_impact_until(step.start, time)?;
                if self.previews[i].is_none() {
                    self.preview(&[i])?;
                }
                self.wake(i, widths[i])?;
                self.begin_watch(i)?;
                attempt.penalty_start[i] = self.model.system.forces()[i].contact.penalty();
                self.integrator.invalidate();
                continue;
            }
            self.store_step()?;
            self.watch()?;
            self.check_motion()?;
            if let Some(ending) = self.look(attempt)? {
                return Ok(ending);
            }
            let last = self.watches.iter().filter_map(ImpactWatch::last_touch);
            attempt.last_force = last.fold(attempt.last_force, f64::max);
            let progress = self.observer.progress(step.end, step.end - step.start, PhaseKind::Impact);
            if progress == Continue::Interrupt {
                return Ok(Ending::Interrupted);
            }
            if step.end - attempt.last_force >= quiet && self.is_separating() {
                break;
            }
        }
        self.check_resolved()?;
        Ok(Ending::Complete)
    }

    /// Refuses an impact in which bodies passed into each other between the contact points.
    fn check_resolved(&mut self) -> Result<(), AdaptiveError> {
        let (time, y) = (self.integrator.time(), self.integrator.state());
        self.model.system.body_states(time, y);
        let states = self.model.system.last_evaluation().0;
        for (i, contact) in &self.model.adaptive {
            let Some(fine) = self.fine[*i].as_ref().filter(|f| !f.has_touched()) else { continue };
            let (overlap, width) = (-contact.nearest(states)?.gap, fine.widths()[0]);
            if overlap > MISSED * width {
                let contact = contact.name.clone();
                return Err(AdaptiveError::Unresolved { contact, time, overlap, width });
            }
        }
        Ok(())
    }

    /// Notes what the contacts did in the last step; the ending, if it shows that going on is pointless.
    fn look(&mut self, attempt: &mut Attempt) -> Result<Option<Ending>, AdaptiveError> {
        let mut has_contact = false;
        for i in 0..self.watches.len() {
            let contact = self.model.system.forces()[i].contact.as_ref();
            let report = *contact.report();
            attempt.most_active[i] = attempt.most_active[i].max(report.n_active as u32);
            has_contact |= report.normal_force > 0.0;
            if let Some(fine) = &mut self.fine[i] {
                fine.mark(contact);
            }
            if !(report.is_rim_touched && report.normal_force > 0.0) {
                continue;
            }
            if self.fine[i].is_some() && !self.is_width_given(i) {
                return Ok(Some(Ending::EdgeTouched(i)));
            }
            let time = self.integrator.time();
            let contact = self.model.contacts[i].name.clone();
            let widths = self.fine[i].as_ref().map_or(self.model.contacts[i].widths, FineContact::widths);
            return Err(AdaptiveError::IntervalTooSmall { contact, time, width: widths[0] });
        }
        attempt.contact_steps += usize::from(has_contact);
        if attempt.trial.is_some_and(|n| attempt.contact_steps >= n) {
            return Ok(Some(Ending::TrialPassed));
        }
        Ok(None)
    }

    fn repeat_impact_until(&mut self, start: f64, end: f64) -> Result<(), AdaptiveError> {
        self.interpolated.copy_from_slice(self.integrator.previous_state());
        self.integrator.restart(start, &self.interpolated);
        self.integrator.stop_at_errors(false); // these steps have passed already
        while self.integrator.time() < end {
            self.integrator.step(&mut self.model.system, end).map_err(AdaptiveError::Dynamics)?;
            self.store_step()?;
            self.watch()?;
        }
        Ok(())
    }
}

/// What is reported once an attempt is accepted.
pub(super) enum Pending {
    /// A stored state.
    Sample(Box<Sample>),
    /// A change of the model.
    Transfer(TransferRecord),
}
