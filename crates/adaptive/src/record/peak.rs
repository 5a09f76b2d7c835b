//! What is largest in a run.

use serde::{Deserialize, Serialize};

/// The largest value of something recorded, at the end of an accepted time step or at a stored instant.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PeakRecord {
    /// What it is the largest value of.
    pub of: PeakOf,
    /// Number of the joint in [`super::RunLayout::joints`], or of the point in [`super::RunLayout::points`].
    pub index: u32,
    /// The value \[N, N m, m, Pa\].
    pub value: f64,
    /// When \[s\].
    pub time: f64,
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
    /// Von Mises stress at a point; zero where stress is not recorded.
    VonMises,
}
