//! Contact points along a straight edge of the target that lies on a face of the contact body
//! (docs/theory.md Eq. C.97).

use iga_core::quadrature::LobattoRule;
use iga_core::surface::lobatto_towards;
use nalgebra::Vector3;

use crate::surface::{MeshSurface, Surface};
use crate::touch::tolerances::TOUCHED_SURFACE;

/// Samples of the edge between which ends of elements are looked for.
const SAMPLES: usize = 256;
/// How far aside points are left out, in halves of the width over which it presses: where elements do not yield under it, a round partner would
/// press what lies nearer than some 2.5 of them (the square root of its approach over that of a unit of the logarithm).
const BESIDE: f64 = 4.0;
/// Halvings of the way between two samples in the search for the end of an element: far below the
/// part of it that a rule's weights see.
const HALVINGS: usize = 20;
/// How far aside elements are looked for, as a share of the body's size: along a row's end round-off
/// would tell them apart.
const ASIDE: f64 = 1e-6;
/// Points of the rule on each part: it is exact for the quadratic functions of most elements.
const POINTS: usize = 3;
/// Cosine of the angle between normals of faces that are turned to the same partner.
const SAME_SIDE: f64 = 0.5;

/// A straight edge of the target along a face of the undeformed contact body, or one of this, in its frame \[m\].
pub struct MetEdge {
    /// The middle of the part that lies on the face.
    pub middle: Vector3<f64>,
    /// From there to its end.
    pub half: Vector3<f64>,
    /// Half of the width over which it presses \[m\].
    pub spread: f64,
    /// Unit vector out of the contact body if it is an edge of this itself, on the target.
    pub outward: Option<Vector3<f64>>,
}

impl MetEdge {
    /// Its place at the share `share` of its half from the middle.
    pub fn at(&self, share: f64) -> [f64; 3] {
        (self.middle + share * self.half).into()
    }

    /// Distance of `point` from it \[m\].
    pub fn distance(&self, point: &[f64; 3]) -> f64 {
        let from_middle = Vector3::from(*point) - self.middle;
        let share = from_middle.dot(&self.half) / self.half.norm_squared();
        (from_middle - share.clamp(-1.0, 1.0) * self.half).norm()
    }

    /// The sides of `surface` under it, and those of which a corner is no farther aside than `reach` \[m\].
    pub fn sides(&self, surface: &MeshSurface, reach: f64) -> Vec<u32> {
        let under = (0..=SAMPLES).filter_map(|k| surface.nearest(&self.at(sample(k))));
        let under = under.flat_map(|foot| surface.sides_at(&foot.place)).map(|at| at.face);
        let beside = (0..surface.sides().len() as u32).filter(|&i| {
            let nodes = surface.sides()[i as usize].nodes.iter();
            nodes
                .map(|&n| self.distance(&surface.mesh().nodes()[n as usize]))
                .any(|distance| distance <= reach)
        });
        under.chain(beside).collect()
    }

    /// Whether a point with the normal `normal` stands on it, where the face has the normal `own`, or
    /// beside it by no more than a body of the size `size` yields: the faces of the target beside
    /// the edge would press it aside. Of an own edge whatever the normal.
    pub fn holds(&self, point: &[f64; 3], normal: &[f64; 3], own: &[f64; 3], size: f64) -> bool {
        self.distance(point) <= (TOUCHED_SURFACE * size).max(BESIDE * self.spread)
            && (self.outward.is_some() || Vector3::from(*normal).dot(&Vector3::from(*own)) > SAME_SIDE)
    }

    /// Puts points along it, on a face with the normal `own` of a body of the size `size`, in place of those of `points` that stand
    /// there; their indices and shares of its half. `of` tells place, normal and area of a point, `element` is as in
    /// [`MetEdge::points`], and `stand` makes a point of a place and an area, if the body has that place.
    pub fn replace<P>(
        &self,
        points: &mut Vec<P>,
        (own, size): (&[f64; 3], f64),
        of: impl Fn(&P) -> ([f64; 3], [f64; 3], f64),
        element: impl Fn([f64; 3]) -> Option<usize>,
        stand: impl Fn([f64; 3], f64) -> Option<P>,
    ) -> Vec<(usize, f64)> {
        points.retain(|point| {
            let (place, normal, _) = of(point);
            !self.holds(&place, &normal, own, size)
        });
        let largest = points.iter().map(|point| of(point).2).fold(0.0, f64::max);
        let mut meeting = Vec::new();
        for (share, weight) in self.points(own, size, element) {
            if let Some(point) = stand(self.at(share), weight * largest) {
                meeting.push((points.len(), share));
                points.push(point);
            }
        }
        meeting
    }

