//! Signed distance of a point from the surface of a body (theory Eqs. C.29, C.31): positive
//! outside.

use iga_core::nurbs::locate::box_newton::{Sample, minimize};
use nalgebra::{Matrix3, Vector3};

use super::bezier::PieceJet;
use super::boxes::NodeKind;
use super::deformed::{Deformed, Side, Site, smallest};
use super::surface_model::SurfaceModel;

/// Distance, in round-off of the size of a body, from which on a line between two points has a
/// direction: to a hundredth.
const DIRECTED: f64 = 256.0;

/// Distance, as a share of the size of a body, within which pieces meet: round-off of a search is far below.
const SAME_EDGE: f64 = 1e-9;

/// The surface point nearest to a point.
#[derive(Debug, Clone, Copy)]
pub(super) struct Nearest {
    pub site: Site,
    /// Its position in the frame of the search.
    pub point: Vector3<f64>,
    /// Outward unit vector along the line between both: gradient of the signed distance.
    pub direction: Vector3<f64>,
    /// Signed distance \[m\].
    pub value: f64,
    /// Outward normal of the surface there.
    pub normal: Vector3<f64>,
}

/// Cosine above which the line to the nearest point is normal to the surface there and decides the
/// side alone.
pub(super) const ALONG_NORMAL: f64 = 0.7;

/// Nearest surface point to `x` and on which side `x` is. `hint`: a site to begin with. `stack` is
/// a buffer.
pub(super) fn nearest(
    side: &Side<'_>,
    deformed: &mut Deformed,
    stack: &mut Vec<(f64, u32)>,
    x: &Vector3<f64>,
    hint: Option<Site>,
) -> Option<Nearest> {
    let in_body = side.in_body(x);
    let nodes = side.model.nodes();
    // What counts as equally near: the surface there is an edge or a seam.
    let tie = |distance: f64| 1e-9 * distance + 64.0 * f64::EPSILON * side.model.size();
    let mut best: Option<(f64, Candidate)> = None;
    let offer = |best: &mut Option<(f64, Candidate)>, found: Candidate| match best {
        Some((least, kept)) if found.distance >= *least - tie(*least) => {
            // Of equally near pieces the one most nearly square to the line tells the side.
            if found.distance <= *least + tie(*least) && found.steepness() > kept.steepness() {
                *kept = found;
            }
            *least = least.min(found.distance);
        }
        _ => *best = Some((found.distance, found)),
    };
    if let Some(site) = hint {
        deformed.load(side, site.piece);
        offer(&mut best, closest_on_piece(side, deformed, site, x));
    }
    stack.clear();
    stack.push((0.0, 0));
    while let Some((bound, node)) = stack.pop() {
        let limit = best.as_ref().map_or(f64::INFINITY, |b| b.0 + tie(b.0));
        if bound > limit {
            continue;
        }
        match nodes[node as usize].kind {
            NodeKind::Children(children) => {
                let bound = |c: u32| nodes[c as usize].bounds.distance_to(&in_body) - side.inflation;
                let [a, b] = children.map(|c| (bound(c), c));
                let (near, far) = if a.0 <= b.0 { (a, b) } else { (b, a) };
                stack.push(far);
                stack.push(near);
            }
            NodeKind::Piece(piece) => {
                deformed.load(side, piece);
                if hint.is_some_and(|h| h.piece == piece) || deformed.bounds(piece).distance_to(x) > limit {
                    continue;
                }
                let points = deformed.points(&side.model.pieces()[piece as usize]);
                let start = smallest(points.iter().map(|p| (p - x).norm_squared()));
                let site = Site { piece, s: side.parameters(piece, start) };
                offer(&mut best, closest_on_piece(side, deformed, site, x));
            }
        }
    }
    best.map(|(_, found)| found.finish(DIRECTED * f64::EPSILON * side.model.size()))
}

/// Pieces whose boxes come within `limit` of `x`.
pub(super) fn pieces_at(
    side: &Side<'_>,
    deformed: &mut Deformed,
    stack: &mut Vec<(f64, u32)>,
    x: &Vector3<f64>,
    limit: f64,
    out: &mut Vec<u32>,
) {
    let in_body = side.in_body(x);
    let nodes = side.model.nodes();
    out.clear();
    stack.clear();
    stack.push((0.0, 0));
    while let Some((_, node)) = stack.pop() {
        let node = &nodes[node as usize];
        if node.bounds.distance_to(&in_body) > side.inflation + limit {
            continue;
        }
        match node.kind {
            NodeKind::Children(children) => stack.extend(children.map(|c| (0.0, c))),
            NodeKind::Piece(piece) => {
                deformed.load(side, piece);
                if deformed.bounds(piece).distance_to(x) <= limit {
                    out.push(piece);
                }
            }
        }
    }
}

impl SurfaceModel {
    /// The place of another piece that meets the undeformed surface's `place` at an edge or a seam, whose outward normal in the
    /// body's frame has a cosine above `least` with `direction`; none if there is none.
    pub fn turned_to(&self, place: &Site, direction: &Vector3<f64>, least: f64) -> Option<Site> {
        let at_rest = vec![0.0; self.n_modes()];
        let side = Side { model: self, elastic: &at_rest, placement: None, inflation: 0.0 };
        let (mut deformed, mut stack, mut pieces) = (Deformed::default(), Vec::new(), Vec::new());
        deformed.begin(self);
        deformed.load(&side, place.piece);
        let x = deformed.jet(&side, place.piece, place.s).point;
        let limit = SAME_EDGE * self.size();
        pieces_at(&side, &mut deformed, &mut stack, &x, limit, &mut pieces);
        pieces.into_iter().filter(|piece| *piece != place.piece).find_map(|piece| {
            let there = site_on_piece(&side, &deformed, piece, &x);
            let jet = deformed.jet(&side, piece, there.s);
            let is_there = (jet.point - x).norm() <= limit;
            (is_there && deformed.normal(&side, &there, &jet).dot(direction) > least).then_some(there)
        })
    }
}

