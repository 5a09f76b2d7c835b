//! Triangular solves with a supernodal Cholesky factor for several right-hand sides at once.
//!
//! Such solves are bound by reading the factor from memory. Right-hand sides are kept by rows, 64 bytes an unknown (eight
//! numbers in double precision, sixteen in single), so that each entry of the factor is read once and serves one vector
//! register.

use faer::sparse::linalg::cholesky::supernodal::{SupernodalLltRef, SymbolicSupernodalCholesky};
use faer::traits::ComplexField;
use pulp::{Simd, WithSimd};

/// Numbers of which a factor may consist.
pub(super) trait Entry:
    ComplexField + Copy + PartialEq + std::ops::MulAssign + std::ops::AddAssign
{
    /// One unknown of all right-hand sides.
    type Row: Copy + AsMut<[Self]> + AsRef<[Self]>;
    /// A vector register.
    type Register<S: Simd>: Copy;
    /// Right-hand sides solved for at once.
    const WIDTH: usize;
    /// Right-hand sides that vanish.
    const ZERO: Self::Row;

    fn inverse(self) -> Self;
    /// A row as vector registers; their number of lanes divides its length.
    fn lanes<S: Simd>(row: &Self::Row) -> &[Self::Register<S>];
    fn lanes_mut<S: Simd>(row: &mut Self::Row) -> &mut [Self::Register<S>];
    fn splat<S: Simd>(simd: S, value: Self) -> Self::Register<S>;
    /// `sum - a b`.
    fn sub_mul<S: Simd>(
        simd: S,
        a: Self::Register<S>,
        b: Self::Register<S>,
        sum: Self::Register<S>,
    ) -> Self::Register<S>;
}

macro_rules! entry {
    ($number:ty, $width:literal, $register:ident, $lanes:ident, $lanes_mut:ident, $splat:ident, $mul_add:ident, $neg:ident) => {
        impl Entry for $number {
            type Row = [$number; $width];
            type Register<S: Simd> = S::$register;
            const WIDTH: usize = $width;
            const ZERO: Self::Row = [0.0; $width];

            #[inline(always)]
            fn inverse(self) -> Self {
                1.0 / self
            }

            #[inline(always)]
            fn lanes<S: Simd>(row: &Self::Row) -> &[S::$register] {
                S::$lanes(row).0
            }

            #[inline(always)]
            fn lanes_mut<S: Simd>(row: &mut Self::Row) -> &mut [S::$register] {
                S::$lanes_mut(row).0
            }

            #[inline(always)]
            fn splat<S: Simd>(simd: S, value: Self) -> S::$register {
                simd.$splat(value)
            }

            #[inline(always)]
            fn sub_mul<S: Simd>(
                simd: S,
                a: S::$register,
                b: S::$register,
                sum: S::$register,
            ) -> S::$register {
                simd.$mul_add(simd.$neg(a), b, sum)
            }
        }
    };
}

entry!(f64, 8, f64s, as_simd_f64s, as_mut_simd_f64s, splat_f64s, mul_add_f64s, neg_f64s);
entry!(f32, 16, f32s, as_simd_f32s, as_mut_simd_f32s, splat_f32s, mul_add_f32s, neg_f32s);

/// Columns eliminated together; their part of the factor is read once for every [`CHUNK`] of rows.
const BLOCK: usize = 32;
/// Rows that stay in the first-level cache while a block of columns passes: 8 KiB.
const CHUNK: usize = 128;
/// Columns that share one load and store of a row.
const PANEL: usize = 4;

/// Rows of the largest supernode: the length of the local buffer that [`solve`] needs.
pub(super) fn largest_supernode(symbolic: &SymbolicSupernodalCholesky<u32>) -> usize {
    let rows = |s: usize| {
        let width = symbolic.supernode_end()[s] - symbolic.supernode_begin()[s];
        width as usize + symbolic.supernode(s).pattern().len()
    };
    (0..symbolic.n_supernodes()).map(rows).max().unwrap_or(0)
}

