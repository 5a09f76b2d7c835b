//! Elements that resolve the kept modes: guessed from the proportions, then checked with finer meshes.
//!
//! Each direction is doubled by itself, those of shapes of several patches together. Frequencies of conforming models fall to their limits from above, so the change tells
//! the error that the direction makes, and the sum over directions that of the mesh (Eqs. N.2, N.3).

use std::fmt;

use super::Candidate;
use super::proportions::{first_elements, lengths};
use crate::error::AdaptiveError;

/// Largest relative error of a kept frequency.
pub const TOLERANCE: f64 = 1e-3;
/// Unknowns of a mesh that is tried, doubled ones included; eigenmodes of larger solids take minutes.
pub const MOST_UNKNOWNS: usize = 40_000;
/// Error over change for a frequency that converges with the square of the size, the slowest that singular nets show; smooth
/// ones with degree p have `1 / (1 - 4^-p)`, which is less.
const ERROR_OVER_CHANGE: f64 = 4.0 / 3.0;
/// Rounds of checking; each may double every direction.
const ROUNDS: usize = 8;
/// Elements grow by no more in a round.
const LARGEST_GROWTH: f64 = 2.0;
/// Share of the tolerance that a mesh aims at when it is refined, so that the next check finds it kept.
const AIM: f64 = 0.5;

/// A mesh that the program has chosen.
#[derive(Debug, Clone, PartialEq)]
pub struct ChosenMesh {
    /// Elements a direction.
    pub elements: Vec<usize>,
    /// Estimated largest relative error of a kept frequency.
    pub error: f64,
    /// Number of modes that it was chosen for.
    pub modes: usize,
}

impl fmt::Display for ChosenMesh {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { elements, error, modes } = self;
        let list = elements.iter().map(usize::to_string).collect::<Vec<_>>().join(" x ");
        write!(out, "{list} elements chosen: the {modes} lowest frequencies are right to {error:.1e}")?;
        if *error > TOLERANCE {
            write!(out, ", not to {TOLERANCE:.0e}, within {MOST_UNKNOWNS} degrees of freedom")?;
        }
        Ok(())
    }
}

/// Elements a direction that resolve `n_modes` modes of `candidate`, and the estimated error of their frequencies.
///
/// # Errors
/// [`AdaptiveError`] naming the body.
pub fn mesh(candidate: &Candidate<'_>, n_modes: usize) -> Result<(Vec<usize>, f64), AdaptiveError> {
    let shape = &candidate.spec.shape;
    let mut elements = first_elements(shape, &lengths(shape), n_modes);
    let mut check = Check::new(candidate, n_modes);
    for round in 1.. {
        let mut errors = check.errors(&elements, Known::Converged)?;
        if errors.iter().sum::<f64>() <= TOLERANCE {
            errors = check.errors(&elements, Known::OnThisMesh)?;
        }
        let error = errors.iter().sum::<f64>();
        let next = refined(&elements, &errors, &check.groups, candidate.degrees());
        let finer = check.groups.iter().map(|group| candidate.unknowns(&doubled(&next, group)));
        let tried = finer.max().unwrap_or(0);
        let is_last = round == ROUNDS || tried > MOST_UNKNOWNS;
        tracing::debug!(?elements, ?errors, "mesh checked");
        if error <= TOLERANCE || is_last {
            return Ok((elements, error));
        }
        elements = next;
    }
    unreachable!("the last round returns")
}

/// `elements` with those of the directions of `group` halved.
fn doubled(elements: &[usize], group: &[usize]) -> Vec<usize> {
    let mut finer = elements.to_vec();
    group.iter().for_each(|&d| finer[d] *= 2);
    finer
}

/// Errors that need not be found again.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Known {
    /// Those found on the very mesh.
    OnThisMesh,
    /// Those of directions that have not been refined since, where they were no more than their share: enough to go on refining.
    Converged,
}

/// What the check of a candidate's meshes has found so far.
struct Check<'a> {
    candidate: &'a Candidate<'a>,
    n_modes: usize,
    /// Directions that are refined together.
    groups: Vec<Vec<usize>>,
    /// For each group, the first one that the shape cannot be told from.
    equivalent_directions: Vec<usize>,
    /// Frequencies \[Hz\] of the meshes solved: where one direction alone is doubled, they serve the next round.
    solved: Vec<(Vec<usize>, Vec<f64>)>,
    /// Mesh and error of the last check of each group.
    last: Vec<Option<(Vec<usize>, f64)>>,
}

