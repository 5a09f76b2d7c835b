//! Discs on the surface and balls inside, on whatever body: polar rules about the centre.
//!
//! A disc is a polar rule in the tangent plane, carried to the surface along the normal. With the
//! normals `n` of the surface and `n₀` at the centre, an area `dA₀` of the plane is
//! `dA = dA₀ / (n · n₀)` of the surface. In two dimensions the disc is a line through the centre,
//! from the axis outwards if the centre lies on it, and a ball a disc.

use super::{ExtentPoint, ON_SURFACE};
use crate::elasticity::Model;
use crate::nurbs::jet::{cross, norm};
use crate::quadrature::GaussRule;

/// Parts of the radius beyond which a disc, or a ball in two dimensions, is not divided further: 64
/// × 256 points.
const MOST_PARTS: usize = 16;
/// The same of a ball: 32 × 32 × 64 points.
const MOST_PARTS_OF_BALL: usize = 8;
/// Parts of the radius on coarse meshes: lines between elements that cross the extent make kinks of
/// the functions there.
const LEAST_PARTS: usize = 2;
/// Gauss points of each part of a radius.
const PART_POINTS: usize = 4;
/// Part of the radius within which a centre counts as lying on the axis.
const ON_AXIS: f64 = 1e-9;

/// The place of the surface that is nearest to a point.
#[derive(Debug, Clone, Copy)]
pub struct Nearest<S> {
    /// Distance from the point \[m\].
    pub distance: f64,
    /// Position \[m\].
    pub point: [f64; 3],
    /// Outward unit normal there or right beside; none where there is none.
    pub normal: Option<[f64; 3]>,
    /// Where searches nearby begin.
    pub start: S,
}

/// A place that a search has found.
#[derive(Debug, Clone, Copy)]
pub struct Found<S> {
    /// Element.
    pub element: usize,
    /// Parameters in it.
    pub xi: [f64; 3],
    /// Position \[m\].
    pub point: [f64; 3],
    /// Sides of the element there that lead along the extent; zero of others \[m\].
    pub sides: [f64; 3],
    /// Where the next search begins.
    pub start: S,
}

/// What a disc or ball asks of its body.
pub trait Surroundings {
    /// Where a search begins.
    type Start: Copy;
    /// What is wrong with an extent.
    type Fault;

    /// Kinematics.
    fn model(&self) -> &Model;

    /// The place of the surface nearest to `point`.
    fn nearest(&self, point: &[f64; 3]) -> Option<Nearest<Self::Start>>;

    /// The surface on the line along the unit vector `normal` through `target`, with the cosine of
    /// the angle between its normal and that; none if it is not there, or too steep.
    fn over(
        &self,
        target: &[f64; 3],
        normal: &[f64; 3],
        start: Self::Start,
    ) -> Option<(Found<Self::Start>, f64)>;

    /// The point `target` inside.
    fn inside(&self, target: &[f64; 3], start: Option<Self::Start>) -> Option<Found<Self::Start>>;

    /// Tells why `point` is not in the body, if so.
    ///
    /// # Errors
    /// The distance.
    fn check_inside(&self, point: &[f64; 3]) -> Result<(), Self::Fault>;

