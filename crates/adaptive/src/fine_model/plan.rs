//! Where the levels of a fine model lie: by Algorithm 3 of \[A\], or lattices on solid bodies (theory section A.2).

use iga_core::SplineError;
use iga_core::elasticity::Model;
use iga_core::hierarchical::{HierarchicalSpace, ParameterBox, PatchTies, SubdomainHierarchy};
use iga_core::knots::KnotVector;
use iga_core::nurbs::Patch;
use iga_core::nurbs::jet::norm;
use iga_core::nurbs::local::parameter_at_distance;
use iga_core::nurbs::patch::PointBasis;
use iga_core::surface::Face;

use super::{Division, FineInterval, FineSettings, RefinementPlan, WantedInterval};
use crate::elastic_body::ElasticBody;
use crate::error::AdaptiveError;
use crate::interval::IntervalEnd;
use crate::lattice::DirectionLattice;
use crate::subdivision::{DirectionPlan, SubdivisionError, SurfaceGrowth, divide, follow};

/// Slack of comparisons between parameters, as a share of the patch's range: round-off of knots and arc lengths.
const PARAMETER_SLACK: f64 = 1e-9;

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

/// How deep the refinement goes: half the width of the whole interval \[m\].
fn depth(coarse: &ElasticBody, patch: &Patch, wanted: &WantedInterval) -> f64 {
    let point = patch.point(&wanted.face.on_face(&wanted.centre));
    let half = |&w: &f64| reach(coarse, &point, w)[1];
    wanted.widths[..wanted.face.directions().count()].iter().map(half).fold(0.0, f64::max)
}

/// Levels and regions for all intervals of a body.
pub(super) fn plan(
    coarse: &ElasticBody,
    patch: &Patch,
    wanted: &[WantedInterval],
    settings: &FineSettings,
) -> Result<RefinementPlan, AdaptiveError> {
    match wanted {
        [one] if patch.dimension() == 3 => lattice_plan(coarse, patch, one, settings),
        _ => parts_plan(coarse, patch, wanted, settings),
    }
}

