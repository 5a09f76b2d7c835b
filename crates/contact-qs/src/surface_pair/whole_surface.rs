//! Projection on the whole surface of a body, edges and corners included (docs/theory.md Eqs. C.53, C.54).

use iga_core::nurbs::jet::{difference, norm};

use super::projection::{Displaced, Functions, Projection, Samples};
use super::target::Edges;
use crate::submodel::is_turned_to;

/// Outward normal of a point's own face in the target's components; none of points that any surface can press.
type Facing<'a> = Option<&'a [f64; 3]>;

impl Displaced<'_> {
    /// Projection of `point`, whose own face has the outward normal `facing` in the target's components, on all faces, of which `samples` has the
    /// displaced places.
    ///
    /// The nearest point of the surface says whether the point is outside. If it is inside, or over an edge by no more than the target's overhang,
    /// the nearest face presses it that lies below it, no deeper than the
    /// surface reaches, and is turned to its own face; without one it is open.
    pub fn on_all_faces(
        &self,
        (point, facing): (&[f64; 3], Facing<'_>),
        samples: &Samples,
        functions: &mut Functions,
    ) -> Projection {
        let Edges { overhang, reach } =
            self.surface.edges.unwrap_or(Edges { overhang: 0.0, reach: f64::INFINITY });
        let mut nearest: Option<(f64, Projection)> = None;
        let mut pressing: Option<(f64, Projection)> = None;
        for face in 0..self.surface.faces.len() {
            let found = self.closest_from(&samples.nearest_on(face, point), point, functions);
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
        let is_outside = (nearest.is_beyond || nearest.gap > 0.0) && distance > overhang;
        match pressing {
            Some(found) if !is_outside || (found.gap - distance).abs() <= overhang => found,
            _ => Projection { is_beyond: true, ..nearest },
        }
    }

    /// Whether a projection found from the place before may stand: over a face that is turned to the point's own.
    pub fn may_stand(&self, found: &Projection, facing: Facing<'_>) -> bool {
        !found.is_beyond && facing.is_none_or(|facing| is_turned_to(facing, &found.normal))
    }
}

fn is_less(distance: f64, best: &Option<(f64, Projection)>) -> bool {
    best.is_none_or(|(least, _)| distance < least)
}
