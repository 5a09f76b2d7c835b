//! Which entry of a matrix goes where in its factor.

use faer::sparse::SymbolicSparseColMatRef;

/// Entries of a lower triangle by columns in the order of elimination; rows of a column in no
/// order.
#[derive(Debug)]
pub(in crate::reduction) struct EntryPositions {
    start: Vec<u32>,
    entries: Vec<EntryPosition>,
}

/// An entry: its row in the order of elimination, and its number among the values of the matrix.
#[derive(Debug, Clone, Copy, Default)]
pub(in crate::reduction) struct EntryPosition {
    pub row: u32,
    pub number: u32,
}

impl EntryPositions {
    /// Entries of the lower triangle `pattern` when `order` holds the p-th unknown at position p.
    pub fn new(pattern: SymbolicSparseColMatRef<'_, u32>, order: &[u32]) -> Self {
        let n = order.len();
        let mut position = vec![0; n];
        order.iter().enumerate().for_each(|(p, &unknown)| position[unknown as usize] = p as u32);
        let mut start = vec![0; n + 1];
        for (j, &column) in position.iter().enumerate() {
            for i in pattern.row_idx_of_col(j) {
                start[column.min(position[i]) as usize + 1] += 1;
            }
        }
        (0..n).for_each(|p| start[p + 1] += start[p]);
        let mut next = start.clone();
        let mut entries = vec![EntryPosition::default(); start[n] as usize];
        for (j, &column) in position.iter().enumerate() {
            for (number, i) in pattern.col_range(j).zip(pattern.row_idx_of_col(j)) {
                let (a, b) = (column.min(position[i]), column.max(position[i]));
                let slot = &mut next[a as usize];
                entries[*slot as usize] = EntryPosition { row: b, number: number as u32 };
                *slot += 1;
            }
        }
        Self { start, entries }
    }

    /// Number of entries.
    pub fn len(&self) -> usize {
        self.entries.len()
    }

    /// Entries of column `p` from the diagonal on.
    pub fn column(&self, p: usize) -> &[EntryPosition] {
        &self.entries[self.start[p] as usize..self.start[p + 1] as usize]
    }
}
