//! Search for the lowest modes, or their frequencies: block Lanczos until they and a gap behind
//! them stand, clean-up, inertia count.
//!
//! Eqs. R.7 and R.11 to R.14. The count is taken in a gap behind the wanted modes; how many modes
//! lie below the gap is decided by the spectrum, not in advance.

use crate::error::{EigenFault, MatrixFault};
use std::f64::consts::TAU;

use faer::{Mat, MatRef};

use super::lanczos::{Lanczos, Pairs, Ritz, inner};
use super::modes::EigenModes;
use crate::DynamicsError;
use crate::body::RigidMotion;
use crate::reduction::blocks::dense;
use crate::reduction::problem::{CLEAN_ACCURACY, ElasticProblem, SEARCH_ACCURACY};

/// Modes behind those asked for among which the gap is sought: the multiplets of a sphere have 2 l
/// + 1 members, up to 7 in the range of interest.
pub(super) const CANDIDATES: usize = 16;
/// Lanczos residual of wanted modes; the clean-up makes it smaller, the eigenvalue error is about
/// its square.
const CONVERGED: f64 = 5e-7;
/// Lanczos residual of modes of which the frequency alone matters, and of those between the wanted
/// ones and the gap: eigenvalues to about 1e-6.
const GUARD_CONVERGED: f64 = 1e-3;
/// Residual that is accepted when round-off of the solves keeps it from becoming smaller:
/// eigenvalues to about 1e-8.
const RESIDUAL_LIMIT: f64 = 1e-4;
/// Corrections of modes of a factor in single precision after which they stand as they are: the
/// first leaves the square of its contraction, which is below 0.1, the second the cube.
const MAX_CORRECTIONS: usize = 6;
/// Contraction of a factor in single precision up to which one correction leaves eigenvalues, its
/// fourth power, to 1e-6; with the greatest two do.
const ONE_CORRECTION: f64 = 0.03;
/// Checks without halving the residual after which it counts as stagnant.
const STAGNANT_CHECKS: usize = 5;
/// Smallest relative gap between two eigenvalues in which a shift is placed: far above the error of
/// the modes below.
const SMALLEST_GAP: f64 = 1e-4;
/// Places in the gap for the shift: golden sections, then the middle.
const SHIFT_PLACES: [f64; 3] = [0.382, 0.618, 0.5];
/// Part of an eigenvalue by which it may lie above its bound: what the search leaves of error.
const ABOVE_BOUND: f64 = 1e-5;
/// Pivot growth above which a count is repeated elsewhere in the gap.
const GROWTH_LIMIT: f64 = 1e4;
/// Rounds of compression, and of restarts for lost copies.
const MAX_ROUNDS: usize = 12;
const MAX_RECOVERIES: usize = 6;
/// New vectors beside the known modes before a recovered set is judged.
const RECOVERY_VECTORS: usize = 40;

/// Room for the basis of a Lanczos run that looks for `want` modes.
pub(super) fn capacity(want: usize) -> usize {
    (4 * want + 40).max(140).next_multiple_of(8)
}

/// The purpose of a search: modes, or frequencies alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Goal {
    /// Modes, cleaned up.
    Modes,
    /// Frequencies; the modes are those of the Lanczos run.
    Frequencies,
}

/// A search for the lowest modes.
pub(super) struct Search<'p, 'a> {
    problem: &'p ElasticProblem<'a>,
    n_modes: usize,
    goal: Goal,
    /// Upper bounds of the lowest eigenvalues, as far as they are known.
    bounds: &'p [f64],
    /// Vectors per Lanczos block.
    width: usize,
}

/// Where the count is to be taken: behind `n_below` modes, between the eigenvalues `below` and
/// `above`.
#[derive(Clone, Copy)]
struct Gap {
    n_below: usize,
    below: f64,
    above: f64,
}

/// Eigenpairs of the stiffness itself.
struct Found {
    lambda: Vec<f64>,
    vectors: Mat<f64>,
    mass_vectors: Mat<f64>,
    residual: f64,
}

