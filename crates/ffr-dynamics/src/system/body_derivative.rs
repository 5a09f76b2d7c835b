//! Derivatives of one body's accelerations for implicit integrators (docs/theory.md Eq. T.19).
//!
//! Only those with respect to elastic coordinates and rates, which are many and stiff; the few of the rigid motion are left to
//! differences of the right-hand side.

use nalgebra::{Matrix3, Vector3};

use super::equations::{BodyWorkspace, active_directions, factor_active, substitute_active};
use super::force::{BodyState, GeneralisedForce};
use crate::body::StandardInputData;
use crate::error::EvaluationFailure;
use crate::integration::Linearisation;
use crate::kinematics::rotation::skew;

impl BodyWorkspace {
    /// Derivatives of the accelerations with respect to the elastic coordinates and rates (Eq. T.19), body by body in the
    /// order translation, rotation, elastic coordinates from `first` on in `derivative`.
    ///
    /// Stiffness, damping, centrifugal and Coriolis terms are exact; the inertia's own dependence on `q_e` is left out, so
    /// that the cost is `O(n_q²)`: that of a few accelerations.
    ///
    /// # Errors
    /// [`EvaluationFailure`] if the inertia of the deformed body is not positive definite.
    pub(super) fn linearise(
        &mut self,
        data: &StandardInputData,
        state: &BodyState,
        first: usize,
        derivative: &mut Linearisation,
    ) -> Result<(), EvaluationFailure> {
        let n_q = data.n_modes();
        let none = GeneralisedForce::zeros(0); // allocates nothing
        let mut rigid = if data.has_rotation() {
            self.turning(data, state, &none)
        } else {
            self.translating(data, state, &none)
        };
        data.modal_mass.whiten(&mut self.elastic, &mut self.coupling);
        self.eliminate_elastic(&mut rigid);
        let active = active_directions(data.motion);
        factor_active(&mut rigid.inertia, active)?;
        for j in 0..n_q {
            for by_rate in [false, true] {
                let column = if by_rate {
                    derivative.velocity_column_mut(first + 6 + j)
                } else {
                    derivative.position_column_mut(first + 6 + j)
                };
                column.fill(0.0);
                let column = &mut column[first..first + 6 + n_q];
                let (to_rigid, elastic) = column.split_at_mut(6);
                rigid.force = self.elastic_change(data, state, j, by_rate, elastic);
                data.modal_mass.whiten_forces(elastic);
                for (row, f) in self.coupling.iter().zip(&*elastic) {
                    rigid.force.iter_mut().zip(row).for_each(|(r, c)| *r -= c * f);
                }
                substitute_active(&rigid.inertia, &mut rigid.force, active);
                for (f, row) in elastic.iter_mut().zip(&self.coupling) {
                    *f -= row.iter().zip(&rigid.force).map(|(c, a)| c * a).sum::<f64>();
                }
                data.modal_mass.unwhiten(elastic);
                let [x, y, z, alpha @ ..] = rigid.force;
                to_rigid[..3].copy_from_slice((state.rotation * Vector3::new(x, y, z)).as_slice());
                to_rigid[3..].copy_from_slice(&alpha);
            }
        }
        Ok(())
    }

    /// Change of the forces with elastic coordinate `j` or its rate, at the moments of the last evaluation: elastic ones are
    /// added to `elastic`, rigid ones returned, in body axes.
    pub(super) fn elastic_change(
        &self,
        data: &StandardInputData,
        state: &BodyState,
        j: usize,
        by_rate: bool,
        elastic: &mut [f64],
    ) -> [f64; 6] {
        if by_rate {
            data.modal_damping.subtract_column(j, elastic);
        } else {
            elastic[j] -= data.modal_stiffness[j];
        }
        let mut rigid = [0.0; 6];
        if !data.has_rotation() {
            return rigid;
        }
        let omega = &state.angular_velocity;
        let c = &data.coupling_translation[j];
        let force = if by_rate { 2.0 * omega.cross(c) } else { omega.cross(&omega.cross(c)) };
        let weights = if by_rate {
            -2.0 * skew(omega)
        } else {
            omega * omega.transpose() - Matrix3::identity() * omega.norm_squared()
        };
        let (n_q, n_c) = (data.n_modes(), data.motion.n_components());
        let size = n_c * n_c * n_q;
        let mut moment = Matrix3::zeros();
        for (a, b) in (0..n_c).flat_map(|a| (0..n_c).map(move |b| (a, b))) {
            let start = (a * n_c + b) * n_q;
            moment[(a, b)] = self.moments[start + j];
            let shapes = &data.shape_shape[j * size + start..j * size + start + n_q];
            elastic.iter_mut().zip(shapes).for_each(|(f, p)| *f -= weights[(a, b)] * p);
            if let Some(g) = data.foreshortening.as_ref().filter(|_| !by_rate) {
                let bent = &g.position[j * size + start..j * size + start + n_q];
                elastic.iter_mut().zip(bent).for_each(|(f, p)| *f -= weights[(a, b)] * p);
            }
        }
        rigid[..3].copy_from_slice((-force).as_slice());
        if by_rate {
            let torque = -2.0 * (omega * moment.trace() - moment.tr_mul(omega));
            rigid[3..].copy_from_slice(torque.as_slice());
        }
        rigid
    }
}
