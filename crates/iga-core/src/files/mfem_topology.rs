//! The mesh of patches in MFEM's files, and the numbers that it gives to the functions of the whole
//! body: those of vertices first, then of edges, faces and insides.
//!
//! The functions of an edge run from its vertex with the smaller number to the other; those of a
//! face as the first patch lists the face's vertices, from the first to the second fastest, then
//! from the first to the last.

use std::collections::BTreeMap;

use super::fault::{ReadError, ReadFault};
use super::words::Words;
use crate::nurbs::FaceId;
use crate::splines::knots::KnotVector;
use crate::splines::tensor;

/// Names of the directions of a patch.
const DIRECTIONS: [&str; 3] = ["xi", "eta", "zeta"];
/// Corners of a solid patch in the order of its vertices.
const SOLID: [[usize; 3]; 8] =
    [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]];
/// Corners of a plane patch in the order of its vertices.
const PLANE: [[usize; 2]; 4] = [[0, 0], [1, 0], [1, 1], [0, 1]];
/// Edges of a solid patch, between its vertices.
const SOLID_EDGES: [[usize; 2]; 12] =
    [[0, 1], [1, 2], [3, 2], [0, 3], [4, 5], [5, 6], [7, 6], [4, 7], [0, 4], [1, 5], [2, 6], [3, 7]];
/// Edges of a plane patch.
const PLANE_EDGES: [[usize; 2]; 4] = [[0, 1], [1, 2], [2, 3], [3, 0]];
/// Faces of a solid patch.
const FACES: [[usize; 4]; 6] =
    [[3, 2, 1, 0], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7], [4, 5, 6, 7]];

/// Corners of a patch in the order of its vertices, as ends 0 and 1 of each direction.
pub fn corners(dimension: usize) -> Vec<&'static [usize]> {
    if dimension == 3 {
        SOLID.iter().map(<[usize; 3]>::as_slice).collect()
    } else {
        PLANE.iter().map(<[usize; 2]>::as_slice).collect()
    }
}

/// Places among the vertices of a patch of those of a face, in MFEM's order, which turns about the
/// outward normal.
pub fn face_corners(dimension: usize, direction: usize, upper: bool) -> Vec<usize> {
    let all = corners(dimension);
    let on_face = |&c: &usize| all[c][direction] == usize::from(upper);
    if dimension == 3 {
        let face = FACES.iter().find(|face| face.iter().all(on_face));
        face.map(|f| f.to_vec()).unwrap_or_default()
    } else {
        let edge = PLANE_EDGES.iter().find(|edge| edge.iter().all(on_face));
        edge.map(|e| e.to_vec()).unwrap_or_default()
    }
}

/// Patches and the vertices between them.
pub struct Topology {
    /// Directions of a patch.
    pub dimension: usize,
    /// Vertices of each patch.
    vertices: Vec<Vec<usize>>,
    /// Knot vector of every edge as given, with the vertices from which and to which it runs.
    edges: Vec<(usize, [usize; 2])>,
    /// Elements of the boundary: attribute, and vertices, rising, of plane models behind two that
    /// are zero.
    boundary: Vec<(i64, [usize; 4])>,
}

/// Numbers of functions.
pub struct Numbering {
    /// How many there are.
    pub n: usize,
    /// For each patch, the number of the function of every entry of its net.
    pub patches: Vec<Vec<usize>>,
}

