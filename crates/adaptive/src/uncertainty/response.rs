//! What an impact does to reactions of joints, displacements and stresses of points until the next one, and by how much that may
//! be off (docs/theory/uncertainty.md Eqs. U.15 to U.17).

use serde::{Deserialize, Serialize};
use tracing::debug;

use super::modes::{goes_on, kept};
use super::replay::{Mode, Transition};
use super::{Histories, MISSED, SAFETY};
use crate::record::band::{NoBand, Source};
use crate::record::{PeakBand, PeakOf, PeakRecord};

/// Instants after the force at which a response is looked at: twenty in a period of the highest mode, but no more than
/// this.
const MOST_INSTANTS: f64 = 2000.0;
const INSTANTS_OF_PERIOD: f64 = 20.0;
/// Share of a largest value that ringing from impacts before it may be where nothing is known of their bands.
const OF_EARLIER: f64 = 1e-2;

/// A reaction, a displacement or a stress as a sum over modes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Output {
    /// What it is.
    pub of: PeakOf,
    /// Number of the joint or point.
    pub index: u32,
    /// Its components without what modes and force do to them.
    pub without: [f64; 6],
    /// Its components by a unit of each mode: of its acceleration in reactions, of its rate in speeds, of its coordinate in
    /// others.
    pub by_mode: Vec<[f64; 6]>,
    /// The same by a unit of the force, modes at rest.
    pub by_force: [f64; 6],
}

/// What follows an impact.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Response {
    /// First contact \[s\].
    pub start: f64,
    /// Time from the first to the last contact \[s\].
    pub duration: f64,
    /// The force as it was repeated with each source changed.
    pub histories: Histories,
    /// Modes of the system.
    pub modes: Vec<Mode>,
    /// Where those of each body end.
    pub ends: Vec<usize>,
    /// What follows from them.
    pub outputs: Vec<Output>,
    /// Share by which steps and ledger may put its impulse off.
    pub of_ends: f64,
    /// Share by which impacts before it may have put the vibrations off that it begins with; infinite if that is not known.
    pub earlier: f64,
}

/// An impact, and what is to be known of what follows it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Sequel {
    /// First contact \[s\].
    pub start: f64,
    /// The groups of bodies that joints connect whose bodies it presses.
    pub groups: Vec<usize>,
    /// What follows.
    pub response: Result<Response, NoBand>,
    /// The largest band of its numbers as a share, with those of impacts of these groups before it; infinite if there is one that is
    /// not known.
    pub share: f64,
}

impl Sequel {
    /// Whether it presses one of `groups`.
    pub fn presses(&self, groups: &[usize]) -> bool {
        self.groups.iter().any(|group| groups.contains(group))
    }

    /// The band of the largest value `record` of a body of the group `group` before `end` \[s\]; none if that was before the impact.
    pub fn band(&self, record: &PeakRecord, group: usize, end: f64) -> Option<PeakBand> {
        (self.groups.contains(&group) && record.time >= self.start).then(|| {
            let response = self.response.as_ref().map_err(|missing| *missing);
            response.and_then(|response| response.band(record, end)).unwrap_or_else(PeakBand::none)
        })
    }
}

/// Modes and force of a response.
struct Variant<'a> {
    modes: &'a [Mode],
    /// Which modes vibrate; others yield statically.
    is_kept: &'a [bool],
    forces: &'a [f64],
}

impl Response {
    /// The band of the largest value `record`, which was recorded after this impact and before `end` \[s\], when the next one or the end
    /// of the run came.
    ///
    /// # Errors
    /// Why it has none.
    pub fn band(&self, record: &PeakRecord, end: f64) -> Result<PeakBand, NoBand> {
        let is_of = |output: &&Output| output.of == record.of && output.index == record.index;
        let output = self.outputs.iter().find(is_of).ok_or(NoBand::Loop)?;
        let until = (record.time + self.duration).min(end) - self.start;
        let of = |modes: &[Mode], is_kept: &[bool], forces: &[f64]| {
            self.series(output, &Variant { modes, is_kept, forces }, until)
        };
        let all = vec![true; self.modes.len()];
        let same = |forces: &[f64]| of(&self.modes, &all, forces);
        let truncated =
            |share: f64, forces: &[f64]| of(&self.modes, &kept(&self.modes, &self.ends, share), forces);
        let Histories { base, stiffer, zone, mesh, half, quarter, .. } = &self.histories;
        let series = same(base);
        let largest = |series: &[[f64; 6]]| series.iter().map(|x| output.of.size(x)).fold(0.0, f64::max);
        let found = largest(&series);
        debug!(?record, found, "largest value of the linear motion");
        if (found / record.value - 1.0).abs() > MISSED || found.is_nan() {
            return Err(NoBand::NotLinear);
        }
        let beside = |other: &[[f64; 6]]| (largest(other) - found).abs();
        let apart = |a: &[[f64; 6]], b: &[[f64; 6]]| {
            let change =
                |(a, b): (&[f64; 6], &[f64; 6])| output.of.size(&std::array::from_fn(|c| a[c] - b[c]));
            a.iter().zip(b).map(change).fold(0.0, f64::max)
        };
        let finer: Vec<Mode> = self.modes.iter().map(|mode| mode.on_finer_mesh()).collect();
        let earlier = largest(&self.ringing_before(output, until));
        if self.earlier.is_infinite() && earlier > OF_EARLIER * found {
            return Err(NoBand::Earlier);
        }
        let [half, quarter] = [truncated(0.5, half), truncated(0.25, quarter)];
        let parts = [
            (Source::Penalty, stiffer.as_ref().map_or(0.0, |forces| 2.0 * beside(&same(forces)))),
            (Source::Zone, beside(&same(zone))),
            (Source::Mesh, beside(&of(&finer, &all, mesh))),
            (Source::Modes, goes_on(apart(&series, &half), apart(&half, &quarter))),
            (Source::Steps, self.of_ends * record.value),
            (Source::Earlier, if earlier > 0.0 { self.earlier.min(1.0) * earlier } else { 0.0 }),
        ];
        let most = parts.iter().max_by(|a, b| a.1.total_cmp(&b.1)).map(|(source, _)| *source);
        let band = SAFETY * parts.iter().map(|(_, part)| part).sum::<f64>();
        Ok(PeakBand { band, largest: most, missing: None })
    }

