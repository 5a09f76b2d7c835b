//! Meeting points: places on an edge or a corner of the target, which have no normal by themselves
//! and get the one of the touch, where edges cross or where a corner or an edge of the target
//! touches the contact body, at one place or along a straight line (docs/theory.md Eqs. C.63, C.97).

use ffr_dynamics::data_error::DataError;
use iga_core::nurbs::jet::{difference, dot, norm};

use super::{Displaced, Functions, Projection, Samples, SurfacePlace};
use crate::ContactError;
use crate::surface_pair::{SurfacePair, TargetSurface};

/// Distance from the place within which points meet the plane, as a share of the target's size;
/// further away curved edges have left the plane.
const REACH: f64 = 0.02;
/// Error of the length of a unit vector: round-off.
const UNIT: f64 = 1e-9;

/// Points of the contact body that meet one place of the target each. For them the surface of the
/// target is the plane through that place.
#[derive(Debug, Clone, PartialEq)]
pub struct MeetingPoint {
    /// Indices of the points, ascending, and how far from `place` the undeformed target has the place
    /// that each of them meets, in the components of its model \[m\].
    pub points: Vec<(usize, [f64; 3])>,
    /// A place on the target, its face counted as they were given to [`crate::surface_pair::TargetSurface`].
    pub place: SurfacePlace,
    /// Unit normal towards the contact body, in the components of the target's model.
    pub normal: [f64; 3],
}

impl MeetingPoint {
    /// The same with the place of each point on the undeformed `surface`.
    fn on(self, surface: &TargetSurface) -> MetPlanes {
        let mut functions = Functions::new(surface);
        let undeformed = Displaced { surface, nodes: &surface.nodes, normals: &[], slack: 0.0 };
        let mut samples = Samples::new(surface);
        samples.update(undeformed);
        let start = undeformed.jet(&self.place, &mut functions).point;
        let mut place_at = |aside: [f64; 3]| {
            let there = std::array::from_fn(|c| start[c] + aside[c]);
            let is_start = norm(&aside) == 0.0;
            let mut found = || undeformed.on_all_faces(&there, (None, None), &samples, &mut functions).place;
            if is_start { self.place } else { found() }
        };
        let points = self.points.iter().map(|(i, aside)| (*i, place_at(*aside))).collect();
        MetPlanes { points, normal: self.normal }
    }
}

/// The same with the place of each point.
pub(in crate::surface_pair) struct MetPlanes {
    points: Vec<(usize, SurfacePlace)>,
    normal: [f64; 3],
}

impl MetPlanes {
    /// Projection of the point `x` on the plane through the displaced `place`, whose functions are
    /// left in `functions`; none of a point that has slid too far from it.
    fn project(
        &self,
        place: SurfacePlace,
        displaced: Displaced<'_>,
        x: &[f64; 3],
        functions: &mut Functions,
    ) -> Option<Projection> {
        let jet = displaced.jet(&place, functions);
        let away = difference(x, &jet.point);
        let gap = dot(&away, &self.normal);
        let along: [f64; 3] = std::array::from_fn(|c| away[c] - gap * self.normal[c]);
        let is_near = norm(&along) <= REACH * displaced.surface.size;
        is_near.then_some(Projection {
            place,
            element: jet.element,
            point: along,
            normal: self.normal,
            gap,
            is_on_plane: true,
            ..Projection::default()
        })
    }
}

impl SurfacePair {
    /// Lets the points of `meeting` meet the planes through their places in place of the surface, as
    /// long as they are near them.
    ///
    /// # Errors
    /// [`ContactError::Data`] if a point or the face does not exist, [`ContactError::Nothing`] without a unit normal.
    pub fn with_meeting_point(mut self, meeting: MeetingPoint) -> Result<Self, ContactError> {
        let check = |what: &str, number: usize, count: usize| match number < count {
            true => Ok(()),
            false => Err(DataError::Index { what: what.into(), number, count }),
        };
        meeting.points.iter().try_for_each(|(i, _)| check("points that meet", *i, self.points.len()))?;
        check("faces of the target", meeting.place.face as usize, self.surface.faces.len())?;
        let error = (norm(&meeting.normal) - 1.0).abs();
        if error.is_nan() || error > UNIT {
            return Err(ContactError::Nothing { what: "a place without a normal" });
        }
        self.meeting = Some(meeting.on(&self.surface));
        Ok(self)
    }

    /// Projection of the point `i` at `x` on the plane that it meets; none of one that meets the
    /// surface.
    pub(in crate::surface_pair) fn on_meeting_plane(
        &self,
        i: usize,
        x: &[f64; 3],
        displaced: Displaced<'_>,
        functions: &mut Functions,
    ) -> Option<Projection> {
        let meeting = self.meeting.as_ref()?;
        let k = meeting.points.binary_search_by_key(&i, |(i, _)| *i).ok()?;
        meeting.project(meeting.points[k].1, displaced, x, functions)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface_pair::target::cube;

    #[test]
    fn points_along_an_edge_meet_planes_through_their_own_places() {
        let surface = cube();
        // The edge along z at x = y = 1, met in its middle on the face x = 1, whose parameters are y and z.
        let normal = [0.5_f64.sqrt(), 0.5_f64.sqrt(), 0.0];
        let shares = [-0.5, -0.2, 0.0, 0.37];
        let points = shares.iter().enumerate().map(|(i, z)| (2 * i, [0.0, 0.0, *z])).collect();
        let met =
            MeetingPoint { points, place: SurfacePlace { face: 1, xi: [1.0, 0.5] }, normal }.on(&surface);
        let displaced = Displaced { surface: &surface, nodes: &surface.nodes, normals: &[], slack: 0.0 };
        let mut functions = Functions::new(&surface);
        for ((i, place), (k, z)) in met.points.iter().zip(shares.iter().enumerate()) {
            let y = displaced.jet(place, &mut functions).point;
            // Places of a search are found to the root of round-off along the surface.
            let there = [1.0, 1.0, 0.5 + z];
            assert!(*i == 2 * k && norm(&difference(&y, &there)) < 1e-7, "{y:?} {there:?}");
            // A point over the edge there is as far from it as from its plane, one that has slid on meets faces.
            let over = std::array::from_fn(|c| there[c] + 0.01 * normal[c]);
            let found = met.project(*place, displaced, &over, &mut functions).expect("it is near");
            assert!(
                (found.gap - 0.01).abs() < 1e-9 && norm(&difference(&found.normal, &normal)) < 1e-15,
                "{found:?}"
            );
            let away = [over[0], over[1], over[2] + 0.1];
            assert!(met.project(*place, displaced, &away, &mut functions).is_none());
        }
    }
}
