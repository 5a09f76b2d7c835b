//! How many modes a body keeps: those that the forces of its impacts set in motion.

use std::f64::consts::PI;
use std::fmt;

use ffr_dynamics::body::RigidMotion;
use ffr_dynamics::reduction::eigen::neighbouring_counts;

use super::Trial;
use super::impact_time::ForceTime;
use super::proportions::{first_elements, lengths};
use crate::elastic_body::rigid_motion;
use crate::error::AdaptiveError;

/// Modes of a body on which no contact acts.
pub const WITHOUT_FORCES: usize = 20;
/// Most modes that are chosen.
pub const MOST: usize = 300;
/// Share of a pulse's energy above the highest kept frequency. Amplitudes go with its root, 1 %, most of which the static
/// answer of what is left out makes good.
const NEGLECTED: f64 = 1e-4;

/// Least number of modes of a body: ten distinct frequencies, which lie in groups where the model has bending or rotations.
pub fn least(motion: RigidMotion) -> usize {
    if motion == RigidMotion::Axial { 10 } else { 20 }
}

/// Frequency \[Hz\] above which the spectrum of half a sine of `duration` \[s\] has the share `NEGLECTED` of its energy (Eq. N.5).
pub fn pulse_frequency(duration: f64) -> f64 {
    (4.0 * PI / (3.0 * NEGLECTED)).cbrt() / (2.0 * PI * duration)
}

/// A number of modes that the program has chosen.
#[derive(Debug, Clone, PartialEq)]
pub struct ChosenModes {
    /// Number of modes.
    pub modes: usize,
    /// Frequency of the highest one \[Hz\].
    pub highest: f64,
    /// What the forces on the body ask for; `None` without contacts.
    pub time: Option<ForceTime>,
}

impl ChosenModes {
    /// Whether more modes would be needed than are ever chosen.
    pub fn is_cut(&self) -> bool {
        self.time.as_ref().is_some_and(|t| t.frequency > self.highest) && self.modes >= MOST
    }
}

impl fmt::Display for ChosenModes {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { modes, highest, time } = self;
        write!(out, "{modes} modes chosen, up to {highest:.4e} Hz: ")?;
        match time {
            None => write!(out, "no contact acts on the body"),
            Some(time) => write!(out, "{time}"),
        }
    }
}

/// Number of modes of `trial` up to the frequency `limit` \[Hz\], between the least and `most`, and the frequency of the last.
///
/// # Errors
/// [`AdaptiveError`] naming the body.
pub fn count(trial: &Trial<'_>, limit: f64, most: usize) -> Result<(usize, f64), AdaptiveError> {
    let motion = rigid_motion(&trial.spec.model);
    let least = if limit > 0.0 { least(motion) } else { WITHOUT_FORCES };
    let most = most.min(MOST);
    // A few modes more show whether the count cuts through a group.
    let mut wanted = least + GROUP;
    loop {
        let elements = if trial.chooses_elements {
            let shape = &trial.spec.shape;
            first_elements(shape, &lengths(shape), wanted)
        } else {
            trial.spec.discretisation.elements.clone()
        };
        let spectrum = trial.spectrum(&elements, wanted)?;
        let known = spectrum.frequencies;
        let below = known.partition_point(|f| *f <= limit);
        let is_enough = below + GROUP <= known.len() || spectrum.is_complete || wanted >= most + GROUP;
        if is_enough {
            let n = whole_group(&known, below.max(least).min(most).min(known.len()), motion).min(most);
            return Ok((n, known.get(n.saturating_sub(1)).copied().unwrap_or(0.0)));
        }
        wanted = (2 * wanted).min(most + GROUP);
    }
}

/// Modes beyond those wanted, as many as the largest group of equal frequencies of low modes of a ball.
const GROUP: usize = 9;

/// `n`, or more so that no group of equal frequencies is cut.
fn whole_group(known: &[f64], n: usize, motion: RigidMotion) -> usize {
    // Modes about an axis are simple: frequencies that happen to lie close together are no group.
    if motion == RigidMotion::Axial {
        return n;
    }
    neighbouring_counts(known, n).map_or(n, |(_, more)| more)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_neglected_share_of_half_a_sine_is_what_it_says() {
        // |F|^2 = (2 pi cos(w/2) / (pi^2 - w^2))^2 of a pulse of length and height one; the whole integral is pi/2.
        let power = |w: f64| (2.0 * PI * (0.5 * w).cos() / (PI * PI - w * w)).powi(2);
        let start = 2.0 * PI * pulse_frequency(1.0);
        let (n, end) = (2_000_000, 4000.0);
        let step = (end - start) / f64::from(n);
        let tail: f64 = (0..n).map(|i| power(start + (f64::from(i) + 0.5) * step) * step).sum();
        let share = tail / (0.5 * PI);
        // The closed form has the mean of cos^2 and w^-4 for the whole tail: next terms are (pi/w)^2 = 0.8 % and the first
        // swing of the cosine, a tenth.
        assert!((share / NEGLECTED - 1.0).abs() < 0.15, "{share}");
    }

    #[test]
    fn groups_are_kept_whole() {
        let known = [1.0, 2.0, 2.0, 2.0, 3.0];
        assert_eq!(whole_group(&known, 2, RigidMotion::Spatial), 4);
        assert_eq!(whole_group(&known, 4, RigidMotion::Spatial), 4);
        assert_eq!(whole_group(&known, 2, RigidMotion::Axial), 2);
    }
}
