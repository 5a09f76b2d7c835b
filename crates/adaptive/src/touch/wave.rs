//! Error of the frequency of a wave on elements of a given length and degree (theory Eq. P.7).

use std::f64::consts::TAU;

use iga_core::elasticity::Material;

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

    /// The shortest one of `frequency` \[Hz\] in a body of `material`, `thickness` thick \[m\]: of shear
    /// or, where that is longer than twice the body is thick, of bending, longitudinal in an
    /// axisymmetric one.
    pub fn shortest(material: &Material, thickness: f64, is_axisymmetric: bool, frequency: f64) -> Self {
        let (young, poisson, density) =
            (material.youngs_modulus(), material.poissons_ratio(), material.density());
        let shear = (young / (2.0 * (1.0 + poisson) * density)).sqrt() / frequency;
        let bar = (young / density).sqrt();
        if shear <= 2.0 * thickness {
            return Self::straight(shear);
        }
        if is_axisymmetric {
            return Self::straight(bar / frequency);
        }
        // c_b = sqrt(ω r c_0) with the radius of gyration r = d / sqrt(12) of a rectangle.
        let length = (TAU * frequency * thickness / 12.0_f64.sqrt() * bar).sqrt() / frequency;
        Self::bending(length, thickness, poisson)
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
        self.error_of(of_squares)
    }

    /// The same on finite elements, whose functions go on from one to the next without a common slope:
    /// `½ (p!/(2p)!)² (kh)^2p / (2p + 1)` for long waves (Ainsworth 2004).
    pub fn error_on_finite_elements(&self, h: f64, p: usize) -> f64 {
        // Shorter waves than two nodes look like longer ones.
        let x = (h / self.length).min(0.5 * p as f64);
        let factorials: f64 = (p + 1..=2 * p).map(|k| k as f64).product();
        self.error_of((TAU * x).powi(2 * p as i32) / (factorials.powi(2) * (2 * p + 1) as f64))
    }

    /// Error of the frequency with the power `of_squares` of what a wave brings with it.
    fn error_of(&self, of_squares: f64) -> f64 {
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
    fn frequencies_on_finite_elements_err_as_those_of_a_line_of_them() {
        // One linear or quadratic element a period h of a wave of kh: the quotient of stiffness and mass
        // on the functions that go on by exp(i kh), the middle node of the quadratic one eliminated.
        let linear = |x: f64| (6.0 * (1.0 - x.cos()) / (2.0 + x.cos())).sqrt() / x - 1.0;
        let quadratic = |x: f64| {
            // K = [7 1 -8; 1 7 -8; -8 -8 16] / 3, M = [4 -1 2; -1 4 2; 2 2 16] / 30: corners c, middle m.
            let (c, s) = (x.cos(), 2.0 * (0.5 * x).cos());
            let det = |w: f64| {
                let corner = (14.0 + 2.0 * c) / 3.0 - w * (8.0 - 2.0 * c) / 30.0;
                let mixed = -8.0 * s / 3.0 - w * 2.0 * s / 30.0;
                corner * (16.0 / 3.0 - w * 16.0 / 30.0) - mixed * mixed
            };
            // The lower root in w = (ω h / c)², between the exact one and an error of a half.
            let [mut a, mut b] = [0.99 * x * x, 1.5 * x * x];
            for _ in 0..60 {
                let middle = 0.5 * (a + b);
                if det(middle) * det(a) > 0.0 { a = middle } else { b = middle }
            }
            a.sqrt() / x - 1.0
        };
        // The next terms of the series are 0.8 and 1.3 % of the first here.
        for (degree, exact) in [(1, &linear as &dyn Fn(f64) -> f64), (2, &quadratic)] {
            let found = Wave::straight(TAU / 0.5).error_on_finite_elements(1.0, degree);
            assert!((found / exact(0.5) - 1.0).abs() < 0.03, "degree {degree}: {found:e}, {:e}", exact(0.5));
            let of_length = |h: f64| Wave::straight(4.0).error_on_finite_elements(h, degree);
            assert!((1..40).all(|i| of_length(f64::from(i) * 0.3) <= of_length(f64::from(i + 1) * 0.3)));
        }
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
