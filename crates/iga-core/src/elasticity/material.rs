//! Isotropic materials (theory Eq. E.3).

use crate::SplineError;

/// An isotropic, linear elastic, homogeneous material.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Material {
    youngs_modulus: f64,
    poissons_ratio: f64,
    density: f64,
    yield_strength: f64,
}

impl Material {
    /// Checks and takes Young's modulus `E > 0` \[Pa\], Poisson's ratio `-1 < ν < 0.5` and density
    /// `ρ > 0` [kg/m³].
    ///
    /// # Errors
    /// [`SplineError::Material`] naming the first constant that is impossible.
    pub fn new(youngs_modulus: f64, poissons_ratio: f64, density: f64) -> Result<Self, SplineError> {
        let fail = |name, value, reason| Err(SplineError::Material { name, value, reason });
        let is_positive = |x: f64| x.is_finite() && x > 0.0;
        if !is_positive(youngs_modulus) {
            return fail("youngs_modulus", youngs_modulus, "must be positive and finite");
        }
        if !(poissons_ratio > -1.0 && poissons_ratio < 0.5) {
            return fail("poissons_ratio", poissons_ratio, "must lie between -1 and 0.5, both excluded");
        }
        if !is_positive(density) {
            return fail("density", density, "must be positive and finite");
        }
        Ok(Self { youngs_modulus, poissons_ratio, density, yield_strength: f64::INFINITY })
    }

    /// The same material, which yields under a tension of `yield_strength`, its proof stress \[Pa\].
    ///
    /// # Errors
    /// [`SplineError::Material`] if it is not positive.
    pub fn with_yield_strength(self, yield_strength: f64) -> Result<Self, SplineError> {
        if yield_strength > 0.0 {
            return Ok(Self { yield_strength, ..self });
        }
        let reason = "must be positive";
        Err(SplineError::Material { name: "yield_strength", value: yield_strength, reason })
    }

    /// Stress in tension at which it yields, infinite if none is known \[Pa\].
    pub fn yield_strength(&self) -> f64 {
        self.yield_strength
    }

    /// Young's modulus `E` \[Pa\].
    pub fn youngs_modulus(&self) -> f64 {
        self.youngs_modulus
    }

    /// Poisson's ratio `ν`.
    pub fn poissons_ratio(&self) -> f64 {
        self.poissons_ratio
    }

    /// Density `ρ` [kg/m³].
    pub fn density(&self) -> f64 {
        self.density
    }

    /// Speed of longitudinal waves in a bar, `c = sqrt(E/ρ)` [m/s].
    pub fn bar_speed(&self) -> f64 {
        (self.youngs_modulus / self.density).sqrt()
    }

    /// First Lamé constant `λ = E ν / ((1 + ν)(1 - 2 ν))` \[Pa\].
    pub fn lame_lambda(&self) -> f64 {
        let nu = self.poissons_ratio;
        self.youngs_modulus * nu / ((1.0 + nu) * (1.0 - 2.0 * nu))
    }

    /// Shear modulus `μ = E / (2 (1 + ν))` \[Pa\].
    pub fn shear_modulus(&self) -> f64 {
        self.youngs_modulus / (2.0 * (1.0 + self.poissons_ratio))
    }
}

/// Materials of the elements of a body; a single one is that of all.
pub trait MaterialField: Send + Sync {
    /// The material of element `e`.
    fn on(&self, e: usize) -> &Material;
}

impl MaterialField for Material {
    fn on(&self, _e: usize) -> &Material {
        self
    }
}

/// Several materials, each in some of the elements.
#[derive(Debug, Clone, PartialEq)]
pub struct ElementMaterials {
    materials: Vec<Material>,
    of_element: Vec<u16>,
}

impl ElementMaterials {
    /// `of_element`: for every element the index of its material in `materials`.
    pub fn new(materials: Vec<Material>, of_element: Vec<u16>) -> Self {
        Self { materials, of_element }
    }

    /// The materials of elements that are parts of `parents`.
    #[must_use]
    pub fn of_parts(&self, parents: &[u32]) -> Self {
        let of_element = parents.iter().map(|&e| self.of_element[e as usize]).collect();
        Self { materials: self.materials.clone(), of_element }
    }
}

impl MaterialField for ElementMaterials {
    fn on(&self, e: usize) -> &Material {
        &self.materials[usize::from(self.of_element[e])]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lame_constants_reproduce_a_bar_in_tension() {
        let m = Material::new(210e9, 0.3, 7850.0).unwrap();
        let (l, g) = (m.lame_lambda(), m.shear_modulus());
        // Uniaxial stress: ε = (1, -ν, -ν) / E per unit stress.
        let strain = [1.0 / 210e9, -0.3 / 210e9, -0.3 / 210e9];
        let trace: f64 = strain.iter().sum();
        assert!((l * trace + 2.0 * g * strain[0] - 1.0).abs() < 1e-14); // round-off
        assert!((l * trace + 2.0 * g * strain[1]).abs() < 1e-14);
    }

    #[test]
    fn impossible_constants_are_refused_by_name() {
        for (e, nu, rho, word) in [
            (0.0, 0.3, 1.0, "youngs_modulus"),
            (f64::NAN, 0.3, 1.0, "youngs_modulus"),
            (1.0, 0.5, 1.0, "poissons_ratio"),
            (1.0, -1.0, 1.0, "poissons_ratio"),
            (1.0, f64::NAN, 1.0, "poissons_ratio"),
            (1.0, 0.3, f64::INFINITY, "density"),
        ] {
            let text = Material::new(e, nu, rho).unwrap_err().to_string();
            assert!(text.contains(word), "{text}");
        }
    }
}
