//! Lattices of patches beyond shared faces: they go on with the elements that the levels have there
//! (theory Eq. A.11).

use iga_core::hierarchical::{Neighbours, PatchTies, SharedFace};
use iga_core::nurbs::Patch;
use iga_core::nurbs::interface::linked::Linked;
use iga_core::nurbs::jet::norm;
use iga_core::nurbs::patch::PointBasis;

use super::LinkedLattice;
use super::levels::links;
use crate::adaptivity::lattice::DirectionLattice;

/// Adds lattices to directions of `patches` that have none, from patch to patch, beginning with
/// those that hold `places`, which have one in every direction: through the shared face, with
/// elements as long as on its other side.
pub(super) fn extend(patches: &[Patch], lattices: &mut Vec<LinkedLattice>, places: &[(usize, [f64; 3])]) {
    let links = links(patches);
    let ties: Vec<PatchTies> = patches.iter().map(PatchTies::detect).collect();
    let neighbours = Neighbours::detect(patches, &ties);
    let mut waiting = places.to_vec();
    let mut is_known = vec![false; patches.len()];
    places.iter().for_each(|(patch, _)| is_known[*patch] = true);
    let mut next = 0;
    while next < waiting.len() {
        let (patch, place) = waiting[next];
        for face in neighbours.of(patch) {
            let there = across(patches, face, &place);
            add(patches, &links, lattices, face, [&place, &there]);
            if !std::mem::replace(&mut is_known[face.other.patch], true) {
                waiting.push((face.other.patch, there));
            }
        }
        next += 1;
    }
}

/// The lattice of a group of directions.
fn of_group(links: &[Vec<Linked>], lattices: &[LinkedLattice], group: usize) -> Option<DirectionLattice> {
    let found = lattices.iter().find(|l| links[l.patch][l.direction].group == group);
    found.map(|l| l.lattice)
}

/// Adds the lattice across a shared face in the other patch, if there is none; `places` are those
/// of both patches nearest to the zone.
fn add(
    patches: &[Patch],
    links: &[Vec<Linked>],
    lattices: &mut Vec<LinkedLattice>,
    face: &SharedFace,
    places: [&[f64; 3]; 2],
) {
    let (own, other) = (face.own, face.other);
    let group = |patch: usize, d: usize| links[patch][d].group;
    if of_group(links, lattices, group(other.patch, other.direction)).is_some() {
        return;
    }
    let Some(known) = of_group(links, lattices, group(own.patch, own.direction)) else { return };
    let speed = |patch: usize, xi: &[f64; 3], d: usize| {
        norm(&patches[patch].jet(xi, 1, &mut PointBasis::default()).first[d])
    };
    let length = known.spacing * speed(own.patch, places[0], own.direction);
    let knots = &patches[other.patch].knots()[other.direction];
    let (first, last) = knots.domain();
    let rate = speed(other.patch, places[1], other.direction);
    let (end, inwards) = if other.upper { (last, -1.0) } else { (first, 1.0) };
    // Where parameters do not move the place, a patch is not divided.
    let spacing = if rate > 0.0 { (length / rate).min(last - first) } else { last - first };
    let lattice = DirectionLattice::into_depth(knots, end, end + inwards * spacing, spacing);
    let lattice = DirectionLattice { n_skipped: known.n_skipped, ..lattice };
    lattices.push(LinkedLattice { patch: other.patch, direction: other.direction, lattice });
}

/// The place of the other patch on a shared face that is across from `place` of the own one.
fn across(patches: &[Patch], face: &SharedFace, place: &[f64; 3]) -> [f64; 3] {
    let (own, other) = (&patches[face.own.patch], &patches[face.other.patch]);
    let mut there = [0.0; 3];
    let (first, last) = other.knots()[face.other.direction].domain();
    there[face.other.direction] = if face.other.upper { last } else { first };
    for (d, knots) in own.knots().iter().enumerate() {
        let Some((along, is_reversed)) = face.direction(d) else { continue };
        let (first, last) = knots.domain();
        let share = (place[d] - first) / (last - first);
        let (first, last) = other.knots()[along].domain();
        there[along] =
            if is_reversed { last - share * (last - first) } else { first + share * (last - first) };
    }
    there
}
