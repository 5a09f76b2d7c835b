//! Inertia forces and weight of a body, fixed in space and to its material points (docs/theory.md
//! Eq. M.56).

use nalgebra::{Matrix3, UnitQuaternion, Vector3};

use crate::body::StandardInputData;
use crate::force::BodyState;
use crate::rotation::axial;
use crate::system::tree::kinematics::{SpatialVector, join, split};

/// The forces `-ρ a` of an acceleration `a` that each material point of a body keeps, whatever the
/// motion.
#[derive(Debug, Clone)]
pub(super) struct DeadLoad {
    /// Rotation of the body in which the rest is expressed.
    rotation: UnitQuaternion<f64>,
    /// `∫ ρ a` \[N\].
    force: Vector3<f64>,
    /// `∫ ρ X aᵀ` [N m].
    position: Matrix3<f64>,
    /// `∫ ρ φ_j aᵀ`; empty if nothing turns.
    modes: Vec<Matrix3<f64>>,
    /// `∫ ρ g_ij aᵀ` at `i n_q + j`, of geometric stiffening; empty without.
    second: Vec<Matrix3<f64>>,
}

impl DeadLoad {
    /// The load on a body in `state` whose frame has the acceleration `frame` less gravity, in its
    /// axes; modes do not accelerate.
    pub fn new(data: &StandardInputData, state: &BodyState, frame: &SpatialVector) -> Self {
        let (translation, spin) = split(frame);
        let (n_q, n_c, q) = (data.n_modes(), data.motion.n_components(), &state.elastic);
        let moved = data.coupling_translation.iter().zip(q).map(|(c, q)| c * *q).sum::<Vector3<f64>>();
        let force = translation * data.mass + spin.cross(&(data.mass_moment + moved));
        let rotation = state.rotation;
        if !data.has_rotation() {
            let none = Vec::new();
            return Self { rotation, force, position: Matrix3::zeros(), modes: none.clone(), second: none };
        }
        let size = n_c * n_c * n_q;
        // ∫ ρ x φ_jᵀ from integrals in the model's components.
        let block = |integrals: &[f64], j: usize| {
            let entry =
                |a: usize, b: usize| if a.max(b) < n_c { integrals[(a * n_c + b) * n_q + j] } else { 0.0 };
            Matrix3::from_fn(entry)
        };
        let of_point = |j: usize| block(&data.position_shape, j);
        let of_mode = |i: usize, j: usize| block(&data.shape_shape[i * size..(i + 1) * size], j);
        let turned = spin.cross_matrix().transpose();
        let mut position = data.mass_moment * translation.transpose() + data.second_moment * turned;
        for (j, q) in q.iter().enumerate() {
            position += of_point(j) * turned * *q;
        }
        let mode = |j: usize| {
            let alone =
                data.coupling_translation[j] * translation.transpose() + of_point(j).transpose() * turned;
            (0..n_q).fold(alone, |sum, i| sum + of_mode(j, i) * turned * q[i])
        };
        let second = data.foreshortening.as_ref().map_or_else(Vec::new, |g| {
            let pair = |i: usize, j: usize| {
                let moment = block(&g.position[i * size..(i + 1) * size], j);
                g.translation[i * n_q + j] * translation.transpose() + moment.transpose() * turned
            };
            (0..n_q).flat_map(|i| (0..n_q).map(move |j| (i, j))).map(|(i, j)| pair(i, j)).collect()
        });
        Self { rotation, force, position, modes: (0..n_q).map(mode).collect(), second }
    }

    /// Force on the frame and moment about it, in the axes of the body in `state`; modal forces are
    /// added to `elastic`.
    pub fn apply(&self, state: &BodyState, elastic: &mut [f64]) -> SpatialVector {
        let turn: Matrix3<f64> = (state.rotation.inverse() * self.rotation).to_rotation_matrix().into_inner();
        let (n_q, q) = (self.modes.len(), &state.elastic);
        let mut position = self.position;
        for (j, mode) in self.modes.iter().enumerate() {
            let mut own = *mode;
            if !self.second.is_empty() {
                let bent: Matrix3<f64> = (0..n_q).map(|i| self.second[i * n_q + j] * q[i]).sum();
                own += bent;
                position += bent * (0.5 * q[j]);
            }
            position += mode * q[j];
            elastic[j] -= own.component_mul(&turn).sum();
        }
        join(&-(turn * self.force), &-axial(&(position * turn.transpose())))
    }
}
