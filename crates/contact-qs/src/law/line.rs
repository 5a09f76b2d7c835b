//! Hertz's contact of two plane models along a line (docs/theory.md Eqs. A.24, C.104; K. L. Johnson, Contact Mechanics, section 5.6).

use std::f64::consts::PI;

/// Curvature times size, or ratio of two curvatures, below which Hertz's theory of points or lines
/// has no answer: it divides by them.
pub const NO_CURVATURE: f64 = 1e-9;

/// Line contact of a plane model (theory Eq. A.24): approach over force with the logarithm of the
/// bodies' size.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LineLaw {
    curvature: f64,
    compliance: f64,
    size: f64,
    thickness: f64,
}

impl LineLaw {
    /// `curvature`: sum of the curvatures of both partners in the plane [1/m]; `compliance`: sum of
    /// `(1 - ν²)/E`, for a partner of another thickness multiplied by `thickness` over its own
    /// [1/Pa]; `size`: size of the bodies, on whose logarithm the approach depends \[m\];
    /// `thickness` \[m\]. `None` without curvature or compliance.
    pub fn new(curvature: f64, compliance: f64, size: f64, thickness: f64) -> Option<Self> {
        let is_possible = curvature > NO_CURVATURE / size && compliance > 0.0 && compliance.is_finite();
        is_possible.then_some(Self { curvature, compliance, size, thickness })
    }

    /// Half width under the force `force` \[m\].
    pub fn half_width(&self, force: f64) -> f64 {
        (4.0 * force / self.thickness * self.compliance / (PI * self.curvature)).sqrt()
    }

    /// Half width at the peak of an impact of two bodies that close at `speed`; `inverse_mass`: sum
    /// of their inverse effective masses [1/kg]. Zero where they do not close \[m\].
    pub fn half_width_of_impact(&self, inverse_mass: f64, speed: f64) -> f64 {
        let Self { curvature, compliance, size, thickness } = *self;
        line_impact(curvature, compliance, inverse_mass * thickness, speed, size)
            .map_or(0.0, |(half, _)| half)
    }

    /// Approach of the bodies under the force `force` \[m\].
    pub fn approach(&self, force: f64) -> f64 {
        let length = self.curvature * self.size * self.size;
        let g = force * self.compliance / (self.thickness * PI * length);
        length * g * if g > 0.0 { (-g.ln() - 1.0).max(1.0) } else { 1.0 }
    }

    /// Area of the contact under the force `force` \[m²\].
    pub fn area(&self, force: f64) -> f64 {
        2.0 * self.half_width(force) * self.thickness
    }

    /// `l` and `t F_0` (Eq. C.104) [m, N].
    fn units(&self) -> (f64, f64) {
        let length = self.curvature * self.size * self.size;
        (length, self.thickness * PI * length / self.compliance)
    }

    /// Force at `approach` \[N\], the energy stored by then \[J\] and the slope of the force [N/m]: `δ = l g max(ln(1/g) - 1, 1)`
    /// with `g = F/(t F_0)`, `l = κ ℓ²`, `F_0 = π E* l`, Eq. A.24 with `b` put in (Eq. C.104).
    pub fn at(&self, approach: f64) -> (f64, f64, f64) {
        let (length, unit) = self.units();
        let g = line_load(approach / length);
        let edge = (-2.0_f64).exp(); // from where on the logarithm is held
        let lower = g.min(edge);
        let logarithm = (1.0 / lower.max(f64::MIN_POSITIVE)).ln();
        let energy = lower * lower * (0.5 * logarithm - 0.75) + 0.5 * (g * g - lower * lower);
        let flexibility = if g <= 0.0 {
            f64::INFINITY
        } else if g < edge {
            logarithm - 2.0
        } else {
            1.0
        };
        (unit * g, unit * length * energy, unit / length / flexibility)
    }
}

/// Solves `g max(ln(1/g) - 1, 1) = x`, `x >= 0`: Newton's method from below, where the left side is
/// concave.
fn line_load(x: f64) -> f64 {
    let edge = (-2.0_f64).exp();
    if x >= edge || x <= 0.0 {
        return x.max(0.0);
    }
    // Below the solution, for ln(L + ln L) <= 1 + ln L where L = ln(1/x) >= 2.
    let logarithm = (1.0 / x).ln();
    let mut g = x / (logarithm + logarithm.ln());
    for _ in 0..50 {
        let logarithm = (1.0 / g).ln();
        let next = (g + (x - g * (logarithm - 1.0)) / (logarithm - 2.0)).clamp(g, edge);
        if next - g <= 4.0 * f64::EPSILON * g {
            break;
        }
        g = next;
    }
    g
}

