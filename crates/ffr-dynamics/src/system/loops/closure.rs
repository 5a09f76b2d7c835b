//! Joints that close loops, and gears: constraints, their forces, and the way back to them
//! (docs/theory.md Eq. M.32 to M.39).
//!
//! A constraint holds a displacement of the child marker along an axis of the parent marker, or
//! keeps an axis of the one perpendicular to an axis of the other. Redundant constraints (four
//! hinges with parallel axes) are found and left out.

use nalgebra::Vector3;

use super::rows::{GearRow, Owner, Row, Side, free_mobility, gear_mobility};
use crate::error::{EvaluationFailure, MotionFault};
use crate::force::BodyState;
use crate::system::model::gear::Gear;
use crate::system::model::{LoopJoint, MultibodyModel, Site};
use crate::system::tree::kinematics::{JointKinematics, SpatialVector, join};
use crate::system::tree::solver::{Answer, FactorisedTree};

/// Share of a constraint's mobility between free bodies below which it counts as redundant: the
/// tree already holds it.
const REDUNDANT: f64 = 1e-10;

/// Constraints of all loop joints, then of all gears, with their buffers.
#[derive(Debug, Clone)]
pub(in crate::system) struct LoopSolver {
    sides: Vec<[Side; 2]>,
    rows: Vec<Row>,
    gears: Vec<GearRow>,
    /// Mobility of each constraint if the bodies it joins were free: the scale of redundancy.
    scales: Vec<f64>,
    /// Mobility between constraints, its factor, the order of pivots.
    mobility: Vec<f64>,
    factor: Vec<f64>,
    pivots: Vec<usize>,
    rank: usize,
    /// Right-hand side, then multipliers.
    pub multipliers: Vec<f64>,
    scratch: Vec<f64>,
    pub response: Answer<f64>,
}

impl LoopSolver {
    pub fn new(model: &MultibodyModel, states: &[BodyState]) -> Self {
        let sides: Vec<_> =
            model.loops.iter().map(|l| [Side::new(&l.parent, states), Side::new(&l.child, states)]).collect();
        let count = |l: &LoopJoint| l.kind.held_directions().len() + l.kind.perpendicular_axes().len();
        let n = model.loops.iter().map(count).sum::<usize>() + model.gears.len();
        let mut scales = Vec::with_capacity(n);
        for joint in &model.loops {
            let (translation, rotation) = free_mobility(model, [joint.parent.body, joint.child.body]);
            scales.extend(joint.kind.held_directions().iter().map(|_| translation));
            scales.extend(joint.kind.perpendicular_axes().iter().map(|_| rotation));
        }
        scales.extend(model.gears.iter().map(|gear| gear_mobility(model, gear)));
        Self {
            sides,
            rows: Vec::with_capacity(n),
            gears: vec![GearRow::default(); model.gears.len()],
            scales,
            mobility: vec![0.0; n * n],
            factor: vec![0.0; n * n],
            pivots: vec![0; n],
            rank: 0,
            multipliers: vec![0.0; n],
            scratch: vec![0.0; n],
            response: Answer::new(model),
        }
    }

    /// Number of constraints, redundant ones included.
    pub fn n_constraints(&self) -> usize {
        self.multipliers.len()
    }

    /// Constraints that the last mobility found independent.
    pub fn rank(&self) -> usize {
        self.rank
    }

    /// Residuals, directions and velocity terms at the present motion (Eq. M.32, M.33).
    pub fn evaluate(&mut self, model: &MultibodyModel, states: &[BodyState], edges: &[JointKinematics]) {
        self.rows.clear();
        for (row, gear) in self.gears.iter_mut().zip(&model.gears) {
            *row = GearRow::new(gear, edges);
        }
        for (j, (joint, sides)) in model.loops.iter().zip(&mut self.sides).enumerate() {
            *sides = [Side::new(&joint.parent, states), Side::new(&joint.child, states)];
            let [p, c] = &*sides;
            let d = c.place - p.place;
            let relative = c.velocity - p.velocity - p.spin.cross(&d);
            for &k in joint.kind.held_directions() {
                let axis = p.axes.column(k).into_owned();
                let bias = -axis.dot(&(p.spin.cross(&(p.spin.cross(&d) + 2.0 * relative))));
                self.rows.push(Row { joint: j, residual: axis.dot(&d), axis, is_rotation: false, bias });
            }
            for &(a, b) in joint.kind.perpendicular_axes() {
                let (e_p, e_c) = (p.axes.column(a).into_owned(), c.axes.column(b).into_owned());
                let axis = e_c.cross(&e_p);
                let rate = c.spin.cross(&e_c).cross(&e_p) + e_c.cross(&p.spin.cross(&e_p));
                let bias = rate.dot(&(c.spin - p.spin));
                self.rows.push(Row { joint: j, residual: e_p.dot(&e_c), axis, is_rotation: true, bias });
            }
        }
    }

