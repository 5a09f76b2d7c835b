//! Plane bodies, in `(x, y)`.

use super::{AROUND, DISC_CORNERS, FIRST, NamedFaces, SECOND, bezier, positive, shape, singular, unit_disc};
use crate::SplineError;
use crate::nurbs::{Shape, Symmetry};

/// Rectangle centred at the origin.
///
/// # Errors
/// [`SplineError::Dimension`] for impossible lengths.
pub fn rectangle(width: f64, height: f64) -> Result<Shape, SplineError> {
    let (x, y) = (0.5 * positive("width", width)?, 0.5 * positive("height", height)?);
    let points = vec![[-x, -y, 0.0], [x, -y, 0.0], [-x, y, 0.0], [x, y, 0.0]];
    let patch = bezier(&[1, 1], points, vec![1.0; 4])?;
    let markers = [
        ("centre", [0.0; 3]),
        ("left", [-x, 0.0, 0.0]),
        ("right", [x, 0.0, 0.0]),
        ("bottom", [0.0, -y, 0.0]),
        ("top", [0.0, y, 0.0]),
        ("start", [-x, 0.0, 0.0]),
        ("end", [x, 0.0, 0.0]),
    ];
    let faces: NamedFaces<'_> = &[
        ("x-", FIRST[0]),
        ("x+", FIRST[1]),
        ("y-", SECOND[0]),
        ("y+", SECOND[1]),
        ("start", FIRST[0]),
        ("end", FIRST[1]),
    ];
    Ok(shape(vec![patch], markers, faces, Vec::new()))
}

/// Disc centred at the origin, from the 3 x 3 net of \[B\] Eqs. (40), (41).
///
/// Four boundary points, at 45°, 135°, 225° and 315°, are singular: both boundary tangents are
/// parallel there.
///
/// # Errors
/// [`SplineError::Dimension`] for an impossible radius.
pub fn disc(radius: f64) -> Result<Shape, SplineError> {
    let r = positive("radius", radius)?;
    let (points, weights) = unit_disc().iter().map(|([x, y], w)| ([r * x, r * y, 0.0], *w)).unzip();
    let patch = bezier(&[2, 2], points, weights)?;
    let markers = [
        ("centre", [0.0; 3]),
        ("left", [-r, 0.0, 0.0]),
        ("right", [r, 0.0, 0.0]),
        ("bottom", [0.0, -r, 0.0]),
        ("top", [0.0, r, 0.0]),
    ];
    let corner = |&([u, v], angle): &([f64; 2], usize)| {
        singular([Some(u), Some(v), None], format!("boundary point at {angle}°"))
    };
    let shape = shape(vec![patch], markers, &[("rim", AROUND)], DISC_CORNERS.iter().map(corner).collect());
    let middles = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]];
    Ok(Shape { symmetry: Some(Symmetry::about_z(&middles)), ..shape })
}
