//! Patches that touch where they are not joined.

use super::{Parts, WELD, compare};
use crate::nurbs::interface::{FaceNet, Way, coinciding_pairs};
use crate::nurbs::jet::{diagonal, difference, dot, norm};
use crate::nurbs::joining::fault::JoinFault;
use crate::nurbs::patch::PointBasis;
use crate::nurbs::{Face, SurfacePoint};
use crate::nurbs::{Patch, PatchSearch};

/// Slits narrower than this share of the size of the smaller patch are a slip.
const SLIT: f64 = 1e-4;
/// Places along a face, as shares of the elements, at which it is looked at: none lies on an edge
/// or in a middle.
const PLACES: [f64; 4] = [0.13, 0.37, 0.61, 0.87];
/// Elements per direction of a face that are looked at.
const MOST_ON_FACE: usize = 8;
/// Elements per direction of a patch that are looked at.
const MOST_INSIDE: usize = 4;
/// Places along a patch at which it is looked at.
const INSIDE: [f64; 3] = [0.11, 0.47, 0.91];
/// Distance from the ends of a parameter range that counts as inside.
const MARGIN: f64 = 1e-3;

/// Checks that the material of two faces that are one lies on either side.
pub fn check_sides(parts: &Parts, a: usize, b: usize, way: Way) -> Result<(), JoinFault> {
    let [one, other] = [a, b].map(|f| parts.faces[f]);
    let dimension = parts.patches[one.patch].dimension();
    let (mut xi, mut eta) = ([0.0; 3], [0.0; 3]);
    let along: Vec<usize> = other.tangents(dimension).collect();
    for (i, d) in one.tangents(dimension).enumerate() {
        let (partner, is_reversed) = way.direction(i);
        xi[d] = PLACES[i + 1];
        eta[along[partner]] = if is_reversed { 1.0 - xi[d] } else { xi[d] };
    }
    let [one, other] = [(one, xi), (other, eta)].map(|(id, xi)| {
        Face::new(&parts.patches, id, false).at(&parts.patches[id.patch], &xi, &mut PointBasis::default())
    });
    if dot(&one.normal, &other.normal) > 0.0 {
        let patches = [a, b].map(|f| parts.faces[f].patch);
        return Err(JoinFault::Overlap { patches, point: one.point });
    }
    Ok(())
}

/// Checks that faces that are not joined do not lie on one another, and that no patch reaches into
/// another.
pub fn check(parts: &Parts) -> Result<(), JoinFault> {
    if parts.patches.len() == 1 {
        return Ok(());
    }
    let mut is_tied = vec![false; parts.faces.len()];
    parts.ties.iter().for_each(|&(a, b, _)| (is_tied[a], is_tied[b]) = (true, true));
    let free: Vec<usize> = (0..is_tied.len()).filter(|&f| !is_tied[f]).collect();
    check_slits(parts, &free)?;
    check_faces(parts, &free)?;
    check_insides(parts)
}

/// Faces that are nearly the same and look at each other.
fn check_slits(parts: &Parts, free: &[usize]) -> Result<(), JoinFault> {
    let nets: Vec<FaceNet> = free.iter().map(|&f| FaceNet::new(&parts.patches, parts.faces[f])).collect();
    for (i, j, way) in coinciding_pairs(&nets, SLIT) {
        let (a, b) = (free[i], free[j]);
        if parts.faces[a].patch == parts.faces[b].patch {
            continue;
        }
        let distances = nets[i]
            .points()
            .iter()
            .enumerate()
            .map(|(flat, p)| norm(&difference(p, &nets[j].points()[way.partner(nets[i].sizes(), flat)])));
        let distance = distances.fold(0.0, f64::max);
        let share = distance / nets[i].extent().min(nets[j].extent());
        let [one, other] = [a, b].map(|f| middle(parts, f));
        if dot(&one.normal, &difference(&other.point, &one.point)) > 0.0 {
            return Err(JoinFault::Gap { faces: parts.names(a, b), distance, share });
        }
    }
    Ok(())
}

fn middle(parts: &Parts, face: usize) -> SurfacePoint {
    let id = parts.faces[face];
    Face::new(&parts.patches, id, false).at(&parts.patches[id.patch], &[0.5; 3], &mut PointBasis::default())
}

/// Points in the inside of faces that lie on another face.
fn check_faces(parts: &Parts, free: &[usize]) -> Result<(), JoinFault> {
    let boxes: Vec<Bounds> =
        free.iter().map(|&f| Bounds::new(FaceNet::new(&parts.patches, parts.faces[f]).points())).collect();
    let searches: Vec<PatchSearch> = free
        .iter()
        .map(|&f| {
            let id = parts.faces[f];
            PatchSearch::new(&parts.patches[id.patch], id.fixed(&parts.patches))
        })
        .collect();
    for (i, j) in neighbours(&boxes) {
        let [a, b] = [free[i], free[j]].map(|f| parts.faces[f]);
        if a.patch == b.patch {
            continue;
        }
        let limit = WELD * boxes[i].diagonal().min(boxes[j].diagonal());
        for (face, other, search, bounds) in
            [(a, b, &searches[j], &boxes[j]), (b, a, &searches[i], &boxes[i])]
        {
            let patch = &parts.patches[face.patch];
            let fixed = face.fixed(&parts.patches);
            for xi in places(patch, &fixed, &PLACES, MOST_ON_FACE) {
                let point = patch.point(&xi);
                if !bounds.holds(&point, limit) {
                    continue;
                }
                let on_other = search.closest_below(&parts.patches[other.patch], &point, limit);
                if on_other.is_none_or(|found| {
                    !is_inside(&found.xi, &other.fixed(&parts.patches), patch.dimension())
                }) {
                    continue;
                }
                let faces = parts.names(free[i], free[j]);
                let way = compare::way_by_corners(&parts.patches, [a, b]);
                let difference = way.and_then(|way| compare::splines(&parts.patches, [a, b], way));
                return Err(match difference {
                    Some(difference) => JoinFault::Mismatch { faces, difference },
                    None => JoinFault::Partly { faces, point },
                });
            }
        }
    }
    Ok(())
}

