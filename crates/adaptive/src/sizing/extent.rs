//! How long bodies are along a direction of space.

use ffr_dynamics::force::BodyState;
use nalgebra::Vector3;

use crate::spec::RunSpec;
use crate::surface;

/// Length of a body along a direction of space \[m\]; infinite without a surface.
pub fn extent(spec: &RunSpec, poses: &[BodyState], body: usize, along: &Vector3<f64>) -> f64 {
    let direction = poses[body].rotation.inverse_transform_vector(along);
    surface::of_body(&spec.bodies[body].kind)
        .map_or(f64::INFINITY, |surface| surface.extent_along(&direction))
}
