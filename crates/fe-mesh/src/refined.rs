//! Meshes whose elements are halved about a place (docs/theory.md section C.10).
//!
//! Elements are halved along every edge in their parameters; nodes of the pieces lie on the map of
//! the element, which the pieces have exactly, since quadratic functions of a part of the
//! parameters are quadratic: the part keeps its shape. Nodes of small pieces on edges and sides of
//! larger ones are tied to them, so that displacements are continuous. Neighbours differ by one
//! level at most. Pyramids stay whole. Meshes of tetrahedra may be halved edge by edge, so that pieces are longer in one direction than in another.

mod cell;
mod names;
mod division;
mod bisection;
mod hanging;

use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

use iga_core::space::Rows;

use crate::element::shape::Functions;
use crate::fault::MeshFault;
use crate::mesh::Mesh;
use crate::mesh::boundary::Face;
use crate::mesh::raw::Elements;

use cell::Cell;
pub use division::CellBall;
use division::{Division, place};
use names::{Numbers, is_on_side, name};

/// A mesh some of whose elements are divided.
#[derive(Debug, Clone, PartialEq)]
pub struct RefinedMesh {
    mesh: Arc<Mesh>,
    n_free: usize,
    /// The free nodes that each node behind these follows, with their weights.
    hanging: Vec<Vec<(u32, f64)>>,
    /// Functions of the free nodes on every element with a node that follows others.
    rows: Arc<Rows>,
    /// Element of the mesh before, of every element.
    parents: Vec<u32>,
    /// Element and parameters in the mesh before, of the nodes that were not there.
    origins: Vec<(u32, [f64; 3])>,
    /// Number of nodes of the mesh before, which are the first.
    n_before: usize,
}

/// A mesh while its pieces are numbered.
struct Pieces<'a> {
    before: &'a Mesh,
    nodes: Vec<[f64; 3]>,
    origins: Vec<(u32, [f64; 3])>,
    elements: Elements,
    parents: Vec<u32>,
    numbers: Numbers,
    /// Sides on the surface, each with the one of the mesh before that it is a part of.
    surface: Vec<(Face, Face)>,
}

impl RefinedMesh {
    /// Halves the elements of `mesh`, and what becomes of them, as long as `is_wanted`; into `most`
    /// pieces at most.
    ///
    /// # Errors
    /// [`MeshFault::TooFine`] beyond that, or if elements are halved more than sixteen times; [`MeshFault::Undivided`] where a pyramid is wanted smaller, or has neighbours
    /// that are smaller by more than a level.
    pub fn new(mesh: &Mesh, is_wanted: impl Fn(&CellBall) -> bool, most: usize) -> Result<Self, MeshFault> {
        Ok(Self::of(mesh, &Division::new(mesh, is_wanted, most)?))
    }

    /// Halves the edges of the tetrahedra of `mesh`, the longest first, and what becomes of them, as long as they have a
    /// `length` between their two ends (theory Eq. C.110); into `most` pieces at most.
    ///
    /// # Errors
    /// [`MeshFault::TooFine`] beyond that, [`MeshFault::Undivided`] for elements that are no tetrahedra.
    pub fn at_edges(
        mesh: &Mesh,
        length: impl Fn([&[f64; 3]; 2]) -> Option<f64>,
        most: usize,
    ) -> Result<Self, MeshFault> {
        Ok(Self::of(mesh, &Division::of_edges(mesh, length, most)?))
    }

    fn of(mesh: &Mesh, division: &Division) -> Self {
        let mut pieces = Pieces::new(mesh, division);
        for (e, element) in mesh.elements().iter().enumerate().filter(|(e, _)| !division.is_divided[*e]) {
            pieces.push_whole(e as u32, element.nodes);
        }
        division.cells.iter().for_each(|cell| pieces.push(cell));
        let tied = hanging::ties(mesh, &division.cells_and_neighbours(mesh), &pieces.numbers);
        pieces.finished(tied)
    }

    /// All elements with all nodes.
    pub fn mesh(&self) -> &Arc<Mesh> {
        &self.mesh
    }

    /// Number of free nodes, which come first.
    pub fn n_free(&self) -> usize {
        self.n_free
    }

    /// Positions of the free nodes \[m\].
    pub fn free_nodes(&self) -> &[[f64; 3]] {
        &self.mesh.nodes()[..self.n_free]
    }

    /// The free nodes that `node` follows, with their weights (theory Eq. C.71); none of a free
    /// node.
    pub fn followed(&self, node: u32) -> &[(u32, f64)] {
        (node as usize).checked_sub(self.n_free).and_then(|i| self.hanging.get(i)).map_or(&[], Vec::as_slice)
    }

    /// The functions of the free nodes on each element.
    pub(crate) fn rows(&self) -> &Arc<Rows> {
        &self.rows
    }

    /// Element of the mesh before, of every element.
    pub fn parents(&self) -> &[u32] {
        &self.parents
    }

    /// The functions of the mesh before, `mesh`, that are not zero at free node `node`, with their
    /// values there.
    pub fn functions_before(&self, mesh: &Mesh, node: usize) -> Vec<(u32, f64)> {
        let Some(new) = node.checked_sub(self.n_before) else { return vec![(node as u32, 1.0)] };
        let (e, xi) = self.origins[new];
        let element = mesh.elements().get(e as usize);
        let mut functions = Functions::default();
        element.kind.functions(&xi, &mut functions);
        element.nodes.iter().copied().zip(functions.values).collect()
    }
}

