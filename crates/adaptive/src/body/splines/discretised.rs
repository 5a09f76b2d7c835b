//! Splines as contact zones on faces see them, and how fields of splines find points and parts.

use contact_qs::zone::points::DofLookup;
use ffr_dynamics::body::RigidMotion;
use iga_core::elasticity::Model;
use iga_core::extent::{Extent, ExtentPoint};
use iga_core::nurbs::{Patch, Shape};
use iga_core::space::SplineSpace;

use crate::body::field::Field;
use crate::error::AdaptiveError;
use crate::spec::body::rigid_motion;

/// The splines of a body, coarse or fine, as contact zones on its faces see them.
#[derive(Clone, Copy)]
pub struct Discretised<'a> {
    /// Its patches: those of a plain space, of a hierarchical one the coarsest.
    pub patches: &'a [Patch],
    /// Functions.
    pub space: &'a dyn SplineSpace,
    /// Kinematics.
    pub model: &'a Model,
    /// The number of the unknown of each function and component.
    pub lookup: &'a DofLookup,
}

impl Discretised<'_> {
    /// Rigid motions of the model.
    pub fn motion(&self) -> RigidMotion {
        rigid_motion(self.model)
    }
}

/// [`Field::locate`] of `field`, whose functions are those of `space`; `shape` is the body's before refinement, which keeps the parameters and is the
/// cheaper one to search.
pub fn locate(
    field: &dyn Field,
    shape: &Shape,
    space: &dyn SplineSpace,
    place: &[f64; 3],
) -> Result<(usize, [f64; 3]), AdaptiveError> {
    let (patch, xi) = shape.locate(place).map_err(|source| field.geometry_fault(source))?;
    Ok((space.find_element(patch, &xi), xi))
}

/// [`Field::points_of`] of the same.
pub fn points_of(
    field: &dyn Field,
    shape: &Shape,
    space: &dyn SplineSpace,
    extent: &Extent,
) -> Result<Vec<ExtentPoint>, AdaptiveError> {
    extent.points(shape, space, field.model()).map_err(|source| field.geometry_fault(source))
}

/// [`Field::named_place`] of the same.
pub fn named_place(field: &dyn Field, shape: &Shape, marker: &str) -> Result<[f64; 3], AdaptiveError> {
    shape.markers.get(marker).copied().ok_or_else(|| {
        let known: Vec<&str> = shape.markers.keys().map(String::as_str).collect();
        let (marker, known) = (marker.to_owned(), known.join(", "));
        let what = AdaptiveError::no_marker("shape", &marker, &known);
        AdaptiveError::unsupported_body(field.name(), what)
    })
}
