//! What the waves that an impact sends into a body take of its energy (theory Eqs. N.10, N.11).

use std::f64::consts::TAU;

use iga_core::elasticity::Material;

/// Share of the energy of an impact that waves above the highest frequency kept may carry: half of
/// it is missing from the velocity of separation.
const NEGLECTED: f64 = 4e-3;
/// Power that a half-space takes up of a force at a point over the square of its rate, times
/// `rho c³`: what makes Hunter's loss of colliding balls.
const HALF_SPACE: f64 = 0.55;
/// Where the limit of `x = ω T` is looked for.
const SEARCH: (f64, f64) = (1e-3, 1e5);

/// How readily a place of a body moves under forces of high frequency: as a plate or bar with waves
/// longer than it is thick, as a half-space with shorter ones.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Radiation {
    /// [kg/m³].
    density: f64,
    /// Young's modulus \[Pa\].
    young: f64,
    /// \[m³\].
    volume: f64,
    /// The longest way through the body \[m\].
    longest: f64,
    /// Length of the line along which the force acts, the thickness of a plane body; none at a
    /// point \[m\].
    line: Option<f64>,
}

/// Real part of the mobility of a half-space.
#[derive(Debug, Clone, Copy, PartialEq)]
enum HalfSpace {
    /// Under a force at a point, over the square of the angular frequency [s³/kg].
    Point(f64),
    /// Along a line, over the angular frequency [s²/kg].
    Line(f64),
}

impl Radiation {
    /// The radiation into a body with a `volume` \[m³\] and a longest way through it \[m\], of a
    /// plane body with its thickness: a plate or bar as thick as the one over the other allows.
    /// Long bodies count as thinner than they are, which move more readily.
    pub fn new(material: &Material, volume: f64, longest: f64, plane: Option<f64>) -> Self {
        let (density, young) = (material.density(), material.youngs_modulus());
        Self { density, young, volume, longest, line: plane }
    }

    /// The same for a force along a line of so many metres over a solid body, whose waves are those
    /// of a plane body as thick.
    #[must_use]
    pub fn along(self, line: f64) -> Self {
        Self { line: Some(line), ..self }
    }

    /// Real part of the mobility of a plate or bar, of twice its value in the middle [s/kg].
    fn mobility(&self) -> f64 {
        let section = match self.line {
            Some(_) => self.volume / self.longest,
            None => (self.volume / (self.longest * self.longest)).powi(2),
        };
        1.0 / (section * self.density * self.speed())
    }

    fn half_space(&self) -> HalfSpace {
        match self.line {
            Some(width) => HalfSpace::Line(1.0 / (self.young * width)),
            None => HalfSpace::Point(HALF_SPACE / (self.density * self.speed().powi(3))),
        }
    }

    /// Speed of waves along a bar [m/s].
    fn speed(&self) -> f64 {
        (self.young / self.density).sqrt()
    }

    /// Share of the energy of an impact that waves above `x` over its `duration` \[s\] carry, if it
    /// stops `mass` \[kg\] in half of it. Under Hertz's law the force begins and ends as
    /// `sin^(3/2)` and its spectrum falls with `x^(-5/2)`, along a line as `sin` and with `x^(-2)`.
    fn share(&self, mass: f64, duration: f64, x: f64) -> f64 {
        let of_bar = self.mobility() * mass / duration;
        match self.half_space() {
            HalfSpace::Point(k) => 226.0 * of_bar / x.powi(4) + 450.0 * k * mass / (duration.powi(3) * x * x),
            HalfSpace::Line(k) => 41.0 * of_bar / x.powi(3) + 62.0 * k * mass / (duration * x).powi(2),
        }
    }

