//! Real and complex numbers in which a tree is solved; products and inverses of a few rows and
//! columns.
//!
//! They work on arrays of columns, whose lengths are known, so that compilers find whole registers
//! to work on.

use faer::c64;
use nalgebra::{ArrayStorage, ComplexField, Matrix6, SMatrix, Vector6};

/// Pivot, as a share of the diagonal entry it came from, below which an inertia counts as singular:
/// round-off.
const SMALLEST_PIVOT: f64 = 1e-13;

/// Number of a linear system whose impedances are real or complex.
pub(crate) trait Number: ComplexField<RealField = f64> + Copy {
    /// Inverse of a symmetric matrix that inertia makes regular; none if it is singular.
    fn inverse_of_inertia(matrix: &Matrix6<Self>) -> Option<Matrix6<Self>>;
}

impl Number for f64 {
    /// Gauss-Jordan elimination along the diagonal, stable for positive definite matrices.
    fn inverse_of_inertia(matrix: &Matrix6<Self>) -> Option<Matrix6<Self>> {
        let mut a = matrix.data.0;
        for k in 0..6 {
            // NaN is no inertia either.
            let is_positive = a[k][k] > SMALLEST_PIVOT * matrix[(k, k)];
            if !is_positive {
                return None;
            }
            eliminate(&mut a, k);
        }
        Some(Matrix6::from_array_storage(ArrayStorage(a)))
    }
}

impl Number for c64 {
    fn inverse_of_inertia(matrix: &Matrix6<Self>) -> Option<Matrix6<Self>> {
        inverse(matrix)
    }
}

/// Inverse by Gauss-Jordan elimination with row pivots; none if the matrix is singular or not
/// finite.
pub(super) fn inverse<T: Number, const N: usize>(matrix: &SMatrix<T, N, N>) -> Option<SMatrix<T, N, N>> {
    let mut a = matrix.data.0;
    let mut rows = [0; N];
    for (k, row) in rows.iter_mut().enumerate() {
        *row = (k..N).max_by(|i, j| a[k][*i].norm1().total_cmp(&a[k][*j].norm1()))?;
        if *row != k {
            a.iter_mut().for_each(|column| column.swap(k, *row));
        }
        let size = a[k][k].norm1();
        let is_regular = size > 0.0 && size.is_finite();
        if !is_regular {
            return None;
        }
        eliminate(&mut a, k);
    }
    for (k, row) in rows.into_iter().enumerate().rev() {
        a.swap(k, row);
    }
    Some(SMatrix::from_array_storage(ArrayStorage(a)))
}

/// One step of Gauss-Jordan elimination in place of columns, with the pivot on the diagonal.
fn eliminate<T: Number, const N: usize>(a: &mut [[T; N]; N], k: usize) {
    let reciprocal = a[k][k].recip();
    let mut pivot_column = a[k];
    pivot_column[k] = T::zero();
    for (j, column) in a.iter_mut().enumerate() {
        let factor = if j == k { reciprocal } else { column[k] * reciprocal };
        if j == k {
            *column = [T::zero(); N];
        }
        for (x, p) in column.iter_mut().zip(&pivot_column) {
            *x -= *p * factor;
        }
        column[k] = factor;
    }
}

/// `a x`.
pub(super) fn applied<T: Number>(a: &Matrix6<T>, x: &Vector6<T>) -> Vector6<T> {
    Vector6::from(combined(&a.data.0, &x.data.0[0]))
}

/// `aᵀ x`.
pub(super) fn transposed_applied<T: Number>(a: &Matrix6<T>, x: &Vector6<T>) -> Vector6<T> {
    Vector6::from(combined(&a.transpose().data.0, &x.data.0[0]))
}

/// `a b`.
pub(super) fn product<T: Number>(a: &Matrix6<T>, b: &Matrix6<T>) -> Matrix6<T> {
    Matrix6::from_array_storage(ArrayStorage(b.data.0.map(|column| combined(&a.data.0, &column))))
}

/// `aᵀ b`.
pub(super) fn transposed_product<T: Number>(a: &Matrix6<T>, b: &Matrix6<T>) -> Matrix6<T> {
    product(&a.transpose(), b)
}

/// Columns, each as often as `factors` says.
fn combined<T: Number>(columns: &[[T; 6]; 6], factors: &[T; 6]) -> [T; 6] {
    let mut sum = [T::zero(); 6];
    for (column, factor) in columns.iter().zip(factors) {
        for (s, c) in sum.iter_mut().zip(column) {
            *s += *c * *factor;
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Entries without a pattern, of size one, and a diagonal that keeps the condition small.
    fn irregular(seed: f64) -> Matrix6<f64> {
        let entries =
            Matrix6::from_fn(|r, c| (seed + 1.7 * r as f64 + 2.9 * c as f64 + 0.3 * (r * c) as f64).sin());
        entries + Matrix6::identity() * 4.0
    }

    /// Round-off of 36 products, times a condition of some hundred.
    const ROUND_OFF: f64 = 1e-12;

    #[test]
    fn inverses_are_inverse() {
        let general = irregular(0.4);
        let product = general * inverse(&general).expect("regular");
        assert!((product - Matrix6::identity()).amax() < ROUND_OFF, "{product}");
        let definite = general * general.transpose() + Matrix6::identity();
        let found = f64::inverse_of_inertia(&definite).expect("positive definite");
        assert!((definite * found - Matrix6::identity()).amax() < ROUND_OFF);
        let complex = general.zip_map(&irregular(1.1), c64::new);
        let product = complex * c64::inverse_of_inertia(&complex).expect("regular");
        let error = (product - Matrix6::identity()).iter().map(|x| x.norm1()).fold(0.0, f64::max);
        assert!(error < ROUND_OFF, "{error}");
    }

    #[test]
    fn products_are_those_of_matrices() {
        let (a, b) = (irregular(0.4), irregular(1.1));
        let x = Vector6::from_fn(|i, _| 0.3 + i as f64);
        assert!((product(&a, &b) - a * b).amax() < ROUND_OFF);
        assert!((transposed_product(&a, &b) - a.transpose() * b).amax() < ROUND_OFF);
        assert!((applied(&a, &x) - a * x).amax() < ROUND_OFF);
        assert!((transposed_applied(&a, &x) - a.transpose() * x).amax() < ROUND_OFF);
    }

    #[test]
    fn pivots_may_be_anywhere() {
        let permutation = Matrix6::from_fn(|r, c| if (r + 1) % 6 == c { 2.0 } else { 0.0 });
        assert_eq!(inverse(&permutation), Some(permutation.transpose() / 4.0));
    }

    #[test]
    fn what_lacks_inertia_has_no_inverse() {
        let mut flat = Matrix6::<f64>::identity();
        flat[(3, 3)] = 0.0;
        assert_eq!(f64::inverse_of_inertia(&flat), None);
        assert_eq!(inverse(&flat), None);
        flat[(3, 3)] = -1.0;
        assert_eq!(f64::inverse_of_inertia(&flat), None, "negative");
        flat[(3, 3)] = f64::NAN;
        assert_eq!(f64::inverse_of_inertia(&flat), None, "not a number");
        assert_eq!(inverse(&flat), None);
    }
}