/// The largest correction of a wanted mode, to the error of which it adds up but for the
/// contraction of the factor: in the mass norm, and as a part of the mode in energy, as a ratio of
/// lengths.
struct Correction {
    mass_norm: f64,
    in_energy: f64,
}

/// How the residual of the wanted modes falls, and when to look at it again.
struct Progress {
    /// The smallest residual so far, and for how many checks it has not been halved.
    best: f64,
    checks: usize,
    /// Step and residual of the last check.
    last: (usize, f64),
    /// Step of the next check.
    next: usize,
}

impl Progress {
    fn new() -> Self {
        Self { best: f64::INFINITY, checks: 0, last: (0, f64::INFINITY), next: 0 }
    }

    /// Takes the `residual` of a check behind step `step`, which has cost as much as `cost` steps;
    /// it is to become `enough`. The next check comes after as many, or when the residual will be
    /// small enough if it falls on as it did since the last one.
    fn note(&mut self, residual: f64, (step, cost): (usize, usize), enough: f64) {
        let (before, was) = self.last;
        let per_step = (was / residual).ln() / (step - before).max(1) as f64;
        let remaining = ((residual / enough).ln() / per_step).ceil();
        let most = 1 + cost;
        // As a count of steps: nothing if it is not a number, the most if it is infinite.
        let wait = if per_step > 0.0 && was.is_finite() { remaining as usize } else { most };
        (self.last, self.next) = ((step, residual), step + wait.clamp(1, most));
        if residual < 0.5 * self.best {
            (self.best, self.checks) = (residual, 0);
        } else {
            self.checks += 1;
        }
    }

    fn is_stagnant(&self) -> bool {
        self.checks >= STAGNANT_CHECKS
    }
}

impl<'p, 'a> Search<'p, 'a> {
    /// A search with the block width that suits the body: multiplets of solids have many members,
    /// and a factor too large for the cache serves eight right-hand sides in little more time than
    /// four.
    pub fn new(problem: &'p ElasticProblem<'a>, n_modes: usize, goal: Goal) -> Self {
        let width = if problem.pencil().body().motion == RigidMotion::Spatial { 8 } else { 4 };
        Self { problem, n_modes, goal, bounds: &[], width }
    }

    /// The same for eigenvalues that are no higher than `bounds`, one for each that is wanted: as
    /// long as those found are not, no copy was lost, and nothing is counted.
    pub fn below(self, bounds: &'p [f64]) -> Self {
        Self { bounds, ..self }
    }

    fn is_below_bounds(&self, lambda: &[f64]) -> bool {
        self.bounds.len() >= self.n_modes
            && lambda.iter().zip(self.bounds).all(|(found, bound)| *found <= bound * (1.0 + ABOVE_BOUND))
    }

    pub fn run(self) -> Result<EigenModes, DynamicsError> {
        let mut run = Lanczos::new(self.problem, self.width, capacity(self.n_modes + CANDIDATES))?;
        let mut at_least = self.n_modes + 2 * self.width;
        let mut last = (0, 0, 0.0);
        for recoveries in 0..MAX_RECOVERIES {
            let (ritz, gap) = self.iterate(&mut run, at_least)?;
            let found = match self.goal {
                Goal::Modes => self.modes(&run, &ritz, gap.n_below + 1)?,
                Goal::Frequencies => self.ritz_pairs(&run, &ritz, gap.n_below + 1)?,
            };
            if self.is_below_bounds(&found.lambda[..self.n_modes]) {
                return Ok(self.finish(found, gap.n_below, None, recoveries));
            }
            let above = gap.above.min(found.lambda[gap.n_below]);
            let gap = Gap { below: found.lambda[gap.n_below - 1], above, ..gap };
            let counted = self.count(gap)?;
            let expected = counted - self.problem.n_rigid().min(counted);
            if expected == gap.n_below {
                return Ok(self.finish(found, gap.n_below, Some(counted), recoveries));
            }
            last = (gap.n_below, expected, gap.below);
            if expected < gap.n_below {
                break;
            }
            tracing::debug!(
                found = gap.n_below,
                expected,
                "copies of multiple modes were lost, restarting beside them"
            );
            let theta: Vec<f64> = found.lambda.iter().map(|l| 1.0 / l).collect();
            run.keep(found.vectors.as_ref(), found.mass_vectors.as_ref(), &theta);
            run.restart_random()?;
            at_least = theta.len() + RECOVERY_VECTORS.max(4 * self.width);
        }
        let (found, expected, lambda) = last;
        let (frequency, fault) = (lambda.sqrt() / TAU, EigenFault::Count);
        Err(DynamicsError::Eigenmodes { found, expected, frequency, fault })
    }

