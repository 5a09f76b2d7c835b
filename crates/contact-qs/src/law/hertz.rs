//! Hertz's closed forms for the contact of two spheres (docs/theory.md section C.6; \[B\]
//! Eqs. 29-33; K. L. Johnson, Contact Mechanics, section 4.2). A rigid partner has an infinite
//! Young's modulus, a plane has an infinite radius.

use std::f64::consts::PI;

/// Elastic constants of one partner.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Solid {
    /// Young's modulus, infinite for a rigid partner \[Pa\].
    pub young: f64,
    /// Poisson's ratio.
    pub poisson: f64,
}

impl Solid {
    /// A rigid partner.
    pub const RIGID: Self = Self { young: f64::INFINITY, poisson: 0.0 };

    /// Compliance `(1 - ν²)/E` of plane strain, zero for a rigid partner [1/Pa].
    pub fn compliance(self) -> f64 {
        (1.0 - self.poisson * self.poisson) / self.young
    }

    /// The partner that yields in plane strain as this one does in plane stress, by `1/E`.
    #[must_use]
    pub fn of_plane_stress(self) -> Self {
        let Self { young, poisson } = self;
        let sum = 1.0 + poisson;
        Self { young: young * (sum + poisson) / (sum * sum), poisson: poisson / sum }
    }
}

/// Two spheres in contact, reduced to one modulus and one radius.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HertzPair {
    /// Equivalent modulus `1/E* = (1-ν1²)/E1 + (1-ν2²)/E2` (\[B\] Eq. 30) \[Pa\].
    pub modulus: f64,
    /// Equivalent radius `1/R* = 1/r1 + 1/r2` (\[B\] Eq. 31) \[m\].
    pub radius: f64,
}

impl HertzPair {
    /// Pair of two spheres with elastic constants `solids` and radii `radii` (infinite for a plane)
    /// \[m\].
    pub fn new(solids: [Solid; 2], radii: [f64; 2]) -> Self {
        Self {
            modulus: 1.0 / (solids[0].compliance() + solids[1].compliance()),
            radius: 1.0 / (1.0 / radii[0] + 1.0 / radii[1]),
        }
    }

    /// Coefficient `k = 4/3 E* sqrt(R*)` of `F = k δ^(3/2)` [N/m^1.5].
    pub fn stiffness(self) -> f64 {
        4.0 / 3.0 * self.modulus * self.radius.sqrt() // Eq. C.20
    }

    /// Force at approach `approach`, zero without contact (\[B\] Eq. 29) \[N\].
    pub fn force(self, approach: f64) -> f64 {
        if approach > 0.0 { self.stiffness() * approach * approach.sqrt() } else { 0.0 }
    }

    /// Elastic energy `2/5 k δ^(5/2)` at approach `approach` \[J\].
    pub fn energy(self, approach: f64) -> f64 {
        0.4 * approach * self.force(approach)
    }

    /// Approach under force `force` \[m\].
    pub fn approach(self, force: f64) -> f64 {
        (force / self.stiffness()).powf(2.0 / 3.0)
    }

    /// Radius `a = sqrt(R* δ)` of the contact circle at approach `approach` \[m\].
    pub fn contact_radius(self, approach: f64) -> f64 {
        (self.radius * approach.max(0.0)).sqrt() // Eq. C.21
    }

    /// Largest pressure `p0 = 3 F / (2 π a²)` at approach `approach` (\[B\] Eq. 33) \[Pa\].
    pub fn peak_pressure(self, approach: f64) -> f64 {
        2.0 / PI * self.modulus * (approach.max(0.0) / self.radius).sqrt() // the same, with F and a inserted
    }

    /// Pressure `p0 sqrt(1 - ρ²/a²)` at distance `distance` from the axis \[Pa\].
    pub fn pressure(self, approach: f64, distance: f64) -> f64 {
        let a = self.contact_radius(approach);
        if distance < a { self.peak_pressure(approach) * (1.0 - (distance / a).powi(2)).sqrt() } else { 0.0 }
    }
}
