//! The whole surface of a mesh as a contact zone, with its edges and corners (docs/theory.md
//! section C.9).

use std::collections::BTreeMap;
use std::sync::Arc;

use contact_qs::SurfacePiece;
use contact_qs::zone::points::{PressureMean, SurfacePoint};
use fe_mesh::SideKind;
use fe_mesh::fault::MeshFault;
use iga_core::elasticity::Model;
use iga_core::nurbs::SAME_PLACE;
use iga_core::quadrature::LobattoRule;
use iga_core::surface::lobatto_towards;
use nalgebra::{Matrix3, Vector3};

use super::on_sides::unknowns_of;
use super::{
    ContactZone, HALVINGS, MetEdge, PointsAbout, WholeRequest, ZoneExtent, ZoneRegion, stands_there,
};
use crate::surface::{Foot, MeshSurface, Surface, SurfacePlace};

/// Round-off of a function that is one at its node.
const ONE: f64 = 1e-12;
/// Weights of the points of a triangle with six nodes over its area: corners, middles of edges,
/// centroid; exact to degree three.
const TRIANGLE: [f64; 3] = [1.0 / 20.0, 2.0 / 15.0, 9.0 / 20.0];
/// Weights of Simpson's rule on `[-1, 1]` at an end and in the middle.
const SIMPSON: [f64; 2] = [1.0 / 3.0, 4.0 / 3.0];

/// Points and weights of a curve, those of splines (theory Eq. C.56), divided at `place` and by halves
/// towards it if there is one.
fn on_curve(kind: SideKind, model: &Model, place: Option<f64>) -> Vec<([f64; 2], f64)> {
    let of_radius = usize::from(*model == Model::Axisymmetric);
    let rule = LobattoRule::new((kind.degrees()[0] + of_radius + 3).div_ceil(2));
    let halvings = if place.is_some() { HALVINGS } else { 0 };
    let points = lobatto_towards((-1.0, 1.0), place, halvings, &rule).into_iter();
    points.map(|(s, weight)| ([s, 0.0], weight)).collect()
}

/// Points of a side on which contact stands on whole surfaces, its nodes among them, with their
/// weights.
fn points_of(kind: SideKind, model: &Model) -> Vec<([f64; 2], f64)> {
    let nodes = kind.node_parameters();
    match kind {
        SideKind::Line2 | SideKind::Line3 => on_curve(kind, model, None),
        SideKind::Tri3 => nodes.into_iter().map(|eta| (eta, 1.0 / 6.0)).collect(),
        SideKind::Quad4 => nodes.into_iter().map(|eta| (eta, 1.0)).collect(),
        SideKind::Tri6 => {
            let at = |(k, eta)| (eta, 0.5 * if k < 3 { TRIANGLE[0] } else { TRIANGLE[1] });
            let centroid = ([1.0 / 3.0; 2], 0.5 * TRIANGLE[2]);
            nodes.into_iter().enumerate().map(at).chain([centroid]).collect()
        }
        SideKind::Quad8 | SideKind::Quad9 => {
            let weight = |x: f64| SIMPSON[usize::from(x.abs() < 0.5)];
            let line = [-1.0, 0.0, 1.0];
            let grid = line.iter().flat_map(|y| line.iter().map(move |x| [*x, *y]));
            grid.map(|[x, y]| ([x, y], weight(x) * weight(y))).collect()
        }
    }
}

/// Points and weights of a side of the kind `kind` that is divided at its place `place` and by
/// halves towards it: on the square of four corners, and on the pieces of a triangle.
fn points_towards(
    (kind, model): (SideKind, &Model),
    pieces: &[SurfacePiece],
    place: [f64; 2],
) -> Vec<([f64; 2], f64)> {
    if kind.is_curve() {
        return on_curve(kind, model, Some(place[0]));
    }
    let rule = LobattoRule::new(kind.degrees()[0] + 1);
    let square = |range: (f64, f64), place: Option<[f64; 2]>| -> Vec<([f64; 2], f64)> {
        let along = [0, 1].map(|d| lobatto_towards(range, place.map(|s| s[d]), HALVINGS, &rule));
        let grid = along[0].iter().flat_map(|u| along[1].iter().map(move |v| (u, v)));
        grid.map(|((s, v), (t, w))| ([*s, *t], v * w)).collect()
    };
    if kind.n_corners() == 4 {
        return square((-1.0, 1.0), Some(place));
    }
    let on_piece = |piece: &SurfacePiece| -> Vec<([f64; 2], f64)> {
        let points = square((0.0, 1.0), piece.place_of(place)).into_iter();
        points.map(|(s, w)| (piece.parameters(s), w * piece.area_at(s))).collect()
    };
    pieces.iter().flat_map(on_piece).collect()
}

