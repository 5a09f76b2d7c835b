//! Damping of bodies that joints hold (docs/theory.md Eq. F.29 to F.33).

use ffr_dynamics::DynamicsError;
use ffr_dynamics::body::ModalDamping;
use ffr_dynamics::system::OwnDamping;

use super::BodyModel;
use crate::body::reduced::damping::{damping, law};
use crate::error::AdaptiveError;
use crate::spec::{DampingSpec, RunSpec};
use crate::state::simulation::System;

/// Lets the damping ratios of the bodies hold for the modes of the system as it is joined in the
/// pose of `y` at time `t` (Eq. F.29 to F.33).
///
/// # Errors
/// [`AdaptiveError::Reduction`] with the body's name, [`AdaptiveError::Model`] of the system.
pub(super) fn hold(
    spec: &RunSpec,
    bodies: &mut [BodyModel],
    system: &mut System,
    (t, y): (f64, &[f64]),
) -> Result<(), AdaptiveError> {
    let of_body = |(i, body): (usize, &BodyModel)| {
        let asked = spec.bodies[i].kind.flexible().map(|flexible| &flexible.damping);
        let Some(asked) = asked.filter(|asked| **asked != DampingSpec::None) else { return Ok(None) };
        own(asked, body).map_err(|source| AdaptiveError::Reduction { body: body.name.clone(), source })
    };
    let all = bodies.iter().enumerate().map(of_body).collect::<Result<Vec<_>, AdaptiveError>>()?;
    if all.iter().all(Option::is_none) {
        return Ok(());
    }
    system.set_held_damping((t, y), &all).map_err(AdaptiveError::Model)?;
    for (body, in_system) in bodies.iter_mut().zip(&system.model().bodies) {
        body.data.modal_damping.clone_from(&in_system.data.modal_damping);
    }
    Ok(())
}

/// The damping ratios of `body` by its own law; its model still has the damping of the free body.
fn own(asked: &DampingSpec, body: &BodyModel) -> Result<Option<OwnDamping>, DynamicsError> {
    let Some(law) = law(asked)? else { return Ok(None) };
    let stiffness = &body.data.modal_stiffness;
    let n = stiffness.len();
    let counts = body.coordinates();
    let n_static: usize = counts.answers.iter().map(|(_, count)| count).sum();
    let n_modes = if counts.interface == 0 { n - n_static.min(n) } else { n };
    let ModalDamping::PerMode(free) = damping(asked, stiffness, n_modes)? else { return Ok(None) };
    let added = match &body.data.modal_damping {
        ModalDamping::PerMode(whole) => whole.iter().zip(&free).map(|(a, b)| (a - b).max(0.0)).collect(),
        ModalDamping::None | ModalDamping::Full(_) => Vec::new(),
    };
    let highest = stiffness[..n_modes].iter().fold(0.0, |top: f64, k| top.max(k.sqrt()));
    Ok(Some(OwnDamping { law, highest, free, added }))
}
