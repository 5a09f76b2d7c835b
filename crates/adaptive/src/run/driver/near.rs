//! Which contacts may have met in the last step, and when their gaps became zero.
//!
//! A run of many bodies has far more contacts than bodies near each other. What a contact costs in a step is decided
//! here: nothing but a distance, if its bodies were too far apart.

use contact_qs::search::{TouchSettings, first_touch};
use ffr_dynamics::force::BodyState;
use ffr_dynamics::integration::{Crossing, DenseOutput, Slope};

use super::{Driver, EVENT_TOLERANCE, SHORTEST_LOOK, TOUCHING};
use crate::error::AdaptiveError;
use crate::impact::{AdaptiveContact, FineContact};
use crate::run::driver::contact_slot::{ContactSlot, Nearness};
use crate::state::simulation::{System, gap_alone, gap_as_placed, smallest_gap};
use crate::touch::detection::{BETWEEN_INSTANTS, Clearance};

/// How many times the way that bodies may have closed in a step they are apart to be left out: monitors of impacts then
/// see them some steps before they touch.
const FAR: f64 = 4.0;

impl Driver<'_> {
    /// The contacts that have fine models at present, with these.
    pub(super) fn refined(&self) -> impl Iterator<Item = (usize, &FineContact)> {
        self.refinable.iter().filter_map(|&i| Some((i, self.slots[i].fine()?)))
    }

    /// Finds which of the contacts with a model were far from a touch throughout the last step, and the gaps at its ends
    /// of others that have them in closed form; lists those that were not far. Leaves the bodies at its end.
    ///
    /// With clearances `c0` and `c1` at the ends of a step of `h`, and origins that move at `v` relative to each other at
    /// most, the clearance is at least `(c0 + c1 - v h) / 2` in between (theory section C, spheres that are far apart).
    pub(super) fn sort_contacts(&mut self) {
        let (start, end) = self.integrator.interval();
        let mut which = std::mem::take(&mut self.near);
        which.clear();
        let is_known = self.list_not_apart(&mut which);
        if !is_known {
            which.extend(0..self.slots.len());
        }
        let [y0, y1] = [self.integrator.previous_state(), self.integrator.state()];
        let system = &mut self.model.system;
        // Whether there is a closed form does not depend on the motion.
        let is_any = which.iter().any(|i| clearance(system, *i).is_some());
        if !is_any || end <= start {
            for i in &which {
                self.slots[*i].nearness = self.slots[*i].without_distance();
            }
            which.retain(|i| self.slots[*i].nearness != Nearness::Far);
            self.near = which;
            return;
        }
        system.body_states(end, y1);
        for &i in &which {
            let slot = &mut self.slots[i];
            slot.nearness = slot.without_distance();
            if let Some((clearance, speed)) = clearance(system, i) {
                slot.clearance = Clearance { gap: clearance, time: end, speed };
                slot.nearness = Nearness::Near { gaps: [clearance; 2], slope: Slope::UNKNOWN };
            }
        }
        system.body_states(start, y0);
        for &i in &which {
            let slot = &mut self.slots[i];
            let Nearness::Near { gaps, slope } = &mut slot.nearness else { continue };
            let Some((clearance, speed)) = clearance(system, i) else {
                slot.nearness = Nearness::Unknown;
                continue;
            };
            let last = slot.clearance;
            slope.fastest = BETWEEN_INSTANTS * speed.max(last.speed);
            let way = slope.fastest * (end - start);
            let is_far = clearance.min(last.gap) > 0.0 && clearance + last.gap > FAR * way;
            if is_far && !slot.monitor.is_running() {
                slot.nearness = Nearness::Far;
            } else {
                gaps[0] = gap_as_placed(system, y0, i);
            }
        }
        let states = system.body_states(end, y1);
        if !is_known && self.slots.len() > states.len() {
            let (slots, states) = (&self.slots, system.last_evaluation().0);
            let far = |i: usize| clearance(system, i).filter(|_| slots[i].nearness == Nearness::Far);
            self.apart.sort(slots.len(), states, |i| far(i).map(|(clearance, _)| clearance));
        }
        which.retain(|i| self.slots[*i].nearness != Nearness::Far);
        for &i in &which {
            let slot = &mut self.slots[i];
            if let Nearness::Near { gaps, slope } = &mut slot.nearness {
                gaps[1] = gap_as_placed(system, y1, i);
                // Beside the frames that move centres of spheres turn with them.
                slope.jump = gaps[1] - slot.clearance.gap;
            }
        }
        self.near = which;
    }

    /// Lists the contacts that may not have been far apart throughout the last step, if that is known without a look at
    /// each: others have more than [`FAR`] times the way that the fastest two bodies may have closed in it. Where there
    /// are no more contacts than bodies, a look at each costs no more.
    fn list_not_apart(&mut self, which: &mut Vec<usize>) -> bool {
        let ((start, end), system) = (self.integrator.interval(), &mut self.model.system);
        let [y0, y1] = [self.integrator.previous_state(), self.integrator.state()];
        let fastest =
            |states: &[BodyState]| states.iter().map(|state| state.velocity.norm()).fold(0.0, f64::max);
        if self.slots.len() <= system.model().bodies.len() {
            return false;
        }
        let speed = fastest(system.body_states(end, y1));
        let states = system.body_states(start, y0);
        let margin = FAR * BETWEEN_INSTANTS * speed.max(fastest(states)) * (end - start);
        let is_known = self.apart.near(states, margin).is_some()
            && self.apart.near(system.body_states(end, y1), margin).is_some_and(|near| {
                which.extend_from_slice(near);
                true
            });
        if !is_known {
            self.apart.forget();
        }
        is_known
    }

    /// Gaps of contact `i` at both ends of the last step.
    pub(super) fn gaps(&mut self, i: usize) -> [f64; 2] {
        if let Nearness::Near { gaps, .. } = self.slots[i].nearness {
            return gaps;
        }
        let (system, (start, end)) = (&mut self.model.system, self.integrator.interval());
        let first = smallest_gap(system, start, self.integrator.previous_state(), i);
        [first, smallest_gap(system, end, self.integrator.state(), i)]
    }

    /// When the gaps of the contacts `which` first became zero in the last step, of those that did. Each is looked at by
    /// itself, for the least gap of all would hide that one that is not the least dips; those in closed form are
    /// evaluated together at the instants that all searches look at.
    ///
    /// # Errors
    /// [`AdaptiveError::Dynamics`] if a gap is not a number.
    pub(super) fn first_crossings(
        &mut self,
        which: &[usize],
    ) -> Result<Vec<(usize, Crossing)>, AdaptiveError> {
        let (integrator, system, slots) = (&self.integrator, &mut self.model.system, &self.slots);
        let together: Vec<usize> =
            which.iter().copied().filter(|i| slots[*i].nearness != Nearness::Unknown).collect();
        let mut known = vec![Vec::new(); self.crossing.n_instants()];
        let mut found = Vec::new();
        for &i in which {
            let place = together.binary_search(&i).ok();
            let slope = match slots[i].nearness {
                Nearness::Near { slope, .. } => slope,
                Nearness::Unknown | Nearness::Far => Slope::UNKNOWN,
            };
            let search = self.crossing.first_crossing_of(integrator.interval(), slope, |t, instant, y| {
                let Some((instant, place)) = instant.zip(place) else {
                    integrator.interpolate(t, y);
                    return if place.is_some() {
                        gap_alone(system, t, y, i)
                    } else {
                        smallest_gap(system, t, y, i)
                    };
                };
                let gaps = &mut known[instant];
                if gaps.is_empty() {
                    integrator.interpolate(t, y);
                    system.body_states(t, y);
                    gaps.extend(together.iter().map(|i| gap_as_placed(system, y, *i)));
                }
                gaps[place]
            });
            found.extend(search.map_err(AdaptiveError::Dynamics)?.map(|crossing| (i, crossing)));
        }
        Ok(found)
    }

    /// Last time in the step from `start` to `end` before any contact closes; `None` if none does.
    pub(super) fn first_closing(&mut self, (start, end): (f64, f64)) -> Result<Option<f64>, AdaptiveError> {
        self.sort_contacts();
        let is_open = |i: &usize| !self.slots[*i].is_watching();
        let near: Vec<usize> = self.near.iter().copied().filter(is_open).collect();
        let closing = self.first_crossings(&near)?.into_iter().map(|(_, c)| c.before).reduce(f64::min);
        let touch = self.first_touch((start, end))?.map(|(_, time)| time);
        Ok([closing, touch].into_iter().flatten().reduce(f64::min))
    }

    /// The watched contacts, which are refined at a touch, whose surfaces may have met in the last step.
    fn without_clearance(&mut self, (start, end): (f64, f64)) -> Vec<usize> {
        let watching = self.refinable.iter().copied().filter(|i| self.slots[*i].is_watching());
        let mut close: Vec<usize> = watching.collect();
        let [before, now] = [self.integrator.previous_state(), self.integrator.state()];
        let is_unknown = |i: &&usize| self.slots[**i].clearance.time.to_bits() != start.to_bits();
        let unknown: Vec<usize> = close.iter().filter(is_unknown).copied().collect();
        let (slots, contacts, system) = (&mut self.slots, &self.model.contacts, &mut self.model.system);
        let mut holds = |i: usize, t: f64, states: &[BodyState]| {
            contacts[i].refinement.as_ref().is_none_or(|AdaptiveContact { detector, .. }| {
                slots[i].clearance.go_on(detector, (t, states), TOUCHING * detector.size())
            })
        };
        if !unknown.is_empty() {
            let states = system.body_states(start, before);
            for i in unknown {
                holds(i, start, states);
            }
        }
        if !close.is_empty() {
            let states = system.body_states(end, now);
            close.retain(|i| !holds(*i, end, states));
        }
        close
    }

    /// The first watched contact, which is refined at a touch, to touch in the last step, and the last time before.
    pub(super) fn first_touch(
        &mut self,
        (start, end): (f64, f64),
    ) -> Result<Option<(usize, f64)>, AdaptiveError> {
        let which = self.without_clearance((start, end));
        let mut earliest: Option<(usize, f64)> = None;
        let mut y = vec![0.0; if which.is_empty() { 0 } else { self.interpolated.len() }];
        for i in which {
            let Some(refinement) = &self.model.contacts[i].refinement else { continue };
            let detector = &refinement.detector;
            let until = earliest.map_or(end, |(_, t)| t);
            let ContactSlot { clearance, nearest: search, .. } = &mut self.slots[i];
            let settings = TouchSettings {
                gap: TOUCHING * detector.size(),
                time: EVENT_TOLERANCE * self.impact_step.min(end - start),
                shortest: SHORTEST_LOOK * (end - start),
                acceleration: self.settings.gravity.norm(),
            };
            let (integrator, system) = (&self.integrator, &mut self.model.system);
            let touch = first_touch([start, until], &settings, |t| {
                integrator.interpolate(t, &mut y);
                system.body_states(t, &y);
                let states = system.last_evaluation().0;
                let (gap, speed) =
                    (search.nearest(detector, states)?.gap, detector.closing_speed_bound(states));
                // The last look is at the end of the step if there is no touch.
                *clearance = Clearance { gap, time: t, speed };
                Ok((gap, speed))
            });
            let touch = touch
                .map_err(|source| AdaptiveError::Contact { contact: refinement.name.clone(), source })?;
            if let Some(touch) = touch {
                earliest = Some((i, touch.time));
            }
        }
        Ok(earliest)
    }
}

/// Clearance of contact `i`, and the speed at which the frames of its bodies move relative to each other, as they are
/// placed; none if it has no closed form.
fn clearance(system: &System, i: usize) -> Option<(f64, f64)> {
    let (states, contact) = (system.last_evaluation().0, &system.forces()[i].contact);
    let clearance = contact.clearance(states)?;
    let (body, target) = contact.facts().bodies();
    let speed = |state: &BodyState, other: Option<&BodyState>| match other {
        Some(other) => (state.velocity - other.velocity).norm(),
        None => state.velocity.norm(),
    };
    Some((clearance, speed(&states[body], target.map(|target| &states[target]))))
}
