//! Block Lanczos iteration on `F M` in the mass inner product (Eqs. R.11, R.12), thick restart.
//!
//! `F M x = theta x` has the eigenvalues `theta = 1 / lambda`, the lowest elastic modes come first.
//! Blocks find the copies of multiple eigenvalues that a single vector misses; every block is
//! orthogonalised against the whole basis.

use crate::error::MatrixFault;
use faer::{Mat, MatMut, MatRef};

use crate::DynamicsError;
use crate::reduction::blocks::dense;
use crate::reduction::blocks::random::Random;
use crate::reduction::problem::{ElasticProblem, SEARCH_ACCURACY};

/// A new direction shorter than this part of the operator's norm is round-off.
const BREAKDOWN: f64 = 1e-13;
/// A block whose columns shrink below this part of their length while they are made orthogonal
/// among themselves is orthogonalised once more with a fresh product: what is left would have lost
/// more than two digits.
const CANCELLATION: f64 = 1e-2;

/// What a Lanczos run multiplies with: `F M`, symmetric in the mass inner product.
pub(crate) trait Operator {
    /// Number of unknowns.
    fn n_unknowns(&self) -> usize;

    /// Replaces loads (n x k) by `F` times them.
    fn apply(&self, x: MatMut<'_, f64>);

    /// `M x`.
    fn mass_product(&self, x: MatRef<'_, f64>) -> Mat<f64>;

    /// Takes out of displacements (n x k) what the search is not about.
    fn project(&self, x: MatMut<'_, f64>);
}

impl Operator for ElasticProblem<'_> {
    fn n_unknowns(&self) -> usize {
        self.n_unknowns()
    }

    fn apply(&self, x: MatMut<'_, f64>) {
        self.flexibility_within(SEARCH_ACCURACY, x);
    }

    fn mass_product(&self, x: MatRef<'_, f64>) -> Mat<f64> {
        self.mass_product(x)
    }

    fn project(&self, x: MatMut<'_, f64>) {
        self.remove_rigid(x);
    }
}

/// Basis, projected operator and next block of a Lanczos run.
#[derive(Debug)]
pub(crate) struct Lanczos<'p, O> {
    problem: &'p O,
    /// Vectors per block.
    width: usize,
    /// Mass-orthonormal basis, the first `size` columns are in use.
    basis: Mat<f64>,
    /// `M` times the basis, so that inner products are plain ones.
    mass_basis: Mat<f64>,
    /// `V^T M F M V`.
    projected: Mat<f64>,
    size: usize,
    /// First basis vector of the block before the last one: the operator couples a block with those
    /// from there on alone, but for round-off. 0 behind a restart.
    previous: usize,
    next: Block,
    /// `next * coupling` is what the last block leaves outside the basis.
    coupling: Mat<f64>,
    random: Random,
    norm: f64,
}

/// A few vectors and their products with the mass matrix.
#[derive(Debug)]
struct Block {
    x: Mat<f64>,
    mass_x: Mat<f64>,
}

/// Ritz pairs of the projected operator, largest first.
pub(crate) struct Ritz {
    pub theta: Vec<f64>,
    vectors: Mat<f64>,
    /// Relative residual `|F M x - theta x| / theta` in the mass norm.
    pub residuals: Vec<f64>,
}

/// Approximate eigenpairs of the stiffness, and the products of their vectors with the matrices.
pub(crate) struct Pairs {
    pub lambda: Vec<f64>,
    pub vectors: Mat<f64>,
    pub mass_vectors: Mat<f64>,
    pub stiffness_vectors: Mat<f64>,
}

impl<'p, O: Operator> Lanczos<'p, O> {
    /// A run with blocks of `width` vectors and room for `capacity` basis vectors.
    pub fn new(problem: &'p O, width: usize, capacity: usize) -> Result<Self, DynamicsError> {
        let n = problem.n_unknowns();
        let mut run = Self {
            problem,
            width,
            basis: Mat::zeros(n, capacity),
            mass_basis: Mat::zeros(n, capacity),
            projected: Mat::zeros(capacity, capacity),
            size: 0,
            previous: 0,
            next: Block { x: Mat::zeros(n, width), mass_x: Mat::zeros(n, width) },
            coupling: Mat::zeros(width, width),
            random: Random::new(0x5eed),
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
        self.size + self.width <= self.basis.ncols()
    }

    /// Replaces the next block by random vectors, smoothed once by the operator and orthogonal to
    /// the basis.
    pub fn restart_random(&mut self) -> Result<(), DynamicsError> {
        let block = self.smooth_random(self.width);
        // The scale of the block itself: a random start has no operator norm to compare with.
        let norm = std::mem::replace(&mut self.norm, 0.0);
        (self.next, _) = self.orthonormalise(block)?;
        (self.norm, self.previous) = (norm, 0);
        self.coupling = Mat::zeros(self.width, self.width);
        Ok(())
    }

    fn smooth_random(&mut self, columns: usize) -> Mat<f64> {
        let random = &mut self.random;
        let start = Mat::from_fn(self.basis.nrows(), columns, |_, _| random.next());
        let mut block = self.problem.mass_product(start.as_ref());
        self.problem.apply(block.as_mut());
        for _ in 0..2 {
            self.orthogonalise(&mut block, 0);
        }
        block
    }

    /// Takes the next block into the basis and applies the operator to it.
    pub fn step(&mut self) -> Result<(), DynamicsError> {
        let (old, new, width) = (self.size, self.size + self.width, self.width);
        self.basis.as_mut().subcols_mut(old, width).copy_from(&self.next.x);
        self.mass_basis.as_mut().subcols_mut(old, width).copy_from(&self.next.mass_x);
        self.size = new;
        let mut block = self.next.mass_x.clone();
        self.problem.apply(block.as_mut());
        // What is large first, so that the second pass leaves round-off of what is small.
        let mut along = self.orthogonalise(&mut block, self.previous);
        along += self.orthogonalise(&mut block, 0);
        self.previous = old;
        for j in 0..width {
            for i in 0..new {
                self.projected[(i, old + j)] = along[(i, j)];
                self.projected[(old + j, i)] = along[(i, j)];
            }
        }
        for i in 0..width {
            self.norm = self.norm.max(self.projected[(old + i, old + i)].abs());
            for j in 0..i {
                let mean = 0.5 * (along[(old + i, j)] + along[(old + j, i)]);
                self.projected[(old + i, old + j)] = mean;
                self.projected[(old + j, old + i)] = mean;
            }
        }
        (self.next, self.coupling) = self.orthonormalise(block)?;
        Ok(())
    }

    /// Removes the parts along the rigid modes and the basis vectors from number `first` on;
    /// returns the coefficients along the whole basis.
    fn orthogonalise(&self, block: &mut Mat<f64>, first: usize) -> Mat<f64> {
        self.problem.project(block.as_mut());
        let count = self.size - first;
        let (basis, mass_basis) =
            (self.basis.as_ref().subcols(first, count), self.mass_basis.as_ref().subcols(first, count));
        let mut along = Mat::zeros(self.size, block.ncols());
        dense::add_product(
            along.as_mut().subrows_mut(first, count),
            1.0,
            mass_basis.transpose(),
            block.as_ref(),
        );
        dense::add_product(block.as_mut(), -1.0, basis, along.as_ref().subrows(first, count));
        along
    }

    /// Makes a block that is orthogonal to the basis mass-orthonormal; returns it with the
    /// triangular factor.
    fn orthonormalise(&mut self, x: Mat<f64>) -> Result<(Block, Mat<f64>), DynamicsError> {
        let mass_x = self.problem.mass_product(x.as_ref());
        let mut block = Block { x, mass_x };
        let (mut factor, shrinkage) = self.gram_schmidt(&mut block, self.norm * BREAKDOWN)?;
        if shrinkage < CANCELLATION {
            self.orthogonalise(&mut block.x, 0);
            block.mass_x = self.problem.mass_product(block.x.as_ref());
            let (second, _) = self.gram_schmidt(&mut block, 0.0)?;
            factor = dense::product(second.as_ref(), factor.as_ref());
        }
        Ok((block, factor))
    }

    /// Modified Gram-Schmidt inside a block, and how much the worst column shrank; directions
    /// shorter than `limit` become new random ones with no coupling.
    fn gram_schmidt(&mut self, block: &mut Block, limit: f64) -> Result<(Mat<f64>, f64), DynamicsError> {
        let mut factor = Mat::zeros(self.width, self.width);
        let mut shrinkage = 1.0_f64;
        for j in 0..self.width {
            let before = block.length(j);
            for i in 0..j {
                let along = inner(block.x.as_ref(), i, block.mass_x.as_ref(), j);
                factor[(i, j)] = along;
                subtract(&mut block.x, j, i, along);
                subtract(&mut block.mass_x, j, i, along);
            }
            let mut length = block.length(j);
            factor[(j, j)] = length;
            if length <= limit.max(f64::MIN_POSITIVE) {
                factor[(j, j)] = 0.0;
                shrinkage = 0.0;
                length = self.replace(block, j);
            } else {
                shrinkage = shrinkage.min(length / before);
            }
            if !length.is_finite() || length <= 0.0 {
                let fault = MatrixFault::LanczosVector;
                return Err(DynamicsError::Factorisation { matrix: "the flexibility", fault });
            }
            scale(&mut block.x, j, 1.0 / length);
            scale(&mut block.mass_x, j, 1.0 / length);
        }
        Ok((factor, shrinkage))
    }

    /// Puts a random unit direction, orthogonal to basis and block, into column `j`; returns its
    /// length, 1 or not finite.
    fn replace(&mut self, block: &mut Block, j: usize) -> f64 {
        let mut fresh = self.smooth_random(1);
        let mut length = 0.0;
        for _ in 0..3 {
            self.orthogonalise(&mut fresh, 0);
            let earlier = block.x.as_ref().subcols(0, j);
            let along = dense::product(block.mass_x.as_ref().subcols(0, j).transpose(), fresh.as_ref());
            dense::add_product(fresh.as_mut(), -1.0, earlier, along.as_ref());
            let mass_fresh = self.problem.mass_product(fresh.as_ref());
            length = inner(fresh.as_ref(), 0, mass_fresh.as_ref(), 0).max(0.0).sqrt();
            scale(&mut fresh, 0, 1.0 / length);
        }
        block.x.col_mut(j).copy_from(fresh.col(0));
        let mass_fresh = self.problem.mass_product(fresh.as_ref());
        block.mass_x.col_mut(j).copy_from(mass_fresh.col(0));
        if length.is_finite() { 1.0 } else { length }
    }

    /// Steps that cost as much as [`Lanczos::ritz`] with the present basis of `m` vectors: some
    /// `9 m^3` operations, a step takes `8 n m` for each vector of its block in products with the
    /// basis.
    pub fn steps_of_ritz(&self) -> usize {
        9 * self.size.pow(2) / (8 * self.problem.n_unknowns() * self.width).max(1)
    }

    /// Ritz pairs of the present basis.
    pub fn ritz(&self) -> Result<Ritz, DynamicsError> {
        let m = self.size;
        let (ascending, vectors) = dense::symmetric_eigen(self.projected.as_ref().submatrix(0, 0, m, m))?;
        let theta: Vec<f64> = ascending.iter().rev().copied().collect();
        let vectors = Mat::from_fn(m, m, |i, j| vectors[(i, m - 1 - j)]);
        let last = vectors.as_ref().subrows(m - self.width, self.width);
        let outside = dense::product(self.coupling.as_ref(), last);
        let residuals =
            (0..m).map(|j| outside.col(j).norm_l2() / theta[j].abs().max(f64::MIN_POSITIVE)).collect();
        Ok(Ritz { theta, vectors, residuals })
    }

    /// Ritz vectors of the first `k` pairs and their products with `M`, n x k each.
    pub fn vectors(&self, ritz: &Ritz, k: usize) -> (Mat<f64>, Mat<f64>) {
        let turn = |basis: &Mat<f64>| {
            dense::product(basis.as_ref().subcols(0, self.size), ritz.vectors.as_ref().subcols(0, k))
        };
        (turn(&self.basis), turn(&self.mass_basis))
    }

    /// Shrinks the basis to the first `k` Ritz vectors; the next block stays (thick restart, Wu and
    /// Simon 2000).
    pub fn compress(&mut self, ritz: &Ritz, k: usize) {
        let (kept, mass_kept) = self.vectors(ritz, k);
        self.keep(kept.as_ref(), mass_kept.as_ref(), &ritz.theta[..k]);
    }

    /// Takes mass-orthonormal vectors, their products with `M` and their eigenvalues `theta` as the
    /// whole basis.
    pub fn keep(&mut self, vectors: MatRef<'_, f64>, mass_vectors: MatRef<'_, f64>, theta: &[f64]) {
        let k = theta.len();
        self.basis.as_mut().subcols_mut(0, k).copy_from(vectors);
        self.mass_basis.as_mut().subcols_mut(0, k).copy_from(mass_vectors);
        self.projected.fill(0.0);
        for (i, &value) in theta.iter().enumerate() {
            self.projected[(i, i)] = value;
        }
        (self.size, self.previous) = (k, 0);
    }
}

impl Lanczos<'_, ElasticProblem<'_>> {
    /// The first `k` Ritz pairs of the stiffness itself: without the error of a flexibility of
    /// limited accuracy, apart from what it leaves outside the basis.
    pub fn pairs_of_stiffness(&self, k: usize) -> Result<Pairs, DynamicsError> {
        let basis = self.basis.as_ref().subcols(0, self.size);
        let pulled = self.problem.stiffness_product(basis);
        let mut projected = dense::product(basis.transpose(), pulled.as_ref());
        dense::symmetrise(&mut projected);
        let (mut lambda, rotation) = dense::symmetric_eigen(projected.as_ref())?;
        lambda.truncate(k);
        let turn = |basis: &Mat<f64>| {
            dense::product(basis.as_ref().subcols(0, self.size), rotation.as_ref().subcols(0, k))
        };
        Ok(Pairs {
            lambda,
            vectors: turn(&self.basis),
            mass_vectors: turn(&self.mass_basis),
            stiffness_vectors: turn(&pulled),
        })
    }
}

impl Block {
    fn length(&self, j: usize) -> f64 {
        inner(self.x.as_ref(), j, self.mass_x.as_ref(), j).max(0.0).sqrt()
    }
}

/// Inner product of column `i` of `a` and column `j` of `b`.
pub(super) fn inner(a: MatRef<'_, f64>, i: usize, b: MatRef<'_, f64>, j: usize) -> f64 {
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
