//! Stress along straight lines, from the dynamic and the quasistatic displacement together.
//!
//! Stress is linear: that of the modes and of the interface the body was reduced for comes from its own model, and that of zones
//! refined during the run from their fine models, built again for it (theory Eq. A.24).

use faer::Mat;
use iga_core::elasticity::kinematics::von_mises;
use iga_core::recovery::RecoveryWorkspace;
use iga_core::space::Space;

use crate::adaptive_contact::ZoneModel;
use crate::elastic_body::{ElasticBody, ReducedBody};
use crate::error::AdaptiveError;
use crate::fine_model::FineMesh;
use crate::record::{StressRecord, StressState};
use crate::spec::StressSpec;

/// Stress along the line of `request` in the state `state`, with the models of the zones that were refined during the run.
///
/// # Errors
/// [`AdaptiveError::Geometry`] if a point of the line is not in the body.
pub fn evaluate(
    request: &StressSpec,
    (body, reduced): (&ElasticBody, &ReducedBody),
    zones: &[ZoneModel],
    state: &StressState,
) -> Result<StressRecord, AdaptiveError> {
    let coarse = body.discretised();
    let mut fields = vec![(coarse, coarse.control_values(&displacement(reduced, state)))];
    fields.extend(zones.iter().zip(&state.zones).map(|(zone, load)| {
        let mesh = zone.mesh.as_ref().map_or(coarse, FineMesh::discretised);
        (mesh, mesh.control_values(&zone.residual.displacement(&load.forces)))
    }));
    let mut record = StressRecord { name: request.name.clone(), time: state.time, ..StressRecord::default() };
    let mut workspace = RecoveryWorkspace::default();
    let mut at = |space: &dyn Space, field: &[f64], (e, xi): (usize, [f64; 3])| {
        workspace
            .stress(space, &body.spec.model, &body.spec.material, field, e, &xi)
            .map(|found| found.stress)
            .map_err(|source| AdaptiveError::Geometry { body: body.name.clone(), source })
    };
    for place in line(request) {
        let mut stress = [0.0; 6];
        for (mesh, field) in &fields {
            let local = at(mesh.space, field, mesh.locate(&place)?)?;
            stress.iter_mut().zip(local).for_each(|(sum, s)| *sum += s);
        }
        record.points.push(body.assembled.motion.in_space(&place).into());
        record.von_mises.push(von_mises(&stress));
        record.stress.push(stress);
    }
    Ok(record)
}

/// Displacement of all unknowns: `Φ q_e + u_hf(f_b)` \[m\].
fn displacement(reduced: &ReducedBody, state: &StressState) -> Vec<f64> {
    let shapes = &reduced.basis.shapes;
    let q = Mat::from_fn(state.elastic.len(), 1, |i, _| state.elastic[i]);
    let low = shapes * q;
    let mut u: Vec<f64> = low.col(0).iter().copied().collect();
    if let Some(residual) = &reduced.residual {
        let quasistatic = residual.displacement(&state.interface_forces);
        u.iter_mut().zip(quasistatic).for_each(|(u, v)| *u += v);
    }
    u
}

/// Points of the line in the model's components.
fn line(spec: &StressSpec) -> impl Iterator<Item = [f64; 3]> + '_ {
    let [from, to] = spec.ends;
    let last = spec.samples.max(2) - 1;
    (0..=last).map(move |i| {
        let s = i as f64 / last as f64;
        std::array::from_fn(|c| from[c] + s * (to[c] - from[c]))
    })
}