impl Topology {
    /// Reads from the dimension to the number of vertices.
    pub fn read(words: &mut Words) -> Result<Self, ReadError> {
        words.keyword("dimension")?;
        let dimension: usize = words.number("a dimension")?;
        if !(2..=3).contains(&dimension) {
            let remedy = "a body has patches of three directions, a plane model of two";
            return words
                .fail(ReadFault::Unsupported { what: format!("a mesh of {dimension} directions"), remedy });
        }
        words.keyword("elements")?;
        "the elements".clone_into(&mut words.section);
        let (kind, n_vertices) = if dimension == 3 { (5, 8) } else { (3, 4) };
        let mut vertices = Vec::new();
        for i in 0..words.count()? {
            let (_, found): (i64, usize) =
                (words.number("an attribute")?, words.number("a kind of element")?);
            if found != kind {
                let what = format!("element {i} of kind {found}");
                let remedy = "patches are cubes (kind 5), of plane models squares (kind 3)";
                return words.fail(ReadFault::Unsupported { what, remedy });
            }
            let own: Vec<usize> =
                (0..n_vertices).map(|_| words.number("a vertex")).collect::<Result<_, _>>()?;
            if own.iter().enumerate().any(|(k, v)| own[..k].contains(v)) {
                let what = format!("element {i}, which has a vertex twice,");
                return words.fail(ReadFault::Unsupported { what, remedy: "cut the patch in two" });
            }
            vertices.push(own);
        }
        words.keyword("boundary")?;
        "the boundary".clone_into(&mut words.section);
        let mut boundary = Vec::new();
        for _ in 0..words.count()? {
            let (attribute, _): (i64, usize) =
                (words.number("an attribute")?, words.number("a kind of element")?);
            let mut own = [0; 4];
            for vertex in &mut own[4 - n_vertices / 2..] {
                *vertex = words.number("a vertex")?;
            }
            own[4 - n_vertices / 2..].sort_unstable();
            boundary.push((attribute, own));
        }
        words.keyword("edges")?;
        "the edges".clone_into(&mut words.section);
        let mut edges = Vec::new();
        for _ in 0..words.count()? {
            let knots = words.number("a knot vector")?;
            edges.push((knots, [words.number("a vertex")?, words.number("a vertex")?]));
        }
        words.keyword("vertices")?;
        "the vertices".clone_into(&mut words.section);
        let n: usize = words.number("a count")?;
        let named = vertices.iter().flatten().chain(edges.iter().flat_map(|(_, v)| v));
        if let Some(v) = named.into_iter().find(|v| **v >= n) {
            let user = "an element or edge".to_owned();
            return words.fail(ReadFault::Unknown { user, what: "vertex", number: v.to_string() });
        }
        Ok(Self { dimension, vertices, edges, boundary })
    }

    /// The faces of each attribute of the boundary, which is their name; elements of it that are no
    /// single face of a patch are noted.
    pub fn boundary_faces(&self, notes: &mut Vec<String>) -> Vec<(String, Vec<FaceId>)> {
        let mut by_vertices: BTreeMap<Vec<usize>, Vec<FaceId>> = BTreeMap::new();
        for (id, key) in self.faces() {
            by_vertices.entry(key).or_default().push(id);
        }
        let (mut found, mut lost): (BTreeMap<i64, Vec<FaceId>>, usize) = (BTreeMap::new(), 0);
        for (attribute, vertices) in &self.boundary {
            let own = &vertices[4 - (1 << (self.dimension - 1))..];
            match by_vertices.get(own).map(Vec::as_slice) {
                Some([face]) => found.entry(*attribute).or_default().push(*face),
                _ => lost += 1,
            }
        }
        if lost > 0 {
            let all = self.boundary.len();
            notes.push(format!(
                "left out: {lost} of {all} elements of the boundary, which are no face of one patch alone"
            ));
        }
        found.into_iter().map(|(attribute, faces)| (attribute.to_string(), faces)).collect()
    }

    /// All faces with their vertices, rising.
    fn faces(&self) -> impl Iterator<Item = (FaceId, Vec<usize>)> {
        let ends = (0..self.dimension).flat_map(|direction| [false, true].map(|upper| (direction, upper)));
        let ends: Vec<(usize, bool)> = ends.collect();
        self.vertices.iter().enumerate().flat_map(move |(patch, vertices)| {
            let face = |&(direction, upper): &(usize, bool)| {
                let corners = face_corners(self.dimension, direction, upper);
                let mut key: Vec<usize> = corners.iter().map(|&c| vertices[c]).collect();
                key.sort_unstable();
                (FaceId { patch, direction, upper }, key)
            };
            ends.iter().map(face).collect::<Vec<_>>()
        })
    }

    /// Number of patches.
    pub fn n_patches(&self) -> usize {
        self.vertices.len()
    }

