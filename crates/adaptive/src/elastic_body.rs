//! A flexible body from its specification: refined geometry, matrices, reduced basis.

use contact_qs::points::DofLookup;
use faer::{Mat, MatRef};
use ffr_dynamics::DynamicsError;
use ffr_dynamics::body::{AssembledBody, Dof, MassMatrix, RayleighDamping, RigidMotion, StandardInputData};
use ffr_dynamics::kinematics::marker::FlexiblePoint;
use ffr_dynamics::reduction::compliance::ResidualFlexibility;
use ffr_dynamics::reduction::craig_bampton::{FixedInterfaceModes, craig_bampton};
use ffr_dynamics::reduction::modal::{ReducedBasis, all_modes, modal_truncation};
use ffr_dynamics::reduction::problem::ElasticProblem;
use iga_core::SplineError;
use iga_core::assembly::assemble;
use iga_core::elasticity::Model;
use iga_core::nurbs::local::RefinementWindow;
use iga_core::nurbs::patch::PointBasis;
use iga_core::nurbs::{Patch, Shape};
use iga_core::space::{PatchSpace, Space};
use nalgebra::Vector3;
use tracing::warn;

use crate::error::AdaptiveError;
use crate::spec::{DiscretisationSpec, ElasticBodySpec, ReductionSpec, RefinementSpec};

/// Part of a parameter range within which a point counts as lying at its end.
const AT_END: f64 = 1e-9;

/// A discretised body before reduction.
pub struct ElasticBody {
    /// What it was built from.
    pub spec: ElasticBodySpec,
    /// Refined geometry.
    pub shape: Shape,
    /// Spline space on it.
    pub space: PatchSpace,
    /// Matrices.
    pub assembled: AssembledBody,
    /// Numbers of the unknowns.
    pub lookup: DofLookup,
}

/// The reduced model of a body.
pub struct ReducedBody {
    /// Modes of the dynamic elastic coordinates at the unknowns.
    pub basis: ReducedBasis,
    /// Flexibility of what the modes leave out; with quasistatic contact only.
    pub residual: Option<ResidualFlexibility>,
    /// Inertia and couplings.
    pub data: StandardInputData,
}

/// What contact asks of a body's reduction.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Interface {
    /// Unknowns of the contact interface, rising.
    pub unknowns: Vec<usize>,
    /// Whether the high-frequency part follows statically.
    pub is_quasistatic: bool,
}

/// Rigid motions of a kinematic model.
pub fn rigid_motion(model: &Model) -> RigidMotion {
    match model {
        Model::Axisymmetric => RigidMotion::Axial,
        Model::PlaneStrain { .. } | Model::PlaneStress { .. } => RigidMotion::Planar,
        Model::Solid => RigidMotion::Spatial,
    }
}

impl ElasticBody {
    /// Refines the shape and assembles the matrices.
    ///
    /// # Errors
    /// [`AdaptiveError::Geometry`] with the body's name.
    pub fn build(spec: ElasticBodySpec) -> Result<Self, AdaptiveError> {
        let fail = |source| AdaptiveError::Geometry { body: spec.name.clone(), source };
        let shape = refine(&spec.shape, &spec.model, &spec.discretisation).map_err(fail)?;
        let space = PatchSpace::new(shape.patches.clone()).map_err(fail)?;
        let matrices = assemble(&space, &spec.model, &spec.material).map_err(fail)?;
        let dofs: Vec<Dof> = matrices.dofs.iter().map(|&(node, component)| Dof { node, component }).collect();
        let assembled = AssembledBody {
            name: spec.name.clone(),
            motion: rigid_motion(&spec.model),
            stiffness: matrices.stiffness,
            mass: MassMatrix::PerComponent(matrices.mass),
            nodes: space.control_points().to_vec(),
            anchors: space.anchors(),
            dofs,
        };
        let lookup = DofLookup::new(&assembled.dofs);
        Ok(Self { spec, shape, space, assembled, lookup })
    }

