//! Flexible multibody systems in joint and elastic coordinates (docs/theory.md Eq. M.12 to M.42).
//!
//! Bodies form a tree, so that the equations are ordinary ones without drift; loop-closing joints
//! add constraints.

pub mod error_scale;
pub(super) mod free_vibration;
pub(super) mod workspace;
pub mod apart;
mod derivative;

use std::ops::DerefMut;

use faer::c64;
use nalgebra::Vector3;

use super::free_body::uncoupled_modes::UncoupledModes;
use super::joints::forces::joint_energy;
use super::model::specification::SystemSpec;
use super::model::{JointCoordinates, MultibodyModel, TreeBody, check_damping};
use super::tree::error::TreeNorm;
use super::tree::stage_solver::StageSolver;
use crate::body::ModalDamping;
use crate::data_error::DataError;
use crate::error::{DynamicsError, EvaluationFailure};
use crate::force::active::ActiveForce;
use crate::force::{BodyState, GeneralisedForce, Motion};
use crate::integration::{KinematicBlock, Linearisation, OdeSystem, Oscillator, Oscillators};
use crate::kinematics::Marker;
use crate::rotation::renormalise;
use crate::system::free_body::invariants::{Invariants, centre_of_mass};
use apart::Apart;
use error_scale::ErrorScale;
use free_vibration::oscillators;
use workspace::{Powers, Workspace};

/// A multibody system under force elements, as a system of ordinary differential equations.
///
/// The state vector holds body by body joint positions, `q_e`, joint velocities, `dq_e/dt`
/// ([`super::model::TreeLayout`]); then the quadratures: dissipated work, supplied work, and the
/// impulse (3) of each force element; then the internal coordinates of the force elements, each
/// element's followed by their rates.
///
/// `F` holds a force element at work: a box of one, or something around it.
pub struct Multibody<F = Box<dyn ActiveForce>> {
    pub(super) model: MultibodyModel,
    forces: Vec<F>,
    error_scale: ErrorScale,
    pub(super) workspace: Workspace,
    pub(super) norm: TreeNorm,
    oscillators: Vec<Oscillator>,
    stages: StageSolver,
    apart: Apart,
}

impl<F: DerefMut<Target: ActiveForce>> Multibody<F> {
    /// A system from its description and force elements, which number the bodies as `spec` does.
    ///
    /// # Errors
    /// See [`MultibodyModel::new`].
    pub fn new(spec: SystemSpec, forces: Vec<F>) -> Result<Self, DynamicsError> {
        let model = MultibodyModel::new(spec)?;
        let workspace = Workspace::new(&model);
        let norm = TreeNorm::new(&model, &workspace.states, &workspace.edges)?;
        let oscillators = oscillators(&model);
        let stages = StageSolver::new(&model);
        let (error_scale, apart) = (ErrorScale::default(), Apart::new(forces.len(), model.bodies.len()));
        Ok(Self { model, forces, error_scale, workspace, norm, oscillators, stages, apart })
    }

    /// Replaces the bodies by other models of them with as many coordinates; force elements and
    /// tolerances stay. States keep their places, but elastic coordinates belong to the new modes.
    ///
    /// # Errors
    /// See [`MultibodyModel::new`]. The system is then as before.
    ///
    /// # Panics
    /// If states would have other places.
    pub fn replace_model(&mut self, spec: SystemSpec) -> Result<(), DynamicsError> {
        let model = MultibodyModel::new(spec)?;
        let layouts = |model: &MultibodyModel| model.bodies.iter().map(|b| b.layout).collect::<Vec<_>>();
        assert_eq!(
            layouts(&model),
            layouts(&self.model),
            "models that replace each other have the same coordinates"
        );
        let workspace = Workspace::new(&model);
        self.norm = TreeNorm::new(&model, &workspace.states, &workspace.edges)?;
        self.oscillators = oscillators(&model);
        self.stages = StageSolver::new(&model);
        self.apart.forget();
        (self.model, self.workspace) = (model, workspace);
        Ok(())
    }

