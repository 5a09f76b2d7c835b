//! What is monitored and logged of the contacts in an impact phase.

use std::f64::consts::PI;
use std::ops::Range;

use ffr_dynamics::integration::DenseOutput;
use iga_core::elasticity::kinematics::von_mises;

use super::{Driver, TOUCHING};
use crate::adaptivity::interval::IntervalAssessment;
use crate::error::AdaptiveError;
use crate::impact::FineContact;
use crate::model::ContactFacts;
use crate::record::{BareForce, EventRecord, TransferDirection, TrialOutcome, TrialRecord};
use crate::run::driver::contact_slot::{AtPeak, ContactSlot, Nearness};
use crate::run::driver::impact::trial::Trial;
use crate::spec::{LocalField, StressInstant};
use crate::state::impact_monitor::{Change, ContactInstant, Impact, NearMotion};
use crate::state::simulation::{
    System, gap_alone, hold_at, motion_at, near_motion, normal_motion, smallest_gap,
};
use crate::touch::parts::TouchKind;

/// Points that carry force from which on their area is that of the contact within a third or so.
const TELLING_POINTS: usize = 6;

impl Driver<'_> {
    /// Ends an accepted impact: reports it, with what follows from `minor` contacts, and takes the
    /// fine models out of the system.
    pub(super) fn finish_impact(&mut self, minor: &[bool]) -> Result<(), AdaptiveError> {
        self.store_noted()?;
        let is_open: Vec<bool> =
            self.model.system.forces().iter().map(|f| f.contact.report().normal_force <= 0.0).collect();
        let doubts: Vec<_> = (0..self.slots.len()).map(|i| self.doubts(i, minor[i])).collect();
        let mut is_closed = false; // time is up, or the user stopped the run
        for i in self.latest_first() {
            let before = self.present_balance()?;
            is_closed |= self.model.system.forces()[i].contact.report().normal_force > 0.0;
            let hosts = self.slots[i].fine().is_some_and(|fine| !fine.hosted.is_empty());
            if self.model.system.forces()[i].contact.report().normal_force > 0.0 || is_closed && hosts {
                continue;
            }
            self.deactivate(i)?;
            let after = self.present_balance()?;
            self.record_transfer(i, TransferDirection::FineToCoarse, &before, &after);
        }
        self.output.flush()?;
        let pressing = self.pressing();
        let spans = |i| self.presses_beside(i, &pressing);
        let others: Vec<Vec<(f64, f64)>> = (0..self.slots.len()).map(spans).collect();
        for (i, (is_open, spans)) in is_open.into_iter().zip(others).enumerate() {
            let is_at_once = self.slots[i].found.touches.len() > 1;
            let monitor = &mut self.slots[i].monitor;
            let is_alone =
                |(start, end): (f64, f64)| !spans.iter().any(|(first, last)| *first < end && start < *last);
            if monitor.is_running() {
                self.run.contacts[i].close(monitor.last_touch().unwrap_or_default());
            }
            let is_one = |impact: &Impact| !is_at_once && is_alone(impact.span());
            let records = monitor.finish(i as u32, self.run.n_rows(), is_one);
            let hardest = records.iter().map(|record| record.peak_force).fold(0.0, f64::max);
            for mut record in records {
                record.band = self.band(&record, is_alone((record.start, record.end)), &doubts[i]);
                self.slots[i].monitor.set_band(record.band);
                self.output.observer.impact(&record)?;
                self.run.n_impacts += u32::from(record.row == self.run.n_rows());
                if record.peak_force >= hardest {
                    self.check_peak(&record)?;
                }
                self.check_impact(&record, is_open, minor[i], &doubts[i])?;
            }
            self.run.contacts[i].impact = self.slots[i].monitor.reported();
        }
        self.report_events()?;
        self.report_hits()?;
        self.check_output()?;
        self.integrator.invalidate();
        self.run.next_output = self.integrator.time() + self.run.free_interval;
        Ok(())
    }

    /// Reports what contacts did in this phase, in the order of time.
    fn report_events(&mut self) -> Result<(), AdaptiveError> {
        let all = self.slots.iter_mut().zip(0..);
        let all = all.flat_map(|(slot, contact)| {
            slot.monitor.take_events().into_iter().map(move |event| EventRecord { contact, ..event })
        });
        let mut events: Vec<EventRecord> = all.collect();
        events.sort_by(|a, b| a.time.total_cmp(&b.time));
        Ok(events.iter().try_for_each(|event| self.output.observer.event(event))?)
    }

    /// Reports the last impacts again, without restitution, if the run ended before it is known that
    /// their bodies do not touch again in them.
    pub(super) fn report_unended_impacts(&mut self) -> Result<(), AdaptiveError> {
        let time = self.integrator.time();
        for (i, contact) in self.run.contacts.iter().enumerate() {
            if let Some(record) = contact.impact.and_then(|impact| impact.unended(i as u32, time)) {
                self.output.observer.impact(&record)?;
            }
        }
        Ok(())
    }

    /// For each group of bodies that joints connect the contacts that have pressed it in this phase.
    fn pressing(&self) -> Vec<Vec<usize>> {
        let mut pressing = vec![Vec::new(); self.groups.len()];
        for (i, _) in
            self.slots.iter().enumerate().filter(|(_, slot)| slot.monitor.impacts().next().is_some())
        {
            self.groups_of(i).for_each(|group| pressing[group].push(i));
        }
        pressing
    }

    /// Groups of the bodies of contact `i`.
    pub(super) fn groups_of(&self, i: usize) -> impl Iterator<Item = usize> + '_ {
        let (body, target) = self.model.system.forces()[i].contact.facts().bodies();
        [Some(body), target].into_iter().flatten().map(|body| self.groups[body])
    }

    /// From when until when other contacts among the `pressing` ones press the bodies of contact `i` in this phase, or
    /// bodies that joints connect with them: velocities of impacts meanwhile are the work of both.
    fn presses_beside(&self, i: usize, pressing: &[Vec<usize>]) -> Vec<(f64, f64)> {
        let others = self.groups_of(i).flat_map(|group| &pressing[group]).filter(|k| **k != i);
        others.flat_map(|k| self.slots[*k].monitor.impacts().map(Impact::span)).collect()
    }

    /// Logs a trial, one entry per contact that took part.
    pub(super) fn log(
        &mut self,
        trial: &Trial,
        outcome: TrialOutcome,
        reason: &str,
        verdicts: &[Option<IntervalAssessment>],
    ) -> Result<(), AdaptiveError> {
        let statistics = self.statistics();
        let processor = trial.processor.and_then(|start| start.try_elapsed().ok());
        let cpu_time = processor.map_or(f64::NAN, |spent| spent.as_secs_f64());
        let mut impact = self.run.n_rows();
        for i in 0..self.slots.len() {
            let slot = &self.slots[i];
            // A trial may end before any force acts, or before there is a model.
            let has_begun =
                outcome == TrialOutcome::Failed && slot.fine().is_some() || self.building == Some(i);
            let took_part = slot.monitor.is_running() || has_begun;
            if !took_part {
                continue;
            }
            let facts = &self.model.contacts[i];
            let contact = &self.model.system.forces()[i].contact;
            let sizes = slot.fine().map_or_else(|| self.model.trial_sizes(i), |f| f.sizes);
            let mut utilisation =
                [f64::from(trial.most_active[i]) / contact.facts().n_points().max(1) as f64, 0.0];
            let verdict = verdicts.get(i).and_then(Option::as_ref);
            if let Some(verdict) = verdict.filter(|v| !v.directions.is_empty()) {
                utilisation = [0.0; 2];
                utilisation.iter_mut().zip(&verdict.directions).for_each(|(u, d)| *u = d.utilisation);
            }
            let (row, n_new) = slot.monitor.rows(impact);
            let record = TrialRecord {
                impact: row,
                number: trial.number,
                start: self.work.start,
                stop: self.integrator.time(),
                penalty_start: trial.penalty_start[i],
                penalty_end: contact.facts().penalty(),
                interval_widths: slot.fine().map_or(facts.widths, FineContact::widths),
                utilisation,
                elements: sizes.elements,
                dofs: sizes.dofs,
                interface_dofs: sizes.interface,
                steps: statistics.steps - trial.steps,
                rejected: statistics.rejected - trial.rejected,
                peak_force: slot.monitor.peak_force(),
                outcome,
                reason: reason.into(),
                wall_time: trial.started.elapsed().as_secs_f64(),
                cpu_time,
            };
            self.output.observer.trial(&record)?;
            impact += if slot.monitor.is_running() { n_new } else { 1 };
        }
        Ok(())
    }

    /// Whether every gap is open, those of the contacts that touched in this phase are wider than
    /// before the last step, and no surfaces that touch between contact points close. A contact
    /// that a body flies towards, away from another one, is left to the free phase.
    ///
    /// # Errors
    /// [`AdaptiveError::Contact`] if motions are not finite.
    pub(super) fn is_separating(&mut self) -> Result<bool, AdaptiveError> {
        let near = std::mem::take(&mut self.near);
        let are_open = near.iter().all(|&i| {
            let [before, gap] = self.gaps(i);
            gap > 0.0 && (!self.slots[i].monitor.is_running() || gap > before)
        });
        self.near = near;
        Ok(are_open && !self.are_surfaces_closing()?)
    }

    /// Whether the surfaces of a refined contact that has its fine models touch without opening in
    /// the last step, as [`contact_qs::search::first_touch`] has it.
    fn are_surfaces_closing(&mut self) -> Result<bool, AdaptiveError> {
        let (start, end) = self.integrator.interval();
        for i in 0..self.slots.len() {
            let Some(refinement) = &self.model.contacts[i].refinement else { continue };
            if self.slots[i].fine().is_none() {
                continue;
            }
            let search = &mut self.slots[i].nearest;
            let mut gap = |t: f64, y: &[f64]| -> Result<f64, AdaptiveError> {
                self.model.system.body_states(t, y);
                Ok(refinement.nearest(self.model.system.last_evaluation().0, search)?.gap)
            };
            let (before, now) =
                (gap(start, self.integrator.previous_state())?, gap(end, self.integrator.state())?);
            let touching = TOUCHING * refinement.detector.size();
            let is_overlap = now < -touching && now <= before;
            if is_overlap || now <= touching && now < before - touching {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Shows the end of the last step to the monitors, and the state to the stress requests.
    pub(super) fn update_monitors(&mut self) -> Result<(), AdaptiveError> {
        let (t, y) = (self.integrator.time(), self.integrator.state());
        self.model.system.body_states(t, y);
        for k in 0..self.near.len() {
            let i = self.near[k];
            let now = self.instant(i);
            self.check_contact(i, now.time, -now.motion.along(&now.normal))?;
            let (touch, release) = self.changes(i)?;
            if self.slots[i].monitor.step(now, touch, release) {
                self.note_peak(i);
                let bare = self.bare_forces(i);
                let sample = &self.output.sample;
                let shown = |point: usize| von_mises(&sample.points[point].state.stress);
                let left_out = bare.iter().filter_map(|bare| self.model.left_out_at_points(bare, shown));
                self.slots[i].at_peak.left_out =
                    left_out.reduce(|a, b| if a.1.or_worse(b.1) == a.1 { a } else { b });
            }
        }
        self.update_stress_states();
        Ok(())
    }

    /// Shows the present state to the stress requests.
    pub(super) fn update_stress_states(&mut self) {
        let n = if self.model.n_stress_requests() > 0 { self.slots.len() } else { 0 };
        let bare: Vec<BareForce> = (0..n).flat_map(|i| self.bare_forces(i)).collect();
        let slots = &self.slots;
        let time = self.integrator.time();
        self.model.update_stress_states(&mut self.run.stress, time, |_| true, |i| slots[i].fine(), &bare);
    }

    /// The present force of contact `i` on bodies in which stress is asked for, where their modes alone
    /// tell of it.
    fn bare_forces(&mut self, i: usize) -> Vec<BareForce> {
        let report = *self.model.system.forces()[i].contact.report();
        let (own, target) = self.model.system.forces()[i].contact.facts().bodies();
        let asked =
            [Some(own), target].into_iter().flatten().filter(|body| self.model.is_stress_asked(*body));
        let asked: Vec<usize> = asked.collect();
        let are_modes_alone =
            self.run.contacts[i].is_by_law || self.model.contacts[i].local_field == LocalField::ModesAlone;
        if asked.is_empty() || !are_modes_alone || report.normal_force <= 0.0 {
            return Vec::new();
        }
        let (time, y) = (self.integrator.time(), self.integrator.state());
        let (force, motion) = self.model.system.force_in_motion(time, y, i);
        let place = force.contact.meeting(motion).place;
        let states = self.model.system.last_evaluation().0;
        let on = |body: usize| {
            let flexible = self.model.bodies[body].flexible()?;
            let radius = match flexible.body.model().thickness() {
                Some(thickness) => 0.5 * report.contact_area / thickness,
                None => (report.contact_area / PI).sqrt(),
            };
            let state = &states[body];
            let place = state.rotation.inverse_transform_vector(&(place - state.position)).into();
            Some(BareForce {
                contact: i as u32,
                body: body as u32,
                place,
                force: report.normal_force,
                radius,
            })
        };
        asked.into_iter().filter_map(on).collect()
    }

    /// Shows the states of a force-free step from `start` to `end` to the stress requests of instants
    /// in it.
    pub(super) fn update_free_stress(&mut self, (start, end): (f64, f64)) {
        let times: Vec<f64> = self.model.stress_times().filter(|t| (start..=end).contains(t)).collect();
        for time in times {
            self.integrator.interpolate(time, &mut self.interpolated);
            self.model.system.body_states(time, &self.interpolated);
            let slots = &self.slots;
            let at_time = |at| at == StressInstant::Time(time);
            self.model.update_stress_states(&mut self.run.stress, time, at_time, |i| slots[i].fine(), &[]);
        }
    }

    /// Finds which contacts are near in the last step, and shows its start to those monitors that have not seen it, their
    /// bodies having been far apart before.
    pub(super) fn sort_step(&mut self) {
        self.sort_contacts();
        let ((start, end), system) = (self.integrator.interval(), &mut self.model.system);
        let is_new = |slot: &ContactSlot| {
            matches!(slot.nearness, Nearness::Near { .. }) && !slot.monitor.has_seen(start)
        };
        if !self.near.iter().any(|i| is_new(&self.slots[*i])) {
            return;
        }
        let [before, now] = [self.integrator.previous_state(), self.integrator.state()];
        system.body_states(start, before);
        for &i in &self.near {
            let slot = &mut self.slots[i];
            if !is_new(slot) {
                continue;
            }
            let mut seen = contact_instant(system, (i, &self.model.contacts[i]), start, before);
            (seen.force, seen.penetration) = (0.0, 0.0);
            slot.monitor.see_again(seen);
        }
        system.body_states(end, now);
    }

    /// Begins to monitor the contacts `which` at the present instant; an impact that goes on, in another zone or with another
    /// penalty factor, keeps what its peak was like.
    pub(super) fn begin_monitors(&mut self, which: Range<usize>) -> Result<(), AdaptiveError> {
        self.model.system.body_states(self.integrator.time(), self.integrator.state());
        for i in which {
            let now = self.instant(i);
            self.check_contact(i, now.time, -now.motion.along(&now.normal))?;
            self.begin_trace(i, now.time);
            if !self.slots[i].monitor.is_running() {
                self.slots[i].at_peak = AtPeak::default();
            }
            if self.slots[i].monitor.begin(now) {
                self.note_peak(i);
            }
        }
        Ok(())
    }

    /// Notes how contact `i` presses in the present state, which has the largest force so far.
    fn note_peak(&mut self, i: usize) {
        let (pressure, n_active) =
            (self.mean_pressure(i), self.model.system.forces()[i].contact.report().n_active);
        let at_peak = &mut self.slots[i].at_peak;
        (at_peak.pressure, at_peak.n_active) = (pressure, n_active);
    }

    /// Mean pressure of contact `i`; zero where too few points carry its force to tell, and where
    /// it has no bound \[Pa\].
    fn mean_pressure(&self, i: usize) -> f64 {
        let element = &self.model.system.forces()[i].contact;
        let report = element.report();
        let is_smooth = self.slots[i].fine().is_none_or(|fine| {
            fine.whole.is_none_or(TouchKind::bounds_pressure)
                && fine.zones.iter().all(|zone| zone.site.meets.is_none())
        });
        let has_points = element.facts().point(0).is_none() || report.n_active >= TELLING_POINTS;
        if is_smooth && has_points && report.contact_area > 0.0 {
            report.normal_force / report.contact_area
        } else {
            0.0
        }
    }

    /// What the monitor of contact `i` sees of the present instant, at which the bodies are placed.
    fn instant(&mut self, i: usize) -> ContactInstant {
        let facts = (i, &self.model.contacts[i]);
        contact_instant(&mut self.model.system, facts, self.integrator.time(), self.integrator.state())
    }

    /// When contact `i` closed and opened in the last step, if it did.
    fn changes(&mut self, i: usize) -> Result<(Option<Change>, Option<Change>), AdaptiveError> {
        let [first, last] = self.gaps(i);
        Ok(if first > 0.0 && last <= 0.0 {
            (self.crossing(i, 1.0)?, None)
        } else if first < 0.0 && last >= 0.0 {
            (None, self.crossing(i, -1.0)?)
        } else {
            (None, None)
        })
    }

    /// Motion of the bodies of contact `i` at the place where their surfaces are nearest at `time`,
    /// in the interpolated state: of smooth surfaces that of the search between them, since contact
    /// points stand beside it.
    fn motion_of_touch(&mut self, i: usize, time: f64) -> Result<NearMotion, AdaptiveError> {
        let (slot, system) = (&mut self.slots[i], &mut self.model.system);
        let is_smooth = slot.fine().is_some_and(|fine| fine.touch() == TouchKind::Smooth);
        let Some(refinement) = self.model.contacts[i].refinement.as_ref().filter(|_| is_smooth) else {
            return Ok(near_motion(system, time, &self.interpolated, i));
        };
        system.body_states(time, &self.interpolated);
        let place = refinement.nearest(system.last_evaluation().0, &mut slot.nearest)?.contact.point;
        Ok(motion_at(system, i, &place))
    }

    /// When in the last step `sign` times the gap of contact `i` became zero or less.
    fn crossing(&mut self, i: usize, sign: f64) -> Result<Option<Change>, AdaptiveError> {
        let system = &mut self.model.system;
        let is_alone = self.slots[i].nearness != Nearness::Unknown;
        let gap: fn(&mut System, f64, &[f64], usize) -> f64 = if is_alone { gap_alone } else { smallest_gap };
        let found = self
            .crossing
            .first_crossing(&self.integrator, |t, y| sign * gap(system, t, y, i))
            .map_err(AdaptiveError::Dynamics)?;
        let change = match found {
            Some(c) => {
                self.integrator.interpolate(c.time, &mut self.interpolated);
                Some(Change { time: c.time, motion: self.motion_of_touch(i, c.time)? })
            }
            None => None,
        };
        let (t, y, system) = (self.integrator.time(), self.integrator.state(), &mut self.model.system);
        // The search leaves the bodies at another instant.
        if is_alone {
            gap_alone(system, t, y, i);
        } else {
            system.body_states(t, y);
        }
        Ok(change)
    }
}

/// What the monitor of contact `i` sees at `time` in the state `y`, in which the bodies are placed.
fn contact_instant(
    system: &mut System,
    (i, facts): (usize, &ContactFacts),
    time: f64,
    y: &[f64],
) -> ContactInstant {
    let (place, normal, motion) = normal_motion(system, y, i);
    let report = system.forces()[i].contact.report();
    let (force, penetration, energies) = (report.normal_force, report.penetration, &report.energies);
    let (springs, zones) = (energies.penalty, energies.elastic_high);
    let of_springs = (zones > 0.0).then(|| springs / (springs + zones));
    let hold = hold_at(system, i, (place, facts.has_friction, facts.size));
    let impulse = system.impulse(y, i);
    ContactInstant { time, force, impulse, normal, motion, penetration, of_springs, hold }
}
