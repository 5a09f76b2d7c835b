//! Functions of elements as sums of the B-splines of a level, stored once a B-spline.

use std::collections::HashMap;
use std::ops::Range;

use crate::nurbs::patch::PointBasis;

/// Functions of every element, and their weighted coefficients `w_i C_im` in the B-splines of the
/// element's level (theory Eq. H.5, H.6).
///
/// A coefficient is the same on all elements on which the B-spline does not vanish, `(p + 1)^d` of
/// them: columns are stored once, and elements name theirs.
#[derive(Debug, Clone)]
pub(super) struct Columns {
    /// Functions of element `e`: `functions[starts[e]..starts[e + 1]]`.
    starts: Vec<usize>,
    functions: Vec<u32>,
    /// Where in `numbers` the columns of an element are; none, if its functions are the B-splines
    /// of its level, one by one.
    own: Vec<Range<usize>>,
    /// Column of every B-spline of an element, first direction fastest.
    numbers: Vec<u32>,
    /// Entries of column `m`: `ends[m]..ends[m + 1]`.
    ends: Vec<usize>,
    rows: Vec<u32>,
    entries: Vec<f64>,
}

/// A B-spline: patch, level and number in the net of the level.
pub(super) type RawFunction = (usize, usize, usize);

/// Columns by the B-splines that they belong to, while they are made.
#[derive(Debug, Default)]
pub(super) struct ColumnNumbers {
    known: HashMap<RawFunction, u32>,
    /// The B-spline of each column.
    raw: Vec<RawFunction>,
}

impl Default for Columns {
    fn default() -> Self {
        let (functions, own, numbers) = (Vec::new(), Vec::new(), Vec::new());
        let (rows, entries) = (Vec::new(), Vec::new());
        Self { starts: vec![0], functions, own, numbers, ends: vec![0], rows, entries }
    }
}

impl Columns {
    /// Adds the next element, a plain one with `functions`.
    pub fn push_plain(&mut self, functions: &[u32]) {
        self.functions.extend_from_slice(functions);
        self.starts.push(self.functions.len());
        self.own.push(0..0);
    }

    /// Adds the next element with `functions` and the B-splines `raw`; `entry(i, m)` is the
    /// coefficient of function `i` in B-spline `m`, both counted on the element.
    pub fn push(
        &mut self,
        functions: &[u32],
        raw: impl Iterator<Item = RawFunction>,
        known: &mut ColumnNumbers,
        entry: impl Fn(usize, usize) -> f64,
    ) {
        self.functions.extend_from_slice(functions);
        self.starts.push(self.functions.len());
        let first = self.numbers.len();
        for (m, raw) in raw.enumerate() {
            let number = known.number(raw, || {
                let column = functions.iter().enumerate().map(|(i, &f)| (f, entry(i, m)));
                self.push_column(column.filter(|&(_, c)| c != 0.0));
            });
            self.numbers.push(number);
        }
        self.own.push(first..self.numbers.len());
    }

    fn push_column(&mut self, column: impl Iterator<Item = (u32, f64)>) {
        for (function, coefficient) in column {
            self.rows.push(function);
            self.entries.push(coefficient);
        }
        self.ends.push(self.entries.len());
    }

    /// Adds the elements of `other`, whose columns are those of `its`, behind the own ones.
    pub fn append(&mut self, other: &Self, its: &ColumnNumbers, known: &mut ColumnNumbers) {
        let number = |m: usize| known.number(its.raw[m], || self.push_column(other.column_at(m)));
        let numbers: Vec<u32> = (0..its.raw.len()).map(number).collect();
        let (functions, first) = (self.functions.len(), self.numbers.len());
        self.starts.extend(other.starts[1..].iter().map(|s| s + functions));
        self.functions.extend_from_slice(&other.functions);
        self.own.extend(other.own.iter().map(|own| own.start + first..own.end + first));
        self.numbers.extend(other.numbers.iter().map(|&m| numbers[m as usize]));
    }

    /// Functions of element `e`.
    pub fn functions(&self, e: usize) -> &[u32] {
        &self.functions[self.starts[e]..self.starts[e + 1]]
    }

    /// Whether the functions of element `e` are the B-splines of its level, one by one.
    pub fn is_plain(&self, e: usize) -> bool {
        self.own[e].is_empty()
    }

    /// Functions with a part of B-spline `m` of element `e`, which is not plain, and their
    /// coefficients.
    pub fn column(&self, e: usize, m: usize) -> impl Iterator<Item = (u32, f64)> + '_ {
        self.column_at(self.numbers[self.own[e].start + m] as usize)
    }

    fn column_at(&self, number: usize) -> impl Iterator<Item = (u32, f64)> + '_ {
        let range = self.ends[number]..self.ends[number + 1];
        self.rows[range.clone()].iter().copied().zip(self.entries[range].iter().copied())
    }

    /// Number of stored coefficients.
    pub fn n_stored(&self) -> usize {
        self.entries.len()
    }

    /// The functions of element `e`, which is not plain, at a point from the B-splines `out` there:
    /// `Σ_m C_im out_m`, also of their derivatives if there are any.
    pub fn combine(&self, e: usize, out: &mut PointBasis) {
        let n = self.functions(e).len();
        let of = |is_empty: bool| if is_empty { 0 } else { n };
        let mut values = vec![0.0; n];
        let mut first = vec![[0.0; 3]; of(out.first.is_empty())];
        let mut second = vec![[0.0; 6]; of(out.second.is_empty())];
        self.each_entry(e, |i, m, c| {
            values[i] += c * out.values[m];
            if let (Some(sum), Some(raw)) = (first.get_mut(i), out.first.get(m)) {
                sum.iter_mut().zip(raw).for_each(|(s, x)| *s += c * x);
            }
            if let (Some(sum), Some(raw)) = (second.get_mut(i), out.second.get(m)) {
                sum.iter_mut().zip(raw).for_each(|(s, x)| *s += c * x);
            }
        });
        (out.values, out.first, out.second) = (values, first, second);
    }

    /// `Σ_m C_im raw_m` of all functions of element `e`, which is not plain.
    pub fn combined(&self, e: usize, raw: &[f64]) -> Vec<f64> {
        let mut sums = vec![0.0; self.functions(e).len()];
        self.each_entry(e, |i, m, c| sums[i] += c * raw[m]);
        sums
    }

    /// Calls `work` with function and B-spline, counted on element `e`, and coefficient of every
    /// entry; B-splines rise.
    fn each_entry(&self, e: usize, mut work: impl FnMut(usize, usize, f64)) {
        let own = self.functions(e);
        let least = own.iter().copied().min().unwrap_or_default();
        let most = own.iter().copied().max().unwrap_or_default();
        let mut place = vec![0u16; (most - least) as usize + 1];
        own.iter().enumerate().for_each(|(i, &f)| place[(f - least) as usize] = i as u16);
        for (m, &number) in self.numbers[self.own[e].clone()].iter().enumerate() {
            for (f, c) in self.column_at(number as usize) {
                work(place[(f - least) as usize] as usize, m, c);
            }
        }
    }
}

impl ColumnNumbers {
    /// The column of `raw`, which `make` adds if it is the first time that it is asked for.
    fn number(&mut self, raw: RawFunction, make: impl FnOnce()) -> u32 {
        *self.known.entry(raw).or_insert_with(|| {
            make();
            self.raw.push(raw);
            self.raw.len() as u32 - 1
        })
    }
}
