//! Fine models of contacts in an impact: when they come and go, and what sizes them.

use std::time::Instant;

use ffr_dynamics::force::active::Active;
use ffr_dynamics::integration::{Integrator, StepSettings};
use ffr_dynamics::system::multibody::error_scale::ErrorScale;

use crate::run::driver::contact_slot::ContactPhase;
use crate::run::driver::impact::Start;
use crate::run::driver::{Driver, NEAR, QUIET_STEPS};
use tracing::debug;

use crate::adaptivity::interval::IntervalAssessment;
use crate::checks::resolution::edge_touch;
use crate::error::AdaptiveError;
use crate::impact::{Activation, FineBasis, FineContact, RefinedContact, RefinementRequest};
use crate::model::RunModel;
use crate::record::{PhaseKind, TransferDirection, ZoneSite, ZoneSize};
use crate::state::observer::Stage;
use crate::state::simulation::RunContact;
use crate::touch::hertz::preview::StandIn;
use crate::touch::parts::TouchKind;

/// Relative error a step of a preview, which only sizes an interval.
const PREVIEW_TOLERANCE: f64 = 1e-6;
/// Steps of a preview without a larger force than before, after which it ends: bodies that rest on
/// each other never part. As many more as it took to the largest force.
const PREVIEW_STEPS: usize = 5000;
/// Steps of a preview at most.
const LONGEST_PREVIEW: usize = 40 * PREVIEW_STEPS;
/// Relative difference of widths up to which the same fine model is used again.
const SAME_WIDTH: f64 = 1e-9;

