//! Gap of a body and a plane: the lowest point of the deformed surface (theory Eq. C.32).

use ffr_dynamics::body::RigidMotion;
use ffr_dynamics::force::BodyState;
use iga_core::nurbs::locate::box_newton::{Sample, minimize};
use nalgebra::Vector3;

use super::boxes::NodeKind;
use super::deformed::{Side, Site, smallest};
use super::minimum_distance::check_state;
use super::query::SearchWorkspace;
use super::surface_model::{SurfaceModel, SurfaceSite};
use crate::error::MotionFault;
use crate::{ContactError, Plane};

/// How near a body is to a plane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlaneProximity {
    /// Height of the lowest point over the plane, negative below it \[m\].
    pub gap: f64,
    /// The lowest point.
    pub site: SurfaceSite,
    /// The same as a place on the pieces of the surface.
    pub place: Site,
}

/// The gap of a body and a plane in the motion `state`.
///
/// # Errors
/// [`ContactError::Motion`] for a state that is not finite; [`ContactError::Normal`] if an axisymmetric or plane model meets a
/// plane that leaves its symmetry.
pub fn plane_distance(
    model: &SurfaceModel,
    state: &BodyState,
    plane: &Plane,
    workspace: &mut SearchWorkspace,
) -> Result<PlaneProximity, ContactError> {
    check_state(model, state)?;
    let n = state.rotation.inverse() * plane.normal.into_inner();
    check_normal(model.motion(), &n)?;
    let inflation = model.displacement_bound(&state.elastic);
    let side = Side { model, elastic: &state.elastic, placement: None, inflation };
    workspace.deformed[0].begin(model);
    let Some((site, height)) = lowest(&side, &n, workspace) else {
        return Err(MotionFault::Overflow.into());
    };
    let piece = &model.pieces()[site.piece as usize];
    let point = workspace.deformed[0].jet(&side, site.piece, site.s).point;
    let offset = plane.normal.dot(&(state.position - plane.point));
    let found = piece.origin.site(site.s, state.position + state.rotation * point);
    Ok(PlaneProximity { gap: height + offset, site: found, place: site })
}

/// Round-off of a unit normal's components.
const NORMAL_TOLERANCE: f64 = 1e-12;

fn check_normal(motion: RigidMotion, n: &Vector3<f64>) -> Result<(), ContactError> {
    let (leaves, requirement) = match motion {
        RigidMotion::Axial => (n.x.hypot(n.y), "an axisymmetric body needs a plane across its axis"),
        RigidMotion::Planar => (n.z.abs(), "a plane body needs a plane whose normal lies in its own plane"),
        RigidMotion::Spatial => return Ok(()),
    };
    if leaves <= NORMAL_TOLERANCE {
        return Ok(());
    }
    Err(ContactError::Normal { normal: [n.x, n.y, n.z], requirement })
}

/// Site with the smallest `n · x` in the body's frame.
fn lowest(side: &Side<'_>, n: &Vector3<f64>, ws: &mut SearchWorkspace) -> Option<(Site, f64)> {
    let nodes = side.model.nodes();
    let mut best: Option<(Site, f64)> = None;
    ws.stack.clear();
    ws.stack.push((f64::NEG_INFINITY, 0));
    while let Some((bound, node)) = ws.stack.pop() {
        let limit = best.map_or(f64::INFINITY, |b| b.1);
        if bound >= limit {
            continue;
        }
        match nodes[node as usize].kind {
            NodeKind::Children(children) => {
                let [a, b] = children.map(|c| (nodes[c as usize].bounds.lowest(n) - side.inflation, c));
                ws.stack.extend(if a.0 <= b.0 { [b, a] } else { [a, b] });
            }
            NodeKind::Piece(piece) => {
                let deformed = &mut ws.deformed[0];
                deformed.load(side, piece);
                let points = deformed.points(&side.model.pieces()[piece as usize]);
                let start = smallest(points.iter().map(|p| n.dot(p)));
                if n.dot(&points[start]) >= limit {
                    continue;
                }
                let objective = |s: &[f64; 2]| {
                    let jet = deformed.jet(side, piece, *s);
                    let (first, second) = (jet.first.map(Into::into), jet.second.map(Into::into));
                    Sample::height(&jet.point.into(), &first, |i, j| second[i + j], n.as_ref())
                };
                let (s, height) =
                    minimize(objective, &side.parameters(piece, start), &[0.0; 2], &side.upper(piece));
                if height < limit {
                    best = Some((Site { piece, s }, height));
                }
            }
        }
    }
    best
}
