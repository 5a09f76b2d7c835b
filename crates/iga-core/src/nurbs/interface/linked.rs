//! Directions of patches that shared faces turn into one another: what divides one of them divides
//! all (theory section S.3).

use super::{COINCIDENT, FaceId, FaceNet, coinciding_pairs};
use crate::nurbs::Patch;

/// A direction of a patch as one of several that are divided together.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Linked {
    /// Number of the group.
    pub group: usize,
    /// Whether the direction runs against the first one of the group.
    pub is_reversed: bool,
}

/// Groups of directions, for each patch and each of its directions.
///
/// A group that is linked with itself the wrong way round, as on a twisted ring, has each direction
/// the way it was first reached.
pub fn linked_directions(patches: &[Patch]) -> Vec<Vec<Linked>> {
    let faces = FaceId::all(patches);
    let nets: Vec<FaceNet> = faces.iter().map(|&id| FaceNet::new(patches, id)).collect();
    let first: Vec<usize> = patches
        .iter()
        .scan(0, |next, p| {
            *next += p.dimension();
            Some(*next - p.dimension())
        })
        .collect();
    let mut forest = Forest::new(patches.iter().map(Patch::dimension).sum());
    for (a, b, way) in coinciding_pairs(&nets, COINCIDENT) {
        let (a, b) = (faces[a], faces[b]);
        let others: Vec<usize> = b.tangents(patches[b.patch].dimension()).collect();
        for (along, d) in a.tangents(patches[a.patch].dimension()).enumerate() {
            let (partner, is_reversed) = way.direction(along);
            forest.join(first[a.patch] + d, first[b.patch] + others[partner], is_reversed);
        }
    }
    let direction = |i: usize| {
        let (group, is_reversed) = forest.root(i);
        Linked { group, is_reversed }
    };
    first.iter().zip(patches).map(|(f, p)| (0..p.dimension()).map(|d| direction(f + d)).collect()).collect()
}

/// Sets of directions; each knows its parent and whether it runs against it. The root of a set is
/// its first member.
struct Forest {
    parents: Vec<(usize, bool)>,
}

impl Forest {
    fn new(n: usize) -> Self {
        Self { parents: (0..n).map(|i| (i, false)).collect() }
    }

    fn root(&self, mut i: usize) -> (usize, bool) {
        let mut is_reversed = false;
        while self.parents[i].0 != i {
            is_reversed ^= self.parents[i].1;
            i = self.parents[i].0;
        }
        (i, is_reversed)
    }

    fn join(&mut self, a: usize, b: usize, is_reversed: bool) {
        let ((a, from_a), (b, from_b)) = (self.root(a), self.root(b));
        let (low, high) = (a.min(b), a.max(b));
        if low != high {
            self.parents[high] = (low, is_reversed ^ from_a ^ from_b);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_against_each_other_are_told() {
        let mut forest = Forest::new(5);
        forest.join(3, 1, true);
        forest.join(1, 4, true);
        forest.join(4, 0, true);
        assert_eq!([0, 1, 3, 4].map(|i| forest.root(i)), [(0, false), (0, false), (0, true), (0, true)]);
        assert_eq!(forest.root(2), (2, false));
    }
}
