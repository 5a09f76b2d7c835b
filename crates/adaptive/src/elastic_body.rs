//! A flexible body from its specification: refined geometry, matrices, reduced basis.

use std::sync::Arc;

use contact_qs::points::DofLookup;
use faer::{Mat, MatRef};
use ffr_dynamics::DynamicsError;
use ffr_dynamics::body::{AssembledBody, Dof, MassMatrix, ModalDamping, StandardInputData};
use ffr_dynamics::reduction::compliance::ResidualFlexibility;
use ffr_dynamics::reduction::modal::ReducedBasis;
use ffr_dynamics::reduction::problem::ElasticProblem;
use ffr_dynamics::reduction::rigid::RigidModes;
use ffr_dynamics::reduction::static_answers::{TakenLoads, with_static_answers};
use iga_core::SplineError;
use iga_core::assembly::assemble;
use iga_core::elasticity::Model;
use iga_core::nurbs::local::RefinementWindow;
use iga_core::nurbs::{Patch, Shape};
use iga_core::space::{PatchSpace, Space};
use nalgebra::UnitQuaternion;

use crate::error::AdaptiveError;
use crate::marker_loads::MarkerLoads;
use crate::spec::{DiscretisationSpec, ElasticSpec, FrameSpec, RefinementSpec};
use crate::store::{ModelCache, StoredModel, body_definition, matrix, matrix_values};
use crate::unsupported::Unsupported;

mod areas;
mod discretised;
mod key;
mod point_markers;
mod points;
mod reduction;
mod stiffening;

pub use crate::spec::body::rigid_motion;
pub use discretised::Discretised;
pub use key::modes_key;
pub(crate) use reduction::ReductionInput;
pub use stiffening::geometric_stiffening;

/// Part of a parameter range within which a point counts as lying at its end.
const AT_END: f64 = 1e-9;

/// A discretised body before reduction.
pub struct ElasticBody {
    /// Name.
    pub name: String,
    /// What it was built from.
    pub spec: ElasticSpec,
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
    /// Modes of the dynamic elastic coordinates at the unknowns, in the mean-axis frame.
    pub basis: ReducedBasis,
    /// The same modes in a tangent frame, if that is the frame in use.
    pub framed: Option<Mat<f64>>,
    /// Flexibility of what the modes leave out; with quasistatic contact only.
    pub residual: Option<ResidualFlexibility>,
    /// Inertia and couplings.
    pub data: StandardInputData,
    /// Loads whose static answers the basis was asked for; [`ReducedBasis::static_loads`] says which of their columns it has.
    pub loads: Vec<MarkerLoads>,
}

impl ReducedBody {
    /// Modes at the unknowns in the frame in use.
    pub fn shapes(&self) -> MatRef<'_, f64> {
        self.framed.as_ref().unwrap_or(&self.basis.shapes).as_ref()
    }
}

/// What contacts, joints and loads ask of a body's reduction.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Interface {
    /// Unknowns of the contact interface, rising.
    pub unknowns: Vec<usize>,
    /// What becomes of the high-frequency modes.
    pub modes: InterfaceModes,
    /// Loads to which the basis has static answers.
    pub loads: Vec<MarkerLoads>,
}

/// What becomes of the modes that the interface adds to the low-frequency ones (\[A\] sections 2.4 and 6).
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum InterfaceModes {
    /// They follow statically: a residual flexibility takes their place.
    Quasistatic,
    /// They are dynamic.
    #[default]
    Dynamic,
    /// They are dynamic and critically damped, on top of the body's own damping (Eq. F.23).
    Damped,
}

impl InterfaceModes {
    /// As scenarios call it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Quasistatic => "quasistatic",
            Self::Dynamic => "dynamic",
            Self::Damped => "damped",
        }
    }
}

