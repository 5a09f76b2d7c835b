//! The surface of a mesh: its sides, the smooth parts that they form, and the edges between these
//! parts.

use std::collections::{HashMap, HashSet};
use std::sync::{Arc, OnceLock};

use contact_qs::search::{SearchWorkspace, SurfaceModel, plane_distance};
use contact_qs::zone::points::DofLookup;
use contact_qs::{ContactError, PieceEdge, PiecewiseSurface, Plane, SurfacePiece};
use faer::Mat;
use fe_mesh::Mesh;
use fe_mesh::element::side_pieces::SidePiece;
use fe_mesh::locate::{SidePoint, SurfaceSearch};
use fe_mesh::surface::{CREASE, Neighbour, Surface as Sides, SurfaceSide};
use ffr_dynamics::body::RigidMotion;
use ffr_dynamics::force::BodyState;
use nalgebra::{DMatrix, DVector, Matrix2, SymmetricEigen, Unit, Vector2, Vector3};

use super::primitive::Primitive;
use super::{Foot, LocalShape, StraightLine, Surface, SurfacePlace};
use crate::record::TouchedPart;
use crate::spec::body::{dofs_of, rigid_motion};

mod around;
mod curve;
mod edges;
mod lines;

/// The surface of a mesh.
pub struct MeshSurface {
    mesh: Arc<Mesh>,
    sides: Sides,
    /// Sides at each node.
    at_node: OnceLock<Vec<Vec<u32>>>,
    search: OnceLock<SurfaceSearch>,
    /// Numbers of the unknowns of all nodes.
    lookup: OnceLock<DofLookup>,
    highest_edge: OnceLock<f64>,
}

/// Parameters of the corners of a side of four, and of a curve a unit thick.
const SQUARE: [[f64; 2]; 4] = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
const CURVE: [[f64; 2]; 4] = [[-1.0, 0.0], [1.0, 0.0], [1.0, 1.0], [-1.0, 1.0]];
/// Least number of nodes to which a paraboloid is fitted for the curvatures; it has six unknowns.
const FITTED: usize = 16;
/// Number of parts of an edge at whose ends the normals of both sides are compared: enough for
/// contact radii of a sixteenth of an edge.
const EDGE_PARTS: usize = 16;
/// Difference of the cosines of two normals with a direction below which both are equally near to
/// it: round-off of positions.
const ALIKE: f64 = 1e-9;
/// Distance of a point from a side, as a share of its longest edge, below which the point lies on
/// it; searches find places to 1e-9.
const SAME_POINT: f64 = 1e-6;
/// Limit of the steps of Newton's method on a side; six are enough, as sides are flat or slightly
/// curved.
const NEWTON_STEPS: usize = 20;
/// Step of the parameters after which they are right to round-off: the next one would be its square.
const SETTLED: f64 = 1e-9;
/// Deviation of nodes from a plane face or a straight line, as a share of the body's size:
/// coordinates in files have at least six digits.
const SAME_PLANE: f64 = 1e-6;

impl MeshSurface {
    /// The surface of `mesh`.
    pub fn of(mesh: &Arc<Mesh>) -> Arc<Self> {
        let (at_node, search, lookup, highest_edge) = Default::default();
        let (mesh, sides) = (Arc::clone(mesh), Sides::new(mesh));
        Arc::new(Self { mesh, sides, at_node, search, lookup, highest_edge })
    }

    /// The mesh.
    pub fn mesh(&self) -> &Arc<Mesh> {
        &self.mesh
    }

    /// Its sides with their neighbours.
    pub fn sides(&self) -> &[SurfaceSide] {
        self.sides.sides()
    }

    /// The sides that are connected with `first` over smooth edges and through sides for which
    /// `is_wanted` holds, in ascending order.
    pub fn smooth_part(&self, first: usize, is_wanted: impl Fn(usize) -> bool) -> Vec<u32> {
        self.sides.smooth_part(first, is_wanted)
    }

    /// Checks that side `i` has a normal at its points and corners.
    ///
    /// # Errors
    /// [`fe_mesh::fault::MeshFault::FlatSide`].
    pub fn check_side(&self, i: usize) -> Result<(), fe_mesh::fault::MeshFault> {
        self.sides.check_side(&self.mesh, i)
    }

