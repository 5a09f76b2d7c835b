//! Buffers of a multibody system, and the evaluation of motions and accelerations in them.

use nalgebra::Vector3;

use crate::error::EvaluationFailure;
use crate::force::{BodyState, GeneralisedForce};
use crate::system::free_body::equations::{BodyWorkspace, RigidPart};
use crate::system::joints::forces::joint_forces;
use crate::system::loops::closure::LoopSolver;
use crate::system::model::{Load, MultibodyModel, TreeBody};
use crate::system::tree::bearings::BearingSolver;
use crate::system::tree::kinematics::{JointKinematics, SpatialVector, split, update, update_body};
use crate::system::tree::solver::{Answer, FactorisedTree, Impedance, TreeFactors, TreePose};

/// Power that goes in and out of a system at one instant \[W\].
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(in crate::system) struct Powers {
    /// Lost in modal damping and joint dampers.
    pub dissipated: f64,
    /// Supplied by loads, drives and prescribed motion.
    pub supplied: f64,
}

/// Buffers of a multibody system.
#[derive(Debug, Clone)]
pub(in crate::system) struct Workspace {
    pub states: Vec<BodyState>,
    pub sums: Vec<GeneralisedForce>,
    /// In its place while motions are corrected, which does not ask for forces.
    pub spare_sums: Vec<GeneralisedForce>,
    /// Bodies that move along one coordinate, and the rates of all coordinates then.
    pub moving: Vec<BodyState>,
    pub direction: Vec<f64>,
    /// Force elements that act then.
    pub acting: Vec<usize>,
    pub edges: Vec<JointKinematics>,
    pub(in crate::system) bodies: Vec<BodyWorkspace>,
    pub pose: TreePose,
    pub factors: TreeFactors<f64>,
    /// Forces on all bodies at the last evaluation, accelerations of all coordinates, wrenches of
    /// the tree's joints.
    pub accelerations: Answer<f64>,
    pub loops: LoopSolver,
    bearings: BearingSolver,
    /// Forces of springs, dampers, stops and friction along the velocities of joints.
    passive: Vec<SpatialVector>,
    /// Accelerations of the frames, without gravity's offset.
    pub frames: Vec<SpatialVector>,
    /// Wrenches of loop-closing joints on their children at the children's markers, in inertial
    /// axes.
    pub loop_wrenches: Vec<SpatialVector>,
    /// Forces of gears along their second coordinates.
    pub gear_forces: Vec<f64>,
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
            spare_sums: model.bodies.iter().map(|b| GeneralisedForce::zeros(b.layout.n_modes)).collect(),
            moving: states.clone(),
            direction: vec![0.0; model.n_rates()],
            acting: Vec::new(),
            edges: model.bodies.iter().map(edge).collect(),
            bodies: model.bodies.iter().map(|b| BodyWorkspace::new(&b.data, &b.deformation)).collect(),
            pose: TreePose::new(model),
            factors: TreeFactors::new(model),
            accelerations: Answer::new(model),
            loops: LoopSolver::new(model, &states),
            bearings: BearingSolver::new(model),
            passive: vec![[0.0; 6]; n],
            frames: vec![[0.0; 6]; n],
            loop_wrenches: vec![[0.0; 6]; model.loops.len()],
            gear_forces: vec![0.0; model.gears.len()],
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

    /// Motions of `body`, and of those that it hangs on before it, alone.
    pub fn place_body(&mut self, model: &MultibodyModel, (t, y): (f64, &[f64]), body: usize) {
        if let Some(parent) = model.bodies[body].joint.parent.body {
            self.place_body(model, (t, y), parent);
        }
        self.time = t;
        update_body(model, (t, y), body, &mut self.states, &mut self.edges);
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
        let mut powers = Powers { dissipated: self.assemble(model), supplied: self.load_power };
        for (i, body) in model.bodies.iter().enumerate() {
            let joint = &body.joint;
            if joint.coordinates.is_empty() {
                if joint.bearing.is_some() {
                    self.accelerations.forces[body.layout.rates_joint()].fill(0.0);
                    self.passive[i] = [0.0; 6];
                }
                continue; // the slots of others stay zero
            }
            let at = &self.edges[i].coordinates;
            let n = joint.kind.n_velocities();
            let forces =
                joint_forces(joint.kind, &joint.coordinates, self.time, &at.positions, &at.velocities[..n]);
            powers.dissipated += forces.dissipated;
            self.passive[i] = forces.passive;
            let slots = &mut self.accelerations.forces[body.layout.rates_joint()];
            for (slot, k) in slots.iter_mut().zip(joint.free_velocities()) {
                *slot = forces.passive[k] + forces.drive[k];
                powers.supplied += forces.drive[k] * at.velocities[k];
            }
        }
        self.eliminate(model, 1.0)?;
        self.answer(model)?;
        if !self.bearings.bearings.is_empty() {
            powers.dissipated += self.slide(model)?;
        }
        powers.supplied += self.prescribed_power(model);
        Ok(powers)
    }

    /// Accelerations under the forces collected, with loops and gears closed.
    fn answer(&mut self, model: &MultibodyModel) -> Result<(), EvaluationFailure> {
        let tree = FactorisedTree { model, pose: &self.pose, factors: &self.factors };
        self.accelerations.solve(tree, Some(&model.gravity));
        if model.has_constraints() {
            self.close_loops(model)?;
        }
        Ok(())
    }

