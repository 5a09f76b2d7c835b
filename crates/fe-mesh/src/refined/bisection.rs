//! Tetrahedra halved at one edge after the other, the longest first (docs/theory.md Eq. C.110).
//!
//! All tetrahedra about an edge are halved with it, so that no node hangs. What counts as the length of an edge may
//! leave out a direction: pieces stay longer in it.

use std::cmp::Ordering;
use std::collections::{BinaryHeap, HashMap};

use super::cell::Cell;
use super::division::{Division, place};
use crate::element::kind::Form;
use crate::fault::MeshFault;
use crate::mesh::Mesh;

/// Halvings up to which places have exact names: each takes a bit of the weights of their corners.
const MOST_HALVINGS: u8 = 48;
/// Corners of the edges of a tetrahedron.
const EDGES: [[usize; 2]; 6] = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]];

/// An edge that waits to be halved, by its length, then by its ends.
#[derive(PartialEq)]
struct Waiting {
    length: f64,
    ends: [u32; 2],
}

impl Eq for Waiting {}

impl Ord for Waiting {
    fn cmp(&self, other: &Self) -> Ordering {
        self.length.total_cmp(&other.length).then_with(|| other.ends.cmp(&self.ends))
    }
}

impl PartialOrd for Waiting {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// The pieces of a mesh and their edges, while these are halved.
struct Bisection<'a, L> {
    mesh: &'a Mesh,
    /// The length of an edge between two places, if it is to be halved.
    length: L,
    places: Vec<[f64; 3]>,
    /// Pieces with the numbers of their corners.
    cells: Vec<(Cell, [u32; 4])>,
    /// Pieces about each edge.
    about: HashMap<[u32; 2], Vec<usize>>,
    waiting: BinaryHeap<Waiting>,
}

/// The edges of a piece.
fn edges(corners: &[u32; 4]) -> [[u32; 2]; 6] {
    EDGES.map(|[a, b]| [corners[a].min(corners[b]), corners[a].max(corners[b])])
}

impl<L: Fn([&[f64; 3]; 2]) -> Option<f64>> Bisection<'_, L> {
    /// Notes the edges of piece `i`, and which of them are to be halved.
    fn note(&mut self, i: usize) {
        for ends in edges(&self.cells[i].1) {
            let about = self.about.entry(ends).or_default();
            if about.is_empty() {
                let length = (self.length)(ends.map(|n| &self.places[n as usize]));
                self.waiting.extend(length.map(|length| Waiting { length, ends }));
            }
            about.push(i);
        }
    }

    /// Halves the edge between `ends` and all pieces about it, into `most` pieces at most.
    fn halve(&mut self, ends: [u32; 2], most: usize) -> Result<(), MeshFault> {
        let middle = self.places.len() as u32;
        for i in self.about.remove(&ends).unwrap_or_default() {
            let (cell, corners) = self.cells[i];
            if cell.level >= MOST_HALVINGS || self.cells.len() > most {
                return Err(MeshFault::TooFine { levels: cell.level, cells: self.cells.len(), most });
            }
            let [a, b] = ends.map(|n| corners.iter().position(|c| *c == n).unwrap_or_default());
            let xi = [0, 1, 2].map(|d| 0.5 * (cell.corners[a][d] + cell.corners[b][d]));
            if self.places.len() == middle as usize {
                self.places.push(place(self.mesh, cell.element, &xi));
            }
            for edge in edges(&corners) {
                self.about.entry(edge).and_modify(|about| about.retain(|j| *j != i));
            }
            let half = |end: usize| {
                let (mut half, mut numbers) = (cell, corners);
                (half.corners[end], numbers[end], half.level) = (xi, middle, cell.level + 1);
                (half, numbers)
            };
            self.cells[i] = half(a);
            self.cells.push(half(b));
            self.note(i);
            self.note(self.cells.len() - 1);
        }
        Ok(())
    }
}

impl Division {
    /// Halves edges of tetrahedra, the longest first, as long as they have a `length` between their two ends, into `most` pieces at most.
    ///
    /// # Errors
    /// [`MeshFault::TooFine`] beyond that, or if an element is halved too often; [`MeshFault::Undivided`] for other elements.
    pub fn of_edges(
        mesh: &Mesh,
        length: impl Fn([&[f64; 3]; 2]) -> Option<f64>,
        most: usize,
    ) -> Result<Self, MeshFault> {
        let (places, cells) = (mesh.nodes().to_vec(), Vec::new());
        let (about, waiting) = (HashMap::new(), BinaryHeap::new());
        let mut pieces = Bisection { mesh, length, places, cells, about, waiting };
        for (e, element) in mesh.elements().iter().enumerate() {
            let (kind, corners) = (element.kind, [0, 1, 2, 3].map(|k| element.nodes[k]));
            if kind.form() != Form::Tetrahedron {
                let point = mesh.nodes()[corners[0] as usize];
                return Err(MeshFault::Undivided { element: element.label, kind: kind.name(), point });
            }
            pieces.cells.push((Cell::whole(kind, e as u32), corners));
            pieces.note(e);
        }
        while let Some(Waiting { ends, .. }) = pieces.waiting.pop() {
            pieces.halve(ends, most)?;
        }
        let is_divided = vec![false; mesh.elements().len()];
        let mut division = Self { cells: Vec::new(), is_divided, is_near: Vec::new() };
        for (cell, _) in pieces.cells.iter().filter(|(cell, _)| cell.level > 0) {
            division.is_divided[cell.element as usize] = true;
            division.cells.push(*cell);
        }
        division.cells.sort_by_key(|cell| cell.element);
        division.note_near(mesh);
        Ok(division)
    }
}
