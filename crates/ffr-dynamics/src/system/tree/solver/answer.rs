//! Motion of the tree under given forces.

use nalgebra::{Matrix6, Scalar, Vector3, Vector6};

use super::factors::{FactorisedTree, from_real};
use super::number::{Number, applied, transposed_applied};
use crate::system::model::MultibodyModel;
use crate::system::tree::kinematics::{SpatialVector, join};

/// Forces on all bodies, and what they do.
#[derive(Debug, Clone)]
pub(in crate::system) struct Answer<T: Scalar> {
    /// Forces and moments on the frames, in body axes.
    pub frame_forces: Vec<[T; 6]>,
    /// Forces on elastic coordinates and along the free velocities of the joints, in the order of
    /// rates.
    pub forces: Vec<T>,
    /// Accelerations of all coordinates, in the order of rates.
    pub rates: Vec<T>,
    /// Accelerations of the frames, in body axes; less gravity if there is some.
    pub frames: Vec<[T; 6]>,
    /// Forces and moments of the joints on the bodies, at the parents' markers and in the parents'
    /// axes.
    pub wrenches: Vec<[T; 6]>,
    courses: Vec<Course<T>>,
}

/// One body between the way to ground and the way back.
#[derive(Debug, Clone)]
struct Course<T: Scalar> {
    /// Forces on the modes.
    forces: Vec<T>,
    /// Motion of the modes.
    modes: Vec<T>,
    /// Force on the frame with that of all that is attached.
    on_frame: Vector6<T>,
    /// Motion of the place that the joint holds while neither the frame moves nor the joint acts.
    gives_way: Vector6<T>,
    /// Motions of the markers of the bodies attached, without what the frame, the own joint and
    /// later ones bring.
    markers: Vec<Vector6<T>>,
    /// Forces of the bodies attached.
    attached: Vec<Vector6<T>>,
    /// Force that the joint gives while neither the parent's marker nor its velocities move, less.
    at_rest: Vector6<T>,
    /// Velocities of the joint while the parent's marker does not move.
    joint: Vector6<T>,
    /// Force on the parent's marker while that does not move.
    given: Vector6<T>,
    /// Motion of the parent's marker.
    parent: Vector6<T>,
}

impl<T: Number> Answer<T> {
    /// Space for the bodies of `model`; no forces.
    pub fn new(model: &MultibodyModel) -> Self {
        let n = model.bodies.len();
        let courses = model.bodies.iter().zip(&model.children);
        Self {
            frame_forces: vec![[T::zero(); 6]; n],
            forces: vec![T::zero(); model.n_rates()],
            rates: vec![T::zero(); model.n_rates()],
            frames: vec![[T::zero(); 6]; n],
            wrenches: vec![[T::zero(); 6]; n],
            courses: courses.map(|(b, children)| Course::new(b.layout.n_modes, children.len())).collect(),
        }
    }

    /// No forces.
    pub fn clear(&mut self) {
        self.frame_forces.fill([T::zero(); 6]);
        self.forces.fill(T::zero());
    }

    /// Forces on the uncoupled modes of body `body` in the end: with those of its joints and of the
    /// inertia of its frame.
    pub fn modal_forces(&self, body: usize) -> &[T] {
        &self.courses[body].forces
    }

    /// Accelerations under the forces; with `gravity` also by that, by velocities and by prescribed
    /// motions.
    pub fn solve(&mut self, tree: FactorisedTree<'_, T>, gravity: Option<&Vector3<f64>>) {
        let has_biases = gravity.is_some();
        for &i in tree.model.order.iter().rev() {
            self.gather(tree, i, has_biases);
        }
        // Ground falls against gravity.
        let ground = gravity.map_or([0.0; 6], |g| join(&-g, &Vector3::zeros()));
        for &i in &tree.model.order {
            if tree.model.bodies[i].joint.parent.body.is_none() {
                self.courses[i].parent = Vector6::from(ground.map(T::from_real));
            }
            self.place(tree, i, has_biases);
        }
    }

