//! Meeting points: places on an edge or a corner of the target, which have no normal by themselves
//! and get the one of the touch, where edges cross or where a corner or an edge of the target
//! touches the contact body (docs/theory.md Eq. C.63).

use ffr_dynamics::data_error::DataError;
use iga_core::nurbs::jet::{difference, dot, norm};

use super::{Displaced, Functions, Projection, SurfacePlace};
use crate::ContactError;
use crate::surface_pair::SurfacePair;

/// Distance from the place within which points meet the plane, as a share of the target's size;
/// further away curved edges have left the plane.
const REACH: f64 = 0.02;
/// Error of the length of a unit vector: round-off.
const UNIT: f64 = 1e-9;

/// Points of the contact body that meet one place of the target. For them the surface of the target
/// is the plane through that place.
#[derive(Debug, Clone, PartialEq)]
pub struct MeetingPoint {
    /// Indices of the points, which stand in one place.
    pub points: Vec<usize>,
    /// The place on the target, its face counted as they were given to [`crate::surface_pair::TargetSurface`].
    pub place: SurfacePlace,
    /// Unit normal towards the contact body, in the components of the target's model.
    pub normal: [f64; 3],
}

impl MeetingPoint {
    /// Projection of the point `x` on the plane through the displaced place, whose functions are
    /// left in `functions`; none of a point that has slid too far from it.
    pub(super) fn project(
        &self,
        displaced: Displaced<'_>,
        x: &[f64; 3],
        functions: &mut Functions,
    ) -> Option<Projection> {
        let jet = displaced.jet(&self.place, functions);
        let away = difference(x, &jet.point);
        let gap = dot(&away, &self.normal);
        let along: [f64; 3] = std::array::from_fn(|c| away[c] - gap * self.normal[c]);
        let is_near = norm(&along) <= REACH * displaced.surface.size;
        is_near.then_some(Projection {
            place: self.place,
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
    /// Lets the points of `meeting` meet the plane through its place in place of the surface, as
    /// long as they are near it.
    ///
    /// # Errors
    /// [`ContactError::Data`] if a point or the face does not exist, [`ContactError::Nothing`] without a unit normal.
    pub fn with_meeting_point(mut self, meeting: MeetingPoint) -> Result<Self, ContactError> {
        let check = |what: &str, number: usize, count: usize| match number < count {
            true => Ok(()),
            false => Err(DataError::Index { what: what.into(), number, count }),
        };
        meeting.points.iter().try_for_each(|i| check("points that meet", *i, self.points.len()))?;
        check("faces of the target", meeting.place.face as usize, self.surface.faces.len())?;
        let error = (norm(&meeting.normal) - 1.0).abs();
        if error.is_nan() || error > UNIT {
            return Err(ContactError::Nothing { what: "a place without a normal" });
        }
        self.meeting = Some(meeting);
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
        let meeting = self.meeting.as_ref().filter(|meeting| meeting.points.contains(&i))?;
        meeting.project(displaced, x, functions)
    }
}
