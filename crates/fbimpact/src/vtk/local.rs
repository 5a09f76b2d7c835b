//! The quasistatic displacement of contact zones, which no coordinate of the result holds.
//!
//! The contact problem is solved again at the stored state; it depends on nothing else. Zones that were refined for their contact
//! before the run are part of the bodies' models; fine models that the program made during the run are built again.

use adaptive::model::RunModel;
use ffr_dynamics::reduction::ResidualFlexibility;
use ffr_dynamics::system::force::{BodyState, GeneralisedForce, Motion};

use super::states::{BodyMotion, ContactSeries};
use super::zones::RefinedZones;
use crate::error::AppError;

/// Relative deviation of the force from the stored one beyond which a contact problem counts as another one.
const SAME_FORCE: f64 = 1e-3;

/// Contacts whose zones can be solved again.
pub struct LocalContacts {
    contacts: Vec<(usize, ContactSeries)>,
    /// Fine models of the run.
    pub zones: RefinedZones,
    /// Instants at which a contact found another force than the run.
    pub deviations: usize,
}

/// Quasistatic displacement of a body.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct LocalDisplacement {
    /// Of the unknowns of its own model \[m\]; empty where there is none.
    pub own: Vec<f64>,
    /// Of the unknowns of a fine model, with the contact that this belongs to.
    pub zone: Option<(usize, Vec<f64>)>,
}

impl LocalContacts {
    /// Contacts of `model` that act on quasistatic zones without friction, with what the result holds of them.
    pub fn new(
        model: &RunModel,
        stored: impl Fn(&str) -> Option<ContactSeries>,
        has_friction: impl Fn(&str) -> bool,
        zones: RefinedZones,
    ) -> Self {
        let solvable = model.contacts.iter().enumerate();
        let solvable =
            solvable.filter(|(_, c)| (c.loads_interface || c.refinement.is_some()) && !has_friction(&c.name));
        let contacts = solvable.filter_map(|(i, contact)| Some((i, stored(&contact.name)?))).collect();
        Self { contacts, zones, deviations: 0 }
    }

    /// Quasistatic displacement of each body at instant `i`. Of several fine models of a body that of the largest force counts.
    ///
    /// # Errors
    /// [`AppError::Model`] if a fine model cannot be built again.
    pub fn displacements(
        &mut self,
        model: &mut RunModel,
        motions: &[BodyMotion],
        time: f64,
        i: usize,
    ) -> Result<Vec<LocalDisplacement>, AppError> {
        let mut all = vec![LocalDisplacement::default(); model.bodies.len()];
        if self.contacts.iter().all(|(_, c)| c.normal_force[i] <= 0.0) {
            return Ok(all);
        }
        let states: Vec<BodyState> = motions.iter().map(|m| state(m, i)).collect();
        let mut sums: Vec<GeneralisedForce> =
            states.iter().map(|s| GeneralisedForce::zeros(s.elastic.len())).collect();
        let mut own_forces: Vec<Vec<f64>> = vec![Vec::new(); model.bodies.len()];
        let mut largest = vec![0.0; model.bodies.len()];
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
                add_to_own(model, *index, &mut own_forces);
                continue;
            }
            for zone in self.zones.of_contact(*index) {
                let forces = forces_on(model, *index, zone.body, &zone.model.residual);
                let displacement = || zone.model.residual.displacement(&forces);
                let found = &mut all[zone.body];
                if zone.model.mesh.is_none() {
                    add(&mut found.own, &displacement());
                } else if force > largest[zone.body] {
                    largest[zone.body] = force;
                    found.zone = Some((*index, displacement()));
                }
            }
        }
        for (body, forces) in own_forces.iter().enumerate().filter(|(_, forces)| !forces.is_empty()) {
            if let Some(residual) = own_residual(model, body) {
                add(&mut all[body].own, &residual.displacement(forces));
            }
        }
        Ok(all)
    }
}

/// Adds `part` to `sum`, which is empty where it is zero.
fn add(sum: &mut Vec<f64>, part: &[f64]) {
    sum.resize(part.len(), 0.0);
    sum.iter_mut().zip(part).for_each(|(sum, u)| *sum += u);
}

/// Flexibility of the interface that body `body` was reduced for.
fn own_residual(model: &RunModel, body: usize) -> Option<&ResidualFlexibility> {
    model.bodies[body].flexible().and_then(|f| f.reduced.residual.as_ref())
}

/// Adds the forces of contact `contact` on the interfaces that its bodies were reduced for.
fn add_to_own(model: &RunModel, contact: usize, sums: &mut [Vec<f64>]) {
    for (body, sum) in sums.iter_mut().enumerate() {
        let Some(residual) = own_residual(model, body) else { continue };
        if model.system.forces()[contact].acts_on(body) {
            sum.resize(residual.interface().len(), 0.0);
            let part = forces_on(model, contact, body, residual);
            sum.iter_mut().zip(part).for_each(|(sum, f)| *sum += f);
        }
    }
}

/// Forces of the last evaluation of contact `contact` on the interface of `residual`, a model of `body`.
fn forces_on(model: &RunModel, contact: usize, body: usize, residual: &ResidualFlexibility) -> Vec<f64> {
    let mut forces = vec![0.0; residual.interface().len()];
    model.system.forces()[contact].contact.interface_force(body, &mut forces);
    forces
}

fn state(motion: &BodyMotion, i: usize) -> BodyState {
    let (pose, rotation) = (motion.pose(i), motion.rotation(i));
    BodyState {
        position: pose.position,
        rotation,
        velocity: pose.velocity,
        angular_velocity_in_body: rotation.inverse() * pose.angular_velocity,
        elastic: motion.elastic(i).to_vec(),
        elastic_rates: motion.rates(i).to_vec(),
    }
}
