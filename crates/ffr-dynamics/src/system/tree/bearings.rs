//! Loads of bearings whose friction they determine: what joints transmit depends on the friction,
//! and the friction on what they transmit (docs/theory.md Eq. M.17 to M.20).

use nalgebra::Vector3;

use super::kinematics::{JointKinematics, SpatialVector, split};
use crate::error::{EvaluationFailure, MotionFault};
use crate::system::joints::bearing::{JointBearing, Load, Sliding};
use crate::system::model::MultibodyModel;

/// Iterations on the loads; Newton's method takes three to five, what it does not gain contraction
/// does.
const MAX_ITERATIONS: usize = 200;
/// Residual, over the loads, that the last iteration may leave: no more than the tolerance of a
/// step.
const CONVERGED: f64 = 1e-10;

/// A bearing at one instant.
#[derive(Debug, Clone)]
pub(in crate::system) struct SlidingBearing {
    /// Body whose joint has it.
    pub body: usize,
    pub bearing: JointBearing,
    pub sliding: Sliding,
    /// Force and moment that the joint transmits without friction in any bearing.
    without: Load,
    /// The load with friction.
    pub load: f64,
}

impl SlidingBearing {
    /// Force along velocity `k` of the joint for the load `load`.
    pub fn friction(&self, k: usize, load: f64) -> f64 {
        -self.bearing.coefficient() * load * self.sliding.direction[k]
    }

    /// Power lost \[W\].
    pub fn dissipated(&self) -> f64 {
        self.bearing.coefficient() * self.load * self.sliding.power
    }
}

/// All bearings, with the buffers of the equations for their loads.
#[derive(Debug, Clone)]
pub(in crate::system) struct BearingSolver {
    pub bearings: Vec<SlidingBearing>,
    /// What joint `i` transmits by the friction of a unit load on bearing `j`, at `i n + j`.
    responses: Vec<Load>,
    matrix: Vec<f64>,
    candidate: Vec<f64>,
    residual: Vec<f64>,
}

/// What the joint transmits, of the `wrench` at the parent's marker: force and moment about the
/// child's marker, in the axes of the parent's marker.
fn transmitted(edge: &JointKinematics, wrench: &SpatialVector) -> Load {
    let (force, moment) = split(wrench);
    let moment = moment - edge.joint.displacement.cross(&force);
    let axes = edge.parent_point.rotation.inverse();
    (axes * force, axes * moment)
}

impl BearingSolver {
    pub fn new(model: &MultibodyModel) -> Self {
        let none = (Vector3::zeros(), Vector3::zeros());
        let bearings = model.bodies.iter().enumerate().filter_map(|(body, b)| {
            let bearing = b.joint.bearing?;
            Some(SlidingBearing { body, bearing, sliding: Sliding::default(), without: none, load: 0.0 })
        });
        let bearings: Vec<_> = bearings.collect();
        let n = bearings.len();
        Self {
            responses: vec![none; n * n],
            matrix: vec![0.0; n * n],
            candidate: vec![0.0; n],
            residual: vec![0.0; n],
            bearings,
        }
    }

    /// Takes over how the joints slide, and what they transmit without friction.
    pub fn start(&mut self, edges: &[JointKinematics], wrenches: &[SpatialVector]) {
        for at in &mut self.bearings {
            let edge = &edges[at.body];
            at.sliding = at.bearing.sliding(&edge.coordinates.velocities);
            at.without = transmitted(edge, &wrenches[at.body]);
        }
        let none = (Vector3::zeros(), Vector3::zeros());
        self.responses.fill(none);
    }

    /// Adds what the joints transmit by the friction of a unit load on bearing `j`.
    pub fn add_response(&mut self, j: usize, edges: &[JointKinematics], wrenches: &[SpatialVector]) {
        let n = self.bearings.len();
        for (i, at) in self.bearings.iter().enumerate() {
            let (force, moment) = transmitted(&edges[at.body], &wrenches[at.body]);
            let sum = &mut self.responses[i * n + j];
            sum.0 += force;
            sum.1 += moment;
        }
    }

