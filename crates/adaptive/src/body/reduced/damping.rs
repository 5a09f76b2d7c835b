//! Damping of the elastic coordinates of bodies that are reduced here while nothing holds them
//! (docs/theory.md section F.6).

use ffr_dynamics::DynamicsError;
use ffr_dynamics::body::{DampingLaw, ModalDamping, RayleighDamping};

use crate::spec::DampingSpec;

/// The ratios that `spec` asks for; none of an undamped body.
pub(crate) fn law(spec: &DampingSpec) -> Result<Option<DampingLaw>, DynamicsError> {
    Ok(match spec {
        DampingSpec::None => None,
        DampingSpec::Rayleigh { frequencies, ratio } => {
            Some(DampingLaw::Rayleigh(RayleighDamping::from_frequencies(*frequencies, *ratio)?))
        }
        DampingSpec::Modal(ratios) => Some(DampingLaw::Ratios(ratios.clone())),
        DampingSpec::Structural(loss) => Some(DampingLaw::Ratios(vec![0.5 * loss])),
    })
}

/// Damping of the modes of a free body with squared frequencies `stiffness` [rad²/s²], of which
/// those from `n_modes` on are static answers.
///
/// Rayleigh damping grows with the frequency; what stands for a static answer gets critical damping
/// at most, for more would only delay it.
pub(crate) fn damping(
    spec: &DampingSpec,
    stiffness: &[f64],
    n_modes: usize,
) -> Result<ModalDamping, DynamicsError> {
    match law(spec)? {
        None => Ok(ModalDamping::None),
        Some(DampingLaw::Rayleigh(rayleigh)) => {
            let mut damping = rayleigh.modal(stiffness);
            if let ModalDamping::PerMode(coefficients) = &mut damping {
                let answers = coefficients.iter_mut().zip(stiffness).skip(n_modes);
                answers.for_each(|(d, k)| *d = d.min(2.0 * k.sqrt()));
            }
            Ok(damping)
        }
        Some(law) => {
            let all: Vec<f64> = stiffness.iter().enumerate().map(|(j, k)| law.ratio(j, k.sqrt())).collect();
            ModalDamping::from_ratios(&all, stiffness)
        }
    }
}