/// Line contact of a plane model at the peak of an impact: half width and force a metre of
/// thickness (theory Eq. A.24).
///
/// `curvature`: sum of both partners' curvatures in the plane [1/m]; `compliance`: sum of
/// `(1 - ν²)/E` [1/Pa]; `inverse_mass`: of a slice of one metre [m/kg]; `size`: distance over which
/// the bodies yield, such as a diameter \[m\]. Returns half width \[m\] and force [N/m]; `None`
/// where there is no answer.
pub fn line_impact(
    curvature: f64,
    compliance: f64,
    inverse_mass: f64,
    speed: f64,
    size: f64,
) -> Option<(f64, f64)> {
    let is_possible =
        curvature > NO_CURVATURE / size && compliance > 0.0 && inverse_mass > 0.0 && speed > 0.0;
    let energy = 0.5 * speed * speed / inverse_mass;
    if !(is_possible && energy.is_finite() && compliance.is_finite()) {
        return None;
    }
    let half_width = |force: f64| (4.0 * force * compliance / (PI * curvature)).sqrt();
    // The approach grows with the logarithm of the body's size (Johnson Eq. 5.57): a few rounds
    // settle it.
    let mut force = (2.0 * energy / (compliance / PI)).sqrt();
    for _ in 0..30 {
        let logarithm = (2.0 * (2.0 * size / half_width(force)).ln() - 1.0).max(1.0);
        force = (2.0 * energy * PI / (compliance * logarithm)).sqrt();
    }
    Some((half_width(force), force))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `(1 - ν²)/E` of steel.
    const STEEL: f64 = 0.91 / 210e9;

    fn close(found: f64, expected: f64, limit: f64) {
        assert!((found / expected - 1.0).abs() < limit, "{found:e} against {expected:e}");
    }

    #[test]
    fn a_line_contact_stores_the_energy_of_the_impact() {
        let (compliance, inverse_mass, speed, size) = (STEEL, 1.0 / 246.0, 0.1, 0.2);
        let (half_width, force) = line_impact(10.0, compliance, inverse_mass, speed, size).unwrap();
        let approach = force * compliance / PI * (2.0 * (2.0 * size / half_width).ln() - 1.0);
        close(0.5 * force * approach, 0.5 * speed * speed / inverse_mass, 1e-9);
        assert!(line_impact(0.0, compliance, inverse_mass, speed, size).is_none());
    }

    #[test]
    fn the_law_of_a_line_contact_is_the_approach_of_its_force() {
        let (compliance, size, thickness) = (STEEL, 0.2, 0.03);
        let law = LineLaw::new(10.0, compliance, size, thickness).unwrap();
        for approach in [1e-12, 1e-9, 1e-6, 1e-4] {
            let (force, energy, stiffness) = law.at(approach);
            let load = force / thickness;
            let logarithm = (2.0 * (2.0 * size / law.half_width(force)).ln() - 1.0).max(1.0);
            close(load * compliance / PI * logarithm, approach, 1e-12);
            close(law.approach(force), approach, 1e-12);
            // The force is the slope of the energy; a central difference is of second order.
            let h = 1e-4 * approach;
            let slope = (law.at(approach + h).1 - law.at(approach - h).1) / (2.0 * h);
            close(slope, force, 1e-7);
            let slope = (law.at(approach + h).0 - law.at(approach - h).0) / (2.0 * h);
            close(stiffness, slope, 1e-7);
            // Less curved surfaces push less at the same approach, by F b²/8 a unit (Eq. C.106).
            let bent = |by: f64| {
                LineLaw::new(10.0 * (1.0 + by), compliance, size, thickness).unwrap().at(approach).1
            };
            let slope = (bent(1e-4) - bent(-1e-4)) / 2e-3;
            close(slope, -0.125 * force * law.half_width(force).powi(2), 1e-7);
            assert!(energy > 0.0);
        }
        assert_eq!(law.at(0.0), (0.0, 0.0, 0.0));
        assert!(LineLaw::new(0.0, compliance, size, thickness).is_none());
    }
}