impl<'a> Pieces<'a> {
    fn new(before: &'a Mesh, division: &Division) -> Self {
        let mut numbers = Numbers::default();
        for (element, _) in before.elements().iter().zip(&division.is_near).filter(|(_, is)| **is) {
            for (xi, &node) in element.kind.node_parameters().iter().zip(element.nodes) {
                numbers.set(name(element, xi), node);
            }
        }
        Self {
            before,
            nodes: before.nodes().to_vec(),
            origins: Vec::new(),
            elements: Elements::default(),
            parents: Vec::new(),
            numbers,
            surface: Vec::new(),
        }
    }

    /// Adds an element that stays as it is.
    fn push_whole(&mut self, e: u32, nodes: &[u32]) {
        let own = self.elements.len() as u32;
        for side in self.sides_of(e) {
            self.surface.push((Face { element: own, side: side.side }, side));
        }
        let element = self.before.elements().get(e as usize);
        self.elements.push(element.kind, element.label, nodes.iter().copied());
        self.parents.push(e);
    }

    /// Sides of element `e` on the surface.
    fn sides_of(&self, e: u32) -> Vec<Face> {
        let all = self.before.surface();
        let first = all.partition_point(|face| face.element < e);
        all[first..].iter().copied().take_while(|face| face.element == e).collect()
    }

    /// Adds a piece.
    fn push(&mut self, cell: &Cell) {
        let element = self.before.elements().get(cell.element as usize);
        let kind = element.kind;
        let cell = cell.oriented(kind);
        let own = self.elements.len() as u32;
        for of in self.sides_of(cell.element) {
            for side in 0..kind.sides().len() {
                let corners = kind.sides()[side].iter().map(|&c| &cell.corners[c as usize]);
                if corners.into_iter().all(|xi| is_on_side(kind, of.side as usize, xi)) {
                    self.surface.push((Face { element: own, side: side as u8 }, of));
                }
            }
        }
        let mut nodes = Vec::with_capacity(kind.n_nodes());
        for xi in kind.node_parameters() {
            let xi = cell.at(kind, &xi);
            let next = self.nodes.len() as u32;
            let number = self.numbers.get_or(name(element, &xi), next);
            if number == next {
                self.nodes.push(place(self.before, cell.element, &xi));
                self.origins.push((cell.element, xi));
            }
            nodes.push(number);
        }
        self.elements.push(kind, element.label, nodes.into_iter());
        self.parents.push(cell.element);
    }

    /// The mesh, the nodes `tied` to others moved behind the free ones.
    fn finished(mut self, tied: HashMap<u32, Vec<(u32, f64)>>) -> RefinedMesh {
        let n_before = self.before.nodes().len();
        let all = 0..self.nodes.len() as u32;
        let (hanging, free): (Vec<u32>, Vec<u32>) = all.partition(|n| tied.contains_key(n));
        let order: Vec<u32> = free.iter().chain(&hanging).copied().collect();
        let mut new = vec![0; order.len()];
        order.iter().enumerate().for_each(|(i, &n)| new[n as usize] = i as u32);
        self.elements.renumber(&new);
        let lists = hanging.iter().map(|n| tied[n].iter().map(|(m, w)| (new[*m as usize], *w)).collect());
        let (n_free, hanging) = (free.len(), lists.collect::<Vec<_>>());
        let nodes = order.iter().map(|&n| self.nodes[n as usize]).collect();
        // Nodes of the mesh before are never tied: they are corners and middles of the largest
        // elements.
        let origins = order.iter().filter(|&&n| n as usize >= n_before);
        let origins = origins.map(|&n| self.origins[n as usize - n_before]).collect();
        self.surface.sort_unstable();
        let group = |faces: &[Face]| -> Vec<Face> {
            let is_part = |of: &Face| faces.binary_search(of).is_ok();
            self.surface.iter().filter(|(_, of)| is_part(of)).map(|(face, _)| *face).collect()
        };
        let faces = self.before.faces().iter().map(|(name, faces)| (name.clone(), group(faces))).collect();
        let surface = self.surface.iter().map(|(face, _)| *face).collect();
        let mesh = Mesh::divided(*self.before.model(), (nodes, self.elements), surface, faces);
        let rows = Arc::new(rows(mesh.elements(), n_free, &hanging));
        RefinedMesh { mesh: Arc::new(mesh), n_free, hanging, rows, parents: self.parents, origins, n_before }
    }
}

/// Functions of the free nodes in terms of all nodes of each element, where some of these are among
/// the `hanging` ones behind the `n_free` first.
fn rows(elements: &Elements, n_free: usize, hanging: &[Vec<(u32, f64)>]) -> Rows {
    let mut rows = Rows::default();
    for element in elements.iter() {
        if element.nodes.iter().all(|&n| (n as usize) < n_free) {
            rows.push_plain([]);
            continue;
        }
        let mut sums: BTreeMap<u32, Vec<(u16, f64)>> = BTreeMap::new();
        for (column, &node) in (0..).zip(element.nodes) {
            match (node as usize).checked_sub(n_free) {
                None => sums.entry(node).or_default().push((column, 1.0)),
                Some(i) => hanging[i].iter().for_each(|&(n, w)| sums.entry(n).or_default().push((column, w))),
            }
        }
        rows.push(sums);
    }
    rows
}
