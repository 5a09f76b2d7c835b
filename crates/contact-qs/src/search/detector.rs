//! The surfaces of a body and of what it meets: their gap, and how fast it closes. That of a body
//! and a plane is at the lowest point of the deformed surface (theory Eq. C.32).

use std::sync::Arc;

use ffr_dynamics::body::RigidMotion;
use ffr_dynamics::force::BodyState;
use iga_core::nurbs::locate::box_newton::{Sample, minimize};
use nalgebra::Vector3;

use super::advancement::{closing_speed_bound, surface_speed_bound};
use super::boxes::NodeKind;
use super::critical_pair::followed_overlap;
use super::deformed::{Side, Site, smallest};
use super::minimum_distance::{Proximity, check_state, minimum_distance};
use super::query::{SearchWorkspace, in_first_frame};
use super::surface_model::{SurfaceModel, SurfaceSite};
use crate::{ContactError, Plane, Target};

/// The surface of a body.
#[derive(Debug, Clone)]
pub struct BodySurface {
    /// Index of the body.
    pub body: usize,
    /// Its surface.
    pub model: Arc<SurfaceModel>,
}

/// Surfaces that may meet.
#[derive(Debug, Clone)]
pub struct Detector {
    /// That of the contact body.
    pub own: BodySurface,
    /// The one that it meets.
    pub target: Target<BodySurface>,
}

impl Detector {
    /// The surface of body `body` and the one of `target`, where bodies have those that `surface`
    /// says.
    ///
    /// # Errors
    /// Those of `surface`.
    pub fn of<E>(
        body: usize,
        target: Target,
        surface: impl Fn(usize) -> Result<Arc<SurfaceModel>, E>,
    ) -> Result<Self, E> {
        let of = |body: usize| surface(body).map(|model| BodySurface { body, model });
        Ok(Self { own: of(body)?, target: target.try_map(of)? })
    }

    /// Puts `model` in the place of the surface of body `body`, if that is one of the pair; returns
    /// the one before. What a search remembers belongs to the surface before.
    pub fn replace_surface(&mut self, body: usize, model: &Arc<SurfaceModel>) -> Option<Arc<SurfaceModel>> {
        let other = match &mut self.target {
            Target::Body(other) => Some(other),
            Target::Plane(_) => None,
        };
        let surfaces = [Some(&mut self.own), other].into_iter().flatten().filter(|of| of.body == body);
        surfaces.map(|of| std::mem::replace(&mut of.model, Arc::clone(model))).last()
    }

    /// Gap and nearest points in the motions `bodies`. A plane has no faces: the point on it has
    /// the face and the parameters of the other one.
    ///
    /// # Errors
    /// [`ContactError`] for motions that are not finite, or a plane that leaves the model's symmetry.
    pub fn nearest(
        &self,
        bodies: &[BodyState],
        workspace: &mut SearchWorkspace,
    ) -> Result<Proximity, ContactError> {
        let BodySurface { body, model } = &self.own;
        match self.pair(bodies) {
            Target::Plane(plane) => {
                let PlaneProximity { gap, site, place } =
                    plane_distance(model, &bodies[*body], &plane, workspace)?;
                let normal = plane.normal.into_inner();
                let foot = SurfaceSite { point: site.point - normal * gap, ..site };
                Ok(Proximity { gap, sites: [site, foot], places: [place; 2], normal })
            }
            Target::Body((models, states)) => minimum_distance(models, states, workspace),
        }
    }

    /// The same for bodies that lie in each other, from the overlap that `workspace` was at last.
    ///
    /// # Errors
    /// As [`Detector::nearest`].
    pub fn followed(
        &self,
        bodies: &[BodyState],
        workspace: &mut SearchWorkspace,
    ) -> Result<Proximity, ContactError> {
        if let Some((models, states)) = self.pair(bodies).body()
            && let Some(followed) = followed_overlap(models, states, workspace)?
        {
            return Ok(followed);
        }
        self.nearest(bodies, workspace)
    }

    /// A gap that the surfaces have at least in the motions `bodies`, without a search: that of the balls about the origins
    /// of their frames that hold them, or of the boxes around them (theory Eq. C.28). It says nothing where it is not
    /// above zero, and is minus infinity for motions that are not finite, or of bodies that share no axis or no plane \[m\].
    pub fn least_gap(&self, bodies: &[BodyState]) -> f64 {
        let inflation = |model: &SurfaceModel, state: &BodyState| {
            check_state(model, state).ok().map(|()| model.displacement_bound(&state.elastic))
        };
        let least = || match self.pair(bodies) {
            Target::Plane(plane) => {
                let (model, state) = (&*self.own.model, &bodies[self.own.body]);
                let n = state.rotation.inverse() * plane.normal.into_inner();
                let height = plane.normal.dot(&(state.position - plane.point));
                let lowest = model.nodes()[0].bounds.lowest(&n).max(-model.radius());
                Some(height + lowest - inflation(model, state)?)
            }
            Target::Body((models, states)) => {
                let placement = in_first_frame(models[0].motion(), states).ok()?;
                let [first, second] = models.map(|model| &model.nodes()[0].bounds);
                let balls = placement.origin.norm() - models[0].radius() - models[1].radius();
                let apart = placement.distance(first, second).max(balls);
                Some(apart - inflation(models[0], states[0])? - inflation(models[1], states[1])?)
            }
        };
        least().unwrap_or(f64::NEG_INFINITY)
    }

    /// Largest speed at which the surfaces may approach each other [m/s].
    pub fn closing_speed_bound(&self, bodies: &[BodyState]) -> f64 {
        if let Some((models, states)) = self.pair(bodies).body() {
            return closing_speed_bound(models, states);
        }
        let state = &bodies[self.own.body];
        state.velocity.norm() + surface_speed_bound(&self.own.model, state)
    }

    /// Both surfaces with their motions, if the target is a body.
    fn pair<'a>(&'a self, bodies: &'a [BodyState]) -> Target<([&'a SurfaceModel; 2], [&'a BodyState; 2])> {
        let own = &self.own;
        let both =
            |other: &'a BodySurface| ([&*own.model, &*other.model], [&bodies[own.body], &bodies[other.body]]);
        self.target.as_ref().map(both)
    }

    /// Sizes of the bodies, of the contact body first; a plane has none \[m\].
    pub fn sizes(&self) -> impl Iterator<Item = f64> {
        [Some(&self.own), self.target.as_ref().body()].into_iter().flatten().map(|of| of.model.size())
    }

    /// Size of the larger body \[m\].
    pub fn size(&self) -> f64 {
        self.sizes().fold(0.0, f64::max)
    }

    /// Size of the smaller body \[m\].
    pub fn least_size(&self) -> f64 {
        self.sizes().fold(f64::INFINITY, f64::min)
    }
}

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
        return Err(ContactError::Motion("positions: they overflow".into()));
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