    /// Number of unknowns.
    pub fn n_unknowns(&self) -> usize {
        self.assembled.dofs.len()
    }

    /// Size of the body: the diagonal of the box around its control points \[m\].
    pub fn size(&self) -> f64 {
        self.space.size()
    }

    /// Reduces the body for the given contact interface.
    ///
    /// # Errors
    /// [`AdaptiveError::Reduction`] with the body's name.
    pub fn reduce(&self, interface: &Interface) -> Result<ReducedBody, AdaptiveError> {
        self.reduced(interface)
            .map_err(|source| AdaptiveError::Reduction { body: self.spec.name.clone(), source })
    }

    fn reduced(&self, interface: &Interface) -> Result<ReducedBody, DynamicsError> {
        let body = &self.assembled;
        let (basis, residual) = match self.spec.reduction {
            ReductionSpec::Modal { modes } => (modal_truncation(body, modes)?, None),
            ReductionSpec::All => (all_modes(body)?, None),
            ReductionSpec::CraigBampton { modes, .. } if interface.is_quasistatic => {
                let problem = ElasticProblem::free(body, &interface.unknowns)?;
                let basis = free_modes(&problem, modes)?;
                let residual = ResidualFlexibility::new(&problem, &interface.unknowns, &basis)?;
                (basis, Some(residual))
            }
            ReductionSpec::CraigBampton { modes, .. } if interface.unknowns.is_empty() => {
                (modal_truncation(body, modes)?, None)
            }
            ReductionSpec::CraigBampton { modes, fixed_interface_modes } => {
                let count =
                    fixed_interface_modes.map_or(FixedInterfaceModes::Checked, FixedInterfaceModes::Exactly);
                (craig_bampton(body, &interface.unknowns, modes, count)?.basis, None)
            }
        };
        // Twist-free modes about an axis are simple: frequencies that happen to lie close together are no group.
        if let (Some((fewer, more)), false) = (basis.multiplet, body.motion == RigidMotion::Axial) {
            warn!(
                body = self.spec.name,
                "{} modes cut through a group of equal frequencies, which loses energy when models change; {fewer} or {more} modes do not",
                basis.n_low
            );
        }
        let stiffness: Vec<f64> = basis.omega.iter().map(|w| w * w).collect();
        let mut data = StandardInputData::new(body, basis.shapes.as_ref(), &stiffness)?;
        if let Some((frequencies, ratio)) = self.spec.damping {
            data.modal_damping = RayleighDamping::from_frequencies(frequencies, ratio)?.modal(&stiffness);
        }
        Ok(ReducedBody { basis, residual, data })
    }

    /// Functions that are not zero at parameters `xi` of element `e`, with their values.
    pub fn functions_at(&self, e: usize, xi: &[f64; 3]) -> Vec<(u32, f64)> {
        let (mut basis, mut active) = (PointBasis::default(), Vec::new());
        self.space.evaluate(e, xi, 0, &mut basis);
        self.space.active_functions(e, &mut active);
        active.into_iter().zip(basis.values).filter(|(_, value)| value.abs() > 0.0).collect()
    }

    /// Element and parameters of a point of the undeformed body, in the model's components \[m\].
    ///
    /// # Errors
    /// [`AdaptiveError::Geometry`] if the point is not in the body.
    pub fn locate(&self, place: &[f64; 3]) -> Result<(usize, [f64; 3]), AdaptiveError> {
        // Refinement keeps the parameters, and the coarse shape is the cheaper one to search.
        let (patch, xi) = self
            .spec
            .shape
            .locate(place)
            .map_err(|source| AdaptiveError::Geometry { body: self.spec.name.clone(), source })?;
        Ok((self.space.find_element(patch, &xi), xi))
    }

