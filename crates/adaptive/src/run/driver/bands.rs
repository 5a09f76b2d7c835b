//! What bands of an impact are made from: the force of a contact over time and what it does to the modes of
//! its bodies at the peak.

mod sequels;

use ffr_dynamics::body::{ModalDamping, ModalMass, RigidMotion};
use ffr_dynamics::system::joints::JointKind;
use ffr_dynamics::system::vibration::pressed::{PressedMode, PressedModes, UnitMotion};
use tracing::debug;

use sequels::{SystemModes, observe};

use super::Driver;
use super::checks::Doubts;
use crate::checks::resolution::highest_free_mode;
use crate::model::RunModel;
use crate::record::band::{Band, NoBand, Source};
use crate::record::{ImpactRecord, Sample};
use crate::state::simulation::fill_places;
use crate::uncertainty::replay::{Bodies, Mode, Numbers};
use crate::uncertainty::trace::{Beginning, Instant, Pressed};
use crate::uncertainty::zone::ZoneEstimate;
use crate::uncertainty::{Evidence, parts, shares_of_peak, sum};

/// Change of other forces, as a share of the contact's, up to which it acts alone: with more the shares of the
/// modes would be off by as much.
const ALONE: f64 = 1e-3;
/// Normal force at the first instant, as a share of the largest, from which on the difference of both tells less than the sum.
const EARLY: f64 = 0.5;
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
        let RunModel { system, observed, .. } = &*self.model;
        let states = system.last_evaluation().0;
        let of = |body: usize| {
            let state = &states[body];
            state.elastic.iter().zip(&state.elastic_rates).map(|(q, rate)| [*q, *rate]).collect()
        };
        let modes = self.pressed(i).map(of).collect();
        let y = self.integrator.state();
        let is_small = system.model().n_rates() <= MOST_RATES;
        let is_asked = !self.run.peaks.records.is_empty() || !self.pressed(i).all(|body| self.is_free(body));
        let mut places = Sample::default();
        if is_small && is_asked {
            fill_places(system, observed, time, y, &mut places);
        }
        let state = (is_small && is_asked).then(|| y.to_vec());
        self.slots[i].trace.begun = Some(Beginning { time, modes, state, places });
    }

    /// Keeps the forces of all contacts at the end of a step at `time`, which they were evaluated at last:
    /// directly after it, for who asks the system for motions makes it forget them. A step that is taken
    /// again replaces what it was before.
    pub(super) fn keep_forces(&mut self, time: f64) {
        if !self.settings.uncertainty {
            return;
        }
        let (sums, mut found) = (self.model.system.last_evaluation().1, self.model.system.found().peekable());
        for (i, (slot, contact)) in self.slots.iter_mut().zip(self.model.system.forces()).enumerate() {
            // One that is far apart is not asked, unless it had a force before.
            if found.next_if_eq(&i).is_none() && slot.trace.instants.is_empty() {
                continue;
            }
            let (report, facts) = (contact.contact.report(), contact.contact.facts());
            let has_springs = facts.n_points() > 0 && facts.penalty().is_finite();
            let penetration = if has_springs { report.penetration } else { 0.0 };
            let (force, resultant) = (report.normal_force, report.force);
            let trace = &mut slot.trace;
            let is_largest = trace.keep(Instant { time, force, penetration });
            if !is_largest && trace.first.is_some() {
                continue;
            }
            let (body, target) = facts.bodies();
            let bodies = [(Some(body), resultant), (target, -resultant)];
            let bodies = bodies.into_iter().filter_map(|(body, force)| Some((body?, force)));
            let (own, sums) = bodies.map(|(body, own)| (own, sums[body].clone())).unzip();
            let now = Pressed { normal: force, own, sums };
            if is_largest {
                let none = now.none();
                let before = trace.first.as_ref().filter(|first| first.normal < EARLY * force);
                (trace.pushes, trace.is_alone) = now.pushes(before.unwrap_or(&none), ALONE);
            }
            trace.first.get_or_insert(now);
        }
    }

    /// Keeps the energy of the state noted last.
    pub(super) fn keep_energy(&mut self) {
        let energy = self.output.sample.energies.total();
        self.slots.iter_mut().for_each(|slot| slot.trace.keep_energy(energy));
    }

    /// The bands of the impact of a contact that was reported as `record`;
    /// `is_alone`: whether no other contact pressed its bodies meanwhile.
    pub(super) fn band(&mut self, record: &ImpactRecord, is_alone: bool, doubts: &Doubts) -> Band {
        if !self.settings.uncertainty {
            return Band::none(NoBand::Off);
        }
        let evidence = self.evidence(record, is_alone, doubts).and_then(|(mut evidence, instants)| {
            evidence.instants = &instants;
            let parts = parts(&evidence)?;
            debug!(parts = ?parts.of_numbers, "parts of the bands");
            Ok((sum(&evidence, &parts.of_numbers), parts))
        });
        let band = evidence.as_ref().map_or_else(|missing| Band::none(*missing), |(band, _)| *band);
        self.follow(record, &band, evidence.map(|(_, parts)| parts));
        band
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
        let begun = trace.begun.as_ref().ok_or(NoBand::Continued)?;
        if self.run.contacts[i].is_by_law {
            return Err(NoBand::NotOneForce);
        }
        if self.model.contacts[i].zone == ZoneEstimate::Unknown {
            return Err(NoBand::Coarse);
        }
        if !record.separation_velocity.is_finite() {
            return Err(if is_alone { NoBand::Unended } else { NoBand::OtherForces });
        }
        if record.start < begun.time - self.impact_step {
            return Err(NoBand::Continued);
        }
        if !trace.is_alone {
            return Err(NoBand::OtherForces);
        }
        let (bodies, ends) = match self.pressed(i).all(|body| self.is_free(body)) {
            true => self.free_bodies(record, begun)?,
            false => self.held_bodies(record, &self.system_modes(record, begun)?),
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
                peak_time: record.peak_time - record.start,
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

    /// Bodies of an impact that nothing holds, with their modes and where those of each end; `begun`: what they were like at its
    /// beginning.
    fn free_bodies(&self, record: &ImpactRecord, begun: &Beginning) -> Result<(Bodies, Vec<usize>), NoBand> {
        let i = record.contact as usize;
        let since = record.start - begun.time;
        let (mut modes, mut ends) = (Vec::new(), Vec::new());
        for ((body, push), at_start) in self.pressed(i).zip(&self.slots[i].trace.pushes).zip(&begun.modes) {
            let data = &self.model.system.model().bodies[body].data;
            let is_simple = data.modal_mass == ModalMass::Identity
                && !matches!(data.modal_damping, ModalDamping::Full(_));
            if !is_simple || at_start.len() != push.elastic.len() {
                return Err(NoBand::ModesOfFile);
            }
            let errors = [self.frequency_errors(body)?];
            let mode = |(k, (share, start)): (usize, (&f64, &[f64; 2]))| {
                let stiffness = data.modal_stiffness[k];
                let damping = match &data.modal_damping {
                    ModalDamping::PerMode(coefficients) => coefficients[k],
                    ModalDamping::None | ModalDamping::Full(_) => 0.0,
                };
                let mode =
                    Mode { stiffness, damping, share: *share, carried: 0.0, start: *start, error: 0.0 };
                mode.with_error(&errors).after(since)
            };
            modes.extend(push.elastic.iter().zip(at_start).enumerate().map(mode));
            ends.push(modes.len());
        }
        let (speed, approach) = (record.approach_velocity, record.approach_velocity);
        let mass = record.impulse / (speed + record.separation_velocity);
        Ok((Bodies { mass, speed, approach, modes }, ends))
    }

    /// Modes of the whole system at the beginning `begun` of an impact, those of each body together (Eq. U.13).
    fn system_modes(&self, record: &ImpactRecord, begun: &Beginning) -> Result<SystemModes, NoBand> {
        let i = record.contact as usize;
        let RunModel { system, observed, .. } = &*self.model;
        let model = system.model();
        let is_driven =
            model.bodies.iter().any(|body| body.layout.n_velocities < body.joint.kind.n_velocities());
        let y = begun.state.as_ref().filter(|_| !is_driven).ok_or(NoBand::OtherForces)?;
        let errors =
            self.pressed(i).map(|body| self.frequency_errors(body)).collect::<Result<Vec<_>, _>>()?;
        let pushes: Vec<_> = self.pressed(i).zip(self.slots[i].trace.pushes.iter().cloned()).collect();
        let records = &self.run.peaks.records;
        let asked = |unit: UnitMotion<'_>| observe(records, observed, unit);
        let found = system.pressed_modes((record.start, y), &pushes, asked);
        let PressedModes { mut modes, observed } = found.map_err(|_| NoBand::OtherForces)?;
        modes.sort_by_key(|mode| mode.body);
        let since = record.start - begun.time;
        let mode = |found: &PressedMode| {
            let stiffness = found.squared_frequency;
            let (damping, share, carried, start) = (found.damping, found.share, found.carried, found.start);
            let mode = Mode { stiffness, damping, share, carried, start, error: 0.0 };
            mode.with_error(&errors).after(since)
        };
        let ends =
            (0..modes.len()).filter(|k| modes.get(k + 1).is_none_or(|next| next.body != modes[*k].body));
        Ok(SystemModes {
            begun: modes.iter().map(|mode| mode.start).collect(),
            ends: ends.map(|last| last + 1).collect(),
            modes: modes.iter().map(mode).collect(),
            by_mode: modes.into_iter().map(|mode| mode.observed).collect(),
            by_force: observed,
        })
    }

    /// Bodies of an impact of which joints hold one, by the modes `found` of the system (Eq. U.13).
    fn held_bodies(&self, record: &ImpactRecord, found: &SystemModes) -> (Bodies, Vec<usize>) {
        let slowest = (SLOW / (record.end - record.start)).powi(2);
        let is_slow = |mode: &&Mode| mode.stiffness <= slowest;
        let slow = || found.modes.iter().filter(is_slow);
        let mobility: f64 = slow().map(|mode| mode.share * mode.share).sum();
        let speed = -slow().map(|mode| mode.share * mode.start[1]).sum::<f64>();
        let ends = found.ends.iter().map(|end| found.modes[..*end].iter().filter(|m| !is_slow(m)).count());
        let modes = found.modes.iter().filter(|mode| !is_slow(mode)).copied().collect();
        let approach = record.approach_velocity;
        (Bodies { mass: mobility.recip(), speed, approach, modes }, ends.collect())
    }

    /// The shares by which the mesh of `body` puts frequencies off.
    fn frequency_errors(&self, body: usize) -> Result<impl Fn(f64) -> f64 + use<>, NoBand> {
        let errors = self.model.frequency_errors(body).ok_or(NoBand::ModesOfFile)?;
        Ok(move |frequency| errors.at(frequency))
    }
}
