//! Solves with a factor over the elimination tree, on all threads (Eq. R.5).
//!
//! A subtree hands on to its parent what it contributes to the rows below it, and takes back the
//! unknowns of these rows; subtrees run side by side, and rows or columns of large panels do. Every
//! number is made by one thread in an order that the factor alone decides.

use super::entry::Entry;
use super::layout::Layout;
use super::panel_solve::{BLOCK, PanelEntries};

/// Subtrees with fewer entries are one thread's: a fraction of a millisecond.
const SEQUENTIAL: usize = 1 << 18;
/// Rows of a panel that a thread takes at a time.
const ROWS: usize = 512;
/// Panels with fewer entries are one thread's.
const SMALL_PANEL: usize = 1 << 16;

/// A factor by its entries.
#[derive(Clone, Copy)]
pub(super) struct TreeSolve<'a, T> {
    pub layout: &'a Layout,
    pub values: &'a [T],
}

impl<T: Entry> TreeSolve<'_, T> {
    /// Solves `L S Lᵀ x = b` in place, `x` by rows in the elimination order.
    pub fn solve(&self, x: &mut [T::Row]) {
        let roots = self.layout.roots();
        self.forward_forest(&roots, x);
        self.backward_forest(&roots, x, &[]);
    }

    fn first_column(&self, root: u32) -> usize {
        self.layout.supernodes.columns(self.layout.first_descendant[root as usize] as usize).start
    }

    /// The forward solve in the subtrees of `roots`, whose columns `x` holds; what each of them
    /// contributes to the rows below its root.
    fn forward_forest(&self, roots: &[u32], x: &mut [T::Row]) -> Vec<Vec<T::Row>> {
        match roots {
            [] => Vec::new(),
            [root] => vec![self.forward_subtree(*root as usize, x)],
            _ => {
                let (left, right) = roots.split_at(roots.len() / 2);
                let (a, b) = x.split_at_mut(self.first_column(right[0]) - self.first_column(left[0]));
                let (mut a, b) =
                    rayon::join(|| self.forward_forest(left, a), || self.forward_forest(right, b));
                a.extend(b);
                a
            }
        }
    }

    fn forward_subtree(&self, root: usize, x: &mut [T::Row]) -> Vec<T::Row> {
        let layout = self.layout;
        if layout.subtree_values[root] < SEQUENTIAL {
            return self.forward_sequential(root, x);
        }
        let first = self.first_column(root as u32);
        let lowest = self.end_of_chain(root);
        let below = layout.supernodes.columns(lowest).start - first;
        let mut parts = self.forward_forest(layout.children(lowest), &mut x[..below]);
        for s in lowest..=root {
            let columns = layout.supernodes.columns(s);
            let own = &mut x[columns.start - first..columns.end - first];
            let mut rows = own.to_vec();
            rows.resize(columns.len() + layout.supernodes.pattern(s).len(), T::ZERO_ROW);
            for (&child, part) in layout.children(s).iter().zip(&parts) {
                self.add_to_parent(child as usize, part, &mut rows);
            }
            self.forward_panels(s, &mut rows, true);
            own.copy_from_slice(&rows[..columns.len()]);
            parts = vec![rows.split_off(columns.len())];
        }
        parts.pop().unwrap_or_default()
    }

    /// Down the only children, as long as their subtrees are large.
    fn end_of_chain(&self, root: usize) -> usize {
        let mut last = root;
        while let [child] = self.layout.children(last)
            && self.layout.subtree_values[*child as usize] >= SEQUENTIAL
        {
            last = *child as usize;
        }
        last
    }

    fn forward_sequential(&self, root: usize, x: &mut [T::Row]) -> Vec<T::Row> {
        let layout = self.layout;
        let first = self.first_column(root as u32);
        // What subtrees without their parent contribute, one behind the other, and where each
        // begins.
        let (mut open, mut begins) = (Vec::new(), Vec::new());
        let mut rows = Vec::new();
        for s in layout.first_descendant[root] as usize..=root {
            let columns = layout.supernodes.columns(s);
            let own = &mut x[columns.start - first..columns.end - first];
            rows.clear();
            rows.extend_from_slice(own);
            rows.resize(columns.len() + layout.supernodes.pattern(s).len(), T::ZERO_ROW);
            let children = layout.children(s);
            let kept = begins.len() - children.len();
            let end = begins.get(kept).copied().unwrap_or(open.len());
            for (&child, &begin) in children.iter().zip(&begins[kept..]) {
                let n = layout.supernodes.pattern(child as usize).len();
                self.add_to_parent(child as usize, &open[begin..begin + n], &mut rows);
            }
            begins.truncate(kept);
            open.truncate(end);
            self.forward_panels(s, &mut rows, false);
            own.copy_from_slice(&rows[..columns.len()]);
            begins.push(open.len());
            open.extend_from_slice(&rows[columns.len()..]);
        }
        open
    }

    fn add_to_parent(&self, child: usize, part: &[T::Row], rows: &mut [T::Row]) {
        let positions = &self.layout.in_parent[self.layout.supernodes.pattern_range(child)];
        for (&place, row) in positions.iter().zip(part) {
            for (target, part) in rows[place as usize].as_mut().iter_mut().zip(row.as_ref()) {
                *target += *part;
            }
        }
    }

    /// The panels of supernode `s`, each with its place among the columns of the supernode.
    fn panels(&self, s: usize) -> impl DoubleEndedIterator<Item = (usize, PanelEntries<'_, T>)> {
        let start = self.layout.supernodes.columns(s).start;
        self.layout.panels(s).iter().map(move |panel| {
            let values = &self.values[panel.values..panel.values + panel.n_values()];
            let entries = PanelEntries { width: panel.width(), n_rows: panel.n_rows, values };
            (panel.first - start, entries)
        })
    }

    fn forward_panels(&self, s: usize, rows: &mut [T::Row], is_parallel: bool) {
        for (first, panel) in self.panels(s) {
            let (own, below) = rows[first..].split_at_mut(panel.width);
            panel.forward(own);
            let is_parallel = is_parallel && panel.values.len() > SMALL_PANEL;
            halve(below, panel.width, ROWS, is_parallel, &|at, rows| panel.eliminate(own, at, rows));
        }
    }

    fn backward_panels(&self, s: usize, rows: &mut [T::Row], is_parallel: bool) {
        for (first, panel) in self.panels(s).rev() {
            let (own, below) = rows[first..].split_at_mut(panel.width);
            panel.turn(own);
            let is_parallel = is_parallel && panel.values.len() > SMALL_PANEL;
            halve(own, 0, BLOCK, is_parallel, &|at, own| panel.gather(at, own, panel.width, below));
            panel.backward(own);
        }
    }

    /// The backward solve in the subtrees of `roots`; `above` are the rows of their parent.
    fn backward_forest(&self, roots: &[u32], x: &mut [T::Row], above: &[T::Row]) {
        match roots {
            [] => (),
            [root] => self.backward_subtree(*root as usize, x, above),
            _ => {
                let (left, right) = roots.split_at(roots.len() / 2);
                let (a, b) = x.split_at_mut(self.first_column(right[0]) - self.first_column(left[0]));
                rayon::join(
                    || self.backward_forest(left, a, above),
                    || self.backward_forest(right, b, above),
                );
            }
        }
    }

    fn backward_subtree(&self, root: usize, x: &mut [T::Row], above: &[T::Row]) {
        let layout = self.layout;
        if layout.subtree_values[root] < SEQUENTIAL {
            self.backward_sequential(root, x, above);
            return;
        }
        let first = self.first_column(root as u32);
        let lowest = self.end_of_chain(root);
        let mut rows = Vec::new();
        for s in (lowest..=root).rev() {
            let columns = layout.supernodes.columns(s);
            let own = &mut x[columns.start - first..columns.end - first];
            let next = self.rows_of(s, own, if s == root { above } else { &rows });
            rows = next;
            self.backward_panels(s, &mut rows, true);
            own.copy_from_slice(&rows[..columns.len()]);
        }
        let below = layout.supernodes.columns(lowest).start - first;
        self.backward_forest(layout.children(lowest), &mut x[..below], &rows);
    }

    /// Rows of supernode `s`: its own, and those below from the rows of its parent.
    fn rows_of(&self, s: usize, own: &[T::Row], above: &[T::Row]) -> Vec<T::Row> {
        let range = self.layout.supernodes.pattern_range(s);
        let mut rows = Vec::with_capacity(own.len() + range.len());
        rows.extend_from_slice(own);
        if !range.is_empty() {
            rows.extend(self.layout.in_parent[range].iter().map(|&place| above[place as usize]));
        }
        rows
    }

    fn backward_sequential(&self, root: usize, x: &mut [T::Row], above: &[T::Row]) {
        let layout = self.layout;
        let first = self.first_column(root as u32);
        // Rows of the supernodes on the way to the root.
        let mut path: Vec<(usize, Vec<T::Row>)> = Vec::new();
        for s in (layout.first_descendant[root] as usize..=root).rev() {
            let columns = layout.supernodes.columns(s);
            let own = &mut x[columns.start - first..columns.end - first];
            let parent = layout.supernodes.parent[s] as usize;
            while path.last().is_some_and(|entry| entry.0 != parent) {
                path.pop();
            }
            let mut rows = self.rows_of(s, own, path.last().map_or(above, |entry| &entry.1));
            self.backward_panels(s, &mut rows, false);
            own.copy_from_slice(&rows[..columns.len()]);
            if !layout.children(s).is_empty() {
                path.push((s, rows));
            }
        }
    }
}

/// Calls `work` with pieces of `rows` of at most `size`, and with where each begins, `rows`
/// beginning at `first`.
fn halve<R: Send>(
    rows: &mut [R],
    first: usize,
    size: usize,
    is_parallel: bool,
    work: &(impl Fn(usize, &mut [R]) + Sync),
) {
    if !is_parallel {
        rows.chunks_mut(size).enumerate().for_each(|(k, rows)| work(first + k * size, rows));
        return;
    }
    if rows.len() <= size {
        if !rows.is_empty() {
            work(first, rows);
        }
        return;
    }
    let half = rows.len().div_ceil(size) / 2 * size;
    let (a, b) = rows.split_at_mut(half);
    rayon::join(|| halve(a, first, size, true, work), || halve(b, first + half, size, true, work));
}
