//! What is largest in a run.

use iga_core::elasticity::kinematics::von_mises;
use serde::{Deserialize, Serialize};

use super::Sample;
use super::band::{NoBand, Source};

/// The largest value of something recorded, at the end of an accepted time step or at a stored instant.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PeakRecord {
    /// What it is the largest value of.
    pub of: PeakOf,
    /// Number of the joint in [`super::RunLayout::joints`], or of the point in [`super::RunLayout::points`].
    pub index: u32,
    /// The value \[N, N m, m, m/s, Pa\].
    pub value: f64,
    /// When \[s\].
    pub time: f64,
    /// By how much it may be off.
    pub band: PeakBand,
}

impl PeakRecord {
    /// The components in `sample` of what it is the largest value of, three and zeros or those of a stress, points being at
    /// `origins` at the start.
    pub fn components(&self, sample: &Sample, origins: &[[f64; 3]]) -> [f64; 6] {
        let i = self.index as usize;
        let three = |[x, y, z]: [f64; 3]| [x, y, z, 0.0, 0.0, 0.0];
        match self.of {
            PeakOf::ReactionForce => three(sample.joints[i].reaction_force),
            PeakOf::ReactionMoment => three(sample.joints[i].reaction_moment),
            PeakOf::Displacement => {
                three(std::array::from_fn(|k| sample.points[i].position[k] - origins[i][k]))
            }
            PeakOf::Speed => three(sample.points[i].velocity),
            PeakOf::VonMises => sample.points[i].state.stress,
        }
    }
}

impl PeakOf {
    /// The length or von Mises stress of `components`.
    pub fn size(self, components: &[f64; 6]) -> f64 {
        match self {
            Self::VonMises => von_mises(components),
            _ => components.iter().map(|x| x * x).sum::<f64>().sqrt(),
        }
    }
}

/// By how much a largest value may be off because of what the run is resolved to.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub struct PeakBand {
    /// The band, in the unit of the value; NaN where there is none.
    pub band: f64,
    /// Its largest part.
    pub largest: Option<Source>,
    /// Why there is none.
    pub missing: Option<NoBand>,
}

impl PeakBand {
    /// No band.
    pub fn none(missing: NoBand) -> Self {
        Self { band: f64::NAN, largest: None, missing: Some(missing) }
    }

    /// The largest part, or why there is none.
    pub fn note(&self) -> &'static str {
        self.missing.map(NoBand::reason).or(self.largest.map(Source::name)).unwrap_or_default()
    }
}

impl PartialEq for PeakBand {
    /// Whether both are the same, those that are none among them.
    fn eq(&self, other: &Self) -> bool {
        self.band.to_bits() == other.band.to_bits()
            && (self.largest, self.missing) == (other.largest, other.missing)
    }
}

/// What a [`PeakRecord`] is the largest value of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum PeakOf {
    /// Length of the force that a joint transmits.
    ReactionForce,
    /// Length of its moment.
    ReactionMoment,
    /// Distance of a point from where it was at the start.
    Displacement,
    /// Speed of a point.
    Speed,
    /// Von Mises stress at a point; zero where stress is not recorded.
    VonMises,
}
