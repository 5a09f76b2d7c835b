//! How many modes per body keeps: those that the forces of its impacts set in motion.

use std::fmt;

use ffr_dynamics::body::RigidMotion;
use ffr_dynamics::reduction::neighbouring_counts;

use super::impact_time::ForceTime;
use super::mesh::CHECKED;
use super::spectrum::{FrequencyProblem, Known};
use super::{Candidate, Spectrum};
use crate::error::AdaptiveError;
use crate::sizing::mesh::first_elements::first_elements;
use crate::spec::{Accuracy, ReductionSpec};

/// Modes of a body on which no contact acts.
pub const WITHOUT_FORCES: usize = 20;
/// Most modes that are chosen.
pub const MOST: usize = 300;
/// Most modes that are chosen for a force that jumps: each further one makes it rise a little
/// sooner, none is the last that counts.
pub const MOST_OF_JUMPS: usize = 80;
/// Least number of modes of a body: ten distinct frequencies, which lie in groups where the model
/// has bending or rotations.
pub fn least(motion: RigidMotion) -> usize {
    if motion == RigidMotion::Axial { 10 } else { 20 }
}

/// A number of modes that the program has chosen.
#[derive(Debug, Clone, PartialEq)]
pub struct ChosenModes {
    /// Number of modes.
    pub modes: usize,
    /// Frequency of the highest one \[Hz\]; `None` where forces ask for more than are ever chosen.
    pub highest: Option<f64>,
    /// Frequency up to which a mesh carries waves, where the force asks for higher ones \[Hz\].
    pub carried: Option<f64>,
    /// The force that determines the number; `None` without contacts.
    pub time: Option<ForceTime>,
}

impl ChosenModes {
    /// Whether more modes would be needed than are ever chosen, and they would count.
    pub fn is_cut(&self) -> bool {
        let is_beyond = |t: &ForceTime| self.highest.is_none_or(|highest| t.frequency > highest);
        self.time.as_ref().is_some_and(|t| !t.scale.is_jump() && is_beyond(t)) && self.modes >= MOST
    }
}

impl fmt::Display for ChosenModes {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { modes, highest, carried, time } = self;
        match highest {
            Some(highest) => write!(out, "{modes} modes chosen, up to {highest:.4e} Hz: ")?,
            None => write!(out, "{modes} modes chosen, the most that ever are: ")?,
        }
        match time {
            None => write!(out, "no contact acts on the body")?,
            Some(time) => write!(out, "{time}")?,
        }
        carried.map_or(Ok(()), |carried| write!(out, "; its mesh carries waves up to {carried:.2e} Hz"))
    }
}

/// How many modes of a body may be chosen, and up to where.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ModeRange {
    /// Frequency up to which modes are wanted \[Hz\]; zero where no force acts.
    pub limit: f64,
    /// Least number of them.
    pub least: usize,
    /// Most of them.
    pub most: usize,
}

impl ModeRange {
    /// That of a body with the motions `motion` that is reduced by `reduction`, with the fastest
    /// force on it.
    pub fn new(
        motion: RigidMotion,
        reduction: ReductionSpec,
        accuracy: Accuracy,
        time: Option<&ForceTime>,
    ) -> Self {
        let limit = time.map_or(0.0, |t| t.frequency);
        let least = accuracy.modes(if limit > 0.0 { least(motion) } else { WITHOUT_FORCES });
        let is_jump = time.is_some_and(|t| t.scale.is_jump());
        let most = if is_jump { accuracy.modes(MOST_OF_JUMPS) } else { MOST };
        let most = match reduction {
            ReductionSpec::CraigBampton { fixed_interface_modes: Some(n), .. } => n.min(most),
            _ => most,
        };
        Self { limit, least, most }
    }
}