    /// The material point at `place` (model's components \[m\]), moving with the modes `shapes`.
    ///
    /// # Errors
    /// As [`ElasticBody::locate`].
    pub fn flexible_point(
        &self,
        place: &[f64; 3],
        shapes: MatRef<'_, f64>,
    ) -> Result<FlexiblePoint, AdaptiveError> {
        let (e, xi) = self.locate(place)?;
        let functions = self.functions_at(e, &xi);
        let n_components = self.assembled.motion.n_components();
        let mut rows = Mat::zeros(n_components, shapes.ncols());
        for j in 0..shapes.ncols() {
            for c in 0..n_components {
                rows[(c, j)] = functions
                    .iter()
                    .filter_map(|&(node, value)| Some(value * shapes[(self.lookup.number(node, c)?, j)]))
                    .sum();
            }
        }
        let mut position = Vector3::zeros();
        for (c, &x) in place.iter().enumerate().take(n_components) {
            position[self.assembled.motion.direction(c)] = x;
        }
        Ok(FlexiblePoint::from_rows(self.assembled.motion, position, rows.as_ref(), 0))
    }

    /// Displacements of the unknowns as node-major control values, with zeros where a component is constrained.
    pub fn control_values(&self, displacement: &[f64]) -> Vec<f64> {
        let n_components = self.assembled.motion.n_components();
        let mut values = vec![0.0; self.space.n_functions() * n_components];
        for (dof, u) in self.assembled.dofs.iter().zip(displacement) {
            values[dof.node as usize * n_components + dof.component as usize] = *u;
        }
        values
    }
}

/// The lowest free modes, from a factorisation that the compliance uses too.
fn free_modes(problem: &ElasticProblem<'_>, n: usize) -> Result<ReducedBasis, DynamicsError> {
    let rigid = problem.rigid().ok_or_else(|| DynamicsError::Inconsistent {
        reason: "a free body is needed for its free modes".into(),
    })?;
    Ok(ReducedBasis::from_modes(problem.lowest_modes(n)?, rigid.clone()))
}

/// Degrees, elements or explicit knots, and local refinement.
fn refine(shape: &Shape, model: &Model, wanted: &DiscretisationSpec) -> Result<Shape, SplineError> {
    let windows: Vec<RefinementWindow> = wanted
        .refine
        .iter()
        .map(|r| refinement_window(shape, model, r))
        .collect::<Result<_, SplineError>>()?;
    let elements =
        if wanted.knots.is_some() { vec![1; wanted.degrees.len()] } else { wanted.elements.clone() };
    let mut fine = shape.refined(&wanted.degrees, &elements, &windows)?;
    if let Some(knots) = &wanted.knots {
        let insert = |patch: &Patch| {
            let mut patch = patch.clone();
            for (d, given) in knots.iter().enumerate() {
                let existing = patch.knots()[d].breaks();
                let new: Vec<f64> = given.iter().copied().filter(|u| !existing.contains(u)).collect();
                patch = patch.insert_knots(d, &new)?;
            }
            Ok(patch)
        };
        fine.patches = fine.patches.iter().map(insert).collect::<Result<_, SplineError>>()?;
    }
    Ok(fine)
}

/// The window of a refinement: elements of equal size in all directions, half as many where the body's surface cuts it.
fn refinement_window(
    shape: &Shape,
    model: &Model,
    wanted: &RefinementSpec,
) -> Result<RefinementWindow, SplineError> {
    let half_width = RefinementSpec::half_width(model, &wanted.centre, wanted.width);
    let (patch, xi) = shape.locate(&wanted.centre)?;
    let mut elements = [0; 3];
    for (n, (knots, u)) in elements.iter_mut().zip(shape.patches[patch].knots().iter().zip(xi)) {
        let (first, last) = knots.domain();
        let at_end = (u - first).min(last - u) < AT_END * (last - first);
        let reach = if at_end { half_width } else { 2.0 * half_width };
        *n = ((wanted.elements as f64 * reach / wanted.width).round() as usize).max(1);
    }
    Ok(RefinementWindow { centre: wanted.centre, half_width: [half_width; 3], elements, ratio: wanted.ratio })
}
