//! Bodies of revolution whose ends may be round or narrower than one another: cone, capsule,
//! rounded cylinder, torus.
//!
//! Solids have five patches across, a square about the axis and four around it, without singular
//! places but circles where a round end goes over into the jacket without an edge. Their
//! axisymmetric forms are the meridian halves in `(r, z)`.

use std::f64::consts::FRAC_PI_2;

use super::cover::{Cover, CoverNet, Division, Homogeneous, quarter, revolved};
use super::{joined, positive};
use crate::SplineError;
use crate::nurbs::shape::SingularSet;
use crate::nurbs::{FaceId, Patch, Shape};
use crate::splines::knots::KnotVector;

/// A body of revolution.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Round {
    /// Truncated cone, `0 <= z <= length`.
    Cone {
        /// Radius at `z = 0` \[m\].
        radius: f64,
        /// Radius at `z = length` \[m\].
        end_radius: f64,
        /// Length \[m\].
        length: f64,
    },
    /// Cylinder with hemispheres on both ends, `0 <= z <= length`.
    Capsule {
        /// Radius \[m\].
        radius: f64,
        /// Length over all \[m\], more than twice the radius.
        length: f64,
    },
    /// Cylinder `0 <= z <= length` with a flat end at `z = length` and a crowned one, whose pole is
    /// the origin.
    RoundedCylinder {
        /// Radius \[m\].
        radius: f64,
        /// Length over all \[m\].
        length: f64,
        /// Radius of the crown \[m\], not below that of the cylinder; flat if there is none.
        crown_radius: Option<f64>,
        /// Radius of the fillet between crown and jacket \[m\], below that of the cylinder; an edge
        /// if there is none.
        fillet_radius: Option<f64>,
    },
}

/// A body of revolution as layers of covers from the lower end to the upper one.
struct Layers {
    covers: Vec<Cover>,
    /// Radius in the middle of the jacket, and its height \[m\].
    middle: [f64; 2],
    length: f64,
}

/// The name of the circles on which bodies with a smooth rim are singular.
const JUNCTION: &str = "circle where the round end meets the jacket";

impl Round {
    /// The solid about the z axis. Directions of the patch about the axis: x, y, along; of the four
    /// around it: outwards, around, along.
    ///
    /// # Errors
    /// [`SplineError::Dimension`] for impossible lengths.
    pub fn solid(&self) -> Result<Shape, SplineError> {
        let Layers { covers, middle: [radius, middle], length } = self.layers()?;
        let smooth = [&covers[0], &covers[covers.len() - 1]].map(Cover::is_tangent_to_jacket);
        let is_plane = covers.iter().all(|cover| cover.curvature == 0.0);
        let (division, degree) = if is_plane { (Division::Straight, 2) } else { (Division::Projected, 4) };
        let nets: Vec<CoverNet> = covers.iter().map(|cover| cover.net(division)).collect();
        let (across, along) = (outwards(&covers[0])?, upwards(&covers)?);
        let around = KnotVector::uniform(degree, 1)?;
        let stack = |knots: [&KnotVector; 2], part: &dyn Fn(&CoverNet) -> Vec<Homogeneous>| {
            let net: Vec<_> = nets.iter().flat_map(part).collect();
            Patch::from_homogeneous(vec![knots[0].clone(), knots[1].clone(), along.clone()], &net)
        };
        let mut patches = vec![stack([&around, &around], &|net| net.core.clone())?];
        for turn in 0..4 {
            patches.push(stack([&across, &around], &|net| net.rings[turn].clone())?);
        }
        let ends = [false, true]
            .map(|upper| (0..5).map(|patch| FaceId { patch, direction: 2, upper }).collect::<Vec<_>>());
        let jacket = (1..5).map(|patch| FaceId { patch, direction: 0, upper: true }).collect();
        let markers = super::solid::cylinder_markers(0.0, radius, length);
        let markers = markers.map(|(name, [x, y, z])| {
            let is_beside = ["left", "right", "front", "back"].contains(&name);
            (name, [x, y, if is_beside { middle } else { z }])
        });
        Ok(rod_like(patches, markers, ends, jacket, smooth))
    }

    /// The meridian half, in `(r, z)`. Directions: outwards, along.
    ///
    /// # Errors
    /// [`SplineError::Dimension`] for impossible lengths.
    pub fn axisymmetric(&self) -> Result<Shape, SplineError> {
        let Layers { covers, length, .. } = self.layers()?;
        let smooth = [&covers[0], &covers[covers.len() - 1]].map(Cover::is_tangent_to_jacket);
        let net = covers.iter().flat_map(Cover::meridian).map(|[r, z, w]| [r * w, z * w, 0.0, w]);
        let net: Vec<_> = net.collect();
        let patch = Patch::from_homogeneous(vec![outwards(&covers[0])?, upwards(&covers)?], &net)?;
        let end = |upper| vec![FaceId { patch: 0, direction: 1, upper }];
        let jacket = vec![FaceId { patch: 0, direction: 0, upper: true }];
        let markers = super::axisymmetric::rod_markers(0.0, length);
        Ok(rod_like(vec![patch], markers, [end(false), end(true)], jacket, smooth))
    }

