//! Contact that rolls or slides over thousands of zones: it goes on by Hertz's law at the closest places, on the bodies as they are
//! between impacts (docs/theory.md section A.13).

use contact_qs::contact_element::ActiveContact;
use ffr_dynamics::force::active::Active;
use ffr_dynamics::force::{GeneralisedForce, Motion};

use super::intervals::Intervals;
use super::trial_reason::Change;
use crate::error::AdaptiveError;
use crate::record::TransferDirection;
use crate::record::warning::{Warning, WarningKind};
use crate::run::driver::Driver;
use crate::run::driver::contact_slot::ContactPhase;
use crate::state::simulation::RunContact;

/// Zones that have taken over in an impact before it is known how many more it would take.
const SEEN: usize = 3;
/// Zones to the end of the run that are too many (Eq. A.43): of plane models, 0.05 to 0.2 s each, some minutes of work; of solids, seconds each,
/// hours. Wheels and cams that go through some hundred keep them.
const MANY: f64 = 1000.0;
/// The same as long as the bodies touch without a break: grazing impacts, however fast, go through some ten. What has gone through so many lasts.
const MANY_AT_ONCE: f64 = 100.0;

/// How contact goes on that leaves its zone.
pub(super) enum Next {
    /// In another zone.
    Zone,
    /// By Hertz's law, for it would take so many zones.
    Law(Box<RunContact>, f64),
}

impl Next {
    /// What is said of the trial that ended there.
    pub fn reason(&self) -> Change {
        match self {
            Self::Zone => Change::HandOver,
            Self::Law(_, zones) => Change::ByLaw(*zones),
        }
    }
}

impl Driver<'_> {
    /// How contact `i`, which has left its zone, goes on.
    pub(super) fn next(&mut self, i: usize) -> Next {
        let zones = self.zones_ahead(i);
        let law = zones.and_then(|zones| Some((self.law_of(i)?, zones)));
        law.map_or(Next::Zone, |(law, zones)| Next::Law(Box::new(law), zones))
    }

    /// How many zones contact `i` is going to take to the end of the run at the speed at which it went through the last ones (Eq. A.43); none if these
    /// are not many, or it is not known: contact that does not last yet (Eq. A.38, or a hundred zones) has what a preview gave before it, if that was no less than there is.
    fn zones_ahead(&mut self, i: usize) -> Option<f64> {
        let (now, end) = (self.integrator.time(), self.settings.end_time);
        let lasts = self.has_lasted(i) || self.slots[i].found.handed.len() as f64 >= MANY_AT_ONCE;
        self.model.system.body_states(now, self.integrator.state());
        let (slot, states) = (&mut self.slots[i], self.model.system.last_evaluation().0);
        let (found, fine) = (&slot.found, slot.fine()?);
        let length = fine.length();
        let before = found.handed.get((found.handed.len() + 1).checked_sub(SEEN)?..)?;
        let (way, time) = before.iter().fold((length, now - fine.activation.time), |sum, zone| {
            (sum.0 + zone.1, sum.1.max(now - zone.0))
        });
        let (until, longest) = if lasts {
            (end, length)
        } else {
            let force = found.preview.filter(|force| *force >= slot.monitor.peak_force())?;
            let (until, refinement) = (found.presses_until, self.model.contacts[i].refinement.as_ref()?);
            let nearest = refinement.nearest(states, &mut slot.nearest).ok()?;
            // Zones grow with the force. Where contact opens between them they stay as long as those of a first touch.
            let [largest, present] = [force, slot.monitor.peak_force()]
                .map(|force| refinement.length_on_the_way(&self.model.bodies, states, &nearest, force));
            (until.min(end), length * if present > 0.0 { largest / present } else { 1.0 })
        };
        let [at_once, zones] = [until, end].map(|until| (until - now) * way / (time * longest));
        (time > 0.0 && at_once > MANY_AT_ONCE && zones > MANY).then_some(zones)
    }

    /// Contact `i` by Hertz's law; none where that does not hold for the present touch.
    fn law_of(&mut self, i: usize) -> Option<RunContact> {
        let (t, y) = (self.integrator.time(), self.integrator.state());
        self.model.system.body_states(t, y);
        let states = self.model.system.last_evaluation().0;
        let mut law = self.by_law(i).ok()??;
        let mut forces: Vec<_> =
            states.iter().map(|state| GeneralisedForce::zeros(state.elastic.len())).collect();
        let outcome = law.contact.evaluate(Motion::new(t, states), &mut forces);
        law.contact.forget();
        outcome.is_ok().then_some(law)
    }

    /// The force element of contact `i` by Hertz's law; none of one that the program does not refine, and of meshes.
    fn by_law(&self, i: usize) -> Result<Option<RunContact>, AdaptiveError> {
        let facts = &self.model.contacts[i];
        let Some(refinement) = &facts.refinement else { return Ok(None) };
        let law = refinement.by_law(&self.model.bodies).and_then(|law| {
            let boxed = law.map(|law| -> Box<dyn ActiveContact> { Box::new(Active::new(law)) });
            boxed.map(|law| RunContact::new(law).with_damping(facts.damping)).transpose()
        });
        law.map_err(|source| AdaptiveError::Contact { contact: facts.name.clone(), source })
    }

    /// Contact `i`, whose trial was accepted up to the present instant, goes on by `law` from here to the end of the run.
    ///
    /// # Errors
    /// [`AdaptiveError`] if the present state is refused.
    pub(super) fn go_on_by_law(
        &mut self,
        i: usize,
        (law, zones): (RunContact, f64),
        intervals: &mut Intervals,
    ) -> Result<(), AdaptiveError> {
        let before = self.present_balance()?;
        self.deactivate(i)?;
        self.replace_contact(i, law)?;
        (self.slots[i].phase, self.run.contacts[i].is_by_law) = (ContactPhase::Lasting, true);
        self.slots[i].found.travels = true;
        self.slots[i].found.touches.clear();
        intervals.go_on(i, None);
        let after = self.present_balance()?;
        self.record_transfer(i, TransferDirection::FineToCoarse, &before, &after);
        self.integrator.invalidate();
        let (time, name) = (self.integrator.time(), &self.model.contacts[i].name);
        let warning = Warning {
            kind: WarningKind::ByLaw,
            subject: format!("contact \"{name}\""),
            time,
            value: zones,
            limit: MANY,
            message: format!(
                "it rolls or slides so fast that {zones:.0} zones were to take over to the end of the run, one every {:.1e} s; from t = {time:.6e} s on it goes on by Hertz's law at the \
                 closest places, which has no zone and no pressures; mean forces are right to some per cent, peaks of impacts of plane bodies, whose modes yield beside the law, low by a tenth or more",
                (self.settings.end_time - time) / zones
            ),
            remedy: format!(
                "for zones throughout let simulation.end_time leave fewer than {MANY:.0} of them; for one law from the start give contacts.{name}.model = \"hertz\""
            ),
        };
        self.warn(vec![(i, warning)])
    }

    /// Gives contacts that went on by Hertz's law in the run that is taken up their law.
    ///
    /// # Errors
    /// [`AdaptiveError::Contact`] if there is none.
    pub(crate) fn restore_laws(&mut self) -> Result<(), AdaptiveError> {
        for i in 0..self.slots.len() {
            if self.run.contacts[i].is_by_law
                && let Some(law) = self.by_law(i)?
            {
                self.replace_contact(i, law)?;
                self.slots[i].phase = ContactPhase::Lasting;
            }
        }
        Ok(())
    }
}