/// Number of modes of `candidate` in `range`, and the frequency of the last, unless more than are
/// ever chosen lie below the limit. What was solved for goes to `solved`.
///
/// A mesh on which so many lie below it decides even if it is coarse, and a very coarse one is asked
/// first: frequencies of a conforming model lie above those of every finer one (section N.2).
///
/// # Errors
/// [`AdaptiveError`] naming the body.
pub fn count(
    candidate: &Candidate<'_>,
    range: ModeRange,
    solved: &mut Vec<Spectrum>,
) -> Result<(usize, Option<f64>), AdaptiveError> {
    let (motion, ModeRange { limit, least, most }) = (candidate.motion(), range);
    let (mut wanted, mut resolved) = (least, least.min(CHECKED));
    if candidate.wish.elements && limit > 0.0 {
        let body = candidate.build(&first_elements(&candidate.spec, resolved / 4))?;
        let problem = FrequencyProblem::new(candidate.name, &body.assembled, &candidate.digits)?;
        if problem.below(limit)? >= most.max(least) {
            return Ok((most, None));
        }
    }
    loop {
        let elements = if candidate.wish.elements {
            first_elements(&candidate.spec, resolved)
        } else {
            candidate.spec.discretisation.elements.clone()
        };
        let _work = candidate.trial(&elements);
        let body = candidate.build(&elements)?;
        let problem = FrequencyProblem::new(candidate.name, &body.assembled, &candidate.digits)?;
        // The check of the mesh asks for the lowest ones anyway.
        if wanted == least && (candidate.wish.elements || limit <= 0.0) {
            let lowest = problem.lowest(least + GROUP)?;
            let found = Known { first: 0, frequencies: lowest.frequencies.clone() };
            let reaches = found.below(limit) <= least || lowest.is_complete;
            solved.push(Spectrum { elements, ..lowest });
            if reaches {
                return Ok(chosen_from(&found, range, motion));
            }
        }
        let found = problem.next_to(limit, GROUP, most.max(least))?;
        let below = found.below(limit);
        if below <= wanted || below >= most || !candidate.wish.elements {
            return chosen_on(&problem, &found, range);
        }
        wanted = (below + below / 4).max(wanted + least).min(most);
        // Where half the waves have two elements a half wave, the shortest ones are right to a per
        // cent: enough to count them.
        resolved = (wanted + GROUP) / 2;
    }
}

/// As [`chosen_from`] where `found` are the frequencies of `problem` next to the limit: others are
/// found if they decide.
///
/// # Errors
/// [`AdaptiveError`] naming the body.
pub fn chosen_on(
    problem: &FrequencyProblem<'_>,
    found: &Known,
    range: ModeRange,
) -> Result<(usize, Option<f64>), AdaptiveError> {
    let ModeRange { limit, least, most } = range;
    let (motion, below) = (problem.motion(), found.below(limit));
    if below >= most.max(least) {
        return Ok((most, None));
    }
    let wanted = below.max(least);
    if (found.first + 1..=found.first + found.frequencies.len()).contains(&wanted) {
        return Ok(chosen_from(found, range, motion));
    }
    // A few modes more show whether the count cuts through a group.
    let frequencies = problem.lowest(wanted + GROUP)?.frequencies;
    Ok(chosen_from(&Known { first: 0, frequencies }, range, motion))
}

/// Number of frequencies in `range`, of which those next to its limit are `known`, without cutting
/// a group, and the last of them \[Hz\].
pub fn chosen_from(known: &Known, range: ModeRange, motion: RigidMotion) -> (usize, Option<f64>) {
    let (Known { first, frequencies }, ModeRange { limit, least, most }) = (known, range);
    let n = known.below(limit).max(least).min(most).min(first + frequencies.len());
    let n = (first + whole_group(frequencies, n.saturating_sub(*first), motion)).min(most);
    (n, frequencies.get(n.saturating_sub(first + 1)).copied())
}

/// Modes beyond those wanted, as many as the largest group of equal frequencies of low modes of a
/// ball.
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

    #[test]
    fn what_lies_next_to_the_limit_decides_as_all_frequencies_do() {
        let all = [1.0, 2.0, 2.0, 2.0, 3.0, 4.0, 5.0];
        let of = |first: usize, limit: f64| {
            let known = Known { first, frequencies: all[first..].to_vec() };
            chosen_from(&known, ModeRange { limit, least: 1, most: 6 }, RigidMotion::Spatial)
        };
        for (first, limit, expected) in
            [(1, 2.0, (4, 2.0)), (2, 2.5, (4, 2.0)), (4, 3.5, (5, 3.0)), (5, 9.0, (6, 4.0))]
        {
            let expected = (expected.0, Some(expected.1));
            assert_eq!((of(first, limit), of(0, limit)), (expected, expected), "{limit}");
        }
    }
}
