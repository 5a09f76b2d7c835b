//! Closing loops: the start of a system, and the way back to the constraints after a step
//! (docs/theory.md Eq. M.36, M.24).

use std::ops::DerefMut;

use super::loops::rows::Owner;
use super::multibody::Multibody;
use super::multibody::workspace::Workspace;
use super::tree::solver::FactorisedTree;
use super::vibration::small_motion::SmallMotion;
use crate::error::DynamicsError;
use crate::force::active::ActiveForce;

/// Residual of a loop-closing joint at which a state is projected back [m or rad]; the limit asked
/// for is 1e-10.
const LOOP_TOLERANCE: f64 = 1e-12;
/// Rate of a constraint, as a share of the fastest body's velocity (at least of 1 mm/s), at which
/// velocities are projected.
const LOOP_RATE_TOLERANCE: f64 = 1e-11;
/// Elastic inertia counts so many times when positions are projected: deforming would cost energy,
/// moving joints does not. The mobility that is left stays far above the limit of redundancy.
const ELASTIC_WEIGHT: f64 = 1e6;
/// Rate of a constraint, as a share of the fastest body's velocity or angular velocity, above which
/// velocities given contradict a loop: typed with four digits they do not.
const CONTRADICTION: f64 = 1e-3;
/// Newton steps of a projection; drift of one step needs one or two.
const MAX_PROJECTIONS: usize = 8;

impl<F: DerefMut<Target: ActiveForce>> Multibody<F> {
    /// Moves joint and elastic coordinates, then velocities, until the loops are closed and gears
    /// fit: a start for systems with constraints.
    ///
    /// # Errors
    /// [`DynamicsError::Joint`] if a loop does not close; give joint coordinates nearer to a closed position.
    pub fn assemble(&mut self, t: f64, y: &mut [f64]) -> Result<(), DynamicsError> {
        self.assemble_positions(t, y)?;
        self.close_velocities(t, y, 1.0);
        Ok(())
    }

    fn assemble_positions(&mut self, t: f64, y: &mut [f64]) -> Result<(), DynamicsError> {
        for _ in 0..10 * MAX_PROJECTIONS {
            self.close_positions(t, y);
            let residual = self.loop_residual(t, y);
            if residual <= 10.0 * LOOP_TOLERANCE {
                return Ok(());
            }
            if !residual.is_finite() {
                break;
            }
        }
        let gap = self.loop_residual(t, y);
        let loops = &self.workspace.loops;
        let of_loop = format!(
            "the loop stays open by {gap:.3e} m or rad, limit 1e-11; start nearer to a closed position, or the parts do not fit"
        );
        let of_gear = format!(
            "the coordinates stay apart by {gap:.3e} m or rad, limit 1e-11; start nearer to a position that fits"
        );
        Err(self.at_fault(loops.owner(loops.worst()), of_loop, of_gear))
    }

    /// Closes the loops of a start: joint and elastic coordinates as [`Multibody::assemble`] moves
    /// them; then velocities of those joints for which `is_given` does not hold, by body, follow
    /// the given ones and the prescribed motions with the least kinetic energy, as if bodies were
    /// rigid (Eq. M.24).
    ///
    /// # Errors
    /// [`DynamicsError::Joint`] if a loop does not close, or given velocities contradict it.
    pub fn assemble_start(&mut self, t: f64, y: &mut [f64], is_given: &[bool]) -> Result<(), DynamicsError> {
        self.assemble_positions(t, y)?;
        let mut may_move = vec![false; self.model.n_rates()];
        for (body, _) in self.model.bodies.iter().zip(is_given).filter(|(_, is_given)| !**is_given) {
            may_move[body.layout.rates_joint()].fill(true);
        }
        self.loop_residual(t, y);
        let loops = &self.workspace.loops;
        let open: Vec<f64> = (0..loops.n_constraints()).map(|k| loops.present_rate(k)).collect();
        let change = SmallMotion::closing_rates(&self.model, t, y, &may_move, &open)?;
        for body in &self.model.bodies {
            add(&mut y[body.layout.velocities()], &change[body.layout.rates_joint()]);
        }
        self.loop_residual(t, y);
        let (speed, loops) = (self.norm.speed(&self.model, t, y), &self.workspace.loops);
        let spins = self.workspace.states.iter().map(|state| state.angular_velocity_in_body.norm());
        let spin = spins.fold(0.0, f64::max);
        for k in 0..loops.n_constraints() {
            let (rate, owner) = (loops.present_rate(k), loops.owner(k));
            let scale = match owner {
                Owner::Loop { is_rotation: true, .. } => spin,
                Owner::Loop { .. } => speed,
                Owner::Gear { speed, .. } => speed,
            };
            if rate.abs() > CONTRADICTION * scale {
                let of_loop = format!(
                    "velocities given at the start open the loop at {rate:.3e} m/s or rad/s; leave those out that follow from others, or correct \
                     them"
                );
                let of_gear = format!(
                    "velocities given at the start slip by {rate:.3e} m/s or rad/s; leave out those that follow from others, or correct them"
                );
                return Err(self.at_fault(owner, of_loop, of_gear));
            }
        }
        // Round-off, and what the digits of given velocities leave.
        self.close_velocities(t, y, ELASTIC_WEIGHT);
        Ok(())
    }

