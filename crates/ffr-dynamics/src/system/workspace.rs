//! Buffers of a multibody system, and the evaluation of motions and accelerations in them.

use nalgebra::Vector3;

use super::articulated::{BodyFactors, solve_tree};
use super::equations::BodyWorkspace;
use super::force::{BodyState, GeneralisedForce};
use super::joints::forces::joint_forces;
use super::loop_closure::LoopSolver;
use super::model::{Load, MultibodyModel, TreeBody};
use super::tree_kinematics::{JointKinematics, SpatialVector, split, update};
use crate::error::EvaluationFailure;

/// Power that goes in and out of a system at one instant \[W\].
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Powers {
    /// Lost in modal damping and joint dampers.
    pub dissipated: f64,
    /// Supplied by loads, drives and prescribed motion.
    pub supplied: f64,
}

/// Buffers of a multibody system.
#[derive(Debug, Clone)]
pub(super) struct Workspace {
    pub states: Vec<BodyState>,
    pub sums: Vec<GeneralisedForce>,
    pub edges: Vec<JointKinematics>,
    pub(super) bodies: Vec<BodyWorkspace>,
    pub factors: Vec<BodyFactors>,
    pub loops: LoopSolver,
    /// Joint forces along free velocities; springs and dampers of all velocities.
    joint_forces: Vec<SpatialVector>,
    passive: Vec<SpatialVector>,
    /// Accelerations of all coordinates and of the frames (without gravity's offset).
    pub rates: Vec<f64>,
    frames: Vec<SpatialVector>,
    /// Wrenches of the joints at the last accelerations, as [`BodyFactors::joint_force`].
    pub wrenches: Vec<SpatialVector>,
    /// Wrenches of loop-closing joints on their children at the children's markers, in inertial axes.
    pub loop_wrenches: Vec<SpatialVector>,
    load_power: f64,
    /// Time of the last evaluation.
    pub time: f64,
}

impl Workspace {
    pub fn new(model: &MultibodyModel) -> Self {
        let n = model.bodies.len();
        let states: Vec<_> = model.bodies.iter().map(|b| BodyState::at_rest(b.layout.n_modes)).collect();
        let edge = |b: &TreeBody| {
            JointKinematics::new(b, b.joint.parent.body.map_or(0, |p| model.bodies[p].layout.n_modes))
        };
        Self {
            sums: model.bodies.iter().map(|b| GeneralisedForce::zeros(b.layout.n_modes)).collect(),
            edges: model.bodies.iter().map(edge).collect(),
            bodies: model.bodies.iter().map(|b| BodyWorkspace::new(&b.data)).collect(),
            factors: model.bodies.iter().map(BodyFactors::new).collect(),
            loops: LoopSolver::new(model, &states),
            joint_forces: vec![[0.0; 6]; n],
            passive: vec![[0.0; 6]; n],
            rates: vec![0.0; model.n_rates()],
            frames: vec![[0.0; 6]; n],
            wrenches: vec![[0.0; 6]; n],
            loop_wrenches: vec![[0.0; 6]; model.loops.len()],
            load_power: 0.0,
            time: 0.0,
            states,
        }
    }

    /// Motions of all bodies; forgets the forces.
    pub fn place(&mut self, model: &MultibodyModel, t: f64, y: &[f64]) {
        self.time = t;
        update(model, t, y, &mut self.states, &mut self.edges);
        self.sums.iter_mut().for_each(GeneralisedForce::clear);
        self.load_power = 0.0;
    }

    /// Adds the loads at the last motion.
    pub fn add_loads(&mut self, model: &MultibodyModel) {
        for load in &model.loads {
            let (force, moment) = load_at(load, self.time, &self.states[load.body]);
            let state = &self.states[load.body];
            self.load_power +=
                force.dot(&load.marker.velocity(state)) + moment.dot(&load.marker.angular_velocity(state));
            load.marker.add_wrench(state, &force, &moment, &mut self.sums[load.body]);
        }
    }

