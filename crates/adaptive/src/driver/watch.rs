//! What is observed and logged of the contacts in an impact phase.

use ffr_dynamics::integration::DenseOutput;

use super::Driver;
use super::impact::{Attempt, Ending};
use crate::adaptive_contact::FineContact;
use crate::error::AdaptiveError;
use crate::impact_watch::{Change, ContactInstant};
use crate::interval::IntervalAssessment;
use crate::record::TryRecord;
use crate::simulation::{near_motion, normal_motion, smallest_gap};

impl Driver<'_> {
    /// Ends an accepted impact: reports it, and lets the fine models go.
    pub(super) fn finish(&mut self) -> Result<(), AdaptiveError> {
        self.store_noted()?;
        let is_open: Vec<bool> =
            self.model.system.forces().iter().map(|f| f.contact.report().normal_force <= 0.0).collect();
        let mut is_closed = false; // time is up, or the user stopped the run
        for i in self.latest_first() {
            let before = self.present_ledger()?;
            is_closed |= self.model.system.forces()[i].contact.report().normal_force > 0.0;
            let hosts = self.fine[i].as_ref().is_some_and(|fine| !fine.hosted.is_empty());
            if self.model.system.forces()[i].contact.report().normal_force > 0.0 || is_closed && hosts {
                continue;
            }
            self.sleep(i)?;
            let after = self.present_ledger()?;
            self.book_transfer(i, "fine to coarse", &before, &after);
        }
        self.flush()?;
        let alone: Vec<bool> = (0..self.watches.len()).map(|i| self.is_alone(i)).collect();
        let minor = self.minor_contacts(&Ending::Complete);
        for (i, (is_open, is_alone)) in is_open.into_iter().zip(alone).enumerate() {
            if let Some(record) = self.watches[i].finish(i as u32, is_alone) {
                self.observer.impact(&record)?;
                self.n_impacts += 1;
                self.doubt_impact(&record, is_open, minor[i])?;
            }
        }
        self.doubt_output()?;
        self.integrator.invalidate();
        self.next_output = self.integrator.time() + self.settings.free_interval;
        Ok(())
    }

    /// Whether the impact of contact `i` changed the velocities of its bodies alone: no other contact pressed them meanwhile, nor
    /// bodies that hang together with them by joints.
    fn is_alone(&self, i: usize) -> bool {
        let forces = self.model.system.forces();
        let groups = &self.groups;
        let pressed = |k: usize| {
            let (body, target) = forces[k].contact.bodies();
            [Some(body), target].into_iter().flatten().map(move |b| groups[b])
        };
        let Some((start, end)) = self.watches[i].span() else { return true };
        let others = self.watches.iter().enumerate().filter(|(k, _)| *k != i);
        let mut meanwhile = others.filter_map(|(k, watch)| watch.span().map(|span| (k, span)));
        !meanwhile.any(|(k, (first, last))| {
            first < end && start < last && pressed(k).any(|group| pressed(i).any(|own| own == group))
        })
    }

    /// Logs a try, one entry a contact that took part.
    pub(super) fn log(
        &mut self,
        attempt: &Attempt,
        number: u32,
        outcome: &str,
        reason: &str,
        verdicts: &[Option<IntervalAssessment>],
    ) -> Result<(), AdaptiveError> {
        let statistics = self.statistics();
        let processor = attempt.processor.and_then(|start| start.try_elapsed().ok());
        let cpu_time = processor.map_or(f64::NAN, |spent| spent.as_secs_f64());
        let mut impact = self.n_impacts;
        for i in 0..self.watches.len() {
            // A try may end before any force acts, or before there is a model.
            let has_begun = outcome == "failed" && self.fine[i].is_some() || self.building == Some(i);
            let took_part = self.watches[i].is_running() || has_begun;
            if !took_part {
                continue;
            }
            let facts = &self.model.contacts[i];
            let contact = &self.model.system.forces()[i].contact;
            let sizes = self.fine[i].as_ref().map_or_else(|| self.model.try_sizes(i), |f| f.sizes);
            let mut utilisation = [f64::from(attempt.most_active[i]) / contact.n_points().max(1) as f64, 0.0];
            if let Some(verdict) = verdicts.get(i).and_then(Option::as_ref) {
                utilisation = [0.0; 2];
                utilisation.iter_mut().zip(&verdict.directions).for_each(|(u, d)| *u = d.utilisation);
            }
            let record = TryRecord {
                impact,
                number,
                start: self.phase_start,
                stop: self.integrator.time(),
                penalty_start: attempt.penalty_start[i],
                penalty_end: contact.penalty(),
                interval_widths: self.fine[i].as_ref().map_or(facts.widths, FineContact::widths),
                utilisation,
                elements: sizes.elements,
                freedoms: sizes.freedoms,
                interface_freedoms: sizes.interface,
                steps: statistics.steps - attempt.steps,
                rejected: statistics.rejected - attempt.rejected,
                peak_force: self.watches[i].peak_force(),
                outcome: outcome.into(),
                reason: reason.into(),
                wall_time: attempt.started.elapsed().as_secs_f64(),
                cpu_time,
            };
            self.observer.attempt(&record)?;
            impact += 1;
        }
        Ok(())
    }

    /// Whether every gap is open, and those of the contacts that touched in this phase are wider than before the last step.
    /// A contact that a body flies towards, away from another one, is left to the free phase.
    pub(super) fn is_separating(&mut self) -> bool {
        let (system, watches) = (&mut self.model.system, &self.watches);
        let (start, end) = self.integrator.interval();
        let (before, now) = (self.integrator.previous_state(), self.integrator.state());
        watches.iter().enumerate().all(|(i, watch)| {
            let gap = smallest_gap(system, end, now, i);
            gap > 0.0 && (!watch.is_running() || gap > smallest_gap(system, start, before, i))
        })
    }

    /// Shows the end of the last step to the watches, and the state to the stress requests.
    pub(super) fn watch(&mut self) -> Result<(), AdaptiveError> {
        for i in 0..self.watches.len() {
            let now = self.instant(i);
            self.check_contact(i, now.time, -now.motion.velocity.dot(&now.normal))?;
            let (touch, release) = self.changes(i)?;
            self.watches[i].step(now, touch, release);
        }
        self.model.offer_to_stress(self.integrator.time(), &self.fine);
        Ok(())
    }

    /// Shows the present instant to the watch of contact `i`, which has not looked at it up to now.
    pub(super) fn begin_watch(&mut self, i: usize) -> Result<(), AdaptiveError> {
        let now = self.instant(i);
        self.check_contact(i, now.time, -now.motion.velocity.dot(&now.normal))?;
        self.watches[i].begin(now);
        Ok(())
    }

    fn instant(&mut self, i: usize) -> ContactInstant {
        let (time, y) = (self.integrator.time(), self.integrator.state());
        let system = &mut self.model.system;
        let (normal, motion) = normal_motion(system, time, y, i);
        let force = system.forces()[i].contact.report().normal_force;
        ContactInstant { time, force, impulse: system.impulse(y, i), normal, motion }
    }

    /// When contact `i` closed and opened in the last step, if it did.
    fn changes(&mut self, i: usize) -> Result<(Option<Change>, Option<Change>), AdaptiveError> {
        let system = &mut self.model.system;
        let (start, end) = self.integrator.interval();
        let first = smallest_gap(system, start, self.integrator.previous_state(), i);
        let last = smallest_gap(system, end, self.integrator.state(), i);
        Ok(if first > 0.0 && last <= 0.0 {
            (self.crossing(i, 1.0)?, None)
        } else if first < 0.0 && last >= 0.0 {
            (None, self.crossing(i, -1.0)?)
        } else {
            (None, None)
        })
    }

    /// When in the last step `sign` times the gap of contact `i` became zero or less.
    fn crossing(&mut self, i: usize, sign: f64) -> Result<Option<Change>, AdaptiveError> {
        let system = &mut self.model.system;
        let found = self
            .crossing
            .first_crossing(&self.integrator, |t, y| sign * smallest_gap(system, t, y, i))
            .map_err(AdaptiveError::Dynamics)?;
        let change = found.map(|c| {
            self.integrator.interpolate(c.time, &mut self.interpolated);
            Change { time: c.time, motion: near_motion(system, c.time, &self.interpolated, i) }
        });
        // The search leaves the system at another instant.
        system.body_states(self.integrator.time(), self.integrator.state());
        Ok(change)
    }
}
