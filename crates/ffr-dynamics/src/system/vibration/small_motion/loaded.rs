//! The stiffness that force elements add about a pose at rest (docs/theory.md Eq. M.63, C.109).

use std::ops::DerefMut;

use faer::Mat;

use super::{MOTION, Movable, SmallMotion, displace, wrench};
use crate::error::DynamicsError;
use crate::force::active::ActiveForce;
use crate::force::{GeneralisedForce, Motion};
use crate::system::model::MultibodyModel;
use crate::system::multibody::workspace::Workspace;
use crate::system::tree::kinematics::frame_velocities;

/// Skew part of the stiffness of elements between modes, over its largest entry, below which they have a potential: rates
/// with friction are found to 1e-7.
const SYMMETRIC: f64 = 1e-5;

impl SmallMotion {
    /// As [`Self::new`], under the further forces of those of `forces` that `elements` names. Their stiffness along elastic coordinates
    /// is that of their rates (Eq. C.109) where they tell them, else, as along joints, found by motions of surfaces by `reach` \[m\]
    /// and more (Eq. M.63); they have none if that is infinite.
    ///
    /// # Errors
    /// [`DynamicsError::StaticStart`] with what a force element refuses; else as [`Self::new`].
    pub fn loaded<F: DerefMut<Target: ActiveForce>>(
        model: &MultibodyModel,
        (t, y): (f64, &[f64]),
        (elements, reach): (&[usize], f64),
        forces: &mut [F],
    ) -> Result<Self, DynamicsError> {
        let (mut small, mut movable, steps) = Self::without_stiffness(model, t, y);
        let (n, length) = (small.n(), movable.length());
        let mut total = vec![0.0; n];
        movable.further(y, elements, forces, &mut total)?;
        small.hold(&mut movable, y, &total)?;
        small.fill_stiffness(&mut movable, y, &steps);
        if total.iter().all(|force| *force == 0.0) || !reach.is_finite() {
            return Ok(small);
        }
        let (mut most, mut is_elastic) = (vec![f64::INFINITY; n], vec![false; n]);
        for body in &model.bodies {
            // Modes of unit mass move a surface by some one over the root of the body's mass.
            most[body.layout.rates_elastic()].fill(reach * body.data.mass.sqrt());
            is_elastic[body.layout.rates_elastic()].fill(true);
        }
        // An element feels the bodies that it presses.
        let mut pressed = Vec::with_capacity(elements.len());
        for element in elements {
            movable.further(y, &[*element], forces, &mut total)?;
            pressed.push((*element, movable.loaded_bodies()));
        }
        let concerned: Vec<Vec<usize>> = (0..n)
            .map(|j| {
                let is_moved = movable.moved_bodies(y, j);
                let concerned = pressed.iter().filter(|(_, bodies)| bodies.iter().any(|b| is_moved[*b]));
                concerned.map(|(element, _)| *element).collect()
            })
            .collect();
        let (mut added, mut ahead, mut behind) = (Mat::zeros(n, n), vec![0.0; n], vec![0.0; n]);
        let mut is_told = vec![false; n];
        for j in (0..n).filter(|j| is_elastic[*j] && !concerned[*j].is_empty()) {
            is_told[j] = movable.rates(y, j, (&concerned[j], forces), &mut ahead);
            if is_told[j] {
                ahead.iter().enumerate().for_each(|(i, rate)| added[(i, j)] = -rate);
            }
        }
        for j in (0..n).filter(|j| !is_told[*j] && !concerned[*j].is_empty()) {
            let step = (steps[j] * reach / (length * MOTION)).min(most[j]);
            for (at, found) in [(step, &mut ahead), (-step, &mut behind)] {
                let mut moved = y.to_vec();
                displace(model, &mut moved, j, at);
                movable.further(&moved, &concerned[j], forces, found)?;
            }
            for (i, (a, b)) in ahead.iter().zip(&behind).enumerate() {
                added[(i, j)] = -0.5 * (a - b) / step;
            }
        }
        // Of forces with a potential the differences tell the rows of joints in full.
        let told: Vec<usize> = (0..n).filter(|j| is_told[*j]).collect();
        let pairs = || told.iter().flat_map(|i| told.iter().map(move |j| (*i, *j)));
        let size = pairs().map(|at| added[at].abs()).fold(0.0, f64::max);
        if pairs().all(|(i, j)| (added[(i, j)] - added[(j, i)]).abs() <= SYMMETRIC * size) {
            for i in (0..n).filter(|i| !is_told[*i]) {
                told.iter().for_each(|j| added[(i, *j)] = added[(*j, i)]);
            }
        }
        small.stiffness += added;
        Ok(small)
    }
}