    /// Position, normal and functions at parameters of a side.
    pub fn at(&self, side: usize, eta: &[f64; 2]) -> SidePoint {
        let (of, mut places, mut at) = (&self.sides()[side], Vec::new(), SidePoint::default());
        self.mesh.places(&of.nodes, &mut places);
        at.evaluate(of.kind, &places, eta);
        at
    }

    /// Unknowns of node `n`; on a divided mesh of a node that follows no other.
    pub fn unknowns_at(&self, n: u32) -> impl Iterator<Item = usize> {
        let model = self.mesh.model();
        let number = || DofLookup::new(&dofs_of(model, self.mesh.nodes()));
        let lookup = self.lookup.get_or_init(number);
        (0..model.dimension()).filter_map(move |c| lookup.number(n, c))
    }

    /// Longest edge of side `i`, between its corners \[m\].
    pub fn longest_edge(&self, i: usize) -> f64 {
        self.sides.longest_edge(&self.mesh, i)
    }

    /// Sides at node `n`.
    pub fn at_node(&self, n: u32) -> &[u32] {
        let all = self.at_node.get_or_init(|| {
            let mut all = vec![Vec::new(); self.mesh.nodes().len()];
            for (i, side) in self.sides().iter().enumerate() {
                side.nodes.iter().for_each(|&n| all[n as usize].push(i as u32));
            }
            all
        });
        &all[n as usize]
    }

    fn neighbours(&self, side: usize) -> impl Iterator<Item = Neighbour> {
        self.sides()[side].neighbours.into_iter().flatten()
    }

    /// The longest edge of the side at `place` and of those beside it \[m\].
    pub fn length_at(&self, place: &SurfacePlace) -> f64 {
        let side = place.face as usize;
        let beside = self.neighbours(side).map(|n| n.side as usize);
        beside.chain([side]).map(|i| self.longest_edge(i)).fold(0.0, f64::max)
    }

