//! Whether the contact zone of the last impact holds the next one as well, so that its fine model
//! serves again (theory Eq. A.4).

use ffr_dynamics::body::RigidMotion;
use iga_core::nurbs::jet::{difference, norm};

use crate::adaptivity::interval::least_utilisation;
use crate::record::ZoneSite;
use crate::system::body::FlexibleModel;

/// Distance from the axis, as a share of the body's size, that is round-off.
const ON_AXIS: f64 = 1e-12;

/// Whether the zone `kept` on `body`, with `elements` contact elements in a direction, can be
/// expected to be accepted (Algorithm 2) in an impact for which `wanted` would be laid, so wide
/// that the share `target` of it touches.
///
/// Contact must end an element before the zone does, and fill the least share of it that is
/// accepted.
pub(super) fn holds(
    body: &FlexibleModel,
    kept: &ZoneSite,
    wanted: &ZoneSite,
    elements: usize,
    target: f64,
) -> bool {
    let surface = body.body.undeformed();
    if kept.others != wanted.others || !surface.share_directions([kept.face, wanted.face]) {
        return false;
    }
    let [from, to] = [kept, wanted].map(|site| surface.place(site.face, &site.centre).point);
    // The end of a line moves as it turns.
    let turned = 0.5 * body.body.size() * norm(&difference(&kept.across, &wanted.across));
    let moved = norm(&difference(&from, &to)) + turned;
    // From the axis of an axisymmetric model the zone leads one way.
    let is_from_axis =
        body.motion() == RigidMotion::Axial && is_on_axis(body, &from) && is_on_axis(body, &to);
    let sides = if is_from_axis { 1.0 } else { 2.0 };
    let (Some(kept), Some(wanted)) = (kept.size.widths(), wanted.size.widths()) else { return false };
    let mut directions = kept.iter().zip(&wanted).filter(|(kept, _)| **kept > 0.0);
    directions.all(|(kept, wanted)| is_accepted(*kept, target * wanted, moved, sides, elements, target))
}

/// Whether contact of the width `touched`, which leads from the centre to so many `sides`, is
/// accepted in a zone of the width `kept` whose centre lies `moved` from its own \[m\].
fn is_accepted(kept: f64, touched: f64, moved: f64, sides: f64, elements: usize, target: f64) -> bool {
    let edge = kept / elements.max(1) as f64;
    touched / sides + moved <= kept / sides - edge && touched >= least_utilisation(target) * kept
}

/// Whether a point of an axisymmetric body lies on the axis, to round-off.
fn is_on_axis(body: &FlexibleModel, point: &[f64; 3]) -> bool {
    point[0].abs() <= ON_AXIS * body.body.size()
}

#[cfg(test)]
mod tests {
    use super::is_accepted;
    use crate::adaptivity::interval::TARGET_UTILISATION;

    #[test]
    fn zones_serve_until_contact_would_reach_their_edge_or_fill_too_little() {
        let accepted = |touched: f64, moved: f64, sides: f64| {
            is_accepted(1.0, touched, moved, sides, 16, TARGET_UTILISATION)
        };
        // As laid: 70 % of the width touch; an edge element is 6.25 %.
        assert!(accepted(0.7, 0.0, 2.0) && accepted(0.7, 0.08, 2.0) && !accepted(0.7, 0.09, 2.0));
        assert!(accepted(0.87, 0.0, 2.0) && !accepted(0.88, 0.0, 2.0));
        // From the axis there is one edge.
        assert!(accepted(0.93, 0.0, 1.0) && !accepted(0.94, 0.0, 1.0));
        // Below half of the elements nothing is accepted.
        assert!(accepted(0.51, 0.0, 2.0) && !accepted(0.49, 0.0, 2.0));
    }
}
