//! The surface of a body: sides of its cells that no other cell has.

use std::collections::HashMap;

use nalgebra::Vector3;

use crate::postprocessing::vtk::grid::Grid;

/// Part of the size of a body within which points are one.
const SAME: f64 = 1e-6;

/// A surface whose vertices are points of a grid.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Surface {
    /// For each vertex the points of the grid that lie there, one or more.
    sources: Vec<Vec<u32>>,
    /// Corners of the triangles, or ends of the lines of a section that is revolved.
    pub parts: Vec<u32>,
    /// Corners of a part: three, or two of a line.
    pub corners: usize,
}

/// Rings of corners and middles of edges of a kind of cell.
struct CellKind {
    rings: &'static [&'static [usize]],
    edges: &'static [(usize, usize, usize)],
}

const TETRAHEDRON: &[&[usize]] = &[&[0, 2, 1], &[0, 1, 3], &[1, 2, 3], &[2, 0, 3]];
const HEXAHEDRON: &[&[usize]] =
    &[&[0, 3, 2, 1], &[4, 5, 6, 7], &[0, 1, 5, 4], &[1, 2, 6, 5], &[2, 3, 7, 6], &[3, 0, 4, 7]];
const PYRAMID: &[&[usize]] = &[&[0, 3, 2, 1], &[0, 1, 4], &[1, 2, 4], &[2, 3, 4], &[3, 0, 4]];
const WEDGE: &[&[usize]] = &[&[0, 1, 2], &[3, 5, 4], &[0, 3, 4, 1], &[1, 4, 5, 2], &[2, 5, 3, 0]];
const TETRAHEDRON_EDGES: &[(usize, usize, usize)] =
    &[(0, 1, 4), (1, 2, 5), (0, 2, 6), (0, 3, 7), (1, 3, 8), (2, 3, 9)];
const HEXAHEDRON_EDGES: &[(usize, usize, usize)] = &[
    (0, 1, 8),
    (1, 2, 9),
    (2, 3, 10),
    (0, 3, 11),
    (4, 5, 12),
    (5, 6, 13),
    (6, 7, 14),
    (4, 7, 15),
    (0, 4, 16),
    (1, 5, 17),
    (2, 6, 18),
    (3, 7, 19),
];
const PYRAMID_EDGES: &[(usize, usize, usize)] =
    &[(0, 1, 5), (1, 2, 6), (2, 3, 7), (0, 3, 8), (0, 4, 9), (1, 4, 10), (2, 4, 11), (3, 4, 12)];
const WEDGE_EDGES: &[(usize, usize, usize)] =
    &[(0, 1, 6), (1, 2, 7), (0, 2, 8), (3, 4, 9), (4, 5, 10), (3, 5, 11), (0, 3, 12), (1, 4, 13), (2, 5, 14)];

/// Sides of VTK's cell type `kind`; none of those that have no volume.
fn cell_kind(kind: u8) -> Option<CellKind> {
    let (rings, edges): (_, &'static [_]) = match kind {
        10 => (TETRAHEDRON, &[]),
        12 => (HEXAHEDRON, &[]),
        13 => (WEDGE, &[]),
        14 => (PYRAMID, &[]),
        24 => (TETRAHEDRON, TETRAHEDRON_EDGES),
        25 | 29 => (HEXAHEDRON, HEXAHEDRON_EDGES),
        26 | 32 => (WEDGE, WEDGE_EDGES),
        27 => (PYRAMID, PYRAMID_EDGES),
        _ => return None,
    };
    Some(CellKind { rings, edges })
}

