//! The net of a shape that stays what it is when it is turned, such as that of a ball, turned so
//! that it is regular at a place.

use iga_core::SplineError;
use iga_core::nurbs::Face;
use iga_core::nurbs::jet::norm;
use iga_core::nurbs::patch::PointBasis;
use iga_core::nurbs::shape::symmetry::{angle_about, product, rotation_about};
use iga_core::nurbs::{PatchSearch, Shape};

/// The shape with its net turned so that it is regular at `place` of `face`, with that place on it;
/// `None` if the net is regular there already, or the shape has no symmetry.
///
/// # Errors
/// As [`Shape::rotated`].
pub fn regular_view(
    shape: &Shape,
    face: &Face,
    place: &[f64; 3],
) -> Result<Option<(Shape, Face, [f64; 3])>, SplineError> {
    let Some((rotation, point)) = regular_rotation(shape, face, place)? else { return Ok(None) };
    let turned = shape.rotated(&rotation)?;
    let (face, site) = nearest(&turned, &point);
    Ok(Some((turned, face, site.xi)))
}

/// A rotation, or a map of an ellipsoid (rows), and a point in space.
type Turn = ([[f64; 3]; 3], [f64; 3]);

/// The rotation of [`regular_view`], and the point in space.
fn regular_rotation(shape: &Shape, face: &Face, place: &[f64; 3]) -> Result<Option<Turn>, SplineError> {
    let Some(symmetry) = &shape.symmetry else { return Ok(None) };
    let surface = face.at(&shape.patches[face.id.patch], place, &mut PointBasis::default());
    // A ball's normal is its radius, also where that of the net is lost.
    let normal = if symmetry.is_ball() { surface.point } else { surface.normal };
    let Some(first) = symmetry.map_to(&surface.point, &normal) else { return Ok(None) };
    if !symmetry.is_ball() {
        return Ok(Some((first, surface.point)));
    }
    let (_, there) = nearest(&shape.rotated(&first)?, &surface.point);
    // The directions along the face stay those that widths were asked for, as far as the net
    // allows.
    let angle = angle_about(&unit(&normal), &there.tangents[0], &surface.tangents[0]);
    Ok(Some((product(&rotation_about(&unit(&normal), angle), &first), surface.point)))
}

/// A point on a face.
pub struct Site {
    /// Its parameters.
    pub xi: [f64; 3],
    /// Tangents of the face there.
    pub tangents: [[f64; 3]; 2],
}

/// The place on the outer faces of `shape` that is nearest to `point`.
pub fn nearest(shape: &Shape, point: &[f64; 3]) -> (Face, Site) {
    let faces = Face::outer(&shape.patches, false);
    let search = |face: &Face| {
        let mut fixed = [None; 3];
        fixed[face.id.direction] = Some(face.parameter);
        PatchSearch::new(&shape.patches[face.id.patch], fixed).closest(&shape.patches[face.id.patch], point)
    };
    let found = faces.iter().map(|f| (*f, search(f)));
    let best = found.min_by(|a, b| a.1.measure.total_cmp(&b.1.measure));
    let (face, located) = best.expect("a body has an outer face");
    let at = face.at(&shape.patches[face.id.patch], &located.xi, &mut PointBasis::default());
    (face, Site { xi: located.xi, tangents: at.tangents })
}

/// The unit vector along `v`.
pub fn unit(v: &[f64; 3]) -> [f64; 3] {
    let length = norm(v);
    v.map(|c| c / length)
}
