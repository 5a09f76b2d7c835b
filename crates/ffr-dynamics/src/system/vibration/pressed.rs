//! Modes of a joined system as a force on some of its bodies meets them (docs/theory/uncertainty.md Eq. U.13).

use std::ops::DerefMut;

use nalgebra::Vector3;

use super::small_motion::{SmallMotion, wrench};
use super::{Problem, power};
use crate::error::DynamicsError;
use crate::force::active::ActiveForce;
use crate::force::{BodyState, GeneralisedForce};
use crate::system::free_body::deformation::dot;
use crate::system::model::MultibodyModel;
use crate::system::multibody::Multibody;
use crate::system::multibody::workspace::Workspace;
use crate::system::reaction::Reaction;
use crate::system::tree::kinematics::{SpatialVector, frame_velocities, join, split, update};

/// A mode of a joined system, mass-orthonormal, as a force on bodies of it meets it.
#[derive(Debug, Clone, PartialEq)]
pub struct PressedMode {
    /// Squared angular frequency; zero for a rigid motion [rad²/s²].
    pub squared_frequency: f64,
    /// What dampers take from it [1/s].
    pub damping: f64,
    /// Power of the force by a unit rate of the mode.
    pub share: f64,
    /// The same on the rigid motions that carry the momenta of the bodies.
    pub carried: f64,
    /// Coordinate and rate in the state of the system.
    pub start: [f64; 2],
    /// The body that has most of its kinetic energy.
    pub body: usize,
    /// What was asked of a unit of it.
    pub observed: Vec<f64>,
}

/// What a unit of a mode, or of the forces, does in a joined system.
#[derive(Debug, Clone, Copy)]
pub struct UnitMotion<'a> {
    /// Motions of the bodies at a unit rate of the mode, undeformed; at rest of the forces.
    pub states: &'a [BodyState],
    /// Reactions of the bodies' joints by a unit acceleration of the mode, or by the forces on bodies that do not move.
    pub reactions: &'a [Reaction],
}

/// Modes of a joined system as forces meet them.
#[derive(Debug, Clone, PartialEq)]
pub struct PressedModes {
    /// The modes, their squared frequencies rising.
    pub modes: Vec<PressedMode>,
    /// What was asked of the forces on bodies that do not move.
    pub observed: Vec<f64>,
}

