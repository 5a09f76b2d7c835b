//! Standard input data as plain numbers, for files: what comes out goes in again bit by bit.

use faer::Mat;
use nalgebra::{Matrix3, Vector3};

use super::assembled::RigidMotion;
use super::geometric_stiffening::GeometricStiffening;
use super::modal_mass::{FullModalMass, ModalMass};
use super::standard_input_data::{ModalDamping, StandardInputData};
use crate::data_error::{DataError, check_square};
use crate::error::DynamicsError;

/// Deviation from symmetry, as a share of the largest entry, that round-off explains.
const ASYMMETRY: f64 = 1e-9;

/// Everything that [`StandardInputData`] holds. Components are the model's: `n_c` is 2 for plane
/// and axisymmetric bodies, 3 for solid ones.
#[derive(Debug, Clone, PartialEq)]
pub struct DataParts {
    /// Rigid motions of the model.
    pub motion: RigidMotion,
    /// Mass \[kg\].
    pub mass: f64,
    /// First moment `∫ ρ X` \[kg m\].
    pub mass_moment: Vector3<f64>,
    /// Second moment `∫ ρ X Xᵀ` [kg m²].
    pub second_moment: Matrix3<f64>,
    /// `∫ ρ φ_j`, one per mode.
    pub coupling_translation: Vec<Vector3<f64>>,
    /// Modal mass (n_q × n_q); `None` for mass-orthonormal modes.
    pub modal_mass: Option<Mat<f64>>,
    /// Diagonal of the modal stiffness [rad²/s²].
    pub modal_stiffness: Vec<f64>,
    /// Damping.
    pub modal_damping: ModalDamping,
    /// `∫ ρ X_a φ_jb` at `(a n_c + b) n_q + j`; empty for axisymmetric bodies.
    pub position_shape: Vec<f64>,
    /// `∫ ρ φ_ia φ_jb` at `i n_c² n_q + (a n_c + b) n_q + j`; empty for axisymmetric bodies.
    pub shape_shape: Vec<f64>,
    /// Geometric stiffening.
    pub geometric_stiffening: Option<GeometricStiffening>,
}

impl StandardInputData {
    /// The numbers.
    pub fn to_parts(&self) -> DataParts {
        let n = self.n_modes();
        DataParts {
            motion: self.motion,
            mass: self.mass,
            mass_moment: self.mass_moment,
            second_moment: self.second_moment,
            coupling_translation: self.coupling_translation.clone(),
            modal_mass: match &self.modal_mass {
                ModalMass::Identity => None,
                full @ ModalMass::Full(_) => Some(full.to_matrix(n)),
            },
            modal_stiffness: self.modal_stiffness.clone(),
            modal_damping: self.modal_damping.clone(),
            position_shape: self.position_shape.clone(),
            shape_shape: self.shape_shape.clone(),
            geometric_stiffening: self.geometric_stiffening(),
        }
    }

    /// Data from numbers, all of which are checked.
    ///
    /// # Errors
    /// [`DynamicsError::Data`] if sizes do not fit, a number is not finite, the mass or a stiffness is not positive, no distribution of mass has the
    /// second moment, a matrix is not symmetric, or damping feeds energy in;
    /// [`DynamicsError::NotPositiveDefinite`] for the modal mass.
    pub fn from_parts(parts: DataParts) -> Result<Self, DynamicsError> {
        let n = parts.modal_stiffness.len();
        check_rigid(&parts)?;
        check_sizes(&parts, n)?;
        check_modes(&parts, n)?;
        let modal_mass = match &parts.modal_mass {
            None => ModalMass::Identity,
            Some(matrix) => ModalMass::Full(FullModalMass::new(matrix.as_ref())?),
        };
        let data = Self {
            motion: parts.motion,
            mass: parts.mass,
            mass_moment: parts.mass_moment,
            second_moment: parts.second_moment,
            coupling_translation: parts.coupling_translation,
            modal_mass,
            modal_stiffness: parts.modal_stiffness,
            modal_damping: parts.modal_damping,
            position_shape: parts.position_shape,
            shape_shape: parts.shape_shape,
            foreshortening: None,
        };
        match &parts.geometric_stiffening {
            Some(given) => data.with_geometric_stiffening(given),
            None => Ok(data),
        }
    }
}

fn positive(what: String, value: f64) -> Result<(), DataError> {
    if value > 0.0 && value.is_finite() {
        return Ok(());
    }
    Err(DataError::OutOfRange { what, value, range: "> 0 and finite" })
}

