//! One trial of an impact: integration from the touch until the impact is over, or the trial is
//! known to be rejected.

use std::time::Instant;

use cpu_time::ProcessTime;
use ffr_dynamics::error::DynamicsError;
use ffr_dynamics::integration::{DenseOutput, OdeSystem, Step};

use super::judgement::Ending;
use super::pace::Pace;
use crate::checks::resolution::longest_element_of;
use crate::error::AdaptiveError;
use crate::impact::FineContact;
use crate::impact::MISSED_SURFACE;
use crate::record::PhaseKind;
use crate::record::ZoneSize;
use crate::run::driver::contact_slot::ContactSlot;
use crate::run::driver::{Driver, QUIET_STEPS};
use crate::state::observer::Continue;
use crate::state::simulation::smallest_gap;
use crate::uncertainty::trace::Trace;

/// Counters of one trial.
pub(crate) struct Trial {
    /// Number, from 1.
    pub number: u32,
    pub started: Instant,
    /// Processor time at the start; `None` where the system does not tell.
    pub processor: Option<ProcessTime>,
    pub steps: u64,
    pub rejected: u64,
    pub contact_steps: usize,
    /// Stop after so many steps with contact.
    pub contact_step_limit: Option<usize>,
    pub most_active: Vec<u32>,
    pub last_force: f64,
    pub penalty_start: Vec<f64>,
}

/// Overlap without force, as a share of the interval, that shows that its points missed the
/// contact: far above what the detection of the touch leaves, far below what elastic bodies that
/// touch come closer by.
const MISSED: f64 = 1e-4;
/// The most that edges which bend away between points may be pressed in before a point touches, as
/// a share of the body's size: place and moment of the touch are then as right as the kept
/// frequencies, to 0.1 %.
const LATE_SURFACE: f64 = 1e-3;

