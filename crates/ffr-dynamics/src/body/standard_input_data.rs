//! Standard input data of a flexible body (docs/theory.md Eq. D.4 to D.8).
//!
//! All that the equations of motion need from a body: mass, moments, couplings, modal matrices, and
//! how they depend on the elastic coordinates. The letters in brackets are those of Wallrapp
//! (1994). The dependence is kept whole, not only to first order: kinetic energy equals that of the
//! unreduced model for any amplitude.

use faer::{Mat, MatRef};
use nalgebra::{Matrix3, Vector3};

use super::assembled::{AssembledBody, RigidMotion};
use super::foreshortening::Foreshortening;
use super::modal_mass::ModalMass;
use super::shape_integrals::ShapeIntegrals;
use crate::data_error::DataError;
use crate::error::DynamicsError;
use crate::rotation::axial;

/// Deviation of the modal mass matrix from the identity above which modes do not count as
/// mass-orthonormal.
///
/// Eigensolvers reach 1e-10; the deviation is the relative error of the modal kinetic energy.
const ORTHONORMALITY: f64 = 1e-7;

/// Damping of the elastic coordinates `D_e`.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum ModalDamping {
    /// No damping.
    #[default]
    None,
    /// One coefficient for each mode, `2 ζ_j ω_j`, not negative [1/s].
    PerMode(Vec<f64>),
    /// Symmetric matrix, positive semidefinite [1/s].
    Full(Mat<f64>),
}

impl ModalDamping {
    /// Adds `-D_e rates` to `forces`; returns the dissipated power \[W\].
    pub fn apply(&self, rates: &[f64], forces: &mut [f64]) -> f64 {
        let mut power = 0.0;
        match self {
            Self::None => {}
            Self::PerMode(coefficients) => {
                for ((f, rate), d) in forces.iter_mut().zip(rates).zip(coefficients) {
                    *f -= d * rate;
                    power += d * rate * rate;
                }
            }
            Self::Full(matrix) => {
                // The matrix is symmetric; its columns lie together in memory.
                for ((f, rate), column) in forces.iter_mut().zip(rates).zip(matrix.col_iter()) {
                    let force: f64 = column.iter().zip(rates).map(|(d, r)| d * r).sum();
                    *f -= force;
                    power += force * rate;
                }
            }
        }
        power
    }

    /// Subtracts column `j` of `D_e` from `forces`.
    pub fn subtract_column(&self, j: usize, forces: &mut [f64]) {
        match self {
            Self::None => {}
            Self::PerMode(coefficients) => forces[j] -= coefficients[j],
            Self::Full(matrix) => forces.iter_mut().enumerate().for_each(|(i, f)| *f -= matrix[(i, j)]),
        }
    }
}

/// A body as the equations of motion see it. Vectors and matrices are expressed in the body's
/// reference frame.
#[derive(Debug, Clone, PartialEq)]
pub struct StandardInputData {
    /// Rigid motions of the model.
    pub motion: RigidMotion,
    /// Mass `m` \[kg\].
    pub mass: f64,
    /// First moment `m c_0 = ∫ ρ X` \[kg m\].
    pub mass_moment: Vector3<f64>,
    /// Second moment `∫ ρ X Xᵀ` [kg m²]; the inertia is its trace times the identity, minus itself.
    pub second_moment: Matrix3<f64>,
    /// Rows of `C_t = ∫ ρ Φᵀ`, the first-order change of `m c` as well.
    pub coupling_translation: Vec<Vector3<f64>>,
    /// Modal mass `M_e`: the identity for mass-orthonormal modes, another matrix in a tangent
    /// frame.
    pub modal_mass: ModalMass,
    /// Diagonal of `K_e`; for mass-orthonormal modes the squared eigenfrequencies [rad²/s²].
    pub modal_stiffness: Vec<f64>,
    /// Damping `D_e`.
    pub modal_damping: ModalDamping,
    /// `∫ ρ X_a φ_jb`, see [`ShapeIntegrals::position_shape`].
    pub(crate) position_shape: Vec<f64>,
    /// `∫ ρ φ_ia φ_jb`, see [`ShapeIntegrals::shape_shape`].
    pub(crate) shape_shape: Vec<f64>,
    /// Second-order displacements that stand for geometric stiffening.
    pub(crate) foreshortening: Option<Foreshortening>,
}

