//! Contact points of faces with their tributary areas: Greville, Gauss and Lobatto points (theory
//! Eqs. S.19, S.20, C.56).

use std::collections::{BTreeMap, BTreeSet};

use super::extraction::ElementSide;
use crate::nurbs::Patch;
use crate::nurbs::face::Face;
use crate::nurbs::interface::FaceId;
use crate::nurbs::jet::{dot, norm};
use crate::nurbs::patch::PointBasis;
use crate::quadrature::{GaussRule, LobattoRule, MAX_GAUSS};
use crate::space::SplineSpace;

/// A point of the surface at which the contact condition is watched.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CollocationPoint {
    /// The face it lies on.
    pub face: FaceId,
    /// Element of the space.
    pub element: usize,
    /// Parameters in the face's patch.
    pub xi: [f64; 3],
    /// Undeformed position \[m\].
    pub point: [f64; 3],
    /// Undeformed outward normal; zero at a pole of the parametrisation.
    pub normal: [f64; 3],
    /// Tributary area \[m²\] (in plane models length \[m\]): `∫ R_i dA` or Gauss weight times area
    /// element.
    pub area: f64,
    /// The function whose Greville point it is; `None` for Gauss and Lobatto points.
    pub function: Option<u32>,
}

/// Tributary areas `∫ R_i dA` of the functions that do not vanish on the face, by function number
/// \[m²\]. They are non-negative and sum to the area of the face.
pub fn tributary_areas(space: &dyn SplineSpace, patches: &[Patch], face: &Face) -> BTreeMap<u32, f64> {
    let mut areas = BTreeMap::new();
    let mut active = Vec::new();
    let (mut basis, mut scratch) = (PointBasis::default(), PointBasis::default());
    for ElementSide { element: e, .. } in ElementSide::all(space, face) {
        space.active_functions(e, &mut active);
        // The integrand is a quotient with a square root in it; a surface is cheap enough for
        // generous rules.
        for (xi, weight) in points_on(space, face, e, |d| space.gauss_counts(e)[d] + 4) {
            space.evaluate(e, &xi, 0, &mut basis);
            let area = weight * face.at(&patches[face.id.patch], &xi, &mut scratch).area;
            for (&i, r) in active.iter().zip(&basis.values).filter(|(_, r)| **r > 0.0) {
                *areas.entry(i).or_insert(0.0) += r * area;
            }
        }
    }
    areas
}

/// Gauss points of all face elements; `count` points per direction, or as many as the element's
/// matrices take. Areas are Gauss weight times area element.
pub fn gauss_points(
    space: &dyn SplineSpace,
    patches: &[Patch],
    faces: &[Face],
    count: Option<usize>,
) -> Vec<CollocationPoint> {
    let mut points = Vec::new();
    let mut scratch = PointBasis::default();
    for face in faces {
        for ElementSide { element, .. } in ElementSide::all(space, face) {
            let n = |d: usize| count.unwrap_or(space.gauss_counts(element)[d]);
            for (xi, weight) in points_on(space, face, element, n) {
                let at = face.at(&patches[face.id.patch], &xi, &mut scratch);
                points.push(CollocationPoint {
                    face: face.id,
                    element,
                    xi,
                    point: at.point,
                    normal: at.normal,
                    area: weight * at.area,
                    function: None,
                });
            }
        }
    }
    points
}

