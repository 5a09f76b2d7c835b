//! Forces and moments that joints and loads exert on a body, and the centrifugal force of its spin:
//! the loads whose static answers its basis has (docs/theory.md Eq. R.27).

use faer::Mat;
use ffr_dynamics::DynamicsError;
use ffr_dynamics::body::AssembledBody;
use ffr_dynamics::data_error::DataError;
use ffr_dynamics::kinematics::MarkerWeights;
use ffr_dynamics::system::{FreeDirections, JointKind};
use iga_core::extent::Extent;
use iga_core::nurbs::jet::diagonal;
use nalgebra::{UnitQuaternion, Vector3};

use crate::spec::{
    Area, Attachment, BodyKind, CoordinateSpec, Coupling, JointSpec, LoadSpec, Place, RunSpec,
};

/// Strain of a spin, `(ω a/c)²` with half the body's diagonal a and the speed c of its slowest waves
/// along bars, from which on the basis answers it: 0.2 MPa in steel, nothing that anybody looks for
/// beside an impact. Its pseudo-mode would cost shorter steps.
const STRAIN_OF_SPIN: f64 = 1e-6;
/// Centrifugal forces that are linearly independent: products of two components of the axis.
const MOST_AXES: usize = 6;
/// Sine of the angle between two axes that are one.
const SAME_AXIS: f64 = 1e-3;

/// The loads to whose static answers a basis is asked for.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct StaticLoads {
    /// Those of joints and loads.
    pub markers: Vec<MarkerLoads>,
    /// Unit axes in the body's frame about which it turns so fast that the centrifugal force strains
    /// it.
    pub spins: Vec<Vector3<f64>>,
}

/// The directions in which a joint or a load acts on a marker of a body.
#[derive(Debug, Clone, PartialEq)]
pub struct MarkerLoads {
    /// What acts, `hinge (child)` or the name of a load.
    pub name: String,
    /// Where.
    pub place: Place,
    /// Independent directions of the force along and the moment about the body's axes, of unit
    /// length.
    pub directions: Vec<[f64; 6]>,
}

/// Which end of a joint an attachment is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Side {
    Parent,
    Child,
}

/// Relative error of what a disc or ball yields under its own load above which its elements are too
/// coarse (Eq. P.9).
pub const PLACE_ERROR: f64 = 5e-2;

/// A disc or ball on which a load acts, and the elements that it needs.
#[derive(Debug, Clone, Copy)]
pub struct HeldPlace<'a> {
    /// The place.
    pub area: &'a Area,
    /// Its centre, in the model's components \[m\].
    pub point: [f64; 3],
    /// Its radius \[m\].
    pub radius: f64,
    /// Elements over the radius at which it yields right to [`PLACE_ERROR`].
    pub elements: f64,
}

impl From<Vec<MarkerLoads>> for StaticLoads {
    fn from(markers: Vec<MarkerLoads>) -> Self {
        Self { markers, spins: Vec::new() }
    }
}

impl StaticLoads {
    /// The loads of body `index` of `spec`, which has the angular velocities `turns` in its frame
    /// [rad/s].
    pub fn on_body(spec: &RunSpec, index: usize, turns: &[Vector3<f64>]) -> Self {
        Self { markers: MarkerLoads::on_body(spec, index), spins: spins(&spec.bodies[index].kind, turns) }
    }

    fn n_columns(&self) -> usize {
        self.markers.iter().map(|load| load.directions.len()).sum::<usize>() + self.spins.len()
    }

    /// How many coordinates of a basis come from what, if it has the static answers to the load
    /// columns `taken`.
    pub fn answers(&self, taken: &[usize]) -> Vec<(String, usize)> {
        let mut first = 0;
        let mut count = |n: usize| {
            let range = first..first + n;
            first = range.end;
            taken.iter().filter(|column| range.contains(column)).count()
        };
        let markers = self.markers.iter().map(|load| (load.name.clone(), load.directions.len()));
        let spin = (!self.spins.is_empty()).then(|| ("spin".to_owned(), self.spins.len()));
        markers.chain(spin).map(|(name, n)| (name, count(n))).collect()
    }
}

/// The axes about which a body of the given `kind` turns fast, among its angular velocities `turns`.
fn spins(kind: &BodyKind, turns: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
    let (Some(size), Some(material)) = (kind.diagonal(), kind.slowest_material()) else { return Vec::new() };
    let slowest = STRAIN_OF_SPIN.sqrt() * material.bar_speed() / (0.5 * size);
    let mut axes: Vec<Vector3<f64>> = Vec::new();
    for turn in turns.iter().filter(|turn| turn.norm() > slowest) {
        let axis = turn.normalize();
        let is_new = axes.iter().all(|other| other.cross(&axis).norm() > SAME_AXIS);
        if is_new && axes.len() < MOST_AXES {
            axes.push(axis);
        }
    }
    axes
}

