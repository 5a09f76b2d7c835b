//! Projection on all faces of a body, edges and corners included where they press (docs/theory.md
//! Eqs. C.57 to C.59, C.76).

use iga_core::nurbs::jet::{difference, norm};
use nalgebra::Vector3;

use super::proximity_cache::square;
use super::{Displaced, Functions, Projection, Samples, SurfacePlace};
use crate::search::boxes::Bounds;
use crate::surface_pair::target::FaceGrid;
use crate::zone::submodel::is_turned_to;

/// Outward normal of a point's own face in the target's components; none of points that any surface
/// can press.
type Facing<'a> = Option<&'a [f64; 3]>;

/// Times as deep as below the nearest face a point may lie below the face that presses it
/// (Eq. C.58): points along an edge that deepen by less than this part of what they are away from
/// it.
const DEEPER: f64 = 10.0;
/// Points of the net of a piece of a side of a mesh, of degree two, at most.
const MOST_POINTS: usize = 9;

impl Displaced<'_> {
    /// Projection of `point`, whose own face has the outward normal `facing` in the target's
    /// components, on all faces, of which `samples` has the displaced places; `known`: its projection on one of them.
    ///
    /// The nearest point of the surface says whether the point is outside. If it is inside, or over
    /// an edge by no more than the target's overhang, the nearest face presses it that lies below
    /// it, no deeper than the surface reaches and than (C.58) allows, and is turned to its own
    /// face; without one it is open.
    pub fn on_all_faces(
        &self,
        point: &[f64; 3],
        (known, facing): (Option<&Projection>, Facing<'_>),
        samples: &Samples,
        functions: &mut Functions,
    ) -> Projection {
        let overhang = self.surface.overhang();
        let sampled = |functions: &mut _| self.closest_from(&samples.nearest(point), point, functions);
        let known = known.copied().unwrap_or_else(|| sampled(functions));
        let mut limit = self.farthest_that_counts(&known, point);
        let found = loop {
            let found = self.on_faces_within(limit, point, (&known, facing), samples, functions);
            let needed = found.map_or(limit, |(nearest, _)| self.farthest_that_counts(&nearest, point));
            // Asked this way round, a NaN ends it.
            if needed > limit { limit = needed } else { break found }
        };
        let Some((nearest, pressing)) = found else {
            return Projection { gap: f64::NAN, ..Projection::default() };
        };
        let distance = norm(&difference(point, &nearest.point));
        // A point that lies deep below the one face and shallow below another came in through that.
        let deepest = overhang.max(DEEPER * distance);
        let pressing = pressing.filter(|found| found.gap.abs() <= deepest);
        let best = match pressing {
            Some(found)
                if !self.is_outside(&nearest, distance) || (found.gap - distance).abs() <= overhang =>
            {
                found
            }
            _ => Projection { is_beyond: true, ..nearest },
        };
        // Functions are those of the place, not of the face looked at last.
        self.jet(&best.place, functions);
        best
    }

    /// Of the faces no farther from `point` than `limit`: the nearest place, and that of the face which presses it, if one may; none without
    /// such faces.
    fn on_faces_within(
        &self,
        limit: f64,
        point: &[f64; 3],
        (known, facing): (&Projection, Facing<'_>),
        samples: &Samples,
        functions: &mut Functions,
    ) -> Option<(Projection, Option<Projection>)> {
        let reach = self.surface.edges.map_or(f64::INFINITY, |e| e.reach);
        let mut nearest: Option<(f64, Projection)> = None;
        let mut pressing: Option<(f64, Projection)> = None;
        for (face, grid) in self.surface.faces.iter().enumerate() {
            let is_far = square(point, samples.middle(face)) > (grid.reach + limit).powi(2);
            if is_far || self.distance_of_net(face, point) > limit {
                continue;
            }
            // A large face may be nearer elsewhere.
            let mut found = if known.place.face as usize == face && grid.reach.is_finite() {
                *known
            } else {
                self.closest_from(&samples.nearest_on(face, point), point, functions)
            };
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
        Some((nearest?.1, pressing.map(|(_, found)| found)))
    }

    /// Whether a point is outside whose nearest place, `distance` away, is `nearest`.
    fn is_outside(&self, nearest: &Projection, distance: f64) -> bool {
        (nearest.is_beyond || nearest.gap > 0.0) && distance > self.surface.overhang()
    }

    /// Distance beyond which a face neither is the nearest one to `point` nor may press it, if `found` is its nearest place: what presses one
    /// outside has that distance as its gap, what presses one inside (C.58), both but for the overhang, by which its foot may lie beyond both
    /// ends of the face; unbounded where faces are few and large.
    fn farthest_that_counts(&self, found: &Projection, point: &[f64; 3]) -> f64 {
        if self.surface.faces.iter().any(|grid| grid.reach.is_infinite()) {
            return f64::INFINITY;
        }
        let (distance, overhang) = (norm(&difference(point, &found.point)), self.surface.overhang());
        let gap = if self.is_outside(found, distance) { distance } else { overhang.max(DEEPER * distance) };
        gap + 3.0 * overhang
    }

    /// Least distance of `point` from the displaced net of face `face`, and so from the face: from the box around it, and beyond the
    /// planes through its four sides; zero of a face of many elements.
    fn distance_of_net(&self, face: usize, point: &[f64; 3]) -> f64 {
        let FaceGrid { cells, degrees: [p, q], .. } = &self.surface.faces[face];
        let (n, n_points) = (p + 1, (p + 1) * (q + 1));
        let mut net = [Vector3::zeros(); MOST_POINTS];
        let (&[element], true) = (cells.as_slice(), n_points <= MOST_POINTS) else { return 0.0 };
        let (element, net) = (&self.surface.elements[element as usize], &mut net[..n_points]);
        for (&node, row) in element.nodes.iter().zip(element.coefficients.chunks_exact(n_points)) {
            let place = Vector3::from(self.nodes[node as usize]);
            net.iter_mut().zip(row).for_each(|(x, c)| *x += *c * place);
        }
        let point = Vector3::from(*point);
        let corners = [0, *p, n_points - 1, n_points - n].map(|k| net[k]);
        let normal = (corners[2] - corners[0]).cross(&(corners[3] - corners[1]));
        let beyond = (0..4).filter_map(|k| {
            let outward = (corners[(k + 1) % 4] - corners[k]).cross(&normal).try_normalize(0.0)?;
            Some(net.iter().map(|x| outward.dot(&(point - x))).fold(f64::INFINITY, f64::min))
        });
        beyond.fold(Bounds::around(net.iter().copied()).distance_to(&point), f64::max)
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
                        true => displaced.on_all_faces(
                            &point,
                            (None, Some(&[0.0, 0.0, -1.0])),
                            &samples,
                            &mut functions,
                        ),
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
    fn a_net_is_no_farther_than_its_face() {
        let surface = cube();
        let displaced = Displaced { surface: &surface, nodes: &surface.nodes, normals: &[], slack: 0.0 };
        let mut functions = Functions::new(&surface);
        let middle = SurfacePlace { face: 0, xi: [0.5; 2] };
        let centre = displaced.jet(&middle, &mut functions);
        let [t, s] = centre.tangents.map(Vector3::from);
        let out = t.cross(&s).normalize();
        // Beside a side of the unit square, off its plane, and over it.
        for (way, wanted) in
            [((t + s).normalize() * 2.0, 2.0 * 0.5_f64.sqrt() - 0.5), (0.3 * out, 0.3), (0.2 * t, 0.0)]
        {
            let point = (Vector3::from(centre.point) + way).into();
            let found = displaced.closest_from(&middle, &point, &mut functions);
            let (net, face) = (displaced.distance_of_net(0, &point), norm(&difference(&found.point, &point)));
            // Sums of terms of order one.
            assert!(net <= face + 1e-14 && net >= wanted - 1e-14, "{net} {face} {wanted}");
        }
    }

    #[test]
    fn faces_that_are_not_looked_at_change_nothing() {
        let all = cube().with_edges(0.02, None);
        let mut near = cube().with_edges(0.02, None);
        near.faces.iter_mut().for_each(|face| face.reach = 2.0_f64.sqrt());
        let along = [-0.7, -0.011, -1e-3, 0.0, 0.003, 0.15, 0.5, 0.93, 1.0, 1.015, 1.3];
        let places = along.iter().flat_map(|x| along.iter().flat_map(move |y| along.map(|z| [*x, *y, z])));
        let facings = [None, Some([0.0, 0.0, -1.0]), Some([-0.6, 0.8, 0.0]), Some([1.0, 0.0, 0.0])];
        let mut functions = Functions::new(&all);
        let mut n_pressed = 0;
        for point in places {
            for facing in &facings {
                let [wanted, found] = [&all, &near].map(|surface| {
                    let displaced = Displaced { surface, nodes: &surface.nodes, normals: &[], slack: 0.0 };
                    let mut samples = Samples::new(surface);
                    samples.update(displaced);
                    displaced.on_all_faces(&point, (None, facing.as_ref()), &samples, &mut functions)
                });
                n_pressed += usize::from(!wanted.is_beyond);
                assert_eq!(wanted.is_beyond, found.is_beyond, "{point:?} {facing:?}: {wanted:?} {found:?}");
                // Round-off of places of order one.
                assert!((wanted.gap - found.gap).abs() < 1e-14, "{point:?} {facing:?}: {wanted:?} {found:?}");
            }
        }
        assert!(n_pressed > 500, "{n_pressed}");
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
                let found = displaced.on_all_faces(&point, (None, None), &samples, &mut functions);
                let jet = displaced.jet_of(found.element, &functions);
                // Sums of four terms of order one.
                assert!((found.gap - 0.01).abs() < 1e-14, "{found:?}");
                assert!(norm(&difference(&jet.point, &found.point)) < 1e-14, "{found:?} {jet:?}");
            }
        }
    }
}
