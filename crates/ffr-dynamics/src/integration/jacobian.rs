//! Derivatives of the right-hand side in the unknowns that an implicit method solves for (docs/theory.md Eq. T.13 to T.15).
//!
//! Velocities are the unknowns; positions follow through known kinematics and quadratures through nothing but the result.
//! A system of which nothing is known has all its components as unknowns.

use super::step_control::Statistics;
use super::system::OdeSystem;
use crate::error::DynamicsError;
use crate::kinematics::rotation::quaternion_rate;
use nalgebra::Vector3;

/// How a group of state components changes with others. Numbers are indices into the state vector.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum KinematicBlock {
    /// `len` positions from `position` on whose rates are the components from `velocity` on.
    Vector {
        /// First position.
        position: usize,
        /// First velocity.
        velocity: usize,
        /// Number of positions, and of velocities.
        len: usize,
    },
    /// A quaternion `w x y z` with the rate (D.1) from an angular velocity in the turning frame.
    Rotation {
        /// First of four components.
        quaternion: usize,
        /// First of three angular velocities.
        velocity: usize,
    },
    /// `len` components from `start` on whose rates depend on anything, and that move no position directly.
    Plain {
        /// First component.
        start: usize,
        /// Number of components.
        len: usize,
    },
}

impl KinematicBlock {
    /// First unknown and number of unknowns.
    pub(super) fn unknowns(&self) -> (usize, usize) {
        match *self {
            Self::Vector { velocity, len, .. } => (velocity, len),
            Self::Rotation { velocity, .. } => (velocity, 3),
            Self::Plain { start, len } => (start, len),
        }
    }

    /// First position and number of positions.
    fn positions(&self) -> (usize, usize) {
        match *self {
            Self::Vector { position, len, .. } => (position, len),
            Self::Rotation { quaternion, .. } => (quaternion, 4),
            Self::Plain { start, .. } => (start, 0),
        }
    }
}

/// Checked blocks of a system.
#[derive(Debug, Clone)]
pub(super) struct Structure {
    pub(super) blocks: Vec<KinematicBlock>,
    /// Index into the state of each unknown.
    pub(super) unknowns: Vec<usize>,
}

impl Structure {
    /// Blocks of `system`, or one plain block with everything.
    ///
    /// # Errors
    /// [`DynamicsError::Inconsistent`] if blocks overlap or leave the state.
    pub(super) fn of<S: OdeSystem + ?Sized>(system: &S) -> Result<Self, DynamicsError> {
        let dimension = system.dimension();
        let mut blocks = system.kinematics();
        if blocks.is_empty() {
            blocks.push(KinematicBlock::Plain { start: 0, len: dimension });
        }
        let mut is_taken = vec![false; dimension];
        let mut unknowns = Vec::new();
        for block in &blocks {
            let (first, len) = block.unknowns();
            let (position, n_positions) = block.positions();
            for i in (first..first + len).chain(position..position + n_positions) {
                let is_free = is_taken.get_mut(i).is_some_and(|taken| !std::mem::replace(taken, true));
                if !is_free {
                    let reason =
                        format!("{block:?}: component {i} of {dimension} is taken or does not exist");
                    return Err(DynamicsError::Inconsistent { reason });
                }
            }
            unknowns.extend(first..first + len);
        }
        Ok(Self { blocks, unknowns })
    }

    /// Sets `direction` to the change of state that unit speed of unknown `j` brings to the positions of `y` (T.13).
    fn position_direction(&self, y: &[f64], j: usize, direction: &mut [f64]) {
        direction.fill(0.0);
        let mut first = 0;
        for block in &self.blocks {
            let (_, len) = block.unknowns();
            if j < first + len {
                match *block {
                    KinematicBlock::Vector { position, .. } => direction[position + j - first] = 1.0,
                    KinematicBlock::Rotation { quaternion, .. } => {
                        let range = quaternion..quaternion + 4;
                        let axis = Vector3::ith(j - first, 1.0);
                        quaternion_rate(&y[range.clone()], &axis, &mut direction[range]);
                    }
                    KinematicBlock::Plain { .. } => {}
                }
                return;
            }
            first += len;
        }
    }
}

/// Derivatives of the rates of all unknowns: with respect to motion along each unknown's position, and to each unknown itself.
///
/// Unknowns count in the order of the system's blocks: velocities of vectors, angular velocities, plain components.
#[derive(Debug, Clone)]
pub struct Linearisation {
    n: usize,
    by_position: Vec<f64>,
    by_velocity: Vec<f64>,
    is_known: Vec<[bool; 2]>,
}

impl Linearisation {
    /// For `n` unknowns, all derivatives unknown.
    pub fn new(n: usize) -> Self {
        Self {
            n,
            by_position: vec![0.0; n * n],
            by_velocity: vec![0.0; n * n],
            is_known: vec![[false; 2]; n],
        }
    }

    /// Number of unknowns.
    pub fn n_unknowns(&self) -> usize {
        self.n
    }

