//! What the stored compliance of a fine model is made from.

use iga_core::nurbs::interface::FaceId;
use iga_core::surface::Face;

use super::FineSettings;
use crate::elastic_body::{ElasticBody, ReducedBody};
use crate::point_compliance::{ObservedPlace, add_places};
use crate::spec::DivisionRule;
use crate::store::{Bytes, ModelKey, body_definition, matrix_values};
use crate::wanted_interval::WantedInterval;

/// Key of the compliance that the fine model of a body with modes prolonged from `coarse` has at the interface `unknowns`, and to
/// `points` of the body; without an interval that of the body's own elements.
pub fn compliance_key(
    (body, reduced): (&ElasticBody, &ReducedBody),
    interval: Option<(&WantedInterval, &FineSettings)>,
    (unknowns, points): (&[usize], &[ObservedPlace]),
) -> ModelKey {
    let mut key = Bytes(body_definition(&body.spec));
    let basis = &reduced.basis;
    key.add(&(basis.n_low, &basis.omega, basis.shapes.nrows(), matrix_values(&basis.shapes)));
    if let Some((wanted, settings)) = interval {
        add_interval(&mut key, wanted, settings);
    }
    // They say as well by which points the contact is watched.
    add_places(&mut key, unknowns, points);
    ModelKey { kind: "compliance", definition: key.0 }
}

/// What a body is refined for.
fn add_interval(key: &mut Bytes, wanted: &WantedInterval, settings: &FineSettings) {
    let WantedInterval { face, centre, widths } = wanted;
    let Face { id: FaceId { patch, direction, upper }, parameter, dimension, axisymmetric } = face;
    key.add(&(patch, direction, upper, dimension, axisymmetric, parameter));
    key.add(&(centre, widths));
    let FineSettings { division, elements, growth } = settings;
    let division = match division {
        DivisionRule::Graded => 0,
        DivisionRule::Printed => 1,
    };
    key.add(&(division, elements, growth));
}
