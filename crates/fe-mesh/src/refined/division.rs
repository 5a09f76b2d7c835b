//! Which cells the elements are divided into: as wanted, and so that neighbours differ by one level
//! at most.

use std::collections::HashSet;

use super::cell::{Cell, Seams};
use super::names::{MOST_LEVELS, Name, name};
use crate::element::jacobian::{minus, norm, position};
use crate::element::kind::ElementKind;
use crate::element::shape::Functions;
use crate::fault::MeshFault;
use crate::mesh::Mesh;

/// Where a cell lies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CellBall {
    /// Mean of its nodes \[m\].
    pub centre: [f64; 3],
    /// Distance of its farthest node \[m\].
    pub radius: f64,
    /// How often its element was halved.
    pub level: u8,
}

/// The cells of a mesh.
pub struct Division {
    /// Cells of the elements that were divided, in the order of the elements.
    pub cells: Vec<Cell>,
    /// Whether each element was divided.
    pub is_divided: Vec<bool>,
    /// Whether each element shares a node with one that was, or was itself.
    pub is_near: Vec<bool>,
}

/// Position of the place with parameters `xi` in element `e`.
pub fn place(mesh: &Mesh, e: u32, xi: &[f64; 3]) -> [f64; 3] {
    let element = mesh.elements().get(e as usize);
    let (mut functions, mut places) = (Functions::default(), Vec::new());
    mesh.places(element.nodes, &mut places);
    element.kind.functions(xi, &mut functions);
    position(&functions.values, &places)
}

fn ball(mesh: &Mesh, kind: ElementKind, cell: &Cell) -> CellBall {
    let nodes = kind.node_parameters();
    let places: Vec<[f64; 3]> =
        nodes.iter().map(|xi| place(mesh, cell.element, &cell.at(kind, xi))).collect();
    let centre = [0, 1, 2].map(|d| places.iter().map(|x| x[d]).sum::<f64>() / places.len() as f64);
    let radius = places.iter().map(|x| norm(&minus(x, &centre))).fold(0.0, f64::max);
    CellBall { centre, radius, level: cell.level }
}

impl Division {
    /// Halves cells as long as `is_wanted`, into `most` cells at most.
    ///
    /// # Errors
    /// [`MeshFault::TooFine`] beyond that, [`MeshFault::Undivided`] for elements that cannot be halved.
    pub fn new(mesh: &Mesh, is_wanted: impl Fn(&CellBall) -> bool, most: usize) -> Result<Self, MeshFault> {
        let n = mesh.elements().len();
        let (mut cells, mut is_divided) = (Vec::new(), vec![false; n]);
        for (e, element) in mesh.elements().iter().enumerate() {
            let mut waiting = vec![Cell::whole(element.kind, e as u32)];
            while let Some(cell) = waiting.pop() {
                if is_wanted(&ball(mesh, element.kind, &cell)) {
                    check(cell.level, cells.len() + waiting.len(), most)?;
                    is_divided[e] = true;
                    waiting.extend(children(mesh, &cell)?);
                } else if cell.level > 0 {
                    cells.push(cell);
                }
            }
        }
        let mut division = Self { cells, is_divided, is_near: Vec::new() };
        while division.balance(mesh, most)? {}
        division.cells.sort_by_key(|cell| cell.element);
        Ok(division)
    }

    /// The cells of elements that were divided, and the elements beside them as cells.
    pub fn cells_and_neighbours(&self, mesh: &Mesh) -> Vec<Cell> {
        let beside = (0..mesh.elements().len()).filter(|&e| self.is_near[e] && !self.is_divided[e]);
        let beside = beside.map(|e| Cell::whole(mesh.elements().get(e).kind, e as u32));
        self.cells.iter().copied().chain(beside).collect()
    }

    /// Notes the elements that share a node with a divided one.
    pub fn note_near(&mut self, mesh: &Mesh) {
        let mut is_touched = vec![false; mesh.nodes().len()];
        for (element, _) in mesh.elements().iter().zip(&self.is_divided).filter(|(_, is)| **is) {
            element.nodes.iter().for_each(|&n| is_touched[n as usize] = true);
        }
        let is_near = |nodes: &[u32]| nodes.iter().any(|&n| is_touched[n as usize]);
        self.is_near = mesh.elements().iter().map(|element| is_near(element.nodes)).collect();
    }

    /// Halves cells beside others of more than a level above; whether there were any.
    fn balance(&mut self, mesh: &Mesh, most: usize) -> Result<bool, MeshFault> {
        self.note_near(mesh);
        let mut corners: HashSet<Name> = HashSet::new();
        for cell in &self.cells {
            let element = mesh.elements().get(cell.element as usize);
            let own = &cell.corners[..element.kind.n_corners()];
            corners.extend(own.iter().map(|xi| name(element, xi)));
        }
        let seams: Vec<(ElementKind, Seams)> = ElementKind::ALL.map(|kind| (kind, Seams::new(kind))).into();
        let mut is_unchanged = true;
        let mut kept = Vec::new();
        for cell in self.cells_and_neighbours(mesh) {
            let element = mesh.elements().get(cell.element as usize);
            let second = seams.iter().find(|(kind, _)| *kind == element.kind).map(|(_, s)| &s.second[..]);
            let is_corner = |xi: &[f64; 3]| corners.contains(&name(element, &cell.at(element.kind, xi)));
            if second.unwrap_or_default().iter().any(is_corner) {
                check(cell.level, kept.len(), most)?;
                self.is_divided[cell.element as usize] = true;
                kept.extend(children(mesh, &cell)?);
                is_unchanged = false;
            } else if cell.level > 0 {
                kept.push(cell);
            }
        }
        self.cells = kept;
        Ok(!is_unchanged)
    }
}

/// The halves of a cell.
fn children(mesh: &Mesh, cell: &Cell) -> Result<Vec<Cell>, MeshFault> {
    let element = mesh.elements().get(cell.element as usize);
    cell.children(element.kind).ok_or_else(|| {
        let point = ball(mesh, element.kind, cell).centre;
        MeshFault::Undivided { element: element.label, kind: element.kind.name(), point }
    })
}

/// Refuses levels beyond those whose places have exact names, and more cells than `most`.
fn check(level: u8, cells: usize, most: usize) -> Result<(), MeshFault> {
    if level >= MOST_LEVELS || cells > most {
        return Err(MeshFault::TooFine { levels: level, cells, most });
    }
    Ok(())
}
