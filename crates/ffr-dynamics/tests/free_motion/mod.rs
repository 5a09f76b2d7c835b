//! Bodies without joints, as systems of joint and elastic coordinates: construction, states, motions.

use std::ops::DerefMut;

use ffr_dynamics::body::StandardInputData;
use ffr_dynamics::force::BodyState;
use ffr_dynamics::force::active::ActiveForce;
use ffr_dynamics::system::{BodySpec, JointKind, Multibody, SystemSpec};
use nalgebra::Vector3;

/// Bodies by name that move freely, in the rigid motions of their models, under `gravity` and force elements.
pub fn free_system<F: DerefMut<Target: ActiveForce>>(
    bodies: Vec<(&str, StandardInputData)>,
    gravity: Vector3<f64>,
    forces: Vec<F>,
) -> Multibody<F> {
    let spec = |(name, data): (&str, _)| BodySpec { name: name.to_string(), data, markers: Vec::new() };
    let bodies = bodies.into_iter().map(spec).collect();
    Multibody::new(SystemSpec { bodies, gravity, ..SystemSpec::default() }, forces).unwrap()
}

/// State vector of free bodies in the motions given, with quadratures at zero.
///
/// A plane body has no z, an axial one only z: what a motion has beyond is not used.
pub fn state_vector<F: DerefMut<Target: ActiveForce>>(
    system: &Multibody<F>,
    states: &[BodyState],
) -> Vec<f64> {
    let mut y = system.rest();
    assert_eq!(states.len(), system.model().bodies.len());
    for (i, s) in states.iter().enumerate() {
        let (p, v, w, q) = (s.position, s.velocity, s.angular_velocity_in_body, s.rotation);
        let (positions, velocities) = match system.model().bodies[i].joint.kind {
            JointKind::Free => (vec![p.x, p.y, p.z, q.w, q.i, q.j, q.k], vec![v.x, v.y, v.z, w.x, w.y, w.z]),
            JointKind::Planar => (vec![p.x, p.y, q.scaled_axis().z], vec![v.x, v.y, w.z]),
            JointKind::Axial => (vec![p.z], vec![v.z]),
            kind => panic!("a {} joint is no free motion", kind.name()),
        };
        system.set_joint(&mut y, i, &positions, &velocities).unwrap();
        system.set_elastic(&mut y, i, &s.elastic, &s.elastic_rates).unwrap();
    }
    y
}

/// Motion of body `body` in the state `y`.
pub fn body_state<F: DerefMut<Target: ActiveForce>>(
    system: &mut Multibody<F>,
    y: &[f64],
    body: usize,
) -> BodyState {
    system.body_states(0.0, y)[body].clone()
}
