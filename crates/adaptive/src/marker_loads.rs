//! Forces and moments that joints and loads exert on a body: the loads whose static answers its basis has (docs/theory.md Eq. R.21).

use faer::Mat;
use ffr_dynamics::DynamicsError;
use ffr_dynamics::body::AssembledBody;
use ffr_dynamics::data_error::DataError;
use ffr_dynamics::kinematics::MarkerWeights;
use ffr_dynamics::system::JointKind;
use iga_core::nurbs::jet::diagonal;
use nalgebra::{UnitQuaternion, Vector3};

use crate::spec::{Attachment, CoordinateSpec, JointSpec, LoadSpec, Place, RunSpec};

/// The directions in which a joint or a load acts on a marker of a body.
#[derive(Debug, Clone, PartialEq)]
pub struct MarkerLoads {
    /// What acts, `hinge (child)` or the name of a load.
    pub name: String,
    /// Where.
    pub place: Place,
    /// Independent directions of the force along and the moment about the body's axes, of unit length.
    pub directions: Vec<[f64; 6]>,
}

/// Which end of a joint an attachment is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Side {
    Parent,
    Child,
}

impl MarkerLoads {
    /// What the joints and loads of `spec` exert on body `index`: joints in the directions in which they hold or drive it, loads
    /// along their components.
    pub fn on_body(spec: &RunSpec, index: usize) -> Vec<Self> {
        let mut all = Vec::new();
        for joint in spec.joints.iter().chain(&spec.loops) {
            for (side, at) in [(Side::Parent, &joint.parent), (Side::Child, &joint.child)] {
                let name =
                    format!("{} ({})", joint.name, if side == Side::Parent { "parent" } else { "child" });
                all.extend(on_marker(name, at, index, &joint_directions(joint, side)));
            }
        }
        for load in &spec.loads {
            all.extend(on_marker(load.name.clone(), &load.at, index, &load_directions(load)));
        }
        all
    }
}

/// Loads along `directions` (three of the force, three of the moment) of the axes of `at`, if it is on body `index`.
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
fn joint_directions(joint: &JointSpec, side: Side) -> [bool; 6] {
    let is_active = |k: usize| joint.coordinates.get(k).is_some_and(acts);
    let (x, y, z) = (is_active(0), is_active(1), is_active(2));
    match joint.kind {
        JointKind::Fixed => [true; 6],
        JointKind::Revolute => [true, true, true, true, true, x],
        JointKind::Prismatic => [true, true, x, true, true, true],
        JointKind::Cylindrical => [true, true, x, true, true, y],
        // The parent's x axis and the child's y axis are free.
        JointKind::Universal if side == Side::Parent => [true, true, true, x, true, true],
        JointKind::Universal => [true, true, true, true, y, true],
        JointKind::Spherical => {
            let moment = x || y || z;
            [true, true, true, moment, moment, moment]
        }
        JointKind::Planar => {
            let force = x || y;
            [force, force, true, true, true, z || (force && side == Side::Parent)]
        }
        JointKind::Free => {
            let force = x || y || z;
            let moment = (3..6).any(is_active) || (force && side == Side::Parent);
            [force, force, force, moment, moment, moment]
        }
        JointKind::Axial => [false, false, x, false, false, false],
    }
}

/// Whether anything acts along the coordinate, or its motion is prescribed.
fn acts(coordinate: &CoordinateSpec) -> bool {
    let CoordinateSpec { stiffness, rest: _, damping, drive, motion } = coordinate;
    *stiffness != 0.0 || *damping != 0.0 || drive.is_some() || motion.is_some()
}

/// Components of a load; one that keeps its direction in space comes from every side of a body that turns.
fn load_directions(load: &LoadSpec) -> [bool; 6] {
    let given = load.components.each_ref().map(Option::is_some);
    if load.is_following {
        return given;
    }
    let part = |first: usize| given[first..first + 3].contains(&true);
    let (force, moment) = (part(0), part(3));
    [force, force, force, moment, moment, moment]
}

/// Forces on the unknowns of `body` under all `loads`, a column each (n × k): unit forces, and moments of a unit force on a lever of the
/// body's size.
///
/// # Errors
/// Those of `weights`, the markers of the places, and of unknowns that do not exist, by `inconsistent`.
pub fn load_columns<E>(
    body: &AssembledBody,
    loads: &[MarkerLoads],
    weights: impl Fn(&Place) -> Result<MarkerWeights, E>,
    inconsistent: impl Fn(DynamicsError) -> E,
) -> Result<Mat<f64>, E> {
    let (n, lever) = (body.dofs.len(), 0.5 * diagonal(&body.nodes));
    let mut columns = Mat::zeros(n, loads.iter().map(|l| l.directions.len()).sum());
    let mut first = 0;
    for load in loads {
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
    Ok(columns)
}

/// How many coordinates of a basis come from each of `loads`, if it has the static answers to the load columns `taken`.
pub fn answers_by_marker(loads: &[MarkerLoads], taken: &[usize]) -> Vec<(String, usize)> {
    let mut first = 0;
    let count = |load: &MarkerLoads| {
        let range = first..first + load.directions.len();
        first = range.end;
        (load.name.clone(), taken.iter().filter(|column| range.contains(column)).count())
    };
    loads.iter().map(count).collect()
}