impl<F: DerefMut<Target: ActiveForce>> Multibody<F> {
    /// Modes of the structure, its bodies undeformed where they are in the state `y` at time `t`, prescribed
    /// motions held, weight and loads left out, as the forces `pushes` on bodies by index meet them, and what `observe` says of
    /// each. Reactions are those of trees: forces in loops are left out of them.
    ///
    /// # Errors
    /// [`DynamicsError`] if the mass matrix is not positive definite or an eigenproblem cannot be solved.
    pub fn pressed_modes(
        &self,
        (t, y): (f64, &[f64]),
        pushes: &[(usize, GeneralisedForce)],
        observe: impl Fn(UnitMotion<'_>) -> Vec<f64>,
    ) -> Result<PressedModes, DynamicsError> {
        let model = &self.model;
        let mut pose = y[..model.n_states()].to_vec();
        let n = model.n_rates();
        let (mut deformation, mut rates) = (vec![0.0; n], vec![0.0; n]);
        for body in &model.bodies {
            let layout = &body.layout;
            deformation[layout.rates_elastic()].copy_from_slice(&y[layout.elastic()]);
            rates[layout.rates_elastic()].copy_from_slice(&y[layout.elastic_rates()]);
            rates[layout.rates_joint()].copy_from_slice(&y[layout.velocities()]);
            for still in [layout.elastic(), layout.velocities(), layout.elastic_rates()] {
                pose[still].fill(0.0);
            }
        }
        let small = SmallMotion::of_structure(model, t, &pose);
        let (values, vectors) = Problem::new(&small)?.modes()?;
        let mut workspace = Workspace::new(model);
        update(model, t, &pose, &mut workspace.states, &mut workspace.edges);
        let wrenches: Vec<(usize, SpatialVector, &[f64])> = pushes
            .iter()
            .map(|(body, push)| (*body, wrench(&workspace.states[*body], push), push.elastic.as_slice()))
            .collect();
        let product = |of: Vec<f64>| -> Vec<f64> {
            (0..n).map(|i| of.iter().enumerate().map(|(j, x)| small.mass[(i, j)] * x).sum()).collect()
        };
        let (deformation, rates) = (product(deformation), product(rates));
        let mut frames = vec![[0.0; 6]; model.bodies.len()];
        let mut held = frames.clone();
        for (body, wrench, _) in &wrenches {
            held[*body].iter_mut().zip(wrench).for_each(|(sum, f)| *sum -= f);
        }
        let reactions = joint_reactions(model, &workspace, held);
        let observed = observe(UnitMotion { states: &workspace.states, reactions: &reactions });
        let mut moving = Workspace::new(model);
        let modes = values.iter().enumerate().map(|(m, value)| {
            let mode: Vec<f64> = (0..n).map(|i| vectors[(i, m)]).collect();
            let along = |momenta: &[f64]| momenta.iter().zip(&mode).map(|(p, z)| p * z).sum();
            frame_velocities(model, &workspace.edges, &mode, &mut frames);
            let (rigid, _) = small.momenta_of(model, &frames, &mode);
            let energies = small.energies(model, &workspace.edges, &mode);
            let (mut share, mut carried) = (0.0, 0.0);
            for (body, wrench, elastic) in &wrenches {
                let own = &mode[model.bodies[*body].layout.rates_elastic()];
                share += dot(wrench, &frames[*body]);
                share += elastic.iter().zip(own).map(|(f, z)| f * z).sum::<f64>();
                carried += dot(wrench, &small.carrying(*body, &rigid[*body]));
            }
            let most = (0..energies.len()).max_by(|a, b| energies[*a].total_cmp(&energies[*b]));
            for body in &model.bodies {
                let layout = &body.layout;
                pose[layout.velocities()].copy_from_slice(&mode[layout.rates_joint()]);
                pose[layout.elastic_rates()].copy_from_slice(&mode[layout.rates_elastic()]);
            }
            update(model, t, &pose, &mut moving.states, &mut moving.edges);
            let reactions = joint_reactions(model, &workspace, rigid);
            PressedMode {
                squared_frequency: *value,
                damping: power(model, &workspace, &mode),
                share,
                carried,
                start: [along(&deformation), along(&rates)],
                body: most.unwrap_or_default(),
                observed: observe(UnitMotion { states: &moving.states, reactions: &reactions }),
            }
        });
        let modes = modes.collect();
        Ok(PressedModes { modes, observed })
    }
}

/// Reactions of the joints of a tree that change the momenta of its bodies by `wrenches`, in the axes of the bodies (Eq. M.52).
fn joint_reactions(
    model: &MultibodyModel,
    workspace: &Workspace,
    mut wrenches: Vec<SpatialVector>,
) -> Vec<Reaction> {
    let none = Reaction { force: Vector3::zeros(), moment: Vector3::zeros() };
    let mut found = vec![none; wrenches.len()];
    for &i in model.order.iter().rev() {
        let edge = &workspace.edges[i];
        let (force, moment) = split(&wrenches[i]);
        let (force, moment) = (edge.turn.tr_mul(&force), edge.turn.tr_mul(&moment));
        let moment = moment + edge.lever.cross(&force);
        if let Some(p) = model.bodies[i].joint.parent.body {
            edge.add_at_parent(&join(&force, &moment), &mut wrenches[p], &mut []);
        }
        found[i] = Reaction { force, moment: moment - edge.joint.displacement.cross(&force) };
    }
    found
}
