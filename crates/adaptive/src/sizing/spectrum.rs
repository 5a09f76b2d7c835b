//! The lowest eigenfrequencies of a free body, and whether they reach up to a limit.

use std::f64::consts::TAU;

use ffr_dynamics::DynamicsError;
use ffr_dynamics::body::{AssembledBody, RigidMotion};
use ffr_dynamics::reduction::{Digits, ElasticProblem, Pencil};

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
    /// The eigenvalue problem of `body`, whose name is `name`, with what its other meshes have shown
    /// of the digits that it takes.
    ///
    /// # Errors
    /// [`AdaptiveError::Reduction`] naming the body.
    pub fn new(name: &'a str, body: &'a AssembledBody, digits: &Digits) -> Result<Self, AdaptiveError> {
        let pencil = Pencil::new(body, &[]).map_err(|source| fault(name, source))?;
        Ok(Self { name, body, pencil: pencil.with_digits(digits.clone()) })
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
    /// (Eq. R.15); all up to there if they are not found so, but none where these are `most` and more.
    ///
    /// # Errors
    /// [`AdaptiveError::Reduction`] naming the body.
    pub fn next_to(&self, limit: f64, n: usize, most: usize) -> Result<Known, AdaptiveError> {
        let n_rigid = self.body.motion.count();
        let found = self.pencil.neighbours((TAU * limit).powi(2), n, n_rigid + most);
        let found = found.map_err(|source| fault(self.name, source))?;
        let below = found.below.saturating_sub(n_rigid);
        if below >= most {
            return Ok(Known { first: below, frequencies: Vec::new() });
        }
        if !found.next.is_empty() {
            let frequencies = found.next.iter().map(|lambda| lambda.max(0.0).sqrt() / TAU).collect();
            return Ok(Known { first: below.saturating_sub(1), frequencies });
        }
        Ok(Known { first: 0, frequencies: self.lowest(below + n)?.frequencies })
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

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use faer::sparse::{SparseColMat, Triplet};
    use ffr_dynamics::body::{Dof, MassMatrix};

    use super::*;

    #[test]
    fn frequencies_next_to_a_limit_are_not_sought_where_their_number_decides() {
        // Unit masses along the axis with unit springs between them.
        let n = 600;
        let entries = |at: &dyn Fn(u32) -> Vec<(u32, f64)>| {
            let column = |j| at(j).into_iter().map(move |(i, value)| Triplet::new(i, j, value));
            let entries: Vec<_> = (0..n).flat_map(column).collect();
            SparseColMat::try_new_from_triplets(n as usize, n as usize, &entries).expect("a matrix")
        };
        let springs = |j: u32| match j {
            0 => vec![(0, 1.0), (1, -1.0)],
            _ if j + 1 == n => vec![(j, 1.0)],
            _ => vec![(j, 2.0), (j + 1, -1.0)],
        };
        let nodes: Vec<[f64; 3]> = (0..n).map(|i| [0.0, f64::from(i), 0.0]).collect();
        let body = AssembledBody {
            name: "chain".into(),
            motion: RigidMotion::Axial,
            stiffness: entries(&springs),
            mass: MassMatrix::General(entries(&|j| vec![(j, 1.0)])),
            dofs: (0..n).map(|node| Dof { node, component: 1 }).collect(),
            anchors: nodes.clone(),
            nodes,
        };
        let problem = FrequencyProblem::new("chain", &body, &Digits::default()).expect("a pencil");
        let limit = 2.0 * (10.5 * PI / f64::from(2 * n)).sin() / TAU;
        let known = problem.next_to(limit, 3, 11).expect("frequencies");
        assert_eq!((known.first, known.frequencies.len(), known.below(limit)), (9, 4, 10));
        assert_eq!(problem.next_to(limit, 3, 10).expect("a count"), Known { first: 10, frequencies: vec![] });
    }
}
