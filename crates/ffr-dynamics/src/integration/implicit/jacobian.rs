//! Derivatives of the right-hand side in the unknowns that an implicit method solves for
//! (docs/theory.md Eq. T.20 to T.22).
//!
//! Velocities are the unknowns; positions follow through known kinematics and quadratures through
//! nothing but the result. A system of which nothing is known has all its components as unknowns.

use crate::data_error::DataError;
use crate::error::DynamicsError;
use crate::integration::linearisation::{KinematicBlock, Linearisation};
use crate::integration::step_control::Statistics;
use crate::integration::system::OdeSystem;
use crate::rotation::quaternion_rate;
use nalgebra::Vector3;

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
    /// [`DynamicsError::Data`] if blocks overlap or leave the state.
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
                    let what = format!("components of the state of {block:?}");
                    return Err(DataError::Index { what, number: i, count: dimension }.into());
                }
            }
            unknowns.extend(first..first + len);
        }
        Ok(Self { blocks, unknowns })
    }

    /// Sets `direction` to the change of state that unit speed of unknown `j` brings to the
    /// positions of `y` (T.20).
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

    /// Derivative at `(t, y)`: what the system knows, the rest by differences (T.22). Restores the
    /// system's inner state.
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
        out.reset(&structure.blocks);
        if system.linearise(t, y, out).is_err() {
            out.reset(&structure.blocks);
        }
        let is_complete = out.is_known().iter().all(|known| known[0] && known[1]);
        if !is_complete {
            statistics.evaluations += 1;
            let is_refused = system.rhs(t, y, &mut self.base).is_err();
            for j in 0..out.n_unknowns() {
                for part in 0..2 {
                    if out.is_known()[j][part] {
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

    /// Step along `direction`: as long as a permitted error, over which the system counts as
    /// linear, but well above round-off.
    fn difference_step<S: OdeSystem + ?Sized>(&self, system: &mut S, y: &[f64]) -> f64 {
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
