//! Bodies with one section all along: sector of a tube, plate with a hole, L- and T-beam.

use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_2, TAU};

use super::solid::tube;
use super::{FIRST, NamedFaces, SECOND, THIRD, hollow, joined, positive, shape};
use crate::SplineError;
use crate::nurbs::{FaceId, Patch, Shape};
use crate::splines::knots::KnotVector;

/// Part of a hollow cylinder about the z axis, `0 <= z <= length`, over the angle `angle` \[rad\],
/// below a full turn, half of it on either side of the x axis. Directions: outwards, around (arcs
/// of up to 90 degrees), along. Regular throughout.
///
/// # Errors
/// [`SplineError::Dimension`] for impossible sizes.
pub fn tube_sector(
    inner_radius: f64,
    outer_radius: f64,
    length: f64,
    angle: f64,
) -> Result<Shape, SplineError> {
    let (a, b) = (inner_radius, outer_radius);
    hollow(a, b)?;
    let l = positive("length", length)?;
    if !(angle > 0.0 && angle < TAU) {
        let reason = "must be positive and less than a full turn, which is the shape \"hollow-cylinder\"";
        return Err(SplineError::Dimension { name: "angle", value: angle, reason });
    }
    let n_arcs = (angle / FRAC_PI_2 - 1e-9).ceil().max(1.0) as usize; // a quarter in digits is one
    let half = 0.5 * angle / n_arcs as f64;
    let arcs: Vec<[f64; 3]> = (0..=2 * n_arcs)
        .map(|i| {
            let phi = half * i as f64 - 0.5 * angle;
            let weight = if i % 2 == 1 { half.cos() } else { 1.0 };
            [phi.cos() / weight, phi.sin() / weight, weight]
        })
        .collect();
    let patch = tube(&arcs, [a, b], l)?;
    let faces: NamedFaces<'_> = &[
        ("z-", THIRD[0]),
        ("z+", THIRD[1]),
        ("inner", FIRST[0]),
        ("outer", FIRST[1]),
        ("first", SECOND[0]),
        ("last", SECOND[1]),
        ("start", THIRD[0]),
        ("end", THIRD[1]),
    ];
    let middle = 0.5 * (a + b);
    let at = |r: f64, phi: f64, z: f64| [r * phi.cos(), r * phi.sin(), z];
    let markers = [
        ("start", [middle, 0.0, 0.0]),
        ("end", [middle, 0.0, l]),
        ("centre", [middle, 0.0, 0.5 * l]),
        ("bottom", [middle, 0.0, 0.0]),
        ("top", [middle, 0.0, l]),
        ("inner", [a, 0.0, 0.5 * l]),
        ("outer", [b, 0.0, 0.5 * l]),
        ("first", at(middle, -0.5 * angle, 0.5 * l)),
        ("last", at(middle, 0.5 * angle, 0.5 * l)),
    ];
    Ok(shape(vec![patch], markers, faces, Vec::new()))
}

/// Aspect of a plate up to which each of its sides has one of the four patches about the hole; a
/// longer one has a square about the hole and a rectangle on either side of it. Arcs are up to 113
/// degrees long then.
const COMPACT: f64 = 1.5;

/// Plane plate in `(x, y)` with a round hole in its middle, centred at the origin.
///
/// Four patches about the hole (directions outwards, around), graded towards it; long plates have
/// two more. Regular throughout.
///
/// # Errors
/// [`SplineError::Dimension`] for impossible sizes; the hole must lie inside.
pub fn plate_with_hole(size: [f64; 2], hole_radius: f64) -> Result<Shape, SplineError> {
    let [x, y] = plate(size, hole_radius)?;
    let (patches, sides) = plate_patches([x, y], hole_radius)?;
    let markers = [
        ("left", [-x, 0.0, 0.0]),
        ("right", [x, 0.0, 0.0]),
        ("bottom", [0.0, -y, 0.0]),
        ("top", [0.0, y, 0.0]),
        ("start", [-x, 0.0, 0.0]),
        ("end", [x, 0.0, 0.0]),
    ];
    let [left, right, bottom, top] = sides;
    let faces = [
        ("x-", left.clone()),
        ("x+", right.clone()),
        ("y-", bottom),
        ("y+", top),
        ("hole", hole()),
        ("start", left),
        ("end", right),
    ];
    Ok(joined(patches, markers, faces))
}

