//! Damping of a contact, whatever its law (docs/theory.md Eqs. C.92 to C.94).

use std::time::Duration;

use ffr_dynamics::error::EvaluationFailure;
use ffr_dynamics::force::active::ActiveForce;
use ffr_dynamics::force::{BodyState, ForceEnergies, GeneralisedForce, Motion};
use nalgebra::Vector3;

use crate::ContactError;
use crate::contact_element::{ActiveContact, Contact, ContactReport, Meeting};

/// A contact whose elastic forces grow with the speed at which it closes, and fall when it opens, as Hunt and Crossley have it: what
/// they lose thereby has no rate at which it jumps, for they begin at zero.
pub struct DampedContact {
    contact: Box<dyn ActiveContact>,
    /// Growth of the force per closing speed [s/m].
    damping: f64,
    /// Elastic forces on the bodies of the contact, and their rates; of others none.
    elastic: Vec<GeneralisedForce>,
    rates: Vec<GeneralisedForce>,
    /// Forces over the elastic ones in the last evaluation.
    factor: f64,
    report: ContactReport,
}

impl DampedContact {
    /// `contact` with the damping `damping`, the growth of its force per closing speed [s/m].
    ///
    /// # Errors
    /// [`ContactError::Damping`] if it is negative or not finite.
    pub fn new(contact: Box<dyn ActiveContact>, damping: f64) -> Result<Self, ContactError> {
        if !(damping >= 0.0 && damping.is_finite()) {
            return Err(ContactError::Damping { value: damping });
        }
        Ok(Self {
            contact,
            damping,
            elastic: Vec::new(),
            rates: Vec::new(),
            factor: 1.0,
            report: ContactReport::default(),
        })
    }

    /// The bodies that it acts on.
    fn bodies(&self) -> impl Iterator<Item = usize> + use<> {
        let (body, target) = self.contact.facts().bodies();
        [Some(body), target].into_iter().flatten()
    }

    /// Speed at which the contact closes under the elastic forces just found, whose power is `power` \[W\]: that at which their normal
    /// part takes energy (Eq. C.93) [m/s].
    fn closing_speed(&mut self, motion: Motion<'_>, power: f64) -> f64 {
        let report = *self.contact.report();
        let mut of_friction = 0.0;
        if report.friction_force.norm_squared() > 0.0 {
            let place = self.contact.meeting(motion).place;
            let (body, target) = self.contact.facts().bodies();
            let at = |body: usize| velocity_at(&motion.bodies[body], &place);
            let relative = at(body) - target.map_or_else(Vector3::zeros, at);
            of_friction = report.friction_force.dot(&relative);
        }
        let speed = (of_friction - power) / report.normal_force;
        if speed.is_finite() { speed } else { 0.0 }
    }
}

/// Makes room for forces on `bodies` as `forces` has them, and clears it.
fn clear(of: &mut Vec<GeneralisedForce>, bodies: impl Iterator<Item = usize>, forces: &[GeneralisedForce]) {
    of.resize_with(forces.len(), || GeneralisedForce::zeros(0));
    for body in bodies {
        of[body].elastic.resize(forces[body].elastic.len(), 0.0);
        of[body].clear();
    }
}

/// Velocity of a point of the frame of a body that is at `place` [m/s].
fn velocity_at(body: &BodyState, place: &Vector3<f64>) -> Vector3<f64> {
    let spin = body.rotation * body.angular_velocity_in_body;
    body.velocity + spin.cross(&(place - body.position))
}

/// Power of `force` on a body that moves as `body` \[W\].
fn power(force: &GeneralisedForce, body: &BodyState) -> f64 {
    let of_modes: f64 = force.elastic.iter().zip(&body.elastic_rates).map(|(f, rate)| f * rate).sum();
    force.force.dot(&body.velocity) + force.torque_in_body.dot(&body.angular_velocity_in_body) + of_modes
}