impl MarkerLoads {
    /// The disc or ball on which the load acts; none of points, faces and groups.
    pub fn held_place(&self) -> Option<HeldPlace<'_>> {
        let Place::Area(area) = &self.place else { return None };
        let Extent::Around { point, radius } = &area.extent else { return None };
        let is_moment = self.directions.iter().any(|d| d[3..].iter().any(|m| *m != 0.0));
        let elements = elements_per_radius(area.coupling, is_moment);
        Some(HeldPlace { area, point: *point, radius: *radius, elements })
    }

    /// What the joints and loads of `spec` exert on body `index`: joints in the directions in which
    /// they hold or drive it, loads along their components.
    pub fn on_body(spec: &RunSpec, index: usize) -> Vec<Self> {
        let mut all = Vec::new();
        for joint in spec.joints.iter().chain(&spec.loops) {
            for (side, at) in [(Side::Parent, &joint.parent), (Side::Child, &joint.child)] {
                let name =
                    format!("{} ({})", joint.name, if side == Side::Parent { "parent" } else { "child" });
                all.extend(on_marker(name, at, index, &joint_directions(joint, side, &geared(spec, joint))));
            }
        }
        for load in &spec.loads {
            all.extend(on_marker(load.name.clone(), &load.at, index, &load_directions(load)));
        }
        all
    }
}

/// Elements over the radius of a disc or ball at which it yields right to [`PLACE_ERROR`]
/// (Eq. P.9): `C (h/a)²` is missing on average, `C h/a` of a rigid one, whose elements at the rim
/// are rigid as a whole; more under moments, which turn no more than the place itself.
fn elements_per_radius(coupling: Coupling, is_moment: bool) -> f64 {
    match (coupling, is_moment) {
        (Coupling::Average, false) => (0.05 / PLACE_ERROR).sqrt(),
        (Coupling::Average, true) => (0.25 / PLACE_ERROR).sqrt(),
        (Coupling::Rigid, false) => 0.6 / PLACE_ERROR,
        (Coupling::Rigid, true) => 1.0 / PLACE_ERROR,
    }
}

/// Loads along `directions` (three of the force, three of the moment) of the axes of `at`, if it is
/// on body `index`.
fn on_marker(name: String, at: &Attachment, index: usize, directions: &[bool; 6]) -> Option<MarkerLoads> {
    let is_loaded = at.body == Some(index) && directions.contains(&true);
    is_loaded.then(|| MarkerLoads {
        name,
        place: at.place.clone(),
        directions: in_body(directions, &at.rotation),
    })
}

/// The chosen axes in the body's frame; all three axes are taken as the body's own.
fn in_body(chosen: &[bool; 6], rotation: &UnitQuaternion<f64>) -> Vec<[f64; 6]> {
    let mut directions = Vec::new();
    for (part, chosen) in chosen.as_chunks::<3>().0.iter().enumerate() {
        let is_whole = !chosen.contains(&false);
        for axis in (0..3).filter(|&axis| chosen[axis]) {
            let unit = Vector3::ith(axis, 1.0);
            let along = if is_whole { unit } else { rotation * unit };
            let mut direction = [0.0; 6];
            direction[3 * part..3 * part + 3].copy_from_slice(along.as_slice());
            directions.push(direction);
        }
    }
    directions
}

/// Force and moment, along the axes of one side's marker, that `joint` can transmit.
///
/// A displaced joint exerts moments on its parent, at whose marker its force is counted.
fn joint_directions(joint: &JointSpec, side: Side, geared: &[usize]) -> [bool; 6] {
    let FreeDirections(free) = joint.kind.free_directions();
    let mut coordinates = 0..;
    let acts_along = |k: usize| {
        joint.coordinates.get(k).is_some_and(acts) || joint.bearing.is_some() || geared.contains(&k)
    };
    let mut transmits = free.map(|free| !free || coordinates.next().is_some_and(acts_along));
    if joint.kind == JointKind::Axial {
        return std::array::from_fn(|k| k == 2 && transmits[k]);
    }
    let (forces, moments) = transmits.split_at_mut(3);
    let turning: Vec<usize> = (0..3).filter(|&axis| free[3 + axis]).collect();
    match *turning {
        // Forces across the axis change their direction in the child.
        [axis] => mix(forces, [(axis + 1) % 3, (axis + 2) % 3]),
        // The parent's first axis and the child's second axis are free.
        [first, second] => {
            forces.fill(forces.contains(&true));
            let (of_first, of_second) = (moments[first], moments[second]);
            moments.fill(true);
            match side {
                Side::Parent => moments[first] = of_first,
                Side::Child => moments[second] = of_second,
            }
        }
        [_, _, _] => {
            forces.fill(forces.contains(&true));
            moments.fill(moments.contains(&true));
        }
        _ => {}
    }
    if side == Side::Parent {
        for (along, across) in (0..3).flat_map(|a| (0..3).map(move |b| (a, b))).filter(|(a, b)| a != b) {
            moments[3 - along - across] |= free[along] && forces[across];
        }
    }
    transmits
}