/// The site of a loaded piece nearest to `x`.
pub(super) fn site_on_piece(side: &Side<'_>, deformed: &Deformed, piece: u32, x: &Vector3<f64>) -> Site {
    let of = &side.model.pieces()[piece as usize];
    let start = smallest(deformed.points(of).iter().map(|p| (p - x).norm_squared()));
    closest_on_piece(side, deformed, Site { piece, s: side.parameters(piece, start) }, x).site
}

/// A local closest point.
#[derive(Debug, Clone, Copy)]
struct Candidate {
    site: Site,
    point: Vector3<f64>,
    normal: Vector3<f64>,
    offset: Vector3<f64>,
    distance: f64,
}

impl Candidate {
    /// How nearly the line to the point is normal to the surface.
    fn steepness(&self) -> f64 {
        self.offset.dot(&self.normal).abs()
    }

    /// The nearest point; nearer than `shortest` the line to it tells nothing, but the surface's
    /// normal does where it has one.
    fn finish(self, shortest: f64) -> Nearest {
        let sign = if self.offset.dot(&self.normal) < 0.0 { -1.0 } else { 1.0 };
        let has_normal = self.normal.norm() > 0.5;
        let direction = if self.distance > shortest || !has_normal && self.distance > 0.0 {
            self.offset * (sign / self.distance)
        } else {
            self.normal
        };
        let Self { site, point, normal, distance, .. } = self;
        Nearest { site, point, direction, value: sign * distance, normal }
    }
}

fn closest_on_piece(side: &Side<'_>, deformed: &Deformed, start: Site, x: &Vector3<f64>) -> Candidate {
    let objective = |s: &[f64; 2]| {
        let jet = deformed.jet(side, start.piece, *s);
        let (first, second) = (jet.first.map(Into::into), jet.second.map(Into::into));
        Sample::half_square(&jet.point.into(), &first, |a, b| second[a + b], &(*x).into())
    };
    let (s, _) = minimize(objective, &start.s, &[0.0; 2], &side.upper(start.piece));
    let site = Site { piece: start.piece, s };
    let jet = deformed.jet(side, site.piece, s);
    let offset = x - jet.point;
    let normal = deformed.normal(side, &site, &jet);
    Candidate { site, point: jet.point, normal, offset, distance: offset.norm() }
}

/// Second derivatives of the signed distance with respect to the point (theory Eq. C.31).
pub(super) fn curvature(side: &Side<'_>, deformed: &Deformed, near: &Nearest) -> Matrix3<f64> {
    let jet = deformed.jet(side, near.site.piece, near.site.s);
    let n = near.direction;
    if n.dot(&near.normal) < 1.0 - 1e-6 || near.normal.norm() < 0.5 {
        // An edge or a corner is nearest: spheres around it.
        let scale = near.value.abs().max(f64::MIN_POSITIVE);
        return (Matrix3::identity() - n * n.transpose()) / scale;
    }
    let is_curve = side.model.across().is_some();
    let r = n * near.value;
    let b = &jet.first;
    let metric = symmetric(is_curve, |i, j| b[i].dot(&b[j]));
    let bending = symmetric(is_curve, |i, j| n.dot(&jet.second[i + j]));
    let map = symmetric(is_curve, |i, j| b[i].dot(&b[j]) - r.dot(&jet.second[i + j]));
    let (Some(metric), Some(map)) = (inverse(&metric, is_curve), inverse(&map, is_curve)) else {
        return Matrix3::zeros();
    };
    let mut sum = Matrix3::zeros();
    let count = if is_curve { 1 } else { 2 };
    for m in 0..count {
        for i in 0..count {
            let mut factor = 0.0;
            for l in 0..count {
                for k in 0..count {
                    factor += metric[m][l] * bending[l][k] * map[k][i];
                }
            }
            sum -= b[m] * b[i].transpose() * factor;
        }
    }
    sum
}

type Small = [[f64; 2]; 2];

fn symmetric(is_curve: bool, entry: impl Fn(usize, usize) -> f64) -> Small {
    if is_curve { [[entry(0, 0), 0.0], [0.0, 1.0]] } else { [0, 1].map(|i| [0, 1].map(|j| entry(i, j))) }
}

fn inverse(m: &Small, is_curve: bool) -> Option<Small> {
    let determinant = m[0][0] * m[1][1] - m[0][1] * m[1][0];
    let scale = if is_curve { m[0][0].abs() } else { m[0][0].abs() * m[1][1].abs() };
    (determinant.abs() > 1e-12 * scale && scale > 0.0).then(|| {
        [[m[1][1] / determinant, -m[0][1] / determinant], [-m[1][0] / determinant, m[0][0] / determinant]]
    })
}

/// The signed distance from a body as a function of the parameters of another body's piece.
pub(super) fn along_piece(jet: &PieceJet, near: &Nearest, curvature: &Matrix3<f64>, scale: f64) -> Sample<2> {
    let mut sample: Sample<2> =
        Sample { value: near.value, noise: 16.0 * f64::EPSILON * scale, ..Sample::default() };
    for a in 0..2 {
        sample.gradient[a] = near.direction.dot(&jet.first[a]);
        for b in 0..2 {
            sample.hessian[a][b] =
                near.direction.dot(&jet.second[a + b]) + jet.first[a].dot(&(curvature * jet.first[b]));
        }
    }
    sample
}
