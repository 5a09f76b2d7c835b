//! The surface of a mesh as a whole: which sides meet at which edges, and where it is smooth.

use std::collections::{HashMap, VecDeque};

use crate::element::jacobian::{dot, minus, norm};
use crate::element::kind::SideKind;
use crate::fault::MeshFault;
use crate::locate::SidePoint;
use crate::mesh::Mesh;

/// Angle between sides at an edge beyond which it counts as an edge of the part \[degrees\]: facets
/// of a round part with at least 12 of them around, and curved sides with fewer, are smooth.
pub const CREASE: f64 = 31.0;

/// Area element at a point below which a side counts as flat there, as a share of that of a square
/// over its longest edge.
const FLAT: f64 = 1e-6;

/// The other side of an edge.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Neighbour {
    /// Side, an index into [`Mesh::surface`].
    pub side: u32,
    /// Its edge, from 0: that from corner `edge` to the next, of a curve this corner.
    pub edge: u8,
    /// Whether the surface is smooth there.
    pub is_smooth: bool,
}

/// A side of the surface.
#[derive(Debug, Clone, PartialEq)]
pub struct SurfaceSide {
    /// Its kind.
    pub kind: SideKind,
    /// Its nodes, right-handed about the outward normal.
    pub nodes: Vec<u32>,
    /// What lies beyond each edge; none where more than two sides meet.
    pub neighbours: [Option<Neighbour>; 4],
}

/// All sides of the surface with their neighbours.
#[derive(Debug, Clone, PartialEq)]
pub struct Surface {
    sides: Vec<SurfaceSide>,
}

impl SurfaceSide {
    /// Number of its edges.
    pub fn n_edges(&self) -> usize {
        self.kind.n_corners()
    }

    /// Nodes at the ends of edge `edge`; of a curve, whose edges are its ends, one node twice.
    pub fn edge_nodes(&self, edge: usize) -> [u32; 2] {
        self.kind.edge(edge).map(|corner| self.nodes[corner])
    }
}

impl Surface {
    /// The surface of `mesh`.
    pub fn new(mesh: &Mesh) -> Self {
        let side = |&face: &crate::mesh::boundary::Face| {
            let (kind, nodes) = mesh.face(face);
            SurfaceSide { kind, nodes, neighbours: [None; 4] }
        };
        let mut surface = Self { sides: mesh.surface().iter().map(side).collect() };
        let mut edges: HashMap<[u32; 2], Vec<(u32, u8)>> = HashMap::new();
        for (i, side) in surface.sides.iter().enumerate() {
            for e in 0..side.n_edges() {
                let mut ends = side.edge_nodes(e);
                ends.sort_unstable();
                edges.entry(ends).or_default().push((i as u32, e as u8));
            }
        }
        let limit = CREASE.to_radians().cos();
        for owners in edges.values() {
            let [a, b] = owners[..] else { continue };
            let [m, n] = [a, b].map(|(side, edge)| surface.edge_normal(mesh, side as usize, edge as usize));
            let is_smooth = dot(&m, &n) > limit * norm(&m) * norm(&n);
            for ((side, edge), (other, there)) in [(a, b), (b, a)] {
                surface.sides[side as usize].neighbours[edge as usize] =
                    Some(Neighbour { side: other, edge: there, is_smooth });
            }
        }
        surface
    }

    /// Outward normal of a side in the middle of an edge, times the area element.
    fn edge_normal(&self, mesh: &Mesh, side: usize, edge: usize) -> [f64; 3] {
        let SurfaceSide { kind, nodes, .. } = &self.sides[side];
        let (mut at, mut places) = (SidePoint::default(), Vec::new());
        mesh.places(nodes, &mut places);
        at.evaluate(*kind, &places, &kind.on_edge(edge, 0.5));
        at.area
    }

    /// The sides, in the order of [`Mesh::surface`].
    pub fn sides(&self) -> &[SurfaceSide] {
        &self.sides
    }

    /// The sides that are connected with `first` over smooth edges through sides of `is_wanted`,
    /// which `first` belongs to in any case; rising.
    pub fn smooth_part(&self, first: usize, is_wanted: impl Fn(usize) -> bool) -> Vec<u32> {
        let mut is_seen = vec![false; self.sides.len()];
        let mut waiting = VecDeque::from([first]);
        is_seen[first] = true;
        let mut found = Vec::new();
        while let Some(side) = waiting.pop_front() {
            found.push(side as u32);
            for other in self.sides[side].neighbours.iter().flatten().filter(|n| n.is_smooth) {
                let k = other.side as usize;
                if !is_seen[k] && is_wanted(k) {
                    is_seen[k] = true;
                    waiting.push_back(k);
                }
            }
        }
        found.sort_unstable();
        found
    }

    /// Longest edge of side `i` of `mesh`, between its corners \[m\].
    pub fn longest_edge(&self, mesh: &Mesh, i: usize) -> f64 {
        let side = &self.sides[i];
        let (n, at) = (side.n_edges(), |k: usize| &mesh.nodes()[side.nodes[k] as usize]);
        (0..n).map(|k| norm(&minus(at(k), at((k + 1) % n)))).fold(0.0, f64::max)
    }

    /// Checks that side `i` has a normal at its points and corners.
    ///
    /// # Errors
    /// [`MeshFault::FlatSide`].
    pub fn check_side(&self, mesh: &Mesh, i: usize) -> Result<(), MeshFault> {
        let side = &self.sides[i];
        let (mut at, mut places) = (SidePoint::default(), Vec::new());
        mesh.places(&side.nodes, &mut places);
        let length = self.longest_edge(mesh, i);
        // Of quadrilaterals and curves the parameters have the width two.
        let whole = match side.n_edges() {
            2 => 0.5 * length,
            3 => length * length,
            _ => 0.25 * length * length,
        };
        let corners = side.kind.node_parameters();
        let points = side.kind.rule();
        let points = points.iter().map(|p| p.xi).chain(corners[..side.n_edges()].iter().copied());
        for eta in points {
            at.evaluate(side.kind, &places, &eta);
            let share = norm(&at.area) / whole;
            // Asked this way round, a NaN is refused.
            let has_area = share > FLAT;
            if !has_area {
                let element = mesh.elements().get(mesh.surface()[i].element as usize);
                return Err(MeshFault::FlatSide { element: element.label, point: at.position });
            }
        }
        Ok(())
    }
}