    fn layers(&self) -> Result<Layers, SplineError> {
        match *self {
            Self::Cone { radius, end_radius, length } => {
                let (a, b) = (positive("radius", radius)?, positive("end_radius", end_radius)?);
                let l = positive("length", length)?;
                let covers = vec![Cover::plane(0.0, a, a), Cover::plane(l, b, b)];
                Ok(Layers { covers, middle: [0.5 * (a + b), 0.5 * l], length: l })
            }
            Self::Capsule { radius, length } => {
                let (r, l) = (positive("radius", radius)?, positive("length", length)?);
                larger("length", l, 2.0 * r, "must exceed twice the radius, a ball is the shape \"sphere\"")?;
                let round = Cover { pole: 0.0, curvature: 1.0 / r, rim: r, fillet: None };
                let upper = Cover { pole: l, curvature: -1.0 / r, ..round };
                let mut covers = vec![round];
                // One plane between short ends, two where there is a straight part between bowls
                // that have flattened.
                let flat = (2.0 * r).min(0.5 * l);
                covers.push(Cover::plane(flat, r, r));
                if flat < 0.5 * l {
                    covers.push(Cover::plane(l - flat, r, r));
                }
                covers.push(upper);
                Ok(Layers { covers, middle: [r, 0.5 * l], length: l })
            }
            Self::RoundedCylinder { radius, length, crown_radius, fillet_radius } => {
                let (r, l) = (positive("radius", radius)?, positive("length", length)?);
                let crown = crowned(r, crown_radius, fillet_radius)?;
                let depth = crown.outer_height();
                larger("length", l, depth, "must exceed the height of crown and fillet")?;
                let mut covers = vec![crown];
                let flat = (2.0 * depth).min(0.5 * (depth + l));
                if depth > 0.0 {
                    covers.push(Cover::plane(flat, crown.rim, r));
                }
                covers.push(Cover::plane(l, crown.rim, r));
                Ok(Layers { covers, middle: [r, 0.5 * (depth + l)], length: l })
            }
        }
    }
}

/// The crowned lower end of a cylinder of the radius `r`, its pole at the origin: the fillet, of
/// the radius `f`, touches the sphere of the crown, of the radius `c`, from inside, and the jacket
/// (theory Eq. S.12).
fn crowned(r: f64, crown: Option<f64>, fillet: Option<f64>) -> Result<Cover, SplineError> {
    let curvature = match crown {
        Some(c) => {
            let c = positive("crown_radius", c)?;
            if c < r {
                let reason = "must not be below the radius of the cylinder";
                return Err(SplineError::Dimension { name: "crown_radius", value: c, reason });
            }
            1.0 / c
        }
        None => 0.0,
    };
    let Some(f) = fillet else { return Ok(Cover { pole: 0.0, curvature, rim: r, fillet: None }) };
    let f = positive("fillet_radius", f)?;
    if let Some(c) = crown {
        let reason = "must exceed the radius of the cylinder if there is a fillet";
        larger("crown_radius", c, r, reason)?;
    }
    larger("radius", r, f, "must exceed fillet_radius; for a round end choose shape \"capsule\"")?;
    // The angle of the normal to the axis where crown and fillet meet, and how far its centre is
    // above the pole.
    let sine = curvature * (r - f) / (1.0 - curvature * f);
    let cosine = (1.0 - sine * sine).max(0.0).sqrt();
    let rim = r - f + f * sine;
    let sagitta = curvature * rim * rim / (1.0 + cosine); // c (1 - cos)
    let centre = sagitta + f * cosine;
    let half = 0.5 * (FRAC_PI_2 - sine.asin());
    let arc = [[rim, sagitta, 1.0], [r, centre - f * half.tan(), half.cos()], [r, centre, 1.0]];
    Ok(Cover { pole: 0.0, curvature, rim, fillet: Some(arc) })
}

/// Checks that `value` exceeds `limit`.
fn larger(name: &'static str, value: f64, limit: f64, reason: &'static str) -> Result<(), SplineError> {
    if value > limit { Ok(()) } else { Err(SplineError::Dimension { name, value, reason }) }
}

/// Knots outwards: one segment, or two whose parameters are shared by their lengths.
fn outwards(cover: &Cover) -> Result<KnotVector, SplineError> {
    let points = cover.meridian();
    if points.len() == 3 {
        return KnotVector::uniform(2, 1);
    }
    let chord = |a: usize, b: usize| (points[a][0] - points[b][0]).hypot(points[a][1] - points[b][1]);
    // The first segment begins at the edge of the square.
    let (inner, outer) = (0.5 * chord(0, 2), chord(2, 4));
    let at = inner / (inner + outer);
    KnotVector::new(2, vec![0.0, 0.0, 0.0, at, at, 1.0, 1.0, 1.0])
}