    /// Adds the friction of bearings by the loads that the joints transmit with it; returns the
    /// power lost \[W\] (Eq. M.19).
    fn slide(&mut self, model: &MultibodyModel) -> Result<f64, EvaluationFailure> {
        let Self { bearings, edges, loops, .. } = self;
        bearings.start(edges, &self.accelerations.wrenches);
        let tree = FactorisedTree { model, pose: &self.pose, factors: &self.factors };
        for j in 0..bearings.bearings.len() {
            let at = &bearings.bearings[j];
            if at.sliding.power == 0.0 {
                continue;
            }
            let TreeBody { joint, layout, .. } = &model.bodies[at.body];
            loops.response.clear();
            let slots = &mut loops.response.forces[layout.rates_joint()];
            slots.iter_mut().zip(joint.free_velocities()).for_each(|(slot, k)| *slot = at.friction(k, 1.0));
            loops.response.solve(tree, None);
            bearings.add_response(j, edges, &loops.response.wrenches);
            if model.has_constraints() {
                loops.hold_response(tree);
                bearings.add_response(j, edges, &loops.response.wrenches);
            }
        }
        bearings.solve(model)?;
        let mut dissipated = 0.0;
        for at in &bearings.bearings {
            let TreeBody { joint, layout, .. } = &model.bodies[at.body];
            let slots = &mut self.accelerations.forces[layout.rates_joint()];
            for (slot, k) in slots.iter_mut().zip(joint.free_velocities()) {
                *slot += at.friction(k, at.load);
            }
            for (k, passive) in self.passive[at.body].iter_mut().enumerate() {
                *passive += at.friction(k, at.load);
            }
            dissipated += at.dissipated();
            edges[at.body].bearing_load = at.load;
        }
        self.answer(model)?;
        Ok(dissipated)
    }

    /// Inertia of all bodies and the forces on them (Eq. D.7); returns the power lost in modal
    /// damping \[W\].
    fn assemble(&mut self, model: &MultibodyModel) -> f64 {
        let mut dissipated = 0.0;
        for (i, body) in model.bodies.iter().enumerate() {
            let workspace = &mut self.bodies[i];
            let (RigidPart { force, .. }, power) =
                workspace.assemble((&body.data, &body.deformation), &self.states[i], &self.sums[i]);
            dissipated += power;
            self.accelerations.frame_forces[i] = force;
            let elastic = &mut self.accelerations.forces[body.layout.rates_elastic()];
            elastic.copy_from_slice(workspace.elastic_part().1);
        }
        dissipated
    }

    /// Factors of the tree; elastic inertia counts `elastic_weight` times.
    fn eliminate(&mut self, model: &MultibodyModel, elastic_weight: f64) -> Result<(), EvaluationFailure> {
        self.pose.load(model, &self.edges, &self.bodies);
        let joints = Impedance::of_inertia();
        let modes = Impedance { inertia: elastic_weight, ..joints };
        self.factors.factorise(model, &self.pose, |_| modes, &joints)
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
            self.bodies[i].assemble((&body.data, &body.deformation), &self.states[i], &self.sums[i]);
        }
        self.eliminate(model, elastic_weight)?;
        self.loops.evaluate(model, &self.states, &self.edges);
        self.loops.factorise(FactorisedTree { model, pose: &self.pose, factors: &self.factors });
        Ok(())
    }

    /// Adds the forces of loop-closing joints.
    fn close_loops(&mut self, model: &MultibodyModel) -> Result<(), EvaluationFailure> {
        let found = &mut self.accelerations;
        for ((frame, found), state) in self.frames.iter_mut().zip(&found.frames).zip(&self.states) {
            *frame = *found;
            let gravity = state.rotation.inverse_transform_vector(&model.gravity);
            frame.iter_mut().zip(gravity.iter()).for_each(|(a, g)| *a += g);
        }
        self.loops.evaluate(model, &self.states, &self.edges);
        let tree = FactorisedTree { model, pose: &self.pose, factors: &self.factors };
        self.loops.correct_accelerations(tree, &self.frames, &found.rates)?;
        let response = &self.loops.response;
        found.rates.iter_mut().zip(&response.rates).for_each(|(a, b)| *a += b);
        for (wrench, change) in found.wrenches.iter_mut().zip(&response.wrenches) {
            wrench.iter_mut().zip(change).for_each(|(a, b)| *a += b);
        }
        self.loops.fill_wrenches(&mut self.loop_wrenches);
        self.gear_forces.copy_from_slice(self.loops.gear_forces());
        Ok(())
    }

    /// Power of prescribed motion: of the joint's force less that of its springs, dampers and
    /// gears.
    fn prescribed_power(&self, model: &MultibodyModel) -> f64 {
        let mut power = -self.loops.prescribed_power(model, &self.edges);
        for (i, body) in model.bodies.iter().enumerate() {
            for (k, coordinate) in body.joint.coordinates.iter().enumerate() {
                if coordinate.motion.is_none() {
                    continue;
                }
                let (force, moment) = split(&self.accelerations.wrenches[i]);
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