    /// Finds the loads (Eq. M.19).
    ///
    /// # Errors
    /// [`MotionFault::Jam`] if friction adds as much load as it comes from (Eq. M.20): the loads do not exist or are not unique;
    /// [`MotionFault::BearingLoads`] if they are not found.
    pub fn solve(&mut self, model: &MultibodyModel) -> Result<(), EvaluationFailure> {
        self.check_gains(model)?;
        for at in &mut self.bearings {
            at.load = at.bearing.load(&at.without);
        }
        let (mut last, mut error, mut size) = (f64::INFINITY, 0.0, 0.0);
        for _ in 0..MAX_ITERATIONS {
            (error, size) = self.evaluate();
            // The round-off of a sum of what is transmitted with friction and without.
            if error <= 4.0 * f64::EPSILON * size {
                return Ok(());
            }
            let is_newton = error < 0.5 * last && self.newton();
            last = error;
            for (i, at) in self.bearings.iter_mut().enumerate() {
                // Contraction: the load by the present friction.
                at.load += if is_newton { self.candidate[i] } else { self.residual[i] };
            }
        }
        let is_found = error <= CONVERGED * size;
        if is_found { Ok(()) } else { Err(MotionFault::BearingLoads { error, size }.into()) }
    }

    /// Force and moment that joint `i` transmits under the present loads of the bearings.
    fn with_friction(&self, i: usize) -> Load {
        let n = self.bearings.len();
        let mut sum = self.bearings[i].without;
        for (at, (force, moment)) in self.bearings.iter().zip(&self.responses[i * n..(i + 1) * n]) {
            sum.0 += force * at.load;
            sum.1 += moment * at.load;
        }
        sum
    }

    /// Loads by the present friction less the present ones, in `residual`; the largest, and the
    /// largest load with that without friction.
    fn evaluate(&mut self) -> (f64, f64) {
        let (mut error, mut size) = (0.0_f64, 0.0_f64);
        for i in 0..self.bearings.len() {
            let at = &self.bearings[i];
            self.residual[i] = at.bearing.load(&self.with_friction(i)) - at.load;
            error = error.max(self.residual[i].abs());
            size = size.max(at.load.abs() + at.bearing.load(&at.without));
        }
        (error, size)
    }

    /// Newton's step in `candidate`; whether it is one. The matrix has positive pivots in any
    /// order, for the gains allow a contraction.
    fn newton(&mut self) -> bool {
        let n = self.bearings.len();
        for i in 0..n {
            let load = self.with_friction(i);
            let bearing = self.bearings[i].bearing;
            for j in 0..n {
                let unit = if i == j { 1.0 } else { 0.0 };
                self.matrix[i * n + j] = unit - bearing.derivative(&load, &self.responses[i * n + j]);
            }
        }
        if self.eliminate().is_err() {
            return false;
        }
        self.candidate.copy_from_slice(&self.residual);
        for i in 0..n {
            let sum: f64 = (0..i).map(|j| self.matrix[i * n + j] * self.candidate[j]).sum();
            self.candidate[i] -= sum;
        }
        for i in (0..n).rev() {
            let sum: f64 = (i + 1..n).map(|j| self.matrix[i * n + j] * self.candidate[j]).sum();
            self.candidate[i] = (self.candidate[i] - sum) / self.matrix[i * n + i];
        }
        true
    }

    /// Replaces `matrix` by its factors without pivoting; the number and the value of the first
    /// pivot that is not positive.
    fn eliminate(&mut self) -> Result<(), (usize, f64)> {
        let n = self.bearings.len();
        for k in 0..n {
            let pivot = self.matrix[k * n + k];
            let is_positive = pivot > 0.0;
            if !is_positive {
                return Err((k, pivot));
            }
            for i in k + 1..n {
                let factor = self.matrix[i * n + k] / pivot;
                self.matrix[i * n + k] = factor;
                for j in k + 1..n {
                    self.matrix[i * n + j] -= factor * self.matrix[k * n + j];
                }
            }
        }
        Ok(())
    }

    /// Refuses gains with which the loads need not exist (Eq. M.20): the matrix `1 - Γ` has
    /// positive pivots exactly if the spectral radius of `Γ`, which has no negative entries, is
    /// below one.
    fn check_gains(&mut self, model: &MultibodyModel) -> Result<(), EvaluationFailure> {
        let n = self.bearings.len();
        for i in 0..n {
            let bearing = self.bearings[i].bearing;
            for j in 0..n {
                let unit = if i == j { 1.0 } else { 0.0 };
                self.matrix[i * n + j] = unit - bearing.load(&self.responses[i * n + j]);
            }
        }
        self.eliminate().map_err(|(k, pivot)| {
            let joint = model.bodies[self.bearings[k].body].joint.name.clone();
            MotionFault::Jam { joint, gain: 1.0 - pivot }.into()
        })
    }
}
