//! The loop over batches of elements: their products, and which of them enter which column.

use std::ops::Range;

use rayon::prelude::*;

use super::element::{ElementProducts, Workspace, n_rows};
use super::pattern::Connectivity;
use crate::SplineError;
use crate::elasticity::{MaterialField, Model};
use crate::space::Space;

/// Memory for the products of one batch \[bytes\]; large enough to keep every thread busy, small
/// enough for the cache.
const BATCH_BYTES: usize = 6 << 20;
/// Elements of one batch at most.
const MOST_IN_BATCH: usize = 1024;
/// Parts into which a phase is cut, per thread, to balance the load.
const PARTS_PER_THREAD: usize = 4;

/// Parts into which a phase is cut.
pub(super) fn n_parts() -> usize {
    PARTS_PER_THREAD * rayon::current_num_threads()
}

/// Elements and what their products are made from.
pub(super) struct Source<'a> {
    pub space: &'a dyn Space,
    pub connectivity: &'a Connectivity,
    pub model: &'a Model,
    pub materials: &'a dyn MaterialField,
    /// The elements, rising.
    pub elements: &'a [usize],
}

/// Function `node` is at place `own` of the element in slot `slot` of the batch.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Contribution {
    pub node: u32,
    pub slot: u32,
    pub own: u32,
}

impl Source<'_> {
    /// Calls `take` with the products of one batch after the other, and the places of their
    /// functions, sorted by function, then slot.
    pub fn for_each_batch(
        &self,
        mut take: impl FnMut(&[ElementProducts], &[Contribution]),
    ) -> Result<(), SplineError> {
        let n_parts = n_parts();
        // Elements of locally refined spaces differ much in size: the largest would leave batches
        // of the others too small to share.
        let size = |e: usize| self.connectivity.functions(self.elements[e]).len().pow(2);
        let bytes = |e: usize| size_of::<f64>() * size(e) * (n_rows(self.model).pow(2) + 1);
        let batches = batches(self.elements.len(), n_parts, bytes);
        let most = batches.iter().map(Range::len).max().unwrap_or_default();
        let mut slots: Vec<ElementProducts> = std::iter::repeat_with(Default::default).take(most).collect();
        let mut workers: Vec<Workspace> = std::iter::repeat_with(Default::default).take(n_parts).collect();
        let mut contributions = Vec::new();
        for batch in batches {
            let slots = &mut slots[..batch.len()];
            let elements = &self.elements[batch];
            let size = slots.len().div_ceil(n_parts);
            let parts = slots.par_chunks_mut(size).zip(elements.par_chunks(size)).zip(&mut workers);
            parts.try_for_each(|((slots, elements), worker)| {
                slots.iter_mut().zip(elements).try_for_each(|(slot, &e)| {
                    worker.products(self.space, self.model, self.materials.on(e), e, slot)
                })
            })?;
            contributions.clear();
            for (slot, element) in slots.iter().enumerate() {
                let entry = |(own, &node)| Contribution { node, slot: slot as u32, own: own as u32 };
                contributions.extend(element.nodes.iter().enumerate().map(entry));
            }
            contributions.sort_unstable();
            take(slots, &contributions);
            // Slots that have held large elements would add up to more than a batch.
            let share = BATCH_BYTES / slots.len();
            slots.iter_mut().for_each(|slot| slot.shrink_to(share));
        }
        Ok(())
    }
}

/// Cuts `0..n_elements` into batches whose products take `bytes` of each of their elements,
/// together no more than [`BATCH_BYTES`] where `least` elements do not take more.
fn batches(n_elements: usize, least: usize, bytes: impl Fn(usize) -> usize) -> Vec<Range<usize>> {
    let (mut all, mut start, mut sum) = (Vec::new(), 0, 0);
    for e in 0..n_elements {
        let (length, own) = (e - start, bytes(e));
        if length >= MOST_IN_BATCH || length >= least && sum + own > BATCH_BYTES {
            all.push(start..e);
            (start, sum) = (e, 0);
        }
        sum += own;
    }
    if start < n_elements {
        all.push(start..n_elements);
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn batches_hold_every_element_once_and_no_more_than_memory_allows() {
        // A few large elements among many small ones, as at the ends of a refined zone.
        let bytes = |e: usize| if e % 100 == 7 { BATCH_BYTES / 3 } else { BATCH_BYTES / 500 };
        let all = batches(5000, 8, bytes);
        let joined: Vec<usize> = all.iter().cloned().flatten().collect();
        assert_eq!(joined, (0..5000).collect::<Vec<_>>());
        assert!(all.iter().all(|b| b.clone().map(bytes).sum::<usize>() <= BATCH_BYTES));
        // Three large ones fill a batch at most, so that batches end later than the largest would
        // let them.
        assert!(all.len() < 5000 / 100, "{}", all.len());
        assert_eq!(batches(20, 8, |_| BATCH_BYTES), [0..8, 8..16, 16..20]);
        assert_eq!(batches(3000, 8, |_| 1).len(), 3000usize.div_ceil(MOST_IN_BATCH));
        assert!(batches(0, 8, |_| 1).is_empty());
    }
}
