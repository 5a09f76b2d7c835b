//! How hard a contact presses, beside what linear elasticity bears (docs/theory.md Eq. P.15).

use crate::record::ImpactRecord;
use crate::record::warning::{Warning, WarningKind};

/// Ratio of contact radius to radius of curvature above which a warning is given: the strain in the
/// contact is some 0.2 of it (Tabor), beyond the yield point of every metal.
pub const LARGE_CONTACT_STRAIN: f64 = 0.1;
/// The ratio at which a run ends: Hertz's parabola leaves a sphere by a third of the approach.
pub const HUGE_CONTACT_STRAIN: f64 = 0.5;

/// Contact radius over the radius of curvature of two bodies that press each other with the mean
/// pressure `pressure` \[Pa\], from Hertz's `p_m = (4/3π) E* a/R`; of flat faces a strain of the
/// same size.
pub fn contact_strain(pressure: f64, modulus: f64) -> f64 {
    0.75 * std::f64::consts::PI * pressure / modulus
}

/// The warning of contact `name`, which pressed with a mean pressure \[Pa\] and a strain above the
/// limit.
pub fn large_contact_strain(
    name: &str,
    impact: &ImpactRecord,
    (pressure, strain): (f64, f64),
) -> Option<Warning> {
    (strain > LARGE_CONTACT_STRAIN).then(|| Warning {
        kind: WarningKind::LargeContactStrain,
        subject: format!("contact \"{name}\""),
        time: impact.peak_time,
        value: strain,
        limit: LARGE_CONTACT_STRAIN,
        message: format!(
            "contact pressure {:.2} GPa on average at the peak: the contact is as wide as {strain:.2} of the radius of curvature, and strains there \
             are some {:.0} %; most materials have yielded long before, and linear elasticity gives too large a force",
            1e-9 * pressure,
            20.0 * strain
        ),
        remedy: "lower the velocity, or take force and restitution as upper bounds of those of a material that yields".into(),
    })
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::touch::hertz::contact_modulus;

    #[test]
    fn hertz_gives_the_radius_of_the_contact() {
        // a³ = 3 F R / 4 E* of a ball of 10 mm that presses a rigid plane with 1 kN; round-off.
        let (force, radius) = (1e3, 0.01);
        let modulus = contact_modulus(&[(210e9, 0.3), (f64::INFINITY, 0.0)]);
        assert!((modulus - 210e9 / 0.91).abs() < 1e-3);
        let a = (0.75_f64 * force * radius / modulus).cbrt();
        let strain = contact_strain(force / (PI * a * a), modulus);
        assert!((strain - a / radius).abs() < 1e-12);
        assert!(contact_strain(1e9, f64::INFINITY) <= 0.0);
    }

    #[test]
    fn what_is_told_names_the_pressure() {
        let impact = ImpactRecord { peak_time: 1e-5, ..ImpactRecord::default() };
        let told = large_contact_strain("c", &impact, (9e9, 0.18)).expect("a warning");
        assert!(told.message.contains("contact pressure 9.00 GPa"), "{}", told.message);
        assert_eq!(large_contact_strain("c", &impact, (4e9, 0.09)), None);
    }
}
