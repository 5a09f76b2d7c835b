//! Inertia counts (Sylvester's law, Eq. R.7): how many eigenvalues of `(K, M)` lie below a shift.
//!
//! Large matrices are factorised in single precision, in half the time and memory; the error of
//! that factorisation is measured, and only if it could change no sign does the count stand.
//! Otherwise double precision decides.

use std::sync::Arc;

use faer::sparse::SparseColMatRef;
use faer::{Mat, MatMut};

use crate::DynamicsError;
use crate::reduction::blocks::product::symmetric_product;
use crate::reduction::blocks::random::Random;
use crate::reduction::factor::numeric::Kind;
use crate::reduction::factor::single_precision::{SinglePrecisionFactor, diagonal_of};
use crate::reduction::factor::{CholeskyFactor, SymbolicFactor};

/// Factors with at least this many entries are tried in single precision first; smaller ones take a
/// fraction of a second.
pub(super) const SINGLE_FROM: usize = 4_000_000;
/// Largest relative error of the single-precision factor, as its iteration matrix contracts; below
/// 1 no sign can differ.
const CONTRACTION_LIMIT: f64 = 0.25;
/// Random vectors and steps by which the contraction is measured.
const PROBES: usize = 4;
const PROBE_STEPS: usize = 3;

/// Outcome of an inertia count.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Inertia {
    /// Number of negative pivots: eigenvalues below the shift.
    pub negative: usize,
    /// Largest pivot against the diagonal entry it comes from; a large value says that the shift
    /// sits on an eigenvalue of the matrix or of a leading block, so that the count is not to be
    /// trusted. Infinite if a pivot is zero.
    pub growth: f64,
    /// Measured error of the single-precision factor (contraction of its refinement, below 1 where
    /// the count stands); `None` in double precision.
    pub contraction: Option<f64>,
}

impl Inertia {
    /// Whether the factor is accurate enough for the count to stand.
    pub(super) fn stands(&self) -> bool {
        self.contraction.is_none_or(|c| c <= CONTRACTION_LIMIT) && self.growth.is_finite()
    }
}

/// The factor of `K - mu M` in the precision in which its pivots could be counted.
#[derive(Debug)]
pub(in crate::reduction) enum ShiftedFactor {
    Single(SinglePrecisionFactor),
    Double(CholeskyFactor),
}

impl ShiftedFactor {
    /// Solves `(K - mu M) x = b` in place to the accuracy of the factor.
    pub fn solve_in_place(&self, x: MatMut<'_, f64>) {
        match self {
            Self::Single(factor) => factor.solve_in_place(x),
            Self::Double(factor) => factor.solve_in_place(x),
        }
    }
}

impl SymbolicFactor {
    /// Counts the negative pivots of a symmetric matrix with the analysed pattern in double
    /// precision.
    ///
    /// # Errors
    /// [`DynamicsError::FactorTooLarge`] if memory does not suffice.
    ///
    /// # Panics
    /// If the matrix has not as many entries as the pattern.
    pub fn inertia_double(
        self: &Arc<Self>,
        matrix: SparseColMatRef<'_, u32, f64>,
    ) -> Result<Inertia, DynamicsError> {
        Ok(self.counted_double(matrix)?.0)
    }

    /// The same with the factor, unless a pivot vanishes.
    pub(super) fn counted_double(
        self: &Arc<Self>,
        matrix: SparseColMatRef<'_, u32, f64>,
    ) -> Result<(Inertia, Option<ShiftedFactor>), DynamicsError> {
        self.check_memory_beside(size_of::<f64>())?;
        let Some(factor) = self.indefinite(matrix) else { return Ok((SINGULAR, None)) };
        let inertia = self.count_pivots(factor.values(), &diagonal_of(matrix));
        Ok((inertia, Some(ShiftedFactor::Double(factor))))
    }

