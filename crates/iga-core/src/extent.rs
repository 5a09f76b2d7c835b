//! Places with an extent: faces by name, discs on the surface, balls inside (docs/theory.md
//! Eq. M.9).
//!
//! An extent is turned into quadrature points with areas (volumes inside a body), the same whatever
//! the mesh is. Two things make integrals over it converge under refinement: faces take their Gauss
//! points from the elements of the space that is integrated, discs and balls are at least as dense
//! as its elements.

pub mod around;
mod face;
mod splines;

use crate::SplineError;
use crate::elasticity::Model;
use crate::elasticity::mapping::PointMap;
use crate::nurbs::Shape;
use crate::nurbs::jet::norm;
use crate::space::{Cell, GridBasis, PatchSpace, Space, SplineSpace};
use around::around;
use splines::Splines;

/// A part of a body.
#[derive(Debug, Clone, PartialEq)]
pub enum Extent {
    /// The face of the shape that has this name.
    Face(String),
    /// What lies within `radius` of `point`.
    ///
    /// Where the point lies on the surface, the part of the surface whose projection along the
    /// normal at the point is a disc (in two dimensions a line) of that radius; inside the body a
    /// ball (a disc). In axisymmetric models it goes around the axis with its point.
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
    /// Area, inside a body volume, that belongs to it: with the thickness of plane models and
    /// `2 π r` of axisymmetric ones \[m² or m³\].
    pub weight: f64,
}

/// Area or volume of the part with the quadrature points `points` \[m² or m³\].
pub fn measure(points: &[ExtentPoint]) -> f64 {
    points.iter().map(|p| p.weight).sum()
}

/// Its centroid, in the model's components \[m\].
pub fn centroid(points: &[ExtentPoint]) -> [f64; 3] {
    let total = measure(points);
    [0, 1, 2].map(|c| points.iter().map(|p| p.weight * p.point[c]).sum::<f64>() / total)
}

/// Distance of the centre from the surface, as a share of the radius, up to which a disc about the
/// nearest place is meant and no ball, for every kind of body: a ball so near to the surface would
/// leave the body, and sides of a mesh lie beside the shape that they stand for.
pub const ON_SURFACE: f64 = 0.1;
/// Points a direction and part of the rules for faces that know no mesh.
const FINEST: usize = crate::quadrature::MAX_GAUSS;

impl Extent {
    /// Quadrature points of the extent on the body `shape`, whose functions are those of `space`.
    ///
    /// On faces they are the Gauss points of the elements of `space`, so that piecewise polynomials
    /// are integrated piece by piece. On discs and in balls they lie closer than the smallest
    /// element there, down to a limit beyond which a share of the load so small is left to each
    /// point that its neighbourhood yields less than the whole extent does.
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
            Self::Around { point, radius } => {
                if !(radius.is_finite() && *radius > 0.0) {
                    let reason = "must be a positive, finite length in metres";
                    return Err(SplineError::Dimension { name: "radius", value: *radius, reason });
                }
                around(&Splines::new(shape, space, model, *radius), point, *radius)?
            }
        };
        let total = measure(&points);
        if total > 0.0 && total.is_finite() {
            return Ok(points);
        }
        Err(SplineError::EmptyExtent { extent: self.name() })
    }

    /// Where the extent is: the centroid of a face, the centre of a disc or ball, in the model's
    /// components (an axisymmetric extent is on the axis) \[m\]. It does not depend on a mesh.
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
                let total = measure(&points);
                if total.is_nan() || total <= 0.0 {
                    return Err(SplineError::EmptyExtent { extent: self.name() });
                }
                centroid(&points)
            }
        };
        if *model == Model::Axisymmetric {
            centre[0] = 0.0;
        }
        Ok(centre)
    }

    /// Longest side of the elements of `space` at a disc or ball \[m\]; none for a face, with whose
    /// edges functions end.
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
        Ok(Some(longest_element(space, &self.points(shape, space, model)?)))
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

/// Longest side of the elements of `space` at `points`, as it is there \[m\]: of simplices those
/// between their parametric directions, too, of pyramids those to the apex.
pub fn longest_element(space: &dyn Space, points: &[ExtentPoint]) -> f64 {
    let (mut basis, mut active, mut nodes) = (GridBasis::default(), Vec::new(), Vec::new());
    let mut longest = 0.0_f64;
    for p in points {
        space.evaluate_grid(p.element, p.xi.each_ref().map(std::slice::from_ref), &mut basis);
        space.active_functions(p.element, &mut active);
        nodes.clear();
        nodes.extend(active.iter().map(|&a| space.control_points()[a as usize]));
        let map = PointMap::new(space.dimension(), &nodes, basis.values_at(0), basis.first_at(0));
        let element = space.element(p.element);
        let side = |d: usize| {
            let width = element.upper[d] - element.lower[d];
            map.jacobian.map(|row| if d < space.dimension() { row[d] * width } else { 0.0 })
        };
        let sides = [side(0), side(1), side(2)];
        // Shares of the directions in further sides.
        let further: &[[f64; 3]] = match element.cell {
            Cell::Box => &[],
            Cell::Wedge => &[[1.0, -1.0, 0.0]],
            Cell::Tetrahedron => &[[1.0, -1.0, 0.0], [0.0, 1.0, -1.0], [-1.0, 0.0, 1.0]],
            Cell::Pyramid => &[[0.5, 0.5, 1.0], [-0.5, 0.5, 1.0], [-0.5, -0.5, 1.0], [0.5, -0.5, 1.0]],
        };
        let further = further
            .iter()
            .map(|shares| norm(&[0, 1, 2].map(|c| (0..3).map(|d| shares[d] * sides[d][c]).sum::<f64>())));
        longest = sides.iter().map(norm).chain(further).fold(longest, f64::max);
    }
    longest
}
