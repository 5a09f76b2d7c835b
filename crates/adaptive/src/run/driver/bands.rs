//! What bands of an impact are made from: the force of a contact over time and what it does to the modes of
//! its bodies at the peak.

use ffr_dynamics::body::{ModalDamping, ModalMass, RigidMotion};
use ffr_dynamics::system::joints::JointKind;
use nalgebra::Vector3;

use super::Driver;
use super::checks::Doubts;
use crate::checks::resolution::{frequency_error, highest_free_mode};
use crate::record::ImpactRecord;
use crate::record::band::{Band, NoBand};
use crate::system::body::{BodyForm, BodyModel};
use crate::uncertainty::replay::{Mode, Numbers};
use crate::uncertainty::trace::Instant;
use crate::uncertainty::zone::ZoneEstimate;
use crate::uncertainty::{Evidence, band};

/// Force that is not the contact's, as a share of it, up to which it acts alone: with more the shares of the
/// modes would be off by as much.
const ALONE: f64 = 1e-3;

impl Driver<'_> {
    /// The bodies of contact `i`.
    fn pressed(&self, i: usize) -> impl Iterator<Item = usize> + use<> {
        let (body, target) = self.model.system.forces()[i].contact.facts().bodies();
        [Some(body), target].into_iter().flatten()
    }

    /// Begins to keep what contact `i` does, in the motions of the last evaluation.
    pub(super) fn begin_trace(&mut self, i: usize, time: f64) {
        if !self.settings.uncertainty || self.slots[i].trace.begun.is_some() {
            return;
        }
        let states = self.model.system.last_evaluation().0;
        let of = |body: usize| {
            let state = &states[body];
            state.elastic.iter().zip(&state.elastic_rates).map(|(q, rate)| [*q, *rate]).collect()
        };
        let at_start = self.pressed(i).map(of).collect();
        self.slots[i].trace.begun = Some((time, at_start));
    }

    /// Keeps the forces of all contacts at the end of a step at `time`, which they were evaluated at last:
    /// directly after it, for who asks the system for motions makes it forget them. A step that is taken
    /// again replaces what it was before.
    pub(super) fn keep_forces(&mut self, time: f64) {
        if !self.settings.uncertainty {
            return;
        }
        let sums = self.model.system.last_evaluation().1;
        for (slot, contact) in self.slots.iter_mut().zip(self.model.system.forces()) {
            let (report, facts) = (contact.contact.report(), contact.contact.facts());
            let has_springs = facts.n_points() > 0 && facts.penalty().is_finite();
            let penetration = if has_springs { report.penetration } else { 0.0 };
            let (force, resultant) = (report.normal_force, report.force);
            let trace = &mut slot.trace;
            if !trace.keep(Instant { time, force, penetration }) {
                continue;
            }
            let (body, target) = facts.bodies();
            let bodies = [(Some(body), resultant), (target, -resultant)];
            let bodies = bodies.into_iter().filter_map(|(body, force)| Some((body?, force)));
            let alone = |(body, expected): (usize, Vector3<f64>)| {
                (sums[body].force - expected).norm() <= ALONE * resultant.norm()
            };
            trace.is_alone = bodies.clone().all(alone);
            let share = |(body, _): (usize, _)| sums[body].elastic.iter().map(|f| f / force).collect();
            trace.shares = bodies.map(share).collect();
        }
    }

    /// Keeps the energy of the state noted last.
    pub(super) fn keep_energy(&mut self) {
        let energy = self.output.sample.energies.total();
        self.slots.iter_mut().for_each(|slot| slot.trace.keep_energy(energy));
    }

    /// The bands of the impact of a contact that was reported as `record`;
    /// `is_alone`: whether no other contact pressed its bodies meanwhile.
    pub(super) fn band(&self, record: &ImpactRecord, is_alone: bool, doubts: &Doubts) -> Band {
        if !self.settings.uncertainty {
            return Band::none(NoBand::Off);
        }
        match self.evidence(record, is_alone, doubts) {
            Ok((mut evidence, instants)) => {
                evidence.instants = &instants;
                band(&evidence)
            }
            Err(missing) => Band::none(missing),
        }
    }

    fn evidence(
        &self,
        record: &ImpactRecord,
        is_alone: bool,
        doubts: &Doubts,
    ) -> Result<(Evidence<'static>, Vec<Instant>), NoBand> {
        let i = record.contact as usize;
        let slot = &self.slots[i];
        let trace = &slot.trace;
        let (begun, at_start) = trace.begun.as_ref().ok_or(NoBand::Continued)?;
        if self.model.contacts[i].zone == ZoneEstimate::Unknown {
            return Err(NoBand::Coarse);
        }
        if !record.separation_velocity.is_finite() {
            return Err(NoBand::Unended);
        }
        if record.start < begun - self.impact_step {
            return Err(NoBand::Continued);
        }
        if !(is_alone && trace.is_alone && self.pressed(i).all(|body| self.is_free(body))) {
            return Err(NoBand::OtherForces);
        }
        let (mut modes, mut ends) = (Vec::new(), Vec::new());
        let since = record.start - begun;
        for ((body, shares), at_start) in self.pressed(i).zip(&trace.shares).zip(at_start) {
            modes.extend(self.modes_of(body, (shares, at_start), since)?);
            ends.push(modes.len());
        }
        let within = |instant: &&Instant| (record.start..=record.end).contains(&instant.time);
        let mut instants = vec![Instant { time: record.start, force: 0.0, penetration: 0.0 }];
        instants.extend(trace.instants.iter().filter(within));
        instants.push(Instant { time: record.end, force: 0.0, penetration: 0.0 });
        let facts = &self.model.contacts[i];
        let highest = self.pressed(i).filter_map(|body| highest_free_mode(&self.model.bodies[body]));
        let evidence = Evidence {
            numbers: Numbers {
                peak_force: record.peak_force,
                duration: record.end - record.start,
                impulse: record.impulse,
                separation_velocity: record.separation_velocity,
                restitution: record.restitution,
            },
            start: record.start,
            speed: record.approach_velocity,
            instants: &[],
            modes,
            ends,
            zone: facts.zone,
            touch: doubts.touch,
            across: self.points_across(i).max(1.0),
            cut_off: highest.reduce(f64::min),
            ringing: doubts.ringing.map(|ringing| ringing.share * ringing.mean),
            steps: self.model.system.error_scale().relative * trace.instants.len() as f64,
            energy: trace.energy.map_or(0.0, |[first, last]| last - first),
        };
        Ok((evidence, instants))
    }

    /// Whether no joint and no loop holds `body`.
    fn is_free(&self, body: usize) -> bool {
        let system = self.model.system.model();
        let joint = &system.bodies[body].joint;
        let kind = match system.bodies[body].data.motion {
            RigidMotion::Spatial => JointKind::Free,
            RigidMotion::Planar => JointKind::Planar,
            RigidMotion::Axial => JointKind::Axial,
        };
        let holds_other = self.groups.iter().filter(|group| **group == self.groups[body]).count() > 1;
        joint.kind == kind && joint.parent.body.is_none() && joint.coordinates.is_empty() && !holds_other
    }

    /// The modes of `body` with their shares at the peak and what they were at the beginning, the touch being
    /// `since` \[s\] later.
    fn modes_of(
        &self,
        body: usize,
        (shares, at_start): (&[f64], &[[f64; 2]]),
        since: f64,
    ) -> Result<Vec<Mode>, NoBand> {
        let model: &BodyModel = &self.model.bodies[body];
        let data = &self.model.system.model().bodies[body].data;
        let is_simple =
            data.modal_mass == ModalMass::Identity && !matches!(data.modal_damping, ModalDamping::Full(_));
        if matches!(model.form, BodyForm::Imported(_)) || !is_simple || at_start.len() != shares.len() {
            return Err(NoBand::ModesOfFile);
        }
        let known = self.model.frequency_errors.get(body).copied().flatten();
        // The mesh is asked once, for it is slow to answer.
        let highest = data.modal_stiffness.iter().copied().fold(0.0, f64::max);
        let ask = || frequency_error(model, highest.sqrt() / std::f64::consts::TAU);
        let of_highest = if known.is_none() && highest > 0.0 { ask() } else { None };
        let mode = |(k, (share, start)): (usize, (&f64, &[f64; 2]))| {
            let stiffness = data.modal_stiffness[k];
            let damping = match &data.modal_damping {
                ModalDamping::PerMode(coefficients) => coefficients[k],
                ModalDamping::None | ModalDamping::Full(_) => 0.0,
            };
            let of_mesh = of_highest.map(|(error, power)| error * (stiffness / highest).sqrt().powf(power));
            let error = known.or(of_mesh).unwrap_or(0.0);
            Mode { stiffness, damping, share: *share, start: *start, error }.after(since)
        };
        Ok(shares.iter().zip(at_start).enumerate().map(mode).collect())
    }
}
