//! Hertz's contact of two surfaces of any curvature: an ellipse (docs/theory.md Eqs. A.18, A.19,
//! C.86; K. L. Johnson, Contact Mechanics, sections 4.1 and 4.2).

use std::f64::consts::PI;

use super::Solid;

/// Ratio of relative curvatures below which the contact counts as one along a line.
const LINE: f64 = 1e-9;
/// Ratio of semi-axes above which the ellipse counts as a circle: the difference quotient of the
/// integrals loses digits.
const CIRCLE: f64 = 1e-6;

/// Hertz's contact of two surfaces whose gap is `½ (κ₁ x² + κ₂ y²)`: `major = scale F^(1/3)`,
/// `approach = depth F / major`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HertzEllipse {
    ratio: f64,
    scale: f64,
    depth: f64,
}

impl HertzEllipse {
    /// The law for relative curvatures `0 < small <= large` [1/m] and the sum `compliance` of both
    /// partners' `(1 - ν²)/E` [1/Pa]; `None` where there is none: rigid partners, surfaces that are
    /// flat or hollow against each other in one direction.
    pub fn new(small: f64, large: f64, compliance: f64) -> Option<Self> {
        let is_curved = small > LINE * large && large.is_finite() && large > 0.0;
        if !(is_curved && compliance > 0.0 && compliance.is_finite()) {
            return None;
        }
        let ratio = axis_ratio(small / large);
        let (first, second) = elliptic_integrals(1.0 - ratio * ratio);
        let shape = if is_circle(ratio) { 0.25 * PI } else { (first - second) / (1.0 - ratio * ratio) };
        let scale = (3.0 * shape * compliance / (PI * small)).cbrt();
        Some(Self { ratio, scale, depth: 1.5 * first * compliance / PI })
    }

    /// `k` of `F = k δ^(3/2)` [N/m^1.5].
    pub fn stiffness(&self) -> f64 {
        (self.scale / self.depth).powf(1.5)
    }

    /// Semi-axes of the contact under the force `force`, larger first \[m\].
    pub fn semi_axes(&self, force: f64) -> [f64; 2] {
        let major = self.scale * force.cbrt();
        [major, self.ratio * major]
    }

    /// Whether the contact is a circle.
    pub fn is_circle(&self) -> bool {
        is_circle(self.ratio)
    }

    /// Tangential stiffness over the normal one along the larger and the smaller axis, without
    /// slip, of partners of `solids` (Eq. C.86).
    pub fn tangential_ratios(&self, solids: &[Solid; 2]) -> [f64; 2] {
        let m = 1.0 - self.ratio * self.ratio;
        let (first, second) = elliptic_integrals(m);
        // Integrals of sin² and cos² of the direction over the ellipse, from its larger axis.
        let across = if self.is_circle() { 0.25 * PI } else { (second - (1.0 - m) * first) / m };
        let along = first - across;
        // Twice the compliance of shear, 1/G; zero for a rigid partner.
        let shear = solids.map(|s| 2.0 * (1.0 + s.poisson) / s.young);
        let sum = |of: &dyn Fn(&Solid) -> f64| -> f64 {
            solids.iter().zip(&shear).map(|(solid, shear)| shear * of(solid)).sum()
        };
        let normal = sum(&|s| (1.0 - s.poisson) * first);
        [across, along].map(|weight| normal / sum(&|s| first - s.poisson * weight))
    }
}

fn is_circle(ratio: f64) -> bool {
    ratio > 1.0 - CIRCLE
}

/// Ratio `b/a` of the semi-axes of the contact ellipse from the ratio of relative curvatures, both
/// in (0, 1] (Johnson Eq. 4.28: `B/A = ((a/b)² E - K)/(K - E)`).
fn axis_ratio(curvatures: f64) -> f64 {
    if curvatures > 1.0 - CIRCLE {
        return 1.0;
    }
    let inverse = |ratio: f64| {
        let (first, second) = elliptic_integrals(1.0 - ratio * ratio);
        (first - second) / (second / (ratio * ratio) - first)
    };
    let (mut low, mut high) = (1e-9_f64, 1.0 - CIRCLE);
    for _ in 0..100 {
        let middle = (low * high).sqrt();
        if inverse(middle) < curvatures {
            low = middle
        } else {
            high = middle
        }
        if high - low <= 2.0 * f64::EPSILON * high {
            break;
        }
    }
    high
}