    /// A `kind` of radius `radius` about `point` leaves the body.
    fn leaves(&self, kind: &'static str, radius: f64, point: [f64; 3]) -> Self::Fault;
}

/// What lies within `radius` of `point`: of a point on the surface what lies over a disc in the
/// plane that touches it there, of one inside a ball. The points lie closer than the smallest
/// element there, down to a limit.
///
/// # Errors
/// [`Surroundings::leaves`], [`Surroundings::check_inside`].
pub fn around<B: Surroundings>(
    body: &B,
    point: &[f64; 3],
    radius: f64,
) -> Result<Vec<ExtentPoint>, B::Fault> {
    match body.nearest(point) {
        Some(at) if at.distance <= ON_SURFACE * radius => {
            let leaves = || body.leaves("disc", radius, *point);
            let normal = at.normal.ok_or_else(leaves)?;
            refined(radius, MOST_PARTS, |parts| disc(body, &at, &normal, (radius, parts))).ok_or_else(leaves)
        }
        _ => {
            body.check_inside(point)?;
            let most = if body.model().dimension() == 2 { MOST_PARTS } else { MOST_PARTS_OF_BALL };
            refined(radius, most, |parts| ball(body, point, (radius, parts)))
                .ok_or_else(|| body.leaves("ball", radius, *point))
        }
    }
}

/// Points, and the length of the shortest side of their elements \[m\].
type WithShortest = (Vec<ExtentPoint>, f64);

/// The points that `rule` gives of a radius cut into so many parts that none is longer than an
/// element, `most` at most.
fn refined(
    radius: f64,
    most: usize,
    rule: impl Fn(usize) -> Option<WithShortest>,
) -> Option<Vec<ExtentPoint>> {
    let (coarse, shortest) = rule(LEAST_PARTS)?;
    // A quotient that is no number or infinite ends at the limit.
    let wanted = (radius / shortest).ceil();
    let parts = if wanted < most as f64 { (wanted as usize).max(LEAST_PARTS) } else { most };
    if parts == LEAST_PARTS { Some(coarse) } else { rule(parts).map(|(points, _)| points) }
}

/// Takes a point into the rule.
fn push<S>(body: &Model, found: &Found<S>, weight: f64, (points, shortest): &mut WithShortest) {
    let &Found { element, xi, point, sides, .. } = found;
    points.push(ExtentPoint { element, xi, point, weight: weight * body.measure(&point) });
    *shortest = sides.into_iter().filter(|side| *side > 0.0).fold(*shortest, f64::min);
}

/// Points of the disc about the surface place `centre`.
fn disc<B: Surroundings>(
    body: &B,
    centre: &Nearest<B::Start>,
    normal: &[f64; 3],
    (radius, parts): (f64, usize),
) -> Option<WithShortest> {
    let is_plane = body.model().dimension() == 2;
    let along = if is_plane {
        [normal[1], -normal[0], 0.0]
    } else {
        let least = (0..3).min_by(|&i, &j| normal[i].abs().total_cmp(&normal[j].abs())).unwrap_or(0);
        let mut axis = [0.0; 3];
        axis[least] = 1.0;
        let across = cross(normal, &axis);
        across.map(|c| c / norm(&across))
    };
    let across = if is_plane { [0.0; 3] } else { cross(normal, &along) };
    let is_on_axis = *body.model() == Model::Axisymmetric && centre.point[0] <= ON_AXIS * radius;
    let rule = if !is_plane {
        circle(radius, parts)
    } else if is_on_axis {
        let outwards = if along[0] < 0.0 { -1.0 } else { 1.0 };
        composite(0.0, radius, parts).into_iter().map(|(s, w)| ([outwards * s, 0.0], w)).collect()
    } else {
        composite(-radius, radius, 2 * parts).into_iter().map(|(s, w)| ([s, 0.0], w)).collect()
    };
    let (mut all, mut start) = ((Vec::new(), f64::INFINITY), centre.start);
    for ([a, b], weight) in rule {
        let target = [0, 1, 2].map(|c| centre.point[c] + a * along[c] + b * across[c]);
        let (found, cosine) = body.over(&target, normal, start)?;
        push(body.model(), &found, weight / cosine, &mut all);
        start = found.start;
    }
    Some(all)
}

/// Points of the ball about `centre`.
fn ball<B: Surroundings>(body: &B, centre: &[f64; 3], (radius, parts): (f64, usize)) -> Option<WithShortest> {
    let (model, mut all, mut start) = (body.model(), (Vec::new(), f64::INFINITY), None);
    for (offset, weight) in ball_rule(model, centre, (radius, parts)) {
        let target = [0, 1, 2].map(|c| centre[c] + offset[c]);
        let is_beyond_axis = *model == Model::Axisymmetric && target[0] < 0.0;
        let found = body.inside(&target, start).filter(|_| !is_beyond_axis)?;
        push(model, &found, weight, &mut all);
        start = Some(found.start);
    }
    Some(all)
}

/// Offsets from the centre of a ball with their measures.
fn ball_rule(model: &Model, centre: &[f64; 3], (radius, parts): (f64, usize)) -> Vec<([f64; 3], f64)> {
    let radii = || composite(0.0, radius, parts);
    if model.dimension() == 3 {
        let n = 8 * parts;
        let share = std::f64::consts::TAU / n as f64;
        let mut points = Vec::new();
        for (rho, w) in radii() {
            for (height, v) in composite(-1.0, 1.0, parts) {
                let ring = rho * (1.0 - height * height).sqrt();
                let weight = rho * rho * w * v * share;
                points
                    .extend(directions(n).map(|(cos, sin)| ([ring * cos, ring * sin, rho * height], weight)));
            }
        }
        return points;
    }
    if *model == Model::Axisymmetric && centre[0] <= ON_AXIS * radius {
        // Half a disc, which turned about the axis is a ball.
        let quarter = std::f64::consts::FRAC_PI_2;
        let angles = composite(-quarter, quarter, 2 * parts);
        let ray = |(rho, w): (f64, f64)| {
            angles.iter().map(move |(a, v)| ([rho * a.cos(), rho * a.sin(), 0.0], rho * w * v))
        };
        return radii().into_iter().flat_map(ray).collect();
    }
    circle(radius, parts).into_iter().map(|([x, y], w)| ([x, y, 0.0], w)).collect()
}

/// Points of a circle in its plane with their areas.
fn circle(radius: f64, parts: usize) -> Vec<([f64; 2], f64)> {
    let n = 16 * parts;
    let share = std::f64::consts::TAU / n as f64;
    let ring =
        |(rho, w): (f64, f64)| directions(n).map(move |(cos, sin)| ([rho * cos, rho * sin], rho * w * share));
    composite(0.0, radius, parts).into_iter().flat_map(ring).collect()
}

/// Points and weights on `[lower, upper]` in `parts` equal parts.
fn composite(lower: f64, upper: f64, parts: usize) -> Vec<(f64, f64)> {
    let rule = GaussRule::new(PART_POINTS);
    let size = (upper - lower) / parts as f64;
    let part = |i: usize| {
        let (start, mut points) = (lower + i as f64 * size, Vec::with_capacity(PART_POINTS));
        rule.points_on(start, start + size, &mut points);
        points.into_iter().zip(rule.weights.iter().map(|w| 0.5 * size * w)).collect::<Vec<_>>()
    };
    (0..parts).flat_map(part).collect()
}

/// Cosine and sine of `n` directions around the circle, none of them along an axis.
fn directions(n: usize) -> impl Iterator<Item = (f64, f64)> {
    (0..n).map(move |k| {
        let (sin, cos) = (std::f64::consts::TAU * (k as f64 + 0.5) / n as f64).sin_cos();
        (cos, sin)
    })
}
