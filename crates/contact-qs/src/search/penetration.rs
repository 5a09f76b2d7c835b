//! Overlapping bodies: the deepest surface point of either body in the other (theory Eqs. C.30,
//! C.31).

use iga_core::nurbs::locate::box_newton::{Sample, minimize};
use nalgebra::Vector3;

use super::boxes::NodeKind;
use super::deformed::Site;
use super::query::{Pair, Query, SearchWorkspace, separation};
use super::signed_distance::{Nearest, along_piece, curvature, nearest, pieces_at, site_on_piece};

/// The most negative signed distance of a point of one surface from the other body: pair, gap and
/// unit normal towards the first body. `None` if no point lies inside.
///
/// Every piece that may cross the other surface is sampled and searched from its best sample; from
/// the deepest result on each body the descent goes on across the borders of pieces, into those
/// that lie wholly inside. Where an overlap has several deepest places, this finds one of them;
/// separate overlaps are told apart if they lie on different pieces.
pub(super) fn deepest(
    query: &Query<'_>,
    ws: &mut SearchWorkspace,
    touching: &Pair,
) -> Option<(Pair, f64, Vector3<f64>)> {
    let mut best: Option<(usize, Depth)> = None;
    let starts = [Some(touching.sites), ws.last.filter(|last| *last != touching.sites)];
    mark_overlaps(query, ws);
    for b in [0, 1] {
        let hint = touching.sites[1 - b];
        let mut own: Option<Depth> = None;
        let keep = |own: &mut Option<Depth>, found: Option<Depth>| {
            if let Some(found) = found.filter(|f| own.is_none_or(|o| f.near.value < o.near.value)) {
                *own = Some(found);
            }
        };
        for start in starts.iter().flatten() {
            if (start[b].piece as usize) < query.sides[b].model.n_pieces() {
                keep(&mut own, descend(query, ws, b, start[b], hint));
            }
        }
        ws.chosen.clear();
        ws.chosen.extend((0..query.sides[b].model.n_pieces() as u32).filter(|&k| ws.marks[b][k as usize]));
        for at in 0..ws.chosen.len() {
            let piece = ws.chosen[at];
            if let Some((_, start)) = best_sample(query, ws, b, piece, hint) {
                keep(&mut own, descend(query, ws, b, start, hint));
            }
        }
        if let Some(found) = own.map(|o| walk(query, ws, b, o))
            && found.near.value < best.map_or(0.0, |(_, d)| d.near.value)
        {
            best = Some((b, found));
        }
    }
    best.map(|(b, Depth { site, point, near })| {
        let (sites, points, normal) = if b == 0 {
            ([site, near.site], [point, near.point], near.direction)
        } else {
            ([near.site, site], [near.point, point], -near.direction)
        };
        let pair = Pair { sites, points, direction: Some(normal), distance: near.value.abs() };
        (pair, near.value, normal)
    })
}

/// Whether a piece of the first surface, which may be a part of that of its body, has a corner, a
/// middle of an edge or of itself inside the second body.
pub(super) fn reaches_into(query: &Query<'_>, ws: &mut SearchWorkspace) -> bool {
    mark_overlaps(query, ws);
    let hint = Site { piece: 0, s: [0.0; 2] };
    let n_pieces = query.sides[0].model.n_pieces() as u32;
    (0..n_pieces).any(|piece| {
        ws.marks[0][piece as usize]
            && best_sample(query, ws, 0, piece, hint).is_some_and(|(depth, _)| depth < -query.resolution)
    })
}

/// A point of one surface and its signed distance from the other body.
#[derive(Debug, Clone, Copy)]
struct Depth {
    site: Site,
    point: Vector3<f64>,
    near: Nearest,
}

/// Goes on from a minimum at the border of its piece into the pieces beyond, as long as that leads
/// deeper.
fn walk(query: &Query<'_>, ws: &mut SearchWorkspace, b: usize, mut here: Depth) -> Depth {
    /// More pieces than lie between the rim and the middle of a zone of overlap.
    const MAX_STEPS: usize = 200;
    let side = query.sides[b];
    for _ in 0..MAX_STEPS {
        let upper = side.upper(here.site.piece);
        let at_border =
            (0..2).any(|d| upper[d] > 0.0 && (here.site.s[d] <= 0.0 || here.site.s[d] >= upper[d]));
        if !at_border {
            break;
        }
        let limit = 1e-9 * side.model.size();
        let mut found = std::mem::take(&mut ws.chosen);
        pieces_at(&side, &mut ws.deformed[b], &mut ws.stack, &here.point, limit, &mut found);
        let mut next = here;
        for &piece in found.iter().filter(|&&p| p != here.site.piece) {
            let start = site_on_piece(&side, &ws.deformed[b], piece, &here.point);
            if let Some(there) = descend(query, ws, b, start, here.near.site)
                && there.near.value < next.near.value - query.resolution
            {
                next = there;
            }
        }
        ws.chosen = found;
        if next.site == here.site {
            break;
        }
        here = next;
    }
    here
}

