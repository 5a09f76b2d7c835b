//! Lengths of a body along its parametric directions, and the elements that suit them.

use iga_core::nurbs::{Patch, Shape};

/// Places across a patch, a direction, at which parameter lines are measured; both ends are among them, for on singular nets
/// the longest lines lie on the surface.
const LINES: usize = 5;
/// Points of the chord of a line, a knot span: a chord of 1/16 of a quarter circle is 0.04 % too short.
const CHORDS: usize = 16;
/// Elements over half a wave at the start: four over a wave, which splines of degree 3 follow to some 1e-3 (Eq. N.1).
const ELEMENTS_PER_HALF_WAVE: f64 = 2.0;
/// Elements a direction at the start.
const LEAST: usize = 2;

/// Length of the longest parameter line of each direction \[m\]; lines through several patches are counted patch by patch.
pub fn lengths(shape: &Shape) -> Vec<f64> {
    let n = shape.patches.first().map_or(0, Patch::dimension);
    (0..n).map(|d| shape.patches.iter().map(|patch| longest_line(patch, d)).fold(0.0, f64::max)).collect()
}

fn longest_line(patch: &Patch, d: usize) -> f64 {
    let (lower, upper) = patch.domain();
    let n = patch.dimension();
    let mut longest = 0.0_f64;
    for line in 0..LINES.pow(n as u32 - 1) {
        let mut xi = lower;
        let mut rest = line;
        for e in (0..n).filter(|&e| e != d) {
            xi[e] = lower[e] + (upper[e] - lower[e]) * ((rest % LINES) as f64 / (LINES - 1) as f64);
            rest /= LINES;
        }
        longest = longest.max(line_length(patch, &xi, d));
    }
    longest
}

fn line_length(patch: &Patch, start: &[f64; 3], d: usize) -> f64 {
    let mut xi = *start;
    let mut point = |u: f64| {
        xi[d] = u;
        patch.point(&xi)
    };
    let mut length = 0.0;
    for span in patch.knots()[d].breaks().windows(2) {
        let mut before = point(span[0]);
        for k in 1..=CHORDS {
            let next = point(span[0] + (span[1] - span[0]) * (k as f64 / CHORDS as f64));
            length += (0..3).map(|c| (next[c] - before[c]).powi(2)).sum::<f64>().sqrt();
            before = next;
        }
    }
    length
}

/// Length of half a wave of the highest of `n_modes` modes of a body with these `lengths` \[m\].
///
/// A direction shorter than it holds one half wave, a longer one as many as fit; the product is the number of modes (Eq. N.1).
pub fn half_wave(lengths: &[f64], n_modes: usize) -> f64 {
    let modes = |w: f64| lengths.iter().map(|l| (l / w).max(1.0)).product::<f64>();
    let longest = lengths.iter().copied().fold(0.0, f64::max);
    let (mut short, mut long) = (longest / (2.0 * n_modes.max(1) as f64), longest);
    // Two dozen halvings: elements are whole numbers.
    for _ in 0..24 {
        let middle = (short * long).sqrt();
        if modes(middle) > n_modes as f64 { short = middle } else { long = middle }
    }
    long
}

/// Elements a direction for `n_modes` modes, from which the check starts; never fewer than the shape has itself. Each of several
/// patches has its part of the modes, and the same number in all directions: they share faces.
pub fn first_elements(shape: &Shape, lengths: &[f64], n_modes: usize) -> Vec<usize> {
    let of_patch = n_modes.div_ceil(shape.patches.len().max(1));
    let size = half_wave(lengths, of_patch) / ELEMENTS_PER_HALF_WAVE;
    let own = |d: usize| shape.patches.iter().map(|p| p.knots()[d].breaks().len() - 1).max().unwrap_or(1);
    let wanted = |(d, l): (usize, &f64)| ((l / size - 0.1).ceil() as usize).max(LEAST).max(own(d));
    let mut elements: Vec<usize> = lengths.iter().enumerate().map(wanted).collect();
    if shape.patches.len() > 1 {
        let most = elements.iter().copied().max().unwrap_or(LEAST);
        elements.fill(most);
    }
    elements
}

/// For each direction, the first one that looks like it: a single patch whose control net, after exchange of the two, is
/// congruent to itself (all distances between control points and all weights are the same).
pub fn equivalent_directions(shape: &Shape) -> Vec<usize> {
    let n = shape.patches.first().map_or(0, Patch::dimension);
    let [patch] = shape.patches.as_slice() else { return (0..n).collect() };
    (0..n).map(|d| (0..d).find(|&e| is_exchangeable(patch, e, d)).unwrap_or(d)).collect()
}

/// Relative difference of lengths and weights that counts as none: round-off of the nets of the catalogue.
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
    fn patches_that_share_faces_have_the_same_elements_in_all_directions() {
        let shells = sphere::sphere(0.01, SphereNet::Shells).unwrap();
        // A radius from the inner cube to the surface is shorter than the arcs beside it.
        let lengths = lengths(&shells);
        assert!(lengths[2] < 0.9 * lengths[0], "{lengths:?}");
        let elements = first_elements(&shells, &lengths, 700);
        assert!(elements.iter().all(|n| *n == elements[0]), "{elements:?}");
    }

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
