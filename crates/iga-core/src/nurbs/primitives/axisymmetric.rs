//! Meridian halves of bodies of revolution, in `(r, z)`.

use super::{FIRST, NamedFaces, S, SECOND, bezier, hollow, positive, shape, singular};
use crate::SplineError;
use crate::nurbs::{Patch, Shape};
use crate::splines::knots::KnotVector;

/// Sphere: half-disc from the 3 x 2 net of \[B\] Eqs. (35), (36), centred at the origin.
///
/// The first direction runs from the axis to the equator, the second from the lower to the upper
/// half circle. The edge at the equator is collapsed to a point; the poles `(0, ±r)` are regular,
/// so contact belongs there.
///
/// # Errors
/// [`SplineError::Dimension`] for an impossible radius.
pub fn sphere(radius: f64) -> Result<Shape, SplineError> {
    let r = positive("radius", radius)?;
    let points = [[0.0, -r], [r, -r], [r, 0.0], [0.0, r], [r, r], [r, 0.0]];
    let points = points.map(|[x, z]| [x, z, 0.0]).to_vec();
    let patch = bezier(&[2, 1], points, vec![1.0, S, 1.0, 1.0, S, 1.0])?;
    let markers = [
        ("centre", [0.0; 3]),
        ("top", [0.0, r, 0.0]),
        ("bottom", [0.0, -r, 0.0]),
        ("equator", [r, 0.0, 0.0]),
    ];
    let faces: NamedFaces<'_> = &[("surface", &[(1, false), (1, true)])];
    Ok(shape(vec![patch], markers, faces, vec![singular([Some(1.0), None, None], "equator")]))
}

/// Ellipsoid of revolution centred at the origin with the semi-axis `radius` across and `height`
/// along the axis: the half-disc of [`sphere`] stretched, which is exact; regular at the poles.
///
/// # Errors
/// [`SplineError::Dimension`] for impossible lengths.
pub fn spheroid(radius: f64, height: f64) -> Result<Shape, SplineError> {
    let (r, h) = (positive("semi_axes", radius)?, positive("semi_axes", height)?);
    let ball = sphere(1.0)?;
    let stretched = |[x, z, y]: &[f64; 3]| [r * x, h * z, *y];
    let patch = &ball.patches[0];
    let points = patch.control_points().iter().map(stretched).collect();
    let patches = vec![Patch::new(patch.knots().to_vec(), points, patch.weights().to_vec())?];
    let markers = ball.markers.iter().map(|(name, p)| (name.clone(), stretched(p))).collect();
    Ok(Shape { patches, markers, ..ball })
}

/// Rod with flat ends: `0 <= r <= radius`, `0 <= z <= length`.
///
/// # Errors
/// [`SplineError::Dimension`] for impossible lengths.
pub fn rod(radius: f64, length: f64) -> Result<Shape, SplineError> {
    let (r, l) = (positive("radius", radius)?, positive("length", length)?);
    let points = vec![[0.0; 3], [r, 0.0, 0.0], [0.0, l, 0.0], [r, l, 0.0]];
    let patch = bezier(&[1, 1], points, vec![1.0; 4])?;
    Ok(shape(vec![patch], rod_markers(0.0, l), ROD_FACES, Vec::new()))
}

/// Rod with a spherical lower end: the pole is the origin, the flat upper end lies at `z = length`.
///
/// Net of \[B\] Eq. (38), with two changes. There the middle control point of the upper edge
/// coincides with the outer one, which makes `∂r/∂ξ` and with it `det J` vanish along the whole
/// jacket at `r = radius`; here it stands at half the radius, and only the junction of sphere and
/// jacket is singular. There the bowl of the sphere flattens over the whole length, so that the
/// lines `η = const` meet the jacket at grazing angles and radial functions resolve little; here it
/// flattens up to the height of one diameter, where a row of control points crosses the rod on a
/// line of reduced smoothness, and cells above are rectangles. Same body, same exactness.
///
/// # Errors
/// [`SplineError::Dimension`] for impossible lengths; the rod must be longer than its radius.
pub fn rod_spherical_end(radius: f64, length: f64) -> Result<Shape, SplineError> {
    let (r, l) = (positive("radius", radius)?, positive("length", length)?);
    if l <= r {
        return Err(SplineError::Dimension {
            name: "length",
            value: l,
            reason: "must exceed the radius of the spherical end",
        });
    }
    let middle = (2.0 * r).min(0.5 * (r + l));
    let row = |z: f64| [[0.0, z, 0.0], [0.5 * r, z, 0.0], [r, z, 0.0]];
    let mut points = vec![[0.0; 3], [r, 0.0, 0.0], [r, r, 0.0]];
    points.extend(row(middle));
    points.extend(row(l));
    let weights = vec![1.0, S, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0];
    let knots =
        vec![KnotVector::from_breaks(2, &[0.0, 1.0])?, KnotVector::from_breaks(1, &[0.0, middle / l, 1.0])?];
    let patch = Patch::new(knots, points, weights)?;
    let junction = singular([Some(1.0), Some(0.0), None], "junction of spherical end and jacket");
    Ok(shape(vec![patch], rod_markers(0.0, l), ROD_FACES, vec![junction]))
}

/// Hollow cylinder: `inner <= r <= outer`, `0 <= z <= length`. Markers lie in the middle of the
/// wall.
///
/// # Errors
/// [`SplineError::Dimension`] for impossible lengths.
pub fn hollow_cylinder(inner_radius: f64, outer_radius: f64, length: f64) -> Result<Shape, SplineError> {
    let (a, b) = (inner_radius, outer_radius);
    hollow(a, b)?;
    let l = positive("length", length)?;
    let points = vec![[a, 0.0, 0.0], [b, 0.0, 0.0], [a, l, 0.0], [b, l, 0.0]];
    let patch = bezier(&[1, 1], points, vec![1.0; 4])?;
    let faces: NamedFaces<'_> = &[
        ("z-", SECOND[0]),
        ("z+", SECOND[1]),
        ("inner", FIRST[0]),
        ("outer", FIRST[1]),
        ("start", SECOND[0]),
        ("end", SECOND[1]),
    ];
    Ok(shape(vec![patch], rod_markers(0.5 * (a + b), l), faces, Vec::new()))
}

/// Ends and jacket of a rod; the spherical end is `z-`.
const ROD_FACES: NamedFaces<'_> =
    &[("z-", SECOND[0]), ("z+", SECOND[1]), ("jacket", FIRST[1]), ("start", SECOND[0]), ("end", SECOND[1])];

pub(super) fn rod_markers(r: f64, l: f64) -> [(&'static str, [f64; 3]); 5] {
    [
        ("start", [r, 0.0, 0.0]),
        ("end", [r, l, 0.0]),
        ("centre", [r, 0.5 * l, 0.0]),
        ("bottom", [r, 0.0, 0.0]),
        ("top", [r, l, 0.0]),
    ]
}