    /// Largest residual [m or rad]; of large coordinates as a share of them.
    pub fn largest_residual(&self) -> f64 {
        let gears = self.gears.iter().map(|gear| gear.residual.abs() / gear.size);
        self.rows.iter().map(|r| r.residual.abs()).chain(gears).fold(0.0, f64::max)
    }

    /// The joint or gear that constraint `k` belongs to.
    pub fn owner(&self, k: usize) -> Owner {
        match self.rows.get(k) {
            Some(Row { joint, is_rotation, .. }) => Owner::Loop { joint: *joint, is_rotation: *is_rotation },
            None => {
                let gear = k - self.rows.len();
                Owner::Gear { gear, speed: self.gears[gear].speed }
            }
        }
    }

    /// Constraint with the largest residual.
    pub fn worst(&self) -> usize {
        let gears = self.gears.iter().map(|gear| gear.residual.abs() / gear.size);
        let all = self.rows.iter().map(|r| r.residual.abs()).chain(gears);
        all.enumerate().max_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |(k, _)| k)
    }

    /// Rate of constraint `k` for velocities of frames and elastic coordinates (Eq. M.33).
    pub(in crate::system) fn rate(
        &self,
        model: &MultibodyModel,
        k: usize,
        frames: &[SpatialVector],
        rates: &[f64],
    ) -> f64 {
        let Some(row) = self.rows.get(k) else { return model.gears[k - self.rows.len()].rate(rates) };
        let joint = &model.loops[row.joint];
        let velocities = |site: &Site, side: &Side| match site.body {
            None => (Vector3::zeros(), Vector3::zeros()),
            Some(b) => side.velocities(site, &frames[b], &rates[model.bodies[b].layout.rates_elastic()]),
        };
        let [p, c] = &self.sides[row.joint];
        let (v_p, w_p) = velocities(&joint.parent, p);
        let (v_c, w_c) = velocities(&joint.child, c);
        if row.is_rotation {
            row.axis.dot(&(w_c - w_p))
        } else {
            row.axis.dot(&(v_c - v_p - w_p.cross(&(c.place - p.place))))
        }
    }

    /// Adds `multiplier` times the force of constraint `k` to the response's forces.
    fn add_force(&mut self, model: &MultibodyModel, k: usize, multiplier: f64) {
        let Some(&Row { joint, axis, is_rotation, .. }) = self.rows.get(k) else {
            return model.gears[k - self.rows.len()].add_force(multiplier, &mut self.response.forces);
        };
        let LoopJoint { parent, child, .. } = &model.loops[joint];
        let [p, c] = &self.sides[joint];
        let force = axis * multiplier;
        let none = Vector3::zeros();
        if is_rotation {
            c.add(child, model, &none, &force, &mut self.response);
            p.add(parent, model, &none, &-force, &mut self.response);
        } else {
            c.add(child, model, &force, &none, &mut self.response);
            p.add(parent, model, &-force, &(c.place - p.place).cross(&-force), &mut self.response);
        }
    }

    /// Wrenches of the joints on their children at the children's markers, in inertial axes
    /// (Eq. M.54).
    pub fn fill_wrenches(&self, wrenches: &mut [SpatialVector]) {
        wrenches.fill([0.0; 6]);
        let none = Vector3::zeros();
        for (row, multiplier) in self.rows.iter().zip(&self.multipliers) {
            let part = row.axis * *multiplier;
            let part = if row.is_rotation { join(&none, &part) } else { join(&part, &none) };
            wrenches[row.joint].iter_mut().zip(part).for_each(|(sum, p)| *sum += p);
        }
    }

    /// Forces of the gears along their second coordinates [N or N m] (Eq. M.38).
    pub fn gear_forces(&self) -> &[f64] {
        &self.multipliers[self.multipliers.len() - self.gears.len()..]
    }

    /// Power of the gears along prescribed coordinates \[W\].
    pub fn prescribed_power(&self, model: &MultibodyModel, edges: &[JointKinematics]) -> f64 {
        let of_gear = |(gear, force): (&Gear, &f64)| {
            let driven = gear.terms().into_iter().filter(|(at, _)| at.rate.is_none());
            driven
                .map(|(at, factor)| factor * force * edges[at.body].coordinates.velocities[at.velocity])
                .sum::<f64>()
        };
        model.gears.iter().zip(self.gear_forces()).map(of_gear).sum()
    }

    /// Mobility of constraint `k` if the bodies it joins were free [1/kg or 1/(kg m²)].
    pub fn scale(&self, k: usize) -> f64 {
        self.scales[k]
    }

    /// Forces of the constraints for given `multipliers` on frames and modes, in `response`.
    pub fn load_response(&mut self, model: &MultibodyModel, multipliers: &[f64]) {
        self.response.clear();
        for (k, multiplier) in multipliers.iter().enumerate() {
            self.add_force(model, k, *multiplier);
        }
    }

    /// Mobility between constraints with the factors of the tree, and its factorisation (Eq. M.34).
    pub fn factorise(&mut self, tree: FactorisedTree<'_, f64>) {
        let n = self.n_constraints();
        for k in 0..n {
            self.response.clear();
            self.add_force(tree.model, k, 1.0);
            self.response.solve(tree, None);
            for i in 0..n {
                self.mobility[i * n + k] =
                    self.rate(tree.model, i, &self.response.frames, &self.response.rates);
            }
        }
        // Coordinates of the tree can move: their mobility is a scale of its own.
        for k in self.rows.len()..n {
            self.scales[k] = self.mobility[k * n + k];
        }
        self.pivoted_cholesky();
    }

    /// Cholesky factor with the largest scaled pivot first; stops at redundant constraints.
    fn pivoted_cholesky(&mut self) {
        let n = self.n_constraints();
        let scaled = |i: usize, j: usize| self.mobility[i * n + j] / (self.scales[i] * self.scales[j]).sqrt();
        self.pivots.iter_mut().enumerate().for_each(|(i, p)| *p = i);
        self.rank = 0;
        for k in 0..n {
            let rest = |i: usize, factor: &[f64]| {
                scaled(i, i) - (0..k).map(|c| factor[i * n + c].powi(2)).sum::<f64>()
            };
            let Some(best) = (k..n).max_by(|a, b| {
                rest(self.pivots[*a], &self.factor).total_cmp(&rest(self.pivots[*b], &self.factor))
            }) else {
                return;
            };
            let pivot = rest(self.pivots[best], &self.factor);
            let is_independent = pivot > REDUNDANT;
            if !is_independent {
                return;
            }
            self.pivots.swap(k, best);
            let p = self.pivots[k];
            self.factor[p * n + k] = pivot.sqrt();
            for i in k + 1..n {
                let r = self.pivots[i];
                let sum: f64 = (0..k).map(|c| self.factor[r * n + c] * self.factor[p * n + c]).sum();
                self.factor[r * n + k] = (scaled(r, p) - sum) / self.factor[p * n + k];
            }
            self.rank = k + 1;
        }
    }

    /// Turns the right-hand side in `multipliers` into the solution; redundant constraints get
    /// none.
    fn solve_mobility(&mut self) {
        let n = self.n_constraints();
        let Self { multipliers, scratch, factor, pivots, scales, .. } = self;
        let pivots = &pivots[..self.rank];
        for (k, &p) in pivots.iter().enumerate() {
            let sum: f64 = (0..k).map(|c| factor[p * n + c] * scratch[c]).sum();
            scratch[k] = (multipliers[p] / scales[p].sqrt() - sum) / factor[p * n + k];
        }
        for k in (0..pivots.len()).rev() {
            let sum: f64 = (k + 1..pivots.len()).map(|c| factor[pivots[c] * n + k] * scratch[c]).sum();
            scratch[k] = (scratch[k] - sum) / factor[pivots[k] * n + k];
        }
        multipliers.fill(0.0);
        for (&p, x) in pivots.iter().zip(scratch.iter()) {
            multipliers[p] = x / scales[p].sqrt();
        }
    }

    /// Response of the tree to the multipliers.
    fn respond(&mut self, tree: FactorisedTree<'_, f64>) {
        let multipliers = std::mem::take(&mut self.multipliers);
        self.load_response(tree.model, &multipliers);
        self.multipliers = multipliers;
        self.response.solve(tree, None);
    }

    /// Multipliers and the accelerations they add, so that constraints stay (Eq. M.35).
    ///
    /// `frames` and `rates` are the accelerations without the constraints.
    pub fn correct_accelerations(
        &mut self,
        tree: FactorisedTree<'_, f64>,
        frames: &[SpatialVector],
        rates: &[f64],
    ) -> Result<(), EvaluationFailure> {
        self.factorise(tree);
        for k in 0..self.rows.len() {
            let row = self.rows[k];
            let [p, c] = &self.sides[row.joint];
            let by_velocity = if row.is_rotation {
                row.axis.dot(&(c.bias.1 - p.bias.1))
            } else {
                let arm = c.place - p.place;
                row.axis.dot(&(c.bias.0 - p.bias.0 - p.bias.1.cross(&arm)))
            };
            self.multipliers[k] = -(self.rate(tree.model, k, frames, rates) + by_velocity + row.bias);
        }
        for (g, row) in self.gears.iter().enumerate() {
            let k = self.rows.len() + g;
            self.multipliers[k] = -(self.rate(tree.model, k, frames, rates) + row.bias);
        }
        self.solve_mobility();
        if let Some(k) = self.multipliers.iter().position(|l| !l.is_finite()) {
            return Err(match self.owner(k) {
                Owner::Loop { joint, .. } => {
                    MotionFault::LoopForce { joint: tree.model.loops[joint].name.clone() }
                }
                Owner::Gear { gear, .. } => {
                    MotionFault::GearForce { gear: tree.model.gears[gear].name.clone() }
                }
            }
            .into());
        }
        self.respond(tree);
        Ok(())
    }

    /// What the constraints do against the accelerations in `response`, in its place; of the last
    /// factors.
    pub fn hold_response(&mut self, tree: FactorisedTree<'_, f64>) {
        for k in 0..self.n_constraints() {
            let rate = self.rate(tree.model, k, &self.response.frames, &self.response.rates);
            self.multipliers[k] = -rate;
        }
        self.solve_mobility();
        self.respond(tree);
    }

    /// Change of all coordinates that takes the residuals away to first order (Eq. M.36), in
    /// `response.rates`.
    pub fn correct_positions(&mut self, tree: FactorisedTree<'_, f64>) {
        let residuals = self.rows.iter().map(|row| row.residual).chain(self.gears.iter().map(|g| g.residual));
        for (multiplier, residual) in self.multipliers.iter_mut().zip(residuals) {
            *multiplier = -residual;
        }
        self.solve_mobility();
        self.respond(tree);
    }

    /// Rate of constraint `k` at the present motion [m/s or 1/s]; prescribed motion is part of it.
    pub fn present_rate(&self, k: usize) -> f64 {
        let Some(&Row { joint, axis, is_rotation, .. }) = self.rows.get(k) else {
            return self.gears[k - self.rows.len()].rate;
        };
        let [p, c] = &self.sides[joint];
        if is_rotation {
            axis.dot(&(c.spin - p.spin))
        } else {
            axis.dot(&(c.velocity - p.velocity - p.spin.cross(&(c.place - p.place))))
        }
    }

    /// Change of all rates that takes the constraints' rates away, in `response.rates`; returns the
    /// largest rate.
    pub fn correct_velocities(&mut self, tree: FactorisedTree<'_, f64>) -> f64 {
        let mut largest: f64 = 0.0;
        for k in 0..self.n_constraints() {
            let rate = self.present_rate(k);
            largest = largest.max(rate.abs());
            self.multipliers[k] = -rate;
        }
        self.solve_mobility();
        self.respond(tree);
        largest
    }
}
