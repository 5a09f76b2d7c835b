//! The part of a body's surface that may touch a plane or another body: its points, and the
//! unknowns of the contact interface.
//!
//! Every zone is built here, on the mesh that a body has from the start
//! ([`crate::body::zone::at_start`]) or on one that is refined at a touch
//! ([`crate::body::fine::refined`]); that of a finite element mesh lies on its own sides.

use std::sync::Arc;

use contact_qs::surface_pair::TargetFace;
use contact_qs::zone::points::{PressureMean, SurfacePoint};
use contact_qs::{ContactError, PiecewiseSurface};
use iga_core::elasticity::Model;
use iga_core::nurbs::Face;
use iga_core::nurbs::jet::{diagonal, difference, norm};
use iga_core::nurbs::{FaceId, SAME_PLACE};
use iga_core::surface::{
    BodySurface, CollocationPoint, FacePoint, gauss_points, greville_points, lobatto_points,
};
use nalgebra::Vector3;

use crate::body::splines::Discretised;
use crate::record::{TargetPlace, TouchedPart, ZoneSite};
use crate::spec::PointRule;
use crate::surface::{Surface, SurfacePlace};
use crate::touch::tolerances::TOUCHED_SURFACE;

mod met_edge;
mod on_sides;
mod whole_mesh;
pub mod of_rigid;
pub mod at_start;
pub mod contact;
pub mod on_mesh;

pub use met_edge::MetEdge;
pub use on_sides::longest_across;

/// A contact zone on faces of a body.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactZone {
    /// Contact points with their functions.
    pub points: Vec<SurfacePoint>,
    /// Parameters of the points; on a mesh those of their sides.
    pub parameters: Vec<[f64; 3]>,
    /// Faces of the points; none on a mesh.
    pub faces: Vec<FaceId>,
    /// Unknowns of the interface, in ascending order.
    pub unknowns: Vec<usize>,
    /// Full widths along the face \[m\]; the second is zero for curves, and for zones given by one
    /// width. Of a surface with edges the size of the body and, of a part of it, the body's least
    /// extent.
    pub widths: [f64; 2],
    /// The part of the surface that points of another body may touch.
    pub region: ZoneRegion,
    /// Which part of the surface of the body it covers.
    pub extent: ZoneExtent,
    /// Indices of the points that meet an edge or a corner of the target (theory Eq. C.63), with their
    /// places along the edge from its middle, as shares of its half; zero of a place alone.
    pub meeting: Vec<(usize, f64)>,
    /// Compliances of what elements leave out of the indentation at all points; empty if nothing (theory Eq. C.101) [m/N].
    pub left_out: Vec<f64>,
}

/// What of a whole surface is a contact zone.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct WholeRequest {
    /// A place at which additional contact points stand.
    pub about: Option<PointsAbout>,
    /// The part to which it is confined; splines have all.
    pub part: Option<TouchedPart>,
}

/// A place on a whole surface at which additional contact points stand.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PointsAbout {
    /// The place.
    pub place: SurfacePlace,
    /// The edge or corner of the target that the place meets, or the place of it that an own edge there meets. Without one, points stand
    /// ever more densely towards the place.
    pub meets: Option<TargetPlace>,
}

impl PointsAbout {
    /// That of the zone at `site` of `surface`; none of one without further points.
    pub fn of(surface: &dyn Surface, site: &ZoneSite) -> Option<Self> {
        let place = site.place().map(|(face, xi)| surface.place(face, &xi))?;
        Some(Self { place, meets: site.meets })
    }

    /// The edge of the target that lies along a face at the place, or the own one that lies on the target; none of a place alone.
    pub fn edge(&self) -> Option<MetEdge> {
        let meets = self.meets?;
        let (half, outward) = (Vector3::from(meets.along[0]), meets.own_outward().map(Vector3::from));
        let edge = MetEdge { middle: self.place.point.into(), half, spread: meets.spread, outward };
        (half.norm() > 0.0).then_some(edge)
    }
}

/// Number of halvings of the sides of elements towards a place where an edge touches (theory
/// Eq. C.65).
const HALVINGS: u8 = 5;

