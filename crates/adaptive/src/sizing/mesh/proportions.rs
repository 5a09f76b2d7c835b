//! Lengths of a body along its parametric directions, and what is alike about them.

use std::collections::BTreeSet;

use iga_core::nurbs::interface::linked::linked_directions;
use iga_core::nurbs::shape::lengths::longest_line;
use iga_core::nurbs::{Patch, Shape};

/// Distance of the ends of a closed line over its length that is round-off.
const CLOSED: f64 = 1e-9;

/// The least of `lengths`.
pub fn shortest(lengths: &[f64]) -> f64 {
    lengths.iter().copied().fold(f64::INFINITY, f64::min)
}

/// The largest of `lengths`.
pub fn longest(lengths: &[f64]) -> f64 {
    lengths.iter().copied().fold(0.0, f64::max)
}

/// Length of half a wave of the highest of `n_modes` modes of a body with these `lengths` \[m\].
///
/// A direction shorter than it holds one half wave, a longer one as many as fit; the product is the
/// number of modes (Eq. N.1).
pub fn half_wave(lengths: &[f64], n_modes: usize) -> f64 {
    let modes = |w: f64| lengths.iter().map(|l| (l / w).max(1.0)).product::<f64>();
    let longest = longest(lengths);
    let (mut short, mut long) = (longest / (2.0 * n_modes.max(1) as f64), longest);
    // Two dozen halvings: elements are whole numbers.
    for _ in 0..24 {
        let middle = (short * long).sqrt();
        if modes(middle) > n_modes as f64 { short = middle } else { long = middle }
    }
    long
}

/// Whether parameter lines of direction `d` through the middle of `patch` end where they begin.
pub fn is_closed(patch: &Patch, d: usize) -> bool {
    let (lower, upper) = patch.domain();
    let mut ends = [[0.0; 3]; 2];
    for (end, at) in ends.iter_mut().zip([lower[d], upper[d]]) {
        let mut xi: [f64; 3] = std::array::from_fn(|e| 0.5 * (lower[e] + upper[e]));
        xi[d] = at;
        *end = patch.point(&xi);
    }
    let distance = (0..3).map(|c| (ends[0][c] - ends[1][c]).powi(2)).sum::<f64>().sqrt();
    distance < CLOSED * longest_line(patch, d)
}

/// Directions that have one number of elements, because shared faces of patches turn one into the
/// other: of one patch each by itself.
pub fn groups(shape: &Shape) -> Vec<Vec<usize>> {
    let n = shape.patches.first().map_or(0, Patch::dimension);
    if shape.patches.len() == 1 {
        return (0..n).map(|d| vec![d]).collect();
    }
    let linked = linked_directions(&shape.patches);
    let mut groups: Vec<BTreeSet<usize>> = Vec::new();
    for d in 0..n {
        // Members of the links that direction d of any patch belongs to.
        let own: BTreeSet<usize> = linked.iter().map(|links| links[d].group).collect();
        let is_linked = |e: &usize| linked.iter().any(|links| own.contains(&links[*e].group));
        let mut merged: BTreeSet<usize> = (0..n).filter(is_linked).collect();
        groups.retain(|group| {
            let meets = !group.is_disjoint(&merged);
            merged.extend(group.iter().filter(|_| meets));
            !meets
        });
        groups.push(merged);
    }
    let mut groups: Vec<Vec<usize>> = groups.into_iter().map(|group| group.into_iter().collect()).collect();
    groups.sort();
    groups
}

/// For each direction, the first one that looks like it: a single patch whose control net, after
/// exchange of the two, is congruent to itself (all distances between control points and all
/// weights are the same).
pub fn equivalent_directions(shape: &Shape) -> Vec<usize> {
    let n = shape.patches.first().map_or(0, Patch::dimension);
    let [patch] = shape.patches.as_slice() else { return (0..n).collect() };
    (0..n).map(|d| (0..d).find(|&e| is_exchangeable(patch, e, d)).unwrap_or(d)).collect()
}

/// Relative difference of lengths and weights that counts as none: round-off of the nets of the
/// catalogue.
const CONGRUENT: f64 = 1e-12;

fn is_exchangeable(patch: &Patch, a: usize, b: usize) -> bool {
    let (knots, sizes) = (patch.knots(), patch.net_size());
    if knots[a].degree() != knots[b].degree() || knots[a].knots() != knots[b].knots() {
        return false;
    }
    let exchanged = |point: usize| {
        let (mut rest, mut index) = (point, Vec::with_capacity(sizes.len()));
        for size in &sizes {
            index.push(rest % size);
            rest /= size;
        }
        index.swap(a, b);
        index.iter().zip(&sizes).rev().fold(0, |number, (i, size)| number * size + i)
    };
    let (points, weights) = (patch.control_points(), patch.weights());
    let distance =
        |i: usize, j: usize| (0..3).map(|c| (points[i][c] - points[j][c]).powi(2)).sum::<f64>().sqrt();
    let of: Vec<usize> = (0..points.len()).map(exchanged).collect();
    let size = (0..points.len()).map(|i| distance(0, i)).fold(0.0, f64::max);
    let pairs = (0..points.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
    of.iter().enumerate().all(|(i, &k)| (weights[i] - weights[k]).abs() <= CONGRUENT * weights[i].abs())
        && pairs.clone().all(|(i, j)| (distance(i, j) - distance(of[i], of[j])).abs() <= CONGRUENT * size)
}

#[cfg(test)]
mod tests {
    use super::*;
    use iga_core::nurbs::primitives::{SphereNet, axisymmetric, plane, solid, sphere};

    #[test]
    fn directions_that_a_mirror_exchanges_are_twins() {
        let of = |shape: Result<Shape, iga_core::SplineError>| equivalent_directions(&shape.unwrap());
        assert_eq!(of(solid::cuboid([1.0, 1.0, 2.0])), [0, 0, 2]);
        assert_eq!(of(solid::cuboid([1.0, 1.01, 1.0])), [0, 1, 0]);
        assert_eq!(of(solid::cylinder(0.01, 0.02)), [0, 0, 2]);
        assert_eq!(of(solid::hollow_cylinder(1.0, 2.0, 1.0)), [0, 1, 2]);
        assert_eq!(of(sphere::sphere(1.0, SphereNet::Cube)), [0, 0, 0]);
        assert_eq!(
            of(sphere::sphere(1.0, SphereNet::Shells)),
            [0, 1, 2],
            "several patches are not looked at"
        );
        assert_eq!(of(plane::disc(1.0)), [0, 0]);
        assert_eq!(of(axisymmetric::rod(1.0, 2.0)), [0, 1]);
    }
}