impl ActiveForce for DampedContact {
    fn evaluate(
        &mut self,
        motion: Motion<'_>,
        forces: &mut [GeneralisedForce],
    ) -> Result<(), EvaluationFailure> {
        let bodies = self.bodies();
        clear(&mut self.elastic, bodies, forces);
        self.contact.evaluate(motion, &mut self.elastic)?;
        self.report = *self.contact.report();
        if self.report.normal_force <= 0.0 {
            return Ok(());
        }
        let power: f64 = self.bodies().map(|b| power(&self.elastic[b], &motion.bodies[b])).sum();
        let growth = (self.damping * self.closing_speed(motion, power)).max(-1.0);
        self.factor = 1.0 + growth;
        let factor = self.factor;
        self.bodies().for_each(|body| forces[body].add_multiple(factor, &self.elastic[body]));
        let report = &mut self.report;
        report.normal_force *= factor;
        report.force *= factor;
        report.friction_force *= factor;
        // What the elastic forces take is stored, or lost to friction; the rest is lost here.
        report.energies.dissipated_power -= growth * power;
        Ok(())
    }

    fn rates(&mut self, motion: Motion<'_>, by_velocity: bool, rates: &mut [GeneralisedForce]) -> bool {
        if self.report.normal_force <= 0.0 {
            return true;
        }
        if by_velocity {
            let power: f64 = self.bodies().map(|b| power(&self.elastic[b], &motion.bodies[b])).sum();
            let growth = self.damping * self.closing_speed(motion, power);
            self.bodies().for_each(|body| rates[body].add_multiple(growth, &self.elastic[body]));
            return true;
        }
        let bodies = self.bodies();
        clear(&mut self.rates, bodies, rates);
        let is_known = self.contact.rates(motion, by_velocity, &mut self.rates);
        self.bodies().for_each(|body| rates[body].add_multiple(self.factor, &self.rates[body]));
        is_known
    }

    fn energies(&self) -> ForceEnergies {
        let lost = self.report.energies.dissipated_power - self.contact.report().energies.dissipated_power;
        let energies = self.contact.energies();
        ForceEnergies { dissipated_power: energies.dissipated_power + lost, ..energies }
    }

    fn resultant(&self) -> Vector3<f64> {
        self.report.force
    }

    fn is_idle(&self) -> bool {
        self.contact.is_idle()
    }

    fn accelerations(&self) -> &[f64] {
        self.contact.accelerations()
    }

    fn save(&mut self) {
        self.contact.save();
    }

    fn restore(&mut self) {
        self.contact.restore();
    }

    fn n_coordinates(&self) -> usize {
        self.contact.n_coordinates()
    }

    fn coordinate_speed(&self, internal: &[f64]) -> f64 {
        self.contact.coordinate_speed(internal)
    }

    fn clearance(&self, bodies: &[BodyState]) -> Option<f64> {
        self.contact.clearance(bodies)
    }

    fn notes_motions(&self) -> bool {
        self.contact.notes_motions()
    }

    fn elapsed(&self) -> Duration {
        self.contact.elapsed()
    }

    fn take_elapsed(&mut self) -> Duration {
        self.contact.take_elapsed()
    }
}

/// Pressures, and what zones yield by, are those of the elastic forces.
impl ActiveContact for DampedContact {
    fn facts(&self) -> &dyn Contact {
        self.contact.facts()
    }

    fn report(&self) -> &ContactReport {
        &self.report
    }

    fn forget(&mut self) {
        self.contact.forget();
        self.report = *self.contact.report();
    }

    fn meeting(&mut self, motion: Motion<'_>) -> Meeting {
        self.contact.meeting(motion)
    }

    fn point_forces(&self) -> Option<&[f64]> {
        self.contact.point_forces()
    }

    fn friction_forces(&self) -> Vec<Vector3<f64>> {
        self.contact.friction_forces()
    }

    fn prescribe_friction(&mut self, wanted: Option<&[Vector3<f64>]>) {
        self.contact.prescribe_friction(wanted);
    }

    fn set_penalty(&mut self, penalty: f64) -> Result<(), ContactError> {
        self.contact.set_penalty(penalty)
    }

    fn compliance_weight(
        &mut self,
        motion: Motion<'_>,
        reach: f64,
    ) -> Result<Option<f64>, EvaluationFailure> {
        self.contact.compliance_weight(motion, reach)
    }

    fn interface_force(&self, body: usize, out: &mut [f64]) -> bool {
        self.contact.interface_force(body, out)
    }
}
