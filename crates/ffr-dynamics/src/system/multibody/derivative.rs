//! What implicit integrators know of a multibody system: its kinematics and the derivatives of its
//! vibration (docs/theory.md Eq. M.50).

use super::workspace::Workspace;
use crate::integration::{KinematicBlock, Linearisation};
use crate::system::model::{MultibodyModel, TreeBody};
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
    /// Stiffness, damping, centrifugal and Coriolis terms of each body (Eq. T.25) with the inertia
    /// of the whole tree; what the deformation changes in inertia and levers is left out. A column
    /// costs one substitution.
    pub(super) fn linearise(&mut self, model: &MultibodyModel, derivative: &mut Linearisation) {
        for (i, body) in model.bodies.iter().enumerate() {
            let elastic = body.layout.rates_elastic();
            for j in 0..body.layout.n_modes {
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
                    let tree = FactorisedTree { model, pose: &self.pose, factors: &self.factors };
                    response.solve(tree, None);
                    let unknown = elastic.start + j;
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
}
