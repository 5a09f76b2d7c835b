//! From names to numbers: bodies, markers, joints and loads of a specification found and checked.

use std::collections::HashMap;

use nalgebra::{Matrix3, UnitQuaternion, Vector3};

use super::super::free_body::equations::active_directions;
use super::super::joints::JointKind;
use super::super::joints::bearing::bearing_of;
use super::super::model::specification::{Attachment, BodySpec, GROUND, JointSpec, SystemSpec};
use super::{Load, LoopJoint, Site, TreeJoint};
use crate::body::{ModalDamping, RigidMotion, StandardInputData};
use crate::data_error::DataError;
use crate::error::DynamicsError;
use crate::kinematics::Marker;

/// Deviation of axes above which a joint leads out of the plane or off the axis of a body's model;
/// angles typed in degrees.
const ALIGNMENT: f64 = 1e-9;

/// Refuses damping of another size, or negative.
pub(in crate::system) fn check_damping(name: &str, data: &StandardInputData) -> Result<(), DynamicsError> {
    let n_q = data.n_modes();
    let fits = match &data.modal_damping {
        ModalDamping::None => true,
        ModalDamping::PerMode(d) => d.len() == n_q && d.iter().all(|d| *d >= 0.0 && d.is_finite()),
        ModalDamping::Full(d) => d.nrows() == n_q && d.ncols() == n_q && (0..n_q).all(|i| d[(i, i)] >= 0.0),
    };
    if fits {
        return Ok(());
    }
    Err(DataError::Damping { body: name.to_owned(), modes: n_q }.into())
}

/// Refuses two bodies, joints, gears, loads or markers of one body with the same name.
pub(super) fn check_names(spec: &SystemSpec) -> Result<(), DynamicsError> {
    fn repeated<'a>(names: impl Iterator<Item = &'a str>) -> Option<String> {
        let mut seen = std::collections::BTreeSet::new();
        names.into_iter().find(|name| !seen.insert(*name)).map(str::to_string)
    }
    let fail = |what, name| Err(DynamicsError::DuplicateName { what, name });
    let bodies = spec.bodies.iter().map(|b| b.name.as_str());
    if let Some(name) = repeated(bodies.chain([GROUND])) {
        return fail("bodies", name);
    }
    if let Some(name) = repeated(spec.joints.iter().chain(&spec.loops).map(|j| j.name.as_str())) {
        return fail("joints", name);
    }
    if let Some(name) = repeated(spec.gears.iter().map(|g| g.name.as_str())) {
        return fail("gears", name);
    }
    if let Some(name) = repeated(spec.loads.iter().map(|l| l.name.as_str())) {
        return fail("loads", name);
    }
    let groups = spec.bodies.iter().map(|b| &b.markers).chain([&spec.ground]);
    for markers in groups {
        if let Some(name) = repeated(markers.iter().map(|m| m.name.as_str())) {
            return fail("markers of one body", name);
        }
    }
    Ok(())
}

/// A specification whose bodies are found by name at once.
pub(super) struct NamedBodies<'a> {
    spec: &'a SystemSpec,
    numbers: HashMap<&'a str, usize>,
}

impl<'a> NamedBodies<'a> {
    pub fn new(spec: &'a SystemSpec) -> Self {
        let numbers = spec.bodies.iter().enumerate().map(|(i, body)| (body.name.as_str(), i)).collect();
        Self { spec, numbers }
    }
}

/// Marker by name.
fn resolve(named: &NamedBodies<'_>, user: &str, at: &Attachment) -> Result<Site, DynamicsError> {
    let spec = named.spec;
    let list = |names: Vec<&str>| if names.is_empty() { "none".to_string() } else { names.join(", ") };
    let (body, markers, n_modes) = if at.body == GROUND {
        (None, &spec.ground, 0)
    } else {
        let Some(&i) = named.numbers.get(at.body.as_str()) else {
            let names = [GROUND].into_iter().chain(spec.bodies.iter().map(|b| b.name.as_str()));
            return Err(DynamicsError::UnknownBody {
                user: user.to_string(),
                body: at.body.clone(),
                known: list(names.collect()),
            });
        };
        (Some(i), &spec.bodies[i].markers, spec.bodies[i].data.n_modes())
    };
    let Some(marker) = markers.iter().find(|m| m.name == at.marker) else {
        return Err(DynamicsError::UnknownMarker {
            user: user.to_string(),
            body: at.body.clone(),
            marker: at.marker.clone(),
            known: list(markers.iter().map(|m| m.name.as_str()).collect()),
        });
    };
    if marker.n_modes() != 0 && marker.n_modes() != n_modes {
        let fault = format!(
            "marker \"{marker}\" has {found} elastic coordinates, its body \"{body}\" {n_modes}",
            marker = marker.name,
            found = marker.n_modes(),
            body = at.body
        );
        return Err(DynamicsError::Joint { joint: user.to_string(), fault });
    }
    Ok(Site { body, marker: marker.clone() })
}

