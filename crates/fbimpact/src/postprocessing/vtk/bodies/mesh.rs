//! A body of finite elements in its motion as a grid.

use std::sync::Arc;

use adaptive::spec::body::rigid_motion;
use fe_mesh::element::rules::MassRule;
use fe_mesh::{ElementKind, Mesh, MeshSpace};
use ffr_dynamics::body::RigidMotion;
use iga_core::SplineError;
use iga_core::elasticity::ElementMaterials;
use iga_core::elasticity::kinematics::von_mises;
use nalgebra::{Rotation3, Vector3};
use rayon::prelude::*;

use super::assemble::{CELLS_AN_ARC, PointShapes, View, placed, stress_in_body, vector};
use super::revolution::{ArcNode, polygon};
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
/// VTK's linear triangle and quadrilateral, and what they are when they are revolved.
const TRIANGLE: u8 = 5;
const QUADRILATERAL: u8 = 9;
const WEDGE: u8 = 13;
const HEXAHEDRON: u8 = 12;

/// Nodes of the linear parts of a plane element, which are revolved.
fn linear_parts(kind: ElementKind) -> &'static [&'static [usize]] {
    match kind {
        ElementKind::Tri3 => &[&[0, 1, 2]],
        ElementKind::Tri6 => &[&[0, 3, 5], &[3, 1, 4], &[5, 4, 2], &[3, 4, 5]],
        ElementKind::Quad4 => &[&[0, 1, 2, 3]],
        ElementKind::Quad8 => &[&[0, 4, 7], &[4, 1, 5], &[5, 2, 6], &[6, 3, 7], &[4, 5, 6, 7]],
        ElementKind::Quad9 => &[&[0, 4, 8, 7], &[4, 1, 5, 8], &[8, 5, 2, 6], &[7, 8, 6, 3]],
        _ => &[],
    }
}

/// Nodes around the axis at which the section of a body of `motion` is shown, and whether the last joins
/// the first: one of a body that is not revolved.
fn rings(motion: RigidMotion, view: View) -> (Vec<ArcNode>, bool) {
    let Some(degrees) = view.revolve.filter(|_| motion == RigidMotion::Axial) else {
        return (vec![ArcNode::SECTION], false);
    };
    let arcs = polygon(degrees, CELLS_AN_ARC);
    let mut nodes: Vec<ArcNode> = arcs.iter().flat_map(|arc| &arc[..CELLS_AN_ARC]).copied().collect();
    let is_closed = degrees >= 360.0;
    nodes.extend(arcs.last().and_then(|arc| arc.last()).filter(|_| !is_closed));
    (nodes, is_closed)
}

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
        ElementKind::Tri3 => (TRIANGLE, None),
        ElementKind::Quad4 => (QUADRILATERAL, None),
        ElementKind::Tri6 => (22, None),
        ElementKind::Quad8 => (23, None),
        ElementKind::Quad9 => (28, None),
        ElementKind::Hex27 => {
            let mut order: [usize; 27] = std::array::from_fn(|i| i);
            // VTK has the middles of the sides at -x, +x, -y, +y, -z, +z.
            order[20..26].copy_from_slice(&[25, 23, 22, 24, 20, 21]);
            (29, Some(order))
        }
    }
}

impl MeshGeometry {
    /// The grid of the body in the deformation `deformation`, a value per component and node; stress is
    /// that of the nodes, averaged over their elements. Of a section that is revolved quadratic elements
    /// are cut into linear ones.
    ///
    /// # Errors
    /// [`SplineError::Folded`] where an element is folded.
    pub fn grid(&self, pose: &Pose, deformation: Deformation<'_>, view: View) -> Result<Grid, SplineError> {
        let mut grid = grid(&self.mesh, pose, deformation, view);
        let space = MeshSpace::new(Arc::clone(&self.mesh), MassRule::Exact);
        let all = space.nodal_stress(&self.materials, deformation.displacement)?;
        let motion = rigid_motion(self.mesh.model());
        for node in rings(motion, view).0 {
            let rotation =
                pose.rotation * Rotation3::from_axis_angle(&Vector3::z_axis(), node.angle).into_inner();
            for stress in &all {
                grid.von_mises.push([von_mises(stress)]);
                grid.stress.push(rotated(&in_body(motion, stress), &rotation));
            }
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
        let motion = rigid_motion(self.mesh.model());
        let shape = |displacement: &Vec<f64>| {
            let stress = space.nodal_stress(&self.materials, displacement)?;
            let stress = points.iter().map(|&p| stress_in_body(motion, &stress[p as usize]));
            let at = |p: &u32| at_node(motion.n_components(), displacement, *p as usize);
            let displacement = points.iter().map(|p| vector(motion, &at(p), &ArcNode::SECTION).into());
            Ok(PointShapes { displacement: displacement.collect(), stress: stress.collect() })
        };
        displacements.par_iter().map(shape).collect()
    }
}

/// Components, `n` each, of node `i` in the list `of` all nodes.
fn at_node(n: usize, of: &[f64], i: usize) -> [f64; 3] {
    std::array::from_fn(|c| if c < n { of[n * i + c] } else { 0.0 })
}

/// Nodes and elements of `mesh` without stress, displaced as in [`MeshGeometry::grid`].
pub fn grid(mesh: &Mesh, pose: &Pose, deformation: Deformation<'_>, view: View) -> Grid {
    let mut grid = Grid::default();
    let motion = rigid_motion(mesh.model());
    let Deformation { displacement, rate } = deformation;
    let (n, (rings, is_closed)) = (mesh.nodes().len(), rings(motion, view));
    for node in &rings {
        for (i, place) in mesh.nodes().iter().enumerate() {
            let [u, v] = [displacement, rate].map(|of| at_node(motion.n_components(), of, i));
            placed(&mut grid, (pose, view), (motion, node), (place, &u, &v));
        }
    }
    if rings.len() > 1 {
        let next = |ring: usize| if ring + 1 < rings.len() { Some(ring + 1) } else { is_closed.then_some(0) };
        for (ring, next) in (0..rings.len()).filter_map(|ring| Some((ring, next(ring)?))) {
            for element in mesh.elements().iter() {
                for part in linear_parts(element.kind) {
                    let on = |ring: usize| part.iter().map(move |&i| ring * n + element.nodes[i] as usize);
                    let nodes: Vec<usize> = on(ring).chain(on(next)).collect();
                    grid.add_cell(if part.len() == 3 { WEDGE } else { HEXAHEDRON }, 0, &nodes);
                }
            }
        }
        return grid;
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
