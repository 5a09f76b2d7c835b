//! Points at the end of a face, from which other faces of the target go on (docs/theory.md
//! Eqs. C.54, C.55).

use iga_core::nurbs::SAME_PLACE;
use iga_core::nurbs::jet::{difference, dot, norm};

use super::{Displaced, Functions, Projection, Samples, SurfacePlace};

/// Part of an element beside a seam in which normals go over from one face to the other: those of
/// the elements differ by what the elements err, so that a part of one is as good; a point on a
/// seam must not be pressed to either side in turn.
const BAND: f64 = 0.1;

impl Displaced<'_> {
    /// Way along the surface from the foot `found` to `point` at the gap `gap`: none but of a point that has gone a little beyond the end
    /// of a face, where its foot is held.
    pub fn beside_end(&self, found: &Projection, point: &[f64; 3], gap: f64) -> [f64; 3] {
        let (grid, xi) = (&self.surface.faces[found.place.face as usize], &found.place.xi);
        let is_at_end = |a: usize| {
            let [lower, upper] = grid.range(a);
            xi[a] <= lower || xi[a] >= upper
        };
        if !(0..self.surface.n_parameters).any(is_at_end) {
            return [0.0; 3];
        }
        let way = difference(point, &found.point);
        [0, 1, 2].map(|c| way[c] - gap * found.normal[c])
    }

    /// `found` with a normal that is continuous across seams: in a narrow band beside them it goes
    /// over from that of the face to the mean of all that meet there (C.55). The gap stays.
    pub fn across_seams(
        &self,
        found: Projection,
        samples: &mut Samples,
        is_sampled: &mut bool,
        functions: &mut Functions,
    ) -> Projection {
        let grid = &self.surface.faces[found.place.face as usize];
        let element = &self.surface.elements[found.element as usize];
        let mut blended = Projection { normal: self.at(&found.place, functions).normal, ..found };
        for a in 0..self.surface.n_parameters {
            let width = BAND * (element.upper[a] - element.lower[a]);
            for end in grid.range(a) {
                let share = (found.place.xi[a] - end).abs() / width;
                if share < 1.0 {
                    samples.update_once(*self, is_sampled);
                    let mut seam = found.place;
                    seam.xi[a] = end;
                    self.blend(&mut blended, &seam, share, samples, functions);
                }
            }
        }
        // Functions are those of the place.
        self.jet(&found.place, functions);
        blended
    }

    /// Brings the normal of `found`, at `share` of the band's width from the place `seam`, nearer
    /// to those of other faces there.
    fn blend(
        &self,
        found: &mut Projection,
        seam: &SurfacePlace,
        share: f64,
        samples: &Samples,
        functions: &mut Functions,
    ) {
        let point = self.jet(seam, functions).point;
        let round_off = SAME_PLACE * self.surface.size;
        let (mut sum, mut n) = ([0.0; 3], 0);
        for face in (0..self.surface.faces.len()).filter(|face| *face != seam.face as usize) {
            let there = self.closest_from(&samples.nearest_on(face, &point), &point, functions);
            if norm(&difference(&there.point, &point)) <= round_off {
                (0..3).for_each(|c| sum[c] += there.normal[c]);
                n += 1;
            }
        }
        let length = norm(&sum);
        if n > 0 && length > 0.0 {
            let [own, other] = [0.5 * (1.0 + share), 0.5 * (1.0 - share) / length];
            let normal: [f64; 3] = std::array::from_fn(|c| own * found.normal[c] + other * sum[c]);
            found.normal = normal.map(|x| x / norm(&normal));
        }
    }

    /// The closest place to `point` of all faces; `found`, beyond whose end the point lies, is that
    /// of its own face.
    ///
    /// A place on a seam is one of all faces that meet there. If all say that the point lies beyond
    /// their ends, it lies over the edge that the seam has become, or under it: then the mean of
    /// their normals tells the side. Displaced faces are continuous there, not smooth.
    pub fn on_joined_faces(
        &self,
        found: Projection,
        point: &[f64; 3],
        samples: &Samples,
        functions: &mut Functions,
    ) -> Projection {
        let own = found.place.face as usize;
        let others = (0..self.surface.faces.len()).filter(|face| *face != own);
        let mut all = vec![found];
        all.extend(others.map(|face| self.closest_from(&samples.nearest_on(face, point), point, functions)));
        let away = |p: &Projection| norm(&difference(point, &p.point));
        // The first of equal ones is the point's own.
        let least = all.iter().map(away).fold(f64::INFINITY, f64::min);
        let round_off = SAME_PLACE * self.surface.size;
        let nearest = all.iter().filter(|p| away(p) <= least + round_off);
        let inside = nearest.clone().find(|p| !p.is_beyond);
        let mut best = *inside.or_else(|| nearest.clone().next()).unwrap_or(&found);
        // Functions are those of the place.
        self.jet(&best.place, functions);
        if best.is_beyond {
            let joined =
                nearest.filter(|p| norm(&difference(&p.point, &best.point)) <= round_off).map(|p| p.normal);
            let (mut sum, mut n) = ([0.0; 3], 0);
            joined.for_each(|normal| {
                (0..3).for_each(|c| sum[c] += normal[c]);
                n += 1;
            });
            let length = norm(&sum);
            if n > 1 && length > 0.0 {
                best.normal = sum.map(|x| x / length);
                best.gap = dot(&difference(point, &best.point), &best.normal);
                best.is_beyond = false;
            }
        }
        best
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface_pair::target::{TargetFace, TargetSurface};
    use ffr_dynamics::body::RigidMotion;
    use iga_core::nurbs::Face;
    use iga_core::nurbs::{FaceId, Patch};
    use iga_core::space::PatchSpace;
    use iga_core::splines::knots::KnotVector;

    /// Slope of the tops on both sides of the valley.
    const SLOPE: f64 = 0.1;

    /// Two blocks side by side at x = 0, whose tops `z = 1 + SLOPE |x|` make a valley.
    fn valley() -> TargetSurface {
        let block = |left: f64, right: f64| {
            let top = |x: f64| 1.0 + SLOPE * x.abs();
            let layer = |is_top: bool| {
                let at = move |x: f64, y: f64| [x, y, if is_top { top(x) } else { 0.0 }];
                [at(left, 0.0), at(right, 0.0), at(left, 1.0), at(right, 1.0)]
            };
            let knots = vec![KnotVector::uniform(1, 1).expect("knots"); 3];
            Patch::new(knots, [layer(false), layer(true)].concat(), vec![1.0; 8]).expect("a block")
        };
        let patches = vec![block(-1.0, 0.0), block(0.0, 1.0)];
        let space = PatchSpace::new(patches.clone()).expect("a space");
        let faces: Vec<TargetFace> = (0..2)
            .map(|patch| FaceId { patch, direction: 2, upper: true })
            .map(|id| TargetFace::whole(Face::new(&patches, id, false), &patches))
            .collect();
        TargetSurface::rigid(RigidMotion::Spatial, &space, &patches, &faces).expect("a surface")
    }

    #[test]
    fn a_point_under_a_seam_lies_as_deep_as_it_is_away_and_normals_go_over_continuously() {
        let surface = valley();
        let displaced = Displaced { surface: &surface, nodes: &surface.nodes, normals: &[], slack: 0.0 };
        let (mut functions, mut samples) = (Functions::new(&surface), Samples::new(&surface));
        let mut is_sampled = false;
        let mut project = |x: f64, z: f64| {
            let point = [x, 0.4, z];
            samples.update_once(displaced, &mut is_sampled);
            let mut found = displaced.closest_from(&samples.nearest(&point), &point, &mut functions);
            if found.is_beyond {
                found = displaced.on_joined_faces(found, &point, &samples, &mut functions);
            }
            if !found.is_beyond {
                found = displaced.across_seams(found, &mut samples, &mut is_sampled, &mut functions);
            }
            found
        };
        // Below the valley no face has a foot of the point inside it.
        for x in [0.0, 1e-3, -2e-3] {
            let found = project(x, 0.95);
            assert!(
                !found.is_beyond && norm(&difference(&found.point, &[0.0, 0.4, 1.0])) < 1e-12,
                "{found:?}"
            );
            assert!((found.gap + 0.05).abs() < 1e-12 && (found.normal[2] - 1.0).abs() < 1e-12, "{found:?}");
            // The foot is held; the point slides on over it.
            let aside = displaced.beside_end(&found, &[x, 0.4, 0.95], found.gap);
            assert!(norm(&difference(&aside, &[x, 0.0, 0.0])) < 1e-12, "{aside:?}");
        }
        // Above it normals turn within a tenth of an element on either side, and are those of the
        // faces beyond.
        let lean = |x: f64| -SLOPE * x.signum() / (1.0 + SLOPE * SLOPE).sqrt();
        for x in [-0.5, -0.12, 0.12, 0.5] {
            let found = project(x, 1.0 + SLOPE * x.abs());
            assert!((found.normal[0] - lean(x)).abs() < 1e-12 && found.gap.abs() < 1e-12, "{found:?}");
            let aside = displaced.beside_end(&found, &[x, 0.4, 1.0 + SLOPE * x.abs()], found.gap);
            assert!(norm(&aside) < 1e-12, "{aside:?}");
        }
        let mut last = project(-0.11, 1.0 + 0.11 * SLOPE).normal;
        for k in -109..=110 {
            let x = 1e-3 * f64::from(k);
            let normal = project(x, 1.0 + SLOPE * x.abs()).normal;
            // From -SLOPE to SLOPE over two hundred steps, in proportion but for the unit length.
            assert!(norm(&difference(&normal, &last)) < 1.1e-2 * SLOPE, "{x}: {normal:?} {last:?}");
            last = normal;
        }
        // Beyond the valley's ends there is nothing.
        assert!(project(1.2, 1.0).is_beyond);
    }
}
