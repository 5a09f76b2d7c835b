//! Stress along straight lines, from the dynamic and the quasistatic displacement together.

use faer::Mat;
use iga_core::recovery::RecoveryWorkspace;

use crate::elastic_body::{ElasticBody, ReducedBody, point_in_space};
use crate::error::AdaptiveError;
use crate::record::{StressRecord, StressState};
use crate::spec::{StressInstant, StressSpec};

/// A stress request and the state that it waits for.
#[derive(Debug, Clone, PartialEq)]
pub struct StressRequest {
    /// What is asked.
    pub spec: StressSpec,
    /// Best state so far.
    pub state: Option<StressState>,
}

impl StressRequest {
    /// Whether a state at time `time` with contact force `force` \[N\] on the body is the one to keep, so far.
    pub fn wants(&self, time: f64, force: f64) -> bool {
        match self.spec.at {
            StressInstant::PeakForce => self.state.as_ref().is_none_or(|s| force > s.force),
            StressInstant::Time(wanted) => {
                self.state.as_ref().is_none_or(|s| (time - wanted).abs() < (s.time - wanted).abs())
            }
        }
    }

    /// Evaluates the request; `None` if no state was ever kept.
    ///
    /// # Errors
    /// [`AdaptiveError::Geometry`] if a point of the line is not in the body.
    pub fn evaluate(
        &self,
        body: &ElasticBody,
        reduced: &ReducedBody,
    ) -> Result<Option<StressRecord>, AdaptiveError> {
        let Some(state) = &self.state else { return Ok(None) };
        let field = body.control_values(&displacement(reduced, state));
        let mut record =
            StressRecord { name: self.spec.name.clone(), time: state.time, ..StressRecord::default() };
        let mut workspace = RecoveryWorkspace::default();
        for place in line(&self.spec) {
            let (e, xi) = body.locate(&place)?;
            let stress = workspace
                .stress(&body.space, &body.spec.model, &body.spec.material, &field, e, &xi)
                .map_err(|source| AdaptiveError::Geometry { body: body.name.clone(), source })?;
            record.points.push(point_in_space(body.assembled.motion, &place).into());
            record.von_mises.push(stress.von_mises());
            record.stress.push(stress.stress);
        }
        Ok(Some(record))
    }
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