    /// Change of all rates with the position that unknown `unknown` moves, per unit; for a rotation about a body axis, per
    /// radian. To be written; what is in it is undefined.
    pub fn position_column_mut(&mut self, unknown: usize) -> &mut [f64] {
        self.is_known[unknown][0] = true;
        &mut self.by_position[unknown * self.n..(unknown + 1) * self.n]
    }

    /// Change of all rates with the unknown `unknown` itself. To be written; what is in it is undefined.
    pub fn velocity_column_mut(&mut self, unknown: usize) -> &mut [f64] {
        self.is_known[unknown][1] = true;
        &mut self.by_velocity[unknown * self.n..(unknown + 1) * self.n]
    }

    /// The column written by [`Linearisation::position_column_mut`].
    pub fn position_column(&self, unknown: usize) -> &[f64] {
        &self.by_position[unknown * self.n..(unknown + 1) * self.n]
    }

    /// The column written by [`Linearisation::velocity_column_mut`].
    pub fn velocity_column(&self, unknown: usize) -> &[f64] {
        &self.by_velocity[unknown * self.n..(unknown + 1) * self.n]
    }

    /// Forgets all columns, save that plain components have no positions.
    fn reset(&mut self, structure: &Structure) {
        self.is_known.fill([false; 2]);
        let mut first = 0;
        for block in &structure.blocks {
            let (_, len) = block.unknowns();
            if matches!(block, KinematicBlock::Plain { .. }) {
                (first..first + len).for_each(|j| self.position_column_mut(j).fill(0.0));
            }
            first += len;
        }
    }
}

/// Buffers for differences of the right-hand side.
#[derive(Debug, Clone)]
pub(super) struct Differences {
    base: Vec<f64>,
    moved: Vec<f64>,
    direction: Vec<f64>,
    rates: Vec<f64>,
}

impl Differences {
    pub(super) fn new(dimension: usize) -> Self {
        let zeros = || vec![0.0; dimension];
        Self { base: zeros(), moved: zeros(), direction: zeros(), rates: zeros() }
    }

    /// Derivative at `(t, y)`: what the system knows, the rest by differences (T.15). Restores the system's inner state.
    ///
    /// A column whose differences are refused on both sides is left zero.
    pub(super) fn linearise<S: OdeSystem + ?Sized>(
        &mut self,
        system: &mut S,
        structure: &Structure,
        (t, y): (f64, &[f64]),
        out: &mut Linearisation,
        statistics: &mut Statistics,
    ) {
        statistics.jacobians += 1;
        out.reset(structure);
        if system.linearise(t, y, out).is_err() {
            out.reset(structure);
        }
        let is_complete = out.is_known.iter().all(|known| known[0] && known[1]);
        if !is_complete {
            statistics.evaluations += 1;
            let is_refused = system.rhs(t, y, &mut self.base).is_err();
            for j in 0..out.n {
                for part in 0..2 {
                    if out.is_known[j][part] {
                        continue;
                    }
                    if part == 0 {
                        structure.position_direction(y, j, &mut self.direction);
                    } else {
                        self.direction.fill(0.0);
                        self.direction[structure.unknowns[j]] = 1.0;
                    }
                    let column =
                        if part == 0 { out.position_column_mut(j) } else { out.velocity_column_mut(j) };
                    let is_found = !is_refused && self.column(system, structure, t, y, column, statistics);
                    if !is_found {
                        column.fill(0.0);
                    }
                }
            }
        }
        system.restore();
    }

    /// One difference along `direction`; backwards where forwards is refused.
    fn column<S: OdeSystem + ?Sized>(
        &mut self,
        system: &mut S,
        structure: &Structure,
        t: f64,
        y: &[f64],
        column: &mut [f64],
        statistics: &mut Statistics,
    ) -> bool {
        let step = self.difference_step(system, y);
        for step in [step, -step] {
            for ((m, y), d) in self.moved.iter_mut().zip(y).zip(&self.direction) {
                *m = y + step * d;
            }
            statistics.evaluations += 1;
            if system.rhs(t, &self.moved, &mut self.rates).is_err() {
                continue;
            }
            for (c, &i) in column.iter_mut().zip(&structure.unknowns) {
                *c = (self.rates[i] - self.base[i]) / step;
            }
            if column.iter().all(|c| c.is_finite()) {
                return true;
            }
        }
        false
    }

    /// Step along `direction`: as long as a permitted error, over which the system counts as linear, but well above round-off.
    fn difference_step<S: OdeSystem + ?Sized>(&self, system: &S, y: &[f64]) -> f64 {
        let size = system.damped_error_norm(y, y, &self.direction);
        let along: f64 = y.iter().zip(&self.direction).map(|(y, d)| y.abs() * d.abs()).fold(0.0, f64::max);
        let round_off = f64::EPSILON.sqrt();
        let permitted = 1.0 / size;
        if size > 0.0 && permitted.is_finite() && permitted > 0.0 {
            permitted.max(round_off * along)
        } else {
            round_off * along.max(1.0)
        }
    }
}
