//! Sizes of bodies, by which angular velocities become velocities.

use std::collections::BTreeMap;

use adaptive::spec::{BodySpec, ImportedSpec, RunSpec};

/// Size of each body by name: the diagonal of the box about its control points, or its radius of
/// gyration where it has none \[m\].
pub fn sizes(spec: &RunSpec) -> BTreeMap<String, f64> {
    spec.bodies.iter().map(|body| (body.name.clone(), size(body))).collect()
}

fn size(body: &BodySpec) -> f64 {
    if let Some(rigid) = body.kind.rigid() {
        return gyration(0.5 * rigid.inertia.trace(), rigid.mass);
    }
    if let Some(ImportedSpec::Reduced(model)) = body.kind.imported() {
        return gyration(model.data().second_moment.trace(), model.data().mass);
    }
    body.kind.diagonal().unwrap_or_default()
}

fn gyration(moment: f64, mass: f64) -> f64 {
    let radius = (moment / mass).sqrt();
    if radius.is_finite() { radius } else { 0.0 }
}
