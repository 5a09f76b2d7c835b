//! The points under load, with their block of the compliance: all that iterations work on.

use super::{Blocks, PointState, TangentialProblem, pair};
use crate::quasistatic::members::Members;

/// Points with a normal force.
pub(super) struct LoadedPoints {
    n_t: usize,
    /// Points that `block` belongs to; none if it is not known.
    pub points: Members,
    /// `A_TT` of these points, column by column.
    block: Vec<f64>,
    /// Forces of these points, displacements under them.
    compact: [Vec<f64>; 2],
}

impl LoadedPoints {
    /// Buffers for `n_points` points with `n_t` tangential components.
    pub fn new(n_points: usize, n_t: usize) -> Self {
        let n = n_points * n_t;
        Self {
            n_t,
            points: Members::new(n_points),
            block: vec![0.0; n * n],
            compact: [vec![0.0; n], vec![0.0; n]],
        }
    }

    /// Has the block gathered again at the next call.
    pub fn forget(&mut self) {
        self.points.clear();
    }

    /// Takes those points as loaded that are not open, with their block of `compliance`.
    pub fn gather(&mut self, states: &[PointState], compliance: &Blocks) {
        let loaded = |i: &usize| states[*i] != PointState::Open;
        let points = self.points.list();
        if points.iter().copied().eq((0..states.len()).filter(loaded)) && !points.is_empty() {
            return;
        }
        self.points.set((0..states.len()).filter(loaded));
        compliance.gather(self.points.list(), &mut self.block);
    }

    /// Displacements of the loaded points under a unit force at `point` along `direction`, and the
    /// place of each point among them.
    pub fn displacement(&mut self, point: usize, direction: &[f64; 2]) -> (&[f64], &Members) {
        let (n_t, height) = (self.n_t, self.n_t * self.points.list().len());
        let displacement = &mut self.compact[1][..height];
        displacement.fill(0.0);
        for (b, &factor) in direction[..n_t].iter().enumerate().filter(|(_, f)| **f != 0.0) {
            let source = &self.block[(n_t * self.points.place(point) + b) * height..][..height];
            displacement.iter_mut().zip(source).for_each(|(d, s)| *d += factor * s);
        }
        (displacement, &self.points)
    }

    /// Slip increments of the loaded points under `forces`; those of open ones are left.
    pub fn update_increments(
        &mut self,
        problem: &TangentialProblem<'_>,
        forces: &[f64],
        increments: &mut [f64],
    ) {
        let n_t = self.n_t;
        let m = n_t * self.points.list().len();
        let [tau, w] = &mut self.compact;
        for (slot, &i) in self.points.list().iter().enumerate() {
            let (from, to) = (n_t * i..n_t * (i + 1), n_t * slot..n_t * (slot + 1));
            tau[to.clone()].copy_from_slice(&forces[from.clone()]);
            for ((w, slip), force) in w[to].iter_mut().zip(&problem.slips[from.clone()]).zip(&forces[from]) {
                *w = slip + problem.springs[i] * force;
            }
        }
        add_block(&self.block, &tau[..m], &mut w[..m]);
        for (slot, &i) in self.points.list().iter().enumerate() {
            increments[n_t * i..n_t * (i + 1)].copy_from_slice(&w[n_t * slot..n_t * (slot + 1)]);
        }
    }
}

/// Sweeps over the points, from the increments last updated on.
impl LoadedPoints {
    /// Slip increment of a loaded point, and the largest yield of its own to a unit force, with that
    /// of its spring.
    pub fn increment(&self, slot: usize, spring: f64) -> ([f64; 2], f64) {
        let (n_t, m) = (self.n_t, self.n_t * self.points.list().len());
        let own = |a: usize, b: usize| self.block[(n_t * slot + b) * m + n_t * slot + a];
        let largest = if n_t == 1 {
            own(0, 0)
        } else {
            let (mean, half) = (0.5 * (own(0, 0) + own(1, 1)), 0.5 * (own(0, 0) - own(1, 1)));
            mean + half.hypot(own(0, 1))
        };
        (pair(&self.compact[1], slot, n_t), largest + spring)
    }

    /// Adds `force` to that of a loaded point: increments of all follow.
    pub fn add_force(&mut self, slot: usize, spring: f64, force: [f64; 2]) {
        let (n_t, m) = (self.n_t, self.n_t * self.points.list().len());
        let increments = &mut self.compact[1][..m];
        for (a, f) in force.iter().enumerate().take(n_t).filter(|(_, f)| **f != 0.0) {
            let k = n_t * slot + a;
            increments[k] += spring * f;
            increments.iter_mut().zip(&self.block[k * m..]).for_each(|(w, yielding)| *w += f * yielding);
        }
    }
}

/// `out += block x`, four columns at a time.
fn add_block(block: &[f64], x: &[f64], out: &mut [f64]) {
    let m = x.len();
    for (columns, x) in block[..m * m].chunks(4 * m.max(1)).zip(x.chunks(4)) {
        if let &[x, y, z, w] = x {
            let (a, rest) = columns.split_at(m);
            let (b, rest) = rest.split_at(m);
            let (c, d) = rest.split_at(m);
            for ((((o, a), b), c), d) in out.iter_mut().zip(a).zip(b).zip(c).zip(d) {
                *o += (x * a + y * b) + (z * c + w * d);
            }
        } else {
            for (column, x) in columns.chunks_exact(m).zip(x) {
                out.iter_mut().zip(column).for_each(|(o, a)| *o += a * x);
            }
        }
    }
}
