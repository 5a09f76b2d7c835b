//! Lengths of an interval on a body: how far it reaches along the surface and into the depth
//! (theory section A.2).

use iga_core::elasticity::Model;
use iga_core::nurbs::Patch;
use iga_core::nurbs::jet::norm;
use iga_core::nurbs::local::parameter_at_distance;
use iga_core::nurbs::patch::PointBasis;
use iga_core::splines::knots::KnotVector;

use super::WantedInterval;
use crate::adaptivity::subdivision::SubdivisionError;
use crate::body::splines::ElasticBody;
use crate::error::AdaptiveError;

/// Least size of an element of the finest level in units of the round-off of its place.
const RESOLVED: f64 = 1e3;

/// Ends of an interval of width `width` about `point`, along the surface \[m\].
///
/// An interval that would cross the axis of an axisymmetric model goes from the axis outwards: what
/// lies beyond the axis is the same surface once more, and a search finds points on the axis no
/// nearer to it than the square root of round-off.
pub(super) fn reach(coarse: &ElasticBody, point: &[f64; 3], width: f64) -> [f64; 2] {
    let half = 0.5 * width;
    let is_on_axis = coarse.spec.model == Model::Axisymmetric && point[0].abs() < half;
    // The end on the axis is cut off there.
    if is_on_axis { [-(width - point[0]), width - point[0]] } else { [-half, half] }
}

/// Share of half the width of an interval to which the finest level goes into the depth. Contact
/// uses some three quarters of the width, and the largest shear stress lies 0.48 half widths of the
/// contact deep (Johnson, section 4.2): before the finest level ends. Beyond, stress varies over
/// lengths that coarser levels resolve (docs/decisions/0019).
const DEPTH: f64 = 0.5;

/// How deep the finest level goes: a quarter of the width of the interval, of an elongated one the
/// smaller quarter \[m\].
pub(super) fn depth(coarse: &ElasticBody, patch: &Patch, wanted: &WantedInterval) -> f64 {
    let point = patch.point(&wanted.face.on_face(&wanted.centre));
    let half = |&w: &f64| reach(coarse, &point, w)[1];
    DEPTH * wanted.widths[..wanted.face.directions().count()].iter().map(half).fold(f64::INFINITY, f64::min)
}

/// Parameters across the face at the surface and at the depth to which the refinement goes.
pub(super) fn into_depth(coarse: &ElasticBody, patch: &Patch, wanted: &WantedInterval) -> [f64; 2] {
    let xi = wanted.face.on_face(&wanted.centre);
    let inwards = if wanted.face.id.upper { -1.0 } else { 1.0 };
    let by = inwards * depth(coarse, patch, wanted);
    [wanted.face.parameter, parameter_at_distance(patch, &xi, wanted.face.id.direction, by)]
}

/// A fault of the division of `coarse`.
pub(super) fn fail(coarse: &ElasticBody, source: SubdivisionError) -> AdaptiveError {
    AdaptiveError::Subdivision { body: coarse.name.clone(), source }
}

/// Refuses elements so small that round-off of parameters, or of places on the body, would fold
/// them.
pub(super) fn check_resolved(
    coarse: &ElasticBody,
    knots: &KnotVector,
    width: f64,
    spacing: f64,
    speed: f64,
) -> Result<(), AdaptiveError> {
    let (first, last) = knots.domain();
    let round_off = f64::EPSILON * (first.abs().max(last.abs()) * speed).max(coarse.size());
    let element = spacing * speed;
    if element > RESOLVED * round_off {
        return Ok(());
    }
    Err(fail(coarse, SubdivisionError::BelowRoundOff { width, element, size: coarse.size(), round_off }))
}

/// Metres a unit of parameter along the directions of the face, at the centre of an interval.
pub(super) fn speeds(patch: &Patch, wanted: &WantedInterval) -> impl Iterator<Item = f64> {
    let xi = wanted.face.on_face(&wanted.centre);
    let first = patch.jet(&xi, 1, &mut PointBasis::default()).first;
    wanted.face.directions().map(move |d| norm(&first[d]))
}
