//! The surface of a mesh as contact sees it: pieces, contact points, curvatures.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use contact_qs::points::{PressureMean, SurfacePoint};
use contact_qs::{PieceEdge, PiecewiseSurface, SurfacePiece};
use fe_mesh::fault::MeshFault;
use fe_mesh::locate::SidePoint;
use fe_mesh::shape::Functions;
use fe_mesh::surface::{Surface, SurfaceSide};
use fe_mesh::{Mesh, SideKind};
use nalgebra::{DMatrix, DVector, Matrix2, SymmetricEigen, Vector2, Vector3};

use crate::contact_zone::{ContactZone, ZoneExtent, ZoneRegion};

/// A place on a side of a mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SideSite {
    /// Number of the side, in the order of [`Mesh::surface`].
    pub side: usize,
    /// Parameters of the side.
    pub eta: [f64; 2],
    /// Undeformed position \[m\].
    pub point: [f64; 3],
}

/// The surface of a mesh.
pub struct MeshSurface {
    mesh: Arc<Mesh>,
    surface: Surface,
}

/// The shape of a surface about a place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LocalShape {
    /// Principal curvatures, larger first, positive where the body is convex [1/m].
    pub curvatures: [f64; 2],
    /// Direction of the first, a unit vector.
    pub direction: Vector3<f64>,
    /// Two unit vectors along the surface, those of the principal curvatures.
    pub tangents: [Vector3<f64>; 2],
    /// Outward unit normal.
    pub normal: Vector3<f64>,
}

/// Nodes by which curvatures are fitted, at least; a paraboloid has six unknowns.
const FITTED: usize = 16;

/// Parts of an edge at whose ends normals are compared: contact radii of a sixteenth of an edge are seen.
const EDGE_PARTS: usize = 16;

/// Normals whose cosines with a direction differ by less are alike: round-off of positions, squared lengths.
const ALIKE: f64 = 1e-9;

/// A point lies on a side if that comes nearer than this part of its longest edge: places are found to 1e-9.
const SAME_POINT: f64 = 1e-6;

/// Steps of Newton's method on a side, which is flat or slightly curved: five do.
const NEWTON_STEPS: usize = 20;

/// Components of displacement at a node.
const N_COMPONENTS: usize = 3;

/// The linear functions of the corners of `side` at the parameters `xi`, with the numbers of their nodes.
fn hats(side: &SurfaceSide, xi: &[f64; 2]) -> Vec<(u32, f64)> {
    let kind = if side.n_edges() == 3 { SideKind::Tri3 } else { SideKind::Quad4 };
    let mut functions = Functions::default();
    kind.functions(xi, &mut functions);
    side.nodes.iter().copied().zip(functions.values).collect()
}

impl MeshSurface {
    /// The surface of `mesh`.
    pub fn of(mesh: &Arc<Mesh>) -> Arc<Self> {
        Arc::new(Self { mesh: Arc::clone(mesh), surface: Surface::new(mesh) })
    }

    /// The place with the parameters `eta` of side `side`.
    pub fn site(&self, side: usize, eta: [f64; 2]) -> SideSite {
        SideSite { side, eta, point: self.at(side, &eta).position }
    }

    /// Position, normal and functions at parameters of a side.
    fn at(&self, side: usize, eta: &[f64; 2]) -> SidePoint {
        let (of, mut places, mut at) = (&self.surface.sides()[side], Vec::new(), SidePoint::default());
        self.mesh.places(&of.nodes, &mut places);
        at.evaluate(of.kind, &places, eta);
        at
    }

    /// The longest edge of the side at `site` and of those beside it \[m\].
    pub fn length_at(&self, site: &SideSite) -> f64 {
        let beside = self.surface.sides()[site.side].neighbours.iter().flatten().map(|n| n.side as usize);
        beside.chain([site.side]).map(|i| self.surface.longest_edge(&self.mesh, i)).fold(0.0, f64::max)
    }