/// How much of the surface of a body its contact zone covers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ZoneExtent {
    /// A part of a face or of several; contact that reaches its end makes it too small.
    Part,
    /// All faces, touched inside of their smooth parts; contact must not reach an edge.
    Faces,
    /// All faces with the edges and corners between them, at which contact is possible as well
    /// (theory section C.9).
    Whole,
}

/// A part of a body's surface.
#[derive(Debug, Clone, PartialEq)]
pub enum ZoneRegion {
    /// Faces of a body of splines.
    Faces(Vec<TargetFace>),
    /// Sides of a mesh.
    Pieces(Arc<PiecewiseSurface>),
}

/// Where a contact zone ends on a face.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ZoneLimits {
    /// The part of the face.
    pub region: TargetFace,
    /// Tolerance by which parameters of points may lie outside of the zone: round-off.
    pub slack: [f64; 3],
    /// Full widths along the face \[m\].
    pub widths: [f64; 2],
}

impl ZoneLimits {
    /// Whether parameters of the face lie in the zone.
    pub fn contains(&self, xi: &[f64; 3]) -> bool {
        self.region.bounds.contains(xi, &self.slack, self.region.face.directions())
    }
}

/// Gauss points of a zone on the surface of a solid, 24 in a row, from which on as few as integrate a constant pressure exactly do:
/// forces lie so densely that they do not dent the sides of a mesh between its nodes. A ball on a rod of a mesh, 16 elements in
/// each direction, two points in place of three: peak 243.95 in place of 243.98 N; 8 elements: 243.39 in place of 244.14 N.
const ENOUGH_POINTS: usize = 576;

impl ContactZone {
    /// The zone of `body` within `limits`, parts of its faces: its points by `rule`, their areas
    /// times the thickness of plane models, and all unknowns of the functions that are not zero in
    /// the zone. `on_rim` says which points lie where contact must not reach.
    ///
    /// # Errors
    /// [`ContactError::Empty`] if no point lies in the zone.
    pub fn new(
        body: &Discretised<'_>,
        limits: &[ZoneLimits],
        rule: PointRule,
        on_rim: impl FnOnce(&[CollocationPoint]) -> Vec<bool>,
    ) -> Result<Self, ContactError> {
        let is_inside =
            |p: &CollocationPoint| limits.iter().any(|l| l.region.face.id == p.face && l.contains(&p.xi));
        let within = |points: Vec<CollocationPoint>| -> Vec<CollocationPoint> {
            points.into_iter().filter(is_inside).collect()
        };
        let mut faces: Vec<Face> = Vec::new();
        for face in limits.iter().map(|l| l.region.face) {
            if faces.iter().all(|known| known.id != face.id) {
                faces.push(face);
            }
        }
        let widths = limits.first().map_or([0.0; 2], |l| l.widths);
        let gauss_of = |count| within(gauss_points(body.space, body.patches, &faces, count));
        let mut gauss = gauss_of(None);
        let inside = match rule {
            PointRule::Greville => within(greville_points(body.space, body.patches, &faces)),
            PointRule::Gauss => {
                let few = gauss_of(Some(few_points(body, &gauss)));
                gauss = if few.len() >= ENOUGH_POINTS { few } else { gauss };
                gauss.clone()
            }
        };
        if inside.is_empty() {
            return Err(ContactError::Empty { width: widths[0] });
        }
        let thickness = body.model.thickness().unwrap_or(1.0);
        let rim = on_rim(&inside);
        let points: Vec<SurfacePoint> = inside
            .iter()
            .zip(rim)
            .map(|(p, on_rim)| SurfacePoint {
                position: p.point,
                area: p.area * thickness,
                functions: body.space.functions_at(p.element, &p.xi),
                on_rim,
                pressure: p.function.map_or(PressureMean::Area, PressureMean::Function),
                facing: None,
            })
            .collect();
        Ok(Self {
            unknowns: interface(body, &gauss, &points),
            points,
            parameters: inside.iter().map(|p| p.xi).collect(),
            faces: inside.iter().map(|p| p.face).collect(),
            widths,
            region: ZoneRegion::Faces(limits.iter().map(|l| l.region).collect()),
            extent: ZoneExtent::Part,
            meeting: Vec::new(),
            left_out: Vec::new(),
        })
    }
}

