//! Levels of a zone that spreads over several faces: one lattice for all directions that shared
//! faces turn into one another (theory Eq. A.10).

use iga_core::ParameterBox;
use iga_core::nurbs::Patch;
use iga_core::nurbs::jet::norm;
use iga_core::nurbs::local::parameter_at_distance;
use iga_core::nurbs::patch::PointBasis;
use nalgebra::Vector3;

use super::across::extend;
use super::levels::{links, mirror};
use super::measures::{check_resolved, depth};
use super::spread::{Spread, SpreadPart};
use super::{Division, FineSettings, LinkedLattice, RefinementPlan, Region, WantedInterval};
use crate::adaptivity::lattice::DirectionLattice;
use crate::body::splines::ElasticBody;
use crate::error::AdaptiveError;

/// The spacing of elements that a part of a zone needs in a direction along its face.
struct Need {
    patch: usize,
    direction: usize,
    /// The parameters that the part spans.
    span: [f64; 2],
    /// Wanted size of elements in parameters.
    spacing: f64,
    /// Metres a unit of parameter.
    speed: f64,
}

/// The plan of zones on several faces, or of several zones: `spreads` has the parts of each of the `wanted` ones.
pub(super) fn spread_plan(
    coarse: &ElasticBody,
    wanted: &[WantedInterval],
    spreads: Vec<Spread>,
    settings: &FineSettings,
) -> Result<RefinementPlan, AdaptiveError> {
    let patches = &coarse.shape.patches[..];
    let links = links(patches);
    let is_linked = |a: (usize, usize), b: (usize, usize)| links[a.0][a.1].group == links[b.0][b.1].group;
    let is_against =
        |a: (usize, usize), b: (usize, usize)| links[a.0][a.1].is_reversed != links[b.0][b.1].is_reversed;
    let parts =
        || wanted.iter().zip(&spreads).flat_map(|(w, s)| s.parts.iter().map(move |part| (w, s, part)));
    let needs: Vec<Need> =
        parts().flat_map(|(_, spread, part)| needs(patches, spread, part, settings)).collect();
    let mut lattices: Vec<LinkedLattice> = Vec::new();
    let mut speeds = Vec::new();
    for (i, need) in needs.iter().enumerate() {
        let leader = (need.patch, need.direction);
        let knots = &patches[need.patch].knots()[need.direction];
        let width = need.spacing * need.speed * settings.elements as f64;
        check_resolved(coarse, knots, width, need.spacing, need.speed)?;
        if needs[..i].iter().any(|other| is_linked((other.patch, other.direction), leader)) {
            continue;
        }
        let (mut span, mut spacing, mut speed) = (need.span, need.spacing, need.speed);
        for other in needs[i..].iter().filter(|n| is_linked((n.patch, n.direction), leader)) {
            let mirror = mirror(knots, is_against((other.patch, other.direction), leader));
            let [a, b] = other.span.map(mirror);
            span = [span[0].min(a.min(b)), span[1].max(a.max(b))];
            if other.spacing < spacing {
                (spacing, speed) = (other.spacing, other.speed);
            }
        }
        // Whole elements, so that none is longer than wanted; the part that is none of round-off.
        let n = ((span[1] - span[0]) / spacing - 1e-6).ceil().max(1.0) as usize;
        let (lattice, _) = DirectionLattice::along(knots, span, n);
        lattices.push(LinkedLattice { patch: need.patch, direction: need.direction, lattice });
        speeds.push(speed);
    }
    let sizes = || lattices.iter().zip(&speeds).map(|(l, speed)| l.lattice.spacing * speed);
    let size = sizes().fold(f64::INFINITY, f64::min);
    let ratios: Vec<f64> = sizes().map(|own| own / size).collect();
    lattices.iter_mut().zip(ratios).for_each(|(l, ratio)| l.lattice = l.lattice.beside_shorter(ratio));
    let mut regions = Vec::new();
    for (wanted, _, part) in parts() {
        let (number, across) = (part.face.id.patch, part.face.id.direction);
        let patch = &patches[number];
        let inwards = if part.face.id.upper { -1.0 } else { 1.0 };
        let by = inwards * depth(coarse, &patches[wanted.face.id.patch], wanted);
        let end = parameter_at_distance(patch, &part.nearest, across, by);
        let surface = part.face.parameter;
        let mut bounds = part.bounds;
        (bounds.lower[across], bounds.upper[across]) = (surface.min(end), surface.max(end));
        regions.push(Region { patch: number, bounds });
        if lattices.iter().all(|l| !is_linked((l.patch, l.direction), (number, across))) {
            let speed = norm(&patch.jet(&part.nearest, 1, &mut PointBasis::default()).first[across]);
            let lattice = DirectionLattice::into_depth(&patch.knots()[across], surface, end, size / speed);
            lattices.push(LinkedLattice { patch: number, direction: across, lattice });
        }
    }
    let places: Vec<_> = parts().map(|(.., part)| (part.face.id.patch, part.nearest)).collect();
    extend(patches, &mut lattices, &places);
    Ok(RefinementPlan { division: Division::Lattice(lattices), regions, spreads })
}

/// What a part asks for: elements as short, in every direction, as the zone is wide there over
/// their number.
fn needs<'a>(
    patches: &'a [Patch],
    spread: &Spread,
    part: &'a SpreadPart,
    settings: &FineSettings,
) -> impl Iterator<Item = Need> + use<'a> {
    let patch = part.face.id.patch;
    let first = patches[patch].jet(&part.nearest, 1, &mut PointBasis::default()).first;
    let elements = settings.elements as f64;
    let ParameterBox { lower, upper } = part.bounds;
    let frame = spread.frame;
    part.face.directions().map(move |direction| {
        let width = frame.width_along(&Vector3::from(first[direction]));
        let speed = norm(&first[direction]);
        let span = [lower[direction], upper[direction]];
        Need { patch, direction, span, spacing: width / (elements * speed), speed }
    })
}
