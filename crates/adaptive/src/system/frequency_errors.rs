//! By how much meshes put frequencies off (docs/theory/uncertainty.md Eq. U.7).

use super::body::{BodyForm, BodyModel};

/// Relative errors of the frequencies of a body by its mesh (Eq. U.7).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrequencyErrors {
    /// What the choice of the mesh found.
    known: Option<f64>,
    /// That of the wave of the frequency \[Hz\] on the mesh (Eq. P.7), and the power of the frequency with which it falls at least, that of
    /// bending.
    of_wave: Option<(f64, f64, f64)>,
}

impl FrequencyErrors {
    /// Those of `body` with what is `known` of its mesh; none of a body whose mesh is not there.
    pub fn new(body: &BodyModel, known: Option<f64>) -> Option<Self> {
        if matches!(body.form, BodyForm::Imported(_)) {
            return None;
        }
        // The mesh is asked once, for it is slow to answer.
        let ask = || {
            let highest = body.frequencies().into_iter().reduce(f64::max).filter(|f| *f > 0.0)?;
            let (error, _, worst) = body.flexible()?.body.carried_waves()?.error(highest)?;
            Some((highest, error, worst.degree as f64))
        };
        Some(Self { known, of_wave: known.is_none().then(ask).flatten() })
    }

    /// That of a frequency \[Hz\]: zero of a rigid body.
    pub fn at(&self, frequency: f64) -> f64 {
        let of_wave =
            |(highest, error, power): (f64, f64, f64)| error * (frequency / highest).min(1.0).powf(power);
        self.known.or(self.of_wave.map(of_wave)).unwrap_or(0.0)
    }
}