impl Surface {
    /// The surface of `grid`, its points as the undeformed body has them; with `is_revolved` the
    /// lines around a section that do not lie on the axis z.
    pub fn new(grid: &Grid, is_revolved: bool) -> Self {
        let (vertex_of, n) = merged(&grid.points);
        let mut sides =
            Sides { points: &grid.points, vertex_of: &vertex_of, found: HashMap::new(), order: 0 };
        let mut start = 0;
        for (&end, &kind) in grid.offsets.iter().zip(&grid.types) {
            let end = usize::try_from(end).unwrap_or(start);
            let nodes: Vec<usize> =
                grid.connectivity[start..end].iter().filter_map(|n| usize::try_from(*n).ok()).collect();
            start = end;
            match cell_kind(kind) {
                Some(kind) => sides.add_volume(&nodes, &kind),
                None if is_revolved => sides.add_section(&around(kind, nodes)),
                None => sides.add_flat(&around(kind, nodes)),
            }
        }
        let parts = sides.outer();
        numbered(&parts, (&vertex_of, n), if is_revolved { 2 } else { 3 })
    }

    /// The points that the vertices are made of, rising, and the surface with points numbered as there.
    pub fn gathered(&self) -> (Vec<u32>, Self) {
        let mut points: Vec<u32> = self.sources.iter().flatten().copied().collect();
        points.sort_unstable();
        points.dedup();
        let number = |point: &u32| points.partition_point(|p| p < point) as u32;
        let sources = self.sources.iter().map(|of| of.iter().map(number).collect()).collect();
        let gathered = Self { sources, ..self.clone() };
        (points, gathered)
    }

    /// Number of vertices.
    pub fn len(&self) -> usize {
        self.sources.len()
    }

    /// Whether there is nothing to be seen.
    pub fn is_empty(&self) -> bool {
        self.parts.is_empty()
    }

    /// Values at the vertices, means of those of their points.
    pub fn at_vertices<const N: usize>(&self, values: &[[f64; N]]) -> Vec<[f64; N]> {
        let mean = |points: &Vec<u32>| {
            let mut sum = [0.0; N];
            for &point in points {
                sum.iter_mut().zip(&values[point as usize]).for_each(|(s, x)| *s += x);
            }
            sum.map(|s| s / points.len() as f64)
        };
        self.sources.iter().map(mean).collect()
    }
}

/// Corners and middles of edges of a cell of VTK's type `kind` without volume, in their order around it.
fn around(kind: u8, nodes: Vec<usize>) -> Vec<usize> {
    let n = match kind {
        22 => 3,
        23 | 28 => 4,
        _ => return nodes,
    };
    (0..n).flat_map(|i| [nodes[i], nodes[n + i]]).collect()
}

/// Sides of cells, each with its corners in order, as long as only one cell has it.
struct Sides<'a> {
    points: &'a [[f64; 3]],
    vertex_of: &'a [u32],
    /// By sorted corners: the parts that it is cut into, when it came; no parts once a second cell
    /// has it.
    found: HashMap<Vec<u32>, (usize, Vec<u32>)>,
    order: usize,
}

