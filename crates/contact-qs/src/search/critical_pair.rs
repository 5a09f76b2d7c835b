//! The touch of two overlapping bodies, followed from where it was: the places with a common normal
//! (docs/theory.md Eq. C.81).
//!
//! The search for the deepest place looks at every piece that may be inside the other body. While
//! two bodies stay in contact the places move little, and Newton's method finds them in a few
//! steps.

use ffr_dynamics::body::RigidMotion;
use ffr_dynamics::force::BodyState;
use nalgebra::{Matrix4, Vector3, Vector4};

use super::bezier::PieceJet;
use super::deformed::Site;
use super::minimum_distance::{Proximity, check_state, proximity};
use super::query::{Pair, Query, SearchWorkspace, in_first_frame};
use super::signed_distance::{pieces_at, site_on_piece};
use super::surface_model::SurfaceModel;
use crate::ContactError;

/// Newton's steps; from near enough four do.
const MAX_STEPS: usize = 12;
/// Change of parameters that is round-off.
const ROUND_OFF: f64 = 1e-14;
/// Distance beside the common normal, as a share of the size of the first body, up to which two places lie on it: round-off of places is
/// far below. At the end of a flat face the normals are one, and the place held back there is none of the touch.
const BESIDE: f64 = 1e-9;

/// Gap and places of the overlap that `workspace` was at last, in the motions `states`; `None`
/// where the method finds none, or the bodies are apart by now: [`super::minimum_distance`] knows.
///
/// # Errors
/// [`ContactError::Motion`] if a state is not finite or has another number of modes.
pub fn followed_overlap(
    models: [&SurfaceModel; 2],
    states: [&BodyState; 2],
    workspace: &mut SearchWorkspace,
) -> Result<Option<Proximity>, ContactError> {
    for (model, state) in models.iter().zip(&states) {
        check_state(model, state)?;
    }
    let Some(mut sites) = workspace.last.filter(|_| models[0].motion() != RigidMotion::Axial) else {
        return Ok(None);
    };
    let is_known = sites.iter().zip(models).all(|(site, model)| (site.piece as usize) < model.n_pieces());
    if !is_known {
        return Ok(None);
    }
    let placement = in_first_frame(models[0].motion(), states).map_err(ContactError::Motion)?;
    let query = Query::new(models, &states, &placement);
    workspace.begin(models);
    workspace.load(&query, sites.map(|site| site.piece));
    for _ in 0..MAX_STEPS {
        let Some(step) = step(&query, workspace, &sites) else { return Ok(None) };
        for (b, step) in [[step[0], step[1]], [step[2], step[3]]].into_iter().enumerate() {
            if step.iter().any(|s| s.abs() > 1.0) {
                return Ok(None);
            }
            sites[b] = moved(&query, workspace, b, (&sites[b], step));
        }
        if step.amax() <= ROUND_OFF {
            break;
        }
    }
    workspace.load(&query, sites.map(|site| site.piece));
    let Some((pair, gap, normal)) = pair(&query, workspace, sites) else { return Ok(None) };
    workspace.last = Some(sites);
    Ok(Some(proximity(&query, states[0], &pair, gap, normal)))
}

