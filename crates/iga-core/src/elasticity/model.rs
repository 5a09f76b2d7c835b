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

    /// `λ` and `μ` such that the stresses that do work on the model's strains are `σ = λ tr ε + 2 μ ε` \[Pa\]: the material's
    /// own except for plane stress, where `λ` becomes `2 λ μ / (λ + 2 μ)` (theory Eq. E.4).
    pub fn lame(&self, material: &Material) -> (f64, f64) {
        let (lambda, mu) = (material.lame_lambda(), material.shear_modulus());
        match self {
            Self::PlaneStress { .. } => (2.0 * lambda * mu / (lambda + 2.0 * mu), mu),
            _ => (lambda, mu),
        }
    }

    /// Constitutive matrix `D` with `σ = D ε` for the model's own strains, as stored in `kinematics::StressState` \[Pa\].
    ///
    /// Rows and columns of strains that the model does not have are zero; shear strains are engineering strains.
    pub fn constitutive_matrix(&self, material: &Material) -> [[f64; 6]; 6] {
        let (lambda, mu) = self.lame(material);
        let (normal, shear): (&[usize], &[usize]) = match self {
            Self::PlaneStrain { .. } | Self::PlaneStress { .. } => (&[0, 1], &[3]),
            Self::Axisymmetric => (&[0, 1, 2], &[3]),
            Self::Solid => (&[0, 1, 2], &[3, 4, 5]),
        };
        let mut matrix = [[0.0; 6]; 6];
        for &i in normal {
            for &j in normal {
                matrix[i][j] = lambda;
            }
            matrix[i][i] = lambda + 2.0 * mu;
        }
        for &s in shear {
            matrix[s][s] = mu;
        }
        matrix
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn plane_stress_matrix_is_the_textbook_one() {
        let material = Material::new(210e9, 0.3, 7850.0).unwrap();
        let d = Model::PlaneStress { thickness: 1.0 }.constitutive_matrix(&material);
        let c = 210e9 / (1.0 - 0.09);
        // Round-off of a few operations.
        for (i, j, value) in [(0, 0, c), (0, 1, 0.3 * c), (1, 1, c), (3, 3, 0.35 * c), (2, 2, 0.0)] {
            assert!((d[i][j] - value).abs() < 1e-14 * c, "{i} {j}");
        }
    }

    #[test]
    fn impossible_thickness_is_refused() {
        for thickness in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(Model::PlaneStrain { thickness }.validate().is_err());
            assert!(Model::PlaneStress { thickness }.validate().is_err());
        }
        assert!(Model::Axisymmetric.validate().is_ok());
    }
}
