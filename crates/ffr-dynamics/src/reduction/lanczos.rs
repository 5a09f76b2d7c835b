//! Block Lanczos iteration on `F M` in the mass inner product (Eqs. R.7, R.8), thick restart.
//!
//! `F M x = theta x` has the eigenvalues `theta = 1 / lambda`, the lowest elastic modes come first. Blocks find the copies
//! of multiple eigenvalues that a single vector misses; every block is orthogonalised against the whole basis.

use faer::{Mat, MatRef};

use super::dense;
use super::problem::ElasticProblem;
use crate::DynamicsError;

/// Vectors per block: a solve with four right-hand sides costs little more than one with a single one.
pub(crate) const BLOCK: usize = 4;
/// A new direction shorter than this part of the operator's norm is round-off.
const BREAKDOWN: f64 = 1e-13;

/// Deterministic pseudo-random numbers in (-1, 1) (splitmix64, Steele et al. 2014).
#[derive(Debug, Clone)]
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^= z >> 31;
        (z >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}

/// Basis, projected operator and next block of a Lanczos run.
#[derive(Debug)]
pub(crate) struct Lanczos<'p, 'a> {
    problem: &'p ElasticProblem<'a>,
    /// Mass-orthonormal basis, the first `size` columns are in use.
    basis: Mat<f64>,
    /// `V^T M F M V`.
    projected: Mat<f64>,
    size: usize,
    next: Mat<f64>,
    /// `next * coupling` is what the last block leaves outside the basis.
    coupling: Mat<f64>,
    random: Random,
    norm: f64,
}

/// Ritz pairs of the projected operator, largest first.
pub(crate) struct Ritz {
    pub theta: Vec<f64>,
    vectors: Mat<f64>,
    /// Relative residual `|F M x - theta x| / theta` in the mass norm.
    pub residuals: Vec<f64>,
}

impl<'p, 'a> Lanczos<'p, 'a> {
    /// A run with room for `capacity` basis vectors.
    pub fn new(problem: &'p ElasticProblem<'a>, capacity: usize) -> Result<Self, DynamicsError> {
        let n = problem.n_unknowns();
        let mut run = Self {
            problem,
            basis: Mat::zeros(n, capacity),
            projected: Mat::zeros(capacity, capacity),
            size: 0,
            next: Mat::zeros(n, BLOCK),
            coupling: Mat::zeros(BLOCK, BLOCK),
            random: Random(0x5eed),
            norm: 0.0,
        };
        run.restart_random()?;
        Ok(run)
    }

    /// Basis vectors in use.
    pub fn size(&self) -> usize {
        self.size
    }

    /// Whether another block fits.
    pub fn has_room(&self) -> bool {
        self.size + BLOCK <= self.basis.ncols()
    }

    /// Replaces the next block by random vectors, smoothed once by the operator and orthogonal to the basis.
    pub fn restart_random(&mut self) -> Result<(), DynamicsError> {
        let n = self.problem.n_unknowns();
        let random = &mut self.random;
        let start = Mat::from_fn(n, BLOCK, |_, _| random.next());
        let mut block = self.problem.mass_product(start.as_ref());
        self.problem.apply_flexibility(block.as_mut());
        self.orthogonalise(&mut block);
        // The scale of the block itself: a random start has no operator norm to compare with.
        let norm = std::mem::replace(&mut self.norm, 0.0);
        self.orthonormalise(&mut block)?;
        self.norm = norm;
        self.next = block;
        self.coupling = Mat::zeros(BLOCK, BLOCK);
        Ok(())
    }

    /// Takes the next block into the basis and applies the operator to it.
    pub fn step(&mut self) -> Result<(), DynamicsError> {
        let (old, new) = (self.size, self.size + BLOCK);
        self.basis.as_mut().subcols_mut(old, BLOCK).copy_from(&self.next);
        self.size = new;
        let mut block = self.problem.mass_product(self.next.as_ref());
        self.problem.apply_flexibility(block.as_mut());
        let mut along = self.orthogonalise(&mut block);
        along += self.orthogonalise(&mut block);
        for j in 0..BLOCK {
            for i in 0..new {
                self.projected[(i, old + j)] = along[(i, j)];
                self.projected[(old + j, i)] = along[(i, j)];
            }
        }
        for i in 0..BLOCK {
            self.norm = self.norm.max(self.projected[(old + i, old + i)].abs());
            for j in 0..i {
                let mean = 0.5 * (along[(old + i, j)] + along[(old + j, i)]);
                self.projected[(old + i, old + j)] = mean;
                self.projected[(old + j, old + i)] = mean;
            }
        }
        self.coupling = self.orthonormalise(&mut block)?;
        self.next = block;
        Ok(())
    }

    /// Removes the parts along the basis and the rigid modes; returns the coefficients along the basis.
    fn orthogonalise(&self, block: &mut Mat<f64>) -> Mat<f64> {
        self.problem.remove_rigid(block.as_mut());
        let basis = self.basis.as_ref().subcols(0, self.size);
        let mass_block = self.problem.mass_product(block.as_ref());
        let along = dense::product(basis.transpose(), mass_block.as_ref());
        dense::add_product(block.as_mut(), -1.0, basis, along.as_ref());
        along
    }