/// The place of body `b` a step of the parameters further, on the piece that it leads to.
fn moved(query: &Query<'_>, ws: &mut SearchWorkspace, b: usize, (site, step): (&Site, [f64; 2])) -> Site {
    let side = &query.sides[b];
    let wanted = [site.s[0] + step[0], site.s[1] + step[1]];
    let inside = Site { s: wanted.map(|s| s.clamp(0.0, 1.0)), ..*site };
    let beyond = [wanted[0] - inside.s[0], wanted[1] - inside.s[1]];
    if beyond.iter().all(|b| b.abs() < f64::MIN_POSITIVE) {
        return inside;
    }
    let jet = ws.deformed[b].jet(side, inside.piece, inside.s);
    let goal = jet.point + jet.first[0] * beyond[0] + jet.first[1] * beyond[1];
    let mut found = std::mem::take(&mut ws.chosen);
    let limit = 1e-9 * side.model.size();
    pieces_at(side, &mut ws.deformed[b], &mut ws.stack, &jet.point, limit, &mut found);
    let mut best = (inside, (goal - jet.point).norm());
    for &piece in found.iter().filter(|&&piece| piece != inside.piece) {
        let there = site_on_piece(side, &ws.deformed[b], piece, &goal);
        let distance = (ws.deformed[b].jet(side, piece, there.s).point - goal).norm();
        if distance < best.1 {
            best = (there, distance);
        }
    }
    ws.chosen = found;
    best.0
}

/// Jets of both pieces.
fn jets(query: &Query<'_>, ws: &SearchWorkspace, sites: &[Site; 2]) -> [PieceJet; 2] {
    [0, 1].map(|b| ws.deformed[b].jet(&query.sides[b], sites[b].piece, sites[b].s))
}

/// Newton's step for `n_T · a_i = 0`, `r · b_j = 0`, `a`, `b` the tangents and `r` the way from the
/// target; `None` where it has none. The second tangents of plane bodies are across their plane, along which no place moves.
fn step(query: &Query<'_>, ws: &SearchWorkspace, sites: &[Site; 2]) -> Option<Vector4<f64>> {
    let [own, target] = jets(query, ws, sites);
    let across = query.sides[0].model.across();
    let [a, b] = [&own, &target].map(|jet| [jet.first[0], across.unwrap_or(jet.first[1])]);
    let r = own.point - target.point;
    let product = b[0].cross(&b[1]);
    let size = product.norm();
    let n = product / size;
    // Rates of the normal: of the product, without what is along it.
    let rate = |l: usize| {
        let change = target.second[l].cross(&b[1]) + b[0].cross(&target.second[l + 1]);
        (change - n * n.dot(&change)) / size
    };
    let rates = [rate(0), rate(1)];
    let (mut matrix, mut residual) = (Matrix4::zeros(), Vector4::zeros());
    for i in 0..2 {
        residual[i] = n.dot(&a[i]);
        residual[2 + i] = r.dot(&b[i]);
        for k in 0..2 {
            matrix[(i, k)] = n.dot(&own.second[i + k]);
            matrix[(i, 2 + k)] = rates[k].dot(&a[i]);
            matrix[(2 + i, k)] = a[k].dot(&b[i]);
            matrix[(2 + i, 2 + k)] = r.dot(&target.second[i + k]) - b[k].dot(&b[i]);
        }
    }
    if across.is_some() {
        matrix[(1, 1)] = 1.0;
    }
    let step = matrix.lu().solve(&-residual)?;
    step.iter().all(|x| x.is_finite()).then_some(step)
}

/// The pair at `sites`, its gap and normal towards the first body, if the bodies overlap there
/// along a common normal.
fn pair(query: &Query<'_>, ws: &SearchWorkspace, sites: [Site; 2]) -> Option<(Pair, f64, Vector3<f64>)> {
    /// Cosine of the angle between the normals: converged ones differ by the root of round-off at
    /// most.
    const OPPOSITE: f64 = -1.0 + 1e-12;
    let jets = jets(query, ws, &sites);
    let [own, facing] = [0, 1].map(|b| ws.deformed[b].normal(&query.sides[b], &sites[b], &jets[b]));
    let points = jets.each_ref().map(|jet| jet.point);
    let way = points[0] - points[1];
    let gap = facing.dot(&way);
    let beside = (way - facing * gap).norm();
    if own.dot(&facing) > OPPOSITE || gap >= 0.0 || beside > BESIDE * query.sides[0].model.size() {
        return None;
    }
    Some((Pair { sites, points, direction: Some(facing), distance: -gap }, gap, facing))
}
