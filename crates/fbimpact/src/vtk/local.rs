//! The quasistatic displacement of contact zones, which no coordinate of the result holds.
//!
//! Where a body was refined for its contact before the run, the contact problem is solved again at the stored state; it depends
//! on nothing else. Zones that the program refined during the run are not built again.

use adaptive::model::RunModel;
use ffr_dynamics::system::force::{BodyState, ForceElement, GeneralisedForce};

use super::states::{BodyMotion, ContactSeries};

/// Relative deviation of the force from the stored one beyond which a contact problem counts as another one.
const SAME_FORCE: f64 = 1e-3;

/// Contacts whose zones can be solved again.
pub struct LocalContacts {
    contacts: Vec<(usize, ContactSeries)>,
    /// Instants at which a contact found another force than the run.
    pub deviations: usize,
}

impl LocalContacts {
    /// Contacts of `model` that act on quasistatic zones without friction, with what the result holds of them.
    pub fn new(
        model: &RunModel,
        stored: impl Fn(&str) -> Option<ContactSeries>,
        has_friction: impl Fn(&str) -> bool,
    ) -> Self {
        let solvable = model.contacts.iter().enumerate();
        let solvable = solvable.filter(|(_, facts)| facts.loads_interface && !has_friction(&facts.name));
        let contacts = solvable.filter_map(|(i, facts)| Some((i, stored(&facts.name)?))).collect();
        Self { contacts, deviations: 0 }
    }

    /// Quasistatic displacement \[m\] of the unknowns of each body at instant `i`; empty where there is none.
    pub fn displacements(
        &mut self,
        model: &mut RunModel,
        motions: &[BodyMotion],
        time: f64,
        i: usize,
    ) -> Vec<Vec<f64>> {
        let mut forces: Vec<Vec<f64>> = model.bodies.iter().map(|_| Vec::new()).collect();
        if self.contacts.iter().all(|(_, c)| c.normal_force[i] <= 0.0) {
            return forces;
        }
        let states: Vec<BodyState> = motions.iter().map(|m| state(m, i)).collect();
        let mut sums: Vec<GeneralisedForce> =
            states.iter().map(|s| GeneralisedForce::zeros(s.elastic.len())).collect();
        for (index, stored) in &self.contacts {
            if stored.normal_force[i] <= 0.0 {
                continue;
            }
            let element = &mut model.system.forces_mut()[*index];
            element.contact.forget();
            let same =
                |found: f64| (found - stored.normal_force[i]).abs() <= SAME_FORCE * stored.normal_force[i];
            // A factor that does not fit shows in the force.
            if stored.penalty[i].is_finite() {
                let _ = element.contact.set_penalty(stored.penalty[i]);
            }
            let outcome = element.apply(time, &states, &mut sums);
            if outcome.is_err() || !same(element.contact.report().normal_force) {
                self.deviations += 1;
                continue;
            }
            for (body, force) in forces.iter_mut().enumerate() {
                let residual = model.bodies[body].elastic.as_ref().and_then(|e| e.reduced.residual.as_ref());
                let Some(residual) = residual.filter(|_| model.system.forces()[*index].acts_on(body)) else {
                    continue;
                };
                let n = residual.interface().len();
                let mut part = vec![0.0; n];
                model.system.forces()[*index].contact.interface_force(body, &mut part);
                force.resize(n, 0.0);
                force.iter_mut().zip(part).for_each(|(sum, f)| *sum += f);
            }
        }
        let displacement = |(body, force): (usize, Vec<f64>)| {
            let residual = model.bodies[body].elastic.as_ref().and_then(|e| e.reduced.residual.as_ref());
            residual.filter(|_| !force.is_empty()).map_or_else(Vec::new, |r| r.displacement(&force))
        };
        forces.into_iter().enumerate().map(displacement).collect()
    }
}

fn state(motion: &BodyMotion, i: usize) -> BodyState {
    let (pose, rotation) = (motion.pose(i), motion.rotation(i));
    BodyState {
        position: pose.position,
        rotation,
        velocity: pose.velocity,
        angular_velocity: rotation.inverse() * pose.angular_velocity,
        elastic: motion.elastic(i).to_vec(),
        elastic_rates: motion.rates(i).to_vec(),
    }
}
