//! A contact whose zones vibrate: high-frequency modes of the interfaces as coordinates of the
//! force element (docs/theory.md Eqs. C.47, C.48).
//!
//! Wraps a contact without compliance, whose points know the modes of the zones behind those of the
//! bodies. To the bodies it is a force on their low-frequency coordinates; the zones' coordinates
//! have the contact's forces as their only load, for their modes are mass-orthogonal to all rigid
//! and low-frequency motion.

use ffr_dynamics::data_error::DataError;
use ffr_dynamics::error::EvaluationFailure;
use ffr_dynamics::force::{BodyState, Findings, ForceElement, ForceEnergies, GeneralisedForce, Motion};
use nalgebra::Vector3;

use crate::ContactError;
use crate::contact_element::{Contact, ContactElement, ContactReport, Meeting};

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
    /// Damping coefficients `2 ζ_j ω_j`, one per mode [1/s].
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
    /// Number of coordinates of each body that the contact sees: its own and the zone's; zero for
    /// bodies without a zone.
    n_seen: Vec<usize>,
}

/// Buffers of a contact with zones that vibrate, around those of the contact.
pub struct VibratingWorkspace<W> {
    contact: W,
    /// Motions with the zones' coordinates behind those of the bodies.
    states: Vec<BodyState>,
    /// Forces on them.
    forces: Vec<GeneralisedForce>,
}

/// Results of an evaluation of a contact with zones that vibrate.
pub struct VibratingFound<F> {
    contact: F,
    report: ContactReport,
    accelerations: Vec<f64>,
}

impl<C: ContactElement> VibratingContact<C> {
    /// `contact` with the vibrating `zones`, in a system of `n_bodies` bodies.
    ///
    /// # Errors
    /// [`ContactError::Data`] if a zone's body takes no part in the contact, or numbers of modes differ; [`ContactError::Nothing`] if a body of the
    /// contact has no zone: that of a rigid one has no modes.
    pub fn new(contact: C, zones: Vec<ZoneVibration>, n_bodies: usize) -> Result<Self, ContactError> {
        let (body, target) = contact.bodies();
        let mut n_seen = vec![0; n_bodies];
        for zone in &zones {
            if zone.body != body && Some(zone.body) != target {
                return Err(ContactError::ForeignBody { body: zone.body });
            }
            if zone.damping.len() != zone.len() {
                let (what, found) = ("damping coefficients of a contact zone".into(), zone.damping.len());
                return Err(DataError::Count { what, found, expected: zone.len() }.into());
            }
            let missing = DataError::Index { what: "bodies".into(), number: zone.body, count: n_bodies };
            *n_seen.get_mut(zone.body).ok_or(missing)? = zone.n_low + zone.len();
        }
        let mut bodies = [Some(body), target].into_iter().flatten();
        if bodies.any(|body| zones.iter().all(|zone| zone.body != body)) {
            return Err(ContactError::Nothing { what: "a body of the contact has no vibrating zone" });
        }
        Ok(Self { contact, zones, n_seen })
    }

    /// The motion that the contact sees, in `states`: that of the bodies and, behind their
    /// coordinates, the zones'.
    fn seen<'a>(&self, motion: Motion<'_>, states: &'a mut [BodyState]) -> Motion<'a> {
        let (q, rates) = motion.internal.split_at(motion.internal.len() / 2);
        let mut first = 0;
        for zone in &self.zones {
            let (body, state) = (&motion.bodies[zone.body], &mut states[zone.body]);
            (state.position, state.rotation) = (body.position, body.rotation);
            (state.velocity, state.angular_velocity_in_body) = (body.velocity, body.angular_velocity_in_body);
            let last = first + zone.len();
            state.elastic[..zone.n_low].copy_from_slice(&body.elastic);
            state.elastic[zone.n_low..].copy_from_slice(&q[first..last]);
            state.elastic_rates[..zone.n_low].copy_from_slice(&body.elastic_rates);
            state.elastic_rates[zone.n_low..].copy_from_slice(&rates[first..last]);
            first = last;
        }
        Motion::new(motion.time, states)
    }

    /// Energies of the contact, and of the zones at the coordinates `internal`.
    fn energies_of_zones(&self, internal: &[f64], contact: ForceEnergies) -> ForceEnergies {
        let (q, rates) = internal.split_at(internal.len() / 2);
        let modes = self.zones.iter().flat_map(|z| z.omega.iter().zip(&z.damping));
        modes.zip(q.iter().zip(rates)).fold(contact, |sum, ((omega, damping), (q, rate))| ForceEnergies {
            elastic_high: sum.elastic_high + 0.5 * (omega * q).powi(2),
            kinetic: sum.kinetic + 0.5 * rate * rate,
            dissipated_power: sum.dissipated_power + damping * rate * rate,
            ..sum
        })
    }

    /// Second derivatives of the coordinates `internal` under `forces` on the modes (Eq. C.47).
    fn accelerate(&self, internal: &[f64], forces: &[GeneralisedForce], out: &mut [f64]) {
        let (q, rates) = internal.split_at(internal.len() / 2);
        let mut first = 0;
        for zone in &self.zones {
            let load = &forces[zone.body].elastic[zone.n_low..];
            for (j, (omega, damping)) in zone.omega.iter().zip(&zone.damping).enumerate() {
                let i = first + j;
                out[i] = load[j] - damping * rates[i] - omega * omega * q[i];
            }
            first += zone.len();
        }
    }
}

