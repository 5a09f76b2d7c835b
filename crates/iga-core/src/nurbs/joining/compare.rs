//! What two faces that lie on one another differ in.

use super::{DIRECTIONS, WELD};
use crate::nurbs::Patch;
use crate::nurbs::interface::{FaceId, FaceNet, Way};
use crate::nurbs::jet::{difference as minus, norm};
use crate::splines::knots::KnotVector;

/// What makes two faces, of which the first lies on the second in the way `way`, no single spline.
pub fn splines(patches: &[Patch], faces: [FaceId; 2], way: Way) -> Option<String> {
    functions(patches, faces, way).or_else(|| nets(patches, faces, way))
}

fn functions(patches: &[Patch], [a, b]: [FaceId; 2], way: Way) -> Option<String> {
    let others: Vec<usize> = b.tangents(patches[b.patch].dimension()).collect();
    for (i, d) in a.tangents(patches[a.patch].dimension()).enumerate() {
        let (partner, is_reversed) = way.direction(i);
        let e = others[partner];
        let (first, second) = (&patches[a.patch].knots()[d], &patches[b.patch].knots()[e]);
        let (p, q, along, beside) = (first.degree(), second.degree(), DIRECTIONS[d], DIRECTIONS[e]);
        if p != q {
            return Some(format!("their degrees are {p} and {q} along {along} and {beside}"));
        }
        let own = interior(first);
        let mut other = interior(second);
        if is_reversed {
            other.reverse();
            other.iter_mut().for_each(|u| *u = 1.0 - *u);
        }
        if own.len() != other.len() || own.iter().zip(&other).any(|(u, v)| (u - v).abs() > WELD) {
            return Some(format!(
                "their interior knots are {own:?} and {other:?} along {along} and {beside}"
            ));
        }
    }
    None
}

fn interior(knots: &KnotVector) -> Vec<f64> {
    let all = knots.knots();
    all[knots.degree() + 1..all.len() - knots.degree() - 1].to_vec()
}

fn nets(patches: &[Patch], [a, b]: [FaceId; 2], way: Way) -> Option<String> {
    let (first, second) = (FaceNet::new(patches, a), FaceNet::new(patches, b));
    let limit = WELD * first.extent().min(second.extent());
    let [weights, others] =
        [a, b].map(|id| entries(patches, id).map(|i| patches[id.patch].weights()[i]).collect::<Vec<_>>());
    let scale = weights[0] / others[way.partner(first.sizes(), 0)];
    for (i, point) in first.points().iter().enumerate() {
        let partner = way.partner(first.sizes(), i);
        let distance = norm(&minus(point, &second.points()[partner]));
        if distance > limit {
            return Some(format!(
                "a control point of the second is {distance:.2e} m off the one of the first at ({}, {}, {}) m",
                point[0], point[1], point[2]
            ));
        }
        let pair = [weights[i], scale * others[partner]];
        if (pair[0] - pair[1]).abs() > WELD * pair[0] {
            return Some(format!(
                "their weights are in no fixed proportion, {} and {} at ({}, {}, {}) m",
                pair[0], pair[1], point[0], point[1], point[2]
            ));
        }
    }
    None
}

/// Numbers in its patch of the control points of a face, in the order of its net.
pub fn entries(patches: &[Patch], id: FaceId) -> impl Iterator<Item = usize> + use<> {
    let sizes = patches[id.patch].net_size();
    let stride: usize = sizes[..id.direction].iter().product();
    let (n, total) = (sizes[id.direction], sizes.iter().product::<usize>());
    let layer = if id.upper { n - 1 } else { 0 };
    (0..total).filter(move |i| i / stride % n == layer)
}

/// The way in which the first face lies on the second if their corners agree.
pub fn way_by_corners(patches: &[Patch], [a, b]: [FaceId; 2]) -> Option<Way> {
    let [first, second] = [a, b].map(|id| FaceNet::new(patches, id));
    let limit = WELD * first.extent().min(second.extent());
    let agrees = |way: &Way| {
        let [m, n] = first.sizes();
        let target = second.sizes();
        [0, m - 1, m * (n - 1), m * n - 1].into_iter().all(|flat| {
            // Corners of a net of another size: the same corner of a net of two points per
            // direction.
            let corner = usize::from(flat % m > 0) + 2 * usize::from(flat / m > 0);
            let partner = way.partner([2, 2], corner);
            let at = (partner % 2) * (target[0] - 1) + (partner / 2) * (target[1] - 1) * target[0];
            norm(&minus(&first.points()[flat], &second.points()[at])) <= limit
        })
    };
    let mut ways: Vec<Way> = Way::all().filter(agrees).collect();
    // Of several, as on closed faces, the one in which least differs.
    ways.sort_by_key(|way| functions(patches, [a, b], *way).is_some());
    ways.first().copied()
}
