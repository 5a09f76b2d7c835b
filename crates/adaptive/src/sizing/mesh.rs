//! Elements that resolve the kept modes: guessed from the proportions, then checked with finer meshes.
//!
//! Each direction is doubled by itself. Frequencies of conforming models fall to their limits from above, so the change tells
//! the error that the direction makes, and the sum over directions that of the mesh (Eqs. N.2, N.3).

use std::fmt;

use super::Trial;
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
            write!(out, ", not to {TOLERANCE:.0e}, within {MOST_UNKNOWNS} freedoms")?;
        }
        Ok(())
    }
}

/// Elements a direction that resolve `n_modes` modes of `trial`, and the estimated error of their frequencies.
///
/// # Errors
/// [`AdaptiveError`] naming the body.
pub fn mesh(trial: &Trial<'_>, n_modes: usize) -> Result<(Vec<usize>, f64), AdaptiveError> {
    let shape = &trial.spec.shape;
    let mut elements = first_elements(shape, &lengths(shape), n_modes);
    let mut solved = Solved::new();
    for round in 1.. {
        let errors = errors(trial, &elements, n_modes, &mut solved)?;
        let error = errors.iter().sum::<f64>();
        let next = refined(&elements, &errors, trial.degrees());
        let tried = (0..next.len()).map(|d| trial.unknowns(&doubled(&next, d))).max().unwrap_or(0);
        let is_last = round == ROUNDS || tried > MOST_UNKNOWNS;
        if error <= TOLERANCE || is_last {
            return Ok((elements, error));
        }
        elements = next;
    }
    unreachable!("the last round returns")
}

/// `elements` with those of direction `d` halved.
fn doubled(elements: &[usize], d: usize) -> Vec<usize> {
    let mut finer = elements.to_vec();
    finer[d] *= 2;
    finer
}

/// Frequencies \[Hz\] of the meshes solved so far: where one direction alone is doubled, they serve the next round.
type Solved = Vec<(Vec<usize>, Vec<f64>)>;

fn frequencies(
    trial: &Trial<'_>,
    elements: &[usize],
    n: usize,
    solved: &mut Solved,
) -> Result<Vec<f64>, AdaptiveError> {
    if let Some((_, known)) = solved.iter().find(|(of, _)| of == elements) {
        return Ok(known.clone());
    }
    let found = trial.spectrum(elements, n)?.frequencies;
    solved.push((elements.to_vec(), found.clone()));
    Ok(found)
}

/// Largest relative error of the `n_modes` lowest frequencies that each direction makes.
fn errors(
    trial: &Trial<'_>,
    elements: &[usize],
    n_modes: usize,
    solved: &mut Solved,
) -> Result<Vec<f64>, AdaptiveError> {
    let coarse = frequencies(trial, elements, n_modes, solved)?;
    let of_direction = |d: usize| {
        let fine = frequencies(trial, &doubled(elements, d), n_modes, solved)?;
        let changes = coarse.iter().zip(&fine).map(|(c, f)| (c / f - 1.0).abs());
        Ok(ERROR_OVER_CHANGE * changes.fold(0.0, f64::max))
    };
    (0..elements.len()).map(of_direction).collect()
}

/// More elements in the directions that make more than their share of the error, by the rate of smooth modes (Eq. E.13).
fn refined(elements: &[usize], errors: &[f64], degrees: &[usize]) -> Vec<usize> {
    let share = AIM * TOLERANCE / elements.len() as f64;
    let wanted = |((n, error), p): ((&usize, &f64), &usize)| {
        if *error <= share {
            return *n;
        }
        let growth = (error / share).powf(0.5 / *p as f64).min(LARGEST_GROWTH);
        ((*n as f64 * growth).ceil() as usize).max(n + 1)
    };
    elements.iter().zip(errors).zip(degrees).map(wanted).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_directions_that_err_are_refined() {
        // 64 times its share with rate 2 p = 6: twice the elements.
        let share = AIM * TOLERANCE / 2.0;
        assert_eq!(refined(&[4, 10], &[0.5 * share, 64.0 * share], &[3, 3]), [4, 20]);
        assert_eq!(refined(&[4, 10], &[1.1 * share, 1e9], &[3, 3]), [5, 20]);
    }

    #[test]
    fn the_sentence_tells_when_the_error_is_too_large() {
        let mesh = |error| ChosenMesh { elements: vec![2, 40], error, modes: 20 }.to_string();
        assert_eq!(mesh(2.5e-4), "2 x 40 elements chosen: the 20 lowest frequencies are right to 2.5e-4");
        assert!(mesh(2e-3).ends_with(", not to 1e-3, within 40000 freedoms"));
    }
}
