//! Projection on all faces of a body, edges and corners included where they press (docs/theory.md
//! Eqs. C.57 to C.59, C.76).

use iga_core::nurbs::jet::{difference, norm};

use super::{Displaced, Functions, Projection, Samples, SurfacePlace};
use crate::zone::submodel::is_turned_to;

/// Outward normal of a point's own face in the target's components; none of points that any surface
/// can press.
type Facing<'a> = Option<&'a [f64; 3]>;

/// Times as deep as below the nearest face a point may lie below the face that presses it
/// (Eq. C.58): points along an edge that deepen by less than this part of what they are away from
/// it.
const DEEPER: f64 = 10.0;

impl Displaced<'_> {
    /// Projection of `point`, whose own face has the outward normal `facing` in the target's
    /// components, on all faces, of which `samples` has the displaced places.
    ///
    /// The nearest point of the surface says whether the point is outside. If it is inside, or over
    /// an edge by no more than the target's overhang, the nearest face presses it that lies below
    /// it, no deeper than the surface reaches and than (C.58) allows, and is turned to its own
    /// face; without one it is open.
    pub fn on_all_faces(
        &self,
        point: &[f64; 3],
        facing: Facing<'_>,
        samples: &Samples,
        functions: &mut Functions,
    ) -> Projection {
        let (overhang, reach) =
            (self.surface.overhang(), self.surface.edges.map_or(f64::INFINITY, |e| e.reach));
        let mut nearest: Option<(f64, Projection)> = None;
        let mut pressing: Option<(f64, Projection)> = None;
        let limit = self.farthest_that_counts(point, samples, functions);
        for (face, grid) in self.surface.faces.iter().enumerate() {
            let (start, sampled) = samples.nearest_on(face, point);
            if sampled - grid.reach > limit {
                continue;
            }
            let mut found = self.closest_from(&start, point, functions);
            if found.is_beyond
                && let Some(other) = self.across_seam(&found.place, &found.point, functions)
            {
                found = self.closest_from(&other, point, functions);
            }
            let distance = norm(&difference(point, &found.point));
            if is_less(distance, &nearest) {
                nearest = Some((distance, found));
            }
            let is_near = found.gap > -reach;
            if is_near && self.may_stand(&found, facing) && is_less(found.gap.abs(), &pressing) {
                pressing = Some((found.gap.abs(), found));
            }
        }
        let (Some((distance, nearest)), pressing) = (nearest, pressing.map(|(_, found)| found)) else {
            return Projection { gap: f64::NAN, ..Projection::default() };
        };
        // A point that lies deep below the one face and shallow below another came in through that.
        let deepest = overhang.max(DEEPER * distance);
        let pressing = pressing.filter(|found| found.gap.abs() <= deepest);
        let is_outside = (nearest.is_beyond || nearest.gap > 0.0) && distance > overhang;
        let best = match pressing {
            Some(found) if !is_outside || (found.gap - distance).abs() <= overhang => found,
            _ => Projection { is_beyond: true, ..nearest },
        };
        // Functions are those of the place, not of the face looked at last.
        self.jet(&best.place, functions);
        best
    }

    /// Distance beyond which a face neither is the nearest one to `point` nor may press it
    /// (Eq. C.58); unbounded where faces are few and large.
    fn farthest_that_counts(&self, point: &[f64; 3], samples: &Samples, functions: &mut Functions) -> f64 {
        if self.surface.faces.iter().any(|grid| grid.reach.is_infinite()) {
            return f64::INFINITY;
        }
        let found = self.closest_from(&samples.nearest(point), point, functions);
        let distance = norm(&difference(point, &found.point));
        self.surface.overhang().max(DEEPER * distance)
    }

    /// The other end of a face that ends in `place` at `point`, if the face is closed there.
    pub fn across_seam(
        &self,
        place: &SurfacePlace,
        point: &[f64; 3],
        functions: &mut Functions,
    ) -> Option<SurfacePlace> {
        let grid = &self.surface.faces[place.face as usize];
        (0..self.surface.n_parameters).find_map(|a| {
            let ([low, high], mut other) = (grid.range(a), *place);
            other.xi[a] = if place.xi[a] <= low { high } else { low };
            let there = self.jet(&other, functions).point;
            let is_end = place.xi[a] <= low || place.xi[a] >= high;
            (is_end && norm(&difference(&there, point)) <= self.surface.round_off()).then_some(other)
        })
    }

    /// Whether a projection found from the place before may stand: over a face that is turned to
    /// the point's own.
    pub fn may_stand(&self, found: &Projection, facing: Facing<'_>) -> bool {
        !found.is_beyond && facing.is_none_or(|facing| is_turned_to(facing, &found.normal))
    }
}

