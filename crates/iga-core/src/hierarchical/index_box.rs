//! Boxes of elements and unions of them.

/// An axis-parallel box of elements, half open: `lower[d] <= index < upper[d]`. Directions that a
/// patch does not have run from 0 to 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct IndexBox {
    /// First element per direction.
    pub lower: [usize; 3],
    /// One past the last element per direction.
    pub upper: [usize; 3],
}

impl IndexBox {
    /// The box of all elements of a net.
    pub fn whole(sizes: [usize; 3]) -> Self {
        Self { lower: [0; 3], upper: sizes }
    }

    /// Elements per direction; zero where the ends have changed places.
    pub fn sizes(&self) -> [usize; 3] {
        std::array::from_fn(|d| self.upper[d].saturating_sub(self.lower[d]))
    }

    /// Number of elements.
    pub fn count(&self) -> usize {
        self.sizes().iter().product()
    }

    /// Whether the box has no element.
    pub fn is_empty(&self) -> bool {
        self.count() == 0
    }

    /// Whether element `index` lies in the box.
    pub fn holds(&self, index: &[usize; 3]) -> bool {
        (0..3).all(|d| self.lower[d] <= index[d] && index[d] < self.upper[d])
    }

    /// Whether all of `other` lies in this box.
    pub fn contains(&self, other: &Self) -> bool {
        (0..3).all(|d| self.lower[d] <= other.lower[d] && other.upper[d] <= self.upper[d])
    }

    /// Whether the boxes share an element.
    pub fn overlaps(&self, other: &Self) -> bool {
        (0..3).all(|d| self.lower[d].max(other.lower[d]) < self.upper[d].min(other.upper[d]))
    }

    /// Calls `piece` for at most six disjoint boxes that make up the box without `hole` (which
    /// overlaps it), as long as it answers true. Answers whether it always did.
    fn all_pieces_without(&self, hole: &Self, mut piece: impl FnMut(Self) -> bool) -> bool {
        let mut rest = *self;
        for d in 0..3 {
            if rest.lower[d] < hole.lower[d] {
                let mut below = rest;
                below.upper[d] = hole.lower[d];
                rest.lower[d] = hole.lower[d];
                if !piece(below) {
                    return false;
                }
            }
            if hole.upper[d] < rest.upper[d] {
                let mut above = rest;
                above.lower[d] = hole.upper[d];
                rest.upper[d] = hole.upper[d];
                if !piece(above) {
                    return false;
                }
            }
        }
        true
    }

    /// Multi-indices of the elements, first direction fastest.
    pub fn elements(&self) -> impl Iterator<Item = [usize; 3]> + use<> {
        let (l, u) = (self.lower, self.upper);
        (l[2]..u[2]).flat_map(move |k| (l[1]..u[1]).flat_map(move |j| (l[0]..u[0]).map(move |i| [i, j, k])))
    }
}

/// Whether the union of `boxes` contains all of `wanted`.
pub fn covers(boxes: &[IndexBox], wanted: &IndexBox) -> bool {
    for (k, b) in boxes.iter().enumerate() {
        if b.overlaps(wanted) {
            // Whatever this box leaves open must be covered by the later ones: the earlier ones do
            // not touch it.
            return wanted.all_pieces_without(b, |piece| covers(&boxes[k + 1..], &piece));
        }
    }
    wanted.is_empty()
}

/// Disjoint boxes that make up the union of `boxes` without the union of `holes`.
pub fn difference(boxes: &[IndexBox], holes: &[IndexBox]) -> Vec<IndexBox> {
    let mut current = boxes.to_vec();
    for hole in holes {
        let mut next = Vec::with_capacity(current.len());
        for b in current {
            if b.overlaps(hole) {
                b.all_pieces_without(hole, |piece| {
                    next.push(piece);
                    true
                });
            } else {
                next.push(b);
            }
        }
        current = next;
    }
    current
}

/// Disjoint boxes with the same union; empty boxes are dropped.
pub fn disjoint(boxes: &[IndexBox]) -> Vec<IndexBox> {
    let mut union: Vec<IndexBox> = Vec::with_capacity(boxes.len());
    for b in boxes.iter().filter(|b| !b.is_empty()) {
        let new = difference(&[*b], &union);
        union.extend(new);
    }
    union
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn any_box() -> impl Strategy<Value = IndexBox> {
        prop::array::uniform3((0usize..6, 1usize..5))
            .prop_map(|r| IndexBox { lower: r.map(|(l, _)| l), upper: r.map(|(l, n)| l + n) })
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]

        #[test]
        fn box_algebra_agrees_with_sets_of_elements(
            boxes in prop::collection::vec(any_box(), 1..5), holes in prop::collection::vec(any_box(), 0..4),
        ) {
            let union = disjoint(&boxes);
            let left = difference(&union, &holes);
            for index in IndexBox::whole([11; 3]).elements() {
                let count = |list: &[IndexBox]| list.iter().filter(|b| b.holds(&index)).count();
                prop_assert_eq!(count(&union), usize::from(count(&boxes) > 0));
                prop_assert_eq!(count(&left), usize::from(count(&boxes) > 0 && count(&holes) == 0));
            }
            for wanted in boxes.iter().chain(&holes) {
                let all = wanted.elements().all(|i| boxes.iter().any(|b| b.holds(&i)));
                prop_assert_eq!(covers(&boxes, wanted), all);
            }
        }
    }
}