    /// Runs until the wanted modes and a gap behind them stand and the basis holds `at_least`
    /// vectors.
    fn iterate(
        &self,
        run: &mut Lanczos<'_, ElasticProblem<'_>>,
        at_least: usize,
    ) -> Result<(Ritz, Gap), DynamicsError> {
        let mut progress = Progress::new();
        let enough = if self.goal == Goal::Modes { CONVERGED } else { GUARD_CONVERGED };
        let (mut worst, mut steps) = (f64::INFINITY, 0);
        for _ in 0..MAX_ROUNDS {
            while run.has_room() {
                run.step()?;
                steps += 1;
                if run.size() < at_least || steps < progress.next {
                    continue;
                }
                let ritz = run.ritz()?;
                worst = ritz.residuals[..self.n_modes].iter().fold(0.0, |a: f64, &r| a.max(r));
                progress.note(worst, (steps, run.steps_of_ritz()), enough);
                if worst > enough && !(progress.is_stagnant() && worst <= RESIDUAL_LIMIT) {
                    continue;
                }
                if let Some(gap) = self.widest_gap(&ritz) {
                    tracing::debug!(steps, size = run.size(), residual = worst, "modes have converged");
                    return Ok((ritz, gap));
                }
            }
            let ritz = run.ritz()?;
            let want = self.n_modes + CANDIDATES;
            run.compress(&ritz, want + (run.size() - want) / 3);
        }
        let fault = if worst > RESIDUAL_LIMIT {
            EigenFault::NotConverged { residual: worst, blocks: steps, limit: RESIDUAL_LIMIT }
        } else {
            EigenFault::NoGap { candidates: CANDIDATES }
        };
        Err(DynamicsError::Eigenmodes { found: 0, expected: self.n_modes, frequency: f64::INFINITY, fault })
    }

    /// The widest gap behind the wanted modes with converged modes below it; its upper end is what
    /// the residual leaves.
    fn widest_gap(&self, ritz: &Ritz) -> Option<Gap> {
        let last = (self.n_modes + CANDIDATES).min(ritz.theta.len() - 1);
        let gaps = (self.n_modes.max(1)..=last)
            .take_while(|&k| ritz.residuals[k - 1] <= GUARD_CONVERGED && ritz.theta[k] > 0.0)
            .map(|k| Gap {
                n_below: k,
                below: 1.0 / ritz.theta[k - 1],
                above: 1.0 / (ritz.theta[k] * (1.0 + ritz.residuals[k])),
            });
        gaps.filter(|gap| gap.width() > SMALLEST_GAP).max_by(|a, b| a.width().total_cmp(&b.width()))
    }

    /// The first `k` modes, cleaned up.
    fn modes(
        &self,
        run: &Lanczos<'_, ElasticProblem<'_>>,
        ritz: &Ritz,
        k: usize,
    ) -> Result<Found, DynamicsError> {
        let found = match self.problem.contraction() {
            Some(contraction) => self.corrected(run.pairs_of_stiffness(k)?, contraction)?,
            None => {
                let (x, mass_x) = run.vectors(ritz, k);
                self.clean(x.as_ref(), mass_x.as_ref())?
            }
        };
        tracing::debug!(residual = found.residual, "modes are cleaned up");
        if found.residual <= RESIDUAL_LIMIT {
            return Ok(found);
        }
        let fault = EigenFault::Residual { residual: found.residual, limit: RESIDUAL_LIMIT };
        let frequency = found.lambda[..self.n_modes].last().map_or(0.0, |l| l.max(0.0).sqrt() / TAU);
        Err(DynamicsError::Eigenmodes { found: 0, expected: self.n_modes, frequency, fault })
    }

