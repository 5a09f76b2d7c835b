//! Largest values at the places that a scenario asks for: displacement of points, stress at points
//! and along lines.

use crate::error::ResultError;
use crate::stored::Stored;
use crate::stored::peak::read_peak;

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
    let mut found = Vec::new();
    for path in stored.entries.keys() {
        let mut parts = path.splitn(3, '/');
        let (kind, at, name) = match (parts.next(), parts.next(), parts.next()) {
            (Some("points"), Some(name), Some("position")) => (PeakKind::Displacement, "point", name),
            (Some("points"), Some(name), Some("von_mises")) => (PeakKind::Stress, "point", name),
            (Some("stress"), Some(name), Some("von_mises")) => (PeakKind::Stress, "stress", name),
            _ => continue,
        };
        let of_steps = stored.file().dataset(path).ok().and_then(|dataset| read_peak(&dataset));
        let value = match (of_steps, kind) {
            (Some((value, _)), _) => value,
            (None, PeakKind::Displacement) => displacement(&stored.values(path)?),
            (None, PeakKind::Stress) => stored.values(path)?.into_iter().fold(0.0, f64::max),
        };
        found.push(Peak { kind, place: format!("{at} \"{name}\""), value });
    }
    Ok(found)
}

/// Largest distance of a row of three from the first one.
fn displacement(positions: &[f64]) -> f64 {
    let (rows, _) = positions.as_chunks::<3>();
    let Some(first) = rows.first() else { return 0.0 };
    let distance = |row: &[f64; 3]| super::motion::length(&std::array::from_fn(|k| row[k] - first[k]));
    rows.iter().map(distance).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    #[test]
    fn a_displacement_counts_from_the_first_instant_and_may_be_over_at_the_end() {
        let positions = [[1.0, 0.0, 0.0], [1.0, 3.0, 4.0], [1.0, 0.0, 0.0]];
        assert!((super::displacement(positions.as_flattened()) - 5.0).abs() < 1e-15);
        assert!(super::displacement(&[]).abs() <= 0.0);
    }
}
