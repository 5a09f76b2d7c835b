//! Rows with few entries.

/// Rows with few entries: the shape functions of the points in terms of the interface degrees of
/// freedom, `N_b`.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SparseRows {
    starts: Vec<usize>,
    entries: Vec<(usize, f64)>,
    n_columns: usize,
}

impl SparseRows {
    /// No rows yet, `n_columns` columns.
    pub fn new(n_columns: usize) -> Self {
        Self { starts: vec![0], entries: Vec::new(), n_columns }
    }

    /// Adds a row of `(column, value)` pairs.
    ///
    /// # Panics
    /// If a column does not exist.
    pub fn push(&mut self, row: impl IntoIterator<Item = (usize, f64)>) {
        for (column, value) in row {
            assert!(column < self.n_columns, "column {column} of {}", self.n_columns);
            self.entries.push((column, value));
        }
        self.starts.push(self.entries.len());
    }

    /// Number of rows.
    pub fn n_rows(&self) -> usize {
        self.starts.len().saturating_sub(1)
    }

    /// Number of columns.
    pub fn n_columns(&self) -> usize {
        self.n_columns
    }

    /// Entries `(column, value)` of row `i`.
    pub fn row(&self, i: usize) -> &[(usize, f64)] {
        &self.entries[self.starts[i]..self.starts[i + 1]]
    }

    /// Replaces `out` by the product of the transpose with `x`, one for each row.
    pub(crate) fn spread(&self, x: &[f64], out: &mut [f64]) {
        out.fill(0.0);
        for (row, &factor) in x.iter().enumerate().filter(|(_, factor)| **factor != 0.0) {
            self.row(row).iter().for_each(|&(column, value)| out[column] += value * factor);
        }
    }
}