    /// The count in single precision; `None` if the factor is not accurate enough for it to stand.
    ///
    /// With `A` the matrix and `P` the product of its rounded factors, no eigenvalue of
    /// `P^-1 (A - P)` at or below -1 means that no matrix on the line from `P` to `A` is singular:
    /// their inertia is the same. The largest eigenvalue is measured by iterating
    /// `x <- x - P^-1 A x` on random vectors, first filtered by `P^-1`, which brings out the modes
    /// next to the shift, whose signs are at stake.
    ///
    /// # Errors
    /// [`DynamicsError::FactorTooLarge`] if memory does not suffice.
    ///
    /// # Panics
    /// If the matrix has not as many entries as the pattern.
    pub fn inertia_single(
        self: &Arc<Self>,
        matrix: SparseColMatRef<'_, u32, f64>,
    ) -> Result<Option<Inertia>, DynamicsError> {
        let counted = self.counted_single(matrix)?;
        Ok(counted.map(|(inertia, _)| inertia).filter(Inertia::stands))
    }

    /// The count whether it stands or not, with the factor; `None` if a pivot vanishes.
    pub(super) fn counted_single(
        self: &Arc<Self>,
        matrix: SparseColMatRef<'_, u32, f64>,
    ) -> Result<Option<(Inertia, ShiftedFactor)>, DynamicsError> {
        self.check_memory_beside(size_of::<f32>())?;
        let Some(factor) = SinglePrecisionFactor::new(self, matrix, &[], Kind::Indefinite) else {
            return Ok(None);
        };
        // The diagonal of the scaled matrix is one up to its sign.
        let inertia = self.count_pivots(factor.values(), &vec![1.0; self.n_unknowns()]);
        let contraction = contraction(matrix, &factor);
        tracing::debug!(contraction, growth = inertia.growth, "inertia count in single precision");
        let counted = Inertia { contraction: Some(contraction), ..inertia };
        Ok(Some((counted, ShiftedFactor::Single(factor))))
    }

    fn count_pivots<T: Copy + Into<f64>>(&self, values: &[T], diagonal: &[f64]) -> Inertia {
        let mut inertia = Inertia { growth: 0.0, ..SINGULAR };
        for panel in self.layout.all_panels() {
            for column in panel.first..panel.end {
                let place = panel.values + (column - panel.first) * (panel.n_rows + 1);
                let root: f64 = values[place].into();
                let pivot = root * root.abs();
                let entry = diagonal[self.order()[column] as usize];
                inertia.negative += usize::from(pivot < 0.0);
                let growth = (pivot / entry).abs();
                inertia.growth = if growth.is_nan() { f64::INFINITY } else { inertia.growth.max(growth) };
            }
        }
        inertia
    }
}

/// Largest factor by which `x - P^-1 A x` changes vectors, `P` the rounded factorisation; infinite
/// if it fails.
fn contraction(matrix: SparseColMatRef<'_, u32, f64>, factor: &SinglePrecisionFactor) -> f64 {
    let scale = factor.scale();
    let mut random = Random::new(0x5eed);
    let mut x = Mat::from_fn(scale.len(), PROBES, |i, _| random.next() / scale[i]);
    factor.solve_in_place(x.as_mut());
    // In the scaled unknowns, in which all are of the same weight.
    let length = |x: &Mat<f64>, j: usize| {
        x.col(j).iter().zip(scale).map(|(x, s)| (x / s) * (x / s)).sum::<f64>().sqrt()
    };
    let mut worst = 0.0_f64;
    for _ in 0..PROBE_STEPS {
        for j in 0..PROBES {
            let length = length(&x, j);
            x.col_mut(j).iter_mut().for_each(|v| *v /= length);
        }
        let mut image = Mat::zeros(x.nrows(), PROBES);
        symmetric_product(matrix, x.as_ref(), image.as_mut());
        factor.solve_in_place(image.as_mut());
        x -= &image;
        for j in 0..PROBES {
            let length = length(&x, j);
            worst = if length.is_finite() { length.max(worst) } else { f64::INFINITY };
        }
    }
    worst
}

/// The count of a matrix with a pivot that vanishes.
const SINGULAR: Inertia = Inertia { negative: 0, growth: f64::INFINITY, contraction: None };
