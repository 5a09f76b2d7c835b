//! Elements that resolve the kept modes: guessed from the proportions, then checked with finer
//! meshes.
//!
//! Each direction is refined by itself, those that shared faces of patches turn into one another
//! together. Frequencies of conforming models fall to their limits from above, so the change tells
//! the error that the direction makes, and the sum over directions that of the mesh (Eqs. N.5,
//! N.6).

pub mod proportions;
pub mod first_elements;

use std::fmt;

use super::{Candidate, Spectrum};
use crate::error::AdaptiveError;
use crate::sizing::mesh::first_elements::{errors_across, first_elements};
use crate::spec::Accuracy;

/// Largest relative error of a kept frequency.
pub const TOLERANCE: f64 = 1e-3;
/// Unknowns of a mesh that is tried, doubled ones included; eigenmodes of larger solids take
/// minutes.
pub const MOST_UNKNOWNS: usize = 40_000;
/// Unknowns up to which a mesh is doubled to check it; larger ones take longer than the body
/// itself.
const CHEAP: usize = 10_000;
/// Error that a user may count on (docs/verification.md); above it twice as many unknowns are
/// tried.
const PROMISED: f64 = 3e-3;
/// Modes whose frequencies are checked. Meshes for more have as many more elements as their waves
/// ask for (Eqs. N.1, N.3), times what the check has found those of the checked ones to want.
pub const CHECKED: usize = 20;
/// Power of the element's size with which errors fall as far as two meshes do not show a smaller
/// one: the least of singular nets; smooth modes have twice the degree.
const USUAL: f64 = 2.0;
/// Rounds of checking; each may double every direction.
const ROUNDS: usize = 8;
/// Elements grow by no more in a round.
const LARGEST_GROWTH: f64 = 2.0;
/// Least power of the element's size with which errors are taken to fall: layers at free edges, as
/// long as elements are longer than the body is thick.
const SLOWEST: f64 = 1.0;
/// Error below which a mesh has the shape of the modes, so that a finer one shows the rate.
const RESOLVED: f64 = 1e-2;
/// Share of the tolerance that a mesh aims at when it is refined, so that the next check finds it
/// kept.
const AIM: f64 = 0.5;

/// A mesh that the program has chosen.
#[derive(Debug, Clone, PartialEq)]
pub struct ChosenMesh {
    /// Elements per direction.
    pub elements: Vec<usize>,
    /// Estimated largest relative error of a kept frequency.
    pub error: f64,
    /// Number of modes that it was chosen for.
    pub modes: usize,
    /// Level at which it was chosen.
    pub accuracy: Accuracy,
}

impl ChosenMesh {
    /// Largest relative error that was asked for.
    pub fn tolerance(&self) -> f64 {
        tolerance(self.accuracy)
    }

    /// Number of frequencies that `error` is about.
    fn checked(&self) -> usize {
        self.modes.min(CHECKED)
    }
}

impl fmt::Display for ChosenMesh {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { elements, error, modes, .. } = self;
        let checked = self.checked();
        let list = elements.iter().map(usize::to_string).collect::<Vec<_>>().join(" x ");
        write!(out, "{list} elements chosen: the {checked} lowest frequencies are right to {error:.1e}")?;
        let tolerance = self.tolerance();
        if *error > tolerance {
            let most = if self.error > PROMISED { 2 * MOST_UNKNOWNS } else { MOST_UNKNOWNS };
            write!(out, ", not to {tolerance:.0e}, within {most} degrees of freedom")?;
        }
        if *modes > checked {
            write!(out, "; {modes} have as many elements over a wave")?;
        }
        Ok(())
    }
}

