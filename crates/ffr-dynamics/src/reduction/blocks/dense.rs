//! Dense kernels: large products and solves on the threads of the current rayon pool, in tiles that
//! the sizes alone decide, each tile sequential: the same bits on every run and for any number of
//! threads.

use crate::error::MatrixFault;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt;
use faer::linalg::evd::{
    ComputeEigenvectors, SelfAdjointEvdParams, self_adjoint_evd, self_adjoint_evd_scratch,
};
use faer::linalg::matmul::matmul;
use faer::linalg::triangular_solve::{solve_lower_triangular_in_place, solve_upper_triangular_in_place};
use faer::{Accum, Auto, Mat, MatMut, MatRef, Par};

use crate::DynamicsError;

/// Product `a b`.
pub fn product(a: MatRef<'_, f64>, b: MatRef<'_, f64>) -> Mat<f64> {
    let mut c = Mat::zeros(a.nrows(), b.ncols());
    multiply(c.as_mut(), Accum::Replace, 1.0, a, b);
    c
}

/// Adds `factor a b` to `c`.
pub fn add_product(c: MatMut<'_, f64>, factor: f64, a: MatRef<'_, f64>, b: MatRef<'_, f64>) {
    multiply(c, Accum::Add, factor, a, b);
}

/// Multiplications that one thread does at a time, some tenths of a millisecond, if the sizes
/// allow.
const TILE_WORK: usize = 1 << 22;
/// Rows or columns of the smallest tile.
const TILE: usize = 32;

/// Rows or columns of a tile if each of them takes `work` multiplications.
fn tile(work: usize) -> usize {
    (TILE_WORK / work.max(1)).next_multiple_of(TILE).max(TILE)
}

fn multiply(c: MatMut<'_, f64>, accum: Accum, factor: f64, a: MatRef<'_, f64>, b: MatRef<'_, f64>) {
    let (m, n, k) = (c.nrows(), c.ncols(), a.ncols());
    if m.saturating_mul(n).saturating_mul(k) <= TILE_WORK || (m < 2 * TILE && n < 2 * TILE) {
        matmul(c, accum, a, b, factor, Par::Seq);
    } else if m >= n {
        let half = halved(m, tile(n * k));
        let (upper, lower) = c.split_at_row_mut(half);
        let (a_upper, a_lower) = a.split_at_row(half);
        if half == m {
            matmul(upper, accum, a_upper, b, factor, Par::Seq);
            return;
        }
        rayon::join(
            || multiply(upper, accum, factor, a_upper, b),
            || multiply(lower, accum, factor, a_lower, b),
        );
    } else {
        let half = halved(n, tile(m * k));
        let (left, right) = c.split_at_col_mut(half);
        let (b_left, b_right) = b.split_at_col(half);
        if half == n {
            matmul(left, accum, a, b_left, factor, Par::Seq);
            return;
        }
        rayon::join(
            || multiply(left, accum, factor, a, b_left),
            || multiply(right, accum, factor, a, b_right),
        );
    }
}

/// About half of `n` in whole tiles; all of it if it is no more than one.
fn halved(n: usize, tile: usize) -> usize {
    if n <= tile { n } else { (n.div_ceil(tile) / 2 * tile).max(tile) }
}

/// Calls `solve` with tiles of the columns of `x`, right-hand sides of a triangle of as many rows.
fn by_columns(x: MatMut<'_, f64>, solve: &(impl Fn(MatMut<'_, f64>) + Sync)) {
    let half = halved(x.ncols(), tile(x.nrows().saturating_mul(x.nrows()) / 2));
    if half == x.ncols() {
        solve(x);
        return;
    }
    let (left, right) = x.split_at_col_mut(half);
    rayon::join(|| by_columns(left, solve), || by_columns(right, solve));
}

/// Makes a matrix that is symmetric up to round-off exactly symmetric.
pub fn symmetrise(a: &mut Mat<f64>) {
    for j in 0..a.ncols() {
        for i in j + 1..a.nrows() {
            let mean = 0.5 * (a[(i, j)] + a[(j, i)]);
            a[(i, j)] = mean;
            a[(j, i)] = mean;
        }
    }
}

/// Lower Cholesky factor of a symmetric positive definite matrix (only the lower triangle is read).
///
/// # Errors
/// [`DynamicsError::NotPositiveDefinite`] with the pivot that fails, named `matrix` in the text.
pub fn cholesky(mut a: Mat<f64>, matrix: &'static str) -> Result<Mat<f64>, DynamicsError> {
    let n = a.nrows();
    let scratch = llt::factor::cholesky_in_place_scratch::<f64>(n, Par::Seq, Default::default());
    let mut memory = MemBuffer::new(scratch);
    let stack = MemStack::new(&mut memory);
    let done =
        llt::factor::cholesky_in_place(a.as_mut(), Default::default(), Par::Seq, stack, Default::default());
    if let Err(llt::factor::LltError::NonPositivePivot { index }) = done {
        return Err(DynamicsError::NotPositiveDefinite { matrix, pivot: index, size: n });
    }
    for j in 0..n {
        if !a[(j, j)].is_finite() {
            return Err(DynamicsError::NotPositiveDefinite { matrix, pivot: j, size: n });
        }
        a.col_mut(j).subrows_mut(0, j).fill(0.0);
    }
    Ok(a)
}

