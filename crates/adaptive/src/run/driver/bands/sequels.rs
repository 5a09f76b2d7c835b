//! What follows impacts: bands of the largest reactions, displacements and stresses.

use ffr_dynamics::system::vibration::pressed::UnitMotion;

use super::super::Driver;
use crate::record::band::{Band, NoBand};
use crate::record::{ImpactRecord, PeakBand, PeakOf, PeakRecord};
use crate::state::simulation::Observed;
use crate::uncertainty::Parts;
use crate::uncertainty::replay::Mode;
use crate::uncertainty::response::{Output, Response, Sequel};

/// Modes of the system as a force meets them.
pub(super) struct SystemModes {
    /// The modes as they are at the first contact.
    pub modes: Vec<Mode>,
    /// Their coordinates and rates at the beginning, to which the recorded places belong.
    pub begun: Vec<[f64; 2]>,
    /// Where those of each body end.
    pub ends: Vec<usize>,
    /// Six numbers for each record of a largest value, by a unit of each mode.
    pub by_mode: Vec<Vec<f64>>,
    /// The same by a unit of the force, modes at rest.
    pub by_force: Vec<f64>,
}

/// What is recorded in `records`, six numbers each, by a unit of a mode or of the force.
pub(super) fn observe(records: &[PeakRecord], observed: &Observed, unit: UnitMotion<'_>) -> Vec<f64> {
    let of = |record: &PeakRecord| {
        let i = record.index as usize;
        let [x, y, z] = match record.of {
            PeakOf::VonMises => {
                let point = &observed.points[i];
                return point.state(&unit.states[point.body].elastic_rates).stress;
            }
            PeakOf::Displacement | PeakOf::Speed => {
                let point = &observed.points[i];
                point.point.velocity(&unit.states[point.body]).into()
            }
            PeakOf::ReactionForce | PeakOf::ReactionMoment => {
                let reaction = observed.joints.get(i).map(|body| unit.reactions[*body]);
                let is_force = record.of == PeakOf::ReactionForce;
                reaction.map_or([0.0; 3], |r| if is_force { r.force } else { r.moment }.into())
            }
        };
        [x, y, z, 0.0, 0.0, 0.0]
    };
    records.iter().flat_map(of).collect()
}

impl Driver<'_> {
    /// Follows the impact `record` with the bands `band`, of which `parts` were found: largest values of its bodies up to now belong to impacts
    /// before it.
    pub(super) fn follow(&mut self, record: &ImpactRecord, band: &Band, parts: Result<Parts, NoBand>) {
        if self.run.peaks.records.is_empty() {
            return;
        }
        let groups: Vec<usize> = self.groups_of(record.contact as usize).collect();
        self.bound(&groups, record.start);
        let (over, rest): (Vec<_>, Vec<_>) =
            std::mem::take(&mut self.run.sequels).into_iter().partition(|sequel| sequel.presses(&groups));
        self.run.sequels = rest;
        let earlier = over.iter().map(|sequel| sequel.share).fold(0.0, f64::max);
        let shares = [band.impulse / record.impulse, band.peak_force / record.peak_force];
        let own = shares.into_iter().filter(|share| share.is_finite()).reduce(f64::max);
        let response = parts.and_then(|parts| self.response(record, parts, earlier));
        let share = earlier + own.unwrap_or(f64::INFINITY);
        // A group that an earlier impact pressed beside these rings on.
        let more = over.iter().flat_map(|sequel| &sequel.groups).filter(|group| !groups.contains(group));
        let groups = groups.iter().chain(more).copied().collect();
        self.run.sequels.push(Sequel { start: record.start, groups, response, share });
    }

    /// The bands of the largest values of bodies of `groups` up to the time `end` \[s\].
    fn bound(&mut self, groups: &[usize], end: f64) {
        for k in 0..self.run.peaks.records.len() {
            let record = &self.run.peaks.records[k];
            let is_now = |group: &usize| groups.contains(group) && record.time <= end;
            let group = self.group_of(record).filter(is_now);
            let band = group.and_then(|group| {
                self.run.sequels.iter().rev().find_map(|sequel| sequel.band(record, group, end))
            });
            if let Some(band) = band {
                self.run.peaks.records[k].band = band;
            }
        }
    }

    /// The bands of all largest values, at the end of the run.
    pub(in crate::run::driver) fn bound_peaks(&mut self) {
        if !self.settings.uncertainty {
            self.run.peaks.records.iter_mut().for_each(|peak| peak.band = PeakBand::none(NoBand::Off));
        }
        let groups: Vec<usize> = self.run.sequels.iter().flat_map(|sequel| sequel.groups.clone()).collect();
        self.bound(&groups, self.integrator.time());
    }

    /// The group of the body that a largest value is of; none of joints that close loops at ground alone.
    fn group_of(&self, record: &PeakRecord) -> Option<usize> {
        let (i, joints) = (record.index as usize, &self.model.observed.joints);
        let body = match record.of {
            PeakOf::ReactionForce | PeakOf::ReactionMoment => match joints.get(i) {
                Some(body) => *body,
                // Joints that close loops are recorded after the others.
                None => {
                    let closing = self.model.system.model().loops.get(i - joints.len())?;
                    closing.child.body.or(closing.parent.body)?
                }
            },
            PeakOf::Displacement | PeakOf::Speed | PeakOf::VonMises => self.model.observed.points[i].body,
        };
        Some(self.groups[body])
    }

    /// What follows the impact `record`, of which `parts` were found.
    fn response(&self, record: &ImpactRecord, parts: Parts, earlier: f64) -> Result<Response, NoBand> {
        let begun = self.slots[record.contact as usize].trace.begun.as_ref().ok_or(NoBand::Continued)?;
        let found = self.system_modes(record, begun)?;
        let has_loops = !self.model.system.model().loops.is_empty();
        let is_reaction = |of: PeakOf| matches!(of, PeakOf::ReactionForce | PeakOf::ReactionMoment);
        let is_known = |record: &PeakRecord| !(has_loops && is_reaction(record.of));
        let output = |(k, of): (usize, &PeakRecord)| {
            let six = |all: &[f64]| std::array::from_fn(|c| all[6 * k + c]);
            let by_mode: Vec<[f64; 6]> = found.by_mode.iter().map(|all| six(all)).collect();
            let mut without = of.components(&begun.places, &self.run.peaks.origins);
            for ((mode, begun), by_mode) in found.modes.iter().zip(&found.begun).zip(&by_mode) {
                let moved = mode.moved(of.of, *begun, 0.0);
                without.iter_mut().zip(by_mode).for_each(|(sum, c)| *sum -= c * moved);
            }
            Output { of: of.of, index: of.index, without, by_mode, by_force: six(&found.by_force) }
        };
        let records = self.run.peaks.records.iter().enumerate().filter(|(_, record)| is_known(record));
        Ok(Response {
            start: record.start,
            duration: record.end - record.start,
            of_ends: parts.of_ends(record.impulse),
            histories: parts.histories,
            outputs: records.map(output).collect(),
            modes: found.modes,
            ends: found.ends,
            earlier,
        })
    }
}
