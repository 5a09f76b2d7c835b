//! A contact whose zones vibrate: high-frequency modes of the interfaces as coordinates of the force element
//! (docs/theory.md Eqs. C.46, C.47).
//!
//! Wraps a contact without compliance, whose points know the modes of the zones behind those of the bodies. To the bodies it
//! is a force on their low-frequency coordinates; the zones' coordinates have the contact's forces as their only load, for their modes
//! are mass-orthogonal to all rigid and low-frequency motion.

use std::cell::RefCell;

use ffr_dynamics::data_error::DataError;
use ffr_dynamics::error::EvaluationFailure;
use ffr_dynamics::system::force::{BodyState, ForceElement, ForceEnergies, GeneralisedForce};
use nalgebra::{UnitQuaternion, Vector3};

use crate::ContactError;
use crate::contact_element::{ContactElement, ContactReport};

/// High-frequency modes of the contact zone of one body.
#[derive(Debug, Clone, PartialEq)]
pub struct ZoneVibration {
    /// Index of the body.
    pub body: usize,
    /// Its number of low-frequency coordinates.
    pub n_low: usize,
    /// Its mass, by which errors count \[kg\].
    pub mass: f64,
    /// Angular eigenfrequencies [rad/s].
    pub omega: Vec<f64>,
    /// Damping coefficients `2 ζ_j ω_j`, one a mode [1/s].
    pub damping: Vec<f64>,
}

impl ZoneVibration {
    fn len(&self) -> usize {
        self.omega.len()
    }
}

/// A contact with zones that vibrate.
pub struct VibratingContact<C> {
    contact: C,
    zones: Vec<ZoneVibration>,
    /// Coordinates of all zones, then their rates.
    own: Vec<f64>,
    /// Motions with the zones' coordinates behind those of the bodies.
    states: RefCell<Vec<BodyState>>,
    forces: Vec<GeneralisedForce>,
    report: ContactReport,
}

impl<C: ContactElement> VibratingContact<C> {
    /// `contact` with the vibrating `zones`, in a system of `n_bodies` bodies.
    ///
    /// # Errors
    /// [`ContactError::Data`] if a zone's body takes no part in the contact, or numbers of modes differ.
    pub fn new(contact: C, zones: Vec<ZoneVibration>, n_bodies: usize) -> Result<Self, ContactError> {
        let (body, target) = contact.bodies();
        let mut states: Vec<BodyState> = (0..n_bodies).map(|_| BodyState::at_rest(0)).collect();
        for zone in &zones {
            if zone.body != body && Some(zone.body) != target {
                return Err(ContactError::ForeignBody { body: zone.body });
            }
            if zone.damping.len() != zone.len() {
                let (what, found) = ("damping coefficients of a contact zone".into(), zone.damping.len());
                return Err(DataError::Count { what, found, expected: zone.len() }.into());
            }
            let missing = DataError::Index { what: "bodies".into(), number: zone.body, count: n_bodies };
            *states.get_mut(zone.body).ok_or(missing)? = BodyState::at_rest(zone.n_low + zone.len());
        }
        let n: usize = zones.iter().map(ZoneVibration::len).sum();
        Ok(Self {
            forces: states.iter().map(|s| GeneralisedForce::zeros(s.elastic.len())).collect(),
            states: RefCell::new(states),
            own: vec![0.0; 2 * n],
            report: ContactReport::default(),
            contact,
            zones,
        })
    }

    /// Calls `f` with the motions that the contact sees: those of the bodies and, behind their coordinates, the zones'.
    fn seen<T>(&self, bodies: &[BodyState], f: impl FnOnce(&[BodyState]) -> T) -> T {
        let mut states = self.states.borrow_mut();
        self.fill(bodies, &mut states);
        f(&states)
    }

    fn fill(&self, bodies: &[BodyState], states: &mut [BodyState]) {
        let (q, rates) = self.own.split_at(self.own.len() / 2);
        let mut first = 0;
        for zone in &self.zones {
            let (body, state) = (&bodies[zone.body], &mut states[zone.body]);
            (state.position, state.rotation) = (body.position, body.rotation);
            (state.velocity, state.angular_velocity) = (body.velocity, body.angular_velocity);
            let last = first + zone.len();
            state.elastic[..zone.n_low].copy_from_slice(&body.elastic);
            state.elastic[zone.n_low..].copy_from_slice(&q[first..last]);
            state.elastic_rates[..zone.n_low].copy_from_slice(&body.elastic_rates);
            state.elastic_rates[zone.n_low..].copy_from_slice(&rates[first..last]);
            first = last;
        }
    }

