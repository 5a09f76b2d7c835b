//! Sizes of bodies, by which angular velocities become velocities.

use std::collections::BTreeMap;

use adaptive::spec::ImportedSpec;
use adaptive::spec::{BodyKind, BodySpec, RunSpec};

/// Size of each body by name: the diagonal of the box about its control points, or its radius of gyration where it has none \[m\].
pub fn sizes(spec: &RunSpec) -> BTreeMap<String, f64> {
    spec.bodies.iter().map(|body| (body.name.clone(), size(body))).collect()
}

fn size(body: &BodySpec) -> f64 {
    match &body.kind {
        BodyKind::Elastic(elastic) => {
            diagonal(elastic.shape.patches.iter().flat_map(|p| p.control_points().iter()))
        }
        BodyKind::Rigid(rigid) => gyration(0.5 * rigid.inertia.trace(), rigid.mass),
        BodyKind::Imported(ImportedSpec::Full { body, .. }) => diagonal(body.body().nodes.iter()),
        BodyKind::Imported(ImportedSpec::Reduced(model)) => {
            gyration(model.data().second_moment.trace(), model.data().mass)
        }
    }
}

/// Diagonal of the box about `points`.
fn diagonal<'a>(points: impl Iterator<Item = &'a [f64; 3]>) -> f64 {
    let empty = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
    let [low, high] = points.fold(empty, |[low, high], p| {
        [std::array::from_fn(|k| low[k].min(p[k])), std::array::from_fn(|k| high[k].max(p[k]))]
    });
    let squares = low.iter().zip(high).map(|(low, high)| (high - low).powi(2));
    let diagonal = squares.sum::<f64>().sqrt();
    if diagonal.is_finite() { diagonal } else { 0.0 }
}

fn gyration(moment: f64, mass: f64) -> f64 {
    let radius = (moment / mass).sqrt();
    if radius.is_finite() { radius } else { 0.0 }
}