/// Local minimum of the signed distance from the other body over a piece of body `b`.
fn descend(query: &Query<'_>, ws: &mut SearchWorkspace, b: usize, start: Site, hint: Site) -> Option<Depth> {
    let (own, other) = (&query.sides[b], &query.sides[1 - b]);
    ws.deformed[b].load(own, start.piece);
    let SearchWorkspace { deformed: [first, second], stack, .. } = ws;
    let (mine, theirs) = if b == 0 { (first, second) } else { (second, first) };
    let mut hint = hint;
    let objective = |s: &[f64; 2]| {
        let jet = mine.jet(own, start.piece, *s);
        match nearest(other, theirs, stack, &jet.point, Some(hint)) {
            Some(near) => {
                hint = near.site;
                let bend = curvature(other, theirs, &near);
                along_piece(&jet, &near, &bend, own.model.size() + other.model.size())
            }
            None => Sample { value: f64::NAN, noise: f64::NAN, ..Sample::default() },
        }
    };
    let (s, _) = minimize(objective, &start.s, &[0.0; 2], &own.upper(start.piece));
    let point = mine.jet(own, start.piece, s).point;
    let near = nearest(other, theirs, stack, &point, Some(hint))?;
    Some(Depth { site: Site { piece: start.piece, s }, point, near })
}

/// The deepest of a few samples of a piece, with its signed distance.
fn best_sample(
    query: &Query<'_>,
    ws: &mut SearchWorkspace,
    b: usize,
    piece: u32,
    hint: Site,
) -> Option<(f64, Site)> {
    let (own, other) = (&query.sides[b], &query.sides[1 - b]);
    ws.deformed[b].load(own, piece);
    let upper = own.upper(piece);
    let counts = upper.map(|u| if u > 0.0 { 3 } else { 1 });
    let (mut best, mut hint) = (None, hint);
    for k in 0..counts[0] * counts[1] {
        let s = [0.5 * (k % counts[0]) as f64, 0.5 * (k / counts[0]) as f64];
        let point = ws.deformed[b].jet(own, piece, s).point;
        let near = nearest(other, &mut ws.deformed[1 - b], &mut ws.stack, &point, Some(hint))?;
        hint = near.site;
        if best.is_none_or(|(value, _)| near.value < value) {
            best = Some((near.value, Site { piece, s }));
        }
    }
    best
}

/// Marks the pieces of both bodies whose hulls may meet a piece of the other.
fn mark_overlaps(query: &Query<'_>, ws: &mut SearchWorkspace) {
    for (marks, side) in ws.marks.iter_mut().zip(&query.sides) {
        marks.clear();
        marks.resize(side.model.n_pieces(), false);
    }
    let inflation = query.sides[0].inflation + query.sides[1].inflation;
    let nodes = query.sides.map(|s| s.model.nodes());
    let mut pairs = std::mem::take(&mut ws.pairs);
    pairs.clear();
    pairs.push((0.0, 0, 0));
    while let Some((_, a, b)) = pairs.pop() {
        let (u, v) = (&nodes[0][a as usize], &nodes[1][b as usize]);
        if query.placement.distance(&u.bounds, &v.bounds) > inflation + query.resolution {
            continue;
        }
        match (u.kind, v.kind) {
            (NodeKind::Piece(i), NodeKind::Piece(j)) => {
                let (done_a, done_b) = (ws.marks[0][i as usize], ws.marks[1][j as usize]);
                if !(done_a && done_b) && may_meet(query, ws, [i, j]) {
                    (ws.marks[0][i as usize], ws.marks[1][j as usize]) = (true, true);
                }
            }
            (NodeKind::Children(c), NodeKind::Piece(_)) => pairs.extend(c.map(|c| (0.0, c, b))),
            (NodeKind::Piece(_), NodeKind::Children(c)) => pairs.extend(c.map(|c| (0.0, a, c))),
            (NodeKind::Children(c), NodeKind::Children(d)) => {
                if u.bounds.half.norm_squared() >= v.bounds.half.norm_squared() {
                    pairs.extend(c.map(|c| (0.0, c, b)));
                } else {
                    pairs.extend(d.map(|d| (0.0, a, d)));
                }
            }
        }
    }
    ws.pairs = pairs;
}

/// Whether the control points of two pieces can be told apart by neither their boxes nor the line
/// between their middles.
fn may_meet(query: &Query<'_>, ws: &mut SearchWorkspace, pieces: [u32; 2]) -> bool {
    ws.load(query, pieces);
    let bounds = [0, 1].map(|b| ws.deformed[b].bounds(pieces[b]));
    if bounds[0].distance(bounds[1]) > query.resolution {
        return false;
    }
    let points = [0, 1].map(|b| ws.deformed[b].points(&query.sides[b].model.pieces()[pieces[b] as usize]));
    let line = bounds[0].centre - bounds[1].centre;
    let length = line.norm();
    !(length > 0.0 && separation(points, &(line / length)) > query.resolution)
}
