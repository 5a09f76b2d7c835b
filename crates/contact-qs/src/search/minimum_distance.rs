//! Minimum distance between the deformed, moving surfaces of two bodies (\[A\] (7); theory
//! Eqs. C.28 to C.31).
//!
//! Two trees of boxes are descended together, nearest pairs first; a pair of pieces is left out if
//! its boxes, or its control points along the best direction so far, lie farther apart than the
//! best pair. On the rest a Newton method in a box of two or four parameters starts from the
//! nearest pair of control points. The last answer comes first, so that in a slow motion the
//! descent only certifies it. All geometry is done in the frame of the first body: distances keep
//! their digits however far from the origin the bodies are.

use ffr_dynamics::body::RigidMotion;
use ffr_dynamics::force::BodyState;
use iga_core::nurbs::locate::box_newton::{Sample, minimize};
use nalgebra::Vector3;

use super::boxes::{NodeKind, Placement};
use super::deformed::{Deformed, Site};
use super::penetration::{self, deepest};
use super::query::{Pair, Query, SearchReport, SearchWorkspace, in_first_frame, separation};
use super::signed_distance::{ALONG_NORMAL, nearest};
use super::surface_model::{SurfaceModel, SurfaceSite};
use crate::ContactError;

/// How near two bodies are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Proximity {
    /// Gap (theory Eq. C.30): distance of the surfaces apart, minus the depth of the deepest point
    /// when they overlap \[m\].
    pub gap: f64,
    /// Critical points of the contact body and of the target.
    pub sites: [SurfaceSite; 2],
    /// The same as places on the pieces of the surfaces.
    pub places: [Site; 2],
    /// Unit vector towards the contact body in the inertial frame; `gap = n · (x_C - x_T)`. Zero if
    /// the surfaces touch at places without a normal.
    pub normal: Vector3<f64>,
}

/// The gap between the contact body and the target in the motions `states`, with the points at
/// which it is attained.
///
/// Repeated calls on one workspace start from the last answer and do not allocate. The answer does
/// not depend on where the search started, except among places that are equally near.
///
/// # Errors
/// [`ContactError::Motion`] if a state is not finite or has another number of modes; [`ContactError::Data`] if the
/// models are of different kinds.
pub fn minimum_distance(
    models: [&SurfaceModel; 2],
    states: [&BodyState; 2],
    workspace: &mut SearchWorkspace,
) -> Result<Proximity, ContactError> {
    let placement = checked_placement(models, states)?;
    let query = Query::new(models, &states, &placement);
    workspace.begin(models);
    let found = signed_pair(&query, workspace)
        .ok_or_else(|| ContactError::Motion("positions: they overflow".into()))?;
    workspace.last = Some(found.0.sites);
    Ok(proximity(&query, states[0], &found.0, found.1, found.2))
}

/// Whether a point of the first surface, which may be a part of that of its body, lies inside the
/// second body, whose surface is whole, in the motions `states`: of the corners of its pieces and
/// the middles between them.
///
/// # Errors
/// As [`minimum_distance`].
pub fn reaches_into(
    models: [&SurfaceModel; 2],
    states: [&BodyState; 2],
    workspace: &mut SearchWorkspace,
) -> Result<bool, ContactError> {
    let placement = checked_placement(models, states)?;
    workspace.begin(models);
    Ok(penetration::reaches_into(&Query::new(models, &states, &placement), workspace))
}

/// Where the second body stands in the frame of the first.
fn checked_placement(models: [&SurfaceModel; 2], states: [&BodyState; 2]) -> Result<Placement, ContactError> {
    if models[0].motion() != models[1].motion() {
        return Err(ContactError::MixedModels { first: models[0].motion(), second: models[1].motion() });
    }
    for (model, state) in models.iter().zip(&states) {
        check_state(model, state)?;
    }
    in_first_frame(models[0].motion(), states).map_err(ContactError::Motion)
}

