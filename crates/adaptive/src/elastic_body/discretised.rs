//! The discretisation of a body, coarse or fine: functions at a place.

use contact_qs::points::DofLookup;
use ffr_dynamics::body::{AssembledBody, RigidMotion};
use iga_core::elasticity::Model;
use iga_core::nurbs::Shape;
use iga_core::nurbs::patch::PointBasis;
use iga_core::space::Space;
use nalgebra::Vector3;

use crate::error::AdaptiveError;

/// What points and markers need of a body's discretisation, coarse or fine.
#[derive(Clone, Copy)]
pub struct Discretised<'a> {
    /// Name of the body.
    pub name: &'a str,
    /// Its shape before refinement, which keeps the parameters and is the cheaper one to search.
    pub shape: &'a Shape,
    /// Functions.
    pub space: &'a dyn Space,
    /// Kinematics.
    pub model: &'a Model,
    /// Unknowns.
    pub assembled: &'a AssembledBody,
    /// Numbers of the unknowns.
    pub lookup: &'a DofLookup,
}

/// Point in space of a position in the components of a model with the rigid motions `motion`.
pub fn point_in_space(motion: RigidMotion, position: &[f64; 3]) -> Vector3<f64> {
    let mut point = Vector3::zeros();
    for (c, &x) in position.iter().enumerate().take(motion.n_components()) {
        point[motion.direction(c)] = x;
    }
    point
}

impl Discretised<'_> {
    /// Functions that are not zero at parameters `xi` of element `e`, with their values.
    pub fn functions_at(&self, e: usize, xi: &[f64; 3]) -> Vec<(u32, f64)> {
        let (mut basis, mut active) = (PointBasis::default(), Vec::new());
        self.space.evaluate(e, xi, 0, &mut basis);
        self.space.active_functions(e, &mut active);
        active.into_iter().zip(basis.values).filter(|(_, value)| value.abs() > 0.0).collect()
    }

    /// Element and parameters of a point of the undeformed body, in the model's components \[m\].
    ///
    /// # Errors
    /// [`AdaptiveError::Geometry`] if the point is not in the body.
    pub fn locate(&self, place: &[f64; 3]) -> Result<(usize, [f64; 3]), AdaptiveError> {
        let (patch, xi) = self
            .shape
            .locate(place)
            .map_err(|source| AdaptiveError::Geometry { body: self.name.to_owned(), source })?;
        Ok((self.space.find_element(patch, &xi), xi))
    }
}
