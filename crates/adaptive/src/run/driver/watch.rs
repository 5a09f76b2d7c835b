//! The watch of a run: no bodies go through each other, whatever their contacts say (docs/theory.md
//! Eq. P.12).

use contact_qs::Meeting;

use super::Driver;
use crate::checks::watch::{Seen, Unknown, WatchedPair};
use crate::error::AdaptiveError;
use crate::record::finding::Components;
use crate::record::{MOST_TOUCHES, PhaseKind};
use crate::touch::detection::Nearest;

/// Overlap that says nothing, as a share of the size of the smaller body: far above what detection
/// leaves, 1e-12 of the larger one.
const SMALL: f64 = 1e-6;
/// Overlap that says nothing, as a share of the width of a contact zone: bodies that are curved by
/// twice the width lie so deep in each other before the first of ten points touches.
const BETWEEN_POINTS: f64 = 1e-3;
/// Overlap that says nothing, as a share of the size of bodies with contact on their whole
/// surfaces; the height of the surface between its points is added.
const ON_SURFACES: f64 = 1e-4;

impl Driver<'_> {
    /// Begins to watch another phase, or another trial of one.
    pub(super) fn begin_watch(&mut self) {
        self.watched.iter_mut().for_each(WatchedPair::begin);
    }

    /// Looks at the surfaces of every pair in the state `interpolated` at time `t`, in impact
    /// phases the fewer the longer they last.
    ///
    /// # Errors
    /// [`AdaptiveError::PassedThrough`] if bodies lie deep in each other and their contact does not know.
    pub(super) fn watch(&mut self, t: f64, kind: PhaseKind) -> Result<(), AdaptiveError> {
        let mut is_placed = false;
        for i in 0..self.watched.len() {
            if kind == PhaseKind::Free || self.watched[i].is_due(t - self.work.start) {
                if !is_placed {
                    self.model.system.body_states(t, &self.interpolated);
                    is_placed = true;
                }
                let (last, told) = self.look(i, t)?;
                // In a free phase no contact is to come: what overlaps now is a fault now.
                let unknown =
                    told.or_else(|| self.watched[i].unknown(last).filter(|_| kind == PhaseKind::Free));
                unknown.map_or(Ok(()), |unknown| Err(self.passed_through(i, unknown)))?;
            }
        }
        Ok(())
    }

    /// Looks once more at the end of a phase, and back at all of it.
    ///
    /// # Errors
    /// As [`Driver::watch`].
    pub(super) fn end_watch(&mut self) -> Result<(), AdaptiveError> {
        let t = self.integrator.time();
        self.interpolated.copy_from_slice(self.integrator.state());
        self.model.system.body_states(t, &self.interpolated);
        for i in 0..self.watched.len() {
            let (last, told) = self.look(i, t)?;
            let unknown = told.or_else(|| self.watched[i].unknown(last));
            unknown.map_or(Ok(()), |unknown| Err(self.passed_through(i, unknown)))?;
        }
        Ok(())
    }

    /// Whether the next trial of the impact lays another zone about the places `nearest`: there the bodies of contact `i` lie in each
    /// other by more than says nothing, beside the present zones.
    pub(super) fn adds_zone(&mut self, i: usize, nearest: &Nearest) -> bool {
        let (slot, refinement) = (&self.slots[i], &self.model.contacts[i].refinement);
        let (Some(fine), Some(refinement)) = (slot.fine(), refinement) else { return false };
        let least = (BETWEEN_POINTS * fine.widths()[0]).max(SMALL * refinement.detector.least_size());
        let is_beside = nearest.gap < -least && refinement.is_beside(&self.model.bodies, fine, nearest);
        let may_be = !refinement.is_width_given() && slot.found.touches.len() < MOST_TOUCHES;
        let adds = is_beside && may_be && !slot.lacks_zone();
        if adds {
            self.slots[i].found.touches.push(*nearest);
        }
        adds
    }

    /// The present overlap of contact `i`, the bodies being placed in the state `interpolated`, with the overlap that the contact sees, if it is above
    /// what says nothing; and the unknown overlap, if it is to end the run at once.
    fn look(&mut self, i: usize, t: f64) -> Result<(Option<Unknown>, Option<Unknown>), AdaptiveError> {
        let least = self.unresolved(i);
        let facts = &self.model.contacts[i];
        let states = self.model.system.last_evaluation().0;
        let found = self.watched[i].overlap(&facts.name, facts.refinement.as_ref(), (t, states))?;
        let nearest = found.and_then(|overlap| overlap.nearest);
        if nearest.is_some_and(|nearest| self.adds_zone(i, &nearest)) || self.slots[i].lacks_zone() {
            return Ok((None, None));
        }
        let Some(overlap) = found.filter(|overlap| overlap.depth > least) else { return Ok((None, None)) };
        let (contact, motion) = self.model.system.force_as_placed(&self.interpolated, i);
        // Zones that vibrate have given way in coordinates of their own.
        let has_given_way = contact.n_coordinates() > 0 && contact.contact.report().normal_force > 0.0;
        let Meeting { gap, place, .. } = contact.contact.meeting(motion);
        let depth = if has_given_way { overlap.depth } else { -gap };
        let element = contact.contact.facts();
        let areas = (0..element.n_points()).filter_map(|k| element.point(k));
        let spacing = areas.fold(0.0, |largest: f64, (_, area)| largest.max(area)).sqrt();
        let told = self.watched[i].note((t, least), overlap, Seen { depth, place, spacing });
        Ok((Some(Unknown { time: t, overlap, known: depth.max(0.0) }), told))
    }

    /// Overlap that the points of contact `i` may leave unseen \[m\].
    fn unresolved(&self, i: usize) -> f64 {
        let facts = &self.model.contacts[i];
        let fine = self.slots[i].fine();
        let last = self.run.contacts[i].history.zones[0].and_then(|zone| zone.size.widths());
        let width = fine.map_or(facts.widths[0].max(last.map_or(0.0, |w| w[0])), |f| f.widths()[0]);
        let of_zone = match fine {
            Some(fine) if fine.whole.is_some() => {
                ON_SURFACES * width + self.model.bodies[facts.body].height_between_points()
            }
            fine => BETWEEN_POINTS * width + 2.0 * fine.map_or(0.0, |fine| fine.offset.abs()),
        };
        of_zone.max(SMALL * self.watched[i].size(facts.refinement.as_ref())).max(facts.allowed_overlap)
    }

    fn passed_through(&self, i: usize, unknown: Unknown) -> AdaptiveError {
        let facts = &self.model.contacts[i];
        let named = |other: usize| format!("body \"{}\"", self.model.bodies[other].name);
        let target = facts.target.body().map_or_else(|| "the plane".to_owned(), named);
        // Contacts with one model for the whole run have their places by what the scenario gives.
        let given = match &facts.refinement {
            Some(refinement) if refinement.has_width() => Some("interval.width"),
            Some(_) => None,
            None => Some("model"),
        };
        let name = &facts.name;
        let is_interval = self.slots[i].fine().is_some_and(|fine| fine.whole.is_none());
        let remedy = match given {
            _ if self.is_rigid(i) => {
                "no contact point of either stands there, as where edges cross between theirs: take one of them as flexible".into()
            }
            Some(key) => {
                format!("leave contacts.{name}.{key} out, so that the program finds where they touch")
            }
            None if is_interval => format!(
                "zones lie about {MOST_TOUCHES} touches of a pair at once at most; take contacts.{name}.model = \"quasistatic\", an interval.width that holds them all, and discretisation.refine of the bodies at each"
            ),
            None => "give its bodies more elements".to_owned(),
        };
        AdaptiveError::PassedThrough {
            remedy: remedy.into(),
            contact: facts.name.clone(),
            bodies: Box::new([self.model.bodies[facts.body].name.clone(), target]),
            time: unknown.time,
            depth: unknown.overlap.depth,
            place: Components(unknown.overlap.place),
            known: unknown.known,
        }
    }
}

impl Driver<'_> {
    /// Notes after a step whether the bodies are as slow as `stop_at_rest` asks for: by the root of
    /// their mean square speed `sqrt(2 T / m)`, with the kinetic energy `T` and the mass `m` of all
    /// bodies.
    pub(super) fn note_rest(&mut self) {
        let Some(rest) = self.settings.stop_at_rest else { return };
        let (t, y) = (self.integrator.time(), self.integrator.state());
        let mass: f64 = self.model.bodies.iter().map(|b| b.data.mass).filter(|m| m.is_finite()).sum();
        let is_slow = 2.0 * self.model.system.invariants(t, y).kinetic <= mass * rest.speed * rest.speed;
        self.run.slow_since = is_slow.then(|| self.run.slow_since.unwrap_or(t));
    }

    /// Whether the bodies have been slow for as long as `stop_at_rest` asks for.
    pub(super) fn is_at_rest(&self) -> bool {
        let slow = self.settings.stop_at_rest.zip(self.run.slow_since);
        slow.is_some_and(|(rest, since)| self.integrator.time() - since >= rest.duration)
    }
}