    /// Places along it as shares of its half, and their parts of its length over the largest one:
    /// Lobatto points between the ends of elements, which `element` numbers at a point, of a face
    /// with the normal `own`.
    pub fn points(
        &self,
        own: &[f64; 3],
        size: f64,
        element: impl Fn([f64; 3]) -> Option<usize>,
    ) -> Vec<(f64, f64)> {
        let across = Vector3::from(*own).cross(&self.half).try_normalize(0.0).unwrap_or_default();
        // Beside an own edge lies a face on one side only.
        let is_beyond = self.outward.is_some_and(|outward| across.dot(&outward) > 0.0);
        let across = if is_beyond { -across } else { across };
        let element = |share: f64| element((Vector3::from(self.at(share)) + ASIDE * size * across).into());
        let mut ends = vec![-1.0];
        for k in 0..SAMPLES {
            let (mut before, mut after) = (sample(k), sample(k + 1));
            let here = element(before);
            if element(after) == here {
                continue;
            }
            for _ in 0..HALVINGS {
                let middle = 0.5 * (before + after);
                if element(middle) == here { before = middle } else { after = middle }
            }
            ends.push(after);
        }
        // An end within round-off of that of the edge is this.
        ends.retain(|end| *end < 1.0 - ASIDE);
        ends.push(1.0);
        let rule = LobattoRule::new(POINTS);
        let mut points: Vec<(f64, f64)> = Vec::new();
        for part in ends.windows(2) {
            for (share, weight) in lobatto_towards((part[0], part[1]), None, 0, &rule) {
                match points.last_mut().filter(|(last, _)| share <= *last) {
                    Some((_, before)) => *before += weight,
                    None => points.push((share, weight)),
                }
            }
        }
        let largest = points.iter().map(|p| p.1).fold(f64::MIN_POSITIVE, f64::max);
        points.iter_mut().for_each(|(_, weight)| *weight /= largest);
        points
    }
}

/// Place of sample `k`, as a share of the half of an edge.
fn sample(k: usize) -> f64 {
    2.0 * k as f64 / SAMPLES as f64 - 1.0
}

#[cfg(test)]
mod tests {
    use super::*;

    const EDGE: [f64; 2] = [0.3, 0.1];
    /// Ends of elements along x, and where along y a row of them ends.
    const ENDS: [f64; 4] = [0.21, 0.27, 0.333, 0.395];

    fn edge() -> MetEdge {
        MetEdge {
            middle: Vector3::new(EDGE[0], 0.0, 0.0),
            half: Vector3::new(EDGE[1], 0.0, 0.0),
            spread: 0.0,
            outward: None,
        }
    }

    /// A row ends along the edge itself, where round-off says on which side a place is.
    fn element([x, y, _]: [f64; 3]) -> Option<usize> {
        Some(2 * ENDS.iter().filter(|end| x > **end).count() + usize::from(y > 0.0))
    }

    #[test]
    fn loads_of_quadratic_functions_of_each_element_are_exact() {
        let points = edge().points(&[0.0, 0.0, 1.0], 1.0, element);
        // Three points on each of five parts, of which neighbours share their ends.
        assert_eq!(points.len(), 11);
        assert!(points.windows(2).all(|pair| pair[0].0 < pair[1].0) && points.iter().all(|p| p.1 <= 1.0));
        let mean = |f: &dyn Fn(f64) -> f64| {
            let sum: f64 = points.iter().map(|(share, weight)| weight * f(edge().at(*share)[0])).sum();
            sum / points.iter().map(|p| p.1).sum::<f64>()
        };
        // The square of the way beyond the end of an element has its kink there.
        for end in ENDS {
            let (from, to) = (EDGE[0] - EDGE[1], EDGE[0] + EDGE[1]);
            let exact = (to - end).powi(3) / 3.0 / (to - from);
            let found = mean(&|x| (x - end).max(0.0).powi(2));
            // Ends are found to 2^-28 of the edge.
            assert!((found / exact - 1.0).abs() < 1e-6, "{end}: {found:e} {exact:e}");
        }
    }

    #[test]
    fn points_beside_the_edge_are_its_own_where_they_face_the_same_way() {
        let up = [0.0, 0.0, 1.0];
        let near = 0.5 * TOUCHED_SURFACE;
        for (point, normal, expected) in [
            ([0.3, 0.0, 0.0], up, true),
            ([0.25, near, 0.0], up, true),
            ([0.4 + near, 0.0, 0.0], up, true),
            ([0.25, 4.0 * near, 0.0], up, false),
            ([0.4 + 4.0 * near, 0.0, 0.0], up, false),
            ([0.4, 0.0, 0.0], [1.0, 0.0, 0.0], false), // of the side face that meets it there
        ] {
            assert_eq!(edge().holds(&point, &normal, &up, 1.0), expected, "{point:?} {normal:?}");
        }
    }
}