/// Solves `L x = b` in place.
pub fn solve_lower(l: MatRef<'_, f64>, x: MatMut<'_, f64>) {
    by_columns(x, &|x| solve_lower_triangular_in_place(l, x, Par::Seq));
}

/// Solves `L^T x = b` in place.
pub fn solve_lower_transposed(l: MatRef<'_, f64>, x: MatMut<'_, f64>) {
    by_columns(x, &|x| solve_upper_triangular_in_place(l.transpose(), x, Par::Seq));
}

/// Inverse `L^-T L^-1` of `L L^T`. Zeros of the triangles are left out, and half of what is symmetric: a third of the
/// work of a solution for all unit vectors and the product of two full matrices.
pub fn inverse_of_factor(l: MatRef<'_, f64>) -> Mat<f64> {
    let n = l.nrows();
    let mut x = Mat::identity(n, n);
    by_tiles(x.as_mut(), 0, &|x, first| {
        let (l, x) = (l.submatrix(first, first, n - first, n - first), x.subrows_mut(first, n - first));
        solve_lower_triangular_in_place(l, x, Par::Seq);
    });
    let mut g = Mat::zeros(n, n);
    by_tiles(g.as_mut(), 0, &|mut g, first| {
        // Rows of `x` above the first of a tile have no share in it.
        for row in (first..n).step_by(INVERSE_TILE) {
            let height = INVERSE_TILE.min(n - row);
            let below = x.subrows(row, n - row);
            let (a, b) = (below.subcols(row, height), below.subcols(first, g.ncols()));
            matmul(g.as_mut().subrows_mut(row, height), Accum::Replace, a.transpose(), b, 1.0, Par::Seq);
        }
    });
    for j in 0..n {
        for i in j + 1..n {
            g[(j, i)] = g[(i, j)];
        }
    }
    g
}

/// Columns of a tile of an inverse: few beside the thousands of a large one, enough for the kernels.
const INVERSE_TILE: usize = 128;

/// Calls `work` with tiles of the columns of `x`, the first of which is number `first`, and the number of their first one.
fn by_tiles(x: MatMut<'_, f64>, first: usize, work: &(impl Fn(MatMut<'_, f64>, usize) + Sync)) {
    let half = halved(x.ncols(), INVERSE_TILE);
    if half == x.ncols() {
        work(x, first);
        return;
    }
    let (left, right) = x.split_at_col_mut(half);
    rayon::join(|| by_tiles(left, first, work), || by_tiles(right, first + half, work));
}

/// Eigenvalues in ascending order and orthonormal eigenvectors of a symmetric matrix.
///
/// Divide and conquer; its secular equation is sometimes solved to half the digits only (residuals
/// of 1e-8 were seen on a well-separated spectrum of 234), so the residual is checked and the
/// slower QR iteration taken where it is too large.
///
/// # Errors
/// [`DynamicsError::Factorisation`] if the matrix is not finite or the iteration does not converge.
pub fn symmetric_eigen(a: MatRef<'_, f64>) -> Result<(Vec<f64>, Mat<f64>), DynamicsError> {
    let failed = |fault| DynamicsError::Factorisation { matrix: "a projected matrix", fault };
    if !a.col_iter().all(|column| column.iter().all(|x| x.is_finite())) {
        return Err(failed(MatrixFault::NotFinite));
    }
    let default: SelfAdjointEvdParams = <SelfAdjointEvdParams as Auto<f64>>::auto();
    let qr_iteration = SelfAdjointEvdParams { recursion_threshold: usize::MAX, ..default };
    for parameters in [default, qr_iteration] {
        if let Some((values, vectors)) = eigen_with(a, parameters)
            && eigen_residual(a, &values, &vectors) <= EIGEN_RESIDUAL
        {
            return Ok((values, vectors));
        }
    }
    Err(failed(MatrixFault::NoConvergence))
}

/// Largest entry of `A V - V Lambda` against the largest eigenvalue that an eigensolver may leave:
/// round-off of matrices of a few thousand rows is ten times smaller.
const EIGEN_RESIDUAL: f64 = 1e-12;

