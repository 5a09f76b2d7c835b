//! Numeric factorisation `A = L S Lᵀ` on all threads (Eq. R.4): `S` holds the signs of the pivots,
//! which are those of the diagonal of `L`.
//!
//! Left-looking by supernodes: each takes the products of all supernodes below it that reach into
//! its columns, then is factorised itself. Subtrees of the elimination tree are independent and run
//! side by side; in large supernodes at the top of the tree, tiles of rows do. Tiles and the order
//! of products depend on the matrix alone, and each tile is one thread's: the factor has the same
//! bits for any number of threads. No other memory is taken than the factor's and a tile for every
//! thread.

use std::sync::{Mutex, PoisonError};

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::{ldlt, llt};
use faer::linalg::matmul::matmul;
use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
use faer::reborrow::{Reborrow, ReborrowMut};
use faer::sparse::SymbolicSparseColMatRef;
use faer::{Accum, MatMut, MatRef, Par};

use super::entry::Entry;
use super::entry_positions::EntryPositions;
use super::layout::{Layout, Panel};

/// Rows of a tile: what one thread does at a time.
const ROWS: usize = 512;
/// Columns of a product at the diagonal that begin at the same row.
const STRIP: usize = 64;
/// Subtrees with less work than this \[multiplications and additions\] are one thread's: some
/// milliseconds.
const SEQUENTIAL: f64 = 5e7;

/// Which matrices have a factor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::reduction) enum Kind {
    /// Positive definite ones: Cholesky's `L Lᵀ`.
    Definite,
    /// All whose leading blocks are regular: `L S Lᵀ`, that is `L D Lᵀ` with `|D|` shared between
    /// both triangles, without pivoting.
    Indefinite,
}

/// Entries of the factor of a symmetric matrix, as `layout` places them.
/// `value(number, row, column)` is the entry that has this number in the `pattern` of `positions`;
/// row and column are those of the factor.
///
/// Above the diagonal of a panel stand numbers without meaning.
///
/// # Errors
/// The place in the elimination order of the first pivot that is not positive and finite (zero, for
/// [`Kind::Indefinite`]).
pub(in crate::reduction) fn factorise<T: Entry>(
    layout: &Layout,
    (pattern, positions): (SymbolicSparseColMatRef<'_, u32>, &EntryPositions),
    value: impl Fn(usize, usize, usize) -> T + Sync,
    kind: Kind,
) -> Result<Vec<T>, usize> {
    let mut values = vec![T::ZERO; layout.n_values()];
    let run = Factorisation {
        layout,
        pattern,
        matrix: positions,
        value: &value,
        kind,
        scratch: Pool::default(),
        positions: Pool::default(),
    };
    run.forest(&layout.roots(), &mut values)?;
    Ok(values)
}

/// Things that threads take when they need one and put back.
struct Pool<X>(Mutex<Vec<X>>);

impl<X> Default for Pool<X> {
    fn default() -> Self {
        Self(Mutex::new(Vec::new()))
    }
}

impl<X: Default> Pool<X> {
    fn with<R>(&self, work: impl FnOnce(&mut X) -> R) -> R {
        let lock = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let mut taken = lock().pop().unwrap_or_default();
        let result = work(&mut taken);
        lock().push(taken);
        result
    }
}

/// Memory for one tile.
#[derive(Default)]
struct Scratch<T> {
    product: Vec<T>,
    scaled: Vec<T>,
    positions: Vec<u32>,
}

struct Factorisation<'a, T, V> {
    layout: &'a Layout,
    pattern: SymbolicSparseColMatRef<'a, u32>,
    matrix: &'a EntryPositions,
    value: &'a V,
    kind: Kind,
    scratch: Pool<Scratch<T>>,
    /// Place of every row of the matrix in a supernode.
    positions: Pool<Vec<u32>>,
}

/// Entries of finished supernodes, the first of which stands at `base` in the factor.
#[derive(Clone, Copy)]
struct Done<'v, T> {
    values: &'v [T],
    base: usize,
}

impl<'v, T: Entry> Done<'v, T> {
    fn panel(self, panel: &Panel) -> MatRef<'v, T> {
        let values = &self.values[panel.values - self.base..][..panel.n_values()];
        MatRef::from_column_major_slice(values, panel.n_rows, panel.width())
    }
}

/// The panel that is at work.
struct Target<'a> {
    s: usize,
    panel: &'a Panel,
    columns: std::ops::Range<usize>,
    pattern: &'a [u32],
    positions: &'a [u32],
}

