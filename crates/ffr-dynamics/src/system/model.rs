//! A multibody system with names resolved: a tree of bodies, loops, loads. Immutable.

use std::ops::Range;

use nalgebra::Vector3;

use super::free_body::deformation::DeformationMaps;
use super::free_body::uncoupled_modes::UncoupledModes;
use super::joints::bearing::JointBearing;
use super::joints::forces::check;
use super::joints::{CoordinateForce, JointKind, TimeFunction};
use crate::body::StandardInputData;
use crate::data_error::DataError;
use crate::error::DynamicsError;
use crate::kinematics::Marker;
use gear::{Gear, GearJoint, resolve as resolve_gears};
use specification::{BodySpec, SystemSpec};
use tree_order::{Parent, order_from_ground};

mod breaks;
pub mod specification;
mod resolution;
pub mod gear;
pub mod stops;
pub mod tree_order;

pub(super) use resolution::check_damping;
use resolution::{NamedBodies, check_names, check_suits_model, loop_joint, resolve_loads, tree_joints};

/// A marker with its body; `None` is ground.
#[derive(Debug, Clone)]
pub struct Site {
    /// The body.
    pub body: Parent,
    /// The marker.
    pub marker: Marker,
}

/// The joint whose child a body is.
#[derive(Debug, Clone)]
pub struct TreeJoint {
    /// Name.
    pub name: String,
    /// Kind.
    pub kind: JointKind,
    /// Marker nearer to ground.
    pub parent: Site,
    /// Marker on the body itself.
    pub child: Marker,
    /// Forces along the velocities; empty if there are none.
    pub coordinates: Vec<CoordinateForce>,
    /// Friction by the load that the joint transmits.
    pub(super) bearing: Option<JointBearing>,
}

impl TreeJoint {
    /// Motion prescribed to velocity `k`.
    pub fn prescribed(&self, k: usize) -> Option<&TimeFunction> {
        self.coordinates.get(k).and_then(|c| c.motion.as_ref())
    }

    /// Velocities that are unknowns.
    pub fn free_velocities(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.kind.n_velocities()).filter(|k| self.prescribed(*k).is_none())
    }
}

/// Place of one body's coordinates in the state vector: joint positions, `q_e`, joint velocities,
/// `dq_e/dt`.
///
/// Prescribed coordinates take no place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TreeLayout {
    /// Index of the first coordinate.
    pub offset: usize,
    /// Number of joint positions.
    pub n_positions: usize,
    /// Number of joint velocities.
    pub n_velocities: usize,
    /// Number of elastic coordinates.
    pub n_modes: usize,
    /// Index of the first rate among all rates, which are ordered `dq_e/dt`, joint velocities, body
    /// by body.
    pub rates_offset: usize,
}

impl TreeLayout {
    /// Joint positions.
    pub fn positions(&self) -> Range<usize> {
        self.offset..self.offset + self.n_positions
    }

    /// Elastic coordinates.
    pub fn elastic(&self) -> Range<usize> {
        let start = self.offset + self.n_positions;
        start..start + self.n_modes
    }

    /// Joint velocities.
    pub fn velocities(&self) -> Range<usize> {
        let start = self.offset + self.n_positions + self.n_modes;
        start..start + self.n_velocities
    }

    /// Elastic rates.
    pub fn elastic_rates(&self) -> Range<usize> {
        let start = self.offset + self.n_positions + self.n_modes + self.n_velocities;
        start..start + self.n_modes
    }

    /// Number of state variables.
    pub fn len(&self) -> usize {
        self.n_positions + self.n_velocities + 2 * self.n_modes
    }

    /// Whether the body has no coordinates: rigid, and fixed or moved as prescribed.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Number of rates.
    pub fn n_rates(&self) -> usize {
        self.n_modes + self.n_velocities
    }

    /// Elastic rates among all rates.
    pub fn rates_elastic(&self) -> Range<usize> {
        self.rates_offset..self.rates_offset + self.n_modes
    }

    /// Joint velocities among all rates.
    pub fn rates_joint(&self) -> Range<usize> {
        self.rates_offset + self.n_modes..self.rates_offset + self.n_rates()
    }
}

/// A body in the tree.
#[derive(Debug, Clone)]
pub struct TreeBody {
    /// Name.
    pub name: String,
    /// Inertia, modes, stiffness, damping.
    pub data: StandardInputData,
    /// Its markers.
    pub markers: Vec<Marker>,
    /// The joint whose child it is.
    pub joint: TreeJoint,
    /// Its place in the state vector.
    pub layout: TreeLayout,
    /// Its modes without coupling.
    pub(super) modes: UncoupledModes,
    /// Changes of its moments of inertia by deformation.
    pub(super) deformation: DeformationMaps,
}

