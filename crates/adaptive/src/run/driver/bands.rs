//! What bands of an impact are made from: the force of a contact over time and what it does to the modes of
//! its bodies at the peak.

use ffr_dynamics::body::{ModalDamping, ModalMass, RigidMotion};
use ffr_dynamics::system::joints::JointKind;
use nalgebra::Vector3;

use super::Driver;
use super::checks::Doubts;
use crate::checks::resolution::{frequency_error, highest_free_mode};
use crate::record::ImpactRecord;
use crate::record::band::{Band, NoBand, Source};
use crate::system::body::{BodyForm, BodyModel};
use crate::uncertainty::replay::{Bodies, Mode, Numbers};
use crate::uncertainty::trace::{Beginning, Instant};
use crate::uncertainty::zone::ZoneEstimate;
use crate::uncertainty::{Evidence, band, shares_of_peak};

/// Force that is not the contact's, as a share of it, up to which it acts alone: with more the shares of the
/// modes would be off by as much.
const ALONE: f64 = 1e-3;
/// Rates of a system that joints hold, at most, for whose modes together an impact pays: a second.
const MOST_RATES: usize = 400;
/// Angle \[rad\] by which a mode that counts as a rigid motion goes on during the impact: a hundredth changes its
/// displacement by 2e-5.
const SLOW: f64 = 1e-2;

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
        let at_start = match self.pressed(i).all(|body| self.is_free(body)) {
            true => Beginning::Free(self.pressed(i).map(of).collect()),
            false => Beginning::Held(self.integrator.state().to_vec()),
        };
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
            trace.pushes = bodies.map(|(body, _)| sums[body].scaled(force.recip())).collect();
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

    /// The parts of the band of the peak force of contact `i` in the trial that has just ended, as shares of it.
    pub(super) fn shares_of_trial(&self, i: usize, is_minor: bool) -> Option<Vec<(Source, f64)>> {
        let records = self.slots[i].monitor.clone().finish(i as u32, 0, |_| true);
        let record = records.into_iter().max_by(|a, b| a.peak_force.total_cmp(&b.peak_force))?;
        let (mut evidence, instants) = self.evidence(&record, true, &self.doubts(i, is_minor)).ok()?;
        evidence.instants = &instants;
        shares_of_peak(&evidence)
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
            return Err(if is_alone { NoBand::Unended } else { NoBand::OtherForces });
        }
        if record.start < begun - self.impact_step {
            return Err(NoBand::Continued);
        }
        if !trace.is_alone {
            return Err(NoBand::OtherForces);
        }
        let (bodies, ends) = match at_start {
            Beginning::Free(at_start) => self.free_bodies(record, (i, at_start), record.start - begun)?,
            Beginning::Held(y) => self.held_bodies(record, (i, y), record.start - begun)?,
        };
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
            instants: &[],
            bodies,
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

    /// Bodies of contact `i` that nothing holds, with their modes and where those of each end; `at_start`: what these were at the beginning, the
    /// touch being `since` \[s\] later.
    fn free_bodies(
        &self,
        record: &ImpactRecord,
        (i, at_start): (usize, &[Vec<[f64; 2]>]),
        since: f64,
    ) -> Result<(Bodies, Vec<usize>), NoBand> {
        let (mut modes, mut ends) = (Vec::new(), Vec::new());
        for ((body, push), at_start) in self.pressed(i).zip(&self.slots[i].trace.pushes).zip(at_start) {
            let data = &self.model.system.model().bodies[body].data;
            let is_simple = data.modal_mass == ModalMass::Identity
                && !matches!(data.modal_damping, ModalDamping::Full(_));
            if !is_simple || at_start.len() != push.elastic.len() {
                return Err(NoBand::ModesOfFile);
            }
            let errors = self.frequency_errors(body)?;
            let mode = |(k, (share, start)): (usize, (&f64, &[f64; 2]))| {
                let stiffness = data.modal_stiffness[k];
                let damping = match &data.modal_damping {
                    ModalDamping::PerMode(coefficients) => coefficients[k],
                    ModalDamping::None | ModalDamping::Full(_) => 0.0,
                };
                let error = errors(stiffness);
                Mode { stiffness, damping, share: *share, carried: 0.0, start: *start, error }.after(since)
            };
            modes.extend(push.elastic.iter().zip(at_start).enumerate().map(mode));
            ends.push(modes.len());
        }
        let (speed, approach) = (record.approach_velocity, record.approach_velocity);
        let mass = record.impulse / (speed + record.separation_velocity);
        Ok((Bodies { mass, speed, approach, modes }, ends))
    }

    /// Bodies of contact `i` of which joints hold one: the modes of the system in its state `y` at the beginning, those of each body together
    /// (Eq. U.13).
    fn held_bodies(
        &self,
        record: &ImpactRecord,
        (i, y): (usize, &[f64]),
        since: f64,
    ) -> Result<(Bodies, Vec<usize>), NoBand> {
        let system = &self.model.system;
        let model = system.model();
        let is_driven =
            model.bodies.iter().any(|body| body.layout.n_velocities < body.joint.kind.n_velocities());
        if model.n_rates() > MOST_RATES || is_driven || y.len() != self.model.dimension() {
            return Err(NoBand::OtherForces);
        }
        let errors =
            self.pressed(i).map(|body| self.frequency_errors(body)).collect::<Result<Vec<_>, _>>()?;
        let pushes: Vec<_> = self.pressed(i).zip(self.slots[i].trace.pushes.iter().cloned()).collect();
        let mut found = system.pressed_modes((record.start, y), &pushes).map_err(|_| NoBand::OtherForces)?;
        found.sort_by_key(|mode| mode.body);
        let (mut mobility, mut speed) = (0.0, 0.0);
        let (mut modes, mut ends) = (Vec::new(), Vec::new());
        let slowest = (SLOW / (record.end - record.start)).powi(2);
        for (k, mode) in found.iter().enumerate() {
            let stiffness = mode.squared_frequency;
            if stiffness <= slowest {
                mobility += mode.share * mode.share;
                speed -= mode.share * mode.start[1];
            } else {
                let error = errors.iter().map(|error| error(stiffness)).fold(0.0, f64::max);
                let (damping, share, carried, start) = (mode.damping, mode.share, mode.carried, mode.start);
                modes.push(Mode { stiffness, damping, share, carried, start, error }.after(since));
            }
            if found.get(k + 1).is_none_or(|next| next.body != mode.body) {
                ends.push(modes.len());
            }
        }
        let approach = record.approach_velocity;
        Ok((Bodies { mass: mobility.recip(), speed, approach, modes }, ends))
    }

    /// The share by which the mesh of `body` puts a frequency off, of its square [rad²/s²].
    fn frequency_errors(&self, body: usize) -> Result<impl Fn(f64) -> f64 + use<>, NoBand> {
        let model: &BodyModel = &self.model.bodies[body];
        if matches!(model.form, BodyForm::Imported(_)) {
            return Err(NoBand::ModesOfFile);
        }
        let known = self.model.frequency_errors.get(body).copied().flatten();
        // The mesh is asked once, for it is slow to answer.
        let data = &self.model.system.model().bodies[body].data;
        let highest = data.modal_stiffness.iter().copied().fold(0.0, f64::max);
        let ask = || frequency_error(model, highest.sqrt() / std::f64::consts::TAU);
        let of_highest = if known.is_none() && highest > 0.0 { ask() } else { None };
        Ok(move |stiffness: f64| {
            let of_mesh =
                of_highest.map(|(error, power)| error * (stiffness / highest).sqrt().min(1.0).powf(power));
            known.or(of_mesh).unwrap_or(0.0)
        })
    }
}
