//! The lowest eigenfrequencies of a free body, and whether they reach up to a limit.

use std::f64::consts::TAU;

use ffr_dynamics::DynamicsError;
use ffr_dynamics::body::AssembledBody;
use ffr_dynamics::reduction::{ElasticProblem, Pencil};

use crate::error::AdaptiveError;

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

/// Matrices of a free body, analysed for factorisations.
pub struct FrequencyProblem<'a> {
    name: &'a str,
    body: &'a AssembledBody,
    pencil: Pencil<'a>,
}

impl<'a> FrequencyProblem<'a> {
    /// That of `body`, called `name`.
    ///
    /// # Errors
    /// [`AdaptiveError::Reduction`] naming the body.
    pub fn new(name: &'a str, body: &'a AssembledBody) -> Result<Self, AdaptiveError> {
        let pencil = Pencil::new(body, &[]).map_err(|source| fault(name, source))?;
        Ok(Self { name, body, pencil })
    }

    /// Number of elastic modes.
    fn available(&self) -> usize {
        self.body.n_unknowns().saturating_sub(self.body.motion.count())
    }

    /// The `n` lowest eigenfrequencies, or all if there are fewer.
    ///
    /// # Errors
    /// [`AdaptiveError::Reduction`] naming the body.
    pub fn lowest(self, n: usize) -> Result<Spectrum, AdaptiveError> {
        let (name, available) = (self.name, self.available());
        let problem = ElasticProblem::free_on(self.pencil, &[]);
        let omega = problem.and_then(|problem| problem.lowest_frequencies(n.min(available).max(1)));
        let omega = omega.map_err(|source| fault(name, source))?;
        let frequencies: Vec<f64> = omega.iter().map(|w| w / TAU).collect();
        let is_complete = frequencies.len() >= available;
        Ok(Spectrum { elements: Vec::new(), frequencies, is_complete })
    }

    /// As [`Self::lowest`], if no more than `n - margin` frequencies lie below `limit` \[Hz\] or there are no more than `n`; otherwise
    /// their number, which a count of the eigenvalues below the limit (Eq. R.3) tells for the price of a factorisation.
    ///
    /// # Errors
    /// [`AdaptiveError::Reduction`] naming the body.
    pub fn lowest_reaching(
        self,
        (limit, n, margin): (f64, usize, usize),
    ) -> Result<Result<Spectrum, usize>, AdaptiveError> {
        if n < self.available() {
            let below = self.below(limit)?;
            if below + margin > n {
                return Ok(Err(below));
            }
        }
        self.lowest(n).map(Ok)
    }

    /// Number of frequencies of elastic modes below `limit` \[Hz\].
    ///
    /// # Errors
    /// [`AdaptiveError::Reduction`] naming the body.
    pub fn below(&self, limit: f64) -> Result<usize, AdaptiveError> {
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