/// Moments of the deformed body at one instant (Eq. D.6).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DeformedMoments {
    /// First moment `m c(q_e)` \[kg m\].
    pub mass_moment: Vector3<f64>,
    /// Its rate in the body's frame, `C_tᵀ dq_e/dt` [kg m/s].
    pub mass_moment_rate: Vector3<f64>,
    /// Inertia `I(q_e)` about the frame's origin [kg m²].
    pub inertia: Matrix3<f64>,
    /// Relative angular momentum `C_rᵀ(q_e) dq_e/dt = ∫ ρ (X + u) × du/dt` [kg m²/s].
    pub relative_spin: Vector3<f64>,
}

impl StandardInputData {
    /// Data of a model whose elastic modes are the columns of `shapes` (n × n_q), mass-orthonormal,
    /// with the squared angular eigenfrequencies `modal_stiffness` [rad²/s²].
    ///
    /// # Errors
    /// [`DynamicsError::Data`] if sizes do not fit, modes are not mass-orthonormal or an eigenfrequency is not
    /// positive; see [`ShapeIntegrals::new`] too.
    pub fn new(
        body: &AssembledBody,
        shapes: MatRef<'_, f64>,
        modal_stiffness: &[f64],
    ) -> Result<Self, DynamicsError> {
        let integrals = ShapeIntegrals::new(body, shapes)?;
        let n_q = shapes.ncols();
        for j in 0..n_q {
            for i in 0..n_q {
                let expected = if i == j { 1.0 } else { 0.0 };
                let deviation = (integrals.modal_mass[(i, j)] - expected).abs();
                if deviation > ORTHONORMALITY {
                    let (first, second, limit) = (i + 1, j + 1, ORTHONORMALITY);
                    return Err(DataError::NotOrthonormal { first, second, deviation, limit }.into());
                }
            }
        }
        let data = Self::from_integrals(body.motion, integrals, modal_stiffness)?;
        Ok(Self { modal_mass: ModalMass::Identity, ..data })
    }

    /// Data from the inertia integrals of any linearly independent modes without coupling in the
    /// stiffness, whose modal mass matrix may be any symmetric positive definite one.
    ///
    /// # Errors
    /// [`DynamicsError::Data`] if sizes do not fit or a stiffness is not positive,
    /// [`DynamicsError::NotPositiveDefinite`] if the modes are linearly dependent.
    pub fn from_integrals(
        motion: RigidMotion,
        integrals: ShapeIntegrals,
        modal_stiffness: &[f64],
    ) -> Result<Self, DynamicsError> {
        let n_q = integrals.shapes.len();
        if modal_stiffness.len() != n_q {
            let (what, found) = ("eigenfrequencies of the modes".into(), modal_stiffness.len());
            return Err(DataError::Count { what, found, expected: n_q }.into());
        }
        if let Some(j) = modal_stiffness.iter().position(|k| !(*k > 0.0 && k.is_finite())) {
            let what = format!("the squared frequency of mode {}", j + 1);
            return Err(DataError::OutOfRange { what, value: modal_stiffness[j], range: "> 0" }.into());
        }
        let modal_mass = ModalMass::from_matrix(integrals.modal_mass.as_ref(), 0.0)?;
        Ok(Self {
            motion,
            mass: integrals.mass,
            mass_moment: integrals.mass_moment,
            second_moment: integrals.second_moment,
            coupling_translation: integrals.shapes,
            modal_mass,
            modal_stiffness: modal_stiffness.to_vec(),
            modal_damping: ModalDamping::None,
            position_shape: integrals.position_shape,
            shape_shape: integrals.shape_shape,
            foreshortening: None,
        })
    }

