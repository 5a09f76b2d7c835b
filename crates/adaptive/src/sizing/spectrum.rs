//! The lowest eigenfrequencies of a free body, and whether they reach up to a limit.

use std::f64::consts::TAU;

use ffr_dynamics::DynamicsError;
use ffr_dynamics::body::{AssembledBody, RigidMotion};
use ffr_dynamics::reduction::{ElasticProblem, Pencil};

use crate::error::AdaptiveError;

/// Frequencies above a shift among which one is sought.
const AROUND: usize = 10;
/// Shifts after which a frequency is found among the lowest ones instead.
const SHIFTS: usize = 8;
/// Power of the frequency with which the number below it grows at first sight: that of plane
/// bodies, between bars and solids.
const FIRST_GROWTH: f64 = 2.0;

/// Lowest eigenfrequencies of a trial.
#[derive(Debug, Clone, PartialEq)]
pub struct Spectrum {
    /// Elements per direction; none of a mesh.
    pub elements: Vec<usize>,
    /// Frequencies, rising \[Hz\].
    pub frequencies: Vec<f64>,
    /// Whether the model has no more.
    pub is_complete: bool,
}

/// Some neighbouring eigenfrequencies.
#[derive(Debug, Clone, PartialEq)]
pub struct Known {
    /// How many lie below them.
    pub first: usize,
    /// Frequencies, rising \[Hz\].
    pub frequencies: Vec<f64>,
}

impl Known {
    /// Number of frequencies up to `limit` \[Hz\], which lies among them.
    pub fn below(&self, limit: f64) -> usize {
        self.first + self.frequencies.partition_point(|f| *f <= limit)
    }
}

/// Matrices of a free body, analysed for factorisations.
pub struct FrequencyProblem<'a> {
    name: &'a str,
    body: &'a AssembledBody,
    pencil: Pencil<'a>,
}

impl<'a> FrequencyProblem<'a> {
    /// The eigenvalue problem of `body`, whose name is `name`.
    ///
    /// # Errors
    /// [`AdaptiveError::Reduction`] naming the body.
    pub fn new(name: &'a str, body: &'a AssembledBody) -> Result<Self, AdaptiveError> {
        let pencil = Pencil::new(body, &[]).map_err(|source| fault(name, source))?;
        Ok(Self { name, body, pencil })
    }

    /// Rigid motions of the body.
    pub fn motion(&self) -> RigidMotion {
        self.body.motion
    }

    /// Number of elastic modes.
    fn available(&self) -> usize {
        self.body.n_unknowns().saturating_sub(self.body.motion.count())
    }

    /// The `n` lowest eigenfrequencies, or all if there are fewer.
    ///
    /// # Errors
    /// [`AdaptiveError::Reduction`] naming the body.
    pub fn lowest(&self, n: usize) -> Result<Spectrum, AdaptiveError> {
        self.lowest_below(n, &[])
    }

    /// As [`Self::lowest`], if they are known not to exceed `bounds` \[Hz\].
    ///
    /// # Errors
    /// [`AdaptiveError::Reduction`] naming the body.
    pub fn lowest_below(&self, n: usize, bounds: &[f64]) -> Result<Spectrum, AdaptiveError> {
        let bounds: Vec<f64> = bounds.iter().map(|f| f * TAU).collect();
        let available = self.available();
        let problem = ElasticProblem::free_on(self.pencil.clone(), &[]);
        let omega =
            problem.and_then(|problem| problem.lowest_frequencies_below(n.min(available).max(1), &bounds));
        let omega = omega.map_err(|source| fault(self.name, source))?;
        let frequencies: Vec<f64> = omega.iter().map(|w| w / TAU).collect();
        let is_complete = frequencies.len() >= available;
        Ok(Spectrum { elements: Vec::new(), frequencies, is_complete })
    }

    /// Number of frequencies below `limit` \[Hz\], and the one before it and `n` behind it
    /// (Eq. R.15); all up to there if they are not found so.
    ///
    /// # Errors
    /// [`AdaptiveError::Reduction`] naming the body.
    pub fn next_to(&self, limit: f64, n: usize) -> Result<Known, AdaptiveError> {
        let found = self.pencil.neighbours((TAU * limit).powi(2), n);
        if let Some(found) = found.map_err(|source| fault(self.name, source))? {
            let below = found.below.saturating_sub(self.body.motion.count());
            let lambda = std::iter::once(found.lower).chain(found.upper);
            let frequencies = lambda.map(|lambda| lambda.max(0.0).sqrt() / TAU).collect();
            return Ok(Known { first: below.saturating_sub(1), frequencies });
        }
        let below = self.below(limit)?;
        Ok(Known { first: 0, frequencies: self.lowest(below + n)?.frequencies })
    }

    /// The frequency number `n` \[Hz\], counted from 1, found from the numbers below others,
    /// `known` (frequency and number) being the first of them.
    ///
    /// # Errors
    /// [`AdaptiveError::Reduction`] naming the body.
    pub fn nth(&self, n: usize, known: (f64, usize)) -> Result<f64, AdaptiveError> {
        let ((mut frequency, mut below), mut growth) = (known, FIRST_GROWTH);
        for _ in 0..SHIFTS {
            // So that the one sought is in the middle of those found above the shift.
            let aim = n.saturating_sub(AROUND / 2).max(1) as f64;
            let shift = frequency * (aim / below.max(1) as f64).powf(1.0 / growth);
            let found = self.next_to(shift, AROUND)?;
            if let Some(sought) = (n - 1).checked_sub(found.first).and_then(|i| found.frequencies.get(i)) {
                return Ok(*sought);
            }
            let now = found.below(shift);
            let seen = (now.max(1) as f64 / below.max(1) as f64).ln() / (shift / frequency).ln();
            growth =
                if seen.is_finite() { seen.clamp(0.5 * FIRST_GROWTH, 2.0 * FIRST_GROWTH) } else { growth };
            (frequency, below) = (shift, now);
        }
        let lowest = self.lowest(n)?.frequencies;
        Ok(lowest.last().copied().unwrap_or(0.0))
    }

    /// Number of frequencies of elastic modes below `limit` \[Hz\].
    ///
    /// # Errors
    /// [`AdaptiveError::Reduction`] naming the body.
    fn below(&self, limit: f64) -> Result<usize, AdaptiveError> {
        let fail = |source| fault(self.name, source);
        let (eigenvalue, free) = ((TAU * limit).powi(2), vec![false; self.body.n_unknowns()]);
        let inertia = match self.pencil.inertia_single(eigenvalue, &free).map_err(fail)? {
            Some(inertia) => inertia,
            None => self.pencil.inertia(eigenvalue, &free).map_err(fail)?,
        };
        Ok(inertia.negative.saturating_sub(self.body.motion.count()))
    }
}

fn fault(name: &str, source: DynamicsError) -> AdaptiveError {
    AdaptiveError::Reduction { body: name.to_owned(), source }
}