fn check_rigid(parts: &DataParts) -> Result<(), DataError> {
    positive("the mass [kg]".into(), parts.mass)?;
    let second = &parts.second_moment;
    let size = second.norm();
    if !parts.mass_moment.iter().chain(second.iter()).all(|v| v.is_finite()) {
        return Err(DataError::NotFinite { what: "first or second moment of the mass".into() });
    }
    if (second - second.transpose()).norm() > ASYMMETRY * size {
        return Err(DataError::NotSymmetric { what: "the second moment of the mass".into() });
    }
    let central = second - parts.mass_moment * parts.mass_moment.transpose() / parts.mass;
    // Rigid bodies that do not leave the plane, or do not turn, may have been given the inertia
    // that matters alone.
    let smallest = match parts.motion {
        RigidMotion::Axial => 0.0,
        RigidMotion::Planar => central.fixed_view::<2, 2>(0, 0).symmetric_eigenvalues().min(),
        RigidMotion::Spatial => central.symmetric_eigenvalues().min(),
    };
    if smallest < -ASYMMETRY * size {
        return Err(DataError::Inertia { moment: smallest });
    }
    Ok(())
}

fn check_sizes(parts: &DataParts, n: usize) -> Result<(), DataError> {
    let n_c = parts.motion.n_components();
    let row = if parts.motion == RigidMotion::Axial { 0 } else { n_c * n_c * n };
    let sizes = [
        ("coupling_translation", parts.coupling_translation.len(), n),
        ("position_shape", parts.position_shape.len(), row),
        ("shape_shape", parts.shape_shape.len(), n * row),
    ];
    if let Some((name, found, expected)) = sizes.into_iter().find(|(_, found, expected)| found != expected) {
        return Err(DataError::Count { what: format!("entries of {name} for {n} modes"), found, expected });
    }
    let all = parts.coupling_translation.iter().flat_map(|c| c.iter());
    if !all.chain(&parts.position_shape).chain(&parts.shape_shape).all(|v| v.is_finite()) {
        return Err(DataError::NotFinite { what: "an inertia integral of the modes".into() });
    }
    parts.modal_mass.as_ref().map_or(Ok(()), |m| check_square("the modal mass", m.as_ref(), n))
}

fn check_modes(parts: &DataParts, n: usize) -> Result<(), DataError> {
    for (j, k) in parts.modal_stiffness.iter().enumerate() {
        positive(format!("the stiffness of mode {}", j + 1), *k)?;
    }
    // φ_i φ_jᵀ and φ_j φ_iᵀ are transposed: otherwise gyroscopic forces would do work.
    let n_c = parts.motion.n_components();
    let at = |i: usize, a: usize, b: usize, j: usize| parts.shape_shape[((i * n_c + a) * n_c + b) * n + j];
    let scale = parts.shape_shape.iter().fold(0.0f64, |m, v| m.max(v.abs()));
    if scale > 0.0 {
        for (i, j) in (0..n).flat_map(|i| (0..=i).map(move |j| (i, j))) {
            for (a, b) in (0..n_c).flat_map(|a| (0..n_c).map(move |b| (a, b))) {
                if (at(i, a, b, j) - at(j, b, a, i)).abs() > ASYMMETRY * scale {
                    let what = format!("shape_shape of the modes {} and {}", i + 1, j + 1);
                    return Err(DataError::NotSymmetric { what });
                }
            }
        }
    }
    match &parts.modal_damping {
        ModalDamping::None => Ok(()),
        ModalDamping::PerMode(d) => {
            if d.len() != n {
                let what = "damping coefficients of modes".into();
                return Err(DataError::Count { what, found: d.len(), expected: n });
            }
            match d.iter().find(|d| !(**d >= 0.0 && d.is_finite())) {
                None => Ok(()),
                Some(&value) => {
                    let what = "the damping coefficient of a mode".into();
                    Err(DataError::OutOfRange { what, value, range: ">= 0 and finite" })
                }
            }
        }
        ModalDamping::Full(d) => check_damping(d, n),
    }
}

fn check_damping(d: &Mat<f64>, n: usize) -> Result<(), DataError> {
    check_square("the damping matrix", d.as_ref(), n)?;
    let size = d.norm_max();
    let symmetric = (0..n).all(|i| (0..i).all(|j| (d[(i, j)] - d[(j, i)]).abs() <= ASYMMETRY * size));
    if !symmetric {
        return Err(DataError::NotSymmetric { what: "the damping matrix".into() });
    }
    let values = nalgebra::DMatrix::from_fn(n, n, |i, j| d[(i, j)]).symmetric_eigenvalues();
    let smallest = values.iter().copied().fold(f64::INFINITY, f64::min);
    if smallest < -ASYMMETRY * size {
        return Err(DataError::NegativeDamping { eigenvalue: smallest });
    }
    Ok(())
}
