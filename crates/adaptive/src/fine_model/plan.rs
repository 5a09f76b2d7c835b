//! Where the levels of a fine model lie: graded lattices, or Algorithm 3 of \[A\] (theory section A.2).

use iga_core::ParameterBox;
use iga_core::SplineError;
use iga_core::elasticity::Model;
use iga_core::hierarchical::{HierarchicalSpace, PatchTies, SubdomainHierarchy};
use iga_core::knots::KnotVector;
use iga_core::nurbs::Patch;
use iga_core::nurbs::jet::norm;
use iga_core::nurbs::local::parameter_at_distance;
use iga_core::nurbs::patch::PointBasis;
use iga_core::surface::Face;

use super::{Division, DivisionRule, FineInterval, FineSettings, RefinementPlan, WantedInterval};
use crate::elastic_body::ElasticBody;
use crate::error::AdaptiveError;
use crate::interval::IntervalEnd;
use crate::lattice::DirectionLattice;
use crate::subdivision::{DirectionPlan, SubdivisionError, SurfaceGrowth, divide, follow};
use crate::unsupported::Unsupported;

/// Slack of comparisons between parameters, as a share of an element of the finest level: far above what round-off does to
/// elements that are not refused, far below a distance between points.
const PARAMETER_SLACK: f64 = 1e-2;

/// Least size of an element of the finest level in units of the round-off of its place.
const RESOLVED: f64 = 1e3;

/// Elements by which the coarser levels of a lattice reach beyond the interval at least.
const COARSE_REACH: usize = 2;

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

/// Ends of an interval of width `width` about `point`, along the surface \[m\].
///
/// An interval that would cross the axis of an axisymmetric model goes from the axis outwards: what lies beyond the axis is
/// the same surface once more, and a search finds points on the axis no nearer to it than the square root of round-off.
fn reach(coarse: &ElasticBody, point: &[f64; 3], width: f64) -> [f64; 2] {
    let half = 0.5 * width;
    let is_on_axis = coarse.spec.model == Model::Axisymmetric && point[0].abs() < half;
    // The end on the axis is cut off there.
    if is_on_axis { [-(width - point[0]), width - point[0]] } else { [-half, half] }
}

/// Share of half the width of an interval to which the finest level goes into the depth. Contact uses some three quarters of the width, and the
/// largest shear stress lies 0.48 half widths of the contact deep (Johnson, section 4.2): before the finest level ends. Beyond, stress varies over
/// lengths that coarser levels resolve (docs/decisions/0019).
const DEPTH: f64 = 0.5;

/// How deep the finest level goes: a quarter of the width of the interval, of an elongated one the smaller quarter \[m\].
fn depth(coarse: &ElasticBody, patch: &Patch, wanted: &WantedInterval) -> f64 {
    let point = patch.point(&wanted.face.on_face(&wanted.centre));
    let half = |&w: &f64| reach(coarse, &point, w)[1];
    DEPTH * wanted.widths[..wanted.face.directions().count()].iter().map(half).fold(f64::INFINITY, f64::min)
}

/// Parameters across the face at the surface and at the depth to which the refinement goes.
fn into_depth(coarse: &ElasticBody, patch: &Patch, wanted: &WantedInterval) -> [f64; 2] {
    let xi = wanted.face.on_face(&wanted.centre);
    let inwards = if wanted.face.id.upper { -1.0 } else { 1.0 };
    let by = inwards * depth(coarse, patch, wanted);
    [wanted.face.parameter, parameter_at_distance(patch, &xi, wanted.face.id.direction, by)]
}

/// Levels and regions for all intervals of a body.
pub(super) fn plan(
    coarse: &ElasticBody,
    patch: &Patch,
    wanted: &[WantedInterval],
    settings: &FineSettings,
) -> Result<RefinementPlan, AdaptiveError> {
    for w in wanted {
        let widths = &w.widths[..w.face.directions().count()];
        if let Some(&width) = widths.iter().find(|w| !(w.is_finite() && **w > 0.0)) {
            return Err(fail(coarse, SubdivisionError::Width { width }));
        }
    }
    match (wanted, settings.division) {
        ([one], DivisionRule::Graded) => lattice_plan(coarse, patch, one, settings),
        _ => parts_plan(coarse, patch, wanted, settings),
    }
}

fn fail(coarse: &ElasticBody, source: SubdivisionError) -> AdaptiveError {
    AdaptiveError::Subdivision { body: coarse.name.clone(), source }
}

/// Refuses elements so small that round-off of parameters, or of places on the body, would fold them.
fn check_resolved(
    coarse: &ElasticBody,
    knots: &KnotVector,
    (width, spacing, speed): (f64, f64, f64),
) -> Result<(), AdaptiveError> {
    let (first, last) = knots.domain();
    let round_off = f64::EPSILON * (first.abs().max(last.abs()) * speed).max(coarse.size());
    let element = spacing * speed;
    if element > RESOLVED * round_off {
        return Ok(());
    }
    Err(fail(coarse, SubdivisionError::BelowRoundOff { width, element, size: coarse.size(), round_off }))
}

