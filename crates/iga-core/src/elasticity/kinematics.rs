//! Strain from displacement gradients, stress from strain, for every model (theory Eq. E.1 to E.5).

use super::{Material, Model};

/// Strain and stress at one point.
///
/// Components: `xx, yy, zz, xy, yz, zx`; axisymmetric `rr, zz, θθ, rz, 0, 0`. In both cases entry 2
/// is the direction out of a two-dimensional model's plane and entry 3 the shear in its plane.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct PointState {
    /// Strains; shear strains are engineering strains, twice the tensor's components.
    pub strain: [f64; 6],
    /// Stresses \[Pa\].
    pub stress: [f64; 6],
}

impl PointState {
    /// Strain and stress from the displacement gradient `gradient[i][j] = ∂u_i/∂x_j` and the hoop
    /// strain `u_r / r` (used by the axisymmetric model alone).
    pub fn new(model: &Model, material: &Material, gradient: &[[f64; 3]; 3], hoop: f64) -> Self {
        let g = gradient;
        let mut strain = [g[0][0], g[1][1], 0.0, g[0][1] + g[1][0], 0.0, 0.0];
        let (lambda, mu) = (material.lame_lambda(), material.shear_modulus());
        match model {
            Model::PlaneStrain { .. } => {}
            // The strain that makes σ_zz vanish (Eq. E.4).
            Model::PlaneStress { .. } => strain[2] = -lambda / (lambda + 2.0 * mu) * (strain[0] + strain[1]),
            Model::Axisymmetric => strain[2] = hoop,
            Model::Solid => {
                strain[2] = g[2][2];
                strain[4] = g[1][2] + g[2][1];
                strain[5] = g[2][0] + g[0][2];
            }
        }
        let pressure = lambda * (strain[0] + strain[1] + strain[2]);
        let mut stress = strain.map(|e| mu * e);
        for i in 0..3 {
            stress[i] = pressure + 2.0 * mu * strain[i];
        }
        if matches!(model, Model::PlaneStress { .. }) {
            stress[2] = 0.0;
        }
        Self { strain, stress }
    }

    /// Adds `factor` times `other`.
    pub fn add_scaled(&mut self, other: &Self, factor: f64) {
        let add = |sum: &mut [f64; 6], part: &[f64; 6]| {
            sum.iter_mut().zip(part).for_each(|(s, p)| *s += factor * p)
        };
        add(&mut self.strain, &other.strain);
        add(&mut self.stress, &other.stress);
    }

    /// Von Mises equivalent stress (theory Eq. E.6) \[Pa\].
    pub fn von_mises(&self) -> f64 {
        von_mises(&self.stress)
    }
}

/// Von Mises equivalent stress of the components `xx, yy, zz, xy, yz, zx` (theory Eq. E.6) \[Pa\].
pub fn von_mises(stress: &[f64; 6]) -> f64 {
    let s = stress;
    let normal = (s[0] - s[1]).powi(2) + (s[1] - s[2]).powi(2) + (s[2] - s[0]).powi(2);
    let shear = s[3] * s[3] + s[4] * s[4] + s[5] * s[5];
    (0.5 * normal + 3.0 * shear).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn von_mises_is_the_tension_in_tension_and_root_three_times_shear() {
        assert!((von_mises(&[5.0, 0.0, 0.0, 0.0, 0.0, 0.0]) - 5.0).abs() < 1e-14);
        assert!((von_mises(&[0.0, 0.0, 0.0, 2.0, 0.0, 0.0]) - 2.0 * 3f64.sqrt()).abs() < 1e-14);
        assert!(von_mises(&[-7.0, -7.0, -7.0, 0.0, 0.0, 0.0]).abs() < 1e-14);
    }

    /// Constitutive matrix `D` with `σ = D ε` for the model's own strains [Pa]; rows and columns of
    /// strains that the model does not have are zero, shear strains are engineering strains.
    fn constitutive_matrix(model: &Model, material: &Material) -> [[f64; 6]; 6] {
        let (lambda, mu) = model.lame(material);
        let (normal, shear): (&[usize], &[usize]) = match model {
            Model::PlaneStrain { .. } | Model::PlaneStress { .. } => (&[0, 1], &[3]),
            Model::Axisymmetric => (&[0, 1, 2], &[3]),
            Model::Solid => (&[0, 1, 2], &[3, 4, 5]),
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

    #[test]
    fn plane_stress_matrix_is_the_textbook_one() {
        let material = Material::new(210e9, 0.3, 7850.0).unwrap();
        let d = constitutive_matrix(&Model::PlaneStress { thickness: 1.0 }, &material);
        let c = 210e9 / (1.0 - 0.09);
        // Round-off of a few operations.
        for (i, j, value) in [(0, 0, c), (0, 1, 0.3 * c), (1, 1, c), (3, 3, 0.35 * c), (2, 2, 0.0)] {
            assert!((d[i][j] - value).abs() < 1e-14 * c, "{i} {j}");
        }
    }

    #[test]
    fn stress_agrees_with_the_constitutive_matrix() {
        let material = Material::new(72.8e9, 0.33, 2789.0).unwrap();
        let gradient = [[1e-3, 2e-4, -3e-4], [5e-4, -7e-4, 1e-4], [2e-4, 6e-4, 4e-4]];
        let thickness = 0.01;
        for model in [
            Model::PlaneStrain { thickness },
            Model::PlaneStress { thickness },
            Model::Axisymmetric,
            Model::Solid,
        ] {
            let state = PointState::new(&model, &material, &gradient, 9e-4);
            let matrix = constitutive_matrix(&model, &material);
            for (i, row) in matrix.iter().enumerate() {
                if row[i] > 0.0 {
                    let sum: f64 = row.iter().zip(&state.strain).map(|(d, e)| d * e).sum();
                    assert!((sum - state.stress[i]).abs() < 1e-12 * 72.8e9 * 1e-3, "{model:?} {i}"); // round-off
                }
            }
        }
    }
}