impl ContactZone {
    /// The zone of a body of a plane model `own` thick that touches one `other` thick, over the
    /// smaller thickness \[m\]; itself where one of them is not of a plane model.
    pub fn over_both(mut self, own: Option<f64>, other: Option<f64>) -> Self {
        if let (Some(own), Some(other)) = (own, other)
            && other < own
        {
            self.points.iter_mut().for_each(|point| point.area *= other / own);
        }
        self
    }

    /// The whole surface of `body` with its edges and corners (docs/theory.md section C.9): Lobatto
    /// points of all outer faces, each pressed only by surfaces that its face is turned to, and all
    /// unknowns of the functions that are not zero there. At the place `about`, if there is one,
    /// every face that meets there has a point: for a bent edge, which may touch between the points
    /// of its elements, with further points ever more densely about the place; to meet an edge or a
    /// corner of the target, without them. An edge of the target that lies along a face has points
    /// along it in place of those that stand there.
    ///
    /// # Errors
    /// [`ContactError::Nothing`] for a body without an outer face.
    pub fn whole(body: &Discretised<'_>, about: Option<&PointsAbout>) -> Result<Self, ContactError> {
        let faces = Face::outer(body.patches, *body.model == Model::Axisymmetric);
        let size = diagonal(body.space.control_points());
        let edge = about.and_then(PointsAbout::edge);
        let here = about.filter(|_| edge.is_none()).map(|about| about.place.point);
        let places: Vec<(FaceId, [f64; 3])> = here.map_or_else(Vec::new, |here| {
            let on = |face: &Face| {
                let found = BodySurface::of_faces(body.patches, vec![*face]).closest(body.patches, &here)?;
                (found.measure <= 4.0 * SAME_PLACE * size).then_some((face.id, found.xi))
            };
            faces.iter().filter_map(on).collect()
        });
        let is_met = about.is_some_and(|about| about.meets.is_some());
        let halvings = if is_met { 0 } else { HALVINGS };
        let mut found = lobatto_points(body.space, body.patches, &faces, (&places, halvings));
        let mut meeting: Vec<(usize, f64)> = Vec::new();
        if let Some(edge) = &edge {
            let surface = BodySurface::of_faces(body.patches, faces.clone());
            let on = |point: [f64; 3]| surface.closest(body.patches, &point);
            let element = |at: &FacePoint| body.space.find_element(faces[at.face].id.patch, &at.xi);
            let own = on(edge.middle.into()).map_or([0.0; 3], |at| at.normal);
            let stand = |point: [f64; 3], area: f64| {
                let at = on(point)?;
                Some(CollocationPoint {
                    face: faces[at.face].id,
                    element: element(&at),
                    xi: at.xi,
                    point: at.point,
                    normal: own,
                    area,
                    function: None,
                })
            };
            let of = |p: &CollocationPoint| (p.point, p.normal, p.area);
            meeting =
                edge.replace(&mut found, (&own, size), of, |point| on(point).map(|at| element(&at)), stand);
        }
        let is_here = |p: &CollocationPoint, here: &[f64; 3]| {
            norm(&difference(&p.point, here)) <= 4.0 * SAME_PLACE * size
        };
        if let Some(here) = here.filter(|_| is_met) {
            found.retain(|p| is_here(p, &here) || !stands_there(&p.point, &here, size));
        }
        if found.is_empty() {
            return Err(ContactError::Nothing { what: "the body has no outer face" });
        }
        let thickness = body.model.thickness().unwrap_or(1.0);
        let mut points: Vec<SurfacePoint> = found
            .iter()
            .map(|p| SurfacePoint {
                position: p.point,
                area: p.area * thickness,
                functions: body.space.functions_at(p.element, &p.xi),
                on_rim: false,
                pressure: PressureMean::Area,
                facing: Some(p.normal),
            })
            .collect();
        if let Some(here) = here.filter(|_| is_met) {
            meeting.extend((0..found.len()).filter(|i| is_here(&found[*i], &here)).map(|i| (i, 0.0)));
            // The spring of a point has no area of its own: together they have that of the stiffest of
            // all.
            let largest = points.iter().map(|p| p.area).fold(0.0, f64::max);
            meeting.iter().for_each(|(i, _)| points[*i].area = largest / meeting.len() as f64);
        }
        let gauss = gauss_points(body.space, body.patches, &faces, None);
        Ok(Self {
            unknowns: interface(body, &gauss, &points),
            points,
            parameters: found.iter().map(|p| p.xi).collect(),
            faces: found.iter().map(|p| p.face).collect(),
            widths: [size, 0.0],
            region: ZoneRegion::Faces(
                faces.into_iter().map(|f| TargetFace::whole(f, body.patches)).collect(),
            ),
            extent: ZoneExtent::Whole,
            meeting,
            left_out: Vec::new(),
        })
    }

