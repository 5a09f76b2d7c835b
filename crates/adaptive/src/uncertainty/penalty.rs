//! Penetration of the springs between the surfaces (docs/theory/uncertainty.md Eq. U.4).

use super::law::{Law, Power};
use crate::touch::parts::TouchKind;

/// The law with springs twice as stiff, half of whose penetration in `samples`, pairs of force and
/// penetration, is gone: half of what is missing to rigid ones. Without any, flat faces ring. None without
/// springs.
pub fn stiffer(law: Law, touch: TouchKind, samples: &[(f64, f64)]) -> Option<Law> {
    let shown = Power::fit(samples)?;
    Some(Law { less: Some(Power { factor: 0.5 * of_largest(touch) * shown.factor, ..shown }), ..law })
}

/// Share of the largest penetration that is in the approach: the mean of the penetration by the pressure,
/// which is in proportion to it.
fn of_largest(touch: TouchKind) -> f64 {
    match touch {
        // Ellipsoid and half cylinder of pressures, as Hertz's theory has them.
        TouchKind::Smooth => 3.0 / 4.0,
        TouchKind::Line | TouchKind::LineOfPoints => 8.0 / (3.0 * std::f64::consts::PI),
        TouchKind::Flat | TouchKind::Narrow | TouchKind::Edge | TouchKind::BetweenPoints => 1.0,
    }
}

/// What rigid springs change in a number, of which springs twice as stiff change `half`.
pub fn to_rigid(half: f64) -> f64 {
    2.0 * half
}