/// Knots along the axis, by the heights of the layers on the jacket.
fn upwards(covers: &[Cover]) -> Result<KnotVector, SplineError> {
    let heights: Vec<f64> = covers.iter().map(Cover::outer_height).collect();
    let (first, last) = (heights[0], heights[heights.len() - 1]);
    let breaks: Vec<f64> = heights.iter().map(|z| (z - first) / (last - first)).collect();
    KnotVector::from_breaks(1, &breaks)
}

fn rod_like<const N: usize>(
    patches: Vec<Patch>,
    markers: [(&'static str, [f64; 3]); N],
    [lower, upper]: [Vec<FaceId>; 2],
    jacket: Vec<FaceId>,
    smooth: [bool; 2],
) -> Shape {
    // All outward ends of the patches that end on the jacket, where an end is tangent to it.
    let circle = |face: &FaceId| {
        let n = patches[face.patch].dimension();
        let face = *face;
        let ends = [0.0, 1.0].into_iter().zip(smooth).filter(|(_, is_smooth)| *is_smooth);
        ends.map(move |(end, _)| {
            let mut parameters = [None; 3];
            (parameters[face.direction], parameters[n - 1]) = (Some(1.0), Some(end));
            SingularSet { patch: face.patch, parameters, name: JUNCTION.to_owned() }
        })
    };
    let singular = jacket.iter().flat_map(circle).collect();
    let faces =
        [("z-", lower.clone()), ("z+", upper.clone()), ("jacket", jacket), ("start", lower), ("end", upper)];
    Shape { singular, ..joined(patches, markers, faces) }
}

/// Torus about the z axis, centred at the origin: the circle of the radius `tube_radius`, whose
/// centre is `radius` away from the axis.
///
/// A solid has 20 patches, five across in each of the quarters about ±x and ±y; directions as for
/// [`Round::solid`], the last one around the z axis. Regular throughout.
///
/// # Errors
/// [`SplineError::Dimension`] for impossible lengths; `tube_radius` must be below `radius`.
pub fn torus(radius: f64, tube_radius: f64) -> Result<Shape, SplineError> {
    let sections = section(radius, tube_radius)?;
    let quadratic = KnotVector::uniform(2, 1)?;
    let mut patches = Vec::with_capacity(20);
    for turn in 0..4 {
        for net in &sections {
            let arc = quarter(turn);
            let swept = arc.iter().flat_map(|a| {
                // Downwards, so that the directions are a right-handed system.
                net.iter().map(move |[r, h, _, w]| revolved(&[r / w, -h / w, *w], a))
            });
            patches.push(Patch::from_homogeneous(vec![quadratic.clone(); 3], &swept.collect::<Vec<_>>())?);
        }
    }
    let surface = (0..20).filter(|p| p % 5 > 0).map(|patch| FaceId { patch, direction: 0, upper: true });
    let outer = radius + tube_radius;
    let markers = [
        ("left", [-outer, 0.0, 0.0]),
        ("right", [outer, 0.0, 0.0]),
        ("front", [0.0, -outer, 0.0]),
        ("back", [0.0, outer, 0.0]),
        ("bottom", [radius, 0.0, -tube_radius]),
        ("top", [radius, 0.0, tube_radius]),
    ];
    Ok(joined(patches, markers, [("surface", surface.collect())]))
}

/// The section of [`torus`] in `(r, z)`: five patches.
///
/// # Errors
/// As [`torus`].
pub fn axisymmetric_torus(radius: f64, tube_radius: f64) -> Result<Shape, SplineError> {
    let quadratic = KnotVector::uniform(2, 1)?;
    let sections = section(radius, tube_radius)?;
    let patches = sections.iter().map(|net| Patch::from_homogeneous(vec![quadratic.clone(); 2], net));
    let surface = (1..5).map(|patch| FaceId { patch, direction: 0, upper: true }).collect();
    let markers = [
        ("centre", [radius, 0.0, 0.0]),
        ("bottom", [radius, -tube_radius, 0.0]),
        ("top", [radius, tube_radius, 0.0]),
        ("inner", [radius - tube_radius, 0.0, 0.0]),
        ("outer", [radius + tube_radius, 0.0, 0.0]),
    ];
    Ok(joined(patches.collect::<Result<_, _>>()?, markers, [("surface", surface)]))
}

/// Nets of the section of a torus, a disc of five patches: radius, height, 0, weight.
fn section(radius: f64, tube_radius: f64) -> Result<Vec<Vec<Homogeneous>>, SplineError> {
    let (a, b) = (positive("radius", radius)?, positive("tube_radius", tube_radius)?);
    larger("radius", a, b, "must exceed tube_radius")?;
    let CoverNet { core, rings } = Cover::plane(0.0, b, b).net(Division::Straight);
    let shifted = |net: Vec<Homogeneous>| net.iter().map(|[x, y, _, w]| [x + a * w, *y, 0.0, *w]).collect();
    Ok(std::iter::once(core).chain(rings).map(shifted).collect())
}
