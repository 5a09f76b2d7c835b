//! Where the levels of a fine model lie: graded lattices, or Algorithm 3 of \[A\] (theory
//! section A.2).

use iga_core::ParameterBox;
use iga_core::nurbs::Patch;
use iga_core::nurbs::jet::norm;
use iga_core::nurbs::local::parameter_at_distance;
use iga_core::nurbs::patch::PointBasis;

use super::across::extend;
use super::levels::growth;
use super::measures::{check_resolved, fail, into_depth, reach, speeds};
use super::spread::{Spread, Surroundings};
use super::spread_plan::spread_plan;
use super::{Division, DivisionRule, FineSettings, LinkedLattice, RefinementPlan, Region, WantedInterval};
use crate::adaptivity::lattice::DirectionLattice;
use crate::adaptivity::subdivision::{DirectionPlan, SubdivisionError, SurfaceGrowth, divide, follow};
use crate::body::splines::ElasticBody;
use crate::error::AdaptiveError;

/// The parameters of an interval's ends along the face, as it is asked for.
fn parameters(coarse: &ElasticBody, patch: &Patch, wanted: &WantedInterval) -> [Option<[f64; 2]>; 3] {
    let on_face = wanted.face.on_face(&wanted.centre);
    let point = patch.point(&on_face);
    let mut spans = [None; 3];
    for (d, width) in wanted.face.directions().zip(wanted.widths) {
        let reach = reach(coarse, &point, width);
        spans[d] = Some(reach.map(|s| parameter_at_distance(patch, &on_face, d, s)));
    }
    spans
}

/// Levels and regions for all intervals of a body.
pub(super) fn plan(
    coarse: &ElasticBody,
    wanted: &[WantedInterval],
    settings: &FineSettings,
) -> Result<RefinementPlan, AdaptiveError> {
    for w in wanted {
        let widths = &w.widths[..w.face.directions().count()];
        if let Some(&width) = widths.iter().find(|w| !(w.is_finite() && **w > 0.0)) {
            return Err(fail(coarse, SubdivisionError::Width { width }));
        }
    }
    match (wanted, settings.division, &coarse.shape.patches[..]) {
        ([one], DivisionRule::Graded, [_]) => lattice_plan(coarse, one, settings),
        (_, DivisionRule::Graded, _) => {
            let surroundings = Surroundings::new(coarse);
            let spreads: Vec<Spread> = wanted.iter().map(|w| surroundings.spread(w)).collect();
            match (wanted, &spreads[..]) {
                ([one], [spread]) if spread.parts.len() < 2 => lattice_plan(coarse, one, settings),
                _ => spread_plan(coarse, wanted, spreads, settings),
            }
        }
        (_, _, [patch]) => parts_plan(coarse, patch, wanted, settings),
        _ => Err(AdaptiveError::unsupported_body(
            &coarse.name,
            "interval.division = \"printed\" is for bodies of one patch; leave it out".into(),
        )),
    }
}