    /// The first `k` Ritz pairs; those of a factor in single precision are corrected with the
    /// stiffness itself, once or twice (Eq. R.14).
    fn ritz_pairs(
        &self,
        run: &Lanczos<'_, ElasticProblem<'_>>,
        ritz: &Ritz,
        k: usize,
    ) -> Result<Found, DynamicsError> {
        let (vectors, mass_vectors) = run.vectors(ritz, k);
        let residual = ritz.residuals[..self.n_modes].iter().fold(0.0, |a: f64, &r| a.max(r));
        let lambda = ritz.theta[..k].iter().map(|theta| 1.0 / theta).collect();
        let Some(contraction) = self.problem.contraction() else {
            return Ok(Found { lambda, vectors, mass_vectors, residual });
        };
        let stiffness_vectors = self.problem.stiffness_product(vectors.as_ref());
        let (mut pairs, _) = self.correct(Pairs { lambda, vectors, mass_vectors, stiffness_vectors })?;
        if contraction > ONE_CORRECTION {
            (pairs, _) = self.correct(pairs)?;
        }
        Ok(found(pairs, residual))
    }

    /// One more multiplication and a Rayleigh-Ritz step (Eq. R.13); `mass_x` is `M x`. The residual
    /// is that of `x`.
    fn clean(&self, x: MatRef<'_, f64>, mass_x: MatRef<'_, f64>) -> Result<Found, DynamicsError> {
        let mut y = mass_x.to_owned();
        self.problem.apply_flexibility(y.as_mut());
        let mass_y = self.problem.mass_product(y.as_ref());
        // With y = F M x and x orthogonal to the rigid modes, K y = M x.
        let (lambda, rotation) = rayleigh_ritz(y.as_ref(), mass_x, mass_y.as_ref())?;
        // The Rayleigh quotients of x and y agree to the square of the residual, so lambda serves
        // both.
        let residuals = (0..self.n_modes).map(|j| {
            let terms = (0..x.nrows()).map(|i| {
                let error = lambda[j] * y[(i, j)] - x[(i, j)];
                error * (lambda[j] * mass_y[(i, j)] - mass_x[(i, j)])
            });
            terms.sum::<f64>().max(0.0).sqrt()
        });
        let residual = largest(residuals);
        let turned = |x: Mat<f64>| dense::product(x.as_ref(), rotation.as_ref());
        Ok(Found { lambda, vectors: turned(y), mass_vectors: turned(mass_y), residual })
    }

    /// Pairs of a factor in single precision, corrected until the corrections that would follow are
    /// small in energy, and the last in the mass norm (Eq. R.13).
    fn corrected(&self, mut pairs: Pairs, contraction: f64) -> Result<Found, DynamicsError> {
        let mut residual = f64::NAN;
        for _ in 0..MAX_CORRECTIONS {
            let (better, step) = self.correct(pairs)?;
            tracing::debug!(residual = step.mass_norm, in_energy = step.in_energy, "modes are corrected");
            (pairs, residual) = (better, step.mass_norm);
            if step.in_energy * contraction <= CLEAN_ACCURACY && residual <= RESIDUAL_LIMIT {
                break;
            }
        }
        Ok(found(pairs, residual))
    }