impl TreeBody {
    /// Its joint as far as gears are concerned.
    fn gear_joint(&self) -> GearJoint<'_> {
        let mut rates = [None; 6];
        self.joint
            .free_velocities()
            .zip(self.layout.rates_joint())
            .for_each(|(k, rate)| rates[k] = Some(rate));
        GearJoint { name: &self.joint.name, kind: self.joint.kind, rates }
    }
}

/// A joint that closes a loop.
#[derive(Debug, Clone)]
pub struct LoopJoint {
    /// Name.
    pub name: String,
    /// Kind.
    pub kind: JointKind,
    /// One marker.
    pub parent: Site,
    /// The other.
    pub child: Site,
}

/// A load on a marker.
#[derive(Debug, Clone)]
pub struct Load {
    /// Name.
    pub name: String,
    /// The body.
    pub body: usize,
    /// The marker.
    pub marker: Marker,
    /// Force and moment over time.
    pub components: [Option<TimeFunction>; 6],
    /// Whether the axes turn with the marker.
    pub is_following: bool,
}

/// A multibody system, ready to be evaluated.
#[derive(Debug, Clone)]
pub struct MultibodyModel {
    /// Bodies in the order given; force elements number them so.
    pub bodies: Vec<TreeBody>,
    /// Bodies with parents before children.
    pub order: Vec<usize>,
    /// Children of each body in the tree, in that order.
    pub(super) children: Vec<Vec<usize>>,
    /// Loop-closing joints.
    pub loops: Vec<LoopJoint>,
    /// Gears.
    pub gears: Vec<Gear>,
    /// Loads.
    pub loads: Vec<Load>,
    /// Gravity [m/s²].
    pub gravity: Vector3<f64>,
    /// For each body the number of the group that `fixed` joints connect it with, and the bodies of each group.
    fixed: Vec<usize>,
    fixed_bodies: Vec<Vec<usize>>,
    n_states: usize,
}

impl MultibodyModel {
    /// Resolves names, orders the tree and checks that joints suit their bodies.
    ///
    /// # Errors
    /// Names: [`DynamicsError::DuplicateName`], [`DynamicsError::UnknownBody`],
    /// [`DynamicsError::UnknownMarker`]; structure: [`DynamicsError::JointCycle`],
    /// [`DynamicsError::OverConstrained`], [`DynamicsError::Joint`]; numbers:
    /// [`DynamicsError::Data`].
    pub fn new(spec: SystemSpec) -> Result<Self, DynamicsError> {
        check_names(&spec)?;
        if !spec.gravity.norm().is_finite() {
            return Err(DataError::NotFinite { what: "gravity".into() }.into());
        }
        let named = NamedBodies::new(&spec);
        let joints = tree_joints(&named)?;
        let parents: Vec<Parent> = joints.iter().map(|j| j.parent.body).collect();
        let order = order_from_ground(&parents, |i| spec.bodies[i].name.clone(), |i| joints[i].name.clone())?;
        for (i, joint) in joints.iter().enumerate() {
            check(&joint.name, joint.kind, &joint.coordinates)?;
            check_suits_model(&spec.bodies[i], joint, joint.parent.body.map(|p| &spec.bodies[p]))?;
        }
        let loops = spec.loops.iter().map(|joint| loop_joint(&named, joint)).collect::<Result<_, _>>()?;
        let loads = resolve_loads(&named)?;
        let mut bodies = Vec::with_capacity(spec.bodies.len());
        let (mut offset, mut rates_offset) = (0, 0);
        for (BodySpec { name, data, markers }, joint) in spec.bodies.into_iter().zip(joints) {
            check_damping(&name, &data)?;
            let n_velocities = joint.free_velocities().count();
            let n_positions = n_velocities + joint.kind.n_positions() - joint.kind.n_velocities();
            let n_modes = data.n_modes();
            let layout = TreeLayout { offset, n_positions, n_velocities, n_modes, rates_offset };
            offset += layout.len();
            rates_offset += layout.n_rates();
            let modes = UncoupledModes::new(&data)?;
            let deformation = DeformationMaps::new(&data);
            bodies.push(TreeBody { name, data, markers, joint, layout, modes, deformation });
        }
        let mut children = vec![Vec::new(); bodies.len()];
        for &i in &order {
            if let Some(p) = parents[i] {
                children[p].push(i);
            }
        }
        let gears = resolve_gears(&spec.gears, &bodies.iter().map(TreeBody::gear_joint).collect::<Vec<_>>())?;
        let (gravity, fixed, fixed_bodies) = (spec.gravity, Vec::new(), vec![Vec::new(); bodies.len()]);
        let n_states = offset;
        let mut model =
            Self { bodies, order, children, loops, gears, loads, gravity, fixed, fixed_bodies, n_states };
        model.fixed = model.groups_by(|kind| kind == JointKind::Fixed);
        for (body, group) in model.fixed.iter().enumerate() {
            model.fixed_bodies[*group].push(body);
        }
        Ok(model)
    }