/// Lattices about one interval.
fn lattice_plan(
    coarse: &ElasticBody,
    wanted: &WantedInterval,
    settings: &FineSettings,
) -> Result<RefinementPlan, AdaptiveError> {
    let number = wanted.face.id.patch;
    let patch = &coarse.shape.patches[number];
    let mut spans = parameters(coarse, patch, wanted);
    let xi = wanted.face.on_face(&wanted.centre);
    let first = patch.jet(&xi, 1, &mut PointBasis::default()).first;
    let none = DirectionLattice { anchor: 0.0, spacing: 1.0, n_levels: 0, n_skipped: 0 };
    let (mut lattices, mut size) = ([none; 3], f64::INFINITY);
    for ((d, width), speed) in wanted.face.directions().zip(wanted.widths).zip(speeds(patch, wanted)) {
        let (Some(span), knots) = (&mut spans[d], &patch.knots()[d]) else { continue };
        check_resolved(coarse, knots, width, (span[1] - span[0]) / settings.elements as f64, speed)?;
        (lattices[d], *span) = DirectionLattice::along(knots, *span, settings.elements);
        size = size.min(lattices[d].spacing * speed);
    }
    for (d, speed) in wanted.face.directions().zip(speeds(patch, wanted)) {
        lattices[d] = lattices[d].beside_shorter(lattices[d].spacing * speed / size);
    }
    let across = wanted.face.id.direction;
    let spacing = size / norm(&first[across]);
    let [surface, end] = into_depth(coarse, patch, wanted);
    lattices[across] = DirectionLattice::into_depth(&patch.knots()[across], surface, end, spacing);
    let along = spans.map(|span| {
        span.map(|interval| DirectionPlan {
            parts: Vec::new(),
            intervals: vec![interval],
            n_elements: vec![settings.elements],
            deviation: 0.0,
        })
    });
    let bounds = region(coarse, patch, wanted, &spans, &along, &mut [0; 3]);
    let lattice = |direction| LinkedLattice { patch: number, direction, lattice: lattices[direction] };
    let mut lattices = (0..patch.dimension()).map(lattice).collect();
    extend(&coarse.shape.patches, &mut lattices, &[(number, xi)]);
    Ok(RefinementPlan {
        division: Division::Lattice(lattices),
        regions: vec![Region { patch: number, bounds }],
        spreads: Vec::new(),
    })
}

/// Algorithm 3 for all intervals of a body.
fn parts_plan(
    coarse: &ElasticBody,
    patch: &Patch,
    wanted: &[WantedInterval],
    settings: &FineSettings,
) -> Result<RefinementPlan, AdaptiveError> {
    let spans: Vec<_> = wanted.iter().map(|w| parameters(coarse, patch, w)).collect();
    let mut along: [Option<DirectionPlan>; 3] = Default::default();
    for (d, knots) in patch.knots().iter().enumerate() {
        let intervals: Vec<[f64; 2]> = spans.iter().filter_map(|s| s[d]).collect();
        if !intervals.is_empty() {
            let growth = growth(knots, 2, settings);
            let surface = SurfaceGrowth { growth, directions: patch.dimension() as i32 - 1 };
            let plan = divide(&knots.breaks(), &intervals, surface, settings.elements);
            along[d] = Some(plan.ok_or_else(|| fail(coarse, too_small(patch, wanted, d)))?);
        }
    }
    let n_levels = along.iter().flatten().map(|p| p.parts.len()).max().unwrap_or(0);
    let mut parts = vec![[1; 3]; n_levels];
    for (d, plan) in along.iter().enumerate() {
        let Some(plan) = plan else { continue };
        let first = n_levels - plan.parts.len();
        plan.parts.iter().zip(&mut parts[first..]).for_each(|(n, level)| level[d] = *n);
    }
    for d in (0..patch.dimension()).filter(|&d| along[d].is_none()) {
        let into_depth = wanted.iter().map(|w| depth_parts(patch, w, d, &parts));
        let most = into_depth.max_by_key(|list| list.iter().product::<usize>()).unwrap_or_default();
        most.into_iter().zip(&mut parts).for_each(|(n, level)| level[d] = n);
    }
    let mut taken = [0; 3];
    let mut regions = Vec::new();
    for (w, span) in wanted.iter().zip(&spans) {
        regions.push(Region { patch: 0, bounds: region(coarse, patch, w, span, &along, &mut taken) });
    }
    Ok(RefinementPlan { division: Division::Parts(parts), regions, spreads: Vec::new() })
}

