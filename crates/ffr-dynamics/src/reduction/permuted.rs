//! Lower triangle of a symmetric matrix in the order of elimination.

use faer::sparse::SparseColMatRef;

/// Entries by columns of the factor; rows of a column in no order.
pub(super) struct Permuted<T> {
    start: Vec<usize>,
    entries: Vec<(u32, T)>,
}

impl<T: Copy> Permuted<T> {
    /// The matrix with the lower triangle `lower` when `order` holds the p-th unknown at position p.
    pub fn new(lower: SparseColMatRef<'_, u32, T>, order: &[u32]) -> Self {
        let n = order.len();
        let mut position = vec![0; n];
        order.iter().enumerate().for_each(|(p, &unknown)| position[unknown as usize] = p as u32);
        let mut start = vec![0; n + 1];
        for j in 0..n {
            let column = position[j];
            for i in lower.row_idx_of_col(j) {
                start[column.min(position[i]) as usize + 1] += 1;
            }
        }
        (0..n).for_each(|p| start[p + 1] += start[p]);
        let mut next = start.clone();
        let mut entries = match lower.val().first() {
            Some(&any) => vec![(0, any); start[n]],
            None => Vec::new(),
        };
        for j in 0..n {
            let column = position[j];
            for (i, &value) in lower.row_idx_of_col(j).zip(lower.val_of_col(j)) {
                let (a, b) = (column.min(position[i]), column.max(position[i]));
                let slot = &mut next[a as usize];
                entries[*slot] = (b, value);
                *slot += 1;
            }
        }
        Self { start, entries }
    }

    /// Rows and values of column `p` from the diagonal on.
    pub fn column(&self, p: usize) -> &[(u32, T)] {
        &self.entries[self.start[p]..self.start[p + 1]]
    }
}