/// The same as a solid of the thickness `thickness`, in `z` about the origin.
///
/// # Errors
/// As [`plate_with_hole`].
pub fn solid_plate_with_hole(size: [f64; 2], hole_radius: f64, thickness: f64) -> Result<Shape, SplineError> {
    let [x, y] = plate(size, hole_radius)?;
    let h = 0.5 * positive("thickness", thickness)?;
    let (plane, sides) = plate_patches([x, y], hole_radius)?;
    let patches = extruded(&plane, [-h, h])?;
    // Points of the material: above and below the hole there is none.
    let markers = [
        ("left", [-x, 0.0, 0.0]),
        ("right", [x, 0.0, 0.0]),
        ("front", [0.0, -y, 0.0]),
        ("back", [0.0, y, 0.0]),
        ("start", [-x, 0.0, 0.0]),
        ("end", [x, 0.0, 0.0]),
    ];
    let [left, right, front, back] = sides;
    let faces = [
        ("x-", left.clone()),
        ("x+", right.clone()),
        ("y-", front),
        ("y+", back),
        ("z-", across(&patches, false)),
        ("z+", across(&patches, true)),
        ("hole", hole()),
        ("start", left),
        ("end", right),
    ];
    Ok(joined(patches, markers, faces))
}

/// Half the sizes of a plate with a hole, checked.
fn plate(size: [f64; 2], hole_radius: f64) -> Result<[f64; 2], SplineError> {
    let [x, y] = [0.5 * positive("size", size[0])?, 0.5 * positive("size", size[1])?];
    let r = positive("hole_radius", hole_radius)?;
    if r < x.min(y) {
        return Ok([x, y]);
    }
    let reason = "must be less than half of both sizes";
    Err(SplineError::Dimension { name: "hole_radius", value: r, reason })
}

/// The surface of the hole: the inner ends of the four patches about it.
fn hole() -> Vec<FaceId> {
    (0..4).map(|patch| FaceId { patch, direction: 0, upper: false }).collect()
}

/// Faces of a plate's sides: left, right, lower, upper.
type Sides = [Vec<FaceId>; 4];

/// Patches of a plate with half the sizes `[x, y]`, and its sides.
fn plate_patches([x, y]: [f64; 2], hole_radius: f64) -> Result<(Vec<Patch>, Sides), SplineError> {
    let is_long = [x > COMPACT * y, y > COMPACT * x];
    let [a, b] = [if is_long[0] { y } else { x }, if is_long[1] { x } else { y }];
    // Corners against the clock from the lower right one; patch i lies between corners i and i + 1.
    let corners = [[a, -b], [a, b], [-a, b], [-a, -b]];
    let middle = [[a, 0.0], [0.0, b], [-a, 0.0], [0.0, -b]];
    // The middle control points outwards stand where lengths along the hole and outwards are about
    // alike; half way for large holes.
    let share = 0.5 * (hole_radius / a.min(b)).sqrt();
    let mut patches = Vec::with_capacity(6);
    for side in 0..4 {
        let ends = [corners[side], middle[side], corners[(side + 1) % 4]];
        patches.push(beside_hole(ends, hole_radius, share)?);
    }
    let end = |patch, direction, upper| FaceId { patch, direction, upper };
    let around = |patch| end(patch, 0, true);
    let mut sides = [vec![around(2)], vec![around(0)], vec![around(3)], vec![around(1)]];
    if is_long[0] {
        patches.push(rectangle([-x, -a], [-y, y], [1, 2])?);
        patches.push(rectangle([a, x], [-y, y], [1, 2])?);
        sides[0] = vec![end(4, 0, false)];
        sides[1] = vec![end(5, 0, true)];
        sides[2].extend([end(4, 1, false), end(5, 1, false)]);
        sides[3].extend([end(4, 1, true), end(5, 1, true)]);
    } else if is_long[1] {
        patches.push(rectangle([-x, x], [-y, -b], [2, 1])?);
        patches.push(rectangle([-x, x], [b, y], [2, 1])?);
        sides[2] = vec![end(4, 1, false)];
        sides[3] = vec![end(5, 1, true)];
        sides[0].extend([end(4, 0, false), end(5, 0, false)]);
        sides[1].extend([end(4, 0, true), end(5, 0, true)]);
    }
    Ok((patches, sides))
}