    /// One correction of pairs with what the stiffness itself leaves out of balance, and a
    /// Rayleigh-Ritz step (Eq. R.14).
    ///
    /// The projected stiffness is that of `K` multiplied out: what the correction leaves of error
    /// enters the eigenvalues squared.
    fn correct(&self, pairs: Pairs) -> Result<(Pairs, Correction), DynamicsError> {
        let Pairs { lambda, mut vectors, mass_vectors, stiffness_vectors: mut out_of_balance } = pairs;
        for (j, lambda) in lambda.iter().enumerate() {
            let column = out_of_balance.col_mut(j).iter_mut();
            column.zip(mass_vectors.col(j).iter()).for_each(|(f, m)| *f = lambda * m - *f);
        }
        let mut correction = out_of_balance.clone();
        self.problem.flexibility_within(SEARCH_ACCURACY, correction.as_mut());
        let mass_correction = self.problem.mass_product(correction.as_ref());
        let wanted = 0..self.n_modes;
        let energy = |j: usize| inner(out_of_balance.as_ref(), j, correction.as_ref(), j) / lambda[j];
        let step = Correction {
            mass_norm: largest(
                wanted.clone().map(|j| inner(correction.as_ref(), j, mass_correction.as_ref(), j).sqrt()),
            ),
            in_energy: largest(wanted.map(|j| energy(j).abs().sqrt())),
        };
        vectors += correction;
        let mass_vectors = mass_vectors + mass_correction;
        let stiffness_vectors = self.problem.stiffness_product(vectors.as_ref());
        let (lambda, rotation) =
            rayleigh_ritz(vectors.as_ref(), stiffness_vectors.as_ref(), mass_vectors.as_ref())?;
        let turned = |x: Mat<f64>| dense::product(x.as_ref(), rotation.as_ref());
        let pairs = Pairs {
            lambda,
            vectors: turned(vectors),
            mass_vectors: turned(mass_vectors),
            stiffness_vectors: turned(stiffness_vectors),
        };
        Ok((pairs, step))
    }

    /// Eigenvalues below the gap, by inertia; repeated elsewhere in the gap if a pivot is close to
    /// zero.
    ///
    /// A shift near an eigenvalue of a leading block spoils the single-precision factor only;
    /// another shift is then cheaper than double precision.
    fn count(&self, gap: Gap) -> Result<usize, DynamicsError> {
        let (pencil, clamped) = (self.problem.pencil(), self.problem.clamped_unknowns());
        let shift = |part: f64| gap.below + part * (gap.above - gap.below);
        for part in &SHIFT_PLACES[..2] {
            let single = pencil.inertia_single(shift(*part), clamped)?;
            if let Some(inertia) = single.filter(|i| i.growth <= GROWTH_LIMIT) {
                return Ok(inertia.negative);
            }
        }
        let mut best: Option<crate::reduction::Inertia> = None;
        for part in SHIFT_PLACES {
            let inertia = pencil.inertia(shift(part), clamped)?;
            if best.is_none_or(|b| inertia.growth < b.growth) {
                best = Some(inertia);
            }
            if inertia.growth <= GROWTH_LIMIT {
                break;
            }
        }
        let best = best.filter(|b| b.growth.is_finite());
        best.map(|b| b.negative).ok_or_else(|| DynamicsError::Factorisation {
            matrix: "K - mu M",
            fault: MatrixFault::NoRegularShift,
        })
    }

    fn finish(&self, found: Found, n_below: usize, counted: Option<usize>, recoveries: usize) -> EigenModes {
        let omega: Vec<f64> = found.lambda.iter().map(|l| l.sqrt()).collect();
        EigenModes {
            following: omega[self.n_modes..=n_below].to_vec(),
            omega: omega[..self.n_modes].to_vec(),
            shapes: found.vectors.as_ref().subcols(0, self.n_modes).to_owned(),
            residual: found.residual,
            counted,
            recoveries,
        }
    }
}

impl Gap {
    fn width(&self) -> f64 {
        (self.above - self.below) / self.above
    }
}

/// Pairs with the residual of those that they were made of.
fn found(pairs: Pairs, residual: f64) -> Found {
    let Pairs { lambda, vectors, mass_vectors, .. } = pairs;
    Found { lambda, vectors, mass_vectors, residual }
}