/// Solves `L Lᵀ x = b` in place in the elimination order, with the widest vector registers that the processor has.
pub(super) fn solve<T: Entry>(factor: SupernodalLltRef<'_, u32, T>, x: &mut [T::Row], local: &mut [T::Row]) {
    pulp::Arch::new().dispatch(Solve { factor, x, local });
}

struct Solve<'a, T: Entry> {
    factor: SupernodalLltRef<'a, u32, T>,
    x: &'a mut [T::Row],
    local: &'a mut [T::Row],
}

impl<T: Entry> WithSimd for Solve<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        forward(simd, self.factor, self.x, self.local);
        backward(simd, self.factor, self.x, self.local);
    }
}

/// A supernode: entries by columns, `n_rows` a column, the first `width` rows being its own.
struct Supernode<'a, T> {
    start: usize,
    width: usize,
    n_rows: usize,
    pattern: &'a [u32],
    values: &'a [T],
}

impl<'a, T: Entry> Supernode<'a, T> {
    #[inline(always)]
    fn new(factor: SupernodalLltRef<'a, u32, T>, s: usize) -> Self {
        let block = factor.supernode(s);
        let (n_rows, width) = (block.val().nrows(), block.val().ncols());
        let symbolic = factor.symbolic();
        let first = symbolic.col_ptr_for_val()[s] as usize;
        Self {
            start: block.start(),
            width,
            n_rows,
            pattern: block.pattern(),
            values: &factor.values()[first..first + n_rows * width],
        }
    }

    #[inline(always)]
    fn column(&self, j: usize) -> &'a [T] {
        &self.values[j * self.n_rows..(j + 1) * self.n_rows]
    }

    #[inline(always)]
    fn panel(&self, j: usize) -> [&'a [T]; PANEL] {
        std::array::from_fn(|c| self.column(j + c))
    }
}

#[inline(always)]
fn forward<T: Entry, S: Simd>(
    simd: S,
    factor: SupernodalLltRef<'_, u32, T>,
    x: &mut [T::Row],
    local: &mut [T::Row],
) {
    for s in 0..factor.symbolic().n_supernodes() {
        let node = Supernode::new(factor, s);
        let w = &mut local[..node.n_rows];
        w[..node.width].copy_from_slice(&x[node.start..node.start + node.width]);
        w[node.width..].fill(T::ZERO);
        let mut first = 0;
        while first < node.width {
            let end = (first + BLOCK).min(node.width);
            for j in first..end {
                let column = node.column(j);
                scale::<T>(&mut w[j], column[j].inverse());
                let value = w[j];
                for (row, l) in w[j + 1..end].iter_mut().zip(&column[j + 1..end]) {
                    subtract::<T, S>(simd, row, *l, &value);
                }
            }
            let (done, below) = w.split_at_mut(end);
            let own = &done[first..];
            for (k, rows) in below.chunks_mut(CHUNK).enumerate() {
                let at = end + k * CHUNK;
                eliminate(simd, &node, first, own, at, rows);
            }
            first = end;
        }
        x[node.start..node.start + node.width].copy_from_slice(&w[..node.width]);
        for (&i, row) in node.pattern.iter().zip(&w[node.width..]) {
            for (target, part) in x[i as usize].as_mut().iter_mut().zip(row.as_ref()) {
                *target += *part;
            }
        }
    }
}

/// Subtracts the columns `first..` times `own` from the rows that start at `at`.
#[inline(always)]
fn eliminate<T: Entry, S: Simd>(
    simd: S,
    node: &Supernode<'_, T>,
    first: usize,
    own: &[T::Row],
    at: usize,
    rows: &mut [T::Row],
) {
    let n = rows.len();
    let full = own.len() / PANEL * PANEL;
    for c in (0..full).step_by(PANEL) {
        let l = node.panel(first + c).map(|column| &column[at..at + n]);
        let x: [T::Row; PANEL] = std::array::from_fn(|k| own[c + k]);
        let [l0, l1, l2, l3] = l;
        for ((((row, l0), l1), l2), l3) in rows.iter_mut().zip(l0).zip(l1).zip(l2).zip(l3) {
            let factors = [l0, l1, l2, l3].map(|l| T::splat(simd, *l));
            for (g, target) in T::lanes_mut::<S>(row).iter_mut().enumerate() {
                let mut sum = *target;
                for (factor, x) in factors.iter().zip(&x) {
                    sum = T::sub_mul(simd, *factor, T::lanes::<S>(x)[g], sum);
                }
                *target = sum;
            }
        }
    }
    for (c, x) in own.iter().enumerate().skip(full) {
        let column = &node.column(first + c)[at..at + n];
        for (row, l) in rows.iter_mut().zip(column) {
            subtract::<T, S>(simd, row, *l, x);
        }
    }
}