/// Lattices about one interval.
fn lattice_plan(
    coarse: &ElasticBody,
    patch: &Patch,
    wanted: &WantedInterval,
    settings: &FineSettings,
) -> Result<RefinementPlan, AdaptiveError> {
    let mut spans = parameters(coarse, patch, wanted);
    let xi = wanted.face.on_face(&wanted.centre);
    let first = patch.jet(&xi, 1, &mut PointBasis::default()).first;
    let none = DirectionLattice { anchor: 0.0, spacing: 1.0, n_levels: 0, n_skipped: 0 };
    let (mut lattices, mut size) = ([none; 3], f64::INFINITY);
    for ((d, width), speed) in wanted.face.directions().zip(wanted.widths).zip(speeds(patch, wanted)) {
        let (Some(span), knots) = (&mut spans[d], &patch.knots()[d]) else { continue };
        check_resolved(coarse, knots, (width, (span[1] - span[0]) / settings.elements as f64, speed))?;
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
    let region = region(coarse, patch, wanted, &spans, &along, &mut [0; 3]);
    Ok(RefinementPlan { division: Division::Lattice(lattices), regions: vec![region] })
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
        regions.push(region(coarse, patch, w, span, &along, &mut taken));
    }
    Ok(RefinementPlan { division: Division::Parts(parts), regions })
}

/// Metres a unit of parameter along the directions of the face, at the centre of an interval.
pub(super) fn speeds(patch: &Patch, wanted: &WantedInterval) -> impl Iterator<Item = f64> {
    let xi = wanted.face.on_face(&wanted.centre);
    let first = patch.jet(&xi, 1, &mut PointBasis::default()).first;
    wanted.face.directions().map(move |d| norm(&first[d]))
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
    for (w, region) in wanted.iter().zip(&plan.regions) {
        let [lower, upper] = [region.lower, region.upper].map(|corner| w.face.on_face(&corner));
        if let Some(set) = coarse.shape.singular_in(w.face.id.patch, &lower, &upper) {
            let what = Unsupported::SingularInterval { set: set.name.clone() };
            return Err(AdaptiveError::unsupported_body(&coarse.name, what));
        }
    }
    Ok(())
}

/// Parts into the depth, so that elements at the contact have about the same size in all directions.
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

/// The box around which the levels are refined for an interval, its ends moved to knots. `taken` counts the intervals
/// of each direction that were used before.
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

/// Elements by which a level that splits elements into `parts` reaches beyond an interval. A function of the finer level
/// that is not zero on the interval ends within the degree divided by `parts` elements of the coarser one.
fn growth(knots: &KnotVector, parts: usize, settings: &FineSettings) -> usize {
    let degree = knots.degree();
    let own = if parts == 1 { degree } else { degree.div_ceil(2) };
    settings.growth.map_or(own, |g| g.min(degree))
}

/// The levels of a plan.
pub(super) fn refined(
    patch: &Patch,
    plan: &RefinementPlan,
    settings: &FineSettings,
) -> Result<SubdomainHierarchy, SplineError> {
    let ties = PatchTies::detect(patch);
    let mut hierarchy = SubdomainHierarchy::new(patch.knots());
    let levels = match &plan.division {
        Division::Lattice(lattices) => {
            return refined_lattice(hierarchy, lattices, &plan.regions, settings, &ties);
        }
        Division::Parts(parts) => parts,
    };
    for &parts in levels.iter().filter(|p| p.iter().any(|&n| n > 1)) {
        let growth =
            std::array::from_fn(|d| patch.knots().get(d).map_or(0, |k| growth(k, parts[d], settings)));
        let boxes = hierarchy.elements_around(&plan.regions, growth, &ties)?;
        let levels = hierarchy.levels();
        let coarse = levels[levels.len() - 1].knots();
        let split = |(d, k): (usize, &KnotVector)| {
            split_inside(k, parts[d], |e| boxes.iter().any(|b| (b.lower[d]..b.upper[d]).contains(&e)))
        };
        let knots = coarse.iter().enumerate().map(split).collect::<Result<Vec<_>, _>>()?;
        hierarchy.refine_knots(knots, &boxes)?;
    }
    Ok(hierarchy)
}