/// Why Algorithm 3 has no division in direction `d`, in metres.
fn too_small(patch: &Patch, wanted: &[WantedInterval], d: usize) -> SubdivisionError {
    let knots = &patch.knots()[d];
    let of = |w: &WantedInterval| {
        let (a, b) = knots.element(knots.find_element(w.face.on_face(&w.centre)[d]));
        let mut along = w.face.directions().zip(w.widths).zip(speeds(patch, w));
        let found = along.find(|((k, _), _)| *k == d);
        found.map_or((0.0, 0.0), |((_, width), speed)| (width, (b - a) * speed))
    };
    let narrowest = wanted.iter().map(of).min_by(|a, b| a.0.total_cmp(&b.0));
    let (width, element) = narrowest.unwrap_or_default();
    SubdivisionError::TooSmall { element, width }
}

/// Refuses intervals that touch a singular line of the parametrisation.
pub(super) fn check_regular(
    coarse: &ElasticBody,
    wanted: &[WantedInterval],
    plan: &RefinementPlan,
) -> Result<(), AdaptiveError> {
    for (part, bounds) in faces(wanted, plan) {
        let face = part.face;
        let [lower, upper] = [bounds.lower, bounds.upper].map(|corner| face.on_face(&corner));
        if let Some(set) = coarse.shape.singular_in(face.id.patch, &lower, &upper) {
            let what = format!(
                "a contact interval touches the singular {} of the parametrisation; turn the body's frame or choose another net",
                set.name
            );
            return Err(AdaptiveError::unsupported_body(&coarse.name, what));
        }
    }
    Ok(())
}

/// All intervals, of those on several faces their parts, with the regions around them.
pub(super) fn faces<'a>(
    wanted: &'a [WantedInterval],
    plan: &'a RefinementPlan,
) -> impl Iterator<Item = (WantedInterval, &'a ParameterBox)> {
    let of_parts = wanted.iter().zip(&plan.spreads).flat_map(|(WantedInterval { widths, .. }, spread)| {
        spread.parts.iter().map(|p| WantedInterval { face: p.face, centre: p.nearest, widths: *widths })
    });
    let alone = wanted.iter().filter(|_| plan.spreads.is_empty()).copied();
    of_parts.chain(alone).zip(plan.regions.iter().map(|r| &r.bounds))
}

/// Parts into the depth, so that elements at the contact have about the same size in all
/// directions.
fn depth_parts(patch: &Patch, wanted: &WantedInterval, depth: usize, parts: &[[usize; 3]]) -> Vec<usize> {
    let xi = wanted.face.on_face(&wanted.centre);
    let first = patch.jet(&xi, 1, &mut PointBasis::default()).first;
    let size = |d: usize| {
        let knots = &patch.knots()[d];
        let (a, b) = knots.element(knots.find_element(xi[d]));
        (b - a) * norm(&first[d])
    };
    let mut sizes: Vec<(usize, f64)> = wanted.face.directions().map(|d| (d, size(d))).collect();
    let along: Vec<f64> = parts
        .iter()
        .map(|level| {
            sizes.iter_mut().for_each(|(d, s)| *s /= level[*d] as f64);
            sizes.iter().map(|s| s.1).fold(f64::INFINITY, f64::min)
        })
        .collect();
    follow(size(depth), &along)
}

/// The box around which the levels are refined for an interval, its ends moved to knots. `taken`
/// counts the intervals of each direction that were used before.
fn region(
    coarse: &ElasticBody,
    patch: &Patch,
    wanted: &WantedInterval,
    span: &[Option<[f64; 2]>; 3],
    along: &[Option<DirectionPlan>; 3],
    taken: &mut [usize; 3],
) -> ParameterBox {
    let (mut lower, mut upper) = ([0.0; 3], [0.0; 3]);
    for d in 0..patch.dimension() {
        let ends = match (span[d], &along[d]) {
            (Some(_), Some(plan)) => {
                taken[d] += 1;
                plan.intervals[taken[d] - 1]
            }
            _ => {
                let [surface, end] = into_depth(coarse, patch, wanted);
                [end.min(surface), end.max(surface)]
            }
        };
        (lower[d], upper[d]) = (ends[0], ends[1]);
    }
    ParameterBox { lower, upper }
}