/// Elements per direction that resolve `n_modes` modes of `candidate`, and the estimated error of
/// their frequencies, of the [`CHECKED`] lowest of them; `solved` holds what is known of some meshes.
///
/// A mesh that errs by more than 0.3 % is refined by as much as may be solved; one for more
/// modes than are checked is finer than what is checked in any case.
///
/// # Errors
/// [`AdaptiveError`] naming the body.
pub fn mesh(
    candidate: &Candidate<'_>,
    n_modes: usize,
    solved: Vec<Spectrum>,
) -> Result<(Vec<usize>, f64), AdaptiveError> {
    let first = first_elements(&candidate.spec, n_modes.min(CHECKED));
    let mut elements = first.clone();
    let mut check = Check::new(candidate, n_modes.min(CHECKED), solved);
    let tolerance = tolerance(candidate.accuracy);
    for round in 1.. {
        let mut errors = check.errors(&elements, Known::Converged)?;
        if errors.iter().sum::<f64>() <= tolerance {
            errors = check.errors(&elements, Known::OnThisMesh)?;
        }
        let error = errors.iter().sum::<f64>();
        let mut next = refined(&elements, &errors, check.share(), &check.groups, &check.rates);
        let most = if error > PROMISED { 2 * MOST_UNKNOWNS } else { MOST_UNKNOWNS };
        while n_modes <= CHECKED && error > PROMISED && next != elements && !check.is_feasible(&next, most) {
            next = halfway(&elements, &next);
        }
        let is_last = round == ROUNDS || next == elements || !check.is_feasible(&next, most);
        tracing::debug!(?elements, ?errors, "mesh checked");
        if error <= tolerance || is_last {
            if n_modes <= CHECKED {
                return Ok((elements, error));
            }
            let wanted = first_elements(&candidate.spec, n_modes);
            let more = in_proportion(&wanted, &elements, &first);
            let growth = more.iter().zip(&elements).map(|(n, m)| *n as f64 / *m as f64);
            let least = growth.fold(f64::INFINITY, f64::min).max(1.0);
            return Ok((more, error * least.powf(-USUAL)));
        }
        elements = next;
    }
    unreachable!("the last round returns")
}

/// Elements halfway from `few` to `many`, rounded towards the former.
fn halfway(few: &[usize], many: &[usize]) -> Vec<usize> {
    few.iter().zip(many).map(|(a, b)| a + b.saturating_sub(*a) / 2).collect()
}

/// The `wanted` elements times what was `found` to be needed of the `first` ones.
fn in_proportion(wanted: &[usize], found: &[usize], first: &[usize]) -> Vec<usize> {
    let scaled = |((n, found), first): ((&usize, &usize), &usize)| (n * found).div_ceil(*first);
    wanted.iter().zip(found).zip(first).map(scaled).collect()
}

/// `elements` with those of the directions of `group` halved, or with a third more of them if that
/// makes more than [`CHEAP`] unknowns.
fn finer(candidate: &Candidate<'_>, elements: &[usize], group: &[usize]) -> Vec<usize> {
    let with = |more: fn(usize) -> usize| {
        let mut finer = elements.to_vec();
        group.iter().for_each(|&d| finer[d] += more(finer[d]));
        finer
    };
    let doubled = with(|n| n);
    if candidate.unknowns(&doubled) <= CHEAP { doubled } else { with(|n| n.div_ceil(3)) }
}

/// Errors that need not be found again.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Known {
    /// Errors that were found on this mesh.
    OnThisMesh,
    /// Also errors that were found on coarser meshes, of directions that have not been refined
    /// since and made no more than their share: enough to go on refining, not to accept a mesh.
    Converged,
}

/// The check of the meshes of a candidate, with the errors and rates that it has found so far.
struct Check<'a> {
    candidate: &'a Candidate<'a>,
    n_modes: usize,
    /// Directions that are refined together.
    groups: Vec<Vec<usize>>,
    /// For each group of directions, the first one that is equivalent to it by the symmetry of the
    /// shape.
    equivalent_directions: Vec<usize>,
    /// Meshes solved: where one direction alone is doubled, they serve the next round.
    solved: Vec<Spectrum>,
    /// For each group, its error where that follows from the proportions of the body and is no more
    /// than its share.
    given: Vec<Option<f64>>,
    /// Mesh and error of the last check of each group.
    last: Vec<Option<(Vec<usize>, f64)>>,
    /// For each group, the power of the element's size with which its error falls: that of smooth
    /// modes until two meshes have shown another.
    rates: Vec<f64>,
}

