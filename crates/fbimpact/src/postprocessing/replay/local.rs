//! The quasistatic displacement of contact zones, which no coordinate of the result holds.
//!
//! The contact problem is solved again at the stored state; it depends on nothing else. Zones that
//! were refined for their contact before the run are part of the bodies' models; fine models that
//! the program made during the run are built again.

use std::fmt;

use adaptive::impact::AdaptiveContact;
use adaptive::model::{ContactFacts, RunModel};
use ffr_dynamics::force::{BodyState, GeneralisedForce, Motion};
use ffr_dynamics::reduction::ResidualFlexibility;

use super::states::{BodyMotion, ContactSeries};
use super::zones::RefinedZones;
use crate::error::AppError;

/// Relative deviation of the force from the stored one beyond which a contact problem counts as
/// another one.
const SAME_FORCE: f64 = 1e-3;

/// Contacts whose zones can be solved again.
pub struct LocalContacts<View> {
    contacts: Vec<(usize, ContactSeries)>,
    /// Contacts with quasistatic zones that cannot be solved again.
    pub left_out: Vec<LeftOut>,
    /// Fine models of the run.
    pub zones: RefinedZones<View>,
    /// Instants at which a contact found another force than the run.
    pub deviations: usize,
}

/// A contact that has touched and whose zone cannot be solved again.
#[derive(Debug, Clone)]
pub struct LeftOut {
    /// Number of the contact.
    pub contact: usize,
    name: String,
    reason: &'static str,
}

impl fmt::Display for LeftOut {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { name, reason, .. } = self;
        write!(f, "local deformation and stress by contact \"{name}\" are left out: {reason}")
    }
}

/// Forces to which zones answer with a quasistatic displacement.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct LocalForces {
    /// For each body those on the interface that it was reduced for \[N\]; empty where none act.
    pub own: Vec<Vec<f64>>,
    /// Forces on the interfaces of fine models \[N\].
    pub zones: Vec<ZoneForces>,
}

/// Forces on the interface of a fine model.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ZoneForces {
    /// Number of the contact.
    pub contact: usize,
    /// Number of the model among those of the contact, [`RefinedZones::of_contact`].
    pub zone: usize,
    /// Normal force of the contact \[N\].
    pub total: f64,
    /// Forces on its interface \[N\].
    pub forces: Vec<f64>,
}

impl<View> LocalContacts<View> {
    /// Contacts of `model` that act on quasistatic zones without friction, with what the result
    /// holds of them.
    pub fn new(
        model: &RunModel,
        stored: impl Fn(&str) -> Option<ContactSeries>,
        has_friction: impl Fn(&str) -> bool,
        zones: RefinedZones<View>,
    ) -> Self {
        let (mut contacts, mut left_out) = (Vec::new(), Vec::new());
        let on_zones = |(_, c): &(usize, &ContactFacts)| c.loads_interface || c.refinement.is_some();
        for (i, contact) in model.contacts.iter().enumerate().filter(on_zones) {
            let is_solvable = contact.refinement.as_ref().is_none_or(AdaptiveContact::is_rebuildable);
            let series = stored(&contact.name);
            if series.as_ref().is_some_and(|s| s.normal_force.iter().all(|force| *force <= 0.0)) {
                continue; // nothing to leave out
            }
            let reason = match series {
                _ if has_friction(&contact.name) => "the state of its friction is not stored",
                _ if !is_solvable => {
                    "zones that vibrate and zones with modes of their own are not built again"
                }
                None => "the result does not hold its penalty factor",
                Some(series) => {
                    contacts.push((i, series));
                    continue;
                }
            };
            left_out.push(LeftOut { contact: i, name: contact.name.clone(), reason });
        }
        Self { contacts, left_out, zones, deviations: 0 }
    }

    /// Forces on quasistatic zones at instant `i`, with the fine models that contacts had then.
    ///
    /// # Errors
    /// [`AppError::Model`] if a fine model cannot be built again.
    pub fn forces(
        &mut self,
        model: &mut RunModel,
        motions: &[BodyMotion],
        time: f64,
        i: usize,
    ) -> Result<LocalForces, AppError> {
        let mut all = LocalForces { own: vec![Vec::new(); model.bodies.len()], zones: Vec::new() };
        if self.contacts.iter().all(|(_, c)| c.normal_force[i] <= 0.0) {
            return Ok(all);
        }
        let states: Vec<BodyState> = motions.iter().map(|m| m.state(i)).collect();
        let mut sums: Vec<GeneralisedForce> =
            states.iter().map(|s| GeneralisedForce::zeros(s.elastic.len())).collect();
        for (index, stored) in &self.contacts {
            let force = stored.normal_force[i];
            let is_own = model.contacts[*index].loads_interface;
            if force <= 0.0 || !(is_own || self.zones.enter(model, *index, time)?) {
                continue;
            }
            let element = &mut model.system.forces_mut()[*index];
            element.contact.forget();
            // A factor that does not fit shows in the force.
            if stored.penalty[i].is_finite() {
                let _ = element.contact.set_penalty(stored.penalty[i]);
            }
            let outcome = element.evaluate(Motion::new(time, &states), &mut sums);
            let found = element.contact.report().normal_force;
            if outcome.is_err() || (found - force).abs() > SAME_FORCE * force {
                self.deviations += 1;
                continue;
            }
            if is_own {
                add_to_own(model, *index, &mut all.own);
                continue;
            }
            for (zone, of_body) in self.zones.of_contact(*index).iter().enumerate() {
                let forces = forces_on(model, *index, of_body.body, &of_body.model.residual);
                let forces = forces.map(|forces| ZoneForces { contact: *index, zone, total: force, forces });
                all.zones.extend(forces);
            }
        }
        Ok(all)
    }
}

/// Flexibility of the interface that body `body` was reduced for.
pub fn own_residual(model: &RunModel, body: usize) -> Option<&ResidualFlexibility> {
    model.bodies[body].flexible().and_then(|f| f.reduced.residual.as_ref())
}

/// Adds the forces of contact `contact` on the interfaces that its bodies were reduced for.
fn add_to_own(model: &RunModel, contact: usize, sums: &mut [Vec<f64>]) {
    for (body, sum) in sums.iter_mut().enumerate() {
        let Some(residual) = own_residual(model, body) else { continue };
        if model.system.forces()[contact].acts_on(body) {
            sum.resize(residual.interface().len(), 0.0);
            let part = forces_on(model, contact, body, residual);
            sum.iter_mut().zip(part.unwrap_or_default()).for_each(|(sum, f)| *sum += f);
        }
    }
}

/// Forces of the last evaluation of contact `contact` on the interface of `residual`, a model of
/// `body`; none of a contact that has no quasistatic zone there.
fn forces_on(
    model: &RunModel,
    contact: usize,
    body: usize,
    residual: &ResidualFlexibility,
) -> Option<Vec<f64>> {
    let mut forces = vec![0.0; residual.interface().len()];
    model.system.forces()[contact].contact.interface_force(body, &mut forces).then_some(forces)
}
