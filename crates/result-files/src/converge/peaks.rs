//! Largest values at the places that a scenario asks for: displacement of points, stress at points
//! and along lines.

use crate::error::ResultError;
use crate::file::fault::FileFault;
use crate::stored::Stored;
use crate::stored::peak;

/// What is largest.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PeakKind {
    /// Distance of a point from where it was at the start \[m\].
    Displacement,
    /// Von Mises stress at a place \[Pa\].
    Stress,
}

/// The largest value at a place in a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Peak {
    /// What it is of.
    pub kind: PeakKind,
    /// The place, `point "tip"` or `stress "root"`.
    pub place: String,
    /// The value \[m or Pa\].
    pub value: f64,
}

/// The largest values of the run in `stored`, in the order of names.
///
/// # Errors
/// [`ResultError::File`] if the result cannot be read.
pub fn peaks(stored: &Stored) -> Result<Vec<Peak>, ResultError> {
    let time = stored.values("time")?;
    let of_places =
        peak::peaks(stored.file(), &time).map_err(|e| ResultError::io(stored.path(), FileFault::part(e)))?;
    let points = of_places.into_iter().filter_map(|peak| {
        let kind = match peak.quantity.name {
            "peak_displacement" => PeakKind::Displacement,
            "peak_von_mises" => PeakKind::Stress,
            _ => return None,
        };
        Some(Peak { kind, place: format!("point \"{}\"", peak.place), value: peak.peak.value })
    });
    let mut found: Vec<Peak> = points.collect();
    for path in stored.entries.keys() {
        let line = path.strip_prefix("stress/").and_then(|rest| rest.strip_suffix("/von_mises"));
        if let Some(name) = line {
            let value = stored.values(path)?.into_iter().fold(0.0, f64::max);
            found.push(Peak { kind: PeakKind::Stress, place: format!("stress \"{name}\""), value });
        }
    }
    Ok(found)
}
