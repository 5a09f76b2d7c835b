//! Contacts seen from both sides, and their damping, whatever the law (docs/theory.md Eqs. C.92 to C.94 and section C.18).

use std::time::Duration;

use ffr_dynamics::error::EvaluationFailure;
use ffr_dynamics::force::active::ActiveForce;
use ffr_dynamics::force::{BodyState, ForceEnergies, GeneralisedForce, Motion};
use nalgebra::Vector3;

use crate::ContactError;
use crate::contact_element::{ActiveContact, Contact, ContactReport, Meeting};

/// A contact, and with it, where both bodies carry points, its mirror image: the points of either body on the other one, so that an
/// edge of the target presses a face of the contact body between its points. What has one value for a contact is that of the contact
/// body's points.
///
/// With damping the elastic forces grow with the speed at which the contact closes, and fall when it opens, as Hunt and Crossley have
/// it: what they lose thereby has no rate at which it jumps, for they begin at zero.
pub struct ContactSides {
    sides: Vec<Box<dyn ActiveContact>>,
    /// Growth of the force per closing speed [s/m].
    damping: f64,
    /// Elastic forces on the bodies of the contact, and their rates; of others none. Without damping not in use.
    elastic: Vec<GeneralisedForce>,
    rates: Vec<GeneralisedForce>,
    /// Forces over the elastic ones in the last evaluation.
    factor: f64,
    report: ContactReport,
}

impl ContactSides {
    /// `contact`, `mirrored` if there are points on both bodies, with the damping `damping`, the growth of its force per closing speed
    /// [s/m].
    ///
    /// # Errors
    /// [`ContactError::Damping`] if it is negative or not finite.
    pub fn new(
        contact: Box<dyn ActiveContact>,
        mirrored: Option<Box<dyn ActiveContact>>,
        damping: f64,
    ) -> Result<Self, ContactError> {
        if !(damping >= 0.0 && damping.is_finite()) {
            return Err(ContactError::Damping { value: damping });
        }
        Ok(Self {
            sides: std::iter::once(contact).chain(mirrored).collect(),
            damping,
            elastic: Vec::new(),
            rates: Vec::new(),
            factor: 1.0,
            report: ContactReport::default(),
        })
    }

    /// The contact by the points of the contact body.
    fn own(&self) -> &dyn ActiveContact {
        self.sides[0].as_ref()
    }

    /// What was found without damping.
    fn elastic_report(&self) -> ContactReport {
        self.sides[1..].iter().fold(*self.own().report(), |own, side| both(&own, side.report()))
    }

    /// The bodies that it acts on.
    fn bodies(&self) -> impl Iterator<Item = usize> + use<> {
        let (body, target) = self.facts().bodies();
        [Some(body), target].into_iter().flatten()
    }

    /// Speed at which the contact closes under the elastic forces just found, whose power is `power` \[W\]: that at which their normal
    /// part takes energy (Eq. C.93) [m/s].
    fn closing_speed(&mut self, motion: Motion<'_>, power: f64) -> f64 {
        let report = self.elastic_report();
        let mut of_friction = 0.0;
        if report.friction_force.norm_squared() > 0.0 {
            let place = self.meeting(motion).place;
            let (body, target) = self.facts().bodies();
            let at = |body: usize| velocity_at(&motion.bodies[body], &place);
            let relative = at(body) - target.map_or_else(Vector3::zeros, at);
            of_friction = report.friction_force.dot(&relative);
        }
        let speed = (of_friction - power) / report.normal_force;
        if speed.is_finite() { speed } else { 0.0 }
    }
}