    /// Energies of the contact, and of the zones in their present coordinates.
    fn energies_of_zones(&self, contact: ForceEnergies) -> ForceEnergies {
        let (q, rates) = self.own.split_at(self.own.len() / 2);
        let modes = self.zones.iter().flat_map(|z| z.omega.iter().zip(&z.damping));
        modes.zip(q.iter().zip(rates)).fold(contact, |sum, ((omega, damping), (q, rate))| ForceEnergies {
            elastic_high: sum.elastic_high + 0.5 * (omega * q).powi(2),
            kinetic: sum.kinetic + 0.5 * rate * rate,
            dissipated_power: sum.dissipated_power + damping * rate * rate,
            ..sum
        })
    }
}

impl<C: ContactElement> ForceElement for VibratingContact<C> {
    fn apply(
        &mut self,
        t: f64,
        bodies: &[BodyState],
        forces: &mut [GeneralisedForce],
    ) -> Result<(), EvaluationFailure> {
        let mut states = self.states.take();
        self.fill(bodies, &mut states);
        self.zones.iter().for_each(|zone| self.forces[zone.body].clear());
        let outcome = self.contact.apply(t, &states, &mut self.forces);
        self.states.replace(states);
        outcome?;
        for zone in &self.zones {
            let (part, sum) = (&self.forces[zone.body], &mut forces[zone.body]);
            sum.force += part.force;
            sum.torque += part.torque;
            sum.elastic.iter_mut().zip(&part.elastic).for_each(|(sum, f)| *sum += f);
        }
        let report = *self.contact.report();
        self.report = ContactReport { energies: self.energies_of_zones(report.energies), ..report };
        Ok(())
    }

    fn energies(&self) -> ForceEnergies {
        self.report.energies
    }

    fn resultant(&self) -> Vector3<f64> {
        self.contact.resultant()
    }

    fn is_idle(&self) -> bool {
        self.contact.is_idle()
    }

    fn save(&mut self) {
        self.contact.save();
    }

    fn restore(&mut self) {
        self.contact.restore();
    }

    fn n_coordinates(&self) -> usize {
        self.own.len() / 2
    }

    fn set_coordinates(&mut self, own: &[f64]) {
        self.own.copy_from_slice(own);
    }

    fn accelerations(&self, out: &mut [f64]) {
        let (q, rates) = self.own.split_at(self.own.len() / 2);
        let mut first = 0;
        for zone in &self.zones {
            let load = &self.forces[zone.body].elastic[zone.n_low..];
            for (j, (omega, damping)) in zone.omega.iter().zip(&zone.damping).enumerate() {
                let i = first + j;
                out[i] = load[j] - damping * rates[i] - omega * omega * q[i];
            }
            first += zone.len();
        }
    }

    fn coordinate_speed(&self, own: &[f64]) -> f64 {
        let (q, rates) = own.split_at(own.len() / 2);
        let modes = self.zones.iter().flat_map(|z| z.omega.iter().map(|w| (*w, z.mass)));
        let squares = modes.zip(q.iter().zip(rates));
        squares.map(|((w, m), (q, rate))| ((w * q).powi(2) + rate * rate) / m).sum::<f64>().sqrt()
    }
}

impl<C: ContactElement> ContactElement for VibratingContact<C> {
    fn kind(&self) -> &'static str {
        self.contact.kind()
    }

    fn bodies(&self) -> (usize, Option<usize>) {
        self.contact.bodies()
    }

    fn smallest_gap(&self, bodies: &[BodyState]) -> f64 {
        self.seen(bodies, |states| self.contact.smallest_gap(states))
    }

    fn normal(&self, bodies: &[BodyState]) -> Vector3<f64> {
        self.seen(bodies, |states| self.contact.normal(states))
    }

    fn place(&self, bodies: &[BodyState]) -> Vector3<f64> {
        self.seen(bodies, |states| self.contact.place(states))
    }

    fn report(&self) -> &ContactReport {
        &self.report
    }

    fn penalty(&self) -> f64 {
        self.contact.penalty()
    }

    fn n_points(&self) -> usize {
        self.contact.n_points()
    }

    fn check_orientation(&self, rotation: &UnitQuaternion<f64>) -> Result<(), ContactError> {
        self.contact.check_orientation(rotation)
    }

    fn point_forces(&self) -> &[f64] {
        self.contact.point_forces()
    }

    fn point(&self, i: usize) -> Option<([f64; 3], f64)> {
        self.contact.point(i)
    }

    fn set_penalty(&mut self, penalty: f64) -> Result<(), ContactError> {
        self.contact.set_penalty(penalty)
    }

    fn forget(&mut self) {
        self.contact.forget();
        self.report = ContactReport::default();
    }
}