    /// The zone under a flat face of the target whose edges press its points, too: these have the outward normal
    /// `outward` of their own face, and lie `on_rim` where that goes on (theory Eq. C.102).
    pub fn under_edges(mut self, outward: [f64; 3], on_rim: impl Iterator<Item = bool>) -> Self {
        for (point, on_rim) in self.points.iter_mut().zip(on_rim) {
            (point.facing, point.on_rim) = (Some(outward), on_rim);
        }
        self
    }

    /// Whether edges of the target may press its points: those of a whole surface, or under a flat face.
    pub fn is_under_edges(&self) -> bool {
        self.extent == ZoneExtent::Whole || self.points.iter().any(|point| point.facing.is_some())
    }

    /// Nodes of its pieces with their places; none of a face.
    pub fn nodes(&self) -> Vec<(u32, [f64; 3])> {
        let ZoneRegion::Pieces(pieces) = &self.region else { return Vec::new() };
        let mut nodes: Vec<u32> = pieces.pieces.iter().flat_map(|p| p.nodes.iter().copied()).collect();
        nodes.sort_unstable();
        nodes.dedup();
        nodes.into_iter().map(|n| (n, pieces.positions[n as usize])).collect()
    }

    /// Moves points and nodes of a zone of pieces to where `place` says; displacements stay those
    /// of the mesh.
    pub fn move_to(&mut self, place: impl Fn(&[f64; 3]) -> [f64; 3]) {
        let nodes = self.nodes();
        let ZoneRegion::Pieces(pieces) = &mut self.region else { return };
        let mut moved = pieces.as_ref().clone();
        nodes.iter().for_each(|(n, x)| moved.positions[*n as usize] = place(x));
        *pieces = Arc::new(moved);
        self.points.iter_mut().for_each(|point| point.position = place(&point.position));
    }
}

/// Whether `point` of a body of the size `size` stands where another one meets an edge or a corner of the target, `here`, or beside it by no more
/// than the body yields: one of the faces beside that would press it aside.
fn stands_there(point: &[f64; 3], here: &[f64; 3], size: f64) -> bool {
    norm(&difference(point, here)) <= TOUCHED_SURFACE * size
}

/// As few Gauss points per direction as integrate a constant pressure times every function of the flat elements of `points`
/// exactly.
fn few_points(body: &Discretised<'_>, points: &[CollocationPoint]) -> usize {
    let counts = points.iter().flat_map(|p| body.space.gauss_counts(p.element));
    counts.max().map_or(1, |of_matrices| of_matrices / 2 + 1)
}

/// All unknowns of the functions that are not zero at Gauss points or contact points of a zone, in
/// ascending order.
fn interface(body: &Discretised<'_>, gauss: &[CollocationPoint], points: &[SurfacePoint]) -> Vec<usize> {
    let mut nodes: Vec<u32> = gauss
        .iter()
        .flat_map(|p| body.space.functions_at(p.element, &p.xi))
        .chain(points.iter().flat_map(|p| p.functions.iter().copied()))
        .map(|f| f.0)
        .collect();
    nodes.sort_unstable();
    nodes.dedup();
    let n_components = body.motion().n_components();
    let number = |&n: &u32| (0..n_components).filter_map(move |c| body.lookup.number(n, c));
    let mut unknowns: Vec<usize> = nodes.iter().flat_map(number).collect();
    unknowns.sort_unstable();
    unknowns
}
