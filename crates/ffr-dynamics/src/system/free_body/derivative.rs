//! Derivatives of one body's forces for implicit integrators (docs/theory.md Eq. T.25).
//!
//! Only those with respect to elastic coordinates and rates, which are many and stiff; the few of
//! the rigid motion are left to differences of the right-hand side.

use nalgebra::Matrix3;

use super::equations::BodyWorkspace;
use crate::body::StandardInputData;
use crate::force::BodyState;
use crate::rotation::skew;

impl BodyWorkspace {
    /// Change of the forces with elastic coordinate `j` or its rate, at the moments of the last
    /// evaluation: elastic ones are added to `elastic`, rigid ones returned, in body axes.
    pub(in crate::system) fn elastic_change(
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
        let omega = &state.angular_velocity_in_body;
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
            moment[(a, b)] = self.moment(data, a, b)[j];
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