    /// What is wrong with the loop or the gear that a constraint belongs to.
    fn at_fault(&self, owner: Owner, of_loop: String, of_gear: String) -> DynamicsError {
        match owner {
            Owner::Loop { joint, .. } => {
                DynamicsError::Joint { joint: self.model.loops[joint].name.clone(), fault: of_loop }
            }
            Owner::Gear { gear, .. } => {
                DynamicsError::Gear { gear: self.model.gears[gear].name.clone(), fault: of_gear }
            }
        }
    }

    /// Projects positions and velocities onto the constraints; returns whether it changed `y`.
    pub(super) fn close_loops(&mut self, t: f64, y: &mut [f64]) -> bool {
        let has_moved = self.close_positions(t, y);
        self.close_velocities(t, y, 1.0) || has_moved
    }

    /// Projects velocities onto the constraints, elastic inertia counting `elastic_weight` times;
    /// returns whether it changed `y`.
    fn close_velocities(&mut self, t: f64, y: &mut [f64], elastic_weight: f64) -> bool {
        self.workspace.place(&self.model, t, y);
        if self.workspace.factorise(&self.model, elastic_weight).is_err() {
            return false;
        }
        let Workspace { loops, pose, factors, .. } = &mut self.workspace;
        let rate = loops.correct_velocities(FactorisedTree { model: &self.model, pose, factors });
        let speed = self.norm.speed(&self.model, t, y).max(1e-3);
        let is_slow = rate <= LOOP_RATE_TOLERANCE * speed;
        if is_slow {
            return false;
        }
        for body in &self.model.bodies {
            add(&mut y[body.layout.elastic_rates()], &loops.response.rates[body.layout.rates_elastic()]);
            add(&mut y[body.layout.velocities()], &loops.response.rates[body.layout.rates_joint()]);
        }
        true
    }

    /// Moves positions onto the constraints, joints rather than elastic coordinates; returns
    /// whether it changed `y`.
    fn close_positions(&mut self, t: f64, y: &mut [f64]) -> bool {
        for step in 0..MAX_PROJECTIONS {
            let residual = self.loop_residual(t, y);
            let is_open = residual > LOOP_TOLERANCE && residual.is_finite();
            if !is_open || self.workspace.factorise(&self.model, ELASTIC_WEIGHT).is_err() {
                return step > 0;
            }
            let Workspace { loops, pose, factors, .. } = &mut self.workspace;
            loops.correct_positions(FactorisedTree { model: &self.model, pose, factors });
            self.move_coordinates(y);
        }
        true
    }

    /// Moves positions by the loops' response.
    fn move_coordinates(&self, y: &mut [f64]) {
        self.model.displace(y, &self.workspace.loops.response.rates);
    }
}

fn add(to: &mut [f64], change: &[f64]) {
    to.iter_mut().zip(change).for_each(|(a, b)| *a += b);
}