fn eigen_with(a: MatRef<'_, f64>, parameters: SelfAdjointEvdParams) -> Option<(Vec<f64>, Mat<f64>)> {
    let n = a.nrows();
    let mut vectors = Mat::zeros(n, n);
    let mut values = faer::Col::<f64>::zeros(n);
    let vectors_too = ComputeEigenvectors::Yes;
    let scratch = self_adjoint_evd_scratch::<f64>(n, vectors_too, Par::Seq, parameters.into());
    let mut memory = MemBuffer::new(scratch);
    let stack = MemStack::new(&mut memory);
    let diagonal = values.as_mut().as_diagonal_mut();
    self_adjoint_evd(a, diagonal, Some(vectors.as_mut()), Par::Seq, stack, parameters.into()).ok()?;
    Some((values.iter().copied().collect(), vectors))
}

fn eigen_residual(a: MatRef<'_, f64>, values: &[f64], vectors: &Mat<f64>) -> f64 {
    let mut rest = product(a, vectors.as_ref());
    for (j, value) in values.iter().enumerate() {
        for i in 0..rest.nrows() {
            rest[(i, j)] -= value * vectors[(i, j)];
        }
    }
    let largest = values.iter().fold(f64::MIN_POSITIVE, |top: f64, value| top.max(value.abs()));
    rest.norm_max() / largest
}

/// Orthonormal basis of the complement of the columns of `a` (n x r, independent columns): n x (n -
/// r).
pub fn orthogonal_complement(a: MatRef<'_, f64>) -> Mat<f64> {
    let (n, r) = (a.nrows(), a.ncols());
    let mut work = a.to_owned();
    let mut reflectors = Mat::<f64>::zeros(n, r);
    for j in 0..r {
        for i in j..n {
            reflectors[(i, j)] = work[(i, j)];
        }
        let norm = reflectors.col(j).norm_l2();
        reflectors[(j, j)] += norm.copysign(work[(j, j)]);
        let length = reflectors.col(j).norm_l2().max(f64::MIN_POSITIVE);
        reflectors.col_mut(j).iter_mut().for_each(|x| *x /= length);
        reflect(reflectors.col(j).as_mat(), work.as_mut());
    }
    let mut complement = Mat::from_fn(n, n - r, |i, j| if i == j + r { 1.0 } else { 0.0 });
    for j in (0..r).rev() {
        reflect(reflectors.col(j).as_mat(), complement.as_mut());
    }
    complement
}

/// Householder reflection `x - 2 v v^T x` with a unit vector `v` (n x 1).
fn reflect(v: MatRef<'_, f64>, x: MatMut<'_, f64>) {
    let dots = product(v.transpose(), x.as_ref());
    add_product(x, -2.0, v, dots.as_ref());
}

/// Rows that support the columns of `rigid` best: greedy pivoting, one row per column; `allowed`
/// filters rows.
///
/// Returns fewer rows than columns if the allowed rows do not hold all motions.
pub fn pivot_rows(rigid: MatRef<'_, f64>, allowed: impl Fn(usize) -> bool) -> Vec<usize> {
    let mut rest = rigid.to_owned();
    let mut rows = Vec::with_capacity(rigid.ncols());
    let norm = |m: &Mat<f64>, i: usize| m.row(i).iter().map(|x| x * x).sum::<f64>();
    let scale = (0..rigid.nrows()).map(|i| norm(&rest, i)).fold(0.0, f64::max);
    for _ in 0..rigid.ncols() {
        let best = (0..rest.nrows())
            .filter(|&i| allowed(i))
            .max_by(|&i, &j| norm(&rest, i).total_cmp(&norm(&rest, j)));
        let Some(best) = best else { break };
        let length = norm(&rest, best);
        // Squared: a motion held by less than 1e-7 of the best lever is not held.
        if length <= 1e-14 * scale {
            break;
        }
        let direction = Mat::from_fn(rest.ncols(), 1, |c, _| rest[(best, c)] / length.sqrt());
        let along = product(rest.as_ref(), direction.as_ref());
        add_product(rest.as_mut(), -1.0, along.as_ref(), direction.transpose());
        rows.push(best);
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_inverse_of_several_tiles_is_that_of_the_whole_factor() {
        // No multiple of a tile; rows that fall off keep the condition at some ten.
        let n = 2 * INVERSE_TILE + 37;
        let entry = |i: usize, j: usize| if i < j { 0.0 } else { 1.0 / (1.0 + 3.0 * (i - j) as f64) };
        let l = Mat::from_fn(n, n, entry);
        let found =
            product(inverse_of_factor(l.as_ref()).as_ref(), product(l.as_ref(), l.transpose()).as_ref());
        let off = |i: usize, j: usize| (found[(i, j)] - f64::from(u8::from(i == j))).abs();
        assert!((0..n * n).all(|k| off(k % n, k / n) < 1e-11));
    }
}
