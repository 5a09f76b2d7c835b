//! How long bodies are along a direction of space.

use ffr_dynamics::system::force::BodyState;
use nalgebra::Vector3;

use crate::spec::{BodyKind, RunSpec};

/// Length of a body along a direction of space \[m\]; infinite without a surface.
pub fn extent(spec: &RunSpec, poses: &[BodyState], body: usize, along: &Vector3<f64>) -> f64 {
    let direction = poses[body].rotation.inverse_transform_vector(along);
    let range = |points: &mut dyn Iterator<Item = &[f64; 3]>| {
        let heights = points.map(|p| Vector3::from(*p).dot(&direction));
        let (low, high) =
            heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), h| (f64::min(a, h), f64::max(b, h)));
        if high > low { high - low } else { f64::INFINITY }
    };
    match &spec.bodies[body].kind {
        BodyKind::Meshed(meshed) => range(&mut meshed.mesh.nodes().iter()),
        BodyKind::Elastic(_) | BodyKind::Rigid(_) | BodyKind::Imported(_) => {
            spec.bodies[body].geometry().map_or(f64::INFINITY, |body| {
                range(&mut body.shape.patches.iter().flat_map(|p| p.control_points()))
            })
        }
    }
}
