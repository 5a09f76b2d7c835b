//! Inertia counts (Sylvester's law, Eq. R.3): how many eigenvalues of `(K, M)` lie below a shift.
//!
//! Large matrices are factorised in single precision, in half the time and memory; the error of that factorisation is
//! measured, and only if it could change no sign does the count stand. Otherwise double precision decides.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::SparseColMatRef;
use faer::sparse::linalg::cholesky::supernodal::SupernodalLdltRef;
use faer::sparse::linalg::cholesky::{LdltRef, SymbolicCholeskyRaw};
use faer::traits::ComplexField;
use faer::{Conj, Mat, Par, Side};

use super::factor::{SymbolicFactor, buffer};
use super::product::symmetric_product;
use super::random::Random;
use crate::DynamicsError;

/// Factors with at least this many entries are tried in single precision first; smaller ones take a fraction of a second.
pub(super) const SINGLE_FROM: usize = 4_000_000;
/// Largest relative error of the single-precision factor, as its iteration matrix contracts; below 1 no sign can differ.
const CONTRACTION_LIMIT: f64 = 0.25;
/// Random vectors and steps by which the contraction is measured.
const PROBES: usize = 4;
const PROBE_STEPS: usize = 3;

/// Outcome of an inertia count.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Inertia {
    /// Number of negative pivots: eigenvalues below the shift.
    pub negative: usize,
    /// Largest pivot against the diagonal entry it comes from; a large value says that the shift sits on an eigenvalue
    /// of the matrix or of a leading block, so that the count is not to be trusted. Infinite if a pivot is zero.
    pub growth: f64,
    /// Measured error of the single-precision factor (contraction of its refinement, below 1); `None` in double precision.
    pub contraction: Option<f64>,
}

impl SymbolicFactor {
    /// Counts the negative pivots of a symmetric matrix with the analysed pattern in double precision.
    ///
    /// # Errors
    /// [`DynamicsError::Factorisation`] if memory runs out.
    pub fn inertia_double(&self, matrix: SparseColMatRef<'_, u32, f64>) -> Result<Inertia, DynamicsError> {
        let factor = self.indefinite(matrix)?;
        Ok(factor.map_or(SINGULAR, |values| self.count_pivots(&values, &diagonal_of(matrix))))
    }

    /// The count in single precision; `None` if the factor is not accurate enough for it to stand.
    ///
    /// With `A` the matrix and `P` the product of its rounded factors, no eigenvalue of `P^-1 (A - P)` at or below -1 means
    /// that no matrix on the line from `P` to `A` is singular: their inertia is the same. The largest eigenvalue is measured
    /// by iterating `x <- x - P^-1 A x` on random vectors, first filtered by `P^-1`, which brings out the modes next to the
    /// shift, whose signs are at stake.
    ///
    /// # Errors
    /// [`DynamicsError::Factorisation`] if memory runs out.
    pub fn inertia_single(
        &self,
        matrix: SparseColMatRef<'_, u32, f64>,
    ) -> Result<Option<Inertia>, DynamicsError> {
        let (scaled, scale) = scaled_to_single(matrix);
        let scaled = SparseColMatRef::new(matrix.symbolic(), &scaled);
        let Some(values) = self.indefinite(scaled)? else { return Ok(None) };
        // The diagonal of the scaled matrix is one up to its sign.
        let inertia = self.count_pivots(&values, &vec![1.0; scale.len()]);
        let contraction = self.contraction(matrix, &scale, &values)?;
        tracing::debug!(contraction, growth = inertia.growth, "inertia count in single precision");
        let stands = contraction <= CONTRACTION_LIMIT && inertia.growth.is_finite();
        Ok(stands.then_some(Inertia { contraction: Some(contraction), ..inertia }))
    }

    /// `L` and `D` of a symmetric matrix in the precision of its entries; `None` if a pivot vanishes.
    fn indefinite<T: ComplexField>(
        &self,
        matrix: SparseColMatRef<'_, u32, T>,
    ) -> Result<Option<Vec<T>>, DynamicsError> {
        let mut values = vec![faer::traits::math_utils::zero::<T>(); self.n_entries()];
        let scratch = self.symbolic.factorize_numeric_ldlt_scratch::<T>(Par::Seq, Default::default());
        let mut memory = buffer(scratch, "the shifted matrix")?;
        let done = self.symbolic.factorize_numeric_ldlt(
            &mut values,
            matrix,
            Side::Lower,
            Default::default(),
            Par::Seq,
            MemStack::new(&mut memory),
            Default::default(),
        );
        Ok(done.is_ok().then_some(values))
    }