/// Points of a smooth part that stand in one place.
struct Gathered {
    xi: [f64; 3],
    position: Vector3<f64>,
    functions: Vec<(u32, f64)>,
    /// Sum of the outward normals times their areas.
    area: Vector3<f64>,
    size: f64,
}

/// The points of all sides.
struct Gathering<'a> {
    surface: &'a MeshSurface,
    points: Vec<Gathered>,
    /// Index in `points` by node and smooth part of the surface at the node.
    at_nodes: BTreeMap<[u32; 2], usize>,
    /// Indices of the points about a divided place, which stand at no node: a list for each smooth
    /// part that meets there.
    about_place: Vec<Vec<usize>>,
    /// Distance of points that are one \[m\].
    near: f64,
}

impl Gathering<'_> {
    /// Adds the point with the parameters `eta` of side `i`, which belongs to the smooth part
    /// `group` about the place; an earlier one that stands there takes its area.
    fn add(&mut self, i: u32, (eta, weight): ([f64; 2], f64), group: Option<usize>) {
        let (side, at) = (&self.surface.sides()[i as usize], self.surface.at(i as usize, &eta));
        let measure = self.surface.mesh().model().measure(&at.position);
        let (area, position) = (weight * Vector3::from(at.area), Vector3::from(at.position));
        let functions: Vec<(u32, f64)> =
            side.nodes.iter().copied().zip(at.functions.values).filter(|f| f.1.abs() > 0.0).collect();
        // On the axis of symmetry.
        if area.norm() * measure == 0.0 {
            return;
        }
        let node = functions.iter().find(|f| (f.1 - 1.0).abs() <= ONE).map(|f| f.0);
        let here = node.map(|n| [n, self.surface.part_at(n, i)]);
        let beside = || {
            let mut known = self.about_place[group?].iter().copied();
            known.find(|k| (self.points[*k].position - position).norm() <= self.near)
        };
        let known = match here {
            Some(here) => self.at_nodes.get(&here).copied(),
            None => beside(),
        };
        if let Some(k) = known {
            self.points[k].area += area;
            self.points[k].size += area.norm() * measure;
            return;
        }
        match (here, group) {
            (Some(here), _) => {
                self.at_nodes.insert(here, self.points.len());
            }
            (None, Some(group)) => self.about_place[group].push(self.points.len()),
            (None, None) => {}
        }
        let functions = node.map_or(functions, |n| vec![(n, 1.0)]);
        let (xi, size) = ([eta[0], eta[1], 0.0], area.norm() * measure);
        self.points.push(Gathered { xi, position, functions, area, size });
    }

    /// Adds a point of each of the smooth parts `groups` at their place, which meet what is there
    /// of the target, instead of those that stand there; their indices.
    fn add_meeting(&mut self, groups: &[Vec<SurfacePlace>]) -> Vec<(usize, f64)> {
        let Some(here) = groups.first().and_then(|group| group.first()).map(|at| at.point) else {
            return Vec::new();
        };
        let size = self.surface.length();
        self.points.retain(|g| !stands_there(g.position.as_ref(), &here, size));
        let mut meeting = Vec::new();
        for group in groups {
            let (Some(SurfacePlace { face, xi, .. }), Some(normal)) =
                (group.first(), self.surface.mean_normal(group))
            else {
                continue;
            };
            let at = self.surface.at(*face as usize, &[xi[0], xi[1]]);
            let nodes = self.surface.sides()[*face as usize].nodes.iter().copied();
            meeting.push((self.points.len(), 0.0));
            let (position, functions) = (at.position.into(), nodes.zip(at.functions.values).collect());
            self.points.push(Gathered { xi: *xi, position, functions, area: normal, size: 0.0 });
        }
        // The spring of a point has no area of its own: together they have that of the stiffest of
        // all.
        let largest = self.points.iter().map(|g| g.size).fold(0.0, f64::max);
        meeting.iter().for_each(|(k, _)| self.points[*k].size = largest / meeting.len() as f64);
        meeting
    }

    /// Adds points along `edge` in place of those that stand there; their indices and shares.
    fn add_edge(&mut self, edge: &MetEdge) -> Vec<(usize, f64)> {
        let (surface, size) = (self.surface, self.surface.length());
        let on = |point: [f64; 3]| surface.nearest(&point);
        let own = on(edge.middle.into()).map_or_else(Vector3::zeros, |at| at.normal);
        let of =
            |g: &Gathered| (g.position.into(), g.area.try_normalize(0.0).unwrap_or_default().into(), g.size);
        let stand = |point: [f64; 3], size: f64| {
            let Foot { place: SurfacePlace { face, xi, .. }, .. } = on(point)?;
            let at = surface.at(face as usize, &[xi[0], xi[1]]);
            let functions = surface.sides()[face as usize].nodes.iter().copied().zip(at.functions.values);
            Some(Gathered {
                xi,
                position: at.position.into(),
                functions: functions.collect(),
                area: own,
                size,
            })
        };
        let element = |point| on(point).map(|at| at.place.face as usize);
        edge.replace(&mut self.points, (own.as_ref(), size), of, element, stand)
    }
}

