//! Tangent frame: modes shifted by the rigid motion that holds a point and its rotation
//! (docs/theory.md Eq. M.1 to M.3).

use faer::{Mat, MatRef};
use nalgebra::{Matrix3, Vector3};

use super::assembled::{AssembledBody, RigidMotion};
use super::modal_mass::ModalMass;
use super::standard_input_data::StandardInputData;
use crate::data_error::DataError;
use crate::error::DynamicsError;
use crate::rotation::skew;

/// The rigid motions by which the modes of a body are shifted so that displacement and rotation
/// vanish at a point.
///
/// `φ'_j(X) = φ_j(X) - t_j - ϑ_j × (X - X_0)` with the displacement `t_j` and the rotation `ϑ_j` of
/// mode `j` at `X_0`. Elastic coordinates, stiffness and damping do not change: a rigid motion
/// carries no elastic energy.
#[derive(Debug, Clone, PartialEq)]
pub struct TangentFrame {
    origin: Vector3<f64>,
    translations: Vec<Vector3<f64>>,
    rotations: Vec<Vector3<f64>>,
}

impl TangentFrame {
    /// Frame that follows the point `origin` \[m\], where the modes have the displacements
    /// `translations` and the rotations `rotations` (half the curl), one per mode. Shifts keep to
    /// the rigid motions of the model.
    ///
    /// # Errors
    /// [`DynamicsError::Data`] if their numbers differ.
    pub fn new(
        motion: RigidMotion,
        origin: Vector3<f64>,
        mut translations: Vec<Vector3<f64>>,
        mut rotations: Vec<Vector3<f64>>,
    ) -> Result<Self, DynamicsError> {
        if translations.len() == rotations.len() {
            for (t, turn) in translations.iter_mut().zip(&mut rotations) {
                restrict(motion, t, turn);
            }
            return Ok(Self { origin, translations, rotations });
        }
        let (what, found) = ("rotations of modes at a tangent frame".into(), rotations.len());
        Err(DataError::Count { what, found, expected: translations.len() }.into())
    }

    /// Number of modes.
    pub fn n_modes(&self) -> usize {
        self.translations.len()
    }

    /// What the shift adds to mode `j` at the undeformed place `x`.
    pub fn displacement(&self, j: usize, x: &Vector3<f64>) -> Vector3<f64> {
        -self.translations[j] - self.rotations[j].cross(&(x - self.origin))
    }

    /// What the shift adds to the rotation of mode `j`, anywhere.
    pub fn rotation(&self, j: usize) -> Vector3<f64> {
        -self.rotations[j]
    }

    /// The modes `shapes` (n × n_q) of an unreduced body with the shift added, for what depends on
    /// the frame in use.
    ///
    /// # Errors
    /// [`DynamicsError::Data`] if sizes do not fit.
    pub fn shifted_shapes(
        &self,
        body: &AssembledBody,
        shapes: MatRef<'_, f64>,
    ) -> Result<Mat<f64>, DynamicsError> {
        let (n, n_q) = (body.dofs.len(), self.n_modes());
        if shapes.nrows() != n || shapes.ncols() != n_q {
            let (what, found) = ("the shapes for a tangent frame".into(), (shapes.nrows(), shapes.ncols()));
            return Err(DataError::Size { what, found, expected: (n, n_q) }.into());
        }
        let motion = body.motion;
        Ok(Mat::from_fn(n, n_q, |i, j| {
            let dof = body.dofs[i];
            let shift = match motion.rotation_axis(dof.component) {
                Some(axis) => self.rotation(j)[axis],
                None => {
                    let node = body.nodes[dof.node as usize];
                    let mut place = Vector3::zeros();
                    (0..motion.n_components()).for_each(|c| place[motion.direction(c)] = node[c]);
                    self.displacement(j, &place)[motion.direction(dof.component as usize)]
                }
            };
            shapes[(i, j)] + shift
        }))
    }