/// Both directions if one of them is chosen.
fn mix(chosen: &mut [bool], [a, b]: [usize; 2]) {
    let any = chosen[a] || chosen[b];
    (chosen[a], chosen[b]) = (any, any);
}

/// Coordinates of `joint` along which gears act.
fn geared(spec: &RunSpec, joint: &JointSpec) -> Vec<usize> {
    let ends = spec.gears.iter().flat_map(|gear| [gear.first, gear.second]);
    ends.filter(|(other, _)| std::ptr::eq(&raw const spec.joints[*other], joint)).map(|(_, k)| k).collect()
}

/// Whether anything acts along the coordinate, or its motion is prescribed.
fn acts(coordinate: &CoordinateSpec) -> bool {
    let CoordinateSpec { stiffness, rest: _, damping, stop, friction, drive, motion } = coordinate;
    *stiffness != 0.0
        || *damping != 0.0
        || stop.is_some()
        || friction.is_some()
        || drive.is_some()
        || motion.is_some()
}

/// Components of a load; one that keeps its direction in space comes from every side of a body that
/// turns.
fn load_directions(load: &LoadSpec) -> [bool; 6] {
    let given = load.components.each_ref().map(Option::is_some);
    if load.is_following {
        return given;
    }
    let part = |first: usize| given[first..first + 3].contains(&true);
    let (force, moment) = (part(0), part(3));
    [force, force, force, moment, moment, moment]
}

/// Forces on the unknowns of `body` under all `loads`, a column each (n × k): unit forces, moments of
/// a unit force on a lever of the body's size, and `M n × (n × x)` of a spin about n, whose part
/// that moves the body as a whole is balanced by its inertia.
///
/// # Errors
/// Those of `weights`, the markers of the places, and of unknowns that do not exist, by
/// `inconsistent`.
pub fn load_columns<E>(
    body: &AssembledBody,
    loads: &StaticLoads,
    weights: impl Fn(&Place) -> Result<MarkerWeights, E>,
    inconsistent: impl Fn(DynamicsError) -> E,
) -> Result<Mat<f64>, E> {
    let (n, lever) = (body.dofs.len(), 0.5 * diagonal(&body.nodes));
    let mut columns = Mat::zeros(n, loads.n_columns());
    let mut first = 0;
    for load in &loads.markers {
        let marker = weights(&load.place)?;
        for (unknown, w) in marker.entries() {
            let row = *unknown as usize;
            if row >= n {
                let what = "unknowns of a marker".into();
                return Err(inconsistent(DataError::Index { what, number: row, count: n }.into()));
            }
            for (j, direction) in load.directions.iter().enumerate() {
                let part = |range: std::ops::Range<usize>| -> f64 {
                    w[range.clone()].iter().zip(&direction[range]).map(|(a, b)| a * b).sum()
                };
                columns[(row, first + j)] = part(0..3) + lever * part(3..6);
            }
        }
        first += load.directions.len();
    }
    if !loads.spins.is_empty() {
        let accelerations = Mat::from_fn(n, loads.spins.len(), |i, j| acceleration(body, i, &loads.spins[j]));
        columns.subcols_mut(first, loads.spins.len()).copy_from(body.mass_product(accelerations.as_ref()));
    }
    Ok(columns)
}

/// Component of the unknown `i` of the acceleration `n × (n × x)` of a turn about `axis` at unit
/// rate: it is linear in the place, so that control points have their own; its curl is zero.
fn acceleration(body: &AssembledBody, i: usize, axis: &Vector3<f64>) -> f64 {
    let (dof, motion) = (&body.dofs[i], body.motion);
    let component = usize::from(dof.component);
    if component >= motion.n_components() {
        return 0.0;
    }
    let place = motion.in_space(&body.nodes[dof.node as usize]);
    axis.cross(&axis.cross(&place))[motion.direction(component)]
}