    /// Gives body `body` another damping.
    pub(super) fn replace_damping(
        &mut self,
        body: usize,
        damping: ModalDamping,
    ) -> Result<(), DynamicsError> {
        let changed = &mut self.model.bodies[body];
        changed.data.modal_damping = damping;
        check_damping(&changed.name, &changed.data)?;
        changed.modes = UncoupledModes::new(&changed.data)?;
        self.oscillators = oscillators(&self.model);
        self.norm.forget();
        Ok(())
    }

    /// The model.
    pub fn model(&self) -> &MultibodyModel {
        &self.model
    }

    /// The force elements.
    pub fn forces(&self) -> &[F] {
        &self.forces
    }

    /// Which force elements may have found anything in the last evaluation; the others found no energy and no force.
    pub fn found(&self) -> impl Iterator<Item = usize> {
        self.apart.found(self.forces.len())
    }

    /// The force elements, to be changed. Tell the integrator
    /// ([`crate::integration::Integrator::invalidate`]).
    pub fn forces_mut(&mut self) -> &mut [F] {
        self.apart.forget();
        &mut self.forces
    }

    /// The model, and the force elements to be evaluated.
    pub(super) fn parts(&mut self) -> (&MultibodyModel, &mut [F]) {
        self.apart.forget();
        (&self.model, &mut self.forces)
    }

    /// Tolerances of the error norm.
    pub fn error_scale(&self) -> ErrorScale {
        self.error_scale
    }

    /// Changes the tolerances of the error norm.
    ///
    /// # Errors
    /// [`DynamicsError::Data`] if one is not positive.
    pub fn set_error_scale(&mut self, scale: ErrorScale) -> Result<(), DynamicsError> {
        self.error_scale = scale.checked()?;
        self.norm.forget();
        Ok(())
    }

    /// Highest eigenfrequency of the free bodies, above which no frequency of the joined system
    /// lies \[Hz\].
    ///
    /// Joints between bodies of the same modes only move frequencies between those of the free
    /// bodies (Rayleigh). Stiff joint springs are not counted.
    pub fn highest_frequency(&self) -> f64 {
        self.norm.highest_frequency() / std::f64::consts::TAU
    }

    /// State with all joint coordinates at zero, undeformed, at rest, quadratures at zero.
    pub fn rest(&self) -> Vec<f64> {
        let mut y = vec![0.0; self.dimension()];
        for TreeBody { joint, layout, .. } in &self.model.bodies {
            if let Some(w) = joint.kind.quaternion() {
                y[layout.offset + w] = 1.0;
            }
        }
        y
    }

    /// Sets the free coordinates of the joint of body `body`, in the order of
    /// [`super::joints::JointKind`].
    ///
    /// # Errors
    /// [`DynamicsError::Joint`] if there are too few or too many, or a number is not finite.
    pub fn set_joint(
        &self,
        y: &mut [f64],
        body: usize,
        positions: &[f64],
        velocities: &[f64],
    ) -> Result<(), DynamicsError> {
        let TreeBody { joint, layout, .. } = &self.model.bodies[body];
        let fail = |fault: String| Err(DynamicsError::Joint { joint: joint.name.clone(), fault });
        if positions.len() != layout.n_positions || velocities.len() != layout.n_velocities {
            return fail(format!(
                "{positions} positions and {velocities} velocities, the {kind} joint has {n_positions} and {n_velocities} that are not prescribed",
                positions = positions.len(),
                velocities = velocities.len(),
                kind = joint.kind.name(),
                n_positions = layout.n_positions,
                n_velocities = layout.n_velocities
            ));
        }
        if !positions.iter().chain(velocities).all(|x| x.is_finite()) {
            return fail("a coordinate or velocity is not finite".into());
        }
        y[layout.positions()].copy_from_slice(positions);
        y[layout.velocities()].copy_from_slice(velocities);
        if let Some(w) = joint.kind.quaternion() {
            let quaternion = &mut y[layout.offset + w..layout.offset + w + 4];
            if quaternion.iter().all(|c| *c == 0.0) {
                return fail("the quaternion is zero".into());
            }
            renormalise(quaternion);
        }
        Ok(())
    }