    /// Inertia of the tree and accelerations under the forces collected.
    pub fn accelerate(&mut self, model: &MultibodyModel) -> Result<Powers, EvaluationFailure> {
        let mut powers = Powers { dissipated: 0.0, supplied: self.load_power };
        for (i, body) in model.bodies.iter().enumerate() {
            let workspace = &mut self.bodies[i];
            powers.dissipated += self.factors[i].load(body, &self.states[i], &self.sums[i], workspace);
            let joint = &body.joint;
            if joint.coordinates.is_empty() {
                continue; // the slots stay zero
            }
            let at = &self.edges[i].coordinates;
            let n = joint.kind.n_velocities();
            let forces =
                joint_forces(joint.kind, &joint.coordinates, self.time, &at.positions, &at.velocities[..n]);
            powers.dissipated += forces.dissipated;
            self.passive[i] = forces.passive;
            for (slot, k) in joint.free_velocities().enumerate() {
                self.joint_forces[i][slot] = forces.passive[k] + forces.drive[k];
                powers.supplied += forces.drive[k] * at.velocities[k];
            }
        }
        solve_tree(model, &self.edges, &self.joint_forces, &mut self.factors)?;
        for (factor, body) in self.factors.iter().zip(&model.bodies) {
            self.rates[body.layout.rates_elastic()].copy_from_slice(factor.elastic_accelerations());
            self.rates[body.layout.rates_joint()].copy_from_slice(factor.joint_accelerations());
        }
        if !model.loops.is_empty() {
            self.close_loops(model)?;
        }
        keep(&mut self.wrenches, self.factors.iter().map(|f| &f.joint_force));
        powers.supplied += self.prescribed_power(model);
        Ok(powers)
    }

    /// Inertia of the tree and mobility of the loops at the last motion, whatever the forces.
    ///
    /// Elastic inertia counts `elastic_weight` times.
    pub fn factorise(
        &mut self,
        model: &MultibodyModel,
        elastic_weight: f64,
    ) -> Result<(), EvaluationFailure> {
        for (i, body) in model.bodies.iter().enumerate() {
            self.factors[i].load(body, &self.states[i], &self.sums[i], &mut self.bodies[i]);
            self.factors[i].weigh_elastic(elastic_weight);
        }
        solve_tree(model, &self.edges, &self.joint_forces, &mut self.factors)?;
        self.loops.evaluate(model, &self.states);
        self.loops.factorise(model, &self.edges, &self.factors);
        Ok(())
    }

    /// Accelerations of all coordinates by a unit force on the elastic coordinate `rate`, loops aside.
    pub fn unit_response(&mut self, model: &MultibodyModel, rate: usize) -> &[f64] {
        let response = &mut self.loops.response;
        response.clear();
        response.elastic_force[rate] = 1.0;
        response.solve(model, &self.edges, &self.factors);
        &response.rates
    }

    /// Adds the forces of loop-closing joints.
    fn close_loops(&mut self, model: &MultibodyModel) -> Result<(), EvaluationFailure> {
        for ((frame, factor), state) in self.frames.iter_mut().zip(&self.factors).zip(&self.states) {
            *frame = factor.frame;
            let gravity = state.rotation.inverse_transform_vector(&model.gravity);
            frame.iter_mut().zip(gravity.iter()).for_each(|(a, g)| *a += g);
        }
        self.loops.evaluate(model, &self.states);
        self.loops.correct_accelerations(model, &self.edges, &self.factors, &self.frames, &self.rates)?;
        let response = &self.loops.response;
        self.rates.iter_mut().zip(&response.rates).for_each(|(a, b)| *a += b);
        for (factor, force) in self.factors.iter_mut().zip(&response.joint_forces) {
            factor.joint_force.iter_mut().zip(force).for_each(|(a, b)| *a += b);
        }
        self.loops.fill_wrenches(&mut self.loop_wrenches);
        Ok(())
    }

    /// Power of prescribed motion: of the joint's force less that of its springs and dampers.
    fn prescribed_power(&self, model: &MultibodyModel) -> f64 {
        let mut power = 0.0;
        for (i, body) in model.bodies.iter().enumerate() {
            for (k, coordinate) in body.joint.coordinates.iter().enumerate() {
                if coordinate.motion.is_none() {
                    continue;
                }
                let (force, moment) = split(&self.factors[i].joint_force);
                let edge = &self.edges[i];
                let column = &edge.joint.columns[k];
                let moved = column.translation - column.rotation.cross(&edge.joint.displacement);
                let along = force.dot(&moved) + moment.dot(&column.rotation);
                power += (along - self.passive[i][k]) * edge.coordinates.velocities[k];
            }
        }
        power
    }
}

/// Force and moment of a load in the inertial frame.
fn load_at(load: &Load, t: f64, state: &BodyState) -> (Vector3<f64>, Vector3<f64>) {
    let component = |i: usize| load.components[i].as_ref().map_or(0.0, |f| f.at(t)[0]);
    let (force, moment) = (Vector3::from_fn(|c, _| component(c)), Vector3::from_fn(|c, _| component(3 + c)));
    if !load.is_following {
        return (force, moment);
    }
    let axes = load.marker.orientation(state);
    (axes * force, axes * moment)
}

/// Copies the wrenches of joints, which projections and linearisations overwrite where they are found.
fn keep<'a>(wrenches: &mut [SpatialVector], found: impl Iterator<Item = &'a SpatialVector>) {
    wrenches.iter_mut().zip(found).for_each(|(kept, found)| *kept = *found);
}
