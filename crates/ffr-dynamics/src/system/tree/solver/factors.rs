//! Elimination of the motion of all bodies, from the leaves to ground.

use nalgebra::{ArrayStorage, Matrix6, SMatrix};

use super::number::{Number, inverse, product, transposed_product};
use super::pose::{BodyPose, TreePose};
use crate::error::{EvaluationFailure, MotionFault};
use crate::system::model::{MultibodyModel, TreeBody};
use crate::system::tree::kinematics::SpatialVector;

/// What inertia, damping and stiffness count for: `inertia + damping d + stiffness k`.
#[derive(Debug, Clone, Copy)]
pub(in crate::system) struct Impedance<T> {
    pub inertia: T,
    pub damping: T,
    pub stiffness: T,
}

impl<T: Number> Impedance<T> {
    /// Inertia alone.
    pub fn of_inertia() -> Self {
        Self { inertia: T::one(), damping: T::zero(), stiffness: T::zero() }
    }

    /// Impedance of a damper and a spring.
    pub(super) fn passive(&self, damping: f64, stiffness: f64) -> T {
        self.damping.scale(damping) + self.stiffness.scale(stiffness)
    }
}

/// A body on another one's marker, as that one feels it: the force on the parent is
/// `given - felt p` for the motion `p` of the marker.
#[derive(Debug, Clone)]
pub(super) struct Attached<T> {
    /// Motion of the marker by that of the frame, `V`.
    pub by_frame: Matrix6<T>,
    /// Motion of the marker by the force of the own joint, `Λ_kc`.
    pub by_own: Matrix6<T>,
    /// `(1 + Λ_kk A_k)⁻¹`.
    pub gate: Matrix6<T>,
}

/// Factors of one body.
#[derive(Debug, Clone)]
pub(super) struct BodyFactors<T> {
    /// Reciprocal impedance of the modes.
    pub modes: Vec<T>,
    pub attached: Vec<Attached<T>>,
    /// Compliance between the markers of the bodies attached, `Λ`, row by row; eliminated from the
    /// first on.
    pub between: Vec<Matrix6<T>>,
    /// Motion of the frame by the force on it while the place that the joint holds does not move,
    /// and by the motion of that place, `P`; not used if the joint does not feel the modes.
    pub frame_by_force: Matrix6<T>,
    pub frame_by_place: Matrix6<T>,
    /// Force of the joint by the motion of the place that it holds, `W`.
    pub own: Matrix6<T>,
    /// Velocities of the joint by forces along them, `E`; by the motion of its place; force on the
    /// place by forces along them.
    pub joint_mobility: Matrix6<T>,
    pub joint_share: Matrix6<T>,
    pub by_joint_force: Matrix6<T>,
}

/// Factors of all bodies for one pose and one set of impedances.
#[derive(Debug, Clone)]
pub(in crate::system) struct TreeFactors<T> {
    pub(super) bodies: Vec<BodyFactors<T>>,
    /// Inertia that the parent of each body feels, `A`.
    pub(super) felt: Vec<Matrix6<T>>,
}

/// A tree in one pose with its factors.
#[derive(Debug)]
pub(in crate::system) struct FactorisedTree<'a, T> {
    pub model: &'a MultibodyModel,
    pub pose: &'a TreePose,
    pub factors: &'a TreeFactors<T>,
}

impl<T> Clone for FactorisedTree<'_, T> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<T> Copy for FactorisedTree<'_, T> {}

impl<T: Number> TreeFactors<T> {
    /// Space for the bodies of `model`.
    pub fn new(model: &MultibodyModel) -> Self {
        let bodies = model.bodies.iter().zip(&model.children);
        Self {
            bodies: bodies.map(|(b, children)| BodyFactors::new(b.layout.n_modes, children.len())).collect(),
            felt: vec![Matrix6::zeros(); model.bodies.len()],
        }
    }

    /// Eliminates all bodies; `modes` gives the impedance of the modes of each body, `joints` that
    /// of the joints' springs.
    ///
    /// # Errors
    /// [`MotionFault::Inertia`].
    pub fn factorise(
        &mut self,
        model: &MultibodyModel,
        pose: &TreePose,
        modes: impl Fn(usize) -> Impedance<T>,
        joints: &Impedance<T>,
    ) -> Result<(), EvaluationFailure> {
        for &i in model.order.iter().rev() {
            match self.bodies[i].eliminate(model, pose, &self.felt, i, (&modes(i), joints)) {
                Ok(felt) => self.felt[i] = felt,
                Err(coordinates) => {
                    let body = model.bodies[i].name.clone();
                    return Err(MotionFault::Inertia { coordinates, body }.into());
                }
            }
        }
        Ok(())
    }
}