    /// Shift of mode `j` as `a + B X`.
    fn affine(&self, j: usize) -> (Vector3<f64>, Matrix3<f64>) {
        (self.displacement(j, &Vector3::zeros()), skew(&self.rotation(j)))
    }
}

impl StandardInputData {
    /// The same body with the modes of a tangent frame (Eq. M.2, M.3).
    ///
    /// Points and markers must be shifted as well.
    ///
    /// # Errors
    /// [`DynamicsError::Data`] if the number of modes differs or the body has geometric stiffening already; [`DynamicsError::NotPositiveDefinite`] if the
    /// shifted modes are linearly dependent.
    pub fn in_tangent_frame(&self, frame: &TangentFrame) -> Result<Self, DynamicsError> {
        let n = self.n_modes();
        if frame.n_modes() != n {
            let (what, found) = ("modes of the tangent frame".into(), frame.n_modes());
            return Err(DataError::Count { what, found, expected: n }.into());
        }
        if self.foreshortening.is_some() {
            return Err(DataError::FrameOfStiffenedBody.into());
        }
        let shift: Vec<_> = (0..n).map(|j| frame.affine(j)).collect();
        let mut data = self.clone();
        let mut mass = Mat::<f64>::zeros(n, n);
        for (j, (a, b)) in shift.iter().enumerate() {
            data.coupling_translation[j] += a * self.mass + b * self.mass_moment;
            let position = self.mass_moment * a.transpose() + self.second_moment * b.transpose();
            add_block(self.motion, &mut data.position_shape, n, j, &position);
        }
        let size = data.position_shape.len();
        for (i, shift_i) in shift.iter().enumerate() {
            for (j, shift_j) in shift.iter().enumerate() {
                let change = self.pair_change(i, j, shift_i, shift_j);
                mass[(i, j)] = self.modal_mass.entry(i, j) + change.trace();
                if size > 0 {
                    add_block(self.motion, &mut data.shape_shape[i * size..(i + 1) * size], n, j, &change);
                }
            }
        }
        data.modal_mass = ModalMass::from_matrix(mass.as_ref(), 0.0)?;
        Ok(data)
    }

    /// Change of `∫ ρ φ_i φ_jᵀ` by the shifts of both modes.
    fn pair_change(
        &self,
        i: usize,
        j: usize,
        (a_i, b_i): &(Vector3<f64>, Matrix3<f64>),
        (a_j, b_j): &(Vector3<f64>, Matrix3<f64>),
    ) -> Matrix3<f64> {
        let (c_i, c_j) = (&self.coupling_translation[i], &self.coupling_translation[j]);
        let (p_i, p_j) = (self.position_shape_integral(i), self.position_shape_integral(j));
        let s = &self.mass_moment;
        c_i * a_j.transpose()
            + p_i.transpose() * b_j.transpose()
            + a_i * c_j.transpose()
            + b_i * p_j
            + a_i * a_j.transpose() * self.mass
            + a_i * (b_j * s).transpose()
            + b_i * s * a_j.transpose()
            + b_i * self.second_moment * b_j.transpose()
    }
}

/// Keeps the part of a rigid motion that the model can perform.
fn restrict(motion: RigidMotion, translation: &mut Vector3<f64>, rotation: &mut Vector3<f64>) {
    match motion {
        RigidMotion::Spatial => {}
        RigidMotion::Planar => {
            translation.z = 0.0;
            *rotation = Vector3::z() * rotation.z;
        }
        RigidMotion::Axial => {
            *translation = Vector3::z() * translation.z;
            rotation.fill(0.0);
        }
    }
}

/// Adds `change` to block `j` of an array ordered `(a n_c + b) n_q + j`.
fn add_block(motion: RigidMotion, array: &mut [f64], n_q: usize, j: usize, change: &Matrix3<f64>) {
    if array.is_empty() {
        return;
    }
    let n_c = motion.n_components();
    for a in 0..n_c {
        for b in 0..n_c {
            array[(a * n_c + b) * n_q + j] += change[(a, b)];
        }
    }
}