/// Complete elliptic integrals `K(m)`, `E(m)` by the arithmetic-geometric mean, `0 <= m < 1`.
fn elliptic_integrals(m: f64) -> (f64, f64) {
    let (mut a, mut b, mut power, mut sum) = (1.0, (1.0 - m).sqrt(), 0.5, 0.5 * m);
    for _ in 0..40 {
        let c = 0.5 * (a - b);
        (a, b) = (0.5 * (a + b), (a * b).sqrt());
        power *= 2.0;
        sum += power * c * c;
        if c.abs() < f64::EPSILON * a {
            break;
        }
    }
    let first = 0.5 * PI / a;
    (first, first * (1.0 - sum))
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEEL: Solid = Solid { young: 210e9, poisson: 0.3 };

    fn close(found: f64, expected: f64, limit: f64) {
        assert!((found / expected - 1.0).abs() < limit, "{found} against {expected}");
    }

    #[test]
    fn elliptic_integrals_have_their_tabulated_values() {
        // Abramowitz & Stegun, tables 17.1: m = 0.5. Round-off.
        let (k, e) = elliptic_integrals(0.5);
        close(k, 1.854_074_677_301_372, 1e-14);
        close(e, 1.350_643_881_047_675_5, 1e-14);
        close(elliptic_integrals(0.0).0, 0.5 * PI, 1e-15);
    }

    #[test]
    fn the_gap_of_an_ellipse_closes_at_both_ends_alike() {
        // Pressure p0 sqrt(1 - x²/a² - y²/b²): Johnson's Eq. 4.28 must hold for both curvatures.
        let compliance = STEEL.compliance();
        for (small, large) in [(20.0, 100.0), (1.0, 1e4), (99.0, 100.0)] {
            let law = HertzEllipse::new(small, large, compliance).unwrap();
            let [a, b] = law.semi_axes(50.0);
            let (k, e) = elliptic_integrals(1.0 - (b / a).powi(2));
            let p0 = 1.5 * 50.0 / (PI * a * b);
            let common = 2.0 * compliance * p0 * b / (a * a - b * b); // the curvature is twice Johnson's A
            // Round-off, times a/(a - b) in the differences.
            close(common * (k - e), small, 1e-8);
            close(common * ((a / b).powi(2) * e - k), large, 1e-8);
        }
    }

    /// Displacement at the middle of an ellipse under `(1 - x²/a² - y²/b²)^(-1/2)` of unit
    /// resultant, normal and tangential, of a half space, by quadrature over directions (Johnson
    /// Eqs. 2.25, 3.6): `∫ R(φ) (1 - ν) dφ`, `∫ R(φ) (1 - ν sin²(φ - φ_t)) dφ`.
    fn by_quadrature([a, b]: [f64; 2], solid: Solid) -> [f64; 3] {
        let shear = 0.5 * solid.young / (1.0 + solid.poisson);
        let n = 4000;
        let mut sums = [0.0; 3];
        for i in 0..n {
            let (s, c) = (2.0 * PI * f64::from(i) / f64::from(n)).sin_cos();
            let radius = 1.0 / ((c / a).powi(2) + (s / b).powi(2)).sqrt();
            let weights = [1.0 - solid.poisson, 1.0 - solid.poisson * s * s, 1.0 - solid.poisson * c * c];
            sums.iter_mut().zip(weights).for_each(|(sum, w)| *sum += radius * w);
        }
        sums.map(|sum| sum * 2.0 * PI / f64::from(n) / (8.0 * PI * shear * a * b))
    }

    #[test]
    fn tangential_stiffness_is_that_of_the_half_space() {
        let rubber = Solid { young: 1e9, poisson: 0.48 };
        for (small, large) in [(3.0, 100.0), (50.0, 100.0), (100.0, 100.0)] {
            for pair in [[STEEL, rubber], [STEEL, Solid::RIGID]] {
                let compliance = pair[0].compliance() + pair[1].compliance();
                let law = HertzEllipse::new(small, large, compliance).unwrap();
                let axes = law.semi_axes(10.0);
                let mut sums = [0.0; 3];
                for solid in pair.into_iter().filter(|s| s.young.is_finite()) {
                    sums.iter_mut().zip(by_quadrature(axes, solid)).for_each(|(sum, u)| *sum += u);
                }
                let found = law.tangential_ratios(&pair);
                // Trapezoidal rule of a smooth periodic function: round-off.
                close(found[0], sums[0] / sums[1], 1e-9);
                close(found[1], sums[0] / sums[2], 1e-9);
            }
        }
        // Mindlin (1949): 8 G a/(2 - ν) over 4 G a/(1 - ν).
        let circle = HertzEllipse::new(10.0, 10.0, STEEL.compliance()).unwrap();
        close(circle.tangential_ratios(&[STEEL, Solid::RIGID])[0], 2.0 * 0.7 / 1.7, 1e-12);
    }
}
