//! What the active functions look like on one leaf element: extraction operators (theory Eq. H.4,
//! H.5).
//!
//! On a leaf of level `L` every active function is a combination of the `Π (p_d + 1)`
//! tensor-product B-splines of level `L`. The combination is carried down level by level with the
//! local two-scale relation; truncation removes, on each level, the part along functions whose
//! support lies in that level's region.

use super::basis::HierarchicalBasis;
use super::domain::Leaf;
use crate::splines::knots::MAX_DEGREE;

const W: usize = MAX_DEGREE + 1;

/// Which of the two bases of the hierarchical space.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Truncation {
    /// Truncated: partition of unity, smaller supports (Giannelli, Jüttler, Speleers 2012).
    Truncated,
    /// Plain hierarchical B-splines.
    Plain,
}

/// The active functions of a leaf and their coefficients.
#[derive(Debug, Clone, Default)]
pub struct ElementOperator {
    /// Numbers of the functions that do not vanish on the leaf, coarse levels first.
    pub functions: Vec<u32>,
    /// Row by row the coefficients in the B-splines of the leaf's level, first direction fastest.
    /// Empty if the functions *are* those B-splines in their order.
    pub rows: Vec<f64>,
}

/// Builds operators one after the other in the same memory.
#[derive(Debug, Default)]
pub struct OperatorBuilder {
    operator: ElementOperator,
    elements: Vec<[usize; 3]>,
    inside: Vec<Vec<bool>>,
    buffer: Vec<f64>,
}

impl OperatorBuilder {
    /// Extraction operator of a leaf.
    pub fn build(&mut self, basis: &HierarchicalBasis, leaf: &Leaf, kind: Truncation) -> &ElementOperator {
        let hierarchy = basis.hierarchy();
        let orders: [usize; 3] =
            std::array::from_fn(|d| hierarchy.levels()[0].knots().get(d).map_or(1, |k| k.degree() + 1));
        let n: usize = orders.iter().product();
        let Self { operator, elements, inside, buffer } = self;
        elements.clear();
        elements.extend((0..=leaf.level).map(|l| hierarchy.ancestor(leaf, l)));
        // Above a level whose functions on the element all lie in its region everything is
        // truncated away.
        let mut start = 0;
        inside.clear();
        for l in (1..=leaf.level).rev() {
            let mask = functions_inside(basis, l, &elements[l]);
            if kind == Truncation::Truncated && mask.iter().all(|&m| m) {
                start = l;
                break;
            }
            inside.push(mask);
        }
        operator.functions.clear();
        operator.rows.clear();
        append_active(basis, start, &elements[start], n, operator);
        if start == leaf.level && operator.functions.len() == n {
            operator.rows.clear();
            return operator;
        }
        for l in start + 1..=leaf.level {
            for d in 0..hierarchy.dimension() {
                let local = local_two_scale(basis, l, d, elements[l - 1], elements[l]);
                contract(&mut operator.rows, &orders, d, &local, buffer);
            }
            let mask = inside.pop().filter(|_| kind == Truncation::Truncated);
            drop_vanishing(operator, n, mask.as_deref());
            append_active(basis, l, &elements[l], n, operator);
        }
        operator
    }
}

/// For the functions of level `l` on an element of that level: whether their support lies in `Ω^l`,
/// in all patches.
fn functions_inside(basis: &HierarchicalBasis, l: usize, element: &[usize; 3]) -> Vec<bool> {
    let level = &basis.hierarchy().levels()[l];
    let here = super::IndexBox { lower: *element, upper: element.map(|i| i + 1) };
    level.functions_on(&here).elements().map(|f| basis.is_inside(l, &f)).collect()
}

/// Appends unit rows for the functions of level `l` that are active on an element of that level.
fn append_active(
    basis: &HierarchicalBasis,
    l: usize,
    element: &[usize; 3],
    n: usize,
    to: &mut ElementOperator,
) {
    let here = super::IndexBox { lower: *element, upper: element.map(|i| i + 1) };
    let functions = basis.hierarchy().levels()[l].functions_on(&here);
    basis.active_in(l, &functions, |position, f| {
        to.functions.push(f);
        let row = to.rows.len();
        to.rows.resize(row + n, 0.0);
        to.rows[row + position] = 1.0;
    });
}

/// Two-scale coefficients in direction `d` between the functions on a parent of level `l - 1` and
/// on its child: row = coarse, column = fine.
fn local_two_scale(
    basis: &HierarchicalBasis,
    l: usize,
    d: usize,
    parent: [usize; 3],
    child: [usize; 3],
) -> [[f64; W]; W] {
    let levels = basis.hierarchy().levels();
    let mut local = [[0.0; W]; W];
    let Some(relation) = levels[l].two_scale().get(d) else { return local };
    let (coarse, fine) = (&levels[l - 1].knots()[d], &levels[l].knots()[d]);
    let p = fine.degree();
    let (i0, j0) = (coarse.element_span(parent[d]) - p, fine.element_span(child[d]) - p);
    for (i, row) in local.iter_mut().enumerate().take(p + 1) {
        for (j, slot) in row.iter_mut().enumerate().take(p + 1) {
            *slot = relation.coefficient(i0 + i, j0 + j);
        }
    }
    local
}

/// Multiplies all rows in direction `d` by the local two-scale matrix.
fn contract(
    rows: &mut Vec<f64>,
    orders: &[usize; 3],
    d: usize,
    matrix: &[[f64; W]; W],
    buffer: &mut Vec<f64>,
) {
    let stride: usize = orders[..d].iter().product();
    let order = orders[d];
    buffer.clear();
    buffer.resize(rows.len(), 0.0);
    if stride == 1 {
        for (old, new) in rows.chunks_exact(order).zip(buffer.chunks_exact_mut(order)) {
            for (x, line) in old.iter().zip(matrix).filter(|(x, _)| **x != 0.0) {
                for (y, s) in new.iter_mut().zip(line) {
                    *y += s * x;
                }
            }
        }
        std::mem::swap(rows, buffer);
        return;
    }
    for (old, new) in rows.chunks_exact(stride * order).zip(buffer.chunks_exact_mut(stride * order)) {
        for (coarse, line) in old.chunks_exact(stride).zip(matrix) {
            if coarse.iter().all(|&v| v == 0.0) {
                continue;
            }
            for (fine, &s) in new.chunks_exact_mut(stride).zip(line).filter(|(_, s)| **s != 0.0) {
                for (y, x) in fine.iter_mut().zip(coarse) {
                    *y += s * x;
                }
            }
        }
    }
    std::mem::swap(rows, buffer);
}

/// Sets the coefficients marked in `mask` to zero and drops rows that vanish. Coefficients are sums
/// of products of non-negative numbers, so zeros are exact.
fn drop_vanishing(operator: &mut ElementOperator, n: usize, mask: Option<&[bool]>) {
    let mut kept = 0;
    for r in 0..operator.functions.len() {
        let row = &mut operator.rows[r * n..(r + 1) * n];
        for (v, _) in row.iter_mut().zip(mask.unwrap_or_default()).filter(|(_, m)| **m) {
            *v = 0.0;
        }
        if row.iter().any(|&v| v != 0.0) {
            operator.rows.copy_within(r * n..(r + 1) * n, kept * n);
            operator.functions[kept] = operator.functions[r];
            kept += 1;
        }
    }
    operator.functions.truncate(kept);
    operator.rows.truncate(kept * n);
}
