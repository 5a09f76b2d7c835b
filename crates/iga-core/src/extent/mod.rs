//! Places with an extent: faces by name, discs on the surface, balls inside (docs/theory.md Eq. M.44).
//!
//! An extent is turned into quadrature points with areas (volumes inside a body), the same whatever the mesh is. Two
//! things make integrals over it converge under refinement: faces take their Gauss points from the elements of the space
//! that is integrated, discs and balls are at least as dense as its elements.

mod ball;
mod disc;
mod face;

use crate::SplineError;
use crate::elasticity::Model;
use crate::nurbs::Shape;
use crate::nurbs::jet::{diagonal, norm};
use crate::nurbs::patch::PointBasis;
use crate::quadrature::GaussRule;
use crate::space::{PatchSpace, SplineSpace};
use crate::surface::BodySurface;

/// A part of a body.
#[derive(Debug, Clone, PartialEq)]
pub enum Extent {
    /// The face of the shape that has this name.
    Face(String),
    /// What lies within `radius` of `point`.
    ///
    /// Where the point lies on the surface, the part of the surface whose projection along the normal at the point is a disc
    /// (in two dimensions a line) of that radius; inside the body a ball (a disc). In axisymmetric models it goes around
    /// the axis with its point.
    Around {
        /// Centre, in the model's components \[m\].
        point: [f64; 3],
        /// Radius \[m\].
        radius: f64,
    },
}

/// A quadrature point of an extent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExtentPoint {
    /// Element of the space.
    pub element: usize,
    /// Parameters in its patch.
    pub xi: [f64; 3],
    /// Position in the model's components \[m\].
    pub point: [f64; 3],
    /// Area, inside a body volume, that belongs to it: with the thickness of plane models and `2 π r` of axisymmetric ones
    /// \[m² or m³\].
    pub weight: f64,
}

/// Distance of the centre from the surface, as a share of the radius, up to which a disc about the nearest place is meant and no ball, for every kind of
/// body: a ball so near to the surface would leave the body, and sides of a mesh lie beside the shape that they stand for.
pub const ON_SURFACE: f64 = 0.1;
/// Points a direction and part of the rules for faces that know no mesh.
const FINEST: usize = crate::quadrature::MAX_GAUSS;

impl Extent {
    /// Quadrature points of the extent on the body `shape`, whose functions are those of `space`.
    ///
    /// On faces they are the Gauss points of the elements of `space`, so that piecewise polynomials are integrated
    /// piece by piece. On discs and in balls they lie closer than the smallest element there, down to a limit beyond which
    /// a share of the load so small is left to each point that its neighbourhood yields less than the whole extent does.
    ///
    /// # Errors
    /// [`SplineError::UnknownFace`]; [`SplineError::EmptyExtent`] for a face without area; [`SplineError::ExtentBeyondBody`] for a disc or ball that leaves the body;
    /// [`SplineError::PointNotFound`] for a centre outside the body.
    pub fn points(
        &self,
        shape: &Shape,
        space: &dyn SplineSpace,
        model: &Model,
    ) -> Result<Vec<ExtentPoint>, SplineError> {
        let points = match self {
            Self::Face(name) => {
                // Functions of degree p, three more points for the area element and the lever.
                let count = |e: usize| space.gauss_counts(e).map(|n| (n + 3).min(FINEST));
                face::points(shape, space, model, name, count, 1)?
            }
            Self::Around { point, radius } => around(shape, space, model, point, *radius)?,
        };
        let total: f64 = points.iter().map(|p| p.weight).sum();
        if total > 0.0 && total.is_finite() {
            return Ok(points);
        }
        Err(SplineError::EmptyExtent { extent: self.name() })
    }

    /// Where the extent is: the centroid of a face, the centre of a disc or ball, in the model's components (an
    /// axisymmetric extent is on the axis) \[m\]. It does not depend on a mesh.
    ///
    /// # Errors
    /// As [`Extent::points`].
    pub fn centre(&self, shape: &Shape, model: &Model) -> Result<[f64; 3], SplineError> {
        let mut centre = match self {
            Self::Around { point, .. } => *point,
            Self::Face(name) => {
                let space = PatchSpace::new(shape.patches.clone())?;
                // Arcs of 90° in two parts of sixteen points: far below round-off.
                let points = face::points(shape, &space, model, name, |_| [FINEST; 3], 2)?;
                let total: f64 = points.iter().map(|p| p.weight).sum();
                if total.is_nan() || total <= 0.0 {
                    return Err(SplineError::EmptyExtent { extent: self.name() });
                }
                [0, 1, 2].map(|c| points.iter().map(|p| p.weight * p.point[c]).sum::<f64>() / total)
            }
        };
        if *model == Model::Axisymmetric {
            centre[0] = 0.0;
        }
        Ok(centre)
    }