impl Movable {
    /// The forces that those of `forces` that `elements` names add to those on the bodies in the pose of `y`, along all coordinates.
    fn further<F: DerefMut<Target: ActiveForce>>(
        &mut self,
        y: &[f64],
        elements: &[usize],
        forces: &mut [F],
        out: &mut [f64],
    ) -> Result<(), DynamicsError> {
        self.place(y);
        let Workspace { states, sums, .. } = &mut self.workspace;
        let motion = Motion::new(self.t, states);
        let added = elements.iter().try_for_each(|element| forces[*element].evaluate(motion, sums));
        added.map_err(|refusal| DynamicsError::StaticStart(refusal.into()))?;
        self.write_sums(out);
        Ok(())
    }

    /// The rates of these forces, last evaluated in the pose of `y`, by a unit rate of coordinate `j`; false if one does not tell them.
    fn rates<F: DerefMut<Target: ActiveForce>>(
        &mut self,
        y: &[f64],
        j: usize,
        (elements, forces): (&[usize], &mut [F]),
        out: &mut [f64],
    ) -> bool {
        self.place(y);
        self.workspace.move_along(&self.model, j);
        let Workspace { moving, sums, .. } = &mut self.workspace;
        let motion = Motion::new(self.t, moving);
        let is_told = elements.iter().all(|element| forces[*element].rates(motion, false, sums));
        self.write_sums(out);
        is_told
    }

    /// Forces along all coordinates from those that elements have added on the bodies.
    fn write_sums(&mut self, out: &mut [f64]) {
        let Self { model, workspace: Workspace { states, sums, .. }, wrenches, modal, .. } = self;
        for (i, (body, sum)) in model.bodies.iter().zip(sums).enumerate() {
            modal[body.layout.rates_elastic()].copy_from_slice(&sum.elastic);
            wrenches[i] = wrench(&states[i], sum);
        }
        self.write_coordinates(out);
    }

    /// The bodies on which the forces of the last [`Self::further`] act.
    fn loaded_bodies(&self) -> Vec<usize> {
        let is_zero = |sum: &GeneralisedForce| {
            let rigid = sum.force.iter().chain(sum.torque_in_body.iter());
            rigid.chain(&sum.elastic).all(|f| *f == 0.0)
        };
        let sums = self.workspace.sums.iter().enumerate();
        sums.filter(|(_, sum)| !is_zero(sum)).map(|(i, _)| i).collect()
    }

    /// Which bodies a motion of the coordinate of rate `j` moves or deforms in the pose of `y`.
    fn moved_bodies(&mut self, y: &[f64], j: usize) -> Vec<bool> {
        self.place(y);
        let mut rates = vec![0.0; self.modal.len()];
        rates[j] = 1.0;
        let mut frames = vec![[0.0; 6]; self.model.bodies.len()];
        frame_velocities(&self.model, &self.workspace.edges, &rates, &mut frames);
        let bodies = self.model.bodies.iter().zip(&frames);
        bodies
            .map(|(body, frame)| frame.iter().any(|v| *v != 0.0) || body.layout.rates_elastic().contains(&j))
            .collect()
    }
}
