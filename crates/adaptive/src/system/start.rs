//! Where bodies are and how they move at the start.

use std::ops::DerefMut;

use ffr_dynamics::DynamicsError;
use ffr_dynamics::body::StandardInputData;
use ffr_dynamics::force::BodyState;
use ffr_dynamics::force::active::ActiveForce;
use ffr_dynamics::system::{JointKind, Multibody};
use nalgebra::{Matrix3, Vector3};

use super::joints;
use crate::error::AdaptiveError;
use crate::spec::{BodySpec, InitialMotion, RunSpec, Start};
use crate::system::body::BodyForm;
use crate::system::body::BodyModel;
use crate::system::imported::ImportedModel;

/// Instants of the run at which the rates of prescribed motions are looked at.
const LOOKS: u32 = 64;

/// Motions of all bodies at the start if they were rigid.
///
/// # Errors
/// [`AdaptiveError::Model`] if joints do not make a tree or loops do not close.
pub fn poses(spec: &RunSpec) -> Result<Vec<BodyState>, AdaptiveError> {
    let (mut system, y) = rigid_system(spec)?;
    Ok(system.body_states(0.0, &y).to_vec())
}

/// Angular velocities of all bodies in their frames at the start, and as prescribed motions turn
/// them later with all other coordinates as at the start: for each body a list [rad/s].
///
/// # Errors
/// As [`poses`].
pub fn turns(spec: &RunSpec) -> Result<Vec<Vec<Vector3<f64>>>, AdaptiveError> {
    let (mut system, y) = rigid_system(spec)?;
    let is_driven = spec.joints.iter().flat_map(|joint| &joint.coordinates).any(|c| c.motion.is_some());
    let last = if is_driven { LOOKS } else { 0 };
    let mut turns = vec![Vec::new(); spec.bodies.len()];
    for k in 0..=last {
        let time = spec.settings.end_time * f64::from(k) / f64::from(LOOKS);
        for (turns, state) in turns.iter_mut().zip(system.body_states(time, &y)) {
            turns.push(state.angular_velocity_in_body);
        }
    }
    Ok(turns)
}

/// A system without contacts.
type Unloaded = Multibody<Box<dyn ActiveForce>>;

/// The bodies as rigid ones on their joints, and their state at the start.
fn rigid_system(spec: &RunSpec) -> Result<(Unloaded, Vec<f64>), AdaptiveError> {
    let rigid = rigid_models(spec)?;
    let description = joints::system_spec(spec, &rigid)?;
    let mut system = Multibody::new(description, Vec::new()).map_err(AdaptiveError::Model)?;
    let y = joint_state(spec, &mut system)?;
    Ok((system, y))
}

/// The bodies as rigid ones of unit mass with their places, for poses.
///
/// # Errors
/// [`AdaptiveError::Model`] as [`StandardInputData::rigid`].
pub(crate) fn rigid_models(spec: &RunSpec) -> Result<Vec<BodyModel>, AdaptiveError> {
    let rigid = spec.bodies.iter().map(|body| {
        if let Some(imported) = body.kind.imported() {
            return Ok(BodyModel::imported(body.name.clone(), ImportedModel::rigid(imported)?));
        }
        let motion = body.kind.motion();
        // Poses do not depend on masses.
        let data = StandardInputData::rigid(motion, 1.0, Vector3::zeros(), Matrix3::identity())?;
        Ok(BodyModel { name: body.name.clone(), data, form: BodyForm::Rigid(None) })
    });
    rigid.collect::<Result<_, DynamicsError>>().map_err(AdaptiveError::Model)
}

/// State of `system` at the start: joint coordinates as given, elastic ones zero or in equilibrium.
///
/// # Errors
/// [`AdaptiveError::Model`] if coordinates do not fit, loops do not close, or there is no equilibrium.
pub fn state<F: DerefMut<Target: ActiveForce>>(
    spec: &RunSpec,
    system: &mut Multibody<F>,
) -> Result<Vec<f64>, AdaptiveError> {
    let mut y = joint_state(spec, system)?;
    if spec.settings.start == Start::Elastic {
        system.static_start(0.0, &mut y).map_err(AdaptiveError::Model)?;
    }
    Ok(y)
}

fn joint_state<F: DerefMut<Target: ActiveForce>>(
    spec: &RunSpec,
    system: &mut Multibody<F>,
) -> Result<Vec<f64>, AdaptiveError> {
    let mut y = system.rest();
    for (i, body) in spec.bodies.iter().enumerate() {
        let (positions, velocities) = match spec.joints.iter().find(|j| j.child.body == Some(i)) {
            Some(joint) => {
                let free: Vec<usize> = system.model().bodies[i].joint.free_velocities().collect();
                if free.len() == joint.kind.n_velocities() {
                    (joint.positions.clone(), joint.velocities.clone())
                } else {
                    // Prescribed coordinates are no part of the state; joints with a quaternion
                    // have none.
                    let pick = |all: &[f64]| free.iter().filter_map(|&k| all.get(k).copied()).collect();
                    (pick(&joint.positions), pick(&joint.velocities))
                }
            }
            None => free_coordinates(system.model().bodies[i].joint.kind, &body.motion),
        };
        system.set_joint(&mut y, i, &positions, &velocities).map_err(AdaptiveError::Model)?;
    }
    if !spec.loops.is_empty() || !spec.gears.is_empty() {
        let is_given = |(i, body): (usize, &BodySpec)| {
            let joint = spec.joints.iter().find(|joint| joint.child.body == Some(i));
            let moves =
                body.motion.velocity != Vector3::zeros() || body.motion.angular_velocity != Vector3::zeros();
            joint.map_or(moves, |joint| joint.has_velocities)
        };
        let is_given: Vec<bool> = spec.bodies.iter().enumerate().map(is_given).collect();
        system.assemble_start(0.0, &mut y, &is_given).map_err(AdaptiveError::Model)?;
    }
    Ok(y)
}

/// Coordinates of the joint by which a free body is joined to ground, see [`joints::system_spec`].
fn free_coordinates(kind: JointKind, motion: &InitialMotion) -> (Vec<f64>, Vec<f64>) {
    let into = |v: &Vector3<f64>| motion.rotation.inverse_transform_vector(v);
    let (v, w) = (into(&motion.velocity), into(&motion.angular_velocity));
    match kind {
        JointKind::Axial => (vec![0.0], vec![v.z]),
        JointKind::Planar => (vec![0.0; 3], vec![v.x, v.y, w.z]),
        _ => (vec![0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0], vec![v.x, v.y, v.z, w.x, w.y, w.z]),
    }
}