/// Lobatto points of all face elements, those on common ends of elements of a face once where it is
/// smooth (theory Eq. C.56): edges, rims and corners carry points, one of each face that meets
/// there. The rule integrates a constant pressure times every function of a flat face exactly.
/// Points without area, as on the axis of axisymmetric models, at poles and on singular lines, are
/// left out.
///
/// Sides of elements that hold one of the places `about`, parameters on faces, are divided there,
/// and `halvings` times towards it by halves: the rule holds on each part, so that a point stands
/// at the place and others about it (theory Eq. C.65).
pub fn lobatto_points(
    space: &dyn SplineSpace,
    patches: &[Patch],
    faces: &[Face],
    (about, halvings): (&[(FaceId, [f64; 3])], u8),
) -> Vec<CollocationPoint> {
    let mut scratch = PointBasis::default();
    let mut points: Vec<CollocationPoint> = Vec::new();
    for face in faces {
        let patch = &patches[face.id.patch];
        let rules: Vec<LobattoRule> = (face.degrees(patch).iter())
            .map(|p| {
                LobattoRule::new((p + usize::from(face.axisymmetric) + 3).div_ceil(2).clamp(2, MAX_GAUSS))
            })
            .collect();
        let mut known: BTreeMap<[i64; 3], Vec<usize>> = BTreeMap::new();
        let (lower, upper) = patch.domain();
        let share =
            |xi: &[f64; 3], d: usize| (xi[d] - lower[d]) / (upper[d] - lower[d]).max(f64::MIN_POSITIVE);
        for side in ElementSide::all(space, face) {
            let place = about.iter().find(|(id, xi)| *id == face.id && side.holds(xi)).map(|(_, xi)| *xi);
            for (xi, weight) in lobatto_on(&side, &rules, (place, halvings)) {
                // Tangents at ends of elements are those from within: they may jump there.
                let middle = side.parameters([0.5; 2]);
                let inside = std::array::from_fn(|d| xi[d] + INSIDE * (middle[d] - xi[d]));
                // Asked this way round, a NaN is left out.
                let has_area = face.at(patch, &xi, &mut scratch).area > 0.0;
                let at = face.at(patch, &inside, &mut scratch);
                let area = weight * at.area;
                if !has_area {
                    continue;
                }
                let here =
                    known.entry([0, 1, 2].map(|d| (SAME_SHARE * share(&xi, d)).round() as i64)).or_default();
                if let Some(&i) = here.iter().find(|&&i| dot(&points[i].normal, &at.normal) > 1.0 - SMOOTH) {
                    points[i].area += area;
                    continue;
                }
                here.push(points.len());
                points.push(CollocationPoint {
                    face: face.id,
                    element: side.element,
                    xi,
                    point: patch.point(&xi),
                    normal: at.normal,
                    area,
                    function: None,
                });
            }
        }
    }
    points
}

/// Parts of a range of which points in one are one: far below the smallest part of an element, far
/// above round-off.
const SAME_SHARE: f64 = 1e10;

/// Share of the way to the middle of an element at which tangents at its ends are taken.
const INSIDE: f64 = 1e-9;

/// Share of an element's side by which a place beside its end is that end: round-off of a search,
/// far below the smallest part.
const AT_END: f64 = 1e-6;

/// Ends of the parts of a range that is divided at `place`, and `halvings` times towards it.
fn parts_towards(place: f64, halvings: u8, (lower, upper): (f64, f64)) -> Vec<f64> {
    let is_end = |end: f64| (place - end).abs() <= AT_END * (upper - lower);
    let mut ends = vec![lower];
    if !is_end(lower) {
        ends.extend((1..=halvings).map(|k| place - (place - lower) * (-f64::from(k)).exp2()));
    }
    if !is_end(lower) && !is_end(upper) {
        ends.push(place);
    }
    if !is_end(upper) {
        ends.extend((1..=halvings).rev().map(|k| place + (upper - place) * (-f64::from(k)).exp2()));
    }
    ends.push(upper);
    ends
}

/// Lobatto points of `rule` on a range with their weights, on its parts towards `place` if there is
/// one, which is divided `halvings` times; ends of the range are theirs to the last bit.
pub fn lobatto_towards(
    range: (f64, f64),
    place: Option<f64>,
    halvings: u8,
    rule: &LobattoRule,
) -> Vec<(f64, f64)> {
    let ends = place.map_or_else(|| vec![range.0, range.1], |u| parts_towards(u, halvings, range));
    let last = rule.points.len() - 1;
    let mut along: Vec<(f64, f64)> = Vec::with_capacity(ends.len() * last);
    for part in ends.windows(2) {
        let half = 0.5 * (part[1] - part[0]);
        for (k, (x, w)) in rule.points.iter().zip(&rule.weights).enumerate() {
            let (u, weight) = match k {
                0 => (part[0], w * half),
                _ if k == last => (part[1], w * half),
                _ => (part[0] + half * (1.0 + x), w * half),
            };
            match along.last_mut() {
                // The common end of two parts.
                Some((_, before)) if k == 0 => *before += weight,
                _ => along.push((u, weight)),
            }
        }
    }
    along
}