/// Points in the inside of patches that lie inside another.
fn check_insides(parts: &Parts) -> Result<(), JoinFault> {
    let boxes: Vec<Bounds> = parts.patches.iter().map(|p| Bounds::new(p.control_points())).collect();
    let mut searches: Vec<Option<PatchSearch>> = vec![None; boxes.len()];
    for (i, j) in neighbours(&boxes) {
        for (p, q) in [(i, j), (j, i)] {
            let (patch, other) = (&parts.patches[p], &parts.patches[q]);
            let limit = WELD * boxes[q].diagonal();
            for xi in places(patch, &[None; 3], &INSIDE, MOST_INSIDE) {
                let point = patch.point(&xi);
                if !boxes[q].holds(&point, 0.0) {
                    continue;
                }
                let search = searches[q].get_or_insert_with(|| PatchSearch::new(other, [None; 3]));
                let found = search.closest_below(other, &point, limit);
                if found.is_some_and(|at| is_inside(&at.xi, &[None; 3], other.dimension())) {
                    return Err(JoinFault::Overlap { patches: [p.min(q), p.max(q)], point });
                }
            }
        }
    }
    Ok(())
}

/// Whether all free parameters, from 0 to 1, are off the ends.
fn is_inside(xi: &[f64; 3], fixed: &[Option<f64>; 3], dimension: usize) -> bool {
    (0..dimension).all(|d| fixed[d].is_some() || (MARGIN..=1.0 - MARGIN).contains(&xi[d]))
}

/// Parameters in the elements of a patch, at `shares` of each direction that is not fixed, in
/// `most` elements of it at most.
fn places(patch: &Patch, fixed: &[Option<f64>; 3], shares: &[f64], most: usize) -> Vec<[f64; 3]> {
    let mut places = vec![[0.0; 3]];
    for (d, knots) in patch.knots().iter().enumerate() {
        let step = knots.n_elements().div_ceil(most);
        let values: Vec<f64> = match fixed[d] {
            Some(u) => vec![u],
            None => (0..knots.n_elements())
                .step_by(step)
                .flat_map(|e| {
                    let (a, b) = knots.element(e);
                    shares.iter().map(move |s| a + s * (b - a))
                })
                .collect(),
        };
        places = places
            .iter()
            .flat_map(|p| {
                values.iter().map(|u| {
                    let mut xi = *p;
                    xi[d] = *u;
                    xi
                })
            })
            .collect();
    }
    places
}

/// A box around points.
struct Bounds {
    lower: [f64; 3],
    upper: [f64; 3],
}

impl Bounds {
    fn new(points: &[[f64; 3]]) -> Self {
        let fold = |start: f64, f: fn(f64, f64) -> f64| {
            points.iter().fold([start; 3], |b, p| [0, 1, 2].map(|c| f(b[c], p[c])))
        };
        Self { lower: fold(f64::INFINITY, f64::min), upper: fold(f64::NEG_INFINITY, f64::max) }
    }

    fn diagonal(&self) -> f64 {
        diagonal(&[self.lower, self.upper])
    }

    fn holds(&self, p: &[f64; 3], slack: f64) -> bool {
        (0..3).all(|c| self.lower[c] - slack <= p[c] && p[c] <= self.upper[c] + slack)
    }

    fn meets(&self, other: &Self) -> bool {
        let slack = WELD * self.diagonal().min(other.diagonal());
        (0..3).all(|c| self.lower[c] <= other.upper[c] + slack && other.lower[c] <= self.upper[c] + slack)
    }
}

/// Pairs of boxes that meet, found by sorting them along x.
fn neighbours(boxes: &[Bounds]) -> Vec<(usize, usize)> {
    let mut order: Vec<usize> = (0..boxes.len()).collect();
    order.sort_by(|&a, &b| boxes[a].lower[0].total_cmp(&boxes[b].lower[0]).then(a.cmp(&b)));
    let mut pairs = Vec::new();
    for (place, &a) in order.iter().enumerate() {
        let end = boxes[a].upper[0] + WELD * boxes[a].diagonal();
        for &b in order[place + 1..].iter().take_while(|&&b| boxes[b].lower[0] <= end) {
            if boxes[a].meets(&boxes[b]) {
                pairs.push((a.min(b), a.max(b)));
            }
        }
    }
    pairs.sort_unstable();
    pairs
}
