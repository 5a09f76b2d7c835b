//! Impact phases: trials, each from the same start, until every fine model and penalty factor is
//! acceptable (\[A\] Fig. 2, Algorithm 3).

pub(crate) mod balance;
pub(crate) mod refine;
pub(crate) mod trial_reason;
pub(crate) mod intervals;
pub(crate) mod judgement;
pub(crate) mod pace;
mod stepped_over;
pub(crate) mod trial;
mod by_law;
mod travel;

use super::{Driver, Part};
use crate::adaptivity::interval::IntervalAssessment;
use crate::error::AdaptiveError;
use crate::record::{StressState, TrialOutcome};
use crate::run::driver::contact_slot::{AtPeak, Found};
use crate::run::driver::impact::intervals::Intervals;
use crate::run::driver::impact::judgement::{Ending, Judgement};
use crate::run::driver::impact::travel::HeldFriction;
use crate::run::driver::impact::trial::Trial;
use crate::state::impact_monitor::ImpactMonitor;
use crate::state::ledger::{EnergyLedger, NumericalDamping};
use crate::state::peaks::Peaks;

/// Most trials of one impact: widths change by half at least each time, penalty factors by a factor
/// of ten.
pub(crate) const MAX_TRIALS: u32 = 40;

/// Where all trials of an impact start.
pub(crate) struct Start {
    pub time: f64,
    pub state: Vec<f64>,
    pub monitors: Vec<(ImpactMonitor, AtPeak)>,
    pub stress: Vec<Option<StressState>>,
    pub peaks: Peaks,
    pub numerical: NumericalDamping,
    pub ledger: EnergyLedger,
    pub slow_since: Option<f64>,
    /// What sticks in contacts that press.
    pub friction: Vec<HeldFriction>,
    part: Part,
    n_phases: u32,
}

impl Driver<'_> {
    /// Simulates an impact from the present state until every contact has been open for the quiet
    /// time; returns whether the observer stopped the run.
    pub(super) fn impact_phase(&mut self) -> Result<bool, AdaptiveError> {
        let mut start = self.impact_start();
        self.output.buffer(self.model.contacts.iter().any(|c| c.refinement.is_some()));
        let mut intervals = Intervals::new(self.slots.len());
        for slot in &mut self.slots {
            slot.found = Found::default();
        }
        let touching = self.touching()?;
        self.preview(&touching)?;
        let mut built = self.activate_touching(&intervals.sizes);
        let mut contact_step_limit = self.restart_searches();
        let (mut number, mut last) = (0, MAX_TRIALS);
        while number < last {
            number += 1;
            let mut trial = self.begin_trial(number, contact_step_limit);
            let ending = match std::mem::replace(&mut built, Ok(()))
                .and_then(|()| self.simulate(&mut trial, &intervals.sizes))
            {
                Ok(ending) => ending,
                Err(AdaptiveError::Interrupted) => Ending::Interrupted,
                Err(error) => return self.fail(&trial, &[], error),
            };
            let minor = self.minor_contacts(&ending);
            let mut verdicts = self.assess(&minor);
            match self.judge(&ending, (&verdicts, &minor), &mut intervals, number) {
                Err(error) => return self.fail(&trial, &verdicts, error),
                Ok(Judgement::Accept(acceptance)) => {
                    let is_interrupted = ending == Ending::Interrupted;
                    let outcome =
                        if is_interrupted { TrialOutcome::Interrupted } else { TrialOutcome::Accepted };
                    let next = match ending {
                        Ending::Travelled(i) => Some((i, self.next(i))),
                        _ => None,
                    };
                    let reason = match &next {
                        Some((i, next)) => self.demand(*i, next.reason()).to_string(),
                        None => acceptance.to_string(),
                    };
                    self.log(&trial, outcome, &reason, &verdicts)?;
                    if let Some((i, next)) = next {
                        if let Err(error) = self.hand_over(i, next, &mut intervals) {
                            return self.fail(&trial, &verdicts, error);
                        }
                        (start, last) = (self.impact_start(), number + MAX_TRIALS);
                        continue;
                    }
                    intervals.raise(&mut verdicts);
                    self.record_history(&verdicts);
                    self.finish_impact(&minor)?;
                    return Ok(is_interrupted);
                }
                Ok(Judgement::Again { demands, contact_steps }) => {
                    self.log(&trial, TrialOutcome::Rejected, &trial_reason::line(&demands), &verdicts)?;
                    contact_step_limit = contact_steps;
                    let sizes = &intervals.sizes;
                    let mut again = || {
                        self.rewind(&start, sizes)?;
                        if self.is_settled_start() {
                            self.settle_again(sizes)
                        } else {
                            self.hold_friction(&start.friction)
                        }
                    };
                    built = if number < last { again() } else { Ok(()) };
                }
            }
        }
        self.output.flush()?;
        Err(self.no_model(intervals.latest, MAX_TRIALS))
    }

    /// The state from which every trial of the impact starts, taken now.
    pub(crate) fn impact_start(&self) -> Start {
        Start {
            time: self.integrator.time(),
            state: self.integrator.state().to_vec(),
            monitors: self.slots.iter().map(|slot| (slot.monitor.clone(), slot.at_peak)).collect(),
            stress: self.run.stress.clone(),
            peaks: self.run.peaks.clone(),
            numerical: self.run.numerical,
            ledger: self.run.ledger,
            slow_since: self.run.slow_since,
            friction: self.held_friction(),
            part: self.work.part,
            n_phases: self.run.n_phases,
        }
    }

    /// Reports a trial that ends the run, with what it computed, and passes `error` on.
    fn fail(
        &mut self,
        trial: &Trial,
        verdicts: &[Option<IntervalAssessment>],
        error: AdaptiveError,
    ) -> Result<bool, AdaptiveError> {
        self.log(trial, TrialOutcome::Failed, &error.to_string(), verdicts)?;
        self.store_noted()?;
        self.output.flush()?;
        Err(error)
    }
}
