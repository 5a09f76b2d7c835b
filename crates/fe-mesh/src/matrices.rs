//! Sparse stiffness and mass matrices.

mod element;
mod pattern;

use faer::sparse::{SparseColMat, SymbolicSparseColMat};
use rayon::prelude::*;

use crate::fault::MeshFault;
use crate::mesh::Mesh;
use crate::refined::RefinedMesh;
use crate::rules::MassRule;
use crate::ties::Ties;
use element::{ElementMatrices, KindRules};
use pattern::{Connectivity, NodePattern};

/// Elastic constants and density of an isotropic material.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Constants {
    /// First Lamé constant \[Pa\].
    pub lambda: f64,
    /// Shear modulus \[Pa\].
    pub mu: f64,
    /// Density [kg/m³].
    pub density: f64,
}

/// Materials of a mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct Materials {
    constants: Vec<Constants>,
    /// Place of each element's constants; empty if all have the first.
    of_element: Vec<u16>,
}

impl Materials {
    /// One material for all elements.
    pub fn uniform(constants: Constants) -> Self {
        Self { constants: vec![constants], of_element: Vec::new() }
    }

    /// A material for each of the groups of elements `groups`, which share no element, and `rest` for those in none of them; without it they leave none
    /// out.
    ///
    /// # Errors
    /// As [`Mesh::by_group`].
    pub fn by_group(
        mesh: &Mesh,
        groups: &[(&str, Constants)],
        rest: Option<Constants>,
    ) -> Result<Self, MeshFault> {
        let names: Vec<&str> = groups.iter().map(|(name, _)| *name).collect();
        let of_element = mesh.by_group(&names, rest.is_some())?;
        Ok(Self { constants: groups.iter().map(|(_, c)| *c).chain(rest).collect(), of_element })
    }

    /// The materials of elements that are parts of `parents`.
    pub fn of_parts(&self, parents: &[u32]) -> Self {
        let own = |&e: &u32| self.of_element.get(e as usize).copied().unwrap_or(0);
        let of_element =
            if self.of_element.is_empty() { Vec::new() } else { parents.iter().map(own).collect() };
        Self { constants: self.constants.clone(), of_element }
    }

    /// Constants of element `e`.
    pub fn of(&self, e: usize) -> &Constants {
        let at = self.of_element.get(e).copied().unwrap_or(0);
        &self.constants[at as usize]
    }
}

/// Matrices of a free body, lower triangles.
#[derive(Debug, Clone)]
pub struct Matrices {
    /// Stiffness, unknown by unknown [N/m].
    pub stiffness: SparseColMat<u32, f64>,
    /// Mass, node by node, the same for each direction \[kg\].
    pub mass: SparseColMat<u32, f64>,
}

/// Elements that are integrated before they are added up: bounds the memory beside the matrices.
const BATCH: usize = 4096;

/// Stiffness and mass matrices of `mesh` (theory Eq. E.11), the mass integrated by `rule`; the same bits for any number of threads.
///
/// All elements are plain displacement elements with the rules of [`crate::rules`]: hex8 has neither a mean dilatation nor incompatible
/// modes.
///
/// # Errors
/// [`MeshFault::TooLarge`] if the entries do not fit 32-bit indices.
pub fn assemble(mesh: &Mesh, materials: &Materials, rule: MassRule) -> Result<Matrices, MeshFault> {
    assemble_tied(mesh, &Ties::new(mesh.nodes().len(), Vec::new()), materials, rule)
}

/// The same of the free nodes of a divided mesh, `materials` being those of the mesh before.
///
/// # Errors
/// As [`assemble`].
pub fn assemble_refined(
    refined: &RefinedMesh,
    materials: &Materials,
    rule: MassRule,
) -> Result<Matrices, MeshFault> {
    assemble_tied(refined.mesh(), refined.ties(), &materials.of_parts(refined.parents()), rule)
}

fn assemble_tied(
    mesh: &Mesh,
    ties: &Ties,
    materials: &Materials,
    rule: MassRule,
) -> Result<Matrices, MeshFault> {
    let (n, connectivity) = (ties.n_free(), Connectivity::new(mesh, ties));
    let pattern = NodePattern::new(n, &connectivity)?;
    let rules = KindRules::all(rule);
    let mut stiffness = vec![0.0; pattern.n_stiffness()];
    let mut mass = vec![0.0; pattern.n_mass()];
    let elements = mesh.elements();
    for first in (0..elements.len()).step_by(BATCH) {
        let batch = first..(first + BATCH).min(elements.len());
        let made: Vec<ElementMatrices> = batch
            .clone()
            .into_par_iter()
            .map(|e| {
                let element = elements.get(e);
                let matrices = ElementMatrices::new(mesh, element, materials.of(e), &rules);
                matrices.tied(element.nodes, ties, connectivity.of(e))
            })
            .collect();
        for (e, matrices) in batch.zip(&made) {
            pattern.add(connectivity.of(e), matrices, &mut stiffness, &mut mass);
        }
    }
    let (columns, rows) = pattern.unknowns();
    let stiffness =
        SparseColMat::new(SymbolicSparseColMat::new_checked(3 * n, 3 * n, columns, None, rows), stiffness);
    let (columns, rows) = pattern.into_nodes();
    let mass = SparseColMat::new(SymbolicSparseColMat::new_checked(n, n, columns, None, rows), mass);
    Ok(Matrices { stiffness, mass })
}
