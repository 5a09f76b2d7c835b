//! What the matrices of a fine model are made from.

use iga_core::nurbs::Face;
use iga_core::nurbs::interface::FaceId;

use super::FineSettings;
use crate::adaptivity::wanted_interval::WantedInterval;
use crate::body::splines::ElasticBody;
use crate::spec::DivisionRule;
use crate::store::{Bytes, body_definition};

/// What the matrices of a body are made from that is refined for the intervals `wanted`; without one its own
/// elements.
pub fn zone_definition(body: &ElasticBody, wanted: &[WantedInterval], settings: &FineSettings) -> Bytes {
    let mut key = Bytes(body_definition(&body.spec));
    wanted.iter().for_each(|wanted| add_interval(&mut key, wanted, settings));
    key
}

/// The contact zone for which a body is refined.
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