    /// A rigid body from its mass \[kg\], centre of mass \[m\] and inertia about the frame's origin
    /// [kg m²], both in its frame.
    ///
    /// # Errors
    /// [`DynamicsError::Data`] if the mass is not positive, or the inertia is not symmetric or not that of any
    /// distribution of mass (a principal moment above the sum of the other two) about the centre of
    /// mass.
    pub fn rigid(
        motion: RigidMotion,
        mass: f64,
        centre_of_mass: Vector3<f64>,
        inertia: Matrix3<f64>,
    ) -> Result<Self, DynamicsError> {
        if !(mass > 0.0 && mass.is_finite()) {
            return Err(
                DataError::OutOfRange { what: "the mass [kg]".into(), value: mass, range: "> 0" }.into()
            );
        }
        let size = inertia.norm();
        if !size.is_finite() || !centre_of_mass.norm().is_finite() {
            return Err(DataError::NotFinite { what: "inertia or centre of mass".into() }.into());
        }
        // Round-off of numbers written with many digits.
        if (inertia - inertia.transpose()).norm() > 1e-9 * size {
            return Err(DataError::NotSymmetric { what: "the inertia tensor".into() }.into());
        }
        let second_moment = Matrix3::identity() * (0.5 * inertia.trace()) - inertia;
        let central = second_moment - centre_of_mass * centre_of_mass.transpose() * mass;
        let smallest = central.symmetric_eigenvalues().min();
        if motion == RigidMotion::Spatial && smallest < -1e-9 * size {
            return Err(DataError::Inertia { moment: smallest }.into());
        }
        Ok(Self {
            motion,
            mass,
            mass_moment: mass * centre_of_mass,
            second_moment,
            coupling_translation: Vec::new(),
            modal_mass: ModalMass::Identity,
            modal_stiffness: Vec::new(),
            modal_damping: ModalDamping::None,
            position_shape: Vec::new(),
            shape_shape: Vec::new(),
            foreshortening: None,
        })
    }

    /// Number of elastic coordinates.
    pub fn n_modes(&self) -> usize {
        self.modal_stiffness.len()
    }

    /// Whether the body turns, so that its moments matter.
    pub(crate) fn has_rotation(&self) -> bool {
        self.motion != RigidMotion::Axial
    }

    /// Inertia `I_0` of the undeformed body about the frame's origin [kg m²].
    pub fn inertia(&self) -> Matrix3<f64> {
        inertia_from(&self.second_moment)
    }

    /// `∫ ρ X φ_jᵀ`: its sum with the transpose is the first-order change of the second moment
    /// (Wallrapp's C4 group).
    pub fn position_shape_integral(&self, j: usize) -> Matrix3<f64> {
        self.block(&self.position_shape, j)
    }

    /// Row `j` of `C_r` at rest, `∫ ρ X × φ_j`; zero in a Buckens frame.
    pub fn coupling_rotation_at_rest(&self, j: usize) -> Vector3<f64> {
        axial(&self.position_shape_integral(j))
    }

    /// Centre of mass of the undeformed body in its frame \[m\].
    pub fn centre_of_mass(&self) -> Vector3<f64> {
        self.mass_moment / self.mass
    }

    /// Row `j` of `O_e` at rest: its product with `(ωx², ωy², ωz², ωx ωy, ωy ωz, ωz ωx)` is the
    /// centrifugal force (Eq. D.8).
    pub fn centrifugal(&self, j: usize) -> [f64; 6] {
        let c = self.position_shape_integral(j);
        [
            -(c[(1, 1)] + c[(2, 2)]),
            -(c[(0, 0)] + c[(2, 2)]),
            -(c[(0, 0)] + c[(1, 1)]),
            c[(0, 1)] + c[(1, 0)],
            c[(1, 2)] + c[(2, 1)],
            c[(0, 2)] + c[(2, 0)],
        ]
    }

