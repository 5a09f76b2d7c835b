//! The solid sphere: three exact nets (docs/decisions/0001-sphere-net.md), and the ellipsoid, which
//! is a stretched sphere.
//!
//! An exact conforming cube-topology sphere needs degree 4; degrees 2 and 3 suffice if two faces
//! collapse to poles.

use super::{positive, shape, singular, unit_disc};
use crate::SplineError;
use crate::nurbs::Face;
use crate::nurbs::shape::SingularSet;
use crate::nurbs::shape::symmetry::Symmetry;
use crate::nurbs::{Patch, Shape};
use crate::splines::knots::KnotVector;

/// Nets of the solid sphere.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum SphereNet {
    /// One biquartic patch, 5 x 5 x 5: a blown-up cube. Singular on its twelve edges; regular at
    /// the six face centres `±x`, `±y`, `±z`.
    #[default]
    Cube,
    /// One patch of degree (2, 2, 3), 3 x 3 x 4: a disc moved along a half circle, poles at
    /// `y = ±r`. Singular at the poles and on four meridians; regular and smooth around `±x` and
    /// `±z`.
    Spindle,
    /// Seven patches: a cube with six shells. Regular everywhere, only continuous between patches.
    Shells,
}

impl SphereNet {
    /// All nets.
    pub const ALL: [Self; 3] = [Self::Cube, Self::Spindle, Self::Shells];

    /// The net for a wanted degree: the smoothest one that it can represent.
    pub fn for_degree(degree: usize) -> Self {
        if degree < Self::Cube.least_degree() { Self::Spindle } else { Self::Cube }
    }

    /// Lowest degree that represents the net; of the spindle's half circle 3 wherever less is asked
    /// for.
    pub fn least_degree(self) -> usize {
        match self {
            Self::Spindle => 2,
            Self::Cube | Self::Shells => 4,
        }
    }
}

/// Solid sphere centred at the origin.
///
/// # Errors
/// [`SplineError::Dimension`] for an impossible radius.
pub fn sphere(radius: f64, net: SphereNet) -> Result<Shape, SplineError> {
    let r = positive("radius", radius)?;
    let (patches, singular) = match net {
        SphereNet::Cube => (vec![cube(r)?], cube_edges()),
        SphereNet::Spindle => (vec![spindle(r)?], spindle_poles()),
        SphereNet::Shells => (shells(r)?, Vec::new()),
    };
    let markers = [
        ("centre", [0.0; 3]),
        ("left", [-r, 0.0, 0.0]),
        ("right", [r, 0.0, 0.0]),
        ("front", [0.0, -r, 0.0]),
        ("back", [0.0, r, 0.0]),
        ("bottom", [0.0, 0.0, -r]),
        ("top", [0.0, 0.0, r]),
    ];
    let regular = [
        [1.0, 0.0, 0.0],
        [-1.0, 0.0, 0.0],
        [0.0, 0.0, 1.0],
        [0.0, 0.0, -1.0],
        [0.0, 1.0, 0.0],
        [0.0, -1.0, 0.0],
    ];
    // The last two are the poles of the spindle.
    let symmetry = match net {
        SphereNet::Spindle => Some(Symmetry::ball(&regular[..4])),
        SphereNet::Cube => Some(Symmetry::ball(&regular)),
        // Regular everywhere: it need not be turned.
        SphereNet::Shells => None,
    };
    let surface = Face::outer(&patches, false).into_iter().map(|face| face.id).collect();
    let faces = [("surface".to_owned(), surface)].into();
    Ok(Shape { symmetry, faces, ..shape(patches, markers, &[], singular) })
}

/// Solid ellipsoid centred at the origin with the semi-axes along the axes: the cube net of the
/// unit ball, stretched, which is exact; regular at the ends of the axes, and wherever a map of its
/// symmetry brings them.
///
/// # Errors
/// [`SplineError::Dimension`] for impossible lengths.
pub fn ellipsoid(semi_axes: [f64; 3]) -> Result<Shape, SplineError> {
    for length in semi_axes {
        positive("semi_axes", length)?;
    }
    let ball = sphere(1.0, SphereNet::Cube)?;
    let stretched = |p: &[f64; 3]| std::array::from_fn(|d| semi_axes[d] * p[d]);
    let patch = |patch: &Patch| {
        let points = patch.control_points().iter().map(stretched).collect();
        Patch::new(patch.knots().to_vec(), points, patch.weights().to_vec())
    };
    Ok(Shape {
        patches: ball.patches.iter().map(patch).collect::<Result<_, _>>()?,
        markers: ball.markers.iter().map(|(name, p)| (name.clone(), stretched(p))).collect(),
        symmetry: ball.symmetry.as_ref().map(|ball| Symmetry::ellipsoid(semi_axes, ball.regular())),
        ..ball
    })
}