/// Checks that a search can run.
pub(super) fn check_state(model: &SurfaceModel, state: &BodyState) -> Result<(), ContactError> {
    let not_finite = |what| Err(ContactError::Motion(format!("{what}: not finite")));
    let (modes, found) = (model.n_modes(), state.elastic.len());
    if modes != found {
        return Err(ContactError::Motion(format!(
            "elastic coordinates: {found} for a surface of {modes} modes"
        )));
    }
    if state.position.iter().any(|x| !x.is_finite()) {
        return not_finite("position");
    }
    if state.rotation.coords.iter().any(|x| !x.is_finite()) {
        return not_finite("rotation");
    }
    if state.elastic.iter().any(|x| !x.is_finite()) {
        return not_finite("elastic coordinates");
    }
    if model.motion() == RigidMotion::Axial && state.rotation.angle() > 1e-12 {
        return Err(ContactError::Motion("rotation: an axial body does not turn".into()));
    }
    Ok(())
}

/// Distance relative to the bodies' size below which the search looks for points inside: where
/// surfaces cross, Newton's method ends at a distance of round-off whose direction tells nothing.
const NEAR_TOUCH: f64 = 1e-9;

/// Pair, signed gap and unit normal in the frame of the search.
fn signed_pair(query: &Query<'_>, ws: &mut SearchWorkspace) -> Option<(Pair, f64, Vector3<f64>)> {
    let (pair, is_inside) = closest_pair(query, ws)?;
    if !is_inside && pair.distance > NEAR_TOUCH * query.size() {
        let normal = pair.direction.unwrap_or_else(Vector3::zeros);
        return Some((pair, pair.distance, normal));
    }
    // Touching or overlapping: without a point inside the other body the surfaces only touch.
    Some(match deepest(query, ws, &pair) {
        Some((deep, value, normal)) => (deep, value, normal),
        None => {
            let normal = pair.direction.unwrap_or_else(Vector3::zeros);
            (pair, pair.distance, normal)
        }
    })
}

/// Whether a point of a pair lies inside the other body. Asked is only where the cosine between the
/// line that leaves the other body and its normal is below `most`: the nearest pair of all, with a
/// larger one than [`ALONG_NORMAL`], lies outside. `None` if numbers are not finite.
fn is_inside(query: &Query<'_>, ws: &mut SearchWorkspace, pair: &Pair, most: f64) -> Option<bool> {
    let Some(direction) = pair.direction else { return Some(false) };
    for (b, sign) in [(1, 1.0), (0, -1.0)] {
        let (side, site) = (&query.sides[b], &pair.sites[b]);
        let jet = ws.deformed[b].jet(side, site.piece, site.s);
        let normal = ws.deformed[b].normal(side, site, &jet);
        if direction.dot(&normal) * sign < most {
            let near = nearest(side, &mut ws.deformed[b], &mut ws.stack, &pair.points[1 - b], Some(*site))?;
            if near.value < 0.0 {
                return Some(true);
            }
        }
    }
    Some(false)
}