impl<'a> Check<'a> {
    fn new(candidate: &'a Candidate<'a>, n_modes: usize, solved: Vec<Spectrum>) -> Self {
        let groups = candidate.groups();
        // Directions that stand alone are their groups.
        let equivalent_directions =
            if groups.len() == 1 { vec![0] } else { candidate.equivalent_directions() };
        let last = vec![None; groups.len()];
        let rates = groups.iter().map(|group| 2.0 * candidate.degrees()[group[0]] as f64).collect();
        let across = errors_across(&candidate.spec, n_modes);
        let given = groups.iter().map(|group| across[group[0]].filter(|_| group.len() == 1)).collect();
        let check = Self { candidate, n_modes, groups, equivalent_directions, solved, given, last, rates };
        let share = check.share();
        let given = check.given.iter().map(|error| error.filter(|error| *error <= share)).collect();
        Self { given, ..check }
    }

    /// Whether the meshes that tell the errors of `elements` have no more than `most` unknowns; of
    /// directions that have settled the last error will do.
    fn is_feasible(&self, elements: &[usize], most: usize) -> bool {
        let fits = |g: usize| {
            self.given[g].is_some()
                || self.candidate.unknowns(&finer(self.candidate, elements, &self.groups[g])) <= most
                || self.last[g]
                    .as_ref()
                    .is_some_and(|last| self.is_known(Known::Converged, last, elements, g))
        };
        (0..self.groups.len()).all(fits)
    }