impl<T: Number> BodyFactors<T> {
    fn new(n_modes: usize, n_children: usize) -> Self {
        let zero = Matrix6::zeros();
        Self {
            modes: vec![T::zero(); n_modes],
            attached: vec![Attached { by_frame: zero, by_own: zero, gate: zero }; n_children],
            between: vec![zero; n_children * n_children],
            frame_by_force: zero,
            frame_by_place: zero,
            own: zero,
            joint_mobility: zero,
            joint_share: zero,
            by_joint_force: zero,
        }
    }

    /// Eliminates body `i`, whose children have the inertia `felt`; returns its own. The error says
    /// which coordinates lack inertia.
    fn eliminate(
        &mut self,
        model: &MultibodyModel,
        tree: &TreePose,
        felt: &[Matrix6<T>],
        i: usize,
        (impedance, joints): (&Impedance<T>, &Impedance<T>),
    ) -> Result<Matrix6<T>, &'static str> {
        let (body, children, pose) = (&model.bodies[i], &model.children[i], &tree.bodies[i]);
        for ((g, k), d) in self.modes.iter_mut().zip(&body.modes.stiffness).zip(&body.modes.damping) {
            *g = (impedance.inertia + impedance.passive(*d, *k)).recip();
        }
        let mut frame = from_real(&pose.rigid) - weighed(&pose.coupling, &self.modes, &pose.coupling);
        let (mut lever, mut yields) = (Matrix6::zeros(), Matrix6::zeros());
        let feels_modes = !pose.own.is_empty();
        if feels_modes {
            lever = from_real(&pose.at_own) - weighed(&pose.own, &self.modes, &pose.coupling);
            yields = weighed(&pose.own, &self.modes, &pose.own);
        }
        for (k, &child) in children.iter().enumerate() {
            let port = &tree.bodies[child];
            let attached = &mut self.attached[k];
            attached.by_frame =
                from_real(&port.at_parent) - weighed(&port.parent, &self.modes, &pose.coupling);
            attached.by_own = weighed(&port.parent, &self.modes, &pose.own);
            for (j, &other) in children.iter().enumerate().take(k + 1) {
                let compliance = weighed(&port.parent, &self.modes, &tree.bodies[other].parent);
                self.between[j * children.len() + k] = compliance.transpose();
                self.between[k * children.len() + j] = compliance;
            }
        }
        for (k, &child) in children.iter().enumerate() {
            let is_still = tree.bodies[child].parent.is_empty();
            let stiffened = self.attach(k, &felt[child], is_still).ok_or("elastic coordinates")?;
            let Attached { by_frame, by_own, .. } = &self.attached[k];
            let by_frame_stiffened = product(&stiffened, by_frame);
            frame += transposed_product(by_frame, &by_frame_stiffened);
            if feels_modes && !is_still {
                lever -= transposed_product(by_own, &by_frame_stiffened);
                yields -= transposed_product(by_own, &product(&stiffened, by_own));
            }
        }
        if feels_modes {
            self.release(pose, &frame, &lever, &yields).ok_or("elastic coordinates")?;
        } else {
            self.own = frame;
        }
        self.close_joint(body, pose, joints)
    }

    /// Motion of the frame and force of the joint by the force on the frame and the motion of the
    /// place that the joint holds, from the frame's inertia and the motions of the place by those
    /// of the frame and by its force.
    fn release(
        &mut self,
        pose: &BodyPose,
        frame: &Matrix6<T>,
        lever: &Matrix6<T>,
        yields: &Matrix6<T>,
    ) -> Option<()> {
        // Both motions in units in which they weigh about one: what the modes yield may outweigh
        // the frame by many orders.
        let frame_unit: [f64; 6] = std::array::from_fn(|k| pose.sizes[k / 3].recip());
        let place_unit: [f64; 6] =
            std::array::from_fn(|k| (frame_unit[k].powi(2) + yields[(k, k)].norm1()).sqrt());
        let pairs = (0..6).flat_map(|r| (0..6).map(move |c| (r, c)));
        let mut both = SMatrix::<T, 12, 12>::zeros();
        for (r, c) in pairs.clone() {
            both[(r, c)] = frame[(r, c)].scale(frame_unit[r] * frame_unit[c]);
            both[(6 + r, c)] = -lever[(r, c)].scale(frame_unit[c] / place_unit[r]);
            both[(c, 6 + r)] = both[(6 + r, c)];
            both[(6 + r, 6 + c)] = -yields[(r, c)].unscale(place_unit[r] * place_unit[c]);
        }
        let both = inverse(&both)?;
        for (r, c) in pairs {
            self.frame_by_force[(r, c)] = both[(r, c)].scale(frame_unit[r] * frame_unit[c]);
            self.frame_by_place[(r, c)] = -both[(r, 6 + c)].scale(frame_unit[r] / place_unit[c]);
            self.own[(r, c)] = -both[(6 + r, 6 + c)].unscale(place_unit[r] * place_unit[c]);
        }
        Some(())
    }

    /// Attaches child `k`, whose joint has the inertia `felt`; returns that inertia as the rest of
    /// the body sees it.
    fn attach(&mut self, k: usize, felt: &Matrix6<T>, is_still: bool) -> Option<Matrix6<T>> {
        if is_still {
            self.attached[k].gate = Matrix6::identity();
            return Some(*felt);
        }
        let n = self.attached.len();
        let gate = inverse(&(Matrix6::identity() + product(&self.between[k * n + k], felt)))?;
        let stiffened = product(felt, &gate);
        self.attached[k].gate = gate;
        for a in k + 1..n {
            let left = product(&self.between[a * n + k], &stiffened);
            for b in k + 1..n {
                let change = product(&left, &self.between[k * n + b]);
                self.between[a * n + b] -= change;
            }
            let Attached { by_frame, by_own, .. } = &self.attached[k];
            let (by_frame, by_own) = (product(&left, by_frame), product(&left, by_own));
            self.attached[a].by_frame -= by_frame;
            self.attached[a].by_own -= by_own;
        }
        Some(stiffened)
    }

    /// What the joint makes of the inertia of the place that it holds: returns what the parent
    /// feels.
    fn close_joint(
        &mut self,
        body: &TreeBody,
        pose: &BodyPose,
        joints: &Impedance<T>,
    ) -> Result<Matrix6<T>, &'static str> {
        let across = from_real(&pose.across);
        let mut held = self.own;
        let n = body.layout.n_velocities;
        if n > 0 {
            let columns = from_real(&pose.joint);
            let by_velocity = product(&self.own, &columns);
            let mut felt_by_joint = transposed_product(&columns, &by_velocity);
            for (k, [stiffness, damping]) in pose.springs.iter().enumerate() {
                felt_by_joint[(k, k)] += if k < n { joints.passive(*damping, *stiffness) } else { T::one() };
            }
            self.joint_mobility = T::inverse_of_inertia(&felt_by_joint).ok_or("joint coordinates")?;
            self.by_joint_force = product(&by_velocity, &self.joint_mobility);
            self.joint_share = self.by_joint_force.transpose();
            held -= product(&self.by_joint_force, &by_velocity.transpose());
        }
        Ok(transposed_product(&across, &product(&held, &across)))
    }
}

/// A real matrix among others.
pub(super) fn from_real<T: Number>(matrix: &Matrix6<f64>) -> Matrix6<T> {
    matrix.map(T::from_real)
}

/// `columns diag(weights) othersᵀ` of two sets of columns of six; no columns count as zero.
fn weighed<T: Number>(columns: &[SpatialVector], weights: &[T], others: &[SpatialVector]) -> Matrix6<T> {
    let mut out = [[T::zero(); 6]; 6];
    if !columns.is_empty() {
        // Three rows at a time: their sums stay in registers, and none waits for another.
        for (half, sums) in out.as_chunks_mut::<3>().0.iter_mut().enumerate() {
            for ((column, g), other) in columns.iter().zip(weights).zip(others) {
                for (r, sums) in sums.iter_mut().enumerate() {
                    let weight = g.scale(column[3 * half + r]);
                    sums.iter_mut().zip(other).for_each(|(sum, o)| *sum += weight.scale(*o));
                }
            }
        }
    }
    Matrix6::from_array_storage(ArrayStorage(out)).transpose()
}
