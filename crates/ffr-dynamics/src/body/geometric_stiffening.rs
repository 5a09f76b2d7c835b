//! Geometric stiffening by axial inertia forces, of first order (docs/theory.md Eq. M.43 to M.45;
//! Wallrapp & Schwertassek 1991).
//!
//! Inertia forces stress a body, and stress makes it stiffer or softer against deformation. To
//! first order the stress is that of the undeformed body under reference loads, once and for all.

use faer::Mat;
use nalgebra::Vector3;

use super::assembled::RigidMotion;
use super::foreshortening::Foreshortening;
use super::standard_input_data::StandardInputData;
use crate::data_error::DataError;
use crate::error::DynamicsError;

/// Deviation from symmetry of a matrix against its largest entry: round-off of sums over many
/// control points.
const ASYMMETRY: f64 = 1e-9;

/// Geometric stiffness `∫ ∇φ_iᵀ σ ∇φ_j` in modal coordinates (n_q × n_q) for the stress `σ` of the
/// undeformed body under loads per volume in the directions of its frame.
///
/// The stress is that of the body supported as it is in the system, at the point that a tangent
/// frame follows, say; the modes are those of the frame in use. Plane models leave the cases with
/// the third direction empty (0 × 0).
#[derive(Debug, Clone, PartialEq)]
pub struct GeometricStiffening {
    /// `translation[b]`: load `ρ e_b`, for an acceleration of 1 m/s².
    pub translation: [Mat<f64>; 3],
    /// `position[a][b]`: load `ρ X_a e_b`, for 1/s². Wallrapp's centrifugal loads `ω × (ω × X)` and
    /// his angular ones are sums of these.
    pub position: [[Mat<f64>; 3]; 3],
}

impl StandardInputData {
    /// The same body with geometric stiffening.
    ///
    /// # Errors
    /// [`DynamicsError::Data`] if a matrix has not n_q rows and columns, is not symmetric or not finite, or the model
    /// is axisymmetric, which does not turn.
    pub fn with_geometric_stiffening(mut self, given: &GeometricStiffening) -> Result<Self, DynamicsError> {
        let (n_q, n_c) = (self.n_modes(), self.motion.n_components());
        if self.motion == RigidMotion::Axial {
            return Err(DataError::NotInModel { model: "axisymmetric", what: "geometric stiffening" }.into());
        }
        let size = n_c * n_c * n_q;
        let mut translation = vec![Vector3::zeros(); n_q * n_q];
        let mut position = vec![0.0; n_q * size];
        for b in 0..n_c {
            check(&given.translation[b], n_q, "translation", &[b])?;
            for (at, g) in translation.iter_mut().enumerate() {
                g[b] = -given.translation[b][(at / n_q, at % n_q)];
            }
            for a in 0..n_c {
                let matrix = &given.position[a][b];
                check(matrix, n_q, "position", &[a, b])?;
                for (i, j) in (0..n_q).flat_map(|i| (0..n_q).map(move |j| (i, j))) {
                    position[i * size + (a * n_c + b) * n_q + j] = -matrix[(i, j)];
                }
            }
        }
        self.foreshortening = Some(Foreshortening { translation, position });
        Ok(self)
    }

    /// The geometric stiffening that the body was given.
    pub fn geometric_stiffening(&self) -> Option<GeometricStiffening> {
        let Foreshortening { translation, position } = self.foreshortening.as_ref()?;
        let (n_q, n_c) = (self.n_modes(), self.motion.n_components());
        let size = n_c * n_c * n_q;
        let matrix = |is_there: bool, entry: &dyn Fn(usize, usize) -> f64| {
            let n = if is_there { n_q } else { 0 };
            Mat::from_fn(n, n, |i, j| -entry(i, j))
        };
        Some(GeometricStiffening {
            translation: std::array::from_fn(|b| matrix(b < n_c, &|i, j| translation[i * n_q + j][b])),
            position: std::array::from_fn(|a| {
                std::array::from_fn(|b| {
                    matrix(a.max(b) < n_c, &|i, j| position[i * size + (a * n_c + b) * n_q + j])
                })
            }),
        })
    }
}

fn check(matrix: &Mat<f64>, n_q: usize, kind: &str, case: &[usize]) -> Result<(), DynamicsError> {
    let limit = ASYMMETRY * matrix.norm_max();
    let is_sound = matrix.nrows() == n_q
        && matrix.ncols() == n_q
        && limit.is_finite()
        && (0..n_q).all(|i| (0..i).all(|j| (matrix[(i, j)] - matrix[(j, i)]).abs() <= limit));
    if is_sound {
        return Ok(());
    }
    let what = format!("the geometric stiffness of load case {kind} {case:?}");
    let found = (matrix.nrows(), matrix.ncols());
    Err(if found != (n_q, n_q) {
        DataError::Size { what, found, expected: (n_q, n_q) }
    } else if limit.is_finite() {
        DataError::NotSymmetric { what }
    } else {
        DataError::NotFinite { what }
    }
    .into())
}