    /// Forces of body `i` and all that is attached to it, as its parent feels them.
    fn gather(
        &mut self,
        FactorisedTree { model, pose: tree, factors }: FactorisedTree<'_, T>,
        i: usize,
        has_biases: bool,
    ) {
        let (body, children) = (&model.bodies[i], &model.children[i]);
        let (pose, factor) = (&tree.bodies[i], &factors.bodies[i]);
        let Course { forces, modes, markers, .. } = &mut self.courses[i];
        body.modes.forces(&self.forces[body.layout.rates_elastic()], forces);
        modes.iter_mut().zip(forces.iter().zip(&factor.modes)).for_each(|(z, (f, g))| *z = *f * *g);
        let mut on_frame = Vector6::from(self.frame_forces[i]) - times(&pose.coupling, modes);
        let mut gives_way = times(&pose.own, modes);
        for (marker, &child) in markers.iter_mut().zip(children) {
            *marker = times(&tree.bodies[child].parent, modes);
            if has_biases {
                *marker += tree.bodies[child].parent_bias.map(T::from_real);
            }
        }
        for (k, &child) in children.iter().enumerate() {
            let given = self.courses[child].given;
            let (attached, row) = (&factor.attached[k], k * children.len());
            let markers = &mut self.courses[i].markers;
            markers[k] = applied(&attached.gate, &(markers[k] + applied(&factor.between[row + k], &given)));
            let force = given - applied(&factors.felt[child], &markers[k]);
            on_frame += transposed_applied(&attached.by_frame, &force);
            gives_way += transposed_applied(&attached.by_own, &force);
            for (a, marker) in markers.iter_mut().enumerate().skip(k + 1) {
                *marker += applied(&factor.between[a * children.len() + k], &force);
            }
        }
        let course = &mut self.courses[i];
        course.on_frame = on_frame;
        course.at_rest = if pose.own.is_empty() {
            on_frame
        } else {
            course.gives_way = gives_way;
            applied(&factor.own, &gives_way) + transposed_applied(&factor.frame_by_place, &on_frame)
        };
        if has_biases {
            course.at_rest -= applied(&factor.own, &pose.bias.map(T::from_real));
        }
        let n = body.layout.n_velocities;
        course.joint = Vector6::zeros();
        let mut force = course.at_rest;
        if n > 0 {
            course.joint.rows_mut(0, n).copy_from_slice(&self.forces[body.layout.rates_joint()]);
            let along = course.joint + transposed_applied(&from_real(&pose.joint), &course.at_rest);
            course.joint = applied(&factor.joint_mobility, &along);
            force -= applied(&factor.by_joint_force, &along);
        }
        course.given = transposed_applied(&from_real(&pose.across), &force);
    }

    /// Motion of body `i` from that of the parent's marker; leaves the motions of its children's
    /// markers.
    fn place(
        &mut self,
        FactorisedTree { model, pose: tree, factors }: FactorisedTree<'_, T>,
        i: usize,
        has_biases: bool,
    ) {
        let (body, children) = (&model.bodies[i], &model.children[i]);
        let (pose, factor) = (&tree.bodies[i], &factors.bodies[i]);
        let course = &mut self.courses[i];
        let across: Matrix6<T> = from_real(&pose.across);
        let mut moved = applied(&across, &course.parent);
        if body.layout.n_velocities > 0 {
            let velocities = course.joint - applied(&factor.joint_share, &moved);
            self.rates[body.layout.rates_joint()]
                .copy_from_slice(&velocities.as_slice()[..body.layout.n_velocities]);
            moved += applied(&from_real(&pose.joint), &velocities);
        }
        let force = applied(&factor.own, &moved) - course.at_rest;
        self.wrenches[i] = transposed_applied(&across, &force).into();
        if has_biases {
            moved += pose.bias.map(T::from_real);
        }
        let frame = if pose.own.is_empty() {
            moved
        } else {
            applied(&factor.frame_by_force, &course.on_frame)
                + applied(&factor.frame_by_place, &(moved - course.gives_way))
        };
        self.frames[i] = frame.into();
        for (k, &child) in children.iter().enumerate().rev() {
            let course = &mut self.courses[i];
            let attached = &factor.attached[k];
            let mut free = applied(&attached.by_frame, &frame);
            if !tree.bodies[child].parent.is_empty() {
                free += applied(&attached.by_own, &force);
                for b in k + 1..children.len() {
                    free += applied(&factor.between[k * children.len() + b], &course.attached[b]);
                }
            }
            let marker = course.markers[k] + applied(&attached.gate, &free);
            self.courses[child].parent = marker;
            let given = self.courses[child].given;
            self.courses[i].attached[k] = given - applied(&factors.felt[child], &marker);
        }
        let Course { forces, modes, attached, .. } = &mut self.courses[i];
        subtract_transposed(&pose.coupling, &frame, forces);
        subtract_transposed(&pose.own, &-force, forces);
        for (on_marker, &child) in attached.iter().zip(children) {
            subtract_transposed(&tree.bodies[child].parent, &-on_marker, forces);
        }
        modes.iter_mut().zip(forces.iter().zip(&factor.modes)).for_each(|(z, (f, g))| *z = *f * *g);
        body.modes.coordinates(modes, &mut self.rates[body.layout.rates_elastic()]);
    }
}

impl<T: Number> Course<T> {
    fn new(n_modes: usize, n_children: usize) -> Self {
        let zero = Vector6::zeros();
        Self {
            forces: vec![T::zero(); n_modes],
            modes: vec![T::zero(); n_modes],
            on_frame: zero,
            gives_way: zero,
            markers: vec![zero; n_children],
            attached: vec![zero; n_children],
            at_rest: zero,
            joint: zero,
            given: zero,
            parent: zero,
        }
    }
}

/// Columns of six times a vector; no columns count as zero.
fn times<T: Number>(columns: &[SpatialVector], vector: &[T]) -> Vector6<T> {
    let mut out = [T::zero(); 6];
    for (column, x) in columns.iter().zip(vector) {
        out.iter_mut().zip(column).for_each(|(o, c)| *o += x.scale(*c));
    }
    Vector6::from(out)
}

/// Subtracts the transpose of columns of six times `factors`.
fn subtract_transposed<T: Number>(columns: &[SpatialVector], factors: &Vector6<T>, out: &mut [T]) {
    for (o, column) in out.iter_mut().zip(columns) {
        let sum = factors.iter().zip(column).fold(T::zero(), |sum, (f, c)| sum + f.scale(*c));
        *o -= sum;
    }
}
