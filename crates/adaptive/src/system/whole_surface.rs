//! The penalty factor of flat faces that meet as a whole (docs/theory.md Eq. C.69).

use std::f64::consts::PI;

use crate::system::body::FlexibleModel;

/// Compliance of the modes of a bar that are left out, times impedance and highest frequency kept:
/// `Σ_{j>N} 2/(jπ)² → 2/(π²N)` (Eq. C.69).
const LEFT_OUT: f64 = 2.0 / PI;

/// The penalty factor with which, together with what the modes left out yield, the force rises
/// against waves in the `bodies` within half a period of the highest mode that all of them have;
/// infinite where there is none (Eq. C.69) [N/m³].
pub fn resolved_penalty<'a>(bodies: impl Iterator<Item = &'a FlexibleModel>) -> f64 {
    let (mut mobility, mut lowest) = (0.0, f64::INFINITY);
    for body in bodies {
        mobility +=
            body.body.slowest_material().map_or(0.0, |m| 1.0 / (m.youngs_modulus() * m.density()).sqrt());
        lowest = body.reduced.basis.omega.iter().copied().fold(0.0, f64::max).min(lowest);
    }
    let penalty = lowest / ((PI - LEFT_OUT) * mobility);
    if penalty > 0.0 { penalty } else { f64::INFINITY }
}