/// The sums over both sides, as the contact body feels them. Both see the same area.
fn both(own: &ContactReport, mirrored: &ContactReport) -> ContactReport {
    let mut solver = own.solver;
    solver.add(mirrored.solver);
    ContactReport {
        normal_force: own.normal_force + mirrored.normal_force,
        force: own.force - mirrored.force,
        friction_force: own.friction_force - mirrored.friction_force,
        penetration: own.penetration.max(mirrored.penetration),
        n_active: own.n_active + mirrored.n_active,
        n_sliding: own.n_sliding + mirrored.n_sliding,
        contact_area: own.contact_area.max(mirrored.contact_area),
        is_rim_touched: own.is_rim_touched || mirrored.is_rim_touched,
        energies: own.energies + mirrored.energies,
        solver,
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

impl ActiveForce for ContactSides {
    fn evaluate(
        &mut self,
        motion: Motion<'_>,
        forces: &mut [GeneralisedForce],
    ) -> Result<(), EvaluationFailure> {
        if self.damping == 0.0 {
            self.sides.iter_mut().try_for_each(|side| side.evaluate(motion, forces))?;
            self.report = self.elastic_report();
            return Ok(());
        }
        let bodies = self.bodies();
        clear(&mut self.elastic, bodies, forces);
        self.sides.iter_mut().try_for_each(|side| side.evaluate(motion, &mut self.elastic))?;
        self.report = self.elastic_report();
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
        let all = |sides: &mut [Box<dyn ActiveContact>], rates: &mut [GeneralisedForce]| {
            sides.iter_mut().all(|side| side.rates(motion, by_velocity, rates))
        };
        if self.damping == 0.0 {
            return all(&mut self.sides, rates);
        }
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
        let is_known = all(&mut self.sides, &mut self.rates);
        self.bodies().for_each(|body| rates[body].add_multiple(self.factor, &self.rates[body]));
        is_known
    }

    fn energies(&self) -> ForceEnergies {
        let lost = self.report.energies.dissipated_power - self.elastic_report().energies.dissipated_power;
        let energies = self.sides[1..].iter().fold(self.own().energies(), |sum, side| sum + side.energies());
        ForceEnergies { dissipated_power: energies.dissipated_power + lost, ..energies }
    }

    fn resultant(&self) -> Vector3<f64> {
        self.report.force
    }

    fn is_idle(&self) -> bool {
        self.sides.iter().all(|side| side.is_idle())
    }

    fn accelerations(&self) -> &[f64] {
        self.own().accelerations()
    }

    fn save(&mut self) {
        self.sides.iter_mut().for_each(|side| side.save());
    }

    fn restore(&mut self) {
        self.sides.iter_mut().for_each(|side| side.restore());
    }

    fn n_coordinates(&self) -> usize {
        self.own().n_coordinates()
    }

    fn coordinate_speed(&self, internal: &[f64]) -> f64 {
        self.own().coordinate_speed(internal)
    }

    fn clearance(&self, bodies: &[BodyState]) -> Option<f64> {
        self.own().clearance(bodies)
    }

    fn notes_motions(&self) -> bool {
        self.own().notes_motions()
    }

    fn elapsed(&self) -> Duration {
        self.sides.iter().map(|side| side.elapsed()).sum()
    }

    fn take_elapsed(&mut self) -> Duration {
        self.sides.iter_mut().map(|side| side.take_elapsed()).sum()
    }
}

/// Pressures, and what zones yield by, are those of the elastic forces.
impl ActiveContact for ContactSides {
    fn facts(&self) -> &dyn Contact {
        self.own().facts()
    }

    fn report(&self) -> &ContactReport {
        &self.report
    }

    fn forget(&mut self) {
        self.sides.iter_mut().for_each(|side| side.forget());
        self.report = self.elastic_report();
    }

    fn meeting(&mut self, motion: Motion<'_>) -> Meeting {
        let own = self.sides[0].meeting(motion);
        let mirrored = self.sides.get_mut(1).map(|side| side.meeting(motion));
        // A gap that is not a number is told.
        let Some(mirrored) = mirrored.filter(|mirrored| !(mirrored.gap >= own.gap || own.gap.is_nan()))
        else {
            return own;
        };
        let normal = -mirrored.normal;
        Meeting { gap: mirrored.gap, normal, place: mirrored.place + normal * mirrored.gap }
    }

    fn point_forces(&self) -> Option<&[f64]> {
        self.own().point_forces()
    }

    fn friction_forces(&self) -> Vec<Vector3<f64>> {
        self.sides.iter().flat_map(|side| side.friction_forces()).collect()
    }

    fn prescribe_friction(&mut self, wanted: Option<&[Vector3<f64>]>) {
        let (n, of_both) = (self.facts().n_points(), self.sides.len() > 1);
        let (own, mirrored) = match wanted {
            Some(all) if of_both => all.split_at_checked(n).unzip(),
            _ => (wanted, None),
        };
        self.sides.iter_mut().zip([own, mirrored]).for_each(|(side, wanted)| side.prescribe_friction(wanted));
    }

    fn set_penalty(&mut self, penalty: f64) -> Result<(), ContactError> {
        self.sides.iter_mut().try_for_each(|side| side.set_penalty(penalty))
    }

    fn compliance_weight(
        &mut self,
        motion: Motion<'_>,
        reach: f64,
    ) -> Result<Option<f64>, EvaluationFailure> {
        self.sides[0].compliance_weight(motion, reach)
    }

    fn interface_force(&self, body: usize, out: &mut [f64]) -> bool {
        self.own().interface_force(body, out)
    }
}
