//! The extraction operators of all elements, multiplied by the weights (theory Eq. H.5, H.6).

use rayon::prelude::*;

use super::numbering::{Numbering, Part};
use crate::hierarchical::domain::Leaf;
use crate::hierarchical::truncation::{ElementOperator, OperatorBuilder, Truncation};
use crate::space::Rows;

/// Elements that one task works on; the result does not depend on it.
const CHUNK: usize = 64;

/// Functions of every element and their coefficients `w_i M_im` in the B-splines of the element's
/// level: rows of all `leaves`, in their order, those of one patch after those of another.
pub(super) fn extraction(parts: &[Part], leaves: &[Leaf], numbering: &Numbering) -> Rows {
    let of_chunk = |part: &Part, leaves: &[Leaf]| {
        let (mut chunk, mut builder, mut sums) = (Rows::default(), OperatorBuilder::default(), Vec::new());
        for leaf in leaves {
            let operator = builder.build(&part.basis, leaf, Truncation::Truncated);
            push(&mut chunk, operator, (numbering, part.first_active), &mut sums);
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
    let chunks: Vec<Rows> = chunks.par_iter().map(|(part, leaves)| of_chunk(part, leaves)).collect();
    let mut all = Rows::default();
    all.reserve_exact(chunks.iter().map(Rows::n_stored).sum());
    chunks.iter().for_each(|part| all.append(part));
    all
}

/// Adds the next element, of a patch whose active functions are numbered from `first_active` on:
/// rows of tied functions are added up.
fn push(
    all: &mut Rows,
    operator: &ElementOperator,
    (numbering, first_active): (&Numbering, u32),
    sums: &mut Vec<f64>,
) {
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
        all.push_plain(own);
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
    let entries = sums.chunks_exact(width).map(|sum| {
        let all = sum.iter().enumerate().filter(|(_, v)| **v != 0.0);
        all.map(|(c, &v)| (c as u16, v))
    });
    all.push(own.into_iter().zip(entries));
}
