//! Faces that patches share, and the functions of one level that are one function across them
//! (theory section H.8).

use super::ties::PatchTies;
use crate::nurbs::Patch;
use crate::nurbs::interface::{COINCIDENT, FaceId, FaceNet, coinciding_pairs};

/// A face of a patch that is also a face of another one, seen from the first.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SharedFace {
    /// The face as one of the patch.
    pub own: FaceId,
    /// The same face as one of the other patch.
    pub other: FaceId,
    /// For each direction along the face that of the other patch, and whether it runs backwards
    /// there.
    along: [Option<(usize, bool)>; 3],
}

impl SharedFace {
    /// The direction of the other patch that direction `d` along the face is, and whether it runs
    /// backwards there; none across the face.
    pub fn direction(&self, d: usize) -> Option<(usize, bool)> {
        self.along[d]
    }

    /// The face seen from the other patch.
    fn reversed(&self) -> Self {
        let mut along = [None; 3];
        for (d, way) in self.along.iter().enumerate() {
            if let Some((other, is_reversed)) = *way {
                along[other] = Some((d, is_reversed));
            }
        }
        Self { own: self.other, other: self.own, along }
    }

    /// Whether net entry `index` of the patch, whose net has the `sizes`, lies on the face.
    pub(super) fn holds(&self, index: &[usize; 3], sizes: &[usize; 3]) -> bool {
        let end = if self.own.upper { sizes[self.own.direction] - 1 } else { 0 };
        index[self.own.direction] == end
    }

    /// The entry of the other patch's net that entry `index` of the own one is; `sizes` are those
    /// of both nets.
    pub(super) fn partner(&self, index: &[usize; 3], [own, other]: [&[usize; 3]; 2]) -> [usize; 3] {
        let mut partner = [0; 3];
        partner[self.other.direction] = if self.other.upper { other[self.other.direction] - 1 } else { 0 };
        for d in 0..3 {
            if let Some((there, is_reversed)) = self.along[d] {
                partner[there] = if is_reversed { own[d] - 1 - index[d] } else { index[d] };
            }
        }
        partner
    }
}

/// Faces that are shared by two patches each, for every patch.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Neighbours {
    shared: Vec<Vec<SharedFace>>,
}

impl Neighbours {
    /// Finds the shared faces of `patches` by their control points. Faces that collapse to a line
    /// or a point are none, and a seam of a patch with itself belongs to its [`PatchTies`].
    pub fn detect(patches: &[Patch], ties: &[PatchTies]) -> Self {
        let mut shared = vec![Vec::new(); patches.len()];
        if patches.len() > 1 {
            let mut faces = FaceId::all(patches);
            faces.retain(|face| !ties[face.patch].has_collapsed_face(face, patches[face.patch].dimension()));
            let nets: Vec<FaceNet> = faces.iter().map(|&id| FaceNet::new(patches, id)).collect();
            for (a, b, way) in coinciding_pairs(&nets, COINCIDENT) {
                let (own, other) = (faces[a], faces[b]);
                if own.patch == other.patch {
                    continue;
                }
                let there: Vec<usize> = other.tangents(patches[other.patch].dimension()).collect();
                let mut along = [None; 3];
                for (i, d) in own.tangents(patches[own.patch].dimension()).enumerate() {
                    let (partner, is_reversed) = way.direction(i);
                    along[d] = Some((there[partner], is_reversed));
                }
                let face = SharedFace { own, other, along };
                shared[own.patch].push(face);
                shared[other.patch].push(face.reversed());
            }
        }
        Self { shared }
    }

    /// The shared faces of patch `patch`.
    pub fn of(&self, patch: usize) -> &[SharedFace] {
        &self.shared[patch]
    }

    /// Whether face `face` is shared.
    pub fn shared_face(&self, face: &FaceId) -> Option<&SharedFace> {
        self.shared[face.patch].iter().find(|s| s.own == *face)
    }
}

/// The functions of one level of all patches as those of a space that is continuous across shared
/// faces, seams and lines of collapse.
pub(super) struct Level<'a> {
    pub neighbours: &'a Neighbours,
    pub ties: &'a [PatchTies],
    /// Net sizes of the level, one per patch.
    pub sizes: &'a [[usize; 3]],
}

impl Level<'_> {
    /// Whether entry `index` of a patch's net lies on a face that is shared.
    pub fn is_shared(&self, patch: usize, index: &[usize; 3]) -> bool {
        self.neighbours.of(patch).iter().any(|face| face.holds(index, &self.sizes[patch]))
    }

    /// All net entries that are one function with entry `index` of the net of `patch`, itself the
    /// first.
    pub fn group(&self, patch: usize, index: [usize; 3]) -> Vec<(usize, [usize; 3])> {
        let mut group = vec![(patch, index)];
        let mut next = 0;
        while next < group.len() {
            let (patch, index) = group[next];
            let sizes = &self.sizes[patch];
            let mut add = |entry| {
                if !group.contains(&entry) {
                    group.push(entry);
                }
            };
            for face in self.neighbours.of(patch).iter().filter(|face| face.holds(&index, sizes)) {
                let there = face.other.patch;
                add((there, face.partner(&index, [sizes, &self.sizes[there]])));
            }
            self.ties[patch].for_each_partner(&index, sizes, |other| add((patch, other)));
            next += 1;
        }
        group
    }
}