/// The patch between the hole and a side, given by its ends and its middle: quadratic outwards with
/// the middle points at `share` of the way, so that elements grow with the distance from the hole.
fn beside_hole(side: [[f64; 2]; 3], r: f64, share: f64) -> Result<Patch, SplineError> {
    let [first, mean, last] = side.map(|[x, y]| [x / x.hypot(y), y / x.hypot(y)]);
    let cosine = first[0] * mean[0] + first[1] * mean[1];
    // The side has the weights of the arc, which leaves it straight.
    let arc = [(first, 1.0), (mean.map(|c| c / cosine), cosine), (last, 1.0)];
    let (mut points, mut weights) = (Vec::with_capacity(9), Vec::with_capacity(9));
    for ((on_circle, weight), outer) in arc.iter().zip(side) {
        for s in [0.0, share, 1.0] {
            let point = |c: usize| (1.0 - s) * r * on_circle[c] + s * outer[c];
            points.push([point(0), point(1), 0.0]);
            weights.push(*weight);
        }
    }
    Patch::new(vec![KnotVector::uniform(2, 1)?; 2], points, weights)
}

/// A rectangle with the given degrees; a quadratic direction has the weights of the arc that its
/// neighbours have, which leaves its lines straight.
fn rectangle(x: [f64; 2], y: [f64; 2], degrees: [usize; 2]) -> Result<Patch, SplineError> {
    let along = |[a, b]: [f64; 2], degree: usize| -> Vec<(f64, f64)> {
        match degree {
            1 => vec![(a, 1.0), (b, 1.0)],
            _ => vec![(a, 1.0), (0.5 * (a + b), FRAC_1_SQRT_2), (b, 1.0)],
        }
    };
    let (mut points, mut weights) = (Vec::new(), Vec::new());
    for (v, of_v) in along(y, degrees[1]) {
        for (u, of_u) in along(x, degrees[0]) {
            points.push([u, v, 0.0]);
            weights.push(of_u * of_v);
        }
    }
    super::bezier(&degrees, points, weights)
}

/// Plane patches moved along z.
pub(super) fn extruded(plane: &[Patch], [lower, upper]: [f64; 2]) -> Result<Vec<Patch>, SplineError> {
    let along = |patch: &Patch| {
        let layer = |z: f64| patch.control_points().iter().map(move |[x, y, _]| [*x, *y, z]);
        let mut knots = patch.knots().to_vec();
        knots.push(KnotVector::uniform(1, 1)?);
        let points = layer(lower).chain(layer(upper)).collect();
        Patch::new(knots, points, patch.weights().repeat(2))
    };
    plane.iter().map(along).collect()
}

/// The lower or upper ends of all patches in z.
pub(super) fn across(patches: &[Patch], upper: bool) -> Vec<FaceId> {
    (0..patches.len()).map(|patch| FaceId { patch, direction: 2, upper }).collect()
}