/// Homogeneous net of the tile on the face `z < 0` of the unit sphere, `[i][j]` with `i` along x,
/// `j` along y: a sixth of the sphere between great circles as a biquartic patch (Cobb 1988).
/// Closed form of the stereographic construction in theory section S.4; the corner weight is one.
fn tile() -> [[[f64; 4]; 5]; 5] {
    let (s2, s3, s6) = (2f64.sqrt(), 3f64.sqrt(), 6f64.sqrt());
    let corner = 4.0 * (1.0 - s3);
    let quarter = [
        [
            [corner, corner, corner, 4.0 * (3.0 - s3)],
            [s2 * (s3 - 4.0), -s2, s2 * (s3 - 4.0), s2 * (3.0 * s3 - 2.0)],
            [4.0 / 3.0 * (1.0 - 2.0 * s3), 0.0, 4.0 / 3.0 * (1.0 - 2.0 * s3), 4.0 / 3.0 * (5.0 - s3)],
        ],
        [
            [0.0; 4],
            [0.5 * (2.0 - 3.0 * s3), 0.5 * (2.0 - 3.0 * s3), -0.5 * (s3 + 6.0), 0.5 * (s3 + 6.0)],
            [s2 * (2.0 * s3 - 7.0) / 3.0, 0.0, -5.0 * s6 / 3.0, s2 * (s3 + 6.0) / 3.0],
        ],
        [[0.0; 4], [0.0; 4], [0.0, 0.0, 4.0 * (s3 - 5.0) / 3.0, 4.0 * (5.0 * s3 - 1.0) / 9.0]],
    ];
    let mut net = [[[0.0; 4]; 5]; 5];
    for (i, row) in net.iter_mut().enumerate() {
        for (j, entry) in row.iter_mut().enumerate() {
            let (a, b) = (i.min(4 - i), j.min(4 - j));
            let mut h = quarter[a.min(b)][a.max(b)];
            if a > b {
                h.swap(0, 1);
            }
            h[0] *= if i > 2 { -1.0 } else { 1.0 };
            h[1] *= if j > 2 { -1.0 } else { 1.0 };
            *entry = h.map(|v| v / (4.0 * (3.0 - s3)));
        }
    }
    net
}

/// Homogeneous control point of the unit sphere's surface at index `index` of the 5 x 5 x 5 cube
/// net, at least one entry of which is 0 or 4.
fn surface_point(tile: &[[[f64; 4]; 5]; 5], index: [usize; 3]) -> [f64; 4] {
    let normal = (0..3).find(|&d| index[d] == 0 || index[d] == 4).unwrap_or(2);
    on_tile(tile, index, normal)
}

/// Surface tiles with the interior by transfinite (Coons) blending of the homogeneous net.
fn cube(r: f64) -> Result<Patch, SplineError> {
    let tile = tile();
    let mut net = Vec::with_capacity(125);
    for flat in 0..125 {
        let index = [flat % 5, flat / 5 % 5, flat / 25];
        let mut point = [0.0; 4];
        // Inclusion-exclusion over the sets of directions that are blended between their two ends.
        for set in 1..8usize {
            let blended: Vec<usize> = (0..3).filter(|d| set >> d & 1 == 1).collect();
            let sign = if blended.len() % 2 == 1 { 1.0 } else { -1.0 };
            for ends in 0..1usize << blended.len() {
                let (mut at, mut share) = (index, sign);
                for (bit, &d) in blended.iter().enumerate() {
                    let upper = ends >> bit & 1 == 1;
                    let s = index[d] as f64 / 4.0;
                    share *= if upper { s } else { 1.0 - s };
                    at[d] = if upper { 4 } else { 0 };
                }
                for (sum, v) in point.iter_mut().zip(surface_point(&tile, at)) {
                    *sum += share * v;
                }
            }
        }
        let on_surface = index.iter().any(|&i| i == 0 || i == 4);
        net.push(if on_surface { surface_point(&tile, index) } else { point });
    }
    from_unit(vec![KnotVector::uniform(4, 1)?; 3], &net, r)
}