/// The levels of lattices.
fn refined_lattice(
    mut hierarchy: SubdomainHierarchy,
    lattices: &[DirectionLattice; 3],
    regions: &[ParameterBox],
    settings: &FineSettings,
    ties: &PatchTies,
) -> Result<SubdomainHierarchy, SplineError> {
    let n_levels = lattices.iter().map(|l| l.n_skipped + l.n_levels).max().unwrap_or(0);
    for level in (0..n_levels).rev() {
        let levels = hierarchy.levels();
        let coarse = levels[levels.len() - 1].knots().to_vec();
        // Levels beyond the finest reach out further: their elements then grow with the distance from the contact.
        let reach = |d: usize| {
            let divides = lattices[d].divides(level);
            let own = growth(&coarse[d], if divides { 2 } else { 1 }, settings);
            // Finer levels that leave the direction as it is reach out by its degree. Elements of this one hold two of those, but
            // for two at a knot of the coarse model.
            let finer =
                if divides && lattices[d].n_skipped > 0 { coarse[d].degree().div_ceil(2) + 1 } else { 0 };
            own.max(finer).max(if level == 0 { 1 } else { COARSE_REACH })
        };
        let by = std::array::from_fn(|d| if d < coarse.len() { reach(d) } else { 0 });
        let boxes = hierarchy.elements_around(regions, by, ties)?;
        let split = |(d, k): (usize, &KnotVector)| {
            lattices[d].refine(k, level, |e| boxes.iter().any(|b| (b.lower[d]..b.upper[d]).contains(&e)))
        };
        let knots = coarse.iter().enumerate().map(split).collect::<Result<Vec<_>, _>>()?;
        if knots != coarse {
            hierarchy.refine_knots(knots, &boxes)?;
        }
    }
    Ok(hierarchy)
}

/// Splits the elements that are `wanted` into `parts` equal ones. Elsewhere the next level is not used and needs no knots, of
/// which a long body would have many.
fn split_inside(
    coarse: &KnotVector,
    parts: usize,
    wanted: impl Fn(usize) -> bool,
) -> Result<KnotVector, SplineError> {
    let mut new = Vec::new();
    for e in (0..coarse.n_elements()).filter(|&e| wanted(e)) {
        let (a, b) = coarse.element(e);
        new.extend((1..parts).map(|k| a + (b - a) * (k as f64 / parts as f64)));
    }
    coarse.with_knots(&new)
}

pub(super) fn fine_intervals(
    coarse: &ElasticBody,
    patch: &Patch,
    space: &HierarchicalSpace,
    wanted: &[WantedInterval],
    plan: &RefinementPlan,
) -> Vec<FineInterval> {
    let levels = space.basis().hierarchy().levels();
    let knots = levels[levels.len() - 1].knots();
    let make = |(w, region): (&WantedInterval, &ParameterBox)| {
        let directions: Vec<usize> = w.face.directions().collect();
        let mut slack = [0.0; 3];
        directions.iter().for_each(|&d| slack[d] = PARAMETER_SLACK * least_element(&knots[d], region, d));
        let (mut n_elements, mut first) = ([1; 2], [0; 2]);
        for (i, &d) in directions.iter().enumerate() {
            first[i] = knots[d].find_element(region.lower[d] + slack[d]);
            n_elements[i] = knots[d].find_element(region.upper[d] - slack[d]) + 1 - first[i];
        }
        let ends = directions.iter().map(|&d| interval_ends(coarse, patch, &w.face, region, (d, slack[d])));
        let ends = ends.collect();
        let (face, widths) = (w.face, w.widths);
        FineInterval { face, directions, region: *region, ends, n_elements, widths, first, slack }
    };
    wanted.iter().zip(&plan.regions).map(make).collect()
}

/// Smallest of the elements that meet `region` in direction `d`.
fn least_element(knots: &KnotVector, region: &ParameterBox, d: usize) -> f64 {
    let (lower, upper) = (region.lower[d], region.upper[d]);
    let sizes = (knots.find_element(lower)..=knots.find_element(upper)).map(|e| {
        let (a, b) = knots.element(e);
        b - a
    });
    sizes.fold(f64::INFINITY, f64::min)
}

/// What lies at both ends of an interval in direction `d`, along which parameters have a `slack`.
fn interval_ends(
    coarse: &ElasticBody,
    patch: &Patch,
    face: &Face,
    region: &ParameterBox,
    (d, slack): (usize, f64),
) -> [IntervalEnd; 2] {
    let (first, last) = patch.knots()[d].domain();
    let corners = [&region.lower, &region.upper].map(|corner| patch.point(&face.on_face(corner)));
    let extent = norm(&std::array::from_fn(|c| corners[1][c] - corners[0][c]));
    [(region.lower, first), (region.upper, last)].map(|(corner, end)| {
        let is_axis = coarse.spec.model == Model::Axisymmetric
            && patch.point(&face.on_face(&corner))[0].abs() < PARAMETER_SLACK * extent;
        match ((corner[d] - end).abs() <= slack, is_axis) {
            (false, _) => IntervalEnd::Open,
            (true, true) => IntervalEnd::Axis,
            (true, false) => IntervalEnd::FaceEnd,
        }
    })
}
