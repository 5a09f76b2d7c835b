//! Penalty factors of flat faces that meet as a whole (docs/theory.md Eqs. C.69, A.45).

use std::f64::consts::PI;

use crate::adaptivity::overlap::MOST_OVERLAP_OF_WAVES;
use crate::system::body::FlexibleModel;

/// Compliance of the modes of a bar that are left out, times impedance and highest frequency kept:
/// `Σ_{j>N} 2/(jπ)² → 2/(π²N)` (Eq. C.69).
const LEFT_OUT: f64 = 2.0 / PI;

/// The penalty factor with which, together with what the modes left out yield, the force rises
/// against waves in the `bodies` within half a period of the highest mode that all of them have
/// (Eq. C.69), and that with which as much of the approach is penetration as is allowed while waves say
/// how large the force is (Eq. A.45); infinite where there is none [N/m³].
pub fn flat_penalties<'a>(bodies: impl Iterator<Item = &'a FlexibleModel>) -> [f64; 2] {
    let (mut mobility, mut lowest, mut round_trip) = (0.0, f64::INFINITY, f64::INFINITY);
    for FlexibleModel { body, reduced, .. } in bodies {
        if let Some(material) = body.slowest_material() {
            mobility += 1.0 / (material.youngs_modulus() * material.density()).sqrt();
            round_trip = (2.0 * body.size() / material.bar_speed()).min(round_trip);
        }
        lowest = reduced.basis.omega.iter().copied().fold(0.0, f64::max).min(lowest);
    }
    let odds = MOST_OVERLAP_OF_WAVES / (1.0 - MOST_OVERLAP_OF_WAVES);
    let rates = [lowest / (PI - LEFT_OUT), 4.0 / (odds * round_trip)];
    rates.map(|rate| if rate > 0.0 { rate / mobility } else { f64::INFINITY })
}
