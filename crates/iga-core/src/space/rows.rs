//! Functions of elements as sums of others: `R_i = Σ_m C_im N_m`, in compressed rows.

/// Mark of elements whose functions are the raw ones, one by one.
const PLAIN: usize = usize::MAX;

/// Functions of every element and their coefficients `C_im` in the raw functions `N_m` of the
/// element: ties of coincident control points, nodes that hang on sides of larger elements (C.71).
///
/// Only functions of the space stand for rows, so that whoever evaluates an element meets no
/// dependent one. Elements without rows are *plain*; their functions need not be listed where the
/// space knows them otherwise.
#[derive(Debug, Clone, PartialEq)]
pub struct Rows {
    /// Functions of element `e`: `functions[starts[e]..starts[e + 1]]`.
    starts: Vec<usize>,
    functions: Vec<u32>,
    /// Where in `row_ends` the rows of an element begin, or [`PLAIN`].
    operators: Vec<usize>,
    /// Entries of row `r`: `row_ends[r]..row_ends[r + 1]`.
    row_ends: Vec<usize>,
    /// Local raw function of each entry.
    columns: Vec<u16>,
    entries: Vec<f64>,
}

impl Default for Rows {
    fn default() -> Self {
        let (functions, operators, row_ends) = (Vec::new(), Vec::new(), Vec::new());
        Self { starts: vec![0], functions, operators, row_ends, columns: Vec::new(), entries: Vec::new() }
    }
}

impl Rows {
    /// The rows of a space in which no function depends on others.
    pub fn none() -> Self {
        Self::default()
    }

    /// Adds the next element, a plain one with `functions`.
    pub fn push_plain(&mut self, functions: impl IntoIterator<Item = u32>) {
        self.functions.extend(functions);
        self.starts.push(self.functions.len());
        self.operators.push(PLAIN);
    }

    /// Adds the next element: its functions, each with the local raw functions and coefficients of
    /// its row.
    pub fn push<R: IntoIterator<Item = (u16, f64)>>(&mut self, rows: impl IntoIterator<Item = (u32, R)>) {
        self.operators.push(self.row_ends.len());
        for (function, row) in rows {
            self.functions.push(function);
            self.row_ends.push(self.entries.len());
            for (column, entry) in row {
                self.columns.push(column);
                self.entries.push(entry);
            }
        }
        self.row_ends.push(self.entries.len());
        self.starts.push(self.functions.len());
    }

    /// Functions of element `e`; those listed, if it is plain.
    pub fn functions(&self, e: usize) -> &[u32] {
        &self.functions[self.starts[e]..self.starts[e + 1]]
    }

    /// Whether the functions of element `e` are the raw ones, one by one, as they are if no element
    /// has been added.
    pub fn is_plain(&self, e: usize) -> bool {
        self.operators.get(e).is_none_or(|&o| o == PLAIN)
    }

    /// Local raw functions and coefficients of local function `row` of element `e`, which is not
    /// plain.
    pub fn row(&self, e: usize, row: usize) -> (&[u16], &[f64]) {
        let at = self.operators[e] + row;
        let range = self.row_ends[at]..self.row_ends[at + 1];
        (&self.columns[range.clone()], &self.entries[range])
    }

    /// The functions of element `e` at a point from the raw ones `raw` there: `Σ_m C_im raw_m`,
    /// appended to `out`.
    pub fn combine(&self, e: usize, raw: &[f64], out: &mut Vec<f64>) {
        out.extend((0..self.functions(e).len()).map(|i| {
            let (columns, entries) = self.row(e, i);
            columns.iter().zip(entries).map(|(&c, v)| v * raw[c as usize]).sum::<f64>()
        }));
    }

    /// The same of `N` derivatives at a time, in the place of the raw ones; nothing of none.
    pub fn combine_all<const N: usize>(&self, e: usize, list: &mut Vec<[f64; N]>) {
        let n_raw = list.len();
        for i in 0..if n_raw > 0 { self.functions(e).len() } else { 0 } {
            let (columns, entries) = self.row(e, i);
            let mut sum = [0.0; N];
            for (&c, v) in columns.iter().zip(entries) {
                sum.iter_mut().zip(&list[c as usize]).for_each(|(s, x)| *s += v * x);
            }
            list.push(sum);
        }
        list.drain(..n_raw);
    }
}
