//! Geometric stiffening of a spline body by inertia forces, and markers of spline bodies (docs/theory.md Eq. M.25, M.34, E.15).
//!
//! Supported at the marker that its frame follows, the body is stressed by unit inertia loads; the stresses give the modal
//! matrices that [`StandardInputData::with_geometric_stiffening`](ffr_dynamics::body::StandardInputData::with_geometric_stiffening) takes.

use faer::{Mat, MatRef};
use ffr_dynamics::DynamicsError;
use ffr_dynamics::body::{GeometricStiffening, ReferenceLoad, RigidMotion};
use ffr_dynamics::kinematics::MarkerWeights;
use ffr_dynamics::reduction::ElasticProblem;
use iga_core::assembly::geometric_stiffness;
use iga_core::recovery::RecoveryWorkspace;
use nalgebra::{UnitQuaternion, Vector3};

use crate::elastic_body::{Discretised, ElasticBody, point_in_space};
use crate::error::AdaptiveError;

/// Share of the largest weight below which an unknown does not count for a marker: round-off of basis functions that vanish there.
const ROUND_OFF: f64 = 1e-12;

/// The marker at `place` (model's components \[m\]) with the orientation `rotation` in the body's frame: it moves with the material
/// point and turns by half the curl of the displacement.
///
/// # Errors
/// [`AdaptiveError::Geometry`] if the point is not in the body, [`AdaptiveError::Reduction`] if its orientation is not finite.
pub fn marker_weights(
    body: &ElasticBody,
    place: &[f64; 3],
    rotation: UnitQuaternion<f64>,
) -> Result<MarkerWeights, AdaptiveError> {
    weights_on(&body.discretised(), place, rotation)
}

/// As [`marker_weights`], on a coarse or fine discretisation.
///
/// # Errors
/// As there.
pub fn weights_on(
    body: &Discretised<'_>,
    place: &[f64; 3],
    rotation: UnitQuaternion<f64>,
) -> Result<MarkerWeights, AdaptiveError> {
    let (e, xi) = body.locate(place)?;
    let functions = RecoveryWorkspace::default()
        .functions(body.space, e, &xi)
        .map_err(|source| AdaptiveError::Geometry { body: body.name.to_owned(), source })?;
    let motion = body.assembled.motion;
    let mut entries = Vec::new();
    for f in functions {
        let gradient = Vector3::from(f.gradient);
        for c in 0..motion.n_components() {
            let Some(unknown) = body.lookup.number(f.number, c) else { continue };
            let direction = Vector3::ith(motion.direction(c), 1.0);
            let mut w = [0.0; 6];
            if motion != RigidMotion::Axial {
                w[3..].copy_from_slice((0.5 * gradient.cross(&direction)).as_slice());
            } else if c == 0 {
                continue; // around the circumference radial displacements have no mean
            }
            w[..3].copy_from_slice((f.value * direction).as_slice());
            entries.push((unknown as u32, w));
        }
    }
    drop_round_off(&mut entries);
    entries.sort_by_key(|(unknown, _)| *unknown);
    MarkerWeights::new(point_in_space(motion, place), rotation, entries)
        .map_err(|source| AdaptiveError::Reduction { body: body.name.to_owned(), source })
}

/// Leaves out unknowns that move and turn the marker by round-off only.
fn drop_round_off(entries: &mut Vec<(u32, [f64; 6])>) {
    let largest = |part: std::ops::Range<usize>| {
        entries.iter().flat_map(|(_, w)| &w[part.clone()]).fold(0.0f64, |m, v| m.max(v.abs()))
    };
    let limits = [largest(0..3), largest(3..6)].map(|m| ROUND_OFF * m);
    entries.retain(|(_, w)| w.iter().enumerate().any(|(i, v)| v.abs() > limits[i / 3]));
}

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
        return Err(AdaptiveError::Unsupported {
            subject: format!("body \"{}\"", body.name),
            reason: "an axisymmetric body does not turn and has no geometric stiffening, use a solid model"
                .into(),
        });
    }
    let displacements = reference_displacements(body, support).map_err(|source| failed(body, source))?;
    let fields: Vec<Vec<f64>> = displacements
        .col_iter()
        .map(|u| body.control_values(&u.iter().copied().collect::<Vec<f64>>()))
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
    ElasticProblem::free(assembled, &[])?.supported(loads.as_ref(), reactions.as_ref())
}

fn failed(body: &ElasticBody, source: DynamicsError) -> AdaptiveError {
    AdaptiveError::Reduction { body: body.name.clone(), source }
}
