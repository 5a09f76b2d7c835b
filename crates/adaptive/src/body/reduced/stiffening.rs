//! Geometric stiffening of a body by inertia forces (docs/theory.md Eq. M.43, E.13).
//!
//! Supported at the marker that its frame follows, the body is stressed by unit inertia loads; the
//! stresses give the modal matrices that
//! [`StandardInputData::with_geometric_stiffening`](ffr_dynamics::body::StandardInputData::with_geometric_stiffening)
//! takes.

use faer::{Mat, MatRef};
use ffr_dynamics::DynamicsError;
use ffr_dynamics::body::{AssembledBody, GeometricStiffening, ReferenceLoad, RigidMotion};
use ffr_dynamics::kinematics::MarkerWeights;
use ffr_dynamics::reduction::ElasticProblem;
use iga_core::elasticity::assembly::geometric_stiffness;

use crate::body::field::Field;
use crate::error::AdaptiveError;

/// Geometric stiffening for the modes `shapes` (n × n_q) of the frame in use, of the body with the
/// field `field` and the matrices `assembled`, held at `support`, the marker that a tangent frame
/// follows: one factorisation, 6 (plane) or 12 (solid) static problems.
///
/// # Errors
/// [`AdaptiveError::Unsupported`] for an axisymmetric body, which does not turn; [`AdaptiveError::Reduction`] if sizes do not
/// fit or the marker does not follow rigid motions; [`AdaptiveError::Geometry`].
pub fn geometric_stiffening(
    field: &(impl Field + ?Sized),
    assembled: &AssembledBody,
    shapes: MatRef<'_, f64>,
    support: &MarkerWeights,
) -> Result<GeometricStiffening, AdaptiveError> {
    let failed = |source| AdaptiveError::Reduction { body: field.name().to_owned(), source };
    if assembled.motion == RigidMotion::Axial {
        let what =
            "an axisymmetric body does not turn and has no geometric stiffening, use a solid model".into();
        return Err(AdaptiveError::unsupported_body(field.name(), what));
    }
    let displacements = reference_displacements(assembled, support).map_err(failed)?;
    let fields: Vec<Vec<f64>> = displacements
        .col_iter()
        .map(|u| field.control_values(&u.iter().copied().collect::<Vec<f64>>()))
        .collect();
    let matrices = geometric_stiffness(field.space(), field.model(), field.materials(), &fields)
        .map_err(|source| field.geometry_fault(source))?;
    let mut matrices = matrices.into_iter();
    // The loads come in the order in which they were solved for.
    GeometricStiffening::from_nodal(assembled, shapes, |_| Ok::<_, DynamicsError>(matrices.next()))
        .map_err(failed)
}

/// Displacements (n × 6 or 12) of the body held at `support` under the loads of
/// [`ReferenceLoad::all`], in their order.
fn reference_displacements(
    assembled: &AssembledBody,
    support: &MarkerWeights,
) -> Result<Mat<f64>, DynamicsError> {
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