/// The largest of some values that are not negative; not a number if one is not.
fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(0.0, |a: f64, r| if r.is_nan() || a.is_nan() { f64::NAN } else { a.max(r) })
}

/// Eigenvalues, ascending, and coefficients of the mass-orthonormal Ritz vectors of the stiffness
/// in the span of `y`, with `stiffness_y = K y` and `mass_y = M y`.
fn rayleigh_ritz(
    y: MatRef<'_, f64>,
    stiffness_y: MatRef<'_, f64>,
    mass_y: MatRef<'_, f64>,
) -> Result<(Vec<f64>, Mat<f64>), DynamicsError> {
    let mut k = dense::product(y.transpose(), stiffness_y);
    let mut m = dense::product(y.transpose(), mass_y);
    // Unit diagonal first: the columns are as long as their flexibility.
    let scale: Vec<f64> = (0..y.ncols()).map(|j| 1.0 / m[(j, j)].sqrt()).collect();
    for j in 0..y.ncols() {
        for i in 0..y.ncols() {
            k[(i, j)] *= scale[i] * scale[j];
            m[(i, j)] *= scale[i] * scale[j];
        }
    }
    dense::symmetrise(&mut k);
    let l = dense::cholesky(m, "the projected mass matrix")?;
    dense::solve_lower(l.as_ref(), k.as_mut());
    let mut k = k.transpose().to_owned();
    dense::solve_lower(l.as_ref(), k.as_mut());
    dense::symmetrise(&mut k);
    let (lambda, mut rotation) = dense::symmetric_eigen(k.as_ref())?;
    dense::solve_lower_transposed(l.as_ref(), rotation.as_mut());
    for j in 0..rotation.ncols() {
        for i in 0..rotation.nrows() {
            rotation[(i, j)] *= scale[i];
        }
    }
    Ok((lambda, rotation))
}

#[cfg(test)]
mod tests {
    use faer::sparse::{SparseColMat, Triplet};

    use super::*;
    use crate::body::{AssembledBody, Dof, MassMatrix};

    /// Eigenvalues of the dense path and of a search agree to the square of the residual of its
    /// vectors, plus round-off of the stiffness (highest over lowest eigenvalue of the lattice
    /// below 1e3).
    const SAME_FREQUENCY: f64 = 1e-10;

    /// A free cube of `n³` unit masses with unit springs to the neighbours along edges and
    /// diagonals: its symmetry makes frequencies double and triple.
    fn lattice(n: usize) -> AssembledBody {
        let place = |a: usize| [a % n, a / n % n, a / (n * n)].map(|i| i as f64);
        let n_nodes = n * n * n;
        let mut stiffness = Vec::new();
        for a in 0..n_nodes {
            for b in 0..n_nodes {
                let (p, q) = (place(a), place(b));
                let along = [0, 1, 2].map(|c| q[c] - p[c]);
                if a == b || along.iter().any(|x| x.abs() > 1.5) {
                    continue;
                }
                let square: f64 = along.iter().map(|x| x * x).sum();
                for c in 0..3 {
                    for d in 0..3 {
                        let value = along[c] * along[d] / square;
                        for (row, column, value) in
                            [(3 * a + c, 3 * a + d, value), (3 * a + c, 3 * b + d, -value)]
                        {
                            if row >= column {
                                stiffness.push(Triplet::new(row as u32, column as u32, value));
                            }
                        }
                    }
                }
            }
        }
        let unit: Vec<_> = (0..n_nodes as u32).map(|a| Triplet::new(a, a, 1.0)).collect();
        let lower = |size, entries: &[Triplet<u32, u32, f64>]| {
            SparseColMat::try_new_from_triplets(size, size, entries).expect("a matrix")
        };
        let nodes: Vec<[f64; 3]> = (0..n_nodes).map(place).collect();
        AssembledBody {
            name: "lattice".into(),
            motion: RigidMotion::Spatial,
            stiffness: lower(3 * n_nodes, &stiffness),
            mass: MassMatrix::PerComponent(lower(n_nodes, &unit)),
            dofs: (0..3 * n_nodes).map(|i| Dof { node: (i / 3) as u32, component: (i % 3) as u8 }).collect(),
            anchors: nodes.clone(),
            nodes,
        }
    }

