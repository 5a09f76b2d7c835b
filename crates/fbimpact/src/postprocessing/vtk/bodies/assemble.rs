//! A body in its motion as a grid.

use ffr_dynamics::body::RigidMotion;
use iga_core::SplineError;
use iga_core::elasticity::kinematics::von_mises;
use nalgebra::{Matrix3, Rotation3, Vector3};
use rayon::prelude::*;

use super::revolution::{ArcNode, arcs, polygon};
use super::splines::{BodyGeometry, Cells, Element, ElementFields, control_values};
use super::tensor::{in_body, rotated};
use crate::postprocessing::replay::states::Pose;
use crate::postprocessing::vtk::grid::order;
use crate::postprocessing::vtk::grid::{Deformation, Grid};

/// How bodies are shown.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct View {
    /// Factor on elastic displacements in the positions of points.
    pub scale: f64,
    /// Degrees by which axisymmetric bodies are revolved; none: their section.
    pub revolve: Option<f64>,
}

/// Linear cells an arc of at most a quarter turn.
pub(super) const CELLS_AN_ARC: usize = 6;

/// The grid of a body with the control values of `deformation`.
///
/// # Errors
/// [`SplineError`] where the geometry is folded.
pub fn grid(
    body: &BodyGeometry,
    pose: &Pose,
    deformation: Deformation<'_>,
    view: View,
) -> Result<Grid, SplineError> {
    let fields = body.fields(deformation.displacement, deformation.rate)?;
    let revolved = view.revolve.filter(|_| body.motion == RigidMotion::Axial);
    let spins = match (revolved, body.cells) {
        (None, _) => vec![vec![ArcNode::SECTION]],
        (Some(degrees), Cells::Bezier) => arcs(degrees),
        (Some(degrees), Cells::Linear(_)) => polygon(degrees, CELLS_AN_ARC),
    };
    let mut grid = Grid::default();
    for spin in &spins {
        for (element, fields) in body.elements.iter().zip(&fields) {
            let mut cell = Cell { body, pose, view, element, fields, spin, grid: &mut grid };
            cell.add();
        }
    }
    Ok(grid)
}

/// Displacement \[m\] and stress \[Pa\] by each of `displacements`, control values of the body, at the rising `points` of its [`grid`] of linear cells
/// that are not revolved, in the axes of the body.
///
/// # Errors
/// [`SplineError`] where the geometry is folded.
pub fn shapes(
    body: &BodyGeometry,
    displacements: &[Vec<f64>],
    points: &[u32],
) -> Result<Vec<PointShapes>, SplineError> {
    // The points of each element, the number of the first of the element with them.
    let (mut first, mut rest, mut groups) = (0, points, Vec::new());
    for (e, element) in body.elements.iter().enumerate() {
        let next = first + element.nodes.len();
        let (of_element, others) = rest.split_at(rest.partition_point(|&p| (p as usize) < next));
        if !of_element.is_empty() {
            groups.push((e, first, of_element));
        }
        (first, rest) = (next, others);
    }
    let at = |&(e, first, points): &(usize, usize, &[u32])| {
        let seen: Vec<usize> = points.iter().map(|p| *p as usize - first).collect();
        let in_body = |fields: &ElementFields| PointShapes {
            displacement: fields
                .displacement
                .iter()
                .map(|u| vector(body.motion, u, &ArcNode::SECTION).into())
                .collect(),
            stress: fields.stress.iter().map(|s| stress_in_body(body.motion, s)).collect(),
        };
        Ok(body.shapes((e, &seen), displacements)?.iter().map(in_body).collect())
    };
    let parts: Vec<Vec<PointShapes>> = groups.par_iter().map(at).collect::<Result<_, SplineError>>()?;
    let mut all = vec![PointShapes::default(); displacements.len()];
    for (shape, part) in parts.into_iter().flat_map(|part| part.into_iter().enumerate()) {
        all[shape].displacement.extend(part.displacement);
        all[shape].stress.extend(part.stress);
    }
    Ok(all)
}

/// Stress of a model in the axes of its body, as `XX, YY, ZZ, XY, YZ, XZ`.
pub fn stress_in_body(motion: RigidMotion, stress: &[f64; 6]) -> [f64; 6] {
    rotated(&in_body(motion, stress), &Matrix3::identity())
}

