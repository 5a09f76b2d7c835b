//! The map from parameters to space at one point: position, Jacobian, gradients (theory Eq. E.7,
//! E.8).

use crate::SplineError;

/// Position and Jacobian matrix of the geometry at one parametric point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PointMap {
    /// Position \[m\].
    pub position: [f64; 3],
    /// `jacobian[i][d] = ∂x_i/∂ξ_d`; the identity in directions that the space does not have.
    pub jacobian: [[f64; 3]; 3],
    /// Determinant of the Jacobian matrix.
    pub determinant: f64,
}

impl PointMap {
    /// Sums up control points `nodes` with the basis at one point: values and one list of first
    /// derivatives per direction.
    pub fn new(dimension: usize, nodes: &[[f64; 3]], values: &[f64], first: [&[f64]; 3]) -> Self {
        let n = nodes.len();
        let (values, f0, f1, f2) = (&values[..n], &first[0][..n], &first[1][..n], &first[2][..n]);
        let (mut position, mut j) = ([0.0; 3], [[0.0; 3]; 3]);
        for a in 0..n {
            let p = &nodes[a];
            for i in 0..3 {
                position[i] += p[i] * values[a];
                j[i][0] += p[i] * f0[a];
                j[i][1] += p[i] * f1[a];
                j[i][2] += p[i] * f2[a];
            }
        }
        for (d, row) in j.iter_mut().enumerate().skip(dimension) {
            *row = [0.0; 3];
            row[d] = 1.0;
        }
        let cofactor = |a: usize, b: usize| j[1][a] * j[2][b] - j[1][b] * j[2][a];
        let determinant = j[0][0] * cofactor(1, 2) + j[0][1] * cofactor(2, 0) + j[0][2] * cofactor(0, 1);
        Self { position, jacobian: j, determinant }
    }

    /// The determinant, if it is positive.
    ///
    /// # Errors
    /// [`SplineError::Folded`] at `parameters` if it is zero, negative or not a number.
    pub fn volume_ratio(&self, parameters: [f64; 3]) -> Result<f64, SplineError> {
        let determinant = self.determinant;
        if determinant > 0.0 && determinant.is_finite() {
            Ok(determinant)
        } else {
            Err(SplineError::Folded { determinant, parameters })
        }
    }

    /// Inverse of the Jacobian matrix, `[d][i] = ∂ξ_d/∂x_i`; not finite where the determinant
    /// vanishes.
    pub fn inverse(&self) -> [[f64; 3]; 3] {
        let j = &self.jacobian;
        let scale = 1.0 / self.determinant;
        let mut inverse = [[0.0; 3]; 3];
        for (d, row) in inverse.iter_mut().enumerate() {
            for (i, slot) in row.iter_mut().enumerate() {
                // Cyclic indices give the cofactor of (i, d) with its sign.
                let (i1, i2, d1, d2) = ((i + 1) % 3, (i + 2) % 3, (d + 1) % 3, (d + 2) % 3);
                *slot = scale * (j[i1][d1] * j[i2][d2] - j[i1][d2] * j[i2][d1]);
            }
        }
        inverse
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inverse_times_jacobian_is_the_identity() {
        let nodes = [[0.1, 0.2, 0.3], [1.0, 0.1, -0.2], [0.3, 1.2, 0.1], [-0.1, 0.2, 0.9]];
        let first = [[-1.0, 1.0, 0.0, 0.0], [-1.0, 0.0, 1.0, 0.0], [-1.0, 0.0, 0.0, 1.0]];
        let map = PointMap::new(3, &nodes, &[0.25; 4], first.each_ref().map(|f| f.as_slice()));
        let inverse = map.inverse();
        for (d, row) in inverse.iter().enumerate() {
            for e in 0..3 {
                let sum: f64 = (0..3).map(|i| row[i] * map.jacobian[i][e]).sum();
                assert!((sum - f64::from(d == e)).abs() < 1e-14); // round-off
            }
        }
        assert!(map.volume_ratio([0.0; 3]).is_ok());
        assert!(PointMap { determinant: f64::NAN, ..map }.volume_ratio([0.0; 3]).is_err());
    }
}
