//! A body of finite elements in its motion as a grid.

use std::sync::Arc;

use fe_mesh::element::rules::MassRule;
use fe_mesh::{ElementKind, Mesh, MeshSpace};
use ffr_dynamics::body::RigidMotion;
use iga_core::SplineError;
use iga_core::elasticity::ElementMaterials;
use iga_core::elasticity::kinematics::von_mises;
use rayon::prelude::*;

use super::assemble::{PointShapes, View, placed, stress_in_body};
use super::revolution::ArcNode;
use super::tensor::{in_body, rotated};
use crate::postprocessing::replay::states::Pose;
use crate::postprocessing::vtk::grid::{Deformation, Grid};

/// Mesh and materials of a body.
#[derive(Debug, Clone)]
pub struct MeshGeometry {
    /// Its mesh.
    pub mesh: Arc<Mesh>,
    /// Materials of its elements.
    pub materials: ElementMaterials,
}

/// VTK's pyramid of 13 nodes.
const QUADRATIC_PYRAMID: u8 = 27;

/// VTK's type of a cell, and for each of its nodes the place in the element where the order
/// differs. The pyramid with 14 nodes, which VTK does not have, is drawn without the middle of its
/// base.
fn cell(kind: ElementKind) -> (u8, Option<[usize; 27]>) {
    match kind {
        ElementKind::Tet4 => (10, None),
        ElementKind::Hex8 => (12, None),
        ElementKind::Wedge6 => (13, None),
        ElementKind::Tet10 => (24, None),
        ElementKind::Hex20 => (25, None),
        ElementKind::Wedge15 => (26, None),
        ElementKind::Wedge18 => (32, None),
        ElementKind::Pyramid5 => (14, None),
        ElementKind::Pyramid13 | ElementKind::Pyramid14 => (QUADRATIC_PYRAMID, None),
        ElementKind::Hex27 => {
            let mut order: [usize; 27] = std::array::from_fn(|i| i);
            // VTK has the middles of the sides at -x, +x, -y, +y, -z, +z.
            order[20..26].copy_from_slice(&[25, 23, 22, 24, 20, 21]);
            (29, Some(order))
        }
    }
}

impl MeshGeometry {
    /// The grid of the body in the deformation `deformation`, three values per node; stress is that
    /// of the nodes, averaged over their elements.
    ///
    /// # Errors
    /// [`SplineError::Folded`] where an element is folded.
    pub fn grid(&self, pose: &Pose, deformation: Deformation<'_>, view: View) -> Result<Grid, SplineError> {
        let mut grid = grid(&self.mesh, pose, deformation, view);
        let space = MeshSpace::new(Arc::clone(&self.mesh), MassRule::Exact);
        for stress in space.nodal_stress(&self.materials, deformation.displacement)? {
            grid.von_mises.push([von_mises(&stress)]);
            grid.stress.push(rotated(&in_body(RigidMotion::Spatial, &stress), &pose.rotation));
        }
        Ok(grid)
    }
}

impl MeshGeometry {
    /// As [`super::assemble::shapes`], at nodes.
    ///
    /// # Errors
    /// As [`Self::grid`].
    pub fn shapes(
        &self,
        displacements: &[Vec<f64>],
        points: &[u32],
    ) -> Result<Vec<PointShapes>, SplineError> {
        let space = MeshSpace::new(Arc::clone(&self.mesh), MassRule::Exact);
        let shape = |displacement: &Vec<f64>| {
            let (nodes, stress) =
                (displacement.as_chunks::<3>().0, space.nodal_stress(&self.materials, displacement)?);
            let stress = points.iter().map(|&p| stress_in_body(RigidMotion::Spatial, &stress[p as usize]));
            let displacement = points.iter().map(|&p| nodes[p as usize]);
            Ok(PointShapes { displacement: displacement.collect(), stress: stress.collect() })
        };
        displacements.par_iter().map(shape).collect()
    }
}

/// Nodes and elements of `mesh` without stress, displaced as in [`MeshGeometry::grid`].
pub fn grid(mesh: &Mesh, pose: &Pose, deformation: Deformation<'_>, view: View) -> Grid {
    let mut grid = Grid::default();
    let motion = (RigidMotion::Spatial, &ArcNode::SECTION);
    let Deformation { displacement, rate } = deformation;
    let (moved, moving) = (displacement.as_chunks::<3>().0, rate.as_chunks::<3>().0);
    for ((node, u), v) in mesh.nodes().iter().zip(moved).zip(moving) {
        placed(&mut grid, (pose, view), motion, (node, u, v));
    }
    for element in mesh.elements().iter() {
        let (kind, order) = cell(element.kind);
        let at = |i: usize| element.nodes[order.map_or(i, |order| order[i])] as usize;
        let n = if kind == QUADRATIC_PYRAMID { element.nodes.len().min(13) } else { element.nodes.len() };
        let nodes: Vec<usize> = (0..n).map(at).collect();
        grid.add_cell(kind, 0, &nodes);
    }
    grid
}