    /// Edges of a patch: its vertices in the sense of the direction along which they run, and that
    /// direction.
    fn patch_edges(&self) -> Vec<([usize; 2], usize)> {
        let all = corners(self.dimension);
        let edges: &[[usize; 2]] = if self.dimension == 3 { &SOLID_EDGES } else { &PLANE_EDGES };
        let along = |&[a, b]: &[usize; 2]| {
            let d = (0..self.dimension).find(|&d| all[a][d] != all[b][d]).unwrap_or(0);
            (if all[a][d] == 0 { [a, b] } else { [b, a] }, d)
        };
        edges.iter().map(along).collect()
    }

    /// Knot vectors of each patch in its directions, with at most `limit` knots in all: a short
    /// file can name a long vector often.
    pub fn patch_knots(&self, knots: &[KnotVector], limit: usize) -> Result<Vec<Vec<KnotVector>>, ReadFault> {
        let mut n_knots = 0usize;
        let by_vertices: BTreeMap<[usize; 2], (usize, [usize; 2])> =
            self.edges.iter().map(|&(k, v)| (sorted(v), (k, v))).collect();
        let mut patches = Vec::with_capacity(self.vertices.len());
        for (p, vertices) in self.vertices.iter().enumerate() {
            let mut own: Vec<Option<KnotVector>> = vec![None; self.dimension];
            for (ends, d) in self.patch_edges() {
                let ends = ends.map(|c| vertices[c]);
                let user = || format!("patch {p}");
                let Some(&(k, from)) = by_vertices.get(&sorted(ends)) else {
                    let number = format!("{} to {}", ends[0], ends[1]);
                    return Err(ReadFault::Unknown { user: user(), what: "the edge", number });
                };
                let Some(knots) = knots.get(k) else {
                    return Err(ReadFault::Unknown {
                        user: user(),
                        what: "knot vector",
                        number: k.to_string(),
                    });
                };
                let knots = if from == ends { knots.clone() } else { knots.reversed()? };
                let known = own[d].get_or_insert_with(|| knots.clone());
                let differs = |(a, b): (&f64, &f64)| (a - b).abs() > 1e-12 * (1.0 + a.abs()); // round-off of reversing
                if known.degree() != knots.degree()
                    || known.knots().len() != knots.knots().len()
                    || known.knots().iter().zip(knots.knots()).any(differs)
                {
                    return Err(ReadFault::Edges { patch: p, direction: DIRECTIONS[d] });
                }
            }
            let own: Vec<KnotVector> = own.into_iter().flatten().collect();
            n_knots = own.iter().map(|k| k.knots().len()).fold(n_knots, usize::saturating_add);
            if n_knots > limit {
                let what = format!("a mesh whose patches have more than {limit} knots in all");
                let remedy = "write the mesh in its form with patches";
                return Err(ReadFault::Unsupported { what, remedy });
            }
            patches.push(own);
        }
        Ok(patches)
    }

    /// Numbers of the functions of patches with nets of these sizes.
    pub fn numbering(&self, sizes: &[Vec<usize>]) -> Result<Numbering, ReadFault> {
        let all = corners(self.dimension);
        let mut next = self
            .vertices
            .iter()
            .flatten()
            .chain(self.edges.iter().flat_map(|(_, v)| v))
            .max()
            .map_or(0, |m| m + 1);
        let mut patches: Vec<Vec<usize>> =
            sizes.iter().map(|s| vec![usize::MAX; s.iter().product()]).collect();
        for (p, vertices) in self.vertices.iter().enumerate() {
            for (corner, vertex) in all.iter().zip(vertices) {
                let index: Vec<usize> = corner.iter().zip(&sizes[p]).map(|(c, n)| c * (n - 1)).collect();
                patches[p][tensor::flat_index(&sizes[p], &index)] = *vertex;
            }
        }
        // Edges are numbered as the file lists them.
        let mut edges: BTreeMap<[usize; 2], (usize, usize)> = BTreeMap::new();
        let lengths = self.edge_lengths(sizes)?;
        for (_, v) in &self.edges {
            let n = lengths.get(&sorted(*v)).copied().unwrap_or(2) - 2;
            edges.insert(sorted(*v), (next, n));
            next += n;
        }
        for (p, vertices) in self.vertices.iter().enumerate() {
            for ([a, b], d) in self.patch_edges() {
                let (start, n) = edges[&sorted([vertices[a], vertices[b]])];
                for i in 0..n {
                    let mut index: Vec<usize> =
                        all[a].iter().zip(&sizes[p]).map(|(c, n)| c * (n - 1)).collect();
                    index[d] = i + 1;
                    let place = if vertices[a] < vertices[b] { i } else { n - 1 - i };
                    patches[p][tensor::flat_index(&sizes[p], &index)] = start + place;
                }
            }
        }
        if self.dimension == 3 {
            self.number_faces(sizes, &mut patches, &mut next)?;
        }
        for (own, sizes) in patches.iter_mut().zip(sizes) {
            for (flat, number) in own.iter_mut().enumerate() {
                let index = tensor::multi_index(sizes, flat);
                if sizes.iter().zip(index).all(|(n, i)| i > 0 && i + 1 < *n) {
                    *number = next;
                    next += 1;
                }
            }
        }
        Ok(Numbering { n: next, patches })
    }