/// L-beam, `0 <= z <= length`: a foot of the width `width` along x and a wall of the height
/// `height` along y, both of the thickness `thickness`, whose outer edge is the z axis. Three
/// patches; directions x, y, z.
///
/// # Errors
/// [`SplineError::Dimension`] for impossible lengths; `thickness` must be less than `width` and `height`.
pub fn l_beam(width: f64, height: f64, thickness: f64, length: f64) -> Result<Shape, SplineError> {
    let (w, h) = (positive("width", width)?, positive("height", height)?);
    let (t, l) = (positive("thickness", thickness)?, positive("length", length)?);
    thinner(t, w.min(h), "must be less than width and height")?;
    let plane = [
        rectangle([0.0, t], [0.0, t], [1, 1])?,
        rectangle([t, w], [0.0, t], [1, 1])?,
        rectangle([0.0, t], [t, h], [1, 1])?,
    ];
    let patches = extruded(&plane, [0.0, l])?;
    let end = |patch, direction, upper| FaceId { patch, direction, upper };
    let (lower, upper) = (across(&patches, false), across(&patches, true));
    let faces = [
        ("x-", vec![end(0, 0, false), end(2, 0, false)]),
        ("x+", vec![end(1, 0, true)]),
        ("y-", vec![end(0, 1, false), end(1, 1, false)]),
        ("y+", vec![end(2, 1, true)]),
        ("z-", lower.clone()),
        ("z+", upper.clone()),
        ("inside", vec![end(1, 1, true), end(2, 0, true)]),
        ("start", lower),
        ("end", upper),
    ];
    let c = 0.5 * t;
    Ok(joined(patches, beam_markers([c, c], [[w, c], [c, h]], l), faces))
}

/// T-beam, `0 <= z <= length`: a flange of the width `width` along x, whose upper face is `y = 0`,
/// and under its middle a web down to `y = -height`. Four patches; directions x, y, z.
///
/// # Errors
/// [`SplineError::Dimension`] for impossible lengths; the web must be thinner than the flange is wide, the flange than the height.
pub fn t_beam(
    width: f64,
    height: f64,
    flange_thickness: f64,
    web_thickness: f64,
    length: f64,
) -> Result<Shape, SplineError> {
    let (w, h, l) = (positive("width", width)?, positive("height", height)?, positive("length", length)?);
    let t = positive("flange_thickness", flange_thickness)?;
    let s = positive("web_thickness", web_thickness)?;
    if t >= h {
        let reason = "must be less than height";
        return Err(SplineError::Dimension { name: "flange_thickness", value: t, reason });
    }
    if s >= w {
        let reason = "must be less than width";
        return Err(SplineError::Dimension { name: "web_thickness", value: s, reason });
    }
    let (u, v) = (0.5 * s, 0.5 * w);
    let plane = [
        rectangle([-u, u], [-t, 0.0], [1, 1])?,
        rectangle([-v, -u], [-t, 0.0], [1, 1])?,
        rectangle([u, v], [-t, 0.0], [1, 1])?,
        rectangle([-u, u], [-h, -t], [1, 1])?,
    ];
    let patches = extruded(&plane, [0.0, l])?;
    let end = |patch, direction, upper| FaceId { patch, direction, upper };
    let (lower, upper) = (across(&patches, false), across(&patches, true));
    let faces = [
        ("x-", vec![end(1, 0, false)]),
        ("x+", vec![end(2, 0, true)]),
        ("y-", vec![end(3, 1, false)]),
        ("y+", (0..3).map(|patch| end(patch, 1, true)).collect()),
        ("z-", lower.clone()),
        ("z+", upper.clone()),
        ("web", vec![end(3, 0, false), end(3, 0, true)]),
        ("under", vec![end(1, 1, false), end(2, 1, false)]),
        ("start", lower),
        ("end", upper),
    ];
    let c = -0.5 * t;
    Ok(joined(patches, beam_markers([0.0, c], [[v, c], [0.0, -h]], l), faces))
}

/// Markers of a beam: the ends and the middle of its corner or web, and the tips of both flanges in
/// the middle of its length.
fn beam_markers([x, y]: [f64; 2], tips: [[f64; 2]; 2], l: f64) -> [(&'static str, [f64; 3]); 7] {
    let tip = |[x, y]: [f64; 2]| [x, y, 0.5 * l];
    [
        ("start", [x, y, 0.0]),
        ("end", [x, y, l]),
        ("centre", [x, y, 0.5 * l]),
        ("bottom", [x, y, 0.0]),
        ("top", [x, y, l]),
        ("flange", tip(tips[0])),
        ("web", tip(tips[1])),
    ]
}

/// Checks that the thickness `t` is less than `limit`.
fn thinner(t: f64, limit: f64, reason: &'static str) -> Result<(), SplineError> {
    if t < limit { Ok(()) } else { Err(SplineError::Dimension { name: "thickness", value: t, reason }) }
}