impl Driver<'_> {
    /// Begins trial `number`, to be stopped after `contact_step_limit` steps with contact, if there
    /// is a limit.
    pub(crate) fn begin_trial(&mut self, number: u32, contact_step_limit: Option<usize>) -> Trial {
        self.slots.iter_mut().filter_map(ContactSlot::fine_mut).for_each(FineContact::clear);
        // Stored before the impact; states of a trial given up do not count.
        (self.run.last_output, self.output.is_noted) = (self.integrator.time(), false);
        self.lowered = None;
        self.pace = Pace::new(self.impact_step);
        self.begin_watch();
        self.slots.iter_mut().for_each(|slot| slot.trace = Trace::default());
        self.local_deformation.begin(self.integrator.time(), self.model.observed.points.len());
        let statistics = self.statistics();
        let penalties = self.model.system.forces().iter().map(|f| f.contact.facts().penalty());
        Trial {
            number,
            started: Instant::now(),
            processor: ProcessTime::try_now().ok(),
            steps: statistics.steps,
            rejected: statistics.rejected,
            contact_steps: 0,
            contact_step_limit,
            most_active: vec![0; self.slots.len()],
            last_force: self.integrator.time(),
            penalty_start: penalties.collect(),
        }
    }

    /// Integrates until the impact is over or the trial is known to be rejected; contacts that join
    /// get zones of the `sizes` wanted.
    pub(crate) fn simulate(
        &mut self,
        trial: &mut Trial,
        sizes: &[Option<ZoneSize>],
    ) -> Result<Ending, AdaptiveError> {
        self.linear.begin(&self.run.loads, self.integrator.time());
        self.run.hits.clone_from(&self.marked_hits);
        self.output.discard_hits();
        if trial.number > 1 {
            self.forget_last_trial();
        }
        if self.begins_with_overlap() {
            // Its energy is there from the start, as the fine models of this trial have it.
            self.run.ledger.start = None;
            self.store()?;
        }
        self.begin_monitors(0..self.slots.len())?;
        self.update_stress_states();
        while self.integrator.time() < self.settings.end_time {
            self.choose_pace()?;
            let step = match self.take_step() {
                Ok(step) => step,
                Err(_) if self.pace.kind() == PhaseKind::Lasting => {
                    self.slow_down()?;
                    continue;
                }
                Err(source) => {
                    let refusal =
                        self.integrator.last_refusal().filter(|r| r.kind().may_depend_on_penalty()).cloned();
                    let Some(refusal) = refusal else { return Err(AdaptiveError::Dynamics(source)) };
                    if self.lower_penalty()? {
                        trial.contact_step_limit = None; // the second phase of Fig. 3 simulates the whole impact
                        continue;
                    }
                    return Ok(Ending::SolverFailed(refusal));
                }
            };
            let joining = self.first_touch((step.start, step.end))?;
            if self.pace.kind() == PhaseKind::Lasting {
                if joining.is_some()
                    || self.is_any_changed()?
                    || self.is_rim_touched()
                    || self.is_rolled_far(step)
                {
                    self.undo(step)?;
                    continue;
                }
                self.store_lasting(step)?;
            } else if let Some((i, time)) = joining {
                self.repeat_impact_until(step.start, time)?;
                self.join(i, trial, sizes)?;
                continue;
            } else if let Some(deepest) = self.overlap_stepped_over()? {
                self.repeat_impact_until(step.start, deepest)?;
                continue;
            } else {
                self.store_step()?;
            }
            self.update_monitors()?;
            self.check_motion()?;
            self.note_stops()?;
            self.note_rest();
            if let Some(ending) = self.inspect_contacts(trial)? {
                return Ok(ending);
            }
            let last = self.near.iter().filter_map(|i| self.slots[*i].monitor.last_touch());
            trial.last_force = last.fold(trial.last_force, f64::max);
            let progress = self.output.observer.progress(step.end, step.end - step.start, self.pace.kind());
            if progress == Continue::Interrupt {
                return Ok(Ending::Interrupted);
            }
            if self.is_at_rest() {
                break;
            }
            // While there is force nobody asks for how long there was none.
            let is_open = step.end > trial.last_force;
            if is_open && step.end - trial.last_force >= self.quiet_time() && self.is_separating()? {
                if !self.is_yet_to_touch() {
                    break;
                }
                self.check_resolved(true)?;
            }
        }
        self.check_resolved(false)?;
        self.end_watch()?;
        let beside = self.slots.iter().position(ContactSlot::lacks_zone);
        Ok(beside.map_or(Ending::Complete, Ending::EdgeTouched))
    }

    /// Evaluates forces at the start of a trial: what the contacts reported last belongs to the one before.
    fn forget_last_trial(&mut self) {
        // A refusal is that of the first step.
        let (t, y) = (self.integrator.time(), self.integrator.state());
        let _ = self.model.system.evaluate_accelerations(t, y);
        if self.model.system.forces().iter().any(|force| force.contact.report().normal_force > 0.0) {
            // Pressed from the start of the trial.
            self.measure_dents(t);
            self.local_deformation.restart_differences(t);
        }
    }

    /// A step at the present pace; what contacts did in it is kept, and which are near.
    fn take_step(&mut self) -> Result<Step, DynamicsError> {
        let stops = self.refined().any(|(_, fine)| fine.search.stops_at_errors());
        self.integrator.stop_at_errors(stops);
        let goal = self.settings.end_time.min(self.pace.goal(self.integrator.time()));
        let step = self.integrator.step(&mut self.model.system, goal)?;
        self.keep_forces(step.end);
        self.sort_step();
        Ok(step)
    }

    /// Contact `i` joins the impact at the present instant, with a zone of the size wanted.
    fn join(&mut self, i: usize, trial: &mut Trial, sizes: &[Option<ZoneSize>]) -> Result<(), AdaptiveError> {
        if self.slots[i].found.preview.is_none() {
            self.preview(&[i])?;
        }
        self.activate(i, sizes[i])?;
        self.begin_monitors(i..i + 1)?;
        trial.penalty_start[i] = self.model.system.forces()[i].contact.facts().penalty();
        self.integrator.invalidate();
        Ok(())
    }

    /// For how long all contacts are to be open at the end of an impact: several steps, but where none
    /// is refined no longer than a touch has lasted, after which another one is another impact (Eq. Q.1)
    /// \[s\].
    fn quiet_time(&self) -> f64 {
        let steps = QUIET_STEPS * self.impact_step;
        let is_refined = self.refined().next().is_some();
        let longest = self.slots.iter().map(|slot| slot.monitor.longest_touch()).fold(0.0, f64::max);
        self.settings.quiet_time.unwrap_or(if is_refined { steps } else { steps.min(longest) })
    }

    /// Whether points of a whole surface come nearer of which none has touched: an edge that bends
    /// away between them touches before they do.
    fn is_yet_to_touch(&mut self) -> bool {
        let system = &mut self.model.system;
        let (start, end) = self.integrator.interval();
        let (before, now) = (self.integrator.previous_state(), self.integrator.state());
        self.slots.iter().enumerate().any(|(i, slot)| {
            slot.fine().is_some_and(|fine| fine.whole.is_some() && !fine.has_touched())
                && smallest_gap(system, end, now, i) < smallest_gap(system, start, before, i)
        })
    }

    /// Refuses an impact in which bodies passed into each other between the contact points; by more
    /// than these leave between each other if points are still to touch (Eq. C.64).
    fn check_resolved(&mut self, is_yet_to_touch: bool) -> Result<(), AdaptiveError> {
        let (time, y) = (self.integrator.time(), self.integrator.state());
        self.model.system.body_states(time, y);
        let states = self.model.system.last_evaluation().0;
        for (slot, contact) in self.slots.iter_mut().zip(&self.model.contacts) {
            let Some(fine) = slot.fine().filter(|f| !f.has_touched()) else { continue };
            let Some(refinement) = &contact.refinement else { continue };
            let (width, is_whole) = (fine.widths()[0], fine.whole.is_some());
            let overlap = -refinement.nearest(states, &mut slot.nearest)?.gap;
            let name = || contact.name.clone();
            let body = &self.model.bodies[contact.body];
            let between = if is_yet_to_touch && is_whole { body.height_between_points() } else { 0.0 };
            if is_whole && overlap > MISSED_SURFACE * width + between.min(LATE_SURFACE * width) {
                let length = longest_element_of(body).unwrap_or_default();
                let (contact, body) = (name(), body.name.clone());
                return Err(AdaptiveError::UnresolvedSurface { contact, body, time, overlap, length });
            }
            if !is_whole && overlap > MISSED * width {
                return Err(AdaptiveError::Unresolved { contact: name(), time, overlap, width });
            }
        }
        Ok(())
    }

    /// Notes what the contacts did in the last step; the ending, if it shows that going on is
    /// pointless.
    fn inspect_contacts(&mut self, trial: &mut Trial) -> Result<Option<Ending>, AdaptiveError> {
        let mut has_contact = false;
        for k in 0..self.near.len() {
            let i = self.near[k];
            let contact = self.model.system.forces()[i].contact.as_ref();
            let report = *contact.report();
            trial.most_active[i] = trial.most_active[i].max(report.n_active as u32);
            has_contact |= report.normal_force > 0.0;
            if self.note_elements(i)? {
                return Ok(Some(if self.travels(i) { Ending::Travelled(i) } else { Ending::EdgeTouched(i) }));
            }
        }
        if let Some(i) = self.first_elsewhere()? {
            return Ok(Some(Ending::Travelled(i)));
        }
        if let Some(i) = self.slots.iter().position(ContactSlot::lacks_zone) {
            return Ok(Some(Ending::EdgeTouched(i)));
        }
        if let Some(i) = self.touched_outside(None)? {
            return Ok(Some(Ending::EdgeTouched(i)));
        }
        trial.contact_steps += usize::from(has_contact);
        if trial.contact_step_limit.is_some_and(|n| trial.contact_steps >= n) {
            return Ok(Some(Ending::TrialPassed));
        }
        Ok(self.is_past_peak().then_some(Ending::PastPeak))
    }

    /// Notes which elements of the zone of contact `i` press; whether one does at the rim of a zone that may grow.
    ///
    /// # Errors
    /// [`AdaptiveError::IntervalTooSmall`] if one does at the rim of a zone that may not.
    pub(crate) fn note_elements(&mut self, i: usize) -> Result<bool, AdaptiveError> {
        let contact = self.model.system.forces()[i].contact.as_ref();
        let report = *contact.report();
        if let Some(fine) = self.slots[i].fine_mut() {
            fine.mark(contact);
        }
        if !(report.is_rim_touched && report.normal_force > 0.0) {
            return Ok(false);
        }
        if self.slots[i].fine().is_some() && !self.is_width_given(i) {
            return Ok(true);
        }
        let time = self.integrator.time();
        let contact = self.model.contacts[i].name.clone();
        let widths = self.slots[i].fine().map_or(self.model.contacts[i].widths, FineContact::widths);
        Err(AdaptiveError::IntervalTooSmall { contact, time, width: widths[0] })
    }

    /// The first contact whose zones are parts of surfaces that touch outside of them, in the present state or in another
    /// one, `elsewhere`.
    pub(crate) fn touched_outside(
        &mut self,
        elsewhere: Option<&[f64]>,
    ) -> Result<Option<usize>, AdaptiveError> {
        if self.refined().all(|(_, fine)| fine.outside.is_none()) {
            return Ok(None);
        }
        let y = elsewhere.unwrap_or(self.integrator.state());
        let states = self.model.system.body_states(self.integrator.time(), y);
        for (i, (slot, contact)) in self.slots.iter_mut().zip(&self.model.contacts).enumerate() {
            let outside = slot.fine_mut().and_then(|fine| fine.outside.as_mut());
            let Some((outside, refinement)) = outside.zip(contact.refinement.as_ref()) else { continue };
            if refinement.is_touched_outside(outside, states)? {
                return Ok(Some(i));
            }
        }
        Ok(None)
    }

    /// Goes back to the start of the last step, which is `start`.
    pub(crate) fn return_to(&mut self, start: f64) {
        self.interpolated.copy_from_slice(self.integrator.previous_state());
        self.integrator.restart(start, &self.interpolated);
        self.model.system.restore();
    }

    /// Takes the last step of an impact, which began at `start`, again as far as `end`, where
    /// another contact joins or one overlaps that the step has not felt.
    fn repeat_impact_until(&mut self, start: f64, end: f64) -> Result<(), AdaptiveError> {
        self.return_to(start);
        self.integrator.stop_at_errors(false); // these steps have passed already
        while self.integrator.time() < end {
            let step = self.integrator.step(&mut self.model.system, end).map_err(AdaptiveError::Dynamics)?;
            self.keep_forces(step.end);
            self.sort_step();
            self.store_step()?;
            self.update_monitors()?;
        }
        Ok(())
    }
}
