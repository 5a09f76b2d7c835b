//! Bodies, contacts and requests of one run, and what is recorded of them at an instant.

use contact_qs::plane::PlaneContact;
use ffr_dynamics::error::Rejection;
use ffr_dynamics::invariants::centre_of_mass_velocity;
use ffr_dynamics::kinematics::marker::FlexiblePoint;
use ffr_dynamics::system::force::{BodyState, ForceElement, ForceEnergies, GeneralisedForce};
use ffr_dynamics::system::free_bodies::FreeBodies;
use nalgebra::Vector3;
use std::time::{Duration, Instant};

use crate::record::{BodySample, ContactSample, Energies, PointSample, Sample};

/// A plane contact that counts the time spent in it.
pub struct TimedContact {
    /// The contact.
    pub contact: PlaneContact,
    /// Index of its body.
    pub body: usize,
    /// Normal of the plane.
    pub normal: Vector3<f64>,
    elapsed: Duration,
}

impl TimedContact {
    /// Wraps a contact of body `body`.
    pub fn new(contact: PlaneContact, body: usize, normal: Vector3<f64>) -> Self {
        Self { contact, body, normal, elapsed: Duration::ZERO }
    }

    /// Time spent in evaluations so far.
    pub fn elapsed(&self) -> Duration {
        self.elapsed
    }
}

impl ForceElement for TimedContact {
    fn apply(
        &mut self,
        t: f64,
        bodies: &[BodyState],
        forces: &mut [GeneralisedForce],
    ) -> Result<(), Rejection> {
        let start = Instant::now();
        let outcome = self.contact.apply(t, bodies, forces);
        self.elapsed += start.elapsed();
        outcome
    }

    fn energies(&self) -> ForceEnergies {
        self.contact.energies()
    }

    fn resultant(&self) -> Vector3<f64> {
        self.contact.resultant()
    }

    fn save(&mut self) {
        self.contact.save();
    }

    fn restore(&mut self) {
        self.contact.restore();
    }
}

/// A point whose motion is recorded.
#[derive(Debug, Clone)]
pub struct ObservedPoint {
    /// Index of the body.
    pub body: usize,
    /// The material point.
    pub point: FlexiblePoint,
}

/// The system of a run.
pub type System = FreeBodies<TimedContact>;

/// Fills `sample` with everything recorded in the state `y`, which the forces were evaluated at last; time and phase are
/// left to the caller, and the potential of gravity is that about the inertial origin.
pub fn fill_sample(system: &mut System, points: &[ObservedPoint], y: &[f64], sample: &mut Sample) {
    let invariants = system.invariants(y);
    sample.energies = Energies {
        kinetic: invariants.kinetic,
        elastic_low: invariants.elastic,
        gravity: invariants.gravity,
        dissipated: system.dissipated_work(y),
        ..Energies::default()
    };
    sample.linear_momentum = invariants.linear_momentum.into();
    sample.angular_momentum = invariants.angular_momentum.into();
    sample.contacts.resize(system.forces().len(), ContactSample::default());
    for (force, slot) in system.forces().iter().zip(&mut sample.contacts) {
        let (report, energies) = (force.contact.report(), force.energies());
        sample.energies.elastic_high += energies.elastic_high;
        sample.energies.penalty += energies.penalty;
        *slot = ContactSample {
            normal_force: report.normal_force,
            force: report.force.into(),
            penetration: report.penetration,
            active_points: report.n_active as u32,
            contact_area: report.contact_area,
            penalty: force.contact.penalty(),
        };
    }
    sample.bodies.resize(system.bodies().len(), BodySample::default());
    for (i, slot) in sample.bodies.iter_mut().enumerate() {
        let centre = system.centre_of_mass(y, i);
        let state = &system.last_evaluation().0[i];
        fill_body(state, centre, slot);
    }
    sample.points.clear();
    let states = system.last_evaluation().0;
    sample.points.extend(points.iter().map(|p| PointSample {
        position: p.point.position(&states[p.body]).into(),
        velocity: p.point.velocity(&states[p.body]).into(),
    }));
}

fn fill_body(state: &BodyState, centre_of_mass: Vector3<f64>, slot: &mut BodySample) {
    let q = state.rotation.quaternion();
    slot.position = state.position.into();
    slot.rotation = [q.w, q.i, q.j, q.k];
    slot.velocity = state.velocity.into();
    slot.angular_velocity = (state.rotation * state.angular_velocity).into();
    slot.centre_of_mass = centre_of_mass.into();
    slot.elastic_coordinates.clone_from(&state.elastic);
    slot.elastic_velocities.clone_from(&state.elastic_rates);
}

/// Velocity of the centre of mass of contact `index`'s body along the plane's normal in the state `y` [m/s].
pub fn normal_velocity(system: &System, y: &[f64], index: usize, state: &mut BodyState) -> f64 {
    let contact = &system.forces()[index];
    system.read_body(y, contact.body, state);
    centre_of_mass_velocity(&system.bodies()[contact.body].data, state).dot(&contact.normal)
}
