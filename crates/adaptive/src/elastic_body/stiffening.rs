//! Geometric stiffening of a spline body by inertia forces (docs/theory.md Eq. M.25, E.15).
//!
//! Supported at the marker that its frame follows, the body is stressed by unit inertia loads; the stresses give the modal
//! matrices that [`StandardInputData::with_geometric_stiffening`](ffr_dynamics::body::StandardInputData::with_geometric_stiffening) takes.

use faer::{Mat, MatRef};
use ffr_dynamics::DynamicsError;
use ffr_dynamics::body::{GeometricStiffening, ReferenceLoad, RigidMotion};
use ffr_dynamics::kinematics::MarkerWeights;
use ffr_dynamics::reduction::ElasticProblem;
use iga_core::assembly::geometric_stiffness;

use super::ElasticBody;
use crate::error::AdaptiveError;
use crate::unsupported::Unsupported;

/// Geometric stiffening for the modes `shapes` (n × n_q) of the frame in use, of the body held at `support`, the marker that
/// a tangent frame follows: one factorisation, 6 (plane) or 12 (solid) static problems.
///
/// # Errors
/// [`AdaptiveError::Unsupported`] for an axisymmetric body, which does not turn; [`AdaptiveError::Reduction`] if sizes do not
/// fit or the marker does not follow rigid motions; [`AdaptiveError::Geometry`].
pub fn geometric_stiffening(
    body: &ElasticBody,
    shapes: MatRef<'_, f64>,
    support: &MarkerWeights,
) -> Result<GeometricStiffening, AdaptiveError> {
    let assembled = &body.assembled;
    if assembled.motion == RigidMotion::Axial {
        let what = Unsupported::StiffeningOfAxisymmetric;
        return Err(AdaptiveError::unsupported_body(&body.name, what));
    }
    let displacements = reference_displacements(body, support).map_err(|source| failed(body, source))?;
    let fields: Vec<Vec<f64>> = displacements
        .col_iter()
        .map(|u| body.discretised().control_values(&u.iter().copied().collect::<Vec<f64>>()))
        .collect();
    let matrices = geometric_stiffness(&body.space, &body.spec.model, &body.spec.material, &fields)
        .map_err(|source| AdaptiveError::Geometry { body: body.name.clone(), source })?;
    let mut matrices = matrices.into_iter();
    // The loads come in the order in which they were solved for.
    GeometricStiffening::from_nodal(assembled, shapes, |_| Ok::<_, DynamicsError>(matrices.next()))
        .map_err(|source| failed(body, source))
}

/// Displacements (n × 6 or 12) of the body held at `support` under the loads of [`ReferenceLoad::all`], in their order.
fn reference_displacements(body: &ElasticBody, support: &MarkerWeights) -> Result<Mat<f64>, DynamicsError> {
    let assembled = &body.assembled;
    support.check_rigid_motions(assembled)?;
    let mut loads = Mat::zeros(assembled.dofs.len(), ReferenceLoad::all(assembled.motion).count());
    for (j, load) in ReferenceLoad::all(assembled.motion).enumerate() {
        for (i, force) in assembled.reference_load(load)?.into_iter().enumerate() {
            loads[(i, j)] = force;
        }
    }
    let reactions = support.forces(assembled.motion, assembled.dofs.len())?;
    ElasticProblem::free(assembled, &[])?.held_at_point(loads.as_ref(), reactions.as_ref())
}

fn failed(body: &ElasticBody, source: DynamicsError) -> AdaptiveError {
    AdaptiveError::Reduction { body: body.name.clone(), source }
}
