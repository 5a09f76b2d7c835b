//! How many modes per body keeps: those that the forces of its impacts set in motion.

use std::fmt;

use ffr_dynamics::body::RigidMotion;
use ffr_dynamics::reduction::neighbouring_counts;

use super::impact_time::{ForceTime, TimeScale};
use super::mesh::CHECKED;
use super::{Candidate, Spectrum};
use crate::body::splines::rigid_motion;
use crate::error::AdaptiveError;
use crate::sizing::mesh::first_elements::first_elements;
use crate::spec::{Accuracy, ReductionSpec};

/// Modes of a body on which no contact acts.
pub const WITHOUT_FORCES: usize = 20;
/// Most modes that are chosen.
pub const MOST: usize = 300;
/// Most modes that are chosen for a force that jumps: each further one makes it rise a little sooner, none is the last that counts.
pub const MOST_OF_JUMPS: usize = 80;
/// Least number of modes of a body: ten distinct frequencies, which lie in groups where the model has bending or rotations.
pub fn least(motion: RigidMotion) -> usize {
    if motion == RigidMotion::Axial { 10 } else { 20 }
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
        let is_cut = |t: &ForceTime| t.scale != TimeScale::Flat && t.frequency > self.highest;
        self.time.as_ref().is_some_and(is_cut) && self.modes >= MOST
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

/// Number of modes of `candidate` up to the frequency `limit` \[Hz\], between the least and `most`, and the frequency of the last. What was solved
/// for goes to `solved`.
///
/// # Errors
/// [`AdaptiveError`] naming the body.
pub fn count(
    candidate: &Candidate<'_>,
    limit: f64,
    most: usize,
    solved: &mut Vec<Spectrum>,
) -> Result<(usize, f64), AdaptiveError> {
    let motion = rigid_motion(&candidate.spec.model);
    let least = candidate.accuracy.modes(if limit > 0.0 { least(motion) } else { WITHOUT_FORCES });
    // A few modes more show whether the count cuts through a group.
    let (mut wanted, mut resolved) = (least + GROUP, least.min(CHECKED));
    let spectrum = loop {
        let elements = if candidate.chooses_elements {
            first_elements(&candidate.spec, resolved)
        } else {
            candidate.spec.discretisation.elements.clone()
        };
        let is_last = wanted >= most + GROUP;
        // A count in single precision is as good as certain; the frequencies are.
        let reaches = |s: &Spectrum| {
            s.frequencies.partition_point(|f| *f <= limit) + GROUP <= s.frequencies.len() || s.is_complete
        };
        let below = if is_last || limit <= 0.0 {
            break candidate.spectrum(&elements, wanted)?;
        } else {
            match candidate.spectrum_reaching(&elements, (limit, wanted, GROUP))? {
                Ok(spectrum) if reaches(&spectrum) => break spectrum,
                Ok(_) => wanted,
                Err(below) => below,
            }
        };
        wanted = (below + below / 4 + GROUP).max(wanted + least).min(most + GROUP);
        // Where half the waves have two elements a half wave, the shortest ones are right to a per cent: enough to count them.
        resolved = wanted / 2;
    };
    let chosen = chosen_from(&spectrum.frequencies, limit, (least, most), motion);
    solved.push(spectrum);
    Ok(chosen)
}

/// Number of the frequencies `known` \[Hz\] up to `limit`, between `least` and `most` and without cutting a group, and the last of them.
pub fn chosen_from(
    known: &[f64],
    limit: f64,
    (least, most): (usize, usize),
    motion: RigidMotion,
) -> (usize, f64) {
    let below = known.partition_point(|f| *f <= limit);
    let n = whole_group(known, below.max(least).min(most).min(known.len()), motion).min(most);
    (n, known.get(n.saturating_sub(1)).copied().unwrap_or(0.0))
}

/// Most modes of a body that is reduced by `reduction`, with the fastest force on it.
pub fn most(reduction: ReductionSpec, accuracy: Accuracy, time: Option<&ForceTime>) -> usize {
    let is_jump = time.is_some_and(|t| t.scale == TimeScale::Flat);
    let most = if is_jump { accuracy.modes(MOST_OF_JUMPS) } else { MOST };
    match reduction {
        ReductionSpec::CraigBampton { fixed_interface_modes: Some(n), .. } => n.min(most),
        _ => most,
    }
}

/// Modes beyond those wanted, as many as the largest group of equal frequencies of low modes of a ball.
pub const GROUP: usize = 9;

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
    fn groups_are_kept_whole() {
        let known = [1.0, 2.0, 2.0, 2.0, 3.0];
        assert_eq!(whole_group(&known, 2, RigidMotion::Spatial), 4);
        assert_eq!(whole_group(&known, 4, RigidMotion::Spatial), 4);
        assert_eq!(whole_group(&known, 2, RigidMotion::Axial), 2);
    }
}