    /// Largest angles by which normals turn at the edges of the side at `site` and of those beside it: anywhere, and nearer than `radius` to it; creases
    /// do not count.
    pub fn turns_at(&self, site: &SideSite, radius: f64) -> [f64; 2] {
        let centre = Vector3::from(site.point);
        let beside = self.surface.sides()[site.side].neighbours.iter().flatten().map(|n| n.side as usize);
        let mut largest = [0.0_f64; 2];
        for side in beside.chain([site.side]) {
            let of = &self.surface.sides()[side];
            for (edge, other) in of.neighbours.iter().enumerate() {
                let Some(other) = other.filter(|other| other.is_smooth) else { continue };
                for k in 0..=EDGE_PARTS {
                    let share = k as f64 / EDGE_PARTS as f64;
                    let own = self.at(side, &of.kind.on_edge(edge, share));
                    let there = &self.surface.sides()[other.side as usize];
                    // Sides run along their common edge against each other.
                    let there =
                        self.at(other.side as usize, &there.kind.on_edge(other.edge as usize, 1.0 - share));
                    let turn = Vector3::from(own.area).angle(&Vector3::from(there.area));
                    largest[0] = largest[0].max(turn);
                    if (Vector3::from(own.position) - centre).norm() <= radius {
                        largest[1] = largest[1].max(turn);
                    }
                }
            }
        }
        largest
    }