/// The joint of each body; bodies without one are free.
pub(super) fn tree_joints(named: &NamedBodies<'_>) -> Result<Vec<TreeJoint>, DynamicsError> {
    let spec = named.spec;
    let mut joints: Vec<Option<TreeJoint>> = spec.bodies.iter().map(|_| None).collect();
    for JointSpec { name, kind, parent, child, coordinates, bearing } in &spec.joints {
        let (parent, child) = (resolve(named, name, parent)?, resolve(named, name, child)?);
        let Some(body) = child.body else {
            return Err(DynamicsError::Joint {
                joint: name.clone(),
                fault: "its child is ground; exchange parent and child".into(),
            });
        };
        if let Some(first) = &joints[body] {
            return Err(DynamicsError::OverConstrained {
                body: spec.bodies[body].name.clone(),
                first: first.name.clone(),
                second: name.clone(),
            });
        }
        joints[body] = Some(TreeJoint {
            name: name.clone(),
            kind: *kind,
            parent,
            child: child.marker,
            coordinates: coordinates.clone(),
            bearing: bearing.map(|bearing| bearing_of(name, *kind, bearing)).transpose()?,
        });
    }
    let frame = || Marker::rigid("frame", Vector3::zeros(), UnitQuaternion::identity());
    let free = |body: &BodySpec| TreeJoint {
        name: body.name.clone(),
        kind: match body.data.motion {
            RigidMotion::Axial => JointKind::Axial,
            RigidMotion::Planar => JointKind::Planar,
            RigidMotion::Spatial => JointKind::Free,
        },
        parent: Site { body: None, marker: frame() },
        child: frame(),
        coordinates: Vec::new(),
        bearing: None,
    };
    Ok(joints
        .into_iter()
        .zip(&spec.bodies)
        .map(|(joint, body)| joint.unwrap_or_else(|| free(body)))
        .collect())
}

/// Refuses joints that lead out of the plane of a plane model, or off the axis of an axisymmetric
/// one.
pub(super) fn check_suits_model(
    body: &BodySpec,
    joint: &TreeJoint,
    parent: Option<&BodySpec>,
) -> Result<(), DynamicsError> {
    let motion = body.data.motion;
    let fail = |fault: String| Err(DynamicsError::Joint { joint: joint.name.clone(), fault });
    let parent_motion = parent.map(|p| p.data.motion);
    if motion == RigidMotion::Spatial && parent_motion.is_none_or(|m| m == RigidMotion::Spatial) {
        return Ok(());
    }
    let model = if [Some(motion), parent_motion].contains(&Some(RigidMotion::Axial)) {
        "axisymmetric"
    } else {
        "plane"
    };
    let relative = joint.kind.motion(&joint.kind.zero(), &[0.0; 6]);
    let sides = [(motion, &joint.child), (parent_motion.unwrap_or(motion), &joint.parent.marker)];
    for (side, (motion, marker)) in sides.into_iter().enumerate() {
        let is_ground = side == 1 && parent.is_none();
        if is_ground || motion == RigidMotion::Spatial {
            continue;
        }
        let active = active_directions(motion);
        for column in &relative.columns[..joint.kind.n_velocities()] {
            let (u, turn) = (marker.rotation * column.translation, marker.rotation * column.rotation);
            let parts = [u.x, u.y, u.z, turn.x, turn.y, turn.z];
            if let Some(i) = (0..6).find(|i| !active.contains(i) && parts[*i].abs() > ALIGNMENT) {
                let direction = ["x", "y", "z", "rotation x", "rotation y", "rotation z"][i];
                return fail(format!(
                    "a {} joint moves in direction {direction}, which the {model} model lacks",
                    joint.kind.name()
                ));
            }
        }
    }
    let Some(parent) = parent else { return Ok(()) };
    // The normal (axis) of one model must be that of the other.
    let turn: Matrix3<f64> = (joint.parent.marker.rotation * joint.child.rotation.inverse()).into();
    let is_aligned = (turn[(2, 2)].abs() - 1.0).abs() < ALIGNMENT;
    let is_turned = parent.data.motion != motion;
    if !is_aligned || is_turned {
        let (parent, child) = (parent.name.clone(), body.name.clone());
        return fail(format!(
            "{model} bodies can only be joined to ground or to each other with parallel z axes (\"{parent}\", \"{child}\")"
        ));
    }
    Ok(())
}

/// A joint that closes a loop.
pub(super) fn loop_joint(named: &NamedBodies<'_>, joint: &JointSpec) -> Result<LoopJoint, DynamicsError> {
    let JointSpec { name, kind, parent, child, coordinates, bearing } = joint;
    let (parent, child) = (resolve(named, name, parent)?, resolve(named, name, child)?);
    let fail = |fault: String| Err(DynamicsError::Joint { joint: name.clone(), fault });
    if *kind == JointKind::Free {
        return fail("a free joint closes no loop".into());
    }
    if parent.body == child.body {
        return fail("both markers are on the same body".into());
    }
    if !coordinates.is_empty() || bearing.is_some() {
        return fail("a loop-closing joint has no forces along its coordinates".into());
    }
    Ok(LoopJoint { name: name.clone(), kind: *kind, parent, child })
}

/// Loads with their bodies and markers.
pub(super) fn resolve_loads(named: &NamedBodies<'_>) -> Result<Vec<Load>, DynamicsError> {
    let spec = named.spec;
    let mut loads = Vec::with_capacity(spec.loads.len());
    for load in &spec.loads {
        let Site { body, marker } = resolve(named, &load.name, &load.at)?;
        let Some(body) = body else {
            return Err(DynamicsError::LoadOnGround { load: load.name.clone() });
        };
        loads.push(Load {
            name: load.name.clone(),
            body,
            marker,
            components: load.components.clone(),
            is_following: load.is_following,
        });
    }
    Ok(loads)
}
