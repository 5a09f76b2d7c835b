//! What the stored compliance of a fine model is made from.

use iga_core::nurbs::interface::FaceId;
use iga_core::surface::Face;

use super::FineSettings;
use crate::elastic_body::{ElasticBody, ReducedBody};
use crate::spec::DivisionRule;
use crate::store::{Bytes, ModelKey, body_definition};
use crate::wanted_interval::WantedInterval;

/// Key of the compliance that the fine model of a body with modes prolonged from `coarse` has at the interface `unknowns`, and to
/// `points` of the body.
pub fn compliance_key(
    (body, reduced): (&ElasticBody, &ReducedBody),
    wanted: &WantedInterval,
    settings: &FineSettings,
    (unknowns, points): (&[usize], &[[f64; 3]]),
) -> ModelKey {
    let mut key = Bytes(body_definition(&body.spec));
    let basis = &reduced.basis;
    key.count(basis.n_low);
    key.numbers(&basis.omega);
    key.count(basis.shapes.nrows());
    for j in 0..basis.shapes.ncols() {
        basis.shapes.col(j).iter().for_each(|v| key.number(*v));
    }
    let WantedInterval { face, centre, widths } = wanted;
    let Face { id: FaceId { patch, direction, upper }, parameter, dimension, axisymmetric } = face;
    key.counts(&[*patch, *direction, usize::from(*upper), *dimension, usize::from(*axisymmetric)]);
    key.number(*parameter);
    key.numbers(centre);
    key.numbers(widths);
    let FineSettings { division, elements, growth } = settings;
    let division = match division {
        DivisionRule::Graded => 0,
        DivisionRule::Printed => 1,
    };
    key.counts(&[division, *elements]);
    key.counts(growth.as_slice());
    // They say as well by which points the contact is watched.
    key.counts(unknowns);
    key.points(points);
    ModelKey { kind: "compliance", definition: key.0 }
}
