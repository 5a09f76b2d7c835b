//! Finding control points that coincide.

use std::collections::HashMap;

use crate::nurbs::jet::{diagonal, difference, norm};

/// Distance below which control points coincide, relative to the diagonal of the body's bounding
/// box.
const TIE_TOLERANCE: f64 = 1e-9;

/// For every point the index of the first point that it coincides with, itself if there is none
/// before it.
///
/// Only points with `may_tie` are compared. A hash grid with cells of the tolerance's size keeps
/// the cost linear.
pub fn coincident(points: &[[f64; 3]], may_tie: impl Fn(usize) -> bool) -> Vec<usize> {
    let tolerance = TIE_TOLERANCE * diagonal(points);
    let mut cells: HashMap<[i64; 3], Vec<usize>> = HashMap::new();
    let mut first: Vec<usize> = (0..points.len()).collect();
    if tolerance <= 0.0 {
        return first;
    }
    for i in (0..points.len()).filter(|&i| may_tie(i)) {
        // Coordinates lie within 1e9 / 2 cells of the box's centre wherever the origin is not far
        // away; i64 saturates.
        let cell = points[i].map(|x| (x / (2.0 * tolerance)).round() as i64);
        if let Some(j) = neighbour(&cells, cell, points, i, tolerance) {
            first[i] = j;
        } else {
            cells.entry(cell).or_default().push(i);
        }
    }
    first
}

fn neighbour(
    cells: &HashMap<[i64; 3], Vec<usize>>,
    cell: [i64; 3],
    points: &[[f64; 3]],
    i: usize,
    tolerance: f64,
) -> Option<usize> {
    let steps = [0, -1, 1];
    let around = steps.iter().flat_map(|a| steps.iter().flat_map(move |b| steps.map(|c| [*a, *b, c])));
    around
        .filter_map(|s| cells.get(&[0, 1, 2].map(|d| cell[d].saturating_add(s[d]))))
        .flatten()
        .copied()
        .filter(|&j| norm(&difference(&points[i], &points[j])) <= tolerance)
        .min()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_within_the_tolerance_are_found_across_cell_borders() {
        let mut points = vec![[0.0; 3], [1.0, 0.0, 0.0]];
        for i in 0..200 {
            points.push([0.3 + 0.5e-9 * (i % 2) as f64 + 1e-3 * (i / 2) as f64, 0.1, 0.0]);
        }
        let first = coincident(&points, |i| i != 5);
        for i in 0..100 {
            let (a, b) = (2 + 2 * i, 3 + 2 * i);
            assert_eq!(first[b], if b == 5 { b } else { a }, "pair {i}");
        }
    }
}