impl ContactZone {
    /// The whole of `surface`, or a part of it: points at the nodes of all sides and in their middles, each pressed
    /// only by surfaces that its smooth part is turned to, and all unknowns. At the place `about`,
    /// if there is one, stands a point of each part that meets there: with others ever closer about
    /// it, for an edge that bends touches between nodes, or alone to meet an edge or a corner of
    /// the target. A part consists of the sides that come into it; nodes at which others go on are
    /// its rim.
    ///
    /// # Errors
    /// [`MeshFault::FlatSide`].
    pub fn whole_mesh(surface: &MeshSurface, request: &WholeRequest) -> Result<Self, MeshFault> {
        let about = request.about.as_ref();
        let is_met = about.is_some_and(|about| about.meets.is_some());
        let edge = about.and_then(PointsAbout::edge);
        let alone = about.filter(|_| edge.is_none());
        let there = alone.map_or_else(Vec::new, |about| surface.sides_at(&about.place));
        let groups = surface.smooth_groups(&there);
        let mut gathering = Gathering {
            surface,
            points: Vec::new(),
            at_nodes: BTreeMap::new(),
            about_place: vec![Vec::new(); groups.len()],
            near: SAME_PLACE * surface.length(),
        };
        let n_sides = surface.sides().len();
        let chosen = match (&request.part, &edge) {
            (None, _) => (0..n_sides as u32).collect(),
            (Some(part), None) => surface.sides_in(part),
            // The faces beside the edge come nearer no faster than the bodies.
            (Some(part), Some(edge)) => edge.sides(surface, part.depth),
        };
        let mut is_chosen = vec![false; n_sides];
        // Sides that bend away from the plane of the touch by more than the part goes down belong to it where they touch.
        let touched = about.map_or_else(Vec::new, |about| surface.sides_at(&about.place));
        chosen.into_iter().chain(touched.iter().map(|at| at.face)).for_each(|i| is_chosen[i as usize] = true);
        let chosen: Vec<u32> = (0..n_sides as u32).filter(|&i| is_chosen[i as usize]).collect();
        let is_rim = |n: u32| surface.at_node(n).iter().any(|&i| !is_chosen[i as usize]);
        for &i in &chosen {
            surface.check_side(i as usize)?;
            let (kind, model) = (surface.sides()[i as usize].kind, surface.mesh().model());
            let holds = |group: &Vec<SurfacePlace>| group.iter().any(|place| place.face == i);
            let group = groups.iter().position(holds).filter(|_| !is_met);
            let points = match there.iter().find(|place| place.face == i && group.is_some()) {
                Some(SurfacePlace { xi: [u, v, _], .. }) => {
                    points_towards((kind, model), &surface.pieces_of(&[i]).pieces, [*u, *v])
                }
                None => points_of(kind, model),
            };
            points.into_iter().for_each(|point| gathering.add(i, point, group));
        }
        let meeting = match &edge {
            Some(edge) => gathering.add_edge(edge),
            None if is_met => gathering.add_meeting(&groups),
            None => Vec::new(),
        };
        let parameters = gathering.points.iter().map(|g| g.xi).collect();
        let met: Vec<u32> =
            meeting.iter().flat_map(|(k, _)| gathering.points[*k].functions.iter().map(|f| f.0)).collect();
        let points = gathering.points.into_iter().map(|g| SurfacePoint {
            position: g.position.into(),
            area: g.size,
            on_rim: g.functions.len() == 1 && is_rim(g.functions[0].0),
            functions: g.functions,
            pressure: PressureMean::Area,
            facing: g.area.try_normalize(0.0).map(Into::into),
        });
        Ok(Self {
            points: points.collect(),
            parameters,
            faces: Vec::new(),
            unknowns: unknowns_of(surface, &chosen, met.into_iter()),
            widths: [surface.length(), if chosen.len() < n_sides { least_extent(surface) } else { 0.0 }],
            region: ZoneRegion::Pieces(Arc::new(surface.faces(&chosen))),
            extent: ZoneExtent::Whole,
            meeting,
            left_out: Vec::new(),
        })
    }
}

/// The least extent of the body of `surface` along the axes \[m\].
fn least_extent(surface: &dyn Surface) -> f64 {
    let axes = Matrix3::identity();
    (0..3).map(|d| surface.extent_along(&axes.column(d).into_owned())).fold(f64::INFINITY, f64::min)
}