/// Values of a field of displacements at points.
#[derive(Debug, Clone, Default)]
pub struct PointShapes {
    /// Displacement \[m\].
    pub displacement: Vec<[f64; 3]>,
    /// Stress, `XX, YY, ZZ, XY, YZ, XZ` \[Pa\]; empty for rigid bodies.
    pub stress: Vec<[f64; 6]>,
}

/// One element, revolved or not, on its way into the grid.
struct Cell<'a> {
    body: &'a BodyGeometry,
    pose: &'a Pose,
    view: View,
    element: &'a Element,
    fields: &'a ElementFields,
    spin: &'a [ArcNode],
    grid: &'a mut Grid,
}

impl Cell<'_> {
    fn add(&mut self) {
        let first = self.grid.points.len();
        let mut steps = self.element.steps.clone();
        if self.spin.len() > 1 {
            steps.push(self.spin.len() - 1);
        }
        let mut weights = Vec::new();
        for node in self.spin {
            for i in 0..self.element.nodes.len() {
                self.add_point(i, node);
                weights.push(self.element.weights[i] * node.weight);
            }
        }
        self.add_stress(&steps, &weights);
        let dimension = steps.len() - 2;
        if self.body.cells == Cells::Bezier {
            self.grid.add_cell(order::BEZIER[dimension], first, &order::higher_order(&steps));
            let degree = |d: usize| steps.get(d).map_or(1.0, |&p| p as f64);
            self.grid.degrees.push([degree(0), degree(1), degree(2)]);
            self.grid.weights.extend(weights);
        } else {
            for nodes in order::linear(&steps) {
                self.grid.add_cell(order::LINEAR[dimension], first, &nodes);
            }
        }
    }

    fn add_point(&mut self, i: usize, node: &ArcNode) {
        let values = (&self.element.nodes[i], &self.fields.displacement[i], &self.fields.rate[i]);
        placed(self.grid, (self.pose, self.view), (self.body.motion, node), values);
    }

    fn add_stress(&mut self, steps: &[usize], weights: &[f64]) {
        if self.fields.stress.is_empty() {
            return;
        }
        let mut samples = Vec::with_capacity(weights.len());
        for node in self.spin {
            let about_axis = Rotation3::from_axis_angle(&Vector3::z_axis(), node.angle).into_inner();
            let rotation = self.pose.rotation * about_axis;
            for stress in &self.fields.stress {
                let t = rotated(&in_body(self.body.motion, stress), &rotation);
                samples.push([t[0], t[1], t[2], t[3], t[4], t[5], von_mises(stress)]);
            }
        }
        if self.body.cells == Cells::Bezier {
            samples = control_values(steps, weights, &samples);
        }
        for s in samples {
            self.grid.stress.push([s[0], s[1], s[2], s[3], s[4], s[5]]);
            // Control values may undershoot where the field does not.
            self.grid.von_mises.push([s[6].max(0.0)]);
        }
    }
}

/// Adds a material point to `grid`, with its displacement and velocity: `values` are its undeformed
/// place, displacement and the rate of that in the components of a model with the rigid motions
/// `motion`, on a node of an arc.
pub fn placed(
    grid: &mut Grid,
    (pose, view): (&Pose, View),
    (motion, node): (RigidMotion, &ArcNode),
    values: (&[f64; 3], &[f64; 3], &[f64; 3]),
) {
    let Pose { position, rotation, velocity, angular_velocity } = pose;
    let spatial = |v: &[f64; 3]| rotation * vector(motion, v, node);
    let (from_origin, displacement, rate) = (spatial(values.0), spatial(values.1), spatial(values.2));
    let spin = angular_velocity.cross(&(from_origin + displacement));
    grid.points.push((position + from_origin + view.scale * displacement).into());
    grid.displacement.push(displacement.into());
    grid.velocity.push((velocity + spin + rate).into());
}

/// A vector of the model in the axes of the body, on a node of an arc.
pub(super) fn vector(motion: RigidMotion, v: &[f64; 3], node: &ArcNode) -> Vector3<f64> {
    if motion == RigidMotion::Axial {
        return Vector3::new(v[0] * node.direction[0], v[0] * node.direction[1], v[1]);
    }
    motion.in_space(v)
}
