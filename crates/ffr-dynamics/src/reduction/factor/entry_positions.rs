//! Which entry of a matrix goes where in its factor.

use faer::sparse::SymbolicSparseColMatRef;

/// Entries of a lower triangle by columns in the order of elimination; rows of a column in no
/// order. Those that stand in the same column of the matrix are read off its pattern.
#[derive(Debug)]
pub(in crate::reduction) struct EntryPositions {
    n_entries: usize,
    /// Position of every unknown in the order of elimination.
    position: Vec<u32>,
    /// Entries whose row in the matrix is their column in the factor, column by column.
    start: Vec<u32>,
    turned: Vec<EntryPosition>,
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
            for row in pattern.row_idx_of_col(j).map(|i| position[i]).filter(|&row| row < column) {
                start[row as usize + 1] += 1;
            }
        }
        (0..n).for_each(|p| start[p + 1] += start[p]);
        let mut next = start.clone();
        let mut turned = vec![EntryPosition::default(); start[n] as usize];
        for (j, &column) in position.iter().enumerate() {
            for (number, i) in pattern.col_range(j).zip(pattern.row_idx_of_col(j)) {
                if position[i] < column {
                    let slot = &mut next[position[i] as usize];
                    turned[*slot as usize] = EntryPosition { row: column, number: number as u32 };
                    *slot += 1;
                }
            }
        }
        Self { n_entries: pattern.row_idx().len(), position, start, turned }
    }

    /// Number of entries.
    pub fn len(&self) -> usize {
        self.n_entries
    }

    /// Entries from the diagonal on of column `p`, which is that of `unknown` in the matrix with
    /// the lower triangle `pattern`.
    pub fn column<'p>(
        &'p self,
        pattern: SymbolicSparseColMatRef<'p, u32>,
        (p, unknown): (usize, usize),
    ) -> impl Iterator<Item = EntryPosition> + 'p {
        let rows = pattern.row_idx()[pattern.col_range(unknown)].iter();
        let own = pattern
            .col_range(unknown)
            .zip(rows)
            .map(|(number, &i)| EntryPosition { row: self.position[i as usize], number: number as u32 });
        let turned = &self.turned[self.start[p] as usize..self.start[p + 1] as usize];
        own.filter(move |entry| entry.row as usize >= p).chain(turned.iter().copied())
    }
}