    /// Moments of the body deformed by `elastic`, which changes at `rates` (Eq. D.6). Does not
    /// allocate.
    pub fn deformed_moments(&self, elastic: &[f64], rates: &[f64]) -> DeformedMoments {
        let mut mass_moment = self.mass_moment;
        let mut mass_moment_rate = Vector3::zeros();
        for ((c, q), rate) in self.coupling_translation.iter().zip(elastic).zip(rates) {
            mass_moment += c * *q;
            mass_moment_rate += c * *rate;
        }
        if let Some(Foreshortening { translation, .. }) = &self.foreshortening {
            for (at, g) in translation.iter().enumerate() {
                let q_i = elastic[at / self.n_modes()];
                mass_moment += g * (0.5 * q_i * elastic[at % self.n_modes()]);
                mass_moment_rate += g * (q_i * rates[at % self.n_modes()]);
            }
        }
        let mut second = self.second_moment;
        let mut spin = Matrix3::zeros();
        if self.has_rotation() {
            let bent = self.foreshortening.as_ref().map_or(&[][..], |g| &g.position[..]);
            let [moved, turned] = self.contracted(&self.position_shape, elastic, rates);
            second += moved + moved.transpose();
            spin += turned;
            let size = self.position_shape.len().max(1);
            for quadratic in [&self.shape_shape[..], bent] {
                for (rows, q_i) in quadratic.chunks_exact(size).zip(elastic) {
                    let [moved, turned] = self.contracted(rows, elastic, rates);
                    second += (moved + moved.transpose()) * (0.5 * *q_i);
                    spin += turned * *q_i;
                }
            }
        }
        DeformedMoments {
            mass_moment,
            mass_moment_rate,
            inertia: inertia_from(&second),
            relative_spin: axial(&spin),
        }
    }

    /// Sums of the blocks of an array ordered `(a n_c + b) n_q + j`, block `j` times `x_j` and
    /// times `y_j`.
    fn contracted(&self, array: &[f64], x: &[f64], y: &[f64]) -> [Matrix3<f64>; 2] {
        let n_c = self.motion.n_components();
        let mut sums = [Matrix3::zeros(); 2];
        for (at, row) in array.chunks_exact(self.n_modes().max(1)).enumerate() {
            let place = (at / n_c, at % n_c);
            [sums[0][place], sums[1][place]] = products(row, x, y);
        }
        sums
    }

    /// Block `j` of an array ordered `(a n_c + b) n_q + j`; models that do not turn have none.
    fn block(&self, array: &[f64], j: usize) -> Matrix3<f64> {
        let n_c = self.motion.n_components();
        let mut block = Matrix3::zeros();
        if !array.is_empty() {
            for a in 0..n_c {
                for b in 0..n_c {
                    block[(a, b)] = array[(a * n_c + b) * self.n_modes() + j];
                }
            }
        }
        block
    }
}

/// Scalar products of `row` with `x` and with `y`.
fn products(row: &[f64], x: &[f64], y: &[f64]) -> [f64; 2] {
    // Four sums at a time do not wait for each other.
    let mut sums = [[0.0; 4]; 2];
    let ((row, rest), (x, x_rest), (y, y_rest)) =
        (row.as_chunks::<4>(), x.as_chunks::<4>(), y.as_chunks::<4>());
    for ((row, x), y) in row.iter().zip(x).zip(y) {
        for k in 0..4 {
            sums[0][k] += row[k] * x[k];
            sums[1][k] += row[k] * y[k];
        }
    }
    for ((row, x), y) in rest.iter().zip(x_rest).zip(y_rest) {
        sums[0][0] += row * x;
        sums[1][0] += row * y;
    }
    sums.map(|[a, b, c, d]| (a + b) + (c + d))
}

/// Inertia `tr(W) E - W` from the second moment `W`.
pub(crate) fn inertia_from(second_moment: &Matrix3<f64>) -> Matrix3<f64> {
    Matrix3::identity() * second_moment.trace() - second_moment
}