impl Driver<'_> {
    /// Back to the start of the impact, with fine models of the widths wanted.
    pub(crate) fn rewind(&mut self, start: &Start, sizes: &[Option<ZoneSize>]) -> Result<(), AdaptiveError> {
        self.output.discard_after(start.time);
        self.apart.forget();
        for (slot, (monitor, at_peak)) in self.slots.iter_mut().zip(&start.monitors) {
            slot.monitor.clone_from(monitor);
            slot.at_peak = *at_peak;
        }
        self.run.stress.clone_from(&start.stress);
        self.run.peaks.clone_from(&start.peaks);
        (self.run.numerical, self.run.ledger) = (start.numerical, start.ledger);
        self.run.slow_since = start.slow_since;
        (self.work.part, self.run.n_phases) = (start.part, start.n_phases);
        let by_law = self.run.contacts.iter().zip(self.model.system.forces_mut());
        by_law.filter(|(state, _)| state.is_by_law).for_each(|(_, force)| force.contact.forget());
        let leaving = self.leaving(start.time, sizes);
        for i in self.latest_first() {
            let Some(search) = self.slots[i].fine().map(|fine| fine.search.clone()) else { continue };
            let penalty = search.penalty();
            if !leaving.contains(&i) {
                self.set_penalty(i, penalty)?;
                self.model.system.forces_mut()[i].contact.forget();
                continue;
            }
            if self.has_size(i, sizes[i]) {
                // It is activated again, now or when it touches, and goes on with its search.
                self.slots[i].found.search = Some(search);
            }
            self.deactivate(i)?;
            self.output.discard_transfers_of(i);
        }
        let mut state = start.state.clone();
        // No contact had a fine model then: those that stay begin with zones at rest.
        state.resize(self.model.dimension(), 0.0);
        self.model.to_present_modes(start.time, &mut state)?;
        match self.pace.kind() {
            PhaseKind::Lasting => self.replace_integrator(PhaseKind::Impact, (start.time, &state), 0.0)?,
            PhaseKind::Free | PhaseKind::Impact => self.integrator.restart(start.time, &state),
        }
        self.activate_touching(sizes)?;
        self.integrator.invalidate();
        Ok(())
    }

    /// Contacts whose fine models do not serve the next trial: those with other widths, those that
    /// joined the impact later, and those on a body that loses the modes it had because of one of
    /// them.
    fn leaving(&self, start: f64, sizes: &[Option<ZoneSize>]) -> Vec<usize> {
        let mut leaving = Vec::new();
        for i in self.latest_first().into_iter().rev() {
            let Some(fine) = self.slots[i].fine() else { continue };
            let (body, target) = self.model.system.forces()[i].contact.facts().bodies();
            let hosts = leaving.iter().filter_map(|&k: &usize| self.slots[k].fine());
            let is_guest = hosts.flat_map(|f| &f.hosted).any(|b| *b == body || Some(*b) == target);
            if is_guest || fine.activation.time > start || !self.has_size(i, sizes[i]) {
                leaving.push(i);
            }
        }
        leaving
    }

    /// Whether the fine model of contact `i` has the size wanted.
    pub(crate) fn has_size(&self, i: usize, wanted: Option<ZoneSize>) -> bool {
        let fine = self.slots[i].fine();
        if self.slots[i]
            .found
            .reach
            .zip(fine.and_then(FineContact::wider))
            .is_some_and(|(reach, next)| reach >= next)
            || self.slots[i].lacks_zone()
        {
            return false;
        }
        let wanted = match wanted.filter(|_| !self.slots[i].found.keeps_sides) {
            None => return true,
            Some(ZoneSize::Whole) => return fine.is_some_and(|fine| fine.whole.is_some()),
            Some(ZoneSize::Interval { widths, finer }) => {
                if fine.is_some_and(|fine| (fine.finer() / finer - 1.0).abs() > SAME_WIDTH) {
                    return false;
                }
                widths
            }
        };
        let refinement = self.model.contacts[i].refinement.as_ref();
        let granted = refinement.map_or(wanted, |r| r.granted(&self.model.bodies, wanted));
        let mut widths = fine.map_or([0.0; 2], FineContact::widths).into_iter().zip(granted);
        widths.all(|(a, b)| a == 0.0 || (a / b - 1.0).abs() < SAME_WIDTH)
    }

    /// Contacts with fine models, the last one to come first: modes of bodies are given back in the
    /// reverse order.
    pub(crate) fn latest_first(&self) -> Vec<usize> {
        let numbered = self.slots.iter().enumerate();
        let mut list: Vec<(u64, usize)> =
            numbered.filter_map(|(i, slot)| Some((slot.fine()?.activation.number, i))).collect();
        list.sort_unstable_by(|a, b| b.cmp(a));
        list.into_iter().map(|(_, i)| i).collect()
    }

    /// The refined contacts that touch in the present state without having a fine model.
    pub(crate) fn touching(&mut self) -> Result<Vec<usize>, AdaptiveError> {
        let mut touching = Vec::new();
        for i in 0..self.slots.len() {
            if self.slots[i].is_watching() && !self.is_apart(i)? {
                touching.push(i);
            }
        }
        Ok(touching)
    }

    /// Gives every refined contact that touches in the present state its fine model.
    pub(crate) fn activate_touching(&mut self, sizes: &[Option<ZoneSize>]) -> Result<(), AdaptiveError> {
        for i in self.touching()? {
            self.activate(i, sizes[i])?;
        }
        Ok(())
    }

    /// Whether refined contact `i` is farther from touching than detection resolves.
    pub(crate) fn is_apart(&mut self, i: usize) -> Result<bool, AdaptiveError> {
        let (t, y) = (self.integrator.time(), self.integrator.state());
        self.model.system.body_states(t, y);
        let states = self.model.system.last_evaluation().0;
        let Some(refinement) = &self.model.contacts[i].refinement else { return Ok(true) };
        let nearest = refinement.nearest(states, &mut self.slots[i].nearest)?;
        Ok(nearest.gap > NEAR * refinement.detector.size())
    }

    /// Puts the fine model of contact `i` about the present nearest points into the system.
    pub(crate) fn activate(&mut self, i: usize, size: Option<ZoneSize>) -> Result<(), AdaptiveError> {
        let began = Instant::now();
        self.building = Some(i);
        let fixed = self.bodies_in_contact();
        let (t, y) = (self.integrator.time(), self.integrator.state());
        self.model.system.body_states(t, y);
        let states = self.model.system.last_evaluation().0;
        let Some(refinement) = &self.model.contacts[i].refinement else { return Ok(()) };
        let slot = &mut self.slots[i];
        let mut touch = refinement.touch(&self.model.bodies, states, &mut slot.nearest)?;
        match &slot.found.touches[..] {
            [first, _, ..] => (touch.nearest.contact, touch.nearest.target) = (first.contact, first.target),
            _ => slot.found.touches = vec![touch.nearest],
        }
        // Points about another place are those of another model.
        let mut request = RefinementRequest {
            size: size.filter(|_| !slot.found.keeps_sides),
            reach: slot.found.reach,
            ahead: slot.found.ahead,
            others: &slot.found.touches[1..],
            peak: slot.found.preview,
            history: self.run.contacts[i].history,
            search: None,
            activation: Activation { time: t, number: self.run.n_refined + 1 },
            points: &self.model.observed.points,
            fixed: &fixed,
        };
        if slot.found.keeps_sides || refinement.keeps_sides(&self.model.bodies, states, &touch, &request)? {
            slot.found.keeps_sides = true;
            request.size = None;
            touch = refinement.on_own_sides(&self.model.bodies, states, touch, request.peak);
        }
        let whole = refinement.whole_at(&touch, request.size)?;
        let site = ZoneSite {
            part: whole.and_then(|_| refinement.parts(&self.model.bodies, states, &touch, &request)[0]),
            ..refinement.whole_site(&self.model.bodies, states, &touch, whole)
        };
        let serves = |fine: &FineContact| {
            whole.is_some() && fine.whole == whole && fine.zones.first().is_some_and(|zone| zone.site == site)
        };
        if let Some((mut element, mut fine)) = slot.whole.take_if(|(_, fine)| serves(fine)) {
            let (search, bodies) = (slot.found.search.take(), (self.model.bodies.as_slice(), states));
            refinement.begin_again(
                (element.contact.as_mut(), &mut fine),
                search,
                request.activation,
                bodies,
            )?;
            fine.overlap = (0.0 - touch.nearest.gap).max(0.0);
            return self.enter((i, element), fine, Vec::new());
        }
        request.search = slot.found.search.take();
        let observer = &mut *self.output.observer;
        observer.stage(fine_models(self.model, i));
        let mut check_cancel =
            || if observer.is_interrupted() { Err(AdaptiveError::Interrupted) } else { Ok(()) };
        let refined = refinement.refine(&self.model.bodies, states, &touch, request, &mut check_cancel);
        observer.stage(Stage::Motion);
        if refined
            .as_ref()
            .is_err_and(|error| refinement.may_keep_sides(touch.kind, &self.model.bodies, error))
        {
            slot.found.keeps_sides = true;
            return self.activate(i, None);
        }
        let RefinedContact { element, recovery, bases, contact } = refined?;
        let facts = &self.model.contacts[i];
        let element = RunContact::new(element).with_pressures(Some(recovery)).with_damping(facts.damping);
        let element =
            element.map_err(|source| AdaptiveError::Contact { contact: facts.name.clone(), source })?;
        self.enter((i, element), Box::new(contact), bases)?;
        self.model.timings.reduction += began.elapsed().as_secs_f64();
        Ok(())
    }

    /// Puts `element` and its fine models, with the modes of `bases`, into the system as contact
    /// `i`.
    fn enter(
        &mut self,
        (i, element): (usize, RunContact),
        fine: Box<FineContact>,
        bases: Vec<(usize, FineBasis)>,
    ) -> Result<(), AdaptiveError> {
        let before = self.present_balance()?;
        let t = self.integrator.time();
        self.replace_contact(i, element)?;
        self.building = None;
        self.run.n_refined += 1;
        if fine.whole.is_some_and(|kind| !kind.bounds_pressure()) {
            self.model.system.body_states(t, self.integrator.state());
            let (contact, states) = (&self.model.contacts[i], self.model.system.last_evaluation().0);
            let place = contact.refinement.as_ref().zip(self.slots[i].found.touches.first());
            let is_across = place.is_some_and(|(refinement, nearest)| {
                refinement.lies_across(&self.model.bodies, states, nearest)
            });
            let found = edge_touch(
                (&contact.name, t),
                (&self.model.bodies[contact.body], fine.zones.first().map(|zone| &zone.site)),
                contact.target.body().filter(|_| is_across).map(|target| &self.model.bodies[target]),
                self.slots[i].found.keeps_sides,
            );
            self.warn(found.map(|warning| (i, warning)).into_iter().collect())?;
        }
        self.slots[i].phase = ContactPhase::Fine(fine);
        if !bases.is_empty() {
            let mut y = self.integrator.state().to_vec();
            for (body, basis) in bases {
                self.model.enter_fine_modes(body, basis, (t, &mut y))?;
            }
            self.forget_searches();
            self.integrator.restart(t, &y);
        }
        let after = self.present_balance()?;
        self.record_transfer(i, TransferDirection::CoarseToFine, &before, &after);
        Ok(())
    }

    /// Puts `element` in the place of contact `i`, whose element is returned; the coordinates that
    /// it has of its own start at rest.
    pub(super) fn replace_contact(
        &mut self,
        i: usize,
        element: RunContact,
    ) -> Result<RunContact, AdaptiveError> {
        let n = 2 * element.n_coordinates();
        let place = self.model.system.coordinates_of_force(i);
        self.apart.forget();
        let left = std::mem::replace(&mut self.model.system.forces_mut()[i], element);
        if !place.is_empty() || n > 0 {
            let (t, mut y) = (self.integrator.time(), self.integrator.state().to_vec());
            y.splice(place, std::iter::repeat_n(0.0, n));
            self.resize(t, &y)?;
        }
        Ok(left)
    }

    /// Bodies that take part in contacts with fine models.
    fn bodies_in_contact(&self) -> Vec<usize> {
        let contacts = self.model.system.forces().iter().zip(&self.slots);
        let active = contacts.filter(|(_, slot)| slot.fine().is_some());
        let bodies = active.map(|(force, _)| force.contact.facts().bodies());
        bodies.flat_map(|(body, target)| [Some(body), target]).flatten().collect()
    }

    /// Takes the fine model of contact `i` out of the system, and gives its bodies the modes that
    /// they had before.
    pub(crate) fn deactivate(&mut self, i: usize) -> Result<(), AdaptiveError> {
        let fine = self.slots[i].take_fine();
        let inactive = StandIn::inactive(self.model.system.forces()[i].contact.facts().bodies());
        let mut left = self.replace_contact(i, RunContact::new(Box::new(Active::new(inactive))))?;
        self.model.contact_time += left.take_elapsed().as_secs_f64();
        let Some(mut fine) = fine else { return Ok(()) };
        let hosted = std::mem::take(&mut fine.hosted);
        if fine.whole.is_some() && !self.model.changes_modes() {
            self.slots[i].whole = Some((left, fine));
        }
        if hosted.is_empty() {
            return Ok(());
        }
        let (t, mut y) = (self.integrator.time(), self.integrator.state().to_vec());
        for body in hosted {
            self.model.leave_fine_modes(body, (t, &mut y))?;
        }
        self.forget_searches();
        self.integrator.restart(t, &y);
        Ok(())
    }

    /// Keeps widths and penalty factors of an accepted impact for the next ones.
    pub(crate) fn record_history(&mut self, verdicts: &[Option<IntervalAssessment>]) {
        let mut ratios = Vec::new();
        for (i, verdict) in verdicts.iter().enumerate() {
            let (Some(fine), Some(verdict), false) =
                (self.slots[i].fine(), verdict, self.slots[i].found.travels)
            else {
                continue; // zones of contact that goes on are as long as its way
            };
            let Some(refinement) = &self.model.contacts[i].refinement else { continue };
            if fine.touch() != TouchKind::Smooth {
                continue; // its zones and its penalty factor say nothing about smooth surfaces
            }
            let history = refinement.history(fine, verdict, fine.search.penalty());
            ratios.extend(history.stiffness_ratio.map(|ratio| (ratio, refinement.search_kind())));
            self.run.contacts[i].history = history;
        }
        // The ratio has no unit: contacts that have none and search in the same way start from it,
        // too.
        for (contact, state) in self.model.contacts.iter().zip(&mut self.run.contacts) {
            let Some(refinement) = &contact.refinement else { continue };
            let same = ratios.iter().find(|(_, search)| *search == refinement.search_kind());
            if let Some((ratio, _)) = same {
                state.history.stiffness_ratio.get_or_insert(*ratio);
            }
        }
    }

    /// Notes peak forces of the refined contacts `which`, which touch, and of those that bodies
    /// come into meanwhile, and until when there is force, if Hertz's law, or that of a line contact, held in their contact zones:
    /// from one run with the dynamic modes alone, to the end of the simulated time at most. Nothing is
    /// noted while other contacts are closed, or where there is no law.
    pub(crate) fn preview(&mut self, which: &[usize]) -> Result<(), AdaptiveError> {
        let (t, y) = (self.integrator.time(), self.integrator.state().to_vec());
        if self.model.system.forces().iter().any(|f| !f.is_idle()) {
            return Ok(());
        }
        let all = (0..self.slots.len()).collect();
        let touching = |i| which.contains(&i);
        let (peaks, pressed) =
            self.under_laws(all, touching, &y, |driver, places| driver.preview_peaks(places, t, &y))?;
        for ((i, _), (peak, until)) in pressed.into_iter().zip(peaks?) {
            debug!(contact = self.model.contacts[i].name, peak, until, "preview");
            if peak > 0.0 || which.contains(&i) {
                (self.slots[i].found.preview, self.slots[i].found.presses_until) = (Some(peak), until);
            }
        }
        Ok(())
    }

    /// Does `action` with Hertz's law, or that of a line, in place of those contacts of `which` that have one in the state `y`, and
    /// tells it which these are; with what it returns, they and the forces that their laws have at the end. Of those that are not
    /// `touching`, which may be no contacts of smooth surfaces, nothing need be known.
    ///
    /// # Errors
    /// [`AdaptiveError`] where a touch is none of smooth surfaces that it should be.
    pub(in crate::run::driver) fn under_laws<T>(
        &mut self,
        which: Vec<usize>,
        touching: impl Fn(usize) -> bool,
        y: &[f64],
        action: impl FnOnce(&mut Self, &[usize]) -> T,
    ) -> Result<(T, Vec<(usize, f64)>), AdaptiveError> {
        let RunModel { system, contacts, bodies, .. } = &mut *self.model;
        system.body_states(self.integrator.time(), y);
        let mut laws = Vec::new();
        for i in which {
            let Some(refinement) = &contacts[i].refinement else { continue };
            let (states, search) = (system.last_evaluation().0, &mut self.slots[i].nearest);
            let law = match refinement.preview((bodies, touching(i)), states, search) {
                Err(_) if !touching(i) => None,
                law => law?,
            };
            laws.extend(law.map(|law| (i, RunContact::new(Box::new(Active::new(law))))));
        }
        for (i, law) in &mut laws {
            std::mem::swap(law, &mut system.forces_mut()[*i]);
        }
        let places: Vec<usize> = laws.iter().map(|(i, _)| *i).collect();
        let outcome = action(self, &places);
        let forces = self.model.system.forces_mut();
        let pressed = laws.into_iter().map(|(i, contact)| {
            let law = std::mem::replace(&mut forces[i], contact);
            (i, law.contact.report().normal_force)
        });
        Ok((outcome, pressed.collect()))
    }

    /// For each of the contacts `which` its largest force \[N\], and until when there is one, infinite where that is not
    /// known \[s\].
    fn preview_peaks(
        &mut self,
        which: &[usize],
        t: f64,
        y: &[f64],
    ) -> Result<Vec<(f64, f64)>, AdaptiveError> {
        let system = &mut self.model.system;
        let scale = system.error_scale();
        let coarse = ErrorScale { relative: scale.relative.max(PREVIEW_TOLERANCE), ..scale };
        system.set_error_scale(coarse).map_err(AdaptiveError::Dynamics)?;
        let steps = StepSettings::with_max_step(self.impact_step);
        let mut integrator = Integrator::explicit(steps, t, y).map_err(AdaptiveError::Dynamics)?;
        let quiet = self.settings.quiet_time.unwrap_or(QUIET_STEPS * self.impact_step);
        let (mut peaks, mut last_force, mut latest) = (vec![0.0_f64; which.len()], t, 0);
        let mut until = f64::INFINITY;
        let end = self.settings.end_time;
        for n in 0..LONGEST_PREVIEW {
            let is_idle = which.is_empty() || integrator.time() >= end;
            let is_over = is_idle || n - latest > PREVIEW_STEPS.max(latest);
            if is_over || self.output.observer.is_interrupted() || integrator.step(system, end).is_err() {
                break;
            }
            for (peak, i) in peaks.iter_mut().zip(which) {
                let force = system.forces()[*i].contact.report().normal_force;
                if force > *peak {
                    (*peak, latest) = (force, n);
                }
                if force > 0.0 {
                    last_force = integrator.time();
                }
            }
            // A surface that springs back may let go for a moment: over it is as an impact phase
            // is. Bodies that rest on each other wait for the one that comes.
            let has_begun = peaks.iter().any(|peak| *peak > 0.0);
            if has_begun && integrator.time() - last_force >= quiet {
                until = last_force;
                break;
            }
        }
        system.set_error_scale(scale).map_err(AdaptiveError::Dynamics)?;
        Ok(peaks.into_iter().map(|peak| (peak, until)).collect())
    }
}

/// The building of fine models for contact `i`.
fn fine_models(model: &RunModel, i: usize) -> Stage<'_> {
    let (body, target) = model.system.forces()[i].contact.facts().bodies();
    let flexible = |body: usize| model.bodies[body].flexible().map(|flexible| flexible.name());
    let body = flexible(body).unwrap_or_default();
    Stage::FineModels { contact: &model.contacts[i].name, body, target: target.and_then(flexible) }
}
