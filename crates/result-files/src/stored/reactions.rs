//! Largest reactions of joints in a result file: of all time steps, of stored instants in files of earlier
//! versions.

use hdf5::{Dataset, File, Result};
use serde_json::{Value, json};

use crate::file::hdf5_integrity;
use crate::stored::peak::read_peak;

/// Largest force and moment that a joint transmitted.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PeakReaction {
    /// Name of the joint.
    pub joint: String,
    /// Length of the largest force \[N\].
    pub force: f64,
    /// When \[s\].
    pub force_time: f64,
    /// Length of the largest moment \[N m\].
    pub moment: f64,
    /// When \[s\].
    pub moment_time: f64,
}

/// Peaks of all joints; none in files of earlier versions.
pub fn peaks(file: &File, time: &[f64]) -> Result<Vec<PeakReaction>> {
    let Ok(group) = file.group("joints") else { return Ok(Vec::new()) };
    let mut all = Vec::new();
    for joint in group.member_names()? {
        let [force, moment] = ["reaction_force", "reaction_moment"].map(|name| format!("{joint}/{name}"));
        // Ask before opening: HDF5 says on its own why a link is missing.
        let member = group.group(&joint)?;
        if !(member.link_exists("reaction_force") && member.link_exists("reaction_moment")) {
            continue;
        }
        let [(force, force_time), (moment, moment_time)] =
            [largest(&group.dataset(&force)?, time)?, largest(&group.dataset(&moment)?, time)?];
        all.push(PeakReaction { joint, force, force_time, moment, moment_time });
    }
    Ok(all)
}

/// Length of the longest of the vectors in `dataset`, three numbers each, and its instant.
fn largest(dataset: &Dataset, time: &[f64]) -> Result<(f64, f64)> {
    if let Some(peak) = read_peak(dataset) {
        return Ok(peak);
    }
    let rows = hdf5_integrity::rows::<f64>(dataset)?;
    let lengths = rows.as_chunks::<3>().0.iter().map(|v| v.iter().map(|x| x * x).sum::<f64>().sqrt());
    let first = time.first().copied().unwrap_or(0.0);
    let most = lengths.zip(time.iter().copied());
    Ok(most.fold((0.0, first), |most, now| if now.0 > most.0 { now } else { most }))
}

impl PeakReaction {
    /// As JSON, for programs.
    pub fn json(&self) -> Value {
        json!({ "peak_force": self.force, "peak_force_time": self.force_time,
            "peak_moment": self.moment, "peak_moment_time": self.moment_time })
    }
}