    /// Whether there are constraints beside the joints of the tree.
    pub fn has_constraints(&self) -> bool {
        !self.loops.is_empty() || !self.gears.is_empty()
    }

    /// Number of state variables of all bodies.
    pub fn n_states(&self) -> usize {
        self.n_states
    }

    /// Number of rates of all bodies.
    pub fn n_rates(&self) -> usize {
        self.bodies.iter().map(|b| b.layout.n_rates()).sum()
    }

    /// Moves the coordinates of the state `y` by `change`, by their rates.
    pub(super) fn displace(&self, y: &mut [f64], change: &[f64]) {
        for TreeBody { joint, layout, .. } in &self.bodies {
            let elastic = y[layout.elastic()].iter_mut().zip(&change[layout.rates_elastic()]);
            elastic.for_each(|(q, change)| *q += change);
            joint.kind.displace(&mut y[layout.positions()], &change[layout.rates_joint()]);
        }
    }

    /// Index of the body called `name`.
    pub fn body_index(&self, name: &str) -> Option<usize> {
        self.bodies.iter().position(|b| b.name == name)
    }

    /// For each body the number of the group that it is joined to, those with ground left aside.
    pub fn groups(&self) -> Vec<usize> {
        self.groups_by(|kind| kind != JointKind::Free)
    }

    /// The bodies that `fixed` joints connect with `body`, itself among them.
    pub fn fixed_to(&self, body: usize) -> impl Iterator<Item = usize> + '_ {
        self.fixed_bodies[self.fixed[body]].iter().copied()
    }

    /// The groups of bodies that joints of some kinds connect.
    fn groups_by(&self, connects: impl Fn(JointKind) -> bool) -> Vec<usize> {
        let mut group: Vec<usize> = (0..self.bodies.len()).collect();
        let tree = self.bodies.iter().enumerate();
        let in_tree = tree.filter_map(|(i, b)| Some((b.joint.kind, i, b.joint.parent.body?)));
        let in_loops = self.loops.iter().filter_map(|j| Some((j.kind, j.child.body?, j.parent.body?)));
        for (_, a, b) in in_tree.chain(in_loops).filter(|(kind, ..)| connects(*kind)) {
            let (from, to) = (group[a], group[b]);
            group.iter_mut().filter(|g| **g == from).for_each(|g| *g = to);
        }
        group
    }

    /// Joint positions, velocities and prescribed accelerations of a body at time `t` in the state
    /// `y`.
    pub(super) fn joint_coordinates(&self, body: usize, t: f64, y: &[f64]) -> JointCoordinates {
        let TreeBody { joint, layout, .. } = &self.bodies[body];
        let mut full = JointCoordinates::default();
        let (positions, velocities) = (&y[layout.positions()], &y[layout.velocities()]);
        if layout.n_velocities == joint.kind.n_velocities() {
            full.positions[..positions.len()].copy_from_slice(positions);
            full.velocities[..velocities.len()].copy_from_slice(velocities);
            return full;
        }
        let mut free = 0; // joints with prescribed motion have no quaternion
        for k in 0..joint.kind.n_velocities() {
            if let Some(motion) = joint.prescribed(k) {
                [full.positions[k], full.velocities[k], full.accelerations[k]] = motion.at(t);
            } else {
                full.positions[k] = positions[free];
                full.velocities[k] = velocities[free];
                free += 1;
            }
        }
        full
    }
}

/// All coordinates of a joint, free and prescribed.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct JointCoordinates {
    /// Positions, the first as many as the joint has.
    pub positions: [f64; 7],
    /// Velocities, likewise.
    pub velocities: [f64; 6],
    /// Accelerations of prescribed coordinates; zero for free ones.
    pub accelerations: [f64; 6],
}
