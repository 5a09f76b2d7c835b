//! The extraction operators of all elements, multiplied by the weights (theory Eq. H.5, H.6).

use rayon::prelude::*;

use super::columns::{ColumnNumbers, Columns};
use super::numbering::{Numbering, Part};
use crate::hierarchical::IndexBox;
use crate::hierarchical::domain::Leaf;
use crate::hierarchical::truncation::{ElementOperator, OperatorBuilder, Truncation};
use crate::splines::tensor;

/// Elements that one task works on; the result does not depend on it.
const CHUNK: usize = 64;

/// Functions of every element and their coefficients `w_i M_im` in the B-splines of the element's
/// level, on all `leaves`, in their order, those of one patch after those of another.
pub(super) fn extraction(parts: &[Part], leaves: &[Leaf], numbering: &Numbering) -> Columns {
    let of_chunk = |patch: usize, leaves: &[Leaf]| {
        let (mut chunk, mut known) = (Columns::default(), ColumnNumbers::default());
        let (mut builder, mut sums) = (OperatorBuilder::default(), Vec::new());
        for leaf in leaves {
            let operator = builder.build(&parts[patch].basis, leaf, Truncation::Truncated);
            push((&mut chunk, &mut known), (operator, leaf), (numbering, parts, patch), &mut sums);
        }
        (chunk, known)
    };
    let chunks: Vec<(usize, &[Leaf])> = parts
        .iter()
        .enumerate()
        .flat_map(|(patch, part)| {
            let own = &leaves[part.first_element..][..part.basis.hierarchy().n_leaves()];
            own.chunks(CHUNK).map(move |chunk| (patch, chunk))
        })
        .collect();
    let chunks: Vec<_> = chunks.par_iter().map(|&(patch, leaves)| of_chunk(patch, leaves)).collect();
    let (mut all, mut known) = (Columns::default(), ColumnNumbers::default());
    chunks.iter().for_each(|(chunk, its)| all.append(chunk, its, &mut known));
    all
}

/// Adds the next element, the `leaf` of a patch: coefficients of tied functions are added up.
fn push(
    (all, known): (&mut Columns, &mut ColumnNumbers),
    (operator, leaf): (&ElementOperator, &Leaf),
    (numbering, parts, patch): (&Numbering, &[Part], usize),
    sums: &mut Vec<f64>,
) {
    let Part { basis, first_active, .. } = &parts[patch];
    let n = operator.functions.len();
    let of_space = |f: u32| numbering.functions[(first_active + f) as usize];
    let is_first = |f: u32| numbering.representatives[of_space(f) as usize] == first_active + f;
    let mut own: Vec<u32> = Vec::with_capacity(n);
    // Functions of an element rise, so the first one of a tied group comes before the others of the
    // patch if it is there at all.
    for &f in &operator.functions {
        if is_first(f) || !own.contains(&of_space(f)) {
            own.push(of_space(f));
        }
    }
    let weight = |f: u32| numbering.weights[(first_active + f) as usize];
    let of_group = |f: u32| numbering.weights[numbering.representatives[of_space(f) as usize] as usize];
    let has_weight_of_group = |f: u32| weight(f).to_bits() == of_group(f).to_bits();
    if operator.rows.is_empty()
        && own.len() == n
        && operator.functions.iter().all(|&f| has_weight_of_group(f))
    {
        all.push_plain(&own);
        return;
    }
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
    let level = &basis.hierarchy().levels()[leaf.level];
    let sizes = level.net_size();
    let here = level.functions_on(&IndexBox { lower: leaf.index, upper: leaf.index.map(|i| i + 1) });
    let raw = here.elements().map(|f| (patch, leaf.level, tensor::flat_index(&sizes, &f)));
    all.push(&own, raw, known, |i, m| sums[i * width + m]);
}