    /// Control points along every edge.
    fn edge_lengths(&self, sizes: &[Vec<usize>]) -> Result<BTreeMap<[usize; 2], usize>, ReadFault> {
        let mut lengths = BTreeMap::new();
        for (p, vertices) in self.vertices.iter().enumerate() {
            for ([a, b], d) in self.patch_edges() {
                let n = *lengths.entry(sorted([vertices[a], vertices[b]])).or_insert(sizes[p][d]);
                if n != sizes[p][d] {
                    return Err(ReadFault::Edges { patch: p, direction: DIRECTIONS[d] });
                }
            }
        }
        Ok(lengths)
    }

    fn number_faces(
        &self,
        sizes: &[Vec<usize>],
        patches: &mut [Vec<usize>],
        next: &mut usize,
    ) -> Result<(), ReadFault> {
        // Sorted vertices: the vertices as first listed, the first number, the counts along the
        // first side and along the last.
        let mut known: BTreeMap<[usize; 4], ([usize; 4], usize, [usize; 2])> = BTreeMap::new();
        for (p, vertices) in self.vertices.iter().enumerate() {
            for face in FACES {
                let own = face.map(|c| vertices[c]);
                let mut key = own;
                key.sort_unstable();
                // The corner of the patch at a vertex of the face.
                let corner = |v: usize| vertices.iter().position(|w| *w == v).map_or([0; 3], |c| SOLID[c]);
                let (base, start, counts) = known.get(&key).copied().unwrap_or((own, *next, [0; 2]));
                let (origin, first, last) = (corner(base[0]), corner(base[1]), corner(base[3]));
                let axis = |to: [usize; 3]| (0..3).find(|&d| origin[d] != to[d]).unwrap_or(0);
                let axes = [axis(first), axis(last)];
                let n = axes.map(|d| sizes[p][d] - 2);
                if counts != n && known.contains_key(&key) || axes[0] == axes[1] {
                    return Err(ReadFault::Edges { patch: p, direction: DIRECTIONS[axes[0]] });
                }
                if known.insert(key, (base, start, n)).is_none() {
                    *next += n[0] * n[1];
                }
                for flat in 0..n[0] * n[1] {
                    let mut index: [usize; 3] = std::array::from_fn(|d| origin[d] * (sizes[p][d] - 1));
                    for (d, i) in axes.into_iter().zip([flat % n[0], flat / n[0]]) {
                        index[d] = if origin[d] == 0 { i + 1 } else { sizes[p][d] - 2 - i };
                    }
                    patches[p][tensor::flat_index(&sizes[p], &index)] = start + flat;
                }
            }
        }
        Ok(())
    }

    /// Pairs of faces with the same vertices.
    pub fn joined(&self) -> Vec<[FaceId; 2]> {
        let mut first: BTreeMap<Vec<usize>, FaceId> = BTreeMap::new();
        let mut pairs = Vec::new();
        for (id, key) in self.faces() {
            match first.get(&key) {
                // A ring of two patches has two faces with the same vertices in one patch.
                Some(other) if other.patch != id.patch => pairs.push([*other, id]),
                _ => drop(first.insert(key, id)),
            }
        }
        pairs
    }
}

fn sorted([a, b]: [usize; 2]) -> [usize; 2] {
    [a.min(b), a.max(b)]
}
