//! Two bodies that carry points, each on the surface of the other (docs/theory.md section C.18).

use std::time::Duration;

use ffr_dynamics::error::EvaluationFailure;
use ffr_dynamics::force::active::ActiveForce;
use ffr_dynamics::force::{BodyState, ForceEnergies, GeneralisedForce, Motion};
use nalgebra::Vector3;

use crate::ContactError;
use crate::contact_element::{ActiveContact, Contact, ContactReport, Meeting};

/// A contact and its mirror image: the points of either body on the other one, so that an edge of the target presses a face of the
/// contact body between its points. What has one value for a contact is that of the contact body's points.
pub struct MutualContact {
    own: Box<dyn ActiveContact>,
    mirrored: Box<dyn ActiveContact>,
    report: ContactReport,
}

impl MutualContact {
    /// The contact `own` and the same with the bodies exchanged.
    pub fn new(own: Box<dyn ActiveContact>, mirrored: Box<dyn ActiveContact>) -> Self {
        Self { own, mirrored, report: ContactReport::default() }
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

impl ActiveForce for MutualContact {
    fn evaluate(
        &mut self,
        motion: Motion<'_>,
        forces: &mut [GeneralisedForce],
    ) -> Result<(), EvaluationFailure> {
        self.own.evaluate(motion, forces)?;
        self.mirrored.evaluate(motion, forces)?;
        self.report = both(self.own.report(), self.mirrored.report());
        Ok(())
    }

    fn rates(&mut self, motion: Motion<'_>, by_velocity: bool, rates: &mut [GeneralisedForce]) -> bool {
        self.own.rates(motion, by_velocity, rates) && self.mirrored.rates(motion, by_velocity, rates)
    }

    fn energies(&self) -> ForceEnergies {
        self.own.energies() + self.mirrored.energies()
    }

    fn resultant(&self) -> Vector3<f64> {
        self.report.force
    }

    fn is_idle(&self) -> bool {
        self.own.is_idle() && self.mirrored.is_idle()
    }

    fn accelerations(&self) -> &[f64] {
        self.own.accelerations()
    }

    fn save(&mut self) {
        self.own.save();
        self.mirrored.save();
    }

    fn restore(&mut self) {
        self.own.restore();
        self.mirrored.restore();
    }

    fn n_coordinates(&self) -> usize {
        self.own.n_coordinates()
    }

    fn coordinate_speed(&self, internal: &[f64]) -> f64 {
        self.own.coordinate_speed(internal)
    }

    fn clearance(&self, bodies: &[BodyState]) -> Option<f64> {
        self.own.clearance(bodies)
    }

    fn notes_motions(&self) -> bool {
        self.own.notes_motions()
    }

    fn elapsed(&self) -> Duration {
        self.own.elapsed() + self.mirrored.elapsed()
    }

    fn take_elapsed(&mut self) -> Duration {
        self.own.take_elapsed() + self.mirrored.take_elapsed()
    }
}

impl ActiveContact for MutualContact {
    fn facts(&self) -> &dyn Contact {
        self.own.facts()
    }

    fn report(&self) -> &ContactReport {
        &self.report
    }

    fn forget(&mut self) {
        self.own.forget();
        self.mirrored.forget();
        self.report = ContactReport::default();
    }

    fn meeting(&mut self, motion: Motion<'_>) -> Meeting {
        let (own, mirrored) = (self.own.meeting(motion), self.mirrored.meeting(motion));
        // A gap that is not a number is told.
        if mirrored.gap >= own.gap || own.gap.is_nan() {
            return own;
        }
        let normal = -mirrored.normal;
        Meeting { gap: mirrored.gap, normal, place: mirrored.place + normal * mirrored.gap }
    }

    fn point_forces(&self) -> Option<&[f64]> {
        self.own.point_forces()
    }

    fn friction_forces(&self) -> Vec<Vector3<f64>> {
        [self.own.friction_forces(), self.mirrored.friction_forces()].concat()
    }

    fn prescribe_friction(&mut self, wanted: Option<&[Vector3<f64>]>) {
        let n = self.own.facts().n_points();
        let [own, mirrored] = match wanted.and_then(|all| all.split_at_checked(n)) {
            Some((own, mirrored)) => [Some(own), Some(mirrored)],
            None => [None; 2],
        };
        self.own.prescribe_friction(own);
        self.mirrored.prescribe_friction(mirrored);
    }

    fn set_penalty(&mut self, penalty: f64) -> Result<(), ContactError> {
        self.own.set_penalty(penalty)?;
        self.mirrored.set_penalty(penalty)
    }

    fn compliance_weight(
        &mut self,
        motion: Motion<'_>,
        reach: f64,
    ) -> Result<Option<f64>, EvaluationFailure> {
        self.own.compliance_weight(motion, reach)
    }

    fn interface_force(&self, body: usize, out: &mut [f64]) -> bool {
        self.own.interface_force(body, out)
    }
}