    /// Longest edge of each side with its middle \[m\].
    pub fn lengths(&self) -> impl Iterator<Item = ([f64; 3], f64)> + '_ {
        (0..self.surface.sides().len()).map(|i| {
            let eta = if self.surface.sides()[i].n_edges() == 3 { [1.0 / 3.0; 2] } else { [0.0; 2] };
            (self.at(i, &eta).position, self.surface.longest_edge(&self.mesh, i))
        })
    }

    /// All sides as pieces.
    pub fn pieces(&self) -> PiecewiseSurface {
        let all: Vec<u32> = (0..self.surface.sides().len() as u32).collect();
        self.pieces_of(&all)
    }

    /// The sides `chosen` as pieces, which are neighbours of each other where the surface is smooth.
    fn pieces_of(&self, chosen: &[u32]) -> PiecewiseSurface {
        let first = first_pieces(chosen.iter().map(|&i| self.surface.sides()[i as usize].n_edges()));
        let number: HashMap<u32, u32> = chosen.iter().copied().zip(first).collect();
        let mut pieces = Vec::new();
        for &i in chosen {
            let side = &self.surface.sides()[i as usize];
            let (n, first) = (side.n_edges(), number[&i]);
            for (k, piece) in side.kind.pieces().iter().enumerate() {
                // Half of the edge from this corner, and of the one to it, lie on the piece's edges 0 and 3.
                let across = |edge: usize, is_start: bool| -> Option<PieceEdge> {
                    let other = side.neighbours[edge].filter(|other| other.is_smooth)?;
                    let (first, m) =
                        (number.get(&other.side)?, self.surface.sides()[other.side as usize].n_edges());
                    // Sides run along their common edge against each other.
                    let (corner, edge) =
                        if is_start { ((other.edge as usize + 1) % m, 3) } else { (other.edge as usize, 0) };
                    Some(PieceEdge { piece: first + corner as u32, edge })
                };
                let within = |corner: usize, edge| Some(PieceEdge { piece: first + corner as u32, edge });
                pieces.push(SurfacePiece {
                    side: i,
                    corners: piece.corners,
                    degree: side.kind.degree(),
                    nodes: side.nodes.clone(),
                    coefficients: side.kind.bernstein(piece).concat(),
                    neighbours: [
                        across(k, true),
                        within((k + 1) % n, 2),
                        within((k + n - 1) % n, 1),
                        across((k + n - 1) % n, false),
                    ],
                });
            }
        }
        PiecewiseSurface { pieces, positions: self.mesh.nodes().to_vec() }
    }

    /// The zone of the sides that are smoothly connected with the one at `site` and come within `reach` of it, with a ring of sides around: their
    /// Gauss points with areas and functions, and all unknowns of their nodes. On its rim are the points of the ring where the surface goes on beyond.
    ///
    /// # Errors
    /// [`MeshFault::FlatSide`].
    pub fn zone(&self, site: &SideSite, reach: f64) -> Result<ContactZone, MeshFault> {
        let centre = Vector3::from(site.point);
        let width = (2.0 * reach).min(self.mesh.size());
        let is_near = |x: &[f64; 3]| (Vector3::from(*x) - centre).norm() <= reach;
        self.zone_within(site.side, is_near, |_| true, [width, 0.0])
    }

    /// The same of the sides with a point of which `is_near`, among those that may take part: with all of their nodes `is_free`.
    ///
    /// # Errors
    /// [`MeshFault::FlatSide`].
    pub fn zone_within(
        &self,
        first: usize,
        is_near: impl Fn(&[f64; 3]) -> bool,
        is_free: impl Fn(u32) -> bool,
        widths: [f64; 2],
    ) -> Result<ContactZone, MeshFault> {
        let may_be = |i: usize| self.surface.sides()[i].nodes.iter().all(|&n| is_free(n));
        let is_chosen = |i: usize| may_be(i) && self.places_on(i).iter().any(&is_near);
        let mut sides = self.with_ring(&self.surface.smooth_part(first, is_chosen));
        sides.retain(|&i| may_be(i as usize));
        let inside: HashSet<u32> = sides.iter().copied().collect();
        let (mut points, mut parameters, mut nodes) = (Vec::new(), Vec::new(), Vec::new());
        for &i in &sides {
            self.surface.check_side(&self.mesh, i as usize)?;
            let side = &self.surface.sides()[i as usize];
            let beyond = side.neighbours.iter().flatten();
            let on_rim = beyond.copied().any(|n| n.is_smooth && !inside.contains(&n.side));
            for point in side.kind.contact_rule() {
                let at = self.at(i as usize, &point.xi);
                points.push(SurfacePoint {
                    position: at.position,
                    area: point.weight * Vector3::from(at.area).norm(),
                    functions: side.nodes.iter().copied().zip(at.functions.values).collect(),
                    on_rim,
                    pressure: PressureMean::Hats(hats(side, &point.xi)),
                    facing: None,
                });
                parameters.push([point.xi[0], point.xi[1], 0.0]);
            }
            nodes.extend(&side.nodes);
        }
        nodes.sort_unstable();
        nodes.dedup();
        let unknowns = |&n: &u32| (0..N_COMPONENTS).map(move |c| N_COMPONENTS * n as usize + c);
        Ok(ContactZone {
            unknowns: nodes.iter().flat_map(unknowns).collect(),
            points,
            parameters,
            faces: Vec::new(),
            widths,
            region: ZoneRegion::Pieces(Arc::new(self.pieces_of(&sides))),
            extent: ZoneExtent::Part,
            meeting: Vec::new(),
        })
    }

    /// The longest edge of the sides that are smoothly connected with side `first` and have a point that `is_near`, and of those beside them \[m\].
    pub fn longest_within(&self, first: usize, is_near: impl Fn(&[f64; 3]) -> bool) -> f64 {
        let is_chosen = |i: usize| self.places_on(i).iter().any(&is_near);
        let sides = self.with_ring(&self.surface.smooth_part(first, is_chosen));
        sides.iter().map(|&i| self.surface.longest_edge(&self.mesh, i as usize)).fold(0.0, f64::max)
    }

    /// The largest extent along the unit vector `across` of the sides that are smoothly connected with the one at `site` and come within `reach` of the plane
    /// across it through the site \[m\].
    pub fn longest_across(&self, site: &SideSite, across: &Vector3<f64>, reach: f64) -> f64 {
        let centre = Vector3::from(site.point);
        let is_near = |x: &[f64; 3]| (Vector3::from(*x) - centre).dot(across).abs() <= reach;
        let is_chosen = |i: usize| i == site.side || self.places_on(i).iter().any(is_near);
        let extent = |i: &u32| {
            let heights = self.surface.sides()[*i as usize].nodes.iter();
            let heights = heights.map(|&n| Vector3::from(self.mesh.nodes()[n as usize]).dot(across));
            let (low, high) = heights
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), h| (f64::min(a, h), f64::max(b, h)));
            high - low
        };
        self.surface.smooth_part(site.side, is_chosen).iter().map(extent).fold(0.0, f64::max)
    }

    /// The zone of the sides that are smoothly connected with the one at `site` and come within `reach` of the plane across the unit vector `across` through it,
    /// as far as the surface goes along that.
    ///
    /// # Errors
    /// [`MeshFault::FlatSide`].
    pub fn zone_along(
        &self,
        site: &SideSite,
        across: &Vector3<f64>,
        reach: f64,
    ) -> Result<ContactZone, MeshFault> {
        let centre = Vector3::from(site.point);
        let is_near = |x: &[f64; 3]| (Vector3::from(*x) - centre).dot(across).abs() <= reach;
        self.zone_within(site.side, is_near, |_| true, [2.0 * reach, 0.0])
    }

    /// Nodes and points of side `i`.
    fn places_on(&self, i: usize) -> Vec<[f64; 3]> {
        let of = &self.surface.sides()[i];
        let nodes = of.nodes.iter().map(|&n| self.mesh.nodes()[n as usize]);
        nodes.chain(of.kind.rule().into_iter().map(|p| self.at(i, &p.xi).position)).collect()
    }

    /// The side nearest to `point`, with its place.
    pub fn nearest(&self, point: &[f64; 3]) -> Option<SideSite> {
        let found = self.mesh.nearest(point)?;
        let side = self.mesh.surface().binary_search(&found.face).ok()?;
        Some(SideSite { side, eta: found.eta, point: found.point })
    }

    /// The place `site` on that side, of those that meet there, whose normal is nearest to `direction`: what is first to touch may be a corner or an
    /// edge of several sides, of which any may have been found.
    pub fn facing(&self, site: &SideSite, direction: &Vector3<f64>) -> SideSite {
        let own = &self.surface.sides()[site.side].nodes;
        let sides = (0..self.surface.sides().len())
            .filter(|i| self.surface.sides()[*i].nodes.iter().any(|n| own.contains(n)));
        let places = sides.filter_map(|side| {
            let eta = if side == site.side { site.eta } else { self.parameters(side, &site.point)? };
            let normal = Vector3::from(self.at(side, &eta).area).try_normalize(0.0)?;
            Some((normal.dot(direction), SideSite { side, eta, ..*site }))
        });
        // The first of those alike.
        let best = places.fold(None, |best: Option<(f64, SideSite)>, (cosine, place)| match best {
            Some((most, _)) if cosine <= most + ALIKE => best,
            _ => Some((cosine, place)),
        });
        best.map_or(*site, |(_, place)| place)
    }

    /// Parameters of `point` on `side`, by Newton's method; `None` if it does not lie there.
    fn parameters(&self, side: usize, point: &[f64; 3]) -> Option<[f64; 2]> {
        let limit = SAME_POINT * self.surface.longest_edge(&self.mesh, side);
        let ends = self.surface.sides()[side].kind.node_parameters();
        let middle = |d: usize| ends.iter().map(|eta| eta[d]).sum::<f64>() / ends.len() as f64;
        let mut eta = [middle(0), middle(1)];
        for _ in 0..NEWTON_STEPS {
            let at = self.at(side, &eta);
            let miss = Vector3::from(*point) - Vector3::from(at.position);
            if miss.norm() <= limit {
                return Some(eta);
            }
            let [a, b] = at.tangents.map(Vector3::from);
            let matrix = Matrix2::new(a.dot(&a), a.dot(&b), a.dot(&b), b.dot(&b));
            let step = matrix.try_inverse()? * Vector2::new(a.dot(&miss), b.dot(&miss));
            eta = [eta[0] + step[0], eta[1] + step[1]];
        }
        None
    }

    /// Whether a side of the mesh about `site`, its own or one with a node of that, lies in the plane through the place with the unit `normal`, but
    /// for `slope`: the place may be a corner of a flat face and belong to another one.
    pub fn is_flat_against(&self, site: &SideSite, normal: &Vector3<f64>, slope: f64) -> bool {
        let (sides, place) = (self.surface.sides(), Vector3::from(site.point));
        let own = &sides[site.side].nodes;
        let is_beside = |i: &usize| sides[*i].nodes.iter().any(|n| own.contains(n));
        (0..sides.len()).filter(is_beside).any(|i| {
            let most = slope * self.surface.longest_edge(&self.mesh, i);
            self.places_on(i).iter().all(|x| (Vector3::from(*x) - place).dot(normal).abs() <= most)
        })
    }

    /// The sides `chosen` with those beyond their smooth edges, rising.
    fn with_ring(&self, chosen: &[u32]) -> Vec<u32> {
        let beside = |i: &u32| self.surface.sides()[*i as usize].neighbours.into_iter().flatten();
        let ring = chosen.iter().flat_map(beside).filter(|n| n.is_smooth).map(|n| n.side);
        let mut all: Vec<u32> = chosen.iter().copied().chain(ring).collect();
        all.sort_unstable();
        all.dedup();
        all
    }

    /// The shape of the surface about `site`: that of the paraboloid through the nodes around in the sense of least squares, since second
    /// derivatives of a single side are right to its first order only. `None` if the nodes lie on a line, or the side has no normal.
    pub fn shape_at(&self, site: &SideSite) -> Option<LocalShape> {
        let centre = Vector3::from(site.point);
        let normal = Vector3::from(self.at(site.side, &site.eta).area).try_normalize(0.0)?;
        let along = (Vector3::from(self.at(site.side, &site.eta).tangents[0])).try_normalize(0.0)?;
        let (t, s) = (along, normal.cross(&along));
        let places = self.around(site, FITTED);
        let size = places.iter().map(|x| (x - centre).norm()).fold(0.0, f64::max);
        let row = |x: &Vector3<f64>| {
            let r = (x - centre) / size;
            let (u, v) = (r.dot(&t), r.dot(&s));
            [1.0, u, v, 0.5 * u * u, u * v, 0.5 * v * v]
        };
        let matrix = DMatrix::from_fn(places.len(), 6, |i, j| row(&places[i])[j]);
        let heights = DVector::from_fn(places.len(), |i, _| (places[i] - centre).dot(&normal) / size);
        // Beyond this condition the nodes do not tell the six apart.
        let fit = matrix.svd(true, true).solve(&heights, 1e-10).ok()?;
        // Slopes of a smooth surface at its own normal are small: their squares are left out.
        let bend = Matrix2::new(fit[3], fit[4], fit[4], fit[5]) * (-1.0 / size);
        let SymmetricEigen { eigenvalues, eigenvectors } = bend.symmetric_eigen();
        let first = usize::from(eigenvalues[1] > eigenvalues[0]);
        let axis = eigenvectors.column(first);
        let direction = t * axis[0] + s * axis[1];
        Some(LocalShape {
            curvatures: [eigenvalues[first], eigenvalues[1 - first]],
            direction,
            tangents: [direction, normal.cross(&direction)],
            normal,
        })
    }

    /// Nodes of the sides around `site`, ring after ring over smooth edges until there are `enough`, or no more.
    pub fn around(&self, site: &SideSite, enough: usize) -> Vec<Vector3<f64>> {
        let mut rings: HashSet<u32> = HashSet::from([site.side as u32]);
        let nodes = |sides: &HashSet<u32>| -> Vec<u32> {
            let mut all: Vec<u32> =
                sides.iter().flat_map(|&i| self.surface.sides()[i as usize].nodes.iter().copied()).collect();
            all.sort_unstable();
            all.dedup();
            all
        };
        loop {
            let known: HashSet<u32> = nodes(&rings).into_iter().collect();
            if known.len() >= enough {
                break;
            }
            let beside = |i: &u32| self.surface.sides()[*i as usize].neighbours.into_iter().flatten();
            let next: Vec<u32> =
                rings.iter().flat_map(beside).filter(|n| n.is_smooth).map(|n| n.side).collect();
            let before = rings.len();
            rings.extend(next);
            if rings.len() == before {
                break;
            }
        }
        nodes(&rings).into_iter().map(|n| Vector3::from(self.mesh.nodes()[n as usize])).collect()
    }
}

/// Number of the first piece of each side, one per corner.
fn first_pieces(corners: impl Iterator<Item = usize>) -> Vec<u32> {
    corners
        .scan(0, |sum, n| {
            let first = *sum;
            *sum += n as u32;
            Some(first)
        })
        .collect()
}
