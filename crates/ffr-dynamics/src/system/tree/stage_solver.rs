//! The linear systems of implicit stages, by way of the tree (docs/theory.md Eq. M.51).
//!
//! `(M + w² K + w D) x = M r - K s` for a complex weight `w`, with the stiffness and damping of
//! modes and joint springs and the inertia of one pose.

use faer::c64;

use super::kinematics::JointKinematics;
use super::solver::{Answer, FactorisedTree, Impedance, TreeFactors, TreePose};
use crate::body::ModalDamping;
use crate::integration::STAGE_PAIRS;
use crate::system::free_body::equations::BodyWorkspace;
use crate::system::model::MultibodyModel;

/// Solver for the systems of both pairs of stages about one pose.
#[derive(Debug, Clone)]
pub(in crate::system) struct StageSolver {
    pose: TreePose,
    factors: [TreeFactors<c64>; STAGE_PAIRS],
    weights: [c64; STAGE_PAIRS],
    answer: Answer<c64>,
}

impl StageSolver {
    pub fn new(model: &MultibodyModel) -> Self {
        Self {
            pose: TreePose::new(model),
            factors: std::array::from_fn(|_| TreeFactors::new(model)),
            weights: [c64::new(0.0, 0.0); STAGE_PAIRS],
            answer: Answer::new(model),
        }
    }

    /// Takes over the pose of the bodies and their inertia.
    pub fn hold(&mut self, model: &MultibodyModel, edges: &[JointKinematics], bodies: &[BodyWorkspace]) {
        self.pose.load(model, edges, bodies);
    }

    /// Factors for the weight `weight` of pair `pair`; returns whether they exist.
    pub fn factorise(&mut self, model: &MultibodyModel, pair: usize, weight: c64) -> bool {
        self.weights[pair] = weight;
        let impedance =
            Impedance { inertia: c64::new(1.0, 0.0), damping: weight, stiffness: weight * weight };
        self.factors[pair].factorise(model, &self.pose, |_| impedance, &impedance).is_ok()
    }

    /// Replaces `x`, the velocities `r` in the order of rates, by the solution with `s` the real
    /// `motion` times `scale`.
    pub fn solve(
        &mut self,
        model: &MultibodyModel,
        pair: usize,
        x: &mut [c64],
        (scale, motion): (c64, &[f64]),
    ) {
        let weight = self.weights[pair];
        // Force of a spring and a damper: -(w² k + w d) r - k s.
        let passive = |r: c64, s: f64, stiffness: f64, damping: f64| {
            -(weight * weight * r + scale * s) * stiffness - weight * r * damping
        };
        for (body, pose) in model.bodies.iter().zip(self.pose.springs()) {
            let joint = body.layout.rates_joint();
            for (k, [stiffness, damping]) in joint.zip(pose) {
                self.answer.forces[k] = passive(x[k], motion[k], *stiffness, *damping);
            }
            let elastic = body.layout.rates_elastic();
            for (k, stiffness) in elastic.clone().zip(&body.data.modal_stiffness) {
                self.answer.forces[k] = passive(x[k], motion[k], *stiffness, 0.0);
            }
            match &body.data.modal_damping {
                ModalDamping::None => {}
                ModalDamping::PerMode(damping) => {
                    for (k, d) in elastic.zip(damping) {
                        self.answer.forces[k] -= weight * x[k] * *d;
                    }
                }
                ModalDamping::Full(damping) => {
                    for (j, column) in elastic.clone().zip(damping.col_iter()) {
                        for (k, d) in elastic.clone().zip(column.iter()) {
                            self.answer.forces[k] -= weight * x[j] * *d;
                        }
                    }
                }
            }
        }
        let tree = FactorisedTree { model, pose: &self.pose, factors: &self.factors[pair] };
        self.answer.solve(tree, None);
        x.iter_mut().zip(&self.answer.rates).for_each(|(x, change)| *x += change);
    }
}