fn cube_edges() -> Vec<SingularSet> {
    let mut sets = Vec::with_capacity(12);
    for free in 0..3 {
        for corner in 0..4 {
            let mut parameters = [None; 3];
            parameters[(free + 1) % 3] = Some(f64::from(corner & 1));
            parameters[(free + 2) % 3] = Some(f64::from(corner >> 1));
            sets.push(singular(parameters, "edge of the cube net"));
        }
    }
    sets
}

/// The unit disc net, in the plane of z and x, times a half circle from `y = -r` to `y = +r`.
///
/// The half circle is one cubic segment, `(2 t (1-t), t² - (1-t)²) / (t² + (1-t)²)`. Two quadratic
/// ones, as in most libraries, meet at the equator in a line of mere continuity: a deformed surface
/// has a kink there, just where balls touch.
fn spindle(r: f64) -> Result<Patch, SplineError> {
    const THIRD: f64 = 1.0 / 3.0;
    const HALF_CIRCLE: [[f64; 3]; 4] =
        [[0.0, -1.0, 1.0], [2.0, -1.0, THIRD], [2.0, 1.0, THIRD], [0.0, 1.0, 1.0]];
    let (mut points, mut weights) = (Vec::with_capacity(36), Vec::with_capacity(36));
    for [ring, height, w_k] in HALF_CIRCLE {
        for ([p, q], w) in unit_disc() {
            points.push([r * ring * q, r * height, r * ring * p]);
            weights.push(w * w_k);
        }
    }
    let disc = KnotVector::uniform(2, 1)?;
    Patch::new(vec![disc.clone(), disc, KnotVector::uniform(3, 1)?], points, weights)
}

fn spindle_poles() -> Vec<SingularSet> {
    let mut sets = vec![
        singular([None, None, Some(0.0)], "pole y = -r"),
        singular([None, None, Some(1.0)], "pole y = +r"),
    ];
    for ([u, v], angle) in super::DISC_CORNERS {
        sets.push(singular([Some(u), Some(v), None], format!("meridian at {angle}° from the z axis")));
    }
    sets
}

/// Half edge of the inner cube of the seven-patch net, in units of `r/√3`.
const INNER_CUBE: f64 = 0.5;

/// A cube and six shells between its faces and the tiles; the last direction of each shell points
/// outwards.
fn shells(r: f64) -> Result<Vec<Patch>, SplineError> {
    let half = INNER_CUBE / 3f64.sqrt();
    let line = |i: usize| half * (i as f64 / 2.0 - 1.0);
    let inner = |index: [usize; 3]| [line(index[0]), line(index[1]), line(index[2]), 1.0];
    let core: Vec<_> = (0..125).map(|f| inner([f % 5, f / 5 % 5, f / 25])).collect();
    let quartic = KnotVector::uniform(4, 1)?;
    let mut patches = vec![from_unit(vec![quartic.clone(); 3], &core, r)?];
    let tile = tile();
    for normal in 0..3 {
        for end in [0, 4] {
            // The order of the two directions along the face makes a right-handed system with the
            // outward one.
            let (a, b) = if end == 4 { (1, 2) } else { (2, 1) };
            let (a, b) = ((normal + a) % 3, (normal + b) % 3);
            let face = (0..25).map(|f| {
                let mut index = [end; 3];
                index[a] = f % 5;
                index[b] = f / 5;
                index
            });
            let face: Vec<_> = face.collect();
            let mut net: Vec<_> = face.iter().map(|&index| inner(index)).collect();
            net.extend(face.iter().map(|&index| on_tile(&tile, index, normal)));
            patches.push(from_unit(
                vec![quartic.clone(), quartic.clone(), KnotVector::uniform(1, 1)?],
                &net,
                r,
            )?);
        }
    }
    Ok(patches)
}

/// As [`surface_point`] with the face named by its normal direction.
fn on_tile(tile: &[[[f64; 4]; 5]; 5], index: [usize; 3], normal: usize) -> [f64; 4] {
    let (a, b) = ((normal + 1) % 3, (normal + 2) % 3);
    let h = tile[index[a]][index[b]];
    let mut point = [0.0; 4];
    point[a] = h[0];
    point[b] = h[1];
    point[normal] = if index[normal] == 0 { h[2] } else { -h[2] };
    point[3] = h[3];
    point
}

fn from_unit(knots: Vec<KnotVector>, net: &[[f64; 4]], r: f64) -> Result<Patch, SplineError> {
    let net: Vec<_> = net.iter().map(|h| [r * h[0], r * h[1], r * h[2], h[3]]).collect();
    Patch::from_homogeneous(knots, &net)
}