    fn count_pivots<T: Copy + Into<f64>>(&self, values: &[T], diagonal: &[f64]) -> Inertia {
        let SymbolicCholeskyRaw::Supernodal(supernodal) = self.symbolic.raw() else { return SINGULAR };
        let factor = SupernodalLdltRef::new(supernodal, values);
        let mut inertia = Inertia { growth: 0.0, ..SINGULAR };
        for s in 0..supernodal.n_supernodes() {
            let block = factor.supernode(s);
            for j in 0..block.val().ncols() {
                let pivot: f64 = block.val()[(j, j)].into();
                let entry = diagonal[self.order[block.start() + j] as usize];
                inertia.negative += usize::from(pivot < 0.0);
                let growth = (pivot / entry).abs();
                inertia.growth = if growth.is_nan() { f64::INFINITY } else { inertia.growth.max(growth) };
            }
        }
        inertia
    }

    /// Largest factor by which `x - P^-1 A x` changes vectors, `P` the rounded factorisation; infinite if it fails.
    fn contraction(
        &self,
        matrix: SparseColMatRef<'_, u32, f64>,
        scale: &[f64],
        values: &[f32],
    ) -> Result<f64, DynamicsError> {
        let factor = LdltRef::new(&self.symbolic, values);
        let scratch = self.symbolic.solve_in_place_scratch::<f32>(PROBES, Par::Seq);
        let mut memory: MemBuffer = buffer(scratch, "the shifted matrix")?;
        // In the scaled unknowns x / scale, in which all are of the same weight.
        let mut solve = |b: &Mat<f64>| {
            let mut x = Mat::from_fn(b.nrows(), PROBES, |i, j| b[(i, j)] as f32);
            factor.solve_in_place_with_conj(Conj::No, x.as_mut(), Par::Seq, MemStack::new(&mut memory));
            Mat::from_fn(b.nrows(), PROBES, |i, j| f64::from(x[(i, j)]))
        };
        let mut random = Random::new(0x5eed);
        let mut x = solve(&Mat::from_fn(scale.len(), PROBES, |_, _| random.next()));
        let mut worst = 0.0_f64;
        for _ in 0..PROBE_STEPS {
            // Unit length: the right-hand sides stay in the range of single precision.
            for j in 0..PROBES {
                let length = x.col(j).norm_l2();
                x.col_mut(j).iter_mut().for_each(|v| *v /= length);
            }
            let physical = Mat::from_fn(x.nrows(), PROBES, |i, j| scale[i] * x[(i, j)]);
            let mut image = Mat::zeros(x.nrows(), PROBES);
            symmetric_product(matrix, physical.as_ref(), image.as_mut());
            let image = Mat::from_fn(x.nrows(), PROBES, |i, j| scale[i] * image[(i, j)]);
            x -= solve(&image);
            for j in 0..PROBES {
                let length = x.col(j).norm_l2();
                worst = if length.is_finite() { length.max(worst) } else { f64::INFINITY };
            }
        }
        Ok(worst)
    }
}

/// The count of a matrix with a pivot that vanishes.
const SINGULAR: Inertia = Inertia { negative: 0, growth: f64::INFINITY, contraction: None };

/// Values of the matrix scaled to a unit diagonal, in single precision, and the scale of each unknown.
pub(super) fn scaled_to_single(matrix: SparseColMatRef<'_, u32, f64>) -> (Vec<f32>, Vec<f64>) {
    let scale: Vec<f64> =
        diagonal_of(matrix).iter().map(|d| 1.0 / d.abs().sqrt().max(f64::MIN_POSITIVE)).collect();
    let mut scaled = Vec::with_capacity(matrix.val().len());
    for j in 0..matrix.ncols() {
        let column = matrix.row_idx_of_col(j).zip(matrix.val_of_col(j));
        scaled.extend(column.map(|(i, &a)| (a * scale[i] * scale[j]) as f32));
    }
    (scaled, scale)
}

fn diagonal_of(matrix: SparseColMatRef<'_, u32, f64>) -> Vec<f64> {
    let entry = |j: usize| matrix.row_idx_of_col(j).zip(matrix.val_of_col(j)).find(|&(i, _)| i == j);
    (0..matrix.ncols()).map(|j| entry(j).map_or(0.0, |(_, &a)| a)).collect()
}
