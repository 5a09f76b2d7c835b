//! Triangular solves with one panel of a factor for several right-hand sides at once.
//!
//! Such solves are bound by reading the factor from memory. Eight right-hand sides are kept by
//! rows, so that each entry of the factor is read once and serves one vector register or two.

use pulp::{Simd, WithSimd};

use super::entry::Entry;

/// Columns eliminated together.
pub(super) const BLOCK: usize = 32;
/// Rows that stay in the first-level cache while a block of columns passes: 16 KiB in double
/// precision.
const CHUNK: usize = 256;
/// Columns that share one load and store of a row.
const GROUP: usize = 4;

/// A panel: entries by columns of `n_rows`, the first `width` rows being its own.
#[derive(Debug, Clone, Copy)]
pub(super) struct PanelEntries<'a, T> {
    pub width: usize,
    pub n_rows: usize,
    pub values: &'a [T],
}

impl<'a, T: Entry> PanelEntries<'a, T> {
    #[inline(always)]
    fn column(&self, j: usize) -> &'a [T] {
        &self.values[j * self.n_rows..(j + 1) * self.n_rows]
    }

    #[inline(always)]
    fn group(&self, j: usize) -> [&'a [T]; GROUP] {
        std::array::from_fn(|c| self.column(j + c))
    }

    /// Solves with the triangle: `own` become unknowns of `L y = b`.
    pub fn forward(self, own: &mut [T::Row]) {
        pulp::Arch::new().dispatch(Forward { panel: self, own });
    }

    /// Subtracts what the unknowns `own` contribute to the `rows` of the panel from `at` on.
    pub fn eliminate(self, own: &[T::Row], at: usize, rows: &mut [T::Row]) {
        pulp::Arch::new().dispatch(Eliminate { panel: self, own, at, rows });
    }

    /// Subtracts what the `rows` of the panel from `at` on contribute to its unknowns from `first`
    /// on, `own`.
    pub fn gather(self, first: usize, own: &mut [T::Row], at: usize, rows: &[T::Row]) {
        pulp::Arch::new().dispatch(Gather { panel: self, first, own, at, rows });
    }

    /// Gives `own` the signs of the pivots, which stand between the triangles.
    pub fn turn(self, own: &mut [T::Row]) {
        let is_negative = |j: usize| self.column(j)[j].is_negative();
        own.iter_mut()
            .enumerate()
            .filter(|(j, _)| is_negative(*j))
            .for_each(|(_, row)| scale::<T>(row, T::MINUS_ONE));
    }

    /// Solves with the transposed triangle.
    pub fn backward(self, own: &mut [T::Row]) {
        pulp::Arch::new().dispatch(Backward { panel: self, own });
    }
}

struct Forward<'a, T: Entry> {
    panel: PanelEntries<'a, T>,
    own: &'a mut [T::Row],
}

impl<T: Entry> WithSimd for Forward<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { panel, own } = self;
        for first in (0..panel.width).step_by(BLOCK) {
            let end = (first + BLOCK).min(panel.width);
            for j in first..end {
                let column = panel.column(j);
                scale::<T>(&mut own[j], column[j].inverse());
                let value = own[j];
                for (row, l) in own[j + 1..end].iter_mut().zip(&column[j + 1..end]) {
                    subtract::<T, S>(simd, row, *l, &value);
                }
            }
            let (done, rest) = own.split_at_mut(end);
            eliminate(simd, &panel, first, &done[first..], end, rest);
        }
    }
}

struct Eliminate<'a, T: Entry> {
    panel: PanelEntries<'a, T>,
    own: &'a [T::Row],
    at: usize,
    rows: &'a mut [T::Row],
}

impl<T: Entry> WithSimd for Eliminate<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        for (k, rows) in self.rows.chunks_mut(CHUNK).enumerate() {
            eliminate(simd, &self.panel, 0, self.own, self.at + k * CHUNK, rows);
        }
    }
}

struct Gather<'a, T: Entry> {
    panel: PanelEntries<'a, T>,
    first: usize,
    own: &'a mut [T::Row],
    at: usize,
    rows: &'a [T::Row],
}

impl<T: Entry> WithSimd for Gather<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        for (k, rows) in self.rows.chunks(CHUNK).enumerate() {
            gather(simd, &self.panel, self.first, self.own, self.at + k * CHUNK, rows);
        }
    }
}

struct Backward<'a, T: Entry> {
    panel: PanelEntries<'a, T>,
    own: &'a mut [T::Row],
}

impl<T: Entry> WithSimd for Backward<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { panel, own } = self;
        let mut end = panel.width;
        while end > 0 {
            let first = (end - 1) / BLOCK * BLOCK;
            let (open, done) = own.split_at_mut(end);
            gather(simd, &panel, first, &mut open[first..], end, done);
            for j in (first..end).rev() {
                let column = panel.column(j);
                let mut value = own[j];
                for (row, l) in own[j + 1..end].iter().zip(&column[j + 1..end]) {
                    subtract::<T, S>(simd, &mut value, *l, row);
                }
                scale::<T>(&mut value, column[j].inverse());
                own[j] = value;
            }
            end = first;
        }
    }
}

/// Subtracts the columns `first..` times `own` from the rows that start at `at`.
#[inline(always)]
fn eliminate<T: Entry, S: Simd>(
    simd: S,
    panel: &PanelEntries<'_, T>,
    first: usize,
    own: &[T::Row],
    at: usize,
    rows: &mut [T::Row],
) {
    let n = rows.len();
    let full = own.len() / GROUP * GROUP;
    for c in (0..full).step_by(GROUP) {
        let l = panel.group(first + c).map(|column| &column[at..at + n]);
        let x: [T::Row; GROUP] = std::array::from_fn(|k| own[c + k]);
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
        let column = &panel.column(first + c)[at..at + n];
        for (row, l) in rows.iter_mut().zip(column) {
            subtract::<T, S>(simd, row, *l, x);
        }
    }
}

/// Subtracts the products of the columns `first..` with the rows that start at `at` from `own`.
#[inline(always)]
fn gather<T: Entry, S: Simd>(
    simd: S,
    panel: &PanelEntries<'_, T>,
    first: usize,
    own: &mut [T::Row],
    at: usize,
    rows: &[T::Row],
) {
    let n = rows.len();
    let full = own.len() / GROUP * GROUP;
    for c in (0..full).step_by(GROUP) {
        let l = panel.group(first + c).map(|column| &column[at..at + n]);
        let [l0, l1, l2, l3] = l;
        for g in 0..T::lanes::<S>(&T::ZERO_ROW).len() {
            let mut sums: [T::Register<S>; GROUP] = std::array::from_fn(|k| T::lanes::<S>(&own[c + k])[g]);
            for ((((row, l0), l1), l2), l3) in rows.iter().zip(l0).zip(l1).zip(l2).zip(l3) {
                let x = T::lanes::<S>(row)[g];
                for (sum, l) in sums.iter_mut().zip([l0, l1, l2, l3]) {
                    *sum = T::sub_mul(simd, T::splat(simd, *l), x, *sum);
                }
            }
            for (target, sum) in own[c..c + GROUP].iter_mut().zip(sums) {
                T::lanes_mut::<S>(target)[g] = sum;
            }
        }
    }
    for (c, target) in own.iter_mut().enumerate().skip(full) {
        let column = &panel.column(first + c)[at..at + n];
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