    /// Sets the elastic coordinates of a body and their rates.
    ///
    /// # Errors
    /// [`DynamicsError::Data`] if their numbers are wrong, or a number is not finite.
    pub fn set_elastic(
        &self,
        y: &mut [f64],
        body: usize,
        elastic: &[f64],
        rates: &[f64],
    ) -> Result<(), DynamicsError> {
        let TreeBody { name, layout, .. } = &self.model.bodies[body];
        for values in [elastic, rates] {
            let what = format!("elastic coordinates or rates of body \"{name}\"");
            if values.len() != layout.n_modes {
                return Err(DataError::Count { what, found: values.len(), expected: layout.n_modes }.into());
            }
            if !values.iter().all(|v| v.is_finite()) {
                return Err(DataError::NotFinite { what }.into());
            }
        }
        y[layout.elastic()].copy_from_slice(elastic);
        y[layout.elastic_rates()].copy_from_slice(rates);
        Ok(())
    }

    /// Coordinates of the joint of body `body`, prescribed ones included.
    pub fn joint_coordinates(&self, t: f64, y: &[f64], body: usize) -> JointCoordinates {
        self.model.joint_coordinates(body, t, y)
    }

    /// Motions of all bodies at time `t` in the state `y`. Does not allocate.
    pub fn body_states(&mut self, t: f64, y: &[f64]) -> &[BodyState] {
        self.workspace.place(&self.model, t, y);
        &self.workspace.states
    }

    /// Places the two bodies of a force element and those that `fixed` joints connect with them at time `t` in the state
    /// `y`; others stay where they are, but for those that these hang on.
    pub fn place_pair(&mut self, t: f64, y: &[f64], (body, target): (usize, Option<usize>)) {
        for body in [Some(body), target].into_iter().flatten().flat_map(|body| self.model.fixed_to(body)) {
            self.workspace.place_body(&self.model, (t, y), body);
        }
    }

    /// Evaluates motions and forces, so that energies and resultants of force elements belong to
    /// `y`. Does not allocate.
    ///
    /// # Errors
    /// [`EvaluationFailure`] of a force element.
    pub fn evaluate_forces(&mut self, t: f64, y: &[f64]) -> Result<(), EvaluationFailure> {
        self.workspace.place(&self.model, t, y);
        let mut start = self.n_without_internal();
        let Workspace { states, sums, .. } = &mut self.workspace;
        let mut evaluate = |force: &mut F| {
            let end = start + 2 * force.n_coordinates();
            let motion = Motion { time: t, bodies: states, internal: &y[start..end] };
            start = end;
            force.evaluate(motion, sums)
        };
        // Those left out have no internal coordinates.
        if let Some(near) = self.apart.near(states, 0.0) {
            near.iter().try_for_each(|i| evaluate(&mut self.forces[*i]))?;
        } else {
            self.apart.forget();
            self.forces.iter_mut().try_for_each(evaluate)?;
            let forces = &self.forces;
            let clearance = |i: usize| forces[i].clearance(states).filter(|_| !forces[i].notes_motions());
            self.apart.sort(forces.len(), states, clearance);
        }
        self.workspace.add_loads(&self.model);
        Ok(())
    }

    /// Evaluates motions, forces and accelerations, so that reactions of joints belong to `y`, too.
    /// Does not allocate.
    ///
    /// # Errors
    /// [`EvaluationFailure`] of a force element, or of the equations of motion.
    pub fn evaluate_accelerations(&mut self, t: f64, y: &[f64]) -> Result<(), EvaluationFailure> {
        self.evaluate(t, y).map(|_| ())
    }

    /// Motions and forces of the bodies at the last evaluation.
    pub fn last_evaluation(&self) -> (&[BodyState], &[GeneralisedForce]) {
        (&self.workspace.states, &self.workspace.sums)
    }

    /// Energies of the bodies and momenta at time `t` in the state `y`, without joint springs. Does
    /// not allocate.
    pub fn invariants(&mut self, t: f64, y: &[f64]) -> Invariants {
        self.workspace.place(&self.model, t, y);
        let mut sum = Invariants::default();
        for (body, state) in self.model.bodies.iter().zip(&self.workspace.states) {
            sum += Invariants::of_body(&body.data, state, &self.model.gravity);
        }
        sum
    }