    #[test]
    fn lost_copies_of_multiple_frequencies_are_recovered() {
        // Single vectors find one copy each of double and triple frequencies until round-off brings
        // the others.
        let body = lattice(6);
        let problem = ElasticProblem::free(&body, &[]).expect("a free body");
        let search = Search { width: 1, ..Search::new(&problem, 24, Goal::Modes) };
        let modes = search.run().expect("modes");
        assert!(modes.recoveries > 0, "the count showed lost copies");
        let all = problem.all_modes().expect("all modes").omega;
        for (found, expected) in modes.omega.iter().zip(&all) {
            assert!((found / expected - 1.0).abs() < SAME_FREQUENCY, "{found} {expected}");
        }
    }

    #[test]
    fn digits_that_did_not_suffice_are_not_tried_again() {
        use crate::reduction::{Digits, Pencil};
        let body = lattice(17);
        let digits = Digits::default();
        let pencil = || Pencil::new(&body, &[]).expect("a pencil").with_digits(digits.clone());
        let first = ElasticProblem::free_on(pencil(), &[]).expect("a free body");
        assert!(first.is_single_precision());
        first.pencil().note_too_few_digits();
        let second = ElasticProblem::free_on(pencil(), &[]).expect("a free body");
        assert!(!second.is_single_precision(), "another mesh of the body");
        // Shifted matrices are judged by themselves.
        assert!(pencil().inertia_single(-1.0, second.clamped_unknowns()).expect("memory").is_some());
    }

    #[test]
    fn pairs_that_are_off_are_corrected_until_they_are_not() {
        // Rough vectors beside the modes, of the size that a poor factor in single precision leaves
        // outside the space of a search: high modes, as the stiffness brings out of random vectors.
        // One multiplication would not do, for the residual is that of the vectors before it.
        const OFF: f64 = 1e-2;
        let body = lattice(17);
        let problem = ElasticProblem::free(&body, &[]).expect("a free body");
        let contraction = problem.contraction().expect("the body is large enough for single precision");
        let (n, n_modes) = (problem.n_unknowns(), 12);
        let search = Search::new(&problem, n_modes, Goal::Modes);
        let exact = problem.in_double_precision().expect("a factor");
        let reference = exact.lowest_modes(n_modes).expect("modes");
        let mut random = crate::reduction::blocks::random::Random::new(7);
        let random = Mat::from_fn(n, n_modes, |_, _| random.next());
        let mut rough = problem.stiffness_product(random.as_ref());
        // All masses are 1.
        rough.col_iter_mut().for_each(|mut column| column *= faer::Scale(OFF / column.norm_l2()));
        let mut vectors = rough + &reference.shapes;
        problem.remove_rigid(vectors.as_mut());
        let pairs = Pairs {
            lambda: reference.omega.iter().map(|w| w * w).collect(),
            mass_vectors: problem.mass_product(vectors.as_ref()),
            stiffness_vectors: problem.stiffness_product(vectors.as_ref()),
            vectors,
        };
        let found = search.corrected(pairs, contraction).expect("pairs");
        assert!(found.residual <= RESIDUAL_LIMIT, "{}", found.residual);
        for (lambda, omega) in found.lambda.iter().zip(&reference.omega) {
            assert!((lambda.sqrt() / omega - 1.0).abs() < SAME_FREQUENCY, "{lambda} {omega}");
        }
        let across = dense::product(found.vectors.transpose(), found.mass_vectors.as_ref());
        for (i, j) in (0..n_modes).flat_map(|i| (0..n_modes).map(move |j| (i, j))) {
            // Round-off of sums of n products.
            assert!((across[(i, j)] - f64::from(i == j)).abs() < 1e-12, "{i} {j}");
        }
    }
}
