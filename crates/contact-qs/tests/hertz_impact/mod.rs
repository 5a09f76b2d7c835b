//! Closed forms of Hertz's theory that runs do not need: the impact of two spheres, stresses under the pressure (docs/theory.md section C.6; \[B\]
//! Eqs. 29-34; K. L. Johnson, Contact Mechanics, sections 3.4, 4.2 and 11.4).
//!
//! \[B\] writes the contact radius as `sqrt(r δ)` (its Eq. 32) with `r` the radius of one of its two equal spheres and `δ`
//! their approach to the plane of symmetry between them. In general it is `sqrt(R* δ)` with the equivalent radius of
//! Eq. 31 and the approach of the two bodies; both readings give the same number for that example. The stress on the
//! axis, \[B\] Eq. 34, is the exact one (Huber): it is the difference of Eqs. C.25, no approximation.

use contact_qs::law::hertz::HertzPair;
use std::f64::consts::FRAC_PI_2;

/// Impact of two spheres as mass points with Hertz's force between them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HertzImpact {
    /// Elastic pair.
    pub pair: HertzPair,
    /// Reduced mass `1/m* = 1/m1 + 1/m2` \[kg\].
    pub mass: f64,
    /// Closing speed at first touch [m/s].
    pub speed: f64,
}

impl HertzImpact {
    /// Impact of masses `masses` (infinite for a fixed partner) \[kg\] at closing speed `speed` [m/s].
    pub fn new(pair: HertzPair, masses: [f64; 2], speed: f64) -> Self {
        Self { pair, mass: 1.0 / (1.0 / masses[0] + 1.0 / masses[1]), speed }
    }

    /// Largest approach `δ_m = (5 m* v² / (4 k))^(2/5)` (Eq. C.22) \[m\].
    pub fn peak_approach(self) -> f64 {
        (1.25 * self.mass * self.speed * self.speed / self.pair.stiffness()).powf(0.4)
    }

    /// Largest force \[N\].
    pub fn peak_force(self) -> f64 {
        self.pair.force(self.peak_approach())
    }

    /// Duration `2.9433 δ_m / v` of the contact (Eq. C.23) \[s\].
    pub fn duration(self) -> f64 {
        2.0 * elapsed(FRAC_PI_2.powf(0.8)) * self.peak_approach() / self.speed
    }

    /// Approach at `time` after first touch, zero outside the contact \[m\].
    ///
    /// The motion is symmetric about the instant of largest approach; Newton's method inverts Eq. C.24 on the first half.
    pub fn approach_at(self, time: f64) -> f64 {
        let duration = self.duration();
        if !(time > 0.0 && time < duration) {
            return 0.0;
        }
        let peak = self.peak_approach();
        let target = time.min(duration - time) * self.speed / peak;
        let end = FRAC_PI_2.powf(0.8);
        let mut s = target.min(end);
        // The slope lies between 1 and (π/2)^(1/5) = 1.09, so that every iteration gains at least one digit.
        for _ in 0..20 {
            s = (s - (elapsed(s) - target) / slowness(s)).clamp(0.0, end);
        }
        peak * s.powf(1.25).sin().powf(0.8)
    }

    /// Force at `time` after first touch, zero outside the contact \[N\].
    pub fn force_at(self, time: f64) -> f64 {
        self.pair.force(self.approach_at(time))
    }
}

/// `(φ / sin φ)^(1/5)` at `φ = s^(5/4)`: the integrand of [`elapsed`].
fn slowness(s: f64) -> f64 {
    let angle = s.powf(1.25);
    if angle > 0.0 { (angle / angle.sin()).powf(0.2) } else { 1.0 }
}

/// Time `v t / δ_m = ∫ dx / sqrt(1 - x^(5/2))` until `x = sin^(4/5)(s^(5/4))` (Eq. C.24); the substitution removes both
/// end singularities.
fn elapsed(s: f64) -> f64 {
    // Simpson's rule on 64 panels: the integrand is 1 + s^2.5 / 30 + ..., the error below 1e-9.
    const PANELS: usize = 64;
    let h = s / PANELS as f64;
    let inner: f64 = (0..PANELS)
        .map(|i| {
            let left = h * i as f64;
            slowness(left) + 4.0 * slowness(left + 0.5 * h) + slowness(left + h)
        })
        .sum();
    inner * h / 6.0
}

/// Stresses `(σ_r = σ_θ, σ_z)` on the axis at depth `depth` under a Hertz pressure (Eqs. C.25; Johnson 3.45) \[Pa\].
///
/// `peak_pressure` \[Pa\] and `contact_radius` \[m\] of the pressure; `poisson`: of the body under it.
pub fn axis_stresses(peak_pressure: f64, contact_radius: f64, poisson: f64, depth: f64) -> (f64, f64) {
    let z = depth / contact_radius;
    let decay = 1.0 / (1.0 + z * z);
    // 1 - z arctan(1/z); the angle is written so that the surface, z = 0, is no special case.
    let cap = 1.0 - z * f64::atan2(1.0, z);
    (-peak_pressure * ((1.0 + poisson) * cap - 0.5 * decay), -peak_pressure * decay)
}

/// Von Mises stress `|σ_z - σ_r|` on the axis at depth `depth` (\[B\] Eq. 34) \[Pa\]. Arguments as in [`axis_stresses`].
pub fn axis_von_mises(peak_pressure: f64, contact_radius: f64, poisson: f64, depth: f64) -> f64 {
    let (radial, axial) = axis_stresses(peak_pressure, contact_radius, poisson, depth);
    (axial - radial).abs()
}

/// Depth and size of the largest von Mises stress on the axis `[m]`, `[Pa]`. Arguments as in [`axis_stresses`].
pub fn largest_axis_von_mises(peak_pressure: f64, contact_radius: f64, poisson: f64) -> (f64, f64) {
    // One maximum in (0, 2a) for every 0 <= ν <= 1/2 (Johnson Fig. 4.3): golden section.
    let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
    let stress = |z: f64| axis_von_mises(peak_pressure, contact_radius, poisson, z * contact_radius);
    let (mut low, mut high) = (0.0, 2.0);
    // 60 sections narrow the bracket to 2 * 0.618^60 = 6e-13 contact radii.
    for _ in 0..60 {
        let (left, right) = (high - golden * (high - low), low + golden * (high - low));
        if stress(left) < stress(right) { low = left } else { high = right }
    }
    let depth = 0.5 * (low + high);
    (depth * contact_radius, stress(depth))
}