    /// Makes a block mass-orthonormal (and orthogonal to the basis); returns the triangular factor.
    fn orthonormalise(&mut self, block: &mut Mat<f64>) -> Result<Mat<f64>, DynamicsError> {
        let first = self.gram_schmidt(block, self.norm * BREAKDOWN)?;
        self.orthogonalise(block);
        let second = self.gram_schmidt(block, 0.0)?;
        Ok(dense::product(second.as_ref(), first.as_ref()))
    }

    /// Modified Gram-Schmidt inside a block; directions shorter than `limit` become new random ones with no coupling.
    fn gram_schmidt(&mut self, block: &mut Mat<f64>, limit: f64) -> Result<Mat<f64>, DynamicsError> {
        let mut mass_block = self.problem.mass_product(block.as_ref());
        let mut factor = Mat::zeros(BLOCK, BLOCK);
        for j in 0..BLOCK {
            for i in 0..j {
                let along = inner(block.as_ref(), i, mass_block.as_ref(), j);
                factor[(i, j)] = along;
                subtract(block, j, i, along);
                subtract(&mut mass_block, j, i, along);
            }
            let mut length = inner(block.as_ref(), j, mass_block.as_ref(), j).max(0.0).sqrt();
            factor[(j, j)] = length;
            if length <= limit.max(f64::MIN_POSITIVE) {
                factor[(j, j)] = 0.0;
                length = self.replace(block, &mut mass_block, j);
            }
            if !length.is_finite() || length <= 0.0 {
                let reason = "a Lanczos vector is not finite".to_owned();
                return Err(DynamicsError::Factorisation { matrix: "the flexibility", reason });
            }
            scale(block, j, 1.0 / length);
            scale(&mut mass_block, j, 1.0 / length);
        }
        Ok(factor)
    }

    /// Puts a random direction, orthogonal to basis and block, into column `j`; returns its length.
    fn replace(&mut self, block: &mut Mat<f64>, mass_block: &mut Mat<f64>, j: usize) -> f64 {
        let random = &mut self.random;
        let start = Mat::from_fn(block.nrows(), 1, |_, _| random.next());
        let mut fresh = self.problem.mass_product(start.as_ref());
        self.problem.apply_flexibility(fresh.as_mut());
        let mut length = 0.0;
        for _ in 0..3 {
            self.orthogonalise(&mut fresh);
            let earlier = block.as_ref().subcols(0, j);
            let along = dense::product(mass_block.as_ref().subcols(0, j).transpose(), fresh.as_ref());
            dense::add_product(fresh.as_mut(), -1.0, earlier, along.as_ref());
            let mass_fresh = self.problem.mass_product(fresh.as_ref());
            length = inner(fresh.as_ref(), 0, mass_fresh.as_ref(), 0).max(0.0).sqrt();
            scale(&mut fresh, 0, 1.0 / length);
        }
        block.col_mut(j).copy_from(fresh.col(0));
        let mass_fresh = self.problem.mass_product(fresh.as_ref());
        mass_block.col_mut(j).copy_from(mass_fresh.col(0));
        if length.is_finite() { 1.0 } else { length }
    }

    /// Ritz pairs of the present basis.
    pub fn ritz(&self) -> Result<Ritz, DynamicsError> {
        let m = self.size;
        let (ascending, vectors) = dense::symmetric_eigen(self.projected.as_ref().submatrix(0, 0, m, m))?;
        let theta: Vec<f64> = ascending.iter().rev().copied().collect();
        let vectors = Mat::from_fn(m, m, |i, j| vectors[(i, m - 1 - j)]);
        let last = vectors.as_ref().subrows(m - BLOCK, BLOCK);
        let outside = dense::product(self.coupling.as_ref(), last);
        let residuals =
            (0..m).map(|j| outside.col(j).norm_l2() / theta[j].abs().max(f64::MIN_POSITIVE)).collect();
        Ok(Ritz { theta, vectors, residuals })
    }

    /// Ritz vectors of the first `k` pairs, n x k.
    pub fn vectors(&self, ritz: &Ritz, k: usize) -> Mat<f64> {
        dense::product(self.basis.as_ref().subcols(0, self.size), ritz.vectors.as_ref().subcols(0, k))
    }

    /// Shrinks the basis to the first `k` Ritz vectors; the next block stays (thick restart, Wu and Simon 2000).
    pub fn compress(&mut self, ritz: &Ritz, k: usize) {
        let kept = self.vectors(ritz, k);
        self.keep(kept.as_ref(), &ritz.theta[..k]);
    }

    /// Takes mass-orthonormal vectors with their eigenvalues `theta` as the whole basis.
    pub fn keep(&mut self, vectors: MatRef<'_, f64>, theta: &[f64]) {
        let k = theta.len();
        self.basis.as_mut().subcols_mut(0, k).copy_from(vectors);
        self.projected.fill(0.0);
        for (i, &value) in theta.iter().enumerate() {
            self.projected[(i, i)] = value;
        }
        self.size = k;
    }
}

fn inner(a: MatRef<'_, f64>, i: usize, b: MatRef<'_, f64>, j: usize) -> f64 {
    a.col(i).transpose() * b.col(j)
}

fn subtract(block: &mut Mat<f64>, target: usize, source: usize, factor: f64) {
    for i in 0..block.nrows() {
        let part = factor * block[(i, source)];
        block[(i, target)] -= part;
    }
}

fn scale(block: &mut Mat<f64>, column: usize, factor: f64) {
    block.col_mut(column).iter_mut().for_each(|x| *x *= factor);
}