    /// Largest relative error of the lowest frequencies that each group makes.
    fn errors(&mut self, elements: &[usize], known: Known) -> Result<Vec<f64>, AdaptiveError> {
        let mut errors: Vec<f64> = Vec::with_capacity(self.groups.len());
        for g in 0..self.groups.len() {
            let twin = self.equivalent_directions[g];
            let last = self.last[g].as_ref().filter(|last| self.is_known(known, last, elements, g));
            let error = match self.given[g].or(last.map(|(_, error)| *error)) {
                Some(error) => error,
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
        let finer = finer(self.candidate, elements, &self.groups[g]);
        let is_large = self.candidate.unknowns(&finer) > MOST_UNKNOWNS;
        let is_enough = (known == Known::Converged || is_large) && *error <= self.share();
        of == elements || (is_unchanged && is_enough)
    }

    fn error(&mut self, elements: &[usize], g: usize) -> Result<f64, AdaptiveError> {
        let finer = finer(self.candidate, elements, &self.groups[g]);
        let coarse = self.frequencies(elements, &[])?;
        let fine = self.frequencies(&finer, &coarse)?;
        let change = coarse.iter().zip(&fine).map(|(c, f)| (c / f - 1.0).abs()).fold(0.0, f64::max);
        let last = self.last[g].as_ref().filter(|(_, error)| *error < RESOLVED);
        let d = self.groups[g][0];
        let growth = finer[d] as f64 / elements[d] as f64;
        if let Some((before, error)) = last.filter(|(before, _)| before[d] != elements[d]) {
            // The estimates have the same factor where the rate is the usual one.
            let fall = error / error_of(change, growth, self.rates[g]);
            let rate = fall.ln() / (elements[d] as f64 / before[d] as f64).ln();
            self.rates[g] = rate.clamp(SLOWEST, 2.0 * self.candidate.degrees()[d] as f64);
        }
        let error = error_of(change, growth, self.rates[g]);
        self.last[g] = Some((elements.to_vec(), error));
        Ok(error)
    }

    /// Part of the error that each group may make for a mesh to be kept at once.
    fn share(&self) -> f64 {
        AIM * tolerance(self.candidate.accuracy) / self.groups.len() as f64
    }

    /// The checked frequencies of a mesh, which do not exceed `bounds`.
    fn frequencies(&mut self, elements: &[usize], bounds: &[f64]) -> Result<Vec<f64>, AdaptiveError> {
        let serves =
            |s: &&Spectrum| s.elements == elements && (s.frequencies.len() >= self.n_modes || s.is_complete);
        if let Some(known) = self.solved.iter().find(serves) {
            return Ok(known.frequencies[..self.n_modes.min(known.frequencies.len())].to_vec());
        }
        let found = self.candidate.spectrum_below(elements, self.n_modes, bounds)?;
        self.solved.push(found.clone());
        Ok(found.frequencies)
    }
}

/// Error of a frequency that a mesh of `growth` times the elements changes by `change`, at a rate
/// (Eq. N.5).
fn error_of(change: f64, growth: f64, rate: f64) -> f64 {
    change / (1.0 - growth.powf(-rate.min(USUAL)))
}

/// Largest relative error of a kept frequency at a level of accuracy.
fn tolerance(accuracy: Accuracy) -> f64 {
    TOLERANCE * accuracy.mesh_error()
}

/// More elements in the groups of directions that make more than their `share` of the error, by the
/// rate at which it falls (Eq. E.14).
fn refined(
    elements: &[usize],
    errors: &[f64],
    share: f64,
    groups: &[Vec<usize>],
    rates: &[f64],
) -> Vec<usize> {
    let mut next = elements.to_vec();
    for ((group, error), rate) in
        groups.iter().zip(errors).zip(rates).filter(|((_, error), _)| **error > share)
    {
        for &d in group {
            let growth = (error / share).powf(1.0 / rate).min(LARGEST_GROWTH);
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
        assert_eq!(refined(&[4, 10], &[0.5 * share, 64.0 * share], share, &apart, &[6.0, 6.0]), [4, 20]);
        assert_eq!(refined(&[4, 10], &[1.1 * share, 1e9], share, &apart, &[6.0, 6.0]), [5, 20]);
        assert_eq!(
            refined(&[4, 4], &[128.0 * AIM * TOLERANCE / 2.0], AIM * TOLERANCE, &together, &[6.0]),
            [8, 8]
        );
        // Errors seen to fall in proportion to the size: as many times the elements.
        assert_eq!(refined(&[4, 10], &[1.5 * share, 0.0], share, &apart, &[1.0, 6.0]), [6, 10]);
    }

    #[test]
    fn what_a_finer_mesh_changes_tells_the_error_at_the_rate_seen() {
        // 1 + 1/4 + 1/16 + … of the change, and 1 + 1/2 + 1/4 + …
        // With half as many more elements 1 + 4/9 + 16/81 + …
        assert!((error_of(5.0, 1.5, 6.0) - 9.0).abs() < 1e-12);
        assert!(
            (error_of(3.0, 2.0, 6.0) - 4.0).abs() < 1e-12 && (error_of(3.0, 2.0, 1.0) - 6.0).abs() < 1e-12
        );
    }

    #[test]
    fn the_sentence_tells_when_the_error_is_too_large() {
        let mesh = |error| {
            ChosenMesh { elements: vec![2, 40], error, modes: 20, accuracy: Accuracy::Normal }.to_string()
        };
        assert_eq!(mesh(2.5e-4), "2 x 40 elements chosen: the 20 lowest frequencies are right to 2.5e-4");
        assert!(mesh(2e-3).ends_with(", not to 1e-3, within 40000 degrees of freedom"));
        assert!(mesh(8e-3).ends_with(", not to 1e-3, within 80000 degrees of freedom"));
        let many = ChosenMesh { elements: vec![9, 9], error: 1e-4, modes: 75, accuracy: Accuracy::Normal }
            .to_string();
        assert_eq!(
            many,
            "9 x 9 elements chosen: the 20 lowest frequencies are right to 1.0e-4; 75 have as many elements over a wave"
        );
        assert_eq!(in_proportion(&[8, 3], &[6, 1], &[4, 1]), [12, 3]);
        assert_eq!(halfway(&[3, 5], &[6, 5]), [4, 5]);
    }
}