impl Target<'_> {
    /// Row of the matrix at row `i` of the panel.
    fn row(&self, i: usize) -> usize {
        let row = self.panel.first + i;
        if row < self.columns.end { row } else { self.pattern[row - self.columns.end] as usize }
    }

    /// Row of the panel for a row of the matrix.
    fn place(&self, row: u32) -> usize {
        let row = row as usize;
        if row < self.columns.end {
            row - self.panel.first
        } else {
            self.positions[row] as usize + self.columns.end - self.panel.first
        }
    }
}

impl<T: Entry, V: Fn(usize, usize, usize) -> T + Sync> Factorisation<'_, T, V> {
    /// Factorises the subtrees of `roots`, which follow on each other, on all threads.
    fn forest(&self, roots: &[u32], values: &mut [T]) -> Result<(), usize> {
        match roots {
            [] => Ok(()),
            [root] => self.subtree(*root as usize, values),
            _ => {
                let (left, right) = roots.split_at(self.half(roots));
                let size = left.iter().map(|&s| self.layout.subtree_values[s as usize]).sum();
                let (a, b) = values.split_at_mut(size);
                let (a, b) = rayon::join(|| self.forest(left, a), || self.forest(right, b));
                // What fails first in the order of elimination, whoever finds it.
                a.and(b)
            }
        }
    }

    /// Number of subtrees with half the work, at least one and not all.
    fn half(&self, roots: &[u32]) -> usize {
        let work = |s: &u32| self.layout.work[*s as usize];
        let whole: f64 = roots.iter().map(work).sum();
        let mut sum = 0.0;
        let below_half = |s: &&u32| {
            sum += work(s);
            sum <= 0.5 * whole
        };
        roots.iter().take_while(below_half).count().clamp(1, roots.len() - 1)
    }

    fn subtree(&self, root: usize, values: &mut [T]) -> Result<(), usize> {
        let layout = self.layout;
        if layout.work[root] < SEQUENTIAL {
            return self.one_by_one(layout.first_descendant[root] as usize..root + 1, values, false);
        }
        // Down the only children: recursion would be as deep as the tree is high.
        let mut last = root;
        while let [child] = layout.children(last)
            && layout.work[*child as usize] >= SEQUENTIAL
        {
            last = *child as usize;
        }
        let base = layout.values_of(layout.first_descendant[root] as usize);
        let below = layout.values_of(last) - base;
        self.forest(layout.children(last), &mut values[..below])?;
        self.one_by_one(last..root + 1, values, true)
    }

    /// Factorises the supernodes `range` in their order; `values` are those of the subtree of the
    /// last one.
    fn one_by_one(
        &self,
        range: std::ops::Range<usize>,
        values: &mut [T],
        is_parallel: bool,
    ) -> Result<(), usize> {
        let layout = self.layout;
        let base = layout.values_of(layout.first_descendant[range.end - 1] as usize);
        self.positions.with(|positions| {
            positions.resize(layout.supernodes.order.len(), 0);
            for s in range {
                for (place, &row) in layout.supernodes.pattern(s).iter().enumerate() {
                    positions[row as usize] = place as u32;
                }
                let (done, own) = values.split_at_mut(layout.values_of(s) - base);
                self.supernode(s, Done { values: done, base }, own, positions, is_parallel)?;
            }
            Ok(())
        })
    }

    fn supernode(
        &self,
        s: usize,
        below: Done<'_, T>,
        values: &mut [T],
        positions: &[u32],
        is_parallel: bool,
    ) -> Result<(), usize> {
        let (columns, pattern) = (self.layout.supernodes.columns(s), self.layout.supernodes.pattern(s));
        let base = self.layout.values_of(s);
        for panel in self.layout.panels(s) {
            let (earlier, rest) = values.split_at_mut(panel.values - base);
            let earlier = Done { values: earlier, base };
            let target = Target { s, panel, columns: columns.clone(), pattern, positions };
            let (n_rows, width) = (panel.n_rows, panel.width());
            let own = &mut rest[..panel.n_values()];
            // Memory fresh from the system is a page of zeros that all share: one that is read
            // before it is written to is given out twice, and every processor is told.
            own.fill(T::ZERO);
            let mut block = MatMut::from_column_major_slice_mut(own, n_rows, width);
            for j in 0..width {
                let column = panel.first + j;
                let unknown = self.layout.supernodes.order[column] as usize;
                for entry in self.matrix.column(self.pattern, (column, unknown)) {
                    block[(target.place(entry.row), j)] =
                        (self.value)(entry.number as usize, entry.row as usize, column);
                }
            }
            by_tiles(block.rb_mut(), 0, is_parallel, &|first, tile| {
                self.scratch.with(|scratch| self.subtract(&target, below, earlier, first, tile, scratch));
            });
            let (mut diagonal, lower) = block.split_at_row_mut(width);
            self.factorise_diagonal(diagonal.rb_mut()).map_err(|j| panel.first + j)?;
            let diagonal = diagonal.rb();
            by_tiles(lower, 0, is_parallel, &|_, tile| self.divide(diagonal, tile));
        }
        Ok(())
    }

    /// Subtracts what the supernodes `below` and the `earlier` panels contribute to the rows from
    /// `first` on of a panel.
    fn subtract(
        &self,
        target: &Target<'_>,
        below: Done<'_, T>,
        earlier: Done<'_, T>,
        first: usize,
        mut tile: MatMut<'_, T>,
        scratch: &mut Scratch<T>,
    ) {
        let (panel, supernodes) = (target.panel, &self.layout.supernodes);
        let rows = target.row(first)..target.row(first + tile.nrows() - 1) + 1;
        let Scratch { product, scaled, positions } = scratch;
        for update in self.layout.updates(target.s) {
            let source = update.source as usize;
            let pattern = supernodes.pattern(source);
            let from = |begin: usize, end: usize, limit: usize| {
                begin + pattern[begin..end].partition_point(|&row| (row as usize) < limit)
            };
            let (begin, end) = (update.begin as usize, update.end as usize);
            let a = from(begin, end, panel.first);
            let b = from(a, end, panel.end);
            let p = from(a, pattern.len(), rows.start);
            let q = from(p, pattern.len(), rows.end);
            if a == b || p == q {
                continue;
            }
            let (m, n) = (q - p, b - a);
            let at = (target.place(pattern[p]) - first, pattern[a] as usize - panel.first);
            let is_block = target.place(pattern[q - 1]) - first + 1 == at.0 + m
                && pattern[b - 1] as usize - panel.first + 1 == at.1 + n;
            let end_of_source = supernodes.columns(source).end;
            let blocks =
                || self.layout.panels(source).iter().map(|of| (below.panel(of), end_of_source - of.first));
            if is_block {
                for (block, offset) in blocks() {
                    let (left, right) = (block.subrows(offset + p, m), block.subrows(offset + a, n));
                    let part = tile.rb_mut().submatrix_mut(at.0, at.1, m, n);
                    self.multiply(part, p - a, Accum::Add, [left, right, block], scaled);
                }
                continue;
            }
            product.resize(product.len().max(m * n), T::ZERO);
            let mut sum = MatMut::from_column_major_slice_mut(&mut product[..m * n], m, n);
            let mut accum = Accum::Replace;
            for (block, offset) in blocks() {
                let (left, right) = (block.subrows(offset + p, m), block.subrows(offset + a, n));
                self.multiply(sum.rb_mut(), p - a, accum, [left, right, block], scaled);
                accum = Accum::Add;
            }
            positions.clear();
            positions.extend(pattern[p..q].iter().map(|&row| (target.place(row) - first) as u32));
            for (j, column) in product[..m * n].chunks_exact(m).enumerate() {
                let to = tile.rb_mut().col_mut(pattern[a + j] as usize - panel.first);
                let Some(to) = to.try_as_col_major_mut() else {
                    unreachable!("panels are stored by columns")
                };
                let to = to.as_slice_mut();
                // Above the diagonal there is nothing.
                let skipped = (a + j).saturating_sub(p).min(m);
                for (&place, &value) in positions[skipped..].iter().zip(&column[skipped..]) {
                    to[place as usize] += value;
                }
            }
        }
        for of in self.layout.panels(target.s).iter().take_while(|of| of.first < panel.first) {
            let (block, offset) = (earlier.panel(of), panel.first - of.first);
            let (left, right) =
                (block.subrows(offset + first, tile.nrows()), block.subrows(offset, panel.width()));
            self.multiply(tile.rb_mut(), first, Accum::Add, [left, right, block], scaled);
        }
    }

    /// `sum - left S rightᵀ` on and below the diagonal, whose first row stands `above` rows over
    /// `sum`; `left` and `right` are rows of the panel `block`, which holds the signs `S`. Above
    /// the diagonal numbers without meaning may come to stand.
    fn multiply(
        &self,
        mut sum: MatMut<'_, T>,
        above: usize,
        accum: Accum,
        [left, right, block]: [MatRef<'_, T>; 3],
        scaled: &mut Vec<T>,
    ) {
        let (m, n, k) = (left.nrows(), right.nrows(), right.ncols());
        let is_flipped = self.kind == Kind::Indefinite && (0..k).any(|j| block[(j, j)].is_negative());
        let right = if is_flipped {
            scaled.resize(scaled.len().max(n * k), T::ZERO);
            let mut copy = MatMut::from_column_major_slice_mut(&mut scaled[..n * k], n, k);
            for j in 0..k {
                let sign = if block[(j, j)].is_negative() { T::MINUS_ONE } else { T::ONE };
                for (to, &from) in copy.rb_mut().col_mut(j).iter_mut().zip(right.col(j).iter()) {
                    *to = from * sign;
                }
            }
            MatRef::from_column_major_slice(&scaled[..n * k], n, k)
        } else {
            right
        };
        // The rows that the diagonal crosses, in strips of columns from it on, then the others.
        let crossed = n.saturating_sub(above).min(m);
        for first in (0..n).step_by(STRIP) {
            let skipped = first.saturating_sub(above);
            if skipped >= crossed {
                break;
            }
            let width = STRIP.min(n - first);
            let part = sum.rb_mut().submatrix_mut(skipped, first, crossed - skipped, width);
            let (left, right) = (left.subrows(skipped, crossed - skipped), right.subrows(first, width));
            matmul(part, accum, left, right.transpose(), T::MINUS_ONE, Par::Seq);
        }
        let part = sum.subrows_mut(crossed, m - crossed);
        matmul(part, accum, left.subrows(crossed, m - crossed), right.transpose(), T::MINUS_ONE, Par::Seq);
    }

    /// Factorises the rows of a panel that are its columns, too; the error is the number of the
    /// pivot.
    fn factorise_diagonal(&self, mut block: MatMut<'_, T>) -> Result<(), usize> {
        let n = block.nrows();
        if self.kind == Kind::Indefinite {
            let scratch = ldlt::factor::cholesky_in_place_scratch::<T>(n, Par::Seq, Default::default());
            let mut memory = MemBuffer::new(scratch);
            let stack = MemStack::new(&mut memory);
            let done = ldlt::factor::cholesky_in_place(
                block.rb_mut(),
                Default::default(),
                Par::Seq,
                stack,
                Default::default(),
            );
            let found = done.map_err(|ldlt::factor::LdltError::ZeroPivot { index }| index);
            found?;
            for j in 0..n {
                let pivot = block[(j, j)];
                let root = pivot.signed_root();
                block.rb_mut().col_mut(j).subrows_mut(j + 1, n - j - 1).iter_mut().for_each(|v| *v *= root);
                block[(j, j)] = root;
            }
            return Ok(());
        }
        let scratch = llt::factor::cholesky_in_place_scratch::<T>(n, Par::Seq, Default::default());
        let mut memory = MemBuffer::new(scratch);
        let stack = MemStack::new(&mut memory);
        let done = llt::factor::cholesky_in_place(
            block.rb_mut(),
            Default::default(),
            Par::Seq,
            stack,
            Default::default(),
        );
        let llt::factor::LltError::NonPositivePivot { index } = match done {
            Ok(_) => return (0..n).find(|&j| !block[(j, j)].is_positive()).map_or(Ok(()), Err),
            Err(error) => error,
        };
        Err(index)
    }

    /// `tile L⁻ᵀ S` with the factor of the panel's diagonal block.
    fn divide(&self, diagonal: MatRef<'_, T>, mut tile: MatMut<'_, T>) {
        solve_lower_triangular_in_place(diagonal, tile.rb_mut().transpose_mut(), Par::Seq);
        if self.kind == Kind::Indefinite {
            for j in (0..diagonal.ncols()).filter(|&j| diagonal[(j, j)].is_negative()) {
                tile.rb_mut().col_mut(j).iter_mut().for_each(|v| *v *= T::MINUS_ONE);
            }
        }
    }
}

/// Calls `work` with the first row and the rows of every tile of `block`, whose own first row is
/// `first`.
fn by_tiles<T: Entry>(
    block: MatMut<'_, T>,
    first: usize,
    is_parallel: bool,
    work: &(impl Fn(usize, MatMut<'_, T>) + Sync),
) {
    let n = block.nrows();
    if n == 0 {
        return;
    }
    if n <= ROWS {
        work(first, block);
        return;
    }
    let half = n.div_ceil(ROWS) / 2 * ROWS;
    let (upper, lower) = block.split_at_row_mut(half);
    let lower_first = first + half;
    if is_parallel {
        rayon::join(|| by_tiles(upper, first, true, work), || by_tiles(lower, lower_first, true, work));
    } else {
        by_tiles(upper, first, false, work);
        by_tiles(lower, lower_first, false, work);
    }
}