    /// Longest side of the elements of `space` at a disc or ball \[m\]; none for a face, with whose edges functions end.
    ///
    /// # Errors
    /// As [`Extent::points`].
    pub fn longest_element(
        &self,
        shape: &Shape,
        space: &dyn SplineSpace,
        model: &Model,
    ) -> Result<Option<f64>, SplineError> {
        if matches!(self, Self::Face(_)) {
            return Ok(None);
        }
        let mut longest = 0.0_f64;
        for p in self.points(shape, space, model)? {
            longest = sides(shape, space, p.element, &p.xi).into_iter().fold(longest, f64::max);
        }
        Ok(Some(longest))
    }

    /// In words, for messages.
    pub fn name(&self) -> String {
        match self {
            Self::Face(name) => format!("face \"{name}\""),
            Self::Around { point: [x, y, z], radius } => {
                format!("the extent of radius {radius} m about ({x}, {y}, {z}) m")
            }
        }
    }
}

/// Sides of an element as they are at the parameters `xi` in it, zero along directions that the space does not have \[m\].
fn sides(shape: &Shape, space: &dyn SplineSpace, element: usize, xi: &[f64; 3]) -> [f64; 3] {
    let element = space.element(element);
    let jet = shape.patches[element.patch].jet(xi, 1, &mut PointBasis::default());
    std::array::from_fn(|d| {
        if d < space.dimension() { norm(&jet.first[d]) * (element.upper[d] - element.lower[d]) } else { 0.0 }
    })
}

/// Points of a disc or ball.
fn around(
    shape: &Shape,
    space: &dyn SplineSpace,
    model: &Model,
    point: &[f64; 3],
    radius: f64,
) -> Result<Vec<ExtentPoint>, SplineError> {
    if !(radius.is_finite() && radius > 0.0) {
        let reason = "must be a positive, finite length in metres";
        return Err(SplineError::Dimension { name: "radius", value: radius, reason });
    }
    let surface = BodySurface::new(&shape.patches, *model == Model::Axisymmetric);
    let nearest = surface.closest(&shape.patches, point);
    let body = Around { shape, space, model, point: *point, radius };
    match nearest {
        Some(at) if at.measure <= ON_SURFACE * radius => disc::points(&body, &surface, &at),
        _ => ball::points(&body),
    }
}

/// A disc or ball on a body.
struct Around<'a> {
    shape: &'a Shape,
    space: &'a dyn SplineSpace,
    model: &'a Model,
    point: [f64; 3],
    radius: f64,
}

impl Around<'_> {
    /// The point at parameters `xi` of `patch`, to which a plane measure `weight` belongs.
    fn at(&self, patch: usize, xi: [f64; 3], weight: f64) -> ExtentPoint {
        let point = self.shape.patches[patch].point(&xi);
        let element = self.space.find_element(patch, &xi);
        ExtentPoint { element, xi, point, weight: weight * self.model.measure(&point) }
    }

    /// Size of the smallest element at `points` along all directions but the one fixed there \[m\].
    fn smallest_element(&self, points: &[(ExtentPoint, Option<usize>)]) -> f64 {
        let mut smallest = f64::INFINITY;
        for (p, fixed) in points {
            let sides = sides(self.shape, self.space, p.element, &p.xi);
            for d in (0..self.space.dimension()).filter(|&d| Some(d) != *fixed) {
                smallest = smallest.min(sides[d]);
            }
        }
        smallest
    }

    /// Distance that counts as none: round-off of a search \[m\].
    fn slack(&self) -> f64 {
        let size = self.shape.patches.iter().map(|p| diagonal(p.control_points())).fold(0.0, f64::max);
        1e-9 * self.radius + 1e-12 * size
    }

    /// Parts into which a radius is cut so that none is longer than an element of size `h`, at most `most`.
    fn parts(&self, h: f64, most: usize) -> usize {
        // A quotient that is no number or infinite ends at the limit.
        let wanted = (self.radius / h).ceil();
        if wanted < most as f64 { (wanted as usize).max(LEAST_PARTS) } else { most }
    }

    fn leaves(&self, kind: &'static str) -> SplineError {
        SplineError::ExtentBeyondBody { kind, radius: self.radius, point: self.point }
    }
}

/// Parts of the radius on coarse meshes: knot lines that cross the extent make kinks of the functions there.
const LEAST_PARTS: usize = 2;
/// Gauss points of each part of a radius.
const PART_POINTS: usize = 4;

/// Points and weights on `[lower, upper]` in `parts` equal parts.
fn composite(lower: f64, upper: f64, parts: usize) -> Vec<(f64, f64)> {
    let rule = GaussRule::new(PART_POINTS);
    let size = (upper - lower) / parts as f64;
    let part = |i: usize| {
        let (start, mut points) = (lower + i as f64 * size, Vec::with_capacity(PART_POINTS));
        rule.points_on(start, start + size, &mut points);
        points.into_iter().zip(rule.weights.iter().map(|w| 0.5 * size * w)).collect::<Vec<_>>()
    };
    (0..parts).flat_map(part).collect()
}

/// Cosine and sine of `n` directions around the circle, none of them along an axis.
fn directions(n: usize) -> impl Iterator<Item = (f64, f64)> {
    (0..n).map(move |k| {
        let (sin, cos) = (std::f64::consts::TAU * (k as f64 + 0.5) / n as f64).sin_cos();
        (cos, sin)
    })
}