    /// What vibrations that are there before the impact do alone.
    fn ringing_before(&self, output: &Output, until: f64) -> Vec<[f64; 6]> {
        let zeros = vec![0.0; self.histories.base.len()];
        let alone = |mode: &Mode| match mode.stiffness > 0.0 {
            true => *mode,
            false => Mode { start: [0.0; 2], ..*mode },
        };
        let modes: Vec<Mode> = self.modes.iter().map(alone).collect();
        let none = Output { without: [0.0; 6], ..output.clone() };
        let is_kept = vec![true; self.modes.len()];
        self.series(&none, &Variant { modes: &modes, is_kept: &is_kept, forces: &zeros }, until)
    }

    /// `output` from the first contact to `until` \[s\] after it (Eq. U.15).
    fn series(&self, output: &Output, variant: &Variant<'_>, until: f64) -> Vec<[f64; 6]> {
        let h = self.histories.step;
        let Variant { modes, is_kept, forces } = variant;
        let by_mode = || modes.iter().zip(&output.by_mode).zip(*is_kept);
        let mut by_force = output.by_force;
        // What yields statically exerts nothing on joints and has no speed of its own.
        if matches!(output.of, PeakOf::Displacement | PeakOf::VonMises) {
            for ((mode, by_mode), _) in by_mode().filter(|(_, kept)| !**kept) {
                let yields = mode.share / mode.stiffness;
                by_force.iter_mut().zip(by_mode).for_each(|(sum, c)| *sum += c * yields);
            }
        }
        let value = |at: &[[f64; 2]], force: f64| {
            let mut components = output.without;
            components.iter_mut().zip(&by_force).for_each(|(sum, c)| *sum += c * force);
            for (((mode, by_mode), _), at) in by_mode().zip(at).filter(|((_, kept), _)| **kept) {
                let moved = mode.moved(output.of, *at, force);
                components.iter_mut().zip(by_mode).for_each(|(sum, c)| *sum += c * moved);
            }
            components
        };
        let transitions = |h: f64| -> Vec<_> { modes.iter().map(|mode| Transition::new(mode, h)).collect() };
        let mut at: Vec<[f64; 2]> = modes.iter().map(|mode| mode.start).collect();
        let mut go = |steps: &[Transition], forces: [f64; 2]| {
            at.iter_mut().zip(steps).for_each(|(at, step)| *at = step.forced(*at, forces));
            value(&at, forces[1])
        };
        let mut series = Vec::new();
        let steps = transitions(h);
        let pressed = forces.windows(2).take((until / h).ceil() as usize);
        series.extend(pressed.map(|pair| go(&steps, [pair[0], pair[1]])));
        let left = until - h * forces.len().saturating_sub(1) as f64;
        let highest = self.modes.iter().map(Mode::frequency).fold(0.0, f64::max);
        if left > 0.0 {
            let n = (INSTANTS_OF_PERIOD * highest * left).clamp(1.0, MOST_INSTANTS).ceil();
            let steps = transitions(left / n);
            series.extend((0..n as usize).map(|_| go(&steps, [0.0; 2])));
        }
        series
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A mode of 1 rad/s that rings with the amplitude 1, and no force.
    fn ringing(earlier: f64) -> Response {
        let mode =
            Mode { stiffness: 1.0, damping: 0.0, share: 1.0, carried: 0.0, start: [1.0, 0.0], error: 0.0 };
        let none = || vec![0.0; 11];
        let output = Output {
            of: PeakOf::Displacement,
            index: 0,
            without: [0.0; 6],
            by_mode: vec![[2.0, 0.0, 0.0, 0.0, 0.0, 0.0]],
            by_force: [0.0; 6],
        };
        let (base, zone, mesh, half, quarter) = (none(), none(), none(), none(), none());
        Response {
            start: 3.0,
            duration: 1.0,
            histories: Histories { step: 0.1, base, stiffer: None, zone, mesh, half, quarter },
            modes: vec![mode],
            ends: vec![1],
            outputs: vec![output],
            of_ends: 0.0,
            earlier,
        }
    }

    #[test]
    fn what_rings_on_has_the_bands_of_the_impacts_before() {
        let at = |value: f64| PeakRecord {
            of: PeakOf::Displacement,
            index: 0,
            value,
            time: 3.0 + std::f64::consts::PI,
            band: PeakBand::none(NoBand::NoImpact),
        };
        let of = |earlier: f64, value: f64| ringing(earlier).band(&at(value), 20.0);
        // A twentieth of the amplitude of 2 (Eq. U.17), by the factor of Eq. U.12; instants lie a hundredth of a period apart at most.
        let [without, with] = [0.0, 0.05].map(|earlier| of(earlier, 2.0).expect("a band").band);
        assert!((with - without - 1.25 * 0.05 * 2.0).abs() < 1e-3, "{with} {without}");
        assert_eq!(of(f64::INFINITY, 2.0), Err(NoBand::Earlier));
        assert_eq!(of(0.0, 3.0), Err(NoBand::NotLinear));
        let other = PeakRecord { index: 1, ..at(2.0) };
        assert_eq!(ringing(0.0).band(&other, 20.0), Err(NoBand::Loop));
    }
}
