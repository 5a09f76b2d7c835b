//! A mesh as a file has it: numbers of the file resolved, nothing checked.

use iga_core::elasticity::Model;

use super::tie::Tie;
use crate::element::kind::ElementKind;

/// Elements, one after the other.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Elements {
    kinds: Vec<ElementKind>,
    labels: Vec<u64>,
    starts: Vec<u32>,
    nodes: Vec<u32>,
}

/// One element.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Element<'a> {
    /// Its kind.
    pub kind: ElementKind,
    /// Its number in the file.
    pub label: u64,
    /// Its nodes, counted from 0.
    pub nodes: &'a [u32],
}

impl Element<'_> {
    /// Corners of a plane element as those of a side.
    pub fn corners(&self) -> [u32; 4] {
        std::array::from_fn(|i| if i < self.kind.n_corners() { self.nodes[i] } else { NO_NODE })
    }
}

impl Elements {
    /// Adds an element with the nodes of its kind.
    pub fn push(&mut self, kind: ElementKind, label: u64, nodes: impl Iterator<Item = u32>) {
        self.starts.push(self.nodes.len() as u32);
        self.nodes.extend(nodes);
        self.kinds.push(kind);
        self.labels.push(label);
    }

    /// Number of elements.
    pub fn len(&self) -> usize {
        self.kinds.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.kinds.is_empty()
    }

    /// Element `e`.
    ///
    /// # Panics
    /// If there is none.
    pub fn get(&self, e: usize) -> Element<'_> {
        let (kind, first) = (self.kinds[e], self.starts[e] as usize);
        Element { kind, label: self.labels[e], nodes: &self.nodes[first..first + kind.n_nodes()] }
    }

    /// All elements.
    pub fn iter(&self) -> impl Iterator<Item = Element<'_>> {
        (0..self.len()).map(|e| self.get(e))
    }

    /// Gives nodes other numbers.
    pub fn renumber(&mut self, numbers: &[u32]) {
        self.nodes.iter_mut().for_each(|n| *n = numbers[*n as usize]);
    }
}

/// How a file names a part of the surface.
#[derive(Debug, Clone, PartialEq)]
pub enum FaceSource {
    /// By surface elements: their corners, [`NO_NODE`] in the last places of triangles and lines.
    Corners(Vec<[u32; 4]>),
    /// By elements and numbers of their sides.
    Sides(Vec<(u32, u8)>),
    /// By nodes: sides all of whose nodes are in the set.
    Nodes(Vec<u32>),
}

/// A model that the type of plane elements names.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StatedModel {
    /// Plane stress.
    PlaneStress,
    /// Plane strain.
    PlaneStrain,
    /// Rotational symmetry.
    Axisymmetric,
}

impl StatedModel {
    /// Whether `model` is that.
    pub fn is_of(self, model: &Model) -> bool {
        match self {
            Self::PlaneStress => matches!(model, Model::PlaneStress { .. }),
            Self::PlaneStrain => matches!(model, Model::PlaneStrain { .. }),
            Self::Axisymmetric => *model == Model::Axisymmetric,
        }
    }

    /// In words.
    pub fn name(self) -> &'static str {
        match self {
            Self::PlaneStress => "plane stress",
            Self::PlaneStrain => "plane strain",
            Self::Axisymmetric => "rotational symmetry",
        }
    }
}

/// No fourth corner.
pub const NO_NODE: u32 = u32::MAX;

/// A mesh as a file has it, in the file's unit of length.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RawMesh {
    /// Positions.
    pub nodes: Vec<[f64; 3]>,
    /// Numbers of the nodes in the file.
    pub node_labels: Vec<u64>,
    /// Elements, all solid or all plane.
    pub elements: Elements,
    /// The plane model that the file has its elements for.
    pub stated: Option<StatedModel>,
    /// Groups of elements by name.
    pub volumes: Vec<(String, Vec<u32>)>,
    /// Groups of faces by name.
    pub faces: Vec<(String, FaceSource)>,
    /// What was left out, with its place.
    pub notes: Vec<String>,
    /// What the file joins, of all its parts.
    pub ties: Vec<Tie>,
}

impl RawMesh {
    /// Gives nodes other numbers and leaves those out that get [`NO_NODE`], which no element has.
    pub fn keep_nodes(&mut self, numbers: &[u32]) {
        let mut is_kept = numbers.iter().map(|n| *n != NO_NODE);
        self.nodes.retain(|_| is_kept.next() == Some(true));
        let mut is_kept = numbers.iter().map(|n| *n != NO_NODE);
        self.node_labels.retain(|_| is_kept.next() == Some(true));
        self.elements.renumber(numbers);
        let to_number = |n: u32| if n == NO_NODE { NO_NODE } else { numbers[n as usize] };
        for (_, source) in &mut self.faces {
            match source {
                FaceSource::Corners(all) => all.iter_mut().for_each(|c| *c = c.map(to_number)),
                FaceSource::Nodes(all) => {
                    all.iter_mut().for_each(|n| *n = to_number(*n));
                    all.retain(|n| *n != NO_NODE);
                }
                FaceSource::Sides(_) => {}
            }
        }
    }
}
