//! What is left of an error of velocities when ringing counts by its displacement only
//! (docs/theory.md Eq. M.49).
//!
//! Fast vibration of a joined system moves joints and frames as well as elastic coordinates, and no
//! body's own modes tell it apart from slow motion. Its elastic inertia enlarged by `K_e / ν²`, the
//! tree does: what it keeps of a mode of frequency `ω` is `ν² / (ν² + ω²)`, without a mode ever
//! being computed.

use super::kinematics::{JointKinematics, update};
use super::solver::{Answer, FactorisedTree, Impedance, TreeFactors, TreePose};
use crate::force::{BodyState, GeneralisedForce};
use crate::system::free_body::equations::BodyWorkspace;
use crate::system::model::MultibodyModel;

/// The filter with the factors of one state.
#[derive(Debug, Clone)]
pub(super) struct ErrorFilter {
    states: Vec<BodyState>,
    edges: Vec<JointKinematics>,
    bodies: Vec<BodyWorkspace>,
    pose: TreePose,
    factors: TreeFactors<f64>,
    response: Answer<f64>,
    no_forces: Vec<GeneralisedForce>,
    /// Frequency above which a body's motion counts as ringing [rad/s].
    rates: Vec<f64>,
    /// State of the factors; empty or not a number if there are none.
    key: Vec<f64>,
    is_sound: bool,
}

impl ErrorFilter {
    pub fn new(model: &MultibodyModel, states: &[BodyState], edges: &[JointKinematics]) -> Self {
        Self {
            states: states.to_vec(),
            edges: edges.to_vec(),
            bodies: model.bodies.iter().map(|b| BodyWorkspace::new(&b.data, &b.deformation)).collect(),
            pose: TreePose::new(model),
            factors: TreeFactors::new(model),
            response: Answer::new(model),
            no_forces: model.bodies.iter().map(|b| GeneralisedForce::zeros(b.layout.n_modes)).collect(),
            rates: vec![0.0; model.bodies.len()],
            key: vec![f64::NAN; model.n_states()],
            is_sound: false,
        }
    }

    /// Forgets the factors.
    pub fn forget(&mut self) {
        self.key.fill(f64::NAN);
        self.is_sound = false;
    }

    /// Whether the factors are those of the state `y`.
    pub fn is_for(&self, y: &[f64]) -> bool {
        self.key.iter().zip(y).all(|(a, b)| a.total_cmp(b).is_eq())
    }

    /// Factors at time `t` in the state `y`, for the frequencies `rate` of each body.
    ///
    /// A state without factors leaves errors as they are.
    pub fn factorise(&mut self, model: &MultibodyModel, t: f64, y: &[f64], rate: impl Fn(usize) -> f64) {
        self.key.copy_from_slice(&y[..model.n_states()]);
        update(model, t, y, &mut self.states, &mut self.edges);
        for (i, body) in model.bodies.iter().enumerate() {
            self.rates[i] = rate(i);
            self.bodies[i].assemble((&body.data, &body.deformation), &self.states[i], &self.no_forces[i]);
        }
        self.pose.load(model, &self.edges, &self.bodies);
        let joints = Impedance::of_inertia();
        let modes = |i: usize| Impedance { stiffness: self.rates[i].powi(-2), ..joints };
        self.is_sound = self.factors.factorise(model, &self.pose, modes, &joints).is_ok();
    }

    /// Takes ringing out of the errors of all rates.
    pub fn apply(&mut self, model: &MultibodyModel, rates: &mut [f64]) {
        if !self.is_sound {
            return;
        }
        self.response.clear();
        for (body, frequency) in model.bodies.iter().zip(&self.rates) {
            let range = body.layout.rates_elastic();
            let forces = self.response.forces[range.clone()].iter_mut();
            for ((force, k), rate) in forces.zip(&body.data.modal_stiffness).zip(&rates[range]) {
                *force = k / (frequency * frequency) * rate;
            }
        }
        self.response.solve(FactorisedTree { model, pose: &self.pose, factors: &self.factors }, None);
        rates.iter_mut().zip(&self.response.rates).for_each(|(x, change)| *x -= change);
    }
}
