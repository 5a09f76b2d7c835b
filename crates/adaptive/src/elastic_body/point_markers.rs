//! Markers at points of an elastic body (docs/theory.md Eq. M.34).

use ffr_dynamics::body::RigidMotion;
use ffr_dynamics::kinematics::MarkerWeights;
use iga_core::recovery::RecoveryWorkspace;
use nalgebra::{UnitQuaternion, Vector3};

use super::discretised::Discretised;
use crate::error::AdaptiveError;

/// Share of the largest weight below which an unknown does not count for a marker: round-off of basis functions that vanish there.
const ROUND_OFF: f64 = 1e-12;

/// The marker of `body` at `place` (model's components \[m\]) with the orientation `rotation` in the body's frame: it moves with the
/// material point and turns by half the curl of the displacement.
///
/// # Errors
/// [`AdaptiveError::Geometry`] if the point is not in the body, [`AdaptiveError::Reduction`] if its orientation is not finite.
pub fn weights_on(
    body: &Discretised<'_>,
    place: &[f64; 3],
    rotation: UnitQuaternion<f64>,
) -> Result<MarkerWeights, AdaptiveError> {
    let (e, xi) = body.locate(place)?;
    let functions = RecoveryWorkspace::default()
        .functions(body.space, e, &xi)
        .map_err(|source| AdaptiveError::Geometry { body: body.name.to_owned(), source })?;
    let motion = body.motion();
    let mut entries = Vec::new();
    for f in functions {
        let gradient = Vector3::from(f.gradient);
        for c in 0..motion.n_components() {
            let Some(unknown) = body.lookup.number(f.number, c) else { continue };
            let direction = Vector3::ith(motion.direction(c), 1.0);
            let mut w = [0.0; 6];
            if motion != RigidMotion::Axial {
                w[3..].copy_from_slice((0.5 * gradient.cross(&direction)).as_slice());
            } else if c == 0 {
                continue; // around the circumference radial displacements have no mean
            }
            w[..3].copy_from_slice((f.value * direction).as_slice());
            entries.push((unknown as u32, w));
        }
    }
    drop_round_off(&mut entries);
    entries.sort_by_key(|(unknown, _)| *unknown);
    MarkerWeights::new(motion.in_space(place), rotation, entries)
        .map_err(|source| AdaptiveError::Reduction { body: body.name.to_owned(), source })
}

/// Leaves out unknowns that move and turn the marker by round-off only.
fn drop_round_off(entries: &mut Vec<(u32, [f64; 6])>) {
    let largest = |part: std::ops::Range<usize>| {
        entries.iter().flat_map(|(_, w)| &w[part.clone()]).fold(0.0f64, |m, v| m.max(v.abs()))
    };
    let limits = [largest(0..3), largest(3..6)].map(|m| ROUND_OFF * m);
    entries.retain(|(_, w)| w.iter().enumerate().any(|(i, v)| v.abs() > limits[i / 3]));
}
