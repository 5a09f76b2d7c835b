//! The whole surface of a mesh as a contact zone, with its edges and corners (docs/theory.md section C.9).

use std::collections::BTreeMap;
use std::sync::Arc;

use contact_qs::SurfacePiece;
use contact_qs::points::{PressureMean, SurfacePoint};
use fe_mesh::SideKind;
use fe_mesh::fault::MeshFault;
use iga_core::nurbs::SAME_PLACE;
use iga_core::quadrature::LobattoRule;
use iga_core::surface::lobatto_towards;
use nalgebra::Vector3;

use super::on_sides::unknowns_of;
use super::{ContactZone, HALVINGS, PointsAbout, ZoneExtent, ZoneRegion};
use crate::surface::{MeshSurface, Surface, SurfacePlace};

/// Round-off of a function that is one at its node.
const ONE: f64 = 1e-12;
/// Weights of the points of a triangle with six nodes over its area: corners, middles of edges, centroid; exact to degree three.
const TRIANGLE: [f64; 3] = [1.0 / 20.0, 2.0 / 15.0, 9.0 / 20.0];
/// Weights of Simpson's rule on `[-1, 1]` at an end and in the middle.
const SIMPSON: [f64; 2] = [1.0 / 3.0, 4.0 / 3.0];

/// Points of a side on which contact stands on whole surfaces, its nodes among them, with their weights.
fn points_of(kind: SideKind) -> Vec<([f64; 2], f64)> {
    let nodes = kind.node_parameters();
    match kind {
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

/// The same of a side of the kind `kind`, ever closer about its place `place`: on the square of four corners, and on the pieces of a triangle.
fn points_towards(kind: SideKind, pieces: &[SurfacePiece], place: [f64; 2]) -> Vec<([f64; 2], f64)> {
    let rule = LobattoRule::new(kind.degree() + 1);
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

impl ContactZone {
    /// The whole of `surface`: points at the nodes of all sides and in their middles, each pressed only by surfaces that its smooth part is turned to, and
    /// all unknowns. At the place `about`, if there is one, stands a point of each part that meets there: with others ever closer about it, for an edge
    /// that bends touches between nodes, or alone to meet an edge or a corner of the target.
    ///
    /// # Errors
    /// [`MeshFault::FlatSide`].
    pub fn whole_mesh(surface: &MeshSurface, about: Option<&PointsAbout>) -> Result<Self, MeshFault> {
        let all: Vec<u32> = (0..surface.sides().len() as u32).collect();
        let is_met = about.is_some_and(|about| about.meets.is_some());
        let there = about.map_or_else(Vec::new, |about| surface.sides_at(&about.place));
        let groups = surface.smooth_groups(&there);
        let mut gathered: Vec<Gathered> = Vec::new();
        // By node and smooth part there; those about the place by its smooth parts.
        let (mut at_nodes, mut about_place) =
            (BTreeMap::<[u32; 2], usize>::new(), vec![Vec::new(); groups.len()]);
        let near = SAME_PLACE * surface.length();
        for &i in &all {
            surface.check_side(i as usize)?;
            let side = &surface.sides()[i as usize];
            let group = groups.iter().position(|group| !is_met && group.iter().any(|place| place.face == i));
            let place = there.iter().find(|place| place.face == i && group.is_some());
            let points = match place {
                Some(SurfacePlace { xi: [u, v, _], .. }) => {
                    points_towards(side.kind, &surface.pieces_of(&[i]).pieces, [*u, *v])
                }
                None => points_of(side.kind),
            };
            for (eta, weight) in points {
                let at = surface.at(i as usize, &eta);
                let (area, position) = (weight * Vector3::from(at.area), Vector3::from(at.position));
                let functions: Vec<(u32, f64)> =
                    side.nodes.iter().copied().zip(at.functions.values).filter(|f| f.1.abs() > 0.0).collect();
                let node = functions.iter().find(|f| (f.1 - 1.0).abs() <= ONE).map(|f| f.0);
                let here = node.map(|n| [n, surface.part_at(n, i)]);
                let beside = || {
                    let known: &Vec<usize> = &about_place[group?];
                    known.iter().copied().find(|k| (gathered[*k].position - position).norm() <= near)
                };
                let known = match here {
                    Some(here) => at_nodes.get(&here).copied(),
                    None => beside(),
                };
                if let Some(k) = known {
                    gathered[k].area += area;
                    gathered[k].size += area.norm();
                    continue;
                }
                if let Some(here) = here {
                    at_nodes.insert(here, gathered.len());
                } else if let Some(group) = group {
                    about_place[group].push(gathered.len());
                }
                let functions = node.map_or(functions, |n| vec![(n, 1.0)]);
                let (xi, size) = ([eta[0], eta[1], 0.0], area.norm());
                gathered.push(Gathered { xi, position, functions, area, size });
            }
        }
        let mut meeting = Vec::new();
        if is_met {
            for group in &groups {
                let (Some(SurfacePlace { face, xi, .. }), Some(normal)) =
                    (group.first(), surface.mean_normal(group))
                else {
                    continue;
                };
                let side = &surface.sides()[*face as usize];
                let at = surface.at(*face as usize, &[xi[0], xi[1]]);
                let functions = side.nodes.iter().copied().zip(at.functions.values).collect();
                meeting.push(gathered.len());
                let position = at.position.into();
                gathered.push(Gathered { xi: *xi, position, functions, area: normal, size: 0.0 });
            }
            // The spring of a point has no area of its own: together they have that of the stiffest of all.
            let largest = gathered.iter().map(|g| g.size).fold(0.0, f64::max);
            meeting.iter().for_each(|&k| gathered[k].size = largest / meeting.len() as f64);
        }
        let point = |g: &Gathered| SurfacePoint {
            position: g.position.into(),
            area: g.size,
            functions: g.functions.clone(),
            on_rim: false,
            pressure: PressureMean::Area,
            facing: g.area.try_normalize(0.0).map(Into::into),
        };
        Ok(Self {
            points: gathered.iter().map(point).collect(),
            parameters: gathered.iter().map(|g| g.xi).collect(),
            faces: Vec::new(),
            unknowns: unknowns_of(surface, &all),
            widths: [surface.length(), 0.0],
            region: ZoneRegion::Pieces(Arc::new(surface.faces())),
            extent: ZoneExtent::Whole,
            meeting,
        })
    }
}
