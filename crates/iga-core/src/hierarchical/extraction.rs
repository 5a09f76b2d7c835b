//! Compressed storage of the extraction operators of all elements, multiplied by the weights (theory Eq. H.5, H.6).

use std::ops::Range;

use rayon::prelude::*;

use super::domain::Leaf;
use super::numbering::{Numbering, Part};
use super::truncation::{ElementOperator, OperatorBuilder, Truncation};

/// Mark of elements whose functions are the B-splines of their level, so that no operator is kept.
const PLAIN: usize = usize::MAX;

/// Elements that one task works on; the result does not depend on it.
const CHUNK: usize = 64;

/// Functions of every element and their coefficients `w_i M_im` in the B-splines of the element's level.
#[derive(Debug, Clone)]
pub(super) struct Extraction {
    /// Functions of element `e`: `functions[starts[e]..starts[e + 1]]`.
    starts: Vec<usize>,
    functions: Vec<u32>,
    /// Where in `row_ends` the rows of an element begin, or [`PLAIN`].
    operators: Vec<usize>,
    /// Entries of row `r`: `row_ends[r]..row_ends[r + 1]`.
    row_ends: Vec<usize>,
    /// Local B-spline of each entry.
    columns: Vec<u16>,
    entries: Vec<f64>,
}

impl Extraction {
    /// Operators of all leaves, in their order: those of one patch after those of another.
    pub(super) fn new(parts: &[Part], leaves: &[Leaf], numbering: &Numbering) -> Self {
        let of_chunk = |part: &Part, leaves: &[Leaf]| {
            let (mut chunk, mut builder, mut sums) = (Self::empty(), OperatorBuilder::default(), Vec::new());
            for leaf in leaves {
                let operator = builder.build(&part.basis, leaf, Truncation::Truncated);
                chunk.push(operator, (numbering, part.first_active), &mut sums);
            }
            chunk
        };
        let chunks: Vec<(&Part, &[Leaf])> = parts
            .iter()
            .flat_map(|part| {
                let own = &leaves[part.first_element..][..part.basis.hierarchy().n_leaves()];
                own.chunks(CHUNK).map(move |chunk| (part, chunk))
            })
            .collect();
        let chunks: Vec<Self> = chunks.par_iter().map(|(part, leaves)| of_chunk(part, leaves)).collect();
        let mut all = Self::empty();
        all.entries.reserve_exact(chunks.iter().map(|p| p.entries.len()).sum());
        all.columns.reserve_exact(chunks.iter().map(|p| p.columns.len()).sum());
        chunks.iter().for_each(|part| all.append(part));
        all
    }

    fn empty() -> Self {
        let (functions, operators, row_ends) = (Vec::new(), Vec::new(), Vec::new());
        Self { starts: vec![0], functions, operators, row_ends, columns: Vec::new(), entries: Vec::new() }
    }

    /// Functions of element `e`.
    pub(super) fn functions_on(&self, e: usize) -> &[u32] {
        &self.functions[self.starts[e]..self.starts[e + 1]]
    }

    /// Whether the functions of element `e` are the B-splines of its level, one by one.
    pub(super) fn is_plain(&self, e: usize) -> bool {
        self.operators[e] == PLAIN
    }

    /// Local B-splines and weighted coefficients of local function `row` of element `e`, which is not plain.
    pub(super) fn row(&self, e: usize, row: usize) -> (&[u16], &[f64]) {
        let at = self.operators[e] + row;
        let range: Range<usize> = self.row_ends[at]..self.row_ends[at + 1];
        (&self.columns[range.clone()], &self.entries[range])
    }

    /// Number of stored coefficients.
    pub(super) fn n_stored(&self) -> usize {
        self.entries.len()
    }

    /// Adds the next element, of a patch whose active functions are numbered from `first_active` on: rows of tied functions are added up.
    fn push(
        &mut self,
        operator: &ElementOperator,
        (numbering, first_active): (&Numbering, u32),
        sums: &mut Vec<f64>,
    ) {
        let (begin, n) = (self.functions.len(), operator.functions.len());
        let of_space = |f: u32| numbering.functions[(first_active + f) as usize];
        let is_first = |f: u32| numbering.representatives[of_space(f) as usize] == first_active + f;
        // Functions of an element rise, so the first one of a tied group comes before the others of the patch if it is there at all.
        for &f in &operator.functions {
            if is_first(f) || !self.functions[begin..].contains(&of_space(f)) {
                self.functions.push(of_space(f));
            }
        }
        self.starts.push(self.functions.len());
        let own = &self.functions[begin..];
        let weight = |f: u32| numbering.weights[(first_active + f) as usize];
        let of_group = |f: u32| numbering.weights[numbering.representatives[of_space(f) as usize] as usize];
        let has_weight_of_group = |f: u32| weight(f).to_bits() == of_group(f).to_bits();
        if operator.rows.is_empty()
            && own.len() == n
            && operator.functions.iter().all(|&f| has_weight_of_group(f))
        {
            self.operators.push(PLAIN);
            return;
        }
        self.operators.push(self.row_ends.len());
        let width = if operator.rows.is_empty() { n } else { operator.rows.len() / n };
        sums.clear();
        sums.resize(width * own.len(), 0.0);
        let mut next = 0;
        for (r, &f) in operator.functions.iter().enumerate() {
            let place = if own.get(next) == Some(&of_space(f)) {
                next += 1;
                next - 1
            } else {
                own.iter().position(|&g| g == of_space(f)).unwrap_or_default()
            };
            let sum = &mut sums[place * width..(place + 1) * width];
            match operator.rows.get(r * width..(r + 1) * width) {
                Some(row) => sum.iter_mut().zip(row).for_each(|(s, v)| *s += weight(f) * v),
                None => sum[r] += weight(f),
            }
        }
        for sum in sums.chunks_exact(width) {
            self.row_ends.push(self.entries.len());
            for (c, &v) in sum.iter().enumerate().filter(|(_, v)| **v != 0.0) {
                self.columns.push(c as u16);
                self.entries.push(v);
            }
        }
        self.row_ends.push(self.entries.len());
    }

    /// Adds the elements of `other` behind the own ones.
    fn append(&mut self, other: &Self) {
        let (functions, rows, entries) = (self.functions.len(), self.row_ends.len(), self.entries.len());
        self.starts.extend(other.starts[1..].iter().map(|s| s + functions));
        self.functions.extend_from_slice(&other.functions);
        self.operators.extend(other.operators.iter().map(|&o| if o == PLAIN { PLAIN } else { o + rows }));
        self.row_ends.extend(other.row_ends.iter().map(|r| r + entries));
        self.columns.extend_from_slice(&other.columns);
        self.entries.extend_from_slice(&other.entries);
    }
}