impl ElasticBody {
    /// Refines the shape and assembles the matrices, stiffened where parts of the body are rigid.
    ///
    /// # Errors
    /// [`AdaptiveError::Geometry`] with the body's name; [`AdaptiveError::Unsupported`] for rigid parts with thousands of unknowns.
    pub fn build(name: &str, spec: ElasticSpec) -> Result<Self, AdaptiveError> {
        let fail = |source| AdaptiveError::Geometry { body: name.to_owned(), source };
        let shape = refined_shape(&spec.shape, &spec.model, &spec.discretisation).map_err(fail)?;
        let space = PatchSpace::new(shape.patches.clone()).map_err(fail)?;
        let matrices = assemble(&space, &spec.model, &spec.material).map_err(fail)?;
        let dofs: Vec<Dof> = matrices.dofs.iter().map(|&(node, component)| Dof { node, component }).collect();
        let lookup = DofLookup::new(&dofs);
        let mesh = Discretised {
            name,
            shape: &spec.shape,
            patches: &shape.patches,
            space: &space,
            model: &spec.model,
            dofs: &dofs,
            lookup: &lookup,
        };
        let stiffness = mesh.stiffened(matrices.stiffness, &spec.rigid_areas, &spec.material)?;
        let assembled = AssembledBody {
            name: name.to_owned(),
            motion: rigid_motion(&spec.model),
            stiffness,
            mass: MassMatrix::PerComponent(matrices.mass),
            nodes: space.control_points().to_vec(),
            anchors: space.anchors(),
            dofs,
        };
        Ok(Self { name: name.to_owned(), spec, shape, space, assembled, lookup })
    }

    /// A body of another name from `spec`, whose definition ([`crate::store::body_definition`]) is this body's.
    pub fn copied(&self, name: &str, spec: ElasticSpec) -> Self {
        let assembled = AssembledBody { name: name.to_owned(), ..self.assembled.clone() };
        let (shape, space) =
            (Shape { markers: spec.shape.markers.clone(), ..self.shape.clone() }, self.space.clone());
        Self { name: name.to_owned(), spec, shape, space, assembled, lookup: self.lookup.clone() }
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
        self.reduce_with(interface, &ModelCache::default())
    }

    /// As [`ElasticBody::reduce`], with modes from `cache` if they are there.
    ///
    /// # Errors
    /// [`AdaptiveError::Reduction`] with the body's name.
    pub fn reduce_with(
        &self,
        interface: &Interface,
        cache: &ModelCache,
    ) -> Result<ReducedBody, AdaptiveError> {
        let fail = |source| AdaptiveError::Reduction { body: self.name.clone(), source };
        let loads = self.discretised().load_columns(&self.assembled, &interface.loads)?;
        let mut reduced = self.reduced(interface, &loads, cache).map_err(fail)?;
        let FrameSpec::Tangent(place) = &self.spec.frame else {
            if self.spec.geometric_stiffening {
                let what = Unsupported::StiffeningWithoutTangent;
                return Err(AdaptiveError::unsupported_body(&self.name, what));
            }
            return Ok(reduced);
        };
        let support = self.discretised().marker_weights(place, UnitQuaternion::identity())?;
        let marker = support.marker("frame", reduced.basis.shapes.as_ref()).map_err(fail)?;
        let frame = marker.tangent_frame(self.assembled.motion);
        let shapes = frame.shifted_shapes(&self.assembled, reduced.basis.shapes.as_ref()).map_err(fail)?;
        reduced.data = reduced.data.in_tangent_frame(&frame).map_err(fail)?;
        if self.spec.geometric_stiffening {
            let stiffening = geometric_stiffening(self, shapes.as_ref(), &support)?;
            reduced.data = reduced.data.with_geometric_stiffening(&stiffening).map_err(fail)?;
        }
        reduced.framed = Some(shapes);
        Ok(reduced)
    }

    /// The reduction with static answers to `loads`, the columns of those of `interface`.
    fn reduced(
        &self,
        interface: &Interface,
        loads: &Mat<f64>,
        cache: &ModelCache,
    ) -> Result<ReducedBody, DynamicsError> {
        let ElasticSpec { reduction, damping, .. } = &self.spec;
        let key = modes_key(&body_definition(&self.spec), *reduction, interface, loads);
        let input = ReductionInput { body: &self.assembled, reduction: *reduction, damping, key };
        input.reduce(interface, loads, cache)
    }
}