impl Sides<'_> {
    fn add_volume(&mut self, nodes: &[usize], kind: &CellKind) {
        let centre = self.centre(nodes);
        for ring in kind.rings {
            let middle = |i: usize| {
                let (a, b) = (ring[i], ring[(i + 1) % ring.len()]);
                let edge = kind.edges.iter().find(|(p, q, _)| (*p, *q) == (a, b) || (*p, *q) == (b, a));
                edge.and_then(|(_, _, m)| nodes.get(*m)).map(|n| self.vertex_of[*n])
            };
            let corners: Vec<u32> = ring.iter().map(|c| self.vertex_of[nodes[*c]]).collect();
            let middles: Option<Vec<u32>> = (0..ring.len()).map(middle).collect();
            let mut triangles = match middles {
                Some(middles) => with_middles(&corners, &middles),
                None => fan(&corners),
            };
            let places: Vec<usize> = ring.iter().map(|c| nodes[*c]).collect();
            let p: Vec<Vector3<f64>> = places.iter().map(|i| Vector3::from(self.points[*i])).collect();
            let normal = (p[1] - p[0]).cross(&(p[2] - p[0])) + (p[2] - p[0]).cross(&(p[p.len() - 1] - p[0]));
            if normal.dot(&(self.centre(&places) - centre)) < 0.0 {
                triangles.as_chunks_mut::<3>().0.iter_mut().for_each(|t| t.swap(1, 2));
            }
            self.add(corners, triangles);
        }
    }

    /// The lines around a cell of a section.
    fn add_section(&mut self, nodes: &[usize]) {
        let size = nodes.iter().fold(0.0_f64, |most, n| most.max(self.points[*n][0].abs()));
        for i in 0..nodes.len() {
            let ends = [nodes[i], nodes[(i + 1) % nodes.len()]];
            if ends.iter().any(|n| self.points[*n][0].abs() > SAME * size) {
                let line = ends.map(|n| self.vertex_of[n]).to_vec();
                self.add(line.clone(), line);
            }
        }
    }

    /// A cell that is a surface itself.
    fn add_flat(&mut self, nodes: &[usize]) {
        let corners: Vec<u32> = nodes.iter().map(|n| self.vertex_of[*n]).collect();
        let triangles = fan(&corners);
        self.add(corners, triangles);
    }

    fn add(&mut self, mut corners: Vec<u32>, parts: Vec<u32>) {
        corners.sort_unstable();
        corners.dedup();
        self.order += 1;
        let order = self.order;
        self.found.entry(corners).and_modify(|(_, parts)| parts.clear()).or_insert((order, parts));
    }

    /// Parts of the sides that one cell has, in the order of the cells.
    fn outer(self) -> Vec<u32> {
        let mut all: Vec<(usize, Vec<u32>)> = self.found.into_values().collect();
        all.sort_unstable_by_key(|(order, _)| *order);
        all.into_iter().flat_map(|(_, parts)| parts).collect()
    }

    fn centre(&self, nodes: &[usize]) -> Vector3<f64> {
        let sum = nodes.iter().fold(Vector3::zeros(), |sum, n| sum + Vector3::from(self.points[*n]));
        sum / nodes.len().max(1) as f64
    }
}

/// Triangles from the first corner.
fn fan(corners: &[u32]) -> Vec<u32> {
    (2..corners.len()).flat_map(|i| [corners[0], corners[i - 1], corners[i]]).collect()
}

/// Triangles at the corners, and those between the middles of the edges.
fn with_middles(corners: &[u32], middles: &[u32]) -> Vec<u32> {
    let n = corners.len();
    let at_corner = |i: usize| [corners[i], middles[i], middles[(i + n - 1) % n]];
    (0..n).flat_map(at_corner).chain(fan(middles)).collect()
}

/// The surface of `parts`, its vertices in the order in which they are met; parts without extent
/// are left out.
fn numbered(parts: &[u32], (vertex_of, n): (&[u32], usize), corners: usize) -> Surface {
    let mut number = vec![u32::MAX; n];
    let mut kept = Vec::with_capacity(parts.len());
    let mut used = 0;
    for part in parts.chunks_exact(corners) {
        let has_extent = (0..corners).all(|i| !part[..i].contains(&part[i]));
        for &vertex in part.iter().filter(|_| has_extent) {
            let slot = &mut number[vertex as usize];
            if *slot == u32::MAX {
                *slot = used;
                used += 1;
            }
            kept.push(*slot);
        }
    }
    let mut sources = vec![Vec::new(); used as usize];
    for (point, &vertex) in vertex_of.iter().enumerate() {
        if let Some(points) = sources.get_mut(number[vertex as usize] as usize) {
            points.push(point as u32);
        }
    }
    Surface { sources, parts: kept, corners }
}