    /// Energy in joint springs \[J\].
    pub fn joint_energy(&self, t: f64, y: &[f64]) -> f64 {
        let energy = |(i, b): (usize, &TreeBody)| {
            joint_energy(b.joint.kind, &b.joint.coordinates, &self.model.joint_coordinates(i, t, y).positions)
        };
        self.model.bodies.iter().enumerate().map(energy).sum()
    }

    /// Centre of mass of the deformed body `body`, in the inertial frame \[m\].
    pub fn centre_of_mass(&mut self, t: f64, y: &[f64], body: usize) -> Vector3<f64> {
        self.workspace.place(&self.model, t, y);
        centre_of_mass(&self.model.bodies[body].data, &self.workspace.states[body])
    }

    /// Work lost to modal damping, joint dampers and in force elements since the start \[J\].
    pub fn dissipated_work(&self, y: &[f64]) -> f64 {
        y[self.model.n_states()]
    }

    /// Work supplied by loads, drives and prescribed motion since the start \[J\].
    pub fn supplied_work(&self, y: &[f64]) -> f64 {
        y[self.model.n_states() + 1]
    }

    /// Time integral of the resultant of force element `element` since the start [N s].
    pub fn impulse(&self, y: &[f64], element: usize) -> Vector3<f64> {
        let start = self.model.n_states() + 2 + 3 * element;
        Vector3::from_column_slice(&y[start..start + 3])
    }

    /// Length of the state without the coordinates that are internal to force elements.
    fn n_without_internal(&self) -> usize {
        self.model.n_states() + 2 + 3 * self.forces.len()
    }

    /// Places in the state of the coordinates, and their rates, that are internal to force
    /// elements.
    fn internal_coordinates(&self) -> impl Iterator<Item = std::ops::Range<usize>> {
        let mut end = self.n_without_internal();
        self.forces.iter().map(move |force| {
            let start = end;
            end += 2 * force.n_coordinates();
            start..end
        })
    }

    /// The place in the state of the coordinates, and their rates, that are internal to force
    /// element `element`.
    pub fn coordinates_of_force(&self, element: usize) -> std::ops::Range<usize> {
        self.internal_coordinates().nth(element).unwrap_or_default()
    }

    /// Force element `element`, to be asked at time `t` in the state `y`, and the motion there.
    /// Does not allocate.
    pub fn force_in_motion<'a>(
        &'a mut self,
        t: f64,
        y: &'a [f64],
        element: usize,
    ) -> (&'a mut F, Motion<'a>) {
        self.workspace.place(&self.model, t, y);
        self.force_as_placed(y, element)
    }

    /// As [`Multibody::force_in_motion`] in the state `y` that the bodies were placed in last, by
    /// [`Multibody::body_states`] for instance. It is asked, not changed or evaluated:
    /// [`Multibody::forces_mut`] is for that.
    pub fn force_as_placed<'a>(&'a mut self, y: &'a [f64], element: usize) -> (&'a mut F, Motion<'a>) {
        let none = y.len() == self.n_without_internal();
        let internal = if none { &[] } else { &y[self.coordinates_of_force(element)] };
        let (time, bodies) = (self.workspace.time, self.workspace.states.as_slice());
        (&mut self.forces[element], Motion { time, bodies, internal })
    }

    /// Velocity that carries the energy of the internal coordinates of the force elements in `y`
    /// [m/s].
    fn internal_speed(&self, y: &[f64]) -> f64 {
        let n = if y.len() == self.n_without_internal() { 0 } else { self.forces.len() };
        let parts = self.forces.iter().zip(self.internal_coordinates()).take(n);
        parts.map(|(force, place)| force.coordinate_speed(&y[place]).powi(2)).sum::<f64>().sqrt()
    }

    /// Marker `marker` of body `body`, by name.
    pub fn marker(&self, body: &str, marker: &str) -> Option<(usize, &Marker)> {
        let i = self.model.body_index(body)?;
        self.model.bodies[i].markers.iter().find(|m| m.name == marker).map(|m| (i, m))
    }

    /// Largest residual of the loop-closing joints and gears in the state `y` [m or rad]. Does not
    /// allocate.
    pub fn loop_residual(&mut self, t: f64, y: &[f64]) -> f64 {
        self.workspace.place(&self.model, t, y);
        let Workspace { loops, states, edges, .. } = &mut self.workspace;
        loops.evaluate(&self.model, states, edges);
        self.workspace.loops.largest_residual()
    }

    /// Constraints of the loop-closing joints and gears, and how many of them are independent at
    /// the last right-hand side.
    pub fn loop_constraints(&self) -> (usize, usize) {
        (self.workspace.loops.n_constraints(), self.workspace.loops.rank())
    }

    fn evaluate(&mut self, t: f64, y: &[f64]) -> Result<Powers, EvaluationFailure> {
        self.evaluate_forces(t, y)?;
        self.workspace.accelerate(&self.model)
    }
}

