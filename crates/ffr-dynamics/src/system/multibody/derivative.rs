//! What implicit integrators know of a multibody system: its kinematics and the derivatives of its
//! vibration (docs/theory.md Eq. M.50).

use std::ops::DerefMut;

use super::workspace::Workspace;
use crate::force::active::ActiveForce;
use crate::force::{GeneralisedForce, Motion};
use crate::integration::{KinematicBlock, Linearisation};
use crate::system::model::{MultibodyModel, TreeBody};
use crate::system::tree::kinematics::{frame_velocities, join, split};
use crate::system::tree::solver::FactorisedTree;

impl TreeBody {
    /// Blocks of the body's coordinates, in the order of its rates: elastic, joint.
    pub(super) fn kinematics(&self) -> Vec<KinematicBlock> {
        let Self { joint, layout, .. } = self;
        let (position, velocity) = (layout.positions().start, layout.velocities().start);
        let n_plain = joint.kind.quaternion().unwrap_or(layout.n_velocities);
        let mut blocks = vec![
            KinematicBlock::Vector {
                position: layout.elastic().start,
                velocity: layout.elastic_rates().start,
                len: layout.n_modes,
            },
            KinematicBlock::Vector { position, velocity, len: n_plain },
        ];
        if let Some(w) = joint.kind.quaternion() {
            blocks.push(KinematicBlock::Rotation { quaternion: position + w, velocity: velocity + w });
        }
        blocks
    }
}

impl Workspace {
    /// Derivatives of all accelerations with respect to elastic coordinates and rates, at the last
    /// evaluation.
    ///
    /// Stiffness, damping, centrifugal and Coriolis terms of each body (Eq. T.25) and the rates of `forces` (Eq. C.109),
    /// with the inertia of the whole tree; what the deformation changes in inertia and levers is left out. A column
    /// costs one substitution. Columns of which a force does not know its rates are left alone.
    pub(super) fn linearise<F: DerefMut<Target: ActiveForce>>(
        &mut self,
        model: &MultibodyModel,
        forces: &mut [F],
        derivative: &mut Linearisation,
    ) {
        self.acting.clear();
        self.acting.extend((0..forces.len()).filter(|i| !forces[*i].is_idle()));
        for (i, body) in model.bodies.iter().enumerate() {
            let elastic = body.layout.rates_elastic();
            for j in 0..body.layout.n_modes {
                let unknown = elastic.start + j;
                if !self.acting.is_empty() {
                    self.move_along(model, unknown);
                }
                for by_rate in [false, true] {
                    let response = &mut self.loops.response;
                    response.clear();
                    response.frame_forces[i] = self.bodies[i].elastic_change(
                        &body.data,
                        &self.states[i],
                        j,
                        by_rate,
                        &mut response.forces[elastic.clone()],
                    );
                    if !self.add_rates(model, forces, by_rate) {
                        continue;
                    }
                    let tree = FactorisedTree { model, pose: &self.pose, factors: &self.factors };
                    let response = &mut self.loops.response;
                    response.solve(tree, None);
                    let column = if by_rate {
                        derivative.velocity_column_mut(unknown)
                    } else {
                        derivative.position_column_mut(unknown)
                    };
                    column.copy_from_slice(&response.rates);
                }
            }
        }
    }

    /// Has the bodies of `moving` stand as in the last evaluation and move with a unit of rate `j` alone.
    pub fn move_along(&mut self, model: &MultibodyModel, j: usize) {
        let Self { states, moving, direction, frames, edges, .. } = self;
        direction.fill(0.0);
        direction[j] = 1.0;
        frame_velocities(model, edges, direction, frames);
        for (((moving, state), frame), body) in moving.iter_mut().zip(states).zip(frames).zip(&model.bodies) {
            let (velocity, turning) = split(frame);
            moving.position = state.position;
            moving.rotation = state.rotation;
            moving.elastic.copy_from_slice(&state.elastic);
            moving.velocity = state.rotation * velocity;
            moving.angular_velocity_in_body = turning;
            moving.elastic_rates.copy_from_slice(&direction[body.layout.rates_elastic()]);
        }
    }

    /// Adds the rates of those of `forces` that act, in the motion of `moving` to the forces that are answered to; false if one of them is not known.
    fn add_rates<F: DerefMut<Target: ActiveForce>>(
        &mut self,
        model: &MultibodyModel,
        forces: &mut [F],
        by_rate: bool,
    ) -> bool {
        let Self { spare_sums: sums, moving, loops, time, acting, .. } = self;
        if acting.is_empty() {
            return true;
        }
        sums.iter_mut().for_each(GeneralisedForce::clear);
        let motion = Motion::new(*time, moving);
        if !acting.iter().all(|i| forces[*i].rates(motion, by_rate, sums)) {
            return false;
        }
        let response = &mut loops.response;
        for (i, ((sum, state), body)) in sums.iter().zip(&*moving).zip(&model.bodies).enumerate() {
            let frame = join(&state.rotation.inverse_transform_vector(&sum.force), &sum.torque_in_body);
            response.frame_forces[i].iter_mut().zip(frame).for_each(|(to, f)| *to += f);
            let elastic = response.forces[body.layout.rates_elastic()].iter_mut();
            elastic.zip(&sum.elastic).for_each(|(to, f)| *to += f);
        }
        true
    }
}