/// For each point the number of its vertex, and how many there are: points that lie within
/// round-off are one.
fn merged(points: &[[f64; 3]]) -> (Vec<u32>, usize) {
    let all = || points.iter().map(|p| Vector3::from(*p));
    let none = (Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY));
    let (low, high) = all().fold(none, |(low, high), p| (low.inf(&p), high.sup(&p)));
    let size = (high - low).norm();
    let step = if size.is_finite() && size > 0.0 { SAME * size } else { 1.0 };
    let mut cells: HashMap<[i64; 3], u32> = HashMap::new();
    let mut vertex_of = Vec::with_capacity(points.len());
    let mut n = 0;
    for p in all() {
        let cell: [i64; 3] = std::array::from_fn(|c| (p[c] / step).floor() as i64);
        let near = |k: i64| {
            let offset = [k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1];
            cells.get(&std::array::from_fn(|c| cell[c].saturating_add(offset[c]))).copied()
        };
        let vertex = (0..27).find_map(near).unwrap_or_else(|| {
            n += 1;
            n - 1
        });
        cells.entry(cell).or_insert(vertex);
        vertex_of.push(vertex);
    }
    (vertex_of, n as usize)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two cubes side by side, each with points of its own.
    fn cubes() -> Grid {
        let mut grid = Grid::default();
        for shift in [0.0, 1.0] {
            let first = grid.points.len();
            let corners =
                [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]];
            // Round-off, as neighbours have it.
            grid.points.extend(corners.map(|c: [i32; 3]| {
                [f64::from(c[0]) + shift + 1e-15, f64::from(c[1]) - shift * 1e-15, f64::from(c[2])]
            }));
            grid.add_cell(12, first, &[0, 1, 2, 3, 4, 5, 6, 7]);
        }
        grid
    }

    /// Volume by the outward surface: the divergence theorem.
    fn enclosed(surface: &Surface, grid: &Grid) -> f64 {
        let points = surface.at_vertices(&grid.points);
        let parts = surface.parts.as_chunks::<3>().0.iter().map(|t| {
            let [a, b, c] = t.map(|i| Vector3::from(points[i as usize]));
            a.dot(&b.cross(&c)) / 6.0
        });
        parts.sum()
    }

    #[test]
    fn sides_between_cells_are_left_out_and_the_others_face_outwards() {
        let grid = cubes();
        let surface = Surface::new(&grid, false);
        assert_eq!((surface.len(), surface.parts.len()), (12, 3 * 20));
        let volume = enclosed(&surface, &grid);
        assert!((volume - 2.0).abs() < 1e-12, "{volume}");
    }

    /// A cube of six pyramids about its middle, with the middles of edges or without.
    #[test]
    fn pyramids_have_their_base_and_four_triangles() {
        let corners =
            [[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0], [0, 0, 2], [2, 0, 2], [2, 2, 2], [0, 2, 2]];
        for (kind, n_triangles) in [(14, 12), (27, 36)] {
            let mut grid = Grid::default();
            for ring in HEXAHEDRON {
                let mut places =
                    [ring[0], ring[3], ring[2], ring[1]].map(|c| corners[c].map(f64::from)).to_vec();
                places.push([1.0; 3]);
                if kind == 27 {
                    for (a, b, _) in PYRAMID_EDGES {
                        places.push([0, 1, 2].map(|d| 0.5 * (places[*a][d] + places[*b][d])));
                    }
                }
                let nodes: Vec<usize> = (0..places.len()).collect();
                let first = grid.points.len();
                grid.points.extend(places);
                grid.add_cell(kind, first, &nodes);
            }
            let surface = Surface::new(&grid, false);
            assert_eq!(surface.parts.len(), 3 * n_triangles);
            let volume = enclosed(&surface, &grid);
            assert!((volume - 8.0).abs() < 1e-12, "{volume}"); // round-off
        }
    }

    #[test]
    fn section_leaves_lines_off_the_axis() {
        let mut grid = Grid::default();
        grid.points.extend([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 0.0, 1.0], [0.0, 0.0, 1.0]]);
        grid.add_cell(9, 0, &[0, 1, 2, 3]);
        let surface = Surface::new(&grid, true);
        assert_eq!((surface.len(), surface.parts.len(), surface.corners), (4, 6, 2));
    }
}
