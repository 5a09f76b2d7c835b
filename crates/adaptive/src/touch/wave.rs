//! Error of the frequency of a wave on elements of a given length and degree (theory Eq. P.7).

use std::f64::consts::TAU;

/// Shifted waves on either side that count; of degree 1, where they fall off most slowly, 6 % are
/// left out.
const SHIFTS: i32 = 10;

/// Speed of longitudinal waves in a bar of the modulus `young` \[Pa\] and density `density`
/// [kg/m³], `c = sqrt(E/ρ)` [m/s].
pub fn wave_speed(young: f64, density: f64) -> f64 {
    (young / density).sqrt()
}

/// A wave that a body carries.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wave {
    /// Its length \[m\].
    pub length: f64,
    /// Stiffness against shear over that against bending, both at this length; none of a wave
    /// without bending.
    pub shear: f64,
}

impl Wave {
    /// A wave without bending.
    pub fn straight(length: f64) -> Self {
        Self { length, shear: 0.0 }
    }

    /// A wave of bending of a body of the given thickness \[m\]: 5/6 G A over E I k².
    pub fn bending(length: f64, thickness: f64, poissons_ratio: f64) -> Self {
        let shear = 5.0 / (1.0 + poissons_ratio) / (TAU / length * thickness).powi(2);
        Self { length, shear }
    }

    /// Relative error of its frequency on elements of the length `h` \[m\] and degree `p`.
    ///
    /// Smooth splines on a line carry, beside the wave number `k`, those shifted by multiples of
    /// `2π/h`. In bending slope and rotation of the section are splines of one degree that cannot
    /// agree: the difference is sheared.
    pub fn error(&self, h: f64, p: usize) -> f64 {
        // Shorter waves than two elements look like longer ones.
        let x = (h / self.length).min(0.5);
        let parts = |m: i32| [x / (f64::from(m) - x), x / (f64::from(m) + x)];
        let of_squares: f64 = (1..=SHIFTS).flat_map(parts).map(|r| r.powi(2 * p as i32)).sum();
        (1.0 + of_squares * (1.0 + self.shear)).sqrt() - 1.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frequencies_on_a_line_err_as_splines_do() {
        // The first terms for long waves are (2π/n)² / 24, (2π/n)⁴ / 1440, (2π/n)⁶ / 60480
        // (Cottrell, Reali, Bazilevs & Hughes 2006); with 40 elements per wave the next ones are
        // (2π/40)² = 2.5 % of them, and 6 % of the sum are left out.
        let wave = Wave::straight(40.0);
        for (degree, constant) in [(1, 24.0), (2, 1440.0), (3, 60480.0)] {
            let expected = (TAU / 40.0).powi(2 * degree as i32) / constant;
            let found = wave.error(1.0, degree);
            assert!((found / expected - 1.0).abs() < 0.1, "degree {degree}: {found:e}, {expected:e}");
        }
        assert!(Wave::straight(1.0).error(1.0, 3) >= 1e-2, "beyond all elements");
        let of_length = |h: f64| wave.error(h, 3);
        assert!(
            (1..40).all(|i| of_length(f64::from(i) * 0.5) < of_length(f64::from(i + 1) * 0.5)),
            "longer, worse"
        );
    }

    #[test]
    fn bending_waves_need_more_elements_the_thinner_the_body() {
        let error = |shear: f64| Wave { length: 4.0, shear }.error(1.0, 3);
        // In proportion to 1 + shear as long as the error is small, here 2e-3 at most.
        assert!((error(20.0) / error(0.0) / 21.0 - 1.0).abs() < 0.01);
        // Twice as thin: four times the shear.
        let shear = |thickness: f64| Wave::bending(1.0, thickness, 0.3).shear;
        assert!((shear(0.01) / shear(0.02) - 4.0).abs() < 1e-12);
    }
}