/// Nearest pair of surface points (theory Eq. C.29), or the first one found of which a point lies
/// inside the other body, with whether it does. Between overlapping bodies the distance is
/// stationary where they lie deepest in each other: a search that comes there, as one from the last
/// answer does, need not find the way to where the surfaces cross.
fn closest_pair(query: &Query<'_>, ws: &mut SearchWorkspace) -> Option<(Pair, bool)> {
    let mut report = SearchReport::default();
    let mut best: Option<Pair> = None;
    let last = ws.last.filter(|sites| {
        sites.iter().zip(&query.sides).all(|(s, side)| (s.piece as usize) < side.model.n_pieces())
    });
    if let Some(sites) = last {
        ws.load(query, sites.map(|s| s.piece));
        report.is_warm = true;
        report.n_newton += 1;
        best = Some(on_pieces(query, &ws.deformed, sites));
    }
    let mut is_overlap = match &best {
        Some(pair) => is_inside(query, ws, pair, ALONG_NORMAL)?,
        None => false,
    };
    let inflation = query.sides[0].inflation + query.sides[1].inflation;
    let nodes = query.sides.map(|s| s.model.nodes());
    let mut pairs = std::mem::take(&mut ws.pairs);
    pairs.clear();
    pairs.push((0.0, 0, 0));
    while let Some((bound, a, b)) = pairs.pop() {
        let limit = best.map_or(f64::INFINITY, |p: Pair| p.distance - query.resolution);
        if is_overlap || limit <= 0.0 {
            break; // nothing nearer can be told
        }
        if bound >= limit {
            continue;
        }
        let direction = best.as_ref().and_then(|p| p.direction);
        let (u, v) = (&nodes[0][a as usize], &nodes[1][b as usize]);
        let split = match (u.kind, v.kind) {
            (NodeKind::Piece(i), NodeKind::Piece(j)) => {
                if last.is_some_and(|sites| sites[0].piece == i && sites[1].piece == j) {
                    continue;
                }
                if let Some(start) = start_on_pieces(query, ws, [i, j], limit, direction) {
                    report.n_newton += 1;
                    let found = on_pieces(query, &ws.deformed, start);
                    let is_nearer = best.is_none_or(|p| found.distance < p.distance);
                    let most = if is_nearer { ALONG_NORMAL } else { -ALONG_NORMAL };
                    is_overlap = is_inside(query, ws, &found, most)?;
                    if is_nearer || is_overlap {
                        best = Some(found);
                    }
                }
                continue;
            }
            (NodeKind::Children(c), NodeKind::Piece(_)) => c.map(|c| (c, b)),
            (NodeKind::Piece(_), NodeKind::Children(c)) => c.map(|c| (a, c)),
            (NodeKind::Children(c), NodeKind::Children(d)) => {
                if u.bounds.half.norm_squared() >= v.bounds.half.norm_squared() {
                    c.map(|c| (c, b))
                } else {
                    d.map(|d| (a, d))
                }
            }
        };
        report.n_boxes += 2;
        let direction = direction.map(|n| [n, query.placement.rotation.tr_mul(&n)]);
        let [first, second] = split.map(|(a, b)| {
            let (u, v) = (&nodes[0][a as usize], &nodes[1][b as usize]);
            let along = direction.map_or(0.0, |n| query.placement.separation(&u.disc, &v.disc, &n));
            let bound = if along - inflation >= limit {
                along
            } else {
                along.max(query.placement.distance(&u.bounds, &v.bounds))
            };
            (bound - inflation, a, b)
        });
        let both = if first.0 <= second.0 { [second, first] } else { [first, second] };
        pairs.extend(both.into_iter().filter(|p| p.0 < limit));
    }
    ws.pairs = pairs;
    ws.report = report;
    best.filter(|p| p.distance.is_finite()).map(|pair| (pair, is_overlap))
}

/// Where to start on two pieces: at the nearest pair of control points. None if the pieces lie at
/// least `limit` apart.
fn start_on_pieces(
    query: &Query<'_>,
    ws: &mut SearchWorkspace,
    pieces: [u32; 2],
    limit: f64,
    direction: Option<Vector3<f64>>,
) -> Option<[Site; 2]> {
    ws.load(query, pieces);
    let deformed = &ws.deformed;
    if deformed[0].bounds(pieces[0]).distance(deformed[1].bounds(pieces[1])) >= limit {
        return None;
    }
    let points = [0, 1].map(|b| deformed[b].points(&query.sides[b].model.pieces()[pieces[b] as usize]));
    if direction.is_some_and(|n| separation(points, &n) >= limit) {
        return None;
    }
    let mut best = (f64::INFINITY, 0, 0);
    for (j, y) in points[1].iter().enumerate() {
        for (i, x) in points[0].iter().enumerate() {
            let square = (x - y).norm_squared();
            if square < best.0 {
                best = (square, i, j);
            }
        }
    }
    let own = points[0][best.1] - points[1][best.2];
    if best.0 > 0.0 && separation(points, &(own / best.0.sqrt())) >= limit {
        return None;
    }
    let start = [best.1, best.2];
    Some([0, 1].map(|b| Site { piece: pieces[b], s: query.sides[b].parameters(pieces[b], start[b]) }))
}