/// Lattices about one interval of a solid body.
fn lattice_plan(
    coarse: &ElasticBody,
    patch: &Patch,
    wanted: &WantedInterval,
    settings: &FineSettings,
) -> Result<RefinementPlan, AdaptiveError> {
    let mut spans = parameters(coarse, patch, wanted);
    let xi = wanted.face.on_face(&wanted.centre);
    let first = patch.jet(&xi, 1, &mut PointBasis::default()).first;
    let none = DirectionLattice { anchor: 0.0, spacing: 1.0, n_levels: 0 };
    let (mut lattices, mut size) = ([none; 3], f64::INFINITY);
    for d in 0..3 {
        let Some(span) = &mut spans[d] else { continue };
        (lattices[d], *span) = DirectionLattice::along(&patch.knots()[d], *span, settings.limits.elements);
        size = size.min(lattices[d].spacing * norm(&first[d]));
    }
    let across = wanted.face.id.direction;
    let spacing = size / norm(&first[across]);
    lattices[across] = DirectionLattice::into_depth(&patch.knots()[across], wanted.face.parameter, spacing);
    let n_levels = lattices.iter().map(|l| l.n_levels).max().unwrap_or(0);
    if n_levels + 1 > settings.limits.max_levels {
        let source = SubdivisionError::TooManyLevels {
            needed: n_levels + 1,
            allowed: settings.limits.max_levels,
            width: wanted.widths[0].min(wanted.widths[1]),
        };
        return Err(AdaptiveError::Subdivision { body: coarse.name.clone(), source });
    }
    let along = spans.map(|span| {
        span.map(|interval| DirectionPlan {
            parts: Vec::new(),
            intervals: vec![interval],
            n_elements: vec![settings.limits.elements],
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
    let fail = |source| AdaptiveError::Subdivision { body: coarse.name.clone(), source };
    let spans: Vec<_> = wanted.iter().map(|w| parameters(coarse, patch, w)).collect();
    let mut along: [Option<DirectionPlan>; 3] = Default::default();
    for (d, knots) in patch.knots().iter().enumerate() {
        let intervals: Vec<[f64; 2]> = spans.iter().filter_map(|s| s[d]).collect();
        if !intervals.is_empty() {
            let growth = growth(knots, 2, settings);
            let surface = SurfaceGrowth { growth, directions: patch.dimension() as i32 - 1 };
            along[d] = Some(divide(&knots.breaks(), &intervals, surface, &settings.limits).map_err(fail)?);
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
        let into_depth = wanted.iter().map(|w| depth_parts(patch, w, d, &parts, settings));
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

/// Refuses intervals that touch a singular line of the parametrisation.
pub(super) fn check_regular(
    coarse: &ElasticBody,
    wanted: &[WantedInterval],
    plan: &RefinementPlan,
) -> Result<(), AdaptiveError> {
    for (w, region) in wanted.iter().zip(&plan.regions) {
        let [lower, upper] = [region.lower, region.upper].map(|corner| w.face.on_face(&corner));
        if let Some(set) = coarse.shape.singular_in(w.face.id.patch, &lower, &upper) {
            return Err(AdaptiveError::Unsupported {
                subject: format!("body \"{}\"", coarse.name),
                reason: format!(
                    "a contact interval touches the singular {} of the parametrisation; turn the body's frame or choose another net",
                    set.name
                ),
            });
        }
    }
    Ok(())
}

/// Parts into the depth, so that elements at the contact have about the same size in all directions.
fn depth_parts(
    patch: &Patch,
    wanted: &WantedInterval,
    depth: usize,
    parts: &[[usize; 3]],
    settings: &FineSettings,
) -> Vec<usize> {
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
    follow(size(depth), &along, &settings.limits)
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
                let surface = wanted.face.on_face(&wanted.centre);
                let inwards = if wanted.face.id.upper { -1.0 } else { 1.0 };
                let end = parameter_at_distance(patch, &surface, d, inwards * depth(coarse, patch, wanted));
                [end.min(wanted.face.parameter), end.max(wanted.face.parameter)]
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
        let mut boxes = Vec::new();
        for region in &plan.regions {
            boxes.extend(hierarchy.elements_around(region, growth, &ties)?);
        }
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
    let n_levels = lattices.iter().map(|l| l.n_levels).max().unwrap_or(0);
    for level in (0..n_levels).rev() {
        let levels = hierarchy.levels();
        let coarse = levels[levels.len() - 1].knots().to_vec();
        // Levels beyond the finest reach out further: their elements then grow with the distance from the contact.
        let reach = |d: usize| {
            let parts = if level < lattices[d].n_levels { 2 } else { 1 };
            growth(&coarse[d], parts, settings).max(if level == 0 { 1 } else { COARSE_REACH })
        };
        let by = std::array::from_fn(|d| if d < coarse.len() { reach(d) } else { 0 });
        let mut boxes = Vec::new();
        for region in regions {
            boxes.extend(hierarchy.elements_around(region, by, ties)?);
        }
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
        let slack = std::array::from_fn(|d| {
            knots.get(d).map_or(0.0, |k| PARAMETER_SLACK * (k.domain().1 - k.domain().0))
        });
        let (mut n_elements, mut first) = ([1; 2], [0; 2]);
        for (i, &d) in directions.iter().enumerate() {
            first[i] = knots[d].find_element(region.lower[d] + slack[d]);
            n_elements[i] = knots[d].find_element(region.upper[d] - slack[d]) + 1 - first[i];
        }
        let ends = directions.iter().map(|&d| interval_ends(coarse, patch, &w.face, region, d)).collect();
        let (face, widths) = (w.face, w.widths);
        FineInterval { face, directions, region: *region, ends, n_elements, widths, first, slack }
    };
    wanted.iter().zip(&plan.regions).map(make).collect()
}

/// What lies at both ends of an interval in direction `d`.
fn interval_ends(
    coarse: &ElasticBody,
    patch: &Patch,
    face: &Face,
    region: &ParameterBox,
    d: usize,
) -> [IntervalEnd; 2] {
    let (first, last) = patch.knots()[d].domain();
    let slack = PARAMETER_SLACK * (last - first);
    let size = coarse.size();
    [(region.lower, first), (region.upper, last)].map(|(corner, end)| {
        let is_axis = coarse.spec.model == Model::Axisymmetric
            && patch.point(&face.on_face(&corner))[0].abs() < PARAMETER_SLACK * size;
        match ((corner[d] - end).abs() <= slack, is_axis) {
            (false, _) => IntervalEnd::Open,
            (true, true) => IntervalEnd::Axis,
            (true, false) => IntervalEnd::FaceEnd,
        }
    })
}
