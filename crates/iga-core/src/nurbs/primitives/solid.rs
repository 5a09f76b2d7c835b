//! Solid bodies with straight generators.

use super::{
    AROUND, DISC_CORNERS, FIRST, NamedFaces, S, SECOND, THIRD, bezier, hollow, positive, shape, singular,
    unit_disc,
};
use crate::SplineError;
use crate::nurbs::{Patch, Shape, Symmetry};
use crate::splines::knots::KnotVector;

/// Box with edges along the axes, centred at the origin.
///
/// # Errors
/// [`SplineError::Dimension`] for impossible lengths.
pub fn cuboid(size: [f64; 3]) -> Result<Shape, SplineError> {
    for length in size {
        positive("size", length)?;
    }
    let h = size.map(|length| 0.5 * length);
    let side = |bit: usize, d: usize| if bit == 0 { -h[d] } else { h[d] };
    let points = (0..8).map(|i| [side(i & 1, 0), side(i >> 1 & 1, 1), side(i >> 2, 2)]).collect();
    let patch = bezier(&[1, 1, 1], points, vec![1.0; 8])?;
    let markers = [
        ("centre", [0.0; 3]),
        ("left", [-h[0], 0.0, 0.0]),
        ("right", [h[0], 0.0, 0.0]),
        ("front", [0.0, -h[1], 0.0]),
        ("back", [0.0, h[1], 0.0]),
        ("bottom", [0.0, 0.0, -h[2]]),
        ("top", [0.0, 0.0, h[2]]),
        ("start", [0.0, 0.0, -h[2]]),
        ("end", [0.0, 0.0, h[2]]),
    ];
    let faces: NamedFaces<'_> = &[
        ("x-", FIRST[0]),
        ("x+", FIRST[1]),
        ("y-", SECOND[0]),
        ("y+", SECOND[1]),
        ("z-", THIRD[0]),
        ("z+", THIRD[1]),
        ("start", THIRD[0]),
        ("end", THIRD[1]),
    ];
    Ok(shape(vec![patch], markers, faces, Vec::new()))
}

/// Solid cylinder about the z axis, `0 <= z <= length`: the 3 x 3 disc net extruded. Directions:
/// across, across, along.
///
/// Four lines of the jacket, at 45°, 135°, 225° and 315°, are singular; `±x` and `±y` are regular,
/// as are the flat ends but for the four corner points.
///
/// # Errors
/// [`SplineError::Dimension`] for impossible lengths.
pub fn cylinder(radius: f64, length: f64) -> Result<Shape, SplineError> {
    let (r, l) = (positive("radius", radius)?, positive("length", length)?);
    let disc = unit_disc();
    let layer = |z: f64| disc.iter().map(move |([x, y], w)| ([r * x, r * y, z], *w));
    let (points, weights) = layer(0.0).chain(layer(l)).unzip();
    let patch = bezier(&[2, 2, 1], points, weights)?;
    let line = |&([u, v], angle): &([f64; 2], usize)| {
        singular([Some(u), Some(v), None], format!("jacket line at {angle}°"))
    };
    let faces: NamedFaces<'_> =
        &[("z-", THIRD[0]), ("z+", THIRD[1]), ("jacket", AROUND), ("start", THIRD[0]), ("end", THIRD[1])];
    let lines = DISC_CORNERS.iter().map(line).collect();
    let shape = shape(vec![patch], cylinder_markers(0.0, r, l), faces, lines);
    let quarters = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]];
    Ok(Shape { symmetry: Some(Symmetry::about_z(&quarters)), ..shape })
}

/// Hollow cylinder about the z axis, `0 <= z <= length`. Directions: outwards, around (closed, four
/// quarter arcs, seam at `y = 0, x > 0`), along. Regular throughout. Markers "start", "centre" and
/// "end" lie in the middle of the wall at `y = 0`.
///
/// # Errors
/// [`SplineError::Dimension`] for impossible lengths.
pub fn hollow_cylinder(inner_radius: f64, outer_radius: f64, length: f64) -> Result<Shape, SplineError> {
    let (a, b) = (inner_radius, outer_radius);
    hollow(a, b)?;
    let l = positive("length", length)?;
    const CIRCLE: [[f64; 3]; 9] = [
        [1.0, 0.0, 1.0],
        [1.0, 1.0, S],
        [0.0, 1.0, 1.0],
        [-1.0, 1.0, S],
        [-1.0, 0.0, 1.0],
        [-1.0, -1.0, S],
        [0.0, -1.0, 1.0],
        [1.0, -1.0, S],
        [1.0, 0.0, 1.0],
    ];
    let patch = tube(&CIRCLE, [a, b], l)?;
    let faces: NamedFaces<'_> = &[
        ("z-", THIRD[0]),
        ("z+", THIRD[1]),
        ("inner", FIRST[0]),
        ("outer", FIRST[1]),
        ("start", THIRD[0]),
        ("end", THIRD[1]),
    ];
    let shape = shape(vec![patch], cylinder_markers(0.5 * (a + b), b, l), faces, Vec::new());
    // The middles of the four arcs.
    let middles = [[S, S, 0.0], [-S, S, 0.0], [-S, -S, 0.0], [S, -S, 0.0]];
    Ok(Shape { symmetry: Some(Symmetry::about_z(&middles)), ..shape })
}

/// The patch between two radii, `0 <= z <= length`, over arcs of at most a quarter about the z axis
/// that follow each other: `x`, `y` and weight of their ends and of the points between, at the
/// radius one. Directions: outwards, around, along.
pub(super) fn tube(arcs: &[[f64; 3]], radii: [f64; 2], length: f64) -> Result<Patch, SplineError> {
    let (mut points, mut weights) = (Vec::new(), Vec::new());
    for z in [0.0, length] {
        for [x, y, w] in arcs {
            for r in radii {
                points.push([r * x, r * y, z]);
                weights.push(*w);
            }
        }
    }
    let n_arcs = arcs.len() / 2;
    let around = (0..=n_arcs).flat_map(|i| [i as f64 / n_arcs as f64; 2]);
    let around: Vec<f64> = std::iter::once(0.0).chain(around).chain([1.0]).collect();
    let knots = vec![KnotVector::uniform(1, 1)?, KnotVector::new(2, around)?, KnotVector::uniform(1, 1)?];
    Patch::new(knots, points, weights)
}

pub(super) fn cylinder_markers(x: f64, r: f64, l: f64) -> [(&'static str, [f64; 3]); 9] {
    let middle = 0.5 * l;
    [
        ("start", [x, 0.0, 0.0]),
        ("end", [x, 0.0, l]),
        ("centre", [x, 0.0, middle]),
        ("bottom", [x, 0.0, 0.0]),
        ("top", [x, 0.0, l]),
        ("left", [-r, 0.0, middle]),
        ("right", [r, 0.0, middle]),
        ("front", [0.0, -r, middle]),
        ("back", [0.0, r, middle]),
    ]
}