/// Searches, each of which goes on where the one before has stopped: between surfaces that overlap
/// by little the distance falls along a valley, from the deepest place to where they cross, in
/// which steps grow no faster than they double.
const MOST_SEARCHES: usize = 8;
/// Cosine of the angle between the line of a nearest pair and a tangent, in which either may still
/// be moved, up to which they count as square.
const SQUARE: f64 = 1e-6;
/// Round-off of a slope, in that of positions.
const ROUND_OFF: f64 = 8.0;

/// Whether half the square of a distance is least at `s`, as far as its `sample` there tells: the
/// line is square to the surfaces, or held by bounds.
fn is_minimum(sample: &Sample<4>, s: &[f64; 4], upper: &[f64; 4]) -> bool {
    let distance = (2.0 * sample.value).sqrt();
    if distance <= 0.0 {
        return true;
    }
    let most = SQUARE * distance + ROUND_OFF * sample.noise / distance;
    let is_square = |d: usize| {
        let slope = sample.gradient[d];
        let is_held = s[d] <= 0.0 && slope > 0.0 || s[d] >= upper[d] && slope < 0.0;
        is_held || slope.abs() <= most * sample.hessian[d][d].abs().sqrt()
    };
    (0..4).all(is_square)
}

/// Local minimum of the distance on two pieces (theory Eq. C.29), from `start`.
fn on_pieces(query: &Query<'_>, deformed: &[Deformed; 2], start: [Site; 2]) -> Pair {
    let [a, b] = start.map(|s| s.piece);
    let [side_a, side_b] = &query.sides;
    let objective = |s: &[f64; 4]| {
        let x = deformed[0].jet(side_a, a, [s[0], s[1]]);
        let y = deformed[1].jet(side_b, b, [s[2], s[3]]);
        let r = x.point - y.point;
        let rounding = 4.0 * f64::EPSILON * (x.point.norm() + y.point.norm());
        let mut sample: Sample<4> = Sample {
            value: 0.5 * r.norm_squared(),
            noise: rounding * (r.norm() + rounding),
            ..Sample::default()
        };
        for i in 0..2 {
            sample.gradient[i] = r.dot(&x.first[i]);
            sample.gradient[2 + i] = -r.dot(&y.first[i]);
            for j in 0..2 {
                sample.hessian[i][j] = x.first[i].dot(&x.first[j]) + r.dot(&x.second[i + j]);
                sample.hessian[2 + i][2 + j] = y.first[i].dot(&y.first[j]) - r.dot(&y.second[i + j]);
                let mixed = -x.first[i].dot(&y.first[j]);
                (sample.hessian[i][2 + j], sample.hessian[2 + j][i]) = (mixed, mixed);
            }
        }
        sample
    };
    let (upper_a, upper_b) = (side_a.upper(a), side_b.upper(b));
    let from = [start[0].s[0], start[0].s[1], start[1].s[0], start[1].s[1]];
    let upper = [upper_a[0], upper_a[1], upper_b[0], upper_b[1]];
    let mut s = from;
    for _ in 0..MOST_SEARCHES {
        s = minimize(objective, &s, &[0.0; 4], &upper).0;
        if is_minimum(&objective(&s), &s, &upper) {
            break;
        }
    }
    let sites = [Site { piece: a, s: [s[0], s[1]] }, Site { piece: b, s: [s[2], s[3]] }];
    let points = [0, 1].map(|k| deformed[k].jet(&query.sides[k], sites[k].piece, sites[k].s).point);
    let r = points[0] - points[1];
    let distance = r.norm();
    Pair { sites, points, direction: (distance > query.resolution).then(|| r / distance), distance }
}

/// The answer in the inertial frame.
pub(super) fn proximity(
    query: &Query<'_>,
    frame: &BodyState,
    pair: &Pair,
    gap: f64,
    normal: Vector3<f64>,
) -> Proximity {
    let site = |b: usize| {
        let piece = &query.sides[b].model.pieces()[pair.sites[b].piece as usize];
        piece.origin.site(pair.sites[b].s, frame.position + frame.rotation * pair.points[b])
    };
    Proximity { gap, sites: [site(0), site(1)], places: pair.sites, normal: frame.rotation * normal }
}