/// Lobatto points on the side of an element with weights in parameters, on its parts towards
/// `place` if there is one; ends of elements are theirs to the last bit.
fn lobatto_on(
    side: &ElementSide,
    rules: &[LobattoRule],
    (place, halvings): (Option<[f64; 3]>, u8),
) -> Vec<([f64; 3], f64)> {
    let mut points = vec![(side.lower, 1.0)];
    for (d, rule) in side.face.directions().zip(rules) {
        let range = (side.lower[d], side.upper[d]);
        let along = lobatto_towards(range, place.map(|xi| xi[d]), halvings, rule);
        points = along
            .iter()
            .flat_map(|&(u, w)| {
                points.iter().map(move |&(mut xi, weight)| {
                    xi[d] = u;
                    (xi, weight * w)
                })
            })
            .collect();
    }
    points
}

/// Greville points of the functions of `space` on the faces, with their tributary areas.
///
/// A function that is tied (pole, seam, interface) gives one point. Where faces meet smoothly the
/// areas on both sides add up; at a sharp edge each face keeps a point with its own normal.
pub fn greville_points(space: &dyn SplineSpace, patches: &[Patch], faces: &[Face]) -> Vec<CollocationPoint> {
    let mut points: Vec<CollocationPoint> = Vec::new();
    let mut of_function: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    let mut scratch = PointBasis::default();
    for face in faces {
        let areas = tributary_areas(space, patches, face);
        let mut seen = BTreeSet::new();
        for (function, xi) in space.greville(face.id) {
            if !seen.insert(function) {
                continue; // a pole or seam within the face: its area is counted already
            }
            let area = areas.get(&function).copied().unwrap_or(0.0);
            let xi = face.on_face(&xi);
            let at = face.at(&patches[face.id.patch], &xi, &mut scratch);
            let known = of_function.entry(function).or_default();
            let undirected = |n: &[f64; 3]| norm(n) < 0.5; // a pole: nothing tells the faces apart
            let smooth = |&&i: &&usize| {
                let other = &points[i].normal;
                undirected(&at.normal) || undirected(other) || dot(other, &at.normal) > 1.0 - SMOOTH
            };
            if let Some(&i) = known.iter().find(smooth) {
                points[i].area += area;
                continue;
            }
            known.push(points.len());
            points.push(CollocationPoint {
                face: face.id,
                element: space.find_element(face.id.patch, &xi),
                xi,
                point: at.point,
                normal: at.normal,
                area,
                function: Some(function),
            });
        }
    }
    points
}

/// Normals whose cosine falls short of one by less than this (an angle of about 1e-4) belong to one
/// smooth surface.
const SMOOTH: f64 = 1e-8;

/// Gauss points of the side of element `e` with weights in parameters.
fn points_on(
    space: &dyn SplineSpace,
    face: &Face,
    e: usize,
    count: impl Fn(usize) -> usize,
) -> Vec<([f64; 3], f64)> {
    let element = space.element(e);
    let mut points = vec![(face.on_face(&[0.0; 3]), 1.0)];
    for d in face.directions() {
        let rule = GaussRule::new(count(d).clamp(1, MAX_GAUSS));
        let half = 0.5 * (element.upper[d] - element.lower[d]);
        let middle = 0.5 * (element.upper[d] + element.lower[d]);
        points = rule
            .points
            .iter()
            .zip(&rule.weights)
            .flat_map(|(x, w)| {
                points.iter().map(move |&(mut xi, weight)| {
                    xi[d] = middle + half * x;
                    (xi, weight * w * half)
                })
            })
            .collect();
    }
    points
}
