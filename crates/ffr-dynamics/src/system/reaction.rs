//! Forces and moments that joints transmit (docs/theory.md Eq. M.52 to M.54).

use std::ops::DerefMut;

use nalgebra::Vector3;

use super::multibody::Multibody;
use super::tree::kinematics::split;
use crate::force::active::ActiveForce;

/// What a joint exerts on its child: the whole of it, whether the joint holds a direction or a
/// spring, a damper, a drive or a prescribed motion acts along it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reaction {
    /// Force on the child, in the inertial frame \[N\].
    pub force: Vector3<f64>,
    /// Moment on the child about the place of its marker on the deformed body, in the inertial
    /// frame \[N m\].
    pub moment: Vector3<f64>,
}

impl<F: DerefMut<Target: ActiveForce>> Multibody<F> {
    /// Reaction of the joint whose child body `body` is (Eq. M.52, M.53). Zero for bodies that move
    /// freely.
    ///
    /// Belongs to the last accelerations ([`Multibody::evaluate_accelerations`] or a right-hand
    /// side); the bodies must stand where they did then, as after [`Multibody::invariants`] of that
    /// state. Does not allocate.
    pub fn reaction(&self, body: usize) -> Reaction {
        let (force, moment) = split(&self.workspace.accelerations.wrenches[body]);
        let moment = moment - self.workspace.edges[body].joint.displacement.cross(&force);
        match self.model.bodies[body].joint.parent.body {
            None => Reaction { force, moment },
            Some(p) => {
                let axes = &self.workspace.states[p].rotation;
                Reaction { force: axes * force, moment: axes * moment }
            }
        }
    }

    /// Force or moment of gear `gear` along its second coordinate, at the last accelerations
    /// (Eq. M.38); along the first it is the same times the negative ratio. Does not allocate.
    pub fn gear_force(&self, gear: usize) -> f64 {
        self.workspace.gear_forces[gear]
    }

    /// Reaction of the loop-closing joint `joint`, in the order of [`super::MultibodyModel::loops`]
    /// (Eq. M.54), at the last accelerations. Redundant constraints carry nothing. Does not
    /// allocate.
    pub fn loop_reaction(&self, joint: usize) -> Reaction {
        let (force, moment) = split(&self.workspace.loop_wrenches[joint]);
        Reaction { force, moment }
    }
}
