//! A flexible body of splines from its specification: refined geometry and matrices.

use std::sync::Arc;

use contact_qs::zone::points::DofLookup;
use ffr_dynamics::body::{AssembledBody, Dof, MassMatrix};
use iga_core::SplineError;
use iga_core::elasticity::assembly::assemble;
use iga_core::elasticity::{MaterialField, Model};
use iga_core::extent::{Extent, ExtentPoint};
use iga_core::nurbs::local::RefinementWindow;
use iga_core::nurbs::{Patch, Shape};
use iga_core::space::{PatchSpace, Space};

use crate::body::field::Field;
use crate::error::AdaptiveError;
use crate::spec::{DiscretisationSpec, ElasticSpec, RefinementSpec};
use crate::surface::SplineSurface;

mod discretised;
pub mod rotated_net;

pub use crate::spec::body::rigid_motion;
pub use discretised::Discretised;
pub(crate) use discretised::{locate, named_place, points_of};

/// Part of a parameter range within which a point counts as lying at its end.
const AT_END: f64 = 1e-9;

/// A body of splines before reduction.
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
    /// The number of the unknown of each function and component.
    pub lookup: DofLookup,
    /// Its undeformed surface.
    pub surface: Arc<SplineSurface>,
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
        let assembled = AssembledBody {
            name: name.to_owned(),
            motion: rigid_motion(&spec.model),
            stiffness: matrices.stiffness,
            mass: MassMatrix::PerComponent(matrices.mass),
            nodes: space.control_points().to_vec(),
            anchors: space.anchors(),
            dofs,
        };
        let lookup = DofLookup::new(&assembled.dofs);
        let surface = SplineSurface::of(&spec.shape, &spec.model);
        let mut body = Self { name: name.to_owned(), spec, shape, space, assembled, lookup, surface };
        if !body.spec.flexible.rigid_areas.is_empty() {
            let soft = body.assembled.stiffness.clone();
            body.assembled.stiffness =
                body.stiffened(soft, &body.spec.flexible.rigid_areas, &body.spec.material)?;
        }
        Ok(body)
    }

    /// A body of another name from `spec`, whose definition ([`crate::store::body_definition`]) is
    /// this body's.
    pub fn copied(&self, name: &str, spec: ElasticSpec) -> Self {
        let assembled = AssembledBody { name: name.to_owned(), ..self.assembled.clone() };
        let (shape, space) =
            (Shape { markers: spec.shape.markers.clone(), ..self.shape.clone() }, self.space.clone());
        let (lookup, surface) = (self.lookup.clone(), Arc::clone(&self.surface));
        Self { name: name.to_owned(), spec, shape, space, assembled, lookup, surface }
    }

    /// Size of the body: the diagonal of the box around its control points \[m\].
    pub fn size(&self) -> f64 {
        self.space.size()
    }

    /// What contact zones on its faces need.
    pub fn discretised(&self) -> Discretised<'_> {
        Discretised {
            patches: &self.shape.patches,
            space: &self.space,
            model: &self.spec.model,
            lookup: &self.lookup,
        }
    }
}

impl Field for ElasticBody {
    fn name(&self) -> &str {
        &self.name
    }

    fn space(&self) -> &dyn Space {
        &self.space
    }

    fn model(&self) -> &Model {
        &self.spec.model
    }

    fn materials(&self) -> &dyn MaterialField {
        &self.spec.material
    }

    fn dofs(&self) -> &[Dof] {
        &self.assembled.dofs
    }

    fn lookup(&self) -> &DofLookup {
        &self.lookup
    }

    fn locate(&self, place: &[f64; 3]) -> Result<(usize, [f64; 3]), AdaptiveError> {
        locate(self, &self.spec.shape, &self.space, place)
    }

    fn points_of(&self, extent: &Extent) -> Result<Vec<ExtentPoint>, AdaptiveError> {
        points_of(self, &self.spec.shape, &self.space, extent)
    }

    fn named_place(&self, marker: &str) -> Result<[f64; 3], AdaptiveError> {
        named_place(self, &self.spec.shape, marker)
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

/// The window of a refinement: elements of equal size in all directions, half as many where the
/// body's surface cuts it.
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
