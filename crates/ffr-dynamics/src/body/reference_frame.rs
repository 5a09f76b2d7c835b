//! Where a body's reference frame sits (docs/theory.md Eq. D.5).
//!
//! Modes that are mass-orthogonal to the rigid motions of the model belong to the Buckens (mean-axis) frame: they carry
//! neither linear nor, at first order, angular momentum. The frame's origin may be any point of the model; the equations
//! of motion keep the offset of the centre of mass. Moving the origin to the centre of mass is a choice, not a need.

use nalgebra::Vector3;

use super::assembled::AssembledBody;
use super::standard_input_data::StandardInputData;

/// Relative size up to which `C_t` and `C_r` at rest count as zero: modes are orthogonal to the eigensolver's tolerance.
const ORTHOGONALITY: f64 = 1e-6;

impl StandardInputData {
    /// Centre of mass of the undeformed body in its frame \[m\].
    pub fn centre_of_mass(&self) -> Vector3<f64> {
        self.mass_moment / self.mass
    }

    /// Whether the modes belong to the Buckens frame: `C_t = 0` and `C_r = 0` at rest (Eq. D.5).
    pub fn is_buckens_frame(&self) -> bool {
        let scale = self.mass.sqrt();
        let inertia = self.second_moment.trace().sqrt();
        self.coupling_translation.iter().all(|c| c.norm() <= ORTHOGONALITY * scale)
            && (0..self.n_modes())
                .all(|j| self.coupling_rotation_at_rest(j).norm() <= ORTHOGONALITY * inertia)
    }
}

/// Moves the origin of the body's frame to `origin`, a point in the model's components \[m\].
///
/// Shapes and matrices do not change. Contact points, markers and the initial position must be moved as well.
pub fn move_origin(body: &mut AssembledBody, origin: [f64; 3]) {
    for point in body.nodes.iter_mut().chain(&mut body.anchors) {
        for (x, x0) in point.iter_mut().zip(origin) {
            *x -= x0;
        }
    }
}