    /// Frequency \[Hz\] above which waves carry no more than the share `NEGLECTED` of the energy.
    pub fn frequency(&self, mass: f64, duration: f64) -> f64 {
        let (mut low, mut high) = SEARCH;
        // To a thousandth.
        for _ in 0..16 {
            let middle = (low * high).sqrt();
            if self.share(mass, duration, middle) > NEGLECTED { low = middle } else { high = middle }
        }
        high / (TAU * duration)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hertz_impact::HertzImpact;
    use contact_qs::law::hertz::{HertzPair, Solid};
    use std::f64::consts::PI;

    #[test]
    fn the_tails_are_those_of_the_pulse() {
        // F = sin^(3/2)(π t), whose spectrum is summed over its length; the impulse is 2 m v, the
        // energy m v² / 2.
        let n = 4000;
        let time = |i: i32| (f64::from(i) + 0.5) / f64::from(n);
        let force = |i: i32| (PI * time(i)).sin().powf(1.5);
        let impulse: f64 = (0..n).map(force).sum::<f64>() / f64::from(n);
        let power = |w: f64| {
            let sum = |part: fn(f64) -> f64| {
                (0..n).map(|i| force(i) * part(w * time(i))).sum::<f64>() / f64::from(n)
            };
            sum(f64::cos).powi(2) + sum(f64::sin).powi(2)
        };
        let (first, step) = (40.0, 0.5);
        let tail = |weight: fn(f64) -> f64| -> f64 {
            (0..1500)
                .map(|k| first + step * (f64::from(k) + 0.5))
                .map(|w| weight(w) * power(w) * step)
                .sum::<f64>()
                / PI
        };
        // Peak 2 m v / (impulse T): shares of m v² / 2 for mobilities of one.
        let scale = 8.0 / (impulse * impulse);
        let plate = scale * tail(|_| 1.0) * first.powi(4);
        let half_space = scale * tail(|w| w * w) * first.powi(2);
        // The sum over the squares ends at 790, where 1/400 is left.
        assert!((plate / 226.0 - 1.0).abs() < 0.05, "{plate}");
        assert!((half_space / 450.0 - 1.0).abs() < 0.05, "{half_space}");
        // Half a sine: |F|² = (2 π cos(x/2) / (π² - x²))², peak π m v / T.
        let power = |x: f64| (2.0 * PI * (0.5 * x).cos() / (PI * PI - x * x)).powi(2);
        let step = 0.05;
        let tail = |weight: fn(f64) -> f64| -> f64 {
            (0..200_000)
                .map(|k| first + step * (f64::from(k) + 0.5))
                .map(|w| weight(w) * power(w) * step)
                .sum::<f64>()
                / PI
        };
        let scale = 2.0 * PI * PI;
        let (bar, half_plane) = (scale * tail(|_| 1.0) * first.powi(3), scale * tail(|x| x) * first.powi(2));
        assert!((bar / 41.0 - 1.0).abs() < 0.1, "{bar}");
        assert!((half_plane / 62.0 - 1.0).abs() < 0.1, "{half_plane}");
    }

    #[test]
    fn balls_lose_to_waves_what_hunter_found() {
        let (steel, material) =
            (Solid { young: 210e9, poisson: 0.3 }, Material::new(210e9, 0.3, 7850.0).unwrap());
        let (radius, speed) = (0.01_f64, 0.1);
        let mass = 4.0 / 3.0 * PI * 7850.0 * radius.powi(3);
        let pair = HertzPair::new([steel, steel], [radius, f64::INFINITY]);
        let impact = HertzImpact::new(pair, [mass, f64::INFINITY], speed);
        // The rate of the force, (3/2)² π² / 2 · mean of sin cos² over the pulse, with the peak 3.6
        // m v / T.
        let HalfSpace::Point(k) = Radiation::new(&material, 1.0, 1.0, None).half_space() else {
            unreachable!()
        };
        let lost = 122.0 * k * mass / impact.duration().powi(3);
        let hunter = 1.04 * (speed / (210e9_f64 / 7850.0).sqrt()).powf(0.6);
        assert!((lost / hunter - 1.0).abs() < 0.05, "{lost} {hunter}");
    }
}
