//! Triangular solves with a supernodal Cholesky factor for eight right-hand sides at once.
//!
//! Such solves are bound by reading the factor from memory. Right-hand sides are kept by rows, eight numbers an unknown, so
//! that each entry of the factor is read once and serves one vector register.

use faer::sparse::linalg::cholesky::supernodal::{SupernodalLltRef, SymbolicSupernodalCholesky};
use pulp::{Simd, WithSimd};

/// One unknown of eight right-hand sides.
pub(super) type Row = [f64; WIDTH];
/// Right-hand sides solved for at once.
pub(super) const WIDTH: usize = 8;

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
pub(super) fn solve(factor: SupernodalLltRef<'_, u32, f64>, x: &mut [Row], local: &mut [Row]) {
    pulp::Arch::new().dispatch(Solve { factor, x, local });
}

struct Solve<'a> {
    factor: SupernodalLltRef<'a, u32, f64>,
    x: &'a mut [Row],
    local: &'a mut [Row],
}

impl WithSimd for Solve<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        forward(simd, self.factor, self.x, self.local);
        backward(simd, self.factor, self.x, self.local);
    }
}

/// A supernode: entries by columns, `n_rows` a column, the first `width` rows being its own.
struct Supernode<'a> {
    start: usize,
    width: usize,
    n_rows: usize,
    pattern: &'a [u32],
    values: &'a [f64],
}

impl<'a> Supernode<'a> {
    #[inline(always)]
    fn new(factor: SupernodalLltRef<'a, u32, f64>, s: usize) -> Self {
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
    fn column(&self, j: usize) -> &'a [f64] {
        &self.values[j * self.n_rows..(j + 1) * self.n_rows]
    }

    #[inline(always)]
    fn panel(&self, j: usize) -> [&'a [f64]; PANEL] {
        std::array::from_fn(|c| self.column(j + c))
    }
}

#[inline(always)]
fn forward<S: Simd>(simd: S, factor: SupernodalLltRef<'_, u32, f64>, x: &mut [Row], local: &mut [Row]) {
    for s in 0..factor.symbolic().n_supernodes() {
        let node = Supernode::new(factor, s);
        let w = &mut local[..node.n_rows];
        w[..node.width].copy_from_slice(&x[node.start..node.start + node.width]);
        w[node.width..].fill([0.0; WIDTH]);
        let mut first = 0;
        while first < node.width {
            let end = (first + BLOCK).min(node.width);
            for j in first..end {
                let column = node.column(j);
                let pivot = 1.0 / column[j];
                w[j].iter_mut().for_each(|v| *v *= pivot);
                let value = w[j];
                for (row, l) in w[j + 1..end].iter_mut().zip(&column[j + 1..end]) {
                    subtract(simd, row, *l, &value);
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
            for (target, part) in x[i as usize].iter_mut().zip(row) {
                *target += part;
            }
        }
    }
}

/// Subtracts the columns `first..` times `own` from the rows that start at `at`.
#[inline(always)]
fn eliminate<S: Simd>(simd: S, node: &Supernode<'_>, first: usize, own: &[Row], at: usize, rows: &mut [Row]) {
    let n = rows.len();
    let full = own.len() / PANEL * PANEL;
    for c in (0..full).step_by(PANEL) {
        let l = node.panel(first + c).map(|column| &column[at..at + n]);
        let x: [Row; PANEL] = std::array::from_fn(|k| own[c + k]);
        let [l0, l1, l2, l3] = l;
        for ((((row, l0), l1), l2), l3) in rows.iter_mut().zip(l0).zip(l1).zip(l2).zip(l3) {
            let factors = [l0, l1, l2, l3].map(|l| simd.splat_f64s(-*l));
            for (g, target) in lanes_mut::<S>(row).iter_mut().enumerate() {
                let mut sum = *target;
                for (factor, x) in factors.iter().zip(&x) {
                    sum = simd.mul_add_f64s(*factor, lanes::<S>(x)[g], sum);
                }
                *target = sum;
            }
        }
    }
    for (c, x) in own.iter().enumerate().skip(full) {
        let column = &node.column(first + c)[at..at + n];
        for (row, l) in rows.iter_mut().zip(column) {
            subtract(simd, row, *l, x);
        }
    }
}

#[inline(always)]
fn backward<S: Simd>(simd: S, factor: SupernodalLltRef<'_, u32, f64>, x: &mut [Row], local: &mut [Row]) {
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
                    subtract(simd, &mut value, *l, row);
                }
                let pivot = 1.0 / column[j];
                value.iter_mut().for_each(|v| *v *= pivot);
                w[j] = value;
            }
            end = first;
        }
        x[node.start..node.start + node.width].copy_from_slice(&w[..node.width]);
    }
}

/// Subtracts the products of the columns `first..` with the rows that start at `at` from `own`.
#[inline(always)]
fn gather<S: Simd>(simd: S, node: &Supernode<'_>, first: usize, own: &mut [Row], at: usize, rows: &[Row]) {
    let n = rows.len();
    let full = own.len() / PANEL * PANEL;
    for c in (0..full).step_by(PANEL) {
        let l = node.panel(first + c).map(|column| &column[at..at + n]);
        let [l0, l1, l2, l3] = l;
        for g in 0..WIDTH / S::F64_LANES {
            let mut sums = [simd.splat_f64s(0.0); PANEL];
            for ((((row, l0), l1), l2), l3) in rows.iter().zip(l0).zip(l1).zip(l2).zip(l3) {
                let x = lanes::<S>(row)[g];
                for (sum, l) in sums.iter_mut().zip([l0, l1, l2, l3]) {
                    *sum = simd.mul_add_f64s(simd.splat_f64s(*l), x, *sum);
                }
            }
            for (target, sum) in own[c..c + PANEL].iter_mut().zip(sums) {
                let target = &mut lanes_mut::<S>(target)[g];
                *target = simd.sub_f64s(*target, sum);
            }
        }
    }
    for (c, target) in own.iter_mut().enumerate().skip(full) {
        let column = &node.column(first + c)[at..at + n];
        let mut sum = *target;
        for (row, l) in rows.iter().zip(column) {
            subtract(simd, &mut sum, *l, row);
        }
        *target = sum;
    }
}

/// A row as vector registers; their number of lanes divides its length.
#[inline(always)]
fn lanes<S: Simd>(row: &Row) -> &[S::f64s] {
    S::as_simd_f64s(row).0
}

#[inline(always)]
fn lanes_mut<S: Simd>(row: &mut Row) -> &mut [S::f64s] {
    S::as_mut_simd_f64s(row).0
}

/// `row -= factor * x`.
#[inline(always)]
fn subtract<S: Simd>(simd: S, row: &mut Row, factor: f64, x: &Row) {
    let factor = simd.splat_f64s(-factor);
    for (target, x) in lanes_mut::<S>(row).iter_mut().zip(lanes::<S>(x)) {
        *target = simd.mul_add_f64s(factor, *x, *target);
    }
}