impl<F: DerefMut<Target: ActiveForce>> OdeSystem for Multibody<F> {
    fn dimension(&self) -> usize {
        self.n_without_internal() + self.forces.iter().map(|f| 2 * f.n_coordinates()).sum::<usize>()
    }

    fn rhs(&mut self, t: f64, y: &[f64], dydt: &mut [f64]) -> Result<(), EvaluationFailure> {
        let mut powers = self.evaluate(t, y)?;
        for TreeBody { joint, layout, .. } in &self.model.bodies {
            let (positions, velocities) = (&y[layout.positions()], &y[layout.velocities()]);
            joint.kind.position_rates(positions, velocities, &mut dydt[layout.positions()]);
            dydt[layout.elastic()].copy_from_slice(&y[layout.elastic_rates()]);
            dydt[layout.velocities()]
                .copy_from_slice(&self.workspace.accelerations.rates[layout.rates_joint()]);
            dydt[layout.elastic_rates()]
                .copy_from_slice(&self.workspace.accelerations.rates[layout.rates_elastic()]);
        }
        let n = self.model.n_states();
        let end = self.n_without_internal();
        dydt[n + 2..end].fill(0.0);
        for i in self.found() {
            let force = &self.forces[i];
            powers.dissipated += force.energies().integrated_power();
            dydt[n + 2 + 3 * i..n + 5 + 3 * i].copy_from_slice(force.resultant().as_slice());
        }
        dydt[n] = powers.dissipated;
        dydt[n + 1] = powers.supplied;
        let internal = if y.len() == end { 0 } else { self.forces.len() };
        for (force, place) in self.forces.iter().zip(self.internal_coordinates()).take(internal) {
            let middle = place.start + place.len() / 2;
            dydt[place.start..middle].copy_from_slice(&y[middle..place.end]);
            dydt[middle..place.end].copy_from_slice(force.accelerations());
        }
        Ok(())
    }

    fn error_norm(&mut self, y0: &[f64], y1: &[f64], error: &[f64]) -> f64 {
        let (internal, norm) = (self.internal_speed(error), &mut self.norm);
        // Prescribed motion enters with the time of the last evaluation, which is the end of the
        // step.
        let t = self.workspace.time;
        let speed = norm.speed_at_start(&self.model, t, y0);
        let motion = norm.speed(&self.model, t, y1).max(speed).max(self.error_scale.velocity_floor);
        norm.error_speed(&self.model, error, motion).hypot(internal) / (self.error_scale.relative * motion)
    }

    fn damped_error_norm(&mut self, y0: &[f64], y1: &[f64], error: &[f64]) -> f64 {
        let (internal, norm) = (self.internal_speed(error), &mut self.norm);
        let t = self.workspace.time;
        let start = norm.speed_at_start(&self.model, t, y0).max(self.error_scale.velocity_floor);
        let motion = norm.speed(&self.model, t, y1).max(start);
        norm.damped_error_speed(&self.model, (t, y0, start), error, motion).hypot(internal)
            / (self.error_scale.relative * motion)
    }

    fn next_break(&self, t: f64) -> f64 {
        self.model.next_break(t)
    }