#[inline(always)]
fn backward<T: Entry, S: Simd>(
    simd: S,
    factor: SupernodalLltRef<'_, u32, T>,
    x: &mut [T::Row],
    local: &mut [T::Row],
) {
    for s in (0..factor.symbolic().n_supernodes()).rev() {
        let node = Supernode::new(factor, s);
        let w = &mut local[..node.n_rows];
        w[..node.width].copy_from_slice(&x[node.start..node.start + node.width]);
        for (row, &i) in w[node.width..].iter_mut().zip(node.pattern) {
            *row = x[i as usize];
        }
        let mut end = node.width;
        while end > 0 {
            let first = (end - 1) / BLOCK * BLOCK;
            let (done, below) = w.split_at_mut(end);
            let own = &mut done[first..];
            for (k, rows) in below.chunks(CHUNK).enumerate() {
                let at = end + k * CHUNK;
                gather(simd, &node, first, own, at, rows);
            }
            for j in (first..end).rev() {
                let column = node.column(j);
                let mut value = w[j];
                for (row, l) in w[j + 1..end].iter().zip(&column[j + 1..end]) {
                    subtract::<T, S>(simd, &mut value, *l, row);
                }
                scale::<T>(&mut value, column[j].inverse());
                w[j] = value;
            }
            end = first;
        }
        x[node.start..node.start + node.width].copy_from_slice(&w[..node.width]);
    }
}

/// Subtracts the products of the columns `first..` with the rows that start at `at` from `own`.
#[inline(always)]
fn gather<T: Entry, S: Simd>(
    simd: S,
    node: &Supernode<'_, T>,
    first: usize,
    own: &mut [T::Row],
    at: usize,
    rows: &[T::Row],
) {
    let n = rows.len();
    let full = own.len() / PANEL * PANEL;
    for c in (0..full).step_by(PANEL) {
        let l = node.panel(first + c).map(|column| &column[at..at + n]);
        let [l0, l1, l2, l3] = l;
        for g in 0..T::lanes::<S>(&T::ZERO).len() {
            let mut sums: [T::Register<S>; PANEL] = std::array::from_fn(|k| T::lanes::<S>(&own[c + k])[g]);
            for ((((row, l0), l1), l2), l3) in rows.iter().zip(l0).zip(l1).zip(l2).zip(l3) {
                let x = T::lanes::<S>(row)[g];
                for (sum, l) in sums.iter_mut().zip([l0, l1, l2, l3]) {
                    *sum = T::sub_mul(simd, T::splat(simd, *l), x, *sum);
                }
            }
            for (target, sum) in own[c..c + PANEL].iter_mut().zip(sums) {
                T::lanes_mut::<S>(target)[g] = sum;
            }
        }
    }
    for (c, target) in own.iter_mut().enumerate().skip(full) {
        let column = &node.column(first + c)[at..at + n];
        let mut sum = *target;
        for (row, l) in rows.iter().zip(column) {
            subtract::<T, S>(simd, &mut sum, *l, row);
        }
        *target = sum;
    }
}

#[inline(always)]
fn scale<T: Entry>(row: &mut T::Row, factor: T) {
    row.as_mut().iter_mut().for_each(|v| *v *= factor);
}

/// `row -= factor * x`.
#[inline(always)]
fn subtract<T: Entry, S: Simd>(simd: S, row: &mut T::Row, factor: T, x: &T::Row) {
    let factor = T::splat(simd, factor);
    for (target, x) in T::lanes_mut::<S>(row).iter_mut().zip(T::lanes::<S>(x)) {
        *target = T::sub_mul(simd, factor, *x, *target);
    }
}
