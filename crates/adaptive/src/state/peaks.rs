//! Largest reactions of joints, displacements and stresses of observed points, as a run goes on.

use serde::{Deserialize, Serialize};

use crate::record::band::NoBand;
use crate::record::{PeakBand, PeakOf, PeakRecord, Sample};

/// Largest values up to now.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Peaks {
    /// Where the points were at the start \[m\].
    pub origins: Vec<[f64; 3]>,
    /// The values, two for each joint and three for each point; empty before the first instant.
    pub records: Vec<PeakRecord>,
}

impl Peaks {
    /// Looks at the joints and points of `sample` at `time` \[s\].
    pub fn note(&mut self, time: f64, sample: &Sample) {
        if self.records.is_empty() {
            let band = PeakBand::none(NoBand::NoImpact);
            let of = |of: &[PeakOf], n: usize| -> Vec<PeakRecord> {
                let record = |index: u32, of: &PeakOf| PeakRecord { of: *of, index, value: 0.0, time, band };
                (0..n as u32).flat_map(|index| of.iter().map(move |of| record(index, of))).collect()
            };
            self.origins = sample.points.iter().map(|point| point.position).collect();
            self.records = of(&[PeakOf::ReactionForce, PeakOf::ReactionMoment], sample.joints.len());
            let of_points = [PeakOf::Displacement, PeakOf::Speed, PeakOf::VonMises];
            self.records.extend(of(&of_points, sample.points.len()));
        }
        for record in &mut self.records {
            let value = record.of.size(&record.components(sample, &self.origins));
            if value > record.value {
                (record.value, record.time) = (value, time);
                record.band = PeakBand::none(NoBand::NoImpact);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::{JointSample, PointSample};

    #[test]
    fn peaks_are_the_largest_of_all_instants_seen() {
        let at = |force: f64, x: f64| Sample {
            joints: vec![JointSample { reaction_force: [0.0, force, 0.0], ..JointSample::default() }],
            points: vec![PointSample { position: [x, 0.0, 0.0], ..PointSample::default() }],
            ..Sample::default()
        };
        let mut peaks = Peaks::default();
        for (time, force, x) in [(0.0, 1.0, 5.0), (1.0, -3.0, 4.0), (2.0, 2.0, 3.0), (3.0, 0.0, 6.0)] {
            peaks.note(time, &at(force, x));
        }
        let found: Vec<_> = peaks.records.iter().map(|r| (r.of, r.value, r.time)).collect();
        let none = |of: PeakOf| (of, 0.0, 0.0);
        assert_eq!(
            found,
            [
                (PeakOf::ReactionForce, 3.0, 1.0),
                none(PeakOf::ReactionMoment),
                (PeakOf::Displacement, 2.0, 2.0),
                none(PeakOf::Speed),
                none(PeakOf::VonMises)
            ]
        );
    }
}
