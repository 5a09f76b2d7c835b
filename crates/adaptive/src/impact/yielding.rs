//! What contacts and stresses a material bears before it yields (docs/theory.md Eq. P.19).

use std::f64::consts::PI;

use crate::record::ImpactRecord;
use crate::record::warning::{Warning, WarningKind};

/// How the pressure of a contact is spread.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Spread {
    /// Over an ellipse, as Hertz has it.
    Ellipse,
    /// Over a strip, as Hertz has it.
    Strip,
    /// Evenly, over flat faces.
    Even,
}

impl Spread {
    /// Peak over mean, peak over yield strength at which a material with Poisson's ratio 0.3 begins to yield
    /// below the surface by von Mises (Johnson, Contact Mechanics, section 6.1), and the power of the speed
    /// with which the pressure grows.
    fn factors(self) -> [f64; 3] {
        match self {
            Self::Ellipse => [1.5, 1.6, 0.4],
            Self::Strip => [4.0 / PI, 1.79, 0.5],
            Self::Even => [1.0, 1.0, 1.0],
        }
    }
}

/// The warning of contact `name`, which pressed with the `mean` pressure at the peak of `impact` on a
/// material of the yield `strength` \[Pa\], if that yields.
pub fn contact_yields(
    name: &str,
    impact: &ImpactRecord,
    spread: Spread,
    (mean, strength): (f64, f64),
) -> Option<Warning> {
    let [peak_factor, onset, power] = spread.factors();
    let (peak, limit) = (peak_factor * mean, onset * strength);
    let speed = impact.approach_velocity;
    let least = speed * (limit / peak).powf(power.recip());
    let from =
        if least > 0.0 { format!(", from an approach of some {least:.1e} m/s on") } else { String::new() };
    (peak > limit).then(|| Warning {
        kind: WarningKind::Yields,
        subject: format!("contact \"{name}\""),
        time: impact.peak_time,
        value: peak,
        limit,
        message: format!(
            "its pressure reaches {:.3} GPa, and the weaker material, of {:.0} MPa, yields under {:.3} GPa{from}: the run has it elastic, with \
             too large a force and restitution",
            1e-9 * peak,
            1e-6 * strength,
            1e-9 * limit
        ),
        remedy: "take force and restitution as upper bounds, lower the speed, or give materials.NAME.yield_strength of a harder material".into(),
    })
}

/// The warning of `subject`, whose largest von Mises stress `(stress, time)` is above the yield
/// `strength` \[Pa, s\].
pub fn stress_yields(subject: String, (stress, time): (f64, f64), strength: f64) -> Option<Warning> {
    (stress > strength).then(|| Warning {
        kind: WarningKind::Yields,
        subject,
        time,
        value: stress,
        limit: strength,
        message: format!(
            "von Mises stress reaches {:.3e} Pa, and the material yields at {strength:.3e} Pa: the run has it elastic",
            stress
        ),
        remedy: "lower the loads or the speed, or give materials.NAME.yield_strength of a harder material".into(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Largest of `stress` at depths below the centre, in half widths.
    fn largest(stress: impl Fn(f64) -> f64) -> f64 {
        (1..4000).map(|k| stress(1e-3 * f64::from(k))).fold(0.0, f64::max)
    }

    #[test]
    fn hertz_pressure_yields_below_the_surface() {
        let nu = 0.3;
        // Johnson, Eqs. 3.45 and 4.49: stress on the axis over the peak pressure. The constants are his,
        // with three digits.
        let circle = largest(|z| {
            let across = (1.0 + nu) * (1.0 - z * z.recip().atan()) - 0.5 / (1.0 + z * z);
            (1.0 / (1.0 + z * z) - across).abs()
        });
        let strip = largest(|z| {
            let root = (1.0 + z * z).sqrt();
            let (across, down) = ((1.0 + 2.0 * z * z) / root - 2.0 * z, root.recip());
            let along = nu * (across + down);
            let squares = [across - down, down - along, along - across].map(|d| d * d);
            (0.5 * squares.iter().sum::<f64>()).sqrt()
        });
        for (spread, stress) in [(Spread::Ellipse, circle), (Spread::Strip, strip)] {
            assert!((spread.factors()[1] * stress - 1.0).abs() < 0.01, "{spread:?} {stress}");
        }
    }

    #[test]
    fn the_speed_told_is_that_of_the_first_yield() {
        // A pressure twice as large as is borne, from 1 m/s: 2^(-5/2).
        let impact = ImpactRecord { approach_velocity: 1.0, ..ImpactRecord::default() };
        let told = contact_yields("c", &impact, Spread::Ellipse, (2.0 * 1.6 / 1.5, 1.0)).expect("a warning");
        assert!(told.message.contains("some 1.8e-1 m/s"), "{}", told.message);
        assert_eq!(contact_yields("c", &impact, Spread::Ellipse, (1.06, 1.0)), None);
        assert_eq!(stress_yields("s".into(), (1e9, 0.0), f64::INFINITY), None);
    }
}
