//! Static start: elastic coordinates that do not accelerate (docs/theory.md Eq. M.42), and what pushes a
//! whole system out of a pose.

pub mod balance;

use std::ops::DerefMut;

use super::model::MultibodyModel;
use super::multibody::Multibody;
use super::multibody::workspace::Workspace;
use super::tree::solver::{Answer, FactorisedTree, Impedance, TreeFactors};
use crate::error::{DynamicsError, EvaluationFailure, StaticStartFault};
use crate::force::active::ActiveForce;
use crate::integration::OdeSystem;

/// Share of the elastic energy that the last correction may have.
const TOLERANCE: f64 = 1e-24;
/// Corrections; each gains several digits, as elastic forces outweigh the change of all others by
/// deformation.
const MAX_CORRECTIONS: usize = 40;

impl<F: DerefMut<Target: ActiveForce>> Multibody<F> {
    /// Sets the elastic coordinates in `y` such that `d²q_e/dt² = 0` at time `t`, and their rates
    /// to zero.
    ///
    /// Joint coordinates are held, and joint velocities stay as they are, with their centrifugal and
    /// damping forces. The joints are free to accelerate: released from this state, the bodies begin to
    /// move without vibration.
    ///
    /// # Errors
    /// [`DynamicsError::StaticStart`] if the corrections do not converge (too soft bodies), a force element refuses, or there are
    /// loop-closing joints, which the deformation would open.
    pub fn static_start(&mut self, t: f64, y: &mut [f64]) -> Result<(), DynamicsError> {
        let fail = |fault| Err(DynamicsError::StaticStart(fault));
        if self.model.has_constraints() {
            return fail(StaticStartFault::LoopClosing);
        }
        for body in &self.model.bodies {
            y[body.layout.elastic_rates()].fill(0.0);
        }
        if self.model.bodies.iter().all(|b| b.layout.n_modes == 0) {
            return Ok(());
        }
        let mut stiff = StiffTree::new(&self.model);
        let mut rates = vec![0.0; self.dimension()];
        for _ in 0..MAX_CORRECTIONS {
            if let Err(refusal) = self.rhs(t, y, &mut rates) {
                return fail(refusal.into());
            }
            if let Err(refusal) = stiff.solve(&self.model, &self.workspace) {
                return fail(refusal.into());
            }
            let (mut moved, mut stored) = (0.0, 0.0);
            for (i, body) in self.model.bodies.iter().enumerate() {
                let coordinates = &mut y[body.layout.elastic()];
                let changes = stiff.changes(&self.model, i);
                for ((q, change), k) in coordinates.iter_mut().zip(changes).zip(&body.data.modal_stiffness) {
                    *q += change;
                    moved += k * change * change;
                    stored += k * *q * *q;
                }
            }
            if !moved.is_finite() {
                break;
            }
            if moved <= TOLERANCE * stored {
                return Ok(());
            }
        }
        fail(StaticStartFault::NotConverged { corrections: MAX_CORRECTIONS })
    }
}

/// The tree with modes that do not move: bodies and joints accelerate as rigid ones.
struct StiffTree {
    factors: TreeFactors<f64>,
    answer: Answer<f64>,
    changes: Vec<f64>,
}

impl StiffTree {
    fn new(model: &MultibodyModel) -> Self {
        Self { factors: TreeFactors::new(model), answer: Answer::new(model), changes: Vec::new() }
    }

    /// Accelerations under the forces of the last evaluation.
    fn solve(&mut self, model: &MultibodyModel, workspace: &Workspace) -> Result<(), EvaluationFailure> {
        let Workspace { pose, accelerations, .. } = workspace;
        let joints = Impedance::of_inertia();
        let modes = Impedance { inertia: f64::INFINITY, ..joints };
        self.factors.factorise(model, pose, |_| modes, &joints)?;
        self.answer.frame_forces.copy_from_slice(&accelerations.frame_forces);
        self.answer.forces.copy_from_slice(&accelerations.forces);
        let tree = FactorisedTree { model, pose, factors: &self.factors };
        self.answer.solve(tree, Some(&model.gravity));
        Ok(())
    }

    /// Changes of the elastic coordinates of body `i` whose elastic forces are what acts on its
    /// modes.
    fn changes(&mut self, model: &MultibodyModel, i: usize) -> &[f64] {
        let modes = &model.bodies[i].modes;
        let by_modes: Vec<f64> =
            self.answer.modal_forces(i).iter().zip(&modes.stiffness).map(|(f, k)| f / k).collect();
        self.changes.resize(by_modes.len(), 0.0);
        modes.coordinates(&by_modes, &mut self.changes);
        &self.changes
    }
}