fn is_less(distance: f64, best: &Option<(f64, Projection)>) -> bool {
    best.is_none_or(|(least, _)| distance < least)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface_pair::target::{TargetFace, TargetSurface, cube};
    use ffr_dynamics::body::RigidMotion;
    use iga_core::nurbs::primitives::solid;
    use iga_core::nurbs::{Face, FaceId};
    use iga_core::space::PatchSpace;

    #[test]
    fn points_beside_a_disc_are_outside_at_every_angle() {
        // The net of the disc has no tangent across the rim at four places, 45° from the axes.
        let patches = solid::cylinder(1.0, 1.0).expect("a cylinder").patches;
        let space = PatchSpace::new(patches.clone()).expect("a space");
        let id = |k: usize| FaceId { patch: 0, direction: k / 2, upper: k % 2 == 1 };
        let faces = |which: std::ops::Range<usize>| -> Vec<TargetFace> {
            which.map(|k| TargetFace::whole(Face::new(&patches, id(k), false), &patches)).collect()
        };
        let rigid =
            |faces: &[TargetFace]| TargetSurface::rigid(RigidMotion::Spatial, &space, &patches, faces);
        let whole = rigid(&faces(0..6)).expect("a surface").with_edges(3e-4, None);
        let end = rigid(&faces(5..6)).expect("a surface");
        for (surface, is_whole) in [(&whole, true), (&end, false)] {
            let displaced = Displaced { surface, nodes: &surface.nodes, normals: &[], slack: 0.0 };
            let (mut functions, mut samples) = (Functions::new(surface), Samples::new(surface));
            samples.update(displaced);
            for k in 0..72 {
                let (sin, cos) = (f64::from(k) * std::f64::consts::TAU / 72.0).sin_cos();
                for radius in [0.3, 0.98, 1.02, 1.4] {
                    let point = [radius * cos, radius * sin, 0.99];
                    let found = match is_whole {
                        true => {
                            displaced.on_all_faces(&point, Some(&[0.0, 0.0, -1.0]), &samples, &mut functions)
                        }
                        false => displaced.closest_from(&samples.nearest(&point), &point, &mut functions),
                    };
                    let depth = found.distance(&point);
                    assert_eq!(depth < 0.0, radius < 1.0, "{k} {radius} {found:?}");
                    // Below the end, beside the jacket, beside the rim of the end alone.
                    let right = match (radius < 1.0, is_whole) {
                        (true, _) => -0.01,
                        (false, true) => radius - 1.0,
                        (false, false) => (radius - 1.0).hypot(0.01),
                    };
                    assert!((depth - right).abs() < 1e-9, "{k} {radius} {depth} {right}");
                }
            }
        }
    }

    #[test]
    fn functions_after_a_search_on_all_faces_are_those_of_the_place_found() {
        let surface = cube();
        let displaced = Displaced { surface: &surface, nodes: &surface.nodes, normals: &[], slack: 0.0 };
        let (mut functions, mut samples) = (Functions::new(&surface), Samples::new(&surface));
        samples.update(displaced);
        for direction in 0..3 {
            for height in [-0.01, 1.01] {
                let mut point = [0.3, 0.4, 0.45];
                point[direction] = height;
                let found = displaced.on_all_faces(&point, None, &samples, &mut functions);
                let jet = displaced.jet_of(found.element, &functions);
                // Sums of four terms of order one.
                assert!((found.gap - 0.01).abs() < 1e-14, "{found:?}");
                assert!(norm(&difference(&jet.point, &found.point)) < 1e-14, "{found:?} {jet:?}");
            }
        }
    }
}
