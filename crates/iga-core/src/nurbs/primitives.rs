//! Exact shapes by name.
//!
//! Lengths are in metres and checked: positive and finite, inner radii below outer ones. Every
//! shape comes with markers (named points of the material), with named faces (parts of its surface)
//! and with the singular sets of its parametrisation, on which contact must not fall (theory
//! section S.4). \[B\] is the paper of that name in docs/theory.md.

pub mod axisymmetric;
mod cover;
pub mod plane;
pub mod solid;
pub mod profile;
pub mod gear_tooth;
pub mod round;
pub mod sphere;
pub mod rounded_box;

pub use sphere::SphereNet;

use super::interface::FaceId;
use super::shape::SingularSet;
use super::{Patch, Shape};
use crate::SplineError;
use crate::splines::knots::KnotVector;

/// `1/√2`, the middle weight of a quarter circle as a quadratic arc.
const S: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// Checks a length.
fn positive(name: &'static str, value: f64) -> Result<f64, SplineError> {
    if value.is_finite() && value > 0.0 {
        return Ok(value);
    }
    Err(SplineError::Dimension { name, value, reason: "must be a positive, finite length in metres" })
}

/// Checks the radii of a hollow body.
fn hollow(inner: f64, outer: f64) -> Result<(), SplineError> {
    positive("inner_radius", inner)?;
    positive("outer_radius", outer)?;
    if inner < outer {
        return Ok(());
    }
    Err(SplineError::Dimension {
        name: "inner_radius",
        value: inner,
        reason: "must be smaller than outer_radius",
    })
}

/// A patch of single Bézier pieces with the given degrees.
fn bezier(degrees: &[usize], points: Vec<[f64; 3]>, weights: Vec<f64>) -> Result<Patch, SplineError> {
    let knots = degrees.iter().map(|&p| KnotVector::uniform(p, 1)).collect::<Result<_, _>>()?;
    Patch::new(knots, points, weights)
}

fn shape<const N: usize>(
    patches: Vec<Patch>,
    markers: [(&str, [f64; 3]); N],
    faces: NamedFaces<'_>,
    singular: Vec<SingularSet>,
) -> Shape {
    let markers = markers.into_iter().map(|(name, p)| (name.to_owned(), p)).collect();
    let id = |&(direction, upper): &(usize, bool)| FaceId { patch: 0, direction, upper };
    let faces = faces.iter().map(|(name, sides)| ((*name).to_owned(), sides.iter().map(id).collect()));
    Shape { patches, markers, faces: faces.collect(), singular, symmetry: None, parts: [1; 3] }
}

/// A shape of several patches, with all its faces, regular throughout.
fn joined<const N: usize, const M: usize>(
    patches: Vec<Patch>,
    markers: [(&str, [f64; 3]); N],
    faces: [(&str, Vec<FaceId>); M],
) -> Shape {
    let markers = markers.into_iter().map(|(name, p)| (name.to_owned(), p)).collect();
    let faces = faces.into_iter().map(|(name, ids)| (name.to_owned(), ids)).collect();
    Shape { patches, markers, faces, singular: Vec::new(), symmetry: None, parts: [1; 3] }
}

/// Named faces of a shape of one patch: the direction that is fixed on each part, and whether at
/// its upper end.
type NamedFaces<'a> = &'a [(&'a str, &'a [(usize, bool)])];
/// The lower and the upper end of direction 0.
const FIRST: [&[(usize, bool)]; 2] = [&[(0, false)], &[(0, true)]];
/// The lower and the upper end of direction 1.
const SECOND: [&[(usize, bool)]; 2] = [&[(1, false)], &[(1, true)]];
/// The lower and the upper end of direction 2.
const THIRD: [&[(usize, bool)]; 2] = [&[(2, false)], &[(2, true)]];
/// All ends of directions 0 and 1, which bound the disc net.
const AROUND: &[(usize, bool)] = &[(0, false), (0, true), (1, false), (1, true)];

fn singular(parameters: [Option<f64>; 3], name: impl Into<String>) -> SingularSet {
    SingularSet { patch: 0, parameters, name: name.into() }
}

/// The disc net of \[B\] Eqs. (40), (41), radius one: 3 x 3 points with their weights.
fn unit_disc() -> [([f64; 2], f64); 9] {
    const T: f64 = std::f64::consts::SQRT_2;
    [
        ([-S, -S], 1.0),
        ([0.0, -T], S),
        ([S, -S], 1.0),
        ([-T, 0.0], S),
        ([0.0, 0.0], 1.0),
        ([T, 0.0], S),
        ([-S, S], 1.0),
        ([0.0, T], S),
        ([S, S], 1.0),
    ]
}

/// Corners of the disc net and the angles at which they lie on the circle.
const DISC_CORNERS: [([f64; 2], usize); 4] =
    [([1.0, 1.0], 45), ([0.0, 1.0], 135), ([0.0, 0.0], 225), ([1.0, 0.0], 315)];