/// What of a basis is kept: all but the rigid modes.
pub(crate) fn stored_basis(basis: &ReducedBasis) -> StoredModel {
    let (fewer, more) = basis.multiplet.unwrap_or((0, 0));
    let counts = [basis.n_low, basis.n_modes(), usize::from(basis.multiplet.is_some()), fewer, more];
    let counts = counts.iter().chain(&basis.static_loads).map(|n| *n as u64).collect();
    let mut values = basis.omega.clone();
    values.extend(matrix_values(&basis.shapes));
    StoredModel { counts, values }
}

/// The basis that was kept of a body with `n_unknowns` unknowns; none if it does not fit.
pub(crate) fn basis_from(
    stored: &StoredModel,
    n_unknowns: usize,
    rigid: &Arc<RigidModes>,
) -> Option<ReducedBasis> {
    let counts: Vec<usize> =
        stored.counts.iter().map(|n| usize::try_from(*n)).collect::<Result<_, _>>().ok()?;
    let (&[n_low, n_modes, has_multiplet, fewer, more], static_loads) = counts.split_first_chunk()?;
    let (omega, shapes) = stored.values.split_at_checked(n_modes)?;
    let basis = ReducedBasis {
        shapes: matrix(shapes, n_unknowns, n_modes)?,
        omega: omega.to_vec(),
        n_low,
        rigid: Arc::clone(rigid),
        multiplet: (has_multiplet == 1).then_some((fewer, more)),
        static_loads: static_loads.to_vec(),
    };
    (n_low <= n_modes).then_some(basis)
}

/// The lowest free modes, from a factorisation that the compliance uses too.
fn free_modes(problem: &ElasticProblem<'_>, n: usize) -> Result<ReducedBasis, DynamicsError> {
    Ok(ReducedBasis::from_modes(problem.lowest_modes(n)?, problem.free_rigid()?))
}

/// The lowest free modes of `body` with the static answers to `loads`.
pub(crate) fn free_modes_answering(
    body: &AssembledBody,
    n: usize,
    loads: &Mat<f64>,
) -> Result<ReducedBasis, DynamicsError> {
    let problem = ElasticProblem::free(body, &[])?;
    answering(&problem, free_modes(&problem, n)?, loads)
}

/// `basis` with the static answers to `loads`.
fn answering(
    problem: &ElasticProblem<'_>,
    basis: ReducedBasis,
    loads: &Mat<f64>,
) -> Result<ReducedBasis, DynamicsError> {
    with_static_answers(problem, basis, loads.as_ref(), TakenLoads::ByRank)
}

/// `own` damping with critical damping of the modes from `n_low` on added (Eq. F.23); `omega`: their frequencies [rad/s].
pub(crate) fn with_critical(own: ModalDamping, omega: &[f64], n_low: usize) -> ModalDamping {
    let critical = omega.iter().enumerate().map(|(j, w)| if j < n_low { 0.0 } else { 2.0 * w });
    match own {
        ModalDamping::None => ModalDamping::PerMode(critical.collect()),
        ModalDamping::PerMode(own) => {
            ModalDamping::PerMode(own.iter().zip(critical).map(|(a, b)| a + b).collect())
        }
        ModalDamping::Full(mut matrix) => {
            critical.enumerate().for_each(|(j, d)| matrix[(j, j)] += d);
            ModalDamping::Full(matrix)
        }
    }
}

/// The shape with the degrees, elements or explicit knots, and local refinement that are `wanted`.
///
/// # Errors
/// [`SplineError`] for a mesh that the shape cannot have.
pub fn refined_shape(
    shape: &Shape,
    model: &Model,
    wanted: &DiscretisationSpec,
) -> Result<Shape, SplineError> {
    let windows: Vec<RefinementWindow> = wanted
        .refine
        .iter()
        .map(|r| refinement_window(shape, model, r))
        .collect::<Result<_, SplineError>>()?;
    let elements =
        if wanted.knots.is_some() { vec![1; wanted.degrees.len()] } else { wanted.elements.clone() };
    let mut fine = shape.refined(&wanted.degrees, &elements, &windows)?;
    if let Some(knots) = &wanted.knots {
        let n_patches = shape.patches.len();
        if n_patches > 1 {
            let reason = "explicit knots need a shape of one patch";
            return Err(SplineError::MultiPatch { n_patches, reason });
        }
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