impl<F: Findings> Findings for VibratingFound<F> {
    fn energies(&self) -> ForceEnergies {
        self.report.energies
    }

    fn resultant(&self) -> Vector3<f64> {
        self.contact.resultant()
    }

    fn is_idle(&self) -> bool {
        self.contact.is_idle()
    }

    fn accelerations(&self) -> &[f64] {
        &self.accelerations
    }
}

impl<C: ContactElement> ForceElement for VibratingContact<C> {
    type State = C::State;
    type Workspace = VibratingWorkspace<C::Workspace>;
    type Found = VibratingFound<C::Found>;

    fn start(&self) -> (Self::State, Self::Workspace, Self::Found) {
        let (state, contact, found) = self.contact.start();
        let workspace = VibratingWorkspace {
            contact,
            states: self.n_seen.iter().map(|n| BodyState::at_rest(*n)).collect(),
            forces: self.n_seen.iter().map(|n| GeneralisedForce::zeros(*n)).collect(),
        };
        let found = VibratingFound {
            contact: found,
            report: ContactReport::default(),
            accelerations: vec![0.0; self.n_coordinates()],
        };
        (state, workspace, found)
    }

    fn evaluate(
        &self,
        motion: Motion<'_>,
        state: &mut C::State,
        workspace: &mut Self::Workspace,
        found: &mut Self::Found,
        forces: &mut [GeneralisedForce],
    ) -> Result<(), EvaluationFailure> {
        let VibratingWorkspace { contact, states, forces: parts } = workspace;
        self.zones.iter().for_each(|zone| parts[zone.body].clear());
        self.contact.evaluate(self.seen(motion, states), state, contact, &mut found.contact, parts)?;
        for zone in &self.zones {
            let (part, sum) = (&parts[zone.body], &mut forces[zone.body]);
            sum.force += part.force;
            sum.torque_in_body += part.torque_in_body;
            sum.elastic.iter_mut().zip(&part.elastic).for_each(|(sum, f)| *sum += f);
        }
        let report = *self.contact.report(&found.contact);
        found.report =
            ContactReport { energies: self.energies_of_zones(motion.internal, report.energies), ..report };
        self.accelerate(motion.internal, parts, &mut found.accelerations);
        Ok(())
    }

    fn save(&self, state: &mut C::State, found: &Self::Found) {
        self.contact.save(state, &found.contact);
    }

    fn restore(&self, state: &mut C::State, found: &mut Self::Found) {
        self.contact.restore(state, &mut found.contact);
    }

    fn n_coordinates(&self) -> usize {
        self.zones.iter().map(ZoneVibration::len).sum()
    }

    fn coordinate_speed(&self, internal: &[f64]) -> f64 {
        let (q, rates) = internal.split_at(internal.len() / 2);
        let modes = self.zones.iter().flat_map(|z| z.omega.iter().map(|w| (*w, z.mass)));
        let squares = modes.zip(q.iter().zip(rates));
        squares.map(|((w, m), (q, rate))| ((w * q).powi(2) + rate * rate) / m).sum::<f64>().sqrt()
    }
}

impl<C: Contact> Contact for VibratingContact<C> {
    fn kind(&self) -> &'static str {
        self.contact.kind()
    }

    fn bodies(&self) -> (usize, Option<usize>) {
        self.contact.bodies()
    }

    fn penalty(&self) -> f64 {
        self.contact.penalty()
    }

    fn n_points(&self) -> usize {
        self.contact.n_points()
    }

    fn point(&self, i: usize) -> Option<([f64; 3], f64)> {
        self.contact.point(i)
    }
}

/// What its zones do, their own coordinates tell: none of it is quasistatic.
impl<C: ContactElement> ContactElement for VibratingContact<C> {
    fn report<'a>(&self, found: &'a Self::Found) -> &'a ContactReport {
        &found.report
    }

    fn meeting(&self, motion: Motion<'_>, state: &C::State, workspace: &mut Self::Workspace) -> Meeting {
        let seen = self.seen(motion, &mut workspace.states);
        self.contact.meeting(seen, state, &mut workspace.contact)
    }

    fn point_forces<'a>(&self, state: &'a C::State, found: &'a Self::Found) -> Option<&'a [f64]> {
        self.contact.point_forces(state, &found.contact)
    }

    fn friction_forces(&self, state: &C::State, found: &Self::Found) -> Vec<Vector3<f64>> {
        self.contact.friction_forces(state, &found.contact)
    }

    fn prescribe_friction(&self, wanted: Option<&[Vector3<f64>]>, state: &mut C::State, found: &Self::Found) {
        self.contact.prescribe_friction(wanted, state, &found.contact);
    }

    fn set_penalty(&mut self, penalty: f64, state: &mut C::State) -> Result<(), ContactError> {
        self.contact.set_penalty(penalty, state)
    }

    fn compliance_weight(
        &self,
        _: (Motion<'_>, f64),
        _: &mut C::State,
        _: &mut Self::Workspace,
        _: &mut Self::Found,
    ) -> Result<Option<f64>, EvaluationFailure> {
        Ok(None)
    }

    fn interface_force(&self, _: usize, _: &Self::Found, _: &mut [f64]) -> bool {
        false
    }
}