    fn longest_step(&self, t: f64) -> f64 {
        self.model.longest_step(t)
    }

    fn change_of_form(&self, t: f64, y0: &[f64], y1: &[f64], h: f64) -> Option<f64> {
        self.model.change_of_form(t, y0, y1, h)
    }

    fn has_memory(&self) -> bool {
        !self.forces.is_empty()
    }

    fn oscillators(&self) -> Oscillators<'_> {
        Oscillators { list: &self.oscillators, dissipated: Some(self.model.n_states()) }
    }

    fn supply(&mut self, t: f64, y: &[f64], forces: &mut [f64]) -> Option<usize> {
        if self.model.loads.is_empty() {
            return None;
        }
        self.workspace.place(&self.model, t, y);
        self.workspace.add_loads(&self.model);
        let mut oscillators = self.oscillators.iter().zip(forces).peekable();
        for (body, sum) in self.model.bodies.iter().zip(&self.workspace.sums) {
            let rates = body.layout.elastic_rates();
            while let Some((o, force)) = oscillators.next_if(|(o, _)| rates.contains(&o.velocity)) {
                *force = sum.elastic[o.velocity - rates.start];
            }
        }
        Some(self.model.n_states() + 1)
    }

    fn kinematics(&self) -> Vec<KinematicBlock> {
        let internal = self.internal_coordinates().filter(|place| !place.is_empty()).map(|place| {
            let len = place.len() / 2;
            KinematicBlock::Vector { position: place.start, velocity: place.start + len, len }
        });
        self.model.bodies.iter().flat_map(TreeBody::kinematics).chain(internal).collect()
    }

    fn linearise(
        &mut self,
        t: f64,
        y: &[f64],
        derivative: &mut Linearisation,
    ) -> Result<(), EvaluationFailure> {
        self.evaluate(t, y)?;
        if !self.model.has_constraints() {
            self.workspace.linearise(&self.model, &mut self.forces, derivative);
        }
        Ok(()) // what loops couple, differences find out
    }

    fn hold(&mut self) -> bool {
        let is_tree = !self.model.has_constraints()
            && self.forces.iter().all(|force| force.is_idle() && force.n_coordinates() == 0);
        if is_tree {
            self.stages.hold(&self.model, &self.workspace.edges, &self.workspace.bodies);
        }
        is_tree
    }

    fn factorise_held(&mut self, pair: usize, weight: c64) -> bool {
        self.stages.factorise(&self.model, pair, weight)
    }

    fn solve_held(&mut self, pair: usize, x: &mut [c64], scale: c64, motion: &[f64]) {
        self.stages.solve(&self.model, pair, x, (scale, motion));
    }

    fn project(&mut self, t: f64, y: &mut [f64]) -> bool {
        let mut has_changed = false;
        for TreeBody { joint, layout, .. } in &self.model.bodies {
            if let Some(w) = joint.kind.quaternion() {
                has_changed |= renormalise(&mut y[layout.offset + w..layout.offset + w + 4]);
            }
        }
        if self.model.has_constraints() {
            // The forces of the last evaluation are those of the step, which closing changes in the last digits.
            let Workspace { sums, spare_sums, .. } = &mut self.workspace;
            std::mem::swap(sums, spare_sums);
            has_changed |= self.close_loops(t, y);
            let Workspace { sums, spare_sums, .. } = &mut self.workspace;
            std::mem::swap(sums, spare_sums);
        }
        has_changed
    }

    fn finish_quadratures(&mut self, y: &mut [f64], rate: &mut [f64]) {
        // Work of sliding goes to the dissipated work; the next step starts where nothing has slid
        // yet: there `slid` grows with the power of sliding.
        let k = self.model.n_states();
        for i in self.apart.found(self.forces.len()) {
            let energies = self.forces[i].energies();
            y[k] += energies.slid;
            rate[k] += energies.slid_rate - energies.sliding_power;
        }
    }

    fn save(&mut self) {
        self.forces.iter_mut().for_each(|force| force.save());
    }

    fn restore(&mut self) {
        self.forces.iter_mut().for_each(|force| force.restore());
    }
}
