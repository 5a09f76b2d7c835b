//! Modes of a joined system as a force on some of its bodies meets them (docs/theory/uncertainty.md Eq. U.13).

use std::ops::DerefMut;

use super::small_motion::{SmallMotion, wrench};
use super::{Problem, power};
use crate::error::DynamicsError;
use crate::force::GeneralisedForce;
use crate::force::active::ActiveForce;
use crate::system::free_body::deformation::dot;
use crate::system::multibody::Multibody;
use crate::system::multibody::workspace::Workspace;
use crate::system::tree::kinematics::{SpatialVector, frame_velocities, update};

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
}

impl<F: DerefMut<Target: ActiveForce>> Multibody<F> {
    /// Modes of the structure, its bodies undeformed where they are in the state `y` at time `t`, prescribed
    /// motions held, weight and loads left out, as the forces `pushes` on bodies by index meet them.
    ///
    /// # Errors
    /// [`DynamicsError`] if the mass matrix is not positive definite or an eigenproblem cannot be solved.
    pub fn pressed_modes(
        &self,
        (t, y): (f64, &[f64]),
        pushes: &[(usize, GeneralisedForce)],
    ) -> Result<Vec<PressedMode>, DynamicsError> {
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
            PressedMode {
                squared_frequency: *value,
                damping: power(model, &workspace, &mode),
                share,
                carried,
                start: [along(&deformation), along(&rates)],
                body: most.unwrap_or_default(),
            }
        });
        Ok(modes.collect())
    }
}
