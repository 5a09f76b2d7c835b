//! Models: what a displacement field of two or three components means in space.

use super::Material;
use crate::SplineError;

/// Kind of a linear elastic model.
///
/// Two-dimensional models have displacement components 0 and 1: `(x, y)` or `(r, z)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Model {
    /// No strain out of plane.
    PlaneStrain {
        /// Thickness of the body \[m\].
        thickness: f64,
    },
    /// No stress out of plane.
    PlaneStress {
        /// Thickness of the body \[m\].
        thickness: f64,
    },
    /// Torsionless rotational symmetry about the `z` axis in `(r, z)`; integrals carry `2 π r`.
    Axisymmetric,
    /// Three-dimensional solid.
    Solid,
}

impl Model {
    /// Checks the thickness.
    ///
    /// # Errors
    /// [`SplineError::Dimension`] unless it is positive and finite.
    pub fn validate(&self) -> Result<(), SplineError> {
        match self.thickness() {
            Some(value) if !(value.is_finite() && value > 0.0) => {
                let reason = "must be positive and finite";
                Err(SplineError::Dimension { name: "thickness", value, reason })
            }
            _ => Ok(()),
        }
    }

    /// Number of parametric directions and of displacement components: 2 or 3.
    pub fn dimension(&self) -> usize {
        if *self == Self::Solid { 3 } else { 2 }
    }

    /// Thickness of a plane model \[m\].
    pub fn thickness(&self) -> Option<f64> {
        match *self {
            Self::PlaneStrain { thickness } | Self::PlaneStress { thickness } => Some(thickness),
            Self::Axisymmetric | Self::Solid => None,
        }
    }

    /// Factor of an area or volume element at a point: thickness \[m\], `2 π r` \[m\] or 1.
    pub fn measure(&self, position: &[f64; 3]) -> f64 {
        match *self {
            Self::PlaneStrain { thickness } | Self::PlaneStress { thickness } => thickness,
            Self::Axisymmetric => std::f64::consts::TAU * position[0],
            Self::Solid => 1.0,
        }
    }

    /// `λ` and `μ` such that the stresses that do work on the model's strains are
    /// `σ = λ tr ε + 2 μ ε` \[Pa\]: the material's own except for plane stress, where `λ` becomes
    /// `2 λ μ / (λ + 2 μ)` (theory Eq. E.4).
    pub fn lame(&self, material: &Material) -> (f64, f64) {
        let (lambda, mu) = (material.lame_lambda(), material.shear_modulus());
        match self {
            Self::PlaneStress { .. } => (2.0 * lambda * mu / (lambda + 2.0 * mu), mu),
            _ => (lambda, mu),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn impossible_thickness_is_refused() {
        for thickness in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(Model::PlaneStrain { thickness }.validate().is_err());
            assert!(Model::PlaneStress { thickness }.validate().is_err());
        }
        assert!(Model::Axisymmetric.validate().is_ok());
    }
}