impl<'a> Check<'a> {
    fn new(candidate: &'a Candidate<'a>, n_modes: usize) -> Self {
        let groups = candidate.groups();
        // Directions that stand alone are their groups.
        let equivalent_directions =
            if groups.len() == 1 { vec![0] } else { candidate.equivalent_directions() };
        let last = vec![None; groups.len()];
        Self { candidate, n_modes, groups, equivalent_directions, solved: Vec::new(), last }
    }

    /// Largest relative error of the lowest frequencies that each group makes.
    fn errors(&mut self, elements: &[usize], known: Known) -> Result<Vec<f64>, AdaptiveError> {
        let mut errors: Vec<f64> = Vec::with_capacity(self.groups.len());
        for g in 0..self.groups.len() {
            let twin = self.equivalent_directions[g];
            let error = match self.last[g].as_ref().filter(|last| self.is_known(known, last, elements, g)) {
                Some((_, error)) => *error,
                None if twin < g && elements[twin] == elements[g] => errors[twin],
                None => self.error(elements, g)?,
            };
            errors.push(error);
        }
        Ok(errors)
    }

    /// Whether the last error of group `g` does for `elements`.
    fn is_known(&self, known: Known, (of, error): &(Vec<usize>, f64), elements: &[usize], g: usize) -> bool {
        let is_unchanged = self.groups[g].iter().all(|&d| of[d] == elements[d]);
        of == elements || (known == Known::Converged && is_unchanged && *error <= share(self.groups.len()))
    }

    fn error(&mut self, elements: &[usize], g: usize) -> Result<f64, AdaptiveError> {
        let finer = doubled(elements, &self.groups[g]);
        let (coarse, fine) = (self.frequencies(elements)?, self.frequencies(&finer)?);
        let changes = coarse.iter().zip(&fine).map(|(c, f)| (c / f - 1.0).abs());
        let error = ERROR_OVER_CHANGE * changes.fold(0.0, f64::max);
        self.last[g] = Some((elements.to_vec(), error));
        Ok(error)
    }

    fn frequencies(&mut self, elements: &[usize]) -> Result<Vec<f64>, AdaptiveError> {
        if let Some((_, known)) = self.solved.iter().find(|(of, _)| of == elements) {
            return Ok(known.clone());
        }
        let found = self.candidate.spectrum(elements, self.n_modes)?.frequencies;
        self.solved.push((elements.to_vec(), found.clone()));
        Ok(found)
    }
}

/// Part of the error that each of `n` groups may make for a mesh to be kept at once.
fn share(n: usize) -> f64 {
    AIM * TOLERANCE / n as f64
}

/// More elements in the groups of directions that make more than their share of the error, by the rate of smooth modes (Eq. E.13).
fn refined(elements: &[usize], errors: &[f64], groups: &[Vec<usize>], degrees: &[usize]) -> Vec<usize> {
    let share = share(groups.len());
    let mut next = elements.to_vec();
    for (group, error) in groups.iter().zip(errors).filter(|(_, error)| **error > share) {
        for &d in group {
            let growth = (error / share).powf(0.5 / degrees[d] as f64).min(LARGEST_GROWTH);
            next[d] = ((elements[d] as f64 * growth).ceil() as usize).max(elements[d] + 1);
        }
    }
    next
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_directions_that_err_are_refined() {
        // 64 times its share with rate 2 p = 6: twice the elements.
        let share = AIM * TOLERANCE / 2.0;
        let (apart, together) = ([vec![0], vec![1]], [vec![0, 1]]);
        assert_eq!(refined(&[4, 10], &[0.5 * share, 64.0 * share], &apart, &[3, 3]), [4, 20]);
        assert_eq!(refined(&[4, 10], &[1.1 * share, 1e9], &apart, &[3, 3]), [5, 20]);
        assert_eq!(refined(&[4, 4], &[128.0 * share], &together, &[3, 3]), [8, 8]);
    }

    #[test]
    fn the_sentence_tells_when_the_error_is_too_large() {
        let mesh = |error| ChosenMesh { elements: vec![2, 40], error, modes: 20 }.to_string();
        assert_eq!(mesh(2.5e-4), "2 x 40 elements chosen: the 20 lowest frequencies are right to 2.5e-4");
        assert!(mesh(2e-3).ends_with(", not to 1e-3, within 40000 degrees of freedom"));
    }
}