    /// Largest angles by which normals turn at the edges of the side at `place` and of those beside
    /// it: anywhere, and nearer than `radius` to it; creases do not count.
    pub fn turns_at(&self, place: &SurfacePlace, radius: f64) -> [f64; 2] {
        let (centre, side) = (Vector3::from(place.point), place.face as usize);
        let beside = self.neighbours(side).map(|n| n.side as usize);
        let mut largest = [0.0_f64; 2];
        for side in beside.chain([side]) {
            let of = &self.sides()[side];
            for (edge, other) in of.neighbours.iter().enumerate() {
                let Some(other) = other.filter(|other| other.is_smooth) else { continue };
                for k in 0..=EDGE_PARTS {
                    let share = k as f64 / EDGE_PARTS as f64;
                    let own = self.at(side, &of.kind.on_edge(edge, share));
                    let there = &self.sides()[other.side as usize];
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
        (0..self.sides().len()).map(|i| {
            let eta = if self.sides()[i].n_edges() == 3 { [1.0 / 3.0; 2] } else { [0.0; 2] };
            (self.at(i, &eta).position, self.longest_edge(i))
        })
    }

    /// The largest height of an edge of a side over its chord, in its middle, that of a curve itself \[m\].
    pub fn highest_edge(&self) -> f64 {
        *self.highest_edge.get_or_init(|| self.edge_heights().fold(0.0, f64::max))
    }

    fn edge_heights(&self) -> impl Iterator<Item = f64> + '_ {
        self.sides().iter().enumerate().flat_map(move |(i, side)| {
            (0..if side.kind.is_curve() { 1 } else { side.n_edges() }).map(move |edge| {
                let [a, middle, b] = [0.0, 0.5, 1.0].map(|share| {
                    let on_curve = [2.0 * share - 1.0, 0.0];
                    let eta = if side.kind.is_curve() { on_curve } else { side.kind.on_edge(edge, share) };
                    Vector3::from(self.at(i, &eta).position)
                });
                (middle - 0.5 * (a + b)).norm()
            })
        })
    }

    /// All sides as pieces.
    pub fn pieces(&self) -> PiecewiseSurface {
        let all: Vec<u32> = (0..self.sides().len() as u32).collect();
        self.pieces_of(&all)
    }

    /// Each of the sides `chosen` as a face of its own, without normals that are continuous over
    /// edges: one piece for a curve and a quadrilateral, three for a triangle.
    pub fn faces(&self, chosen: &[u32]) -> PiecewiseSurface {
        let pieces = chosen.iter().flat_map(|&i| {
            let side = &self.sides()[i as usize];
            let corners = match side.n_edges() {
                2 => vec![SidePiece { corners: CURVE }],
                4 => vec![SidePiece { corners: SQUARE }],
                _ => side.kind.pieces(),
            };
            corners.into_iter().map(move |piece| SurfacePiece {
                side: i,
                corners: piece.corners,
                degrees: side.kind.degrees(),
                nodes: side.nodes.clone(),
                coefficients: side.kind.bernstein(&piece).concat(),
                neighbours: [None; 4],
            })
        });
        PiecewiseSurface { pieces: pieces.collect(), positions: self.mesh.nodes().to_vec() }
    }

    /// The sides `chosen` as pieces, which are neighbours of each other where the surface is
    /// smooth.
    pub fn pieces_of(&self, chosen: &[u32]) -> PiecewiseSurface {
        let first = first_pieces(chosen.iter().map(|&i| self.sides()[i as usize].n_edges()));
        let number: HashMap<u32, u32> = chosen.iter().copied().zip(first).collect();
        let mut pieces = Vec::new();
        for &i in chosen {
            let side = &self.sides()[i as usize];
            let (n, first) = (side.n_edges(), number[&i]);
            for (k, piece) in side.kind.pieces().iter().enumerate() {
                // Half of the edge from this corner, and of the one to it, lie on the piece's edges
                // 0 and 3.
                let across = |edge: usize, is_start: bool| -> Option<PieceEdge> {
                    let other = side.neighbours[edge].filter(|other| other.is_smooth)?;
                    let (first, m) = (number.get(&other.side)?, self.sides()[other.side as usize].n_edges());
                    if side.kind.is_curve() {
                        let (piece, edge) = (first + u32::from(other.edge), [3, 1][other.edge as usize]);
                        return Some(PieceEdge { piece, edge });
                    }
                    // Sides run along their common edge against each other.
                    let (corner, edge) =
                        if is_start { ((other.edge as usize + 1) % m, 3) } else { (other.edge as usize, 0) };
                    Some(PieceEdge { piece: first + corner as u32, edge })
                };
                let within = |corner: usize, edge| Some(PieceEdge { piece: first + corner as u32, edge });
                pieces.push(SurfacePiece {
                    side: i,
                    corners: piece.corners,
                    degrees: side.kind.degrees(),
                    nodes: side.nodes.clone(),
                    coefficients: side.kind.bernstein(piece).concat(),
                    neighbours: match (side.kind.is_curve(), k) {
                        (true, 0) => [None, within(1, 3), None, across(0, true)],
                        (true, _) => [None, across(1, true), None, within(0, 1)],
                        (false, _) => [
                            across(k, true),
                            within((k + 1) % n, 2),
                            within((k + n - 1) % n, 1),
                            across((k + n - 1) % n, false),
                        ],
                    },
                });
            }
        }
        PiecewiseSurface { pieces, positions: self.mesh.nodes().to_vec() }
    }

    /// Height of side `i` over the plane of the touch of `part`, and how near to the place of the
    /// touch and how far from it the side comes in this plane: of its nodes, and of the disc around
    /// them \[m\].
    fn extent_about(&self, i: usize, part: &TouchedPart) -> (f64, [f64; 2]) {
        let (origin, outward) = (Vector3::from(part.origin), Vector3::from(part.outward));
        let nodes = || self.sides()[i].nodes.iter().map(|&n| Vector3::from(self.mesh.nodes()[n as usize]));
        let height = nodes().map(|x| (x - origin).dot(&outward)).fold(f64::NEG_INFINITY, f64::max);
        let centre = nodes().sum::<Vector3<f64>>() / self.sides()[i].nodes.len() as f64;
        let half = nodes().map(|x| (x - centre).norm()).fold(0.0, f64::max);
        let across = centre - origin;
        let away = (across - outward * across.dot(&outward)).norm();
        (height, [(away - half).max(0.0), away + half])
    }

    /// The sides with a node in `part`, but for what a disc around them is larger, and those at its place, whose nodes may
    /// all lie deeper.
    pub fn sides_in(&self, part: &TouchedPart) -> Vec<u32> {
        let here = self.nearest(&part.origin).map_or_else(Vec::new, |foot| self.sides_at(&foot.place));
        let is_in = |i: &u32| {
            let (height, [near, _]) = self.extent_about(*i as usize, part);
            height >= -part.depth && near <= part.radius || here.iter().any(|at| at.face == *i)
        };
        (0..self.sides().len() as u32).filter(is_in).collect()
    }

    /// Nodes and points of side `i`.
    pub fn places_on(&self, i: usize) -> Vec<[f64; 3]> {
        let of = &self.sides()[i];
        let nodes = of.nodes.iter().map(|&n| self.mesh.nodes()[n as usize]);
        nodes.chain(of.kind.rule().into_iter().map(|p| self.at(i, &p.xi).position)).collect()
    }

    /// Parameters of `point` on `side`, by Newton's method; `None` if it does not lie there.
    fn parameters(&self, side: usize, point: &[f64; 3]) -> Option<[f64; 2]> {
        let limit = SAME_POINT * self.longest_edge(side);
        let ends = self.sides()[side].kind.node_parameters();
        let middle = |d: usize| ends.iter().map(|eta| eta[d]).sum::<f64>() / ends.len() as f64;
        let mut eta = [middle(0), middle(1)];
        for _ in 0..NEWTON_STEPS {
            let at = self.at(side, &eta);
            let miss = Vector3::from(*point) - Vector3::from(at.position);
            let [a, b] = at.tangents.map(Vector3::from);
            let matrix = Matrix2::new(a.dot(&a), a.dot(&b), a.dot(&b), b.dot(&b));
            let step = matrix.try_inverse()? * Vector2::new(a.dot(&miss), b.dot(&miss));
            eta = [eta[0] + step[0], eta[1] + step[1]];
            // A place within SAME_POINT may still be beside the side by more than that.
            if step.norm() <= SETTLED {
                return (miss.norm() <= limit).then_some(eta);
            }
        }
        None
    }

    /// The places of `place` on all sides that hold it, by number of the side.
    pub fn sides_at(&self, place: &SurfacePlace) -> Vec<SurfacePlace> {
        let own = &self.sides()[place.face as usize].nodes;
        let mut beside: Vec<u32> = own.iter().flat_map(|&n| self.at_node(n).iter().copied()).collect();
        beside.sort_unstable();
        beside.dedup();
        let there = beside.into_iter().filter_map(|face| {
            if face == place.face {
                return Some(*place);
            }
            let eta = self.parameters(face as usize, &place.point)?;
            is_inside(&self.sides()[face as usize], &eta).then_some(SurfacePlace {
                face,
                xi: [eta[0], eta[1], 0.0],
                ..*place
            })
        });
        there.collect()
    }

    /// `places` in groups: sides of one group go on smoothly in each other.
    pub fn smooth_groups(&self, places: &[SurfacePlace]) -> Vec<Vec<SurfacePlace>> {
        let mut groups: Vec<Vec<SurfacePlace>> = Vec::new();
        for place in places {
            let goes_on = |other: &SurfacePlace| {
                self.neighbours(place.face as usize).any(|n| n.is_smooth && n.side == other.face)
            };
            let (mut joined, apart): (Vec<_>, Vec<_>) =
                groups.into_iter().partition(|group: &Vec<SurfacePlace>| group.iter().any(goes_on));
            groups = apart;
            let mut group = vec![*place];
            joined.iter_mut().for_each(|other| group.append(other));
            groups.push(group);
        }
        groups
    }

    /// The first side of the smooth part that side `i` belongs to among those at node `n`.
    pub fn part_at(&self, n: u32, i: u32) -> u32 {
        let there = self.at_node(n);
        let (mut part, mut next) = (vec![i], 0);
        while let Some(&side) = part.get(next) {
            let others = self.neighbours(side as usize).filter(|other| other.is_smooth);
            for other in others.map(|other| other.side).filter(|other| there.contains(other)) {
                if !part.contains(&other) {
                    part.push(other);
                }
            }
            next += 1;
        }
        part.into_iter().min().unwrap_or(i)
    }

    /// Mean of the unit normals of a group of places.
    pub fn mean_normal(&self, group: &[SurfacePlace]) -> Option<Vector3<f64>> {
        let sum: Vector3<f64> = group.iter().map(|place| self.normal(place)).sum();
        sum.try_normalize(0.0)
    }
}

/// Whether parameters lie on a side, but for round-off of a search.
fn is_inside(side: &SurfaceSide, [x, y]: &[f64; 2]) -> bool {
    let beyond =
        if side.n_edges() == 3 { (-x).max(-y).max(x + y - 1.0) } else { (x.abs() - 1.0).max(y.abs() - 1.0) };
    beyond <= SAME_POINT
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

impl Surface for MeshSurface {
    fn motion(&self) -> RigidMotion {
        rigid_motion(self.mesh.model())
    }

    fn points(&self) -> Box<dyn Iterator<Item = &[f64; 3]> + '_> {
        Box::new(self.mesh.nodes().iter())
    }

    fn length(&self) -> f64 {
        self.mesh.size()
    }

    fn n_faces(&self) -> usize {
        self.sides().len()
    }

    fn place(&self, face: u32, xi: &[f64; 3]) -> SurfacePlace {
        let is_curve = self.sides()[face as usize].kind.is_curve();
        let xi = [xi[0], if is_curve { 0.0 } else { xi[1] }, 0.0];
        SurfacePlace { face, xi, point: self.at(face as usize, &[xi[0], xi[1]]).position }
    }

    /// Widths on meshes are along principal directions of the surface, which do not depend on the
    /// side.
    fn share_directions(&self, _: [u32; 2]) -> bool {
        true
    }

    fn search_model(&self) -> Result<SurfaceModel, ContactError> {
        let none = Mat::<f64>::zeros(0, 0);
        SurfaceModel::of_pieces(self.motion(), &self.pieces(), &DofLookup::new(&[]), none.as_ref())
    }

    fn nearest(&self, point: &[f64; 3]) -> Option<Foot> {
        let search = self.search.get_or_init(|| SurfaceSearch::new(&self.mesh));
        let found = search.nearest(&self.mesh, point)?;
        let face = self.mesh.surface().binary_search(&found.face).ok()? as u32;
        let place = SurfacePlace { face, xi: [found.eta[0], found.eta[1], 0.0], point: found.point };
        Some(Foot { place, normal: self.normal(&place), distance: found.distance })
    }

    /// At a node or an edge the place is given on the side that is turned to the plane.
    fn lowest(&self, direction: &Vector3<f64>) -> Option<SurfacePlace> {
        let direction_in_space = self.motion().in_space(direction.as_ref());
        let plane = Plane { point: Vector3::zeros(), normal: Unit::try_new(direction_in_space, 0.0)? };
        let (model, mut workspace) = (self.search_model().ok()?, SearchWorkspace::new());
        let found = plane_distance(&model, &BodyState::at_rest(0), &plane, &mut workspace).ok()?;
        Some(self.turned_to(&self.place(found.site.face, &found.site.xi), &-direction))
    }

    fn normal(&self, place: &SurfacePlace) -> Vector3<f64> {
        let [u, v, _] = place.xi;
        let area = Vector3::from(self.at(place.face as usize, &[u, v]).area);
        area.try_normalize(0.0).unwrap_or_else(Vector3::zeros)
    }

    fn normals_at(&self, point: &[f64; 3]) -> Vec<Vector3<f64>> {
        let Some(foot) = self.nearest(point) else { return Vec::new() };
        let groups = self.smooth_groups(&self.sides_at(&foot.place));
        groups.iter().filter_map(|group| self.mean_normal(group)).collect()
    }

    fn smooth_cosine(&self) -> f64 {
        CREASE.to_radians().cos()
    }

    /// The curvatures of the plane, sphere, cylinder or cone on which the nodes around lie, else of the paraboloid that
    /// fits them by least squares, since second
    /// derivatives of a single side are right to its first order only. `None` if the nodes lie on a
    /// line, or the side has no normal.
    fn shape_at(&self, place: &SurfacePlace) -> Option<LocalShape> {
        let centre = Vector3::from(place.point);
        let at = self.at(place.face as usize, &[place.xi[0], place.xi[1]]);
        if self.mesh.model().dimension() == 2 {
            return self.shape_of_curve(place, &at);
        }
        let normal = Vector3::from(at.area).try_normalize(0.0)?;
        let along = Vector3::from(at.tangents[0]).try_normalize(0.0)?;
        if let Some(shape) = self.primitive_at(place).and_then(|(of, _)| of.shape(&centre, &along)) {
            return Some(shape);
        }
        let (t, s) = (along, normal.cross(&along));
        let places = self.around(place, FITTED);
        let size = places.iter().map(|x| (x - centre).norm()).fold(0.0, f64::max);
        // Coordinates as long as the chord, on which a circle is a parabola; nearer nodes count more (theory Eq. C.112).
        let row = |x: &Vector3<f64>| {
            let r = (x - centre) / size;
            let (u, v, weight) = (r.dot(&t), r.dot(&s), (1.0 - r.norm_squared() / 1.1).powi(2));
            let chord = if u == 0.0 && v == 0.0 { 1.0 } else { r.norm() / u.hypot(v) };
            let (u, v) = (u * chord, v * chord);
            [1.0, u, v, 0.5 * u * u, u * v, 0.5 * v * v, r.dot(&normal)].map(|term| weight * term)
        };
        let rows: Vec<_> = places.iter().map(row).collect();
        let matrix = DMatrix::from_fn(rows.len(), 6, |i, j| rows[i][j]);
        let heights = DVector::from_fn(rows.len(), |i, _| rows[i][6]);
        // With a worse condition the nodes do not determine the six unknowns.
        let fit = matrix.svd(true, true).solve(&heights, 1e-10).ok()?;
        // Slopes against the tangent plane are small here; their squares are left out.
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

    fn primitive_at(&self, place: &SurfacePlace) -> Option<(Primitive, f64)> {
        Some((self.primitive_around(place, FITTED)?, self.length_at(place)))
    }

    fn turned_to(&self, place: &SurfacePlace, direction: &Vector3<f64>) -> SurfacePlace {
        // Of equally near normals the first side.
        let best = self.sides_at(place).into_iter().fold(None, |best: Option<(f64, SurfacePlace)>, place| {
            let cosine = self.normal(&place).dot(direction);
            match best {
                Some((most, _)) if cosine <= most + ALIKE => best,
                _ => Some((cosine, place)),
            }
        });
        best.map_or(*place, |(_, place)| place)
    }

    /// The sides in the plane that are smoothly connected with one at the point are a flat face if
    /// they are bounded by edges of the part all around, or if a node lies in their midst, which is
    /// not so for a single side of a round part.
    fn flat_face(&self, point: &[f64; 3], outward: &Vector3<f64>, parallel: f64) -> Vec<[f64; 3]> {
        let Some(foot) = self.nearest(point) else { return Vec::new() };
        let reach = (self as &dyn Surface).reach();
        let most = (parallel + SAME_PLANE) * reach;
        let height = |x: &[f64; 3]| (Vector3::from(*x) - Vector3::from(*point)).dot(outward).abs();
        let is_in_plane = |i: usize| self.places_on(i).iter().all(|x| height(x) <= most);
        let own = self.sides_at(&foot.place).into_iter();
        let mut candidates = own.filter(|place| self.normal(place).dot(outward) > 0.5);
        let found = candidates.find_map(|place| {
            let side = place.face as usize;
            if !is_in_plane(side) {
                return None;
            }
            let face: HashSet<u32> = self.smooth_part(side, is_in_plane).into_iter().collect();
            let ends_at_edges = || {
                let beyond = face.iter().flat_map(|i| self.neighbours(*i as usize));
                beyond.filter(|n| !face.contains(&n.side)).all(|n| !n.is_smooth)
            };
            let is_within = |n: &u32| self.at_node(*n).iter().all(|i| face.contains(i));
            let nodes = || {
                face.iter().flat_map(|i| {
                    let side = &self.sides()[*i as usize];
                    side.nodes[..side.n_edges()].iter()
                })
            };
            (ends_at_edges() || nodes().any(is_within)).then_some(face)
        });
        found.into_iter().flatten().flat_map(|i| self.places_on(i as usize)).collect()
    }

    fn lines_through(&self, point: &[f64; 3]) -> Vec<StraightLine> {
        self.straight_lines(point)
    }

    fn spread(&self, part: &TouchedPart) -> f64 {
        let extents = (0..self.sides().len()).map(|i| self.extent_about(i, part));
        extents.filter(|(height, _)| *height >= -part.depth).map(|(_, [_, far])| far).fold(0.0, f64::max)
    }

    fn along_edges(&self, point: &[f64; 3], length: f64) -> Vec<Vector3<f64>> {
        self.places_of_edges(point, length)
    }
}
