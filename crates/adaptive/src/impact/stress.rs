//! Stress along straight lines, from the dynamic and the quasistatic displacement together.
//!
//! Stress is linear: that of the modes and of the interface the body was reduced for comes from its
//! own model, and that of zones refined during the run from their fine models, built again for it
//! (theory Eq. A.17).

use faer::Mat;
use iga_core::elasticity::kinematics::von_mises;

use crate::body::reduced::ReducedBody;
use crate::error::AdaptiveError;
use crate::impact::ZoneModel;
use crate::record::{StressRecord, StressState};
use crate::spec::StressSpec;
use crate::system::body::FlexibleModel;

/// Stress along the line of `request` in the state `state` of `body`, with the models of the zones
/// that were refined during the run (theory Eqs. A.17, Q.7).
///
/// # Errors
/// [`AdaptiveError::Geometry`] or [`AdaptiveError::Mesh`] if a point of the line is not in the body.
pub fn evaluate(
    request: &StressSpec,
    body: &FlexibleModel,
    zones: &[ZoneModel],
    state: &StressState,
) -> Result<StressRecord, AdaptiveError> {
    let own = displacement(&body.reduced, state);
    let on_zones = zones.iter().zip(&state.zones);
    let on_zones: Vec<(&ZoneModel, Vec<f64>)> =
        on_zones.map(|(zone, load)| (zone, zone.residual.displacement(&load.forces))).collect();
    let mut record = StressRecord { name: request.name.clone(), time: state.time, ..StressRecord::default() };
    for place in line(request) {
        let mut sum = body.body.gauge_at(&place)?.at(body.lookup(), &own);
        for (zone, u) in &on_zones {
            sum.add_scaled(&zone.model.field().gauge_at(&place)?.at(zone.model.field().lookup(), u), 1.0);
        }
        record.points.push(body.motion().in_space(&place).into());
        record.von_mises.push(von_mises(&sum.stress));
        record.stress.push(sum.stress);
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
